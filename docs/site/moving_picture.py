"""The moving picture of the README, a mode of a machine with free motors:
`python -m docs.site.moving_picture [MACHINE --mode K --out FILE]`.

The frames of a cycle are drawn as `show --picture` draws them, and take turns in one SVG file without scripts.
"""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path

import numpy as np

from symoro_elastic import modes, read
from symoro_elastic.analysis.vibration.drawn_modes import drawn_modes
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.machine.machine import Machine
from symoro_elastic.pages.drawing.figure import figure_of, placements_of
from symoro_elastic.pages.drawing.projection import Projection, view_of
from symoro_elastic.pages.drawing.svg import HEIGHT_MOST, WIDTH, _shape, picture_of, svg
from symoro_elastic.pages.drawing.vibrations import changes_of, corners_of
from tests.golden import ROOT

FRAMES = 8
"""Of half of a cycle; the other half shows them in reverse."""
SECONDS = 1.6


def moving_picture(machine: Machine, mode: int) -> str:
    """Return an SVG file of a mode of a machine with free motors; modes count from 1."""
    modal = modes(machine)
    placements = placements_of(machine)
    rest = placements.position({})
    drawn = figure_of(placements, rest)
    moving = tuple(shape for shape in drawn.shapes if shape.frame or shape.role == "base")
    figure = replace(drawn, shapes=moving, marks=())
    (drawn_mode,) = drawn_modes(modal, [mode - 1], corners_of(figure))
    shape = changes_of(modal, drawn_mode)
    phases = np.cos(np.pi * np.arange(FRAMES + 1) / FRAMES)
    still = svg(picture_of(figure))
    projections = [Projection(figure, placements.at(rest + phase * shape), view_of(figure)) for phase in phases]
    outline = np.concatenate([part.points for picture in projections for part in picture.back_to_front])
    low, spread = outline.min(axis=0), np.ptp(outline, axis=0)
    scale = float(min(WIDTH / spread[0], HEIGHT_MOST / spread[1]))
    frames = "\n".join(_frame(projection, k, low, scale) for k, projection in enumerate(projections))
    return still[: still.index("<path")] + frames + "\n" + still[still.index("</svg>") :]


def _frame(projection: Projection, k: int, low: Array, scale: float) -> str:
    parts = [replace(part, points=(part.points - low) * scale) for part in projection.back_to_front]
    paths = "".join(f'<path class="{names}" d="{path}"/>' for names, path in map(_shape, parts))
    order = [*range(FRAMES + 1), *range(FRAMES - 1, 0, -1)]
    values = ";".join("inline" if index == k else "none" for index in order)
    cycle = f'dur="{SECONDS}s" calcMode="discrete" repeatCount="indefinite"'
    first = "inline" if k == FRAMES // 2 else "none"
    return f'<g display="{first}"><animate attributeName="display" values="{values}" {cycle}/>{paths}</g>'


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m docs.site.moving_picture", description=__doc__)
    parser.add_argument("machine", type=Path, nargs="?", default=ROOT / "examples" / "gantry.toml")
    parser.add_argument("--mode", type=int, default=4)
    parser.add_argument("--out", type=Path, default=ROOT / "examples" / "gantry_mode.svg")
    given = parser.parse_args()
    given.out.write_text(moving_picture(read(given.machine), given.mode), encoding="utf-8")


if __name__ == "__main__":
    main()
