"""The domain of the formulas of a machine: positions at which cells such as sqrt(q1) or 1/q1 have a value."""

from __future__ import annotations

import random
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.checks import place_of
from symoro_elastic.machine.columns import Cell, cells
from symoro_elastic.machine.formula import Formula, FormulaError
from symoro_elastic.machine.machine import Joint, Machine

NEXT = 1e-6
"""Of a variable, relative, rad or m: a formula has a slope where it has values so far on both sides."""
REACHES = (0.3, 1.0, 3.0, 10.0)
"""Sizes of the variables that are drawn, rad or m, in turn."""
DRAWS = 200


@dataclass(frozen=True)
class Undefined:
    """A cell of a joint that has no value, or no slope, at a position."""

    number: int
    joint: Joint
    cell: Cell
    formula: Formula

    def error(self, machine: Machine, where: str) -> InputError:
        """Return the error for this cell; `where` names the positions."""
        what = f"{self.formula.text!r} has no value and slope {where}"
        return machine.error(place_of(self.number, self.joint, self.cell.label), what)


class Domain:
    """The cells of a machine that hold joint variables; `free` are the variables that belong to no loop."""

    def __init__(self, machine: Machine) -> None:
        self.machine = machine
        self.cells = [
            Undefined(j, joint, cell, formula)
            for j, joint in enumerate(machine.joints, start=1)
            for cell, formula in cells(joint)
            if not formula.names.isdisjoint(machine.variables)
        ]
        names = {name for cell in self.cells for name in cell.formula.names}
        self.free = sorted(x for x, j in machine.variables.items() if x in names and j not in machine.in_loops)

    def first_undefined(self, symbols: Mapping[str, float]) -> Undefined | None:
        """Return the first cell without value or slope where parameters and variables have these values."""
        return next((cell for cell in self.cells if not self._is_defined(cell.formula, symbols)), None)

    def nearest_defined(self, symbols: Mapping[str, float], source: random.Random) -> dict[str, float] | None:
        """Return the values with free variables changed until all cells have a value; None if the search fails."""
        for values in self._samples(symbols, source):
            if self.first_undefined(values) is None:
                return values
        return None

    def refusal(self, symbols: Mapping[str, float]) -> InputError | None:
        """Return the error for a cell without a value at all random positions; None if each cell has one somewhere."""
        for cell in self.cells:
            samples = self._samples(symbols, random.Random(0))
            if not any(self._is_defined(cell.formula, values) for values in samples):
                return cell.error(self.machine, f"at any of {DRAWS} random positions: correct it")
        return None

    def _samples(self, symbols: Mapping[str, float], source: random.Random) -> Iterator[dict[str, float]]:
        yield dict(symbols)
        for k in range(DRAWS if self.free else 0):
            reach = REACHES[k % len(REACHES)]
            yield {**symbols, **{name: source.uniform(-reach, reach) for name in self.free}}

    def _is_defined(self, formula: Formula, symbols: Mapping[str, float]) -> bool:
        try:
            formula.value(symbols)
            for name in sorted(formula.names & self.machine.variables.keys()):
                x, h = symbols[name], NEXT * max(1.0, abs(symbols[name]))
                formula.value({**symbols, name: x - h})
                formula.value({**symbols, name: x + h})
        except FormulaError:
            return False
        return True
