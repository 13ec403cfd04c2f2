"""Sensors as they are: coarse encoders, torques that are late or have offsets, shares of records that count."""

from __future__ import annotations

import gc
import math
import weakref
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

pytest.importorskip("scipy")

import symoro_elastic as se
from symoro_elastic.analysis.time_series.measurements import Measurements
from symoro_elastic.analysis.time_series.preparation import Preparation
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import Friction, Machine
from symoro_elastic.measured.logs import views
from symoro_elastic.measured.logs.estimation import solve
from symoro_elastic.measured.logs.filtering import default_filter, filtered_motion
from symoro_elastic.measured.logs.fourier_motion import Limits, random_motion
from symoro_elastic.measured.logs.identified import Identified
from symoro_elastic.measured.logs.identify import LogSettings, identify
from symoro_elastic.measured.logs.noise import RowNoise
from symoro_elastic.measured.logs.result import Identification
from symoro_elastic.measured.logs.sensors import Sensors, notes_on_sensors
from symoro_elastic.measured.logs.validation import validation_of
from symoro_elastic.numerics.verification.implementations import numpy_model
from tests.benchmarks.sensors import Sensing, coverage, three_axis

Array = NDArray[np.float64]
LIMITS = Limits.of([-2.0, -2.0], [2.0, 2.0], [4.0, 4.0], [25.0, 25.0])
RATE, NOISE = 500.0, np.array([0.05, 0.02])


@pytest.fixture(scope="module")
def arm() -> Machine:
    """The planar arm, with friction."""
    machine = se.read("examples/planar_2r.toml")
    friction = Friction(Formula.parse(0.3), Formula.parse(0.2))
    return replace(machine, joints=tuple(replace(j, friction=friction) if j.sigma != 2 else j for j in machine.joints))


MODELS: dict[int, object] = {}


def torques(arm: Machine, *motion: Array) -> Array:
    """Return torques along q, qd, qdd."""
    if id(arm) not in MODELS:
        MODELS[id(arm)] = numpy_model(arm, ("inverse_dynamics",))
    found: Array = np.array(MODELS[id(arm)].inverse_dynamics(*motion)[0])  # type: ignore[attr-defined]
    return found


def record(
    arm: Machine,
    late: float = 0.0,
    offset: Sequence[float] = (0.0, 0.0),
    bits: int = 0,
    noise: float = 1.0,
    seed: int = 0,
    seconds: float = 20.0,
) -> Measurements:
    """Return a record along 2 s of a motion, again and again; torques are `late` in s."""
    rng, motion = np.random.default_rng(seed), random_motion(LIMITS, 0.5, 5, seed)
    t = np.arange(round(seconds * RATE)) / RATE
    tau = torques(arm, *motion.at(t - late))
    q, step = motion.at(t)[0], 2 * np.pi / 2**bits
    q = np.round(q / step + 0.3) * step if bits else q + 1e-6 * rng.standard_normal(q.shape)
    return Measurements(t, q, tau + noise * NOISE * rng.standard_normal(tau.shape) + np.array(offset))


def of_machine(found: Identification) -> Array:
    """Return estimates less truth over standard deviations."""
    return np.array(
        [(e.value - e.unknown.nominal) / e.std for e in found.estimates if e.unknown.nominal == e.unknown.nominal]
    )


@pytest.mark.parametrize("bits", [10, 12, 14, 15, 17, 20])
@pytest.mark.parametrize("rate", [500.0, 1000.0])
def test_bandwidth_is_that_of_the_motion_not_of_the_staircase(bits: int, rate: float) -> None:
    """Motions to 2.5 Hz that repeat, so that the staircase has lines of its own."""
    for seed in range(3):
        t, step = np.arange(round(20 * rate)) / rate, 2 * np.pi / 2**bits
        q = np.round(random_motion(LIMITS, 0.5, 5, seed).at(t)[0] / step) * step
        chosen = default_filter(Measurements(t, q, np.zeros_like(q)), (0, 1))
        assert 1.4 < chosen.motion < 2.7


