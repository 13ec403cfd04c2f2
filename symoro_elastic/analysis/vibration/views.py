"""Results of vibration analyses as tables, as data for JSON, as arrays, and as one sentence."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from itertools import takewhile
from typing import Any

import numpy as np

from symoro_elastic.analysis.time_series import writing
from symoro_elastic.analysis.vibration.beyond_limits import Beyond
from symoro_elastic.analysis.vibration.comparison import Compared, Comparison, Loss
from symoro_elastic.analysis.vibration.feed_forward import FeedForward, LeftOut, notes
from symoro_elastic.analysis.vibration.linearization import Linearization
from symoro_elastic.analysis.vibration.modes import (
    GRAVITY_AND_LOADS,
    Modes,
    Sensitivity,
    Shares,
    damped_poles,
    frame_shapes,
    kinetic_shares,
    strain_shares,
)
from symoro_elastic.analysis.vibration.responses import PointStiffness, Response
from symoro_elastic.analysis.vibration.tracking import Tracked
from symoro_elastic.analysis.vibration.zeros import PolesAndZeros
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.results import (
    Field,
    Part,
    Table,
    arrays_of,
    columns_of,
    declare,
    json_of,
    parts_of,
    plain,
    table_of,
)
from symoro_elastic.machine.frames import COORDINATES
from symoro_elastic.numerics.motion.equilibrium import thrusts_of

LEAST_SHARE = 0.1
MOST_SHOWN = 20
"""Frequencies whose magnitude and phase are printed."""
MOST_LISTED, LEAST_LISTED = 3, 0.005
ROUNDING = 1e-12
"""Of the numbers from which another is computed; what is smaller is printed as zero."""
LEAST_LOSS = 1e-12
"""Of a quantity of the full model, for a difference to be more than rounding."""

declare(
    Linearization,
    Field("mass", "M", array=True),
    Field("damping", "D", array=True),
    Field("stiffness", "K", array=True),
    *(Field(name, array=True) for name in ("F", "Cq", "Cv", "Ca")),
    *(Field(name, f"space.{name}", array=True) for name in ("A", "B", "C", "D", "states", "inputs", "outputs")),
    Field("notes", array=True),
    Field("joints", lambda linear: list(linear.motion.names), array=True),
    *(Field(name, f"state.{name}", array=True) for name in ("q", "qd", "qdd", "tau")),
    Field("poles", lambda linear: damped_poles(linear)[0]),
)


@parts_of.register
def _(linear: Linearization) -> Sequence[Part]:
    """Return lines with the state, the names of coordinates and signals, and whether a pole is unstable."""
    growth = damped_poles(linear)[0].real.max(initial=0.0)
    signals = (", ".join(names) or "none" for names in (linear.inputs, linear.outputs))
    stable = f"fastest growth {growth:.3g} 1/s: unstable" if growth > 0 else "no pole is unstable"
    named = [f"coordinates: {', '.join(linear.coordinates)}", "inputs: {}; outputs: {}".format(*signals)]
    return [*state_lines(linear), *named, *linear.notes, stable]


def state_json(linear: Linearization) -> dict[str, Any]:
    """Return position and torque by joint, and the unbalanced force at an equilibrium."""
    state, names = linear.state, linear.motion.names
    tau = dict(zip(linear.motion.motor_names, state.torques.tolist(), strict=True))
    q = dict(zip(names, state.q.tolist(), strict=True))
    base = {name: float(state.tau[k]) for k, name in enumerate(names) if name in COORDINATES}
    carried = {"base": base} if any(base.values()) else {}
    carried |= {"thrusts": thrusts} if (thrusts := thrusts_of(linear.motion)) else {}
    return {"q": q, "tau": tau, "residual": state.residual, "notes": list(linear.doubts), **carried}


def state_lines(linear: Linearization) -> list[str]:
    """Return lines with the position of the machine and its holding torques."""
    motion, state = linear.motion, linear.state
    at = [f"{motion.names[k]} at {state.q[k]:g} {motion.joints[k].unit}" for k in motion.motors]
    scale = max(float(np.abs(state.tau).max(initial=0.0)), _weight(linear))
    tau = [_without_rounding(x, scale) for x in state.tau]
    motors = zip(motion.machine.motor_joints, state.torques, strict=True)
    torques = [f"{joint.name} {_without_rounding(x, scale):.6g} {joint.force_unit}" for joint, x in motors]
    base = [k for k, name in enumerate(motion.names) if name in COORDINATES]
    sag = [k for k in range(len(motion.names)) if k not in motion.motors]
    lines = [f"{', '.join(at)}; torques {', '.join(torques)}"] if at else []
    carrying = [f"{motion.names[k]} {tau[k]:.6g} {motion.joints[k].force_unit}" for k in base if tau[k]]
    carrying += [f"{name} {x:.6g}" for name, x in thrusts_of(motion).items()]
    lines += [f"carried by {', '.join(carrying)}"] if carrying else []
    if sag and np.abs(state.q[sag]).max() > 0:
        most = max(sag, key=lambda k: abs(state.q[k]))
        largest = f"{motion.names[most]} {state.q[most]:.4g} {motion.joints[most].unit}"
        lines.append(f"largest of the other positions: {largest}")
    return lines


def _weight(linear: Linearization) -> float:
    """Return the total weight of the machine, N."""
    motion = linear.motion
    masses = (joint.body.mass.value(motion.parameters) for joint in motion.machine.joints)
    gravity = (formula.value(motion.parameters) for formula in motion.machine.base.gravity)
    return sum(masses) * math.hypot(*gravity)


def _without_rounding(x: float, scale: float) -> float:
    """Return x, or zero if it is within rounding errors of numbers of size `scale`."""
    return float(x) if abs(x) > ROUNDING * scale else 0.0


@parts_of.register
def _(modal: Modes) -> Sequence[Part]:
    """Return the state, the table of modes, and the spring that limits the first."""
    return [*state_lines(modal.linear), *modal.linear.doubts, modes_table(modal), modes_conclusion(modal)]


def modes_table(modal: Modes) -> Table:
    """Return a row for each mode: Hz, damping, strain energy by spring, kinetic energy by body, sensitivity."""
    strain, kinetic = strain_shares(modal), kinetic_shares(modal)
    heads = ("mode", "Hz", "damping", "strain energy in", "kinetic energy in", "sensitivity, % Hz per % of")
    table = Table(heads, title=modal.linear.motion.machine.name)
    for k, f in enumerate(modal.frequencies):
        ratio = modal.damping_ratios[k]
        table.add_row(
            str(k + 1), _hertz(f, modal.growth[k], 6),
            "-" if math.isnan(ratio) else f"{100 * _without_rounding(ratio, 1.0):.3g} %",
            _most(strain, k), _most(kinetic, k), _by(modal.sensitivity, k),
        )  # fmt: skip
    return table


def _by(slopes: Sensitivity, mode: int) -> str:
    """Return the most influential parameters of a frequency; for a repeated one in its first row only."""
    first = slopes.sharing(mode)[0]
    if first != mode:
        return f"see mode {first + 1}"
    strongest = (row for row in slopes.strongest(mode, MOST_LISTED) if max(map(abs, row[1:])) >= LEAST_LISTED)
    effects = [(name, f"{low:+.2f}", f"{high:+.2f}") for name, low, high in strongest]
    return ", ".join(f"{name} {low if low == high else f'{low} to {high}'}" for name, low, high in effects) or "-"


def _hertz(frequency: float, growth: float, digits: int) -> str:
    """Return a frequency as text, or the growth rate of an unstable mode."""
    return f"0, grows {growth:.3g} 1/s" if growth else f"{frequency:.{digits}g}"


def _most(shares: Shares, mode: int) -> str:
    """Return the names with the largest energy shares in a mode, as text."""
    order = np.argsort(-shares.shares[:, mode], kind="stable")[:MOST_LISTED]
    named = [k for k in order if shares.shares[k, mode] >= LEAST_SHARE]
    return ", ".join(f"{shares.names[k]} {shares.shares[k, mode]:.0%}" for k in named) or "-"


def modes_conclusion(modal: Modes) -> str:
    """Return the spring that limits the first frequency, and the gain of a stiffer one.

    Where gravity is what brings the machine back, as a pendulum, the first frequency that a spring limits, too.
    """
    vibrating = np.flatnonzero(modal.frequencies > 0)
    unstable = [f"mode {k + 1} is not a vibration: it grows" for k in np.flatnonzero(modal.growth)]
    if not len(vibrating):
        return "; ".join(["nothing vibrates here: no mode has a frequency above 0 Hz", *unstable])
    by_frequency = sorted(map(int, vibrating), key=lambda k: float(modal.frequencies[k]))
    strain, slopes = strain_shares(modal), modal.sensitivity
    swings = list(takewhile(lambda k: strain.largest(k)[0] == GRAVITY_AND_LOADS, by_frequency))
    parts = _limit(modal, by_frequency[0], "the first vibration")
    if swings and len(swings) < len(by_frequency):
        parts += _limit(modal, by_frequency[len(swings)], "the first that springs limit")
    parts += [_FREE] * bool(swings and modal.linear.motion.motors and not modal.linear.held)
    return "; ".join([*parts, *unstable, *map(_repeated_note, slopes.repeated)])


_FREE = "motors are free here: --hold all holds them"


def _limit(modal: Modes, first: int, which: str) -> list[str]:
    """Return the springs that limit a frequency, and the gain of a stiffer one."""
    strain, slopes = strain_shares(modal), modal.sensitivity
    sharing = list(slopes.sharing(first))
    shares = Shares(strain.names, strain.shares[:, sharing].mean(axis=1, keepdims=True))
    subject = f"{which}, {modal.frequencies[first]:.4g} Hz, is limited by"
    if len(sharing) > 1:
        return [f"{subject} {_most(shares, 0)} of its strain energy"]
    name, share = shares.largest(0)
    joints = modal.linear.motion.machine.joints
    stiffnesses = (f"{name}.stiffness", *(str(joint.spring.stiffness) for joint in joints if joint.name == name))
    springs = [(p, x) for p, x, _ in slopes.strongest(first, len(slopes.parameters)) if p in stiffnesses and x > 0]
    gain = [f"1 % more {p} raises it by {x:.2g} %" for p, x in springs if name != GRAVITY_AND_LOADS]
    return [f"{subject} {name} ({share:.0%} of its strain energy)", *gain]


def _repeated_note(modes: Sequence[int]) -> str:
    return (
        f"modes {modes[0] + 1} to {modes[-1] + 1} share one frequency: their shapes may be combined freely, and a"
        " parameter splits it, from its smallest to its largest slope"
    )


def _frames(modal: Modes) -> list[str]:
    return [joint.name for joint in modal.linear.motion.machine.joints]


def _rows(names: Iterable[Any], rows: Iterable[Any]) -> dict[Any, Any]:
    return dict(zip(names, rows, strict=True))


declare(
    Modes,
    Field("frequencies", array=True, column="frequency"),
    Field("eigenvalues", array=True, json=False),
    Field("damping_ratios", array=True, column="damping_ratio"),
    Field("poles", array=True),
    Field("shapes", array=True, json=False),
    Field("coordinates", "linear.coordinates", array=True, json=False),
    Field("frame_shapes", frame_shapes, array=True, json=False),
    Field("frames", _frames, array=True, json=False),
    Field("sensitivity", "sensitivity.slopes", array=True, json=False),
    Field("parameters", "sensitivity.parameters", array=True, json=False),
    Field("growth", column="growth"),
    Field("shapes", lambda modal: _rows(modal.linear.coordinates, modal.shapes)),
    Field("frame_shapes", lambda modal: _rows(_frames(modal), frame_shapes(modal).transpose(0, 2, 1))),
    Field("strain_energy", lambda modal: strain_shares(modal).by_name, column="strain in {}"),
    Field("kinetic_energy", lambda modal: kinetic_shares(modal).by_name),
    Field("sensitivity", lambda modal: _rows(modal.sensitivity.parameters, modal.sensitivity.slopes)),
    Field("repeated", lambda modal: [[k + 1 for k in modes] for modes in modal.sensitivity.repeated]),
    Field("state", lambda modal: state_json(modal.linear)),
    Field("conclusion", modes_conclusion),
)


@parts_of.register
def _(tracked: Tracked) -> Sequence[Part]:
    """Return the table of frequencies, and where they are lowest and highest."""
    return [tracked_table(tracked), tracked_conclusion(tracked)]


def tracked_table(tracked: Tracked) -> Table:
    """Return a row for each position, a column for each mode that vibrates or grows anywhere."""
    f, growth = tracked.frequencies, tracked.growth
    listed = np.flatnonzero(f.any(axis=0) | growth.any(axis=0))
    title = f"{tracked.modes[0].linear.motion.machine.name}: frequencies, Hz"
    table = Table((*tracked.joints, *(f"mode {k + 1}" for k in listed), "least MAC"), title=title)
    for point, (place, mac) in enumerate(zip(tracked.positions, tracked.mac, strict=True)):
        hertz = (_hertz(f[point, k], growth[point, k], 5) for k in listed)
        table.add_row(*(f"{x:.4g}" for x in place), *hertz, f"{mac.min():.3f}")
    return table


def tracked_conclusion(tracked: Tracked) -> str:
    """Return the mode that depends most on the position, and the doubtful pairs."""
    f = tracked.frequencies
    low, high = f.min(axis=0), f.max(axis=0)
    spread = np.divide(high - low, high, out=np.zeros_like(high), where=high > 0)
    k = int(spread.argmax())
    conclusion = "no frequency depends on the position"
    if spread.any():
        conclusion = f"mode {k + 1} depends most on the position: {low[k]:.4g} to {high[k]:.4g} Hz"
    growing, counts = np.flatnonzero(tracked.growth.any(axis=0)), np.count_nonzero(tracked.growth, axis=0)
    there = f"of {len(f)} positions, so it is not a vibration there"
    parts = [conclusion, *(f"mode {m + 1} grows at {counts[m]} {there}" for m in growing)]
    if tracked.doubtful:
        point, mode = tracked.doubtful[0]
        count = len(tracked.doubtful)
        parts.append(f"{count} pairs are in doubt (mode {mode + 1} at position {point + 1}): a finer grid")
    return "; ".join(parts)


declare(
    Tracked,
    *(Field(name, array=True) for name in ("joints", "positions", "frequencies", "growth", "mac")),
    Field("shapes", lambda tracked: np.array([modal.shapes for modal in tracked.modes]), array=True, json=False),
    Field("coordinates", lambda tracked: tracked.modes[0].linear.coordinates, array=True, json=False),
    Field("conclusion", tracked_conclusion),
    Field("joint", lambda tracked: _rows(tracked.joints, tracked.positions.T), json=False, column="{}"),
    Field("mode", lambda tracked: dict(enumerate(tracked.frequencies.T, start=1)), json=False, column="mode {}"),
)


def _list(transfer: PolesAndZeros, frequencies: Array, none: str) -> str:
    return none if transfer.is_zero else ", ".join(f"{f:.5g}" for f in frequencies) or "-"


def _pairs(response: Response) -> dict[str, Any]:
    """Return the complex response of the pairs."""
    pairs = ((i, j) for i in range(len(response.outputs)) for j in range(len(response.inputs)))
    return {f"{response.outputs[i]} / {response.inputs[j]}": response.values[:, i, j] for i, j in pairs}


def _values(response: Response) -> list[dict[str, Any]]:
    """Return magnitude and phase (deg, -180 to 180) by pair and frequency; empty for many frequencies."""
    few = response.frequencies if len(response.frequencies) <= MOST_SHOWN else ()
    return [
        {"frequency": float(f), "input": source, "output": output, "magnitude": abs(x),
         "unit": response.unit(output, source), "phase": float(np.angle(x, deg=True))}
        for k, f in enumerate(few)
        for j, source in enumerate(response.inputs)
        for i, output in enumerate(response.outputs)
        for x in [complex(response.values[k, i, j])]
    ]  # fmt: skip


declare(
    PolesAndZeros,
    Field("input", head="from"),
    Field("output", head="to"),
    Field("no_response", "is_zero"),
    *map(Field, ("poles", "zeros")),
    Field("resonances", "", "resonances", "Hz", text=lambda x: _list(x, x.resonances, "no response")),
    Field("antiresonances", "", "antiresonances", "Hz", text=lambda x: _list(x, x.antiresonances, "-")),
)
declare(
    PointStiffness, *map(Field, ("output", "source", "unit", "static", "held_by", "peak", "frequency", "shaken_by"))
)
declare(
    Response,
    Field("transfers"),
    Field("stiffnesses"),
    Field("points", lambda response: len(response.frequencies)),
    Field("low", lambda response: response.frequencies[0]),
    Field("high", lambda response: response.frequencies[-1]),
    Field("values", _values),
    Field("notes", "all_notes"),
    Field("frequencies", array=True, json=False, column="frequency"),
    Field("G", "values", array=True, json=False),
    *(Field(name, array=True, json=False) for name in ("inputs", "outputs")),
    Field("pairs", _pairs, json=False, column="{}"),
)


@parts_of.register
def _(response: Response) -> Sequence[Part]:
    """Return the table of poles and zeros, the response at a few frequencies or else their band, and notes."""
    f = response.frequencies
    table = table_of(PolesAndZeros, response.transfers, response.machine)
    values = values_table(response) if len(f) <= MOST_SHOWN else f"{len(f)} frequencies, {f[0]:.4g} to {f[-1]:.4g} Hz"
    return [table, values, *(point.sentence for point in response.stiffnesses), *response.all_notes]


def values_table(response: Response) -> Table:
    """Return a table of magnitude and phase by pair and frequency."""
    table = Table(("frequency, Hz", "from", "to", "magnitude", "unit", "phase, deg"))
    for row in _values(response):
        f, source, output, size, unit, phase = row.values()
        table.add_row(f"{f:.6g}", source, output, f"{size:.4g}", unit, f"{phase:.1f}")
    return table


@parts_of.register
def _(comparison: Comparison) -> Sequence[Part]:
    """Return frequencies and losses of the simpler models, and a conclusion."""
    tables = [frequencies_table(comparison), losses_table(comparison)]
    return [*tables, *comparison.notes, comparison_conclusion(comparison)]


def frequencies_table(comparison: Comparison) -> Table:
    """Return frequencies of the full and the reduced model side by side."""
    title = f"{comparison.full.linear.motion.machine.name}: motors {'held' if comparison.held else 'free'}"
    table = Table(("mode", "full, Hz", "reduced, Hz", "reduced / full"), title=title)
    for k, (f, g) in enumerate(zip(comparison.full.frequencies, comparison.reduced.frequencies, strict=True)):
        shown = (_hertz(modal.frequencies[k], modal.growth[k], 6) for modal in (comparison.full, comparison.reduced))
        table.add_row(str(k + 1), *shown, f"{g / f - 1:+.2%}" if f else "-")
    return table


def losses_table(comparison: Comparison) -> Table:
    """Return the RMS and largest errors of the approximations that differ from the full model."""
    names = [*([] if comparison.alike else ["reduced"]), *([] if comparison.is_rigid else ["rigid"])]
    heads = ("joint", "quantity", "full, rms / largest", *(f"{name} misses" for name in names))
    table = Table(heads, title=comparison.trajectory.source)
    for loss in comparison.losses:
        missed: list[tuple[float, float]] = [getattr(loss, name) for name in names]
        significant = [size if _matters(size, loss) else (0.0, 0.0) for size in missed]
        sizes = (f"{rms:.3g} / {most:.3g}" for rms, most in (loss.full, *significant))
        table.add_row(loss.joint, f"{loss.quantity}, {loss.unit}", *sizes)
    return table


def _models(comparison: Comparison) -> dict[str, Modes | None]:
    return {"full": comparison.full, "reduced": comparison.reduced, "rigid": comparison.rigid}


def comparison_conclusion(comparison: Comparison) -> str:
    """Return the torque errors of the reduced model and of the rigid limit, in one sentence."""
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
        parts.append(f"the reduced model misses {_error_text(worst.reduced, worst)} of the torque of {worst.joint}")
    if comparison.is_rigid:
        parts.append("no joint is elastic, so the rigid limit is the machine itself")
    elif torques:
        worst = max(torques, key=lambda loss: loss.rigid[0] / loss.full[0])
        parts.append(f"the rigid limit misses {_error_text(worst.rigid, worst)} of the torque of {worst.joint}")
    parts = parts or ["no motor has a torque on this motion"]
    for name, modal in _models(comparison).items():
        parts += [f"mode {k + 1} of the {name} model grows" for k in np.flatnonzero(modal.growth if modal else ())]
    return "; ".join(parts)


def _matters(size: tuple[float, float], loss: Loss) -> bool:
    """Return whether an error of the reduced or rigid model exceeds rounding."""
    return size[1] > LEAST_LOSS * loss.full[1]


def _error_text(size: tuple[float, float], loss: Loss) -> str:
    return f"up to {size[0] / loss.full[0]:.2g}" if _matters(size, loss) else "nothing"


declare(Beyond, *map(Field, ("joint", "quantity", "t", "value", "low", "high", "unit")))
declare(Loss, *map(Field, ("joint", "quantity", "unit", "full", "reduced", "rigid")))
declare(
    Comparison,
    Field("frequencies", lambda x: {name: modal.frequencies if modal else () for name, modal in _models(x).items()}),
    Field("growth", lambda x: {name: modal.growth if modal else () for name, modal in _models(x).items()}),
    Field("motion", "trajectory.source"),
    Field("losses"),
    Field("notes"),
    Field("conclusion", comparison_conclusion),
)


@parts_of.register
def _(command: FeedForward) -> Sequence[Part]:
    """Return the table of motors, the samples, and notes."""
    samples = f"{command.t[-1] - command.t[0]:.6g} s, {len(command.t)} samples"
    return [feed_forward_table(command), samples, *map(str, command.beyond), *notes(command)]


def feed_forward_table(command: FeedForward) -> Table:
    """Return a row for each motor: derivatives needed and given, torque, velocity, lead.

    Where motors follow from loops, the derivatives are those of the joints that are to follow, in rows before.
    """
    data = command.as_json()
    first = "joint, motor" if "joints" in data else "motor"
    heads = (first, "derivatives needed / given", "torque, largest / rms", "velocity", "ahead by")
    table = Table(heads, title=f"{command.machine.name}: {data['motion']}")
    for name, joint in data.get("joints", {}).items():
        table.add_row(name, f"{joint['order']} / {joint['given']}", "-", "-", "-")
    for joint in command.machine.motor_joints:
        motor, unit, force = data["motors"][joint.name], joint.unit, joint.force_unit
        table.add_row(
            joint.name, f"{motor['order']} / {motor['given']}" if "order" in motor else "-",
            f"{motor['torque']:.4g} / {motor['torque_rms']:.4g} {force}",
            f"{motor['velocity']:.4g} {unit}/s", f"{motor['lead']:.4g} {unit}" if "lead" in motor else "-",
        )  # fmt: skip
    return table


declare(LeftOut, Field("deflections"), Field("frequency"))


@json_of.register
def _(command: FeedForward) -> dict[str, Any]:
    """Return by motor: order needed and given, largest and rms torque, velocity, lead of the motor; notes."""
    wanted = [joint.name for joint in command.wanted]
    motors: dict[str, dict[str, float]] = {}
    for m, name in enumerate(command.motors):
        tau = command.tau[:, m]
        own = command.following is None
        motors[name] = {
            **(_derivatives(command, name) if own else {}),
            "torque": float(np.abs(tau).max()),
            "torque_rms": float(np.sqrt(np.mean(tau**2))),
            "velocity": float(np.abs(command.velocities[:, m]).max()),
            **({"lead": float(np.abs(command.lead[:, m]).max())} if own else {}),
        }
    joints = {name: _derivatives(command, name) for name in wanted} if command.following else {}
    return {
        "motion": command.reference.source, "duration": float(command.t[-1] - command.t[0]), "samples": len(command.t),
        "motors": motors, **({"joints": joints} if joints else {}),
        "left_out": plain(command.left_out), "beyond_limits": plain(command.beyond), "notes": notes(command),
    }  # fmt: skip


def _derivatives(command: FeedForward, name: str) -> dict[str, float]:
    """Return the required and the available number of derivatives of a joint's motion."""
    return {"order": command.orders[name], "given": command.reference.order(name)}


@arrays_of.register
@columns_of.register
def _(command: FeedForward) -> dict[str, Array]:
    """Return t, q_<joint>, qd_<joint>, tau_<motor>, a row a sample."""
    joints = [joint.name for joint in command.machine.independent_joints]
    blocks = [("q", command.q, joints), ("qd", command.qd, joints), ("tau", command.tau, command.motors)]
    if command.following:
        own = [name not in joints for name in command.motors]
        names = [name for name in command.motors if name not in joints]
        blocks[2:2] = [("q", command.following.x[:, own], names), ("qd", command.following.xd[:, own], names)]
    return writing.columns_of(command.t, *blocks)
