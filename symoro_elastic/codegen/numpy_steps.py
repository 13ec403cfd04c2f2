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
    """A numpy function for a time step: method and variant, head, docstring, and the texts of calls in its body."""

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
        """Argument text of a call: the position at the start of the step."""
        return ", ".join(("q", *self.assembled))

    def forces(self, function: str, node: str) -> str:
        """Argument text of a call: the wrenches on frames at a node, if the function takes them."""
        more = self.more if function != "linearization" else ""
        forces = f", {EXTERNAL}[..., {node}, :]{more}" if function in self.takes_forces else ""
        return f"{forces}, {LOAD}" if function in self.takes_loads else forces

    @property
    def more(self) -> str:
        """Text of the term that methods with exact derivatives add to the wrenches on frames."""
        return " + more" if self.method.kind == "rosenbrock" and EXTERNAL in self.variant.of_nodes else ""

    @property
    def stage_position(self) -> str:
        """Argument text of a call: the position of a stage."""
        return ", ".join(("q", *("dependent" for _ in self.assembled)))

    @property
    def on_base(self) -> str:
        """Argument text of a dynamic model's call for the base."""
        return f", turned, V0, {WRENCH}[..., node, :]" if self.base else ""

    @property
    def z(self) -> str:
        """Argument text for the states of friction and drives."""
        return ", z" if self.states else ""

    @property
    def taker(self) -> str:
        """Name of the function that implements this kind of method."""
        if not self.states:
            return self.method.kind
        return "with_states" if self.method.kind == "explicit" else "w_with_states"

    @property
    def motor_arguments(self) -> str:
        """Argument text of a dynamic model's call for motors at a node, after positions and velocities."""
        names = self.variant.of_nodes if self.variant.right_side == CLOSED else ("tau",)
        return ", ".join(f"{name}[..., node, :]" for name in names if name != EXTERNAL)

    @property
    def rate_results(self) -> str:
        """Names that receive the results of a dynamic model; torques first if friction loads need them."""
        torques = [self.torques if self.loads else "_"] if self.variant.right_side == CLOSED else []
        driving = [self.torques] if self.variant.is_driven and self.loads else []
        results = [*driving, "qdd", *(["zd"] if self.states else []), *torques]
        return ", ".join([*results, *(["V0d"] if self.base else [])])

    @property
    def without_torques(self) -> str:
        """Index text that selects the needed results of the inverse model."""
        if self.loads:
            return ""
        return "[1:]" if self.base or self.states else "[1]"

    @property
    def torques(self) -> str:
        """Expression text of the motor torques in a stage."""
        if self.variant.right_side == CLOSED:
            return "tau_m"
        return "torque" if self.variant.of_step else "tau" if self.variant.is_driven else "tau[..., node, :]"

    @property
    def load_call(self) -> str:
        """Call text of the model of transmitted torques, in a stage."""
        arguments = {"q_dep": "dependent", "tau": self.torques}
        return f"{PASSED}({', '.join([*(arguments.get(name, name) for name in self.of_passed), 'p'])})"

    @property
    def carried_state(self) -> str:
        """Names of the positions and velocities that the method integrates."""
        return ("x, v" if self.base else "q, qd") + self.z

    @property
    def state(self) -> str:
        """Expressions of the state that the step returns."""
        ends = dict.fromkeys(self.assembled, f"assemble({self.position}, p)[0]")
        ends |= {name: f"{name} + {change}" for name, change in zip(self.base, ("turned", "moved"), strict=False)}
        return ", ".join(ends.get(name, name) for name in self.blocks)


@dataclass(frozen=True)
class NumpyMethod:
    """A method: its texts, its coefficients as source by name, and its step functions."""

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
    """Argument text for the states of friction in the factorization of an implicit step."""
    named = (f for f in package.functions if f.name == f"implicit_factors{variant.suffix}")
    sizes = [a.size for f in named for a in f.arguments if a.name == STATES]
    return f", z[..., :{sizes[0]}]" if sizes else ""


def _of_friction(argument: Argument) -> str:
    """Argument text: for the states it selects those of friction, which come first; else the argument's name."""
    return f"{STATES}[..., :{argument.size}]" if argument.name == STATES else argument.name


def _gains(variant: Variant, package: Package) -> str:
    """Argument text of the factorization: gains, or set points and torques at t."""
    at_t = "" if variant.of_step else "[..., 0, :]"
    load = f", {LOAD}" if f"implicit_factors{variant.suffix}" in _taking(LOAD, package) else ""
    return "".join(f", {name}{at_t}" for name in given_to_factors(variant, package)) + load


def _taking(argument: str, package: Package) -> frozenset[str]:
    """Names of the functions that have an argument of this name."""
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
    """Source of the coefficient tables of a method by name: stages, coefficients, weights."""
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
    """Source of a list of coefficients, up to the last that is not zero."""
    coefficients = {j: x for x, j in terms}
    return f"[{', '.join(coefficients.get(j, '0.0') for j in range(max(coefficients, default=-1) + 1))}]"
