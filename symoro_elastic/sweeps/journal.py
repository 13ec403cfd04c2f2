"""The journal of a sweep: a line for each point that is computed, so that none is lost when a run ends early.

Its first line names the sweep by a digest of the machine, the points and what is computed. Numbers are read back to the
last bit; a last line that a killed run left unfinished is dropped.
"""

from __future__ import annotations

import hashlib
import inspect
import json
import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from symoro_elastic.errors import InputError
from symoro_elastic.output_files import appended, cut_file, is_forced, remove_file
from symoro_elastic.sweeps.points import Outcome

TITLE, PLACE = "journal of a sweep of symoro-elastic", "journal"
SOURCE = "source"
"""Fields that hold the name of a file, whose place does not matter."""
SPECIAL = {"nan": math.nan, "inf": math.inf, "-inf": -math.inf}
"""Numbers that JSON has no form for."""

Outcomes: TypeAlias = Iterable[tuple[int, Outcome]]
Record: TypeAlias = Callable[[Outcomes], None]


def digest(*parts: object) -> str:
    """Return a digest of what a sweep computes: of all data of machines and arguments but the names of their files."""
    found = hashlib.sha256()
    for word in _words(parts):
        found.update(word + b"\0")
    return found.hexdigest()


def _words(value: Any) -> Iterator[bytes]:
    """Yield data of any kind in pieces, the same for the same data; a `repr` may leave some out."""
    if is_dataclass(value) and not isinstance(value, type):
        yield type(value).__name__.encode()
        pairs: Iterable[tuple[Any, Any]] = ((one.name, getattr(value, one.name)) for one in fields(value))
        yield from _words([pair for pair in pairs if pair[0] != SOURCE])
    elif isinstance(value, Mapping):
        yield from _words(list(value.items()))
    elif isinstance(value, list | tuple):
        yield str(len(value)).encode()
        for each in value:
            yield from _words(each)
    elif isinstance(value, set | frozenset):
        yield from _words(sorted(map(str, value)))
    elif isinstance(value, np.ndarray):
        yield from (str(value.shape).encode(), value.tobytes())
    else:
        yield value if isinstance(value, bytes) else (_text(value) if callable(value) else repr(value)).encode()


def _text(function: Callable[..., Any]) -> str:
    """Return the text of a function, its name where there is none."""
    try:
        return inspect.getsource(function)
    except (OSError, TypeError):
        return f"{getattr(function, '__module__', '')}.{getattr(function, '__qualname__', type(function).__name__)}"


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
            done = _read(path, head)
            if not path.stat().st_size:
                write(head)
            yield done, lambda outcomes: write(b"".join(_line(k, one) for k, one in outcomes))
    finally:
        if path.exists() and path.read_bytes()[: len(head) + 1] == head:
            remove_file(path)


def _read(path: Path, head: bytes) -> dict[int, Outcome]:
    """Return the outcomes in a journal; what is not whole, or of another sweep and to be replaced, is cut off."""
    content = path.read_bytes()
    whole = content[: content.rfind(b"\n") + 1]
    first, *lines = whole.splitlines(keepends=True) or [b""]
    if content and first != head:
        _refuse(path, content)
        whole, lines = b"", []
    cut_file(path, len(whole), PLACE)
    return dict(map(_outcome, lines))


def _refuse(path: Path, content: bytes) -> None:
    """Raise `InputError` for what is no journal, and for that of another sweep unless it may be replaced."""
    if TITLE.encode("ascii") not in content[:100]:
        raise InputError(str(path), PLACE, "is no journal of a sweep: move it away, or choose another name")
    if not is_forced():
        what = "is of another sweep, or of a machine that has changed since: remove it, or start anew with --force"
        raise InputError(str(path), PLACE, what)


def _line(point: int, outcome: Outcome) -> bytes:
    figures = {name: x if math.isfinite(x) else str(x) for name, x in outcome.figures.items()}
    return json.dumps({"point": point, "figures": figures, "reason": outcome.reason}).encode("ascii") + b"\n"


def _outcome(line: bytes) -> tuple[int, Outcome]:
    entry: dict[str, Any] = json.loads(line)
    figures = {name: SPECIAL[x] if isinstance(x, str) else float(x) for name, x in entry["figures"].items()}
    return entry["point"], Outcome(figures, entry["reason"])
