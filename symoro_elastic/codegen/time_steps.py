"""Time steps as templates are given them: methods, their coefficients as literals, ways to give the motors."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction

from symoro_elastic.codegen.package import Package
from symoro_elastic.codegen.precision import Precision
from symoro_elastic.integration.methods import Method, times_of
from symoro_elastic.integration.midpoint import Midpoint
from symoro_elastic.integration.rosenbrock import Rosenbrock
from symoro_elastic.integration.tableaus import Coefficients, Tableau
from symoro_elastic.integration.w_methods import WMethod

Terms = tuple[tuple[str, int], ...]
"""Coefficients as literals, with their signs, and the stages they belong to."""

MOTOR_COORDINATES = "motor_coordinates"
"""The model that gives positions and velocities of motors on dependent joints."""


@dataclass(frozen=True)
class Variant:
    """A way to give the motors: suffix of names, arrays with a row for each node, arrays for the whole step, words."""

    suffix: str
    of_nodes: tuple[str, ...]
    of_step: tuple[str, ...] = ()
    words: str = ""

    @property
    def right_side(self) -> str:
        """The model that gives accelerations."""
        return "inverse_dynamics" if self is DRIVEN else "direct_dynamics"


WRENCH, DEGREES = "f0", 6
"""The wrench on a floating base, and its degrees of freedom."""
TORQUE = Variant("", ("tau",))
SERVO = Variant("_servo", ("tau", "r", "rd"), ("kp", "kd"), ", motors under tau + kp (r - q) + kd (rd - qd)")
DRIVEN = Variant("_driven", ("y", "yd", "ydd"), (), ", motors on prescribed motions y, yd, ydd")


@dataclass(frozen=True)
class Stage:
    """A stage: number, node, time in words; coefficients of the stages before, and of the rate of torques."""

    number: int
    node: int
    time: str
    a: Terms
    g: Terms = ()
    of_rate: str = ""


@dataclass(frozen=True)
class MethodText:
    """A method in the templates: kind of its stages, gamma, nodes in order, stages, weights, weights of the error."""

    name: str
    title: str
    kind: str
    gamma: str
    nodes: tuple[str, ...]
    stages: tuple[Stage, ...]
    b: Terms
    error: Terms
    iterations: int
    variants: tuple[Variant, ...]

    @property
    def times(self) -> tuple[str, ...]:
        """The times of the nodes in words."""
        return tuple(map(_in_words, self.nodes))


def method_text(method: Method, package: Package, precision: Precision) -> MethodText:
    """Return a method with its coefficients as literals of a precision."""
    literal = Literals(precision)
    times = times_of(method)
    nodes = tuple(dict.fromkeys(times))
    return MethodText(
        name=method.name,
        title=method.title,
        kind=_kind(method),
        gamma=literal.number(method.gamma) if isinstance(method, WMethod | Rosenbrock) else "",
        nodes=tuple(map(literal.number, nodes)),
        stages=_stages(method, times, nodes, literal),
        b=literal.terms(_weights(method)),
        error=literal.terms(_error_weights(method)),
        iterations=method.iterations if isinstance(method, Midpoint) else 0,
        variants=variants(method, package),
    )


def variants(method: Method, package: Package) -> tuple[Variant, ...]:
    """Return the ways in which motors can be given: prescribed motions where they own entries of q."""
    if not package.motor_names:
        return (TORQUE,)
    moves = bool(package.base) or len(package.motors) < len(package.axes)
    follows = moves and package.has_motors_in_q and not isinstance(method, Rosenbrock | Midpoint)
    return (TORQUE, SERVO, DRIVEN) if follows else (TORQUE, SERVO)


def rows_of_nodes(variant: Variant, package: Package) -> dict[str, int]:
    """Return the arrays with a row for each node, and the entries of a row: f0 is the wrench on a floating base."""
    of_motors = dict.fromkeys(variant.of_nodes, len(package.motor_names))
    return of_motors | ({WRENCH: DEGREES} if package.base else {})


def entries_of_state(package: Package) -> int:
    """Return the positions that a method carries: the coordinates of a floating base, then the joints."""
    return (DEGREES if package.base else 0) + len(package.axes)


def error_meaning(package: Package) -> str:
    """Return what the error of a step holds, in words."""
    if package.base:
        return "difference of the base's pose in its axes, q, V0, then of qd, from the embedded method"
    return "difference of q, then of qd, from the embedded method"


class Literals:
    """Numbers as C writes them in the arrays of a precision."""

    def __init__(self, precision: Precision) -> None:
        self._suffix = "f" if precision.state == "float" else ""

    def number(self, x: Fraction) -> str:
        """Return a literal."""
        return repr(float(x)) + self._suffix

    def terms(self, row: Coefficients) -> Terms:
        """Return the coefficients that are not zero."""
        return tuple((self.number(x), j) for j, x in enumerate(row) if x)


def _in_words(node: str) -> str:
    """A time after a part of a step: `t`, `t + 0.5 h`, `t + h`."""
    number = node.removesuffix("f")
    return {"0.0": "t", "1.0": "t + h"}.get(number, f"t + {number} h")


def _kind(method: Method) -> str:
    kinds: Mapping[type, str] = {Tableau: "explicit", WMethod: "w", Rosenbrock: "rosenbrock", Midpoint: "midpoint"}
    return kinds[type(method)]


def _weights(method: Method) -> Coefficients:
    if isinstance(method, Rosenbrock):
        return method.m
    return (Fraction(1),) if isinstance(method, Midpoint) else method.b


def _error_weights(method: Method) -> Coefficients:
    """b less embedded weights; empty where there are none."""
    embedded = method.embedded if isinstance(method, WMethod | Rosenbrock) else ()
    return tuple(b - e for b, e in zip(_weights(method), embedded, strict=True)) if embedded else ()


def _stages(method: Method, times: Coefficients, nodes: Sequence[Fraction], literal: Literals) -> tuple[Stage, ...]:
    if isinstance(method, Midpoint):
        return ()
    a = method.A if isinstance(method, Tableau) else method.a
    g: Sequence[Coefficients] = [()] * len(a)
    rates = [""] * len(a)
    if isinstance(method, WMethod):
        g = [tuple(x / method.gamma for x in row) for row in method.g]
    elif isinstance(method, Rosenbrock):
        g, rates = method.c, [literal.number(x) if x else "" for x in method.gammas]
    rows = zip(times, a, g, rates, strict=True)
    return tuple(
        Stage(k, nodes.index(time), _in_words(literal.number(time)), literal.terms(row), literal.terms(others), rate)
        for k, (time, row, others, rate) in enumerate(rows)
    )
