"""Torques that stay at an end of their range are left out, and said, unless the other samples predict them."""

from __future__ import annotations

import re
from functools import cache
from itertools import pairwise

import numpy as np
import pytest

pytest.importorskip("scipy")

import symoro_elastic as se
from symoro_elastic.analysis.time_series.column_faults import frozen, stays, wraps_of
from symoro_elastic.analysis.time_series.measurements import Measurements, measurements_of
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.machine import Machine
from symoro_elastic.measured.logs.identify import identify
from symoro_elastic.measured.logs.result import Identification
from symoro_elastic.numerics.linear.regressor import Regressor, regressor

PERIOD, SECONDS = 1e-3, 30
SLIDE = {
    "name": "slide", "gravity": [0, 0, 0],
    "joints": [{"name": "x", "kind": "motor", "sigma": 1, "r": "q1"}],
    "bodies": {"x": {"mass": 95}}, "friction": {"x": {"viscous": 120, "coulomb": 25}},
}  # fmt: skip
GEARED = {
    "name": "geared", "gravity": [0, -9.81, 0],
    "joints": [{"name": "a", "kind": "motor", "sigma": 0, "theta": "q1"}],
    "bodies": {"a": {"mass": 2, "center_of_mass": [0.25, 0, 0], "inertia": [0.1, 0.1, 0.1]}},
    "motors": {"a": {"rotor_inertia": 3.5e-4, "ratio": 100}}, "friction": {"a": {"viscous": 2, "coulomb": 1.5}},
}  # fmt: skip
TRUE = {"slide": {"M1": 95.0, "FV1": 120.0, "FS1": 25.0}, "geared": {"ZZ1": 3.725, "MX1": 0.5, "FV1": 2.0, "FS1": 1.5}}


@cache
def machine(name: str) -> tuple[Machine, Regressor]:
    found = se.read(SLIDE if name == "slide" else GEARED, warn=lambda _: None)
    return found, regressor(found)


def motion(name: str, seed: int) -> tuple[Array, Array, Array, Array, Array]:
    """Return t, q, and torques without noise, of five harmonics of 0.1 Hz."""
    rng, t = np.random.default_rng(seed), PERIOD * np.arange(round(SECONDS / PERIOD))
    q, qd, qdd = (np.zeros_like(t) for _ in range(3))
    for k in range(1, 6):
        a, b = rng.normal(size=2) * (0.08 if name == "slide" else 0.5) / k
        w = 0.2 * np.pi * k
        c, s = np.cos(w * t), np.sin(w * t)
        q, qd, qdd = q + a * c + b * s, qd + w * (b * c - a * s), qdd - w**2 * (a * c + b * s)
    if name == "slide":
        return t, q, qd, qdd, 95 * qdd + 120 * qd + 25 * np.sign(qd)
    return t, q, qd, qdd, 3.725 * qdd + 9.81 * 0.5 * np.cos(q) + 2 * qd + 1.5 * np.sign(qd)


def clipped(name: str, share: float, seed: int, step: float = 0.0) -> Measurements:
    """Return a record whose largest torques, of this share of the samples, are at two values."""
    t, q, _, _, tau = motion(name, seed)
    rng = np.random.default_rng(seed + 1)
    tau = tau + 0.02 * np.abs(tau).max() * rng.normal(size=len(t))
    if share:
        most = np.quantile(np.abs(tau), 1 - share)
        tau = np.clip(tau, -most, most)
    tau = np.round(tau / step) * step if step else tau
    encoder = np.round((q + 2e-6 * rng.normal(size=len(t))) / 5e-6) * 5e-6
    return Measurements(t, encoder[:, None], tau[:, None])


def found(name: str, record: Measurements) -> Identification:
    robot, Y = machine(name)
    return identify(robot, record, Y=Y)


def z_scores(name: str, result: Identification) -> list[float]:
    each = {e.unknown.label: e for e in result.estimates}
    return [(each[label].value - x) / each[label].std for label, x in TRUE[name].items()]