@pytest.mark.thorough
@pytest.mark.parametrize("bits", [11, 13])
def test_staircases_of_other_zeros_have_the_energy_of_the_noise(bits: int) -> None:
    """Noise of accelerations that the filter leaves, over 60 zeros of an encoder, against what is taken for it."""
    motion, step, seen, taken = random_motion(LIMITS, 0.5, 5, 1), 2 * np.pi / 2**bits, 0.0, 0.0
    t = np.arange(4000) / RATE
    q = motion.at(t)[0]
    true = Measurements(t, q, np.zeros_like(q))
    chosen = default_filter(true, (0, 1), bandwidth=2.5)
    clean = filtered_motion(true, chosen)
    for zero in np.linspace(0, 1, 60, endpoint=False):
        found = filtered_motion(replace(true, q=(np.round(q / step + zero) - zero) * step), chosen)
        assert found.staircases == (0, 1)
        seen += (found.qdd - clean.qdd).var()
        taken += np.mean([twin[2].var() for twin in found.twins])
    assert taken / seen == pytest.approx(1.0, abs=0.1)


@pytest.mark.thorough
@pytest.mark.parametrize("samples", [-1.0, 0.4, 3.0, 10.0])
def test_a_delay_is_found_and_compensated(arm: Machine, samples: float) -> None:
    """Within four of its standard deviations, and so are the parameters; before, one sample was 18 of theirs."""
    found = identify(arm, record(arm, late=samples / RATE))
    late = found.estimation["delay"]
    assert abs(late.value - samples / RATE) < 4 * late.std < 0.2 / RATE
    assert abs(of_machine(found)).max() < 4
    others = "positions" if samples > 0 else "torques"
    assert [line for line in found.notes if f"ms) behind {others}: compensated" in line]


@pytest.mark.thorough
def test_without_noise_the_delay_is_exact(arm: Machine) -> None:
    found = identify(arm, record(arm, late=0.003, noise=0.0))
    assert found.delay == pytest.approx(0.003, abs=2e-6)
    never = identify(arm, record(arm, late=0.003), LogSettings(delay="never"))
    assert never.delay == 0.0 and abs(of_machine(never)).max() > 10


def test_rows_beside_reversals_know_what_they_share(arm: Machine) -> None:
    """Correlations of noise in rows that `identify` uses, against all weights, the mask of samples and the scale."""
    measured = record(arm, bits=17, seconds=8.0)
    found = identify(arm, measured, LogSettings(offsets="never", delay="never"))
    assert found.filter
    sampled, chosen = found.equations.sample(measured, found.filter), found.filter
    correlation, starts = found.equations.rows(sampled).correlation, chosen.starts(len(sampled.counted))
    H = np.array([np.pad(chosen.weights, (k, len(sampled.counted) - chosen.window - k)) for k in starts])
    for j in range(2):
        R = H * sampled.counted[:, j] @ H.T * np.outer(*2 * [sampled.scale[:, j]]) / (chosen.weights @ chosen.weights)
        assert np.diag(R) == pytest.approx(np.where(sampled.scale[:, j], 1.0, 0.0))
        for lag, each in enumerate(correlation[:, :, j]):
            np.testing.assert_allclose(each[: len(R) - lag], np.diag(R, lag), atol=1e-12)
        assert np.abs(np.diag(R, 1) - chosen.correlation[1]).max() > 0.1


@pytest.mark.thorough
def test_offsets_are_found_and_their_doubt_counts(arm: Machine) -> None:
    found = identify(arm, record(arm, offset=(0.5, -0.1)))
    for label, true in (("OFF1", 0.5), ("OFF2", -0.1)):
        e = found.estimation[label]
        assert abs(e.value - true) < 4 * e.std and e.unknown.unit == "N m"
    assert abs(of_machine(found)).max() < 4
    without = identify(arm, record(arm, offset=(0.5, -0.1)), LogSettings(offsets="never"))
    assert abs(of_machine(without)).max() > 10
    assert sum("has an offset of" in line for line in found.notes) == 2


@pytest.mark.thorough
def test_sensors_without_fault_have_no_delay_and_offsets_that_hold_zero(arm: Machine) -> None:
    """No false alarm in four records; offsets are sought for parameters of gravity would take them up."""
    for seed in range(4):
        found = identify(arm, record(arm, seed=seed, seconds=10))
        offsets = [e for e in found.estimates if e.unknown.quantity == "OFF"]
        assert "DELAY" not in {e.unknown.quantity for e in found.estimates}
        assert offsets and all(abs(e.value) < 4 * e.std for e in offsets)
        said = [line for line in found.notes if "torque offsets of " in line and "cannot be excluded" in line]
        assert len(said) == len(offsets) and "--offsets never" in said[0]
    found = identify(arm, record(arm), LogSettings(offsets="always", delay="always"))
    assert [e.unknown.label for e in found.estimates][-3:] == ["OFF1", "OFF2", "delay"]
    for e in found.estimates[-3:]:
        assert abs(e.value) < 4 * e.std


