"""What the rows of twists, Jacobians and wrenches say of their frames, axes and equations, tried on numbers."""

from __future__ import annotations

import re
from functools import cache
from typing import Any

import numpy as np
import pytest

import symoro_elastic as se
from symoro_elastic.models.programs.catalogue import MODELS
from symoro_elastic.quantities.quantity import Quantity

Array = np.ndarray
Q, QD, QDD = np.array([0.4, -0.7, 0.5]), np.array([0.8, -1.1, 0.6]), np.array([0.3, 0.9, -0.5])
SPIN, DRIFT = (0.2, -0.4, 0.7), (0.5, 0.1, -0.3)
TURNS = {"velocities": "V", "accelerations": "Vd", "jacobian": "J", "jacobian_dot_qd": "Vd"}
EQUATION = re.compile(r"(\w+) = (.+?) on a base at rest, (?:both|all) in the same axes")
OWN, ZERO = "in the frame's own axes or", "in axes of frame 0 or"
STEP = 1e-4


def arm(moving: bool = False) -> dict[str, Any]:
    """A skew arm of three turns; on a base at rest, or on one whose motion its table gives."""
    angles = ({"alpha": 0.0}, {"alpha": 1.1, "d": 0.3, "r": 0.1}, {"alpha": -0.6, "d": 0.4, "r": -0.2})
    rows = [
        {"name": f"j{k}", "antecedent": k - 1, "kind": "motor", "sigma": 0, "theta": f"q{k}", **cells}
        for k, cells in enumerate(angles, 1)
    ]
    rows.append({"name": "tool", "antecedent": "j3", "kind": "fixed", "alpha": 0.8, "d": 0.2, "r": 0.5})
    bodies = {f"j{k}": {"mass": k, "center_of_mass": [0.1, 0.02 * k, -0.05], "inertia": [1, 2, 2.5]} for k in (1, 2, 3)}
    table = {"name": "arm", "gravity": [1, -3, -9], "joints": rows, "bodies": bodies}
    return {**table, "base": {"velocity": list(DRIFT), "angular_velocity": list(SPIN)}} if moving else table


@cache
def loaded(moving: bool = False) -> Any:
    texts = ("tool", "tool in base", "tool in tool", "tool in j2", "j2")
    models = ("geometric_model", "velocities", "accelerations", "reaction_wrenches")
    models += () if moving else ("jacobian", "jacobian_dot_qd")
    return se.load(arm(moving), *models, only={m: texts for m in models if m != "reaction_wrenches"})


def row_of(model: str) -> Quantity:
    return MODELS[model].quantity(TURNS[model])


def found(model: str, moving: bool = False) -> Array:
    """Of `tool` as it is, in frame 0, in itself, in j2; of j2."""
    arguments = {"velocities": (Q, QD), "accelerations": (Q, QD, QDD), "jacobian": (Q,), "jacobian_dot_qd": (Q, QD)}
    return np.array(getattr(loaded(moving), model)(*arguments[model]))


def placed(q: Array) -> Array:
    """The placement of the tool in frame 0."""
    return np.array(loaded().geometric_model(q)[1])


def turned(R: Array, twist: Array) -> Array:
    return np.concatenate([R @ twist[:3], R @ twist[3:]])


@pytest.mark.parametrize("model", TURNS)
def test_axes_without_a_frame_are_those_that_the_row_says(model: str) -> None:
    said = str(row_of(model).frame)
    assert (OWN in said) != (ZERO in said), said
    as_is, in_base, in_itself = found(model)[:3]
    assert np.array_equal(as_is, in_itself if OWN in said else in_base)
    assert not np.allclose(in_itself, in_base)
    assert np.allclose(turned(placed(Q)[:3, :3], in_itself), in_base, atol=1e-13)


@pytest.mark.parametrize("model", ["jacobian", "jacobian_dot_qd"])
def test_the_equation_of_the_note_holds_in_the_same_axes(model: str) -> None:
    """The sentence is read: names are results of models, others the arguments."""
    equation = EQUATION.fullmatch(str(row_of(model).note))
    assert equation
    for frame in (1, 2, 3):
        values = {name: found(name)[frame] for name in TURNS} | {"qd": QD, "qdd": QDD}
        terms = [[values[name] for name in term.split()] for term in equation[2].split(" + ")]
        right = sum(np.linalg.multi_dot(term) if len(term) > 1 else term[0] for term in terms)
        assert np.allclose(values[equation[1]], right, rtol=0, atol=1e-13)


def test_velocities_are_rates_of_placements() -> None:
    """Central differences of T in frame 0; their error is that of the third derivative, 1e-8 of the step squared."""
    R = placed(Q)[:3, :3]
    rate = (placed(Q + STEP * QD) - placed(Q - STEP * QD)) / (2 * STEP)
    spin = rate[:3, :3] @ R.T
    twist = np.array([*rate[:3, 3], spin[2, 1], spin[0, 2], spin[1, 0]])
    assert np.allclose(found("velocities")[1], twist, rtol=0, atol=3e-8)
    assert np.allclose(found("jacobian")[1] @ QD, twist, rtol=0, atol=3e-8)


def test_the_motion_of_a_base_is_included() -> None:
    """V = J qd + that of the base: its axes are those of frame 0."""
    assert "the motion of a base included" in str(row_of("velocities").frame)
    P = placed(Q)[:3, 3]
    of_base = np.concatenate([np.array(DRIFT) + np.cross(SPIN, P), SPIN])
    moving = found("velocities", moving=True)[1]
    assert np.allclose(moving, found("jacobian")[1] @ QD + of_base, rtol=0, atol=1e-13)


def test_reaction_wrenches_are_in_axes_of_the_frames_of_bodies() -> None:
    """At rest each holds the weight of what it carries, in its frame, about its origin."""
    said = MODELS["reaction_wrenches"].quantity("f")
    assert said.frame == "in axes of the frame of the body" and "about the origin of its frame" in said.meaning
    f = np.array(loaded().reaction_wrenches(Q, 0 * Q, 0 * Q))
    frames = np.array(se.load(arm(), "geometric_model").geometric_model(Q))
    g, centers = np.array([1, -3, -9]), [(k, np.array([0.1, 0.02 * k, -0.05])) for k in (1, 2, 3)]
    for j in range(3):
        R, P = frames[j][:3, :3], frames[j][:3, 3]
        carried = [(m, frames[m - 1][:3, :3] @ c + frames[m - 1][:3, 3]) for m, c in centers[j:]]
        force = -sum(m * g for m, _ in carried)
        moment = -sum(np.cross(x - P, m * g) for m, x in carried)
        assert np.allclose(f[j], turned(R.T, np.concatenate([force, moment])), rtol=0, atol=1e-11)


def test_external_wrenches_are_in_axes_of_frame_0_about_the_origin_of_the_frame() -> None:
    row = MODELS["external_forces"].quantity("f_ext")
    assert row.frame == "in axes of frame 0" and "about the origin" in row.meaning
    model = se.load(arm(), "inverse_dynamics", scene={"forces": ["tool"]})
    wrench = np.array([3.0, -2.0, 5.0, 0.4, -0.6, 0.9])
    with_it, without = (model.inverse_dynamics(Q, QD, QDD, x) for x in (wrench, 0 * wrench))
    tau, tau_0 = (np.asarray(x[0] if isinstance(x, tuple) else x) for x in (with_it, without))
    assert np.allclose(tau - tau_0, -found("jacobian")[1].T @ wrench, rtol=0, atol=1e-12)
