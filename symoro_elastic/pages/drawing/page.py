"""The page with the moving machine: one file without network access or other files.

Names and notes of a machine reach it as data only, which the page shows as text.
"""

from __future__ import annotations

import base64
import hashlib
import json
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from html import escape
from io import BytesIO
from pathlib import Path, PurePosixPath
from typing import Any
from urllib.parse import unquote

import numpy as np

from symoro_elastic.analysis.vibration.linearization import linearize
from symoro_elastic.codegen.javascript import javascript_function
from symoro_elastic.codegen.templates import render, template_folder
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.coarse_meshes import coarse_mesh
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.input_files import is_plain_file, read_file
from symoro_elastic.machine.described import BodyShape, DescribedMachine, limits_of
from symoro_elastic.machine.machine import Kind, Machine
from symoro_elastic.machine.names import list_of_names
from symoro_elastic.machine.views import drives_lines
from symoro_elastic.numerics.motion.equations_of_motion import motion_of
from symoro_elastic.numerics.motion.equilibrium import equilibrium
from symoro_elastic.pages.drawing.bars import Bar
from symoro_elastic.pages.drawing.figure import CORNERS, Figure, Placements, figure_of, placements_of
from symoro_elastic.pages.drawing.joint_shapes import REACH
from symoro_elastic.pages.drawing.motions import Played, motions_data, round_significant
from symoro_elastic.pages.drawing.palette import DARK, LIGHT, Palette
from symoro_elastic.pages.drawing.projection import FACES, ROUND, view_of
from symoro_elastic.pages.drawing.shapes import Solid, Wire
from symoro_elastic.pages.drawing.skins import Skin
from symoro_elastic.pages.drawing.svg import joint_counts, legend_of, picture_of, svg
from symoro_elastic.pages.drawing.vibrations import ModeSet, mode_sets, modes_data

