"""Points of a sweep computed: one after another, by processes of this computer, or by a cluster."""

from __future__ import annotations

import json
import math
import shutil
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias

from symoro_elastic.analysis.sweeps.cluster import Cluster
from symoro_elastic.analysis.sweeps.design import Design, rows
from symoro_elastic.analysis.sweeps.processes import Computed, Numbered, Processes, cores, refuse_workers
from symoro_elastic.analysis.sweeps.tasks import Outcome, Task
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.input_files import is_plain_file, read_file
from symoro_elastic.foundation.output_files import cut_file, is_forced, open_at_end, remove_file
from symoro_elastic.foundation.progress import Progress, no_progress
from symoro_elastic.foundation.sizes import MOST_HELD, refuse_numbers

TITLE, PLACE = "journal of a sweep of symoro-elastic", "journal"
SPECIAL = {"nan": math.nan, "inf": math.inf, "-inf": -math.inf}
"""Numbers that JSON has no form for."""

Note = Callable[[str], None]
BYTES = 60
"""Of a number in the journal and in a file of results together, with its name, at most."""
SAID = 60.0
"""Time of a sweep, s, from which on it is announced."""
PROMPT = 20.0
"""Time of the first point, s, up to which a second one tells how long the others take: the first traces the machine."""


@dataclass(frozen=True)
class Workplace:
    """Where points are computed: by this process, by `workers` (0: one on each core), or by a scheduler's."""

    workers: int = 1
    scheduler: str | None = None

    def __post_init__(self) -> None:
        refuse_workers(self.workers)
        if self.scheduler is not None and self.workers != 1:
            what = "a cluster has workers of its own: leave out --workers or --scheduler"
            raise InputError("symoro-elastic", "--scheduler", what)

    @property
    def processes(self) -> int:
        """How many processes of this computer compute."""
        return self.workers or cores()

    def outcomes(self, task: Task, points: Numbered) -> Iterator[Computed]:
        """Yield the outcomes of points, in any order."""
        if self.scheduler is not None:
            return Cluster(task, self.scheduler).outcomes(points)
        if self.processes > 1 and len(points) > 1:
            return Processes(task, min(self.processes, len(points))).outcomes(points)
        return (task.outcomes([point]) for point in points)


@dataclass(frozen=True)
class Run:
    """A task at all points of a design, whose outcomes are kept in a journal."""

    task: Task
    design: Design
    workplace: Workplace
    journal: Path | None = None
    digest: str = ""

    def outcomes(self, note: Note, progress: Progress = no_progress) -> tuple[Outcome, ...]:
        """Return the outcomes of all points in their order; those that failed before are computed again.

        Raises `InputError` where no point has a result.
        """
        points, count = list(enumerate(rows(self.design))), len(self.design.points)
        with open_journal(self.journal, self.digest, count) as (before, record):
            done = {k: one for k, one in before.items() if one.figures}
            if done:
                note(f"{len(done)} of {count} points were computed before and are kept")
            left = [point for point in points if point[0] not in done]
            for found in self._computed(left, done, note):
                record(found)
                done |= dict(found)
                progress(len(done), count)
        self._refuse_without_figures(done)
        return tuple(done[k] for k in range(count))

    def _computed(self, left: Numbered, done: dict[int, Outcome], note: Note) -> Iterator[Computed]:
        """Yield the outcomes of points; the first ones here, which tells how large and how long all will be."""
        if self.workplace.scheduler is None:
            for number in range(min(2, len(left))):
                began = time.perf_counter()
                first = self.task.outcomes(left[:1])
                seconds = time.perf_counter() - began
                left = left[1:]
                if not number:
                    self._refuse_size(max(len(one.figures) for one in (*done.values(), first[0][1])))
                yield first
                if seconds > PROMPT:
                    break
            if left and seconds * len(left) / self.workplace.processes > SAID:
                note(f"{len(left)} points take about {_duration(seconds * len(left) / self.workplace.processes)}")
        if left:
            yield from self.workplace.outcomes(self.task, left)

    def _refuse_size(self, figures: int) -> None:
        """Raise `InputError` where the results at all points do not fit into memory, or on the disk of the journal."""
        points, axes = self.design.points.shape
        what = f"{figures} results and {axes} axes at {points} points"
        refuse_numbers(points * (figures + axes), what, "symoro-elastic", "--over", "give fewer points", MOST_HELD)
        if self.journal is None:
            return
        free, needed = shutil.disk_usage(self.journal.absolute().parent).free, BYTES * points * (figures + axes)
        if needed > free:
            room = f"need {needed / 1e9:.3g} GB, and {free / 1e9:.3g} GB are free"
            raise InputError(str(self.journal), "journal", f"{what} {room}: give fewer points, or another folder")

    def _refuse_without_figures(self, done: dict[int, Outcome]) -> None:
        reasons = [one.reason for _, one in sorted(done.items()) if not one.figures]
        if reasons and len(reasons) == len(done):
            many = f"all {len(reasons)} points" if len(reasons) > 1 else "the point"
            raise InputError("symoro-elastic", "--over", f"{many} without a result; the first: {reasons[0]}")


