"""Pictures: names that are read, text that is not a markup, the same bytes."""

from __future__ import annotations

import re
from dataclasses import replace
from functools import cache
from itertools import combinations
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

from docs.site.moving_picture import moving_picture
from symoro_elastic.formats import read_machine
from symoro_elastic.machine.machine import Machine
from symoro_elastic.pages.drawing.figure import figure_of, placements_of
from symoro_elastic.pages.drawing.picture_files import write_picture
from symoro_elastic.pages.drawing.projection import hull
from symoro_elastic.pages.drawing.svg import (
    LEGEND,
    Label,
    Picture,
    machine_picture,
    overlap,
    picture_of,
    place_labels,
    svg,
    width,
)
from tests.command_line import EXAMPLES, refused, run

pytestmark = pytest.mark.sampled(5)

SVG = "{http://www.w3.org/2000/svg}"
MACHINES = ("two_axis.toml", "gantry.toml", "palletizer.toml", "rx90.par", "floating_arm.toml")
HOSTILE = '</text><script>alert(1)</script>&"<b>'


@cache
def machine(name: str) -> Machine:
    return read_machine(EXAMPLES / name)[0]


@cache
def picture(name: str) -> Picture:
    return machine_picture(machine(name))


def refuse_overlaps(labels: list[Label]) -> None:
    assert [(a.text, b.text) for a, b in combinations(labels, 2) if overlap(a.box, b.box)] == []


@pytest.mark.parametrize("name", MACHINES)
def test_labels_avoid_each_other(name: str) -> None:
    found = picture(name)
    assert [label.text for label in found.labels] == [mark.name for mark in found.figure.marks]
    refuse_overlaps(found.labels)
    left, top, right, bottom = found.box
    for label in found.labels:
        assert left <= label.box[0] and label.box[2] <= right and top <= label.box[1] and label.box[3] <= bottom


@pytest.mark.thorough
def test_labels_of_one_point_avoid_each_other_however_many() -> None:
    anchors = np.zeros((60, 2))
    labels = place_labels([f"joint_{k}" for k in range(60)], anchors, np.zeros((0, 4)))
    refuse_overlaps(labels)
    assert all((label.anchor_x, label.anchor_y) == (0, 0) for label in labels)


@pytest.mark.parametrize("name", MACHINES)
def test_the_same_machine_gives_the_same_document(name: str) -> None:
    text = svg(picture(name))
    assert text == svg(machine_picture(machine(name)))
    tree = ElementTree.fromstring(text)
    shown = [element.text for element in tree.iter(f"{SVG}text") if element.get("class") == "label"]
    assert shown == [mark.name for mark in picture(name).figure.marks]
    assert not re.search(r"nan|inf|https?://(?!www\.w3\.org/2000/svg)", text)


def test_dots_are_where_frames_are_seen() -> None:
    """By another way: the picture is an orthographic view, up to one scale and a shift."""
    found = picture("gantry.toml")
    figure = found.figure
    dots = np.array([(label.anchor_x, label.anchor_y) for label in found.labels])
    origins = figure.reference[[mark.frame for mark in figure.marks], :3, 3]
    known = np.concatenate([origins, np.ones((len(origins), 1))], axis=1)
    map_, _, _, _ = np.linalg.lstsq(known, dots, rcond=None)
    np.testing.assert_allclose(known @ map_, dots, atol=1e-9)
    right, down = map_[:3].T
    assert right @ down == pytest.approx(0, abs=1e-9) and right @ right == pytest.approx(down @ down)
    assert down @ figure.up < 0 and right @ figure.up == pytest.approx(0, abs=1e-9)


@pytest.mark.parametrize("name", ["linkage.toml", "two_axis.toml", "palletizer.toml"])
def test_the_legend_is_within_the_picture(name: str) -> None:
    """Narrow pictures have it in several rows."""
    tree = ElementTree.fromstring(svg(picture(name)))
    left, top, across, down = map(float, tree.attrib["viewBox"].split())
    entries = [one for one in tree.iter(f"{SVG}text") if one.text in LEGEND.values()]
    assert len(entries) > 2
    for one in entries:
        end = float(one.attrib["x"]) + width(one.text or "")
        assert left < float(one.attrib["x"]) < end < left + across, one.text
        assert top < float(one.attrib["y"]) < top + down


@pytest.mark.parametrize("name", ["gantry.toml", "two_axis.toml", "planar_2r.toml"])
def test_all_that_is_drawn_is_within_the_picture(name: str) -> None:
    """At the start and with all joints moved, bodies included."""
    placements = placements_of(machine(name))
    for q in (placements.start, placements.start + 0.2):
        drawing = picture_of(figure_of(placements, placements.start), placements.at(q))
        points = np.concatenate([part.points for part in drawing.drawn])
        left, top, right, bottom = drawing.box
        assert (points >= (left, top)).all() and (points <= (right, bottom)).all()


