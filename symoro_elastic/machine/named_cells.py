"""Numbers of the table as parameters, so that a frequency has a sensitivity to each of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from symoro_elastic.errors import InputError
from symoro_elastic.machine.columns import Cell, with_cells
from symoro_elastic.machine.constants import with_constants
from symoro_elastic.machine.formula import Formula, FormulaError, refuse_range
from symoro_elastic.machine.loops import branches
from symoro_elastic.machine.machine import Joint, Machine, Parameter
from symoro_elastic.machine.names import did_you_mean, quoted

GEOMETRY = "joints"
"""The section of the file that holds lengths and angles."""


def with_named_cells(machine: Machine) -> Machine:
    """Return the machine with masses, stiffnesses, lengths ... as parameters `<joint>.<quantity>` with values.

    Parameters keep their names. Zeros and angles stay as they are: they are the structure of a machine. So do lengths
    in loops: one that changes alone may open a loop, as two sides of a parallelogram are equal.
    """
    named: list[Parameter] = []
    around = {j for loop in machine.loops for branch in branches(machine.antecedents, loop) for j in branch}
    numbered = enumerate(machine.joints, start=1)
    joints = tuple(_with_named_numbers(joint, named, GEOMETRY if j in around else "") for j, joint in numbered)
    return replace(machine, joints=joints, parameters=(*machine.parameters, *named))


def with_values(machine: Machine, values: Mapping[str, float]) -> Machine:
    """Return the machine with other values of parameters, or of the cells named by `with_named_cells`.

    Raises `InputError` for names that do not exist.
    """
    named = with_named_cells(machine)
    names = [parameter.name for parameter in named.parameters]
    refuse_values(machine, values, names)
    given = {name: Formula.parse(float(x)) for name, x in values.items()}
    parameters = tuple(replace(p, value=given.get(p.name, p.value)) for p in named.parameters)
    cells = names[len(machine.parameters) :]
    return with_constants(replace(named, parameters=parameters), cells)


def refuse_values(machine: Machine, values: Mapping[str, float], names: Sequence[str]) -> None:
    """Raise `InputError` for a value of a parameter that does not exist, or that is out of range."""
    source = machine.label
    for name, x in values.items():
        if name not in names:
            raise InputError(source, "parameters", f"no parameter {quoted(name)}{did_you_mean(name, names)}")
        try:
            refuse_range(x)
        except FormulaError as error:
            raise InputError(source, name, str(error)) from None


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
