"""The page on which a machine moves: one file that needs no network and no other file.

Names and notes of a machine reach it as data only, which the page shows as text.
"""

from __future__ import annotations

import base64
import hashlib
import json
import re
from collections.abc import Mapping, Sequence
from html import escape
from typing import Any

from symoro_elastic.codegen.javascript import javascript_function
from symoro_elastic.codegen.templates import render, template_folder
from symoro_elastic.foundation.input_files import read_file
from symoro_elastic.machine.described import DescribedMachine, limits_of
from symoro_elastic.machine.machine import Kind, Machine
from symoro_elastic.machine.views import drives_lines
from symoro_elastic.pages.drawing.figure import Figure
from symoro_elastic.pages.drawing.joint_shapes import REACH
from symoro_elastic.pages.drawing.motions import motions_data
from symoro_elastic.pages.drawing.palette import DARK, LIGHT, Palette
from symoro_elastic.pages.drawing.projection import view_of
from symoro_elastic.pages.drawing.shapes import Solid, Wire
from symoro_elastic.pages.drawing.shown import ShownMachine
from symoro_elastic.pages.drawing.significant import round_significant
from symoro_elastic.pages.drawing.svg import joint_counts, legend_of, picture_of, svg
from symoro_elastic.pages.drawing.vibrations import modes_data

SCRIPTS = (
    "vendor/three.min.js",
    "space.js",
    "frames.js",
    "paint.js",
    "figure.js",
    "labels.js",
    "camera.js",
    "ground.js",
    "measure.js",
    "stage.js",
    "panel.js",
    "play.js",
    "motion.js",
    "record.js",
    "address.js",
    "start.js",
)
"""Scripts of the page in their order, each in a script element of its own."""
TURN = 3.142
"""To each side of a slider of a joint that turns, rad."""
FRAME_HEIGHT = 560
"""Of a page inside another one, px."""
RUN = re.compile(r"<(script|style)>(.*?)</\1>", re.DOTALL)


def machine_page(shown: ShownMachine, *, still: bool = True) -> str:
    """Return the page as HTML; raises `InputError` where the machine cannot be drawn at its position.

    A browser without WebGL shows a `still` picture, which takes half of the time.
    """
    programs = [javascript_function(name, program) for name, program in shown.placements.programs.items()]
    names = ", ".join(shown.placements.programs)
    page = render(
        "view/page.html.j2",
        data=as_json(page_data(shown)),
        style=_file("page.css"),
        picture=svg(picture_of(shown.figure)) if still else "",
        program="\n".join(['"use strict";', *programs, f"const programs = {{ {names} }};"]),
        scripts=[_file(name) for name in SCRIPTS],
    )
    return page.replace("POLICY", content_policy(page), 1)


def page_data(shown: ShownMachine) -> dict[str, Any]:
    """Return all that the scripts of the page read: numbers and texts."""
    machine, figure = shown.placements.machine, shown.figure
    dependent = shown.placements.closed(shown.q).q_dep
    return {
        "title": figure.title,
        "summary": joint_counts(figure),
        "notes": list(DescribedMachine.of(machine).origin.notes),
        "remarks": [*shown.remarks, *drives_lines(machine)],
        "legend": [list(entry) for entry in legend_of({*(shape.role for shape in figure.shapes)})],
        "crowded": figure.is_crowded,
        "marks": [{"frame": mark.frame, "name": mark.name, "role": mark.role} for mark in figure.marks],
        "antecedents": list(figure.antecedents),
        "slides": list(figure.slides),
        "solids": [_solid(solid) for solid in figure.solids],
        "meshes": [mesh.data for mesh in shown.meshes[0]],
        "wires": [_wire(wire) for wire in figure.wires],
        "extent": round_significant(figure.extent),
        "unit": round_significant(figure.unit),
        "room": [round_significant(corner) for corner in figure.room],
        "up": round_significant(figure.up),
        "view": round_significant(view_of(figure).axes),
        "q": round_significant(shown.q, 15),
        "dependent": round_significant(dependent, 15) if len(dependent) else None,
        "joints": [_joint(machine, j, x, figure) for j, x in zip(machine.independent, shown.q, strict=True)],
        "leaves": _leaves(machine),
        "stands": not machine.degrees_of_base,
        "modes": [modes_data(one, figure.extent) for one in shown.modes],
        "motions": motions_data(shown.motions),
        "palettes": {"light": _colours(LIGHT), "dark": _colours(DARK)},
    }


