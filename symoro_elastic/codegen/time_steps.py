"""Time steps as data for templates: methods, their coefficients as literals, variants of motor inputs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

from symoro_elastic.codegen.integration.tableaus import (
    Coefficients,
    Method,
    Midpoint,
    Rosenbrock,
    Tableau,
    WMethod,
    nodes_of,
    times_of,
)
from symoro_elastic.codegen.package import EXTERNAL, Argument, Package
from symoro_elastic.codegen.precision import Precision
from symoro_elastic.quantities import quantity

Terms = tuple[tuple[str, int], ...]
"""Coefficients as literals, with their signs, and the stages they belong to."""

MOTOR_COORDINATES = "motor_coordinates"
"""The model of positions and velocities of motors on dependent joints."""


@dataclass(frozen=True)
class Variant:
    """A kind of motor inputs: suffix of names, arrays with a row per node, arrays per step, words.

    `of_nodes` are those of motors, then that of wrenches on frames.
    `of_rate` are the derivatives by time at t, an additional input of methods with exact derivatives.
    """

    suffix: str
    of_nodes: tuple[str, ...]
    of_step: tuple[str, ...] = ()
    words: str = ""
    of_rate: tuple[str, ...] = ("taud",)

    @property
    def right_side(self) -> str:
        """Name of the model that computes accelerations."""
        if self.suffix == DRIVES.suffix:
            return CLOSED
        return "inverse_dynamics" if self.is_driven else "direct_dynamics"

    @property
    def is_driven(self) -> bool:
        """Whether motors are on prescribed motions."""
        return self.suffix == DRIVEN.suffix


EXTERNAL_RATE = f"{EXTERNAL}d"
STATES = "z"
"""States of friction and drives."""
LOAD, PASSED = "load", "passed_torques"
"""The argument of torques through joints with load-dependent friction, and the model that computes them."""
WRENCH, DEGREES = "f0", 6
"""The wrench on the base, and its degrees of freedom."""
TORQUE = Variant("", ("tau",))
SERVO = Variant("_servo", ("tau", "r", "rd"), ("kp", "kd"), ", motors under tau + kp (r - q) + kd (rd - qd)")
DRIVEN = Variant("_driven", ("y", "yd", "ydd"), (), ", motors on prescribed motions y, yd, ydd", ("yddd",))
KINDS: Mapping[type, str] = {Tableau: "explicit", WMethod: "w", Rosenbrock: "rosenbrock", Midpoint: "midpoint"}
CLOSED = "closed_dynamics"
"""The direct dynamic model under the drives."""
DRIVES = Variant("_drives", ("r", "rd", "rdd", "tau"), (), ", motors under their drives at r, rd, rdd and under tau")
RATES = {
    "taud": "derivative by time of the torques at t, that of kp r + kd rd with it",
    "yddd": "derivative of ydd by time at t",
    EXTERNAL_RATE: "derivative of f_ext by time at t",
}
"""Meanings of the derivatives by time."""


@dataclass(frozen=True)
class Stage:
    """A stage of a method: number, node, time as text; coefficients of earlier stages, and of the input rate."""

    number: int
    node: int
    time: str
    a: Terms
    g: Terms = ()
    of_rate: str = ""


@dataclass(frozen=True)
class MethodText:
    """A method for templates: kind of its stages, gamma, nodes in order, stages, weights, weights of the error.

    `parts` are the nodes as literals, parts of a step. `end` is the node at t + h of motors that are
    driven, where stages have none.
    """

    name: str
    title: str
    kind: str
    gamma: str
    nodes: tuple[Fraction, ...]
    parts: tuple[str, ...]
    end: tuple[Fraction, ...]
    stages: tuple[Stage, ...]
    b: Terms
    error: Terms
    iterations: int
    variants: tuple[Variant, ...]

    @property
    def steps(self) -> list[tuple[Variant, bool]]:
        """Variants of the steps of the method, each without and, if available, with an error estimate."""
        errors = (False, True) if self.error else (False,)
        return [(variant, with_error) for variant in self.variants for with_error in errors]

    def nodes_of(self, variant: Variant) -> tuple[Fraction, ...]:
        """The nodes at which a variant has motor inputs."""
        return (*self.nodes, *self.end) if variant.is_driven else self.nodes

    def times(self, variant: Variant) -> tuple[str, ...]:
        """Times of the nodes, as text."""
        return tuple(map(_in_words, self.nodes_of(variant)))


def method_text(method: Method, package: Package, precision: Precision) -> MethodText:
    """Return a method with its coefficients as literals of a precision."""
    literal = Literals(precision)
    times = times_of(method)
    nodes = nodes_of(method)
    return MethodText(
        name=method.name,
        title=method.title,
        kind=KINDS[type(method)],
        gamma=literal.number(method.gamma) if isinstance(method, WMethod | Rosenbrock) else "",
        nodes=nodes,
        parts=tuple(map(literal.number, nodes)),
        end=nodes_of(method, driven=True)[len(nodes) :],
        stages=_stages(method, times, nodes, literal),
        b=literal.terms(_weights(method)),
        error=literal.terms(_error_weights(method)),
        iterations=method.iterations if isinstance(method, Midpoint) else 0,
        variants=variants(package, with_states=isinstance(method, Tableau | WMethod)),
    )


def variants(package: Package, with_states: bool) -> tuple[Variant, ...]:
    """Return the possible variants of motor inputs: prescribed motions only for independent motors, drives."""
    moves = bool(package.base) or len(package.motors) < len(package.axes)
    variants = [DRIVES if package.only == DRIVES.suffix else TORQUE]
    if package.motor_names and package.only is None:
        variants += [SERVO, *([DRIVEN] if package.has_motors_in_q and moves else [])]
        closed = any(function.name == CLOSED for function in package.functions)
        variants += [DRIVES] if with_states and closed else []
    return tuple(map(_under_forces, variants) if package.external else variants)


def states_carried(variant: Variant, package: Package) -> int:
    """Return the number of states of friction and drives of a step."""
    called = next((f for f in package.functions if f.name == variant.right_side), None)
    return next((a.size for a in called.arguments if a.name == STATES), 0) if called else 0


def blocks_carried(variant: Variant, package: Package) -> tuple[Argument, ...]:
    """Return the state blocks that a step integrates, states of friction and drives last."""
    blocks = tuple(block for block in package.state if block.name != STATES)
    size = states_carried(variant, package)
    return (*blocks, Argument(quantity(STATES), size)) if size else blocks


def given_to_factors(variant: Variant, package: Package) -> tuple[str, ...]:
    """Return the motor arguments of an implicit step's factorization: gains, or inputs at t if limits act."""
    function = next((f for f in package.functions if f.name == f"implicit_factors{variant.suffix}"), None)
    limited = function and any(argument.name == DRIVES.of_nodes[0] for argument in function.arguments)
    return DRIVES.of_nodes if limited else variant.of_step


