"""Mutants change what is computed and nothing else, and tests that reach them are recorded."""

from __future__ import annotations

import ast
import sys
from types import ModuleType

import pytest

from tests.mutants import CORE, RECORDER, ROOT, draw, instrumented, mutants_of

TEXT = '''"""A module."""

from __future__ import annotations

LIMIT: int = 3


def largest(entries: list[int], least: int = 0) -> int:
    """Of all entries above the least."""
    found = {}
    for k, x in enumerate(entries):
        if not x > least and k:
            continue
        found[k] = -x
        largest.calls += 1
    if len(found) == 0:
        raise ValueError(1 + 1, f"none of {len(entries) + 1}")
    return max(LIMIT if found else 1, divmod(8, 3)[0])
'''


def test_every_kind_of_change_is_made_and_texts_of_errors_stay() -> None:
    found = {(mutant.before, mutant.after) for mutant in mutants_of("module.py", TEXT)}
    assert found >= {
        ("3", "(4)"),
        ("0", "(1)"),
        ("not x > least and k", "(not x > least or k)"),
        ("not x > least", "(x > least)"),
        ("x > least", "(x >= least)"),
        ("continue", "pass"),
        ("found[k] = -x", "pass"),
        ("-x", "(x)"),
        ("largest.calls += 1", "pass"),
        ("len(found) == 0", "(len(found) != 0)"),
        ("divmod(8, 3)", "(divmod(3, 8))"),
        ("LIMIT if found else 1", "(LIMIT if not found else 1)"),
    }
    assert not [pair for pair in found if "1 + 1" in pair[0] or "entries) + 1" in pair[0] or "int" in pair[0]]


@pytest.mark.thorough
def test_mutants_of_the_core_are_programs_that_differ() -> None:
    drawn = draw(CORE, 50, seed=3)
    assert drawn == draw(CORE, 50, seed=3) and len({*drawn}) == 50
    for mutant in drawn:
        text = (ROOT / mutant.file).read_bytes()
        assert ast.dump(ast.parse(mutant.apply(text))) != ast.dump(ast.parse(text)), mutant


def test_statements_that_run_are_recorded(monkeypatch: pytest.MonkeyPatch) -> None:
    recorder = ModuleType(RECORDER)
    recorder.reached = set()
    monkeypatch.setitem(sys.modules, RECORDER, recorder)
    numbers = {line: [line] for line in range(1, len(TEXT.splitlines()) + 1)}
    names: dict[str, object] = {}
    exec(compile(instrumented(TEXT, numbers), "module.py", "exec"), names)
    assert recorder.reached == {5}
    recorder.reached.clear()
    names["largest"].calls = 0
    assert names["largest"]([4, 0, 2]) == 3
    assert recorder.reached == {10, 11, 12, 13, 14, 15, 16, 18}
