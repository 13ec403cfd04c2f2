"""The target st: rules of the text, its numbers by an interpreter, and by two compilers where they are there."""

from __future__ import annotations

import ctypes
import math
import re
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cache, partial
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from symoro_elastic.codegen.package import Package
from symoro_elastic.codegen.precision import DOUBLE, SINGLE, Precision
from symoro_elastic.codegen.st.function import LONGEST_BLOCK
from symoro_elastic.codegen.st.lines import (
    LONGEST_NAME,
    MOST_OPERATORS,
    RESERVED,
    WIDTH,
    StNames,
    in_comment,
    statement,
)
from symoro_elastic.codegen.targets.c import render_c
from symoro_elastic.codegen.targets.st import render_st
from symoro_elastic.formats import read_machine
from symoro_elastic.formats.toml import reading as toml
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.generation.pipeline import programs
from symoro_elastic.machine.described import DescribedMachine
from symoro_elastic.machine.drives import ONE, Drive, Drives
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.scene import Scene
from symoro_elastic.numerics.verification.implementations import numpy_model
from tests.closed_chains.machines import without_closed_form
from tests.codegen.test_local_names import arm
from tests.generated_code import compiled
from tests.models.test_creep import creeping
from tests.octave import ulps
from tests.references.controlled import controlled
from tests.structured_text import (
    Array,
    Block,
    File,
    Interpreter,
    Runs,
    by_matiec,
    by_strucpp,
    interpreted,
    needs_matiec,
    needs_strucpp,
    parsed,
    refused,
    without_comments,
)

ROOT = Path(__file__).parents[2]
COMPILERS = {"strucpp": by_strucpp, "matiec": by_matiec}
DYNAMIC = ("inverse_dynamics", "direct_dynamics")
LONG = "a" * 40


def example(name: str) -> Machine:
    return read_machine(ROOT / "examples" / name)[0]


def hostile() -> Machine:
    """Names that differ by case only, reserved words, long names."""
    names = ("R", "S", "N", "D", "L", "T", "LD", "R1", "SIN", "ABS", "limit", "super", "begin", "prepared", "work")
    return arm(("Q1", "q1", "t", "A", f"{LONG}b"), (*names, f"{LONG}c", f"{LONG}d", "m1", "M1", "arm_joints"))


ONE_JOINT = """
name = "pendulum"
gravity = [0, 0, -9.81]
joints = [{ name = "swing", kind = "motor", sigma = 0, alpha = "pi/2", theta = "q1" }]
[bodies]
swing = { mass = 1, center_of_mass = [1, 0, 0], inertia = [0, 0, 0.1] }
"""

CASES: dict[str, tuple[Callable[[], Machine], Scene]] = {
    "hostile names": (hostile, Scene(models=(*DYNAMIC, "geometric_model", "jacobian"))),
    "motors in three ways": (lambda: example("ball_screw.toml"), Scene(models=DYNAMIC, steps=("w2",))),
    "all methods": (lambda: example("planar_2r.toml"), Scene(models=DYNAMIC, steps=("w2", "w3", "rk4", "midpoint"))),
    "one joint": (
        lambda: toml.read(ONE_JOINT, "pendulum.toml"),
        Scene(models=DYNAMIC, steps=("w2", "midpoint"), forces=("swing",)),
    ),
    "missing values": (lambda: example("flex4.par"), Scene(models=DYNAMIC, steps=("w2",))),
    "loops": (lambda: creeping(without_closed_form()), Scene(models=("direct_dynamics", "assemble"))),
    "floating base": (lambda: example("floating_arm.toml"), Scene(models=("direct_dynamics", "velocities"))),
    "inverse model": (lambda: example("puma560_measured.toml"), Scene(models=("inverse_geometric_model",))),
    "dry friction": (lambda: example("pendant_arm.urdf"), Scene(models=DYNAMIC)),
    "controllers": (controlled, Scene(models=("control",))),
}


@cache
def package(case: str) -> Package:
    machine, scene = CASES[case]
    return programs(machine(), scene).package


