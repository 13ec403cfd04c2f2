"""What is printed of vibrations: tables, figures for JSON, and a sentence that concludes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from symoro_elastic.identification.trajectory import motors_of
from symoro_elastic.vibration.comparison import Comparison
from symoro_elastic.vibration.energies import GRAVITY, Shares, frame_shapes, kinetic_shares, strain_shares
from symoro_elastic.vibration.export import arrays_of
from symoro_elastic.vibration.feed_forward import Following, figures
from symoro_elastic.vibration.linearization import Linearization
from symoro_elastic.vibration.modes import Modes, damped
from symoro_elastic.vibration.sensitivity import Sensitivity
from symoro_elastic.vibration.tracking import Tracked
from symoro_elastic.vibration.zeros import PolesAndZeros

LEAST_SHARE = 0.1
MOST_NAMED = 3


def state_json(linear: Linearization) -> dict[str, Any]:
    """Position and torque by joint, and the force left over at an equilibrium."""
    state, names = linear.state, linear.motion.names
    tau = {names[k]: float(state.tau[k]) for k in linear.motion.motors}
    return {"q": dict(zip(names, state.q.tolist(), strict=True)), "tau": tau, "residual": state.residual}


def state_lines(linear: Linearization) -> list[str]:
    """Where the machine is, and what its motors hold."""
    motion, state = linear.motion, linear.state
    at = [f"{motion.names[k]} at {state.q[k]:g}" for k in motion.motors]
    units = ["N" if motion.joints[k].sigma == 1 else "N m" for k in motion.motors]
    torques = [f"{motion.names[k]} {state.tau[k]:.6g} {unit}" for k, unit in zip(motion.motors, units, strict=True)]
    sag = [k for k in range(len(motion.names)) if k not in motion.motors]
    lines = [f"{', '.join(at)}; torques {', '.join(torques)}"] if at else []
    if sag and np.abs(state.q[sag]).max() > 0:
        most = max(sag, key=lambda k: abs(state.q[k]))
        lines.append(f"largest of the other positions: {motion.names[most]} {state.q[most]:.4g}")
    return lines


def linearization_json(linear: Linearization) -> dict[str, Any]:
    """Matrices as rows, names, state; poles in rad/s as [real, imaginary]."""
    arrays = {name: x.tolist() if isinstance(x, np.ndarray) else x for name, x in arrays_of(linear).items()}
    return {**arrays, "poles": [[pole.real, pole.imag] for pole in damped(linear)[0].tolist()]}


def modes_table(found: Modes, slopes: Sensitivity) -> Any:
    """A row a mode: Hz, damping, the springs that give way, the bodies that move, what it depends on."""
    from rich.table import Table

    strain, kinetic = strain_shares(found), kinetic_shares(found)
    table = Table("mode", "Hz", "damping", "strain energy in", "kinetic energy in", "% of Hz by % of")
    for k, f in enumerate(found.frequencies):
        ratio = found.damping_ratios[k]
        by = ", ".join(f"{name} {x:+.2f}" for name, x in slopes.strongest(k, MOST_NAMED))
        grows = found.growth[k]
        table.add_row(
            str(k + 1), f"{f:.6g}" if not grows else f"0, grows {grows:.3g} 1/s",
            "-" if math.isnan(ratio) else f"{100 * ratio:.3g} %", _most(strain, k), _most(kinetic, k), by or "-",
        )  # fmt: skip
    return table


def _most(shares: Shares, mode: int) -> str:
    """Names with the largest shares."""
    order = np.argsort(-shares.shares[:, mode], kind="stable")[:MOST_NAMED]
    named = [k for k in order if shares.shares[k, mode] >= LEAST_SHARE]
    return ", ".join(f"{shares.names[k]} {shares.shares[k, mode]:.0%}" for k in named) or "-"


def modes_json(found: Modes, slopes: Sensitivity) -> dict[str, Any]:
    """All figures of modes by name; NaN as null. Sensitivities are df/dp, Hz by the unit of the parameter."""
    strain, kinetic = strain_shares(found), kinetic_shares(found)
    frames = [joint.name for joint in found.linear.motion.machine.joints]
    seen = np.moveaxis(frame_shapes(found), 2, 0)
    return {
        "frequencies": found.frequencies.tolist(),
        "growth": found.growth.tolist(),
        "damping_ratios": [None if math.isnan(x) else x for x in found.damping_ratios.tolist()],
        "poles": [[pole.real, pole.imag] for pole in found.poles.tolist()],
        "shapes": dict(zip(found.linear.coordinates, found.shapes.tolist(), strict=True)),
        "frame_shapes": {name: seen[:, k].tolist() for k, name in enumerate(frames)},
        "strain_energy": dict(zip(strain.names, strain.shares.tolist(), strict=True)),
        "kinetic_energy": dict(zip(kinetic.names, kinetic.shares.tolist(), strict=True)),
        "sensitivity": dict(zip(slopes.parameters, slopes.slopes.tolist(), strict=True)),
        "state": state_json(found.linear),
        "conclusion": modes_conclusion(found, slopes),
    }


def modes_conclusion(found: Modes, slopes: Sensitivity) -> str:
    """The spring that limits the first frequency, and what would raise it."""
    vibrating = np.flatnonzero(found.frequencies > 0)
    if not len(vibrating):
        return "nothing vibrates here: no mode has a frequency above 0 Hz"
    first = int(vibrating[np.argmin(found.frequencies[vibrating])])
    name, share = strain_shares(found).largest(first)
    f = found.frequencies[first]
    limit = f"the first vibration, {f:.4g} Hz, is limited by {name} ({share:.0%} of its strain energy)"
    springs = [(p, x) for p, x in slopes.strongest(first, len(slopes.parameters)) if p == f"{name}.stiffness" and x > 0]
    gain = [f"1 % more {p} raises it by {x:.2g} %" for p, x in springs if name != GRAVITY]
    unstable = [f"mode {k + 1} is no vibration: it grows" for k in np.flatnonzero(found.growth)]
    return "; ".join([limit, *gain, *unstable])


def tracked_table(tracked: Tracked) -> Any:
    """A row a position, a column a mode that vibrates."""
    from rich.table import Table

    f = tracked.frequencies
    shown = [k for k in range(f.shape[1]) if f[:, k].any()]
    table = Table(*tracked.joints, *(f"mode {k + 1}" for k in shown), "least MAC")
    for place, row, mac in zip(tracked.positions, f, tracked.mac, strict=True):
        table.add_row(*(f"{x:.4g}" for x in place), *(f"{row[k]:.5g}" for k in shown), f"{mac.min():.3f}")
    return table


def tracked_json(tracked: Tracked) -> dict[str, Any]:
    """Positions, frequencies (points x modes) and MAC of each pair."""
    return {
        "joints": list(tracked.joints),
        "positions": tracked.positions.tolist(),
        "frequencies": tracked.frequencies.tolist(),
        "mac": tracked.mac.tolist(),
        "conclusion": tracked_conclusion(tracked),
    }


def tracked_conclusion(tracked: Tracked) -> str:
    """The mode that depends most on the position, and where pairs are in doubt."""
    f = tracked.frequencies
    low, high = f.min(axis=0), f.max(axis=0)
    spread = np.divide(high - low, high, out=np.zeros_like(high), where=high > 0)
    k = int(spread.argmax())
    if not spread.any():
        return "no frequency depends on the position"
    said = f"mode {k + 1} depends most on the position: {low[k]:.4g} to {high[k]:.4g} Hz"
    if not tracked.doubtful:
        return said
    point, mode = tracked.doubtful[0]
    return f"{said}; {len(tracked.doubtful)} pairs are in doubt (mode {mode + 1} at position {point + 1}): a finer grid"


def response_table(found: Sequence[PolesAndZeros]) -> Any:
    """A row a transfer function: resonances and antiresonances, Hz."""
    from rich.table import Table

    table = Table("from", "to", "resonances, Hz", "antiresonances, Hz")
    for each in found:
        lists = [", ".join(f"{f:.5g}" for f in fs) or "-" for fs in (each.resonances, each.antiresonances)]
        table.add_row(each.input, each.output, *(("no response", "-") if each.is_zero else lists))
    return table


def response_notes(found: Sequence[PolesAndZeros]) -> list[str]:
    """What does not move what."""
    return [f"no response: {each.input} does not move {each.output}" for each in found if each.is_zero]


def response_json(found: Sequence[PolesAndZeros]) -> list[dict[str, Any]]:
    """Poles and zeros in rad/s as [real, imaginary], resonances and antiresonances in Hz."""
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
        for each in found
    ]


def frequencies_table(found: Comparison) -> Any:
    """Frequencies of the full and the reduced model side by side; the rigid limit's at the end."""
    from rich.table import Table

    table = Table("mode", "full, Hz", "reduced, Hz", "reduced / full")
    for k, (f, g) in enumerate(zip(found.full.frequencies, found.reduced.frequencies, strict=True), start=1):
        table.add_row(str(k), f"{f:.6g}", f"{g:.6g}", f"{g / f - 1:+.2%}" if f else "-")
    return table


