"""One style for all plots: colours and dashes of curves, names, legends, scales, bars, and maps of numbers.

Curves differ in colour and in dashes, so that they differ in grey and for colour-blind readers. What comes from
a user, such as names of joints, is text: `$` starts no formula.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextvars import ContextVar
from dataclasses import dataclass
from functools import partial
from math import floor, isfinite
from textwrap import wrap
from typing import Any

import numpy as np

from symoro_elastic.foundation.array_types import Array

SMALL, TINY = 8, 7
"""Points of legends and of numbers in maps."""
PER_INCH = 11.5
"""Letters of a title in an inch, wide ones included."""
LONGEST, MOST_LINES = 32, 3
"""Letters of a name, lines of a title."""
MOST_TICKED = 1e3
"""Ratio of a scale by logarithm on which 2 to 9 of each decade are marked; on longer ones 2 and 5, which take as long
to draw as forty curves."""
RIGHT_ANGLE, TWENTY_DECIBELS = 90, 20
"""Between marks of a phase, deg, and of a magnitude, dB, which is a factor of ten."""
MOST_MARKS = 7
"""Intervals between them."""
MOST_NAMED = 10
"""Curves of a diagram with colours of their own; others are grey."""
LEAST_NUMBER, DARK_CELL = 0.05, 0.6
"""Of the largest number of a map: one that is written, one on whose colour it is white."""
RAISED = str.maketrans("-0123456789", "\u207b\u2070\u00b9\u00b2\u00b3\u2074\u2075\u2076\u2077\u2078\u2079")
ON_DARK, ON_LIGHT = "#fefefe", "#000000"
"""Numbers in maps, whose colours are those of light paper on dark paper, too."""


@dataclass(frozen=True)
class Shades:
    """Colours `#rrggbb` on one paper; `good`, `doubtful` and `bad` are of verdicts."""

    paper: str
    ink: str
    grey: str
    grid: str
    curves: tuple[str, ...]
    good: str
    doubtful: str
    bad: str

    @property
    def all(self) -> tuple[str, ...]:
        """All colours, in one order."""
        return (self.paper, self.ink, self.grey, self.grid, *self.curves, self.good, self.doubtful, self.bad)


LIGHT = Shades(
    "#ffffff", "#1d252c", "#818b94", "#d5dade",
    ("#2b48ae", "#ba3f22", "#22957b", "#953d93", "#a18709", "#3b475b"), "#12876a", "#c97a02", "#b52b27",
)  # fmt: skip
DARK = Shades(
    "#14181c", "#e8eaec", "#8f9aa3", "#3a434b",
    ("#74aff8", "#ff965e", "#4ec6a3", "#d2a1d9", "#d9c744", "#c9ccda"), "#53caa6", "#f2ac3c", "#f07a70",
)  # fmt: skip
DRAWN_ON = ContextVar("DRAWN_ON", default=LIGHT)
DASHES: tuple[Any, ...] = ("-", "--", "-.", ":", (0, (7, 1.5, 1, 1.5, 1, 1.5)), (0, (3, 1)))
MARKERS = "osD^vP"

CURVES: dict[str, Any] = {
    "lines.linewidth": 1.3,
    "lines.markersize": 4,
    "legend.fontsize": SMALL,
    "legend.frameon": False,
    "legend.handlelength": 3.2,
    "text.parse_math": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.grid.which": "major",
    "grid.linewidth": 0.5,
    "hatch.linewidth": 0.6,
}
"""What holds in axes of a user, too."""


def style(paper: Shades) -> dict[str, Any]:
    """Return the settings of matplotlib for plots on one paper."""
    inked = ("text.color", "axes.labelcolor", "axes.titlecolor", "xtick.labelcolor", "ytick.labelcolor")
    return {
        **CURVES,
        **dict.fromkeys(inked, paper.ink),
        **dict.fromkeys(("figure.facecolor", "axes.facecolor", "savefig.facecolor"), paper.paper),
        **dict.fromkeys(("axes.edgecolor", "xtick.color", "ytick.color"), paper.grey),
        "grid.color": paper.grid,
        "font.family": "sans-serif",
        "font.sans-serif": ["DejaVu Sans"],
        "font.size": 9,
        "axes.titlesize": 9,
        "axes.titlelocation": "left",
        "figure.titlesize": 10.5,
        "axes.spines.top": False,
        "axes.spines.right": False,
        "image.cmap": "viridis",
        "svg.fonttype": "path",
        "svg.hashsalt": "symoro_elastic",
        "pdf.fonttype": 42,
    }


def on_both_papers(svg: str) -> str:
    """Return a plot on light paper, with rules that change its colours where the page is dark."""
    rules = [
        f'[style*="{kind}: {light}"] {{ {kind}: {dark} !important }}'
        for light, dark in dict(zip(LIGHT.all, DARK.all, strict=True)).items()
        for kind in ("fill", "stroke")
    ]
    styles = f"<style>@media (prefers-color-scheme: dark) {{ {' '.join(rules)} }}</style>"
    head, mark, body = svg.partition("<defs>")
    return f"{head}{styles}\n {mark}{body}"


def curve(k: int) -> dict[str, Any]:
    """Return colour and dashes of curve k; 36 are distinct."""
    count = len(LIGHT.curves)
    return {"color": shades().curves[k % count], "linestyle": DASHES[(k + k // count) % len(DASHES)]}


def marker(k: int) -> str:
    """Return the marker of group k of points."""
    return MARKERS[k % len(MARKERS)]


def shades() -> Shades:
    """Return the colours of the current paper."""
    return DRAWN_ON.get()


def shorten(text: str, most: int = LONGEST) -> str:
    """Return a name in printable letters, the middle of a long one replaced by dots."""
    name = "".join(x if x.isprintable() else "\ufffd" for x in str(text))
    end = (most - 3) // 2
    return name if len(name) <= most else f"{name[: most - 3 - end]}...{name[len(name) - end :]}"


def lines_of(text: str, inches: float) -> str:
    """Return a title in lines no wider than a figure."""
    words = " ".join(shorten(word, 28) for word in text.split())
    return "\n".join(wrap(words, max(16, floor(PER_INCH * inches)), max_lines=MOST_LINES, placeholder=" ..."))


def y_label(axes: Any, *parts: str) -> None:
    """Write quantity and unit of the vertical axis, on separate lines if both are long."""
    labels = [shorten(part, 22) for part in parts if part]
    axes.set_ylabel((", " if sum(map(len, labels)) <= 22 else ",\n").join(labels))


def legend(axes: Any, title: str = "", of: Any = None) -> None:
    """Write the names of curves, of `axes` or other ones, to the right of the diagram."""
    handles, names = (of or axes).get_legend_handles_labels()
    if names:
        more = {"title": title, "title_fontsize": SMALL, "alignment": "left"} if title else {}
        shown = [shorten(name) for name in names]
        axes.legend(handles, shown, loc="upper left", bbox_to_anchor=(1.0, 1.0), borderaxespad=0.2, **more)


def logarithmic(axes: Any, *which: str) -> None:
    """Scale axes "x" and "y" by logarithm, with plain numbers."""
    for direction in which:
        getattr(axes, f"set_{direction}scale")("log")
        axis = getattr(axes, f"{direction}axis")
        low, high = axis.get_view_interval()
        if low > 0 and high / low > MOST_TICKED:
            axis.get_minor_locator().set_params(subs=(2.0, 5.0))
        axis.set_major_formatter(plain)
        axis.set_minor_formatter(partial(_plain_within_a_decade, axis))
        axes.grid(True, which="minor", axis=direction, linewidth=0.25)


def mark_multiples(axes: Any, of: float) -> None:
    """Mark the vertical axis at multiples of a number that enclose the curves; at fewer of them if there are many."""
    low, high = axes.dataLim.intervaly if np.isfinite(axes.dataLim.intervaly).all() else (0.0, 0.0)
    step = of * max(1, np.ceil((high - low) / of / MOST_MARKS))
    first, last = np.floor(low / step + 1e-6), np.ceil(high / step - 1e-6)
    axes.set_yticks(step * np.arange(first, max(last, first + 1) + 1))


def plain(x: float, place: int | None = None) -> str:
    """Return a number of a logarithmic scale: 0.01, 3000, 10\u2076; the place is that of the tick."""
    power = np.log10(abs(x)) if x else 0.0
    if abs(power) < 4 or abs(power - round(power)) > 1e-9:
        return f"{x:.6g}"
    return f"{'-' if x < 0 else ''}10{str(round(power)).translate(RAISED)}"


def _plain_within_a_decade(axis: Any, x: float, place: int | None = None) -> str:
    """A number between powers of ten, if an axis has fewer than two powers."""
    low, high = axis.get_view_interval()
    is_narrow = low > 0 and np.floor(np.log10(high)) - np.ceil(np.log10(low)) < 1
    is_wide = low > 0 and high / low > 3
    leads = f"{x:.0e}"[0] in "1235" if is_wide else True
    return plain(x) if is_narrow and leads else ""


def curves(
    axes: Any, x: Any, columns: Any, names: Sequence[str], first: int = 0, most: int = MOST_NAMED, **more: Any
) -> None:
    """Draw columns (N, k) over x (N,): the `most` that matter with colours, dashes and names, others grey.

    Those that matter are the largest, or have the largest `ranks` (k,).
    """
    columns = np.asarray(columns)
    ranks = more.pop("ranks", None)
    if ranks is None:
        ranks = [np.abs(column[np.isfinite(column)]).max(initial=0.0) for column in columns.T]
    ranked = {*np.argsort(-np.asarray(ranks), kind="stable")[:most].tolist()}
    grey = [k for k in range(len(names)) if k not in ranked]
    for k in grey:
        label = f"{len(grey)} others" if k == grey[0] else None
        axes.plot(x, columns[:, k], color=shades().grey, linewidth=0.5, label=label, zorder=1)
    for j, k in enumerate(sorted(ranked)):
        axes.plot(x, columns[:, k], label=names[k], **(curve(first + j) | more))


def by_unit(units: Sequence[str]) -> dict[str, list[int]]:
    """Return the indices of the columns of each unit, the units in order of first occurrence."""
    return {unit: [k for k, x in enumerate(units) if x == unit] for unit in dict.fromkeys(units)}


def bars(axes: Any, values: Mapping[str, Sequence[float]], rows: Sequence[str]) -> None:
    """Draw bars of several series by name, one for each row from the top; without a bar for infinite numbers."""
    height = 0.8 / max(1, len(values))
    for k, (label, series) in enumerate(values.items()):
        sizes = [float(x) if x is not None and isfinite(x) else 0.0 for x in series]
        places = np.arange(len(rows)) + (k + 0.5) * height - 0.4
        hatch = ("", "///", "...", "\\\\\\", "xxx", "---")[k % 6]
        look = {"facecolor": curve(k)["color"], "edgecolor": shades().paper, "hatch": hatch}
        axes.barh(places, sizes, height, label=label, linewidth=0, **look)
    if not any(map(any, values.values())):
        axes.set_xlim(0, 1)
    _rows(axes, rows)


def dots(axes: Any, values: Mapping[str, Sequence[float | None]], rows: Sequence[str]) -> None:
    """Draw numbers above 0 of several series as points on a logarithmic scale, one line for each row from the top."""
    for k, (label, series) in enumerate(values.items()):
        there = [(x, row) for row, x in enumerate(series) if x is not None and isfinite(x) and x > 0]
        look = {"linestyle": "", "marker": marker(k), "color": curve(k)["color"], "fillstyle": ("full", "none")[k % 2]}
        axes.plot(*zip(*there, strict=True) if there else ([], []), label=label, **look)
    logarithmic(axes, "x")
    _rows(axes, rows)
    axes.grid(True, axis="y")


def _rows(axes: Any, rows: Sequence[str]) -> None:
    axes.set_yticks(range(len(rows)), [shorten(row) for row in rows])
    axes.tick_params(axis="y", length=0)
    axes.set_ylim(len(rows) - 0.4, -0.6)
    axes.grid(False, axis="y")


def map_of_numbers(
    axes: Any, values: Array, rows: Sequence[str], columns: Sequence[str], form: str, of: str = ""
) -> Any:
    """Draw numbers (rows, columns) up to 1 as colours with their values; signed ones from blue to red."""
    is_signed = form[-2] == "f"
    look: dict[str, Any] = {"cmap": "RdBu_r", "vmin": -1.0} if is_signed else {"cmap": "Blues", "vmin": 0.0}
    image = axes.imshow(values, vmax=1.0, aspect="auto", **look)
    for row, k in np.argwhere(np.abs(values) >= LEAST_NUMBER):
        colour = ON_DARK if abs(values[row, k]) > DARK_CELL else ON_LIGHT
        written = form.format(values[row, k])
        axes.text(k, row, written, ha="center", va="center", fontsize=TINY, color=colour)
    axes.set_yticks(range(len(rows)), [shorten(row) for row in rows], fontsize=SMALL)
    axes.set_xticks(range(len(columns)), columns, fontsize=SMALL, rotation=55, ha="right", rotation_mode="anchor")
    axes.grid(False)
    axes.figure.colorbar(image, ax=axes, label=of)
    return image


NEAREST = 0.13
"""Inches between the numbers of two contours."""


def _write_levels(axes: Any, lines: Any) -> None:
    """Write the levels of contours on the middle of their longest parts, legible on every colour."""
    longest = [max(parts, key=len) for parts in lines.allsegs if parts]
    middles = [part[len(part) // 2 - 1 : len(part) // 2 + 1].mean(axis=0) for part in longest if len(part) > 1]
    selected: list[int] = []
    points = axes.transData.transform(middles) if middles else ()
    for k, point in enumerate(points):
        if all(np.hypot(*(point - points[j])) > NEAREST * axes.figure.dpi for j in selected):
            selected.append(k)
    places = [tuple(middles[k]) for k in selected]
    written = axes.clabel(lines, fontsize=TINY, fmt="%.4g", colors=ON_LIGHT, manual=places) if places else ()
    for text in written:
        text.set_bbox({"facecolor": ON_DARK, "linewidth": 0, "pad": 0.6})


def contours(x: Array, y: Array, values: Any, names: Sequence[str], of: str, axes: Any) -> None:
    """Draw a map over two quantities as contours with the computed points; over a single value as a curve."""
    shape = values.shape
    if min(shape) > 1:
        filled = axes.contourf(x, y, values, levels=12)
        lines = axes.contour(x, y, values, levels=filled.levels[1:-1:2], colors="#fefefe", linewidths=0.5)
        _write_levels(axes, lines)
        axes.plot(x.ravel(), y.ravel(), ".", color="#000000", markersize=5, label="computed", clip_on=False)
        axes.figure.colorbar(filled, ax=axes, label=of, format="%.4g")
        axes.set_ylabel(names[1])
    else:
        axes.plot((x if shape[0] > 1 else y).ravel(), values.ravel(), marker=".", **curve(0))
        axes.set_ylabel(of)
    axes.grid(False)
    axes.set_xlabel(names[0] if min(shape) > 1 or shape[0] > 1 else names[1])
