"""Beams as bars: along the deflection of the beam's equation, with their section, in Python and in scripts."""

from __future__ import annotations

import json

import numpy as np
import pytest

from symoro_elastic.formats import read_machine
from symoro_elastic.formats.toml import reading as toml
from symoro_elastic.machine.described import DescribedMachine
from symoro_elastic.pages.drawing.bars import BEAM, Bar
from symoro_elastic.pages.drawing.figure import Figure, Placements, figure_of, placements_of
from symoro_elastic.pages.drawing.page import ShownMachine, page_data
from symoro_elastic.pages.drawing.svg import joint_counts, picture_of, svg
from tests.command_line import EXAMPLES
from tests.pages.drawing.test_scripts import by_node, needs_node, script

LENGTH, EI = 2.0, 3.0
SECTION = 'section = { box = [0.1, 0.2, 0.005] }, E = "70 GPa", density = 2700'
PLAIN = f"EI = {EI}, GJ = 2, EA = 5, mass_per_length = 0.7, inertia_per_length = 0.02"
WALLED = """
name = "walled"
gravity = [0, 0, 0]
joints = [
  { name = "wall", kind = "fixed", antecedent = 0, gamma = 0.4, alpha = 0.7, r = 0.3 },
  { name = "tip", kind = "motor", sigma = 0, theta = "tip" },
]
[beams]
wall = { along = "ALONG", length = 2, SECTION, KEYS }
[bodies]
tip = { mass = 1, center_of_mass = [0, 0, 0], inertia = [1, 1, 1] }
"""


def drawn(keys: str = "joints = 4", along: str = "x", section: str = PLAIN) -> Placements:
    text = WALLED.replace("ALONG", along).replace("SECTION", section).replace("KEYS", keys)
    return placements_of(toml.read(text, "walled.toml"))


def figure(found: Placements) -> Figure:
    return figure_of(found, found.start)


def only_bar(found: Placements) -> Bar:
    (bar,) = figure(found).bars
    return bar


def position(found: Placements, **at: float) -> np.ndarray:
    return np.array([at.get(joint.name, 0.0) for joint in found.machine.independent_joints])


def in_root(found: Placements, bar: Bar, T: np.ndarray) -> np.ndarray:
    """Rings of a bar (R, N, 3) in the frame of its root: x along the beam."""
    root = T[bar.root]
    return np.asarray((bar.rings(T) - root[:3, 3]) @ root[:3, :3])


@pytest.mark.parametrize("joints", [2, 4, 5])
def test_a_bar_follows_the_deflection_of_a_loaded_beam(joints: int) -> None:
    """A small force at the tip bends it by F x^2 (3 L - x)/(6 EI); within 1 % of the tip's, and exact at both ends."""
    found = drawn(f'bends = ["y"], joints = {joints}')
    (beam,) = DescribedMachine.of(found.machine).origin.beams
    bar, force = only_bar(found), 1e-4
    turns = [force * LENGTH * (1 - x) * w * LENGTH / EI for x, w in zip(*beam.places("y"), strict=True)]
    T = found.at(position(found, **{f"wall_y{k}": turn for k, turn in enumerate(turns, start=1)}))
    middle = in_root(found, bar, T).mean(axis=1)
    x = middle[:, 0]
    exact = force * x**2 * (3 * LENGTH - x) / (6 * EI)
    tip = force * LENGTH**3 / (3 * EI)
    assert np.max(np.abs(middle[:, 1] - exact)) < (0.04 if joints == 2 else 0.011) * tip
    assert middle[0] == pytest.approx([0, 0, 0], abs=1e-15)
    assert middle[-1] == pytest.approx([LENGTH, tip, 0], abs=1e-7)
    assert len(middle) >= 24
    bends = np.diff(np.diff(middle[:, 1]) / np.diff(x))
    assert bends.min() > (-0.1 if joints == 2 else -1e-6) * bends.max(), "to one side, of two joints nearly"


@pytest.mark.parametrize("along", ["x", "-y", "z"])
def test_a_bar_ends_as_its_end_frame_is(along: str) -> None:
    """Bent to both sides, twisted and pulled: the last section lies in the frame that carries the tip."""
    found = drawn('bends = ["torsion", "axial", ' + ", ".join(f'"{a}"' for a in "xyz" if a != along[-1]) + "]", along)
    rng, bar = np.random.default_rng(3), only_bar(found)
    T = found.at(rng.uniform(-0.2, 0.2, len(found.start)))
    end = bar.rings(T)[-1]
    at = T[bar.end] @ bar.stations[-1]
    local = (end - at[:3, 3]) @ at[:3, :3]
    np.testing.assert_allclose(local, np.pad(bar.outline, ((0, 0), (1, 0))), atol=1e-12)
    assert found.machine.joint(bar.end).name == "wall_end"
    np.testing.assert_allclose(np.abs(at[:3, 0]), np.abs(T[bar.end][:3, "xyz".index(along[-1])]), atol=1e-12)


