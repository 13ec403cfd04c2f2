"""What bodies of a robot look like: solids, and meshes in STL, OBJ and DAE from files beside it.

No other file is opened, and nothing is fetched.
"""

from __future__ import annotations

import base64
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path, PurePosixPath
from typing import Any
from urllib.parse import unquote

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.input_files import is_plain_file, read_file
from symoro_elastic.machine.described import BodyShape, DescribedMachine
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.names import list_of_names
from symoro_elastic.pages.drawing.figure import CORNERS
from symoro_elastic.pages.drawing.projection import FACES, ROUND

SUFFIXES = (".stl", ".obj", ".dae")
PACKAGE = "package://"
MOST_BYTES, MOST_BYTES_IN_ALL = 50_000_000, 200_000_000
MOST_SHAPES = 400
FARTHEST = 1e6
"""Of a point from its frame, m."""
MOST_TRIANGLES = 8_000
"""Of a mesh on the page: finer ones are drawn on a grid."""
COARSEST = 8
"""Cells of a grid across a mesh, at least."""
UP = 4
"""Folders above a file where the packages of its meshes may be."""


@dataclass(frozen=True)
class Mesh:
    """Triangles fixed to a frame: `points` (N, 3) m, in that frame, and `triangles` (M, 3), their numbers."""

    frame: int
    points: Array
    triangles: Array

    @property
    def data(self) -> dict[str, Any]:
        """What the scripts of a page read: numbers of single precision and of 32 bits, base64."""
        points, triangles = self.points.astype("<f4"), self.triangles.astype("<u4")
        packed = {"points": points, "triangles": triangles}
        return {"frame": self.frame} | {key: base64.b64encode(x.tobytes()).decode() for key, x in packed.items()}


def meshes_of(machine: Machine) -> tuple[list[Mesh], list[str]]:
    """Return what the bodies of a machine look like, and lines about what is not drawn of it.

    Files of meshes that do not lie beside the file of the machine are among that.
    """
    described = DescribedMachine.of(machine)
    numbers = {joint.name: j for j, joint in enumerate(machine.joints, start=1)} | {"": 0}
    shapes = [shape for shape in described.origin.shapes if shape.joint in numbers]
    files, found, missing = _Files(Path(described.source)), [], []
    for shape in shapes[:MOST_SHAPES]:
        mesh = _solid(shape) if shape.solid else files.triangles(shape.file)
        points = mesh[0] @ shape.points[:3, :3].T + shape.points[:3, 3] if mesh else np.empty((0, 3))
        if mesh and (np.abs(points) < FARTHEST).all():
            outward = 1 if np.linalg.det(shape.points[:3, :3]) > 0 else -1
            found.append(Mesh(numbers[shape.joint], points, mesh[1][:, ::outward]))
        else:
            missing.append(PurePosixPath(shape.file).name or shape.solid)
    return found, [*_remarks(files, dict.fromkeys(missing), len(shapes) - MOST_SHAPES)]


def _remarks(files: _Files, missing: Iterable[str], more: int) -> Iterator[str]:
    if files.lack_package:
        yield "meshes are not drawn: pip install 'symoro-elastic[meshes]'"
    elif names := [*missing]:
        yield f"meshes that are not beside the file or cannot be read: {list_of_names(names)}"
    if more > 0:
        yield f"{MOST_SHAPES} shapes of bodies are drawn, {more} are not"


class _Files:
    """The meshes of files beside the file of a robot, each read once."""

    def __init__(self, source: Path) -> None:
        self.source = source
        self.lack_package = False
        self.room = MOST_BYTES_IN_ALL
        self._read: dict[Path, tuple[Array, Array] | None] = {}

    def triangles(self, name: str) -> tuple[Array, Array] | None:
        """Return points (N, 3) and triangles (M, 3) of a file; None where there is none, or none that can be read."""
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


def _solid(shape: BodyShape) -> tuple[Array, Array]:
    """Points and triangles of a solid of half length 1: a box, or what turns about z."""
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
    """Yield where a mesh may be; none is outside of the folder of a package or of the robot's own one."""
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
    """Return points and triangles of a file; None where it holds none."""
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
    return _coarse(points, triangles)


def _coarse(points: Array, triangles: Array) -> tuple[Array, Array]:
    """Return a mesh of few triangles: points that share a cell of a grid become one, at their mean.

    The grid is the finest, of those that halve, on which few enough triangles keep three cells.
    """
    cells = 1024
    low, size = points.min(axis=0), float(np.ptp(points, axis=0).max())
    while len(triangles) > MOST_TRIANGLES and cells >= COARSEST and size > 0:
        _, number = np.unique(np.floor((points - low) / size * cells), axis=0, return_inverse=True)
        number = number.reshape(-1)
        counts = np.bincount(number)
        points = np.stack([np.bincount(number, x) / counts for x in points.T], axis=1)
        triangles = number[triangles]
        a, b, c = triangles.T
        triangles = triangles[(a != b) & (b != c) & (c != a)]
        cells //= 2
    return points, triangles
