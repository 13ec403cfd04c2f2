"""Calls in time steps in C: of the models, and of the functions that steps are made of."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from symoro_elastic.codegen.c_function import CFunction
from symoro_elastic.codegen.c_lines import INDENT, with_arguments
from symoro_elastic.codegen.package import Package
from symoro_elastic.codegen.time_steps import (
    MOTOR_COORDINATES,
    WRENCH,
    MethodText,
    Variant,
    entries_of_state,
    rows_of_nodes,
)


class StepCalls:
    """Lines of calls on one state or, with `many`, on `count` states side by side.

    On one state what depends on parameters only is computed before, for all functions side by side in `c`.
    """

    def __init__(
        self,
        package: Package,
        prefix: str,
        functions: Mapping[str, CFunction],
        methods: Sequence[MethodText],
        many: bool,
    ) -> None:
        """`functions` are the models by name, `methods` those whose steps are written."""
        self.package, self.prefix, self.functions, self.many = package, prefix, functions, many
        self.offsets: dict[str, int] = {}
        self.constants = 0
        for name in functions_of(methods, package):
            size = len(functions[name].constants) if name in functions and not many else 0
            if size:
                self.offsets[name] = self.constants
                self.constants += size

    def preparing(self) -> list[str]:
        """Return the calls that compute what depends on parameters only."""
        return [f"{INDENT}{self.functions[f].name}_prepare(p, {self._place(f)});" for f in self.offsets]

    def accelerations(self, variant: Variant) -> str:
        """Return the call of the right side for the accelerations `qdd`."""
        driven = variant.right_side == "inverse_dynamics"
        given = "ydd" if driven else "torque" if variant.of_step else "tau"
        on_base = ["turned", "qd", WRENCH] if self.package.base else []
        found = [*(["tau"] if driven else []), self._joints("qdd"), *(["V0d"] if self.package.base else [])]
        return self._model(variant.right_side, [*self._stage_position, self._joints("qd"), given, *on_base], found)

    def motors(self) -> str:
        """Return the call that gives positions and velocities of motors on dependent joints."""
        return self._model(MOTOR_COORDINATES, [*self._stage_position, "qd"], ["q_motor", "qd_motor"])

    @property
    def _stage_position(self) -> list[str]:
        return [self._joints("q"), *(["stage_dep"] if self.package.takes_dependent else [])]

    def displacement(self, x: str) -> str:
        """Return the call that finds how far a floating base is from its pose at the start of the step."""
        orientation = self.package.base[0].name
        return self._model("base_displacement", [orientation, x], [f"{orientation}_change", "P0_change"])

    def base_rates(self) -> str:
        """Return the call that finds the rates of the coordinates and of the velocity of a floating base."""
        return self._model("base_rates", ["q", "qd", "V0d"], ["x0d", "qdd"])

    def prepares_rate(self, variant: Variant) -> bool:
        """Return whether something that the accelerations need depends on parameters only."""
        needed = {variant.right_side, *(["assemble"] if self.package.takes_dependent else [])}
        needed |= {MOTOR_COORDINATES} if variant.of_step and not self.package.has_motors_in_q else set()
        return not needed.isdisjoint(self.offsets)

    def assemble(self) -> str:
        """Return the call that closes the loops, from the last position."""
        return self._model("assemble", ["q", "q_dep"], ["stage_dep", "residual"])

    def linearization(self) -> str:
        """Return the call of the linear model at the start of a step."""
        return self._model("linearization", [*self._stage_position, "qd", "qdd"], ["M", "D", "K"])

    def factors(self, variant: Variant) -> str:
        """Return the call that factors the system of an implicit step."""
        position = ["q", "q_dep"] if self.package.takes_dependent else ["q"]
        return self._model(f"implicit_factors{variant.suffix}", [*position, "qd", "g", *variant.of_step], ["factors"])

    def solve(self, variant: Variant, z_q: str, z_v: str, depth: int = 1) -> str:
        """Return the call that solves it, for the right side `v_s`, `qdd`."""
        return self._model(f"implicit_solve{variant.suffix}", ["factors", "v_s", "qdd"], [z_q, z_v], depth)

    def rate(self, variant: Variant, node: int, qdd: str, depth: int = 1) -> str:
        """Return the call that computes the accelerations of the stage at a node, at `q_s`, `v_s`."""
        rows = [self._from(row, node * size) for row, size in rows_of_nodes(variant, self.package).items()]
        dependent = ["q_dep", "stage_dep"] if self.package.takes_dependent else []
        turned = [self.package.base[0].name] if self.package.base else []
        others = [*variant.of_step, *dependent, *turned, "p", *(["c"] if self.constants else [])]
        arrays = ["q_s", "v_s", *rows, *others, qdd]
        head = f"{INDENT * depth}{self.prefix}_rate{variant.suffix}"
        return with_arguments(f"{head}_lanes" if self.many else head, [*self._count, *arrays], ");")

    def _joints(self, array: str) -> str:
        """Return the place of the joints in an array of the whole state, after a floating base."""
        return self._from(array, entries_of_state(self.package) - len(self.package.axes))

    def _from(self, array: str, offset: int) -> str:
        """Return the place of an entry in an array."""
        return f"&{array}[{offset}U{'*count' if self.many else ''}]" if offset else array

    @property
    def _count(self) -> list[str]:
        return ["count"] if self.many else []

    def _model(self, function: str, inputs: Sequence[str], results: Sequence[str], depth: int = 1) -> str:
        prepared = function in self.offsets
        suffix = "_batch" if self.many else "_prepared" if prepared else ""
        head = f"{INDENT * depth}{self.functions[function].name}{suffix}"
        c = [self._place(function)] if prepared else []
        return with_arguments(head, [*self._count, *inputs, "p", *c, *results], ");")

    def _place(self, function: str) -> str:
        return f"&c[{self.offsets[function]}U]" if self.offsets[function] else "c"


def functions_of(methods: Sequence[MethodText], package: Package) -> list[str]:
    """Return the names of the models that steps call."""
    found = dict.fromkeys(variant.right_side for method in methods for variant in method.variants)
    if any(method.kind == "rosenbrock" for method in methods):
        found["linearization"] = None
    implicit = [method for method in methods if method.kind in ("w", "midpoint")]
    for variant in dict.fromkeys(variant for method in implicit for variant in method.variants):
        found |= dict.fromkeys((f"implicit_factors{variant.suffix}", f"implicit_solve{variant.suffix}"))
    of_motors = [] if package.has_motors_in_q else [MOTOR_COORDINATES]
    return [*found, "assemble", *of_motors, "base_displacement", "base_rates"]
