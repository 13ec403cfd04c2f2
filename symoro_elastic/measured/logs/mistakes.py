"""Usual mistakes of a log: rows that change its columns, by which of them a machine of any parameters explains torques.

Torques are compared in relative residuals of least squares without noise, which is what differs from a sample to the
next. What else a model leaves of real torques is systematic: it is worth few independent values, whatever the number
of samples.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from itertools import combinations

import numpy as np

from symoro_elastic.foundation.array_types import Array, BoolArray
from symoro_elastic.foundation.packages import for_identification
from symoro_elastic.measured.fitting.corrections import Correction, Refit, explanations, names_of
from symoro_elastic.measured.fitting.estimates import SIGNIFICANT, Estimate
from symoro_elastic.measured.logs.equations import Equations, Sampled
from symoro_elastic.measured.logs.filtering import smooth

ACCURACY = 0.015  # of the torque: systematic residuals of a machine that its model explains
EXACT = 1e-3  # of the torque: systematic residuals below which models of real machines do not differ
INDEPENDENT = 4.0
"""Values that systematic errors of torques are worth: residuals 3.5 times smaller are very strong evidence."""
SAMPLES = 400  # samples of a log that are compared
FEWEST = 50  # samples below which nothing is compared
GAINS = (1e-3, 1e-2, 1.0, 1e2, 1e3)  # gains of a motor near which the best one is determined
MINUTE = 60.0  # s
ZEROS = tuple(np.linspace(-2.75, 3.14, 12).tolist())  # zeros of a joint, rad, near which the best one is determined
RATIOS = tuple(np.linspace(math.log(4), math.log(400), 60).tolist())
"""Logarithms of ratios of gears near which the best one is determined."""
TURNS = 4 * math.pi  # rad: a larger range of positions may be that of a motor before its gear
NEGATIVE = 0.01  # of the largest torque: negative torques below it are noise
SMALL = 0.1  # of the largest torque: the signs of smaller ones are not determined by fits
MOST_SIGNS = 15  # fits that determine signs
SAME_MOTION = 0.02  # relative difference of a torque from a position, velocity or acceleration that it is
USUAL = 0.5  # of the samples at which a joint moves: a torque with one value there is not resolved by its sensor
CORRELATED = 0.9  # correlation of torques with those by the file, above which their ratio is a factor
UNIT = 5.0  # factor between torques and those by the file that is a unit or a gear, not a wrong value
ONE_SIGN = ("M", "IA", "FV", "FS")


@dataclass(frozen=True, eq=False)
class _Log:
    """Samples of q, qd, qdd (S, n), smooth torques of motors (S, m), and their bandwidth over half of the sampling."""

    q: Array
    qd: Array
    qdd: Array
    tau: Array
    bandwidth: float = 1.0

    def with_positions(self, of: Callable[[Array], Array]) -> _Log:
        """Return the log with a linear function of positions (S, n)."""
        return replace(self, q=of(self.q), qd=of(self.qd), qdd=of(self.qdd))


Row = Correction[_Log]


def _at(k: int | slice, factor: float, columns: int) -> Array:
    """Return the factors of columns: `factor` at k, 1 elsewhere."""
    factors = np.ones(columns)
    factors[k] = factor
    return factors


@dataclass(frozen=True)
class _Columns:
    """Columns of a log as rows of tau = Y X of a machine, with and without usual mistakes."""

    equations: Equations
    log: _Log

    @cached_property
    def _joints(self) -> list[str]:
        return [joint.name for joint in self.equations.machine.independent_joints]

    @cached_property
    def _motors(self) -> list[str]:
        return [joint.name for joint in self.equations.machine.motor_joints]

    def _sides(self, log: _Log) -> tuple[Array, Array, Array]:
        """Return columns of parameters and offsets (S, n, c), torques of motors on joints (S, n, m), known torques."""
        Y, motion = self.equations.Y, (log.q, log.qd, log.qdd)
        units = [np.tile(unit, (len(log.q), 1)) for unit in np.eye(log.tau.shape[1])]
        of_motors = np.stack([Y.joint_torques(log.q, unit) for unit in units], axis=2)
        columns = np.concatenate([Y.evaluate(*motion, self.equations.estimated_columns), of_motors], axis=2)
        return columns, of_motors, self.equations.fixed_torques(motion)

    @cached_property
    def _own_sides(self) -> tuple[Array, Array, Array]:
        return self._sides(self.log)

    @cached_property
    def own_parts(self) -> tuple[float, float, float]:
        """Mean squares of residual, noise and sampling error of the log without correction, as `parts`."""
        return self.parts(self.log)

    def residual(self, log: _Log) -> float:
        """Return the relative root mean square residual of least squares, joints weighted equally; from 0 to 1."""
        return self._solution(log)[0]

    def parts(self, log: _Log) -> tuple[float, float, float]:
        """Return the mean squares of the relative residual, of its noise part, and of its sampling error.

        White noise through the filter differs from the next sample by 2 (1 - correlation) of its mean square, and has
        as many independent values as its bandwidth allows, less those that parameters explain.
        """
        residual, errors, _ = self._solution(log)
        power = float((errors**2).mean()) or 1.0
        noise = float((np.diff(errors, axis=0) ** 2).mean()) / (2 * (1 - np.sinc(log.bandwidth))) / power
        square, independent = residual**2, log.bandwidth * errors.size - self._own_sides[0].shape[2]
        return square, square * min(noise, 1.0), square * math.sqrt(2 / max(independent, 2.0))

    def _solution(self, log: _Log) -> tuple[float, Array, Array]:
        """Return the residual of least squares, those of samples (S, n), and the torques on joints (S, n) predicted."""
        is_same_motion = log.q is self.log.q and log.qd is self.log.qd
        columns, of_motors, fixed = self._own_sides if is_same_motion else self._sides(log)
        tau = np.einsum("snm,sm->sn", of_motors, log.tau) - fixed
        size = np.sqrt((tau**2).mean(axis=0))
        scale = np.where(size > 0, size, np.inf)
        A, b = (columns / scale[:, None]).reshape(-1, columns.shape[2]), (tau / scale).ravel()
        X = np.linalg.lstsq(A, b, rcond=1e-8)[0]
        errors = b - A @ X
        relative = float(np.linalg.norm(errors)) / max(float(np.linalg.norm(b)), 1e-150)
        return relative, errors.reshape(tau.shape), columns @ X + fixed

    def _gain(self, motor: int, near: float) -> float:
        """Return the gain that fits a motor's torque best to those of the others; rows are weighted for gain `near`."""
        columns, of_motors, fixed = self._own_sides
        torques = of_motors * self.log.tau[:, None, :] * _at(motor, near, len(self._motors))
        other_torques = torques.sum(axis=2) - torques[:, :, motor] - fixed
        size = np.sqrt((torques.sum(axis=2) ** 2).mean(axis=0))
        weight = 1 / np.where(size > 0, size, np.inf)
        A = np.concatenate([columns, -torques[:, :, motor : motor + 1]], axis=2) * weight[:, None]
        return near * float(
            np.linalg.lstsq(A.reshape(-1, A.shape[2]), (other_torques * weight).ravel(), rcond=1e-10)[0][-1]
        )

    def rows(self) -> Iterator[Row]:
        """Yield corrected logs, one for each usual mistake."""
        log, n = self.log, len(self._joints)
        yield Correction(
            "positions are in degrees: call their columns q_... [deg]", self._with_scaled(slice(None), math.radians(1))
        )
        in_seconds = replace(log, qd=log.qd / MINUTE, qdd=log.qdd / MINUTE**2)
        yield Correction("t is in minutes: call it t [min]", in_seconds)
        for k, joint in enumerate(self._joints):
            yield Correction(f"q_{joint} has the opposite sign", self._with_scaled(k, -1.0))
            yield Correction(f"q_{joint} is in degrees: call it q_{joint} [deg]", self._with_scaled(k, math.radians(1)))
        for a, b in combinations(range(n), 2):
            exchanged = log.with_positions(partial(_with_exchanged, a=a, b=b))
            yield Correction(f"q_{self._joints[a]} and q_{self._joints[b]} are exchanged", exchanged)
        yield from self._rows_of_torques()
        yield from self._zeros()
        for k in np.flatnonzero(np.ptp(log.q, axis=0) >= TURNS).tolist():
            if self.equations.machine.independent_joints[k].sigma != 1:
                for sign in (1.0, -1.0):
                    for both in (False, True):
                        yield from (self._before_gear(k, sign, both, ratio) for ratio in RATIOS)

    def _rows_of_torques(self) -> Iterator[Row]:
        log, motors = self.log, self._motors
        for a, b in combinations(range(len(motors)), 2):
            exchanged = replace(log, tau=_with_exchanged(log.tau, a, b))
            yield Correction(f"tau_{motors[a]} and tau_{motors[b]} are exchanged", exchanged)
            if len(motors) == len(self._joints):
                both = exchanged.with_positions(partial(_with_exchanged, a=a, b=b))
                yield Correction(f"columns of {motors[a]} and {motors[b]} are exchanged", both)
        for m, name in enumerate(motors):
            for gain in {self._gain(m, near) for near in GAINS} - {0.0}:
                what = f"tau_{name} differs from the others by a unit, sign or gear: give --gain {name}={gain:.3g}"
                yield Correction(what, replace(log, tau=log.tau * _at(m, gain, len(motors))))
        if (positive := log.tau.min(axis=0) > -NEGATIVE * log.tau.max(axis=0)).any():
            names = ", ".join(f"tau_{name}" for name, is_positive in zip(motors, positive, strict=True) if is_positive)
            what = f"{names}: absolute values, whose signs are lost: record them with signs"
            yield from (Correction(what, log, family="signs") for log in self._with_signs(positive))

    def _with_signs(self, positive: BoolArray) -> Iterator[_Log]:
        """Yield the log whose `positive` motors have the signs of torques by the file, then by fits, as residuals fall.

        Its samples are far from zero, where smooth absolute values are those of smooth torques.
        """
        size = np.abs(self.log.tau)
        far = (size > SMALL * size.max(axis=0))[:, positive].all(axis=1)
        if far.sum() < FEWEST:
            return
        log = _Log(*(x[far] for x in (self.log.q, self.log.qd, self.log.qdd, size)))
        Y, values = self.equations.Y, np.array([column.value for column in self.equations.Y.columns])
        joints, best = log.qd, math.inf
        if np.isfinite(values).all():
            joints = Y.torques(log.q, log.qd, log.qdd, range(len(values)), values) + Y.loads(log.q)
        for _ in range(MOST_SIGNS):
            predicted = np.einsum("snm,sn->sm", self._own_sides[1][far], joints)
            signed = replace(log, tau=np.where(positive, np.copysign(log.tau, predicted), self.log.tau[far]))
            residual, _, joints = self._solution(signed)
            if residual >= best:
                return
            best = residual
            yield signed

    def _with_scaled(self, k: int | slice, factor: float) -> _Log:
        return self.log.with_positions(lambda x: x * _at(k, factor, len(self._joints)))

    def _zeros(self) -> Iterator[Row]:
        for k, joint in enumerate(self.equations.machine.independent_joints):
            if joint.sigma != 1:
                yield from (self._zero(k, zero) for zero in ZEROS)

    def _zero(self, k: int, zero: float) -> Row:
        """Return the log with a zero of a joint's position corrected by `zero`."""
        joint = self._joints[k]
        log = replace(self.log, q=self.log.q + zero * (np.arange(len(self._joints)) == k))
        what = f"the zero of q_{joint} is off: add {zero:.3g} rad to it"
        return Correction(what, log, family=f"zero {joint}", number=zero, vary=partial(self._zero, k))

    def _before_gear(self, k: int, sign: float, both: bool, logarithm: float) -> Row:
        """Return the log with a motor's position, and optionally its torque, converted to the load side of a gear."""
        machine, name, ratio = self.equations.machine, self._joints[k], sign * math.exp(logarithm)
        log = self._with_scaled(k, 1 / ratio)
        if both:
            own = np.array([entry == k for entry in machine.motor_entries])
            log = replace(log, tau=log.tau * np.where(own, ratio, 1.0))
        columns = f"q_{name} and tau_{name} are" if both else f"q_{name} is"
        what = f"{columns} of the motor, not the joint, with a ratio of about {ratio:.4g}"
        vary = partial(self._before_gear, k, sign, both)
        return Correction(what, log, family=f"{columns} {sign}", number=logarithm, vary=vary)

    def refit(self, noise: float, row: Row) -> Refit[_Log] | None:
        """Return a correction with its zero or ratio, if any, refitted; None if the residual exceeds torques' accuracy.

        `noise` is the mean square of that of the log, at most what any correction leaves.
        """
        if row.vary is not None:
            row = _best(row, self.residual)
        both = [self.parts(row.data), self.own_parts]
        noise = min(noise, both[0][1])
        corrected, as_it_is = (max(square - noise, sampling, EXACT**2) for square, _, sampling in both)
        if corrected > ACCURACY**2:
            return None
        number = 0.5 * math.log(INDEPENDENT) if row.vary else 0.0
        costs = [0.5 * INDEPENDENT * math.log(x) for x in (corrected, as_it_is)]
        return Refit(row, costs[0] + number, costs[1])


