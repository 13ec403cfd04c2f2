"""The columns of a .par file: their lengths checked, their cells read, their defaults filled in."""

from __future__ import annotations

from collections.abc import Mapping

from symoro_elastic.errors import InputError
from symoro_elastic.machine.columns import Cell
from symoro_elastic.machine.formats.cells import formula, whole
from symoro_elastic.machine.formats.par_counts import check_lengths, counts
from symoro_elastic.machine.formats.par_syntax import BODY, GEOMETRIC, INERTIAL, LISTS, ParText
from symoro_elastic.machine.formula import ZERO, Formula
from symoro_elastic.machine.machine import NO_VECTOR, Given, Kind, Vector3
from symoro_elastic.machine.names import quoted, reserved

ROWS = (*GEOMETRIC, *BODY, "eta", "k")
"""Lists with an entry a row."""
FALSE, TRUE = ("0", "False", "false"), ("1", "True", "true")


class Columns:
    """The table of a .par file; rows are numbered from 1."""

    def __init__(self, found: ParText) -> None:
        self.found, self.source = found, found.source
        self.known_of_base = self._known_of_base()
        for key in ("ant", "sigma"):
            if key not in found.lists:
                raise InputError(self.source, key, f"the list is missing: write {key} = {{...}}, an entry a joint")
        self.counts = counts(found)
        check_lengths(found, self.counts, with_base=self.known_of_base is not None)
        self.count = self.counts.frames
        self.of_base = self._of_base()
        self.lists = {key: self._padded(found.lists[key]) for key in ROWS if key in found.lists}
        self.names = self._names()
        self.numbers = {name: j for j, name in reversed([*enumerate(self.names, start=1)])}
        self._whole: dict[tuple[str, int], int] = {}
        self._formulas: dict[str, tuple[Formula, ...]] = {}
        self._extensions: dict[str, list[Formula]] = {}

    def place(self, j: int, key: str) -> str:
        """The name of one cell in messages."""
        name = self.names[j - 1]
        joint = f"joint {j} ({name if reserved(name) is None else quoted(name)})"
        return f"{joint}, {key}" if key else joint

    def whole(self, key: str, j: int, default: int) -> int:
        """The whole number in a cell."""
        if key not in self.lists:
            return default
        if (key, j) not in self._whole:
            self._whole[key, j] = whole(self.lists[key][j - 1], self.source, self.place(j, key))
        return self._whole[key, j]

    def flag(self, key: str, j: int, default: int) -> int:
        """The 0 or 1 in a cell."""
        value = self.whole(key, j, default)
        if value not in (0, 1):
            raise InputError(self.source, self.place(j, key), f"{value} must be 0 or 1")
        return value

    def formula(self, key: str, j: int) -> Formula:
        """The expression in a cell, zero where the file has no such list."""
        if key not in self.lists:
            return ZERO
        if key not in self._formulas:
            cells = enumerate(self.lists[key], start=1)
            self._formulas[key] = tuple(formula(text, self.source, self.place(i, key)) for i, text in cells)
        return self._formulas[key][j - 1]

    def cell(self, cell: Cell, j: int) -> Formula:
        """The expression in a cell of the table, from a list of the format or from an extension line."""
        if cell.par in LISTS:
            return ZERO if cell.par == "k" and self.kind(j) is not Kind.ELASTIC else self.formula(cell.par, j)
        return self.extension(cell.par)[j - 1]

    def base_vector(self, key: str) -> Vector3:
        """A list of three that belongs to frame 0."""
        if key not in self.found.lists:
            return NO_VECTOR
        x, y, z = (formula(text, self.source, key) for text in self.found.lists[key])
        return x, y, z

    def extension(self, key: str) -> list[Formula]:
        """A list in an extension line, one entry per joint; zeros without the line."""
        if key not in self._extensions:
            self._extensions[key] = self._extension(key)
        return self._extensions[key]

    def _extension(self, key: str) -> list[Formula]:
        if key not in self.found.extensions:
            return [ZERO] * self.count
        value = self.found.extensions[key]
        lengths = (self.counts.bodies, self.counts.joints, self.count)
        if not isinstance(value, list) or len(value) not in lengths or not all(isinstance(v, str) for v in value):
            raise self.fail(key, f"must be a list of {self.count} entries, one a joint")
        return [formula(text, self.source, self.place(j, key)) for j, text in enumerate(self._padded(value), start=1)]

    def extension_table(self, key: str) -> dict[str, str]:
        """A table of texts in an extension line, empty without the line."""
        value = self.found.extensions.get(key) or {}
        if not isinstance(value, dict) or not all(isinstance(v, str) for v in value.values()):
            raise self.fail(key, "must be a table: {name = value, ...}")
        return value

    def fail(self, key: str, what: str) -> InputError:
        """The error to raise about an extension line."""
        return InputError(self.source, f"(*! {key} *)", what)

    def kind(self, j: int) -> Kind:
        """Kind of a joint by its row, sigma, eta and mu; a joint without motor and spring is passive, or coupled."""
        fixed = self.whole("sigma", j, 0) == 2
        if self.counts.is_cut(j):
            return self._cut(j)
        if self.counts.is_end(j) and not fixed:
            raise InputError(self.source, self.place(j, "sigma"), self._no_end(j))
        elastic = self.flag("eta", j, 0) == 1
        if fixed and elastic:
            raise InputError(self.source, self.place(j, "eta"), "a fixed frame (sigma = 2) has no spring: write 0")
        if fixed:
            return Kind.FIXED
        if elastic:
            return Kind.ELASTIC
        return Kind.MOTOR if self.flag("mu", j, 1) else Kind.PASSIVE

    def _cut(self, j: int) -> Kind:
        """The kind of a cut joint, which has no motor and no spring."""
        for key in ("mu", "eta"):
            if self.flag(key, j, 0):
                rows = range(1, self.counts.bodies + 1)
                passive = [self.names[i - 1] for i in rows if self.kind(i) is Kind.PASSIVE][:8]
                elsewhere = f" (passive joints: {', '.join(passive)})" if passive else ""
                what = f"the cut joint carries no motor, spring or body: write 0, or cut the loop elsewhere{elsewhere}"
                raise InputError(self.source, self.place(j, key), what)
        return Kind.CUT

    def _no_end(self, j: int) -> str:
        """What is wrong with the frame that a cut joint meets if it moves."""
        first, last = self.counts.joints + 1, self.count
        rows = f"row {last} is the frame" if first == last else f"rows {first} to {last} are the frames"
        cut = self.names[j - self.counts.loops - 1]
        return f"must be 2: {rows} that cut joints meet, this one {quoted(cut)}, and does not move"

    def _known_of_base(self) -> Given | None:
        """Known quantity of the base: the wrench on a floating one, the acceleration of a mobile one."""
        found = []
        for key, known in (("is_floating", Given.WRENCH), ("is_mobile", Given.ACCELERATION)):
            value = self.found.numbers.get(key, "0")
            if value not in (*TRUE, *FALSE):
                raise InputError(self.source, key, f"{quoted(value)} must be 0 or 1")
            found += [known] if value in TRUE else []
        if len(found) > 1:
            raise InputError(self.source, "is_mobile", "the base is floating already: write 1 for one of both")
        return found[0] if found else None

    def _of_base(self) -> dict[str, str]:
        """Cells of the base, removed from the lists, where they precede those of the bodies."""
        cells = {}
        for key in BODY:
            if self.known_of_base and self.counts.has_base(key, len(self.found.lists.get(key, ()))):
                cells[key], *self.found.lists[key] = self.found.lists[key]
        for key in BODY[len(INERTIAL) :]:
            if not self.base_formula(cells, key).is_zero:
                raise InputError(self.source, f"base, {key}", "the base has no joint, and f0 is an argument: write 0")
        return cells

    def base_formula(self, cells: Mapping[str, str], key: str) -> Formula:
        """A cell of the base, zero without an entry."""
        return formula(cells.get(key, "0"), self.source, f"base, {key}")

    def _padded(self, cells: list[str]) -> list[str]:
        """A list with zeros for the cut joints and the frames they meet, where it has no entries for them."""
        return [*cells, *["0"] * (self.count - len(cells))]

    def _names(self) -> list[str]:
        names = self.found.extensions.get("names")
        if names is None:
            return [f"j{j}" for j in range(1, self.count + 1)]
        if not isinstance(names, list) or len(names) != self.count or not all(isinstance(n, str) for n in names):
            raise self.fail("names", f"must be a list of {self.count} names, one a joint")
        return names
