"""What the bodies of an MJCF model look like: the shapes that MuJoCo's viewer shows, in the frames of the links."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from symoro_elastic.formats.robots.mjcf_bodies import Bodies
from symoro_elastic.formats.robots.robot import Placement
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.machine.described import BodyShape

SHOWN_GROUPS = (0, 1, 2)
"""Those that the viewer shows at first: shapes of contacts are in others where they are not to be seen."""


def shapes_by_link(bodies: Bodies) -> dict[str, tuple[BodyShape, ...]]:
    """Return what links look like, by their names."""
    found: dict[str, tuple[BodyShape, ...]] = {}
    model = bodies.model
    for g in range(model.ngeom):
        place = bodies.place(int(model.geom_bodyid[g]))
        if place and model.geom_group[g] in SHOWN_GROUPS and model.geom_rgba[g][3] > 0:
            link, on_link = place
            at = on_link * _placement(bodies, model.geom_quat[g], model.geom_pos[g])
            shapes = (replace(one, points=at.matrix @ one.points) for one in _shapes(bodies, g))
            found[link] = (*found.get(link, ()), *shapes)
    return found


def _shapes(bodies: Bodies, g: int) -> Iterator[BodyShape]:
    """The shape of a geom, in its frame: planes and fields of heights are not drawn."""
    model = bodies.model
    kind = bodies.compiled.mujoco.mjtGeom(model.geom_type[g]).name.removeprefix("mjGEOM_").lower()
    x, y, z = (float(size) for size in model.geom_size[g])
    mesh = bodies.compiled.meshes.get(g)
    if mesh is not None:
        yield mesh if kind != "mesh" else replace(mesh, points=_from_inertial(bodies, g) @ mesh.points)
    elif kind in ("box", "ellipsoid"):
        yield BodyShape(np.diag([x, y, z, 1.0]), solid=kind)
    elif kind == "sphere":
        yield BodyShape(np.diag([x, x, x, 1.0]), solid="ellipsoid")
    elif kind == "cylinder":
        yield BodyShape(np.diag([x, x, y, 1.0]), solid=kind)
    elif kind == "capsule" and x > 0:
        yield BodyShape(np.diag([x, x, x, 1.0]), solid=kind, straight=y / x)


def _from_inertial(bodies: Bodies, g: int) -> Array:
    """The frame of the points of a file in that of their inertia, in which MuJoCo keeps a mesh."""
    mesh = bodies.model.geom_dataid[g]
    return _placement(bodies, bodies.model.mesh_quat[mesh], bodies.model.mesh_pos[mesh]).inverse.matrix


def _placement(bodies: Bodies, quaternion: Array, position: Array) -> Placement:
    return Placement(bodies.rotation(quaternion), np.array(position))
