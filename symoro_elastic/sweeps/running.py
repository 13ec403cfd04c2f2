"""Points of a sweep computed: one after another, by processes of this computer, or by a cluster."""

from __future__ import annotations

import shutil
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

from symoro_elastic.errors import InputError
from symoro_elastic.progress import Progress, no_progress
from symoro_elastic.sizes import MOST_HELD, refuse_numbers
from symoro_elastic.sweeps.cluster import Cluster
from symoro_elastic.sweeps.design import Design, rows
from symoro_elastic.sweeps.journal import kept
from symoro_elastic.sweeps.points import Outcome, Task
from symoro_elastic.sweeps.processes import Computed, Numbered, Processes, cores, refuse_workers

Note = Callable[[str], None]
BYTES = 60
"""Of a number in the journal and in a file of results together, with its name, at most."""
SAID = 60.0
"""Time of a sweep, s, from which on it is told ahead."""
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

    def computed(self, task: Task, points: Numbered) -> Iterator[Computed]:
        """Yield the outcomes of points, in any order."""
        if self.scheduler is not None:
            return Cluster(task, self.scheduler).computed(points)
        if self.processes > 1 and len(points) > 1:
            return Processes(task, min(self.processes, len(points))).computed(points)
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

        Raises `InputError` where no point has figures.
        """
        points, count = list(enumerate(rows(self.design))), len(self.design.points)
        with kept(self.journal, self.digest, count) as (before, record):
            done = {k: one for k, one in before.items() if one.figures}
            if done:
                note(f"{len(done)} of {count} points were computed before, and are kept")
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
            yield from self.workplace.computed(self.task, left)

    def _refuse_size(self, figures: int) -> None:
        """Raise `InputError` where the figures of all points have no room in memory, or beside the journal."""
        points, axes = self.design.points.shape
        what = f"{figures} figures and {axes} axes at {points} points"
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
            raise InputError("symoro-elastic", "--over", f"{many} without result; the first: {reasons[0]}")


def _duration(seconds: float) -> str:
    if seconds < 5400:
        return f"{seconds / 60:.0f} min" if seconds > 90 else f"{seconds:.0f} s"
    return f"{seconds / 3600:.1f} h"
