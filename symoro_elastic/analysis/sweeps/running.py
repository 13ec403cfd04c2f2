"""Computation of the points of a sweep: sequential, by processes of this computer, or by a cluster."""

from __future__ import annotations

import gc
import json
import logging
import math
import multiprocessing
import os
import re
import shutil
import signal
import sys
import threading
import time
from collections import Counter
from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, CancelledError, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from multiprocessing.context import BaseContext
from pathlib import Path
from typing import Any, TypeAlias

from symoro_elastic.analysis.sweeps.design import Design, rows
from symoro_elastic.analysis.sweeps.tasks import Outcome, Task
from symoro_elastic.foundation.errors import MOST_HELD, InputError, refuse_numbers
from symoro_elastic.foundation.input_files import is_plain_file, read_file
from symoro_elastic.foundation.output_files import cut_file, is_forced, open_at_end, remove_file
from symoro_elastic.foundation.packages import import_optional
from symoro_elastic.foundation.progress import Progress, no_progress

TITLE, PLACE = "journal of a sweep of symoro-elastic", "journal"
SPECIAL = {"nan": math.nan, "inf": math.inf, "-inf": -math.inf}
"""Numbers that JSON has no form for."""

Note = Callable[[str], None]
BYTES = 60
"""Of a number in the journal and in a file of results together, with its name, at most."""
SAID = 60.0
"""Time of a sweep, s, from which on it is announced."""
PROMPT = 20.0
"""Time of the first point, s, up to which a second one is timed for an estimate: the first traces the machine."""
OPTION = "--scheduler"
ADDRESS = re.compile(r"([a-z]+://)?[^\s/]+:\d+")
PATIENCE = 10.0
"""Time in which a scheduler has to answer, s."""
WITHOUT_WORKERS = 60.0
"""Time for which a cluster may be without workers, s."""
PARTS = 8
"""Parts of the work for each thread of the cluster."""
Numbered: TypeAlias = Sequence[tuple[int, Sequence[float]]]
Computed: TypeAlias = list[tuple[int, Outcome]]

MOST_DEATHS = 3
"""Of the processes that compute a point, before it is given up."""
DIED = "the process that computed it died, three times"
PARTS_OF_PROCESSES, LONGEST = 16, 64
"""Parts of the work of a process, and most points of a part: what is computed again where one dies."""
MOST_WORKERS = 1024

_task: Task | None = None


@dataclass(frozen=True)
class Workplace:
    """Where points are computed: in this process, `workers` processes (0: one per core), or by a scheduler."""

    workers: int = 1
    scheduler: str | None = None

    def __post_init__(self) -> None:
        refuse_workers(self.workers)
        if self.scheduler is not None and self.workers != 1:
            what = "a cluster has workers of its own: leave out --workers or --scheduler"
            raise InputError("symoro-elastic", "--scheduler", what)

    @property
    def processes(self) -> int:
        """Number of processes of this computer."""
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
    """A task at all points of a design, with a journal of its outcomes."""

    task: Task
    design: Design
    workplace: Workplace
    journal: Path | None = None
    digest: str = ""

    def outcomes(self, note: Note, progress: Progress = no_progress) -> tuple[Outcome, ...]:
        """Return the outcomes of all points in order; failed ones are computed again.

        Raises `InputError` where no point has a result.
        """
        points, count = list(enumerate(rows(self.design))), len(self.design.points)
        is_new = self.journal is not None and not os.path.lexists(self.journal)
        with open_journal(self.journal, self.digest, count) as (before, record):
            done = {k: outcome for k, outcome in before.items() if outcome.figures}
            if done:
                note(f"{len(done)} of {count} points were computed before and are kept")
            points_left = [point for point in points if point[0] not in done]
            for computed in self._compute(points_left, done, note):
                record(computed)
                done |= dict(computed)
                progress(len(done), count)
        if is_new and self.journal and not any(outcome.figures for outcome in done.values()):
            remove_file(self.journal)  # it has nothing to go on from
        reasons = [outcome.reason for _, outcome in sorted(done.items()) if not outcome.figures]
        if reasons and len(reasons) == len(done):
            many = f"all {len(reasons)} points" if len(reasons) > 1 else "the point"
            raise InputError("symoro-elastic", "--over", f"{many} without a result; the first: {reasons[0]}")
        return tuple(done[k] for k in range(count))

    def _compute(self, points_left: Numbered, done: dict[int, Outcome], note: Note) -> Iterator[Computed]:
        """Yield the outcomes of points; the first ones in this process, to estimate size and duration."""
        if self.workplace.scheduler is None:
            for number in range(min(2, len(points_left))):
                began = time.perf_counter()
                first = self.task.outcomes(points_left[:1])
                seconds = time.perf_counter() - began
                points_left = points_left[1:]
                if not number:
                    self._refuse_size(max(len(outcome.figures) for outcome in (*done.values(), first[0][1])))
                yield first
                if seconds > PROMPT:
                    break
            if points_left and seconds * len(points_left) / self.workplace.processes > SAID:
                duration = _duration(seconds * len(points_left) / self.workplace.processes)
                note(f"{len(points_left)} points need about {duration}")
        if points_left:
            yield from self.workplace.outcomes(self.task, points_left)

    def _refuse_size(self, figures: int) -> None:
        """Raise `InputError` for results that exceed memory, or the disk of the journal."""
        points, axes = self.design.points.shape
        what = f"{figures} results and {axes} axes at {points} points"
        refuse_numbers(points * (figures + axes), what, "symoro-elastic", "--over", "give fewer points", MOST_HELD)
        if self.journal is None:
            return
        free, needed = shutil.disk_usage(self.journal.absolute().parent).free, BYTES * points * (figures + axes)
        if needed > free:
            room = f"need {needed / 1e9:.3g} GB, and {free / 1e9:.3g} GB are free"
            raise InputError(str(self.journal), "journal", f"{what} {room}: give fewer points, or another folder")


