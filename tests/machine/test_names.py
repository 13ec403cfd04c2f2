"""Names that generated code could not carry are refused, with the reason."""

from __future__ import annotations

import builtins
import keyword
import re
import shutil
import subprocess
from pathlib import Path

import pytest

from symoro_elastic.machine import names
from symoro_elastic.machine.names import did_you_mean, quoted, reserved

FREE = "q1 th1 x D4 L12 RL4 XX1 MZ6 IA9 M1 m2 lc1 I1 g0 k4 K4 bed_yaw y_chain_1 j1 e E1 A1 w3 F_max M_x Base"
ALLOWED = FREE.split()


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
        ("np", "generated"),
        ("direct_dynamics", "generated"),
        ("nan", "generated"),
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
    q qd qdd tau p c qdd_motor pi Pi sin cos tan sqrt atan2 sign math np numpy JOINTS MOTORS ELASTIC PARAMETERS
    DEFAULTS FRAMES OUTPUTS parameters direct_dynamics inverse_dynamics inertia_matrix bias_forces geometric_model
    NULL NAN INFINITY EOF"""
    assert [name for name in listed.split() if reserved(name) is None] == []


def test_every_keyword_of_this_python_is_refused() -> None:
    assert [word for word in keyword.kwlist if reserved(word) is None] == []


def test_the_table_of_quantities_is_what_counts(monkeypatch: pytest.MonkeyPatch) -> None:
    assert reserved("beta7") is None and reserved("beta7_x") is None and reserved("sq_x") is None
    extended = {"scalars": ("beta",), "components": ("beta",), "prefixes": ("sq_",)}
    monkeypatch.setattr(names, "QUANTITIES", extended)
    assert reserved("beta7") and reserved("beta7_x") and reserved("sq_x")


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
    assert quoted("a\nb\x00") == repr("a\nb\x00")
    assert len(quoted("x" * 10_000)) < 70
    assert not re.search(r"[\x00-\x1f\x7f\u2028]", quoted("\u2028\x7f\x85"))


def test_suggestions() -> None:
    assert did_you_mean("alfa", ["alpha", "theta"]) == "; did you mean 'alpha'?"
    assert did_you_mean("ALPHA", ["alpha", "theta"]) == "; did you mean 'alpha'?"
    assert did_you_mean("zzzzz", ["b", "a"]) == "; there are: a, b"
    assert did_you_mean("zzzzz", [f"a{i}" for i in range(50)]) == ""
    assert did_you_mean("zzzzz", []) == ""
