"""What scripts of the page compute is what Python computes: frames, springs, labels. Needs node."""

from __future__ import annotations

import json
import shutil
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from symoro_elastic.codegen.javascript import javascript_function
from symoro_elastic.codegen.templates import template_folder
from symoro_elastic.formats import read_machine
from symoro_elastic.machine.machine import Kind
from symoro_elastic.models.programs.catalogue import trace
from symoro_elastic.pages.drawing.figure import Placements, figure_of, placements_of
from symoro_elastic.pages.drawing.page import page_data, shown_machine
from symoro_elastic.pages.drawing.shapes import bend, inverse, slip
from tests.command_line import EXAMPLES

pytestmark = pytest.mark.sampled(5)

NODE = shutil.which("node")
needs_node = pytest.mark.skipif(NODE is None, reason="needs node")
CLOSED = Path(__file__).parents[2] / "closed_chains" / "machines"
MACHINES = {
    "two_axis": EXAMPLES / "two_axis.toml",
    "sr400": EXAMPLES / "sr400.par",
    "gantry": EXAMPLES / "gantry.toml",
    "floating_arm": EXAMPLES / "floating_arm.toml",
    "ring_with_slide": CLOSED / "ring_with_slide.toml",
}
"""A tree, a parallelogram, a loop in a plane, a floating base, and a loop that is followed."""


def script(*names: str) -> str:
    return "\n".join((template_folder() / "view" / name).read_text(encoding="utf-8") for name in names)