def _duration(seconds: float) -> str:
    if seconds < 5400:
        return f"{seconds / 60:.0f} min" if seconds > 90 else f"{seconds:.0f} s"
    return f"{seconds / 3600:.1f} h"


Outcomes: TypeAlias = Iterable[tuple[int, Outcome]]


Record: TypeAlias = Callable[[Outcomes], None]


# The journal of a sweep: a line for each point that is computed, so that a run can end early without loss.
#
# Its first line names the sweep by a digest of the machine, the points and what is computed. Numbers are read back to
# the last bit; a last line that a killed run left unfinished is dropped.
@contextmanager
def open_journal(path: Path | None, digest: str, count: int) -> Iterator[tuple[dict[int, Outcome], Record]]:
    """Yield the outcomes in a journal, by number of the point, and a function that appends to it.

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
            yield done, lambda outcomes: write(b"".join(_line(k, outcome) for k, outcome in outcomes))
        finally:
            if is_plain_file(path) and head.startswith(read_file(path, PLACE, len(head) + 1)):
                remove_file(path)


def _read(path: Path, head: bytes, count: int) -> dict[int, Outcome]:
    """Return the outcomes in a journal; incomplete or replaceable ones are cut off."""
    content = read_file(path, PLACE)
    complete = content[: content.rfind(b"\n") + 1]
    done: dict[int, Outcome] = {}
    if not complete.startswith(head):
        if not head.startswith(content):
            _refuse(path, content)
        complete = b""
    for number, line in enumerate(complete[len(head) :].split(b"\n")[:-1], start=2):
        try:
            done |= [_outcome(line, count)]
        except (ValueError, TypeError, KeyError, AttributeError, RecursionError):
            if not is_forced():
                way_out = "delete the line, and its point is computed again, or start again with --force"
                raise InputError(str(path), PLACE, f"line {number} is damaged: {way_out}") from None
            done, complete = {}, b""
            break
    cut_file(path, len(complete), PLACE)
    return done


def _refuse(path: Path, content: bytes) -> None:
    """Raise `InputError` for a file that is not a journal, or that of another sweep unless it may be replaced."""
    if TITLE.encode("ascii") not in content[:100]:
        raise InputError(str(path), PLACE, "is not a journal of a sweep: move it away, or choose another name")
    if not is_forced():
        what = "is of another sweep, or its machine or function has changed: remove it, or start again with --force"
        raise InputError(str(path), PLACE, what)


def _line(point: int, outcome: Outcome) -> bytes:
    figures = {name: x if math.isfinite(x) else str(x) for name, x in outcome.figures.items()}
    return json.dumps({"point": point, "figures": figures, "reason": outcome.reason}).encode("ascii") + b"\n"


def _outcome(line: bytes, count: int) -> tuple[int, Outcome]:
    """Return the number and the outcome of a point; raises several kinds of errors for an invalid line."""
    entry: dict[str, Any] = json.loads(line.decode("ascii"))
    figures = {name: SPECIAL[x] if isinstance(x, str) else _number(x) for name, x in entry["figures"].items()}
    point, reason = entry["point"], entry["reason"]
    if type(point) is not int or not 0 <= point < count or not isinstance(reason, str):
        raise ValueError
    return point, Outcome(figures, reason)


def _number(value: object) -> float:
    if type(value) not in (int, float):
        raise TypeError
    return float(value)  # type: ignore[arg-type]


class Cluster:
    """A cluster that computes the points of a task; points computed twice after a worker died count once."""

    def __init__(self, task: Task, address: str) -> None:
        self.task, self.address = task, address

    def outcomes(self, points: Numbered) -> Iterator[Computed]:
        """Yield the outcomes of points in batches, in order of completion.

        Raises `InputError` for a missing scheduler, if it vanishes, and without workers.
        """
        with self._client() as client:
            threads = sum(client.nthreads().values()) or 1
            size = max(1, min(LONGEST, len(points) // (PARTS * threads)))
            task = self._given(lambda: client.scatter(self.task, broadcast=True, hash=False))
            lost: list[Numbered] = [points[k : k + size] for k in range(0, len(points), size)]
            while lost:
                parts, lost = lost, []
                for part, computed in self._results(client, task, parts):
                    if computed is not None:
                        yield computed
                    elif len(part) == 1:
                        yield [(part[0][0], Outcome({}, DIED))]
                    else:
                        lost += [[point] for point in part]

    def _results(self, client: Any, task: Any, parts: list[Numbered]) -> Iterator[tuple[Numbered, Computed | None]]:
        """Yield the outcomes of parts of the points; None if each worker that had a part has died."""
        distributed = _dask()
        submitted = self._given(lambda: [client.submit(Task.outcomes, task, part, pure=False) for part in parts])
        running = dict(zip(submitted, parts, strict=True))
        while running:
            for future in self._done(client, list(running)):
                try:
                    computed = future.result(timeout=PATIENCE)
                except distributed.KilledWorker:
                    computed = None
                except Exception as error:  # of many kinds, by what is lost
                    raise self._failure(client, error) from None
                yield running.pop(future), computed

    def _done(self, client: Any, running: list[Any]) -> list[Any]:
        """Return the finished parts, at least one; raises `InputError` without workers."""
        idle = time.monotonic()
        while True:
            try:
                finished = _dask().wait(running, timeout=1.0, return_when="FIRST_COMPLETED").done
                return [future for future in running if future in finished]
            except (TimeoutError, _dask().TimeoutError):
                if client.status != "running":
                    raise self._lost() from None
                idle = time.monotonic() if client.nthreads() else idle
                if time.monotonic() - idle > WITHOUT_WORKERS:
                    raise self._without_workers() from None
            except Exception as error:  # of many kinds, by what is lost
                raise self._failure(client, error) from None

    @contextmanager
    def _client(self) -> Iterator[Any]:
        """A client of the scheduler, closed at the end; the cluster continues."""
        if not ADDRESS.fullmatch(self.address):
            what = f"{self.address!r} is not an address: give that of a scheduler, such as tcp://192.0.2.1:8786"
            raise InputError("symoro-elastic", OPTION, what)
        distributed = _dask()
        with _silent(), ExitStack() as closing:
            try:
                client = distributed.Client(self.address, timeout=PATIENCE)
            except (OSError, ValueError, RuntimeError) as error:
                what = f"{self.address!r}: no scheduler answers there ({_short(error)}): start one, or leave it out"
                raise InputError("symoro-elastic", OPTION, what) from None
            closing.callback(client.close, timeout=1)
            try:
                client.wait_for_workers(1, timeout=PATIENCE)
            except (TimeoutError, distributed.TimeoutError):
                raise self._without_workers() from None
            yield client

    def _given(self, send: Any) -> Any:
        """Return an object sent to the cluster; raises `InputError` if it cannot be sent."""
        try:
            return send()
        except (TypeError, AttributeError, ValueError) as error:
            what = f"the function cannot be sent to other processes ({_short(error)}): define the function in a module"
            raise InputError("symoro-elastic", "--of", what) from None
        except (OSError, CancelledError):
            raise self._lost() from None

    def _failure(self, client: Any, error: Exception) -> InputError:
        if client.status != "running" or isinstance(error, OSError | CancelledError | TimeoutError):
            return self._lost()
        what = f"a worker fails ({_short(error)}): it needs symoro-elastic of this version, and what it uses"
        return InputError("symoro-elastic", OPTION, what)

    def _lost(self) -> InputError:
        advice = "a journal (--out) keeps what was computed: give the command again"
        return InputError("symoro-elastic", OPTION, f"{self.address!r}: the scheduler is gone; {advice}")

    def _without_workers(self) -> InputError:
        return InputError("symoro-elastic", OPTION, f"{self.address!r} has no workers: start some, or leave it out")


@contextmanager
def _silent() -> Iterator[None]:
    """Suppress the library's log of lost connections on the terminal: our errors report it in one line."""
    names = [name for name in logging.root.manager.loggerDict if name.partition(".")[0] == "distributed"]
    levels = {name: logging.getLogger(name).level for name in names}
    for name in levels:
        logging.getLogger(name).setLevel(logging.CRITICAL + 1)
    try:
        yield
    finally:
        for name, level in levels.items():
            logging.getLogger(name).setLevel(level)


