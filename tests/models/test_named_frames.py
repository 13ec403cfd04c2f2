"""Frames without a row are what fixed rows are, wherever a frame is named."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import symoro_elastic as se
from symoro_elastic.formats.toml import reading as toml
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.described import DescribedMachine
from symoro_elastic.machine.frames import FrameNames
from symoro_elastic.numerics.verification.implementations import numpy_model

ARM = """
name = "arm"
gravity = [0.3, -0.2, -9.81]
joints = [
  { name = "waist",    kind = "motor", antecedent = 0, sigma = 0, theta = "q1" },
  { name = "shoulder", kind = "motor", sigma = 0, alpha = "-pi/2", theta = "q2" },
  { name = "elbow",    kind = "motor", sigma = 0, d = 0.4, theta = "q3" },
  { name = "roll",     kind = "motor", sigma = 0, alpha = "-pi/2", r = 0.35, theta = "q4" },
  { name = "bend",     kind = "motor", sigma = 0, alpha = "pi/2", theta = "q5" },
  { name = "turn",     kind = "motor", sigma = 0, alpha = "-pi/2", theta = "q6" },
"""
ROW = """
  { name = "tool", kind = "fixed", sigma = 2, gamma = 0.3, b = 0.1, alpha = 0.4, d = 0.05, theta = -0.7, r = 0.2 },
"""
BODIES = """]
[bodies]
shoulder = { mass = 4, center_of_mass = [0.2, 0.01, 0.02], inertia = [0.1, 0.2, 0.2] }
elbow    = { mass = 3, center_of_mass = [0.0, 0.1, 0.02], inertia = [0.1, 0.2, 0.15] }
turn     = { mass = 1, center_of_mass = [0.01, 0.02, 0.05], inertia = [0.01, 0.02, 0.015] }
"""
Q = np.array([0.3, -0.8, 1.1, 0.4, 0.7, -0.2])
RATES = {"qd": 0.5 - Q, "qdd": Q * Q - 0.3}
EXACT = 1e-13


def with_row() -> DescribedMachine:
    return toml.read(ARM + ROW + BODIES, "arm.toml")


def with_frame() -> DescribedMachine:
    """The same with the tool as a frame, its placement in roll, pitch and yaw by the arm with the row."""
    bare = toml.read(ARM + BODIES, "arm.toml")
    placed = numpy_model(with_row(), ("geometric_model",), {"geometric_model": ("tool in turn",)}).geometric_model(Q)[0]
    pitch = -np.arcsin(placed[2, 0])
    rpy = [np.arctan2(placed[2, 1], placed[2, 2]), pitch, np.arctan2(placed[1, 0], placed[0, 0])]
    entry = f'[frames]\ntool = {{ on = "turn", at = {placed[:3, 3].tolist()}, rpy = {[float(x) for x in rpy]} }}\n'
    made = toml.read(ARM + BODIES + entry, "arm.toml")
    assert [row.name for row in made.joints] == [row.name for row in bare.joints]
    return made


MODELS = {
    "geometric_model": ("tool", "tool in elbow", "elbow in tool", "tool at (0.1, -0.2, 0.3)"),
    "velocities": ("tool", "tool in elbow", "elbow in tool", "tool at (0.1, -0.2, 0.3) in base"),
    "accelerations": ("tool", "tool in elbow", "elbow in tool", "tool at (0.1, -0.2, 0.3) in base"),
    "jacobian": ("tool", "tool in elbow", "elbow in tool", "tool at (0.1, -0.2, 0.3)"),
    "jacobian_dot_qd": ("tool", "tool at (0.1, -0.2, 0.3)"),
}


def called(machine: DescribedMachine, model: str, parts: tuple[str, ...], **more: Any) -> Any:
    function = getattr(numpy_model(machine, (model,), {model: parts}), model)
    names = {"geometric_model": (), "jacobian": (), "velocities": ("qd",), "accelerations": ("qd", "qdd")}
    rates = {name: RATES[name] for name in names.get(model, ("qd",))}
    return function(Q, **rates, **more)


@pytest.mark.parametrize("model", MODELS)
def test_a_frame_without_a_row_is_a_fixed_row(model: str) -> None:
    wanted, found = (called(machine, model, MODELS[model]) for machine in (with_row(), with_frame()))
    assert found == pytest.approx(wanted, rel=0, abs=EXACT)


def test_reaction_wrenches_are_about_its_origin_in_its_axes() -> None:
    """The wrench on the last body, as the body of the row `turn` has it, moved by hand."""
    machine = with_frame()
    model = numpy_model(machine, ("reaction_wrenches",), {"reaction_wrenches": ("turn", "tool")})
    of_row, of_tool = model.reaction_wrenches(Q, **RATES)
    placed = called(machine, "geometric_model", ("tool in turn",))[0]
    force, moment = of_row[:3], of_row[3:] - np.cross(placed[:3, 3], of_row[:3])
    assert of_tool == pytest.approx(np.concatenate([placed[:3, :3].T @ force, placed[:3, :3].T @ moment]), abs=EXACT)


@pytest.mark.sampled(3)
@pytest.mark.parametrize("model", ["inverse_geometric_model", "inverse_position_model"])
@pytest.mark.parametrize("part", ["tool", "tool in waist", "tool in camera"])
def test_inverse_geometry_places_it(model: str, part: str) -> None:
    """Each solution gives the frame the placement that it had; `camera` stands on the base."""
    camera = toml.read(ARM + BODIES + "[frames]\ncamera = { at = [1, 0.2, 0.3], rpy = [0.1, 0.2, 0.3] }\n", "arm.toml")
    machine = replace(with_frame(), frames=(*with_frame().frames, *camera.frames))
    locked = {"waist": 0.3} if "waist" in part else {}
    scene = {"locked": {**locked, **({"roll": 0.4, "bend": 0.7, "turn": -0.2} if "position" in model else {})}}
    forward = se.load(machine, "geometric_model", only={"geometric_model": [part]}, scene=scene)
    free = [joint.name not in scene["locked"] for joint in machine.joints]
    if sum(free) < 6 and "position" not in model:
        pytest.skip("five joints place a frame only where it is by chance")
    if sum(free) < 3:
        pytest.skip("two joints bring a point only where it is by chance")
    target = forward.geometric_model(Q[free])[0]
    inverse = se.load(machine, model, only={model: [part]}, scene=scene)
    solutions, _ = getattr(inverse, model)(target if "position" not in model else target[:3, 3])
    reached = [forward.geometric_model(q)[0] for q in solutions if np.isfinite(q).all()]
    assert reached
    for placed in reached:
        compared = slice(None) if "position" not in model else (slice(3), 3)
        assert placed[compared] == pytest.approx(target[compared], abs=1e-11)


def test_inverse_velocities_move_it() -> None:
    wanted, found = (
        numpy_model(machine, ("inverse_velocity_model",), {"inverse_velocity_model": ("tool",)}).inverse_velocity_model(
            Q, [0.1, -0.2, 0.3, 0.4, 0.2, -0.1]
        )
        for machine in (with_row(), with_frame())
    )
    assert found == pytest.approx(wanted, rel=1e-10)


def test_wrenches_act_on_it() -> None:
    """In motion, and as inputs and outputs of linear models."""
    scene = {"forces": ["tool", "tool at (0.1, 0, 0.2)"]}
    f_ext = np.array([[1.0, 2, 3, 0.4, 0.5, 0.6], [0.3, -0.5, 2, 1, 0.2, -0.1]])
    found = []
    for machine in (with_row(), with_frame()):
        model = se.load(machine, "inverse_dynamics", scene=scene)
        found.append(model.inverse_dynamics(Q, RATES["qd"], RATES["qdd"], f_ext.ravel())[0])
    assert found[1] == pytest.approx(found[0], abs=1e-12)
    at = dict(zip((joint.name for joint in with_row().independent_joints), Q.tolist(), strict=True))
    signals = {"inputs": ["tool.fx", "tool.mz"], "outputs": ["tool.y", "tool.vx", "tool.az", "tool at (0.1, 0, 0).rx"]}
    linear = [se.linearize(machine, at=at, **signals) for machine in (with_row(), with_frame())]
    for name in ("F", "Cq", "Cv", "Ca"):
        assert getattr(linear[1], name) == pytest.approx(getattr(linear[0], name), abs=1e-10)


@pytest.mark.thorough
def test_the_reference_in_many_digits_places_it() -> None:
    assert se.check(with_frame(), "geometric_model", "jacobian", "accelerations").ok


def test_default_frames_are_rows_then_those_without_a_row() -> None:
    assert se.load(with_frame(), "geometric_model").FRAMES[-2:] == ("turn", "tool")
    assert se.load(with_frame(), "inverse_dynamics", "inverse_geometric_model").FRAMES[-1] == "tool"


# Names

NAMED = """[frames]
elbow = { on = "elbow", at = [0, 0, 0.1] }
"link waist" = { on = "turn", at = [0, 0, 0.2] }
"joint waist" = { on = "waist", at = [0, 0, 0.3] }
"""


def test_a_frame_of_the_name_of_a_joint_stands_for_its_row() -> None:
    machine = toml.read(ARM + BODIES + NAMED, "arm.toml")
    names = FrameNames(machine)
    for text in ("elbow", "joint elbow", "link elbow"):
        assert names.number(text) == 7
    assert names.number("row elbow") == 3 and names.name(3) == "row elbow" and names.name(7) == "elbow"
    assert names.number("waist") is None and names.number("row waist") == 1
    assert [names.number(text) for text in ("link waist", "joint waist")] == [8, 9]
    assert FrameNames(machine, by_any_name=True).number("q3") == 7
    T = numpy_model(machine, ("geometric_model",), {"geometric_model": ("elbow in row elbow",)}).geometric_model(Q)
    assert T[0, :3, 3] == pytest.approx([0, 0, 0.1], abs=1e-16)


@pytest.mark.parametrize(
    ("entry", "message"),
    [
        ('tip = { on = "wrist" }', "frame 'tip', on: no joint 'wrist'"),
        ('elbow = { on = "turn" }', "frame 'elbow': the frame of joint elbow, whose body does not carry it"),
        ("base = { at = [0, 0, 1] }", "frame 'base': frame 0 has this name"),
        ('"bad name" = { on = "turn" }', "frame 'bad name': the name 'bad name' cannot be used"),
        ('tip = { on = "turn", at = [1, 2] }', "frame tip, at: has 2 entries, expected 3"),
        ('tip = { on = "turn", at = [0, 0, "Lx"] }', "frame tip, at z: 'Lx' is not declared"),
        ('tip = { in = "turn" }', "frame tip, in: no such key here"),
    ],
)
def test_wrong_frames_are_refused_by_their_names(entry: str, message: str) -> None:
    from symoro_elastic.machine.checks import check

    with pytest.raises(InputError, match=r"arm\.toml: ") as caught:
        check(toml.read(f"{ARM}{BODIES}[frames]\n{entry}\n", "arm.toml"))
    assert message in str(caught.value)


def test_a_wrench_on_frame_0_is_refused() -> None:
    machine = toml.read(ARM + BODIES + "[frames]\ncamera = { at = [1, 0, 0] }\n", "arm.toml")
    with pytest.raises(InputError, match="camera is fixed to frame 0, where a force moves nothing"):
        se.load(machine, "inverse_dynamics", scene={"forces": ["camera"]})
