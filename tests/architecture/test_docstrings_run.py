"""Programs in docstrings of packages run as they stand."""

from __future__ import annotations

import doctest
import importlib

import pytest

from tests.golden import ROOT


def test_the_first_session_prints_what_it_says(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    found = doctest.testmod(importlib.import_module("symoro_elastic"))
    assert found.attempted >= 5
    assert not found.failed


@pytest.mark.thorough
@pytest.mark.parametrize("module", ["symoro_elastic.analysis.vibration"])
def test_programs_in_docstrings_run(module: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """From the first import to the next sentence."""
    pytest.importorskip("scipy")
    monkeypatch.chdir(ROOT)
    paragraphs = str(importlib.import_module(module).__doc__).split("\n\n")
    first = next(k for k, paragraph in enumerate(paragraphs) if paragraph.startswith("from "))
    names: dict[str, object] = {}
    exec("\n".join(paragraphs[first : first + 2]), names)
    assert names["machine"].name == "two_axis"  # type: ignore[attr-defined]