@pytest.mark.thorough
def test_an_offset_that_gravity_hides_widens_standard_deviations() -> None:
    """12 bits, late torques with offsets: MX2 was 7.7 and 11.9 std off where the offset of lift was not sought.

    The draws, of motions that hardly tell it from gravity, are two of thirty.
    """
    arm = three_axis()
    for seed in (2, 5):
        found = identify(arm.machine, arm.record(HIDDEN_OFFSET, seed), Y=arm.regressor)
        assert abs(of_machine(found)).max() < 4
        words = ("torque offsets of lift", "offset of the torque of lift", "of lift has an off")
        said = [line for line in found.notes if any(what in line for what in words)]
        assert len(said) == 1 and ("from gravity by this motion" in said[0]) == (1 in found.sensors.undetermined)


def test_an_offset_that_gravity_hides_is_named(arm: Machine) -> None:
    found = identify(arm, record(arm, seconds=10))
    said = notes_on_sensors(found.estimation, Sensors((0,), undetermined={1: 0.25}), arm)
    assert [line for line in said if "include 0.25 N m" in line and "--offsets never" in line]


def test_errors_of_one_factor_count_in_the_covariance() -> None:
    """Of tau = x1 + x2 t, with an error of the left side that is t^2 times a number of std 0.5: by hand."""
    t = np.linspace(-1, 1, 200)
    Y, tau = np.stack([np.ones(200), t], axis=1)[:, None, :], (1 + 2 * t)[:, None]
    noise = 1e-3 * np.random.default_rng(0).standard_normal(tau.shape)
    bare, doubted = (solve(Y, tau + noise, RowNoise(systematic=x)) for x in ([], [0.5 * t[:, None] ** 2]))
    added = doubted.covariance - bare.covariance
    np.testing.assert_allclose(added, [[(0.5 * np.mean(t**2)) ** 2, 0.0], [0.0, 0.0]], atol=1e-12)
    np.testing.assert_array_equal(doubted.X, bare.X)


def test_zeros_of_coarse_encoders_count_in_standard_deviations(arm: Machine) -> None:
    """An elbow that reads a step of 10 bits more turns MX2 by that angle into MY2, and std has room for half of it."""
    step, motion, values = 2 * np.pi / 2**10, random_motion(LIMITS, 0.5, 5, 0), []
    t = np.arange(10000) / RATE
    q, tau = motion.at(t)[0], torques(arm, *motion.at(t)) + NOISE * np.random.default_rng(0).standard_normal((10000, 2))
    for zero in (0.5, -0.5):
        read = np.floor(q / step + 0.5 + np.array([0.0, zero])) * step
        found = identify(arm, Measurements(t, read, tau))
        values.append(found.estimation["MY2"])
    turned = step * found.estimation["MX2"].unknown.nominal
    assert abs(values[0].value - values[1].value) == pytest.approx(turned, rel=0.05)
    assert min(e.std for e in values) > turned / math.sqrt(12)


def test_nothing_of_an_identification_is_kept(arm: Machine) -> None:
    """Results and what they are made of go with the last one that holds them, so that many need the memory of one."""
    measured = record(arm, seconds=10)
    found = identify(arm, measured)
    held = [weakref.ref(x) for x in (found, found.estimation, found.equations, found.estimation.solution, measured)]
    del found, measured
    gc.collect()
    assert [x() for x in held] == [None] * len(held)


@pytest.mark.thorough
def test_sensors_are_not_saved_and_said_so(arm: Machine) -> None:
    found = se.identify(arm, columns(record(arm, late=0.002, offset=(0.5, 0.0))))
    _, lines = found.saved()
    assert [line for line in lines if "OFF1" in line and "delay" in line and "not of the machine" in line]
    assert isinstance(found, Identified) and not [line for line in se.identify(
        arm, columns(record(arm)), offsets="never", delay="never").saved()[1] if "sensors" in line]  # fmt: skip