def _under_forces(variant: Variant) -> Variant:
    """The variant with wrenches on frames as additional inputs."""
    return replace(variant, of_nodes=(*variant.of_nodes, EXTERNAL), of_rate=(*variant.of_rate, EXTERNAL_RATE))


def rows_of_nodes(variant: Variant, package: Package) -> dict[str, int]:
    """Return the number of entries per row of the input arrays with a row for each node, by name."""
    sizes = dict.fromkeys(variant.of_nodes, len(package.motor_names))
    sizes |= {EXTERNAL: package.external} if package.external else {}
    return sizes | ({WRENCH: DEGREES} if package.base else {})


def loads_of(package: Package) -> int:
    """Return the number of joints with load-dependent friction, whose transmitted torques steps iterate."""
    return next((a.size for function in package.functions for a in function.arguments if a.name == LOAD), 0)


def settling_of(package: Package, literal: Literals) -> dict[str, str | int]:
    """Return the convergence criteria of transmitted torques; empty without load-dependent friction.

    A change counts by its rounding against all terms, a load is extrapolated where it bends so much by squares.
    """
    if not (count := loads_of(package)):
        return {}
    numbers = {"settled": Fraction(1, 256), "straight": Fraction(10) ** -18}
    return {"count": count, "most": 500, "extrapolated": 30} | {key: literal.number(x) for key, x in numbers.items()}


def entries_of_state(package: Package) -> int:
    """Return the number of positions that a method integrates: coordinates of the base, then the joints."""
    return (DEGREES if package.base else 0) + len(package.axes)


def error_meaning(package: Package, states: int = 0) -> str:
    """Return the meaning of a step's error estimate, as text."""
    if states:
        return f"{error_meaning(package)}".replace("then of qd", "of qd, then of z")
    if package.base:
        return "difference of the base's pose in its axes, q, V0, then of qd, from the embedded method"
    return "difference of q, then of qd, from the embedded method"


class Literals:
    """C literals of numbers that are combined with arrays of a precision."""

    def __init__(self, precision: Precision) -> None:
        self._written = precision.number_of_state

    def number(self, x: Fraction) -> str:
        """Return the literal of a number."""
        return f"{'-' if x < 0 else ''}{self._written(repr(abs(float(x))))}"

    def terms(self, row: Coefficients) -> Terms:
        """Return the nonzero coefficients of a row as literals, with their stages."""
        return tuple((self.number(x), j) for j, x in enumerate(row) if x)


def _in_words(node: Fraction) -> str:
    """A time within a step as text: `t`, `t + 0.5 h`, `t + h`."""
    number = repr(float(node))
    return {"0.0": "t", "1.0": "t + h"}.get(number, f"t + {number} h")


def _weights(method: Method) -> Coefficients:
    if isinstance(method, Rosenbrock):
        return method.m
    return (Fraction(1),) if isinstance(method, Midpoint) else method.b


def _error_weights(method: Method) -> Coefficients:
    """Weights of the error estimate: b minus embedded weights; empty without an embedded method."""
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
        Stage(k, nodes.index(time), _in_words(time), literal.terms(row), literal.terms(others), rate)
        for k, (time, row, others, rate) in enumerate(rows)
    )
