"""Names that generated code could not carry are refused, with the reason."""

from __future__ import annotations

import builtins
import keyword
import re
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path

import pytest

from symoro_elastic.formats.toml import reading as toml
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.generation.pipeline import programs
from symoro_elastic.machine.checks import check
from symoro_elastic.machine.names import did_you_mean, quote
from symoro_elastic.machine.names import why_reserved as reserved_beside
from symoro_elastic.machine.scene import Scene
from symoro_elastic.models.packaging import reserved_words
from symoro_elastic.quantities import INTERMEDIATES, Intermediate
from symoro_elastic.quantities.units import NUMBER
from tests.machine.samples import TOML

FREE = "q1 th1 x D4 L12 RL4 XX1 MZ6 IA9 M1 m2 lc1 I1 g0 k4 K4 bed_yaw y_chain_1 j1 e E1 A1 w3 F_max M_x Base"
ALLOWED = FREE.split()


def reserved(name: str) -> str | None:
    """The reason that a machine's file is refused for, words of models and targets included."""
    return reserved_beside(name, reserved_words())


@pytest.mark.parametrize("name", ALLOWED)
def test_ordinary_names_are_free(name: str) -> None:
    assert reserved(name) is None


@pytest.mark.parametrize(
    ("name", "reason"),
    [
        ("", "letters"),
        ("1a", "letters"),
        ("a b", "letters"),
        ("a-b", "letters"),
        ("é", "letters"),
        ("\u0430", "letters"),  # Cyrillic
        ("a\n", "letters"),
        ("_a", "starts with a letter"),
        ("a__b", "two underscores"),
        ("a" * 64, "63"),
        ("int", "keyword"),
        ("lambda", "keyword"),
        ("constexpr", "keyword"),
        ("I", "libraries"),
        ("M_PI", "libraries"),
        ("DBL_MAX", "libraries"),
        ("qdd_motor", "generated"),
        ("direct_dynamics", "generated"),
        ("nan", "formulas"),
        ("H5", "intermediate"),
        ("qd12", "intermediate"),
        ("K5_33", "intermediate"),
        ("sin4_x", "intermediate"),
        ("sin_x", "intermediate"),
    ],
)
def test_reasons(name: str, reason: str) -> None:
    assert reason in (reserved(name) or "allowed")


def test_every_name_the_contract_reserves() -> None:
    listed = """
    q qd qdd tau qdd_motor pi Pi sin cos tan sqrt atan2
    direct_dynamics inverse_dynamics inertia_matrix bias_forces geometric_model
    NULL NAN INFINITY EOF"""
    assert [name for name in listed.split() if reserved(name) is None] == []


def test_names_of_generated_code_itself_are_free() -> None:
    """Generated code avoids the clash (codegen/test_local_names.py)."""
    listed = """
    p c sign math np numpy JOINTS MOTORS ELASTIC PARAMETERS DEFAULTS FRAMES OUTPUTS parameters b x t T M K spill sine
    cosine angle stride live LOAD STORE states numbers"""
    assert [name for name in listed.split() if reserved(name)] == []


@pytest.mark.parametrize("name", ["math", "np", "numpy"])
def test_no_machine_is_called_as_a_module_that_its_code_imports(name: str) -> None:
    with pytest.raises(InputError, match=f"name: the name '{name}' cannot be used: .*; '{name}_' is free"):
        check(toml.read(TOML.replace('"arm"', f'"{name}"'), "arm.toml"), reserved_words())


def test_every_keyword_of_this_python_is_refused() -> None:
    assert [word for word in keyword.kwlist if reserved(word) is None] == []


def test_the_table_of_quantities_is_what_counts(monkeypatch: pytest.MonkeyPatch) -> None:
    assert reserved("beta7") is None and reserved("beta7_x") is None
    row = Intermediate("beta", "", "b", "", "@", "", (), NUMBER, "a quantity that is not there")
    monkeypatch.setattr("symoro_elastic.quantities.INTERMEDIATES", [*INTERMEDIATES, row])
    assert reserved("beta7") and reserved("beta7a") and reserved("beta7_x") is None
    component = replace(row, component="axis")
    monkeypatch.setattr("symoro_elastic.quantities.INTERMEDIATES", [*INTERMEDIATES, row, component])
    assert reserved("beta7") and reserved("beta7_x")


def test_words_of_models_and_targets_are_handed_in() -> None:
    """The machine's room does not know them: `read_machine` and `check` are given them."""
    assert reserved_beside("direct_dynamics") is None and reserved("direct_dynamics")
    machine = toml.read(TOML.replace("base_yaw", "direct_dynamics"), "arm.toml")
    assert check(machine) == []
    with pytest.raises(InputError, match=r"the name 'direct_dynamics' cannot be used: generated code uses this name"):
        check(machine, reserved_words())
    with pytest.raises(InputError, match=r"direct_dynamics: generated code uses this name"):
        _ = programs(machine, Scene()).package


@pytest.mark.skipif(shutil.which("gcc") is None, reason="needs gcc")
@pytest.mark.parametrize("language", [["-std=c99"], ["-std=gnu17"], ["-x", "c++"]], ids=["c99", "gnu17", "c++"])
def test_macros_are_refused_and_free_names_compile(language: list[str], tmp_path: Path) -> None:
    source = tmp_path / "words.c"
    declared = "".join(f"const double {name} = a; (void){name};\n" for name in ALLOWED)
    source.write_text(f"#include <math.h>\nvoid words(double a);\nvoid words(double a) {{\n{declared}}}\n")
    strict = ["-Werror", "-Wall", "-Wextra", "-Wpedantic"]
    subprocess.run(["gcc", *language, *strict, "-fsyntax-only", str(source)], check=True)
    if "c++" in language:  # its math.h draws in headers that generated C never sees
        return
    macros = subprocess.run(["gcc", *language, "-dM", "-E", str(source)], check=True, capture_output=True, text=True)
    defined = re.findall(r"^#define ([A-Za-z]\w*)", macros.stdout, re.MULTILINE)
    assert len(defined) > 10
    assert [name for name in defined if reserved(name) is None] == []


def test_builtins_that_generated_python_calls_are_refused() -> None:
    called = ["len", "range", "tuple", "zip", "ValueError", "TypeError", "KeyError"]
    assert all(hasattr(builtins, name) for name in called)
    assert [name for name in called if reserved(name) is None] == []


def test_quoted_is_one_short_line() -> None:
    assert quote("a\nb\x00") == repr("a\nb\x00")
    assert len(quote("x" * 10_000)) < 70
    assert not re.search(r"[\x00-\x1f\x7f\u2028]", quote("\u2028\x7f\x85"))


def test_suggestions() -> None:
    assert did_you_mean("alfa", ["alpha", "theta"]) == "; did you mean 'alpha'?"
    assert did_you_mean("ALPHA", ["alpha", "theta"]) == "; did you mean 'alpha'?"
    assert did_you_mean("zzzzz", ["b", "a"]) == "; there are: a, b"
    assert did_you_mean("zzzzz", [f"a{i}" for i in range(50)]) == ""
    assert did_you_mean("zzzzz", []) == ""


def test_messages_that_list_names_are_short_and_one_line() -> None:
    said = did_you_mean("lift", ["a" * 1000, "b\nc", "tip"])
    assert said == f"; there are: {'a' * 57}..., b\\nc, tip"