def columns(measured: Measurements) -> dict[str, Array]:
    """Return the columns of a file."""
    return {
        "t": measured.t, "q_shoulder": measured.q[:, 0], "q_elbow": measured.q[:, 1],
        "tau_shoulder": measured.tau[:, 0], "tau_elbow": measured.tau[:, 1],
    }  # fmt: skip


def test_words_of_options(arm: Machine) -> None:
    with pytest.raises(InputError, match=r"offsets: unknown 'yes': choose from auto, always, never"):
        se.identify(arm, columns(record(arm)), offsets="yes")
    with pytest.raises(InputError, match="delay: unknown '2 ms'"):
        se.identify(arm, columns(record(arm)), delay="2 ms")


@pytest.mark.thorough
def test_coarse_encoders_are_named(arm: Machine) -> None:
    """12 bits are said to be steps; 7 bits, which pass too slowly, are said to be too coarse, with the way out."""
    fine = identify(arm, record(arm, bits=12))
    assert [line for line in fine.notes if "whole steps of encoders" in line and "0.00153" in line]
    assert not [line for line in fine.notes if "finer encoder" in line]
    coarse = identify(arm, record(arm, bits=7), LogSettings(bandwidth=2.5))
    assert [line for line in coarse.notes if "encoder of" in line and "finer encoder" in line]


def test_resampled_steps_are_named(arm: Machine) -> None:
    prepared = Preparation(rate=300.0)(record(arm, bits=12), arm)
    assert [line for line in prepared.warnings if "whole steps of an encoder" in line]
    assert not [line for line in Preparation(rate=300.0)(record(arm), arm).warnings if "encoder" in line]


@pytest.mark.thorough
def test_validation_says_what_counts_and_errs_sample_by_sample(arm: Machine) -> None:
    """The elbow rests for 60 % of a record, held by dry friction that no model gives: own sums over the samples."""
    found = identify(arm, record(arm))
    t, rest = np.arange(10000) / RATE, 6000
    motion = random_motion(LIMITS, 0.5, 5, 3)
    q, qd, qdd = motion.at(t)
    q[:rest, 1], qd[:rest, 1], qdd[:rest, 1] = q[rest, 1], 0.0, 0.0
    model = numpy_model(arm, ("inverse_dynamics",))
    tau = np.array(model.inverse_dynamics(q, qd, qdd)[0])
    tau[:rest, 1] += 1.0
    fit = validation_of(found, Measurements(t, q, tau))
    elbow, shoulder = "elbow", "shoulder"
    assert 15 < fit.counted[elbow] < 40 and 40 < fit.counted[shoulder] < 100  # reversals do not count, either
    assert fit.percent[elbow] < 3
    wanted = 100 * math.sqrt(rest / len(t)) / math.sqrt(float(np.mean(tau[:, 1] ** 2)))
    assert fit.sample_percent[elbow] == pytest.approx(wanted, rel=0.15)
    said = str(views.parts_of(Identified(found, (), arm, LogSettings(), fit)))
    assert "sample by sample" in said and f"of averages over {fit.counted[elbow]:.3g} % of the samples" in said


HIDDEN_OFFSET = Sensing(12, late=3, offset=True)
CASES = [Sensing(12), Sensing(14, 1000), Sensing(17), Sensing(late=1), Sensing(offset=True), Sensing(corner=20.0)]


@pytest.mark.thorough
@pytest.mark.parametrize("sensing", CASES, ids=str)
def test_truth_lies_within_two_standard_deviations(sensing: Sensing) -> None:
    """3 unseen draws of a kind of sensors, 22 parameters of an arm of three joints.

    Parameters of a run are correlated: 3 runs are taken for 9 draws, whose binomial share inside two standard
    deviations is 0.954 with a standard deviation of 0.07; three of them are allowed. `python -m
    tests.benchmarks.sensors` is the whole check.
    """
    found = coverage(three_axis(), sensing, 3, first=1000)
    assert not found.refused
    assert float(np.mean(np.abs(np.concatenate(found.z)) < 2)) > 0.954 - 3 * 0.07
    assert bool(sensing.late) == all("compensated" in " ".join(notes) for notes in found.notes)