SCRIPTS = (
    "vendor/three.min.js",
    "space.js",
    "frames.js",
    "paint.js",
    "tubes.js",
    "bars.js",
    "skins.js",
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
MOST_IN_MODES = 100
"""Joint variables of a machine whose modes are shown: 300 need minutes and gigabytes."""
SUFFIXES = (".stl", ".obj", ".dae")
PACKAGE = "package://"
MOST_BYTES, MOST_BYTES_IN_ALL = 50_000_000, 200_000_000
MOST_SHAPES = 400
FARTHEST = 1e6
"""Of a point from its frame, m."""
MOST_TRIANGLES = 8_000
"""Of a mesh on the page: finer ones are drawn on a grid."""
UP = 4
"""Folders above a file where the packages of its meshes may be."""


def machine_page(machine: ShownMachine, *, still: bool = True) -> str:
    """Return the page as HTML; raises `InputError` for a machine that cannot be drawn at its position.

    A browser without WebGL shows a `still` picture, which needs half of the time.
    """
    programs = [javascript_function(name, program) for name, program in machine.placements.programs.items()]
    names = ", ".join(machine.placements.programs)
    page = render(
        "view/page.html.j2",
        data=as_json(page_data(machine)),
        style=_file("page.css"),
        picture=svg(picture_of(machine.figure)) if still else "",
        program="\n".join(['"use strict";', *programs, f"const programs = {{ {names} }};"]),
        scripts=[_file(name) for name in SCRIPTS],
    )
    return page.replace("POLICY", content_policy(page), 1)


def page_data(page: ShownMachine) -> dict[str, Any]:
    """Return all data for the scripts of the page: numbers and texts."""
    machine, figure = page.placements.machine, page.figure
    dependent = page.placements.close_loops(page.q).q_dep
    return {
        "title": figure.title,
        "summary": joint_counts(figure),
        "notes": list(DescribedMachine.of(machine).origin.notes),
        "remarks": [*page.remarks, *drives_lines(machine)],
        "legend": [list(entry) for entry in legend_of({*(shape.role for shape in figure.shapes)})],
        "crowded": figure.is_crowded,
        "marks": [{"frame": mark.frame, "name": mark.name, "role": mark.role} for mark in figure.marks],
        "antecedents": list(figure.antecedents),
        "slides": list(figure.slides),
        "solids": [_solid(solid) for solid in figure.solids],
        "meshes": [mesh.data for mesh in page.meshes[0]],
        "wires": [_wire(wire) for wire in figure.wires],
        **({"bars": [_bar(bar) for bar in figure.bars]} if figure.bars else {}),
        **({"skins": [_skin(skin) for skin in figure.skins]} if figure.skins else {}),
        "extent": round_significant(figure.extent),
        "unit": round_significant(figure.unit),
        "room": [round_significant(corner) for corner in figure.room],
        "up": round_significant(figure.up),
        "view": round_significant(view_of(figure).axes),
        "q": round_significant(page.q, 15),
        "dependent": round_significant(dependent, 15) if len(dependent) else None,
        "joints": [_joint(machine, j, x, figure) for j, x in zip(machine.independent, page.q, strict=True)],
        "leaves": _leaves(machine),
        "stands": not machine.degrees_of_base,
        "modes": [modes_data(mode_set, figure) for mode_set in page.modes],
        "motions": motions_data(page.motions),
        "palettes": {"light": _colours(LIGHT), "dark": _colours(DARK)},
    }


def page_frame(page: str, title: str) -> str:
    """Return an element that shows a page inside another one, isolated with its own scripts."""
    allowed = "allow-scripts allow-downloads"
    return (
        f'<iframe title="{escape(title)}" srcdoc="{escape(page)}" sandbox="{allowed}" '
        f'style="width: 100%; height: {FRAME_HEIGHT}px; border: 0"></iframe>'
    )


def pages_beside(pages: Sequence[tuple[str, str]]) -> str:
    """Return one page that shows pages of machines, each with its title, side by side: each moves by itself."""
    frames = [(escape(title), escape(page)) for title, page in pages]
    html = render("view/beside.html.j2", frames=frames)
    return html.replace("POLICY", content_policy("".join([html, *(page for _, page in pages)])), 1)


def as_json(data: Mapping[str, Any]) -> str:
    """Return data as JSON in ASCII that cannot close an element: without `<`, `>` or `&`."""
    text = json.dumps(data, allow_nan=False, separators=(",", ":"))
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def content_policy(page: str) -> str:
    """Return a policy under which a browser runs and applies only the page's own content, and loads nothing."""
    hashes: dict[str, list[str]] = {"script": [], "style": []}
    for kind, text in RUN.findall(page):
        digest = base64.b64encode(hashlib.sha256(text.encode("utf-8")).digest()).decode("ascii")
        hashes[kind].append(f"'sha256-{digest}'")
    parts = [f"{kind}-src {' '.join(dict.fromkeys(digests))}" for kind, digests in hashes.items()]
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
        "outlined": solid.outlined,
    }


def _bar(bar: Bar) -> dict[str, Any]:
    stations = zip(bar.frames, bar.stations.reshape(-1, 16), strict=True)
    return {
        "stations": [{"frame": frame, "at": round_significant(at)} for frame, at in stations],
        "outline": round_significant(bar.outline),
        "steps": bar.steps,
        "springs": list(bar.springs),
    }


def _skin(skin: Skin) -> dict[str, Any]:
    """Data of a skin for the page: the mesh, and its modes with their rows and springs."""
    surface = skin.surface
    packed = Mesh(skin.root, surface.points, surface.triangles).data
    modes = base64.b64encode(surface.modes.astype("<f4").tobytes()).decode()
    return packed | {"rows": list(skin.rows), "springs": list(skin.springs), "modes": modes}


def _wire(wire: Wire) -> dict[str, Any]:
    return {
        "frame": wire.frame,
        "role": wire.role,
        "points": round_significant(wire.points.reshape(-1), 6),
        "behind": round_significant(wire.behind, 6),
    }


def _joint(machine: Machine, j: int, position: float, figure: Figure) -> dict[str, Any]:
    """A joint and the range of its slider: its limits, extended to its position; by default both directions."""
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
    """Frames that carry no other, whose paths are drawn."""
    carried = {*machine.antecedents}
    ends = (j for j, joint in enumerate(machine.joints, start=1) if joint.kind is not Kind.CUT)
    return [j for j in ends if j not in carried]


def _colours(palette: Palette) -> dict[str, Any]:
    outlines = {role: palette.outline(role) for role in palette.roles}
    return {"paper": palette.paper, "faint": palette.faint, "ink": palette.ink, "fill": palette.roles, "edge": outlines}


