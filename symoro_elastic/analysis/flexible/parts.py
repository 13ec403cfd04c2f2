"""Joints or modes that the beams and bodies of a machine file need: what fewer of them change, and cost.

One part is varied at a time; frequencies and the compliance of a frame are those of the machine with motors held. An
error with k joints or modes is predicted by k + 1 of them, of a beam by k + 2 modes, since every second one adds a mode
of torsion. It is measured by a reference: six modes, with stiffening where the part can have it, else 12 equal joints;
all modes of a file.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from symoro_elastic.analysis.poses.frame_stiffness import frame_stiffness, signals_of
from symoro_elastic.analysis.vibration.linearization import linearize, with_motors
from symoro_elastic.analysis.vibration.modes import modes
from symoro_elastic.formats import read_machine
from symoro_elastic.formats.files import load_text
from symoro_elastic.formats.modes_file import load as load_modes
from symoro_elastic.formats.toml.flexible.beams import HEADING as BEAMS
from symoro_elastic.formats.toml.flexible.bodies import HEADING as BODIES
from symoro_elastic.formats.toml.flexible.modal_rows import ROOT
from symoro_elastic.formats.toml.reading import machine_of
from symoro_elastic.formats.toml.tables import Table, load
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.results import Result
from symoro_elastic.machine.beams.beam import MOST_MODES
from symoro_elastic.machine.beams.places import GAUSS
from symoro_elastic.machine.described import DescribedMachine
from symoro_elastic.machine.machine import Machine
from symoro_elastic.models.programs.catalogue import trace
from symoro_elastic.numerics.motion.equations_of_motion import motion_of
from symoro_elastic.numerics.motion.equilibrium import equilibrium

Entry = dict[str, Any]
UNKNOWN = (np.nan, np.nan)
ROUNDING = 1e-9
"""Of a frequency up to which modes of a file are kept."""
FREQUENCIES = 3
"""That are compared: the first ones with motors held."""
REFERENCES: tuple[Entry, ...] = (
    {"modes": MOST_MODES, "stiffening": True},
    {"modes": MOST_MODES},
    {"joints": 12, "rule": "equal"},
)
OF_COUNT = ("joints", "modes", "rule", "up_to", "tolerance", "stiffening")
"""Keys of a beam that belong to its joints or modes."""


@dataclass(frozen=True)
class PartErrors:
    """Errors of frequencies and of the compliance with `count` joints or modes of a part, relative; NaN where unknown.

    `operations` are products, divisions and sums of the direct model. `present` is the number of the file.
    """

    part: str
    what: str
    count: int
    predicted: tuple[float, float]
    measured: tuple[float, float]
    operations: int
    present: int


@dataclass(frozen=True, repr=False)
class FlexibleParts(Result):
    """Beams and bodies by modes of a machine, one row for each number of joints or modes that was tried.

    The compliance is that of the frame. `within` is the requested accuracy; None where the file's numbers are shown.
    """

    machine: str
    frame_name: str
    rows: tuple[PartErrors, ...]
    within: float | None = None

    @property
    def headline(self) -> str:
        """Machine and parts."""
        parts = dict.fromkeys(row.part for row in self.rows)
        return f"Flexible parts of {self.machine}: {', '.join(parts)}"

    @property
    def advised(self) -> Mapping[str, PartErrors | None]:
        """For each part, the fewest joints or modes with predicted errors within the accuracy; None if none are."""
        parts = dict.fromkeys(row.part for row in self.rows)
        limit = np.inf if self.within is None else self.within
        return {x: next((r for r in self.rows if r.part == x and max(r.predicted) <= limit), None) for x in parts}


@dataclass(frozen=True)
class Figures:
    """Frequencies, Hz, and compliances (3, 3), m/N, of a machine, and operations of its direct model."""

    frequencies: Array
    compliance: Array
    operations: int

    def apart(self, other: Figures) -> tuple[float, float]:
        """Relative differences of frequencies and of the compliance from those of another machine."""
        count = min(len(self.frequencies), len(other.frequencies))
        of_modes = np.abs(self.frequencies[:count] / other.frequencies[:count] - 1).max(initial=0.0)
        change, whole = (np.linalg.norm(x, 2) for x in (self.compliance - other.compliance, other.compliance))
        return float(of_modes), float(change / whole) if whole else 0.0


@dataclass(frozen=True)
class Part:
    """A beam or a modal body of a file: the entries to read it with other numbers of joints or modes.

    A beam has `kinds` of entries to which the number is added, a body one of `keeps` for each number of modes.
    """

    heading: str
    name: str
    what: str
    present: int
    kinds: Sequence[Entry]
    references: Sequence[Entry]
    keeps: Sequence[Entry] = ()

    @property
    def step(self) -> int:
        """Number of additional joints or modes whose results estimate the error."""
        return 2 if self.heading == BEAMS and self.what == "modes" else 1

    def entries(self, count: int) -> Sequence[Entry]:
        """Candidate entries with this number of joints or modes, the first readable one is used; 0: the reference."""
        if not count:
            return self.references
        return self.keeps[count - 1 : count] or [{**kind, self.what: count} for kind in self.kinds]


def flexible_parts(
    file: str | Path, frame: Callable[[DescribedMachine], str], at: Mapping[str, float], within: float | None = None
) -> FlexibleParts:
    """Return the parts of a machine file with errors of the file's numbers of joints and modes, or of fewer.

    With `within`, numbers are tried from one up to the first whose predicted errors are smaller. `frame` names that
    of the compliance, `at` are positions of motors, rad or m. Raises `InputError` for a file without such parts.
    """
    machine, _ = read_machine(file)
    top = load(load_text(file), str(file))
    parts = [*_parts_of(top, machine)]
    if not parts:
        raise InputError(str(file), BEAMS, f"no beam, and no body by modes in [{BODIES}]: name a file that has one")
    name = frame(machine)
    present = _figures(machine, name, at)

    by_count: dict[tuple[str, int], Figures | None] = {}

    def figures(part: Part, count: int) -> Figures | None:
        """Frequencies and compliance of the machine with `count` joints or modes of a part; 0: the reference."""
        if count == part.present:
            return present
        if (part.name, count) not in by_count:
            varied = _read(top, part, part.entries(count))
            by_count[part.name, count] = None if varied is None else _figures(varied, name, at)
        return by_count[part.name, count]

    rows: list[PartErrors] = []
    for part in parts:
        exact, count = figures(part, 0), part.present if within is None else 1
        while (now := figures(part, count)) is not None:
            following = figures(part, count + part.step)
            predicted, measured = (UNKNOWN if x is None else now.apart(x) for x in (following, exact))
            rows.append(PartErrors(part.name, part.what, count, predicted, measured, now.operations, part.present))
            if within is None or max(predicted) <= within:
                break
            count += 1
    return FlexibleParts(machine.name, name, tuple(rows), within)


def _read(top: Table, part: Part, entries: Iterable[Entry]) -> DescribedMachine | None:
    """The machine of a file with another entry for a part: the first of `entries` that is valid; None if none is."""
    for entry in entries:
        changed = {**top.table(part.heading).entries, part.name: entry}
        with suppress(InputError):
            return machine_of(replace(top, entries={**top.entries, part.heading: changed}))
    return None


def _parts_of(top: Table, machine: DescribedMachine) -> Iterator[Part]:
    for beam in machine.origin.beams:
        own = {key: x for key, x in top.table(BEAMS).entries[beam.name].items() if key not in OF_COUNT}
        references = [{**own, **more} for more in REFERENCES]
        if beam.modes:
            kinds: list[Entry] = [{**own, **({"stiffening": True} if beam.stiffening else {})}]
        else:
            kinds = [{**own, "rule": rule} for rule in (beam.rule, GAUSS)]
        what, count = ("modes", beam.modes) if beam.modes else ("joints", beam.joints)
        yield Part(BEAMS, beam.name, what, count, kinds, references)
    for name, entry in top.table(BODIES).entries.items():
        if "file" in entry:
            frequencies = np.sort(load_modes(Path(top.source).parent / str(entry["file"])).frequencies)
            own = {key: x for key, x in entry.items() if key != "keep"}
            (body,) = (x for x in machine.flexible if x.joint == name + ROOT)
            keeps = tuple({**own, "keep": f"{x * (1 + ROUNDING):.12g} Hz"} for x in frequencies)
            yield Part(BODIES, name, "modes", len(body.modes), (), [own], keeps)


def _figures(machine: Machine, frame: str, at: Mapping[str, float]) -> Figures:
    signals = signals_of(frame)
    motion = motion_of(machine, None, *signals)
    held = [motion.names[k] for k in motion.motors]
    linear = with_motors(linearize(motion, equilibrium(motion, at), *signals), held)
    compliance = frame_stiffness(linear, frame, at).compliance[:3, :3]
    count = trace(machine, "direct_dynamics").program.count
    return Figures(modes(linear).frequencies[:FREQUENCIES], compliance, count.products + count.add)