@cache
def text(case: str) -> str:
    (made,) = render_st(package(case)).values()
    return made


each = pytest.mark.parametrize("case", CASES)

# Rules of the text


@pytest.mark.sampled(2)
@each
def test_names_are_free_and_differ_in_more_than_case(case: str) -> None:
    file = parsed(text(case))
    around = [*file.types, *file.blocks]
    assert len(around) == len({*around})
    for block in file.blocks.values():
        own = [name for name, _, _ in block.variables()]
        assert sorted({*own, *around}) == sorted([*own, *around])
        assert [name for name in own if name.upper() in RESERVED] == []
    identifiers = set(re.findall(r"[A-Za-z_]\w*", without_comments(text(case))))
    assert [x for x in identifiers if len(x) > LONGEST_NAME or "__" in x or x.startswith("_") or x.endswith("_")] == []


def test_what_is_renamed_is_said_beside_it() -> None:
    assert "T_1 : arm_x80; (* T: " in text("hostile names")
    assert re.search(r" R_1 : LREAL := [\d.]+; \(\* R \*\)", text("hostile names"))
    names = StNames(["arm_p"])
    assert [names.give(x) for x in ("q1", "Q1", "Arm_P", "a__b", "c_", "if", "x" * 33)] == [
        "q1",
        "Q1_1",
        "Arm_P_1",
        "a_b",
        "c",
        "if_1",
        "x" * 30 + "_1",
    ]


@pytest.mark.sampled(2)
@each
def test_literals_of_reals_have_a_point(case: str) -> None:
    inside = re.sub(r"\[[^\]]*\]|FOR \w+ := \d TO \d+ DO|  k := 0;", " ", without_comments(text(case)))
    literals = re.findall(r"(?<![\w.])\d[\d.]*(?:E-?\d+)?", inside)
    assert [x for x in literals if not re.fullmatch(r"\d+\.\d+(E-?\d+)?", x)] == []
    single = without_comments("".join(render_st(package(case), SINGLE).values()))
    assert re.findall(r"(?<![\w#.])\d+\.\d+", single) == []


@each
def test_lines_are_short_and_hold_few_operators(case: str) -> None:
    for line in without_comments(text(case)).splitlines():
        right = line.rpartition(" := ")[2]
        operators = re.findall(r"(?<=[\w)\]]) [+-] |^ *[+-] |(?<=[\w)\]])[*/]", right)
        assert len(operators) <= MOST_OPERATORS
    assert max(map(len, text(case).splitlines())) <= WIDTH + LONGEST_NAME


@each
def test_there_are_no_loops_of_one_pass(case: str) -> None:
    """matiec passes over them."""
    assert re.findall(r"FOR \w+ := (\d+) TO \1 DO", text(case)) == []


def test_long_expressions_are_broken_at_operators() -> None:
    terms = "a*b*c - (d + e)/f"
    lines = statement("  x := ", " + ".join([terms] * 9))
    assert "".join(line.strip() for line in lines).replace(" ", "") == f"x:={'+'.join([terms] * 9)};".replace(" ", "")
    assert len(lines) > 3
    assert statement("  x := ", "*".join("abcdefghijk")) == ["  x := a*b*c*d*e*f*g*h*", "      i*j*k;"]


@each
def test_arrays_have_named_types(case: str) -> None:
    """matiec refuses anonymous ones between blocks."""
    inside = without_comments(text(case))
    assert inside.count("ARRAY") == inside.partition("END_TYPE")[0].count("ARRAY") > 0
    file = parsed(text(case))
    known = {"lreal", "int", "bool", *file.types, *file.blocks}
    assert {type_ for block in file.blocks.values() for _, type_, _ in block.variables()} <= known