def _with_exchanged(x: Array, a: int, b: int) -> Array:
    """Return columns of x (S, k) with a and b exchanged."""
    order = np.arange(x.shape[1])
    order[[a, b]] = b, a
    return x[:, order]


def _best(row: Row, residual: Callable[[_Log], float]) -> Row:
    """Return the row of least residual within a step of the numbers of its family."""
    vary, step = row.vary or (lambda _: row), (ZEROS if row.family.startswith("zero") else RATIOS)
    width = step[1] - step[0]
    minimum = for_identification("scipy.optimize").minimize_scalar(
        lambda number: residual(vary(number).data), bounds=(row.number - width, row.number + width), method="bounded"
    )
    return vary(float(minimum.x))


def mistakes_of(equations: Equations, records: Sequence[Sampled], estimates: Iterable[Estimate]) -> list[str]:
    """Return notes on mistakes in columns that explain large residuals; none where the torques fit."""
    longest = max(records, key=lambda sampled: len(sampled.motion.t))
    log = _log_of(longest)
    motions = [*_constant_torques(equations, longest), *(_motions(equations, log) if log else ())]
    notes = [*_unresolved_torques(equations, longest), *(motions or _factors(list(estimates)))]
    if log is None or motions or equations.machine.dependent:
        return notes
    columns = _Columns(equations, log)
    square, noise, _ = columns.own_parts
    residual = math.sqrt(square)
    if residual <= ACCURACY:
        return notes
    parts = {row: columns.parts(row.data) for row in columns.rows()}
    noise = min([noise, *(own for corrected, own, _ in parts.values() if corrected < square)])
    rows = explanations(parts, lambda row: math.sqrt(parts[row][0]), partial(columns.refit, noise), residual)
    if not rows:
        return notes
    corrected = 100 * columns.residual(rows[0].data)
    return [f"{names_of(rows)}: residuals {corrected:.3g} % of the torque then, {100 * residual:.3g} % as it is"]


