"""The page of a machine: one file that loads nothing, texts that are not markup, modes and motions as computed."""

from __future__ import annotations

import base64
import hashlib
import json
import re
from dataclasses import replace
from functools import cache
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import symoro_elastic
from symoro_elastic.analysis.vibration.drawn_modes import drawn_modes
from symoro_elastic.analysis.vibration.modes import frame_shapes
from symoro_elastic.codegen.templates import template_folder
from symoro_elastic.formats import read_machine
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.machine import Kind, Machine
from symoro_elastic.models.bound.state import State
from symoro_elastic.pages.drawing.figure import placements_of
from symoro_elastic.pages.drawing.motions import motions_data, simulated_motion, with_base
from symoro_elastic.pages.drawing.page import ShownMachine, machine_page, shown_machine
from symoro_elastic.pages.drawing.vibrations import HELD, arrows_of, changes_of, corners_of, modes_data
from tests.command_line import EXAMPLES, ended, refused, run
from tests.generated_code import COMPILERS

HOSTILE = '</script><script>alert(1)</script><!--&"<b>'


@cache
def machine(name: str) -> Machine:
    return read_machine(EXAMPLES / name)[0]


@cache
def shown(name: str) -> ShownMachine:
    return shown_machine(machine(name), {})


class Elements(HTMLParser):
    """Elements of a page: their attributes, and the text of scripts and styles."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.elements: list[tuple[str, dict[str, str | None]]] = []
        self.run: list[tuple[str, str]] = []
        self.data = ""
        self.feed(page)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append((tag, dict(attrs)))

    def handle_data(self, data: str) -> None:
        tag, attributes = self.elements[-1] if self.elements else ("", {})
        if tag == "script" and attributes.get("type") == "application/json":
            self.data += data
        elif self.get_starttag_text() in ("<script>", "<style>") and data.strip():
            self.run.append((tag, data))


@cache
def page(name: str) -> str:
    return machine_page(shown(name))


def data(text: str) -> dict[str, Any]:
    found = re.search(r'<script type="application/json" id="data">(.*?)</script>', text, re.DOTALL)
    assert found
    return json.loads(found[1])


def test_the_page_loads_nothing_and_runs_only_what_is_in_it() -> None:
    """Every script and style is in the policy by its digest, and nothing is left of other sources."""
    found = Elements(page("two_axis.toml"))
    for tag, attributes in found.elements:
        assert not {"src", "href", "onclick", "onload", "style"} & attributes.keys(), (tag, attributes)
        assert tag not in ("link", "iframe", "object", "embed", "base", "form", "img")
    (policy,) = (str(a["content"]) for tag, a in found.elements if tag == "meta" and "http-equiv" in a)
    assert policy.startswith("default-src 'none'; ") and "unsafe" not in policy
    for tag in ("script", "style"):
        digests = {
            base64.b64encode(hashlib.sha256(text.encode()).digest()).decode() for kind, text in found.run if kind == tag
        }
        (allowed,) = (part for part in policy.split("; ") if part.startswith(f"{tag}-src "))
        assert set(re.findall(r"'sha256-([^']+)'", allowed)) == digests and digests


def test_the_same_machine_gives_the_same_page_of_reasonable_size() -> None:
    assert page("two_axis.toml") == machine_page(shown_machine(machine("two_axis.toml"), {}))
    assert len(page("two_axis.toml").encode()) < 800_000


def test_names_and_notes_are_data_and_never_markup() -> None:
    hostile = replace(machine("planar_2r.toml"), name=HOSTILE).with_notes(HOSTILE)
    hostile = replace(hostile, joints=tuple(replace(j, name=f"{HOSTILE}{k}") for k, j in enumerate(hostile.joints)))
    text = machine_page(shown_machine(hostile, {}))
    assert "alert(1)</script>" not in text and "<b>" not in text
    found = data(text)
    assert found["notes"] == [HOSTILE] and found["title"] == HOSTILE and found["marks"][1]["name"] == f"{HOSTILE}0"
    plain, changed = (Elements(one).elements for one in (page("planar_2r.toml"), text))
    assert [tag for tag, _ in plain] == [tag for tag, _ in changed]


def test_modes_move_frames_as_computed() -> None:
    """Along the shape of a mode, differences of placements are displacements and rotations of its frames."""
    found = shown("two_axis.toml")
    (held, free) = found.modes
    assert held.title == HELD and held.modal is not None and free.modal is not None
    one = modes_data(held, found.figure)
    assert one["count"] == len(one["modes"]) == 10
    seen, small = frame_shapes(held.modal), 1e-6
    for k, mode in enumerate(one["modes"]):
        shape = np.array(mode["shape"])
        there, back = (found.placements.at(found.q + sense * small * shape)[1:] for sense in (1, -1))
        moved = (there[:, :3, 3] - back[:, :3, 3]) / (2 * small)
        scale = np.abs(shape).max() / np.abs(held.modal.shapes[:, k]).max()
        np.testing.assert_allclose(moved, scale * seen[:, :3, k], atol=1e-7)
        assert mode["strain"][0][1] == pytest.approx(max(share for _, share in mode["strain"]))
    assert [mode["hertz"] for mode in one["modes"]] == pytest.approx(held.modal.frequencies.tolist(), rel=1e-8)


@pytest.mark.parametrize("name", ["two_axis.toml", "lathe.toml", "linkage.toml", "ball_screw.toml"])
def test_modes_are_large_enough_to_be_seen_and_arrows_are_where_they_move_most(name: str) -> None:
    """A drawn point moves by 8 % of the picture's diagonal, or a frame turns by 0.35 rad; never more.

    Modes have no rotation of a cut joint about its axis, along which it is a point.
    """
    found = shown(name)
    corners, step = corners_of(found.figure), 1e-6
    rest = found.placements.at(found.q)
    inverses = np.linalg.inv(rest)[corners.frames]
    own = np.array([mark.role != Kind.CUT for mark in sorted(found.figure.marks, key=lambda mark: mark.frame)])
    local = np.einsum("pij,pj->pi", inverses[:, :3, :3], corners.points) + inverses[:, :3, 3]
    for modal in (mode_set.modal for mode_set in found.modes if mode_set.modal):
        for mode in drawn_modes(modal, range(len(modal.eigenvalues)), corners):
            slopes = (found.placements.at(found.q + step * changes_of(modal, mode)) - rest) / step
            moved = np.einsum("pij,pj->pi", slopes[corners.frames, :3, :3], local) + slopes[corners.frames, :3, 3]
            drawn = own[corners.frames]
            np.testing.assert_allclose(mode.displacements[drawn], moved[drawn], atol=1e-4 * corners.extent)
            far = np.linalg.norm(mode.displacements, axis=1)
            turn = max(float(np.linalg.norm(x)) / np.sqrt(2) for x in slopes[own, :3, :3])
            assert max(far.max() / (0.08 * corners.extent), turn / 0.35) == pytest.approx(1, rel=1e-4)
            assert (
                far[mode.arrows].max() == pytest.approx(far.max(), rel=1e-3)
                and far[mode.arrows].min() > 0.5 * far.max()
            )
            lengths = [np.linalg.norm(line[1] - line[0]) for line in arrows_of(mode, corners) if len(line) == 2]
            np.testing.assert_allclose(lengths, far[mode.arrows])


def test_a_mode_says_which_frame_moves_most_and_how_far() -> None:
    found = shown("two_axis.toml")
    (held, _) = found.modes
    assert held.modal is not None
    names = [joint.name for joint in machine("two_axis.toml").joints]
    for mode in modes_data(held, found.figure)["modes"]:
        there, back = (found.placements.at(found.q + sense * 1e-6 * np.array(mode["shape"]))[1:] for sense in (1, -1))
        moved = np.linalg.norm(there[:, :3, 3] - back[:, :3, 3], axis=1) / 2e-6
        assert mode["most"]["unit"] == "m" and mode["most"]["far"] == pytest.approx(moved.max(), rel=1e-7)
        assert moved[names.index(mode["most"]["frame"])] == pytest.approx(moved.max(), rel=1e-7)


def test_texts_are_read_on_light_and_dark_paper() -> None:
    """Contrast of WCAG 2.2, level AA: 4.5 for texts."""
    css = (template_folder() / "view" / "page.css").read_text(encoding="utf-8")
    light, dark = (dict(re.findall(r"--(\w+): (#\w{6})", block)) for block in css.split("color-scheme: dark", 1))
    for colours in (light, dark):
        for text, paper in (
            ("ink", "paper"),
            ("ink", "soft"),
            ("faint", "panel"),
            ("faint", "paper"),
            ("warm", "paper"),
            ("panel", "accent"),
        ):
            assert contrast(colours[text], colours[paper]) >= 4.5, (text, paper)


def contrast(one: str, other: str) -> float:
    def luminance(colour: str) -> float:
        parts = np.array([int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5)])
        linear = np.where(parts <= 0.04045, parts / 12.92, ((parts + 0.055) / 1.055) ** 2.4)
        return float(linear @ (0.2126, 0.7152, 0.0722))

    low, high = sorted((luminance(one), luminance(other)))
    return (high + 0.05) / (low + 0.05)


def test_a_page_inside_a_notebook_runs_its_own_scripts_only() -> None:
    found = symoro_elastic.view(EXAMPLES / "planar_2r.toml")
    (frame,) = Elements(found._repr_html_()).elements
    assert frame[0] == "iframe" and frame[1]["srcdoc"] == found.html
    assert frame[1]["sandbox"] == "allow-scripts allow-downloads"


@pytest.mark.thorough
def test_machines_are_shown_beside_each_other(tmp_path: Path) -> None:
    """Scripts of both are in the policy of the page, which frames inherit."""
    one, other = (symoro_elastic.view(EXAMPLES / name) for name in ("planar_2r.toml", "gantry.toml"))
    both = one.beside(other)
    frames = [found for tag, found in Elements(both.html).elements if tag == "iframe"]
    assert [found["srcdoc"] for found in frames] == [one.html, other.html]
    policies = [re.search(r'Policy" content="([^"]*)"', page)[1] for page in (both.html, one.html, other.html)]
    whole, *inner = ({*re.findall(r"'sha256-[^']+'", policy)} for policy in policies)
    assert all(digests <= whole for digests in inner)
    assert repr(both) == "<Page of planar_2r and gantry: 0 motions>"
    run("view", EXAMPLES / "planar_2r.toml", "--beside", EXAMPLES / "gantry.toml", "--out", tmp_path / "both.html")
    assert (tmp_path / "both.html").read_text(encoding="utf-8") == both.html


@pytest.mark.thorough
def test_machines_without_values_or_springs_have_no_modes_and_say_so_where_they_could() -> None:
    assert shown("palletizer.toml").modes == [] and shown("palletizer.toml").remarks == ()
    assert shown("rx90.par").modes == () and "XX1 has no value" in shown("rx90.par").missing[0]


def test_sliders_are_those_of_the_motors_and_of_all_other_joints() -> None:
    joints = data(page("two_axis.toml"))["joints"]
    assert [joint["name"] for joint in joints if joint["motor"]] == ["motor_x", "motor_y"]
    assert [joint["frame"] for joint in joints] == list(machine("two_axis.toml").independent)
    assert all(joint["low"] < 0 < joint["high"] for joint in joints)


def test_sliders_take_the_limits_of_positions_and_hold_the_position_that_is_shown() -> None:
    """At 0.2 m the slide is within its limits, at 0.5 m beyond; a joint without them has a slider all the same."""
    whole = machine("all_keys.toml")
    for at, most in ((0.2, 0.4), (0.5, 0.5)):
        joints = {one["name"]: one for one in data(machine_page(shown_machine(whole, {"slide": at})))["joints"]}
        assert (joints["slide"]["low"], joints["slide"]["high"]) == (0.0, most)
        assert joints["table"]["high"] == -joints["table"]["low"] == pytest.approx(170 * np.pi / 180, rel=1e-14)
        assert joints["shoulder"]["low"] < joints["shoulder"]["high"]


@pytest.mark.skipif(not COMPILERS, reason="needs a C compiler")
def test_motions_are_played_as_simulated() -> None:
    """Reference and deviation add to the simulated motion at the times shown, to the 8 digits that are written."""
    from symoro_elastic.analysis.simulation.reference_motion import reference_of
    from symoro_elastic.analysis.simulation.simulate import Request, simulate
    from symoro_elastic.formats.toml.motions import read_motions

    found = machine("planar_2r.toml")
    (motion,) = read_motions(EXAMPLES / "scenes" / "planar_2r_move.toml", found)
    simulation = simulate(reference_of(found, motion), Request(step=0.001))
    (played,) = motions_data([simulated_motion(simulation)])
    assert played["t"][0] == 0 and played["t"][-1] == pytest.approx(0.4)
    kept = np.searchsorted(simulation.motion.t, np.array(played["t"]) - 1e-9)
    q = np.array(played["reference"]) + np.array(played["deviation"])
    np.testing.assert_allclose(q, simulation.motion.q[kept], rtol=0, atol=1.1e-8)


def test_a_floating_base_is_played_where_it_is() -> None:
    """Coordinates of a base from its position and quaternion put its frame there, turned as the rotation of scipy."""
    Rotation = pytest.importorskip("scipy.spatial.transform").Rotation
    found = placements_of(machine("floating_arm.toml"))
    rng = np.random.default_rng(4)
    turned = Rotation.from_rotvec(rng.uniform(-1, 1, (5, 3)))
    base = {"P0": rng.normal(size=(5, 3)), "Q0": np.roll(turned.as_quat(), 1, axis=1)}
    frame = [joint.name for joint in found.machine.joints].index("base") + 1
    for k, q in enumerate(with_base(np.zeros((5, 2)), State(base))):
        T = found.at(q)[frame]
        np.testing.assert_allclose(T[:3, :3], turned[k].as_matrix(), atol=1e-14)
        np.testing.assert_allclose(T[:3, 3], base["P0"][k], atol=1e-14)


def test_pages_and_pictures_from_python(tmp_path: Path) -> None:
    page = symoro_elastic.view(EXAMPLES / "planar_2r.toml", at={"elbow": 0.5})
    assert repr(page) == "<Page of planar_2r: 0 motions>" and page.remarks == ()
    assert page.write(tmp_path / "a.html").read_text(encoding="utf-8") == page.html
    drawn = symoro_elastic.picture(EXAMPLES / "rx90.par", at={"th2": 0.5})
    assert repr(drawn) == "<Picture of rx90>" and drawn._repr_html_() == drawn.svg and len(drawn.remarks) == 2
    assert drawn.write(tmp_path / "a.svg").read_text(encoding="utf-8") == drawn.svg
    with pytest.raises(InputError, match="exists already"):
        page.write(tmp_path / "a.html")


# The command


@pytest.mark.thorough
def test_view_writes_one_page(tmp_path: Path) -> None:
    run("view", EXAMPLES / "gantry.toml", "--out", tmp_path / "gantry.html", "--at", "ram=-0.1")
    text = (tmp_path / "gantry.html").read_text(encoding="utf-8")
    (at,) = (x for x, joint in zip(data(text)["q"], data(text)["joints"], strict=True) if joint["name"] == "ram")
    assert at == -0.1 and [path.name for path in tmp_path.iterdir()] == ["gantry.html"]


def test_what_is_missing_is_said_on_the_page_and_on_standard_error(tmp_path: Path) -> None:
    found = ended("view", EXAMPLES / "rx90.par", "--out", tmp_path / "rx90.html")
    assert found.code == 0 and "note: not to scale: D3, RL4 without value" in found.err
    assert "note: no modes: parameters: XX1 has no value" in found.err
    remarks = data((tmp_path / "rx90.html").read_text(encoding="utf-8"))["remarks"]
    assert [line.split(":")[0] for line in remarks] == [
        "not to scale",
        "bodies without usable values are not drawn",
        "no modes",
    ]


def test_positions_that_cannot_be_are_refused_and_nothing_is_written(tmp_path: Path) -> None:
    out = tmp_path / "a.html"
    assert "no moving joint 'knee'" in refused("view", EXAMPLES / "planar_2r.toml", "--out", out, "--at", "knee=1")
    assert "guide does not move by itself" in refused("view", EXAMPLES / "gantry.toml", "--out", out, "--at", "guide=1")
    assert "missing" in refused("view", tmp_path / "none.toml", "--out", out) or not out.exists()
    assert list(tmp_path.iterdir()) == []
