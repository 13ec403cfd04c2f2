"""Times of integrators on the same motion as a small picture."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from symoro_elastic.foundation.pictures import Plot, picture
from symoro_elastic.foundation.plot_style import dots, shades


def draw(figures: list[dict[str, Any]], file: Path) -> None:
    """Milliseconds in C for each stiffness, logarithmic; none where an integrator does not get there."""
    stiffer = list(dict.fromkeys(one["stiffer"] for one in figures))
    names = list(dict.fromkeys(one["name"] for one in figures))

    def panels(*axes: Any) -> None:
        for panel, times in zip(axes, stiffer, strict=True):
            found = {one["name"]: one.get("in_c") for one in figures if one["stiffer"] == times}
            dots(panel, {"": [found.get(name) for name in names]}, names)
            for place, name in enumerate(names):
                if name in found and not found[name]:
                    panel.annotate("too many steps", (1e-2, place), va="center", color=shades().ink)
            panel.set_title(f"springs x {times:g}")
        for panel in axes[1:]:
            panel.set_yticklabels([])

    title = "Time of 50 ms of motion (ms); of scipy and CVODE the evaluations alone"
    plot = Plot(title, panels, columns=len(stiffer), size=(8, 3), share_x=False)
    file.write_bytes(picture(plot.figure(), "svg"))
