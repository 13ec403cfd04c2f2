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
DOCUMENTS = (".txt", ".log", ".rst", ".doc", ".docx", ".odt", ".rtf", ".xls", ".xlsx", ".ods", ".tsv", ".yaml", ".yml")
CODE = (".c", ".h", ".cpp", ".hpp", ".cu", ".py", ".ipynb", ".js", ".st", ".comp", ".fmu", ".xml", ".par", ".urdf")
OTHERS = (".jpg", ".jpeg", ".gif", ".webp", ".eps", ".mp4", ".zip", ".gz", ".tar", ".h5", ".hdf5", ".pkl", ".npy")
WRITTEN = (*COLUMNS, *MODES, *LINEARIZATIONS, *RESPONSES, *SWEEPS, *PICTURES, *PAGES, *EQUATIONS, *SCENES, *MARKDOWN)
OF_FILES = frozenset((*WRITTEN, *SCHEMAS, *DOCUMENTS, *CODE, *OTHERS))
"""Suffixes of what is a file: no folder is made of such a name."""


def form_of(path: str | Path, forms: Sequence[str] | dict[str, str], place: str = "file") -> str:
    """Return the suffix of a file, one of `forms`, in small letters; raises `InputError`."""
    suffix = Path(path).suffix.lower()
    if suffix not in forms:
        *others, last = forms
        known = f"{', '.join(others)} or {last}" if others else last
        given = f"there is no format {Path(path).suffix!r}" if suffix else "its format is not said"
        raise InputError(str(path), place, f"{given}: end the name with {known}")
    return suffix
