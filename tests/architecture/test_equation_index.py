"""The paper, and the equations of closed chains, can be found in the code: each is at a line, or has a reason."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.architecture import equation_index
from tests.architecture.equation_index import (
    INDEX,
    LAST,
    LOOPS_PAGE,
    NOT_WRITTEN,
    OF_LOOPS,
    PAGES,
    WHAT,
    Place,
    index,
    loops_without_row,
    without_row,
    written_out,
)


@pytest.mark.parametrize("equation", range(1, LAST + 1))
def test_every_equation_is_written_or_has_a_reason(equation: int) -> None:
    written = equation in index()
    assert written != (equation in NOT_WRITTEN), "a marker `# (n)` at the line that carries it out, or a reason"
    assert written == (equation in WHAT)


def test_no_marker_has_another_number() -> None:
    assert without_row() == []


def test_every_equation_of_loops_that_is_cited_is_written_out() -> None:
    assert loops_without_row() == []
    assert written_out() == OF_LOOPS.keys() and len(OF_LOOPS) == 49


@pytest.mark.parametrize("path", PAGES, ids=lambda path: path.name)
def test_the_pages_are_up_to_date(path: Path) -> None:
    assert path.read_text(encoding="utf-8") == PAGES[path](), "python -m tests.architecture.equation_index --write"


@pytest.mark.thorough
def test_a_number_without_a_row_is_a_sentence(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(equation_index, "index", lambda: {62: [Place("symoro_elastic/mechanics/energy.py", "power")]})
    first, *others = without_row()
    assert first.startswith("symoro_elastic/mechanics/energy.py, power: (62) has no row: add it to WHAT")
    assert len(others) == len(WHAT) and others[0].startswith("[1] placement of frame j")

    page = tmp_path / LOOPS_PAGE.name
    above = LOOPS_PAGE.read_text(encoding="utf-8").split(INDEX)[0]
    lost = "\n".join(line for line in above.splitlines() if not line.endswith("(L31)"))
    new = f"(L{max(OF_LOOPS) + 1})"
    page.write_text(f"{lost}\n```\nq = 1    {new}\n```\n", encoding="utf-8")
    monkeypatch.setattr(equation_index, "LOOPS_PAGE", page)
    written_out.cache_clear()
    sentences = "\n".join(loops_without_row())
    written_out.cache_clear()
    cited = (
        "symoro_elastic/mechanics/loops/motors.py: cites (L31), which docs/loop_equations.md does not have: write it"
    )
    assert cited in sentences
    assert f"docs/loop_equations.md: {new} has no row: say what it is" in sentences
