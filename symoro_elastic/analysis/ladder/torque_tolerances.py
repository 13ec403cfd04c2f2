"""Errors of torques that use up the tolerance at the tool, by gains of the controlled machine.

    y(t) = int h(t - s) e(s) ds,    |y| <= G max |e|,    G = int |h| dt = total variation of the step response

e is an error of the torque that a motor is given, h the impulse response of the linear model along the motion, frozen
at some of its positions, over as long as the motion lasts. G is the peak gain: an error of any course that stays below
tolerance / G keeps the tolerance. A constant error may be larger, a sinusoid at the frequency of the largest gain less
than a constant one.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from symoro_elastic.analysis.control.drive_laws import TAU, law_of
from symoro_elastic.analysis.simulation.prediction.path import LinearPath
from symoro_elastic.foundation.array_types import Array, ComplexArray
from symoro_elastic.foundation.packages import for_vibrations

POSITIONS = 5
"""Of the motion, at which the linear model is frozen."""
STEPS, MOST_STEPS = 2000, 64_000
"""Of a step response over the duration of the motion: doubled until its total variation stays."""
RESOLVED = 0.01
"""Relative change of a total variation that is resolved."""
FREQUENCIES = 300
"""Of a frequency response, logarithmic from 1 / duration to half the samples of the path."""


@dataclass(frozen=True)
class TorqueTolerance:
    """Torque accuracy of a motor: the largest errors, N m or N, that keep all outputs within their tolerances.

    `constant` for one that does not change, `sinusoid` for the worst sinusoid, at `frequency` Hz, `any` for one of any
    course, each with no error of another motor. `share` is that of any course where all motors have one at a time.
    `output` is the output that limits it, `largest` the largest torque that is fed forward in the motion.
    """

    motor: str
    constant: float
    sinusoid: float
    frequency: float
    any: float
    share: float
    output: str
    largest: float = 0.0

    @property
    def relative(self) -> float:
        """The tolerance `share` as a fraction of the motor's largest torque."""
        return self.share / self.largest if self.largest else np.inf


def torque_tolerances(
    paths: Sequence[LinearPath], tolerance: Mapping[str, float], largest: Array | None = None
) -> tuple[TorqueTolerance, ...]:
    """Return the torque accuracy by motor that tolerances of outputs require, the least over all motions.

    `largest` (m,) are the largest torques. Outputs that no torque moves do not limit it.
    """
    motors = paths[0].reference.motors
    gains = [Gains(path, added_torques(path)) for path in paths]
    limits = np.array([tolerance[name] for name in paths[0].outputs.names])
    largest = np.zeros(len(motors)) if largest is None else largest
    return tuple(_tolerance(motor, k, gains, limits, float(largest[k])) for k, motor in enumerate(motors))


def acceleration_tolerances(path: LinearPath, tolerance: Mapping[str, float]) -> dict[str, float]:
    """Return the acceleration error, rad/s2 or m/s2, by freely moving joint, that keeps outputs within tolerances.

    For errors of any course, joint by joint; an acceleration error a acts as the forces M a.
    """
    n = len(path.joints)
    gains = Gains(path, np.stack([path.M[:, :, k] for k in path.moved], axis=-1) if path.moved else np.zeros((1, n, 0)))
    limits = np.array([tolerance[name] for name in path.outputs.names])
    with np.errstate(divide="ignore"):
        least = (limits / gains.peak).min(axis=1, initial=np.inf)
    return dict(zip(path.names(path.moved), least.tolist(), strict=True))


def added_torques(path: LinearPath) -> Array:
    """Return the forces (N, n, m) per unit torque of each motor, or per unit torque fed forward to each drive."""
    machine, motors = path.machine or path, list(path.reference.machine.motor_entries)
    added, n = np.zeros((len(path.joints), len(motors))), len(machine.joints)
    added[motors, range(len(motors))] = 1.0
    for k, law in enumerate(law_of(drive) for drive in path.reference.drives):
        states = slice(n, n + len(law.A))
        added[motors[k], k], added[states, k] = law.D[TAU], law.B[:, TAU]
        n = states.stop
    return np.broadcast_to(added, (len(path.t), *added.shape))