def test_a_mode_is_drawn_with_arrows_before_a_ghost_of_the_rest_position() -> None:
    found = figure_of(placements_of(machine("planar_2r.toml")), placements_of(machine("planar_2r.toml")).start)
    line = np.array([[0.0, 0, 0], [0, 0, 5]])
    drawing = picture_of(found, None, [line])
    roles = [part.role for part in drawing.drawn]
    solid = [part for part in drawing.drawn if part.closed and part.role not in ("base", "ghost")]
    assert roles[-1] == "arrow" and roles[0] == "ghost" and roles.count("ghost") == len(solid)
    assert "ghost" not in [part.role for part in picture_of(found).drawn]
    left, top, right, bottom = drawing.box
    assert (drawing.drawn[-1].points >= (left, top)).all() and (drawing.drawn[-1].points <= (right, bottom)).all()


def test_names_are_text_and_never_markup() -> None:
    hostile = replace(machine("planar_2r.toml"), name=HOSTILE)
    hostile = replace(hostile, joints=tuple(replace(joint, name=HOSTILE) for joint in hostile.joints[:1]))
    text = svg(machine_picture(hostile))
    tree = ElementTree.fromstring(text)
    assert HOSTILE in [element.text for element in tree.iter(f"{SVG}text")]
    assert "<script" not in text and HOSTILE in (tree.findtext(f"{SVG}title") or "")


def test_the_hull_holds_all_points() -> None:
    points = np.random.default_rng(3).normal(size=(40, 2))
    around = points[hull(points)]
    for a, b in zip(around, np.roll(around, -1, axis=0), strict=True):
        turned = (b[0] - a[0]) * (points[:, 1] - a[1]) - (b[1] - a[1]) * (points[:, 0] - a[0])
        assert turned.min() >= -1e-12


# Files


def test_the_picture_of_the_start_page_is_that_of_the_machine() -> None:
    """Accept another one by `symoro-elastic show examples/gantry.toml --picture examples/gantry.svg --force`."""
    assert svg(picture("gantry.toml")) == (EXAMPLES / "gantry.svg").read_text(encoding="utf-8")
    assert "examples/gantry.svg" in (EXAMPLES.parent / "docs" / "index.md").read_text(encoding="utf-8")


def test_the_moving_picture_of_the_readme_shows_a_cycle() -> None:
    """Frames that are shown one at a time; written by `python -m docs.site.moving_picture`."""
    pytest.importorskip("scipy")
    text = (EXAMPLES / "gantry_mode.svg").read_text(encoding="utf-8")
    made = ElementTree.fromstring(moving_picture(machine("gantry.toml"), 4))
    for root in (ElementTree.fromstring(text), made):
        values = [turn.attrib["values"].split(";") for turn in root.iter(f"{SVG}animate")]
        assert len(values) == 9 and all(column.count("inline") == 1 for column in zip(*values, strict=True))
    assert len(text) < 150_000
    assert "examples/gantry_mode.svg" in (EXAMPLES.parent / "README.md").read_text(encoding="utf-8")


def test_show_draws_the_machine_at_a_position(tmp_path: Path) -> None:
    two_r = machine("planar_2r.toml")
    run("show", EXAMPLES / "planar_2r.toml", "--picture", tmp_path / "bent.svg", "--at", "elbow=0.5")
    drawn = (tmp_path / "bent.svg").read_text(encoding="utf-8")
    assert drawn == svg(machine_picture(two_r, {"elbow": 0.5})) != svg(machine_picture(two_r))


@pytest.mark.thorough
def test_pictures_of_dots_have_the_same_bytes(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    for k in (1, 2):
        write_picture(picture("planar_2r.toml"), str(tmp_path / f"{k}.png"), "--picture")
    first, second = ((tmp_path / f"{k}.png").read_bytes() for k in (1, 2))
    assert first == second and first[:4] == b"\x89PNG"


def test_other_files_are_refused_and_positions_too(tmp_path: Path) -> None:
    two_r = EXAMPLES / "planar_2r.toml"
    assert "end the name with .svg, .png or .pdf" in refused("show", two_r, "--picture", tmp_path / "a.gif")
    assert "no moving joint 'knee'" in refused("show", two_r, "--picture", tmp_path / "a.svg", "--at", "knee=1")
    assert list(tmp_path.iterdir()) == []


def test_equations_have_a_picture_above_them() -> None:
    text = run("equations", EXAMPLES / "planar_2r.toml", "--model", "inertia_matrix", "--format", "html").output
    assert text.count('<svg xmlns="http://www.w3.org/2000/svg" class="machine"') == 1
    assert "prefers-color-scheme" not in text, "the page is for light paper"
