"""How far possible bodies are from the truth, by standard deviations from data and with the file:
`python -m tests.benchmarks.possible [--store] [--stored]`; without options, the stored table is printed.

An arm of three joints with dry friction; motion, noise of torques, zeros of encoders (17 bits) and the file, its bodies
wrong by 30 %, are drawn anew in each run. Least squares rejects records of two seconds. Records of six seconds have
faults of sensors, bodies off by about 2, or a deviation that is named wrongly.
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache

import numpy as np

from symoro_elastic.analysis.time_series.measurements import Measurements
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import Body, Machine
from symoro_elastic.measured.logs.identify import LogSettings, identify
from symoro_elastic.measured.logs.pseudo_inertia import inertial_parameters, pseudo_inertia
from symoro_elastic.mechanics.regressor import INERTIAL
from symoro_elastic.numerics.linear.regressor import nominal_body, regressor
from tests.benchmarks.identification import FAULTS, bare, run_of_log
from tests.benchmarks.sensors import Sensing, three_axis
from tests.benchmarks.tables import Run, print_or_run_table

WRONG = 0.3  # relative deviation of the bodies of a file
TRUST = 0.3
TWICE = 1.0
"""Relative deviation of bodies whose masses are off by a factor of about 2."""
ROWS: dict[str, tuple[float, float | None, str, float]] = {
    "2 s, least squares": (2.0, None, "", WRONG),
    "2 s": (2.0, math.inf, "", WRONG), "2 s, with file": (2.0, TRUST, "", WRONG),
    "6 s, least squares": (6.0, None, "", WRONG), "6 s": (6.0, math.inf, "", WRONG),
    "6 s, with file": (6.0, TRUST, "", WRONG), "20 s": (20.0, math.inf, "", WRONG),
    **{f"6 s, {fault}": (6.0, math.inf, fault, WRONG) for fault in FAULTS},
    **{f"6 s, with file, {fault}": (6.0, TRUST, fault, WRONG) for fault in FAULTS},
    "6 s, off by 2": (6.0, math.inf, "", TWICE), "6 s, with file, off by 2": (6.0, TWICE, "", TWICE),
    "6 s, with file, 0.1 named": (6.0, 0.1, "", WRONG), "2 s, with file, 0.1 named": (2.0, 0.1, "", WRONG),
}  # fmt: skip
"""Seconds, trust, fault of sensors and deviation of the file, by row of the stored table."""
TABLE = dict.fromkeys(ROWS, 8)


def off(machine: Machine, share: float, seed: int) -> Machine:
    """Return a machine whose bodies are wrong by a share, and possible."""
    rng = np.random.default_rng(seed)
    values = {p.name: p.value.value() for p in machine.parameters if p.value is not None}
    joints = []
    for joint in machine.joints:
        x = nominal_body(joint.body, values)
        L = np.linalg.cholesky(pseudo_inertia(np.array([x[name] for name in INERTIAL])))
        spread = np.eye(4) + rng.normal(scale=share / 2, size=(4, 4))
        moved = inertial_parameters(L @ spread @ spread.T @ L.T)
        xx, xy, xz, yy, yz, zz, mx, my, mz, m = (Formula.parse(float(v)) for v in moved)
        joints.append(replace(joint, body=Body(m, (mx, my, mz), (xx, xy, xz, yy, yz, zz))))
    return replace(machine, joints=tuple(joints))


def cut(record: Measurements, seconds: float) -> Measurements:
    """Return the first seconds of a record."""
    inside = record.t <= seconds
    return replace(record, t=record.t[inside], q=record.q[inside], tau=record.tau[inside])


@cache
def _truth() -> dict[str, float]:
    arm = three_axis()
    whole = identify(arm.machine, arm.record(Sensing(), 0), Y=arm.regressor)
    return {bare(e.unknown.label): e.unknown.nominal for e in whole.estimates}


def table_run(row: str, seed: int) -> Run:
    """Return a run of a row of the stored table."""
    seconds, trust, fault, deviation = ROWS[row]
    arm = three_axis()
    record = cut(arm.record(Sensing(), seed), seconds)
    if fault:
        record = FAULTS[fault].change(record, np.random.default_rng([seed, 5]))
    machine = off(arm.machine, deviation, seed)
    Y = regressor(machine)
    reported = FAULTS[fault].reported if fault else ""
    return run_of_log(seed, lambda: identify(machine, record, LogSettings(trust=trust), Y=Y), reported, _truth())


def main() -> None:
    print_or_run_table("possible", TABLE, table_run)


if __name__ == "__main__":
    main()
