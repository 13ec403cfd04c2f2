"""The columns of a .par file: their lengths checked, their cells read, their defaults filled in."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from symoro_elastic.formats.joint_cells import formula, whole
from symoro_elastic.formats.par.syntax import BODY, GEOMETRIC, INERTIAL, JOINT, VECTORS, ParText
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.formula import ZERO, Formula
from symoro_elastic.machine.machine import NO_VECTOR, Kind, KnownOfBase, Vector3
from symoro_elastic.machine.names import quote, why_reserved

ROWS = (*GEOMETRIC, *BODY, "eta", "k")
"""Lists with an entry a row."""
FALSE, TRUE = ("0", "False", "false"), ("1", "True", "true")

OF_JOINTS = (*BODY, *JOINT, "mu")
"""Lists whose entries for the cut joints and for the frames that these meet may be left out."""


@dataclass(frozen=True)
class Counts:
    """Rows 1 to `bodies` carry a body, the next up to `joints` are cut joints, the last are the frames these meet."""

    bodies: int
    joints: int

    @property
    def loops(self) -> int:
        """Number of closed loops, B = NJ - NL."""
        return self.joints - self.bodies

    @property
    def frames(self) -> int:
        """Number of rows, NF = NJ + B."""
        return self.joints + self.loops

    def is_cut(self, j: int) -> bool:
        """Whether row j is a cut joint."""
        return self.bodies < j <= self.joints

    def is_end(self, j: int) -> bool:
        """Whether row j is the frame that a cut joint meets."""
        return j > self.joints

    def lengths(self, key: str) -> dict[int, str]:
        """Numbers of entries that a list may have, and what they count."""
        if key in VECTORS or key == "Z":
            return {16 if key == "Z" else 3: "fixed"}
        if not self.loops:
            return {self.frames: "NL" if key in BODY else "NJ" if key in JOINT else "NF"}
        shorter = {self.bodies: "NL", self.joints: "NJ"} if key in OF_JOINTS else {}
        return {**shorter, self.frames: "NF = 2 NJ - NL"}

    def has_base(self, key: str, entries: int) -> bool:
        """Whether a list with this number of entries begins with one for the base, where that floats."""
        return key in BODY and entries in (self.bodies + 1, self.frames + 1)


def counts(found: ParText) -> Counts:
    """The numbers of bodies and joints; raises `InputError` where they or NF are wrong."""
    if "NL" not in found.numbers:
        raise InputError(found.source, "NL", "is missing: write NL = the number of bodies")
    bodies = whole(found.numbers["NL"], found.source, "NL")
    joints = whole(found.numbers.get("NJ", str(bodies)), found.source, "NJ")
    if bodies < 0:
        raise InputError(found.source, "NL", f"{bodies} must be the number of bodies")
    if joints < bodies:
        what = f"{joints} joints are too few for NL = {bodies} bodies: each body has one, each closed loop one more"
        raise InputError(found.source, "NJ", what)
    found_counts = Counts(bodies, joints)
    frames = whole(found.numbers.get("NF", str(found_counts.frames)), found.source, "NF")
    if frames != found_counts.frames:
        raise InputError(found.source, "NF", f"{frames} must be 2 NJ - NL = {found_counts.frames}, or left out")
    return found_counts


def check_lengths(found: ParText, count: Counts, with_base: bool) -> None:
    """Raise `InputError` for a list that has too few or too many entries."""
    for key, cells in found.lists.items():
        lengths = count.lengths(key)
        if len(cells) in lengths or (with_base and count.has_base(key, len(cells))):
            continue
        *others, last = (f"{length} ({what})" for length, what in lengths.items())
        expected = f"{', '.join(others)} or {last}" if others else last
        raise InputError(found.source, key, f"has {len(cells)} entries, expected {expected}")


class Columns:
    """The table of a .par file; rows are numbered from 1, and have the names j1, j2 ... unless others are given."""

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
        self.names = [f"j{j}" for j in range(1, self.count + 1)]
        self._whole: dict[tuple[str, int], int] = {}
        self._formulas: dict[str, tuple[Formula, ...]] = {}

    def place(self, j: int, key: str) -> str:
        """The name of one cell in messages."""
        name = self.names[j - 1]
        joint = f"joint {j} ({name if why_reserved(name) is None else quote(name)})"
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

    def texts(self, keys: Sequence[str], j: int) -> list[str]:
        """The texts of the cells of a row in these lists; 0 where the file has no such list."""
        if keys == ("k",) and self.kind(j) is not Kind.ELASTIC:
            return ["0"]
        return [self.lists[key][j - 1] if key in self.lists else "0" for key in keys]

    def base_vector(self, key: str) -> Vector3:
        """A list of three that belongs to frame 0."""
        if key not in self.found.lists:
            return NO_VECTOR
        x, y, z = (formula(text, self.source, key) for text in self.found.lists[key])
        return x, y, z

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
        return f"must be 2: {rows} that cut joints meet, this one {quote(cut)}, and does not move"

    def _known_of_base(self) -> KnownOfBase | None:
        """Known quantity of the base: the wrench on a floating one, the acceleration of a mobile one."""
        found = []
        for key, known in (("is_floating", KnownOfBase.WRENCH), ("is_mobile", KnownOfBase.ACCELERATION)):
            value = self.found.numbers.get(key, "0")
            if value not in (*TRUE, *FALSE):
                raise InputError(self.source, key, f"{quote(value)} must be 0 or 1")
            found += [known] if value in TRUE else []
        if len(found) > 1:
            raise InputError(self.source, "is_mobile", "the base is floating already: write 1 for one of the two")
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
