"""Laws of a joint as expressions: its spring and damper, its friction, and the cogging of its motor.

**Spring and damper**: a straight law, or one with a backlash b that roundings e make smooth.

    Gamma = -k D(x) - c D'(x) v,   D(x) = x - (R(x + b/2) - R(x - b/2))/2,   R(u) = sqrt(u^2 + e^2)      (D3)

The slope D' is between 0 and 1, next to 0 within the backlash and next to 1 on its flanks. The spring has a potential,
k U(x) with U' = D, and U(0) = 0. With u = x + b/2, w = x - b/2 and P(u) = u R(u) + e^2 asinh(u/e) it is

    U(x) = x^2/2 - (P(u) - P(w))/4 + P(b/2)/2.

**Friction**: dry friction that jumps, creeps, falls with velocity, rises with load or bends.

    g(v)  = Fc + (Fb - Fc)/(1 + (v/vb)^2) + mu |lambda|             Stribeck without exp, Hess and Soom 1990
    Gamma = s0 z + s1 zd + s2 v,   zd = v (1 - alpha y)             (D1), (D2)
    y     = s0 z sign(v)/g(v),     alpha = x^2 (3 - 2 x),   x = min(max((y - b)/(1 - b), 0), 1)

y is the deflection of the bristle by that of steady slip, positive where it bends in the sense of the motion, so that
alpha is 0 elsewhere without a branch. b = 0 stands for LuGre, alpha = 1. With c^4 = 2 (1 - b) and k = c/(1 - b), in
fewer operations:

    alpha y = X^2 (3 c/2 - X) (k y),     X = c x = min(max(k y - k b, 0), c)

**Cogging** of a motor: a torque by the position of its rotor alone, with a potential as of a spring.

    Gamma = n A sin(N n q + phi),    V = (A/N) cos(N n q + phi),    -dGamma/dq = -N n^2 A cos(N n q + phi)

with the ratio n; of the joint's own axis a = n A and k = n N: Gamma = a sin(k q + phi), V = (a/k) cos(k q + phi).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from symoro_elastic.foundation.scalar import Scalar
from symoro_elastic.machine.joints import USUAL_ROUNDING
from symoro_elastic.mechanics.energy import elastic_energy
from symoro_elastic.mechanics.joint_laws import elastic_torque, friction, friction_slope, smooth_sign
from symoro_elastic.symbolic.differentiation import Differentiation, substitute
from symoro_elastic.symbolic.expression import Graph, Operand, is_constant, operand, quotient
from symoro_elastic.symbolic.functions import amount, clamp, cosine_sine, logarithm, maximum, sign, square_root


@dataclass(frozen=True)
class JointFriction:
    """Friction of a joint at the rate v, N m or N; cells that are left out are 0.

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
        """Whether the deflection z of the bristle is a state."""
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
        """Dry friction g(v) of steady slip, divided by `over`."""
        level = self.coulomb / over
        if not is_zero(self.static):
            square = self.stribeck * self.stribeck
            level = level + (self.static - self.coulomb) * square / over / (square + self.v * self.v)
        return level if is_zero(self.share) else level + self.share / over * amount(self.graph, self.load)

    def rate_of_bristle(self) -> Scalar:
        """Return the time derivative z' of the bristle's deflection."""
        return self.v * (1 - self._alpha_y(self.bristle * self.z * self._side()))

    def slope(self) -> Scalar:
        """Derivative of friction by v at constant bristle deflection z; a sign counts as constant."""
        if not self.has_state and is_zero(self.static):
            return self.slope_at_level()
        v = self.graph.symbol("rate_of_joint")
        at_v = JointFriction(**{**self.__dict__, "v": v}).force()
        slope = Differentiation([at_v]).by(v).of(at_v)
        return substitute(self.graph, [slope], {"rate_of_joint": self.v})[0]

    def slope_at_level(self) -> Scalar:
        """Derivative of friction by v at constant level of dry friction and bristle: never negative."""
        speed = None if self.has_state else self._speed()
        return self.viscous if speed is None else friction_slope(self.viscous, self.level(), self.creep, speed)

    def implicit_bristle(self, g: Scalar) -> ImplicitBristle:
        """The bristle in (I - g T) x = r: slopes by z and v, without those of alpha and g, none negative.

        That by z is of a bristle that slips: one that is bent in fast motion will do so within the step.
        """
        by_z = self.bristle * self._side()
        followed = maximum(self.graph, 1 - self._alpha_y(by_z * self.z), 0)
        return ImplicitBristle(g, self.bristle, self.damping, self._scales[1], by_z * self.v, followed)

    @property
    def _scales(self) -> tuple[Scalar, Scalar]:
        """Return the factors c and k that scale the transition from sticking to slipping."""
        if is_zero(self.breakaway):
            return 1, 1
        width = 1 - self.breakaway
        c = square_root(self.graph, square_root(self.graph, 2 * width))
        return c, c / width

    def _side(self) -> Scalar:
        """Return k sign(v)/g, with g the dry friction of steady slip."""
        side, level = sign(self.graph, self.v), self.level(self._scales[1])
        return side * quotient(1, operand(level)) if is_constant(level) else side / level

    def _alpha_y(self, y: Scalar) -> Scalar:
        """Return alpha y from y = k s0 z sign(v)/g, where alpha rises from 0 (sticking) to 1 (slipping)."""
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
    """Bristle in an implicit step: z' = followed v - a z, force (s0 - s1 a) z + s1 followed v; `ka` is k a."""

    g: Scalar
    stiffness: Scalar
    damping: Scalar
    k: Scalar
    ka: Scalar
    followed: Scalar

    @property
    def over(self) -> Scalar:
        """Return 1/(1 + g a), the factor of the implicit step."""
        return self.k / (self.k + self.g * self.ka)

    @property
    def damper(self) -> Scalar:
        """The contribution of the bristle to the damping of the joint (D7)."""
        return (self.damping + self.g * self.stiffness) * self.followed * self.over

    def push(self, r_z: Scalar) -> Scalar:
        """The force on the joint due to the right-hand side r_z of the bristle (D8)."""
        return (self.stiffness - self.damping / self.k * self.ka) * self.over * r_z

    def solution(self, r_z: Scalar, z_v: Scalar) -> Scalar:
        """Return the solution z of the bristle from r_z and the solution z_v of the joint's rate (D8)."""
        return self.over * (r_z + self.g * self.followed * z_v)


