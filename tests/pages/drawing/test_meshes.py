"""Meshes of bodies: where URDF puts them, from files beside it only, coarse where they are fine."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import symoro_elastic
from symoro_elastic.formats import read_machine
from symoro_elastic.formats.robots.urdf import rotation
from symoro_elastic.pages.drawing.meshes import MOST_TRIANGLES, Mesh, meshes_of
from symoro_elastic.pages.drawing.placements import placements_of

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


def test_fine_meshes_are_drawn_on_a_grid(tmp_path: Path) -> None:
    path = robot(tmp_path, base="fine.stl")
    trimesh.creation.icosphere(subdivisions=5, radius=0.3).export(path.parent / "fine.stl")
    (fine, _), _ = read(path)
    assert 1000 < len(fine.triangles) <= MOST_TRIANGLES
    assert np.linalg.norm(fine.points, axis=1) == pytest.approx(0.3, rel=0.02)


def test_a_page_draws_meshes(tmp_path: Path) -> None:
    page = symoro_elastic.view(robot(tmp_path))
    assert '"meshes":[{"frame":0' in page.html and "meshes" in page.html
