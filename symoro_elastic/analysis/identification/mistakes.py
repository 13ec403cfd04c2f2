"""Mistakes of a log, undone: which change of columns makes torques that no parameters explain those of this machine."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from itertools import combinations

import numpy as np

from symoro_elastic.analysis.identification.equations import Equations, Sampled
from symoro_elastic.analysis.identification.estimation import Estimate
from symoro_elastic.analysis.identification.filtering import smooth
from symoro_elastic.analysis.time_series.measurements import Measurements
from symoro_elastic.foundation.array_types import Array, BoolArray
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.packages import for_identification
from symoro_elastic.machine.machine import Machine

FAR, FITTING, BETTER = 0.015, 0.015, 4.0  # of the torque: residuals that ask for a reason, that need none; times less
SAMPLES, FEWEST, CLEARLY = 400, 50, 0.7
GAINS = (1e-3, 1e-2, 1.0, 1e2, 1e3)  # near which the gain of a motor is sought
DEGREE, MINUTE = np.pi / 180, 60.0
ALIKE, UNIT = 0.9, 5.0  # correlation of torques with those by the file, and factor between them that is named
SIGN = 4.0  # standard deviations below zero
ROUNDS, NEGATIVE, SMALL = 15, 0.01, 0.1  # fits that tell signs; of the largest torque: below zero, near it
ITS_OWN = 0.02  # share by which a torque is a motion
USUAL = 0.5  # of the samples at which a joint moves: one value there is that of a sensor, not of a torque
NEAR_TURN, MOST_JUMPS, LATE = 0.5, 0.9, 1.5  # rad about a turn; share of jumps that are turns; of a usual step of time
ZEROS, TURNS = tuple(np.linspace(-2.75, 3.14, 12)), 4 * np.pi  # rad; range of a position that joints hardly have
RATIOS = tuple(np.linspace(np.log(4), np.log(400), 60))  # logarithms of ratios of gears
ONE_SIGN = ("M", "IA", "FV", "FS")


@dataclass(frozen=True)
class _Log:
    """Samples of q, qd, qdd (S, n) and smooth torques of motors (S, m)."""

    q: Array
    qd: Array
    qdd: Array
    tau: Array

    def turned(self, joint: int | slice, factor: float) -> _Log:
        """Return the log with positions of a joint times a factor."""
        scale = np.ones(self.q.shape[1])
        scale[joint] = factor
        return replace(self, q=self.q * scale, qd=self.qd * scale, qdd=self.qdd * scale)

    def moved(self, joint: int, by: float) -> _Log:
        """Return the log with another zero of a joint."""
        return replace(self, q=self.q + by * (np.arange(self.q.shape[1]) == joint))

    def exchanged(self, order: Sequence[int]) -> _Log:
        """Return the log with positions in another order."""
        return replace(self, q=self.q[:, order], qd=self.qd[:, order], qdd=self.qdd[:, order])


@dataclass(frozen=True)
class _Trial:
    """Equations and a log of theirs."""

    equations: Equations
    log: _Log

    @cached_property
    def _rows(self) -> tuple[Array, Array]:
        """Columns of parameters and offsets (S, n, c), torques of each motor on the joints (S, n, m)."""
        Y, motion = self.equations.Y, (self.log.q, self.log.qd, self.log.qdd)
        ones = [np.tile(one, (len(self.log.q), 1)) for one in np.eye(self.log.tau.shape[1])]
        offsets = np.stack([Y.joint_torques(self.log.q, one) for one in ones], axis=2)
        return np.concatenate([Y.evaluate(*motion, self.equations.kept), offsets], axis=2), offsets

    def left(self, gains: Array | float = 1.0) -> float:
        """Return what least squares leaves of torques times gains, of their mean square, joints alike; from 0 to 1."""
        return self._solved(gains)[0]

    def absolute(self, motors: BoolArray) -> float:
        """Return what is left if torques of motors have lost their signs, which are first those of the file, then those
        of the fit; far from zero, where smooth absolute values are those of smooth torques."""
        Y, values = self.equations.Y, np.array([column.value for column in self.equations.Y.columns])
        size = np.abs(self.log.tau)
        far = (size > SMALL * size.max(axis=0))[:, motors].all(axis=1)
        log = _Log(*(each[far] for each in (self.log.q, self.log.qd, self.log.qdd, self.log.tau)))
        if np.isfinite(values).all():
            predicted = Y.torques(log.q, log.qd, log.qdd, range(len(values)), values) + Y.loads(log.q)
        else:
            predicted = log.qd
        left = 1.0
        for _ in range(ROUNDS if far.sum() > FEWEST else 0):
            own = np.einsum("snm,sn->sm", self._rows[1][far], predicted)
            tau = np.where(motors & (own < 0), -np.abs(log.tau), log.tau)
            before, (left, predicted) = left, _Trial(self.equations, replace(log, tau=tau))._solved(1.0)
            if left >= before:
                break
        return left

    def _solved(self, gains: Array | float) -> tuple[float, Array]:
        """Return what least squares leaves, and the torques that it predicts, (S, n)."""
        columns, of_motors = self._rows
        given = self.equations.given((self.log.q, self.log.qd, self.log.qdd))
        tau = np.einsum("snm,sm->sn", of_motors, self.log.tau * gains) - given
        size = np.sqrt((tau**2).mean(axis=0))
        scale = np.where(size > 0, size, np.inf)
        A, b = (columns / scale[:, None]).reshape(-1, columns.shape[2]), (tau / scale).ravel()
        x = np.linalg.lstsq(A, b, rcond=1e-8)[0]
        rest = b - A @ x
        return float(np.sqrt((rest**2).sum() / max((b**2).sum(), 1e-300))), columns @ x + given

    def gain(self, motor: int, near: float) -> float:
        """Return by what factor torques of one motor are as the others ask, rows weighted by one near it."""
        columns, of_motors = self._rows
        given = self.equations.given((self.log.q, self.log.qd, self.log.qdd))
        each = of_motors * self.log.tau[:, None, :]
        each[:, :, motor] *= near
        others = each.sum(axis=2) - each[:, :, motor] - given
        size = np.sqrt((each.sum(axis=2) ** 2).mean(axis=0))
        weight = 1 / np.where(size > 0, size, np.inf)
        A = np.concatenate([columns, -each[:, :, motor : motor + 1]], axis=2) * weight[:, None]
        return near * float(np.linalg.lstsq(A.reshape(-1, A.shape[2]), (others * weight).ravel(), rcond=1e-10)[0][-1])


def mistakes_of(equations: Equations, records: Sequence[Sampled], estimates: Sequence[Estimate]) -> list[str]:
    """Return lines on mistakes of columns that explain what this machine cannot do; none where torques fit."""
    longest = max(records, key=lambda x: len(x.motion.t))
    log = _log_of(longest)
    seen = [*_dead(equations, longest), *(_motions(equations, log) if log else ())]
    said = [*_unresolved(equations, longest), *(seen or _other_sign(estimates))]
    if log is None or seen:
        return said
    trial = _Trial(equations, log)
    before = trial.left()
    if before <= FAR or equations.machine.dependent:
        return said
    plain, sought = (min(tried(trial), default=(before, "")) for tried in (_tried, _sought))
    after, line = sought if sought[0] < CLEARLY * plain[0] else plain
    if after * max(BETTER, before / FITTING) >= before:
        return said
    return [f"{line}: residuals {100 * after:.3g} % of the torque then, {100 * before:.3g} % as it is"]


def _log_of(sampled: Sampled) -> _Log | None:
    """Return samples at which dry friction does not reverse, torques through the filter of positions."""
    motion, chosen = sampled.motion, sampled.chosen
    counted = np.flatnonzero(sampled.counted.all(axis=1))
    if chosen is None or len(counted) < FEWEST:
        return None
    some = counted[:: max(1, len(counted) // SAMPLES)]
    tau = smooth(motion.tau, chosen, replace(sampled.record, t=motion.t))
    return _Log(motion.q[some], motion.qd[some], motion.qdd[some], tau[some])


def _tried(trial: _Trial) -> Iterator[tuple[float, str]]:
    """Return what mistakes, undone, leave of torques, and their names."""
    equations, log = trial.equations, trial.log
    joints, motors = equations.machine.independent_joints, equations.machine.motor_joints
    every = {"positions are in degrees: call their columns q_... [deg]": log.turned(slice(None), DEGREE)}
    every["t is in minutes: call it t [min]"] = replace(log, qd=log.qd / MINUTE, qdd=log.qdd / MINUTE**2)
    for k, joint in enumerate(joints):
        every[f"q_{joint.name} has the opposite sign"] = log.turned(k, -1.0)
        every[f"q_{joint.name} is in degrees: call it q_{joint.name} [deg]"] = log.turned(k, DEGREE)
    for a, b in combinations(range(len(joints)), 2):
        order = [b if k == a else a if k == b else k for k in range(len(joints))]
        every[f"q_{joints[a].name} and q_{joints[b].name} are exchanged"] = log.exchanged(order)
    yield from ((_Trial(equations, other).left(), name) for name, other in every.items())
    for a, b in combinations(range(len(motors)), 2):
        order = [b if k == a else a if k == b else k for k in range(len(motors))]
        other = replace(log, tau=log.tau[:, order])
        yield _Trial(equations, other).left(), f"tau_{motors[a].name} and tau_{motors[b].name} are exchanged"
        if len(motors) == len(joints):
            both = other.exchanged(order)
            yield _Trial(equations, both).left(), f"columns of {motors[a].name} and {motors[b].name} are exchanged"
    for m, joint in enumerate(motors):
        name = f"beside the others tau_{joint.name} has another unit, sign or side of its gear"
        for factor in {trial.gain(m, near) for near in GAINS} - {0.0}:
            gains = np.where(np.arange(len(motors)) == m, factor, 1.0)
            yield trial.left(gains), f"{name}: give --gain {joint.name}={factor:.3g}"


def _sought(trial: _Trial) -> Iterator[tuple[float, str]]:
    """Return what mistakes with a number that is sought leave: signs that are lost, zeros, ratios of gears."""
    equations, log, named = trial.equations, trial.log, trial.equations.machine.motor_joints
    positive = log.tau.min(axis=0) > -NEGATIVE * log.tau.max(axis=0)
    if positive.any():
        which = ", ".join(f"tau_{joint.name}" for joint, one in zip(named, positive, strict=True) if one)
        yield trial.absolute(positive), f"{which}: absolute values, whose signs are lost: record them with signs"
    for k, joint in enumerate(equations.machine.independent_joints):
        if joint.sigma == 1:
            continue
        after, by = _least(partial(_at_zero, trial, k), ZEROS)
        yield after, f"the zero of q_{joint.name} is off: add {by:.3g} rad to it"
        if np.ptp(log.q[:, k]) < TURNS:
            continue
        for sign in (1.0, -1.0):
            yield from (_of_motor(trial, k, sign, both) for both in (False, True))


def _at_zero(trial: _Trial, k: int, by: float) -> float:
    """Return what is left with another zero of a joint."""
    return _Trial(trial.equations, trial.log.moved(k, by)).left()


def _of_motor(trial: _Trial, k: int, sign: float, both: bool) -> tuple[float, str]:
    """Return what is left if the position of a joint, perhaps its torque, too, is that of the motor before a gear."""
    machine, name = trial.equations.machine, trial.equations.machine.independent_joints[k].name
    own = np.array([entry == k for entry in machine.motor_entries])

    def left(log_ratio: float) -> float:
        n = sign * np.exp(log_ratio)
        turned = _Trial(trial.equations, trial.log.turned(k, 1 / n))
        return turned.left(np.where(own, n, 1.0) if both else 1.0)

    after, log_ratio = _least(left, RATIOS)
    which = f"q_{name} and tau_{name} are" if both else f"q_{name} is"
    return after, f"{which} of the motor, not the joint, with a ratio of about {sign * np.exp(log_ratio):.4g}"


def _least(left: Callable[[float], float], near: Sequence[float]) -> tuple[float, float]:
    """Return the least of a function and where it is, sought near the best of some places."""
    best = min(near, key=left)
    optimize, width = for_identification("scipy.optimize"), near[1] - near[0]
    found = optimize.minimize_scalar(
        left, bounds=(best - width, best + width), method="bounded", options={"maxiter": 25}
    )
    return float(found.fun), float(found.x)


def _motions(equations: Equations, log: _Log) -> list[str]:
    """Return lines on torques that are positions, velocities or accelerations of their joint."""
    found = []
    for m, k in enumerate(equations.machine.motor_entries):
        tau, name = log.tau[:, m], equations.machine.independent_joints[k].name
        for what, x in (("position", log.q), ("velocity", log.qd), ("acceleration", log.qdd)):
            A = np.column_stack([x[:, k], np.ones(len(x))])
            slope, offset = np.linalg.lstsq(A, tau, rcond=None)[0]
            unit = any(abs(slope / one - 1) < ITS_OWN for one in (1.0, -1.0, 1 / DEGREE))
            if unit and np.linalg.norm(tau - A @ [slope, offset]) < ITS_OWN * np.linalg.norm(tau - tau.mean()):
                found.append(f"tau_{name} is the {what} of {name}: give the column of its torque")
    return found


def refuse_wrapped(record: Measurements, machine: Machine) -> None:
    """Raise `InputError` for angles whose jumps from one sample to the next are turns."""
    steps = np.diff(record.t)
    usual = steps < LATE * np.median(steps)
    for k, joint in enumerate(machine.independent_joints):
        size = np.abs(np.diff(record.q[:, k]))[usual]
        count = int((np.abs(size - 2 * np.pi) < NEAR_TURN).sum())
        if joint.sigma == 0 and count > MOST_JUMPS * (size > np.pi).sum():
            what = f"jumps by a turn {count} times, as angles that wrap do: unwrap it (numpy.unwrap)"
            raise InputError(record.source, f"q_{joint.name}", what)


def _dead(equations: Equations, sampled: Sampled) -> list[str]:
    """Return lines on torques that do not change while their joint moves."""
    machine, tau = equations.machine, sampled.motion.tau
    entries = dict(zip(machine.motors, machine.motor_joints, strict=True))
    moved = [entries[j].name for j in machine.motors if j in machine.independent]
    still = {machine.independent_joints[k].name for k in sampled.motion.still}
    constant = [joint.name for k, joint in enumerate(machine.motor_joints) if np.ptp(tau[:, k]) == 0]
    what = "does not change while the joint moves: is its torque measured?"
    return [f"tau_{name} {what}" for name in constant if name in moved and name not in still]


def _unresolved(equations: Equations, sampled: Sampled) -> list[str]:
    """Return lines on torques that have one value at most samples at which their joint moves, as below the resolution
    or in the dead band of a sensor."""
    machine, lines = equations.machine, []
    entries = {joint.name: k for k, joint in enumerate(machine.independent_joints)}
    for joint, tau in zip(machine.motor_joints, sampled.motion.tau.T, strict=True):
        moving = sampled.counted[:, entries[joint.name]] if joint.name in entries else np.zeros(len(tau), dtype=bool)
        usual = float(np.quantile(tau[moving], 0.5, method="lower")) + 0.0 if moving.any() else 0.0
        share = float((tau[moving] == usual).mean()) if moving.any() and np.ptp(tau) > 0 else 0.0
        if share > USUAL and entries[joint.name] not in sampled.motion.still:
            what = f"is {usual:.3g} at {100 * share:.0f} % of the samples at which the joint moves"
            lines.append(f"tau_{joint.name} {what}: its sensor does not resolve it, and estimates of it say little")
    return lines


def _other_sign(estimates: Sequence[Estimate]) -> list[str]:
    """Return a line where all that is positive is negative, or all is another multiple of the file's values."""
    alone = [e for e in estimates if e.unknown.quantity in ONE_SIGN and e.unknown.formula == e.unknown.label]
    told = [e for e in alone if abs(e.value) > SIGN * e.std]
    if len(told) > 1 and all(e.value < 0 for e in told):
        return ["all torques have the opposite sign of those that move this machine: give --gain MOTOR=-1 for each"]
    pairs = [(e.value / e.std, e.unknown.nominal / e.std) for e in estimates if abs(e.value) > SIGN * e.std]
    both = np.array([x for x in pairs if np.isfinite(x).all()]).reshape(-1, 2).T
    found, file = both
    size = float(np.linalg.norm(found) * np.linalg.norm(file))
    factor = float(found @ file / (file @ file)) if size else 1.0
    if len(found) < 3 or found @ file < ALIKE * size or 1 / UNIT < factor < UNIT:
        return []
    return [
        f"all values are {factor:.3g} of those of the file: check units of torques, or their side of the gears (--gain)"
    ]