def is_zero(x: Scalar) -> bool:
    """Whether a cell is the integer zero, as an omitted cell is."""
    return isinstance(x, int) and x == 0


@dataclass(frozen=True)
class JointSpring:
    """Spring and damper of a joint at the deflection x, rad or m; cells that are left out are 0."""

    graph: Graph
    stiffness: Scalar
    x: Scalar
    damping: Scalar
    backlash: Scalar
    rounding: Scalar

    def torque(self, v: Scalar) -> Scalar:
        """Torque of spring and damper at the rate v, N m or N [9]."""
        return elastic_torque(self.stiffness, self._beyond_backlash, self.damper, v)

    @property
    def force(self) -> Scalar:
        """k D(x), the force against the deflection."""
        return self.stiffness * self._beyond_backlash

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
        """Potential energy k U(x) of the spring, J; zero at zero deflection."""
        if is_zero(self.backlash):
            return elastic_energy(self.stiffness, self.x)
        half, amount = self.backlash / 2, self.x * sign(self.graph, self.x)
        difference = self._integral(half, -half) - self._integral(amount + half, amount - half)
        return elastic_energy(self.stiffness, self.x) + self.stiffness * difference / 4

    @cached_property
    def _beyond_backlash(self) -> Scalar:
        """Deflection D(x) beyond the backlash, as x (1 - b/(R + R)): R(u)^2 - R(w)^2 = 2 b x."""
        if is_zero(self.backlash):
            return self.x
        over, under = self._roots
        return self.x * (1 - self.backlash / (over + under))

    @cached_property
    def _share(self) -> Scalar:
        """Derivative D'(x) of the deflection beyond the backlash."""
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
        """P(u) - P(w) for the energy, P the integral of 2 R; u >= 0 and w >= -u keep the logarithm accurate."""
        over, under = self._root(u), self._root(w)
        return u * over - w * under + self._e * self._e * logarithm(self.graph, (u + over) / (w + under))


@dataclass(frozen=True)
class MotorCogging:
    """Cogging at the position x of a joint, and the `spring` in parallel: the interface of `JointSpring`.

    All is of the joint's own axis.
    """

    graph: Graph
    amplitude: Scalar
    order: Scalar
    phase: Scalar
    x: Scalar
    spring: JointSpring

    @property
    def damper(self) -> Scalar:
        """Damping: zero."""
        return 0

    def torque(self, _: Scalar) -> Scalar:
        """Torque, N m or N, whatever the rate."""
        return self.amplitude * self._circle[1] - self.spring.force

    @property
    def force(self) -> Scalar:
        """The equivalent force of a spring against the deflection."""
        return -self.torque(0)

    @property
    def slope(self) -> Scalar:
        """Stiffness at this position, of either sign."""
        return self.spring.slope - (self.amplitude * self.order) * self._circle[0]

    def change(self, _: Scalar) -> Scalar:
        """Stiffness at this position, which the rate does not change."""
        return self.slope

    def energy(self) -> Scalar:
        """Potential, J; the potential of cogging has mean zero."""
        return self.amplitude / self.order * self._circle[0] + self.spring.energy()

    @cached_property
    def _circle(self) -> tuple[Operand, Operand]:
        return cosine_sine(self.graph, self.order * self.x + self.phase)
