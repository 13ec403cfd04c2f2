"""Numbers of the table as parameters, so that a frequency has a sensitivity to each of them."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from typing import Any

from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.columns import LARGEST_SHARE, LEAST_ROUNDING, WITHOUT, Cell, Dimension, cells, with_cells
from symoro_elastic.machine.constants import with_constants
from symoro_elastic.machine.described import AnyMachine
from symoro_elastic.machine.formula import Formula, FormulaError, refuse_range
from symoro_elastic.machine.loops import branches
from symoro_elastic.machine.machine import Joint, Machine, Parameter
from symoro_elastic.machine.names import did_you_mean, quote

GEOMETRY = "joints"
"""The section of the file that holds lengths and angles."""


def with_named_cells(machine: AnyMachine) -> AnyMachine:
    """Return the machine with masses, stiffnesses, lengths ... as parameters `<joint>.<quantity>` with values.

    Parameters keep their names. Zeros and angles stay as they are: they are the structure of a machine. So do lengths
    in loops: one that changes alone may open a loop, as two sides of a parallelogram are equal.
    """
    named: list[Parameter] = []
    around = {j for loop in machine.loops for branch in branches(machine.antecedents, loop) for j in branch}
    numbered = enumerate(machine.joints, start=1)
    joints = tuple(_with_named_numbers(joint, named, GEOMETRY if j in around else "") for j, joint in numbered)
    return replace(machine, joints=joints, parameters=(*machine.parameters, *named))


def with_values(machine: AnyMachine, values: Mapping[str, float]) -> AnyMachine:
    """Return the machine with other values of parameters, or of the cells named by `with_named_cells`.

    Raises `InputError` for names that do not exist, and for values out of range or by which a mass is negative.
    """
    named = with_named_cells(machine)
    names = [parameter.name for parameter in named.parameters]
    refuse_values(machine, values, names)
    given = {name: Formula.parse(float(x)) for name, x in values.items()}
    parameters = tuple(replace(p, value=given.get(p.name, p.value)) for p in named.parameters)
    refuse_wrong_signs(named, values, {p.name: p.value.value() for p in parameters if p.value is not None})
    return with_constants(replace(named, parameters=parameters), names[len(machine.parameters) :])


def refuse_values(machine: Machine, values: Mapping[str, float], names: Sequence[str]) -> None:
    """Raise `InputError` for a value of a parameter that does not exist, or that is out of range."""
    source = machine.label
    for name, x in values.items():
        if name not in names:
            raise InputError(source, "--value", f"no parameter {quote(name)}{did_you_mean(name, names)}")
        try:
            refuse_range(x)
        except FormulaError as error:
            raise InputError(source, f"--value, {name}", str(error)) from None


def refuse_wrong_signs(machine: Machine, given: Collection[str], values: dict[str, float]) -> dict[str, float]:
    """Return the values; raises `InputError` where a given one makes a cell what a file may not give.

    That is negative masses and stiffnesses, a creep velocity of 0, a share near 1, edges too sharp of a backlash.
    """
    owners: list[tuple[str, Any]] = [(joint.name, joint) for joint in machine.joints]
    owners += [("base", body) for body in machine.free_bodies]
    for name, owner in owners:
        for cell, formula in cells(owner):
            is_given = not formula.names.isdisjoint(given) and formula.names <= values.keys()
            if is_given:
                _refuse_wrong(machine, f"{name}.{cell.name}", cell.column.dimension, formula, values)
        if isinstance(owner, Joint):
            _refuse_sharp(machine, owner, given, values)
    return values


def _refuse_wrong(
    machine: Machine, place: str, dimension: Dimension, formula: Formula, values: Mapping[str, float]
) -> None:
    try:
        value = formula.value(values)
    except FormulaError as error:
        raise InputError(machine.label, place, str(error)) from None
    what = ""
    if value < 0 and dimension.is_nonnegative:
        what = "is negative"
    elif value == 0 and dimension in WITHOUT:
        what = "must be above 0"
    elif value >= LARGEST_SHARE and dimension is Dimension.SHARE:
        what = f"must be below {LARGEST_SHARE}"
    if what:
        raise InputError(machine.label, place, f"{what}: {value:g} by {_by(formula, values)}")


def _refuse_sharp(machine: Machine, joint: Joint, given: Collection[str], values: Mapping[str, float]) -> None:
    rounding, backlash = joint.spring.rounding, joint.spring.backlash
    names = rounding.names | backlash.names
    if rounding.is_zero or names.isdisjoint(given) or not names <= values.keys():
        return
    if rounding.value(values) < LEAST_ROUNDING * backlash.value(values):
        what = f"is sharper than {LEAST_ROUNDING:g} of the backlash: {rounding.value(values):g}, give more"
        raise InputError(machine.label, f"{joint.name}.rounding", what)


def _by(formula: Formula, values: Mapping[str, float]) -> str:
    return ", ".join(f"{name} = {values[name]:g}" for name in sorted(formula.names))


def _with_named_numbers(joint: Joint, named: list[Parameter], kept: str) -> Joint:
    """The joint with names in place of the numbers that may be tuned, but those of the section `kept`.

    Their values are added to `named`.
    """

    def name(cell: Cell, formula: Formula) -> Formula:
        if formula.names or formula.is_zero or not cell.column.tunable or cell.column.section == kept:
            return formula
        name = f"{joint.name}.{cell.name}"
        named.append(Parameter(name, formula))
        return Formula(name, ("name", name))

    return with_cells(joint, name)
