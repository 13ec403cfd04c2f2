"""Plots without a window: figures of matplotlib, drawn on request and saved with the same bytes each time.

matplotlib is imported when a figure is drawn.
"""

from __future__ import annotations

import io
import re
import sys
import warnings
from base64 import b64encode
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from symoro_elastic.foundation.errors import InputError, among
from symoro_elastic.foundation.file_forms import PICTURE_FORMATS
from symoro_elastic.foundation.output_files import write_all
from symoro_elastic.foundation.packages import import_optional
from symoro_elastic.foundation.plot_style import CURVES, DARK, DRAWN_ON, LIGHT, Shades, lines_of, on_both_papers, style

WIDGETS = "ipympl.backend_nbagg"
"""What a notebook has imported where its figures are widgets."""
GLYPHS = "Glyph .* missing from"
"""Of the warning about letters that the font lacks, which are drawn as boxes."""


@dataclass(frozen=True)
class Plot:
    """A drawing of a result: the arguments of `draw` are rows x columns axes, row by row, `size` is in inches.

    The title names the quantity and the machine.
    """

    title: str
    draw: Callable[..., None]
    rows: int = 1
    columns: int = 1
    size: tuple[float, float] = (8.0, 4.5)
    ratios: tuple[float, ...] = ()
    share_x: bool = True

    def figure(self, *, dark: bool = False) -> Any:
        """Return a new figure, on light or on dark paper. Raises `InputError` without matplotlib."""
        shades = DARK if dark else LIGHT
        with _style(style(shades), shades):
            figure = _figure_class()(figsize=self.size, layout="constrained")
            figure.shades = shades
            shared: dict[str, Any] = {"sharex": self.share_x and self.columns == 1, "squeeze": False}
            ratios = {"height_ratios": self.ratios} if self.ratios else {}
            axes = figure.subplots(self.rows, self.columns, **shared, **ratios)
            self.draw(*axes.flat)
            figure.suptitle(lines_of(self.title, self.size[0]), x=0.01, ha="left")
        return figure

    def into(self, axes: Any) -> Any:
        """Draw into the user's axes, one or as many as needed, and return them; raises `InputError`."""
        boxes = [*axes.flat] if hasattr(axes, "flat") else [*axes] if isinstance(axes, Iterable) else [axes]
        if len(boxes) != (wanted := self.rows * self.columns):
            what = f"this plot needs {wanted}, not {len(boxes)}: plt.subplots({self.rows}, {self.columns})[1] has them"
            raise InputError("symoro-elastic", "axes", what)
        with _style(CURVES, LIGHT):
            self.draw(*boxes)
            width = boxes[0].get_window_extent().width / boxes[0].figure.dpi
            boxes[0].set_title(lines_of(self.title, width))
        for axis in boxes:
            for text in axis.findobj(_matplotlib("matplotlib.text").Text):
                text.set_parse_math(False)
        return axes


class Figures(Mapping[str, Any]):
    """Figures of matplotlib by name, drawn one by one: a notebook shows them, `save` writes them.

    `left_out` has the reasons why some are not drawn, by name.
    """

    def __init__(self, plots: Mapping[str, Plot | str]) -> None:
        self.all = dict(plots)
        self._plots = {name: plot for name, plot in plots.items() if isinstance(plot, Plot)}
        self.left_out = {name: reason for name, reason in plots.items() if isinstance(reason, str)}

    def __getitem__(self, name: str) -> Any:
        """Return a new figure of the plot of this name."""
        return self._plots[name].figure()

    def __iter__(self) -> Iterator[str]:
        """Yield the names of the figures."""
        return iter(self._plots)

    def __len__(self) -> int:
        """Return the number of figures."""
        return len(self._plots)

    def __repr__(self) -> str:
        """Return one line with the names."""
        return f"<Figures: {', '.join(self)}>"

    def plot(self, name: str) -> Plot:
        """Return the drawing of a name, by default the first; raises `InputError` for unknown names."""
        if not name and self._plots:
            return next(iter(self._plots.values()))
        if name in self._plots:
            return self._plots[name]
        name = name or next(iter(self.left_out))
        what = f"unknown {name!r}: choose from {', '.join(self)}"
        what = f"{name} is not drawn: {self.left_out[name]}" if name in self.left_out else what
        raise InputError("symoro-elastic", "plot", what)

    def save(self, folder: str | Path, form: str = "png") -> list[Path]:
        """Write each figure to folder/<name>.<form>; returns their paths.

        Raises `InputError` for an unknown format or a folder that cannot be written.
        """
        refuse_format(form)
        contents = {f"{file_name(name)}.{form}": picture(figure, form) for name, figure in self.items()}
        return write_all(contents, Path(folder), "--plots")

    def _repr_html_(self) -> str:
        """Return the figures as pictures of a page."""
        coded = (b64encode(picture(figure, "png")).decode() for figure in self.values())
        return "\n".join(f'<img src="data:image/png;base64,{data}">' for data in coded)