def _duration(seconds: float) -> str:
    if seconds < 5400:
        return f"{seconds / 60:.0f} min" if seconds > 90 else f"{seconds:.0f} s"
    return f"{seconds / 3600:.1f} h"


Outcomes: TypeAlias = Iterable[tuple[int, Outcome]]


Record: TypeAlias = Callable[[Outcomes], None]


# The journal of a sweep: a line for each point that is computed, so that none is lost when a run ends early.
#
# Its first line names the sweep by a digest of the machine, the points and what is computed. Numbers are read back to
# the last bit; a last line that a killed run left unfinished is dropped.
@contextmanager
def open_journal(path: Path | None, digest: str, count: int) -> Iterator[tuple[dict[int, Outcome], Record]]:
    """Give the outcomes that a journal holds, by number of the point, and what adds some to it.

    Without a path nothing is kept. Raises `InputError` for a journal of another sweep unless it may be replaced
    (--force), for a file that is not a journal, and for one that another run writes.
    """
    if path is None:
        yield {}, lambda _: None
        return
    head = json.dumps({"title": TITLE, "digest": digest, "points": count}).encode("ascii") + b"\n"
    with open_at_end(path, PLACE) as write:
        try:
            done = _read(path, head, count)
            if not path.stat().st_size:
                write(head)
            yield done, lambda outcomes: write(b"".join(_line(k, one) for k, one in outcomes))
        finally:
            if is_plain_file(path) and head.startswith(read_file(path, PLACE, len(head) + 1)):
                remove_file(path)


def _read(path: Path, head: bytes, count: int) -> dict[int, Outcome]:
    """Return the outcomes in a journal; what is not whole, or of another sweep and to be replaced, is cut off."""
    content = read_file(path, PLACE)
    whole = content[: content.rfind(b"\n") + 1]
    done: dict[int, Outcome] = {}
    if not whole.startswith(head):
        if not head.startswith(content):
            _refuse(path, content)
        whole = b""
    for number, line in enumerate(whole[len(head) :].split(b"\n")[:-1], start=2):
        try:
            done |= [_outcome(line, count)]
        except (ValueError, TypeError, KeyError, AttributeError, RecursionError):
            if not is_forced():
                what = (
                    f"line {number} is damaged: delete the line, and its point is computed again, or start again with"
                )
                raise InputError(str(path), PLACE, f"{what} --force") from None
            done, whole = {}, b""
            break
    cut_file(path, len(whole), PLACE)
    return done


def _refuse(path: Path, content: bytes) -> None:
    """Raise `InputError` for what is not a journal, and for that of another sweep unless it may be replaced."""
    if TITLE.encode("ascii") not in content[:100]:
        raise InputError(str(path), PLACE, "is not a journal of a sweep: move it away, or choose another name")
    if not is_forced():
        what = "is of another sweep, or its machine or function has changed: remove it, or start again with --force"
        raise InputError(str(path), PLACE, what)


def _line(point: int, outcome: Outcome) -> bytes:
    figures = {name: x if math.isfinite(x) else str(x) for name, x in outcome.figures.items()}
    return json.dumps({"point": point, "figures": figures, "reason": outcome.reason}).encode("ascii") + b"\n"


def _outcome(line: bytes, count: int) -> tuple[int, Outcome]:
    """Return the number and the outcome of a point; raises errors of several kinds for a line that is not one."""
    entry: dict[str, Any] = json.loads(line.decode("ascii"))
    figures = {name: SPECIAL[x] if isinstance(x, str) else _number(x) for name, x in entry["figures"].items()}
    point, reason = entry["point"], entry["reason"]
    if type(point) is not int or not 0 <= point < count or not isinstance(reason, str):
        raise ValueError
    return point, Outcome(figures, reason)


def _number(given: object) -> float:
    if type(given) not in (int, float):
        raise TypeError
    return float(given)  # type: ignore[arg-type]