@each
def test_nothing_but_what_every_controller_has(case: str) -> None:
    inside, blocks = without_comments(text(case)), parsed(text(case)).blocks
    instances = {name for block in blocks.values() for name, _, _ in block.variables()}
    called = {x for x in re.findall(r"(\w+)\(", inside) if x.lower() not in {*blocks, *instances}}
    assert called <= {"SIN", "COS", "SQRT", "ABS", "ATAN"}
    words = {*re.findall(r"\b[A-Z_]{2,}\b", inside)} - instances
    assert not words & {"POINTER", "REF", "ADR", "WHILE", "REPEAT", "EXIT", "RETURN", "ARRAY OF", "GOTO"}


def test_comments_hold_what_users_wrote() -> None:
    assert in_comment("a *) b (* c {x} */\n") == "a * ) b ( * c (x) * / "
    odd = replace(package("inverse model"), source="x *) y.toml", options=("z (* {attribute}",))
    made = "".join(render_st(odd).values())
    assert made.count("(*") == made.count("*)")
    assert without_comments(made).strip().startswith("TYPE")


def test_the_header_says_what_holds() -> None:
    assert "order of operations is that of the C" in " ".join(text("inverse model").split())
    assert "without contraction" in text("inverse model")


def test_single_precision_is_the_same_text_in_real() -> None:
    made = parsed(render_st(package("all methods"), SINGLE)["planar_2r_f32.st"].replace("_f32", ""))
    wanted = parsed(text("all methods"))
    assert [name for name, (_, type_) in made.types.items() if type_ != "real"] == []
    assert {name: length for name, (length, _) in made.types.items()} == {x: n for x, (n, _) in wanted.types.items()}
    shared = made.blocks.keys() & wanted.blocks.keys()
    assert len(shared) > 10
    for name in shared:
        block = wanted.blocks[name]
        own = [(x, re.sub("^lreal$", "real", type_), value) for x, type_, value in block.variables()]
        found = [(x, type_, value.replace("real#", "")) for x, type_, value in made.blocks[name].variables()]
        assert [one for one in found if one[1] not in made.blocks] == [
            one for one in own if one[1] not in wanted.blocks
        ]
        assert "".join(made.blocks[name].body.replace("real#", "").split()) == "".join(block.body.split())


def test_text_is_small_and_the_same_each_time() -> None:
    asked = programs(example("rx90.par"), Scene(models=("inverse_dynamics",))).package
    made = render_st(asked)["rx90.st"]
    assert len(made) <= 40_000
    assert made == render_st(asked)["rx90.st"]


def test_parameters_without_a_value_are_inputs_that_cannot_be_forgotten_in_silence() -> None:
    block = parsed(text("missing values")).blocks["flex4_inverse_dynamics"]
    assert ("zz1", "lreal", "1.0e30") in block.sections["var_input"]
    found = run_at_random("missing values", "flex4_inverse_dynamics", 1, left_out=("zz1",))
    assert np.abs(found["tau"]).max() > 1e28


@pytest.mark.thorough
def test_what_is_not_written_is_refused_in_one_line() -> None:
    machine = example("planar_2r.toml")
    with pytest.raises(InputError, match=r"^planar_2r.toml: --target st, steps: rodas4 is not written .*: .*w2.* are$"):
        render_st(programs(machine, Scene(models=DYNAMIC, steps=("rodas4",))).package)
    with pytest.raises(InputError, match=r"^floating_arm.toml: --target st, steps: time steps on a floating base"):
        render_st(programs(example("floating_arm.toml"), Scene(models=DYNAMIC, steps=("w2",))).package)
    driven = replace(DescribedMachine.of(machine), drives=Drives({machine.motor_joints[0].name: Drive(ONE, ONE)}))
    with pytest.raises(InputError, match="--target st, steps: time steps under drives are not written"):
        render_st(programs(driven, Scene(models=DYNAMIC, steps=("w2",))).package)


# Numbers


