"""Commands about vibration: linearize, modes, response."""

from __future__ import annotations

from functools import partial

import click

from symoro_elastic.cli.options import JSON, MACHINE, OutputFile, Plots, draws, writes
from symoro_elastic.cli.output import counted, print_result, save_arrays, steps
from symoro_elastic.cli.parsing import Number, band, grid, parsed_by
from symoro_elastic.cli.reading import read_restricted
from symoro_elastic.cli.situation import Situation, takes_situation

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
@click.option("--out", metavar="FILE", type=OutputFile(), help="Save the matrices: .npz, .mat or .m.")
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
    from symoro_elastic.vibration.export import refuse_linearization_file, save_linearization

    if out:
        refuse_linearization_file(out)
    with steps() as step:
        step("linearize")
        found = situation.linearization(machine, inputs, outputs)
    if out:
        save_linearization(found, out)
    print_result(found, as_json, **({"written": out} if out else {}))
    if out and not as_json:
        click.echo(f"wrote {out}")


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
    from symoro_elastic.api.vibrations import modes_of
    from symoro_elastic.vibration.plots import plot_modes

    with steps() as step:
        step("modes")
        found = modes_of(situation.linearization(machine))
    print_result(found, as_json)
    save_arrays(found, out, as_json)
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
    from symoro_elastic.api.vibrations import modes_over
    from symoro_elastic.vibration.plots import plot_tracked

    with counted("modes") as progress:
        found = modes_over(read_restricted(machine), over, situation.point, situation.values, progress)
    print_result(found, as_json)
    save_arrays(found, out, as_json)
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
    from symoro_elastic.api.vibrations import response_of
    from symoro_elastic.vibration import export
    from symoro_elastic.vibration.plots import plot_response

    if out:
        export.refuse_file(out, export.RESPONSE_FILES)
    with steps() as step:
        step("response")
        found = response_of(situation.linearization(machine, inputs, outputs), None, damping, frequencies)
    print_result(found, as_json)
    if out:
        export.save_response(found, out)
        click.echo(f"wrote {out}", err=as_json)
    plots.write(partial(plot_response, found))
