"""Points computed by processes of this computer; those of a process that dies are computed again by others."""

from __future__ import annotations

import gc
import multiprocessing
import os
import signal
import sys
import threading
from collections import Counter
from collections.abc import Generator, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from multiprocessing.context import BaseContext
from typing import TypeAlias

from symoro_elastic.analysis.sweeps.tasks import Outcome, Task
from symoro_elastic.foundation.errors import InputError

Numbered: TypeAlias = Sequence[tuple[int, Sequence[float]]]
Computed: TypeAlias = list[tuple[int, Outcome]]

MOST_DEATHS = 3
"""Of the processes that compute a point, before it is given up."""
DIED = "the process that computed it died, three times"
PARTS, LONGEST = 16, 64
"""Parts of the work of a process, and most points of a part: what is computed again where one dies."""
MOST_WORKERS = 1024

_task: Task | None = None


def refuse_workers(workers: int) -> None:
    """Raise `InputError` for an invalid number of processes."""
    if isinstance(workers, bool) or not isinstance(workers, int) or not 0 <= workers <= MOST_WORKERS:
        what = f"{workers!r}: give a number of processes from 1 to {MOST_WORKERS}, or 0 for one on each core"
        raise InputError("symoro-elastic", "--workers", what)


def cores() -> int:
    """Return the number of cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


class Processes:
    """Processes that compute the points of a task."""

    def __init__(self, task: Task, workers: int) -> None:
        self.task, self.workers = task, workers
        self._have_worked = False

    def outcomes(self, points: Numbered) -> Iterator[Computed]:
        """Yield the outcomes of points, some at a time, in the order in which they are found. Raises `InputError`."""
        left = dict(points)
        size = max(1, min(LONGEST, len(left) // (PARTS * self.workers)))
        while left:
            lost = yield from self._until_one_dies(left, size, self.workers)
            yield from self._one_by_one({number: left.pop(number) for part in lost for number, _ in part})

    def _one_by_one(self, suspects: dict[int, Sequence[float]]) -> Iterator[Computed]:
        """Yield the outcomes of points one of which may end its process; that one is then given up."""
        deaths: Counter[int] = Counter()
        while suspects:
            lost = yield from self._until_one_dies(suspects, 1, 1)
            if not lost:
                break
            number = lost[0][0][0]
            deaths[number] += 1
            if deaths[number] == MOST_DEATHS:
                self._refuse_to_begin()
                del suspects[number]
                yield [(number, Outcome({}, DIED))]

    def _refuse_to_begin(self) -> None:
        if not self._have_worked:
            what = "all processes end when they begin: in a script call it below if __name__ == '__main__':"
            raise InputError("symoro-elastic", "--workers", what)

    def _until_one_dies(
        self, left: dict[int, Sequence[float]], size: int, workers: int
    ) -> Generator[Computed, None, list[Numbered]]:
        """Yield outcomes and take their points out of `left`; return the parts that were not finished by a death."""
        points = list(left.items())
        parts = [points[k : k + size] for k in range(0, len(points), size)]
        running: dict[Future[Computed], Numbered] = {}
        with _pool(self.task, workers) as pool:
            try:
                while parts or running:
                    while parts and len(running) < 2 * workers:
                        part = parts.pop(0)
                        running[pool.submit(_outcomes, part)] = part
                    for found in _ready(running):
                        for number, _ in found:
                            del left[number]
                        self._have_worked = True
                        yield found
            except BrokenProcessPool:
                return list(running.values())
        return []


@contextmanager
def _pool(task: Task, workers: int) -> Iterator[ProcessPoolExecutor]:
    """Processes that are there within a block; where it fails they end at once, also those that still compute."""
    pool = ProcessPoolExecutor(workers, _context(), _begin, (task,))
    try:
        yield pool
    except BaseException:
        living = list((pool._processes or {}).values())
        pool.shutdown(wait=False, cancel_futures=True)
        for process in living:
            process.terminate()
        raise
    pool.shutdown()


def _ready(running: dict[Future[Computed], Numbered]) -> Iterator[Computed]:
    """Yield the outcomes that are there first; raises `BrokenProcessPool`, those of this future stay then."""
    broken: BrokenProcessPool | None = None
    for future in wait(running, return_when=FIRST_COMPLETED).done:
        try:
            found = future.result()
        except BrokenProcessPool as error:
            broken = error
            continue
        del running[future]
        yield found
    if broken:
        raise broken


def _context() -> BaseContext:
    """Return how processes begin: as copies of this one where that is safe, which need no time to import and trace."""
    alone = sys.platform == "linux" and threading.active_count() == 1
    return multiprocessing.get_context("fork" if alone else "spawn")


def _begin(task: Task) -> None:
    """Prepare a process: Ctrl-C is for the one that started it, and it ends when that one does."""
    global _task  # noqa: PLW0603  (what each process of the pool computes)
    _task = task
    gc.freeze()  # collections do not go through what was copied
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


def _outcomes(points: Numbered) -> Computed:
    assert _task is not None
    return _task.outcomes(points)
