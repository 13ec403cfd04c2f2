"""Programs: nothing unused, everything in order, counted right, the same everywhere, linear in the machine."""

from __future__ import annotations

import os
import subprocess
import sys
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from pathlib import Path
from typing import Any

import pytest

from symoro_elastic.codegen.body import C, Writer
from symoro_elastic.codegen.printers import Printer
from symoro_elastic.codegen.targets.c import render_c
from symoro_elastic.formats import read_machine
from symoro_elastic.machine.machine import Machine, Parameter
from symoro_elastic.machine.names import why_reserved
from symoro_elastic.machine.scene import ALL, Scene
from symoro_elastic.models.bound.bind import Bound
from symoro_elastic.models.packaging import package, reserved_words
from symoro_elastic.models.programs.catalogue import MODELS, TracedModel, trace, trace_scene
from symoro_elastic.numerics.linear.grouping import grouping_by_rank
from symoro_elastic.numerics.verification.verify import verify
from symoro_elastic.symbolic.arithmetic import RATIONAL, Arithmetic, evaluate
from symoro_elastic.symbolic.expression import Expression, Graph, Level, reachable
from symoro_elastic.symbolic.functions import cosine_sine
from symoro_elastic.symbolic.operations import COSPI, SYMBOL
from symoro_elastic.symbolic.program import (
    MAX_INLINE_DEPTH,
    Input,
    Names,
    OperationCount,
    Output,
    Program,
    Section,
    build,
    by_section,
    rename_variables,
    saving,
)
from tests.counted_calls import calls_of
from tests.generated_code import ALL_MODELS, Assignment, c_functions, c_work, names_in, recount, rendered
from tests.references.random_machines import chain, planar_2r, random_machine, two_children

pytestmark = pytest.mark.sampled(6)

ROOT = Path(__file__).parents[2]
EXAMPLES = ("two_axis.toml", "rx90.par", "puma560.par", "flex4.par", "planar_2r.toml")
FUNCTIONS = {"sin", "cos", "sqrt", "sign", "atan2"}
ARRAYS = {"q", "qd", "tau", "qdd", "qdd_motor", "p", "c", "sine", "cosine"}


def example(name: str) -> Machine:
    return read_machine(ROOT / "examples" / name)[0]


def machines() -> list[Machine]:
    trees = [
        random_machine(seed, joints=2 + seed % 9, symbolic=seed % 2 == 0, moving_base=seed % 3 == 0)
        for seed in range(12)
    ]
    return [*trees, chain(4), planar_2r(elastic=(2,)), two_children(symbolic=True), *map(example, EXAMPLES)]


@dataclass
class Subject:
    """A machine with all its models, traced and printed as C once for all tests."""

    machine: Machine

    @cached_property
    def models(self) -> list[TracedModel]:
        return trace_scene(self.machine, Scene(models=ALL_MODELS), grouping_by_rank)

    @cached_property
    def functions(self) -> dict[str, list[Assignment]]:
        """Functions of the C text, taken apart."""
        text = render_c(package(self.machine, self.models, ()))[f"{self.machine.name}.c"]
        return c_functions(text)

    def text(self, model: str) -> tuple[list[Assignment], list[Assignment]]:
        """Assignments of the C of one model: parameters only, then for each call."""
        return c_work(self.functions, f"{self.machine.name}_{model}")


VARIOUS = [pytest.param(Subject(machine), id=f"{k}-{machine.name}") for k, machine in enumerate(machines())]


# What is printed


@pytest.mark.sampled(12)
@pytest.mark.parametrize("subject", VARIOUS)
def test_every_name_is_assigned_once_before_it_is_used_and_is_used(subject: Subject) -> None:
    for model in ALL_MODELS:
        for part in subject.text(model):
            given, macro = FUNCTIONS | ARRAYS, f"{subject.machine.name.upper()}_P_"
            used: set[str] = set()
            for assignment in part:
                for name in names_in(assignment.right):
                    assert name in given or name.startswith(macro), (model, name, assignment)
                    used.add(name)
                if assignment.local:
                    assert assignment.target not in given, (model, "assigned twice", assignment.target)
                    given = given | {assignment.target}
            assert given - FUNCTIONS - ARRAYS <= used, (model, "never used", given - used)


