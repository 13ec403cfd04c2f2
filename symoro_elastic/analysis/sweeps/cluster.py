"""Points computed by the workers of a Dask cluster that is there already, by its address."""

from __future__ import annotations

import logging
import re
import time
from collections.abc import Iterator
from concurrent.futures import CancelledError
from contextlib import ExitStack, contextmanager
from typing import Any

from symoro_elastic.analysis.sweeps.processes import DIED, LONGEST, Computed, Numbered
from symoro_elastic.analysis.sweeps.tasks import Outcome, Task
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.packages import import_optional

OPTION = "--scheduler"
ADDRESS = re.compile(r"([a-z]+://)?[^\s/]+:\d+")
PATIENCE = 10.0
"""Time in which a scheduler has to answer, s."""
WITHOUT_WORKERS = 60.0
"""Time for which a cluster may be without workers, s."""
PARTS = 8
"""Parts of the work for each thread of the cluster."""


class Cluster:
    """A cluster that computes the points of a task; what its workers compute twice since one died counts once."""

    def __init__(self, task: Task, address: str) -> None:
        self.task, self.address = task, address

    def outcomes(self, points: Numbered) -> Iterator[Computed]:
        """Yield the outcomes of points, some at a time, in the order in which they are found.

        Raises `InputError` where there is no scheduler, where it vanishes, and where it has no workers.
        """
        with self._client() as client:
            threads = sum(client.nthreads().values()) or 1
            size = max(1, min(LONGEST, len(points) // (PARTS * threads)))
            task = self._given(lambda: client.scatter(self.task, broadcast=True, hash=False))
            lost: list[Numbered] = [points[k : k + size] for k in range(0, len(points), size)]
            while lost:
                parts, lost = lost, []
                for part, found in self._results(client, task, parts):
                    if found is not None:
                        yield found
                    elif len(part) == 1:
                        yield [(part[0][0], Outcome({}, DIED))]
                    else:
                        lost += [[point] for point in part]

    def _results(self, client: Any, task: Any, parts: list[Numbered]) -> Iterator[tuple[Numbered, Computed | None]]:
        """Yield the outcomes of parts; None where each worker that was given the part has died."""
        distributed = _distributed()
        submitted = self._given(lambda: [client.submit(_outcomes, task, part, pure=False) for part in parts])
        running = dict(zip(submitted, parts, strict=True))
        while running:
            for future in self._done(client, list(running)):
                try:
                    found = future.result(timeout=PATIENCE)
                except distributed.KilledWorker:
                    found = None
                except Exception as error:  # of many kinds, by what is lost
                    raise self._failure(client, error) from None
                yield running.pop(future), found

    def _done(self, client: Any, running: list[Any]) -> list[Any]:
        """Return the parts that are done, at least one."""
        idle = time.monotonic()
        while True:
            try:
                found = _distributed().wait(running, timeout=1.0, return_when="FIRST_COMPLETED").done
                return [future for future in running if future in found]
            except (TimeoutError, _distributed().TimeoutError):
                if client.status != "running":
                    raise self._lost() from None
                idle = time.monotonic() if client.nthreads() else idle
                if time.monotonic() - idle > WITHOUT_WORKERS:
                    raise self._without_workers() from None
            except Exception as error:  # of many kinds, by what is lost
                raise self._failure(client, error) from None

    @contextmanager
    def _client(self) -> Iterator[Any]:
        """A client of the scheduler; it is closed in the end, and the cluster stays."""
        if not ADDRESS.fullmatch(self.address):
            what = f"{self.address!r} is not an address: give that of a scheduler, such as tcp://192.0.2.1:8786"
            raise InputError("symoro-elastic", OPTION, what)
        distributed = _distributed()
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
        """Return what was sent to the cluster; raises `InputError` for what cannot be."""
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
        kept = "a journal (--out) keeps what was computed: give the command again"
        return InputError("symoro-elastic", OPTION, f"{self.address!r}: the scheduler is gone; {kept}")

    def _without_workers(self) -> InputError:
        return InputError("symoro-elastic", OPTION, f"{self.address!r} has no workers: start some, or leave it out")


@contextmanager
def _silent() -> Iterator[None]:
    """Keep what the library logs about lost connections from the terminal: errors of ours say it in one line."""
    names = [name for name in logging.root.manager.loggerDict if name.partition(".")[0] == "distributed"]
    levels = {name: logging.getLogger(name).level for name in names}
    for name in levels:
        logging.getLogger(name).setLevel(logging.CRITICAL + 1)
    try:
        yield
    finally:
        for name, level in levels.items():
            logging.getLogger(name).setLevel(level)


def _outcomes(task: Task, points: Numbered) -> Computed:
    return task.outcomes(points)


def _distributed() -> Any:
    return import_optional("distributed", "a sweep on a cluster", "sweep")


def _short(error: BaseException) -> str:
    return " ".join(f"{type(error).__name__}: {error}".split())[:200]
