"""Pages of machines whose equations of motion are too large for modes."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import Kind, Machine, Spring
from symoro_elastic.pages.drawing import page
from symoro_elastic.pages.drawing.page import shown_machine
from tests.references.random_machines import random_machine


def refused(*_: object, **__: object) -> Any:
    raise AssertionError("not for this machine")


def test_a_page_of_a_large_rigid_machine_misses_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(page, "motion_of", refused)
    monkeypatch.setattr(page, "MOST_IN_MODES", 3)
    driven = all_of(random_machine(4), Kind.MOTOR)
    assert not shown_machine(driven, {}).missing and not shown_machine(driven, {}).modes


def test_modes_of_a_large_machine_are_left_out_and_it_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(page, "motion_of", refused)
    monkeypatch.setattr(page, "MOST_IN_MODES", 3)
    (said,) = shown_machine(all_of(random_machine(4), Kind.ELASTIC), {}).missing
    assert said == "no modes, springs neutral: it has 5 joint variables, and modes are shown up to 3"


def all_of(machine: Machine, kind: Kind) -> Machine:
    spring = Spring(Formula.parse("1e4")) if kind is Kind.ELASTIC else Spring()
    joints = tuple(replace(one, kind=kind, spring=spring) for one in machine.joints)
    values = tuple(replace(p, value=p.value or Formula.parse(1)) for p in machine.parameters)
    return replace(machine, joints=joints, parameters=values)
