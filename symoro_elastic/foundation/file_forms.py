"""Formats of output files, determined by the suffix."""

from __future__ import annotations

import ntpath
import re
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
DOCUMENTS = (".txt", ".log", ".rst", ".doc", ".docx", ".odt", ".rtf", ".xls", ".xlsx", ".ods", ".tsv", ".yaml", ".yml")
CODE = (".c", ".h", ".cpp", ".hpp", ".cu", ".py", ".ipynb", ".js", ".st", ".comp", ".fmu", ".xml", ".par", ".urdf")
OTHERS = (".jpg", ".jpeg", ".gif", ".webp", ".eps", ".mp4", ".zip", ".gz", ".tar", ".h5", ".hdf5", ".pkl", ".npy")
WRITTEN = (*COLUMNS, *MODES, *LINEARIZATIONS, *RESPONSES, *SWEEPS, *PICTURES, *PAGES, *EQUATIONS, *SCENES, *MARKDOWN)
OF_FILES = frozenset((*WRITTEN, *SCHEMAS, *DOCUMENTS, *CODE, *OTHERS))
"""Suffixes of what is a file: no folder is made of such a name."""

DEVICE = re.compile(r"(con|prn|aux|nul|com\d|lpt\d|conin\$|conout\$)", re.ASCII | re.IGNORECASE)
"""Names that Windows keeps for devices, whatever suffix they have."""


def why_not_on_windows(path: str) -> str:
    """Return why a path cannot be a file on Windows; empty for others."""
    _, path = ntpath.splitdrive(path)
    if ":" in path:
        return "a stream of another file"
    stems = (part.partition(".")[0].rstrip(" ") for part in re.split(r"[/\\]", path))
    return "a device" if any(map(DEVICE.fullmatch, stems)) else ""


def form_of(path: str | Path, forms: Sequence[str] | dict[str, str], place: str = "file") -> str:
    """Return the suffix of a file, one of `forms`, in lower case; raises `InputError`."""
    suffix = Path(path).suffix.lower()
    if suffix not in forms:
        *first, last = forms
        listed = f"{', '.join(first)} or {last}" if first else last
        message = f"unknown format {Path(path).suffix!r}" if suffix else "its format is missing"
        raise InputError(str(path), place, f"{message}: end the name with {listed}")
    return suffix