def numbered_figures(several: Iterable[Figures]) -> Figures:
    """Return the plots of several results together, `outputs_1`, `outputs_2` and so on."""
    return Figures({f"{name}_{k}": plot for k, figures in enumerate(several, 1) for name, plot in figures.all.items()})


def file_name(name: str) -> str:
    """Return the name of a picture in letters, digits, `_`, `-` and single points."""
    return re.sub(r"[^\w-]+", "_", re.sub(r"(?<=\w)\.(?=\w)", "_", name)).strip("_") or "plot"


def new_figure(width: float, height: float) -> Any:
    """Return an empty figure, in inches. Raises `InputError` without matplotlib."""
    return _figure_class()(figsize=(width, height))


def refuse_format(form: str) -> None:
    """Raise `InputError` for an unsupported picture format."""
    among((form,), PICTURE_FORMATS, "--plot-format")


def picture(figure: Any, form: str) -> bytes:
    """Return the picture as the bytes of a file; SVG is for light and dark pages."""
    stream = io.BytesIO()
    undated: dict[str, dict[str, Any]] = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}
    with _style(style(figure.shades), figure.shades):
        figure.savefig(stream, format=form, dpi=110, metadata=undated.get(form, {}))
    if form == "svg" and figure.shades is LIGHT:
        return on_both_papers(stream.getvalue().decode("utf-8")).encode("utf-8")
    return stream.getvalue()


@contextmanager
def _style(settings: Mapping[str, Any], shades: Shades) -> Iterator[None]:
    token = DRAWN_ON.set(shades)
    try:
        with _matplotlib("matplotlib").rc_context(dict(settings)), warnings.catch_warnings():
            warnings.filterwarnings("ignore", GLYPHS)
            yield
    finally:
        DRAWN_ON.reset(token)


@cache
def _figure_class() -> Any:
    """The class of figures, drawn in their own style everywhere, and shown by notebooks."""
    figures = _matplotlib("matplotlib.figure")
    canvas = _matplotlib("matplotlib.backends.backend_agg").FigureCanvasAgg
    constrained = _matplotlib("matplotlib.layout_engine").ConstrainedLayoutEngine

    class ShownFigure(figures.Figure):  # type: ignore[misc, name-defined]
        shades = LIGHT

        def __init__(self, *args: Any, **more: Any) -> None:
            super().__init__(*args, **more)
            canvas(self)

        def draw(self, renderer: Any) -> None:
            """Draw the figure; only place its axes if `savefig` needs its layout."""
            layout = self.get_layout_engine()
            with _style(style(self.shades), self.shades):
                if isinstance(layout, constrained) and self.canvas.is_saving():
                    layout.execute(self)
                else:
                    super().draw(renderer)

        def _repr_png_(self) -> bytes:
            return picture(self, "png")

        def _repr_mimebundle_(self, **_: Any) -> dict[str, Any]:
            """After `%matplotlib widget`, the figure whose axes are moved, enlarged and read off; else nothing more."""
            widgets = sys.modules.get(WIDGETS)
            if widgets is None or not {"ipympl", "widget"} & {
                *re.split(r"\W", _matplotlib("matplotlib").get_backend())
            }:
                return {}
            if not isinstance(self.canvas, widgets.Canvas):
                self.manager_of_widget = widgets.FigureManager(widgets.Canvas(self), 0)
            bundle: dict[str, Any] = self.canvas._repr_mimebundle_()
            return bundle

    return ShownFigure


def _matplotlib(module: str) -> Any:
    return import_optional(module, "drawing", "analysis")
