"""Formats of files that are written: the suffix of the name says which one."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from symoro_elastic.foundation.errors import InputError

COLUMNS = (".csv", ".npz")
MODES = (".npz", ".mat")
LINEARIZATIONS = (".npz", ".mat", ".m")
RESPONSES = (".csv", ".npz", ".mat")
SWEEPS = (".csv", ".nc", ".npz")
PICTURES = (".svg", ".png", ".pdf")
PICTURE_FORMATS = ("png", "svg", "pdf")
"""Of plots, the usual one first."""
PAGES = (".html", ".htm")
EQUATIONS = {".tex": "latex", ".html": "html", ".htm": "html", ".pdf": "pdf"}
SCENES, MARKDOWN, SCHEMAS = (".toml",), (".md",), (".json",)


def form_of(path: str | Path, forms: Sequence[str] | dict[str, str], place: str = "file") -> str:
    """Return the suffix of a file, one of `forms`, in small letters; raises `InputError`."""
    suffix = Path(path).suffix.lower()
    if suffix not in forms:
        *others, last = forms
        known = f"{', '.join(others)} or {last}" if others else last
        given = f"there is no format {Path(path).suffix!r}" if suffix else "its format is not said"
        raise InputError(str(path), place, f"{given}: end the name with {known}")
    return suffix