def page_frame(page: str, title: str) -> str:
    """Return an element that shows a page inside another one, where it runs its own scripts only."""
    allowed = "allow-scripts allow-downloads"
    return (
        f'<iframe title="{escape(title)}" srcdoc="{escape(page)}" sandbox="{allowed}" '
        f'style="width: 100%; height: {FRAME_HEIGHT}px; border: 0"></iframe>'
    )


def pages_beside(pages: Sequence[tuple[str, str]]) -> str:
    """Return one page that shows pages of machines, each with its title, side by side: each moves by itself."""
    frames = [(escape(title), escape(page)) for title, page in pages]
    whole = render("view/beside.html.j2", frames=frames)
    return whole.replace("POLICY", content_policy("".join([whole, *(page for _, page in pages)])), 1)


def as_json(data: Mapping[str, Any]) -> str:
    """Return data as JSON in ASCII that closes no element: no `<`, `>` or `&`."""
    text = json.dumps(data, allow_nan=False, separators=(",", ":"))
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def content_policy(page: str) -> str:
    """Return a policy that lets a browser run and apply what is in the page, and load nothing."""
    found: dict[str, list[str]] = {"script": [], "style": []}
    for kind, text in RUN.findall(page):
        digest = base64.b64encode(hashlib.sha256(text.encode("utf-8")).digest()).decode("ascii")
        found[kind].append(f"'sha256-{digest}'")
    parts = [f"{kind}-src {' '.join(dict.fromkeys(digests))}" for kind, digests in found.items()]
    return "; ".join(["default-src 'none'", *parts, "base-uri 'none'", "form-action 'none'"])


def _file(name: str) -> str:
    return read_file(template_folder() / "view" / name).decode("utf-8")


def _solid(solid: Solid) -> dict[str, Any]:
    at = round_significant(solid.placement.reshape(-1))
    return {
        "frame": solid.frame,
        "role": solid.role,
        "shape": solid.shape,
        "at": at,
        "size": round_significant(list(solid.size)),
    }


def _wire(wire: Wire) -> dict[str, Any]:
    return {
        "frame": wire.frame,
        "role": wire.role,
        "points": round_significant(wire.points.reshape(-1), 6),
        "behind": round_significant(wire.behind, 6),
    }


def _joint(machine: Machine, j: int, position: float, figure: Figure) -> dict[str, Any]:
    """A joint and the range of its slider: its limits, which the position may be beyond, else to each side of it."""
    joint, limits = machine.joint(j), limits_of(machine).of(machine.joint(j).name).position
    reach = REACH * figure.unit if joint.sigma == 1 else TURN
    low, high = (limits.low, limits.high) if limits else (position - reach, position + reach)
    return {
        "name": joint.name,
        "frame": j,
        "unit": joint.unit,
        "role": joint.kind,
        "motor": joint.kind is Kind.MOTOR,
        "low": round_significant(min(low, position), 15),
        "high": round_significant(max(high, position), 15),
    }


def _leaves(machine: Machine) -> list[int]:
    """Frames that carry no other: those whose paths are drawn."""
    carried = {*machine.antecedents}
    ends = (j for j, joint in enumerate(machine.joints, start=1) if joint.kind is not Kind.CUT)
    return [j for j in ends if j not in carried]


def _colours(palette: Palette) -> dict[str, Any]:
    outlines = {role: palette.outline(role) for role in palette.roles}
    return {"paper": palette.paper, "faint": palette.faint, "ink": palette.ink, "fill": palette.roles, "edge": outlines}