def losses_table(found: Comparison) -> Any:
    """What each approximation misses of torques and accelerations, root mean square and largest."""
    from rich.table import Table

    table = Table("joint", "quantity", "full, rms / largest", "reduced misses", "rigid misses")
    for loss in found.losses:
        sizes = (f"{rms:.3g} / {most:.3g}" for rms, most in (loss.full, loss.reduced, loss.rigid))
        table.add_row(loss.joint, f"{loss.quantity}, {loss.unit}", *sizes)
    return table


def following_table(found: Following) -> Any:
    """A row a motor: derivatives needed, torque, velocity, and how far the motor is ahead of what it drives."""
    from rich.table import Table

    said = figures(found)["motors"]
    table = Table("motor", "derivatives needed / given", "torque, largest / rms", "velocity", "ahead by")
    for joint in motors_of(found.machine):
        motor, (unit, force) = said[joint.name], ("m", "N") if joint.sigma == 1 else ("rad", "N m")
        table.add_row(
            joint.name, f"{motor['order']} / {motor['given']}",
            f"{motor['torque']:.4g} / {motor['torque_rms']:.4g} {force}",
            f"{motor['velocity']:.4g} {unit}/s", f"{motor['lead']:.4g} {unit}",
        )  # fmt: skip
    return table


def comparison_json(found: Comparison) -> dict[str, Any]:
    """Frequencies of the three models, losses as [rms, largest]."""
    return {
        "frequencies": {
            "full": found.full.frequencies.tolist(),
            "reduced": found.reduced.frequencies.tolist(),
            "rigid": found.rigid.frequencies.tolist() if found.rigid else [],
        },
        "motion": found.course.source,
        "losses": [
            {
                "joint": loss.joint, "quantity": loss.quantity, "unit": loss.unit,
                "full": list(loss.full), "reduced": list(loss.reduced), "rigid": list(loss.rigid),
            }
            for loss in found.losses
        ],
        "conclusion": comparison_conclusion(found),
    }  # fmt: skip


def comparison_conclusion(found: Comparison) -> str:
    """How large the losses are, in one sentence."""
    torques = [loss for loss in found.losses if loss.quantity == "torque" and loss.full[0] > 0]
    parts = []
    if found.alike:
        parts.append(
            "no rotor turns with its body here, so the reduced model is the full one"
            " (rotor inertias of the table are decoupled already; --ratio couples them)"
        )
    elif torques:
        worst = max(torques, key=lambda loss: loss.reduced[0] / loss.full[0])
        parts.append(
            f"the reduced model misses up to {worst.reduced[0] / worst.full[0]:.2g} of the torque of {worst.joint}"
        )
    if torques:
        worst = max(torques, key=lambda loss: loss.rigid[0] / loss.full[0])
        parts.append(f"the rigid limit misses {worst.rigid[0] / worst.full[0]:.2g} of that of {worst.joint}")
    return "; ".join(parts) or "no motor has a torque on this motion"
