"""Bodies by modes as the surface of their mesh, in Python and in scripts."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from symoro_elastic.analysis.flexible.reduction import FlexibleModes, modal_body
from symoro_elastic.analysis.flexible.sources import of_mesh
from symoro_elastic.analysis.vibration.drawn_modes import drawn_modes, mode_pictures
from symoro_elastic.formats import read_machine
from symoro_elastic.formats.modes_file import ModalBody, load
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.pictures import Plot
from symoro_elastic.pages.drawing.bars import BEAM
from symoro_elastic.pages.drawing.figure import BODY, Placements, figure_of, placements_of
from symoro_elastic.pages.drawing.page import ShownMachine, page_data, shown_machine
from symoro_elastic.pages.drawing.skins import Skin
from symoro_elastic.pages.drawing.svg import picture_of
from symoro_elastic.pages.drawing.vibrations import changes_of, corners_of
from tests.pages.drawing.test_scripts import by_node, needs_node, script

skfem = pytest.importorskip("skfem")
DENSITY, SIZE = 2000.0, (0.4, 0.1, 0.06)
MACHINE = """
name = "bracket"
gravity = [0, 0, 0]
joints = [
  { name = "hub", antecedent = 0, kind = "motor", sigma = 0, axis = "y", at = [0.1, 0.2, 0.3] },
  { name = "arm", antecedent = "hub", kind = "fixed", axis = "x", at = [0.2, 0.2, 0.3] },
  { name = "tool", antecedent = "arm_tip", kind = "fixed" },
]
bodies = { tool = { mass = 1 } }
[flexible]
arm = { file = "bracket.npz" }
"""


def reduced(kind: str, folder: Path) -> ModalBody:
    """A bar of tetrahedra or hexahedra whose nodes are moved within its faces."""
    mesh = getattr(skfem, kind).init_tensor(*(np.linspace(0, size, n) for size, n in zip(SIZE, (5, 3, 2), strict=True)))
    x, sizes = mesh.p, np.array(SIZE)[:, None]
    inside = (x > 0) & (x < sizes)
    mesh = type(mesh)(x + inside * np.random.default_rng(0).uniform(-0.01, 0.01, x.shape), mesh.t)
    mesh = mesh.with_boundaries({"root": lambda p: np.isclose(p[0], 0), "tip": lambda p: np.isclose(p[0], SIZE[0])})
    mesh.save(str(folder / "bracket.msh"))
    model = of_mesh(str(folder / "bracket.msh"), f"1e9,0.3,{DENSITY}", 1.0)
    return modal_body(model, model.groups["root"], {"tip": model.groups["tip"]}, 2)


@pytest.fixture(scope="module")
def drawn(tmp_path_factory: pytest.TempPathFactory) -> Placements:
    folder = tmp_path_factory.mktemp("bracket")
    FlexibleModes("bracket", reduced("MeshHex", folder)).write(folder / "bracket.npz")
    (folder / "bracket.toml").write_text(MACHINE)
    return placements_of(read_machine(folder / "bracket.toml")[0])


def only_skin(drawn: Placements) -> Skin:
    (skin,) = figure_of(drawn, drawn.start).skins
    return skin


def bent(drawn: Placements, seed: int = 1) -> np.ndarray:
    """Placements where the motor has turned and all modes deflect."""
    return drawn.at(np.random.default_rng(seed).uniform(-0.05, 0.05, len(drawn.start)))


@pytest.mark.parametrize("kind", ["MeshTet", "MeshHex"])
def test_a_surface_encloses_the_body(kind: str, tmp_path: Path) -> None:
    surface = reduced(kind, tmp_path).surface
    assert surface is not None
    a, b, c = surface.points[surface.triangles].swapaxes(0, 1)
    volume = np.einsum("ti,ti->", a, np.cross(b, c)) / 6
    assert volume == pytest.approx(np.prod(SIZE), rel=1e-12), "closed, with its faces seen from outside"


def test_a_skin_follows_its_interface(drawn: Placements) -> None:
    """Bent by the first mode the tip is where the frame of the interface is, and the root where the joint is."""
    skin, names = only_skin(drawn), [joint.name for joint in drawn.machine.joints]
    q = drawn.start.copy()
    q[[joint.name for joint in drawn.machine.independent_joints].index("arm_e1")] = e = 0.02
    moved, rest = skin.points(drawn.at(q)), skin.points(drawn.at(drawn.start))
    root, tip = (np.isclose(skin.surface.points[:, 0], at) for at in (0.0, SIZE[0]))
    assert moved[root] == pytest.approx(rest[root], abs=1e-9)
    tool = drawn.at(q)[names.index("tool") + 1][:3, 3] - drawn.at(drawn.start)[names.index("tool") + 1][:3, 3]
    assert np.linalg.norm((moved - rest)[tip].mean(axis=0) - tool) < 0.02 * np.linalg.norm(tool)
    assert 0.9 * e < np.linalg.norm(tool) < e, "a unit of a mode is its largest displacement"


def test_drawn_modes_are_small_motions_of_the_skin(drawn: Placements) -> None:
    shown = shown_machine(drawn.machine, {})
    modal = next(mode_set.modal for mode_set in shown.modes if mode_set.modal)
    figure, small = shown.figure, 1e-6
    skin = figure.skins[0].coarse
    corners = corners_of(figure)
    for mode in drawn_modes(modal, range(3), corners):
        moved = skin.points(shown.placements.at(shown.q + small * changes_of(modal, mode)))
        exact = (moved - skin.points(figure.reference)) / small
        computed = mode.displacements[list(corners.bent[0].indices)]
        assert computed == pytest.approx(exact, abs=1e-4 * np.abs(exact).max())


def test_a_skin_is_drawn_in_place_of_a_box(drawn: Placements) -> None:
    figure = figure_of(drawn, drawn.start)
    assert figure.skins[0].root not in {solid.frame for solid in figure.solids if solid.role == BODY}
    areas = [part for part in picture_of(figure, bent(drawn)).drawn if part.role == BEAM]
    assert 20 < len(areas) < len(figure.skins[0].coarse.surface.triangles)


@pytest.mark.thorough
def test_pictures_of_modes_have_its_edges(drawn: Placements) -> None:
    shown = shown_machine(drawn.machine, {})
    plot = mode_pictures(next(mode_set.modal for mode_set in shown.modes if mode_set.modal))
    assert isinstance(plot, Plot)


@needs_node
def test_scripts_draw_the_same_skin(drawn: Placements) -> None:
    skin, T = only_skin(drawn), bent(drawn, 2)
    (data,) = page_data(ShownMachine(drawn, drawn.start))["skins"]
    body = """
    const material = new THREE.LineBasicMaterial(), painted = { fill: () => material, edge: () => material };
    const drawn = new Skin(told.skin, painted, told.T), { position } = drawn.geometry.attributes;
    const energy = drawn.energy([["arm_e1", 0.4], ["arm_e2", 0.1], ["tool", 0.2]]);
    console.log(JSON.stringify([[...position.array], [...drawn.edges.geometry.index.array], energy]));
    """
    told = {"skin": json.loads(json.dumps(data)), "T": T.reshape(-1, 16).tolist()}
    points, edges, energy = by_node(script("vendor/three.min.js", "space.js", "skins.js") + body, told)
    corners = np.reshape(points, (-1, 3, 3))
    assert corners == pytest.approx(skin.points(T)[skin.surface.triangles], abs=1e-6)
    assert 2 * len(edges) == 2 * 3 * len(corners), "each edge of a closed surface once, by two ends"
    assert energy == 0.5


def test_a_surface_is_kept_with_its_modes(tmp_path: Path) -> None:
    body = reduced("MeshTet", tmp_path)
    file = FlexibleModes("bracket", body).write(tmp_path / "bracket.npz")
    kept = load(file).keep(np.arange(body.count) == 2)
    assert kept.surface is not None and body.surface is not None
    assert kept.surface.modes == pytest.approx(body.surface.modes[[2]], abs=1e-6)
    with np.load(file, allow_pickle=False) as stored:
        arrays = {key: stored[key] for key in stored.files}
    for name, wrong in (("triangles", arrays["triangles"] + 1000), ("surface_modes", arrays["surface_modes"][:, :3])):
        np.savez(tmp_path / "wrong.npz", **{**arrays, name: wrong})
        with pytest.raises(InputError, match=f"{name}: must be"):
            load(tmp_path / "wrong.npz")
