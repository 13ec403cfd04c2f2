"""What grows with the cube of the joints is not computed for large machines, and they say so."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import Base
from symoro_elastic.numerics import rank
from symoro_elastic.numerics.grouping import base_parameters, checked_grouping
from tests.references.random_machines import random_machine


def refused(*_: object, **__: object) -> Any:
    raise AssertionError("not for large machines")


def test_the_rank_of_a_large_tree_is_not_compared(monkeypatch: pytest.MonkeyPatch) -> None:
    machine = random_machine(4)
    compared, known = checked_grouping(machine)
    monkeypatch.setattr(rank, "MOST_COMPARED", 3)
    monkeypatch.setattr(rank, "stacked_regressor", refused)
    found, check = checked_grouping(machine)
    assert found.formulas == compared.formulas and check.count == known.rank
    assert check.rank is None and check.conditioning is None and check.torques_stay
    shown_ones = base_parameters(machine)
    assert f"{check.count} base parameters, by the rules (torques stay within" in shown_ones.check
    assert shown_ones.condition is None and "no condition number" in shown_ones.conditioning


def test_a_wrong_grouping_of_a_large_tree_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rank, "MOST_COMPARED", 3)
    machine = random_machine(4)
    found = checked_grouping(machine)[0]
    wrong = replace(found, machine=replace(found.machine, base=Base(gravity=(Formula.parse(7),) * 3)))
    assert "torques change by" in rank.cross_check(machine, wrong).doubt
