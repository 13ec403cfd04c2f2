"""Commands about motions of a scene: simulate, reduce, ladder."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import click

from symoro_elastic.api import kinds
from symoro_elastic.api.declaration import Options, in_si_units, option, part
from symoro_elastic.api.options import Climbing, Integrating, Reducing, Simulating
from symoro_elastic.cli.listed import command
from symoro_elastic.cli.options import JSON, MACHINE, OutputFile, Plots, call, draws, takes, writes
from symoro_elastic.cli.output import echo, print_json, print_parts, print_result, print_table, staged_progress
from symoro_elastic.cli.reading import note, read, scene_of
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.file_forms import COLUMNS, SCENES

if TYPE_CHECKING:
    from symoro_elastic.analysis.ladder.rung import Budget
    from symoro_elastic.analysis.ladder.rungs import Ladder
    from symoro_elastic.analysis.simulation.simulated import Simulation, Simulations
    from symoro_elastic.api.motions import Plan
    from symoro_elastic.machine.described import Wanted


@command("simulate")
@MACHINE
@takes(Simulating)
@click.option(
    "--out",
    metavar="FILE",
    type=OutputFile(COLUMNS),
    help="Save t, q_, qd_, qdd_, tau_ as identify and compare read them, and power_, energy_: .csv or .npz; numbered "
    "for several motions.",
)
@draws
@writes
@JSON
def simulate(machine: str, options: Simulating, out: str | None, plots: Plots, as_json: bool) -> int:
    """Move the motors of MACHINE as [motion] says, under servos or exactly; springs follow.

    Method and step are predicted from the tolerances of [wanted] (else a thousandth of the largest deviation from the
    motion without springs), the error is measured by halving the step. Exit code 1 where it is above a tolerance of
    [wanted].
    """
    from symoro_elastic.analysis.simulation.simulated import Simulations
    from symoro_elastic.analysis.simulation.views import record
    from symoro_elastic.analysis.time_series.writing import write_columns

    with _interruptible():
        planned = _plan(machine, options)
        paths = _paths_of(out, len(planned.references)) if out else []
        simulated = Simulations()
        for reference in planned.references:
            with staged_progress("predict") as (announce, progress):
                simulated.append(planned.run(reference, announce, progress))
    for path, simulation in zip(paths, simulated, strict=False):
        write_columns(record(simulation), path)
    _print(simulated, planned.wanted, paths, as_json)
    plots.write(simulated.plots)
    return int(bool(planned.request.tolerance) and not all(simulation.is_within for simulation in simulated))


@contextmanager
def _interruptible() -> Iterator[None]:
    """Within this block, Ctrl-C reports that nothing was written."""
    try:
        yield
    except KeyboardInterrupt:
        note("interrupted, nothing was written")
        raise


def _plan(machine: str, options: Simulating) -> Plan:
    """Return the motions of a scene, their machine with joints of the scene locked, and the integration."""
    from symoro_elastic.api.motions import plan

    source = str(options.scene or machine)
    full_machine = read(machine)
    scene_of(full_machine, options.scene)
    if Path(source).suffix.lower() != ".toml":
        raise InputError(
            source, "motion", "only a .toml file can hold a motion: give --scene FILE with a table [motion]"
        )
    options = in_si_units(full_machine, options)
    return plan(full_machine, options.scene, part(Integrating, options), options.values)


def _paths_of(out: str, count: int) -> list[str]:
    """Return a file for each motion; raises `InputError` for one that cannot be written."""
    from symoro_elastic.analysis.time_series.writing import refuse_file

    path = Path(out)
    paths = [str(path.with_stem(f"{path.stem}_{k}")) for k in range(1, count + 1)] if count > 1 else [out]
    for name in paths:
        refuse_file(name)
    return paths


def _print(simulated: Simulations, wanted: Wanted | None, paths: Sequence[str], as_json: bool) -> None:
    if as_json:
        written = {"written": list(paths)} if paths else {}
        print_json({**simulated.as_json(), **written})
    else:
        for simulation in simulated:
            print_parts([*simulation.parts(), *_periods(simulation, wanted)])
    for path in paths:
        echo(f"wrote {path}", err=as_json)


def _periods(simulated: Simulation, wanted: Wanted | None) -> list[str]:
    from symoro_elastic.analysis.simulation.periods import period_line

    line = (
        period_line(wanted, simulated.trajectory.step, simulated.trajectory.seconds)
        if wanted and simulated.operations
        else ""
    )
    return [line] if line else []


class ReducedScenes(Options):
    """Where the scenes of reduced models are saved."""

    save: str | None = option(
        None,
        "FILE",
        "Save the scene of the advised model: .toml; for both purposes a second one as FILE_feed_forward.toml.",
        kinds.output_file(*SCENES),
    )


@command("reduce")
@MACHINE
@takes(Reducing)
@takes(ReducedScenes, "scenes")
@draws
@writes
@JSON
def reduce(machine: str, options: Reducing, scenes: ReducedScenes, plots: Plots, as_json: bool) -> int:
    """Give the torque accuracy that a tolerance of outputs such as tool.x needs over the motions of a scene.

    For simulation springs, numbers of bodies, time steps and precision share the tolerance. For feed-forward it becomes
    a tolerance of each motor's torque, within which terms are left out of the inverse model. Errors are predicted by
    the linear model along the motion, and measured at the end. Exit code 1 where they are above the tolerance.
    """
    from symoro_elastic.api import motions as api

    with _interruptible(), staged_progress() as (announce, progress):
        whole = read(machine, announce=announce)
        reduced = call(api.reduce, whole, options, announce=announce, progress=progress)
    print_result(reduced, as_json)
    if scenes.save:
        if lost := reduced.save(scenes.save):
            note(lost)
        for path in reduced.files(scenes.save):
            echo(f"wrote {path}", err=True)
    plots.write(reduced.plots)
    return int(not reduced.is_within)


class ReducedScene(Options):
    """The file for the scene of the advised model."""

    save: str | None = option(
        None,
        "FILE",
        "Save the scene of the chosen rung, or of --budget: .toml.",
        kinds.output_file(*SCENES),
        gone=("--out",),
    )


@command("ladder")
@MACHINE
@takes(Climbing)
@takes(ReducedScene, "reduced")
@draws
@writes
@JSON
def ladder(machine: str, options: Climbing, reduced: ReducedScene, plots: Plots, as_json: bool) -> None:
    """Predict the errors of rigid springs and of steps for every candidate; simulate and measure the chosen one.

    With --budget the tolerances are spent on springs, numbers of bodies, steps and precision together.
    """
    from symoro_elastic.api import motions as api
    from symoro_elastic.api.scenes import motions_of_scene

    with staged_progress() as (announce, progress):
        full_machine = read(machine, announce=announce)
        climbed = call(api.ladder, full_machine, options, announce=announce, progress=progress)
    wanted = motions_of_scene(full_machine, options.scene).wanted
    if as_json:
        print_json(climbed.as_json())
    elif climbed.budget:
        _print_budget(climbed, climbed.budget, wanted)
    else:
        _print_ladder(climbed, str(options.scene or machine), wanted)
    if reduced.save:
        if lost := climbed.save(reduced.save):
            note(lost)
        echo(f"wrote {reduced.save}", err=True)
    plots.write(climbed.plots)


def _print_ladder(climbed: Ladder, scene: str, wanted: Wanted | None) -> None:
    from symoro_elastic.analysis.ladder.views import advice, arithmetic_line, ladder_table, period_of, springs_table

    for line in climbed.condensed:
        note(line)
    print_table(ladder_table(climbed, f"{climbed.machine.name}: models from full to rigid, for {scene}"))
    if climbed.springs:
        print_table(springs_table(climbed))
    lines = [advice(climbed), period_of(climbed, wanted) if wanted else "", arithmetic_line(climbed)]
    echo("\n".join(line for line in lines if line))


def _print_budget(climbed: Ladder, budget: Budget, wanted: Wanted | None) -> None:
    from symoro_elastic.analysis.simulation.periods import period_line

    for line in climbed.condensed:
        note(line)
    print_parts(budget.parts())
    if wanted and (line := period_line(wanted, climbed.step_of(budget.advised.rung), budget.seconds)):
        echo(line)
