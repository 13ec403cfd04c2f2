"""Meshes of bodies: where URDF puts them, from files beside it only, coarse where they are fine."""

from __future__ import annotations

from pathlib import Path
from typing import Any
from xml.sax.saxutils import escape

import numpy as np
import pytest

import symoro_elastic
from symoro_elastic.formats import read_machine
from symoro_elastic.formats.robots.urdf import rotation
from symoro_elastic.pages.drawing.figure import placements_of
from symoro_elastic.pages.drawing.page import MOST_TRIANGLES, Mesh, meshes_of

trimesh = pytest.importorskip("trimesh")

URDF = """<robot name="r"><link name="base"><visual><geometry><mesh filename="{base}"/></geometry></visual></link>
<link name="arm"><inertial><mass value="2"/><inertia ixx="1" iyy="1" izz="1"/></inertial><visual>
<origin xyz="0.1 0.2 0.3" rpy="0.3 -0.2 0.9"/><geometry><mesh filename="{arm}" scale="0.001 0.002 0.003"/></geometry>
</visual></link>
<joint name="j" type="revolute"><parent link="base"/><child link="arm"/><origin xyz="0 0 .4" rpy="0.1 0.4 -0.7"/>
<axis xyz="1 2 3"/></joint></robot>"""


def robot(folder: Path, base: str = "base.stl", arm: str = "package://robot_description/meshes/arm.obj") -> Path:
    """A robot in a package, with its meshes in the formats that are read."""
    package = folder / "robot_description"
    for name in ("urdf", "meshes"):
        (package / name).mkdir(parents=True, exist_ok=True)
    path = package / "urdf" / "r.urdf"
    path.write_text(URDF.format(base=base, arm=arm), encoding="utf-8")
    trimesh.creation.box((1, 2, 3)).export(package / "urdf" / "base.stl")
    for suffix in ("obj", "stl", "dae"):
        trimesh.creation.box((10, 20, 30)).export(package / "meshes" / f"arm.{suffix}")
    return path


def read(path: Path) -> tuple[list[Mesh], list[str]]:
    return meshes_of(read_machine(str(path))[0])


def box(points: np.ndarray) -> np.ndarray:
    return np.stack([points.min(axis=0), points.max(axis=0)])


@pytest.mark.parametrize("suffix", ["obj", "stl", "dae"])
def test_meshes_are_where_urdf_puts_them(tmp_path: Path, suffix: str) -> None:
    """By the definition of URDF: R(rpy) of the link's frame, which the joint places at position 0."""
    if suffix == "dae":
        pytest.importorskip("collada")
    path = robot(tmp_path, arm=f"package://robot_description/meshes/arm.{suffix}")
    (base, arm), remarks = read(path)
    assert remarks == []
    np.testing.assert_allclose(box(base.points), [[-0.5, -1, -1.5], [0.5, 1, 1.5]], atol=1e-7)
    found = placements_of(read_machine(str(path))[0])
    T = found.at(found.start)[arm.frame]
    seen = arm.points @ T[:3, :3].T + T[:3, 3]
    corners = np.array([[x, y, z] for x in (-0.005, 0.005) for y in (-0.02, 0.02) for z in (-0.045, 0.045)])
    on_link = corners @ rotation(0.3, -0.2, 0.9).T + (0.1, 0.2, 0.3)
    wanted = on_link @ rotation(0.1, 0.4, -0.7).T + (0, 0, 0.4)
    far = np.linalg.norm(seen[:, None] - wanted[None], axis=2)
    assert far.min(axis=1).max() < 1e-6 and far.min(axis=0).max() < 1e-6


@pytest.mark.sampled(2)
@pytest.mark.parametrize(
    "name",
    [
        "http://example.com/a.stl",
        "/etc/passwd",
        "../../../outside.stl",
        "package://../outside.stl",
        "package://robot_description/../../outside.stl",
        "base.txt",
        "missing.stl",
        "broken.stl",
        "folder.stl",
        "pipe.stl",
    ],
)
def test_other_files_are_not_opened_and_it_is_said(tmp_path: Path, name: str) -> None:
    import os

    path = robot(tmp_path, arm=name)
    trimesh.creation.box((1, 1, 1)).export(tmp_path / "outside.stl")
    (path.parent / "base.txt").write_text("solid\n", encoding="utf-8")
    (path.parent / "broken.stl").write_bytes(b"solid x\nfacet normal 0 0")
    (path.parent / "folder.stl").mkdir(exist_ok=True)
    if hasattr(os, "mkfifo"):
        os.mkfifo(path.parent / "pipe.stl")
    meshes, (remark,) = read(path)
    assert len(meshes) == 1 and Path(name).name in remark


