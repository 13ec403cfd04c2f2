"""Names that generated code could not carry are refused, with the reason."""

from __future__ import annotations

import builtins
import keyword
import re
import shutil
import subprocess

import pytest

from symoro_elastic.machine import names
from symoro_elastic.machine.names import did_you_mean, quoted, reserved

ALLOWED = "q1 th1 x D4 L12 RL4 XX1 MZ6 IA9 M1 m2 lc1 I1 g0 k4 K4 bed_yaw y_chain_1 j1 e E1 A1 w3 F_max M_x Base".split()


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
        ("а", "letters"),  # Cyrillic
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
    listed = """q qd qdd tau p c qdd_motor pi Pi sin cos tan sqrt atan2 sign math np numpy JOINTS MOTORS ELASTIC PARAMETERS
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
def test_words_of_c_and_cpp_are_refused_as_the_compilers_do(tmp_path) -> None:
    """A word that math.h and the language let a function use as its variable may be free; no other may."""
    candidates = sorted({*names.KEYWORDS, *ALLOWED, "M_E", "FP_NAN", "HUGE_VAL", "isnan", "sin", "y0", "j1"})
    for name in candidates:
        source = tmp_path / "word.c"
        source.write_text(f"#include <math.h>\ndouble value(double a) {{ const double {name} = a; return {name}; }}\n")
        for arguments in (["-std=c99"], ["-x", "c++"]):
            command = ["gcc", *arguments, "-fsyntax-only", "-Werror", "-Wall", "-Wextra", "-Wpedantic", str(source)]
            refused = subprocess.run(command, capture_output=True, check=False).returncode != 0
            assert not refused or reserved(name), (name, arguments)


def test_builtins_that_generated_python_calls_are_refused() -> None:
    called = "len range tuple zip ValueError TypeError KeyError".split()
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