@dataclass(frozen=True)
class ShownMachine:
    """A machine at q (n,): its modes, motions, and lines about what is `missing`."""

    placements: Placements
    q: Array
    modes: Sequence[ModeSet] = ()
    motions: Sequence[Played] = ()
    missing: Sequence[str] = ()

    @cached_property
    def meshes(self) -> tuple[list[Mesh], list[str]]:
        """Meshes of bodies in the file's folder, and lines about missing ones."""
        return meshes_of(self.placements.machine)

    @cached_property
    def figure(self) -> Figure:
        """The figure of the machine at its position."""
        return figure_of(self.placements, self.q)

    @property
    def remarks(self) -> tuple[str, ...]:
        """Lines about parts of the machine that are not shown, or shown differently."""
        return (*self.figure.remarks, *self.meshes[1], *self.missing)


def shown_machine(machine: Machine, at: Mapping[str, float], motions: Sequence[Played] = ()) -> ShownMachine:
    """Return the drawing data of a machine, restricted to a scene, with motors at positions, rad or m.

    It is in equilibrium there; without one, if values are missing, or it is too large, springs are neutral
    and a remark says why. Raises `InputError` for positions of joints that do not move by themselves, and loops that do
    not close.
    """
    placements = placements_of(machine)
    q = placements.position(at)
    if len(machine.independent) > MOST_IN_MODES:
        return ShownMachine(placements, q, (), motions, _too_large(machine))
    try:
        q, sets = _vibrating(machine, at)
    except InputError as error:
        return ShownMachine(placements, q, (), motions, (f"no modes: {error.place}: {error.what}",))
    return ShownMachine(placements, q, sets, motions)


def _too_large(machine: Machine) -> tuple[str, ...]:
    """A line for a large machine that could have modes."""
    count = len(machine.independent)
    if set(machine.independent) <= set(machine.motors):
        return ()
    return (f"no modes, springs neutral: it has {count} joint variables, and modes are shown up to {MOST_IN_MODES}",)


def _vibrating(machine: Machine, at: Mapping[str, float]) -> tuple[Array, list[ModeSet]]:
    """The position of equilibrium, and the modes about it; modes are shown only for machines with springs."""
    motion = motion_of(machine)
    state = equilibrium(motion, at, carried=bool(machine.degrees_of_base))
    sets = mode_sets(linearize(motion, state))
    vibrates = any(mode_set.modal for mode_set in sets) and (bool(motion.springs) or not motion.motors)
    return state.q, sets if vibrates else []


@dataclass(frozen=True)
class Mesh:
    """Triangles fixed to a frame: `points` (N, 3) m, in that frame, and `triangles` (M, 3), their numbers."""

    frame: int
    points: Array
    triangles: Array

    @property
    def data(self) -> dict[str, Any]:
        """Data for the scripts of a page: numbers of single precision and of 32 bits, base64."""
        points, triangles = self.points.astype("<f4"), self.triangles.astype("<u4")
        packed = {"points": points, "triangles": triangles}
        return {"frame": self.frame} | {key: base64.b64encode(x.tobytes()).decode() for key, x in packed.items()}


def meshes_of(machine: Machine) -> tuple[list[Mesh], list[str]]:
    """Return the meshes of a machine's bodies, and lines about missing ones.

    This includes files of meshes outside the folder of the machine.
    """
    described = DescribedMachine.of(machine)
    numbers = {**machine.rows, "": 0}
    shapes = [shape for shape in described.origin.shapes if shape.joint in numbers]
    files, meshes, missing = _Files(Path(described.source)), [], []
    for shape in shapes[:MOST_SHAPES]:
        mesh = _shown_solid(shape) if shape.solid else files.triangles(shape.file)
        points = mesh[0] @ shape.points[:3, :3].T + shape.points[:3, 3] if mesh else np.empty((0, 3))
        if mesh and (np.abs(points) < FARTHEST).all():
            outward = 1 if np.linalg.det(shape.points[:3, :3]) > 0 else -1
            meshes.append(Mesh(numbers[shape.joint], points, mesh[1][:, ::outward]))
        else:
            missing.append(PurePosixPath(shape.file).name or shape.solid)
    return meshes, [*_remarks(files, dict.fromkeys(missing), len(shapes) - MOST_SHAPES)]


