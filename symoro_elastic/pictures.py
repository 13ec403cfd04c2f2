"""Plots without a window, saved with the same bytes each time; matplotlib is imported when one is drawn."""

from __future__ import annotations

import io
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from symoro_elastic.errors import InputError
from symoro_elastic.output_files import write_all
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
    refuse_format(form)
    drawn = {f"{name}.{form}": picture(figure, form) for name, figure in figures.items()}
    return write_all(drawn, Path(folder), "--plots")


def refuse_format(form: str) -> None:
    """Raise `InputError` for a format that pictures are not saved in."""
    if form not in PICTURE_FORMATS:
        raise InputError("symoro-elastic", "--picture", f"no format {form!r}: choose from {', '.join(PICTURE_FORMATS)}")


def picture(figure: Any, form: str) -> bytes:
    """Return the picture as the bytes of a file."""
    stream = io.BytesIO()
    with _matplotlib("matplotlib").rc_context({"svg.hashsalt": "symoro_elastic"}):
        undated: dict[str, dict[str, Any]] = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}
        figure.savefig(stream, format=form, dpi=110, metadata=undated.get(form, {}))
    return stream.getvalue()


def _matplotlib(module: str) -> Any:
    return imported(module, "drawing", "analysis")