def _dask() -> Any:
    return import_optional("distributed", "a sweep on a cluster", "sweep")


def _short(error: BaseException) -> str:
    return " ".join(f"{type(error).__name__}: {error}".split())[:200]


def refuse_workers(workers: int) -> None:
    """Raise `InputError` for an invalid number of processes."""
    if isinstance(workers, bool) or not isinstance(workers, int) or not 0 <= workers <= MOST_WORKERS:
        what = f"{workers!r}: give a number of processes from 1 to {MOST_WORKERS}, or 0 for one on each core"
        raise InputError("symoro-elastic", "--workers", what)


def cores() -> int:
    """Return the number of available cores."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


class Processes:
    """Processes that compute the points of a task."""

    def __init__(self, task: Task, workers: int) -> None:
        self.task, self.workers = task, workers
        self._have_worked = False

    def outcomes(self, points: Numbered) -> Iterator[Computed]:
        """Yield the outcomes of points in batches, in order of completion. Raises `InputError`."""
        points_left = dict(points)
        size = max(1, min(LONGEST, len(points_left) // (PARTS_OF_PROCESSES * self.workers)))
        while points_left:
            lost = yield from self._until_one_dies(points_left, size, self.workers)
            yield from self._one_by_one({number: points_left.pop(number) for part in lost for number, _ in part})

    def _one_by_one(self, suspects: dict[int, Sequence[float]]) -> Iterator[Computed]:
        """Yield the outcomes of `suspects`, points one of which may end its process and is then skipped."""
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
        self, points_left: dict[int, Sequence[float]], size: int, workers: int
    ) -> Generator[Computed, None, list[Numbered]]:
        """Yield outcomes and remove their points from `points_left`; return parts unfinished when a process dies."""
        points = list(points_left.items())
        parts = [points[k : k + size] for k in range(0, len(points), size)]
        running: dict[Future[Computed], Numbered] = {}
        with _pool(self.task, workers) as pool:
            try:
                while parts or running:
                    while parts and len(running) < 2 * workers:
                        part = parts.pop(0)
                        running[pool.submit(_outcomes_of, part)] = part
                    for computed in _ready(running):
                        for number, _ in computed:
                            del points_left[number]
                        self._have_worked = True
                        yield computed
            except BrokenProcessPool:
                return list(running.values())
        return []


@contextmanager
def _pool(task: Task, workers: int) -> Iterator[ProcessPoolExecutor]:
    """Worker processes within a block; on failure they end at once, also during computation."""
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
    """Yield the outcomes that are ready; raises `BrokenProcessPool`, without those of the failed future."""
    broken: BrokenProcessPool | None = None
    for future in wait(running, return_when=FIRST_COMPLETED).done:
        try:
            computed = future.result()
        except BrokenProcessPool as error:
            broken = error
            continue
        del running[future]
        yield computed
    if broken:
        raise broken


def _context() -> BaseContext:
    """Return the multiprocessing context: fork if this process has one thread on Linux, else spawn."""
    alone = sys.platform == "linux" and threading.active_count() == 1
    return multiprocessing.get_context("fork" if alone else "spawn")


def _begin(task: Task) -> None:
    """Prepare a process: it ignores Ctrl-C, and ends with its parent."""
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


def _outcomes_of(points: Numbered) -> Computed:
    assert _task is not None
    return _task.outcomes(points)
