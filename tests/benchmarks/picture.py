"""The ratios of `speed` as a small picture."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from tests.benchmarks.targets import Figures

ROWS = {
    "batch, single, AVX-512": ("batch, float", "#0b5d8f"),
    "batch, double, AVX-512": ("batch, double", "#2b8cbe"),
    "call, ": ("one call", "#7bccc4"),
    "CasADi": ("CasADi-generated C", "#b0b0b0"),
    "MuJoCo": ("MuJoCo", "#d0d0d0"),
}
"""Contestants, of whom the best is drawn, with their label and colour."""
MODELS = {"inverse_dynamics": "inverse dynamics", "direct_dynamics": "direct dynamics"}


def draw(figures: Figures, file: Path) -> None:
    """Bars: how many times faster than Pinocchio C++, on a logarithmic axis. Equal figures give equal bytes."""
    import matplotlib as mpl

    mpl.use("svg")
    from matplotlib import pyplot
    from matplotlib.patches import Rectangle

    settings: Any = {"svg.hashsalt": "benchmarks", "svg.fonttype": "path", "font.size": 8, "axes.spines.top": False}
    machines = list(dict.fromkeys(str(f["machine"]) for f in figures))
    with mpl.rc_context(settings | {"axes.spines.right": False}):
        drawing, panels = pyplot.subplots(1, 2, figsize=(8, 2.9), sharey=True, layout="constrained")
        for panel, (model, title) in zip(panels, MODELS.items(), strict=True):
            _panel(panel, [f for f in figures if f["model"] == model], machines)
            panel.set_title(title)
        panels[0].set_ylabel("times faster than Pinocchio C++")
        handles = [(label, colour) for label, colour in reversed(ROWS.values())]
        patches = [Rectangle((0, 0), 1, 1, color=colour) for _, colour in handles]
        drawing.legend(patches, [label for label, _ in handles], loc="outside lower center", ncols=5, frameon=False)
        drawing.savefig(file, metadata={"Date": None, "Creator": None})
        pyplot.close(drawing)


def _panel(panel: Any, figures: Figures, machines: list[str]) -> None:
    width = 0.8 / len(ROWS)
    for k, (name, (_, colour)) in enumerate(reversed(ROWS.items())):
        for position, machine in enumerate(machines):
            chosen = [f for f in figures if f["machine"] == machine and str(f["contestant"]).startswith(name)]
            if chosen:
                ratio = max(float(f["ratio"]) for f in chosen)
                x = position + (k - (len(ROWS) - 1) / 2) * width
                panel.bar(x, ratio, width * 0.9, color=colour)
                panel.annotate(
                    f"{ratio:.2g}" if ratio < 100 else f"{ratio:.0f}", (x, ratio), ha="center", va="bottom", fontsize=6
                )
    panel.set_yscale("log")
    panel.axhline(1, color="black", linewidth=0.6)
    panel.set_yticks([1, 10, 100], ["1", "10", "100"])
    panel.minorticks_off()
    panel.set_xticks(range(len(machines)), [machine.replace(", ", "\n") for machine in machines])
