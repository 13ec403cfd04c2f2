"""Time steps in Python: data of the templates of the target numpy."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from symoro_elastic.codegen.c.lines import with_arguments
from symoro_elastic.codegen.integration.tableaus import METHODS
from symoro_elastic.codegen.package import EXTERNAL, Argument, Package
from symoro_elastic.codegen.precision import DOUBLE
from symoro_elastic.codegen.time_steps import (
    CLOSED,
    EXTERNAL_RATE,
    LOAD,
    PASSED,
    RATES,
    STATES,
    WRENCH,
    MethodText,
    Terms,
    Variant,
    blocks_carried,
    error_meaning,
    given_to_factors,
    loads_of,
    method_text,
    rows_of_nodes,
    states_carried,
)


@dataclass(frozen=True)
class NumpyStep:
    """A function for a time step: its method and variant, head, docstring, and calls in its body."""

    method: MethodText
    variant: Variant
    with_error: bool
    name: str
    head: str
    described: tuple[str, ...]
    arrays: str
    blocks: tuple[str, ...]
    assembled: tuple[str, ...]
    takes_forces: frozenset[str]
    takes_loads: frozenset[str]
    base: tuple[str, ...]
    needs: str
    states: int
    z_of_factors: str
    gains: str
    loads: int
    of_passed: tuple[str, ...]

    @property
    def position(self) -> str:
        """The arguments for the position at the start of the step."""
        return ", ".join(("q", *self.assembled))

    def forces(self, function: str, node: str) -> str:
        """The wrenches on frames at a node, as an argument of the models that have it."""
        more = self.more if function != "linearization" else ""
        forces = f", {EXTERNAL}[..., {node}, :]{more}" if function in self.takes_forces else ""
        return f"{forces}, {LOAD}" if function in self.takes_loads else forces

    @property
    def more(self) -> str:
        """The term that methods with exact derivatives add to the wrenches on frames."""
        return " + more" if self.method.kind == "rosenbrock" and EXTERNAL in self.variant.of_nodes else ""

    @property
    def stage_position(self) -> str:
        """The arguments for the position of a stage."""
        return ", ".join(("q", *("dependent" for _ in self.assembled)))

    @property
    def on_base(self) -> str:
        """The arguments of a dynamic model for the base."""
        return f", turned, V0, {WRENCH}[..., node, :]" if self.base else ""

    @property
    def z(self) -> str:
        """States of friction and drives as a further argument."""
        return ", z" if self.states else ""

    @property
    def taker(self) -> str:
        """The function that implements the kind of method."""
        if not self.states:
            return self.method.kind
        return "with_states" if self.method.kind == "explicit" else "w_with_states"

    @property
    def motor_arguments(self) -> str:
        """The motor arguments of a dynamic model at a node, after positions and velocities."""
        names = self.variant.of_nodes if self.variant.right_side == CLOSED else ("tau",)
        return ", ".join(f"{name}[..., node, :]" for name in names if name != EXTERNAL)

    @property
    def rate_results(self) -> str:
        """The results of a dynamic model; torques first where loads need those of driven motors."""
        torques = [self.torques if self.loads else "_"] if self.variant.right_side == CLOSED else []
        driving = [self.torques] if self.variant.is_driven and self.loads else []
        results = [*driving, "qdd", *(["zd"] if self.states else []), *torques]
        return ", ".join([*results, *(["V0d"] if self.base else [])])

    @property
    def without_torques(self) -> str:
        """The index that selects the needed results of the inverse model."""
        if self.loads:
            return ""
        return "[1:]" if self.base or self.states else "[1]"

    @property
    def torques(self) -> str:
        """The torques of motors in a stage."""
        if self.variant.right_side == CLOSED:
            return "tau_m"
        return "torque" if self.variant.of_step else "tau" if self.variant.is_driven else "tau[..., node, :]"

    @property
    def load_call(self) -> str:
        """The call of the model of the torques that are passed, in a stage."""
        arguments = {"q_dep": "dependent", "tau": self.torques}
        return f"{PASSED}({', '.join([*(arguments.get(name, name) for name in self.of_passed), 'p'])})"

    @property
    def carried_state(self) -> str:
        """The positions and velocities that the method carries."""
        return ("x, v" if self.base else "q, qd") + self.z

    @property
    def state(self) -> str:
        """The state at the end of the step."""
        ends = dict.fromkeys(self.assembled, f"assemble({self.position}, p)[0]")
        ends |= {name: f"{name} + {change}" for name, change in zip(self.base, ("turned", "moved"), strict=False)}
        return ", ".join(ends.get(name, name) for name in self.blocks)


@dataclass(frozen=True)
class NumpyMethod:
    """A method: its text, its coefficients as source by name, and the functions of its steps."""

    text: MethodText
    tables: dict[str, str]
    steps: tuple[NumpyStep, ...]


def numpy_methods(package: Package) -> list[NumpyMethod]:
    """Return the methods of the time steps of a package."""
    texts = [method_text(METHODS[name], package, DOUBLE) for name in package.steps]
    return [NumpyMethod(x, _tables(x), tuple(_step(x, *step, package) for step in x.steps)) for x in texts]


def _step(method: MethodText, variant: Variant, with_error: bool, package: Package) -> NumpyStep:
    of_rate = variant.of_rate if method.kind == "rosenbrock" else ()
    arrays = [*rows_of_nodes(variant, package), *variant.of_step, *of_rate]
    blocks = blocks_carried(variant, package)
    state = [block.name for block in blocks]
    name = f"step_{method.name}{variant.suffix}{'_error' if with_error else ''}"
    own = [block.name for block in package.base]
    return NumpyStep(
        method=method,
        variant=variant,
        with_error=with_error,
        name=name,
        head=with_arguments(f"def {name}", [*arrays, "h", *state, "p=DEFAULTS"], "):"),
        described=tuple(_docstring(method, variant, with_error, package)),
        arrays=", ".join(["h", "q", "qd", *arrays, *own, *([STATES] if STATES in state else [])]),
        blocks=tuple(state),
        assembled=tuple(block.name for block in package.assembled),
        takes_forces=_taking(EXTERNAL, package),
        takes_loads=_taking(LOAD, package),
        base=tuple(block.name for block in package.base),
        needs=NEEDS[method.kind],
        states=states_carried(variant, package),
        z_of_factors=_z_of_factors(variant, package),
        gains=_gains(variant, package),
        loads=loads_of(package),
        of_passed=tuple(map(_of_friction, (a for f in package.functions if f.name == PASSED for a in f.arguments))),
    )


def _z_of_factors(variant: Variant, package: Package) -> str:
    """States of friction as a further argument of the factors of an implicit step."""
    named = (f for f in package.functions if f.name == f"implicit_factors{variant.suffix}")
    sizes = [a.size for f in named for a in f.arguments if a.name == STATES]
    return f", z[..., :{sizes[0]}]" if sizes else ""


def _of_friction(argument: Argument) -> str:
    """The states of friction (first of all states), as an argument."""
    return f"{STATES}[..., :{argument.size}]" if argument.name == STATES else argument.name


def _gains(variant: Variant, package: Package) -> str:
    """Gains, or set points and torques at t, as arguments of the factors."""
    at_t = "" if variant.of_step else "[..., 0, :]"
    load = f", {LOAD}" if f"implicit_factors{variant.suffix}" in _taking(LOAD, package) else ""
    return "".join(f", {name}{at_t}" for name in given_to_factors(variant, package)) + load


def _taking(argument: str, package: Package) -> frozenset[str]:
    """Names of the functions with an argument."""
    return frozenset(f.name for f in package.functions if any(a.name == argument for a in f.arguments))


NEEDS = {
    "explicit": "rate",
    "w": "rate, factors, solve",
    "midpoint": "rate, factors, solve",
    "rosenbrock": "rate, linear",
}
"""The functions that implement the kinds of methods."""


def _docstring(method: MethodText, variant: Variant, with_error: bool, package: Package) -> Iterator[str]:
    motors, times = len(package.motor_names), ", ".join(method.times(variant))
    rows = [name for name in variant.of_nodes if name != EXTERNAL]
    nodes = len(method.nodes_of(variant))
    yield f"{', '.join(rows)} (..., {nodes}, {motors}): a row for each of the times {times}."
    if package.external:
        yield f"{EXTERNAL} (..., {nodes}, {package.external}): wrenches on frames in axes of frame 0, the same rows."
    if package.base:
        yield f"f0 (..., {nodes}, 6): the wrench on the base at these times, in its axes."
    if variant.of_step:
        yield f"kp, kd ({motors}): gains of the servos."
    if method.kind == "rosenbrock":
        for name in variant.of_rate:
            yield f"{name} ({package.external if name == EXTERNAL_RATE else motors}): {RATES[name]}."
    states = states_carried(variant, package)
    if states:
        yield f"z (..., {states}): states, in the order of Z_NAMES."
    error = f"; {error_meaning(package, states)}" if with_error else ""
    yield f"-> {', '.join(block.name for block in blocks_carried(variant, package))} at t + h{error}"


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
    return "\n        ".join(["[", *(f"{_row(row)}," for row in terms)]) + "\n    ]"


def _row(terms: Terms) -> str:
    """Coefficients up to the last that is not zero."""
    coefficients = {j: x for x, j in terms}
    return f"[{', '.join(coefficients.get(j, '0.0') for j in range(max(coefficients, default=-1) + 1))}]"
