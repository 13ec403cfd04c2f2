"""The variables that rows of a .par file own: names in the cells that sigma selects which are not parameters.

The format declares neither parameters nor coupled joints. A row with a motor or a spring owns a variable; one with
mu = 0 is passive if its cell holds a name of its own, else it is coupled. What stays in doubt is refused.
"""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Collection, Iterator, Mapping, Sequence

from symoro_elastic.formats.joint_cells import OTHER, SELECTED, offset_of
from symoro_elastic.formats.par.columns import Columns
from symoro_elastic.formats.par.syntax import BODY, VECTORS
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.columns import declared_columns as columns_of
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import Joint, Kind
from symoro_elastic.machine.names import quote

WAYS = "each in a line (*toml ... *)"
Candidates = dict[int, set[str]]
"""Names that may be the own variable of each row, by the number of the row."""


def own_variables(
    columns: Columns, declared: Collection[str], elsewhere: Mapping[str, int], given: Mapping[int, str]
) -> dict[int, str]:
    """The own variable of each row that has one, by the number of the row; raises `InputError` where it is in doubt.

    `declared` are parameters; so are the names that stand `elsewhere`, where there is no variable, so many times.
    `given` are the variables that the file names as those of rows.
    """
    return _Cells(columns, declared, elsewhere, given).own()


def owned_names(names: Mapping[int, Collection[str]], optional: Collection[int]) -> Candidates:
    """Names of which each row owns one: one where this is settled, several where it is in doubt, none where coupled.

    A row with one name owns it; one with several owns that which no other row owns. Rows in `optional` are coupled
    where other rows own all their names; a name that such a row has alone is not taken from one that must own one.
    """
    left = {j: set(found) for j, found in names.items()}
    holders: dict[str, list[int]] = {}
    for j, found in left.items():
        for name in found:
            holders.setdefault(name, []).append(j)
    waiting = deque(j for j, found in left.items() if len(found) == 1)
    seen: set[tuple[str, bool]] = set()
    while waiting:
        i = waiting.popleft()
        name = next(iter(left[i]), "")
        if len(left[i]) != 1 or (name, i in optional) in seen:
            continue
        seen.add((name, i in optional))
        for j in holders[name]:
            yields = j in optional or (len(names[j]) > 1 and i not in optional)
            if j != i and yields and name in left[j]:
                left[j].remove(name)
                waiting.append(j)
    return left


def _owned(left: Candidates) -> set[str]:
    """Names that are the variables of rows."""
    return {name for names in left.values() if len(names) == 1 for name in names}