def left_out(result: Identification) -> list[str]:
    return [note for note in result.notes if "these samples are left out" in note]


@pytest.mark.thorough
@pytest.mark.parametrize("name", ["slide", "geared"])
@pytest.mark.parametrize("share", [0.05, 0.2, 0.6])
def test_estimates_from_clipped_torques_are_within_their_intervals(name: str, share: float) -> None:
    """4.5 standard deviations: of 63 scores of a normal distribution one is beyond in one run of 2000."""
    for seed in range(3):
        result = found(name, clipped(name, share, seed))
        (note,) = left_out(result)
        named = re.search(r"tau_. stays at .* N( m)? at (\S+) % of the samples", note)
        assert named and float(named[2]) == pytest.approx(100 * share, abs=3)
        assert np.abs(z_scores(name, result)).max() < 4.5


@pytest.mark.thorough
@pytest.mark.parametrize("name", ["slide", "geared"])
@pytest.mark.parametrize("share", [0.05, 0.6])
def test_intervals_from_clipped_torques_cover_the_truth(name: str, share: float) -> None:
    """30 draws: 95 % of the intervals of 1.96 standard deviations, but for chance (three standard deviations of it)."""
    beyond = np.abs([z_scores(name, found(name, clipped(name, share, seed))) for seed in range(200, 230)]) > 1.96
    assert beyond.mean() < 0.05 + 3 * np.sqrt(0.05 * 0.95 / len(beyond))


@pytest.mark.sampled(5)
@pytest.mark.parametrize("step", [0.0, 0.5, 2.0])
def test_whole_records_raise_no_alarm(step: float) -> None:
    for seed in range(3):
        assert not left_out(found("slide", clipped("slide", 0.0, seed, step)))


def test_a_motor_that_saturates_is_no_clipped_sensor() -> None:
    """The torque that the limit leaves moves the machine, so the other samples predict it; so do disturbances."""
    robot, Y = machine("slide")
    alarms = 0
    for seed in range(4):
        t, q, qd, _, ahead = motion("slide", seed)
        rng, most = np.random.default_rng(seed), np.quantile(np.abs(ahead), 0.995)
        x, v, w = q[0], qd[0], 16 * np.pi
        moved, torques = [], []
        for k, push in enumerate(1.5 * rng.normal(size=len(t))):
            u = float(np.clip(ahead[k] + 95 * w**2 * (q[k] - x) + 152 * w * (qd[k] - v), -most, most))
            moved.append(x)
            torques.append(u)
            for _ in range(4):
                v += PERIOD / 4 * (u + push - 120 * v - 25 * np.tanh(v / 1e-3)) / 95
                x += PERIOD / 4 * v
        encoder = np.round((np.array(moved) + 2e-6 * rng.normal(size=len(t))) / 5e-6) * 5e-6
        record = Measurements(t, encoder[:, None], np.array(torques)[:, None])
        assert stays(record.tau[:, 0]).any()
        alarms += bool(left_out(identify(robot, record, Y=Y)))
    assert alarms <= 1


def test_a_record_that_is_nearly_all_clipped_is_refused_by_name() -> None:
    with pytest.raises(InputError, match=r"tau_x stays at -\d.* at 97 % of the samples"):
        found("slide", clipped("slide", 0.97, 0))


RNG = np.random.default_rng(0)
T = PERIOD * np.arange(20_000)
SMOOTH = 3 * np.sin(np.pi * T) + 1.3 * np.sin(7 * T + 0.3)
NOISY = SMOOTH + 0.02 * RNG.normal(size=len(T))
RIGHT = {
    "smooth": SMOOTH, "noise": NOISY, "steps": np.round(SMOOTH / 0.05) * 0.05, "decimals": np.round(SMOOTH, 3),
    "noise in steps": np.round(NOISY / 0.05) * 0.05, "a sine of 40 steps": np.round(np.sin(T) * 20) / 20,
    "a dead band": np.where(np.abs(SMOOTH) < 1, 0, SMOOTH), "rest at zero": np.where(T < 5, 0, np.abs(SMOOTH) + 0.5),
    "a command of two values": 5 * np.sign(np.sin(3 * T)), "held": np.repeat(NOISY[::10], 10),
    "held in steps": np.repeat(np.round(NOISY[::10] / 0.05) * 0.05, 10), "constant": np.full(len(T), 2.0),
}  # fmt: skip


