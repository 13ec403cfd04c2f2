"""Commands about vibration: linearize, modes, response, compare."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import click

from symoro_elastic.cli.options import JSON, MACHINE
from symoro_elastic.cli.output import counted, print_json, print_table, steps
from symoro_elastic.cli.reading import numbers, ranges, read, scene_of
from symoro_elastic.errors import InputError

if TYPE_CHECKING:
    from symoro_elastic.machine.machine import Machine
    from symoro_elastic.vibration.equations_of_motion import EquationsOfMotion
    from symoro_elastic.vibration.linearization import Linearization

Command = Callable[..., Any]

VALUE = click.option(
    "--value", "values", metavar="NAME=X", multiple=True, help="Value of a parameter; may be repeated."
)
AT = click.option(
    "--at",
    metavar="JOINT=X",
    multiple=True,
    help="Position of a motor, rad or m, 0 unless said; of other joints where the search begins.",
)
INPUT = click.option(
    "--input", "ins", metavar="NAME", multiple=True, help="motor_x.tau, tool.fx ... tool.mz; all motors unless said."
)
OUTPUT = click.option(
    "--output", "outs", metavar="NAME", multiple=True,
    help="motor_x.q, tool.x, tool.vx, tool.ax, 'tool at (0.1, 0, L2).rz' ...; encoders of motors unless said.",
)  # fmt: skip
PLOTS = click.option("--plots", metavar="FOLDER", type=click.Path(), help="Draw pictures there.")
SITUATION = (
    AT,
    click.option(
        "--torque", metavar="MOTOR=X", multiple=True, help="Torque of a motor that is free to find its place."
    ),
    click.option("--rate", metavar="JOINT=X", multiple=True, help="Velocity of a joint, with --as-given."),
    click.option("--as-given", is_flag=True, help="Take --at, --rate and --torque as the state; seek no equilibrium."),
    click.option("--hold", metavar="MOTOR|all", multiple=True, help="Motor that is held; free unless said."),
    click.option("--pd", metavar="MOTOR=KP:KD", multiple=True, help="Gains of a motor's position controller."),
    VALUE,
)


def situation(command: Command) -> Command:
    """Options that say where the machine is, and what its motors do."""
    for option in reversed(SITUATION):
        command = option(command)
    return command


@click.command()
@MACHINE
@situation
@INPUT
@OUTPUT
@click.option("--out", metavar="FILE", type=click.Path(), help="File to write: .npz or .mat.")
@JSON
def linearize(
    machine: str, ins: tuple[str, ...], outs: tuple[str, ...], out: str | None, as_json: bool, **place: Any
) -> None:
    """Small motions of MACHINE about its equilibrium, or a given state: M, D, K and A, B, C, D."""
    from symoro_elastic.vibration.export import refuse_file, save_linearization
    from symoro_elastic.vibration.modes import damped
    from symoro_elastic.vibration.tables import linearization_json, state_lines

    if out:
        refuse_file(out)
    with steps() as step:
        step("linearize")
        linear = _linearized(machine, ins, outs, place)
        growing = damped(linear)[0].real.max(initial=0.0)
    if out:
        save_linearization(linear, out)
    if as_json:
        print_json({**linearization_json(linear), **({"written": out} if out else {})})
        return
    click.echo("\n".join(state_lines(linear)))
    click.echo(f"coordinates: {', '.join(linear.coordinates)}")
    ins_and_outs = (", ".join(names) or "none" for names in (linear.inputs, linear.outputs))
    click.echo("\n".join(["inputs: {}; outputs: {}".format(*ins_and_outs), *linear.notes]))
    click.echo(f"fastest growth {growing:.3g} 1/s: unstable" if growing > 0 else "no pole is unstable")
    if out:
        click.echo(f"wrote {out}")


@click.command()
@MACHINE
@situation
@click.option("--over", metavar="JOINT=LOW:HIGH:COUNT", multiple=True, help="Positions to go through; may be repeated.")
@click.option("--out", metavar="FILE", type=click.Path(), help="Figures to write: .npz or .mat.")
@PLOTS
@JSON
def modes(machine: str, over: tuple[str, ...], out: str | None, plots: str | None, as_json: bool, **place: Any) -> None:
    """Natural frequencies of MACHINE, which springs and bodies make them, and what they depend on."""
    from symoro_elastic.vibration import modes as vibration
    from symoro_elastic.vibration.export import modes_arrays, refuse_file
    from symoro_elastic.vibration.plots import plot_modes
    from symoro_elastic.vibration.sensitivity import sensitivity
    from symoro_elastic.vibration.tables import modes_conclusion, modes_json, modes_table, state_lines

    if out:
        refuse_file(out)
    if over:
        _modes_over(machine, over, out, plots, as_json, place)
        return
    with steps() as step:
        step("modes")
        found = vibration.modes(_linearized(machine, (), (), place))
        slopes = sensitivity(found)
    if as_json:
        print_json(modes_json(found, slopes))
    else:
        click.echo("\n".join([*state_lines(found.linear), *found.linear.unrest]))
        print_table(modes_table(found, slopes), found.linear.motion.machine.name)
        click.echo(modes_conclusion(found, slopes))
    _save(out, modes_arrays(found, slopes), as_json)
    if plots:
        _drawn(plots, plot_modes(found, plots))


def _modes_over(
    machine: str, over: Sequence[str], out: str | None, plots: str | None, as_json: bool, place: dict[str, Any]
) -> None:
    """`modes --over`."""
    from symoro_elastic.vibration.export import tracked_arrays
    from symoro_elastic.vibration.linearization import motion_of
    from symoro_elastic.vibration.plots import plot_tracked
    from symoro_elastic.vibration.tables import tracked_conclusion, tracked_json, tracked_table
    from symoro_elastic.vibration.tracking import over_grid

    if place["as_given"]:
        raise InputError(
            "symoro-elastic", "--over", "modes over positions are those of equilibria: leave out --as-given"
        )
    motion = motion_of(_kept(machine), numbers(place["values"], "--value"))
    with counted("modes") as progress:
        found = over_grid(
            motion, _grid(over), numbers(place["at"], "--at"), numbers(place["torque"], "--torque"),
            _held(motion, place["hold"]), _gains(place["pd"]), progress,
        )  # fmt: skip
    if as_json:
        print_json(tracked_json(found))
    else:
        print_table(tracked_table(found), f"{motion.machine.name}: frequencies, Hz")
        click.echo(tracked_conclusion(found))
    _save(out, tracked_arrays(found), as_json)
    if plots:
        _drawn(plots, plot_tracked(found, plots))


@click.command()
@MACHINE
@situation
@INPUT
@OUTPUT
@click.option(
    "--frequencies", metavar="LOW:HIGH[:COUNT]", help="Hz, on a logarithmic scale; around all poles unless said."
)
@click.option(
    "--damping", default=0.0, metavar="RATIO", help="Damping ratio to add to every mode: 0.01 is one per cent."
)
@click.option("--out", metavar="FILE", type=click.Path(), help="Response to write: .csv, .npz or .mat.")
@PLOTS
@JSON
def response(
    machine: str,
    ins: tuple[str, ...],
    outs: tuple[str, ...],
    frequencies: str | None,
    damping: float,
    out: str | None,
    plots: str | None,
    as_json: bool,
    **place: Any,
) -> None:
    """Frequency responses of MACHINE: from motors or forces on frames to encoders or frames."""
    from symoro_elastic.vibration import export, responses
    from symoro_elastic.vibration.plots import plot_response
    from symoro_elastic.vibration.tables import response_json, response_notes, response_table
    from symoro_elastic.vibration.zeros import poles_and_zeros

    if out:
        export.refuse_file(out, (export.CSV, export.NPZ, export.MAT))
    with steps() as step:
        step("response")
        linear = responses.with_modal_damping(_linearized(machine, ins, outs, place), damping)
        _refuse_silence(linear)
        grid = responses.frequency_grid(linear, *_band(frequencies))
        found = responses.frequency_response(linear, grid)
        pairs = [poles_and_zeros(linear, i, o) for i in linear.inputs for o in linear.outputs]
    notes = [*found.notes, *response_notes(pairs)]
    if as_json:
        print_json({
            "transfers": response_json(pairs), "points": len(grid), "low": float(grid[0]), "high": float(grid[-1]),
            "notes": notes,
        })  # fmt: skip
    else:
        print_table(response_table(pairs), linear.motion.machine.name)
        click.echo("\n".join([f"{len(grid)} frequencies, {grid[0]:.4g} to {grid[-1]:.4g} Hz", *notes]))
    if out:
        export.save_response(found, out)
        click.echo(f"wrote {out}", err=as_json)
    if plots:
        _drawn(plots, plot_response(found, plots))


@click.command()
@MACHINE
@AT
@VALUE
@click.option(
    "--ratio",
    metavar="MOTOR=N",
    multiple=True,
    help="Turns of a rotor for one of its joint; couples them in the full model.",
)
@click.option(
    "--motion",
    metavar="FILE",
    type=click.Path(),
    help="Measured or simulated motion, .csv or .npz; a move unless said.",
)
@click.option("--stroke", default=0.1, show_default=True, metavar="X", help="Of the move, of every motor, rad or m.")
@click.option(
    "--duration", type=float, metavar="S", help="Of the move; five periods of the first vibration unless said."
)
@click.option("--free", is_flag=True, help="Frequencies with motors free instead of held.")
@PLOTS
@JSON
def compare(
    machine: str,
    at: tuple[str, ...],
    values: tuple[str, ...],
    ratio: tuple[str, ...],
    motion: str | None,
    stroke: float,
    duration: float | None,
    free: bool,
    plots: str | None,
    as_json: bool,
) -> None:
    """What Spong's reduced model and the rigid limit lose against the full model of MACHINE, on a motion."""
    from symoro_elastic.time_series.measurements import read_measurements
    from symoro_elastic.vibration import comparison
    from symoro_elastic.vibration.plots import plot_comparison
    from symoro_elastic.vibration.tables import (
        comparison_conclusion,
        comparison_json,
        frequencies_table,
        losses_table,
    )

    found = _kept(machine)
    with steps() as step:
        step("compare")
        course = comparison.course_of(read_measurements(motion, found)) if motion else None
        result = comparison.compare(
            found, numbers(values, "--value"), numbers(at, "--at"), numbers(ratio, "--ratio"), not free, course,
            stroke, duration,
        )  # fmt: skip
    if as_json:
        print_json(comparison_json(result))
    else:
        print_table(frequencies_table(result), f"{found.name}: motors {'free' if free else 'held'}")
        print_table(losses_table(result), result.course.source)
        click.echo(comparison_conclusion(result))
    if plots:
        _drawn(plots, plot_comparison(result, plots))


