"""Time steps in Python: what the templates of the target numpy are given."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from symoro_elastic.codegen.c_lines import with_arguments
from symoro_elastic.codegen.package import Package
from symoro_elastic.codegen.precision import DOUBLE
from symoro_elastic.codegen.time_steps import (
    WRENCH,
    MethodText,
    Terms,
    Variant,
    error_meaning,
    method_text,
    rows_of_nodes,
)
from symoro_elastic.integration.methods import METHODS


@dataclass(frozen=True)
class NumpyStep:
    """A function that takes a step: its method and variant, head, docstring, and calls in its body."""

    method: MethodText
    variant: Variant
    with_error: bool
    head: str
    described: tuple[str, ...]
    arrays: str
    takes_dependent: bool
    base: tuple[str, ...]
    needs: str

    @property
    def position(self) -> str:
        """The arguments for the position at the start of the step."""
        return "q, q_dep" if self.takes_dependent else "q"

    @property
    def stage_position(self) -> str:
        """The arguments for the position of a stage."""
        return "q, dependent" if self.takes_dependent else "q"

    @property
    def on_base(self) -> str:
        """The arguments of a dynamic model for a floating base."""
        return f"turned, V0, {WRENCH}[..., node, :], " if self.base else ""

    @property
    def found(self) -> str:
        """The accelerations that a dynamic model finds."""
        return "qdd, V0d" if self.base else "qdd"

    @property
    def carried(self) -> str:
        """The positions and velocities that the method carries."""
        return "x, v" if self.base else "q, qd"

    @property
    def state(self) -> str:
        """The state at the end of the step."""
        dependent = ", assemble(q, q_dep, p)[0]" if self.takes_dependent else ""
        base = f", {self.base[0]} + turned, P0 + moved, V0" if self.base else ""
        return f"q, qd{dependent}{base}"

    @property
    def gains(self) -> str:
        """The gains as further arguments."""
        return "".join(f", {name}" for name in self.variant.of_step)


@dataclass(frozen=True)
class NumpyMethod:
    """A method: its text, its coefficients by name as source, the functions that take its steps."""

    text: MethodText
    tables: dict[str, str]
    steps: tuple[NumpyStep, ...]


def numpy_methods(package: Package) -> list[NumpyMethod]:
    """Return the methods of the time steps of a package."""
    texts = [method_text(METHODS[name], package, DOUBLE) for name in package.steps]
    return [NumpyMethod(text, _tables(text), tuple(_steps(text, package))) for text in texts]


def _steps(method: MethodText, package: Package) -> Iterator[NumpyStep]:
    for variant in method.variants:
        for with_error in (False, True) if method.error else (False,):
            yield _step(method, variant, with_error, package)


def _step(method: MethodText, variant: Variant, with_error: bool, package: Package) -> NumpyStep:
    of_rate = ("taud",) if method.kind == "rosenbrock" else ()
    arrays = [*rows_of_nodes(variant, package), *variant.of_step, *of_rate]
    dependent = ["q_dep"] if package.takes_dependent else []
    base = tuple(one.name for one in package.base)
    name = f"step_{method.name}{variant.suffix}{'_error' if with_error else ''}"
    return NumpyStep(
        method=method,
        variant=variant,
        with_error=with_error,
        head=with_arguments(f"def {name}", [*arrays, "h", "q", "qd", *dependent, *base, "p=DEFAULTS"], "):"),
        described=tuple(_described(method, variant, with_error, package)),
        arrays=", ".join(["h", "q", "qd", *arrays, *base]),
        takes_dependent=package.takes_dependent,
        base=base,
        needs=NEEDS[method.kind],
    )


NEEDS = {
    "explicit": "rate",
    "w": "rate, factors, solve",
    "midpoint": "rate, factors, solve",
    "rosenbrock": "rate, linear, _steps.on_motors(taud, MOTORS, len(JOINTS))",
}
"""The functions that a step of each kind of method calls."""


def _described(method: MethodText, variant: Variant, with_error: bool, package: Package) -> Iterator[str]:
    motors = len(package.motor_names)
    rows, times = ", ".join(variant.of_nodes), ", ".join(method.times)
    yield f"{rows} (..., {len(method.nodes)}, {motors}): a row for each of the times {times}."
    if package.base:
        yield f"f0 (..., {len(method.nodes)}, 6): the wrench on the base at these times, in its axes."
    if variant.of_step:
        yield f"kp, kd ({motors}): gains of the servos."
    if method.kind == "rosenbrock":
        yield f"taud ({motors}): derivative by time of the torques at t, that of kp r + kd rd with it."
    dependent = ", q_dep" if package.takes_dependent else ""
    base = "".join(f", {one.name}" for one in package.base)
    error = f"; {error_meaning(package)}" if with_error else ""
    yield f"-> q, qd{dependent}{base} at t + h{error}"


def _tables(method: MethodText) -> dict[str, str]:
    """Nodes of the stages, coefficients by stage, weights."""
    if method.kind == "midpoint":
        return {"iterations": str(method.iterations)}
    tables = {"stages": str([stage.node for stage in method.stages]), "a": _rows([s.a for s in method.stages])}
    if method.kind != "explicit":
        tables |= {"gamma": method.gamma, "c": _rows([stage.g for stage in method.stages])}
    if method.kind == "rosenbrock":
        tables["gammas"] = str([float(stage.of_rate or 0) for stage in method.stages])
    return tables | {"b": _row(method.b), "error": _row(method.error)}


def _rows(terms: Sequence[Terms]) -> str:
    return "\n        ".join(["[", *(f"{_row(one)}," for one in terms)]) + "\n    ]"


def _row(terms: Terms) -> str:
    """Coefficients up to the last that is not zero."""
    found = {j: x for x, j in terms}
    return f"[{', '.join(found.get(j, '0.0') for j in range(max(found, default=-1) + 1))}]"