def _log_of(sampled: Sampled) -> _Log | None:
    """Return samples without reversals of dry friction, torques through the filter of positions; None if too few."""
    motion, chosen = sampled.motion, sampled.chosen
    counted = np.flatnonzero(sampled.counted.all(axis=1))
    if chosen is None or len(counted) < FEWEST:
        return None
    every = max(1, len(counted) // SAMPLES)
    some = counted[::every]
    tau = smooth(motion.tau, chosen, replace(sampled.record, t=motion.t))
    bandwidth = min(2 * chosen.cutoff * every / chosen.sampling, 1.0)
    return _Log(motion.q[some], motion.qd[some], motion.qdd[some], tau[some], bandwidth)


def _motions(equations: Equations, log: _Log) -> list[str]:
    """Return lines on torques that are positions, velocities or accelerations of their joint."""
    lines = []
    for m, k in enumerate(equations.machine.motor_entries):
        tau, name = log.tau[:, m], equations.machine.independent_joints[k].name
        for what, x in (("position", log.q), ("velocity", log.qd), ("acceleration", log.qdd)):
            A = np.column_stack([x[:, k], np.ones(len(x))])
            slope, offset = np.linalg.lstsq(A, tau, rcond=None)[0]
            in_a_unit = any(abs(slope / unit - 1) < SAME_MOTION for unit in (1.0, -1.0, 1 / math.radians(1)))
            error = np.linalg.norm(tau - A @ [slope, offset])
            if in_a_unit and error < SAME_MOTION * np.linalg.norm(tau - tau.mean()):
                lines.append(f"tau_{name} is the {what} of {name}: give the column of its torque")
    return lines


def _constant_torques(equations: Equations, sampled: Sampled) -> list[str]:
    """Return lines on torques that do not change while their joint moves."""
    machine, tau = equations.machine, sampled.motion.tau
    moving = {k for k in range(len(machine.independent)) if k not in sampled.motion.still}
    what = "does not change while the joint moves: is its torque measured?"
    driven = zip(machine.motors, machine.motor_joints, tau.T, strict=True)
    is_moving = {j: j in machine.independent and machine.independent.index(j) in moving for j in machine.motors}
    return [f"tau_{joint.name} {what}" for j, joint, torque in driven if np.ptp(torque) == 0 and is_moving[j]]


def _unresolved_torques(equations: Equations, sampled: Sampled) -> list[str]:
    """Return lines on torques that have one value at most samples at which their joint moves, as below the resolution
    or in the dead band of a sensor."""
    machine, lines = equations.machine, []
    entries = {joint.name: k for k, joint in enumerate(machine.independent_joints)}
    for joint, tau in zip(machine.motor_joints, sampled.motion.tau.T, strict=True):
        k = entries.get(joint.name)
        if k is None or k in sampled.motion.still or not np.ptp(tau) or not sampled.counted[:, k].any():
            continue
        moving = tau[sampled.counted[:, k]]
        usual = float(np.quantile(moving, 0.5, method="lower")) + 0.0
        if (fraction := float((moving == usual).mean())) > USUAL:
            what = f"is {usual:.3g} at {100 * fraction:.0f} % of the samples at which the joint moves"
            lines.append(f"tau_{joint.name} {what}: its sensor does not resolve it, and estimates of it are unreliable")
    return lines


def _factors(estimates: Sequence[Estimate]) -> list[str]:
    """Return a line where positive parameters are all negative, or all values are a multiple of the initial ones."""
    significant = [e for e in estimates if abs(e.value) > SIGNIFICANT * e.std]
    positive = [e for e in significant if e.unknown.quantity in ONE_SIGN and e.unknown.formula == e.unknown.label]
    if len(positive) > 1 and all(e.value < 0 for e in positive):
        return ["all torques have the opposite sign of those that move this machine: give --gain MOTOR=-1 for each"]
    values = np.array([(e.value / e.std, e.unknown.nominal / e.std) for e in significant]).reshape(-1, 2)
    estimated, nominal = values[np.isfinite(values).all(axis=1)].T
    size = float(np.linalg.norm(estimated) * np.linalg.norm(nominal))
    factor = float(estimated @ nominal / (nominal @ nominal)) if size else 1.0
    if len(estimated) < 3 or estimated @ nominal < CORRELATED * size or 1 / UNIT < factor < UNIT:
        return []
    what = f"all values are {factor:.3g} of those of the file"
    return [f"{what}: check units of torques, or their side of the gears (--gain)"]
