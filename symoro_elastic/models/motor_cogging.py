"""Cogging of a motor as expressions: a torque by the position of its rotor alone, with a potential as of a spring.

    Gamma = n A sin(N n q + phi),    V = (A/N) cos(N n q + phi),    -dGamma/dq = -N n^2 A cos(N n q + phi)

with the ratio n; of the joint's own axis a = n A and k = n N: Gamma = a sin(k q + phi), V = (a/k) cos(k q + phi).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from symoro_elastic.foundation.scalar import Scalar
from symoro_elastic.symbolic.expression import Graph, Operand
from symoro_elastic.symbolic.functions import cosine_sine


@dataclass(frozen=True)
class MotorCogging:
    """Cogging at the position x of a joint: the interface of `JointSpring`, of the joint's own axis."""

    graph: Graph
    amplitude: Scalar
    order: Scalar
    phase: Scalar
    x: Scalar

    @property
    def damper(self) -> Scalar:
        """None."""
        return 0

    def torque(self, _: Scalar) -> Scalar:
        """Torque, N m or N, whatever the rate."""
        return self.amplitude * self._circle[1]

    @property
    def force(self) -> Scalar:
        """What a spring would exert against the deflection."""
        return -self.torque(0)

    @property
    def slope(self) -> Scalar:
        """Stiffness here, of either sign."""
        return -(self.amplitude * self.order) * self._circle[0]

    def change(self, _: Scalar) -> Scalar:
        """Stiffness here, whatever the rate."""
        return self.slope

    def energy(self) -> Scalar:
        """Potential, J, as much above as below zero."""
        return self.amplitude / self.order * self._circle[0]

    @cached_property
    def _circle(self) -> tuple[Operand, Operand]:
        return cosine_sine(self.graph, self.order * self.x + self.phase)
