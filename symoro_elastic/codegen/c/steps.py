"""Time steps in C: data of the templates of a header and a source."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from symoro_elastic.codegen.c.function import Array, CFunction
from symoro_elastic.codegen.c.lines import INDENT, with_arguments, wrap_lines
from symoro_elastic.codegen.integration.tableaus import METHODS
from symoro_elastic.codegen.package import EXTERNAL, Package
from symoro_elastic.codegen.precision import Precision
from symoro_elastic.codegen.templates import render
from symoro_elastic.codegen.time_steps import (
    CLOSED,
    DRIVES,
    EXTERNAL_RATE,
    LOAD,
    MOTOR_COORDINATES,
    PASSED,
    RATES,
    WRENCH,
    Literals,
    MethodText,
    Terms,
    Variant,
    blocks_carried,
    entries_of_state,
    error_meaning,
    given_to_factors,
    loads_of,
    method_text,
    rows_of_nodes,
    settling_of,
    states_carried,
)

LENGTHS = {"n": "JOINTS", "m": "MOTORS", "d": "DEPENDENT"}
"""Macros of the lengths of blocks, by the axis that their entries follow."""
LANES = 16
"""States of a batch that are stepped together."""


@dataclass(frozen=True)
class Qualifiers:
    """Prefixes of C definitions: of public functions, static functions, the acceleration function, and data."""

    public: str = ""
    static: str = "static "
    rate: str = "static "
    data: str = "static "


PLAIN_C = Qualifiers()


@dataclass(frozen=True)
class StepText:
    """A time step in C: comment, head and call of its working function, prototypes, arrays read and written."""

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
    states: int

    @property
    def title(self) -> str:
        """Title of the method and variant, as a sentence."""
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
        methods = [method_text(METHODS[name], package, precision) for name in package.steps]
        self.methods = [method for method in methods if not (many and method.kind == "rosenbrock")]
        self.prefix = package.name + precision.suffix
        self.macro = self.prefix.upper()
        self.call = StepCalls(package, self.prefix, self.by_name, self.methods, many)
        self.steps = [self._step(method, *step) for method in self.methods for step in method.steps]

    def source(self) -> str:
        """Return the definitions; empty without steps."""
        return render("c/steps.c.j2", **self._context()) if self.methods else ""

    @property
    def constants(self) -> int:
        """Number of parameter-only values."""
        return self.call.constants

    @property
    def nodes(self) -> dict[str, int]:
        """Number of rows of motor inputs of a step, by method."""
        return {method.name: len(method.nodes) for method in self.methods}

    def _step(self, method: MethodText, variant: Variant, with_error: bool) -> StepText:
        name = f"{self.prefix}_step_{method.name}{variant.suffix}{'_error' if with_error else ''}"
        read, written = tuple(self._read(method, variant)), tuple(self._written(variant, with_error))
        c = [self._constants] if self.constants else []
        plain, prepared = self._parameters(read, [self.p], written), self._parameters(read, [self.p, *c], written)
        many = ["size_t count", *self._pointers(read, written)]
        arguments = [*(a.name for a in read), "h", "p", *(a.name for a in (*c, *written))]
        heads = [
            with_arguments(f"void {name}", plain),
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
            states=states_carried(variant, self.package),
        )

    def _parameters(self, read: Sequence[Array], constant: Sequence[Array], written: Sequence[Array]) -> list[str]:
        arrays = [*constant, *written]
        return [*(a.declared() for a in read), f"{self.precision.state} h", *(a.declared() for a in arrays)]

    def _pointers(self, read: Sequence[Array], written: Sequence[Array]) -> list[str]:
        arrays = [self.p, *written]
        return [*(a.pointer() for a in read), f"{self.precision.state} h", *(a.pointer() for a in arrays)]

    def _read(self, method: MethodText, variant: Variant) -> Iterator[Array]:
        """Input arrays of a step: rows for the nodes, gains, and rates of inputs."""
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

    def _written(self, variant: Variant, with_error: bool) -> Iterator[Array]:
        """Output arrays of a step: the state, and the difference from the embedded method."""
        state, sizes = self.precision.state, {x: f"{self.macro}_{word}" for x, word in LENGTHS.items()}
        for block in blocks_carried(variant, self.package):
            yield Array(state, block.name, sizes.get(block.quantity.follows, str(block.size)), block.size, True)
        if with_error:
            states = states_carried(variant, self.package)
            size = 2 * entries_of_state(self.package) + states
            size_name = f"2*{self.macro}_JOINTS" + (f" + {states}" if states else "")
            yield Array(state, "error", str(size) if self.package.base else size_name, size, True)

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
            "dependent": sum(block.size for block in package.assembled),
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
            "loads": settling_of(package, literal),
            "arithmetic": self.precision.state if self.precision.is_pair else self.precision.real,
            "has_dense": any(method.kind == "rosenbrock" for method in self.methods),
        }

    def _motors_in_q(self) -> list[int]:
        """Indices of the motors in the state; empty if some motors are dependent."""
        first = entries_of_state(self.package) - len(self.package.axes)
        return [first + k for k in self.package.motors] if self.package.has_motors_in_q else []

    def _rate_head(self, variant: Variant) -> str:
        """Head of the C function that computes accelerations, with prescribed motor states as outputs."""
        state = self.precision.state
        driven = variant.right_side == "inverse_dynamics"
        moved = [Array(state, "q", "", 0, driven), Array(state, "qd", "", 0, driven or bool(self.package.base))]
        inputs = [Array(state, name, "", 0) for name in (*rows_of_nodes(variant, self.package), *variant.of_step)]
        written = (*self.call.stage, LOAD)
        fixed = [Array(state, name, "", 0, name in written) for name in self.call.held]
        has_states = bool(states_carried(variant, self.package))
        z, zd = ([Array(state, name, "", 0, name == "zd")] if has_states else [] for name in ("z", "zd"))
        arrays = [*moved, *z, *inputs, *fixed, self.p]
        arrays += [*([self._constants] if self.constants else []), Array(state, "qdd", "", 0, True), *zd]
        count = ["size_t count"] if self.many else []
        name = f"{self.qualifiers.rate}void {self.prefix}_rate{variant.suffix}{'_lanes' if self.many else ''}"
        return with_arguments(name, [*count, *(a.pointer() for a in arrays)])

    def _last_row(self, method: MethodText, variant: Variant) -> str:
        """C offset of the row of the last node."""
        offset = (len(method.nodes_of(variant)) - 1) * len(self.package.motor_names)
        return f"{offset}U{'*count' if self.many else ''} + " if offset else ""


def sum_of(terms: Terms, array: str) -> str:
    """Return the text of the sum of coefficients times the entries i of the stages."""
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
    moved = [block.name for block in blocks_carried(variant, package) if block not in package.assembled]
    yield f"{', '.join(moved)}: the state, at t when called, at t + h then"
    if states := states_carried(variant, package):
        yield from textwrap.wrap(f"z: {', '.join(package.states[:states])}", 100)
    if with_error:
        yield f"-> error: {error_meaning(package, states_carried(variant, package))}"


class StepCalls:
    """Writer of C calls on one state or, with `many`, on `count` states side by side.

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
        """Prepare the calls; `functions` are the models by name, `methods` those whose steps are generated."""
        self.package, self.prefix, self.functions, self.many = package, prefix, functions, many
        self.position = ["q", *(block.name for block in package.assembled)]
        self.stage = ["stage_dep" for _ in package.assembled]
        self.held = [*self.position[1:], *self.stage, *(block.name for block in package.base[:1])]
        self.held += [LOAD] if loads_of(package) else []
        """Arrays that a stage needs in addition to its own state, and the loads that it computes."""
        self.offsets: dict[str, int] = {}
        self.constants = 0
        for name in functions_of(methods, package):
            size = len(functions[name].constants) if name in functions and not many else 0
            if size:
                self.offsets[name] = self.constants
                self.constants += size

    def preparing(self) -> list[str]:
        """Return the calls that compute parameter-only values."""
        return [f"{INDENT}{self.functions[f].name}_prepare(p, {self._place(f)});" for f in self.offsets]

    def accelerations(self, variant: Variant, depth: int = 1) -> str:
        """Return the call of the right-hand side, which computes the accelerations `qdd`."""
        inputs = ["ydd"] if variant.is_driven else ["torque"] if variant.of_step else ["tau"]
        inputs = list(DRIVES.of_nodes) if variant.right_side == CLOSED else inputs
        z, zd = (["z"], ["zd"]) if states_carried(variant, self.package) else ([], [])
        on_base = ["turned", "qd", WRENCH] if self.package.base else []
        results = [*(["tau"] if variant.is_driven else []), self._joints("qdd"), *zd]
        results += ["tau_m"] if variant.right_side == CLOSED else []
        results += ["V0d"] if self.package.base else []
        return self._under_forces(variant.right_side, [self._joints("qd"), *z, *inputs, *on_base], results, depth)

    def load_calls(self, variant: Variant) -> str:
        """Return the calls of an iteration for the transmitted torques, to follow the call of the right-hand side."""
        tau = "tau_m" if variant.right_side == CLOSED else "torque" if variant.of_step else "tau"
        arrays = {"q": self._joints("q"), "q_dep": "stage_dep", "qd": self._joints("qd"), "qdd": self._joints("qdd")}
        arrays |= {"tau": tau}
        inputs = [arrays.get(argument.name, argument.name) for argument in self.functions[PASSED].function.arguments]
        settle = [*(self._count or ["1U"]), "number", "passed", "terms", "before", LOAD, "&changing"]
        settling = with_arguments(f"{INDENT * 2}{self.prefix}_settle", settle, ");")
        return f"{self._model(PASSED, inputs, ['passed', 'terms'], 2)}\n{settling}"

    def motors(self) -> str:
        """Return the call that computes positions and velocities of motors on dependent joints."""
        return self._model(MOTOR_COORDINATES, [*self._stage_position, "qd"], ["q_motor", "qd_motor"])

    @property
    def _stage_position(self) -> list[str]:
        return [self._joints("q"), *self.stage]

    def displacement(self, x: str) -> str:
        """Return the call that computes the displacement of the base from its pose at the start of the step."""
        orientation = self.package.base[0].name
        return self._model("base_displacement", [orientation, x], [f"{orientation}_change", "P0_change"])

    def base_rates(self) -> str:
        """Return the call that computes the rates of the base's coordinates and velocity."""
        return self._model("base_rates", ["q", "qd", "V0d"], ["x0d", "qdd"])

    def prepares_rate(self, variant: Variant) -> bool:
        """Return whether a model that the accelerations need has parameter-only values."""
        needed = {variant.right_side, PASSED, *("assemble" for _ in self.stage)}
        needed |= {MOTOR_COORDINATES} if variant.of_step and not self.package.has_motors_in_q else set()
        return not needed.isdisjoint(self.offsets)

    def assemble(self) -> str:
        """Return the call that closes the loops, starting from the last position."""
        return self._model("assemble", self.position, [*self.stage, "residual"])

    def linearization(self) -> str:
        """Return the call of the linear model at the start of a step."""
        return self._under_forces("linearization", ["qd", "qdd"], ["M", "D", "K"])

    def factors(self, variant: Variant) -> str:
        """Return the call that factorizes the linear system of an implicit step."""
        name = f"implicit_factors{variant.suffix}"
        z = ["z"] if any(a.name == "z" for a in self.functions[name].function.arguments) else []
        inputs = [*given_to_factors(variant, self.package), *self._load(name)]
        return self._model(name, [*self.position, "qd", *z, "g", *inputs], ["factors"])

    def solve(self, variant: Variant, z_q: str, z_v: str, z_z: str = "", depth: int = 1) -> str:
        """Return the call that solves the system for `v_s`, `qdd`, `zd`; state rates are stored in `z_z`."""
        side, found = (["zd"], [z_z]) if states_carried(variant, self.package) else ([], [])
        sides = ["factors", "v_s", "qdd", *side]
        return self._model(f"implicit_solve{variant.suffix}", sides, [z_q, z_v, *found], depth)

    def rate(
        self, variant: Variant, node: int, qdd: str, depth: int = 1, forces: str = EXTERNAL, zd: str = "zd"
    ) -> str:
        """Return the call that computes the accelerations of a stage at `q_s`, `v_s` with the inputs of a node."""
        sizes = rows_of_nodes(variant, self.package)
        rows = [self._from(forces if row == EXTERNAL else row, node * size) for row, size in sizes.items()]
        constant = [*variant.of_step, *self.held, "p", *(["c"] if self.constants else [])]
        z, rates = (["z_s"], [zd]) if states_carried(variant, self.package) else ([], [])
        arrays = ["q_s", "v_s", *z, *rows, *constant, qdd, *rates]
        head = f"{INDENT * depth}{self.prefix}_rate{variant.suffix}"
        return with_arguments(f"{head}_lanes" if self.many else head, [*self._count, *arrays], ");")

    def _under_forces(self, function: str, inputs: Sequence[str], results: Sequence[str], depth: int = 1) -> str:
        """Return the call of a model at the position of a stage, with the wrenches on frames if it has them."""
        forces = [EXTERNAL] if any(a.name == EXTERNAL for a in self.functions[function].function.arguments) else []
        return self._model(function, [*self._stage_position, *inputs, *forces, *self._load(function)], results, depth)

    def _load(self, function: str) -> list[str]:
        """Return the argument for transmitted torques, if a model has it."""
        return [LOAD] if any(a.name == LOAD for a in self.functions[function].function.arguments) else []

    def _joints(self, array: str) -> str:
        """Return the C address of the joints' part of an array of the full state, after the base."""
        return self._from(array, entries_of_state(self.package) - len(self.package.axes))

    def _from(self, array: str, offset: int) -> str:
        """Return the C address of an entry of an array."""
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
    names = dict.fromkeys(variant.right_side for method in methods for variant in method.variants)
    if any(method.kind == "rosenbrock" for method in methods):
        names["linearization"] = None
    implicit = [method for method in methods if method.kind in ("w", "midpoint")]
    for variant in dict.fromkeys(variant for method in implicit for variant in method.variants):
        names |= dict.fromkeys((f"implicit_factors{variant.suffix}", f"implicit_solve{variant.suffix}"))
    of_motors = [] if package.has_motors_in_q else [MOTOR_COORDINATES]
    return [*names, "assemble", *of_motors, "base_displacement", "base_rates", PASSED]


