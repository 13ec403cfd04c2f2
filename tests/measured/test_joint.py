"""Logs and vibration tests in one fit: of a slide that a motor moves through a spring, by formulas of two masses."""

from __future__ import annotations

import json
import math
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import symoro_elastic as se
from symoro_elastic.analysis.time_series.measurements import Measurements
from symoro_elastic.measured.fitting.estimates import Verdict
from symoro_elastic.measured.fitting.evidence import Evidence
from symoro_elastic.measured.joint import Log, fit_jointly
from symoro_elastic.measured.logs.identify import LogSettings, identify
from symoro_elastic.measured.vibration_tests.measured import MeasuredResponse, VibrationTest, VibrationTests
from symoro_elastic.measured.vibration_tests.updated import Settings
from tests.benchmarks.joint import TABLE
from tests.benchmarks.tables import stored
from tests.command_line import run
from tests.references.vibrating_tables import with_labels

TRUTH = {"slide.mass": 25.0, "table.mass": 40.0, "table.stiffness": 2e6, "table.damping": 900.0, "slide.viscous": 120.0}
TABLES: dict[str, Any] = {
    "name": "feed", "gravity": [0, 0, 0],
    "joints": [
        {"name": "slide", "kind": "motor", "sigma": 1, "antecedent": 0, "r": "x"},
        {"name": "table", "kind": "elastic", "sigma": 1, "antecedent": "slide", "r": "e"},
    ],
    "bodies": {"slide": {"mass": 25.0}, "table": {"mass": 40.0}},
    "springs": {"table": {"stiffness": 2e6, "damping": 900.0}},
    "friction": {"slide": {"viscous": 120.0, "coulomb": 30.0}},
}  # fmt: skip
F = np.geomspace(8.0, 120.0, 120)
NOISE, AVERAGES, TORQUE_NOISE = 0.02, 20, 4.0
OF_LOG = LogSettings(offsets="never", delay="never", is_evidence=True)


def receptances() -> Any:
    """Positions (N, 2, 2) of slide and of table against it, by forces on the slide and on the table, in frame 0."""
    m1, m2, k, d, v = TRUTH.values()
    s = 2j * np.pi * F[:, None, None]
    M = np.array([[m1 + m2, m2], [m2, m2]])  # coordinates x and e
    return np.linalg.inv(s**2 * M + s * np.diag([v, d]) + np.diag([0.0, k])), s


def hammer(seed: int) -> VibrationTest:
    """A blow on the table: accelerations of table and slide."""
    rng = np.random.default_rng([seed, 1])
    G, s = receptances()
    on_table = np.array([1.0, 1.0])  # generalized force of a force on the table
    x, e = (s**2 * G)[:, 0] @ on_table, (s**2 * G)[:, 1] @ on_table
    responses = []
    for name, exact in (("slide", x), ("table", x + e)):
        sd = NOISE * np.hypot(np.abs(exact), np.median(np.abs(exact))) / math.sqrt(2)
        H = exact + sd * (rng.normal(size=len(F)) + 1j * rng.normal(size=len(F)))
        coherence = 1 / (1 + 2 * (AVERAGES - 1) * (sd / np.abs(H)) ** 2)
        responses.append(MeasuredResponse(f"{name}.az", "table.fz", F, H, coherence))
    return VibrationTest("hammer", {}, averages=AVERAGES, responses=tuple(responses))


@cache
def motion() -> tuple[Any, ...]:
    """A slow motion, at which the spring follows its inertia force: t, x, e, force of the motor."""
    t = np.arange(0, 12, 0.002)
    phases, amplitudes = np.array([0.3, 1.2, 2.1]), np.array([0.1, 0.06, 0.03])
    w = 2 * np.pi * np.array([0.4, 0.9, 1.7])
    m1, m2, k, d, v = TRUTH.values()
    h = w * 1j
    x_h = amplitudes * np.exp(1j * phases)
    e_h = -m2 * h**2 * x_h / (m2 * h**2 + d * h + k)  # exact for each harmonic
    waves = np.exp(np.outer(t, h))
    x, e, xd = (np.real(waves @ y) for y in (x_h, e_h, h * x_h))
    force = np.real(waves @ (((m1 + m2) * h**2 + v * h) * x_h + m2 * h**2 * e_h)) + 30.0 * np.sign(xd)
    return t, x, e, force


def log(seed: int) -> dict[str, Any]:
    rng = np.random.default_rng([seed, 2])
    t, x, e, force = motion()
    q = x + 1e-7 * rng.normal(size=len(t)), e + 1e-9 * rng.normal(size=len(t))
    return {"t": t, "q_slide": q[0], "q_table": q[1], "tau_slide": force + TORQUE_NOISE * rng.normal(size=len(t))}


def measured(columns: dict[str, Any]) -> Measurements:
    q = np.column_stack([columns["q_slide"], columns["q_table"]])
    return Measurements(columns["t"], q, columns["tau_slide"][:, None])


def fits(seed: int) -> tuple[Any, Any, Any]:
    """The log alone, the tests alone with masses in doubt, both; the file is off by up to 1.3."""
    rng = np.random.default_rng(seed)
    off = with_labels(TABLES, {label: x * 1.3 ** rng.uniform(-1, 1) for label, x in TRUTH.items()})
    machine, tests = se.read(off), [hammer(seed)]
    alone = se.update(machine, tests=tests, mass_doubt=0.3)
    identified = identify(machine, measured(log(seed)), OF_LOG)
    return identified, alone, fit_jointly(machine, Log(identified), VibrationTests(tuple(tests)), Settings())


