"""Plots without a window, saved with the same bytes each time; matplotlib is imported when one is drawn."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from symoro_elastic.errors import InputError
from symoro_elastic.packages import imported

PICTURE_FORMATS = ("png", "svg", "pdf")


def new_figure(width: float, height: float) -> Any:
    """Return an empty figure, in inches. Raises `InputError` where matplotlib is missing."""
    figure = _matplotlib("matplotlib.figure").Figure(figsize=(width, height), layout="constrained")
    _matplotlib("matplotlib.backends.backend_agg").FigureCanvasAgg(figure)
    return figure


def save_figures(figures: Mapping[str, Any], folder: str | Path, form: str = "png") -> list[Path]:
    """Write each figure to folder/<name>.<form>; returns their paths.

    Raises `InputError` for an unknown format or a folder that cannot be written.
    """
    if form not in PICTURE_FORMATS:
        raise InputError("symoro-elastic", "--format", f"no format {form!r}: choose from {', '.join(PICTURE_FORMATS)}")
    folder = Path(folder)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        return [_saved(figure, folder / f"{name}.{form}") for name, figure in figures.items()]
    except OSError as error:
        raise InputError(str(folder), "folder", f"cannot be written: {error.strerror or error}") from None


def _saved(figure: Any, path: Path) -> Path:
    with _matplotlib("matplotlib").rc_context({"svg.hashsalt": "symoro_elastic"}):
        dated = {"Date": None} if path.suffix == ".svg" else {"CreationDate": None} if path.suffix == ".pdf" else {}
        figure.savefig(path, dpi=110, metadata=dated)
    return path


def _matplotlib(module: str) -> Any:
    return imported(module, "drawing", "analysis")
