"""Plots without a window, saved with the same bytes each time; matplotlib is imported when one is drawn."""

from __future__ import annotations

import io
from base64 import b64encode
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.output_files import write_all
from symoro_elastic.foundation.packages import import_optional

PICTURE_FORMATS = ("png", "svg", "pdf")


class Figures(Mapping[str, Any]):
    """Figures of matplotlib by name: a notebook shows them, `save` writes them."""

    def __init__(self, figures: Mapping[str, Any]) -> None:
        self._figures = dict(figures)

    def __getitem__(self, name: str) -> Any:
        """Return a figure."""
        return self._figures[name]

    def __iter__(self) -> Iterator[str]:
        """Yield the names."""
        return iter(self._figures)

    def __len__(self) -> int:
        """Return how many there are."""
        return len(self._figures)

    def __repr__(self) -> str:
        """Return one line with the names."""
        return f"<Figures: {', '.join(self._figures)}>"

    def save(self, folder: str | Path, form: str = "png") -> list[Path]:
        """Write each figure to folder/<name>.<form>; returns their paths.

        Raises `InputError` for an unknown format or a folder that cannot be written.
        """
        refuse_format(form)
        drawn = {f"{name}.{form}": picture(figure, form) for name, figure in self.items()}
        return write_all(drawn, Path(folder), "--plots")

    def _repr_html_(self) -> str:
        """Return the figures as pictures of a page."""
        coded = (b64encode(picture(figure, "png")).decode() for figure in self.values())
        return "\n".join(f'<img src="data:image/png;base64,{data}">' for data in coded)


def new_figure(width: float, height: float) -> Any:
    """Return an empty figure, in inches. Raises `InputError` where matplotlib is missing."""
    figure = _matplotlib("matplotlib.figure").Figure(figsize=(width, height), layout="constrained")
    _matplotlib("matplotlib.backends.backend_agg").FigureCanvasAgg(figure)
    return figure


def refuse_format(form: str) -> None:
    """Raise `InputError` for a format that pictures are not saved in."""
    if form not in PICTURE_FORMATS:
        what = f"no format {form!r}: choose from {', '.join(PICTURE_FORMATS)}"
        raise InputError("symoro-elastic", "--plot-format", what)


def picture(figure: Any, form: str) -> bytes:
    """Return the picture as the bytes of a file."""
    stream = io.BytesIO()
    with _matplotlib("matplotlib").rc_context({"svg.hashsalt": "symoro_elastic"}):
        undated: dict[str, dict[str, Any]] = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}
        figure.savefig(stream, format=form, dpi=110, metadata=undated.get(form, {}))
    return stream.getvalue()


def _matplotlib(module: str) -> Any:
    return import_optional(module, "drawing", "analysis")
