"""Monte Carlo of joint fits: a lathe, the two-axis machine and an elastic arm, by a log and by hammer tests.

    python -m tests.benchmarks.joint [--store] [--stored] [--row lathe]

Responses are by another program, logs by a simulated machine under control, with noise of sensors. Files are
off by factors up to 1.3, uniform in the logarithm, masses included. Of each machine: intervals of 95 % of springs,
dampings and viscous friction, and chi2, medians and largest of their standard deviations over those of the tests alone
(masses within a factor 2, as in the joint fit) and of the log alone. Without options, the stored table is printed.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from statistics import median
from typing import Any

import numpy as np

import symoro_elastic as se
from symoro_elastic.analysis.simulation.simulated_measurements import Controller, Sensors, measure, simulate
from symoro_elastic.analysis.time_series.measurements import Measurements
from symoro_elastic.measured.joint import Log, fit_jointly
from symoro_elastic.measured.logs.identify import LogSettings, identify
from symoro_elastic.measured.logs.result import Identification
from symoro_elastic.measured.vibration_tests.measured import VibrationTests
from symoro_elastic.measured.vibration_tests.updated import Settings
from tests.benchmarks.tables import Error, Run, print_or_run_table, run_of
from tests.benchmarks.updating import CASES, Case, exact_responses, labels_of, measured
from tests.references.vibrating_tables import with_labels

TABLE = {"lathe": 12, "two_axis": 8, "elastic arm": 8}
"""Numbers of runs by row of the stored table."""
OFF = 1.3
"""Largest factor between a file and the truth."""
OF_LOG = LogSettings(offsets="never", delay="never", is_evidence=True)
QUANTITIES = {"stiffness": "K", "damping": "DA", "viscous": "FV"}
"""Quantities of a log by those of tests."""


@dataclass(frozen=True)
class LoggedCase:
    """Hammer tests of a machine, and its log: centres and strokes of motors (rad or m), Hz, noises, step of encoders.

    `inertias` are those of the controller's motors; encoders of springs are finer by 100.
    """

    case: Case
    centres: Sequence[float]
    strokes: Sequence[Sequence[float]]
    frequencies: Sequence[Sequence[float]]
    inertias: Sequence[float]
    torque_noise: float
    step: float
    duration: float = 6.0
    sampling: float = 2000.0
    substeps: int = 2


LOGGED = {
    "lathe": LoggedCase(
        CASES["lathe"], (0.2, 0.1), ((0.06, 0.01, 0.002), (0.05, 0.008, 0.002)),
        ((0.5, 2.0, 7.0), (0.6, 2.4, 9.0)), (600.0, 240.0), 10.0, 1e-7,
    ),
    "two_axis": LoggedCase(
        CASES["two_axis"], (0.3, 0.1), ((0.04, 0.008, 0.0012), (0.06, 0.006, 0.0015)),
        ((1.0, 4.0, 11.0), (1.0, 3.0, 13.0)), (460.0, 490.0), 10.0, 1e-7, 3.0, 2500.0, 4,
    ),
    "elastic arm": LoggedCase(
        CASES["milling arm"], (0.0, -0.7, 0.6), ((0.5, 0.15, 0.03), (0.4, 0.12, 0.03), (0.5, 0.15, 0.03)),
        ((0.4, 1.1, 3.0), (0.5, 1.3, 2.6), (0.6, 1.5, 3.4)), (100.0, 100.0, 40.0), 2.0, 1e-6,
    ),
}  # fmt: skip


@cache
def exact_log(name: str) -> Measurements:
    """The log of the true machine, without noise."""
    logged = LOGGED[name]
    w, strokes = 2 * np.pi * np.array(logged.frequencies), np.array(logged.strokes)
    phases = np.outer(1 + np.arange(len(w)), np.arange(w.shape[1]))
    centres = np.array(logged.centres)

    def reference(t: float) -> tuple[Any, Any, Any]:
        sine, cosine = np.sin(w * t + phases), np.cos(w * t + phases)
        q = centres + (strokes * sine).sum(axis=1)
        return q, (strokes * w * cosine).sum(axis=1), -(strokes * w**2 * sine).sum(axis=1)

    controller = Controller.of_bandwidth(logged.inertias, frequency=8.0)
    machine = se.read(dict(logged.case.tables))
    return simulate(machine, {}, reference, controller, logged.duration, logged.sampling, logged.substeps, settle=1.0)


def log(name: str, seed: int) -> Measurements:
    """The log with noise of its sensors."""
    logged = LOGGED[name]
    machine = se.read(dict(logged.case.tables))
    motors = {machine.independent.index(j) for j in machine.motors}
    step = np.array([logged.step if k in motors else logged.step / 100 for k in range(len(machine.independent))])
    noise = np.full(len(machine.motors), logged.torque_noise)
    return measure(exact_log(name), Sensors(step, step / 2, noise), seed)


def of_log(identified: Identification) -> dict[str, float]:
    """Relative standard deviations of a log by the labels of tests, by the equations that noise does not spoil."""
    estimation = identified.driven or identified.estimation
    labels = {quantity: label for label, quantity in QUANTITIES.items()}
    return {
        f"{e.unknown.joint}.{labels[e.unknown.quantity]}": e.relative
        for e in estimation.estimates
        if e.unknown.quantity in labels and math.isfinite(e.relative)
    }


def table_run(row: str, seed: int) -> Run:
    """Return the run of a joint fit; chi2, median and largest of its standard deviations over those of each alone."""
    case = LOGGED[row].case
    rng, truth = np.random.default_rng([seed, 3]), labels_of(case.tables)
    masses = {f"{joint}.mass": float(body["mass"]) for joint, body in case.tables["bodies"].items() if "mass" in body}
    off = {label: x * OFF ** rng.uniform(-1, 1) for label, x in {**truth, **masses}.items()}
    machine = se.read(with_labels(case.tables, off))
    tests = measured(case, exact_responses(case), rng)
    identified = identify(machine, log(row, seed), OF_LOG)
    by_tests = {
        e.unknown.label: e.relative for e in se.update(machine, tests=tests, mass_doubt=math.log(2.0)).estimates
    }
    joint = fit_jointly(machine, Log(identified), VibrationTests(tuple(tests)), Settings())
    estimates = {e.unknown.label: e for e in joint.estimates if e.unknown.label in truth}
    by_log = of_log(identified)
    ratios = [
        [estimates[label].relative / std for label, std in alone.items() if label in estimates]
        for alone in (by_tests, by_log)
    ]
    errors = [
        Error(math.log(e.value / truth[label]), e.relative if is_identified else math.nan, 1.0, is_identified)
        for label, e in estimates.items()
        for is_identified in (e.verdict == "identified",)
    ]
    return run_of(seed, "accepted", errors, [joint.fit.chi2, *(f(x) for x in ratios for f in (median, max))])


def main() -> None:
    """Run or print the table."""
    print_or_run_table("joint", TABLE, table_run)


if __name__ == "__main__":
    main()
