"""Commands about vibration: linearize, modes, response."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

import click

from symoro_elastic.cli.options import JSON, MACHINE, OutputFile, Plots, draws, writes
from symoro_elastic.cli.output import counted, print_json, print_table, save_arrays, steps
from symoro_elastic.cli.parsing import Number, band, grid, parsed_by
from symoro_elastic.cli.situation import Situation, takes_situation
from symoro_elastic.errors import InputError

if TYPE_CHECKING:
    from symoro_elastic.vibration.linearization import Linearization

INPUT = click.option(
    "--input",
    "inputs",
    metavar="NAME",
    multiple=True,
    help="Input: motor_x.tau, tool.fx ... tool.mz (default: all motors); may be repeated.",
)
OUTPUT = click.option(
    "--output",
    "outputs",
    metavar="NAME",
    multiple=True,
    help="Output: motor_x.q, tool.x, tool.vx, tool.ax, 'tool at (0.1, 0, L2).rz' ... (default: encoders of the "
    "motors); may be repeated.",
)


@click.command()
@MACHINE
@takes_situation
@INPUT
@OUTPUT
@click.option("--out", metavar="FILE", type=OutputFile(), help="Save the matrices: .npz or .mat.")
@writes
@JSON
def linearize(
    machine: str,
    situation: Situation,
    inputs: tuple[str, ...],
    outputs: tuple[str, ...],
    out: str | None,
    as_json: bool,
) -> None:
    """Linearize MACHINE about an equilibrium or a state.

    Gives M, D, K of small motions and A, B, C, D of the state space.
    """
    from symoro_elastic.vibration.export import refuse_file, save_linearization
    from symoro_elastic.vibration.modes import damped
    from symoro_elastic.vibration.tables import linearization_json

    if out:
        refuse_file(out)
    with steps() as step:
        step("linearize")
        linear = situation.linearization(machine, inputs, outputs)
        growth = damped(linear)[0].real.max(initial=0.0)
    if out:
        save_linearization(linear, out)
    if as_json:
        print_json({**linearization_json(linear), **({"written": out} if out else {})})
        return
    _print_linearization(linear, growth)
    if out:
        click.echo(f"wrote {out}")


def _print_linearization(linear: Linearization, growth: float) -> None:
    from symoro_elastic.vibration.tables import state_lines

    click.echo("\n".join(state_lines(linear)))
    click.echo(f"coordinates: {', '.join(linear.coordinates)}")
    signals = (", ".join(names) or "none" for names in (linear.inputs, linear.outputs))
    click.echo("\n".join(["inputs: {}; outputs: {}".format(*signals), *linear.notes]))
    click.echo(f"fastest growth {growth:.3g} 1/s: unstable" if growth > 0 else "no pole is unstable")


@click.command()
@MACHINE
@takes_situation
@click.option(
    "--over",
    metavar="JOINT=LOW:HIGH:COUNT",
    multiple=True,
    callback=parsed_by(grid),
    help="Positions of a joint to compute the modes at; may be repeated.",
)
@click.option("--out", metavar="FILE", type=OutputFile(), help="Save the modes: .npz or .mat.")
@draws
@writes
@JSON
def modes(
    machine: str,
    situation: Situation,
    over: dict[str, list[float]],
    out: str | None,
    plots: Plots,
    as_json: bool,
) -> None:
    """Compute natural frequencies, mode shapes, sensitivities.

    Names the springs and the bodies that store the energy of each mode.
    """
    from symoro_elastic.vibration.export import refuse_file

    if out:
        refuse_file(out)
    if over:
        _modes_over(machine, situation, over, out, plots, as_json)
    else:
        _modes_at(machine, situation, out, plots, as_json)


def _modes_at(machine: str, situation: Situation, out: str | None, plots: Plots, as_json: bool) -> None:
    """`modes` at one position."""
    from symoro_elastic.vibration import modes as vibration
    from symoro_elastic.vibration.export import modes_arrays
    from symoro_elastic.vibration.plots import plot_modes
    from symoro_elastic.vibration.sensitivity import sensitivity
    from symoro_elastic.vibration.tables import modes_conclusion, modes_json, modes_table, state_lines

    with steps() as step:
        step("modes")
        linear = situation.linearization(machine)
        vibration.refuse_rigid(linear)
        found = vibration.modes(linear)
        slopes = sensitivity(found)
    if as_json:
        print_json(modes_json(found, slopes))
    else:
        click.echo("\n".join([*state_lines(found.linear), *found.linear.doubts]))
        print_table(modes_table(found, slopes), found.linear.motion.machine.name)
        click.echo(modes_conclusion(found, slopes))
    save_arrays(modes_arrays(found, slopes), out, as_json)
    plots.write(partial(plot_modes, found))


def _modes_over(
    machine: str,
    situation: Situation,
    over: dict[str, list[float]],
    out: str | None,
    plots: Plots,
    as_json: bool,
) -> None:
    """`modes --over`."""
    from symoro_elastic.vibration.export import tracked_arrays
    from symoro_elastic.vibration.plots import plot_tracked
    from symoro_elastic.vibration.tables import tracked_conclusion, tracked_json, tracked_table
    from symoro_elastic.vibration.tracking import over_grid

    if situation.as_given:
        what = "modes over positions are those of equilibria: leave out --as-given"
        raise InputError("symoro-elastic", "--over", what)
    if situation.thrusts:
        raise InputError("symoro-elastic", "--over", "thrusts are found at one position: use --hover, or leave it out")
    motion = situation.motion(machine)
    with counted("modes") as progress:
        held = situation.held(motion)
        at, torques, gains = situation.positions, situation.torques, situation.gains
        found = over_grid(motion, over, at, torques, held, gains, progress, situation.hover)
    if as_json:
        print_json(tracked_json(found))
    else:
        print_table(tracked_table(found), f"{motion.machine.name}: frequencies, Hz")
        click.echo(tracked_conclusion(found))
    save_arrays(tracked_arrays(found), out, as_json)
    plots.write(partial(plot_tracked, found))


@click.command()
@MACHINE
@takes_situation
@INPUT
@OUTPUT
@click.option(
    "--frequencies",
    metavar="LOW:HIGH[:COUNT]",
    callback=parsed_by(band),
    help="Frequencies, Hz, on a logarithmic scale (default: around all poles).",
)
@click.option(
    "--damping", default=0.0, type=Number(), metavar="RATIO", help="Damping ratio added to every mode: 0.01 is 1 %."
)
@click.option("--out", metavar="FILE", type=OutputFile(), help="Save the response: .csv, .npz or .mat.")
@draws
@writes
@JSON
def response(
    machine: str,
    situation: Situation,
    inputs: tuple[str, ...],
    outputs: tuple[str, ...],
    frequencies: tuple[float, float, int] | tuple[()],
    damping: float,
    out: str | None,
    plots: Plots,
    as_json: bool,
) -> None:
    """Compute frequency responses, poles and zeros.

    From motors or forces on frames to encoders or motions of frames.
    """
    from symoro_elastic.vibration import export, responses
    from symoro_elastic.vibration.plots import plot_response
    from symoro_elastic.vibration.tables import response_json, response_notes, response_table
    from symoro_elastic.vibration.zeros import poles_and_zeros

    if out:
        export.refuse_file(out, export.RESPONSE_FILES)
    with steps() as step:
        step("response")
        linear = responses.with_modal_damping(situation.linearization(machine, inputs, outputs), damping)
        _refuse_missing_signals(linear)
        points = responses.frequency_grid(linear, *frequencies)
        found = responses.frequency_response(linear, points)
        pairs = [poles_and_zeros(linear, i, o) for i in linear.inputs for o in linear.outputs]
    notes = [*found.notes, *response_notes(pairs)]
    low, high = float(points[0]), float(points[-1])
    if as_json:
        transfers = response_json(pairs)
        print_json({"transfers": transfers, "points": len(points), "low": low, "high": high, "notes": notes})
    else:
        print_table(response_table(pairs), linear.motion.machine.name)
        click.echo("\n".join([f"{len(points)} frequencies, {low:.4g} to {high:.4g} Hz", *notes]))
    if out:
        export.save_response(found, out)
        click.echo(f"wrote {out}", err=as_json)
    plots.write(partial(plot_response, found))


def _refuse_missing_signals(linear: Linearization) -> None:
    """Raise `InputError` for a response without input or output."""
    for option, names, such in (("--input", linear.inputs, "fx"), ("--output", linear.outputs, "x")):
        if not names:
            frame = linear.motion.machine.joints[-1].name
            what = f"no motor is there, or all are held: name one, such as {frame}.{such}"
            raise InputError(linear.motion.source, option, what)