@pytest.mark.sampled(12)
@pytest.mark.parametrize("subject", VARIOUS)
def test_what_is_done_once_depends_on_parameters_only(subject: Subject) -> None:
    """The first part reads p and nothing else, hands on only what the second reads, and leaves it no such work."""
    parameters = {parameter.name for parameter in subject.machine.parameters}
    for model in ALL_MODELS:
        once, each = subject.text(model)
        assert {name for a in once for name in names_in(a.right)} & ARRAYS <= {"p"}
        handed_on = [a.target for a in once if not a.local]
        assert handed_on == [f"c[{k}]" for k in range(len(handed_on))]
        read = [a.right for a in each if a.right.startswith("c[")]
        assert read == handed_on
        constant = parameters | {a.target for a in each if a.right.startswith("c[")}
        for a in each:
            work = recount([a]) != OperationCount()
            assert not (work and set(names_in(a.right)) - FUNCTIONS <= constant), (model, a)


@pytest.mark.parametrize("subject", VARIOUS)
def test_counts_are_those_of_the_printed_text(subject: Subject) -> None:
    for found in subject.models:
        once, each = subject.text(found.model.name)
        assert recount(once) == found.program.count_once, found.model.name
        assert recount(each) == found.program.count, found.model.name


@pytest.mark.parametrize("subject", VARIOUS)
def test_generated_names_cannot_be_those_of_a_user(subject: Subject) -> None:
    """Whatever the C and the Python call something that the user did not name is refused as a user's name."""
    own = {p.name for p in subject.machine.parameters} | {joint.variable for joint in subject.machine.joints}
    for found in subject.models:
        model, program = found.model.name, found.program
        made = [s.name for s in (*program.once, *program.statements)]
        arguments = [name for argument in program.inputs for name in argument.symbols]
        assert len(set(made)) == len(made), model
        assert not set(made) & {*own, *arguments}, model
        arrays = [argument.name for argument in program.inputs]
        names = {*made, *arguments, *arrays, model} - own
        assert [name for name in sorted(names) if why_reserved(name, reserved_words()) is None] == [], model


@pytest.mark.thorough
@pytest.mark.parametrize(
    "name", ["A", "H", "T", "ARM_P_x", "ARM_JOINTS", "ARM_MOTORS", "ARM_FRAMES", "ARM_PARAMETERS", "ARM_P_ARM_P_"]
)
def test_results_and_macros_may_be_names_of_a_machine(name: str) -> None:
    """A is a rotary axis of machine tools: generated code avoids the clash, and its numbers stay right."""
    arm = replace(planar_2r(), name="arm")
    assert [joint.name for joint in _named(arm, 0, name=name).joints] == [name, "joint2"]
    rendered(_named(arm, 0, name=name))
    rendered(replace(arm, parameters=(*arm.parameters, Parameter(name))))
    assert verify(_named(arm, 0, variable=name), Scene(("inertia_matrix", "geometric_model")), states=(2, 1)).ok


def _named(machine: Machine, row: int, **changes: str) -> Machine:
    joints = list(machine.joints)
    joints[row] = replace(joints[row], **changes)
    return replace(machine, joints=tuple(joints))


@pytest.mark.thorough
def test_part_names_are_refused_too() -> None:
    """Every quantity that is named may have parts a, b, ..., z, aa: as names they are refused."""
    names = {
        statement.name
        for subject in (parameter.values[0] for parameter in VARIOUS)
        for model in subject.models
        for statement in (*model.program.once, *model.program.statements)
    }
    parts = {name + letter for name in names for letter in ("a", "z", "ab")}
    parts |= {"result_a", "result_ab"}
    assert [name for name in sorted(parts) if why_reserved(name) is None] == []


# Small programs by hand


def program_of(*results: Any, names: Names | None = None) -> Program:
    return build([Input("q", ("x", "y", "z"))], [Output("r", (len(results),), results)], names or Names())


def test_products_by_hand() -> None:
    """Pairs of factors shared, common factors taken out of sums, a reciprocal used once a division."""
    graph = Graph()
    w, x, y, z = (graph.symbol(name) for name in "wxyz")
    a, b = (graph.symbol(name, Level.PARAMETER) for name in "ab")
    cases: list[tuple[tuple[Any, ...], OperationCount, OperationCount]] = [
        ((x * y * w, x * z * w, x * w), OperationCount(mul=3), OperationCount()),
        ((2 * w * x, 2 * w * y, 2 * w * z), OperationCount(mul=4), OperationCount()),
        ((a * x * b,), OperationCount(mul=1), OperationCount(mul=1)),
        ((x * w + y + z * w,), OperationCount(mul=1, add=2), OperationCount()),
        ((y - x * w - z * w,), OperationCount(mul=1, add=2), OperationCount()),
        ((x * w + z * w, z * w), OperationCount(mul=2, add=1), OperationCount()),
        ((x * (1 / y),), OperationCount(div=1), OperationCount()),
        ((x * (1 / y), z * (1 / y)), OperationCount(mul=2, div=1), OperationCount()),
    ]
    values = {
        "w": Fraction(3),
        "x": Fraction(5),
        "y": Fraction(7),
        "z": Fraction(11),
        "a": Fraction(2),
        "b": Fraction(13),
    }
    for entries, each, once in cases:
        program = build([], [Output("result", (len(entries),), entries)], Names())
        assert (program.count, program.count_once) == (each, once), entries
        rational = Arithmetic(Fraction, RATIONAL)
        before, after = (evaluate(found, values, rational) for found in (entries, program.outputs[0].entries))
        assert list(map(before, entries)) == list(map(after, program.outputs[0].entries))