# Functions of C that carry out many time steps, one after another.
@dataclass(frozen=True)
class Run:
    """A C function that carries out many steps: input arrays with their lengths per step, and output arrays.

    Arrays that are `kept` are the same for all steps. `head` and `call` are those of the function and of its steps.
    """

    name: str
    read: dict[str, int]
    kept: tuple[str, ...]
    written: dict[str, int]
    head: str
    call: str


def runs(text: CSteps) -> list[Run]:
    """Return the functions that carry out many steps, by method and variant."""
    return [_run(step, bool(text.constants)) for step in text.steps if not step.with_error]


def _run(step: StepText, prepared: bool) -> Run:
    read, written = ({array.name: array.entries for array in arrays} for arrays in (step.read, step.written))
    constant = [f"const double *{name}" for name in read]
    states = [f"double *{name}" for name in written]
    head = [*("size_t steps", *constant, "double h", "const double *p", *states), "double *record"]
    constant_rows = step.variant.of_step
    rows = [name if name in constant_rows else f"{name} + s*{size}U" for name, size in read.items()]
    call = [*rows, "h", "p", *(["c"] if prepared else []), *written]
    name = f"{step.name}_prepared" if prepared else step.name
    return Run(
        name=step.name,
        read=read,
        kept=constant_rows,
        written=written,
        head=with_arguments(f"void {step.name}_run", head),
        call=with_arguments(f"{INDENT * 2}{name}", call, ");"),
    )


def render_runs(name: str, text: CSteps) -> dict[str, str]:
    """Return the file of the functions that carry out many steps of a package, in double precision."""
    run_text = render("c/run.c.j2", name=name, macro=text.macro, constants=text.constants, runs=runs(text))
    return {f"{name}_run.c": wrap_lines(run_text)}
