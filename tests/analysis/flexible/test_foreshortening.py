"""Foreshortening of finite-element bodies: against beams, and rotations of stressed bodies."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from symoro_elastic.analysis.flexible.reduction import FiniteElements, FlexibleModes, modal_body
from symoro_elastic.analysis.flexible.sources import of_mesh
from symoro_elastic.formats import read_machine
from symoro_elastic.formats.modes_file import ModalBody, load
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import InputError
from tests.mechanics.test_flexible_bodies import model as results_of

skfem = pytest.importorskip("skfem")

LENGTH, WIDTH, HEIGHT, AWAY = 1.0, 0.02, 0.03, 0.3
E, DENSITY = 70e9, 2700.0


@pytest.fixture(scope="module")
def bar(tmp_path_factory: pytest.TempPathFactory) -> FiniteElements:
    """A slender bar along x, its axis at y = AWAY, without lateral contraction."""
    ends = ((0, LENGTH), (AWAY - WIDTH / 2, AWAY + WIDTH / 2), (-HEIGHT / 2, HEIGHT / 2))
    mesh = skfem.MeshHex.init_tensor(*(np.linspace(*end, n) for end, n in zip(ends, (9, 2, 2), strict=True)))
    mesh = mesh.with_boundaries({"root": lambda x: x[0] == 0, "tip": lambda x: x[0] == LENGTH})
    file = tmp_path_factory.mktemp("meshes") / "bar.msh"
    mesh.save(str(file))
    return of_mesh(str(file), f"{E},0,{DENSITY}", 1.0)


@pytest.fixture(scope="module")
def body(bar: FiniteElements) -> ModalBody:
    return modal_body(bar, bar.groups["root"], {"tip": bar.groups["tip"]}, 4)


def test_stresses_turn_with_the_body(bar: FiniteElements) -> None:
    """Forces that a body in equilibrium bears turn with it: Kg of a small turn is the turn of the forces."""
    assert bar.geometric is not None
    rng = np.random.default_rng(0)
    displacements, turn = rng.normal(size=bar.x.size), rng.normal(size=3)
    forces = (bar.K @ displacements).reshape(-1, 3)
    turned = bar.geometric(displacements) @ np.cross(turn, bar.x)
    assert turned == pytest.approx(np.cross(turn, forces), abs=1e-9 * np.abs(forces).max())


CENTRIFUGAL = (1.1934, 6.478)
"""w^2 = w0^2 + c speed^2 of flapping of a clamped beam, modes 1 and 2 (Southwell's coefficients)."""
STRAIGHT = (1.5709, 8.6471)
"""int (L - x) phi'^2/int phi^2 of these modes."""
AT_TIP = (4.6478, 32.4174)
"""int phi'^2 L/int phi^2."""


def test_a_slender_bar_is_shortened_as_a_beam(body: ModalBody) -> None:
    """Along x by accelerations and forces along it; the place of the axis is a factor of the others."""
    assert body.Ct1 is not None and body.T1s is not None
    shorter = body.interfaces["tip"].shorter
    assert shorter is not None
    for k in range(4):
        mass, bends = body.masses[k, k], k // 2
        assert -body.T1s[k, k, 0, 0] / mass == pytest.approx(CENTRIFUGAL[bends], rel=0.01)
        assert -body.Ct1[k, k, 0] * LENGTH / mass == pytest.approx(STRAIGHT[bends], rel=0.01)
        assert -shorter[k, k, 0] * LENGTH * body.rigid[0] / mass == pytest.approx(AT_TIP[bends], rel=0.02)
        assert body.T1s[k, k, 1, 0] == pytest.approx(AWAY * body.Ct1[k, k, 0], rel=1e-3)
        assert np.abs(body.T1s[k, k, 0, 1:]).max() < 1e-3 * abs(body.T1s[k, k, 0, 0])
    for x in (body.Ct1, body.T1s, shorter):
        assert x == pytest.approx(x.swapaxes(0, 1), abs=1e-9 * np.abs(x).max())


TURNING = """
name = "turning"
gravity = [0, 0, 0]
joints = [
  { name = "hub", antecedent = 0, kind = "motor", sigma = 0, axis = "z", at = [0, 0, 0] },
  { name = "arm", antecedent = "hub", kind = "fixed", at = [0.1, PLACE, 0] },
  { name = "tool", antecedent = "END", kind = "fixed" },
]
bodies = { tool = { mass = 1.0 } }
"""
BEAM = f"""
[beams.arm]
along = "x"
length = {LENGTH}
section = {{ bar = [{WIDTH}, {HEIGHT}] }}
E = {E}
density = {DENSITY}
modes = 3
stiffening = true
bends = ["y", "z"]
"""


def squares(file: Path, speed: float) -> Array:
    """Squares of the two lowest frequencies with a hub of constant speed, (rad/s)^2."""
    machine, _ = read_machine(file)
    n = len(machine.independent)
    qd = np.where(np.arange(n) == 0, speed, 0.0)
    M, C, K = (x[1:, 1:] for x in results_of(machine, "linearization", np.zeros(n), qd, np.zeros(n)))
    one, zero = np.eye(n - 1), np.zeros((n - 1, n - 1))
    w = np.linalg.eigvals(np.block([[zero, one], [-np.linalg.solve(M, K), -np.linalg.solve(M, C)]])).imag
    return np.asarray(np.sort(w[w > 0])[:2] ** 2)


def test_a_turning_bar_with_a_tool_is_a_beam(body: ModalBody, tmp_path: Path) -> None:
    """Centrifugal forces of the bar and of what it carries add 17 % and 31 % to the squares at 40 rad/s."""
    FlexibleModes("bar", body).write(tmp_path / "bar.npz")
    text = TURNING.replace("PLACE", "0").replace("END", "arm") + BEAM
    (tmp_path / "beam.toml").write_text(text)
    text = TURNING.replace("PLACE", f"{-AWAY}").replace("END", "arm_tip")
    entry = '[flexible]\narm = { file = "bar.npz", keep = "3 kHz", stiffening = true }\n'
    (tmp_path / "mesh.toml").write_text(text + entry)
    (tmp_path / "soft.toml").write_text(text + entry.replace("true", "false"))
    names, speeds = ("beam.toml", "mesh.toml", "soft.toml"), (0.0, 40.0)
    beam, mesh, soft = ([squares(tmp_path / name, speed) for speed in speeds] for name in names)
    assert mesh[0] == pytest.approx(beam[0], rel=0.01)
    assert mesh[1] - mesh[0] == pytest.approx(beam[1] - beam[0], rel=0.01)
    assert soft[1][0] < mesh[0][0] / 2, "without it the arm turns softer, by the square of the speed"


def test_what_matrices_cannot_give(bar: FiniteElements, tmp_path: Path) -> None:
    plain = replace(bar, geometric=None)
    FlexibleModes("bar", modal_body(plain, bar.groups["root"], {}, 2)).write(tmp_path / "bar.npz")
    text = TURNING.replace("PLACE", "0").replace("END", "arm")
    (tmp_path / "mesh.toml").write_text(text + '[flexible]\narm = { file = "bar.npz", stiffening = true }\n')
    with pytest.raises(InputError, match="stiffening: the file has no foreshortening, which needs stresses: make it"):
        read_machine(tmp_path / "mesh.toml")


def test_a_file_keeps_foreshortening(body: ModalBody, tmp_path: Path) -> None:
    kept = load(FlexibleModes("bar", body).write(tmp_path / "bar.npz")).keep(np.arange(body.count) < 3)
    for key in ("Ct1", "T1s"):
        assert np.array_equal(getattr(kept, key), getattr(body, key)[:3, :3]), key
    first, second = kept.interfaces["tip"].shorter, body.interfaces["tip"].shorter
    assert first is not None and second is not None and np.array_equal(first, second[:3, :3])
