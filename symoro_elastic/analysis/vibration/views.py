"""Results of vibration analyses as tables, as data for JSON, and as one sentence."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import takewhile
from typing import Any

import numpy as np

from symoro_elastic.array_types import Array
from symoro_elastic.machine.free_base import COORDINATES
from symoro_elastic.vibration.comparison import Compared, Comparison, Loss
from symoro_elastic.vibration.energies import GRAVITY_AND_LOADS, Shares, frame_shapes, kinetic_shares, strain_shares
from symoro_elastic.vibration.export import arrays_of
from symoro_elastic.vibration.feed_forward import FeedForward, figures
from symoro_elastic.vibration.hover import thrusts_of
from symoro_elastic.vibration.linearization import Linearization
from symoro_elastic.vibration.modes import Modes, damped
from symoro_elastic.vibration.sensitivity import Sensitivity
from symoro_elastic.vibration.tracking import Tracked
from symoro_elastic.vibration.zeros import PolesAndZeros

LEAST_SHARE = 0.1
MOST_LISTED = 3
ROUNDING = 1e-12
"""Of the numbers from which another is computed; what is smaller is printed as zero."""
LEAST_LOSS = 1e-12
"""Of a quantity of the full model, for a difference to be more than rounding."""


def state_json(linear: Linearization) -> dict[str, Any]:
    """Return position and torque by joint, and the unbalanced force at an equilibrium."""
    state, names = linear.state, linear.motion.names
    tau = dict(zip(linear.motion.motor_names, state.torques.tolist(), strict=True))
    q = dict(zip(names, state.q.tolist(), strict=True))
    base = {name: float(state.tau[k]) for k, name in enumerate(names) if name in COORDINATES}
    carried = {"base": base} if any(base.values()) else {}
    carried |= {"thrusts": found} if (found := thrusts_of(linear.motion)) else {}
    return {"q": q, "tau": tau, "residual": state.residual, "notes": list(linear.doubts), **carried}


def state_lines(linear: Linearization) -> list[str]:
    """Return lines with the position of the machine and the torques that hold it."""
    motion, state = linear.motion, linear.state
    at = [f"{motion.names[k]} at {state.q[k]:g}" for k in motion.motors]
    scale = max(float(np.abs(state.tau).max(initial=0.0)), _weight(linear))
    tau = [_cleared(x, scale) for x in state.tau]
    motors = zip(motion.machine.motor_joints, state.torques, strict=True)
    torques = [f"{joint.name} {_cleared(x, scale):.6g} {joint.force_unit}" for joint, x in motors]
    base = [k for k, name in enumerate(motion.names) if name in COORDINATES]
    sag = [k for k in range(len(motion.names)) if k not in motion.motors]
    lines = [f"{', '.join(at)}; torques {', '.join(torques)}"] if at else []
    carrying = [f"{motion.names[k]} {tau[k]:.6g} {motion.joints[k].force_unit}" for k in base if tau[k]]
    carrying += [f"{name} {x:.6g}" for name, x in thrusts_of(motion).items()]
    lines += [f"carried by {', '.join(carrying)}"] if carrying else []
    if sag and np.abs(state.q[sag]).max() > 0:
        most = max(sag, key=lambda k: abs(state.q[k]))
        lines.append(f"largest of the other positions: {motion.names[most]} {state.q[most]:.4g}")
    return lines


def _weight(linear: Linearization) -> float:
    """Return the weight of the whole machine, N."""
    motion = linear.motion
    masses = (joint.body.mass.value(motion.parameters) for joint in motion.machine.joints)
    gravity = (formula.value(motion.parameters) for formula in motion.machine.base.gravity)
    return sum(masses) * math.hypot(*gravity)


def _cleared(x: float, scale: float) -> float:
    """Return a number, zero where it is only rounding of numbers of this size."""
    return float(x) if abs(x) > ROUNDING * scale else 0.0


def linearization_json(linear: Linearization) -> dict[str, Any]:
    """Return matrices as rows, names, state; poles in rad/s as [real, imaginary]."""
    arrays = {name: x.tolist() if isinstance(x, np.ndarray) else x for name, x in arrays_of(linear).items()}
    return {**arrays, "poles": [[pole.real, pole.imag] for pole in damped(linear)[0].tolist()]}


def linearization_lines(linear: Linearization) -> list[str]:
    """Return lines with the state, the names of coordinates and signals, and whether a pole is unstable."""
    growth = damped(linear)[0].real.max(initial=0.0)
    signals = (", ".join(names) or "none" for names in (linear.inputs, linear.outputs))
    stable = f"fastest growth {growth:.3g} 1/s: unstable" if growth > 0 else "no pole is unstable"
    named = [f"coordinates: {', '.join(linear.coordinates)}", "inputs: {}; outputs: {}".format(*signals)]
    return [*state_lines(linear), *named, *linear.notes, stable]


def modes_table(modal: Modes, slopes: Sensitivity) -> Any:
    """Return a row for each mode: Hz, damping, strain energy by spring, kinetic energy by body, sensitivity."""
    from rich.table import Table

    strain, kinetic = strain_shares(modal), kinetic_shares(modal)
    table = Table("mode", "Hz", "damping", "strain energy in", "kinetic energy in", "% of Hz by % of")
    for k, f in enumerate(modal.frequencies):
        ratio = modal.damping_ratios[k]
        table.add_row(
            str(k + 1), _hertz(f, modal.growth[k], 6),
            "-" if math.isnan(ratio) else f"{100 * _cleared(ratio, 1.0):.3g} %",
            _most(strain, k), _most(kinetic, k), _by(slopes, k),
        )  # fmt: skip
    return table


def _by(slopes: Sensitivity, mode: int) -> str:
    """Return the most influential parameters of a frequency; of a repeated one in the first of its rows."""
    first = slopes.sharing(mode)[0]
    if first != mode:
        return f"see mode {first + 1}"
    shown = [(name, f"{low:+.2f}", f"{high:+.2f}") for name, low, high in slopes.strongest(mode, MOST_LISTED)]
    return ", ".join(f"{name} {low if low == high else f'{low} to {high}'}" for name, low, high in shown) or "-"


def _hertz(frequency: float, growth: float, digits: int) -> str:
    """Return a frequency, or the growth of an unstable motion."""
    return f"0, grows {growth:.3g} 1/s" if growth else f"{frequency:.{digits}g}"


def _most(shares: Shares, mode: int) -> str:
    """Return the names with the largest shares."""
    order = np.argsort(-shares.shares[:, mode], kind="stable")[:MOST_LISTED]
    named = [k for k in order if shares.shares[k, mode] >= LEAST_SHARE]
    return ", ".join(f"{shares.names[k]} {shares.shares[k, mode]:.0%}" for k in named) or "-"


def modes_json(modal: Modes, slopes: Sensitivity) -> dict[str, Any]:
    """Return all figures of modes by name; NaN as null. Sensitivities are df/dp, Hz by the unit of the parameter.

    `repeated` are the modes, counted from 1, of each frequency that comes more than once.
    """
    strain, kinetic = strain_shares(modal), kinetic_shares(modal)
    frames = [joint.name for joint in modal.linear.motion.machine.joints]
    seen = np.moveaxis(frame_shapes(modal), 2, 0)
    return {
        "frequencies": modal.frequencies.tolist(),
        "growth": modal.growth.tolist(),
        "damping_ratios": [None if math.isnan(x) else x for x in modal.damping_ratios.tolist()],
        "poles": [[pole.real, pole.imag] for pole in modal.poles.tolist()],
        "shapes": dict(zip(modal.linear.coordinates, modal.shapes.tolist(), strict=True)),
        "frame_shapes": {name: seen[:, k].tolist() for k, name in enumerate(frames)},
        "strain_energy": dict(zip(strain.names, strain.shares.tolist(), strict=True)),
        "kinetic_energy": dict(zip(kinetic.names, kinetic.shares.tolist(), strict=True)),
        "sensitivity": dict(zip(slopes.parameters, slopes.slopes.tolist(), strict=True)),
        "repeated": [[k + 1 for k in modes] for modes in slopes.repeated],
        "state": state_json(modal.linear),
        "conclusion": modes_conclusion(modal, slopes),
    }


def modes_conclusion(modal: Modes, slopes: Sensitivity) -> str:
    """Return the spring that limits the first frequency, and the gain of a stiffer one.

    Where gravity is what brings the machine back, as a pendulum, the first frequency that a spring limits, too.
    """
    vibrating = np.flatnonzero(modal.frequencies > 0)
    unstable = [f"mode {k + 1} is no vibration: it grows" for k in np.flatnonzero(modal.growth)]
    if not len(vibrating):
        return "; ".join(["nothing vibrates here: no mode has a frequency above 0 Hz", *unstable])
    by_frequency = sorted(map(int, vibrating), key=lambda k: float(modal.frequencies[k]))
    strain = strain_shares(modal)
    swings = list(takewhile(lambda k: strain.largest(k)[0] == GRAVITY_AND_LOADS, by_frequency))
    parts = _limit(modal, slopes, by_frequency[0], "the first vibration")
    if swings and len(swings) < len(by_frequency):
        parts += _limit(modal, slopes, by_frequency[len(swings)], "the first that springs limit")
    parts += [_FREE] * bool(swings and modal.linear.motion.motors and not modal.linear.held)
    return "; ".join([*parts, *unstable, *map(_repeated, slopes.repeated)])


_FREE = "motors are free here: --hold all holds them"


def _limit(modal: Modes, slopes: Sensitivity, first: int, which: str) -> list[str]:
    """Return the springs that limit a frequency, and the gain of a stiffer one."""
    strain, sharing = strain_shares(modal), list(slopes.sharing(first))
    whole = Shares(strain.names, strain.shares[:, sharing].mean(axis=1, keepdims=True))
    said = f"{which}, {modal.frequencies[first]:.4g} Hz, is limited by"
    if len(sharing) > 1:
        return [f"{said} {_most(whole, 0)} of its strain energy"]
    name, share = whole.largest(0)
    springs = [x for p, x, _ in slopes.strongest(first, len(slopes.parameters)) if p == f"{name}.stiffness" and x > 0]
    gain = [f"1 % more {name}.stiffness raises it by {x:.2g} %" for x in springs if name != GRAVITY_AND_LOADS]
    return [f"{said} {name} ({share:.0%} of its strain energy)", *gain]


def _repeated(modes: Sequence[int]) -> str:
    return (
        f"modes {modes[0] + 1} to {modes[-1] + 1} are one frequency: their shapes may be mixed at will, and a"
        " parameter splits it, from the least to the largest of its slopes"
    )


def tracked_table(tracked: Tracked) -> Any:
    """Return a row for each position, a column for each mode that vibrates or grows anywhere."""
    from rich.table import Table

    f, growth = tracked.frequencies, tracked.growth
    shown = np.flatnonzero(f.any(axis=0) | growth.any(axis=0))
    table = Table(*tracked.joints, *(f"mode {k + 1}" for k in shown), "least MAC")
    for point, (place, mac) in enumerate(zip(tracked.positions, tracked.mac, strict=True)):
        hertz = (_hertz(f[point, k], growth[point, k], 5) for k in shown)
        table.add_row(*(f"{x:.4g}" for x in place), *hertz, f"{mac.min():.3f}")
    return table


def tracked_json(tracked: Tracked) -> dict[str, Any]:
    """Return positions, frequencies, growth (points x modes) and MAC of each pair."""
    return {
        "joints": list(tracked.joints),
        "positions": tracked.positions.tolist(),
        "frequencies": tracked.frequencies.tolist(),
        "growth": tracked.growth.tolist(),
        "mac": tracked.mac.tolist(),
        "conclusion": tracked_conclusion(tracked),
    }


def tracked_conclusion(tracked: Tracked) -> str:
    """Return the mode that depends most on the position, and the doubtful pairs."""
    f = tracked.frequencies
    low, high = f.min(axis=0), f.max(axis=0)
    spread = np.divide(high - low, high, out=np.zeros_like(high), where=high > 0)
    k = int(spread.argmax())
    said = "no frequency depends on the position"
    if spread.any():
        said = f"mode {k + 1} depends most on the position: {low[k]:.4g} to {high[k]:.4g} Hz"
    growing = np.flatnonzero(tracked.growth.any(axis=0))
    parts = [said, *(f"mode {m + 1} grows at {_positions(tracked.growth[:, m])}" for m in growing)]
    if tracked.doubtful:
        point, mode = tracked.doubtful[0]
        count = len(tracked.doubtful)
        parts.append(f"{count} pairs are in doubt (mode {mode + 1} at position {point + 1}): a finer grid")
    return "; ".join(parts)


def _positions(growth: Array) -> str:
    count = int(np.count_nonzero(growth))
    return f"{count} of {len(growth)} positions, so it is no vibration there"


def response_table(transfers: Sequence[PolesAndZeros]) -> Any:
    """Return a row for each transfer function: resonances and antiresonances, Hz."""
    from rich.table import Table

    table = Table("from", "to", "resonances, Hz", "antiresonances, Hz")
    for each in transfers:
        lists = [", ".join(f"{f:.5g}" for f in fs) or "-" for fs in (each.resonances, each.antiresonances)]
        table.add_row(each.input, each.output, *(("no response", "-") if each.is_zero else lists))
    return table


def response_notes(transfers: Sequence[PolesAndZeros]) -> list[str]:
    """Return lines about transfer functions that are zero."""
    return [f"no response: {each.input} does not move {each.output}" for each in transfers if each.is_zero]


def response_json(transfers: Sequence[PolesAndZeros]) -> list[dict[str, Any]]:
    """Return poles and zeros in rad/s as [real, imaginary], resonances and antiresonances in Hz."""
    return [
        {
            "input": each.input,
            "output": each.output,
            "no_response": each.is_zero,
            "poles": [[s.real, s.imag] for s in each.poles.tolist()],
            "zeros": [[s.real, s.imag] for s in each.zeros.tolist()],
            "resonances": each.resonances.tolist(),
            "antiresonances": each.antiresonances.tolist(),
        }
        for each in transfers
    ]


def frequencies_table(comparison: Comparison) -> Any:
    """Return frequencies of the full and the reduced model side by side."""
    from rich.table import Table

    table = Table("mode", "full, Hz", "reduced, Hz", "reduced / full")
    for k, (f, g) in enumerate(zip(comparison.full.frequencies, comparison.reduced.frequencies, strict=True)):
        shown = (_hertz(each.frequencies[k], each.growth[k], 6) for each in (comparison.full, comparison.reduced))
        table.add_row(str(k + 1), *shown, f"{g / f - 1:+.2%}" if f else "-")
    return table


def losses_table(comparison: Comparison) -> Any:
    """Return the errors of each approximation that is one, root mean square and largest."""
    from rich.table import Table

    names = [*([] if comparison.alike else ["reduced"]), *([] if comparison.is_rigid else ["rigid"])]
    table = Table("joint", "quantity", "full, rms / largest", *(f"{name} misses" for name in names))
    for loss in comparison.losses:
        missed: list[tuple[float, float]] = [getattr(loss, name) for name in names]
        shown = [size if _matters(size, loss) else (0.0, 0.0) for size in missed]
        sizes = (f"{rms:.3g} / {most:.3g}" for rms, most in (loss.full, *shown))
        table.add_row(loss.joint, f"{loss.quantity}, {loss.unit}", *sizes)
    return table


def feed_forward_table(command: FeedForward) -> Any:
    """Return a row for each motor: derivatives needed and given, torque, velocity, lead.

    Where motors follow from loops, the derivatives are those of the joints that are to follow, in rows before.
    """
    from rich.table import Table

    said = figures(command)
    first = "joint, motor" if "joints" in said else "motor"
    table = Table(first, "derivatives needed / given", "torque, largest / rms", "velocity", "ahead by")
    for name, joint in said.get("joints", {}).items():
        table.add_row(name, f"{joint['order']} / {joint['given']}", "-", "-", "-")
    for joint in command.machine.motor_joints:
        motor, unit, force = said["motors"][joint.name], joint.unit, joint.force_unit
        table.add_row(
            joint.name, f"{motor['order']} / {motor['given']}" if "order" in motor else "-",
            f"{motor['torque']:.4g} / {motor['torque_rms']:.4g} {force}",
            f"{motor['velocity']:.4g} {unit}/s", f"{motor['lead']:.4g} {unit}" if "lead" in motor else "-",
        )  # fmt: skip
    return table


def comparison_json(comparison: Comparison) -> dict[str, Any]:
    """Return frequencies, Hz, and growth, 1/s, of the three models, losses as [rms, largest]."""
    return {
        "frequencies": {name: each.frequencies.tolist() if each else [] for name, each in _models(comparison).items()},
        "growth": {name: each.growth.tolist() if each else [] for name, each in _models(comparison).items()},
        "motion": comparison.course.source,
        "losses": [
            {
                "joint": loss.joint, "quantity": loss.quantity, "unit": loss.unit,
                "full": list(loss.full), "reduced": list(loss.reduced), "rigid": list(loss.rigid),
            }
            for loss in comparison.losses
        ],
        "notes": list(comparison.notes),
        "conclusion": comparison_conclusion(comparison),
    }  # fmt: skip


def _models(comparison: Comparison) -> dict[str, Modes | None]:
    return {"full": comparison.full, "reduced": comparison.reduced, "rigid": comparison.rigid}


def comparison_conclusion(comparison: Comparison) -> str:
    """Return the size of the losses in one sentence."""
    torques = [loss for loss in comparison.losses if loss.quantity is Compared.TORQUE]
    most = max((loss.full[1] for loss in torques), default=0.0)
    torques = [loss for loss in torques if loss.full[1] > LEAST_LOSS * most]
    parts = []
    if comparison.alike:
        parts.append(
            "no rotor turns with its body here, so the reduced model is the full one"
            " (rotor inertias of the table are decoupled already; --ratio couples them)"
        )
    elif torques:
        worst = max(torques, key=lambda loss: loss.reduced[0] / loss.full[0])
        parts.append(f"the reduced model misses {_missed(worst.reduced, worst)} of the torque of {worst.joint}")
    if comparison.is_rigid:
        parts.append("no joint is elastic, so the rigid limit is the machine itself")
    elif torques:
        worst = max(torques, key=lambda loss: loss.rigid[0] / loss.full[0])
        parts.append(f"the rigid limit misses {_missed(worst.rigid, worst)} of the torque of {worst.joint}")
    parts = parts or ["no motor has a torque on this motion"]
    for name, each in _models(comparison).items():
        parts += [f"mode {k + 1} of the {name} model grows" for k in np.flatnonzero(each.growth if each else ())]
    return "; ".join(parts)


def _matters(size: tuple[float, float], loss: Loss) -> bool:
    """Return whether a loss is more than rounding."""
    return size[1] > LEAST_LOSS * loss.full[1]


def _missed(size: tuple[float, float], loss: Loss) -> str:
    return f"up to {size[0] / loss.full[0]:.2g}" if _matters(size, loss) else "nothing"
