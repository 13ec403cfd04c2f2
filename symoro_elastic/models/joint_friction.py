"""Friction of a joint as expressions: dry friction that jumps, creeps, falls with velocity, rises with load or bends.

    g(v)  = Fc + (Fb - Fc)/(1 + (v/vb)^2) + mu |lambda|             Stribeck without exp, Hess and Soom 1990
    Gamma = s0 z + s1 zd + s2 v,   zd = v (1 - alpha y)             (D1), (D2)
    y     = s0 z sign(v)/g(v),     alpha = x^2 (3 - 2 x),   x = min(max((y - b)/(1 - b), 0), 1)

y is the deflection of the bristle by that of steady slip, positive where it bends in the sense of the motion, so that
alpha is 0 elsewhere without a branch. b = 0 stands for LuGre, alpha = 1. With c^4 = 2 (1 - b) and k = c/(1 - b), in
fewer operations:

    alpha y = X^2 (3 c/2 - X) (k y),     X = c x = min(max(k y - k b, 0), c)
"""

from __future__ import annotations

from dataclasses import dataclass

from symoro_elastic.foundation.scalar import Scalar
from symoro_elastic.mechanics.joint_laws import friction, friction_slope, smooth_sign
from symoro_elastic.symbolic.differentiation import Differentiation, substitute
from symoro_elastic.symbolic.expression import Graph, is_constant, operand, quotient
from symoro_elastic.symbolic.functions import amount, clamp, maximum, sign, square_root


@dataclass(frozen=True)
class JointFriction:
    """Friction of one joint at the rate v, N m or N; cells that are left out are 0.

    `z` is the deflection of its bristle, `load` the torque through the transmission.
    """

    graph: Graph
    v: Scalar
    z: Scalar
    load: Scalar
    viscous: Scalar
    coulomb: Scalar
    creep: Scalar
    static: Scalar
    stribeck: Scalar
    share: Scalar
    bristle: Scalar
    damping: Scalar
    breakaway: Scalar

    @property
    def has_state(self) -> bool:
        """Whether z is a state."""
        return not is_zero(self.bristle)

    def force(self) -> Scalar:
        """Friction, opposing motion."""
        if self.has_state:
            return self.bristle * self.z + self.damping * self.rate_of_bristle() + self.viscous * self.v
        return friction(self.viscous, self.level(), self.v, self.sense())

    def sense(self) -> Scalar:
        """sign(v), smooth where the joint creeps."""
        speed = self._speed()
        return sign(self.graph, self.v) if speed is None else smooth_sign(self.v, speed)

    def level(self, over: Scalar = 1) -> Scalar:
        """g(v), the dry friction of steady slip, by a number."""
        level = self.coulomb / over
        if not is_zero(self.static):
            square = self.stribeck * self.stribeck
            level = level + (self.static - self.coulomb) * square / over / (square + self.v * self.v)
        return level if is_zero(self.share) else level + self.share / over * amount(self.graph, self.load)

    def rate_of_bristle(self) -> Scalar:
        """Return zd."""
        return self.v * (1 - self._held_back(self.bristle * self.z * self._side()))

    def slope(self) -> Scalar:
        """Derivative of friction by v, z held; a sign counts as constant."""
        if not self.has_state and is_zero(self.static):
            return self.slope_at_level()
        v = self.graph.symbol("rate_of_joint")
        at_v = JointFriction(**{**self.__dict__, "v": v}).force()
        slope = Differentiation([at_v]).by(v).of(at_v)
        return substitute(self.graph, [slope], {"rate_of_joint": self.v})[0]

    def slope_at_level(self) -> Scalar:
        """The same where the level of dry friction and the bristle are held: never negative, as of implicit steps."""
        speed = None if self.has_state else self._speed()
        return self.viscous if speed is None else friction_slope(self.viscous, self.level(), self.creep, speed)

    def implicit_bristle(self, g: Scalar) -> ImplicitBristle:
        """What the bristle does in (I - g T) x = r: slopes by z and v without those of alpha and g, none below 0.

        That by z is of a bristle that slips: one that is bent in fast motion will do so within the step.
        """
        by_z = self.bristle * self._side()
        followed = maximum(self.graph, 1 - self._held_back(by_z * self.z), 0)
        return ImplicitBristle(g, self.bristle, self.damping, self._scales[1], by_z * self.v, followed)

    @property
    def _scales(self) -> tuple[Scalar, Scalar]:
        """Return c and k."""
        if is_zero(self.breakaway):
            return 1, 1
        width = 1 - self.breakaway
        c = square_root(self.graph, square_root(self.graph, 2 * width))
        return c, c / width

    def _side(self) -> Scalar:
        """Return k sign(v)/g."""
        side, level = sign(self.graph, self.v), self.level(self._scales[1])
        return side * quotient(1, operand(level)) if is_constant(level) else side / level

    def _held_back(self, y: Scalar) -> Scalar:
        """Return alpha y by k y."""
        if is_zero(self.breakaway):
            return y
        c, k = self._scales
        X = clamp(self.graph, y - k * self.breakaway, 0, c)
        return X * X * (3 * c / 2 - X) * y

    def _speed(self) -> Scalar | None:
        """sqrt(v^2 + creep^2) of a joint that creeps; None for others."""
        if is_zero(self.creep):
            return None
        return square_root(self.graph, self.v * self.v + self.creep * self.creep)


@dataclass(frozen=True)
class ImplicitBristle:
    """The row z' = followed v - a z of T and the force (s0 - s1 a) z + s1 followed v; `ka` is k a."""

    g: Scalar
    stiffness: Scalar
    damping: Scalar
    k: Scalar
    ka: Scalar
    followed: Scalar

    @property
    def over(self) -> Scalar:
        """Return 1/(1 + g a)."""
        return self.k / (self.k + self.g * self.ka)

    @property
    def damper(self) -> Scalar:
        """What it adds to the damping of the joint (D7)."""
        return (self.damping + self.g * self.stiffness) * self.followed * self.over

    def push(self, r_z: Scalar) -> Scalar:
        """The force of the part of z that the right side alone gives (D8)."""
        return (self.stiffness - self.damping / self.k * self.ka) * self.over * r_z

    def solution(self, r_z: Scalar, z_v: Scalar) -> Scalar:
        """Return z of the solution, by that of the rate of the joint (D8)."""
        return self.over * (r_z + self.g * self.followed * z_v)


def is_zero(x: Scalar) -> bool:
    """Whether a cell is left out."""
    return isinstance(x, int) and x == 0