def _remarks(files: _Files, missing: Iterable[str], more: int) -> Iterator[str]:
    if files.lack_package:
        yield "meshes are not drawn: pip install 'symoro-elastic[meshes]'"
    elif names := [*missing]:
        yield f"meshes that are missing in the folder or cannot be read: {list_of_names(names)}"
    if more > 0:
        yield f"{MOST_SHAPES} shapes of bodies are drawn, {more} are not"


class _Files:
    """The meshes of files next to the file of a robot, each read once."""

    def __init__(self, source: Path) -> None:
        self.source = source
        self.lack_package = False
        self.room = MOST_BYTES_IN_ALL
        self._read: dict[Path, tuple[Array, Array] | None] = {}

    def triangles(self, name: str) -> tuple[Array, Array] | None:
        """Return points (N, 3) and triangles (M, 3) of a file; None for a missing or unreadable one."""
        path = _beside(name, self.source)
        if path is None:
            return None
        if path not in self._read:
            try:
                size = path.stat().st_size
                self.room -= size
                self._read[path] = _read(path) if self.room >= 0 else None
            except ImportError:
                self.lack_package, self._read[path] = True, None
        return self._read[path]


def _shown_solid(shape: BodyShape) -> tuple[Array, Array]:
    """Points and triangles of a solid of half length 1: a box, or a solid of revolution about z."""
    if shape.solid == "box":
        faces = np.array([corners for corners, _, _ in FACES])
        return 2 * CORNERS, np.concatenate([faces[:, [0, 1, 2]], faces[:, [0, 2, 3]]])
    if shape.solid == "cylinder":
        r, z = np.array([0.0, 1.0, 1.0, 0.0]), np.array([-1.0, -1.0, 1.0, 1.0])
    else:
        half = np.linspace(0, np.pi / 2, ROUND // 4 + 1)
        angles, ends = np.concatenate([-half[::-1], half]), np.repeat([-shape.straight, shape.straight], len(half))
        r, z = np.cos(angles), np.sin(angles) + ends
    around = 2 * np.pi / ROUND * np.arange(ROUND)
    points = np.stack([np.outer(r, np.cos(around)), np.outer(r, np.sin(around)), np.outer(z, np.ones(ROUND))], axis=2)
    row, k = np.divmod(np.arange((len(r) - 1) * ROUND), ROUND)
    a, b = row * ROUND + k, row * ROUND + (k + 1) % ROUND
    lower, upper = np.stack([a, b, b + ROUND], axis=1), np.stack([a, b + ROUND, a + ROUND], axis=1)
    return points.reshape(-1, 3), np.concatenate([lower, upper])


def _beside(name: str, source: Path) -> Path | None:
    """Return the file of a mesh: in the folder of its robot, or in a package in one of the folders above it."""
    return next((path for path in _places(unquote(name), source.resolve().parent) if is_plain_file(path)), None)


def _places(name: str, folder: Path) -> Iterator[Path]:
    """Yield possible paths of a mesh, all inside the folder of a package or of the robot."""
    if PurePosixPath(name).suffix.lower() not in SUFFIXES:
        return
    around = [folder, *list(folder.parents)[:UP]]
    if name.startswith(PACKAGE):
        package, _, inside = name.removeprefix(PACKAGE).partition("/")
        roots = [
            (up if up.name == package else up / package, inside) for up in around if package not in ("", ".", "..")
        ]
    elif "://" in name or PurePosixPath(name).is_absolute():
        return
    else:
        roots = [(folder, name)] if not name.startswith("../") else [(folder.parent, name.removeprefix("../"))]
    for root, inside in roots:
        path = (root / inside).resolve()
        if path.is_relative_to(root):
            yield path


def _read(path: Path) -> tuple[Array, Array] | None:
    """Return points and triangles of a file; None for a file without them."""
    import trimesh

    try:
        content = read_file(path, "mesh", MOST_BYTES)
        read = trimesh.load_scene(BytesIO(content), file_type=path.suffix.lower()[1:]).to_mesh()
    except ImportError:
        raise
    except InputError:
        return None
    except Exception:  # trimesh names no errors of its own: a damaged file is one that cannot be read
        return None
    points, triangles = np.asarray(read.vertices, dtype=float), np.asarray(read.faces)
    if not len(triangles) or not np.isfinite(points).all():
        return None
    return coarse_mesh(points, triangles, MOST_TRIANGLES)
