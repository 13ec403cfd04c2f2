"""Names in a .par file, classified as joint variables and parameters."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence

from symoro_elastic.machine.columns import declared
from symoro_elastic.machine.formats.cells import SELECTED, formula
from symoro_elastic.machine.formats.par_columns import Columns
from symoro_elastic.machine.formats.par_syntax import BODY, VECTORS
from symoro_elastic.machine.formats.par_variables import own_variables
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import Joint, Kind, Parameter
from symoro_elastic.machine.names import did_you_mean, quoted

GEOMETRY = tuple(key for column in declared(Joint, "joints") for key in column.par)


class Names:
    """All names of the file, in order of first appearance by joint, then by column."""

    def __init__(self, columns: Columns, others: Sequence[Formula]) -> None:
        self.columns = columns
        self.cells = [*_cells(columns), *others]
        self.known = {name for cell in self.cells for name in cell.names}
        self.listed = self._listed()
        self.values, self.units = columns.extension_table("values"), columns.extension_table("units")
        self._check_known("values", self.values)
        self._check_known("units", self.units)
        elsewhere = Counter(name for cell in (*_without_variables(columns), *others) for name in cell.names)
        self.variables = own_variables(columns, {*self.listed, *self.values, *self.units}, elsewhere)

    def parameters(self) -> tuple[Parameter, ...]:
        """All names but the joint variables, those listed in the file first."""
        ordered, variables = dict.fromkeys(self.listed), set(self.variables.values())
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
            if name not in self.known and name not in self.listed:
                raise self.columns.fail(key, f"no name {quoted(name)} in the table{did_you_mean(name, self.known)}")


def _cells(columns: Columns) -> Iterator[Formula]:
    for j in range(1, columns.count + 1):
        for key in (*GEOMETRY, *BODY):
            yield columns.formula(key, j)
        if columns.kind(j) == Kind.ELASTIC:
            yield columns.formula("k", j)
    for key in VECTORS:
        yield from columns.base_vector(key)


def _without_variables(columns: Columns) -> Iterator[Formula]:
    """The cells in which no joint variable stands."""
    for j in range(1, columns.count + 1):
        selected = SELECTED.get(columns.whole("sigma", j, 0))
        for key in (*GEOMETRY, *BODY):
            if key != selected:
                yield columns.formula(key, j)
    for key in VECTORS:
        yield from columns.base_vector(key)


def _in_order(cell: Formula) -> list[str]:
    return sorted(cell.names, key=lambda name: (cell.text.index(name), name))
