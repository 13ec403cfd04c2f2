"""Commands about vibration and control: linearize, modes, response, compare, feed-forward."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import click

from symoro_elastic.api.declaration import Options, in_si_units
from symoro_elastic.api.options import Comparing, Following, Linearizing, Oscillating, Responding
from symoro_elastic.api.rows import along_row
from symoro_elastic.cli.listed import command
from symoro_elastic.cli.options import JSON, MACHINE, OutputFile, Plots, call, draws, takes, writes
from symoro_elastic.cli.output import echo, print_result, progress_bar, save_arrays, steps
from symoro_elastic.cli.reading import read_for
from symoro_elastic.foundation.file_forms import COLUMNS, LINEARIZATIONS, MODES, RESPONSES


@command("linearize")
@MACHINE
@takes(Linearizing)
@click.option("--out", metavar="FILE", type=OutputFile(LINEARIZATIONS), help="Save the matrices: .npz, .mat or .m.")
@writes
@JSON
def linearize(machine: str, options: Linearizing, out: str | None, as_json: bool) -> None:
    """Give M, D, K of small motions and A, B, C, D of the state space."""
    from symoro_elastic.analysis.vibration.export import refuse_linearization_file, save_linearization
    from symoro_elastic.api import vibrations

    if out:
        refuse_linearization_file(out)
    with steps("linearize"):
        full_machine = read_for(options.scene, machine)
        linear = call(vibrations.linearize, full_machine, options)
    if out:
        save_linearization(linear, out)
    print_result(linear, as_json, out)


class Path(Options):
    """Positions that modes are followed along."""

    along: Mapping[str, Sequence[float]] = along_row()


@command("modes")
@MACHINE
@takes(Path, "path")
@takes(Oscillating)
@click.option("--out", metavar="FILE", type=OutputFile(MODES), help="Save the modes: .npz or .mat.")
@draws
@writes
@JSON
def modes(machine: str, path: Path, options: Oscillating, out: str | None, plots: Plots, as_json: bool) -> None:
    """Name the springs and the bodies that store the energy of the modes."""
    from symoro_elastic.api import vibrations

    full_machine = read_for(options.scene, machine)
    with progress_bar("modes") as progress:
        along = in_si_units(full_machine, path).along
        tracked = vibrations.modes_along(full_machine, along, options, progress) if along else None
        result: Any = tracked or call(vibrations.modes, full_machine, options)
    print_result(result, as_json)
    save_arrays(result, out, as_json)
    plots.write(tracked.plots if tracked else result.plots)


@command("response")
@MACHINE
@takes(Responding)
@click.option("--out", metavar="FILE", type=OutputFile(RESPONSES), help="Save the response: .csv, .npz or .mat.")
@draws
@writes
@JSON
def response(machine: str, options: Responding, out: str | None, plots: Plots, as_json: bool) -> None:
    """Compute them from motors or forces on frames to encoders or motions of frames."""
    from symoro_elastic.analysis.vibration import export
    from symoro_elastic.api import vibrations

    with steps("response"):
        full_machine = read_for(options.scene, machine)
        result = call(vibrations.response, full_machine, options)
    print_result(result, as_json)
    if out:
        export.save_response(result, out)
        echo(f"wrote {out}", err=as_json)
    plots.write(result.plots)


@command("compare")
@MACHINE
@takes(Comparing)
@draws
@writes
@JSON
def compare(machine: str, options: Comparing, plots: Plots, as_json: bool) -> None:
    """Give errors in frequencies, torques and elastic accelerations of Spong's reduced model and of the rigid limit,
    on a motion.
    """
    from symoro_elastic.api import vibrations

    full_machine = read_for(options.scene, machine)
    with progress_bar("springs follow") as progress:
        result = call(vibrations.compare, full_machine, options, progress=progress)
    print_result(result, as_json)
    plots.write(result.plots)


@command("feed-forward")
@MACHINE
@takes(Following)
@click.option(
    "--out", metavar="FILE", type=OutputFile(COLUMNS), help="Save torques and motion of all joints: .csv or .npz."
)
@draws
@writes
@JSON
def feed_forward(machine: str, options: Following, out: str | None, plots: Plots, as_json: bool) -> None:
    """Give motor torques of the full elastic model of MACHINE: the load, beyond the springs, follows the reference.

    They need derivatives of its trajectory: two, and two more for each spring in a row. Springs may have damping.
    Behind a gear or a screw the trajectory of a motor is that of the last joint of its drive.
    Springs that are not behind a motor on its axis are left out; the command prints the resulting error.
    Where motors follow from loops, as in a delta, the trajectory is that of the independent joints (y_<joint>).
    """
    from symoro_elastic.analysis.vibration.feed_forward import save_feed_forward
    from symoro_elastic.api import vibrations

    full_machine = read_for(options.scene, machine)
    with steps("feed-forward"):
        result = call(vibrations.feed_forward, full_machine, options)
    if out:
        save_feed_forward(result, out)
    print_result(result, as_json, out)
    plots.write(result.plots)
