"""Identification: data files, filters, least squares, verdicts, exciting motions, pictures."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

pytest.importorskip("scipy")

from symoro_elastic.analysis.simulation.simulated_measurements import Controller, Sensors, measure, simulate
from symoro_elastic.analysis.time_series.measurements import (
    Measurements,
    check,
    from_columns,
    read_measurements,
    write_measurements,
)
from symoro_elastic.formats import read_machine
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.output_files import permission
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import Body, Friction, Kind, Machine, Parameter, Spring
from symoro_elastic.measured.fitting.estimates import Unknown, Verdict
from symoro_elastic.measured.logs.estimation import LinearModel, estimate, solve
from symoro_elastic.measured.logs.excitation import Condition, ExcitationSettings, Response, excite
from symoro_elastic.measured.logs.filtering import (
    Filter,
    average,
    bandwidth_of,
    default_filter,
    differentiate,
    filtered_motion,
    smooth,
)
from symoro_elastic.measured.logs.fourier_motion import Limits, random_motion, within
from symoro_elastic.measured.logs.identified import machine_with_estimates, without_negatives
from symoro_elastic.measured.logs.identify import LogSettings, identify
from symoro_elastic.measured.logs.noise import RowNoise
from symoro_elastic.measured.logs.result import Identification
from symoro_elastic.measured.logs.views import table
from symoro_elastic.numerics.linear.independence import independent_columns
from symoro_elastic.numerics.linear.regressor import RegressorColumn, regressor
from symoro_elastic.numerics.verification.implementations import numpy_model
from tests.references.random_machines import with_springs_beside_motors

EXAMPLES = Path(__file__).parents[3] / "examples"
LIMITS = Limits.of([-1.5, -1.5], [1.5, 1.5], [3, 4], [15, 25])


@pytest.fixture(scope="module")
def arm() -> Machine:
    """The planar arm, with friction."""
    machine, _ = read_machine(EXAMPLES / "planar_2r.toml")
    lossy = [
        replace(joint, friction=Friction(Formula.parse(0.3), Formula.parse(0.2))) if joint.sigma != 2 else joint
        for joint in machine.joints
    ]
    return replace(machine, joints=tuple(lossy))


@pytest.fixture(scope="module")
def elastic() -> Machine:
    """The planar arm with a spring for an elbow."""
    machine, _ = read_machine(EXAMPLES / "planar_2r.toml")
    spring = Spring(Formula.parse(40), Formula.parse(0.05), Formula.parse(0.1))
    joints = list(machine.joints)
    joints[0] = replace(joints[0], friction=Friction(Formula.parse(0.3)))
    joints[1] = replace(joints[1], kind=Kind.ELASTIC, spring=spring)
    return replace(machine, joints=tuple(joints))


def exact(machine: Machine, seed: int = 0, count: int = 600, still: tuple[int, ...] = ()) -> Measurements:
    """Rigid motion without noise, of the right torques: positions, velocities, accelerations, torques."""
    t = np.arange(count) / 100
    q, qd, qdd = random_motion(LIMITS, 0.25, 4, seed).at(t)
    q[:, still], qd[:, still], qdd[:, still] = 0.3, 0.0, 0.0
    model = numpy_model(machine, ("inverse_dynamics",))
    tau = model.inverse_dynamics(q, qd, qdd)[0]
    return Measurements(t, q, tau, qd, qdd)


def nominal(found: Identification) -> dict[str, float]:
    return {e.unknown.label: e.unknown.nominal for e in found.estimates}


# The regressor


@pytest.mark.sampled(5)
@pytest.mark.parametrize("name", ["flex4.par", "two_axis.toml", "puma560.par"])
def test_regressor_times_parameters_is_the_rigid_inverse_model(name: str) -> None:
    machine, _ = read_machine(EXAMPLES / name)
    values = {p.name: p.value.value() if p.value else 0.1 + k % 7 for k, p in enumerate(machine.parameters)}
    Y = regressor(machine, values)
    X = np.array([column.value for column in Y.columns])
    n = len(machine.independent)
    q, qd, qdd = np.random.default_rng(0).uniform(-1, 1, (3, 20, n))
    model = numpy_model(machine, ("inertia_matrix", "bias_forces"))
    p = model.parameters(**values)
    wanted = np.einsum("tij,tj->ti", model.inertia_matrix(q, p), qdd) + model.bias_forces(q, qd, p)
    joints = [machine.joints[j - 1] for j in machine.independent]
    for k, joint in enumerate(joints):
        if joint.kind is Kind.ELASTIC:
            wanted[:, k] += joint.spring.stiffness.value(values) * q[:, k]
    np.testing.assert_allclose(
        Y.evaluate(q, qd, qdd, range(len(X))) @ X, wanted, rtol=1e-9, atol=1e-9 * abs(wanted).max()
    )


@pytest.mark.parametrize("sprung", [False, True])
def test_two_ways_to_the_regressor_agree(elastic: Machine, sprung: bool) -> None:
    machine = with_springs_beside_motors(elastic) if sprung else elastic
    values = {p.name: p.value.value() for p in machine.parameters if p.value}
    Y, X = regressor(machine, values), np.random.default_rng(2).uniform(0.5, 1.5, 100)
    state = np.random.default_rng(1).uniform(-1, 1, (3, 20, 2))
    chosen = range(len(Y.columns))
    by_dynamics = Y.torques(*state, chosen, X[: len(chosen)])
    np.testing.assert_allclose(Y.evaluate(*state, chosen) @ X[: len(chosen)], by_dynamics, atol=1e-12)


@pytest.mark.sampled(2)
@pytest.mark.parametrize(("name", "inertial"), [("planar_2r.toml", 7), ("rx90.par", 40), ("puma560.par", 40)])
def test_base_parameters_are_as_many_as_known(name: str, inertial: int) -> None:
    machine, _ = read_machine(EXAMPLES / name)
    values = {p.name: p.value.value() if p.value else 0.4 for p in machine.parameters}
    Y = regressor(machine, values)
    q, qd, qdd = np.random.default_rng(0).uniform(-2, 2, (3, 60, len(machine.independent)))
    W = Y.evaluate(q, qd, qdd, range(len(Y.columns))).reshape(-1, len(Y.columns))
    kept = [Y.columns[c].quantity for c in independent_columns(W, 1e-8).kept]
    assert sum(quantity not in ("FV", "FS") for quantity in kept) == inertial


def test_missing_geometry_is_named() -> None:
    machine, _ = read_machine(EXAMPLES / "flex4.par")
    with pytest.raises(InputError, match="L2 has no value"):
        regressor(machine)


# Estimation


@pytest.mark.sampled(2)
@pytest.mark.parametrize("sprung", [False, True])
def test_exact_recovery_without_noise(arm: Machine, sprung: bool) -> None:
    """Of springs beside the motors too."""
    arm = with_springs_beside_motors(arm) if sprung else arm
    found = identify(arm, exact(arm), LogSettings(filtered=False))
    assert {e.verdict for e in found.estimates} <= {Verdict.IDENTIFIED, Verdict.POOR}
    for e in found.estimates:
        assert e.value == pytest.approx(e.unknown.nominal, abs=1e-10), e.unknown.formula
    assert found.estimation["ZZ1"].unknown.formula == "ZZ1 + 0.16 M2 + IA1"
    assert {"K1", "K2"} & nominal(found).keys() == ({"K1", "K2"} if sprung else set())


def test_recovery_through_filters_without_noise(arm: Machine) -> None:
    bare = replace(exact(arm, count=3000), qd=None, qdd=None)
    found = identify(arm, bare)
    assert found.filter is not None
    for e in found.estimates:
        assert e.value == pytest.approx(e.unknown.nominal, rel=5e-3, abs=2e-3), e.unknown.formula


def test_std_is_that_of_monte_carlo(arm: Machine) -> None:
    true, sigma, trials = exact(arm, count=300), np.array([0.2, 0.05]), 60
    rng, raw = np.random.default_rng(0), LogSettings(filtered=False, offsets="never")
    runs = [
        identify(arm, replace(true, tau=true.tau + sigma * rng.standard_normal(true.tau.shape)), raw)
        for _ in range(trials)
    ]  # fmt: skip
    values = np.array([[e.value for e in run.estimates] for run in runs])
    stated = np.sqrt(np.mean([[e.std**2 for e in run.estimates] for run in runs], axis=0))
    ratio = values.std(axis=0, ddof=1) / stated
    assert (abs(ratio - 1) < 4 / math.sqrt(2 * trials) + 0.1).all(), ratio
    truth = np.array(list(nominal(runs[0]).values()))
    assert (abs(values.mean(axis=0) - truth) < 5 * stated / math.sqrt(trials)).all()
    assert np.mean([run.estimation.solution.sigma for run in runs], axis=0) == pytest.approx(sigma, rel=0.05)


def test_position_noise_does_not_pull_towards_zero() -> None:
    rng = np.random.default_rng(0)
    samples, X = 4000, np.array([2.0, -3.0])
    Y0 = rng.standard_normal((samples, 1, 2))
    tau, noise = Y0 @ X, lambda: 0.5 * rng.standard_normal(Y0.shape)
    Y = Y0 + noise()
    assert abs(solve(Y, tau).X[0]) < 1.7
    found = solve(Y, tau, RowNoise([noise()]))
    assert (abs(found.X - X) < 4 * found.std).all() and (found.std < 0.1).all()
    assert found.noise == pytest.approx(0.2, abs=0.03)


def test_equation_without_torque_does_not_vanish_in_noise() -> None:
    rng = np.random.default_rng(0)
    samples, mass, stiffness = 3000, 0.6, 250.0
    t = np.arange(samples) / 100
    given, noise = np.sin(t), lambda: 0.05 * rng.standard_normal(samples)
    Y = np.zeros((samples, 2, 3))
    Y[:, 0, 0] = np.cos(2 * t)
    Y[:, 0, 1] = 1e-6 * given
    Y[:, 1, 1], Y[:, 1, 2] = given + noise(), -given * mass / stiffness * (1 + noise())
    tau = np.zeros((samples, 2))
    tau[:, 0] = 5 * Y[:, 0, 0] + 0.1 * rng.standard_normal(samples)
    twins = []
    for _ in range(2):
        other = np.zeros_like(Y)
        other[:, 1, 1] = noise()
        twins.append(other)
    names = ("motor", "head")
    unknowns = [
        Unknown(x, "", formula=x, joint=j, quantity=x) for x, j in (("M1", "motor"), ("M2", "head"), ("K2", "head"))
    ]
    found = estimate(LinearModel(Y, tau, unknowns, names, RowNoise(twins)))
    assert found["M1"].value == pytest.approx(5, abs=0.02)
    assert found.not_identifiable == ("M2", "K2")
    assert "head has no motor" in found["K2"].reason


@pytest.mark.thorough
def test_elastic_joint_from_noisy_encoders(elastic: Machine) -> None:
    reference = random_motion(Limits.of([-1.5], [1.5], [4], [30]), 0.5, 4, seed=3)
    controller = Controller.of_bandwidth([0.6], 4.0)
    true = simulate(elastic, {}, reference.at, controller, 6.0, 500.0, settle=1.0)
    step = np.full(2, 2 * math.pi / 2**18)
    found = identify(elastic, measure(true, Sensors(step, step, np.array([0.05]))))
    assert found.estimation["K2"].value == pytest.approx(40, rel=0.02)
    assert found.estimation["DA2"].value == pytest.approx(0.05, rel=0.2)
    assert found.neutral["elbow"][0] == pytest.approx(0.1, abs=1e-3)
    for e in found.estimates:
        if e.verdict is Verdict.IDENTIFIED:
            assert abs(e.value - e.unknown.nominal) < 5 * e.std, e.unknown.formula
    text = table(found, nominal(found))
    assert "K2" in text and "identified" in text
    figures: Any = found.as_json()
    assert figures["estimates"]["K2"]["verdict"] == "identified" and figures["samples"] == len(found.t)


def test_verdicts_name_what_a_joint_at_rest_hides(arm: Machine) -> None:
    found = identify(arm, exact(arm, still=(1,)), LogSettings(filtered=False))
    assert {"FV2", "FS2", "IA2"} <= set(found.estimation.not_identifiable)
    assert found.estimation["FV2"].reason == "elbow does not move"
    assert any("elbow does not move" in note for note in found.notes)
    assert found.estimation["FV1"].verdict is Verdict.IDENTIFIED
    assert math.isnan(found.estimation["FV2"].value)
    for e in found.estimates:
        if e.verdict is Verdict.NOT:
            assert e.reason


def test_torques_of_zero_of_a_joint_at_rest_are_no_measurement(arm: Machine) -> None:
    true = exact(arm, still=(1,))
    noisy = true.tau + 0.01 * np.random.default_rng(0).standard_normal(true.tau.shape)
    noisy[:, 1] = 0.0
    found = identify(arm, replace(true, tau=noisy), LogSettings(filtered=False))
    assert any("elbow is held still, and its torques are zero throughout" in note for note in found.notes)
    assert not found.estimation.solution.residuals[:, 1].any()
    assert 0.5 < found.estimation.solution.residuals[:, 0].std() / 0.01 < 1.5
    assert all(e.std > 0 for e in found.estimates if e.verdict is not Verdict.NOT)


def test_known_values_are_not_sought(arm: Machine) -> None:
    true = exact(arm)
    found = identify(arm, true, LogSettings(known={"FS1": 0.2, "IA2": 0.0}, filtered=False))
    assert {"FS1", "IA2"}.isdisjoint(nominal(found))
    assert found.estimation["FV1"].value == pytest.approx(0.3)
    with pytest.raises(InputError, match="no such parameter; did you mean 'FS1'"):
        identify(arm, true, LogSettings(known={"FS11": 0.2}))


def renamed(arm: Machine) -> Machine:
    """The arm whose elbow calls its first moment FV1, and its rotor inertia X_XX2: like other parameters are called."""
    zero = Formula.parse(0)
    body = Body(Formula.parse("m2"), (Formula.parse("FV1"), zero, zero), (*(zero,) * 5, Formula.parse(0.04575)))
    elbow = replace(arm.joints[1], rotor_inertia=Formula.parse("X_XX2"), body=body)
    own = (Parameter("FV1", Formula.parse(0.225)), Parameter("X_XX2", Formula.parse(0.02)))
    return replace(arm, joints=(arm.joints[0], elbow, *arm.joints[2:]), parameters=(*arm.parameters, *own))


def test_labels_are_no_names_of_other_quantities(arm: Machine) -> None:
    """The same estimates, friction by another label; a name that may mean two parameters is refused with both."""
    other = renamed(arm)
    true = exact(other)
    found, plain = identify(other, true, LogSettings(filtered=False)), identify(arm, true, LogSettings(filtered=False))
    assert {e.unknown.label for e in found.estimates} == {
        "FV_1" if e.unknown.label == "FV1" else e.unknown.label for e in plain.estimates
    }
    assert found.estimation["FV_1"].value == pytest.approx(0.3)
    assert "FV_1" not in nominal(identify(other, true, LogSettings(known={"FV_1": 0.3}, filtered=False)))
    with pytest.raises(InputError) as error:
        identify(other, true, LogSettings(known={"FV1": 0.3}, filtered=False))
    assert "--known, FV1: the machine has another quantity of this name: write MX2 for MX of joint 2 (elbow)" in str(
        error.value
    )
    assert str(error.value).endswith(" or FV_1 for FV of joint 1 (shoulder)")
    saved = machine_with_estimates(found)
    states = np.random.default_rng(2).uniform(-2, 2, (3, 30, 2))
    tau, known = (np.asarray(numpy_model(m, ("inverse_dynamics",)).inverse_dynamics(*states)[0]) for m in (saved, arm))
    rotor = 0.02 * states[2] * [0, 1]
    np.testing.assert_allclose(tau, known + rotor, atol=1e-6 * np.abs(known).max())


def test_a_rotor_behind_a_ratio_is_saved_as_the_joint_feels_it(arm: Machine) -> None:
    geared = replace(arm.joints[1], rotor_inertia=Formula.parse(2e-4), ratio=Formula.parse(10))
    machine = replace(arm, joints=(arm.joints[0], geared, *arm.joints[2:]))
    found = identify(machine, exact(machine), LogSettings(filtered=False))
    assert found.estimation["IA2"].unknown.nominal == pytest.approx(0.02)
    states = np.random.default_rng(2).uniform(-2, 2, (3, 30, 2))
    both = (machine_with_estimates(found), machine)
    saved, true = (np.asarray(numpy_model(m, ("inverse_dynamics",)).inverse_dynamics(*states)[0]) for m in both)
    np.testing.assert_allclose(saved, true, atol=1e-6 * np.abs(true).max())


def saved_without_negatives(machine: Machine, measured: Measurements) -> tuple[Identification, list[str]]:
    """The fit that is saved."""
    found = identify(machine, measured, LogSettings(filtered=False))
    return without_negatives(found, lambda fixed: identify(machine, measured, LogSettings(known=fixed, filtered=False)))


def test_negative_values_are_zero_and_the_others_fitted_again(arm: Machine) -> None:
    """What is saved is the least-squares fit without them; a second value may become negative by the first."""
    true = exact(arm)
    wrong = replace(true, tau=true.tau - 2 * true.qd * [0.3, 0.0])
    fitted, lines = saved_without_negatives(arm, wrong)
    assert [line.split(" is ")[0] for line in lines] == ["FV1 = -0.3", "FS1 = -0.139"]
    assert "the others are fitted again, as with --known FV1=0" in lines[0]
    machine = machine_with_estimates(fitted)
    assert machine.joints[0].friction.viscous.is_zero and machine.joints[0].friction.coulomb.is_zero
    states = (wrong.q, wrong.qd, wrong.qdd)
    tau = np.asarray(numpy_model(machine, ("inverse_dynamics",)).inverse_dynamics(*states)[0])
    Y = regressor(arm)
    others = [c for c, column in enumerate(Y.columns) if column.label not in ("FV1", "FS1")]
    W = (Y.evaluate(*states, others) / fitted.estimation.solution.sigma[:, None]).reshape(-1, len(others))
    left = ((wrong.tau - tau) / fitted.estimation.solution.sigma).ravel()
    assert np.abs(W.T @ left).max() < 1e-6 * np.linalg.norm(W, axis=0).max() * np.linalg.norm(left)
    first = identify(arm, wrong, LogSettings(filtered=False))
    kept = first.estimation.solution.residuals.ravel()
    assert np.linalg.norm(wrong.tau - tau) > 2 * np.linalg.norm(kept), "torques of the first fit need the negative one"


def of_spring(machine: Machine, X: float, file: float) -> Any:
    """What `possible` reads of a fit that found a stiffness alone."""
    columns = [RegressorColumn("K2", "K", 2, 1, "N m/rad", file)]
    equations = SimpleNamespace(Y=SimpleNamespace(columns=columns), fixed={}, estimated_columns=(0,))
    estimation = SimpleNamespace(solution=SimpleNamespace(X=np.array([X])), grouping=SimpleNamespace(kept=(0,)))
    return SimpleNamespace(machine=machine, equations=equations, estimation=estimation)


def test_a_negative_stiffness_is_that_of_the_file(elastic: Machine) -> None:
    """Where the file has none, it is refused."""
    fixed: list[Mapping[str, float]] = []
    good = of_spring(elastic, 40.0, 40.0)
    found, lines = without_negatives(of_spring(elastic, -1.0, 40.0), lambda known: fixed.append(dict(known)) or good)
    assert fixed == [{"K2": 40.0}] and found is good
    assert lines[0].startswith("K2 = -1 is saved as 40, because it is physically impossible")
    with pytest.raises(
        InputError, match=r"known, K2: -1 was estimated, which no spring can have, and the file gives no value"
    ):
        without_negatives(of_spring(elastic, -1.0, math.nan), lambda _: good)


def test_negative_friction_is_noted(arm: Machine) -> None:
    true = exact(arm)
    wrong = replace(true, tau=true.tau - 2 * true.qd * 0.3)
    noted = identify(arm, wrong, LogSettings(filtered=False)).notes
    assert any(note.startswith("FV1 = -0.3 is negative") for note in noted)


@pytest.mark.thorough
def test_negative_values_by_chance_are_no_alarm(arm: Machine) -> None:
    """Of a machine without friction: alarms in some 1 % of the records, though a value is often 2 std below zero."""
    free = replace(arm, joints=tuple(replace(joint, friction=Friction()) for joint in arm.joints))
    true, rng = exact(free, count=300), np.random.default_rng(0)
    alarms, low = 0, 0
    for _ in range(40):
        noisy = replace(true, tau=true.tau + 0.1 * rng.standard_normal(true.tau.shape))
        found = identify(free, noisy, LogSettings(filtered=False))
        alarms += any("is negative by" in note for note in found.notes)
        low += any(e.value < -2 * e.std for e in found.estimates if e.unknown.quantity in ("FV", "FS"))
    assert low > 1 and alarms <= 2, (low, alarms)


@pytest.mark.thorough
def test_several_records_are_one(arm: Machine) -> None:
    found = identify(arm, [exact(arm, seed=1), exact(arm, seed=2)], LogSettings(filtered=False))
    assert len(found.t) == 2 * len(identify(arm, exact(arm), LogSettings(filtered=False)).t)


def test_torques_that_are_zero_throughout(arm: Machine) -> None:
    true = exact(arm)
    with pytest.raises(InputError, match="tau: is zero throughout"):
        identify(arm, replace(true, tau=0 * true.tau), LogSettings(filtered=False))


def test_too_few_equations(arm: Machine) -> None:
    with pytest.raises(InputError, match="equations after filtering for 11 parameters"):
        identify(arm, exact(arm, count=14), LogSettings(filtered=False))


# Filters


def test_filters_keep_phase_and_size() -> None:
    """Averages of a wave are the wave in the middle of the window, times the gain of the Hann window."""
    chosen = Filter(1000.0, 5.0, 25.0, window=100, step=33)
    t = np.arange(6000) / 1000
    wave = np.sin(2 * np.pi * 4 * t)
    inner = slice(chosen.trim, -chosen.trim)
    assert abs(smooth(wave, chosen) - wave)[inner].max() < 2e-3
    kept, times = average(wave, chosen), average(t, chosen)
    np.testing.assert_allclose(times[:2], [0.0495, 0.0825], atol=1e-12)
    gain = np.sinc(0.4) / (1 - 0.4**2)
    assert abs(kept - gain * np.sin(2 * np.pi * 4 * times)).max() < 1e-3
    assert abs(average(np.sin(2 * np.pi * 80 * t), chosen)).max() < 1e-3


def test_rows_use_the_whole_record(arm: Machine) -> None:
    """Three rows in each window, of which reversals cost a part: V 9, where 15 s were too short."""
    true = exact(arm, count=1500)
    torques = true.tau + 0.05 * np.random.default_rng(0).standard_normal(true.tau.shape)
    record = Measurements(true.t, true.q, torques)
    chosen = default_filter(record, (0, 1))
    rows = len(chosen.starts(1500 - 2 * chosen.trim))
    assert rows > 0.7 * 15 * 3 * 2 * chosen.motion
    found = identify(arm, record)
    assert len(found.t) == rows
    used = (found.estimation.solution.residuals != 0).mean(axis=0)
    assert (used > 0.7).all()


def test_correlation_of_averages() -> None:
    chosen = Filter(1000.0, 5.0, 25.0, window=99, step=33)
    rows = average(np.random.default_rng(0).standard_normal((400_000, 1)), chosen)[:, 0]
    seen = [float(rows[k:] @ rows[: len(rows) - k] / (rows @ rows)) for k in range(4)]
    np.testing.assert_allclose([*chosen.correlation, 0.0], seen, atol=0.02)


def test_twins_have_the_law_of_the_noise() -> None:
    """Modulation puts noise of the same size into the band of the filter, and none of the motion."""
    t, rng = np.arange(40000) / 1000, np.random.default_rng(0)
    true, noise = np.sin(2 * np.pi * 0.7 * t), 1e-3 * rng.standard_normal(len(t))
    record = Measurements(t, (true + noise)[:, None], np.zeros((len(t), 0)))
    chosen = default_filter(record, (0,))
    clean = filtered_motion(replace(record, q=true[:, None]), chosen)
    seen = filtered_motion(record, chosen)
    assert len(seen.twins) == 2
    for k, name in enumerate(("q", "qd", "qdd")):
        left = getattr(seen, name) - getattr(clean, name)
        for twin in seen.twins:
            assert twin[k].std() == pytest.approx(left.std(), rel=0.15), name
            assert abs(float(np.corrcoef(twin[k][:, 0], left[:, 0])[0, 1])) < 0.2


def test_differences_of_fourth_order() -> None:
    errors = []
    for period in (2e-3, 1e-3):
        t = np.arange(0, 1, period)
        first, second = differentiate(np.sin(9 * t), period)
        inner = t[2:-2]
        errors.append((abs(first - 9 * np.cos(9 * inner)).max(), abs(second + 81 * np.sin(9 * inner)).max()))
    assert errors[0][0] / errors[1][0] == pytest.approx(16, rel=0.1)
    assert errors[1][0] < 1e-6 and errors[1][1] < 1e-5


def test_bandwidth_is_that_of_the_motion_not_of_the_noise() -> None:
    t = np.arange(8000) / 1000
    noise = 1e-4 * np.random.default_rng(0).standard_normal(len(t))
    for frequency in (0.5, 3.0, 20.0):
        assert bandwidth_of(np.sin(2 * np.pi * frequency * t) + noise, 1e-3) == pytest.approx(frequency, abs=0.5)


def test_default_filter_says_what_it_does(arm: Machine) -> None:
    chosen = default_filter(exact(arm, count=2000), (0, 1))
    assert chosen.cutoff == pytest.approx(5 * chosen.motion)
    assert chosen.sampling / chosen.window == pytest.approx(2 * chosen.motion, rel=0.01)
    assert any("Butterworth" in line for line in chosen.description())
    with pytest.raises(InputError, match="sample at least"):
        default_filter(exact(arm), (0, 1), bandwidth=60.0)


# Exciting motions


def test_motion_and_its_derivatives_keep_limits() -> None:
    for seed in range(5):
        motion = random_motion(LIMITS, 0.4, 5, seed)
        t = np.linspace(0, motion.period, 4001)
        q, qd, qdd = motion.at(t)
        assert (q >= LIMITS.low - 1e-2).all() and (q <= LIMITS.high + 1e-2).all()
        assert (abs(qd) <= LIMITS.velocity * 1.01).all() and (abs(qdd) <= LIMITS.acceleration * 1.01).all()
        np.testing.assert_allclose(np.gradient(q, t, axis=0)[2:-2], qd[2:-2], atol=1e-3)
        np.testing.assert_allclose(np.gradient(qd, t, axis=0)[2:-2], qdd[2:-2], atol=1e-2)
        again = within(motion, LIMITS)
        np.testing.assert_allclose(again.a, motion.a)


def test_optimizer_lowers_the_condition_number(arm: Machine) -> None:
    seen: list[float] = []
    found = excite(
        arm, LIMITS, 0.25, ExcitationSettings(4, starts=3, evaluations=150), lambda done, total, c: seen.append(c)
    )
    assert found.condition < 0.8 * found.before
    assert len(seen) == 150 and seen == sorted(seen, reverse=True)
    assert found.condition == pytest.approx(
        Condition(Response(arm, regressor(arm)), random_motion(LIMITS, 0.25, 4, 0))(found.motion), rel=1e-9
    )
    assert "ZZ2" in found.columns
    with pytest.raises(InputError, match="the machine has 2 motors"):
        excite(arm, Limits.of([-1], [1], [1], [1]), 0.25)
    with pytest.raises(InputError, match="no room"):
        Limits.of([1], [-1], [1], [1])


def test_springs_follow_in_the_design(elastic: Machine) -> None:
    limits = Limits.of([-1.0], [1.0], [2], [5])
    motion = random_motion(limits, 0.2, 3)
    q, _, _ = Response(elastic, regressor(elastic)).states(motion)
    assert 0.01 < np.ptp(q[:, 1]) < 0.5


# Data files


def columns(machine: Machine) -> dict[str, np.ndarray]:
    true = exact(machine, count=100)
    return {
        "t": true.t, "q_shoulder": true.q[:, 0], "q_elbow": true.q[:, 1],
        "tau_shoulder": true.tau[:, 0], "tau_elbow": true.tau[:, 1],
    }  # fmt: skip


def written(path: Path, data: dict[str, Any], cells: dict[tuple[int, str], str] | None = None) -> Path:
    rows = [
        [(cells or {}).get((k, name), f"{values[k]:.9g}") for name, values in data.items()]
        for k in range(len(next(iter(data.values()))))
    ]
    path.write_text("\n".join([",".join(data), *map(",".join, rows)]) + "\n")
    return path


def test_csv_and_npz_read_back(arm: Machine, tmp_path: Path) -> None:
    true = exact(arm, count=100)
    write_measurements(true, arm, tmp_path / "run.csv")
    found = read_measurements(tmp_path / "run.csv", arm)
    np.testing.assert_allclose(found.q, true.q, rtol=1e-9)
    assert found.qdd is not None and found.period == pytest.approx(0.01)
    np.savez(tmp_path / "run.npz", t=true.t, q=true.q, tau=true.tau)
    np.testing.assert_array_equal(read_measurements(tmp_path / "run.npz", arm).tau, true.tau)
    np.savez(tmp_path / "named.npz", **columns(arm))
    assert read_measurements(tmp_path / "named.npz", arm).q.shape == (100, 2)


def test_names_variables_and_units(arm: Machine) -> None:
    data = columns(arm)
    renamed = {
        "time": data["t"], "q_q1 [deg]": np.degrees(data["q_shoulder"]), "q2": data["q_elbow"],
        "tau_q1 [mN m]": 1e3 * data["tau_shoulder"], "tau_elbow": data["tau_elbow"], "note": data["t"],
    }  # fmt: skip
    found = from_columns(renamed, arm, "data")
    np.testing.assert_allclose(found.q[:, 0], data["q_shoulder"])
    np.testing.assert_allclose(found.tau[:, 0], data["tau_shoulder"])
    assert found.warnings == ("column note is skipped",)
    with pytest.raises(InputError, match=r"'mm' cannot be converted to rad"):
        from_columns({"t": data["t"], "q_elbow [mm]": data["q_elbow"]}, arm, "data")


BAD_CELLS = [
    ({(5, "q_elbow"): "nan"}, "q_elbow: NaN or infinity at 1 samples, first at sample 6"),
    ({(5, "q_elbow"): ""}, "q_elbow: line 7: is empty: a gap"),
    ({(5, "q_elbow"): "abc"}, "q_elbow: line 7: 'abc' is not a number"),
    ({(5, "t"): "0.04"}, "t: does not increase from sample 5"),
    ({(99, "t"): "3"}, "t: gap of 2.02 s after sample 99"),
    ({(5, "t"): "0.053"}, "t: uneven sampling: sample 6"),
]


@pytest.mark.sampled(2)
@pytest.mark.parametrize(("cells", "message"), BAD_CELLS)
def test_bad_cells(arm: Machine, tmp_path: Path, cells: dict[tuple[int, str], str], message: str) -> None:
    refused(written(tmp_path / "bad.csv", columns(arm), cells), arm, message)


def refused(path: Path, machine: Machine, message: str) -> None:
    with pytest.raises(InputError) as caught:
        read_measurements(path, machine)
    line = str(caught.value)
    assert message in line and line.startswith(str(path)) and "\n" not in line, line


def test_bad_columns(arm: Machine, tmp_path: Path) -> None:
    data, path = columns(arm), tmp_path / "bad.csv"
    without = {name: x for name, x in data.items() if name not in ("q_elbow", "tau_elbow")}
    refused(written(path, without), arm, "q_elbow, tau_elbow: missing; the file has t, q_shoulder, tau_shoulder")
    refused(written(path, {**data, "q_wrist": data["t"]}), arm, "q_wrist: no moving joint 'wrist'")
    passive = replace(arm, joints=tuple(replace(joint, kind=Kind.PASSIVE) for joint in arm.joints))
    refused(written(path, data), passive, "tau_shoulder: no joint has a motor")
    refused(written(path, {**data, "q_q1": data["t"]}), arm, "q_q1: is given twice")
    refused(written(path, {name: x[:20] for name, x in data.items()}), arm, "t: 20 samples are too few")
    refused(written(path, {**data, "t": 1e3 * data["t"]}), arm, "if t is in ms")
    refused(written(path, {**data, "q_elbow": 0 * data["t"], "q_shoulder": 0 * data["t"]}), arm, "no joint moves")
    rates = {"qd_elbow": data["t"], "qd_shoulder": 57.3 * np.gradient(data["q_shoulder"], 0.01)}
    refused(written(path, data | rates), arm, "qd_shoulder: is 57.3 times the slope of q_shoulder")


def test_bad_files(arm: Machine, elastic: Machine, tmp_path: Path) -> None:
    data = columns(arm)
    refused(tmp_path / "no.csv", arm, "file: no such file")
    refused(tmp_path / "no.xlsx", arm, "measurements are .csv or .npz")
    (tmp_path / "short.csv").write_text("t,q_elbow\n")
    refused(tmp_path / "short.csv", arm, "holds no samples")
    (tmp_path / "ragged.csv").write_text("t,q_elbow\n0,1\n1\n2,3\n")
    refused(tmp_path / "ragged.csv", arm, "line 3: has 1 cells, the header has 2")
    (tmp_path / "headless.csv").write_text("0,1\n1,2\n")
    refused(tmp_path / "headless.csv", arm, "line 1: the first line holds numbers")
    (tmp_path / "double.csv").write_text("t,t\n1,2\n")
    refused(tmp_path / "double.csv", arm, "t: is given twice")
    (tmp_path / "text.npz").write_text("no archive")
    refused(tmp_path / "text.npz", arm, "cannot be read as arrays of numbers")
    np.savez(tmp_path / "objects.npz", t=np.array([None, {}]))
    refused(tmp_path / "objects.npz", arm, "holds text or objects, not arrays of numbers")
    np.savez(tmp_path / "narrow.npz", t=data["t"], q=np.zeros((100, 3)), tau=np.zeros((100, 2)))
    refused(tmp_path / "narrow.npz", arm, "q: has 3 columns: 2 are expected, of shoulder, elbow")
    refused(written(tmp_path / "spring.csv", data), elastic, "elbow has no motor: motors are ")


def test_lengths_in_mm_and_angles_in_degrees(arm: Machine) -> None:
    machine, _ = read_machine(EXAMPLES / "two_axis.toml")
    t = np.arange(100) / 100
    q = np.zeros((100, 12))
    q[:, 4] = 300 * np.sin(t)
    with pytest.raises(
        InputError, match=r"q_motor_x: moves over .* these look like mm. Call the column q_motor_x \[mm\]"
    ):
        check(Measurements(t, q, np.zeros((100, 2))), machine)
    check(Measurements(t, q, np.zeros((100, 2))), machine, frozenset({"q_motor_x"}))
    turned = check(Measurements(t, np.degrees(np.stack([3 * t, -t], axis=1)), np.zeros((100, 2))), arm)
    assert "if these are degrees, call it q_shoulder [deg]" in turned.warnings[0]


# Pictures


@pytest.mark.thorough
def test_pictures(arm: Machine, tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    found = identify(arm, exact(arm, still=(1,)), LogSettings(filtered=False))
    paths = found.plots().save(tmp_path / "pictures", "svg")
    assert [path.name for path in paths] == ["torques.svg", "residuals.svg", "spectra.svg", "parameters.svg"]
    text = paths[2].read_text()
    first = [path.read_bytes() for path in paths]
    with permission(force=True):
        assert (
            "<svg" in text and [path.read_bytes() for path in found.plots().save(tmp_path / "pictures", "svg")] == first
        )
    assert found.plots().save(tmp_path, "png")[0].read_bytes().startswith(b"\x89PNG")
    with pytest.raises(InputError, match="unknown 'bmp'"):
        found.plots().save(tmp_path, "bmp")
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="is a file, not a folder"):
        found.plots().save(tmp_path / "file" / "below")
