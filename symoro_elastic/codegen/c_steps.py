"""Time steps in C: what the templates of a header and a source are given."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from symoro_elastic.codegen.c_function import CFunction
from symoro_elastic.codegen.c_lines import INDENT, fitted, with_arguments
from symoro_elastic.codegen.package import Package
from symoro_elastic.codegen.precision import Precision
from symoro_elastic.codegen.templates import render
from symoro_elastic.codegen.time_steps import Calls, Literals, MethodText, Variant, functions_of, method_text
from symoro_elastic.integration.methods import METHODS

LANES = 16
"""States of a batch that take a step side by side."""


@dataclass(frozen=True)
class StepFunction:
    """A function for users in a header: its comment, its prototypes."""

    comment: str
    prototypes: tuple[str, ...]


@dataclass(frozen=True)
class Run:
    """A function that carries out many steps: arrays that are read, each with its length for a step, and written ones.

    Arrays that are `kept` are the same for all steps.
    """

    name: str
    read: dict[str, int]
    kept: tuple[str, ...]
    written: dict[str, int]


class CSteps:
    """The time steps of a package in C, on one state or, with `many`, on batches."""

    def __init__(
        self, package: Package, precision: Precision, functions: Sequence[CFunction], many: bool = False
    ) -> None:
        self.package, self.precision, self.many = package, precision, many
        self.by_name = {function.function.name: function for function in functions}
        literal = Literals(precision)
        self.zero, self.half = literal.number(Fraction(0)), literal.number(Fraction(1, 2))
        made = [method_text(METHODS[name], package, precision) for name in package.steps]
        self.methods = [method for method in made if not (many and method.kind == "rosenbrock")]
        names = {name: function.name for name, function in self.by_name.items()}
        used = functions_of(self.methods)
        constants = {name: len(f.constants) for name, f in self.by_name.items() if name in used}
        self.call = Calls(names, constants, "count" if many else "")
        self.prefix = package.name + precision.suffix
        self.macro = self.prefix.upper()

    def source(self) -> str:
        """Return the definitions; empty where no steps are asked for."""
        return render("c/steps.c.j2", **self._context()) if self.methods else ""

    def header(self) -> list[StepFunction]:
        """Return the functions for users."""
        return [
            StepFunction(self._comment(method, variant, with_error), self._prototypes(method, variant, with_error))
            for method in self.methods
            for variant in method.variants
            for with_error in self._errors(method)
        ]

    @property
    def constants(self) -> int:
        """How many numbers depend on parameters only."""
        return self.call.total

    @property
    def nodes(self) -> dict[str, int]:
        """How many rows of torques a step takes, by method."""
        return {method.name: len(method.nodes) for method in self.methods}

    def _context(self) -> dict[str, Any]:
        package = self.package
        used = list(dict.fromkeys(variant for method in self.methods for variant in method.variants))
        factors = {v.suffix: self.by_name.get(f"implicit_factors{v.suffix}") for v in used}
        return {
            "name": self.prefix,
            "macro": self.macro,
            "state": self.precision.state,
            "real": self.precision.type_of_real(package.name),
            "many": self.many,
            "n": len(package.axes),
            "motors": package.motors,
            "torques": len(package.motor_names),
            "motor_list": ", ".join(f"{k}U" for k in package.motors),
            "dependent": len(package.dependent or ()) if package.takes_dependent else 0,
            "methods": self.methods,
            "used_variants": used,
            "sizes": {suffix: f.results[0].entries for suffix, f in factors.items() if f},
            "zero": self.zero,
            "half": self.half,
            "constants": self.constants,
            "preparing": self.call.preparing(),
            "call": self.call,
            "step_head": self._core_head,
            "public_head": self._public_head,
            "call_step": self._call_of_core,
            "name_of": self._name,
            "arrays": self._arrays,
            "read_lanes": self._read_lanes,
            "written_lanes": self._written,
            "batch_head": self.batch_head,
            "lanes_each": LANES,
            "has_dense": any(method.kind == "rosenbrock" for method in self.methods),
        }

    def runs(self) -> list[Run]:
        """Return the functions that carry out many steps, for each method and way to give the motors."""
        found = []
        for method in self.methods:
            for variant in method.variants:
                name = self._name(method, variant, False)
                found.append(Run(name, self._arrays(method, variant), variant.of_step, dict(self._written(False))))
        return found

    @staticmethod
    def _errors(method: MethodText) -> list[bool]:
        return [False, True] if method.error else [False]

    def _name(self, method: MethodText, variant: Variant, with_error: bool) -> str:
        return f"{self.prefix}_step_{method.name}{variant.suffix}{'_error' if with_error else ''}"

    def _arrays(self, method: MethodText, variant: Variant) -> dict[str, int]:
        """Sizes of the arrays that are read: rows for the nodes, gains, and the rate of the torques."""
        torques = len(self.package.motor_names)
        found = {name: len(method.nodes) * torques for name in variant.of_nodes}
        found |= dict.fromkeys(variant.of_step, torques)
        return found | ({"taud": torques} if method.kind == "rosenbrock" else {})

    def _read_lanes(self, method: MethodText, variant: Variant) -> list[tuple[str, int]]:
        return [*self._arrays(method, variant).items(), *self._written(False)]

    def _written(self, with_error: bool) -> list[tuple[str, int]]:
        """Names and sizes of the arrays that are written."""
        package, n = self.package, len(self.package.axes)
        dependent = [("q_dep", len(package.dependent or ()))] if package.takes_dependent else []
        return [("q", n), ("qd", n), *dependent, *([("error", 2 * n)] if with_error else [])]

    def _declared(
        self, method: MethodText, variant: Variant, with_error: bool, prepared: bool, sizes: bool
    ) -> list[str]:
        state = self.precision.state
        read = self._arrays(method, variant)
        written = dict(self._written(with_error))
        constant = {"c": self.constants} if prepared else {}

        def array(name: str, size: int, type_: str) -> str:
            return f"{type_} {name}[{size if sizes and size else ''}]" if size else f"{type_} *{name}"

        parameters = len(self.package.parameters)
        return [
            *(array(name, size, f"const {state}") for name, size in read.items()),
            f"{state} h",
            array("p", parameters, f"const {state}"),
            *(
                array(x, size, f"const {self.precision.type_of_real(self.package.name)}")
                for x, size in constant.items()
            ),
            *(array(name, size, state) for name, size in written.items()),
        ]

    def _public_head(self, method: MethodText, variant: Variant, with_error: bool, prepared: bool) -> str:
        name = self._name(method, variant, with_error) + ("_prepared" if prepared else "")
        return with_arguments(f"void {name}", self._declared(method, variant, with_error, prepared, sizes=True))

    def _core_head(self, method: MethodText, variant: Variant, with_error: bool) -> str:
        states = ["size_t count"] if self.many else []
        declared = self._declared(method, variant, with_error, bool(self.constants) and not self.many, sizes=False)
        name = f"{self._name(method, variant, with_error)}_{'lanes' if self.many else 'stages'}"
        return with_arguments(f"void {name}", [*states, *declared])

    def _call_of_core(self, method: MethodText, variant: Variant, with_error: bool) -> str:
        names = [*self._arrays(method, variant), "h", "p", *(["c"] if self.constants else []), "q", "qd"]
        names += ["q_dep"] if self.package.takes_dependent else []
        names += ["error"] if with_error else []
        return with_arguments(f"{INDENT}{self._name(method, variant, with_error)}_stages", names, ");").lstrip()

    def _prototypes(self, method: MethodText, variant: Variant, with_error: bool) -> tuple[str, ...]:
        if self.many:
            return (self.batch_head(method, variant, with_error),)
        heads = [False, True] if self.constants else [False]
        return tuple(self._public_head(method, variant, with_error, prepared) for prepared in heads)

    def batch_head(self, method: MethodText, variant: Variant, with_error: bool) -> str:
        """Return the head of the function for many states."""
        declared = self._declared(method, variant, with_error, False, sizes=False)
        pointers = [
            text
            if "[" not in text
            else f"{text[: text.index('[')].rpartition(' ')[0]} *{text[: text.index('[')].rpartition(' ')[2]}"
            for text in declared
        ]
        return with_arguments(f"void {self._name(method, variant, with_error)}_batch", ["size_t states", *pointers])

    def _comment(self, method: MethodText, variant: Variant, with_error: bool) -> str:
        lines = [f"One step h [s] of the {method.title}{variant.words}."]
        rows = ", ".join(variant.of_nodes)
        lines.append(f"{rows}: a row for each of the times {', '.join(method.times)}")
        if method.kind == "rosenbrock":
            lines.append("taud: derivative of the torques by time at t, that of kp r + kd rd with it")
        lines.append("q, qd: the state, at t when called, at t + h then")
        if with_error:
            lines.append("-> error: difference of q, then of qd, from the embedded method")
        return "\n * ".join(lines)


def render_runs(package: Package, text: CSteps) -> dict[str, str]:
    """Return the file of the functions that carry out many steps, in double precision."""
    made = render("c/run.c.j2", name=package.name, macro=text.macro, constants=text.constants, runs=text.runs())
    return {f"{package.name}_run.c": fitted(made)}
