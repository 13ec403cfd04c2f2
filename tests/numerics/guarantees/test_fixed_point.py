"""Fixed point: integers never overflow in the box, and results are never further from exact ones than is proven."""

from __future__ import annotations

import ctypes
import math
import re
import subprocess
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from functools import cache, cached_property
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import example as also
from hypothesis import given, settings
from hypothesis import strategies as st

import symoro_elastic as se
from symoro_elastic.api.machines import the_machine
from symoro_elastic.codegen.c.fixed_function import inside
from symoro_elastic.codegen.compile import compile_library
from symoro_elastic.codegen.fixed_point import LARGEST, TURN, bits_of, quantize, symbols_of, turn_factor, turning
from symoro_elastic.codegen.guaranteed import EntryRange
from symoro_elastic.codegen.package import Function, Package
from symoro_elastic.codegen.targets.c_fixed import render_c_fixed
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.progress import announce_nothing, no_progress
from symoro_elastic.generation.pipeline import programs
from symoro_elastic.generation.reduced_models.search import models_in_fixed_point
from symoro_elastic.generation.reduced_models.sentences import fixed_totals
from symoro_elastic.machine.described import DescribedMachine
from symoro_elastic.machine.limits import Limits, Range
from symoro_elastic.machine.scene import Scene
from symoro_elastic.machine.within import Evidence, Within, tolerance
from symoro_elastic.numerics.guarantees.box import Box
from symoro_elastic.numerics.guarantees.fixed_point import box_in_units, in_fixed_point, with_scales
from tests.command_line import refused, run
from tests.examples import example
from tests.numerics.guarantees.fixed import FixedCase

ROOT = Path(__file__).parents[3]
STATES = 100_000
TURNING_SPRING = {
    "name": "spring_arm",
    "gravity": [0, -9.81, 0],
    "joints": [
        {"name": "bend", "antecedent": 0, "kind": "elastic", "sigma": 0, "theta": "q1"},
        {"name": "hinge", "antecedent": "bend", "kind": "motor", "sigma": 0, "d": 0.5, "theta": "q2"},
    ],
    "bodies": {
        "bend": {"mass": 3, "center_of_mass": [0.2, 0.01, 0], "inertia": [0.1, 0.1, 0.1]},
        "hinge": {"mass": 2, "center_of_mass": [0.3, 0, 0], "inertia": [0.1, 0.1, 0.1]},
    },
    "springs": {"bend": {"stiffness": 40}},
    "friction": {"hinge": {"coulomb": 0.7, "viscous": 0.3}},
    "limits": {
        "bend": {"position": [-0.2, 0.3], "velocity": 1, "acceleration": 4, "torque": 1},
        "hinge": {"position": [2.5, 4.0], "velocity": 3, "acceleration": 4, "torque": 1},
    },
}
"""An angle that a spring takes, too, and one within limits that reach over half a turn."""
CASES = {
    "planar_2r": ("planar_2r.toml", "inverse_dynamics"),
    "PUMA 560": ("puma560_measured.toml", "inverse_dynamics"),
    "inertia matrix": ("planar_2r.toml", "inertia_matrix"),
    "machine tool": ("two_axis.toml", "bias_forces"),
    "frames": ("puma560_measured.toml", "geometric_model"),
    "spring": (TURNING_SPRING, "energy"),
    "friction": (TURNING_SPRING, "friction_forces"),
}


@cache
def case(name: str) -> FixedCase:
    source, model = CASES[name]
    machine = the_machine(source if isinstance(source, dict) else ROOT / "examples" / source)
    return FixedCase(machine, DescribedMachine.of(machine).limits, model)


def double_errors(name: str) -> np.ndarray:
    """What the double precision that is compared with may be off itself."""
    source, model = CASES[name]
    machine = source if isinstance(source, dict) else ROOT / "examples" / source
    (certificate,) = se.certify(machine, model).certificates
    return np.array([entry.error for entry in certificate.entries])


@pytest.mark.sampled(12)
@pytest.mark.parametrize("name", CASES)
def test_errors_are_never_above_what_is_proven(name: str, tmp_path: Path) -> None:
    """Compiled with checks of overflows; half of the states are corners of the box."""
    one = case(name)
    states = one.states(STATES, np.random.default_rng(0))
    in_box, found = one.run(states, tmp_path)
    assert in_box.all()
    error = np.abs(found * one.units - one.exact(states)).max(axis=0)
    assert (error <= one.proven + double_errors(name)).all(), error / one.proven


