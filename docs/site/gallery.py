"""The gallery: pictures that commands make of the examples while the site is built."""

from __future__ import annotations

import shlex
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from tests.command_line import ended
from tests.documented_pages import beside_examples


class Shown(NamedTuple):
    """What a command shows: a title, a sentence, the command; its pictures are in the folder `plots`, or a page."""

    title: str
    sentence: str
    command: str


MOST = 4
"""Pictures of a command."""
FRAME = '<iframe src="{path}" title="{title}" style="width: 100%; height: 32rem; border: 0"></iframe>'
TWO_AXIS = "examples/two_axis.toml"
SHOWN = (
    Shown("A machine on a page", "Move its motors, watch its modes, measure.", f"view {TWO_AXIS} --out two_axis.html"),
    Shown(
        "A picture of a machine",
        "For papers, as SVG, PNG or PDF.",
        "show examples/palletizer.toml --picture plots/palletizer.svg",
    ),
    Shown("Modes", "Shapes, and the springs that hold the energy.", f"modes {TWO_AXIS} --hold all --plots plots"),
    Shown(
        "Frequency responses",
        "From force to motion at the tool.",
        f"response {TWO_AXIS} --hold all --input tool.fx --output tool.x --plots plots",
    ),
    Shown(
        "A motion",
        "What springs do while motors follow.",
        f"simulate {TWO_AXIS} --scene examples/scenes/two_axis_move.toml --plots plots",
    ),
    Shown(
        "Drives",
        "Loops, margins, and what limits the gains.",
        f"control {TWO_AXIS} --damping 0.02 --compliance tool.x --plots plots",
    ),
    Shown(
        "Stable cutting",
        "Depth of cut over spindle speed.",
        f"lobes {TWO_AXIS} --direction tool.x --cutting 2e9 --teeth 4 --damping 0.02 --plots plots",
    ),
    Shown(
        "Variants",
        "Frequencies over parameters and positions.",
        f"sweep {TWO_AXIS} --over ram.stiffness=1e6:1e8:9,log --over q.motor_y=0,0.1,0.2 --hold all "
        "--result 'frequency_[1-3]' --plots plots",
    ),
    Shown(
        "What a scene requires",
        "Springs, method and step for a motion.",
        f"ladder {TWO_AXIS} --scene examples/scenes/two_axis_move.toml --plots plots",
    ),
    Shown(
        "Speed and accuracy",
        "Builds on one plane of time and error.",
        "trade examples/planar_2r.toml --effort quick --plots plots",
    ),
    Shown(
        "Springs from hammer tests",
        "Measured, before and after.",
        "update examples/lathe.toml examples/lathe_tests/tests.toml --plots plots",
    ),
    Shown("A report", "All about a machine, on one page.", f"report {TWO_AXIS} --out report.html"),
)


def gallery(work: Path) -> Iterator[tuple[str, str | bytes]]:
    """Yield the page of the gallery, its pictures, and the pages it leads to."""
    parts = ["# Gallery", "", "Every picture is made by the command above it, when this site is built.", ""]
    for k, one in enumerate(SHOWN):
        found = dict(_made(one, work / str(k)))
        parts += [f"## {one.title}", "", one.sentence, "", "```text", f"symoro-elastic {one.command}", "```", ""]
        for name, content in found.items():
            path = f"gallery_files/{k}/{name}"
            yield path, content
            shown = FRAME if name.endswith(".html") else "![{title}]({path})"
            parts += [shown.format(title=Path(name).stem.replace("_", " "), path=path), ""]
    yield "gallery.md", "\n".join(parts)


def _made(one: Shown, work: Path) -> Iterator[tuple[str, bytes]]:
    """Run a command, and yield its pictures, or its page."""
    (work / "plots").mkdir(parents=True)
    drawn = ["--plot-format", "svg"] if "--plots" in one.command else []
    with beside_examples(work):
        done = ended(*shlex.split(one.command), *drawn, *(["--force"] if drawn else []))
        if done.code:
            raise SystemExit(f"{one.command}: {done.err}")
    files = [*sorted((work / "plots").glob("*.svg"))[:MOST], *sorted(work.glob("*.html"))]
    yield from ((path.name, path.read_bytes()) for path in files)
