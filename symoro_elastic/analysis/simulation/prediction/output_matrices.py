"""Changes of outputs by small motions: dy = Cq d + Cv d' + Ca d'', at every time of a motion.

Outputs are signals (`numerics/motion/signals.py`), and torques of motors: `motor_x.tau`. Where static springs deflect
by the reactions in the motion, placements x of frames change by

    dx = J_R dq_R + J_E dq_E,    dq_E = (dq_E/dq_R) dq_R + (dq_E/dv_R) dv_R + (dq_E/da_R) da_R

R are the joints that move, E those of the static springs; q_E(q_R, v_R, a_R) is the model `static_deflections`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from symoro_elastic.analysis.simulation.prediction.small_motion import SmallMotion
from symoro_elastic.foundation.array_types import Array, BoolArray
from symoro_elastic.machine.frames import FrameNames
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.static_springs import with_free_springs
from symoro_elastic.numerics.motion.signals import MOTOR_TORQUE, FrameSignal, JointSignal, Signal, entry_of, inputs
from symoro_elastic.numerics.motion.signals import outputs as output_signals
from symoro_elastic.numerics.verification.implementations import numpy_model

MOTION_MODELS = ("jacobian", "velocities", "accelerations")
"""Models by the order of the output that their results are rows of."""
Three = tuple[Array, Array, Array]
Deflections = Callable[[Array, Array, Array], Array]
"""q_E (N, s) of states q, v, a (N, n)."""
NEIGHBOURS = range(4)
STEP = 1e-6
"""Of central differences, rad, m, rad/s or m/s: of quantities that change over 1, they are right to 1e-10."""


@dataclass(frozen=True)
class Outputs:
    """Rows Cq, Cv, Ca (N, outputs, n) of outputs by name.

    `follows` (outputs,) says which ones take part in the deflections of static springs: torques do not.
    """

    names: tuple[str, ...]
    Cq: Array
    Cv: Array
    Ca: Array
    follows: BoolArray

    def at(self, t: Array, wanted: Array) -> Outputs:
        """Return the rows at other times, cubic between the times t (N,)."""
        Cq, Cv, Ca = (between(t, C, wanted) for C in (self.Cq, self.Cv, self.Ca))
        return replace(self, Cq=Cq, Cv=Cv, Ca=Ca)

    @property
    def every_second(self) -> Outputs:
        """The output rows at every second time."""
        return replace(self, Cq=self.Cq[::2], Cv=self.Cv[::2], Ca=self.Ca[::2])

    def of_following_springs(self, springs: Sequence[int], by: Three) -> Outputs:
        """Return rows that eliminate the springs' variables (s,): d_E = by_q d + by_v d' + by_a d''.

        `by` are (N, s, n), zero for the springs themselves.
        """
        along = np.where(self.follows[:, None], self.Cq[..., list(springs)], 0.0)
        Cq, Cv, Ca = (C + along @ x for C, x in zip((self.Cq, self.Cv, self.Ca), by, strict=True))
        return replace(self, Cq=Cq, Cv=Cv, Ca=Ca)

    def of(self, motion: SmallMotion) -> Array:
        """Return the output changes dy (N, sets, outputs) of small motions (N, sets, n)."""
        terms = zip((self.Cq, self.Cv, self.Ca), (motion.d, motion.dd, motion.ddd), strict=True)
        return np.asarray(sum(np.einsum("toi,tsi->tso", C, d) for C, d in terms))


def is_torque(name: str) -> bool:
    """Whether an output is the torque of a motor."""
    return name.rpartition(".")[2] == MOTOR_TORQUE


def outputs_along(
    machine: Machine,
    servo: tuple[Array, Array] | None,
    names: Sequence[str],
    states: Three,
    torques: Three,
    deflections: Deflections | None = None,
) -> Outputs:
    """Return the rows of outputs along states q, v, a (N, n); raises `InputError` for signals that do not exist.

    `torques` are the rows of K, D, M of the motors (N, m, n), their torques where no servo gives them; `deflections`
    are those of the static springs of the machine, where it has some.
    """
    signals = [inputs(machine, [name])[0] if is_torque(name) else output_signals(machine, [name])[0] for name in names]
    Cq, Cv, Ca = np.zeros((3, len(states[0]), len(names), states[0].shape[1]))
    _add_frames(machine, signals, states, (Cq, Cv, Ca), deflections)
    for row, (name, signal) in enumerate(zip(names, signals, strict=True)):
        if not isinstance(signal, JointSignal):
            continue
        k = entry_of(machine, signal)
        if not is_torque(name):
            (Cq, Cv, Ca)[signal.order][:, row, k] = 1.0
            continue
        motor = machine.motor_entries.index(k)
        if servo is None:
            Cq[:, row], Cv[:, row], Ca[:, row] = (x[:, motor] for x in torques)
        else:
            Cq[:, row, k], Cv[:, row, k] = -servo[0][motor], -servo[1][motor]
    return Outputs(tuple(names), Cq, Cv, Ca, np.array([not is_torque(name) for name in names]))


def _add_frames(
    machine: Machine, signals: Sequence[Signal], states: Three, rows: Three, deflections: Deflections | None
) -> None:
    """Fill the rows of frames: the Jacobian, and how velocities and accelerations change with the state."""
    by_row = {row: signal for row, signal in enumerate(signals) if isinstance(signal, FrameSignal)}
    if not by_row:
        return
    names = FrameNames(machine)
    texts = {row: names.in_base(signal.number, signal.at) for row, signal in by_row.items()}
    frames = tuple(dict.fromkeys(texts.values()))
    highest = max(signal.order for signal in by_row.values())
    models = MOTION_MODELS[: highest + 1]
    model = numpy_model(machine, models, dict.fromkeys(models, frames))
    q, v, a = states
    J = model.jacobian(q)
    by_order: list[tuple[Array, ...]] = [placement_rows(machine, frames, states, deflections) if deflections else (J,)]
    if highest > 0:
        by_order.append((slopes(lambda q: model.velocities(q, v), q), J))
    if highest > 1:
        by_q = slopes(lambda q: model.accelerations(q, v, a), q)
        by_order.append((by_q, slopes(lambda v: model.accelerations(q, v, a), v), J))
    for row, signal in by_row.items():
        for C, matrix in zip(rows, by_order[signal.order], strict=False):
            C[:, row] = matrix[:, frames.index(texts[row]), signal.component]


def placement_rows(machine: Machine, frames: Sequence[str], states: Three, deflections: Deflections) -> Three:
    """Return the derivatives (N, frames, 6, n) of placements by q, v, a of the joints that move; SI units, frame 0."""
    free = replace(with_free_springs(machine), static={})
    static = {joint.name for joint in machine.static_springs.values()}
    names = [joint.name for joint in free.independent_joints]
    E = [k for k, name in enumerate(names) if name in static]
    R = [k for k, name in enumerate(names) if name not in static]
    q, v, a = states
    variables = np.zeros((len(q), len(names)))
    variables[:, R], variables[:, E] = q, deflections(q, v, a)
    J = numpy_model(free, ("jacobian",), {"jacobian": tuple(frames)}).jacobian(variables)
    of_springs = (
        slopes(lambda q: deflections(q, v, a), q),
        slopes(lambda v: deflections(q, v, a), v),
        slopes(lambda a: deflections(q, v, a), a),
    )
    by_q, by_v, by_a = (np.einsum("tfce,ten->tfcn", J[..., E], x) for x in of_springs)
    return J[..., R] + by_q, by_v, by_a


def between(t: Array, x: Array, wanted: Array) -> Array:
    """Return x (N, ...), known at equidistant times t (N,), at other times: cubic through the four nearest."""
    place = (wanted - t[0]) / (t[1] - t[0])
    first = np.clip(place.astype(int) - 1, 0, len(t) - len(NEIGHBOURS))
    s = place - first
    total = np.zeros((len(wanted), *x.shape[1:]))
    for k in NEIGHBOURS:
        neighbours = [m for m in NEIGHBOURS if m != k]
        weight = np.prod([(s - m) / (k - m) for m in neighbours], axis=0)
        total += weight.reshape(-1, *(1,) * (x.ndim - 1)) * x[first + k]
    return total


def interpolate(h: float, x: tuple[Array, Array, Array], wanted: Array) -> tuple[Array, Array]:
    """Return x and x' (M, ...) at times (M,) from x, x', x'' (N, ...) at times h apart from 0.

    Between samples they are polynomials of degree 5 with these values at both ends.
    """
    place = np.clip(wanted / h, 0.0, len(x[0]) - 1)
    first = np.minimum(place.astype(int), len(x[0]) - 2)
    s = (place - first).reshape(-1, *(1,) * (x[0].ndim - 1))
    (a, b), (u, v), (f, g) = ((y[first] * h**k, y[first + 1] * h**k) for k, y in enumerate(x))
    rise, turn, bend = b - a - u - f / 2, v - u - f, (g - f) / 2  # what the last three coefficients have to reach
    c3, c4, c5 = 10 * rise - 4 * turn + bend, -15 * rise + 7 * turn - 2 * bend, 6 * rise - 3 * turn + bend
    value = a + s * (u + s * (f / 2 + s * (c3 + s * (c4 + s * c5))))
    rate = u + s * (f + s * (3 * c3 + s * (4 * c4 + s * 5 * c5)))
    return value, rate / h


def slopes(function: Callable[[Array], Array], x: Array) -> Array:
    """Return the derivatives (N, ..., n) of values (N, ...) by x (N, n), by central differences."""
    changes = STEP * np.eye(x.shape[1])
    return np.stack([(function(x + change) - function(x - change)) / (2 * STEP) for change in changes], axis=-1)
