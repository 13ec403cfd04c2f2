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
from symoro_elastic.cli.output import print_json, print_parts, staged
from symoro_elastic.cli.parsing import Number, numbers, parsed_by
from symoro_elastic.cli.reading import read, scene_of
from symoro_elastic.errors import InputError

if TYPE_CHECKING:
    from symoro_elastic.api.motions import Integration, Plan
    from symoro_elastic.machine.wanted import Wanted
    from symoro_elastic.simulation.simulated import Simulation


@dataclass(frozen=True)
class Steps:
    """How to integrate: even steps of a method, or steps that are adapted and find events."""

    method: str | None
    step: float | None
    adaptive: bool
    events: Mapping[str, float]
    stop: bool

    @property
    def integration(self) -> Integration:
        """The integration."""
        from symoro_elastic.api.motions import Integration

        return Integration(self.method, self.step, self.adaptive, self.events, self.stop)


@click.command()
@MACHINE
@click.option(
    "--scene",
    metavar="FILE",
    type=InputFile(),
    help="TOML file with [motion], or several, [wanted] and [scene] (default: those of MACHINE).",
)
@gather("integration", Steps)
@click.option(
    "--method",
    metavar="NAME",
    shell_complete=completion.METHODS,
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
    integration: Steps,
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
    from symoro_elastic.time_series.writing import write_columns

    with _interruptible():
        planned = _planned(machine, scene, integration.integration, values)
        paths = _numbered(out, len(planned.references)) if out else []
        found = []
        for reference in planned.references:
            with staged("predict") as (announce, progress):
                found.append(planned.run(reference, announce, progress))
    for path, one in zip(paths, found, strict=False):
        write_columns(one.arrays(), path)
    _print(found, planned.wanted, paths, as_json)
    plots.write(partial(plot_simulations, found))
    return int(bool(planned.request.tolerance) and not all(one.is_within for one in found))


@contextmanager
def _interruptible() -> Iterator[None]:
    """Say that nothing was written where Ctrl-C ends the block."""
    try:
        yield
    except KeyboardInterrupt:
        click.echo("note: interrupted, nothing was written", err=True)
        raise


def _planned(machine: str, scene: str | None, integration: Integration, values: Mapping[str, float]) -> Plan:
    """Return the motions of a scene, of a machine whose joints the scene locks, and how they are simulated."""
    from symoro_elastic.api.motions import plan

    source = scene or machine
    whole = read(machine)
    scene_of(whole, scene)
    if Path(source).suffix.lower() != ".toml":
        raise InputError(source, "motion", "no motion can stand here: give --scene FILE with a table [motion]")
    return plan(whole, scene, integration, values)


def _numbered(out: str, count: int) -> list[str]:
    """Return a file for each motion; raises `InputError` for those that cannot be written."""
    from symoro_elastic.time_series.writing import refuse_file

    path = Path(out)
    numbered = [str(path.with_stem(f"{path.stem}_{k}")) for k in range(1, count + 1)] if count > 1 else [out]
    for each in numbered:
        refuse_file(each)
    return numbered


def _print(found: Sequence[Simulation], wanted: Wanted | None, paths: Sequence[str], as_json: bool) -> None:
    if as_json:
        written = {"written": list(paths)} if paths else {}
        name = found[0].reference.machine.name
        print_json({"name": name, "motions": [one.as_json() for one in found], **written})
    else:
        for one in found:
            print_parts([*one.parts(), *_periods(one, wanted)])
    for path in paths:
        click.echo(f"wrote {path}", err=as_json)


def _periods(found: Simulation, wanted: Wanted | None) -> list[str]:
    from symoro_elastic.simulation.periods import period_line

    line = period_line(wanted, found.trajectory.step, found.trajectory.seconds) if wanted and found.operations else ""
    return [line] if line else []