@pytest.mark.parametrize(("along", "sides"), [("x", (2, 0.1, 0.2)), ("y", (0.1, 2, 0.2)), ("-z", (0.1, 0.2, 2))])
def test_a_section_is_drawn_in_its_size(along: str, sides: tuple[float, ...]) -> None:
    found = drawn("joints = 2", along, SECTION)
    bar, T = only_bar(found), found.at(found.start)
    wall = [joint.name for joint in found.machine.joints].index("wall") + 1
    rings = (bar.rings(T).reshape(-1, 3) - T[wall][:3, 3]) @ T[wall][:3, :3]
    assert np.ptp(rings, axis=0) == pytest.approx(sides, abs=1e-12)
    assert not bar.is_round


def test_without_a_section_it_is_a_rod_of_equal_inertia_or_slender() -> None:
    assert np.ptp(only_bar(drawn()).outline[:, 0]) == pytest.approx(np.sqrt(8 * 0.02 / 0.7), rel=1e-9)
    slender = drawn('bends = ["y"]', section="EI = 3, mass_per_length = 1")
    assert np.ptp(only_bar(slender).outline[:, 0]) == pytest.approx(LENGTH / 20, rel=1e-9)


def test_pieces_and_joints_of_a_beam_are_not_drawn() -> None:
    """Neither as boxes and springs nor as names; the frame at its end has its name, and what is there its box."""
    shown = figure(drawn())
    assert [mark.name for mark in shown.marks] == ["base", "wall", "wall_end", "tip"]
    (bar,) = shown.bars
    assert not {solid.frame for solid in shown.solids} & {*range(bar.root, bar.end + 1)}
    assert "elastic" not in {shape.role for shape in shown.shapes}
    assert joint_counts(shown) == "1 motor, 1 beam"
    assert len(bar.springs) == 10


def test_a_beam_by_modes_is_bent_by_the_frames_of_its_ends() -> None:
    """The deflection of one mode has constant curvature, as under a moment at the tip."""
    found = drawn("modes = 1")
    bar = only_bar(found)
    assert len(bar.frames) == 2
    x, y, z = in_root(found, bar, found.at(position(found, wall_y1=1e-4))).mean(axis=1).T
    np.testing.assert_allclose(y, 1e-4 * (x / LENGTH) ** 2, atol=1e-10)
    assert np.abs(z).max() < 1e-15


def test_modes_and_what_follows_them_are_not_joints_of_a_picture() -> None:
    shown = figure(placements_of(read_machine(EXAMPLES / "flexible_gantry.toml")[0]))
    assert joint_counts(shown) == "3 motors, 5 elastic joints, 1 beam"
    names = {mark.name for mark in shown.marks}
    assert {"x_axis", "x_axis_body", "bridge_end"} <= names
    assert not any("bridge_y" in name or "_shift_" in name or "_turn_" in name for name in names)


def test_pictures_have_beams_and_their_ghosts() -> None:
    for section in (SECTION, PLAIN):
        shown = figure(drawn(section=section))
        picture = picture_of(shown)
        areas = [part for part in picture.drawn if part.role == BEAM]
        assert len(areas) == (3 if section == SECTION else 2), "the sides towards the eye, or the outline, and an end"
        assert (BEAM, "beam, or body by modes") in picture.legend
        assert f'class="{BEAM} s' in svg(picture)
        ghosts = picture_of(shown, shown.reference, [np.eye(3)]).drawn
        assert sum(part.role == "ghost" for part in ghosts) >= len(areas)


def test_pages_of_machines_without_beams_have_none() -> None:
    machine = toml.read((EXAMPLES / "two_axis.toml").read_text(encoding="utf-8"), "two_axis.toml")
    found = placements_of(machine)
    assert "bars" not in page_data(ShownMachine(found, found.start))


@needs_node
@pytest.mark.parametrize("section", [SECTION, PLAIN])
def test_rings_of_scripts_are_those_of_pictures(section: str) -> None:
    found = drawn('bends = ["y", "z", "torsion", "axial"]', section=section)
    bar, rng = only_bar(found), np.random.default_rng(4)
    T = found.at(rng.uniform(-0.2, 0.2, len(found.start)))
    (data,) = page_data(ShownMachine(found, found.start))["bars"]
    body = """
    const material = new THREE.LineBasicMaterial(), painted = { fill: () => material, edge: () => material };
    const drawn = new Bar(told.bar, painted, told.T), { position } = drawn.geometry.attributes;
    const rings = ringsOf(told.bar, told.T).map((ring) => ring.map((p) => p.toArray()));
    const energy = drawn.energy([["wall_y2", 0.4], ["tip", 0.2]]), index = [...drawn.geometry.index.array];
    console.log(JSON.stringify([rings, [...position.array], index, energy]));
    """
    told = {"bar": json.loads(json.dumps(data)), "T": T.reshape(-1, 16).tolist()}
    scripts = script("vendor/three.min.js", "space.js", "bars.js")
    rings, points, index, energy = by_node(scripts + body, told)
    np.testing.assert_allclose(rings, bar.rings(T), atol=1e-8)
    corners = np.reshape(points, (-1, 3))[np.reshape(index, (-1, 3))]
    volume = np.einsum("ti,ti->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6
    area = 0.02 if section == SECTION else 20 / 2 * np.sin(2 * np.pi / 20) * 0.02 * 2 / 0.7
    assert volume == pytest.approx(area * LENGTH, rel=0.1), "closed, with its sides outside"
    assert energy == 0.4
