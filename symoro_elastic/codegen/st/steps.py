"""Time steps as function blocks of Structured Text: the operations of C, in its order."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from symoro_elastic.codegen.c.steps import sum_of
from symoro_elastic.codegen.integration.tableaus import METHODS, Rosenbrock
from symoro_elastic.codegen.package import Package, ParameterValue
from symoro_elastic.codegen.precision import DOUBLE
from symoro_elastic.codegen.st.function import StArray, StBlock, StForm, StFunction, parameter_line
from symoro_elastic.codegen.st.lines import INDENT, StNames, call, in_comment, statement
from symoro_elastic.codegen.templates import render
from symoro_elastic.codegen.time_steps import (
    CLOSED,
    MethodText,
    Terms,
    Variant,
    error_meaning,
    loads_of,
    method_text,
    rows_of_nodes,
)
from symoro_elastic.foundation.errors import InputError

KINDS = ("explicit", "w", "midpoint")
"""Supported kinds of methods; those with exact derivatives need dense matrices."""
STATE = ("q", "qd")
"""Blocks of the state of time steps."""
COUNTER = "k"
"""Variable of loops over the entries of the state."""
NOTHING = "(* nothing *)"
"""A line that is removed."""
MEANINGS = {
    "tau": "motor torques or forces",
    "r": "positions that servos hold",
    "rd": "their velocities",
    "y": "prescribed positions of the motors",
    "yd": "their velocities",
    "ydd": "their accelerations",
    "kp": "stiffness of the servos",
    "kd": "damping of the servos",
    "f_ext": "wrenches on frames",
}


def step_blocks(form: StForm, functions: Mapping[str, StFunction], source: str) -> Iterator[StBlock]:
    """Yield the blocks of the time steps of a package; raises `InputError` for unsupported ones."""
    package = form.package
    methods = [method_text(METHODS[name], package, DOUBLE) for name in package.steps]
    _refuse(package, methods, source)
    yield from (StStep(form, functions, method, *step).block() for method in methods for step in method.steps)


def _refuse(package: Package, methods: Sequence[MethodText], source: str) -> None:
    """Raise `InputError` for a method or a machine whose time steps are not supported."""
    exact = [method.name for method in methods if method.kind not in KINDS]
    if exact:
        written = ", ".join(name for name, method in METHODS.items() if not isinstance(method, Rosenbrock))
        what = f"{exact[0]} is not written in Structured Text: {written} are"
        raise InputError(source, "--target st, steps", what)
    why = _why_not(package)
    if methods and why:
        what = f"time steps {why} are not written in Structured Text: leave them out"
        raise InputError(source, "--target st, steps", what)


def _why_not(package: Package) -> str:
    """Feature of a machine that the time steps do not support; empty for a supported machine."""
    if package.base:
        return "on a floating base"
    if loads_of(package):
        return "with friction that rises with load"
    if package.assembled:
        return "of loops without a closed form"
    if any(function.name == CLOSED for function in package.functions):
        return "under drives"
    blocks = [block.name for block in package.state if block.name not in STATE]
    if blocks:
        return f"of a state with {', '.join(blocks)}"
    return "" if package.has_motors_in_q else "with motors on dependent joints"


class StStep:
    """A time step: a method with a variant of motor inputs."""

    def __init__(
        self, form: StForm, functions: Mapping[str, StFunction], method: MethodText, variant: Variant, with_error: bool
    ) -> None:
        """Prepare the step; `functions` are the models of the file, by name."""
        self.form, self.package, self.functions = form, form.package, functions
        self.method, self.variant, self.with_error = method, variant, with_error
        self.n, self.nodes = len(self.package.axes), len(method.nodes_of(variant))
        self.rows = rows_of_nodes(variant, self.package)
        self.name = form.name(f"step_{method.name}{variant.suffix}{'_error' if with_error else ''}")
        self.names = StNames((), self.package.name)
        self.models: dict[str, str] = {}
        self.arrays: dict[str, int] = {}
        self.missing: dict[str, ParameterValue] = {}

    def block(self) -> StBlock:
        """Return the function block of the step."""
        rows = [self._array(name, self.nodes * size, MEANINGS[name]) for name, size in self.rows.items()]
        gains = [self._array(name, len(self.package.motor_names), MEANINGS[name]) for name in self.variant.of_step]
        state = (self._array("q", self.n, "joint variables"), self._array("qd", self.n, "joint velocities"))
        error = [self._array("error", 2 * self.n, error_meaning(self.package))] if self.with_error else []
        h = StArray("h", self.form.type, 1, "length of the step, s")
        text = render("st/step.st.j2", step=self, sum=self.sum, number=self.form.number)
        title, times = self.method.title, ", ".join(self.method.times(self.variant))
        about = (
            f"{title[:1].upper()}{title[1:]}{self.variant.words}.",
            f"{', '.join(self.rows)}: a row for each of the times {times}.",
            "q, qd: the state, at t when called, at t + h then.",
        )
        return StBlock(
            self.name,
            about,
            inputs=(*rows, *gains, h),
            in_outs=state,
            results=tuple(error),
            given=tuple(parameter_line(name, p, self.form) for name, p in self.missing.items()),
            variables=tuple(self._variables()),
            body=tuple(line for line in text.rstrip("\n").split("\n") if line != NOTHING),
        )

    def _array(self, name: str, length: int, meaning: str = "") -> StArray:
        return StArray(self.names.give(name), self.form.array(length), length, in_comment(meaning))

    def _variables(self) -> Iterator[str]:
        for function, name in self.models.items():
            yield f"{INDENT * 2}{name} : {self.functions[function].name};"
        for name, length in self.arrays.items():
            yield f"{INDENT * 2}{name} : {self.form.array(length)};"
        yield f"{INDENT * 2}{COUNTER} : INT;"
        if self.method.kind == "midpoint":
            yield f"{INDENT * 2}iteration : INT;"

    # What the template is written with

    def local(self, name: str, length: int = 0) -> str:
        """Declare a local array of the block, as long as q by default, and return its name."""
        self.arrays.setdefault(name, length or self.n)
        return name

    def sum(self, terms: Terms, array: str) -> str:
        """Return the text of the sum of coefficients times the entries i of the stages."""
        own = tuple((self.form.number(float(x)), stage) for x, stage in terms)
        for _, stage in terms:
            self.local(f"{array}{stage}")
        return sum_of(own, array).replace("[i]", "<i>").replace("[", "").replace("]", "").replace("<i>", f"[{COUNTER}]")

    def each(self, indent: str = INDENT) -> str:
        """Return the head of a loop over q; a loop with one pass is unrolled, as matiec skips it."""
        return f"{indent}FOR {COUNTER} := 0 TO {self.n - 1} DO" if self.n > 1 else f"{indent}{COUNTER} := 0;"

    def end(self, indent: str = INDENT) -> str:
        """Return the end of a loop over q."""
        return f"{indent}END_FOR;" if self.n > 1 else NOTHING

    def advance(self, to: str, start: str, terms: Terms, array: str) -> str:
        """Return the assignment `to` = `start` + h times a sum over stages."""
        change = f" + h*({self.sum(terms, array)})" if terms else ""
        return self.assign(f"{to}[{COUNTER}]", f"{start}[{COUNTER}]{change}")

    def errors(self) -> str:
        """Return the assignments of the error estimate, the difference from the embedded method."""
        terms = self.method.error
        of_q = self.assign(f"error[{COUNTER}]", f"h*({self.sum(terms, 'k_q')})")
        of_v = f"h*({self.sum(terms, 'k_v')})"
        return f"{of_q}\n{self.assign(f'error[{self.n} + {COUNTER}]', of_v)}"

    def assign(self, to: str, value: str, depth: int = 2) -> str:
        """Return the lines of an assignment."""
        return "\n".join(statement(f"{INDENT * depth}{to} := ", value))

    def row(self, name: str, node: int, depth: int) -> tuple[list[str], str]:
        """Return lines that copy an input's row of a node, and the name of the array with the row."""
        size = self.rows[name]
        if self.nodes == 1:
            return [], self.names.give(name)
        row = self.local(f"{name}_row", size)
        array = self.names.give(name)
        return [f"{INDENT * depth}{row}[{k}] := {array}[{node * size + k}];" for k in range(size)], row

    def rate(self, node: int, qdd: str, depth: int = 1) -> str:
        """Return the lines that compute the accelerations of a stage at `q_s`, `v_s` with the inputs of a node."""
        lines: list[str] = []
        rows: dict[str, str] = {}
        for name in self.rows:
            copied, rows[name] = self.row(name, node, depth)
            lines += copied
        arguments = self.functions[self.variant.right_side].function.arguments
        forces = [rows["f_ext"]] if "f_ext" in rows and any(a.name == "f_ext" for a in arguments) else []
        if self.variant.is_driven:
            lines += self.on_prescribed_motion(rows, "q_s", "v_s", depth)
            results = {"qdd": qdd}
            return "\n".join(
                [*lines, *self.call("inverse_dynamics", ["q_s", "v_s", rows["ydd"], *forces], results, depth)]
            )
        torque = rows["tau"]
        if self.variant.of_step:
            torque = self.local("torque", len(self.package.motor_names))
            for k, j in enumerate(self.package.motors):
                value = f"{rows['tau']}[{k}] + {self._gain('kp')}[{k}]*({rows['r']}[{k}] - q_s[{j}])"
                value += f" + {self._gain('kd')}[{k}]*({rows['rd']}[{k}] - v_s[{j}])"
                lines += statement(f"{INDENT * depth}{torque}[{k}] := ", value)
        lines += self.call("direct_dynamics", ["q_s", "v_s", torque, *forces], {"qdd": qdd}, depth)
        return "\n".join(lines)

    def _gain(self, name: str) -> str:
        return self.names.give(name)

    def on_prescribed_motion(self, rows: Mapping[str, str], q: str, qd: str, depth: int = 1) -> list[str]:
        """Return the lines that set positions and velocities of motors to their prescribed values."""
        pairs = [(k, j) for k, j in enumerate(self.package.motors)]
        indent = INDENT * depth
        return [
            line
            for k, j in pairs
            for line in (f"{indent}{q}[{j}] := {rows['y']}[{k}];", f"{indent}{qd}[{j}] := {rows['yd']}[{k}];")
        ]

    def last_motion(self) -> str:
        """Return the lines that set motors to their prescribed states at the end of the step."""
        lines: list[str] = []
        rows: dict[str, str] = {}
        for name in ("y", "yd"):
            copied, rows[name] = self.row(name, self.nodes - 1, 1)
            lines += copied
        return "\n".join([*lines, *self.on_prescribed_motion(rows, "q", "qd")])

    def factors(self) -> str:
        """Return the call that factorizes the linear system of an implicit step for `g`."""
        name = f"implicit_factors{self.variant.suffix}"
        size = self.functions[name].results[0].length
        inputs = ["q", "qd", self.local("g", 1), *map(self._gain, self.variant.of_step)]
        return "\n".join(self.call(name, inputs, [self.local("factors", size)], 1))

    def solve(self, z_q: str, z_v: str, depth: int = 1) -> str:
        """Return the call that solves the linear system of an implicit step for `v_s`, `qdd`."""
        inputs = ["factors", "v_s", self.local("qdd")]
        results = [self.local(z_q), self.local(z_v)]
        return "\n".join(self.call(f"implicit_solve{self.variant.suffix}", inputs, results, depth))

    def call(
        self, function: str, arguments: Sequence[str], results: Sequence[str] | Mapping[str, str], depth: int
    ) -> list[str]:
        """Return the call of a block, and the copies of its results: all in order, or some by name."""
        block = self.functions[function]
        instance = self.models.setdefault(function, self.names.give(function))
        pairs = zip(block.arguments, arguments, strict=True)
        inputs = [f"{array.name} := {value}" for array, value in pairs if array.length]
        for name in block.missing:
            parameter = block.parameters[name]
            own = self.names.give(parameter.name)
            self.missing[own] = parameter
            inputs.append(f"{name} := {own}")
        if not isinstance(results, Mapping):
            results = dict(zip((r.name for r in block.function.results), results, strict=True))
        arrays = {r.name: array for r, array in zip(block.function.results, block.results, strict=True)}
        indent = INDENT * depth
        copies = [
            f"{indent}{self.local(to)} := {instance}.{arrays[name].name};"
            for name, to in results.items()
            if arrays[name].length
        ]
        return [*call(f"{indent}{instance}", inputs), *copies]
