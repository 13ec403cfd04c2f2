"""Times of integrators on the same motion as a small picture."""

from __future__ import annotations

from pathlib import Path
from typing import Any

COLOURS = {"generated": "#0b5d8f", "scipy": "#7bccc4", "CVODE": "#2b8cbe", "MuJoCo": "#b0b0b0"}


def draw(figures: list[dict[str, Any]], file: Path) -> None:
    """Bars: milliseconds in C for each stiffness, logarithmic; none where an integrator does not get there."""
    import matplotlib as mpl

    mpl.use("svg")
    from matplotlib import pyplot

    stiffer = list(dict.fromkeys(one["stiffer"] for one in figures))
    with mpl.rc_context({"svg.hashsalt": "scenes", "svg.fonttype": "none", "font.size": 8}):
        drawing, panels = pyplot.subplots(1, len(stiffer), figsize=(8, 3), sharey=True, layout="constrained")
        for panel, times in zip(panels, stiffer, strict=True):
            rows = list({one["name"]: one for one in figures if one["stiffer"] == times}.values())[::-1]
            for place, one in enumerate(rows):
                if one.get("in_c"):
                    panel.barh(place, one["in_c"], color=COLOURS[one["name"].split()[0]])
                else:
                    panel.annotate("too many steps", (1e-2, place), va="center")
            panel.set_yticks(range(len(rows)), [one["name"] for one in rows])
            panel.set_xscale("log")
            panel.set_title(f"springs x {times:g}")
            panel.set_xlabel("ms for 50 ms; scipy, CVODE: evaluations alone")
        drawing.savefig(file, metadata={"Date": None, "Creator": None})
        pyplot.close(drawing)
