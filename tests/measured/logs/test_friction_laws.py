"""Friction that rises with load, falls with velocity, and changes from record to record: simulated with known truth."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

pytest.importorskip("scipy")

import symoro_elastic as se
from symoro_elastic.analysis.time_series.measurements import Measurements
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.measured.logs.fourier_motion import random_motion
from symoro_elastic.measured.logs.friction_laws import FrictionLaws
from symoro_elastic.measured.logs.identified import Identified
from symoro_elastic.measured.logs.identify import LogSettings, identify
from symoro_elastic.numerics.linear.regressor import regressor
from symoro_elastic.numerics.verification.implementations import numpy_model
from tests.benchmarks.logs import LOAD, Draw, arm
from tests.benchmarks.sensors import three_axis

RATE, SECONDS = 500.0, 8.0
DRY, VISCOUS = np.array([2.0, 2.0, 0.5]), np.array([3.0, 3.0, 1.0])
JOINTS = ("turn", "lift", "wrist")


@cache
def record(
    seed: int, load: float = 0.0, static: float = 0.0, warm: float = 1.0, link_side: bool = False
) -> dict[str, Array]:
    """Return a record of the arm; the torque that passes is that of the model without friction and rotors."""
    arm = three_axis()
    rng, motion = np.random.default_rng(seed), random_motion(arm.limits, 0.2, 8, seed)
    t = np.arange(round(SECONDS * RATE)) / RATE
    q, qd, qdd = motion.at(t)
    whole = np.array(arm.model.inverse_dynamics(q, qd, qdd)[0])
    rotors = np.array([c.value for c in arm.regressor.columns if c.quantity == "IA"])
    passing = whole - DRY * np.sign(qd) - VISCOUS * qd - rotors * qdd
    more = load * np.abs(passing) + static / (1 + (qd / 0.3) ** 2) + (warm - 1) * DRY
    tau = passing if link_side else whole + more * np.sign(qd) + (warm - 1) * VISCOUS * qd
    tau = tau + arm.noise * rng.standard_normal(tau.shape)
    step = 2 * np.pi / 2**17
    columns = {"t": t, **{f"q_{name}": np.round(x / step) * step for name, x in zip(JOINTS, q.T, strict=True)}}
    return columns | {f"tau_{name}": x for name, x in zip(JOINTS, tau.T, strict=True)}


def error(found: Identified) -> float:
    assert found.validation is not None
    return float(np.mean(list(found.validation.percent.values())))


def within(found: Identified, label: str, truth: float, deviations: float = 3.0) -> bool:
    e = found.found.estimation[label]
    return abs(e.value - truth) < deviations * e.std


@pytest.mark.thorough
def test_load_friction_is_found_and_saved() -> None:
    machine = three_axis().machine
    plain = se.identify(machine, record(1, load=0.08), validate=record(2, load=0.08))
    found = se.identify(machine, record(1, load=0.08), validate=record(2, load=0.08), load_friction=["all"])
    assert all(within(found, f"FL{j}", 0.08) for j in (1, 2, 3))
    assert error(found) < 0.5 * error(plain)
    assert any(note.startswith("load friction: residuals") for note in found.found.notes)
    fitted, _ = found.saved()
    assert float(fitted.joint(2).friction.load.value({})) == found.estimates["FL2"]


@pytest.mark.thorough
def test_no_load_friction_loses_nothing() -> None:
    machine = three_axis().machine
    plain = se.identify(machine, record(1), validate=record(2))
    found = se.identify(machine, record(1), validate=record(2), load_friction=["all"])
    assert all(within(found, f"FL{j}", 0.0, 2.5) for j in (1, 2, 3))
    assert error(found) < error(plain) + 0.1


@pytest.mark.thorough
def test_stribeck() -> None:
    machine = three_axis().machine
    found = se.identify(machine, record(1, static=0.6), stribeck=dict.fromkeys(JOINTS, 0.3))
    assert all(within(found, f"FB{j}", 0.6) for j in (1, 2, 3))
    fitted, _ = found.saved()
    law = fitted.joint(1).friction
    static, coulomb = float(law.static.value({})), float(law.coulomb.value({}))
    assert static - coulomb == pytest.approx(found.estimates["FB1"]) and float(law.stribeck.value({})) == 0.3


@pytest.mark.thorough
def test_two_temperatures() -> None:
    machine = three_axis().machine
    cold, warm = record(1), record(3, warm=0.7)
    found = se.identify(machine, [cold, warm], temperatures=True)
    for j, dry, viscous in zip((1, 2, 3), DRY, VISCOUS, strict=True):
        assert within(found, f"FS{j}", dry) and within(found, f"FS{j}_2", -0.3 * dry)
        assert within(found, f"FV{j}", viscous) and within(found, f"FV{j}_2", -0.3 * viscous)


@pytest.mark.thorough
def test_torques_behind_transmissions_keep_rotors_of_the_file() -> None:
    machine = three_axis().machine
    found = se.identify(machine, record(1, link_side=True), link_side=["all"])
    assert not {"IA3", "FV1", "FS1"} & set(found.estimates)
    fitted, _ = found.saved()
    for before, after in zip(machine.motor_joints, fitted.motor_joints, strict=True):
        assert after.rotor_inertia == before.rotor_inertia and after.friction == before.friction


@pytest.mark.thorough
def test_possible_bodies_have_laws_of_friction() -> None:
    machine = three_axis().machine
    found = se.identify(machine, record(1, load=0.08), load_friction=["all"], possible=True)
    assert all(within(found, f"FL{j}", 0.08) for j in (1, 2, 3)) and not found.saved()[0].is_grouped


@pytest.mark.thorough
def test_what_no_friction_has_is_not_saved_and_said() -> None:
    found = se.identify(three_axis().machine, record(1, load=-0.05), load_friction=["turn"])
    fitted, lines = found.saved()
    assert any(line.startswith("FL1 = -0.0") and "not saved" in line for line in lines)
    assert fitted.joint(1).friction.load.is_zero


def test_unknown_motors_are_refused() -> None:
    machine = three_axis().machine
    with pytest.raises(InputError, match="load_friction"):
        se.identify(machine, record(1), load_friction=["elbow"])
    with pytest.raises(InputError, match="above 0"):
        se.identify(machine, record(1), stribeck={"turn": 0.0})


@pytest.mark.thorough
@pytest.mark.parametrize("known", [(), ("MX1",)])
def test_load_friction_is_exact_without_noise(known: tuple[str, ...]) -> None:
    """Of a motion whose gravity is hardly told from an offset: FS1 was 30 standard deviations off. Rotors of the file
    and what is known pass the transmission, too, but are not sought."""
    draw, machine = Draw(18), arm()
    q, qd, qdd = draw.exact
    whole = np.array(numpy_model(machine, ("inverse_dynamics",)).inverse_dynamics(q, qd, qdd)[0])
    record = Measurements(draw.t, q, whole + LOAD * np.abs(draw.bodies) * np.sign(qd), qd, qdd)
    given = {x.label: x.value for x in regressor(machine).columns if x.label in known}
    found = identify(
        machine, record, LogSettings(laws=FrictionLaws(load=(1, 2)), known=given, filtered=False, delay="never")
    )
    for e in found.estimates:
        truth = {"FL": LOAD, "OFF": 0.0}.get(e.unknown.quantity, e.unknown.nominal)
        assert e.value == pytest.approx(truth, abs=1e-6), e.unknown.label
    np.testing.assert_allclose(found.tau - found.estimation.solution.predicted, 0.0, atol=1e-5)


@pytest.mark.thorough
def test_load_friction_that_does_not_settle_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("symoro_elastic.measured.logs.friction_laws.ROUNDS", 1)
    found = se.identify(three_axis().machine, record(1, load=0.08), load_friction=["all"])
    assert any("load friction: not settled after 1 steps" in note for note in found.found.notes)
