"""The journal of a sweep: a line for each point that is computed, so that none is lost when a run ends early.

Its first line names the sweep by a digest of the machine, the points and what is computed. Numbers are read back to the
last bit; a last line that a killed run left unfinished is dropped.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TypeAlias

from symoro_elastic.errors import InputError
from symoro_elastic.output_files import appended, cut_file, is_forced, remove_file
from symoro_elastic.sweeps.points import Outcome

TITLE, PLACE = "journal of a sweep of symoro-elastic", "journal"
SPECIAL = {"nan": math.nan, "inf": math.inf, "-inf": -math.inf}
"""Numbers that JSON has no form for."""

Outcomes: TypeAlias = Iterable[tuple[int, Outcome]]
Record: TypeAlias = Callable[[Outcomes], None]


@contextmanager
def kept(path: Path | None, digest: str, count: int) -> Iterator[tuple[dict[int, Outcome], Record]]:
    """Give the outcomes that a journal holds, by number of the point, and what adds some to it.

    Without a path nothing is kept. Raises `InputError` for a journal of another sweep unless it may be replaced
    (--force), for a file that is no journal, and for one that another run writes.
    """
    if path is None:
        yield {}, lambda _: None
        return
    head = json.dumps({"title": TITLE, "digest": digest, "points": count}).encode("ascii") + b"\n"
    try:
        with appended(path, PLACE) as write:
            done = _read(path, head, count)
            if not path.stat().st_size:
                write(head)
            yield done, lambda outcomes: write(b"".join(_line(k, one) for k, one in outcomes))
    finally:
        if path.exists() and path.read_bytes()[: len(head) + 1] == head:
            remove_file(path)


def _read(path: Path, head: bytes, count: int) -> dict[int, Outcome]:
    """Return the outcomes in a journal; what is not whole, or of another sweep and to be replaced, is cut off."""
    content = path.read_bytes()
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
                what = f"line {number} is damaged: delete the line, and its point is computed again, or start anew with"
                raise InputError(str(path), PLACE, f"{what} --force") from None
            done, whole = {}, b""
            break
    cut_file(path, len(whole), PLACE)
    return done


def _refuse(path: Path, content: bytes) -> None:
    """Raise `InputError` for what is no journal, and for that of another sweep unless it may be replaced."""
    if TITLE.encode("ascii") not in content[:100]:
        raise InputError(str(path), PLACE, "is no journal of a sweep: move it away, or choose another name")
    if not is_forced():
        what = "is of another sweep, or of a machine or function changed since: remove it, or start anew with --force"
        raise InputError(str(path), PLACE, what)


def _line(point: int, outcome: Outcome) -> bytes:
    figures = {name: x if math.isfinite(x) else str(x) for name, x in outcome.figures.items()}
    return json.dumps({"point": point, "figures": figures, "reason": outcome.reason}).encode("ascii") + b"\n"


def _outcome(line: bytes, count: int) -> tuple[int, Outcome]:
    """Return the number and the outcome of a point; raises errors of several kinds for a line that is none."""
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