def _tolerance(motor: str, k: int, gains: Sequence[Gains], limits: Array, largest: float) -> TorqueTolerance:
    with np.errstate(divide="ignore"):
        constant = np.min([limits / gain.constant[k] for gain in gains], axis=0)
        peak = np.min([limits / gain.peak[k] for gain in gains], axis=0)
        rows = [(float(np.min(limits / gain.sinusoid[k])), gain.frequency[k]) for gain in gains]
    sinusoid, frequency = min(rows)
    least, share = float(peak.min()), float(peak.min()) / max(1, len(gains[0].peak))
    output = gains[0].path.outputs.names[int(np.argmin(peak))]
    return TorqueTolerance(motor, float(constant.min()), sinusoid, frequency, least, share, output, largest)


class Gains:
    """Gains (m, outputs) from added forces to outputs, each the largest over the positions of a path.

    `peak` is the total variation of the step response, `constant` its largest value, `sinusoid` the largest of the
    frequency response, at `frequency` (m,) Hz.
    """

    def __init__(self, path: LinearPath, added: Array) -> None:
        """Compute the gains; `added` are the forces (N, n, m) of unit inputs."""
        self.path = path
        places = np.unique(np.linspace(0, len(path.t) - 1, POSITIONS).astype(int))
        self._rows = [k for k in range(len(path.joints)) if k in path.moved]
        frozen = [_Frozen(path, k, self._rows, added[min(k, len(added) - 1)]) for k in places]
        steps = STEPS
        self.constant, self.peak = _largest(frozen, steps)
        while steps < MOST_STEPS:
            before, steps = self.peak, 2 * steps
            self.constant, self.peak = _largest(frozen, steps)
            if np.all(np.abs(self.peak - before) <= RESOLVED * self.peak):
                break
        frequencies = np.geomspace(1 / path.t[-1], 1 / (2 * path.h), FREQUENCIES)
        responses = np.max([np.abs(x.response(frequencies)) for x in frozen], axis=0)
        self.sinusoid = responses.max(axis=0, initial=0.0)
        relative = responses / np.where(self.sinusoid, self.sinusoid, 1.0)
        self.frequency = frequencies[relative.max(axis=-1, initial=0.0).argmax(axis=0)]


def _largest(frozen: Sequence[_Frozen], steps: int) -> tuple[Array, Array]:
    """Return the largest values and total variations of step responses (m, outputs) over all positions."""
    pairs = [x.step_response(steps) for x in frozen]
    constant, peak = (np.max(x, axis=0) for x in zip(*pairs, strict=True))
    return constant, peak


class _Frozen:
    """The linear model at one position: x' = A x + B e, y = C x + D e, x = [d; d'] of the joints that move."""

    def __init__(self, path: LinearPath, k: int, rows: Sequence[int], added: Array) -> None:
        n = len(rows)
        M, D, K = (x[k][np.ix_(rows, rows)] for x in (path.M, path.D, path.K))
        solved = np.linalg.solve(M, np.hstack([K, D, added[rows]]))
        self.A = np.block([[np.zeros((n, n)), np.eye(n)], [-solved[:, :n], -solved[:, n : 2 * n]]])
        self.B = np.vstack([np.zeros_like(added[rows]), solved[:, 2 * n :]])
        Cq, Cv, Ca = (x[k][:, rows] for x in (path.outputs.Cq, path.outputs.Cv, path.outputs.Ca))
        self.C = np.hstack([Cq, Cv]) + Ca @ self.A[n:]
        self.D = Ca @ self.B[n:]
        self.duration = float(path.t[-1])

    def step_response(self, steps: int) -> tuple[Array, Array]:
        """Return the largest value and the total variation of the responses (m, outputs) to unit steps.

        [x; e]' = [A B; 0 0] [x; e] is exact at even steps.
        """
        n, m = self.B.shape
        augmented = np.zeros((n + m, n + m))
        augmented[:n] = np.hstack([self.A, self.B])
        expm = for_vibrations("scipy.linalg").expm
        step: Array = expm(augmented * (self.duration / steps))[:n]
        x, y = np.zeros((n, m)), self.D
        largest, variation = np.abs(y), np.abs(y)
        for _ in range(steps):
            x = step[:, :n] @ x + step[:, n:]
            following = self.C @ x + self.D
            variation = variation + np.abs(following - y)
            largest = np.maximum(largest, np.abs(following))
            y = following
        return largest.T, variation.T

    def response(self, frequencies: Array) -> ComplexArray:
        """Return C (jw - A)^-1 B + D, (frequencies, m, outputs)."""
        jw = 2j * np.pi * frequencies[:, None, None] * np.eye(len(self.A))
        B = np.broadcast_to(self.B + 0j, (len(frequencies), *self.B.shape))
        response: ComplexArray = self.C @ np.linalg.solve(jw - self.A, B) + self.D
        return response.transpose(0, 2, 1)
