"""Solids of CAD programs, meshed by gmsh: a bar is a beam, whatever the unit of its file."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import symoro_elastic as se
from tests.command_line import refused

pytest.importorskip("skfem")
try:
    import gmsh
except (ImportError, OSError) as error:  # OSError: libraries of a screen are missing
    pytest.skip(f"gmsh: {error}", allow_module_level=True)

LENGTH, WIDTH, HEIGHT = 0.5, 0.05, 0.03
E, DENSITY = 210e9, 7850.0


def solid(file: Path, unit: str) -> Path:
    """A bar in a file whose unit is "M" or "MM"."""
    gmsh.initialize([], readConfigFiles=False, interruptible=False)
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.option.setString("Geometry.OCCTargetUnit", unit)
    scale = {"M": 1.0, "MM": 1000.0}[unit]
    gmsh.model.occ.addBox(0, 0, 0, scale * LENGTH, scale * WIDTH, scale * HEIGHT)
    gmsh.model.occ.synchronize()
    gmsh.write(str(file))
    gmsh.finalize()
    return file


def test_a_bar_of_a_step_file_is_a_beam(tmp_path: Path) -> None:
    """Shear lowers f1 by 0.3 % at most; elements are as long as the bar is wide."""
    body = se.flexible(solid(tmp_path / "bar.step", "MM"), "x=0", {"tip": "x=0.5"}, material=f"{E},0,{DENSITY}").body
    assert body.rigid[0] == pytest.approx(DENSITY * LENGTH * WIDTH * HEIGHT, rel=1e-9)
    exact = 3.5160152685 / (2 * np.pi * LENGTH**2) * np.sqrt(E * HEIGHT**2 / (12 * DENSITY))
    assert -3e-3 < body.frequencies[0] / exact - 1 < 2e-3


@pytest.mark.parametrize(
    ("name", "size", "what"),
    [
        ("bar.step", (), "bar.step: file: cannot be meshed"),
        ("bar.step", ("--size", "0"), "bar.step: --size: 0 must be above 0, m"),
        ("bar.msh", ("--size", "0.1"), "bar.msh: --size: is of solids that are meshed here, .step"),
    ],
)
def test_solids_that_are_refused(name: str, size: tuple[str, ...], what: str, tmp_path: Path) -> None:
    (tmp_path / name).write_text("no solid")
    assert what in refused("flexible", tmp_path / name, "--fixed", "x=0", *size)


def test_smaller_elements_are_softer(tmp_path: Path) -> None:
    file = solid(tmp_path / "bar.step", "M")
    coarse, fine = (se.flexible(file, "x=0", {"tip": "x=0.5"}, size=size).body for size in (0.1, 0.02))
    assert fine.G.shape == coarse.G.shape and 0.98 < fine.frequencies[0] / coarse.frequencies[0] < 1
