"""The command simulate: motions of a machine over time, with the error of their steps measured."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import click

from symoro_elastic.cli import completion
from symoro_elastic.cli.options import JSON, MACHINE, VALUE, InputFile, OutputFile, Plots, draws, gather, writes
from symoro_elastic.cli.output import print_json, print_table, staged
from symoro_elastic.cli.parsing import Number, among, numbers, parsed_by
from symoro_elastic.cli.reading import read, scene_of
from symoro_elastic.errors import InputError

if TYPE_CHECKING:
    from symoro_elastic.machine.wanted import Wanted
    from symoro_elastic.model_ladder.simulate import Request
    from symoro_elastic.progress import Announce, Progress
    from symoro_elastic.simulation.reference import Reference
    from symoro_elastic.simulation.simulated import Simulation

NEITHER = "choose even steps (--method, --step) or adapted ones (--adaptive)"


@dataclass(frozen=True)
class Integration:
    """How to integrate: even steps of a method, or steps that are adapted and find events."""

    method: str | None
    step: float | None
    adaptive: bool
    events: Mapping[str, float]
    stop: bool

    def __post_init__(self) -> None:
        if self.adaptive and (self.method or self.step is not None):
            raise InputError("symoro-elastic", "--adaptive", NEITHER)
        if self.events and not self.adaptive:
            raise InputError("symoro-elastic", "--event", "even steps find no events: add --adaptive")
        if self.stop and not self.events:
            raise InputError("symoro-elastic", "--stop", "there is no event to stop at: name one by --event")

    def run(self, reference: Reference, request: Request, announce: Announce, progress: Progress) -> Simulation:
        """Return the simulated motion."""
        from symoro_elastic.model_ladder.simulate import simulate
        from symoro_elastic.model_ladder.simulate_adaptively import simulate_adaptively

        if self.adaptive:
            return simulate_adaptively(reference, request, self.events, self.stop, announce, progress)
        return simulate(reference, request, announce, progress)


def _method(name: str | None, option: str) -> str | None:
    """The name of a method of even steps, or None."""
    from symoro_elastic.integration.methods import METHODS

    return name and among([name], list(METHODS), option)[0]


@click.command()
@MACHINE
@click.option(
    "--scene",
    metavar="FILE",
    type=InputFile(),
    help="TOML file with [motion], or several, [wanted] and [scene] (default: those of MACHINE).",
)
@gather("integration", Integration)
@click.option(
    "--method",
    metavar="NAME",
    shell_complete=completion.METHODS,
    callback=parsed_by(_method),
    help="Method of even steps: w3, w2, rk4, rodas4 or midpoint (default: the cheapest by prediction).",
)
@click.option("--step", type=Number(), metavar="S", help="Step, s (default: the longest that is exact enough).")
@click.option("--adaptive", is_flag=True, help="Steps of scipy's DOP853 or Radau, adapted to the motion.")
@click.option(
    "--event",
    "events",
    metavar="JOINT.q=X",
    multiple=True,
    callback=parsed_by(numbers),
    help="Time at which a joint's position (.q) or velocity (.qd) crosses a level; may be repeated.",
)
@click.option("--stop", is_flag=True, help="End the motion at the first event.")
@VALUE
@click.option(
    "--out",
    metavar="FILE",
    type=OutputFile(),
    help="Save t, q_, qd_, qdd_, tau_ as identify and compare read them: .csv or .npz; numbered for several motions.",
)
@draws
@writes
@JSON
def simulate(
    machine: str,
    scene: str | None,
    integration: Integration,
    values: dict[str, float],
    out: str | None,
    plots: Plots,
    as_json: bool,
) -> int:
    """Simulate the motions of a scene with a measured error.

    The motors of MACHINE do what [motion] says, under servos or exactly; springs follow. Method and step are predicted
    from the tolerances of [wanted] (else a thousandth of the largest deviation from the motion without springs), the
    error is measured by halving the step. Exit code 1 where it is above a tolerance of [wanted].
    """
    from symoro_elastic.simulation.plots import plot_simulations
    from symoro_elastic.simulation.tables import simulation_columns
    from symoro_elastic.time_series.writing import write_columns

    with _interruptible():
        references, wanted = _references(machine, scene, values)
        paths = _numbered(out, len(references)) if out else []
        request = _request(references[0], wanted, integration)
        found = []
        for reference in references:
            with staged("predict") as (announce, progress):
                found.append(integration.run(reference, request, announce, progress))
    for path, one in zip(paths, found, strict=False):
        write_columns(simulation_columns(one), path)
    _print(found, wanted, paths, as_json)
    plots.write(partial(plot_simulations, found))
    return int(bool(request.tolerance) and not all(one.is_within for one in found))


@contextmanager
def _interruptible() -> Iterator[None]:
    """Say that nothing was written where Ctrl-C ends the block."""
    try:
        yield
    except KeyboardInterrupt:
        click.echo("note: interrupted, nothing was written", err=True)
        raise


def _references(
    machine: str, scene: str | None, values: Mapping[str, float]
) -> tuple[tuple[Reference, ...], Wanted | None]:
    """Return the motions of a scene, of a machine whose joints the scene locks, and what is wanted of them."""
    from symoro_elastic.machine.formats.motions import read_motions, read_wanted
    from symoro_elastic.machine.named_cells import with_values
    from symoro_elastic.machine.restrict import restricted
    from symoro_elastic.simulation.reference import reference_of
    from symoro_elastic.simulation.tolerances import refuse_rounding

    source = scene or machine
    whole = read(machine)
    moving = with_values(restricted(whole, scene_of(whole, scene)), values)
    if Path(source).suffix.lower() != ".toml":
        raise InputError(source, "motion", "no motion can stand here: give --scene FILE with a table [motion]")
    motions = read_motions(source, whole)
    if not motions:
        what = "missing: write a table [motion] with duration and moves, or give --scene FILE that has one"
        raise InputError(source, "motion", what)
    wanted = read_wanted(source)
    references = tuple(reference_of(moving, motion) for motion in motions)
    if wanted:
        for reference in references:
            refuse_rounding(wanted, reference)
    return references, wanted


def _request(reference: Reference, wanted: Wanted | None, integration: Integration) -> Request:
    from symoro_elastic.model_ladder.simulate import Request
    from symoro_elastic.simulation.tolerances import output_signals, tolerances

    if wanted is None:
        return Request(method=integration.method, step=integration.step)
    machine = reference.machine
    outputs, allowed = output_signals(wanted, machine), tolerances(wanted, machine)
    names = tuple(dict.fromkeys((*outputs, *allowed)))
    return Request(names, allowed or None, integration.method, integration.step, wanted.period)


def _numbered(out: str, count: int) -> list[str]:
    """Return a file for each motion; raises `InputError` for those that cannot be written."""
    from symoro_elastic.time_series.writing import refuse_file

    path = Path(out)
    numbered = [str(path.with_stem(f"{path.stem}_{k}")) for k in range(1, count + 1)] if count > 1 else [out]
    for each in numbered:
        refuse_file(each)
    return numbered


def _print(found: Sequence[Simulation], wanted: Wanted | None, paths: Sequence[str], as_json: bool) -> None:
    from symoro_elastic.simulation.tables import errors_table, simulation_json, simulation_lines, steps_table

    name = found[0].reference.machine.name
    if as_json:
        written = {"written": list(paths)} if paths else {}
        print_json({"name": name, "motions": [simulation_json(one) for one in found], **written})
    else:
        for one in found:
            print_table(steps_table(one), f"{name}: {one.reference.prescribed.place}, {one.motion.t[-1]:g} s")
            print_table(errors_table(one))
            click.echo("\n".join([*simulation_lines(one), *_periods(one, wanted)]))
    for path in paths:
        click.echo(f"wrote {path}", err=as_json)


def _periods(found: Simulation, wanted: Wanted | None) -> list[str]:
    from symoro_elastic.simulation.periods import period_line

    line = period_line(wanted, found.trajectory.step, found.trajectory.seconds) if wanted and found.operations else ""
    return [line] if line else []