@pytest.mark.parametrize("name", RIGHT)
def test_right_columns_stay_nowhere(name: str) -> None:
    assert not stays(RIGHT[name]).any()


@pytest.mark.parametrize("name", ["smooth", "noise", "steps", "noise in steps", "decimals", "held", "held in steps"])
@pytest.mark.parametrize("share", [0.05, 0.2, 0.4])
def test_clipped_samples_are_named(name: str, share: float) -> None:
    """Where values are held for ten samples and have steps, 5 % are too few to tell an end from a peak."""
    x = RIGHT[name]
    if (name, share) == ("held in steps", 0.05):
        return
    most = np.quantile(np.abs(x), 1 - share)
    cut = np.clip(x, -most, most)
    assert stays(cut).mean() == pytest.approx((np.abs(cut) >= most * (1 - 1e-9)).mean(), abs=0.02)


@pytest.mark.parametrize(("count", "others"), [(4, 0), (6, 2), (12, 3)])
def test_few_equal_samples_at_an_end_are_clipped_where_no_other_value_repeats(count: int, others: int) -> None:
    """As in a short ring-down of a sensor with many bits; before, up to 14 of 800 samples were a peak."""
    x = np.exp(-T[:800]) * np.cos(300 * T[:800]) + 0.01 * np.random.default_rng(count).normal(size=800)
    ordered = np.sort(x)
    cut = np.clip(x, ordered[others - 1] if others else None, ordered[-count])
    assert not stays(x).any()
    assert stays(cut).sum() == count


def test_a_sensor_that_is_stuck_is_named() -> None:
    x = NOISY.copy()
    x[4000:4300] = x[4000]
    assert np.flatnonzero(stays(x)).tolist() == [*range(4000, 4300)]


# Positions and velocities


def moves(kind: str, seed: int) -> Array:
    """Return moves from rest to rest, with rests between: bang-bang, trapezoids of velocity, cosines."""
    rng, s = np.random.default_rng(seed), np.linspace(0, 1, 1000)
    ramp = np.minimum(s, 1 - s)
    speed = {"bang": ramp, "trapezoid": np.minimum(ramp, 0.1), "cosine": np.sin(np.pi * s)}[kind]
    shape = np.cumsum(speed) / speed.sum()
    parts = [(a + (b - a) * shape, np.full(rng.integers(50, 2000), b)) for a, b in pairwise(rng.normal(size=10))]
    return np.concatenate([x for both in parts for x in both])


def stick_slip(seed: int) -> Array:
    """Return positions of a mass with dry friction under a force that moves it now and then."""
    rng, dt = np.random.default_rng(seed), 1e-3
    t = dt * np.arange(15_000)
    force = sum(rng.normal() * np.sin(2 * np.pi * rng.uniform(0.2, 3) * t + rng.uniform(0, 6)) for _ in range(4))
    dry, x, v, found = rng.uniform(0.6, 1.8) * np.std(force), 0.0, 0.0, []
    for f in np.asarray(force).tolist():
        side = np.sign(v) or np.sign(f)
        if v or abs(f) > dry:
            after = v + dt * (f - side * dry - v) / 0.3
            v = after if after * side > 0 else 0.0
        x += dt * v
        found.append(x)
    return np.array(found)


@pytest.mark.sampled(2)
@pytest.mark.parametrize("step", [0.0, 1e-6, 1e-4, 1e-3])
def test_joints_that_rest_are_not_frozen(step: float) -> None:
    for seed in range(4):
        others = [motion(name, seed)[1] for name in TRUE]
        for x in (*(moves(kind, seed) for kind in ("bang", "trapezoid", "cosine")), stick_slip(seed), *others):
            assert not frozen(np.round(x / step) * step if step else x).any()


