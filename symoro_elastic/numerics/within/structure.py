"""Structure that an inverse model loses with single terms: symmetry of its inertia matrix, balance of its power.

The columns of the inertia matrix A_S are the torques of single accelerations, less those at rest. In a whole model the
power of the velocity torques c is the rate of change of A:

    qd' c = 1/2 qd' Ad qd

A reduced model violates the balance by the difference of both sides from that of the full model (friction has power in
both). Omitted parameters keep symmetry and balance; omitted terms do not, and so the violation is reported.

That is so where positions, velocities and torques are those of the same joints: not where loops or couplings give the
positions of motors (a gantry whose model moves with its yaw, driven by the carriages on both sides).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.numerics.evaluation.arrays import arithmetic
from symoro_elastic.numerics.guarantees.box import Box
from symoro_elastic.symbolic.arithmetic import evaluate
from symoro_elastic.symbolic.program import Program

STATES = 2000
STEP = 1e-6
"""Of the time over which A changes, s."""


@dataclass(frozen=True)
class LostStructure:
    """Largest asymmetry and violation of the power balance of a reduced inverse model at drawn states.

    `asymmetry` is that of A over its largest entry, `power` the violation of the balance, W; `largest_power` is that of
    the motors.
    """

    asymmetry: float
    power: float
    largest_power: float


def lost_structure(whole: Program, reduced: Program, box: Box, seed: int = 0) -> LostStructure | None:
    """Return the structure that an inverse model in the variables of motors has lost; None for other models.

    Whether they are is for the caller to know (`Machine.moves_by_motors`) where there are as many motors as variables.
    """
    inputs = {argument.name: argument.symbols for argument in whole.inputs}
    if {*inputs} != {"q", "qd", "qdd_motor"} or len({len(symbols) for symbols in inputs.values()}) != 1:
        return None
    states = {name: np.zeros(STATES) for symbols in inputs.values() for name in symbols}
    states |= box.states(STATES, np.random.default_rng(seed))
    exact, left = (_Inverse(program, inputs) for program in (whole, reduced))
    A = left.inertia(states)
    if not A.any():
        return None
    violation = left.power_balance(states) - exact.power_balance(states)
    return LostStructure(
        float(np.abs(A - A.transpose(1, 0, 2)).max() / np.abs(A).max()),
        float(np.abs(violation).max()),
        float(np.abs(exact.power(states)).max()),
    )


class _Inverse:
    """The torques of an inverse model at states (motors, states)."""

    def __init__(self, program: Program, inputs: Mapping[str, tuple[str, ...]]) -> None:
        self._roots = next(output.entries for output in program.outputs if output.name == "tau")
        self._inputs = inputs

    def torques(self, states: Mapping[str, Array], **changed: Array) -> Array:
        """The torques at states of which some arguments (entries, states) are `changed`."""
        own = {name: x for key, rows in changed.items() for name, x in zip(self._inputs[key], rows, strict=True)}
        value = evaluate(self._roots, {**states, **own}, arithmetic(np.float64))
        return np.array([np.broadcast_to(value(x), STATES) for x in self._roots])

    def argument(self, states: Mapping[str, Array], name: str) -> Array:
        return np.array([states[symbol] for symbol in self._inputs[name]])

    def inertia(self, states: Mapping[str, Array], q: Array | None = None) -> Array:
        """A (motors, motors, states), at the positions of the states or at others."""
        still = np.zeros((len(self._roots), STATES))
        here = {"q": self.argument(states, "q") if q is None else q, "qd": still}
        static_torques = self.torques(states, qdd_motor=still, **here)
        columns = []
        for k in range(len(self._roots)):
            single = still.copy()
            single[k] = 1.0
            columns.append(self.torques(states, qdd_motor=single, **here) - static_torques)
        return np.array(columns).transpose(1, 0, 2)

    def power(self, states: Mapping[str, Array]) -> Array:
        """The power of the motors."""
        return np.asarray((self.argument(states, "qd") * self.torques(states)).sum(axis=0))

    def power_balance(self, states: Mapping[str, Array]) -> Array:
        """qd' c - 1/2 qd' Ad qd: the power of friction, and the violation of the balance."""
        q, qd = self.argument(states, "q"), self.argument(states, "qd")
        still = np.zeros_like(qd)
        c = self.torques(states, qdd_motor=still) - self.torques(states, qd=still, qdd_motor=still)
        rate = (self.inertia(states, q + STEP * qd) - self.inertia(states, q - STEP * qd)) / (2 * STEP)
        return np.asarray((qd * c).sum(axis=0) - np.einsum("is,iks,ks->s", qd, rate, qd) / 2)
