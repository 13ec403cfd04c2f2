"""Names in a .par file, classified as joint variables and parameters."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator

from symoro_elastic.errors import InputError
from symoro_elastic.machine.columns import declared
from symoro_elastic.machine.formats.cells import OTHER, SELECTED, formula, offset_of
from symoro_elastic.machine.formats.par_columns import Columns
from symoro_elastic.machine.formats.par_syntax import BODY, VECTORS
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import Joint, Kind, Parameter
from symoro_elastic.machine.names import did_you_mean, quoted

GEOMETRY = tuple(key for column in declared(Joint, "joints") for key in column.par)


class Names:
    """All names of the file, in order of first appearance by joint, then by column."""

    def __init__(self, columns: Columns, others: Iterable[Formula]) -> None:
        self.columns = columns
        self.cells = [*_cells(columns), *others]
        self.appearances = Counter(name for cell in self.cells for name in cell.names)
        self.listed = self._listed()
        self.values, self.units = columns.extension_table("values"), columns.extension_table("units")
        self._check_known("values", self.values)
        self._check_known("units", self.units)
        self.declared = {*self.listed, *self.values, *self.units}

    def variable(self, j: int, sigma: int) -> str:
        """The joint variable: the name in the cell that sigma selects which is no parameter."""
        column = SELECTED[sigma]
        cell = self.columns.formula(column, j)
        names = sorted(cell.names - self.declared)
        if len(names) > 1:
            names = [name for name in names if self.appearances[name] == 1] or names
        if len(names) > 1:
            names = [name for name in names if offset_of(cell, name) is not None] or names
        if len(names) == 1:
            return names[0]
        raise InputError(self.columns.source, self.columns.place(j, column), self._no_variable(j, sigma, names))

    def parameters(self, variables: set[str]) -> tuple[Parameter, ...]:
        """All names but the joint variables, those listed in the file first."""
        ordered = dict.fromkeys(self.listed)
        for cell in self.cells:
            ordered.update(dict.fromkeys(name for name in _in_order(cell) if name not in variables))
        return tuple(Parameter(name, self._value(name), self.units.get(name, "")) for name in ordered)

    def _value(self, name: str) -> Formula | None:
        if name not in self.values:
            return None
        return formula(self.values[name], self.columns.source, f"(*! values *), {name}")

    def _listed(self) -> list[str]:
        listed = self.columns.found.extensions.get("parameters", [])
        if not isinstance(listed, list) or not all(isinstance(name, str) for name in listed):
            raise self.columns.fail("parameters", "must be a list of names: {D3, RL4}")
        return listed

    def _check_known(self, key: str, names: Iterable[str]) -> None:
        for name in names:
            if name not in self.appearances and name not in self.listed:
                raise self.columns.fail(
                    key, f"no name {quoted(name)} in the table{did_you_mean(name, self.appearances)}"
                )

    def _no_variable(self, j: int, sigma: int, names: list[str]) -> str:
        column, other = SELECTED[sigma], OTHER[sigma]
        cell = quoted(self.columns.formula(column, j))
        if names:
            what = f"{cell} may hold any of {', '.join(names)} as joint variable (sigma = {sigma})"
            return f"{what}: list the parameters among them in (*! parameters = {{...}} *)"
        what = f"no joint variable in {cell}, where sigma = {sigma} expects it"
        elsewhere = sorted(name for name in self.columns.formula(other, j).names if self.appearances[name] == 1)
        if elsewhere:
            what += f"; {elsewhere[0]!r} stands in {other}, which is for sigma = {1 - sigma}"
        return what


def _cells(columns: Columns) -> Iterator[Formula]:
    for j in range(1, columns.count + 1):
        for key in (*GEOMETRY, *BODY):
            yield columns.formula(key, j)
        if columns.kind(j) == Kind.ELASTIC:
            yield columns.formula("k", j)
    for key in VECTORS:
        yield from columns.base_vector(key)


def _in_order(cell: Formula) -> list[str]:
    return sorted(cell.names, key=lambda name: (cell.text.index(name), name))
