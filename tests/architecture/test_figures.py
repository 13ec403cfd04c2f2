"""Measured figures on pages are those of the stored file, and ratios over other tools are marked by their names."""

from __future__ import annotations

import pytest

from tests.benchmarks import figures

NAMED = figures.figures()
WITHOUT_BUILDS = ("python_calls", "python_loops", "record", "problems")
"""Runs that compile no Pinocchio, or compiled it once when they were stored."""
PAGES = {str(path.relative_to(figures.ROOT)): page for path, page in figures.pages().items()}


@pytest.mark.parametrize("page", [page for page, text in PAGES.items() if "<!--" in text])
def test_figures_of_pages_are_the_stored_ones(page: str) -> None:
    """To write them: `python -m tests.benchmarks.figures --write`."""
    assert figures.rewritten(PAGES[page], NAMED) == PAGES[page]


def test_ratios_over_other_tools_are_marked() -> None:
    assert {page: ratios for page, text in PAGES.items() if (ratios := figures.unmarked(text))} == {}


def test_figures_differ_from_pages_that_were_edited() -> None:
    page = "Pinocchio: 9<!--call/most--> times faster, 1/8 of its time, 3 times slower\n\n2 times faster than before\n"
    assert figures.rewritten(page, {"call/most": 51.3}).startswith("Pinocchio: 51<!--")
    assert figures.unmarked(page) == ["1/8", "3 times slower"]


def test_every_run_names_its_conditions() -> None:
    for name, run in figures.stored().items():
        assert name in figures.RUNS
        assert run["instructions"] in ("AVX2", "AVX-512") or "not recorded" in run["instructions"]
        assert run["command"] == figures.RUNS[name].command and run["processor"] and run["compilers"] and run["figures"]
        assert run["compilers of Pinocchio"].count(",") == 1 or name in (
            "python_calls",
            "python_loops",
            "record",
            "problems",
        ), "both builds"
