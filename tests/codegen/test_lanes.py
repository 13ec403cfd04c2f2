"""Congruent limbs in the lanes of vectors: the bits of the text without them, and fewer operations."""

from __future__ import annotations

import re
import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from symoro_elastic.codegen.c.lanes import LanesFunction, in_lanes, operations
from symoro_elastic.codegen.compile import CompiledPackage, compile_library
from symoro_elastic.codegen.package import Package
from symoro_elastic.codegen.precision import DOUBLE, DOUBLE_DOUBLE, MIXED, SINGLE, Precision
from symoro_elastic.codegen.printed_order import in_printed_order
from symoro_elastic.codegen.targets.c import functions_of, render_c
from symoro_elastic.codegen.targets.numpy import render_numpy
from symoro_elastic.formats.toml.reading import machine_of
from symoro_elastic.formats.toml.tables import table_of
from symoro_elastic.generation.pipeline import programs
from symoro_elastic.machine.formula import ZERO
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.scene import ALL, Scene
from tests.benchmarks.machines import arm_6, humanoid, quadruped, with_base_parameters
from tests.generated_code import STRICT
from tests.references.limbs import with_limbs

INVERSE, DIRECT, MATRIX = "inverse_dynamics", "direct_dynamics", "inertia_matrix"
DERIVED = ("inverse_dynamics_derivatives", "direct_dynamics_derivatives")
EXACT = ("-ffp-contract=off", *STRICT)
TRAPS = ("-fsanitize=undefined", "-fsanitize-undefined-trap-on-error")
"""Makes undefined behaviour end the process."""
COMPILERS = [name for name in ("gcc", "clang", "clang-19") if shutil.which(name)]
pytestmark = pytest.mark.skipif(not COMPILERS, reason="needs GCC or Clang")


def gantry() -> Machine:
    """A bed with two columns that bend and twist, each with a carriage; the second one is mirrored."""
    joints = [{"name": "bed", "kind": "motor", "sigma": 1, "alpha": "pi/2", "r": "x"}]
    for side, sign in (("left", ""), ("right", "-")):
        rows = (("bend", 0, f"{sign}0.8", 0), ("twist", 0, 0, 0.3), ("carriage", 1, 0, 0))
        for k, (name, sigma, d, r) in enumerate(rows):
            variable = f"{side}_{name}_q"
            row = {"name": f"{side}_{name}", "antecedent": joints[-1]["name"] if k else "bed", "sigma": sigma, "d": d}
            row |= {"kind": "motor" if sigma else "elastic", "alpha": "pi/2", "r": variable if sigma else r}
            joints.append(row | ({} if sigma else {"theta": variable}))
    springs = {
        f"{s}_{name}": {"stiffness": 2e6, "damping": 80} for s in ("left", "right") for name in ("bend", "twist")
    }
    bodies = {
        str(joint["name"]): {
            "mass": 40 + k,
            "first_moments": [1.5, 0.1 * k + 0.2, 2],
            "inertia_at_origin": [3, 4, 5 + k],
        }
        for k, joint in enumerate(joints)
    }
    table = {"name": "gantry2", "joints": joints, "bodies": bodies, "springs": springs, "gravity": [0, 0, -9.81]}
    return machine_of(table_of(table, "gantry"))


def of_limbs(seed: int, copies: int, symbolic: bool) -> Callable[[], Machine]:
    return lambda: with_limbs(seed, copies, symbolic=symbolic)


CASES: dict[str, tuple[Callable[[], Machine], tuple[str, ...], str | tuple[str, ...]]] = {
    "quadruped": (quadruped, (INVERSE, DIRECT, MATRIX), ()),
    "quadruped, folded": (quadruped, (INVERSE, DIRECT, MATRIX), ALL),
    "quadruped, derivatives": (lambda: with_base_parameters(quadruped()), DERIVED, ()),
    "humanoid": (humanoid, (INVERSE, DIRECT, MATRIX), ()),
    "humanoid, folded": (lambda: with_base_parameters(humanoid()), (INVERSE, DIRECT, MATRIX), ALL),
    "gantry": (gantry, (INVERSE, DIRECT, MATRIX, "bias_forces"), ()),
    **{
        f"limbs {seed}, {copies}{', symbolic' if symbolic else ''}": (
            of_limbs(seed, copies, symbolic),
            (INVERSE, DIRECT, MATRIX),
            (),
        )
        for seed in range(8)
        for copies in (2, 4, 6)
        for symbolic in (False, True)
    },
}


def package_of(machine: Machine, *models: str, fold: str | tuple[str, ...] = ()) -> Package:
    return programs(machine, Scene(models=models, fold=fold)).package


def vectors_in(package: Package) -> list[LanesFunction | None]:
    """The functions on vectors, None for those that are not worth them."""
    return [in_lanes(function) for function in functions_of(package, DOUBLE)]


@pytest.mark.sampled(60)
@pytest.mark.parametrize("compiler", COMPILERS)
@pytest.mark.parametrize("case", CASES)
def test_lanes_give_the_bits_of_the_text_without_vectors(case: str, compiler: str, tmp_path: Path) -> None:
    compare_with_numbers(case, compiler, DOUBLE, tmp_path)


