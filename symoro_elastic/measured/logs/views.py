"""What an identification found, and an exciting trajectory, as text, as columns and as data for JSON."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from symoro_elastic.analysis.time_series import writing
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import some_of
from symoro_elastic.foundation.results import (
    Field,
    Part,
    arrays_of,
    columns_of,
    declare,
    json_of,
    parts_of,
    plain,
    table_of,
)
from symoro_elastic.machine.machine import Machine
from symoro_elastic.measured.fitting.estimates import Estimate
from symoro_elastic.measured.logs.excitation import Excitation
from symoro_elastic.measured.logs.identified import Identified
from symoro_elastic.measured.logs.result import Identification
from symoro_elastic.measured.logs.trajectory import ExcitingTrajectory, MotorRange
from symoro_elastic.measured.logs.validation import Fit, own_fit

FRICTION = "friction (FV viscous, FS dry) is estimated for every motor; to exclude it: --known"
SPRINGS_FOLLOW = 4.0
"""Springs follow a motion quasi-statically up to this part of their frequency: torques have twice that of a motion."""


def with_file(result: Identification) -> dict[str, float]:
    """Return standard deviations that include the prior of the file, by label; empty without a prior."""
    if result.possible is None or not math.isfinite(result.possible.trust):
        return {}
    return {e.unknown.label: x for e, x in zip(result.estimates, result.possible.with_file, strict=True)}


def _bodies(result: Identification) -> dict[str, dict[str, float]]:
    """Return parameters of the physically consistent bodies by name of the joint."""
    bodies: dict[str, dict[str, float]] = {}
    for (row, quantity), x in result.possible.values.items() if result.possible else ():
        bodies.setdefault(result.machine.joint(row).name, {})[quantity] = x
    return bodies


declare(
    Fit,
    Field("source"),
    Field("residual_rms", "residual"),
    Field("residual_percent", "percent"),
    Field("counted_percent", "counted"),
    Field("sample_percent"),
    Field("band_percent"),
)
declare(
    Identification,
    Field("estimates", lambda x: {e.unknown.label: e for e in x.estimates}, rows=Estimate),
    Field("neutral_positions", lambda x: {name: {"value": q0, "std": std} for name, (q0, std) in x.neutral.items()}),
    Field("residual_std", lambda x: dict(zip(x.estimation.joints, x.estimation.solution.sigma, strict=True))),
    Field("residual_percent", lambda x: own_fit(x).percent),
    Field("condition", "estimation.solution.condition"),
    Field("samples", lambda x: len(x.t)),
    Field("not_identifiable", "estimation.not_identifiable"),
    Field("notes"),
    Field("std_with_file", with_file),
    Field("bodies", _bodies),
)
declare(Identified, Field("estimates", "found.estimates", rows=Estimate))


@parts_of.register
def _(result: Identification) -> list[Part]:
    return _parts(result, [own_fit(result)])


@parts_of.register
def _(result: Identified) -> list[Part]:
    fits = [own_fit(result.found), *([result.validation] if result.validation else [])]
    return [*(parts_of(result.joint) if result.joint else ()), *_parts(result.found, fits)]


def _parts(result: Identification, fits: Sequence[Fit]) -> list[Part]:
    """Return the table of parameters, and the lists of neutral positions, residuals and notes."""
    nominal = {e.unknown.label: e.unknown.nominal for e in result.estimates if not math.isnan(e.unknown.nominal)}
    estimates = table(result, nominal or None, "file")
    residuals = [line for fit in fits for line in _residuals(fit, result.machine)]
    return [estimates, *neutral_positions(result), *residuals, *result.notes]


@json_of.register
def _(result: Identified) -> dict[str, Any]:
    validation = {"validation": plain(result.validation)} if result.validation else {}
    if result.joint:
        return {**json_of(result.joint), "log": {**json_of(result.found), **validation}}
    return {**json_of(result.found), **validation}


def table(result: Identification, true: Mapping[str, float] | None = None, head: str = "true") -> str:
    """Return the estimates as aligned text; `true` values by label where they are known, under the title `head`."""
    trusted = with_file(result)
    of_std = ["std from data", "std with file"] if trusted else ["std"]
    heads = ["parameter", *([head] if true is not None else []), "estimated", *of_std, "std %", "unit", "verdict"]
    rows = [heads]
    for e in result.estimates:
        true_value = [_number((true or {}).get(e.unknown.label, math.nan))] if true is not None else []
        percent = "-" if not math.isfinite(e.relative) else f"{100 * e.relative:.2g}"
        verdict = f"{e.verdict}: {e.reason}" if e.reason else str(e.verdict)
        stds = [_number(e.std), *([_number(trusted[e.unknown.label])] if trusted else [])]
        rows.append([e.unknown.formula, *true_value, _number(e.value), *stds, percent, e.unknown.unit, verdict])
    widths = [max(len(row[k]) for row in rows) for k in range(len(heads) - 1)]
    return "\n".join(
        "  ".join([row[0].ljust(widths[0]), *(x.rjust(w) for x, w in zip(row[1:-1], widths[1:], strict=True)), row[-1]])
        for row in rows
    )


def _number(x: float) -> str:
    return "-" if math.isnan(x) else f"{x:.5g}"


def neutral_positions(result: Identification) -> list[str]:
    """Return a line for each spring with an identified neutral position."""
    units = {joint.name: joint.unit for joint in result.machine.joints}
    return [
        f"neutral position of {name}: {q0:.5g} {units[name]}, std {std:.2g}"
        for name, (q0, std) in result.neutral.items()
    ]


def _residuals(fit: Fit, machine: Machine) -> list[str]:
    """Return a line for each joint that motors drive: its residual, and in per cent of the torque."""
    units = {joint.name: joint.force_unit for joint in machine.independent_joints}
    lines = {
        name: f"{fit.source}: {name}: {fit.percent[name]:.3g} % of the torque, {residual:.3g} {units[name]} rms"
        for name, residual in fit.residual.items()
    }
    for name, counted in fit.counted.items():
        every = f"sample by sample {fit.sample_percent[name]:.3g} %"
        every += f", in the band of the motion {fit.band_percent[name]:.3g} %"
        lines[name] += f", of averages over {counted:.3g} % of the samples (not at reversals or rest); {every}"
    return list(lines.values())


declare(
    MotorRange,
    Field("name", head="motor", json=False),
    Field("position", head="position", text=lambda x: _range(x.position)),
    Field("position_limits", head="of", text=lambda x: _range(x.position_limits)),
    Field("velocity", head="velocity"),
    Field("velocity_limit", head="of"),
    Field("acceleration", head="acceleration"),
    Field("acceleration_limit", head="of"),
    Field("centre"),
    Field("a"),
    Field("b"),
    Field("torque"),
    Field("torque_limits"),
)
declare(
    ExcitingTrajectory,
    Field("condition_before", "best.before"),
    Field("condition", "best.condition"),
    Field("parameters", "best.columns"),
    Field("frequency", "best.motion.frequency"),
    Field("duration", lambda x: x.sampled.t[-1]),
    Field("start", "sampled.start"),
    Field("samples", lambda x: len(x.sampled.t)),
    Field("motors", lambda x: {motor.name: motor for motor in x.motors}),
)


def _range(limits: tuple[float, float]) -> str:
    return f"{limits[0]:.4g} : {limits[1]:.4g}"


@parts_of.register
def _(found: ExcitingTrajectory) -> list[Part]:
    """Return the table of motor ranges and limits, and sentences about the excited parameters."""
    best, sampled = found.best, found.sampled
    friction = [label for label in best.columns if label.startswith(("FV", "FS"))]
    return [
        table_of(MotorRange, found.motors, f"{found.machine.name}: reached of the limits"),
        *_torques(found),
        f"condition number of the regressor: {best.before:.4g} at the first random motion, {best.condition:.4g} now",
        f"for {len(best.columns)} parameters: {', '.join(best.columns)}",
        *([f"{FRICTION} {friction[0]} ..."] if friction else []),
        *_near_springs(best),
        f"{sampled.t[-1]:g} s, {len(sampled.t)} samples: start and stop {sampled.start:g} s each, "
        "at rest where it ends",
    ]


def _torques(trajectory: ExcitingTrajectory) -> list[str]:
    """Return a line on the torques of motors whose torque is limited."""
    units = {joint.name: joint.force_unit for joint in trajectory.machine.motor_joints}
    limited = [(x, x.torque, x.torque_limits) for x in trajectory.motors if x.torque_limits]
    if limited and trajectory.best.unknown:
        shown = some_of(trajectory.best.unknown, 3)
        return [f"limits of torques are not kept, for parameters have no value: {shown}"]
    reached = [f"{x.name} {_range(tau)} of {_range(of)} {units[x.name]}" for x, tau, of in limited if tau and of]
    loads = ", ".join(f"{name} {_range(ends)}" for name, ends in trajectory.payloads.items())
    of_loads = f", and with payloads {loads}" if loads else ""
    what = f"torques from rest to rest, by the parameters of the machine{of_loads}"
    return [f"{what}: {', '.join(reached)}"] if reached else []


def _near_springs(best: Excitation) -> list[str]:
    """Return a warning where the motion is too fast for springs to follow quasi-statically."""
    fastest = best.motion.frequency * best.motion.a.shape[1]
    if SPRINGS_FOLLOW * fastest <= best.natural:
        return []
    what = f"harmonics up to {fastest:.4g} Hz are near the first natural frequency of the springs, {best.natural:.4g}"
    way_out = "give a lower --fundamental, or fewer --harmonics"
    return [f"{what} Hz: torques and frames may leave their limits there; {way_out}"]


@arrays_of.register
@columns_of.register
def _(found: ExcitingTrajectory) -> dict[str, Array]:
    """Return t, q_<motor>, qd_<motor>, qdd_<motor>, one row per sample."""
    sampled, names = found.sampled, [joint.name for joint in found.machine.motor_joints]
    blocks = (("q", sampled.q, names), ("qd", sampled.qd, names), ("qdd", sampled.qdd, names))
    return writing.columns_of(sampled.t, *blocks)