def test_quantities_with_a_name_stay_whole() -> None:
    graph, names = Graph(), Names()
    w, x, y = (graph.symbol(name) for name in "wxy")
    names.give(-(x * y), "xy", Section("Section"))
    program = build([], [Output("result", (2,), (w * (x * y), w * x))], names)
    assert [(s.name, s.negative) for s in program.statements if s.name == "xy"] == [("xy", True)]


def test_counts_by_hand() -> None:
    graph = Graph()
    x, y = graph.symbol("x"), graph.symbol("y")
    a, b = graph.symbol("a", Level.PARAMETER), graph.symbol("b", Level.PARAMETER)
    cosine, sine = cosine_sine(graph, x + graph.pi / 2 + y)
    fifth = graph.node(COSPI, Fraction(1, 5))
    cases: list[tuple[Any, OperationCount, OperationCount]] = [
        (x * y + 3, OperationCount(mul=1, add=1), OperationCount()),
        (x - y, OperationCount(add=1), OperationCount()),
        (-x, OperationCount(), OperationCount()),
        (x * x, OperationCount(mul=1), OperationCount()),
        (-(x * y) - (x * y), OperationCount(mul=2), OperationCount()),
        (1 / x + x / y, OperationCount(div=2, add=1), OperationCount()),
        (x / 4, OperationCount(mul=1), OperationCount()),
        (x * 2 * 3, OperationCount(mul=1), OperationCount()),
        (x * fifth * fifth, OperationCount(mul=1), OperationCount()),
        (a * b * x, OperationCount(mul=1), OperationCount(mul=1)),
        ((a / b - 1) * (x + a), OperationCount(mul=1, add=1), OperationCount(div=1, add=1)),
        (cosine, OperationCount(mul=2, add=1, sincos=4), OperationCount()),
        (cosine * sine, OperationCount(mul=5, add=2, sincos=4), OperationCount()),
        ((x + y) * (x + y) + 1 / (x + y), OperationCount(mul=1, add=2, div=1), OperationCount()),
        (Fraction(7), OperationCount(), OperationCount()),
        (a, OperationCount(), OperationCount()),
        (cosine_sine(graph, a)[0] * x, OperationCount(mul=1), OperationCount(sincos=1)),
    ]
    for result, each, once in cases:
        program = program_of(result)
        assert (program.count, program.count_once) == (each, once), result
    everything = program_of(*(result for result, _, _ in cases))
    assert everything.count.sincos == 4 and everything.count_once == OperationCount(mul=1, add=1, div=1, sincos=1)


def test_counts_add_and_subtract() -> None:
    first, second = OperationCount(5, 4, 3, 2), OperationCount(1, 1, 1, 1)
    assert first + second == OperationCount(6, 5, 4, 3)
    assert saving(first, second) == {"mul": 4, "add": 3, "div": 2, "sincos": 1}
    assert first.products == 8


def test_what_no_output_needs_is_left_out() -> None:
    graph = Graph()
    x, y, z = (graph.symbol(name) for name in "xyz")
    names, here = Names(), Section("Here")
    names.give(x * y, "H1", here)
    names.give(y * z, "H2", here)
    program = program_of(x * y + 1, names=names)
    assert [s.name for s in program.statements] == ["H1"]
    assert program.used == {"x", "y"}


def test_shared_work_is_named_after_the_first_quantity_that_needs_it() -> None:
    graph = Graph()
    x, y, z = (graph.symbol(name) for name in "xyz")
    names, first, second = Names(), Section("First", 1), Section("Second", 2)
    shared = x + y
    names.give(shared * z, "Js5_33", first)
    names.give(shared * x, "K5_33", second)
    program = program_of(shared * z, -(shared * x), -(y - z) * (z - y), names=names)
    assert [s.name for s in program.statements] == ["Js5_33a", "Js5_33", "K5_33", "result_a"]
    assert [(s.title, [x.name for x in g]) for s, g in by_section(program.statements)] == [
        ("First", ["Js5_33a", "Js5_33"]),
        ("Second", ["K5_33"]),
        ("Results", ["result_a"]),
    ]


