"""The columns of a .par file: their lengths checked, their cells read, their defaults filled in."""

from __future__ import annotations

from collections.abc import Mapping

from symoro_elastic.errors import InputError
from symoro_elastic.machine.columns import Cell
from symoro_elastic.machine.formats.cells import formula, whole
from symoro_elastic.machine.formats.par_syntax import BODY, GEOMETRIC, INERTIAL, JOINT, LISTS, VECTORS, ParText
from symoro_elastic.machine.formula import ZERO, Formula
from symoro_elastic.machine.machine import NO_VECTOR, Given, Kind, Vector3
from symoro_elastic.machine.names import quoted, reserved

FALSE, TRUE = ("0", "False", "false"), ("1", "True", "true")


class Columns:
    """The table of a .par file; rows are numbered from 1."""

    def __init__(self, found: ParText) -> None:
        self.found, self.source = found, found.source
        self.known_of_base = self._known_of_base()
        self.count = self._count()
        self._check_lengths()
        self.of_base = self._of_base()
        self.names = self._names()
        self._formulas: dict[str, tuple[Formula, ...]] = {}
        self._extensions: dict[str, list[Formula]] = {}

    def place(self, j: int, key: str) -> str:
        """The name of one cell in messages."""
        name = self.names[j - 1]
        joint = f"joint {j} ({name if reserved(name) is None else quoted(name)})"
        return f"{joint}, {key}" if key else joint

    def whole(self, key: str, j: int, default: int) -> int:
        """The whole number in a cell."""
        if key not in self.found.lists:
            return default
        return whole(self.found.lists[key][j - 1], self.source, self.place(j, key))

    def flag(self, key: str, j: int, default: int) -> int:
        """The 0 or 1 in a cell."""
        value = self.whole(key, j, default)
        if value not in (0, 1):
            raise InputError(self.source, self.place(j, key), f"{value} must be 0 or 1")
        return value

    def formula(self, key: str, j: int) -> Formula:
        """The expression in a cell, zero where the file has no such list."""
        if key not in self.found.lists:
            return ZERO
        if key not in self._formulas:
            cells = enumerate(self.found.lists[key], start=1)
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
        if not isinstance(value, list) or len(value) != self.count or not all(isinstance(v, str) for v in value):
            raise self.fail(key, f"must be a list of {self.count} entries, one a joint")
        return [formula(text, self.source, self.place(j, key)) for j, text in enumerate(value, start=1)]

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
        """Kind of a joint by sigma, eta and mu."""
        fixed = self.whole("sigma", j, 0) == 2
        elastic = self.flag("eta", j, 0) == 1
        if fixed and elastic:
            raise InputError(self.source, self.place(j, "eta"), "a fixed frame (sigma = 2) has no spring: write 0")
        if fixed:
            return Kind.FIXED
        if elastic:
            return Kind.ELASTIC
        return Kind.MOTOR if self.flag("mu", j, 1) else Kind.PASSIVE

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
            if len(self.found.lists.get(key, ())) > self.count:
                cells[key], *self.found.lists[key] = self.found.lists[key]
        for key in BODY[len(INERTIAL) :]:
            if not self.base_formula(cells, key).is_zero:
                raise InputError(self.source, f"base, {key}", "the base has no joint, and f0 is an argument: write 0")
        return cells

    def base_formula(self, cells: Mapping[str, str], key: str) -> Formula:
        """A cell of the base, zero without an entry."""
        return formula(cells.get(key, "0"), self.source, f"base, {key}")

    def _count(self) -> int:
        if "NL" not in self.found.numbers:
            raise InputError(self.source, "NL", "is missing: write NL = the number of bodies")
        for key in ("ant", "sigma"):
            if key not in self.found.lists:
                raise InputError(self.source, key, f"the list is missing: write {key} = {{...}}, an entry a joint")
        bodies = whole(self.found.numbers["NL"], self.source, "NL")
        joints = whole(self.found.numbers.get("NJ", str(bodies)), self.source, "NJ")
        if joints != bodies:
            raise InputError(self.source, "NJ", self._loops(bodies, joints))
        frames = whole(self.found.numbers.get("NF", str(bodies)), self.source, "NF")
        if frames != bodies:
            raise InputError(self.source, "NF", f"{frames} must be 2 NJ - NL = {bodies}, or left out")
        return bodies

    def _loops(self, bodies: int, joints: int) -> str:
        if joints < bodies:
            return f"{joints} joints are too few for NL = {bodies} bodies: each body has one"
        ant = self.found.lists["ant"]
        loops = []
        for j in range(bodies + 1, min(joints, bodies + 5) + 1):
            end = j + joints - bodies
            ends = f", between bodies {ant[j - 1]} and {ant[end - 1]}" if end <= len(ant) else ""
            loops.append(f"joint {j} closes a loop{ends}")
        return f"{joints} joints for {bodies} bodies: {'; '.join(loops)[:200]}; closed loops are not handled, cut them"

    def _check_lengths(self) -> None:
        expected = {**dict.fromkeys(VECTORS, 3), "Z": 16}
        for key, cells in self.found.lists.items():
            count = expected.get(key, self.count)
            if key in BODY and self.known_of_base and len(cells) == count + 1:
                continue
            if len(cells) != count:
                rows = "NL" if key in BODY else "NJ" if key in JOINT else "NF" if key in GEOMETRIC else "fixed"
                raise InputError(self.source, key, f"has {len(cells)} entries, expected {count} ({rows})")

    def _names(self) -> list[str]:
        names = self.found.extensions.get("names")
        if names is None:
            return [f"j{j}" for j in range(1, self.count + 1)]
        if not isinstance(names, list) or len(names) != self.count or not all(isinstance(n, str) for n in names):
            raise self.fail("names", f"must be a list of {self.count} names, one a joint")
        return names
