"""Blocks that repeat become functions in long programs: the same numbers, text that does not grow, calls as cheap."""

from __future__ import annotations

import re
import shutil
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from symoro_elastic.codegen.c import function as c_function
from symoro_elastic.codegen.c import rows
from symoro_elastic.codegen.compile import CompiledPackage, compile_library
from symoro_elastic.codegen.package import Package
from symoro_elastic.codegen.precision import DOUBLE, DOUBLE_DOUBLE, MIXED, SINGLE, Precision
from symoro_elastic.codegen.targets.c import render_c
from symoro_elastic.codegen.targets.c_batch import render_c_batch
from symoro_elastic.codegen.targets.cpp import render_cpp
from symoro_elastic.generation.pipeline import programs
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.scene import ALL, Scene
from tests.benchmarks import contest
from tests.benchmarks.instructions import available, per_call
from tests.benchmarks.machines import chain, humanoid
from tests.benchmarks.ours import code
from tests.codegen import test_cpp
from tests.generated_code import STRICT

pytestmark = pytest.mark.sampled(5)

INVERSE, DIRECT = "inverse_dynamics", "direct_dynamics"
DERIVED = "inverse_dynamics_derivatives"
BOTH = (INVERSE, DIRECT)
CASES = {
    "chain": (chain, 14, (), DOUBLE, BOTH),
    "folded": (chain, 14, ALL, DOUBLE, BOTH),
    "single": (chain, 10, (), SINGLE, BOTH),
    "mixed": (chain, 10, ALL, MIXED, BOTH),
    "tree": (lambda _: humanoid(), 29, (), DOUBLE, BOTH),
    "large results": (chain, 9, (), DOUBLE, (DERIVED,)),
    "large results, mixed": (chain, 9, (), MIXED, (DERIVED,)),
}


@cache
def package_of(n: int, model: str = INVERSE, fold: tuple[str, ...] = ()) -> Package:
    return programs(chain(n), Scene(models=(model,), fold=fold)).package


@pytest.fixture
def outlined(monkeypatch: pytest.MonkeyPatch) -> None:
    """Blocks that repeat become functions in short programs, too."""
    monkeypatch.setattr(c_function, "OUTLINED_FROM", 0)


