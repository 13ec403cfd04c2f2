"""The paper's inverse model along motions of a machine; loops without closed form are assembled successively."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, NoReturn

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.scalar import Scalar
from symoro_elastic.machine.formula import ZERO
from symoro_elastic.machine.machine import Kind, Machine
from symoro_elastic.models.bound.state import DEPENDENT, State, closing_models
from symoro_elastic.models.loops.plan import lacks_closed_form
from symoro_elastic.numerics.evaluation.arrays import arithmetic
from symoro_elastic.numerics.evaluation.assembled_states import start_of
from symoro_elastic.numerics.motion.equations_of_motion import EquationsOfMotion
from symoro_elastic.numerics.motion.independent_joints import share_torques, shares
from symoro_elastic.numerics.verification.implementations import numpy_model
from symoro_elastic.symbolic.arithmetic import evaluate

STEP, FINEST = 0.05, 64
"""Largest step of an independent variable from one assembled position to the next, rad or m, and its least part."""
JUMP = 0.3
"""Change of a dependent variable in one step that may be one to another branch, rad or m."""
CLOSED = 1e-12
"""Gap of a loop, m and rad, that is rounding."""


class InverseModel:
    """Inverse dynamics of motors: torques (61) and accelerations (59) at states (..., n) of a machine.

    Motors that move with others are driven by these.
    """

    def __init__(self, motion: EquationsOfMotion) -> None:
        motion.given.refuse_states_of_friction("a motion of given motors")
        self.motion, self.machine = motion, _driven_by_independent(motion)
        self._model = numpy_model(self.machine, ("inverse_dynamics", *closing_models(self.machine)))
        self._position: tuple[Array, Array] | None = None
        self._known: tuple[Array, Array] | None = None

    def __call__(self, q: Array, qd: Array, qdd_motor: Array) -> tuple[Array, Array]:
        """Return torques (..., motors) of the independent motors, N m or N, and accelerations (..., n)."""
        state = self._close_loops(State({"q": q, "qd": qd, "qdd_motor": qdd_motor}))
        tau, qdd = state.results(self._model.inverse_dynamics)
        return tau, qdd

    def torques(self, q: Array, tau: Array) -> Array:
        """Return torques (N, m) of all motors equivalent to tau (N, motors) at q (N, n), shared by weights (L31)."""
        motion = self.motion
        if not motion.followers:
            return tau
        S_x = motion.bound.coordinates.S_x
        columns = [motion.machine.independent[k] for k in motion.motors]
        entries = [S_x[m].get(k, 0) for m in motion.machine.motors for k in columns]
        slopes = self._along(entries, q, np.zeros_like(q), np.zeros_like(q))
        slopes = slopes.reshape(len(q), len(motion.motor_names), len(columns))
        share = shares(motion.machine, motion.parameters)
        return np.array([share_torques(S_m, forces, share) for S_m, forces in zip(slopes, tau, strict=True)])

    def joint_coordinate_accelerations(self, q: Array, qd: Array, qdd: Array) -> Array:
        """Return accelerations (N, owners) of all joint coordinates, dependent ones too, in table order (L2)."""
        return self._along(self.motion.joint_coordinate_rates[1], q, qd, qdd)

    def _along(self, roots: Sequence[Scalar], q: Array, qd: Array, qdd: Array) -> Array:
        """Return values (N, roots) of expressions of the machine's graph at states (N, n)."""
        names, symbols = self.motion.bound.arguments(), dict[str, Any](self.motion.parameters)
        for key, block in self._close_loops(State({"q": q, "qd": qd, "qdd": qdd})).blocks.items():
            symbols |= zip(names[key], block.T, strict=True)
        value = evaluate(roots, symbols, arithmetic(float))
        values = np.zeros((len(q), len(roots)))
        for column, x in enumerate(roots):
            values[:, column] = value(x)
        return values

    def _close_loops(self, state: State) -> State:
        """Return the state with its loops closed, each from the previous one."""
        if not lacks_closed_form(self.machine):
            return state
        q = state.q
        if self._known is None or self._known[0] is not q:
            closed = np.array([self._assemble(place) for place in q.reshape(-1, q.shape[-1])])
            self._known = q, closed.reshape(*q.shape[:-1], closed.shape[1])
        return state.with_blocks(**{DEPENDENT: self._known[1]})

    def _assemble(self, q: Array) -> Array:
        """Return the dependent variables at q, from the last position; raises `InputError` for open loops."""
        start = start_of(self.machine)
        last, at = self._position or (start.q, start.q_dep)
        step, done = 1 / max(1, math.ceil(float(np.abs(q - last).max()) / STEP)), 0.0
        least = step / FINEST
        while done < 1:
            ahead = min(1.0, done + step)
            near, gap = self._model.assemble(last + ahead * (q - last), at)
            if gap[0] < CLOSED and np.abs(near - at).max() < JUMP:
                at, done = near, ahead
            elif step > least:
                step /= 2
            else:
                self._refuse_open(last + ahead * (q - last))
        self._position = q, at
        return at

    def _refuse_open(self, q: Array) -> NoReturn:
        loops = ", ".join(loop.name for loop in self.machine.loops)
        at = ", ".join(f"{name}={x:g}" for name, x in zip(self.motion.names, q, strict=True))
        raise self.machine.error(f"loop {loops}", f"it does not close at {at}: give a motion that stays on its branch")


def _driven_by_independent(motion: EquationsOfMotion) -> Machine:
    """Return the machine with dependent motors passive: its motion stays the same."""
    joints = list(motion.given.joints)
    for j in motion.followers:
        joints[j - 1] = replace(joints[j - 1], kind=Kind.PASSIVE, sharing=ZERO)
    return replace(motion.given, joints=tuple(joints)) if motion.followers else motion.given
