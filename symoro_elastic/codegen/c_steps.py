"""Time steps in C: what the templates of a header and a source are given."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from symoro_elastic.codegen.c_function import Array, CFunction
from symoro_elastic.codegen.c_lines import with_arguments
from symoro_elastic.codegen.c_step_calls import StepCalls
from symoro_elastic.codegen.package import Package
from symoro_elastic.codegen.precision import Precision
from symoro_elastic.codegen.templates import render
from symoro_elastic.codegen.time_steps import (
    EXTERNAL_RATE,
    RATES,
    Literals,
    MethodText,
    Terms,
    Variant,
    entries_of_state,
    error_meaning,
    method_text,
    rows_of_nodes,
)
from symoro_elastic.integration.methods import METHODS

LANES = 16
"""States of a batch that take a step side by side."""


@dataclass(frozen=True)
class Qualifiers:
    """What definitions begin with: functions that users call, those of the file, accelerations, data."""

    public: str = ""
    static: str = "static "
    rate: str = "static "
    data: str = "static "


PLAIN_C = Qualifiers()


@dataclass(frozen=True)
class StepText:
    """A time step: comment and heads of its functions, the call of that which does the work, arrays by use."""

    method: MethodText
    variant: Variant
    with_error: bool
    name: str
    comment: str
    working: str
    call: str
    prototypes: tuple[str, ...]
    read: tuple[Array, ...]
    written: tuple[Array, ...]

    @property
    def title(self) -> str:
        """The method and the variant, as a sentence begins."""
        return f"{self.method.title[:1].upper()}{self.method.title[1:]}{self.variant.words}."


class CSteps:
    """The time steps of a package in C, on one state or, with `many`, on batches."""

    def __init__(
        self,
        package: Package,
        precision: Precision,
        functions: Sequence[CFunction],
        many: bool = False,
        qualifiers: Qualifiers = PLAIN_C,
    ) -> None:
        self.package, self.precision, self.many, self.qualifiers = package, precision, many, qualifiers
        self.by_name = {function.function.name: function for function in functions}
        made = [method_text(METHODS[name], package, precision) for name in package.steps]
        self.methods = [method for method in made if not (many and method.kind == "rosenbrock")]
        self.prefix = package.name + precision.suffix
        self.macro = self.prefix.upper()
        self.call = StepCalls(package, self.prefix, self.by_name, self.methods, many)
        self.steps = list(self._steps())

    def source(self) -> str:
        """Return the definitions; empty where no steps are asked for."""
        return render("c/steps.c.j2", **self._context()) if self.methods else ""

    @property
    def constants(self) -> int:
        """How many numbers depend on parameters only."""
        return self.call.constants

    @property
    def nodes(self) -> dict[str, int]:
        """How many rows of torques a step takes, by method."""
        return {method.name: len(method.nodes) for method in self.methods}

    def _steps(self) -> Iterator[StepText]:
        for method in self.methods:
            for variant in method.variants:
                for with_error in (False, True) if method.error else (False,):
                    yield self._step(method, variant, with_error)

    def _step(self, method: MethodText, variant: Variant, with_error: bool) -> StepText:
        name = f"{self.prefix}_step_{method.name}{variant.suffix}{'_error' if with_error else ''}"
        read, written = tuple(self._read(method, variant)), tuple(self._written(with_error))
        c = [self._constants] if self.constants else []
        one, prepared = self._declared(read, [self.p], written), self._declared(read, [self.p, *c], written)
        many = ["size_t count", *self._pointers(read, written)]
        arguments = [*(a.name for a in read), "h", "p", *(a.name for a in (*c, *written))]
        heads = [
            with_arguments(f"void {name}", one),
            *([with_arguments(f"void {name}_prepared", prepared)] if c else []),
        ]
        batch = with_arguments(f"void {name}_batch", ["size_t states", *self._pointers(read, written)])
        return StepText(
            method=method,
            variant=variant,
            with_error=with_error,
            name=name,
            comment="\n * ".join(_comment(method, variant, with_error, self.package)),
            working=with_arguments(
                f"{self.qualifiers.static}void {name}_{'lanes' if self.many else 'stages'}",
                many if self.many else prepared,
            ),
            call=with_arguments(f"    {name}_stages", arguments, ");").lstrip(),
            prototypes=(batch,) if self.many else tuple(heads),
            read=read,
            written=written,
        )

    def _declared(self, read: Sequence[Array], constant: Sequence[Array], written: Sequence[Array]) -> list[str]:
        arrays = [*constant, *written]
        return [*(a.declared() for a in read), f"{self.precision.state} h", *(a.declared() for a in arrays)]

    def _pointers(self, read: Sequence[Array], written: Sequence[Array]) -> list[str]:
        arrays = [self.p, *written]
        return [*(a.pointer() for a in read), f"{self.precision.state} h", *(a.pointer() for a in arrays)]

    def _read(self, method: MethodText, variant: Variant) -> Iterator[Array]:
        """Rows for the nodes, gains, and the rate of the torques."""
        state, torques, motors = self.precision.state, len(self.package.motor_names), f"{self.macro}_MOTORS"
        for name, entries in rows_of_nodes(variant, self.package).items():
            rows = len(method.nodes_of(variant)) * entries
            yield Array(state, name, str(rows), rows)
        for name in variant.of_step:
            yield Array(state, name, motors, torques)
        for name in variant.of_rate if method.kind == "rosenbrock" else ():
            if name == EXTERNAL_RATE:
                yield Array(state, name, str(self.package.external), self.package.external)
            else:
                yield Array(state, name, motors, torques)

    def _written(self, with_error: bool) -> Iterator[Array]:
        """The state, and the difference from the embedded method."""
        state, n = self.precision.state, len(self.package.axes)
        yield from (Array(state, name, f"{self.macro}_JOINTS", n, True) for name in ("q", "qd"))
        if self.package.takes_dependent:
            yield Array(state, "q_dep", f"{self.macro}_DEPENDENT", len(self.package.dependent or ()), True)
        yield from (Array(state, one.name, str(one.size), one.size, True) for one in self.package.base)
        if with_error:
            size = 2 * entries_of_state(self.package)
            yield Array(state, "error", str(size) if self.package.base else f"2*{self.macro}_JOINTS", size, True)

    @property
    def p(self) -> Array:
        """The array of parameters."""
        return Array(self.precision.state, "p", f"{self.macro}_PARAMETERS", len(self.package.parameters))

    @property
    def _constants(self) -> Array:
        real = self.precision.type_of_real(self.package.name)
        return Array(real, "c", f"{self.macro}_STEP_CONSTANTS", self.constants)

    def _context(self) -> dict[str, Any]:
        package, literal = self.package, Literals(self.precision)
        variants = list(dict.fromkeys(step.variant for step in self.steps))
        factors = {v.suffix: self.by_name.get(f"implicit_factors{v.suffix}") for v in variants}
        return {
            "name": self.prefix,
            "macro": self.macro,
            "state": self.precision.state,
            "real": self.precision.type_of_real(package.name),
            "many": self.many,
            "qualifiers": self.qualifiers,
            "times": "*count" if self.many else "",
            "lanes": f"*{self.macro}_LANES" if self.many else "",
            "lanes_each": LANES,
            "n": entries_of_state(package),
            "joints": len(package.axes),
            "base": package.base,
            "at_q": "x" if package.base else "q",
            "at_v": "v" if package.base else "qd",
            "motors": self._motors_in_q(),
            "driven": len(package.motor_names),
            "external": package.external,
            "dependent": len(package.dependent or ()) if package.takes_dependent else 0,
            "steps": self.steps,
            "rates": [(variant, self._rate_head(variant)) for variant in variants],
            "sizes": {suffix: f.results[0].entries for suffix, f in factors.items() if f},
            "zero": literal.number(Fraction(0)),
            "one": literal.number(Fraction(1)),
            "half": literal.number(Fraction(1, 2)),
            "constants": self.constants,
            "preparing": self.call.preparing(),
            "call": self.call,
            "sum": sum_of,
            "last_row": self._last_row,
            "has_dense": any(method.kind == "rosenbrock" for method in self.methods),
        }

    def _motors_in_q(self) -> list[int]:
        """The entries of the motors in the state; empty where some own none."""
        first = entries_of_state(self.package) - len(self.package.axes)
        return [first + k for k in self.package.motors] if self.package.has_motors_in_q else []

    def _rate_head(self, variant: Variant) -> str:
        """The head of the function that computes accelerations; motors on prescribed motions are put in their place."""
        state = self.precision.state
        driven = variant.right_side == "inverse_dynamics"
        moved = [Array(state, "q", "", 0, driven), Array(state, "qd", "", 0, driven or bool(self.package.base))]
        given = [Array(state, name, "", 0) for name in (*rows_of_nodes(variant, self.package), *variant.of_step)]
        dependent = [Array(state, "q_dep", "", 0), Array(state, "stage_dep", "", 0, True)]
        turned = [Array(state, one.name, "", 0) for one in self.package.base[:1]]
        arrays = [*moved, *given, *(dependent if self.package.takes_dependent else []), *turned, self.p]
        arrays += [*([self._constants] if self.constants else []), Array(state, "qdd", "", 0, True)]
        count = ["size_t count"] if self.many else []
        name = f"{self.qualifiers.rate}void {self.prefix}_rate{variant.suffix}{'_lanes' if self.many else ''}"
        return with_arguments(name, [*count, *(a.pointer() for a in arrays)])

    def _last_row(self, method: MethodText, variant: Variant) -> str:
        """The place of the row of the last node."""
        offset = (len(method.nodes_of(variant)) - 1) * len(self.package.motor_names)
        return f"{offset}U{'*count' if self.many else ''} + " if offset else ""


def sum_of(terms: Terms, array: str) -> str:
    """Return the sum of coefficients times the entries i of the stages."""
    text = ""
    for number, (x, stage) in enumerate(terms):
        sign = "-" if x.startswith("-") else "+" if number else ""
        text += f"{f' {sign} ' if number else sign}{x.removeprefix('-')}*{array}[{stage}][i]"
    return text


def _comment(method: MethodText, variant: Variant, with_error: bool, package: Package) -> Iterator[str]:
    yield f"One step h [s] of the {method.title}{variant.words}."
    rows, times = ", ".join(rows_of_nodes(variant, package)), ", ".join(method.times(variant))
    yield f"{rows}: a row for each of the times {times}"
    if method.kind == "rosenbrock":
        yield from (f"{name}: {RATES[name]}" for name in variant.of_rate)
    yield f"{', '.join(('q', 'qd', *(one.name for one in package.base)))}: the state, at t when called, at t + h then"
    if with_error:
        yield f"-> error: {error_meaning(package)}"