@pytest.mark.sampled(12)
@pytest.mark.parametrize("case", CASES)
def test_functions_give_the_bits_of_straight_lines(case: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    build, n, fold, precision, models = CASES[case]
    package = programs(build(n), Scene(models=models, fold=fold)).package
    straight = loaded(package, precision, tmp_path / "straight")
    monkeypatch.setattr(c_function, "OUTLINED_FROM", 0)
    monkeypatch.setattr(rows, "FEWEST_RESULTS", 64)
    in_functions = loaded(package, precision, tmp_path / "functions")
    files = render_c(package, precision)
    assert calls(files) > 5
    assert ("place[k][1]" in "".join(files.values())) == (DERIVED in models)
    for function in package.functions:
        random = np.random.default_rng(5)
        state = {a.name: random.uniform(-2, 2, (20, a.size)) for a in function.arguments}
        wanted, found = straight.call(function.name, **state), in_functions.call(function.name, **state)
        for name, values in wanted.items():
            assert np.isfinite(values).all()
            assert np.array_equal(values, found[name])


@pytest.mark.sampled(12)
@pytest.mark.parametrize("case", CASES)
def test_batches_in_functions_give_the_bits_of_straight_lines(
    case: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    build, n, fold, precision, models = CASES[case]
    package = programs(build(n), Scene(models=models, fold=fold)).package
    straight = loaded(package, precision, tmp_path / "straight")
    monkeypatch.setattr(c_function, "OUTLINED_FROM", 0)
    monkeypatch.setattr(rows, "FEWEST_RESULTS", 64)
    files = render_c_batch(package, precision)
    assert calls(files, "_batch.c") > 5
    batch = loaded(package, precision, tmp_path / "functions", files)
    for function in package.functions:
        random = np.random.default_rng(5)
        state = {a.name: random.uniform(-2, 2, (35, a.size)) for a in function.arguments}
        wanted, found = straight.call(function.name, **state), batch.call_batch(function.name, **state)
        for name, values in wanted.items():
            assert np.isfinite(values).all()
            assert np.array_equal(values, found[name])


@pytest.mark.thorough
@pytest.mark.skipif(not test_cpp.COMPILERS or not shutil.which("gcc"), reason="needs compilers of C and C++")
def test_templates_in_functions_have_the_bits_of_c(outlined: None, tmp_path: Path) -> None:
    assert len(re.findall(r"Called\s+(?:\*\s+)?\d+", render_cpp(test_cpp.package("long"))["chain22.hpp"])) >= 2
    assert test_cpp.differing("long", DOUBLE, tmp_path) == []


def loaded(
    package: Package, precision: Precision, folder: Path, files: dict[str, str] | None = None
) -> CompiledPackage:
    flags, files = ("-O0", "-ffp-contract=off"), files or render_c(package, precision)
    return CompiledPackage(package, compile_library(files, folder, flags=flags), precision)


def calls(files: dict[str, str], end: str = ".c") -> int:
    """Calls of functions for repeated blocks, in the file whose name ends so."""
    (text,) = (text for name, text in files.items() if name.endswith(end))
    return sum(int(times) for times in re.findall(r"Called\s+(?:\*\s+)?(\d+)", text))


def test_a_long_chain_has_hardly_more_statements() -> None:
    """Beyond about 60 joints there are more calls, not more statements."""
    few, many = (statements(render_c(package_of(n))) for n in (72, 144))
    whole = len(package_of(144).functions[0].program.statements)
    assert many < 1.1 * few
    assert many < 0.3 * whole


def statements(files: dict[str, str]) -> int:
    """Assignments to variables that compute: those that read an entry of an array do not count."""
    (text,) = (text for name, text in files.items() if name.endswith(".c"))
    text = text[text.index("Called ") :]
    return len(re.findall(r"^    const double \w+ = .*[-+*/]", text, re.MULTILINE))


@pytest.mark.thorough
@pytest.mark.skipif(not available(), reason="callgrind counts instructions: install valgrind")
def test_instructions_grow_by_less_than_a_third(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Loads and stores of what is handed on; the time of a call falls where the straight line is long."""
    monkeypatch.setattr(contest, "BUILD", tmp_path)
    made = code(chain(12), DIRECT, fold=False)
    straight = per_call(made, "gcc")
    monkeypatch.setattr(c_function, "OUTLINED_FROM", 0)
    called, counted = calls(made.files), per_call(made, "gcc")
    assert called > 5
    assert straight < counted < 1.3 * straight


def test_short_programs_and_pairs_stay_straight(monkeypatch: pytest.MonkeyPatch) -> None:
    package = package_of(12)
    assert calls(render_c(package)) == 0
    assert calls(render_c_batch(package), "_batch.c") == 0
    pairs = render_c(package, DOUBLE_DOUBLE)
    monkeypatch.setattr(c_function, "OUTLINED_FROM", 0)
    in_pairs = render_c(package, DOUBLE_DOUBLE)
    assert in_pairs == pairs


def test_names_of_users_are_kept_apart(outlined: None, tmp_path: Path) -> None:
    """Parameters may be called as the arguments of functions would be."""
    machine = with_parameters(chain(16), {"D9": "number", "D10": "from_w4_x", "D11": "to_sin_q5", "D12": "sine"})
    package = programs(machine, Scene(models=(INVERSE,))).package
    plain = package_of(16)
    state = {a.name: np.linspace(-1.0, 1.0, a.size) for a in plain.functions[0].arguments}
    found = loaded(package, DOUBLE, tmp_path / "named").call(INVERSE, **state)
    wanted = loaded(plain, DOUBLE, tmp_path / "plain").call(INVERSE, **state)
    assert np.array_equal(found["tau"], wanted["tau"])


def with_parameters(machine: Machine, names: dict[str, str]) -> Machine:
    """The machine with parameters by other names."""

    def other(text: str) -> str:
        return names.get(text, text)

    joints = tuple(replace(j, d=Formula.parse(other(str(j.d)))) for j in machine.joints)
    parameters = tuple(replace(p, name=other(p.name)) for p in machine.parameters)
    return replace(machine, joints=joints, parameters=parameters)


@pytest.mark.thorough
def test_functions_compile_without_a_warning(outlined: None, tmp_path: Path) -> None:
    strict = (*STRICT, "-Wconversion", "-Wshadow", "-Wundef", "-Wstrict-prototypes", "-O1")
    compile_library(render_c(package_of(16, INVERSE, ALL), MIXED), tmp_path, flags=strict)