def _kept(path: str) -> Machine:
    """The machine of a file, with what its own scene locks."""
    from symoro_elastic.machine.restrict import restricted

    found = read(path)
    return restricted(found, scene_of(found, None))


def _linearized(path: str, ins: Sequence[str], outs: Sequence[str], place: dict[str, Any]) -> Linearization:
    """The linearization that the options ask for."""
    from symoro_elastic.vibration import linearization
    from symoro_elastic.vibration.equilibrium import equilibrium, given_state

    motion = linearization.motion_of(_kept(path), numbers(place["values"], "--value"), ins, outs)
    at, torques, rates = (numbers(place[name], f"--{name}") for name in ("at", "torque", "rate"))
    if place["as_given"]:
        state = given_state(motion, at, rates, torques)
    elif rates:
        raise InputError("symoro-elastic", "--rate", "an equilibrium is at rest: add --as-given, or leave it out")
    else:
        state = equilibrium(motion, at, torques)
    linear = linearization.linearize(motion, state, ins or None, outs or None)
    held = linearization.with_motors(linear, _held(motion, place["hold"]), _gains(place["pd"]))
    _refuse_still(linear, held, ins, outs)
    return held


def _refuse_still(linear: Linearization, held: Linearization, ins: Sequence[str], outs: Sequence[str]) -> None:
    """Refuse signals of held motors that were asked for."""
    for option, asked, before, left in (
        ("--input", ins, linear.inputs, held.inputs),
        ("--output", outs, linear.outputs, held.outputs),
    ):
        still = [name for name in before if name not in left]
        if asked and still:
            what = f"{still[0]} is of a motor that is held, so nothing moves there: leave out one of the two"
            raise InputError(linear.motion.source, option, what)


