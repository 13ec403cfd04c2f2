"""Numbers from elsewhere as formulas."""

from __future__ import annotations

from decimal import Decimal
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from symoro_elastic.machine.formula import Formula, FormulaError


@pytest.mark.parametrize(
    ("number", "text"),
    [
        (np.float64(0.1), "0.1"),
        (np.float64(-1e-300), "-1e-300"),
        (np.float32(0.5), "0.5"),
        (np.int64(-3), "-3"),
        (7, "7"),
        (Decimal("0.10"), "0.10"),
        (Fraction(1, 3), "1/3"),
    ],
)
def test_numbers_of_any_library(number: Any, text: str) -> None:
    formula = Formula.parse(number)
    assert formula.text == text and formula.value() == float(number)


@pytest.mark.parametrize("number", [np.float64("nan"), np.float64("inf"), True])
def test_what_is_no_number(number: Any) -> None:
    with pytest.raises(FormulaError):
        Formula.parse(number)


def test_formulas_are_shown_by_their_texts() -> None:
    """So that a table can be read where Python shows it."""
    assert repr(Formula.parse(" 2*L1 ")) == "Formula('2*L1')"
