"""How far a long call is, below the cell of a notebook that makes it."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from html import escape
from typing import Any

from symoro_elastic.foundation.progress import Progress

SHOWN_AFTER, AT_LEAST_BETWEEN = 1.0, 0.2
"""s: when a call is long, and how often what is shown of it changes."""


@contextmanager
def followed(name: str, wanted: Mapping[str, object], given: Mapping[str, object]) -> Iterator[dict[str, Any]]:
    """Give those callbacks of a function that are `wanted` and not `given`: they show how far it is in a notebook.

    Elsewhere there are none. What is shown comes after a second and goes at the end.
    """
    shell = getattr(sys.modules.get("IPython"), "get_ipython", lambda: None)()
    if getattr(shell, "kernel", None) is None:
        yield {}
        return
    from IPython.display import display, update_display

    shown = _Shown(name, display, update_display)
    callbacks = {"progress": shown.progress, "announce": shown.announce, "watched": shown.watched}
    try:
        yield {key: call for key, call in callbacks.items() if key in wanted and key not in given}
    finally:
        shown.end()


class _Shown:
    """A line and a bar below a cell."""

    def __init__(self, name: str, display: Any, update: Any) -> None:
        self.name, self.step = name, ""
        self._display, self._update = display, update
        self._next = time.monotonic() + SHOWN_AFTER
        self._id: str | None = None

    def announce(self, step: str) -> None:
        self.step = step
        self._show("", "")

    def watched(self, step: str) -> Progress:
        self.announce(step)
        return self.progress

    def progress(self, done: int, total: int) -> None:
        bar = f'<progress max="{int(total)}" value="{int(done)}" aria-label="{escape(self.name)}"></progress> '
        self._show(bar, f" {done} of {total}")

    def end(self) -> None:
        """Leave nothing of it."""
        if self._id:
            self._show("", None)

    def _show(self, bar: str, count: str | None) -> None:
        if count is not None and time.monotonic() < self._next:
            return
        self._next = time.monotonic() + AT_LEAST_BETWEEN
        text = "" if count is None else f"{self.name}{f', {self.step}' if self.step else ''}{count}"
        data = {"text/plain": text, "text/html": bar + escape(text)}
        if self._id:
            self._update(data, display_id=self._id, raw=True)
        else:
            self._id = self._display(data, display_id=True, raw=True).display_id