def _refuse_silence(linear: Linearization) -> None:
    """Refuse a response without input or output."""
    for option, names, such in (("--input", linear.inputs, "fx"), ("--output", linear.outputs, "x")):
        if not names:
            frame = linear.motion.machine.joints[-1].name
            what = f"no motor is there, or all are held: name one, such as {frame}.{such}"
            raise InputError(linear.motion.source, option, what)


def _held(motion: EquationsOfMotion, names: Sequence[str]) -> list[str]:
    return [motion.names[k] for k in motion.motors] if "all" in names else list(names)


def _gains(given: Sequence[str]) -> dict[str, tuple[float, float]]:
    for text in given:
        if ":" not in text:
            raise InputError(
                "symoro-elastic", "--pd", f"{text!r} is not MOTOR=KP:KD, in N/m and N s/m or N m/rad and N m s/rad"
            )
    return ranges(given, "--pd")


def _grid(over: Sequence[str]) -> dict[str, list[float]]:
    """`JOINT=LOW:HIGH:COUNT` by joint."""
    grid = {}
    for text in over:
        name, _, limits = text.partition("=")
        low, high, count = _three(limits, "--over", text)
        if name.strip() in grid:
            raise InputError("symoro-elastic", "--over", f"{name.strip()} is given twice: name each joint once")
        grid[name.strip()] = [low + (high - low) * k / max(count - 1, 1) for k in range(count)]
    return grid


def _band(text: str | None) -> tuple[float, float, int] | tuple[()]:
    if text is None:
        return ()
    return _three(text if text.count(":") > 1 else f"{text}:2000", "--frequencies", text)


def _three(limits: str, option: str, text: str) -> tuple[float, float, int]:
    parts = limits.split(":")
    try:
        low, high, count = float(parts[0]), float(parts[1]), int(parts[2])
        if len(parts) != 3 or count < 1 or not abs(low) + abs(high) < float("inf"):
            raise ValueError
    except (ValueError, IndexError):
        raise InputError(
            "symoro-elastic", option, f"{text!r}: give LOW:HIGH:COUNT, numbers and a count from 1"
        ) from None
    return low, high, count


def _save(out: str | None, arrays: dict[str, Any], quiet: bool) -> None:
    if out:
        from symoro_elastic.vibration.export import save_arrays

        save_arrays(arrays, out)
        click.echo(f"wrote {out}", err=quiet)


def _drawn(folder: str, written: Sequence[Any]) -> None:
    click.echo(f"wrote {folder}: {', '.join(path.name for path in written)}", err=True)