@pytest.mark.sampled(10)
@pytest.mark.parametrize("precision", [SINGLE, MIXED], ids=lambda precision: precision.name)
@pytest.mark.parametrize("compiler", COMPILERS)
@pytest.mark.parametrize("case", ["quadruped", "quadruped, folded", "humanoid", "gantry", "limbs 3, 6"])
def test_lanes_of_floats_do_too(case: str, compiler: str, precision: Precision, tmp_path: Path) -> None:
    compare_with_numbers(case, compiler, precision, tmp_path)


def compare_with_numbers(case: str, compiler: str, precision: Precision, tmp_path: Path) -> None:
    """Call all models of a case with and without vectors."""
    build, models, fold = CASES[case]
    package = package_of(build(), *models, fold=fold)
    files = render_c(package, precision)
    assert any("lanes" in text for text in files.values())
    flags = {"lanes": ("-O0", *(TRAPS if compiler == "gcc" else ())), "numbers": ("-O0", "-DNO_VECTORS")}
    lanes, numbers = (
        CompiledPackage(package, compile_library(files, tmp_path / name, [compiler], [*EXACT, *own]), precision)
        for name, own in flags.items()
    )
    for function in package.functions:
        random = np.random.default_rng(3)
        state = {a.name: random.uniform(-2, 2, (20, a.size)) for a in function.arguments}
        wanted, found = numbers.call(function.name, **state), lanes.call(function.name, **state)
        for name, values in wanted.items():
            assert np.isfinite(values).all()
            assert np.array_equal(values, found[name]), (function.name, name)


@pytest.mark.parametrize(
    ("build", "fold", "most"),
    [(humanoid, (), 0.56), (humanoid, ALL, 0.62), (quadruped, (), 0.37), (quadruped, ALL, 0.45), (gantry, (), 0.8)],
)
def test_operations_that_remain(build: Callable[[], Machine], fold: str | tuple[str, ...], most: float) -> None:
    """A vector counts once: two limbs nearly halve the operations, four leave a third."""
    (function,) = functions_of(package_of(build(), INVERSE, fold=fold), DOUBLE)
    vectors = in_lanes(function)
    assert vectors
    assert operations(vectors) < most * operations(function)


@pytest.mark.thorough
def test_text_is_carried_out_as_the_graph_has_it() -> None:
    for fold in (), ALL:
        for function in package_of(quadruped(), INVERSE, DIRECT, fold=fold).functions:
            assert in_printed_order(function.program)[0] is function.program


@pytest.mark.thorough
def test_joints_and_quantities_keep_their_names() -> None:
    text = render_c(package_of(humanoid(), INVERSE))["humanoid.c"]
    assert "const lanes2 qd2 = {qd[1], qd[7]};" in text
    assert "const lanes2 w2_x = qd1*sin_q2;" in text
    assert re.search(r"joint 2 \(left_leg_hip_roll\) with 8\s+(\* )?\(right_leg_hip_roll\)", text)
    assert "const double w8_x = qd7*sin_q8;" in text
    assert "lanes4" in render_c(package_of(quadruped(), INVERSE))["quadruped.c"]


def test_machines_without_limbs_and_other_forms_have_no_vectors() -> None:
    assert "lanes" not in render_c(package_of(arm_6(), INVERSE))["rx90.c"]
    package = package_of(quadruped(), INVERSE)
    assert not any("lanes" in text for text in render_c(package, DOUBLE_DOUBLE).values())
    assert not any("lanes" in text for text in render_numpy(package).values())


def test_a_limb_that_differs_in_a_zero_is_none() -> None:
    machine = with_base_parameters(humanoid())
    knee = machine.joint(4)
    other = replace(knee, body=replace(knee.body, moments=(ZERO, *knee.body.moments[1:])), d=ZERO)
    changed = replace(machine, joints=(*machine.joints[:3], other, *machine.joints[4:]))
    package = package_of(changed, INVERSE)
    assert not {2, 3, 4, 8, 9, 10} & {j for group in package.limbs for j in group}
    assert {16, 23} <= {j for group in package.limbs for j in group}


def test_a_renaming_that_is_no_symmetry_is_not_worth_it() -> None:
    package = package_of(arm_6(), INVERSE)
    names = [("q2", "q5"), ("qd2", "qd5"), ("qdd2", "qdd5"), ("q3", "q6"), ("qd3", "qd6"), ("qdd3", "qdd6")]
    assert vectors_in(replace(package, congruent=tuple(names))) == [None]


@pytest.mark.thorough
def test_names_of_users_are_kept_apart(tmp_path: Path) -> None:
    """A parameter may be called as a type of vectors is."""
    machine = quadruped()
    text = {p.name: "lanes4" if p.name == "D5" else p.name for p in machine.parameters}
    joint = machine.joint(5)
    joints = (*machine.joints[:4], replace(joint, d=type(joint.d).parse("lanes4")), *machine.joints[5:])
    parameters = tuple(replace(p, name=text[p.name]) for p in machine.parameters)
    package = package_of(replace(machine, joints=joints, parameters=parameters), INVERSE)
    assert any(vectors_in(package))
    compile_library(render_c(package), tmp_path, [COMPILERS[0]], [*EXACT, "-O0"])
