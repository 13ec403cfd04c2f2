"""The paper can be found in the code: every equation is at a line, or has a reason."""

from __future__ import annotations

import pytest

from tests.house.equation_index import LAST, NOT_WRITTEN, PAGE, WHAT, index, page


@pytest.mark.parametrize("equation", range(1, LAST + 1))
def test_every_equation_is_written_or_has_a_reason(equation: int) -> None:
    written = equation in index()
    assert written != (equation in NOT_WRITTEN), "a marker `# (n)` at the line that carries it out, or a reason"
    assert written == (equation in WHAT)


def test_the_page_is_up_to_date() -> None:
    assert PAGE.read_text(encoding="utf-8") == page(), "python -m tests.house.equation_index --write"


def test_no_marker_has_another_number() -> None:
    assert set(index()) <= set(range(1, LAST + 1))
