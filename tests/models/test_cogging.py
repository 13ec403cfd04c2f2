"""Cogging of motors: the law by hand, its energy along a motion, its stiffness, and who refuses it."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import symoro_elastic as se
from symoro_elastic.foundation.errors import InputError

A, N, PHASE, RATIO, ROTOR = 0.05, 6.0, 0.3, 10.0, 1e-3


def arm(**motor: Any) -> dict[str, Any]:
    """A motor behind a ratio, with a spring behind it and gravity across its axis."""
    cogging = {"cogging": A, "cogging_order": N, "cogging_phase": PHASE}
    return {
        "name": "arm",
        "gravity": [0, -9.81, 0],
        "joints": [
            {"name": "motor", "kind": "motor", "sigma": 0, "theta": "q1"},
            {"name": "gear", "antecedent": "motor", "kind": "elastic", "sigma": 0, "theta": "q2"},
        ],
        "bodies": {"gear": {"mass": 2.0, "center_of_mass": [0.3, 0, 0], "inertia": [0.01, 0.02, 0.03]}},
        "springs": {"gear": {"stiffness": 300.0}},
        "motors": {"motor": {"rotor_inertia": ROTOR, "ratio": RATIO, **cogging, **motor}},
    }


def torque(q: float) -> float:
    """n A sin(N n q + phi)."""
    return RATIO * A * float(np.sin(N * RATIO * q + PHASE))


def test_models_have_the_torque_of_the_law() -> None:
    """As without cogging, under a torque of the motor that has it added."""
    models = ["direct_dynamics", "inverse_dynamics"]
    q, qd, tau = np.array([0.4, -0.05]), np.array([1.0, 2.0]), np.array([0.7])
    with_it = se.load(arm(), models)
    without = se.load(arm(cogging=0, cogging_order=0, cogging_phase=0), models)
    qdd = with_it.direct_dynamics(q, qd, tau)
    assert qdd == pytest.approx(without.direct_dynamics(q, qd, tau + torque(0.4)), rel=1e-13)
    assert with_it.inverse_dynamics(q, qd, qdd[:1])[0] == pytest.approx(tau, rel=1e-11)


def test_constants_of_the_rotor_are_those_of_the_joint_times_the_ratio() -> None:
    own = arm(rotor_inertia=ROTOR * RATIO**2, ratio=0, cogging=A * RATIO, cogging_order=N * RATIO)
    state = np.array([0.4, -0.05]), np.array([1.0, 2.0]), np.array([0.7])
    found = [se.load(x, ["direct_dynamics"]).direct_dynamics(*state) for x in (arm(), own)]
    assert found[0] == pytest.approx(found[1], rel=1e-13)


def test_stiffness_is_its_slope() -> None:
    model, step = se.load(arm(), ["linearization"]), 1e-6
    q, zero = np.array([0.4, 0.0]), np.zeros(2)
    plain = se.load(arm(cogging=0, cogging_order=0, cogging_phase=0), ["linearization"])
    found = model.linearization(q, zero, zero)[2] - plain.linearization(q, zero, zero)[2]
    slope = -(torque(0.4 + step) - torque(0.4 - step)) / (2 * step)
    assert found == pytest.approx(np.diag([slope, 0]), rel=1e-8, abs=1e-9)


def test_no_energy_is_lost_or_made_along_a_motion() -> None:
    """Kinetic, gravity and elastic energy, that of cogging among it, by Radau."""
    integrate = pytest.importorskip("scipy.integrate")
    model = se.load(arm(), ["direct_dynamics", "energy"])

    def rate(_: float, y: Any) -> Any:
        return np.concatenate([y[2:], model.direct_dynamics(y[:2], y[2:], np.zeros(1))])

    start = np.array([0.3, 0.0, 2.0, -1.0])
    ends = integrate.solve_ivp(rate, (0, 0.5), start, rtol=1e-11, atol=1e-12).y.T
    energies = np.array([model.energy(y[:2], y[2:]).sum() for y in ends])
    potential = RATIO * A / (RATIO * N) * np.cos(N * RATIO * ends[:, 0] + PHASE)
    assert np.abs(energies - energies[0]).max() < 1e-8 < np.ptp(potential) / 1e5


def test_a_motor_that_rests_in_a_notch_swings_there() -> None:
    machine = arm(cogging_phase=np.pi)
    rows = machine["joints"][:1]
    bare = {"name": "rotor", "joints": rows, "motors": {"motor": machine["motors"]["motor"]}}
    found = se.modes(bare).frequencies
    assert found == pytest.approx([np.sqrt(A * N / ROTOR) / (2 * np.pi)], rel=1e-9)


@pytest.mark.parametrize(
    ("motors", "what"),
    [
        ({"motor": {"cogging": 1.0}}, "cogging order.*is missing: give the periods"),
        ({"motor": {"cogging_order": 4}}, "cogging.*is missing, its order is given"),
        ({"gear": {"cogging": 1.0, "cogging_order": 4}}, "only a motor has cogging"),
    ],
)
def test_what_is_no_cogging_is_refused(motors: dict[str, Any], what: str) -> None:
    with pytest.raises(InputError, match=what):
        se.load(arm() | {"motors": motors}, ["direct_dynamics"])


def test_regressors_refuse_it() -> None:
    with pytest.raises(InputError, match="not linear in its order and phase"):
        se.load(arm(), ["regressor"])