def by_node(text: str, told: Any) -> Any:
    """What a script prints as JSON, given the constant `told`."""
    assert NODE
    whole = f"const told = {json.dumps(told)};\n{text}"
    run = subprocess.run([NODE, "-"], input=whole, capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stderr
    return json.loads(run.stdout)


def programs(found: Placements) -> str:
    text = "\n".join(javascript_function(name, program) for name, program in found.programs.items())
    return f"{text}\nconst programs = {{ {', '.join(found.programs)} }};\n"


def told(found: Placements, positions: np.ndarray) -> dict[str, Any]:
    dependent = found.close_loops(found.start).q_dep
    return {
        "q": found.start.tolist(),
        "dependent": dependent.tolist() or None,
        "antecedents": [0, *found.machine.antecedents],
        "slides": [False, *(joint.sigma == 1 for joint in found.machine.joints)],
        "positions": positions.tolist(),
    }


def positions_of(found: Placements) -> np.ndarray:
    reach = np.where([joint.kind is Kind.ELASTIC for joint in found.machine.independent_joints], 0.02, 0.2)
    return found.start + np.random.default_rng(5).uniform(-1, 1, (4, len(found.start))) * reach


@needs_node
@pytest.mark.parametrize("name", MACHINES)
def test_frames_of_scripts_are_those_of_the_models(name: str) -> None:
    found = placements_of(read_machine(MACHINES[name])[0])
    positions = positions_of(found)
    body = "const frames = new Frames(programs, told);\nconsole.log(JSON.stringify(told.positions.map((q) => "
    body += "frames.at(q).map((T) => [...T]))));"
    seen = np.array(by_node(programs(found) + script("space.js", "frames.js") + body, told(found, positions)))
    expected = np.array([found.at(q) for q in positions])
    assembled = found.close_loops(found.start).q_dep.size
    np.testing.assert_allclose(seen.reshape(expected.shape), expected, atol=1e-11 if assembled else 1e-14)


@needs_node
def test_springs_of_scripts_bend_as_those_of_pictures() -> None:
    found = placements_of(read_machine(MACHINES["two_axis"])[0])
    figure = figure_of(found, found.start)
    (q,) = positions_of(found)[:1]
    T = found.at(q)
    wires = [wire for wire in figure.wires if wire.role == Kind.ELASTIC]
    known = told(found, q[None]) | {
        "wires": [(w.frame, w.points.reshape(-1).tolist(), w.behind.tolist()) for w in wires]
    }
    body = """
    const frames = new Frames(programs, told), T = frames.at(told.positions[0]);
    const points = ([j, points, behind]) => [...bent(points, behind, frames.moved(T, j), frames.slides[j])];
    console.log(JSON.stringify(told.wires.map(points)));
    """
    seen = by_node(programs(found) + script("space.js", "frames.js") + body, known)
    for wire, points in zip(wires, seen, strict=True):
        j, a = wire.frame, figure.antecedents[wire.frame]
        before = inverse(figure.reference[a]) @ figure.reference[j]
        moved = slip(inverse(T[a]) @ T[j], before, figure.slides[j])
        np.testing.assert_allclose(np.reshape(points, (-1, 3)), bend(wire, moved, figure.slides[j]), atol=1e-13)


@pytest.mark.thorough
@needs_node
def test_a_loop_that_cannot_close_is_told() -> None:
    found = placements_of(read_machine(CLOSED / "two_jack_arm.toml")[0])
    names = [joint.name for joint in found.machine.independent_joints]
    away = found.start + np.eye(len(names))[names.index("rod_1")]
    body = """
    const frames = new Frames(programs, told);
    console.log(JSON.stringify(told.positions.map((q) => frames.at(q) === null)));
    """
    text = programs(found) + script("space.js", "frames.js") + body
    assert by_node(text, told(found, np.array([away, found.start]))) == [True, False]


@pytest.mark.thorough
@needs_node
def test_labels_of_scripts_avoid_each_other_and_the_edges() -> None:
    """As many as there is room for; all of a machine of 20 frames of which some are in one point."""
    rng = np.random.default_rng(2)
    points = rng.uniform(150, 450, (15, 2))
    anchors = np.concatenate([points, points[:5]])
    names = [{"x": x, "y": y, "width": 30.0 + 3 * k} for k, (x, y) in enumerate(anchors.tolist())]
    body = """
    const placed = placeLabels(told, 700, 600, 10).map((one) => one && one.box);
    const again = placeLabels(told, 700, 600, 10).map((one) => one && one.box);
    console.log(JSON.stringify([placed, again]));
    """
    placed, again = by_node(script("labels.js") + body, names)
    assert None not in placed and placed == again, "names stay where they are"
    for k, a in enumerate(placed):
        assert a["left"] >= 4 and a["right"] <= 696 and a["top"] >= 4 and a["bottom"] <= 596
        for b in placed[:k]:
            assert (
                a["right"] <= b["left"] or b["right"] <= a["left"] or a["bottom"] <= b["top"] or b["bottom"] <= a["top"]
            )


CANVAS = """
const canvas = { addEventListener() {}, removeEventListener() {}, style: {} };
Object.assign(canvas, { getRootNode: () => canvas, ownerDocument: canvas });
const material = new THREE.LineBasicMaterial(), painted = { fill: () => material, edge: () => material };
const frames = new Frames(programs, told.data), figure = new MachineFigure(told.data, frames, painted);
const corners = () => [...cornersOf(figure.groups)].map(([corner]) => corner);
const eye = new Eye(told.data, canvas, corners, () => {});
"""
SCENES = ("vendor/three.min.js", "space.js", "frames.js", "tubes.js", "figure.js", "camera.js")


@needs_node
@pytest.mark.parametrize("size", [(1000, 900), (390, 420)])
@pytest.mark.parametrize("name", ["two_axis", "gantry"])
def test_all_shapes_are_in_the_window_at_every_pose_and_phase(name: str, size: tuple[int, int]) -> None:
    page = shown_machine(read_machine(MACHINES[name])[0], {})
    data = page_data(page)
    shapes = [mode["shape"] for mode_set in data["modes"] for mode in mode_set["modes"]]
    phases = [page.q + by * np.array(shape) for shape in shapes for by in (-3, -1, 1, 3)]
    poses = [page.q + sense * np.ones(len(page.q)) for sense in (-0.4, 0.4)]
    body = f"""
    Object.assign(eye, {{ width: {size[0]}, height: {size[1]} }});
    eye.look("Home");
    console.log(JSON.stringify(told.positions.map((q) => {{
      figure.place(frames.at(q));
      eye.keep(corners());
      const seen = corners().map((p) => p.project(eye.camera));
      return Math.max(...seen.flatMap(({{ x, y }}) => [Math.abs(x), Math.abs(y)]));
    }})));
    """
    known = {"data": data, "positions": np.array([*phases, *poses]).tolist()}
    farthest = by_node(programs(page.placements) + script(*SCENES) + CANVAS + body, known)
    assert len(farthest) == len(phases) + 2 and max(farthest) <= 1 + 1e-9, "1 is the edge of the window"


@needs_node
def test_names_avoid_the_shapes_of_joints() -> None:
    """A name above a joint has room on the other side of it."""
    shapes = [{"left": -60, "right": 60, "top": -30 - 25 * k, "bottom": 0} for k in range(3)]
    moved = [{edge: x + 300 for edge, x in shape.items()} for shape in shapes]
    body = "console.log(JSON.stringify(placeLabels([told[0]], 600, 600, 10, told[1]).map((one) => one.box)));"
    (box,) = by_node(script("labels.js") + body, [{"x": 300, "y": 300, "width": 40}, moved])
    assert box["top"] >= 300


def test_parameters_that_are_left_are_refused() -> None:
    program = trace(read_machine(EXAMPLES / "planar_2r.toml")[0], "geometric_model").program
    with pytest.raises(ValueError, match="parameters without value: l1"):
        javascript_function("geometric_model", program)


def test_names_are_identifiers_and_no_words_of_the_language() -> None:
    found = placements_of(read_machine(EXAMPLES / "floating_arm.toml")[0])
    text = javascript_function("geometric_model", found.programs["geometric_model"])
    names = [line.split()[1] for line in text.splitlines() if line.strip().startswith("const ")]
    assert len(names) == len(set(names)) > 10 and all(name.isidentifier() for name in names)