def stds(estimates: Any) -> dict[str, float]:
    return {e.unknown.label: e.relative for e in estimates if e.unknown.label in TRUTH}


def test_both_together_are_nearer_than_either() -> None:
    identified, alone, joint = fits(0)
    of_both, of_tests = stds(joint.estimates), stds(alone.estimates)
    assert set(of_both) == set(TRUTH)
    assert all(of_both[label] < of_tests[label] for label in of_tests)
    assert of_both["slide.viscous"] < of_tests["slide.viscous"] / 10
    assert identified.estimation["K2"].verdict is Verdict.NOT
    assert not any("contradict" in note for note in joint.notes)


@pytest.mark.thorough
def test_intervals_of_the_joint_fit_cover_the_truth() -> None:
    """Of 95 %, over drawn noise and files: between 0.90 and 0.99 of 40 times 5 values."""
    inside = [
        abs(math.log(e.value / TRUTH[e.unknown.label])) < 1.96 * e.relative
        for seed in range(40)
        for e in fits(seed)[2].estimates
    ]
    assert 0.90 < np.mean(inside) < 0.99


def test_a_log_with_another_gain_contradicts_the_tests() -> None:
    """Forces in another unit scale the masses by the log, and those of the tests' forces do not follow."""
    machine = se.read(TABLES)
    wrong = {**log(0), "tau_slide": 0.7 * log(0)["tau_slide"]}
    identified = identify(machine, measured(wrong), OF_LOG)
    joint = fit_jointly(machine, Log(identified), VibrationTests((hammer(0),)), Settings())
    assert any("the log and the tests contradict each other" in note for note in joint.notes)


def test_evidence_has_unit_residuals_and_right_slopes() -> None:
    C = np.array([[4.0, 1.0], [1.0, 9.0]])
    evidence = Evidence.of(lambda x: np.array([np.exp(x[0]) + x[1], x[1] ** 2]), np.array([1.0, 2.0]), C)
    x = np.array([0.2, 0.7])
    r, J = evidence.residuals(x)
    apart = evidence.theta(x) - evidence.values
    assert r @ r == pytest.approx(apart @ np.linalg.solve(C, apart))
    slopes = np.array([[np.exp(0.2), 1.0], [0.0, 1.4]])
    np.testing.assert_allclose(J @ J.T, slopes.T @ np.linalg.solve(C, slopes), rtol=1e-8)


def test_covariances_that_are_not_positive_definite_by_their_own_error_are_widened() -> None:
    """Of three estimates whose correlations are those of no distribution; a right one stays as it is."""
    std = np.array([2.0, 0.5, 10.0])
    wrong = np.outer(std, std) * np.array([[1.0, 0.9, 0.2], [0.9, 1.0, -0.3], [0.2, -0.3, 1.0]])
    assert np.linalg.eigvalsh(wrong).min() < 0
    root = Evidence.of(lambda x: x, np.zeros(3), wrong).root
    used = np.linalg.inv(root.T @ root)
    assert np.linalg.eigvalsh(used - wrong).min() > 0 and np.linalg.eigvalsh(used).min() > 0
    right = np.outer(std, std) * np.array([[1.0, 0.9, 0.2], [0.9, 1.0, 0.3], [0.2, 0.3, 1.0]])
    root = Evidence.of(lambda x: x, np.zeros(3), right).root
    np.testing.assert_allclose(np.linalg.inv(root.T @ root), right, rtol=1e-12)


@pytest.mark.parametrize("name", list(TABLE))
def test_stored_joint_fits_are_nearer_than_either(name: str) -> None:
    """Standard deviations over those of the tests alone and of the log alone, of three machines."""
    _, of_tests, largest_of_tests, of_log, largest_of_log = zip(
        *(run.metrics for run in stored("joint")[name]), strict=True
    )
    assert max(of_tests) < 1 and max(of_log) < 1
    assert max(largest_of_tests) < 1.05 and max(largest_of_log) < 1.05


@pytest.mark.thorough
def test_the_command_takes_logs_and_lists_together(tmp_path: Path) -> None:
    se.write(se.read(TABLES), tmp_path / "feed.toml")
    columns = log(0)
    rows = np.column_stack([columns[name] for name in columns])
    np.savetxt(tmp_path / "log.csv", rows, delimiter=",", header=",".join(columns), comments="")
    write_hammer(tmp_path, hammer(0))
    done = run("identify", tmp_path / "feed.toml", tmp_path / "log.csv", tmp_path / "tests.toml", "--json")
    assert done.exit_code == 0, done.output
    estimates = json.loads(done.stdout)["estimates"]
    for label, x in TRUTH.items():
        assert abs(math.log(estimates[label]["value"] / x)) < 4 * estimates[label]["relative_std"]
    with pytest.raises(se.InputError, match=r"tests\.toml: records: vibration tests without a log: use update"):
        se.identify(tmp_path / "feed.toml", tmp_path / "tests.toml")


def write_hammer(folder: Path, test: VibrationTest) -> None:
    """The list and the file of a test."""
    heads, columns = ["f [Hz]"], [test.responses[0].f]
    for r in test.responses:
        heads += [f"re {r.pair}", f"im {r.pair}", f"coherence {r.pair}"]
        columns += [r.H.real, r.H.imag, r.coherence if r.coherence is not None else np.ones(len(r.f))]
    np.savetxt(folder / "hammer.csv", np.column_stack(columns), delimiter=",", header=",".join(heads), comments="")
    entry = f'[[tests]]\nfile = "hammer.csv"\naverages = {test.averages}\nwindow = "none"\n'
    (folder / "tests.toml").write_text(entry, encoding="utf-8")
