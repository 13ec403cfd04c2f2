"""Time steps as templates are given them: methods, their coefficients as literals, ways to give the motors."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

from symoro_elastic.codegen.integration.methods import Method, Midpoint, nodes_of, times_of
from symoro_elastic.codegen.integration.rosenbrock import Rosenbrock
from symoro_elastic.codegen.integration.tableaus import Coefficients, Tableau
from symoro_elastic.codegen.integration.w_methods import WMethod
from symoro_elastic.codegen.package import EXTERNAL, Argument, Package
from symoro_elastic.codegen.precision import Precision
from symoro_elastic.quantities import quantity

Terms = tuple[tuple[str, int], ...]
"""Coefficients as literals, with their signs, and the stages they belong to."""

MOTOR_COORDINATES = "motor_coordinates"
"""The model that gives positions and velocities of motors on dependent joints."""


@dataclass(frozen=True)
class Variant:
    """A way to give the motors: suffix of names, arrays with a row for each node, arrays for the whole step, words.

    `of_nodes` are those of motors, then that of wrenches on frames.
    `of_rate` is what methods with exact derivatives take beside: what changes by time at t.
    """

    suffix: str
    of_nodes: tuple[str, ...]
    of_step: tuple[str, ...] = ()
    words: str = ""
    of_rate: tuple[str, ...] = ("taud",)

    @property
    def right_side(self) -> str:
        """The model that gives accelerations."""
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
"""The torques through joints whose friction rises with them, which stages find, and the model that gives them."""
WRENCH, DEGREES = "f0", 6
"""The wrench on the base, and its degrees of freedom."""
TORQUE = Variant("", ("tau",))
SERVO = Variant("_servo", ("tau", "r", "rd"), ("kp", "kd"), ", motors under tau + kp (r - q) + kd (rd - qd)")
DRIVEN = Variant("_driven", ("y", "yd", "ydd"), (), ", motors on prescribed motions y, yd, ydd", ("yddd",))
CLOSED = "closed_dynamics"
"""The direct dynamic model under the drives."""
DRIVES = Variant("_drives", ("r", "rd", "rdd", "tau"), (), ", motors under their drives at r, rd, rdd and under tau")
RATES = {
    "taud": "derivative by time of the torques at t, that of kp r + kd rd with it",
    "yddd": "derivative of ydd by time at t",
    EXTERNAL_RATE: "derivative of f_ext by time at t",
}
"""Meaning of what changes by time."""


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
    """A method in the templates: kind of its stages, gamma, nodes in order, stages, weights, weights of the error.

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

    def nodes_of(self, variant: Variant) -> tuple[Fraction, ...]:
        """The nodes at which a variant is given the motors."""
        return (*self.nodes, *self.end) if variant.is_driven else self.nodes

    def times(self, variant: Variant) -> tuple[str, ...]:
        """Their times in words."""
        return tuple(map(_in_words, self.nodes_of(variant)))


def method_text(method: Method, package: Package, precision: Precision) -> MethodText:
    """Return a method with its coefficients as literals of a precision."""
    literal = Literals(precision)
    times = times_of(method)
    nodes = nodes_of(method)
    return MethodText(
        name=method.name,
        title=method.title,
        kind=_kind(method),
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
    """Return the ways in which motors can be given: prescribed motions where they own entries of q, drives."""
    moves = bool(package.base) or len(package.motors) < len(package.axes)
    found = [DRIVES if package.only == DRIVES.suffix else TORQUE]
    if package.motor_names and package.only is None:
        found += [SERVO, *([DRIVEN] if package.has_motors_in_q and moves else [])]
        closed = any(function.name == CLOSED for function in package.functions)
        found += [DRIVES] if with_states and closed else []
    return tuple(map(_under_forces, found) if package.external else found)


def states_carried(variant: Variant, package: Package) -> int:
    """Return how many states of friction and drives a step takes further, beside positions and velocities."""
    called = next((f for f in package.functions if f.name == variant.right_side), None)
    return next((a.size for a in called.arguments if a.name == STATES), 0) if called else 0


def blocks_carried(variant: Variant, package: Package) -> tuple[Argument, ...]:
    """Return the blocks that a step takes further, states of friction and drives last."""
    others = tuple(block for block in package.state if block.name != STATES)
    size = states_carried(variant, package)
    return (*others, Argument(quantity(STATES), size)) if size else others


def given_to_factors(variant: Variant, package: Package) -> tuple[str, ...]:
    """Return what the factors of an implicit step are given of the motors: gains, or rows of t where limits act."""
    function = next((f for f in package.functions if f.name == f"implicit_factors{variant.suffix}"), None)
    limited = function and any(argument.name == DRIVES.of_nodes[0] for argument in function.arguments)
    return DRIVES.of_nodes if limited else variant.of_step


def _under_forces(variant: Variant) -> Variant:
    """The variant with the wrenches on frames, too."""
    return replace(variant, of_nodes=(*variant.of_nodes, EXTERNAL), of_rate=(*variant.of_rate, EXTERNAL_RATE))


def rows_of_nodes(variant: Variant, package: Package) -> dict[str, int]:
    """Return the arrays with a row for each node, and the entries of a row: f0 is the wrench on the base."""
    given = dict.fromkeys(variant.of_nodes, len(package.motor_names))
    given |= {EXTERNAL: package.external} if package.external else {}
    return given | ({WRENCH: DEGREES} if package.base else {})


def loads_of(package: Package) -> int:
    """Return of how many joints the friction rises with the torque through the transmission, which steps find."""
    return next((a.size for function in package.functions for a in function.arguments if a.name == LOAD), 0)


def settling_of(package: Package, literal: Literals) -> dict[str, str | int]:
    """Return when the loads of joints settle; empty where no friction rises with them.

    A change counts by what is rounded off beside all terms, a load is extrapolated where it bends so much by squares.
    """
    if not (count := loads_of(package)):
        return {}
    numbers = {"settled": Fraction(1, 256), "straight": Fraction(10) ** -18}
    return {"count": count, "most": 500, "extrapolated": 30} | {key: literal.number(x) for key, x in numbers.items()}


def entries_of_state(package: Package) -> int:
    """Return the positions that a method carries: the coordinates of the base, then the joints."""
    return (DEGREES if package.base else 0) + len(package.axes)


def error_meaning(package: Package, states: int = 0) -> str:
    """Return what the error of a step holds, in words."""
    if states:
        return f"{error_meaning(package)}".replace("then of qd", "of qd, then of z")
    if package.base:
        return "difference of the base's pose in its axes, q, V0, then of qd, from the embedded method"
    return "difference of q, then of qd, from the embedded method"


class Literals:
    """Numbers as C writes them in the arrays of a precision."""

    def __init__(self, precision: Precision) -> None:
        self._written = precision.number_of_state

    def number(self, x: Fraction) -> str:
        """Return a literal."""
        return f"{'-' if x < 0 else ''}{self._written(repr(abs(float(x))))}"

    def terms(self, row: Coefficients) -> Terms:
        """Return the coefficients that are not zero."""
        return tuple((self.number(x), j) for j, x in enumerate(row) if x)


def _in_words(node: Fraction) -> str:
    """A time after a part of a step: `t`, `t + 0.5 h`, `t + h`."""
    number = repr(float(node))
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
        Stage(k, nodes.index(time), _in_words(time), literal.terms(row), literal.terms(others), rate)
        for k, (time, row, others, rate) in enumerate(rows)
    )
