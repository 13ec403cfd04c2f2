"""Columns of the table are declared once: checks, formats, values, sensitivities and tables cover all of them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, fields, is_dataclass, replace
from typing import Any, get_args, get_type_hints

import pytest

from symoro_elastic.formats.par import reading as par
from symoro_elastic.formats.toml import reading as toml
from symoro_elastic.machine.checks import formulas
from symoro_elastic.machine.columns import Cell, Dimension, cells, column, declared_columns, with_cells
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import Base, Body, Joint, Kind, Machine, Parameter, Spring
from symoro_elastic.machine.named_cells import with_named_cells
from symoro_elastic.machine.views import machine_table
from symoro_elastic.models.parameters.base_parameters import base_grouping
from symoro_elastic.numerics.evaluation.values import DRAWS, DRAWS_WHERE_NAMED, parameter_values

BODIES = (Dimension.MASS, Dimension.FIRST_MOMENT, Dimension.INERTIA)


@dataclass(frozen=True)
class PreloadedSpring(Spring):
    """A spring with one cell more."""

    preload: Formula = column(Dimension.MOMENT, "springs", "preload", symbol="F0", tunable=True)


@dataclass(frozen=True)
class PreloadedJoint(Joint):
    """A joint with such a spring."""

    spring: Spring = PreloadedSpring()


def named(cell: Cell, j: int) -> Formula:
    return Formula.parse(f"x{j}x" + cell.label.replace(" ", ""))


def full_machine(kind: type[Joint] = Joint) -> Machine:
    """An elastic joint and its motor, every cell of which is a parameter of its own; the motor has no spring."""
    base = with_cells(Base(), lambda cell, _: named(cell, 0))
    spring = with_cells(kind("flange", 1, Kind.ELASTIC, 0, "q2"), lambda cell, _: named(cell, 2))
    motor = with_cells(
        kind("drive", 0, Kind.MOTOR, 0, "q1"),
        lambda cell, formula: formula if cell.column.section == "springs" else named(cell, 1),
    )
    names = [formula.text for owner in (base, motor, spring) for _, formula in cells(owner) if formula.names]
    return Machine("full", (motor, spring), tuple(map(Parameter, names)), base)


def names_of(machine: Machine) -> list[str]:
    return [parameter.name for parameter in machine.parameters]


def formula_fields(owner: type) -> Iterator[tuple[str, int]]:
    """Fields of a class that hold formulas by their types, with the number of formulas."""
    hints = get_type_hints(owner)
    for one in fields(owner):
        hint: Any = hints[one.name]
        if hint is Formula:
            yield one.name, 1
        elif set(get_args(hint)) == {Formula}:
            yield one.name, len(get_args(hint))
        elif is_dataclass(hint):
            yield from formula_fields(hint)  # type: ignore[arg-type]


# The walk


@pytest.mark.parametrize("owner", [Joint, Body, Base])
def test_every_field_that_holds_formulas_is_a_column(owner: type) -> None:
    assert [(count) for _, count in formula_fields(owner)] == [len(one.cells) for one in declared_columns(owner)]


@pytest.mark.parametrize("central", [False, True])
def test_cells_of_a_joint_differ_in_label_key_and_name(central: bool) -> None:
    found = [cell for cell, _ in cells(replace(full_machine().joint(1), body=Body(central=central)))]
    for names in ([c.label for c in found], [c.name for c in found], [c.par for c in found if c.par]):
        assert len(set(names)) == len(names)


def test_a_change_of_nothing_changes_nothing() -> None:
    joint = full_machine().joint(2)
    assert with_cells(joint, lambda _, formula: formula) == joint
    assert [formula.text for _, formula in cells(joint)] == [named(cell, 2).text for cell, _ in cells(joint)]


# Who walks: a cell more is a cell more everywhere


@pytest.mark.parametrize("kind", [Joint, PreloadedJoint])
def test_checks_see_every_cell(kind: type[Joint]) -> None:
    machine = full_machine(kind)
    assert sorted(x for _, formula in formulas(machine) for x in formula.names) == sorted(names_of(machine))


@pytest.mark.parametrize("kind", [Joint, PreloadedJoint])
def test_every_dimension_has_values_of_its_own(kind: type[Joint]) -> None:
    """Names that no cell holds alone are drawn near one; here every name is a cell."""
    assert {*DRAWS, *DRAWS_WHERE_NAMED, *BODIES} == set(Dimension)
    machine = full_machine(kind)
    values = parameter_values(machine)
    assert values["x2xstiffness"] >= 100 and abs(values["x1xcoulombfriction"]) <= 1.0
    if kind is PreloadedJoint:
        assert abs(values["x2xpreload"]) >= 1.0
    assert values.keys() == {*names_of(machine)}


@pytest.fixture
def with_preload(monkeypatch: pytest.MonkeyPatch) -> None:
    """Formats that know the cell more."""
    monkeypatch.setattr(toml, "Joint", PreloadedJoint)


@pytest.mark.parametrize("form", [toml, par])
def test_formats_write_and_read_every_cell(form: Any) -> None:
    machine = full_machine()
    again = form.read(form.write(machine), "full")
    assert (again.joints, again.base) == (machine.joints, machine.base)
    assert sorted(names_of(again)) == sorted(names_of(machine))


@pytest.mark.parametrize("form", [toml, par])
def test_formats_write_and_read_a_cell_more(form: Any, with_preload: None) -> None:
    machine = full_machine(PreloadedJoint)
    again = form.read(form.write(machine), "full")
    assert again.joint(2).spring.preload.text == "x2xpreload" and again.joints == machine.joints
    assert sorted(names_of(again)) == sorted(names_of(machine))


@pytest.mark.parametrize("kind", [Joint, PreloadedJoint])
def test_numbers_that_may_be_tuned_get_names(kind: type[Joint]) -> None:
    numbers = iter(range(1, 1000))
    joint = with_cells(kind("flange", 0, Kind.ELASTIC, 0, "q1"), lambda *_: Formula.parse(next(numbers)))
    machine = with_named_cells(Machine("full", (joint,)))
    tunable = {f"flange.{cell.name}": formula for cell, formula in cells(joint) if cell.column.tunable}
    assert {p.name: p.value for p in machine.parameters} == tunable
    assert ("flange.preload" in tunable) == (kind is PreloadedJoint)
    assert not any(name.endswith(("alpha", "coulomb", "FX")) for name in tunable)


@pytest.mark.parametrize("kind", [Joint, PreloadedJoint])
def test_grouping_replaces_inertial_cells_and_no_others(kind: type[Joint]) -> None:
    numbers = {cell.label: Formula.parse(k) for k, (cell, _) in enumerate(cells(full_machine(kind).joint(2)), start=1)}
    joint = with_cells(kind("drive", 0, Kind.MOTOR, 0, "q1"), lambda cell, _: numbers[cell.label])
    (after,) = base_grouping(Machine("one", (joint,))).machine.joints
    changed = {old.column.section for (old, x), (_, y) in zip(cells(joint), cells(after), strict=True) if x != y}
    assert changed <= {"bodies", "motors"} and changed


@pytest.mark.parametrize("kind", [Joint, PreloadedJoint])
def test_the_table_shows_every_cell_with_a_symbol(kind: type[Joint]) -> None:
    column_of_laws = list(machine_table(full_machine(kind)).columns[-1][1])
    shown = {cell.column.symbol for cell, _ in cells(full_machine(kind).joint(2)) if cell.column.symbol}
    assert {entry.split(" = ")[0] for entry in column_of_laws[1].split(", ")} == shown
    assert {"k", "d", "q0", "Ia", "Fv", "Fs"} <= shown