def frozen_at(q: Array, fault: float) -> Array:
    """Return positions that are clipped at a share of the samples, or do not change for some seconds, below zero."""
    if fault > 0:
        most = np.quantile(np.abs(q), 1 - fault)
        return np.clip(q, -most, most)
    x, count = q.copy(), round(-fault / PERIOD)
    x[8500 : 8500 + count] = x[8500]
    return x


@pytest.mark.sampled(12)
@pytest.mark.parametrize("name", TRUE)
@pytest.mark.parametrize("fault", [0.02, 0.2, -1.0, -0.1])
def test_positions_that_stay_amid_motion_are_left_out(name: str, fault: float) -> None:
    robot, _ = machine(name)
    joint = robot.joints[0].name
    for seed in range(3):
        whole = clipped(name, 0.0, seed)
        q = frozen_at(whole.q[:, 0], fault)
        share = fault if fault > 0 else -fault / SECONDS
        assert frozen(q).mean() == pytest.approx(share, abs=0.2 * share + 0.001)
        result = se.identify(robot, {"t": whole.t, f"q_{joint}": q, f"tau_{joint}": whole.tau[:, 0]}).found
        (note,) = left_out(result)
        assert note.startswith(f"q_{joint}: no change amid motion, as beyond the end of a sensor, at ")
        assert np.abs(z_scores(name, result)).max() < 4.5


@pytest.mark.thorough
def test_velocities_that_stay_at_their_ends_are_not_used() -> None:
    t, q, qd, _, tau = motion("slide", 0)
    most = np.quantile(np.abs(qd), 0.8)
    for velocity, said in ((qd, False), (np.clip(qd, -most, most), True)):
        record = {"t": t, "q_x": q, "tau_x": tau, "qd_x": velocity}
        notes = se.identify(machine("slide")[0], record).found.notes
        assert any(note.startswith("qd is not used: qd_x stays at its ends at 6000 of") for note in notes) == said


# Counters that wrap

ANGLE = 0.5 * np.sin(T) + 0.3 * np.sin(2.3 * T)


@pytest.mark.parametrize("period", [0.1, 0.3, 0.065536, 1.2])
@pytest.mark.parametrize("every", [1, 4])
@pytest.mark.parametrize("noise", [0.0, 1e-4])
def test_counters_that_wrap_are_named_with_their_period(period: float, every: int, noise: float) -> None:
    rng = np.random.default_rng(1)
    x = np.round((ANGLE[::every] + noise * rng.normal(size=len(ANGLE[::every]))) / 1e-6) * 1e-6
    wrapped = (x + period / 2) % period - period / 2
    wraps = wraps_of(T[::every], wrapped)
    assert wraps and wraps.period == pytest.approx(period, rel=0.01)
    assert np.abs(np.diff(wrapped))[wraps.first - 1] > 0.7 * period
    assert wraps.count == (np.abs(np.diff(wrapped)) > period / 2).sum()


def test_spikes_and_moves_are_no_wraps() -> None:
    lost, high = ANGLE.copy(), ANGLE.copy()
    lost[RNG.integers(0, len(T), 30)], high[RNG.integers(0, len(T), 30)] = 0.0, 5.0
    for x in (ANGLE, lost, high, np.round(ANGLE, 1), np.where(T < 5, 0, 0.1), np.round(ANGLE, 3)):
        assert wraps_of(T, x) is None


@pytest.mark.parametrize("every", [1, 4])
def test_a_slide_whose_counter_wraps_is_refused_with_the_jump(every: int) -> None:
    """16 bits of 1 um: 65.536 mm."""
    robot, _ = machine("slide")
    t, q, _, _, tau = motion("slide", 0)
    counts = (np.round(q / 1e-6) + 32768) % 65536 - 32768
    columns = {"t": t[::every], "q_x [um]": counts[::every], "tau_x": tau[::every]}
    with pytest.raises(InputError, match=r"q_x: jumps by 0\.0655\d* m \d+ times, first at sample \d+ .*: unwrap it"):
        measurements_of(columns, robot, "log.csv")