MJCF = """<mujoco model="m"><compiler meshdir="assets" angle="degree"/>
<default><default class="seen"><geom contype="0" conaffinity="0" group="2"/></default>
<default class="small"><mesh scale="0.001 0.002 -0.003"/></default></default>
<asset><mesh file="a.stl"/><mesh name="part" class="small" file="a.obj" refpos="3 -5 7"
refquat="0.5 0.1 -0.7 0.4"/></asset>
<worldbody><geom type="plane" size="9 9 1"/><geom class="seen" type="mesh" mesh="a" pos="1 2 3" euler="20 30 40"/>
<body name="one" pos="0.1 0 0.3" euler="10 0 50"><joint name="j1" axis="1 2 3" pos="0.1 0.2 0" ref="30"/>
<inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>
<frame euler="0 70 0"><geom class="seen" type="mesh" mesh="part" pos="0.4 0 -0.2" euler="5 0 80"/></frame>
<geom type="capsule" fromto="0 0 0 0.3 0.4 0.1" size="0.05"/><geom group="3" type="sphere" size="0.2"/>
<body name="two" pos="0 0 1"><joint name="j2" type="slide" axis="0 1 1"/><geom type="mesh" mesh="part" euler="0 0 30"/>
<geom type="box" size="0.1 0.2 0.3" pos="0.5 0 0" euler="0 0 30"/><geom type="cylinder" size="0.1 0.3" euler="90 0 0"/>
<geom type="ellipsoid" size="0.1 0.2 0.3" pos="0 0.5 0"/><geom type="sphere" size="0.1" pos="0 0 1"/>
<geom type="sphere" size="0.1" rgba="1 1 1 0"/></body></body></worldbody>
<actuator><motor joint="j1"/><motor joint="j2"/></actuator></mujoco>"""


def scene(folder: Path) -> Path:
    (folder / "assets").mkdir()
    for suffix in ("stl", "obj"):
        trimesh.creation.cone(30, 80, sections=5).export(folder / "assets" / f"a.{suffix}")
    (folder / "m.xml").write_text(MJCF, encoding="utf-8")
    return folder / "m.xml"


def test_shapes_are_where_mujoco_has_them(tmp_path: Path) -> None:
    """MuJoCo's own vertices, in the world: of two files, with its defaults, frames, sizes and points of reference."""
    mujoco = pytest.importorskip("mujoco")
    path = scene(tmp_path)
    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    data.qpos[:] = 0.9, -0.4
    mujoco.mj_forward(model, data)
    meshes, remarks = read(path)
    placements = placements_of(read_machine(str(path))[0])
    T = placements.at(placements.position({"j1": 0.9, "j2": -0.4}))
    seen = [mesh.points @ T[mesh.frame, :3, :3].T + T[mesh.frame, :3, 3] for mesh in meshes]
    shown = [g for g in range(model.ngeom) if model.geom_group[g] < 3 and model.geom_rgba[g][3] and model.geom_type[g]]
    assert remarks == [] and len(seen) == len(shown) == 8
    for g, points in zip(shown, seen, strict=True):
        own = (points - data.geom_xpos[g]) @ data.geom_xmat[g].reshape(3, 3)
        assert residual(mujoco, model, g, own) < 1e-6


