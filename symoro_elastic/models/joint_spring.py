"""Spring and damper of a joint as expressions: a straight law, or one with a backlash b that roundings e make smooth.

    Gamma = -k D(x) - c D'(x) v,   D(x) = x - (R(x + b/2) - R(x - b/2))/2,   R(u) = sqrt(u^2 + e^2)      (D3)

The slope D' is between 0 and 1, next to 0 within the backlash and next to 1 on its flanks. The spring has a potential,
k U(x) with U' = D, and U(0) = 0. With u = x + b/2, w = x - b/2 and P(u) = u R(u) + e^2 asinh(u/e) it is

    U(x) = x^2/2 - (P(u) - P(w))/4 + P(b/2)/2.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from symoro_elastic.foundation.scalar import Scalar
from symoro_elastic.machine.joints import USUAL_ROUNDING
from symoro_elastic.mechanics.energy import elastic_energy
from symoro_elastic.mechanics.joint_laws import elastic_torque
from symoro_elastic.models.joint_friction import is_zero
from symoro_elastic.symbolic.expression import Graph
from symoro_elastic.symbolic.functions import logarithm, sign, square_root


@dataclass(frozen=True)
class JointSpring:
    """Spring and damper of one joint at the deflection x, rad or m; cells that are left out are 0."""

    graph: Graph
    stiffness: Scalar
    x: Scalar
    damping: Scalar
    backlash: Scalar
    rounding: Scalar

    def torque(self, v: Scalar) -> Scalar:
        """Torque of spring and damper at the rate v, N m or N [9]."""
        return elastic_torque(self.stiffness, self._pressed, self.damper, v)

    @property
    def force(self) -> Scalar:
        """k D(x), the force against the deflection."""
        return self.stiffness * self._pressed

    @property
    def slope(self) -> Scalar:
        """k D'(x), the stiffness at this deflection."""
        return self.stiffness if is_zero(self.backlash) else self.stiffness * self._share

    @property
    def damper(self) -> Scalar:
        """c D'(x), the damping at this deflection."""
        return self.damping if is_zero(self.backlash) or is_zero(self.damping) else self.damping * self._share

    def change(self, v: Scalar) -> Scalar:
        """k D'(x) + c D''(x) v, the derivative of k D(x) + c D'(x) v by x."""
        if is_zero(self.backlash) or is_zero(self.damping):
            return self.slope
        over, under = self._roots
        bend = self._e * self._e * (1 / (under * under * under) - 1 / (over * over * over)) / 2
        return self.slope + self.damping * bend * v

    def energy(self) -> Scalar:
        """k U(x), J; zero where the deflection is."""
        if is_zero(self.backlash):
            return elastic_energy(self.stiffness, self.x)
        half, amount = self.backlash / 2, self.x * sign(self.graph, self.x)
        rest = self._integral(half, -half) - self._integral(amount + half, amount - half)
        return elastic_energy(self.stiffness, self.x) + self.stiffness * rest / 4

    @cached_property
    def _pressed(self) -> Scalar:
        """D(x), as x (1 - b/(R + R)): R(u)^2 - R(w)^2 = 2 b x."""
        if is_zero(self.backlash):
            return self.x
        over, under = self._roots
        return self.x * (1 - self.backlash / (over + under))

    @cached_property
    def _share(self) -> Scalar:
        """D'(x)."""
        half, (over, under) = self.backlash / 2, self._roots
        return 1 - ((self.x + half) / over - (self.x - half) / under) / 2

    @cached_property
    def _roots(self) -> tuple[Scalar, Scalar]:
        return self._root(self.x + self.backlash / 2), self._root(self.x - self.backlash / 2)

    @cached_property
    def _e(self) -> Scalar:
        return self.backlash / USUAL_ROUNDING if is_zero(self.rounding) else self.rounding

    def _root(self, u: Scalar) -> Scalar:
        return square_root(self.graph, u * u + self._e * self._e)

    def _integral(self, u: Scalar, w: Scalar) -> Scalar:
        """P(u) - P(w), where u is not negative and w is at least -u: the logarithm then is of what is at least 1."""
        over, under = self._root(u), self._root(w)
        return u * over - w * under + self._e * self._e * logarithm(self.graph, (u + over) / (w + under))