def states_of(file: File, block: Block, count: int, seed: int = 0) -> dict[str, Array]:
    """Arrays of all inputs of a block, drawn by a seed; what is true or false is true at the first call alone."""
    rng = np.random.default_rng(seed)
    inputs = [*block.sections.get("var_input", ()), *block.sections.get("var_in_out", ())]
    lengths = {name: file.length(type_) or 1 for name, type_, _ in inputs}
    found = {name: rng.uniform(-1, 1, (count, n)).astype(np.float32).astype(float) for name, n in lengths.items()}
    found |= {name: np.eye(count, 1) for name, type_, _ in inputs if type_.upper() == "BOOL"}
    return found | ({"h": np.full((count, 1), 1e-4)} if "h" in found else {})


def run_at_random(case: str, block: str, count: int, left_out: tuple[str, ...] = ()) -> dict[str, Array]:
    file = parsed(text(case))
    states = states_of(file, file.blocks[block], count)
    runs = Interpreter(file, np.float64)
    instance = runs.instance(block)
    for name, x in states.items():
        if name not in left_out:
            setattr(instance, name, [*x[0]] if x.shape[1] > 1 else x[0, 0])
    runs.call(block, instance)
    return {name: np.array(getattr(instance, name)) for name, _, _ in file.blocks[block].sections["var_output"]}


class InC(NamedTuple):
    """The C of a package with the sines of its library, without contraction."""

    library: ctypes.CDLL
    package: Package
    precision: Precision

    def run(self, file: File, block: Block, states: Mapping[str, Array]) -> dict[str, Array]:
        """Return what the function of this block finds for its inputs: arrays in order, then parameters."""
        function = getattr(self.library, self._name(file.wanted.get(block.name, block.name)))
        real = np.float32 if self.precision is SINGLE else np.float64
        number = ctypes.c_float if self.precision is SINGLE else ctypes.c_double
        function.restype = None
        values = [(p.name.lower(), p.value) for p in self.package.parameters]
        read = [x for x, type_, _ in block.sections.get("var_input", ()) if x == "h" or file.length(type_)]
        count = len(next(iter(states.values())))
        lengths = {x: file.length(type_) for x, type_, _ in block.sections.get("var_output", ())}
        states = {x: array.astype(real) for x, array in states.items()}
        found = {x: states[x].copy() for x, _, _ in block.sections.get("var_in_out", ())}
        found |= {x: np.full((count, n), np.nan, real) for x, n in lengths.items()}
        for k in range(count):
            given = [number(states[x][k, 0]) if x == "h" else _at(states[x][k]) for x in read]
            p = np.array([states[x][k, 0] if math.isnan(v) and x in states else v for x, v in values], real)
            function(*given, _at(p), *(_at(x[k]) for x in found.values()))
        return found

    def _name(self, block: str) -> str:
        """The function of a block."""
        model = block[len(self.package.name) + 1 :].removesuffix("_f32")
        models = {f.name.lower(): f.name for f in self.package.functions}
        if model in models:
            return self.precision.function(self.package.name, models[model])
        return f"{self.package.name}{self.precision.suffix}_{model}"


def _at(array: Array) -> ctypes.c_void_p:
    return array.ctypes.data_as(ctypes.c_void_p)


def in_c(asked: Package, folder: Path, precision: Precision = DOUBLE) -> InC:
    for name, source in render_c(asked, precision).items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(source)
    return InC(compiled(folder, folder, "cc", asked.name + precision.suffix), asked, precision)


def equal_to_c(made: str, run: Runs, c: InC, count: int) -> dict[str, float]:
    """Return by block how many units in the last place of C results are off; NaN where C has it is right."""
    file = parsed(made)
    off = {}
    for block in file.blocks.values():
        if block.kind == "function_block" and not re.search(r"_p\d+$", block.name):
            states = states_of(file, block, count)
            wanted, found = c.run(file, block, states), run(block.name, states)
            off[block.name] = max(ulps(found[x].astype(w.dtype).reshape(w.shape), w) for x, w in wanted.items())
    return off


