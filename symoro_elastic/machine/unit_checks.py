"""Units of parameters and of formulas: what contradicts itself is refused, what may be meant is warned about."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

from symoro_elastic.machine.formula import Formula, names_in
from symoro_elastic.machine.formula_units import Mismatch, mismatches
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.names import quoted
from symoro_elastic.quantities.units import Powers, in_base_units

NOT_SI = {"mm", "cm", "dm", "um", "µm", "km", "inch", "ft", "deg", "degree", "degrees", "°", "rpm", "g", "mg", "lb"}
NOT_SI |= {"Nmm", "Ncm", "kN", "MN", "daN", "ms", "min"}


def parameter_faults(machine: Machine) -> Iterator[tuple[str, str]]:
    """Parameters in units other than SI, with their place: values are not converted."""
    for parameter in machine.parameters:
        if any(word in NOT_SI for word in re.findall(r"[^\W\d_]+|°", parameter.unit)):
            what = f"its unit is {quoted(parameter.unit)}, but nothing converts values: write it in m, kg, s, rad, N"
            yield f"parameter {parameter.name}", what


@dataclass(frozen=True)
class Doubt:
    """What is wrong with the units of a formula, or only may be."""

    what: str
    is_certain: bool


@dataclass(frozen=True)
class UnitsOfNames:
    """Units of the names of a machine: of the parameters that declare one, and of the joint variables."""

    machine: Machine

    @cached_property
    def declared(self) -> dict[str, Powers]:
        """Units of parameters, as exponents of kg, m, s and rad, where they are declared and known."""
        found = {p.name: in_base_units(p.unit) for p in self.machine.parameters}
        return {name: powers for name, powers in found.items() if powers is not None}

    @cached_property
    def of_variables(self) -> dict[str, Powers]:
        """Units of joint variables."""
        units = {name: in_base_units(self.machine.joint(j).unit) for name, j in self.machine.variables.items()}
        return {name: powers for name, powers in units.items() if powers is not None}

    @cached_property
    def known(self) -> dict[str, Powers]:
        """Units of all names that have one."""
        return {**self.declared, **self.of_variables}

    def doubts(self, formula: Formula, unit: str, *, gives_position: bool) -> Iterator[Doubt]:
        """What is doubtful about a formula that needs a unit, and gives the position of a joint or does not.

        Numbers may have units: `8e4/L` is a stiffness in N/m, `1*q1` an arc of radius 1 m. So it is certain only where
        a variable stands alone, or where units are declared. A unit that is only not that of the cell is a warning:
        values are taken in the unit of the cell.
        """
        needed = in_base_units(unit or "1") or {}
        for one in mismatches(formula, self.known, needed):
            if (gives_position or one.is_mixed) and self._is_certain(one):
                yield Doubt(one.said, is_certain=True)
            elif (gives_position and not one.is_of_angles) or one.is_mixed or self._is_declared(one, formula):
                yield Doubt(one.said, is_certain=False)

    def _is_certain(self, one: Mismatch) -> bool:
        names = names_in(one.part)
        stands_alone = one.part[0] == "name" or not names.isdisjoint(self.declared)
        return stands_alone and not one.found.counted and not one.is_of_angles

    def _is_declared(self, one: Mismatch, formula: Formula) -> bool:
        """Whether a declared unit does not fit; beside variables a number may make up for it, but not for rad2."""
        declared = any(name in self.declared for name in formula.names)
        return declared and (one.is_of_angles or formula.names.isdisjoint(self.of_variables))