def residual(mujoco: Any, model: Any, g: int, points: np.ndarray) -> float:
    """How far points are from the surface of a shape, in its axes, relative to its size, and from its extent."""
    kind, (a, b, c) = mujoco.mjtGeom(model.geom_type[g]).name, model.geom_size[g]
    if kind == "mjGEOM_MESH":
        mesh = model.geom_dataid[g]
        first, count = model.mesh_vertadr[mesh], model.mesh_vertnum[mesh]
        vertices = model.mesh_vert[first : first + count]
        far = np.linalg.norm(points[:, None] - vertices[None], axis=2)
        return float(max(far.min(axis=1).max(), far.min(axis=0).max()) / np.abs(vertices).max())
    r = np.hypot(points[:, 0], points[:, 1])
    beyond = np.maximum(np.abs(points[:, 2]) - b, 0.0)
    half = {"mjGEOM_SPHERE": (a, a, a), "mjGEOM_CYLINDER": (a, a, b), "mjGEOM_CAPSULE": (a, a, a + b)}.get(
        kind, (a, b, c)
    )
    off = {
        "mjGEOM_BOX": np.abs(np.abs(points) - (a, b, c)).max(),
        "mjGEOM_SPHERE": np.abs(np.linalg.norm(points, axis=1) - a).max(),
        "mjGEOM_ELLIPSOID": np.abs(np.linalg.norm(points / np.maximum((a, b, c), 1e-9), axis=1) - 1).max() * a,
        "mjGEOM_CYLINDER": np.minimum(np.abs(r - a), r).max() + np.abs(np.abs(points[:, 2]) - b).max(),
        "mjGEOM_CAPSULE": np.abs(np.hypot(r, beyond) - a).max(),
    }[kind]
    return float(off / a + np.abs(np.abs(points).max(axis=0) / half - 1)[[0, 2]].max() * (kind != "mjGEOM_BOX"))


def test_solids_of_urdf_are_drawn(tmp_path: Path) -> None:
    path = tmp_path / "r.urdf"
    shapes = '<box size="2 4 6"/>', '<cylinder radius="0.5" length="4"/>', '<sphere radius="3"/>', '<box size="1 x 2"/>'
    visuals = "".join(f'<visual><geometry>{one}</geometry><origin xyz="1 0 0"/></visual>' for one in shapes)
    text = URDF.replace('<visual><geometry><mesh filename="{base}"/></geometry></visual>', visuals)
    path.write_text(text.format(arm="none.stl"), encoding="utf-8")
    solids, _ = read(path)
    halves = [np.abs(mesh.points - (1, 0, 0)).max(axis=0) for mesh in solids]
    np.testing.assert_allclose(halves, [(1, 2, 3), (0.5, 0.5, 2), (3, 3, 3)], atol=1e-12)
    for mesh in solids:
        a, b, c = mesh.points[mesh.triangles.T]
        assert (np.einsum("ij,ij->i", np.cross(b - a, c - a), a - (1, 0, 0)) >= -1e-12).all(), "corners turn outwards"


def test_files_in_all_are_bounded(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = robot(tmp_path)
    monkeypatch.setattr("symoro_elastic.pages.drawing.page.MOST_BYTES_IN_ALL", 1000)
    meshes, (remark,) = read(path)
    assert len(meshes) == 1 and "arm.obj" in remark
    monkeypatch.setattr("symoro_elastic.pages.drawing.page.MOST_SHAPES", 1)
    assert read(path)[1] == ["1 shapes of bodies are drawn, 1 are not"]


def test_fine_meshes_are_drawn_on_a_grid(tmp_path: Path) -> None:
    path = robot(tmp_path, base="fine.stl")
    trimesh.creation.icosphere(subdivisions=5, radius=0.3).export(path.parent / "fine.stl")
    (fine, _), _ = read(path)
    assert 1000 < len(fine.triangles) <= MOST_TRIANGLES
    assert np.linalg.norm(fine.points, axis=1) == pytest.approx(0.3, rel=0.02)


def test_names_of_meshes_are_text(tmp_path: Path) -> None:
    hostile = "<img src=x onerror=alert(1)>\u202e$x$.stl"
    page = symoro_elastic.view(robot(tmp_path, arm=escape(hostile, {'"': "&quot;"}))).html
    assert "<img src=x" not in page and "alert(1)" in page


def test_a_page_draws_meshes(tmp_path: Path) -> None:
    page = symoro_elastic.view(robot(tmp_path))
    assert '"meshes":[{"frame":0' in page.html and "meshes" in page.html