@pytest.mark.sampled(5)
@pytest.mark.parametrize(
    "case",
    [
        "hostile names",
        "one joint",
        "missing values",
        "floating base",
        "dry friction",
        pytest.param("loops", marks=pytest.mark.thorough),
        pytest.param("all methods", marks=pytest.mark.thorough),
        pytest.param("motors in three ways", marks=pytest.mark.thorough),
    ],
)
def test_interpreted_text_has_the_bits_of_c(case: str, tmp_path: Path) -> None:
    off = equal_to_c(text(case), partial(interpreted, text(case)), in_c(package(case), tmp_path), 3)
    assert off == dict.fromkeys(off, 0.0)
    assert len(off) >= 2


@pytest.mark.thorough
def test_single_precision_has_the_bits_of_c_but_for_sines(tmp_path: Path) -> None:
    """The library's sines of floats are not always the rounded ones, which the interpreter takes."""
    (made,) = render_st(package("missing values"), SINGLE).values()
    off = equal_to_c(made, partial(interpreted, made), in_c(package("missing values"), tmp_path, SINGLE), 3)
    without_sines = [name for name in off if "implicit_solve" in name]
    assert [off[name] for name in without_sines] == [0.0] * 3
    assert max(off.values()) <= 64


def test_models_with_arc_tangents_are_within_their_bound(tmp_path: Path) -> None:
    """Placements that can be reached; angles are off by what `atan2` may be off."""
    made, asked = text("inverse model"), package("inverse model")
    machine = example("puma560_measured.toml")
    geometric = programs(machine, Scene(models=("geometric_model",))).package
    c = in_c(geometric, tmp_path / "geometric")
    q = np.random.default_rng(1).uniform(-2, 2, (4, 6))
    T = np.full((4, len(machine.joints), 16), np.nan)
    for k in range(4):
        c.library.puma560_measured_geometric_model(
            _at(q[k]), _at(np.array([x.value for x in geometric.parameters])), _at(T[k])
        )
    inverse = in_c(asked, tmp_path / "inverse")
    file = parsed(made)
    (block,) = (one for one in file.blocks.values() if one.kind == "function_block")
    states = {block.sections["var_input"][0][0]: T[:, -1]}
    wanted, found = inverse.run(file, block, states), interpreted(made, block.name, states)
    assert np.isfinite(wanted["q"]).any(axis=1).all()
    assert np.nanmax(np.abs(found["q"] - wanted["q"])) <= 16 * np.spacing(np.pi)


def test_a_model_in_parts_has_the_same_bits(tmp_path: Path) -> None:
    asked = package("missing values")
    (made,) = render_st(asked, DOUBLE, longest=40).values()
    parts = [block for name, block in parsed(made).blocks.items() if re.search(r"_p\d+$", name)]
    assert len(parts) >= 4
    assert all(block.body.count(":=") <= 40 + 2 * 60 for block in parts)
    off = equal_to_c(made, partial(interpreted, made), in_c(asked, tmp_path), 2)
    assert off == dict.fromkeys(off, 0.0)


@pytest.mark.parametrize(
    "run",
    [
        pytest.param(lambda made, folder: partial(interpreted, made), id="interpreter"),
        pytest.param(by_strucpp, marks=[needs_strucpp, pytest.mark.thorough], id="strucpp"),
        pytest.param(by_matiec, marks=[needs_matiec, pytest.mark.thorough], id="matiec"),
    ],
)
@pytest.mark.parametrize("longest", [LONGEST_BLOCK, 6])
def test_controllers_keep_their_states(run: Callable[[str, Path], Runs], longest: int, tmp_path: Path) -> None:
    """A block over 300 periods, begun at rest twice: the bits of numpy, whose states the caller keeps."""
    (made,) = render_st(package("controllers"), DOUBLE, longest).values()
    file, code = parsed(made), numpy_model(controlled(), ("control", "control_start"))
    block = file.blocks["ball_screw_control"]
    assert "zc" in [name for name, _, _ in block.sections["var"]]
    names = ("measured", "speed", "r", "rd", "rdd", "tau")
    drawn = np.random.default_rng(8).normal(size=(300, 6)) * (1, 5, 1, 5, 100, 10)
    begins = np.isin(np.arange(300), (0, 170))
    given = {"r_1" if name == "r" else name: drawn[:, [k]] for k, name in enumerate(names)}
    found = run(made, tmp_path)(block.name, {"start": begins[:, None].astype(float), **given})["u"]
    zc = np.zeros(0)
    for k, row in enumerate(drawn):
        entries = [np.array([x]) for x in row]
        zc = code.control_start(*entries[2:]) if begins[k] else zc
        u, zc = code.control(*entries, zc)
        assert np.array_equal(found[k], u), k


