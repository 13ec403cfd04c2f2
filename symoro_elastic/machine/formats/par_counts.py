"""How many bodies, joints and frames a .par file has, and how many entries its lists."""

from __future__ import annotations

from dataclasses import dataclass

from symoro_elastic.errors import InputError
from symoro_elastic.machine.formats.cells import whole
from symoro_elastic.machine.formats.par_syntax import BODY, JOINT, VECTORS, ParText

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