def test_parts_beyond_z() -> None:
    graph = Graph()
    x, y = graph.symbol("x"), graph.symbol("y")
    total: Any = 0
    for k in range(1, 31):
        part = x + k
        total = total + part * part * y
    names = Names()
    names.give(total, "H1", Section("Here"))
    made = [s.name for s in program_of(total, names=names).statements if s.name != "H1"]
    assert made[:2] == ["H1a", "H1b"] and {"H1z", "H1aa", "H1ad"} <= set(made) and len(set(made)) == len(made)


def test_a_name_given_first_stays_and_signs_go_outside() -> None:
    graph = Graph()
    x, y = graph.symbol("x"), graph.symbol("y")
    names, here = Names(), Section("Here")
    names.give(-(x * y), "H1", here)
    names.give(x * y, "H2", here)
    names.give(x, "H3", here)
    names.give(3, "H4", here)
    program = program_of(x * y, -(x * y), x, names=names)
    assert [(s.name, s.negative) for s in program.statements] == [("H1", True)]
    printer = Printer(program)
    assert "    const double H1 = -x*y;" in Writer(printer, C, ()).statements(program.statements)
    assert [printer.value(x) for output in program.outputs for x in output.entries] == ["-H1", "H1", "x"]


def test_one_name_for_two_quantities_is_refused() -> None:
    graph, here = Graph(), Section("Here")
    x, y, z = (graph.symbol(name) for name in "xyz")
    twice, of_a_variable = Names(), Names()
    twice.give(x * y, "H1", here)
    twice.give(y * z, "H1", here)
    of_a_variable.give(x * y, "z", here)
    for names, repeated in ((twice, "H1"), (of_a_variable, "z")):
        with pytest.raises(ValueError, match=f"^one name for two quantities: {repeated}$"):
            program_of(x * y, y * z, names=names)
    assert [s.name for s in program_of(x * y, names=of_a_variable).statements] == ["z"]
    assert twice.quantities == {"H1": x * y}


def test_quantities_that_are_constant_are_recorded_by_their_first_name() -> None:
    graph, names, here = Graph(), Names(), Section("Here")
    x = graph.symbol("x")
    for value, name in ((2 * graph.pi, "H1"), (graph.pi, "H1"), (3, "H2"), (4, "H2"), (0, "H3"), (x, "H4")):
        names.give(value, name, here)
    found = {constant.label: constant.value for constant in program_of(x, names=names).named_constants}
    assert found == {("H1", here): 2 * graph.pi, ("H2", here): 3}


def test_no_statement_is_deeper_than_the_limit() -> None:
    graph = Graph()
    x, y, z = (graph.symbol(name) for name in "xyz")
    nested: Any = x
    for _ in range(20):
        nested = (nested + y) * z
    program = program_of(nested)
    assigned = {s.node.id for s in program.statements}

    def depth(node: Expression) -> int:
        return 1 + max((0 if x.id in assigned else depth(x) for x in node.needs), default=-1)

    assert [depth(s.node) for s in program.statements] == [MAX_INLINE_DEPTH + 1] * 4 == [9] * 4


def test_a_use_of_the_negative_is_a_use() -> None:
    """Sums have a variable that are used by both signs, twice by the negative one, or as a result of parameters."""
    graph = Graph()
    x, y, z = (graph.symbol(name) for name in "xyz")
    a, b = (graph.symbol(name, Level.PARAMETER) for name in "ab")
    both = program_of((x + y) * z, -(x + y), z)
    assert [s.node for s in both.statements if s.node == x + y] == [x + y]
    assert [s.node for s in program_of(-(x + y), -(x + y)).statements] == [x + y]
    assert [s.node for s in program_of(x, -(a + b)).once] == [a + b]


def test_variables_are_renamed_wherever_they_are() -> None:
    graph, names, here = Graph(), Names(), Section("Here")
    x, y = graph.symbol("x"), graph.symbol("y")
    a, b = (graph.symbol(name, Level.PARAMETER) for name in "ab")
    names.give(x * y, "H1", here)
    program = program_of((a + b) * x, x * y + a, y, names=names)
    renamed = rename_variables(program, {"x": "u", "a": "c"})
    assert (program.used, renamed.used) == ({"x", "y", "a", "b"}, {"u", "y", "c", "b"})
    assert renamed.inputs == (Input("q", ("u", "y", "z")),)
    before, after = (Printer(p) for p in (program, renamed))
    for old, new in zip((*program.once, *program.statements), (*renamed.once, *renamed.statements), strict=True):
        assert new.name == old.name and new.node.id == old.node.id
        symbols = {n.operands[0] for n in reachable([new.node]) if n.operation == SYMBOL}
        assert symbols.isdisjoint({"x", "a"}) and len(symbols) == len(
            {n.operands[0] for n in reachable([old.node]) if n.operation == SYMBOL}
        )
    entries = [printer.value(x) for p, printer in ((program, before), (renamed, after)) for x in p.outputs[0].entries]
    assert entries[2] == entries[5] == "y"


