"""Numbers of the table as parameters, so that a frequency has a sensitivity to each of them."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace

from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.checks import law_faults
from symoro_elastic.machine.columns import Cell, Dimension, with_cells
from symoro_elastic.machine.constants import with_constants
from symoro_elastic.machine.described import AnyMachine
from symoro_elastic.machine.drive_numbers import refuse_wrong_drives, with_named_drives
from symoro_elastic.machine.formula import Formula, FormulaError, refuse_range
from symoro_elastic.machine.loop_checks import start_faults
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
    """Return the machine with other values of parameters, of the cells named by `with_named_cells`, or of drives.

    Raises `InputError` for names that do not exist, and for values that no file may have, such as a negative mass.
    """
    named = with_named_drives(with_named_cells(machine))
    names = [parameter.name for parameter in named.parameters]
    refuse_values(machine, values, names)
    given = {name: Formula.parse(float(x)) for name, x in values.items()}
    parameters = tuple(replace(p, value=given.get(p.name, p.value)) for p in named.parameters)
    refuse_wrong_values(named, values, {p.name: p.value.value() for p in parameters if p.value is not None})
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


def refuse_wrong_values(machine: Machine, given: Collection[str], values: dict[str, float]) -> dict[str, float]:
    """Return the values; raises `InputError` where a cell is what no file may say by a given one: a negative mass."""
    for name, owner, named in machine.cells_with_names:
        touched = False
        for cell, formula in named:
            if not formula.names.isdisjoint(given) and formula.names <= values.keys():
                _refuse(machine, f"{name}.{cell.name}", cell.column.dimension, formula, values)
                touched = True
        if touched and isinstance(owner, Joint):
            for key, what in law_faults(owner, values):
                raise InputError(machine.label, f"{name}.{key}", what)
    refuse_wrong_drives(machine, given, values)
    for place, what in start_faults(machine, values) if machine.loops else ():
        raise InputError(machine.label, place, what)
    return values


def _refuse(machine: Machine, place: str, dimension: Dimension, formula: Formula, values: Mapping[str, float]) -> None:
    """Raise `InputError` for the value of a cell that depends on parameters, or that has none."""
    try:
        value = formula.table_value(values)
    except FormulaError as error:
        raise InputError(machine.label, place, str(error)) from None
    if what := dimension.fault(value, f" by {_by(formula, values)}"):
        raise InputError(machine.label, place, what)


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
