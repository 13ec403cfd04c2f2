"""A joint may be called `base`: frame 0 keeps its name, and the joint is reached as `joint base`."""

from __future__ import annotations

import numpy as np
import pytest

import symoro_elastic as se
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.generation.fmu.programs import asked_frames
from symoro_elastic.machine.resolve import resolve
from symoro_elastic.machine.scene import Scene
from symoro_elastic.models.bound.model import Frame
from symoro_elastic.models.programs.catalogue import MODELS
from symoro_elastic.numerics.motion.signals import FrameSignal, outputs

TURN = 1.2


def arm(name: str) -> dict[str, object]:
    """A motor, a spring and a tool 1 m off; on its first row the name to be tried."""
    first = {"name": name, "antecedent": 0, "kind": "motor", "sigma": 0, "theta": "q1"}
    rows = [
        *(first, {"name": "link", "antecedent": name, "kind": "elastic", "sigma": 0, "theta": "q2", "d": 0.25}),
        {"name": "tool", "antecedent": "link", "kind": "fixed", "d": 1.0},
    ]
    bodies = {
        name: {"mass": 1, "inertia": [0.1] * 3},
        "link": {"mass": 2, "center_of_mass": [0.5, 0, 0], "inertia": [1] * 3},
    }
    springs = {"link": {"stiffness": 1e4, "damping": 10}}
    return {"name": "arm", "gravity": [0, 0, -9.81], "joints": rows, "bodies": bodies, "springs": springs}


def scene(name: str) -> dict[str, object]:
    outputs = ["tool.x", "tool.y", "tool at (0, 0.5, 0).x"]
    motion = {"duration": 0.5, "moves": [{"motor": name, "by": TURN, "in": 0.4}]}
    return {"motion": motion, "wanted": {"outputs": outputs, "tolerance": 1e-4}}


@pytest.fixture(scope="module")
def placements() -> dict[str, Array]:
    """Frames of both arms as requests name them, at q = (0.3, 0.2)."""
    asked = {"turret": ("tool in base", "tool in turret", "base in tool", "turret")}
    asked["base"] = ("tool in base", "tool in joint base", "base in tool", "base")
    found = {}
    for name, texts in asked.items():
        model = se.load(arm(name), "geometric_model", only={"geometric_model": texts})
        found[name] = np.array(model.geometric_model([0.3, 0.2]))
    return found


def test_frame_0_is_not_shadowed(placements: dict[str, Array]) -> None:
    a = 0.5
    assert np.allclose(placements["base"][0][:2, 3], [0.25 * np.cos(0.3) + np.cos(a), 0.25 * np.sin(0.3) + np.sin(a)])
    assert np.array_equal(placements["base"], placements["turret"])


@pytest.mark.parametrize("text", ["tool in 1", "tool in q1", "tool in joint base", "tool in joint  base"])
def test_the_joint_keeps_being_reachable(text: str, placements: dict[str, Array]) -> None:
    model = se.load(arm("base"), "geometric_model", only={"geometric_model": [text]})
    assert np.array_equal(model.geometric_model([0.3, 0.2])[0], placements["turret"][1])


def test_resolved_names_are_read_as_they_were_meant() -> None:
    machine = se.read(arm("base"))
    texts = ("tool in base", "tool in 1", "joint base", "base in joint base", "tool at (1, 0, 0) in q1")
    once = resolve(Scene(outputs={"geometric_model": texts}), machine, MODELS)
    assert once.outputs["geometric_model"] == (
        "tool in base",
        "tool in joint base",
        "base",
        "base in joint base",
        "tool at (1, 0, 0) in joint base",
    )
    assert resolve(once, machine, MODELS) == once


@pytest.mark.thorough
def test_simulated_outputs_do_not_depend_on_the_name_of_a_joint() -> None:
    for options in ({"method": "rk4", "step": 1e-3}, {"adaptive": True}):
        (one,), (other,) = (se.simulate(arm(name), scene(name), **options) for name in ("turret", "base"))
        assert np.array_equal(one.outputs, other.outputs)
        assert abs(one.outputs[-1, 0] - (0.25 + 1) * np.cos(TURN)) < 1e-2


def test_every_reader_of_names_numbers_frames_alike() -> None:
    machine = se.read(arm("base"))
    asked = resolve(Scene(outputs={"geometric_model": ("tool in base", "tool in joint base")}), machine, MODELS)
    assert asked_frames(machine, asked) == (Frame(3, 0), Frame(3, 1))
    latex = se.equations(machine, model="geometric_model", only=asked.outputs)._repr_latex_()
    assert "{}^{0}T_{3" in latex and "{}^{1}T_{3" in latex
    of_joint, named = outputs(machine, ["base.x", "joint base.x"])
    assert isinstance(of_joint, FrameSignal) and isinstance(named, FrameSignal)
    assert of_joint.number == named.number == 1
    floating = se.read(arm("base") | {"base": {"floating": "quaternion", "body": {"mass": 1, "inertia": [1, 1, 1]}}})
    of_base, of_joint = outputs(floating, ["base.x", "joint base.x"])
    assert isinstance(of_base, FrameSignal) and isinstance(of_joint, FrameSignal)
    assert (of_base.number, of_joint.number) == (0, 1)


def test_an_unknown_frame_is_refused_with_those_that_there_are() -> None:
    with pytest.raises(se.InputError, match="no frame 'bass'; did you mean 'base'"):
        se.load(arm("turret"), "geometric_model", only={"geometric_model": ["tool in bass"]})


def floating_arm(name: str) -> dict[str, object]:
    body = {"mass": 20, "center_of_mass": [0, 0, 0.1], "inertia": [1, 2, 3]}
    return arm(name) | {"base": {"floating": "rotation", "body": body}}


def test_on_a_base_that_floats_small_motions_are_those_of_another_name() -> None:
    """`base.x` and `base.fx` are of the base, `base.q` and `base.tau` of the joint, `joint base.wz` of its frame."""
    found = [
        se.linearize(
            floating_arm(name),
            hover=True,
            inputs=["base.fx", f"joint {name}.fy", f"{name}.tau"],
            outputs=["base.x", "base.wz", f"joint {name}.wz", f"{name}.q"],
        )
        for name in ("turret", "base")
    ]
    one, other = found
    for key in ("M", "D", "K", "F", "Cq", "Cv"):
        assert np.array_equal(getattr(one, key), getattr(other, key))
    assert not np.array_equal(other.Cv[1], other.Cv[2])


@pytest.mark.thorough
def test_modes_and_thrusts_on_such_a_base_too() -> None:
    first, second = (se.modes(floating_arm(name), hold=["all"], hover=True) for name in ("turret", "base"))
    assert np.array_equal(first.frequencies, second.frequencies)
    thrusts = {"base.fz": None, "base.mx": None, "base.my": None}
    one, other = (se.linearize(floating_arm(name), hold=["all"], thrusts=thrusts) for name in ("turret", "base"))
    assert np.array_equal(one.K, other.K) and np.abs(one.K).max() > 0
