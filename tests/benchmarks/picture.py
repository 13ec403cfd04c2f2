"""The ratios of `speed` as a small picture."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from symoro_elastic.foundation.pictures import Plot, picture
from symoro_elastic.foundation.plot_style import dots, legend
from tests.benchmarks.targets import Figures

ROWS = {
    "batch, single": "batch, single, AVX-512",
    "batch, double": "batch, double, AVX-512",
    "one call": "call, ",
    "CasADi's C": "CasADi",
    "MuJoCo": "MuJoCo",
}
"""Contestants by what their names begin with; the fastest of each is drawn."""
MODELS = {"inverse_dynamics": "inverse dynamics", "direct_dynamics": "direct dynamics"}


def draw(figures: Figures, file: Path) -> None:
    """Times faster than Pinocchio C++, by machine and contestant. Equal figures give equal bytes."""
    machines = list(dict.fromkeys(str(f["machine"]) for f in figures))

    def panels(*axes: Any) -> None:
        for panel, (model, title) in zip(axes, MODELS.items(), strict=True):
            of_model = [f for f in figures if f["model"] == model]
            dots(
                panel,
                {label: [_fastest(of_model, name, m) for m in machines] for label, name in ROWS.items()},
                machines,
            )
            panel.set_title(title)
            panel.set_xticks([1, 10, 100, 1000], ["1", "10", "100", "1000"])
        axes[1].set_yticklabels([])
        legend(axes[1])

    plot = Plot(
        "How many times faster than Pinocchio C++ (which is 1)", panels, columns=2, size=(8, 2.6), share_x=False
    )
    file.write_bytes(picture(plot.figure(), "svg"))


def _fastest(figures: Figures, contestant: str, machine: str) -> float | None:
    ratios = [
        float(f["ratio"]) for f in figures if f["machine"] == machine and str(f["contestant"]).startswith(contestant)
    ]
    return max(ratios, default=None)