@pytest.mark.thorough
def test_limits_of_a_robot_file_are_its_box_and_those_it_lacks_are_named(tmp_path: Path) -> None:
    robot = ROOT / "examples" / "pendant_arm.urdf"
    said = refused("generate", robot, "--target", "c-fixed", "--model", "inverse_dynamics", "--out", tmp_path)
    assert "limits, wrist: has no velocity: convert the file to .toml, and give it there, as in [limits] wrist" in said
    assert "missing, too: acceleration of waist, shoulder, elbow and wrist" in said
    machine, limits = example("pendant_arm.urdf"), {}
    for joint in ("waist", "shoulder", "elbow", "wrist"):
        given = machine.limits.of(joint)
        limits[joint] = replace(given, velocity=given.velocity or Range(-5, 5), acceleration=Range(-8, 8))
    assert limits["elbow"].position == Range(-2.4, 2.4)
    one = FixedCase(machine, Limits(limits), "inverse_dynamics")
    states = one.states(STATES, np.random.default_rng(0))
    in_box, found = one.run(states, tmp_path)
    assert in_box.all()
    assert (np.abs(found * one.units - one.exact(states)).max(axis=0) <= one.proven * (1 + 1e-6)).all()


@pytest.mark.thorough
@pytest.mark.parametrize("name", ["planar_2r", "PUMA 560"])
def test_errors_of_torques_are_small(name: str, tmp_path: Path) -> None:
    """Of the largest torque: proven at most 1.7e-6, found at most 2.5e-7; the proof is within 20 times that."""
    one = case(name)
    torques = slice(0, len(one.units) // 2)
    states = one.states(STATES, np.random.default_rng(1))
    exact, (_, found) = one.exact(states)[:, torques], one.run(states, tmp_path)
    largest = np.abs(exact).max(axis=0)
    error = np.abs(found[:, torques] * one.units[torques] - exact).max(axis=0)
    assert (one.proven[torques] / largest).max() <= 1.7e-6
    assert (error / largest).max() <= 2.5e-7
    assert (one.proven[torques] <= 20 * error).all()


@pytest.mark.sampled(12)
@pytest.mark.parametrize("name", CASES)
def test_arguments_beside_the_box_are_told(name: str, tmp_path: Path) -> None:
    """Each number at an end of its range, then one unit further; angles over a whole turn have no end."""
    one = case(name)
    ranges = {(r.argument, r.entry): r for r in one.function.guaranteed["fixed-point"].ranges}
    inside = one.states(1, np.random.default_rng(2))
    rows, wanted, column = [], [], 0
    for array in one.text.arguments:
        for k, (bits, turns) in enumerate(zip(array.bits, array.turns, strict=True)):
            found = ranges.get((array.name, k))
            if found and bits is not None and found.high - found.low < 6:
                unit = 2 * math.pi / 2**32 if turns else 2.0**-bits
                low, high = math.ceil(found.low / unit), math.floor(found.high / unit)
                for value, is_inside in ((low, True), (low - 1, False), (high, True), (high + 1, False)):
                    row = inside[0].copy()
                    row[column] = np.array([value]).astype(np.uint32).view(np.int32)[0]
                    rows.append(row)
                    wanted.append(is_inside)
            column += 1
    if rows:
        in_box, _ = one.run(np.array(rows), tmp_path, ("-std=c99", "-O0"))
        assert in_box.tolist() == wanted


ENDS = st.floats(-12.0, 12.0)
WIDTHS = st.one_of(
    st.just(0.0),
    st.floats(0.0, 4e-9),
    st.floats(0.0, 3.0),
    st.integers(-6, 6).map(lambda units: 2 * math.pi + units * float(TURN)),
    st.floats(6.0, 8.0),
)


@cache
def bending() -> Function:
    return case("spring").function


@given(st.tuples(ENDS, WIDTHS), st.tuples(ENDS, WIDTHS), st.integers(0, 2**32 - 1), st.integers(-3, 3))
@also((-math.pi, 2 * math.pi), (0.7, 0.0), 2**31, 0)
@also((0.1, 0.0), (0.7, 0.0), 2**31, 0)
@settings(max_examples=50, deadline=None)
def test_units_in_the_box_are_those_of_its_ranges(
    turn: tuple[float, float], number: tuple[float, float], unit: int, beside: int
) -> None:
    """Narrow ranges, those about a whole turn, those that wrap around: by exact fractions, and never none."""
    ranges = {name: Range(low, low + width) for name, (low, width) in {"q2": turn, "qd1": number}.items()}
    box = box_in_units(bending(), Box({**dict.fromkeys(("q1", "qd2"), Range(0.0, 0.5)), **ranges}))
    _, fixed = in_fixed_point(bending(), box, "", 1)
    for name, whole_turn in (("q2", 2**32), ("qd1", 0)):
        one, node = box.ranges[name], symbols_of(bending().program)[name]
        exact = TURN if whole_turn else Fraction(2) ** -fixed.bits[node.id]
        printed = in_box_condition(one, 0 if whole_turn else fixed.bits[node.id], bool(whole_turn))
        low, high = (round(Fraction(end) / exact) for end in (one.low, one.high))
        tried = {low + beside, high + beside, (low + high) // 2, *([unit] if whole_turn else [])}
        inside = [n for n in tried if printed(n)]
        assert inside or not any(one.low <= n * exact <= one.high for n in tried)
        assert printed(low) or printed(high) or printed(low + 1)
        for n in tried:
            turns = (Fraction(one.low) / exact - n) / whole_turn if whole_turn else 0
            assert printed(n) == (one.low <= (n + math.ceil(turns) * whole_turn) * exact <= one.high)
        off = max(ranges[name].low - one.low, one.high - ranges[name].high)
        assert off <= float(exact) / 2 * (1 + 1e-9) and (one == ranges[name] or one.high - one.low < 4e-9 or whole_turn)


def in_box_condition(one: Range, bits: int, turns: bool) -> Callable[[int], bool]:
    """What the printed comparisons of an entry say of a whole number, in arithmetic of 32 bits."""
    texts = inside("q", EntryRange("q", 0, one.low, one.high), bits, turns)

    def condition(n: int) -> bool:
        words = [re.sub(r"\(uint32_t\)q - (\d+)U <= (\d+)U", rf"({n} - \1) % 2**32 <= \2", text) for text in texts]
        return all(eval(re.sub(r"\bq\b", f"({n})", word)) for word in words)

    return condition


POINTED = {
    "name": "m1",
    "gravity": [0, -9.81, 0],
    "joints": [
        {"name": "a", "antecedent": 0, "kind": "motor", "sigma": 0, "theta": "q1"},
        {"name": "b", "antecedent": 1, "kind": "motor", "sigma": 0, "d": 0.3, "theta": "q2"},
    ],
    "bodies": {
        "a": {"mass": 1, "center_of_mass": [0.1, 0, 0], "inertia": [0.01, 0.01, 0.01]},
        "b": {"mass": 1.3, "center_of_mass": [0.7, 0, 0], "inertia": [0.01, 0.01, 0.02]},
    },
    "limits": {
        "a": {"position": [-0.1, 0.3], "velocity": [0.7, 0.7], "acceleration": 3.3},
        "b": {"position": [0.1, 0.1], "velocity": 0.7, "acceleration": 3.3},
    },
}


@pytest.mark.sampled(2)
@pytest.mark.parametrize("within", [None, "5 %"])
def test_a_joint_whose_range_is_a_point_has_one_unit_in_the_box(within: str | None, tmp_path: Path) -> None:
    """And the errors there are as proven, with terms left out, too."""
    machine = the_machine(POINTED)
    limits = DescribedMachine.of(machine).limits
    one = ReducedCase(machine, limits, "inverse_dynamics") if within else FixedCase(machine, limits, "inverse_dynamics")
    states = one.states(1000, np.random.default_rng(0))
    beside = np.repeat(states[:1], 4, axis=0)
    beside[:, 1] += np.array([1, -1, 2**31 - 1, 2**29])
    in_box, found = one.run(np.concatenate([states, beside]), tmp_path)
    assert in_box.tolist() == [True] * len(states) + [False] * len(beside)
    error = np.abs(found[: len(states)] * one.units - one.exact(states)).max(axis=0)
    assert (error <= one.proven + 1e-12).all()


def test_an_angle_that_a_spring_takes_is_no_part_of_a_turn() -> None:
    """It is a number of radians, and its sine is taken of the part of a turn that it makes."""
    q, _ = case("spring").text.arguments
    assert q.turns == (False, True)
    assert "_turns(" in render_c_fixed(case("spring").package)["spring_arm_fixed.c"]


@pytest.mark.thorough
def test_turns_are_kept_only_where_all_that_uses_them_keeps_them() -> None:
    for name in CASES:
        program = case(name).function.program
        turns = turning(program)
        for node in program.nodes:
            if node.id in turns:
                assert all(x.id in turns for x in node.needs)
            elif node.operation not in ("sin", "cos"):
                assert not any(x.id in turns for x in node.needs)


SINES = """
#include <stdio.h>
@SOURCE@
int main(void)
{
    uint32_t angle;
    int32_t found[2];
    while (fread(&angle, sizeof angle, 1, stdin) == 1) {
        planar_2r_fixed_sincos(angle, &found[0], &found[1]);
        fwrite(found, sizeof *found, 2, stdout);
    }
    return 0;
}
"""


def test_sines_and_cosines_are_within_a_unit(tmp_path: Path) -> None:
    """Evenly spaced angles, and those beside ends and middles of quarters; the template proves the bound."""
    files = render_c_fixed(case("planar_2r").package)
    source = SINES.replace("@SOURCE@", files["planar_2r_fixed.c"])
    (tmp_path / "main.c").write_text(source)
    (tmp_path / "planar_2r_fixed.h").write_text(files["planar_2r_fixed.h"])
    flags = ["-std=c99", "-O1", "-fsanitize=undefined", "-fno-sanitize-recover=all"]
    subprocess.run(["gcc", *flags, "main.c", "-o", "main"], cwd=tmp_path, check=True)
    beside = [k * 2**29 + d for k in range(8) for d in range(-300, 300)]
    angles = np.concatenate([np.arange(0, 2**32, 8191), np.array(beside) % 2**32]).astype(np.uint32)
    made = subprocess.run([str(tmp_path / "main")], input=angles.tobytes(), capture_output=True, check=True).stdout
    found = np.frombuffer(made, np.int32).reshape(-1, 2) * 2.0**-30
    x = angles.astype(np.float64) * (2 * math.pi / 2**32)
    error = np.abs(found - np.stack([np.sin(x), np.cos(x)], axis=1)).max(axis=0) * 2**30
    assert (error <= 1).all() and (error >= 0.5).all()
    assert found[0].tolist() == [0.0, 1.0]


def test_numbers_fit_and_are_as_close_as_they_can_be() -> None:
    for x in map(Fraction, ("1", "-1", "9.81", "1e-9", "123456789", "-0.49999999999", str(LARGEST), "4294967296")):
        found = quantize(x)
        assert abs(found.value) <= LARGEST < 2 * abs(x) * Fraction(2) ** found.bits + 2
        assert abs(found.exact - x) <= Fraction(1, 2) * Fraction(2) ** -found.bits
        assert abs(x) * Fraction(2) ** bits_of(abs(x)) <= LARGEST


def test_the_factor_of_turns_has_31_bits() -> None:
    for bits in (0, 20, 31, 45):
        wanted = 2.0 ** (32 - bits) / (2 * math.pi)
        factor = turn_factor(bits)
        assert factor.value >= 2**30 and float(factor.exact) == pytest.approx(wanted, rel=2**-31)
    with pytest.raises(OverflowError, match="2\\^30 rad"):
        turn_factor(-1)


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> ctypes.CDLL:
    folder = tmp_path_factory.mktemp("fixed")
    return ctypes.CDLL(str(compile_library(render_c_fixed(case("planar_2r").package), folder)))


def test_angles_and_numbers_are_converted_to_nearest(library: ctypes.CDLL) -> None:
    angle, number = library.planar_2r_fixed_of_angle, library.planar_2r_fixed_of_number
    angle.argtypes, number.argtypes = [ctypes.c_double], [ctypes.c_double, ctypes.c_double]
    for x in (0.0, 1.0, -1.0, 3.14159, -3.14159, 4.0, -4.0, 7.0, 100.0, -1234.5):
        distance = (angle(x) * (2 * math.pi / 2**32) - x) % (2 * math.pi)
        assert min(distance, 2 * math.pi - distance) <= 0.51 * 2 * math.pi / 2**32 + 1e-15 * abs(x), x
    assert angle(math.pi) in (-(2**31), LARGEST) and angle(math.nan) == 0
    assert [number(x, 0.25) for x in (0.3, -0.3, 0.4, 1e30, -1e30)] == [1, -1, 2, LARGEST, -(2**31)]


def test_it_can_be_called_with_si_units(library: ctypes.CDLL) -> None:
    state = {"q": [0.3, -2.0], "qd": [1.0, -0.5], "qdd_motor": [4.0, 3.0]}
    tau, qdd = (ctypes.c_double * 2)(), (ctypes.c_double * 2)()
    library.planar_2r_fixed_inverse_dynamics_si(*((ctypes.c_double * 2)(*x) for x in state.values()), tau, qdd)
    with se.load(ROOT / "examples" / "planar_2r.toml", "inverse_dynamics") as model:
        wanted, _ = model.inverse_dynamics(**state)
    assert np.abs(np.array(tau) - wanted).max() < 1e-6 and list(qdd) == state["qdd_motor"]


# The command


def test_the_command_writes_header_and_source(tmp_path: Path) -> None:
    run("generate", ROOT / "examples" / "planar_2r.toml", "--model", "inverse_dynamics", "--target", "c-fixed",
        "--target", "c", "--out", tmp_path)  # fmt: skip
    names = {path.name for path in (tmp_path / "planar_2r").iterdir()}
    assert {"planar_2r_fixed.h", "planar_2r_fixed.c", "planar_2r.h"} <= names
    text = " ".join((tmp_path / "planar_2r" / "planar_2r_fixed.h").read_text().replace("*", " ").split())
    assert "q[0] 2^-32 turn" in text and "qd[0] 2^-29" in text and "proven" in text
    assert re.search(r"tau\[shoulder\]: -41\.\d+ to 41\.\d+, error at most \S+e-07, proven", text)


REFUSED = {
    "direct_dynamics": ("planar_2r.toml", {"models": "direct_dynamics"}, "divides by what moves"),
    "no limits": ("rx90.par", {"models": "inverse_dynamics"}, "limits"),
    "springs": ("two_axis.toml", {"models": "inverse_dynamics"}, "divides by what moves"),
    "time steps": ("planar_2r.toml", {"models": "inverse_dynamics", "steps": ["w3"]}, "has no time steps"),
    "wrenches": ("planar_2r.toml", {"models": "bias_forces", "scene": Scene(forces=("tip",))}, "f_ext has no limits"),
}


@pytest.mark.parametrize(("file", "asked", "why"), REFUSED.values(), ids=REFUSED)
def test_what_has_no_fixed_point_is_refused_by_name(file: str, asked: dict[str, Any], why: str, tmp_path: Path) -> None:
    models, more = asked["models"], {key: x for key, x in asked.items() if key != "models"}
    with pytest.raises(InputError, match=why) as error:
        se.generate(ROOT / "examples" / file, models, targets=["c-fixed"], out=tmp_path / "new", **more)
    assert "\n" not in str(error.value) and not (tmp_path / "new").exists()


def test_a_base_that_moves_freely_is_refused(tmp_path: Path) -> None:
    arm = tmp_path / "arm.toml"
    limits = "[limits]\nshoulder = { velocity = 2 }\nelbow = { velocity = 2 }\n"
    arm.write_text((ROOT / "examples" / "floating_arm.toml").read_text() + limits)
    with pytest.raises(InputError, match="has no limits: models that take it have no box"):
        se.generate(arm, "bias_forces", targets=["c-fixed"], out=tmp_path / "new")


@pytest.mark.thorough
def test_what_is_far_below_a_unit_is_zero(tmp_path: Path) -> None:
    """A moment of 1e-16 N m beside one of 10 N m: less than half a unit of the sum, also where it is a product."""
    tiny = {
        "name": "tiny",
        "joints": [{"name": "hinge", "antecedent": 0, "kind": "motor", "sigma": 0, "theta": "q1"}],
        "bodies": {"hinge": {"mass": 1, "inertia": [2, 2, 2]}},
        "friction": {"hinge": {"viscous": 1e-22}},
        "limits": {"hinge": {"velocity": 1, "acceleration": 5, "torque": 1}},
    }
    machine = the_machine(tiny)
    one = FixedCase(machine, DescribedMachine.of(machine).limits, "inverse_dynamics")
    assert "0*qd1*" in render_c_fixed(one.package)["tiny_fixed.c"]
    states = one.states(1000, np.random.default_rng(0))
    _, found = one.run(states, tmp_path)
    assert (np.abs(found * one.units - one.exact(states)).max(axis=0) <= one.proven).all()


@pytest.mark.thorough
@pytest.mark.parametrize("variable", ["sine", "angle", "k", "uint32_t", "tau_n", "hinge_fixed_product"])
def test_variables_may_be_called_like_words_of_the_code(variable: str, tmp_path: Path) -> None:
    machine = the_machine(
        {
            "name": "hinge",
            "gravity": [0, -9.81, 0],
            "joints": [{"name": "hinge", "antecedent": 0, "kind": "motor", "sigma": 0, "theta": variable}],
            "bodies": {"hinge": {"mass": 2, "center_of_mass": [0.5, 0, 0], "inertia": [0.1, 0.1, 0.1]}},
            "limits": {"hinge": {"velocity": 1, "acceleration": 1, "torque": 1}},
        }
    )
    one = FixedCase(machine, DescribedMachine.of(machine).limits, "inverse_dynamics")
    states = one.states(1000, np.random.default_rng(0))
    _, found = one.run(states, tmp_path)
    assert (np.abs(found * one.units - one.exact(states)).max(axis=0) <= one.proven + 1e-14).all()


class ReducedCase(FixedCase):
    """The same with terms left out of it within a tolerance, proven."""

    tolerance = "5 %"

    @cached_property
    def package(self) -> Package:
        within = Within({"": tolerance(self.tolerance)}, guaranteed=Evidence.PROVEN)
        machine = DescribedMachine.of(self.machine)
        scene = Scene((self.model,), within=within)
        asked, reduced = models_in_fixed_point(machine, scene, programs, announce_nothing, no_progress)
        assert reduced[0].reduction.left_out
        return with_scales(asked, self.limits, totals=fixed_totals(reduced))


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("name", "allowed"),
    [
        ("planar_2r", "60 %"),
        pytest.param("planar_2r", "20 %", marks=pytest.mark.thorough),
        pytest.param("machine tool", "1 %", marks=pytest.mark.thorough),
    ],
)
def test_terms_left_out_and_fixed_point_are_one_total(name: str, allowed: str, tmp_path: Path) -> None:
    whole = case(name)
    one = ReducedCase(whole.machine, whole.limits, whole.model)
    object.__setattr__(one, "tolerance", allowed)
    states = one.states(STATES, np.random.default_rng(3))
    in_box, found = one.run(states, tmp_path)
    assert in_box.all()
    error = np.abs(found * one.units - one.exact(states)).max(axis=0)
    assert (error <= one.proven + double_errors(name)).all()
    assert (one.proven > whole.proven).any()


@pytest.mark.sampled(2)
@pytest.mark.parametrize("precision", ["single", "fixed"])
def test_what_rounding_needs_is_not_left_out(precision: str, tmp_path: Path) -> None:
    """A tolerance that is hardly above the rounding of the whole model is kept: less is left out."""
    machine = ROOT / "examples" / "planar_2r.toml"
    target = {"targets": ["c-fixed"]} if precision == "fixed" else {"precisions": ["single"]}
    model, options = "inverse_dynamics", {"within": "2e-4 %", "guaranteed": "proven", "out": tmp_path}
    (one,) = se.generate(machine, model, **target, **options).reduced
    tolerances = {(error.output, error.index): error.tolerance for error in one.reduction.errors}
    for k, entry in enumerate(one.certificates[0].entries[:2]):
        assert 0 < entry.error <= tolerances["tau", k] * 1.001


@pytest.mark.thorough
def test_the_report_counts_instructions_of_fixed_point(tmp_path: Path) -> None:
    machine = ROOT / "examples" / "planar_2r.toml"
    whole, left = (
        se.generate(machine, "inverse_dynamics", targets=["c-fixed"], report=True, out=tmp_path / name, **more)
        for name, more in (("whole", {}), ("left", {"within": "20 %"}))
    )
    counts = [{one.name: one.cost.instructions for one in made.reports[0].functions} for made in (whole, left)]
    name = "planar_2r_fixed_inverse_dynamics"
    assert counts[1][name] < counts[0][name] and f"{name}_si" in counts[0]
