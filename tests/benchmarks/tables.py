"""How benchmarks tell their figures."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any, TypeVar

from rich import box
from rich.console import Console
from rich.progress import track
from rich.table import Table

T = TypeVar("T")


def print_table(title: str, columns: Sequence[str], rows: Iterable[Sequence[str]]) -> None:
    """Text to the left, figures to the right."""
    table = Table(title=title, box=box.SIMPLE_HEAD, title_justify="left")
    for k, column in enumerate(columns):
        table.add_column(column, justify="right" if k else "left")
    for row in rows:
        table.add_row(*row)
    Console(highlight=False, width=None if sys.stdout.isatty() else 180).print(table)


def met(is_met: bool) -> str:
    """Whether a goal is met, in words."""
    return "met" if is_met else "NOT MET"


def save_json(file: Path, figures: Any) -> None:
    file.write_text(json.dumps(figures, indent=1) + "\n", encoding="utf-8")


def progress(items: Sequence[T], title: str) -> Iterable[T]:
    """The items, with a bar on a terminal's stderr."""
    console = Console(stderr=True)
    return track(items, title, console=console, disable=not console.is_terminal, transient=True)