def test_arc_tangent_and_sign() -> None:
    file = parsed(text("inverse model"))
    runs = Interpreter(file, np.float64)
    atan2 = next(name for name in file.blocks if name.endswith("atan2"))
    rng = np.random.default_rng(2)
    special = [(y, x) for y in (-1.0, 0.0, 2.0) for x in (-3.0, 0.0, 1.0)]
    for y, x in [*special, *(10.0 ** rng.uniform(-9, 9, (2000, 2)) * rng.choice([-1, 1], (2000, 2)))]:
        found = float(getattr(runs._functions(), atan2)(np.float64(y), np.float64(x)))
        assert abs(found - math.atan2(y, x)) <= 2 * math.ulp(math.atan2(y, x))
    friction = Interpreter(parsed(text("dry friction")), np.float64)._functions()
    assert [friction.pendant_arm_sign(np.float64(x)) for x in (-2.0, 0.0, 0.5)] == [-1.0, 0.0, 1.0]


# The compilers


TEN = (
    "two_axis.toml",
    "ball_screw.toml",
    "ball_screw_rigid.toml",
    "planar_2r.toml",
    "puma560_measured.toml",
    "rx90.par",
    "flex4.par",
    "palletizer.toml",
    "linkage.toml",
    "sr400.par",
)
STATES = 10_000


@pytest.mark.sampled(1000)
@pytest.mark.parametrize("name", TEN)
@pytest.mark.parametrize(
    "compiler", [pytest.param("strucpp", marks=needs_strucpp), pytest.param("matiec", marks=needs_matiec)]
)
def test_compiled_text_has_the_bits_of_c(name: str, compiler: str, tmp_path: Path) -> None:
    asked = programs(example(name), Scene(models=DYNAMIC, steps=("w2",))).package
    (made,) = render_st(asked).values()
    run = COMPILERS[compiler](made, tmp_path / compiler)
    off = equal_to_c(made, run, in_c(asked, tmp_path / "c"), STATES)
    assert off == dict.fromkeys(off, 0.0)
    assert len(off) >= 5


@pytest.mark.thorough
@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("precision", [DOUBLE, SINGLE])
@pytest.mark.parametrize(
    "compiler", [pytest.param("strucpp", marks=needs_strucpp), pytest.param("matiec", marks=needs_matiec)]
)
def test_compilers_take_every_text(case: str, precision: Precision, compiler: str, tmp_path: Path) -> None:
    """In single precision both round the sines of doubles, as the interpreter does."""
    made = "".join(render_st(package(case), precision).values())
    run = COMPILERS[compiler](made, tmp_path)
    file = parsed(made)
    for block in file.blocks.values():
        if block.kind == "function_block":
            states = states_of(file, block, 3)
            found, wanted = run(block.name, states), interpreted(made, block.name, states)
            assert max(ulps(found[x].astype(wanted[x].dtype), wanted[x]) for x in wanted) == 0.0


@pytest.mark.thorough
@pytest.mark.parametrize(
    "compiler", [pytest.param("strucpp", marks=needs_strucpp), pytest.param("matiec", marks=needs_matiec)]
)
def test_compilers_refuse_what_is_wrong(compiler: str, tmp_path: Path) -> None:
    made = text("missing values")
    assert not refused(compiler, made, tmp_path / "right")
    assert refused(compiler, made.replace("th2 := q[1];", "thh2 := q[1];", 1), tmp_path / "name")
    assert refused(compiler, re.sub(r"(?m)^    \w+, ", "    ", made, count=1), tmp_path / "declaration")
