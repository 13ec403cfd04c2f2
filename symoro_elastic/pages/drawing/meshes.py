"""Meshes of bodies from files beside a robot: STL, OBJ and DAE. No other file is opened, and nothing is fetched."""

from __future__ import annotations

import base64
from collections.abc import Iterator
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

SUFFIXES = (".stl", ".obj", ".dae")
PACKAGE = "package://"
MOST_BYTES = 50_000_000
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
    """Return the meshes of the bodies that lie beside the file of a machine, and lines about those that do not."""
    described = DescribedMachine.of(machine)
    shapes, found, missing = described.origin.shapes, [], []
    numbers = {joint.name: j for j, joint in enumerate(machine.joints, start=1)} | {"": 0}
    for shape in shapes:
        path = _beside(shape.file, Path(described.source)) if shape.joint in numbers else None
        try:
            mesh = _read(path, shape, numbers[shape.joint]) if path else None
        except ImportError:
            return [], ["meshes are not drawn: pip install 'symoro-elastic[meshes]'"]
        found += [mesh] if mesh else []
        missing += [] if mesh else [PurePosixPath(shape.file).name]
    lines = [f"meshes that are not beside the file or cannot be read: {list_of_names(dict.fromkeys(missing))}"]
    return found, lines if missing else []


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


def _read(path: Path, shape: BodyShape, frame: int) -> Mesh | None:
    """Return the mesh of a file; None where it holds none."""
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
    points, triangles = _coarse(points * shape.scale, triangles)
    T = shape.placement
    return Mesh(frame, points @ T[:3, :3].T + T[:3, 3], triangles)


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