class _Cells:
    """The cells that sigma selects, of the rows that move."""

    def __init__(
        self, columns: Columns, declared: Collection[str], elsewhere: Mapping[str, int], given: Mapping[int, str]
    ) -> None:
        self.columns, self.elsewhere = columns, elsewhere
        rows = range(1, columns.count + 1)
        self.sigma = {j: sigma for j in rows if (sigma := columns.whole("sigma", j, 0)) in SELECTED}
        self.cells = {j: columns.formula(SELECTED[sigma], j) for j, sigma in self.sigma.items()}
        self.names = {j: cell.names.difference(declared) for j, cell in self.cells.items()}
        self.holders = Counter(name for names in self.names.values() for name in names)
        self.given = self._checked(given)
        passive = [j for j in self.cells if j not in self.given and columns.kind(j) is Kind.PASSIVE]
        self.optional = {j for j in passive if any(self.holders[name] > 1 for name in self.names[j])}
        self.candidates = {j: set(self._candidates(j)) for j in self.cells}

    def own(self) -> dict[int, str]:
        """The own variables, by the number of the row."""
        left = owned_names(self.candidates, self.optional)
        for narrowed in (self._followed, self._only_here, self._followed):
            left = owned_names({**left, **narrowed(left)}, self.optional)
        owned = _owned(left)
        for j, names in left.items():
            doubt = self._doubt(j, names, owned)
            if doubt:
                raise self._error(j, SELECTED[self.sigma[j]], doubt)
        return {j: name for j, names in left.items() for name in names}

    def _candidates(self, j: int) -> Collection[str]:
        """Names in a cell that may be its own variable: added to the rest, and nowhere a parameter."""
        names = self.names[j]
        if j in self.given:
            return {self.given[j]}
        if len(names) == 1 and j not in self.optional:
            return names
        variables = names.difference(self.elsewhere)
        added = {name for name in variables if offset_of(self.cells[j], name) is not None}
        return added if j in self.optional else added or variables or names

    def _followed(self, left: Candidates) -> Candidates:
        """Rows in doubt with one name that a coupled row needs, as no other row may own a name in its cell."""
        owners: dict[str, list[int]] = {}
        for j, names in left.items():
            for name in names:
                owners.setdefault(name, []).append(j)
        found: Candidates = {}
        for j in self._without_leader(left):
            possible = [(i, name) for name in self.names[j] for i in owners.get(name, ())]
            found |= {i: {name} for i, name in possible if len(possible) == 1}
        self.candidates |= found
        return found

    def _without_leader(self, left: Candidates) -> list[int]:
        """Coupled rows in whose cells no name is known yet to be the variable of another row."""
        owned = _owned(left)
        return [j for j in self.optional if not left[j] and owned.isdisjoint(self.names[j])]

    def _only_here(self, left: Candidates) -> Candidates:
        """Rows in doubt with one name that stands in no other cell: its own, where the others may be parameters."""
        followed = {name for j in self._without_leader(left) for name in self.names[j]}
        followed |= {name for j in self.optional if len(left[j]) == 1 for name in left[j]}
        found = {}
        for j, names in left.items():
            new = {name for name in names if self.holders[name] == 1}
            if len(names) > 1 and len(new) == 1 and names.isdisjoint(followed):
                found[j] = new
        return found

    def _checked(self, given: Mapping[int, str]) -> Mapping[int, str]:
        """Variables that the file names as those of rows; raises `InputError` where they cannot be."""
        for j, variable in given.items():
            if j not in self.cells:
                raise self._error(j, "variable", "a fixed frame has no variable of its own: leave it out")
            if variable not in self.cells[j].names:
                where = f"{SELECTED[self.sigma[j]]} = {quote(self.cells[j])}"
                raise self._error(j, "variable", f"{quote(variable)} does not stand in {where}")
        return given

    def _error(self, j: int, key: str, what: str) -> InputError:
        return InputError(self.columns.source, self.columns.place(j, key), what)

    def _doubt(self, j: int, names: Collection[str], owned: Collection[str]) -> str:
        """Why it is in doubt what a row owns, or that it has no variable and needs one; empty where all is well."""
        cell, one = quote(self.cells[j]), min(names, default="")
        joint = self.columns.names[j - 1]
        if len(names) > 1:
            what = f"{cell} may hold any of {', '.join(sorted(names))} as joint variable (sigma = {self.sigma[j]})"
            return f"{what}: declare the parameters among them in [parameters], or give the variable of {joint}: {WAYS}"
        leaders = sorted(self.names[j].intersection(owned))
        if not names and not leaders:
            return self._no_variable(j)
        if not names and j not in self.optional:
            what = f"{cell} holds variables of other joints only ({', '.join(leaders)})"
            return f"{what}: add one of its own, or write mu = 0 for a coupled joint"
        if j in self.optional and len(self.candidates[j]) > 1 and self.holders[one] > 1:
            what = f"{one!r} in {cell} may be a variable of its own, or a parameter"
            return f"{what}: give variable = {one!r} in the row of {joint}, or declare {one} in [parameters]: {WAYS}"
        return ""

    def _no_variable(self, j: int) -> str:
        sigma = self.sigma[j]
        what = f"no joint variable in {quote(self.cells[j])}, where sigma = {sigma} expects it"
        names = self.columns.formula(OTHER[sigma], j).names
        elsewhere = sorted(name for name in names if self.elsewhere[name] == 1 and not self.holders[name])
        if elsewhere:
            what += f"; {elsewhere[0]!r} stands in {OTHER[sigma]}, which is for sigma = {1 - sigma}"
        return what


GEOMETRY = tuple(key for column in columns_of(Joint, "joints") for key in column.par)


class Names:
    """All names of the file, in order of first appearance by joint, then by column."""

    def __init__(
        self, columns: Columns, others: Sequence[Formula], declared: Collection[str], given: Mapping[int, str]
    ) -> None:
        self.cells = [*_cells(columns), *others]
        elsewhere = Counter(name for cell in (*_without_variables(columns), *others) for name in cell.names)
        self.variables = own_variables(columns, declared, elsewhere, given)

    def parameters(self) -> list[str]:
        """All names but the joint variables, in order of appearance."""
        variables = {*self.variables.values()}
        return [*dict.fromkeys(name for cell in self.cells for name in _in_order(cell) if name not in variables)]


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