# Everywhere the same

DIGESTS = """
import hashlib, sys
from symoro_elastic.formats import read_machine
from symoro_elastic.machine.scene import ALL, Scene
from tests.generated_code import rendered
from tests.references.random_machines import random_machine
machines = [read_machine(path)[0] for path in sys.argv[1:]]
machines += [random_machine(1, joints=7, symbolic=True, moving_base=True)]
for machine in machines:
    for scene in (Scene(), Scene(fold=ALL, gravity=False)):
        for name, text in sorted(rendered(machine, scene).items()):
            print(machine.name, name, hashlib.sha256(text.encode()).hexdigest())
"""


@pytest.mark.thorough
def test_the_same_bytes_whatever_the_hash_seed() -> None:
    paths = [str(ROOT / "examples" / name) for name in ("two_axis.toml", "flex4.par")]
    found = []
    for seed in ("0", "4242"):
        environment = {**os.environ, "PYTHONHASHSEED": seed}
        command = [sys.executable, "-c", DIGESTS, *paths]
        run = subprocess.run(command, capture_output=True, text=True, check=True, cwd=ROOT, env=environment)
        found.append(run.stdout.splitlines())
    assert found[0] == found[1]
    assert len(found[0]) == 2 * (len(paths) + 1) * (2 + 2 + len(ALL_MODELS))


# Linear in the number of joints


def size(joints: int, model: str) -> tuple[int, int, int]:
    """Nodes of the graph, operations of a call, statements, for a generic chain."""
    bound = Bound(chain(joints))
    MODELS[model].run(bound, tuple(bound.machine.independent))
    program = trace(chain(joints), model).program
    count = program.count
    return len(bound.graph), count.products + count.add + count.sincos, len(program.statements)


@pytest.mark.thorough
@pytest.mark.parametrize("model", ["direct_dynamics", "inverse_dynamics", "bias_forces"])
def test_nodes_and_operations_are_linear_in_the_joints(model: str) -> None:
    """Every further pair of joints of a generic chain adds the same, exactly; signs alternate joint by joint."""
    at = {n: size(n, model) for n in (52, 76, 100)}
    first, second = ([b - a for a, b in zip(at[m], at[m + 24], strict=True)] for m in (52, 76))
    assert first == second


CALLS_PER_JOINT = 60_000
"""A tenth above what it takes; a fifth of that finds the blocks that repeat."""


def calls(joints: int) -> int:
    """Function calls that it takes to print the direct model of a chain as C."""
    machine = chain(joints, elastic=range(2, joints, 2))
    rendered(chain(2), targets=["c"])
    return calls_of(lambda: rendered(machine, Scene(models=("direct_dynamics",)), ["c"]))


@pytest.mark.thorough
def test_work_of_generating_is_linear_in_the_joints() -> None:
    """Counted in calls, which no busy machine changes: those of 40 joints against twice those of 20."""
    small, large = calls(20), calls(40)
    assert large < 2.1 * small
    assert (large - small) / 20 < CALLS_PER_JOINT


def test_programs_and_packages_are_shown_in_a_line() -> None:
    """Messages of failed tests print them: not one expression of thousands."""
    machine = chain(12)
    models = trace_scene(machine, Scene(models=("direct_dynamics", "inertia_matrix")))
    made = package(machine, models, ())
    assert repr(made) == "<Package chain12: direct_dynamics, inertia_matrix>"
    assert repr(models[1].program).startswith("<Program of A: ")
    assert all(len(repr(x)) < 2500 and "sin" not in repr(x) for x in (*models, *made.functions))


def test_folding_everything_leaves_no_parameter_in_the_graph() -> None:
    machine = random_machine(3, joints=8, symbolic=True)
    names = [p.name for p in machine.parameters]
    for model in ALL_MODELS:
        program = trace(machine, model, folded=names).program
        roots = [x for output in program.outputs for x in output.entries if isinstance(x, Expression)]
        assert not program.once and not [n for n in reachable(roots) if n.level == Level.PARAMETER]
        assert not program.used & set(names)
    assert ALL == "all"
