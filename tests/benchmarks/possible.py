"""How far possible bodies are from the truth, in standard deviations from data and with the file:
`python -m tests.benchmarks.possible [--runs N] [--trust SHARE] [--only SECONDS ...] [--json FILE]`.

An arm of three joints with dry friction; motion, noise of torques, zeros of encoders (17 bits) and the file, its bodies
wrong by 30 %, are drawn anew in each run. Least squares takes no record of two seconds.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from symoro_elastic.analysis.identification.identify import Identification, identify
from symoro_elastic.analysis.identification.pseudo_inertia import inertial_parameters, pseudo_inertia
from symoro_elastic.analysis.identification.regression import nominal_body, regressor
from symoro_elastic.analysis.time_series.measurements import Measurements
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import Body, Machine
from symoro_elastic.mechanics.regressor import INERTIAL
from tests.benchmarks.sensors import Sensing, three_axis
from tests.benchmarks.tables import print_table, progress, save_json

RUNS, WRONG, TRUST = 30, 0.3, 0.3
SECONDS = (2.0, 6.0, 20.0)
ALONE, WITH_FILE, PLAIN = "possible", "possible, with file", "least squares"


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


@dataclass
class Errors:
    """Errors over the standard deviations that are stated, and over those of least squares; widths over the latter."""

    z: list[float] = field(default_factory=list)
    of_data: list[float] = field(default_factory=list)
    widths: list[float] = field(default_factory=list)
    refused: int = 0

    def add(self, found: Identification, truth: Sequence[float], with_file: bool) -> None:
        """Add the estimates of a run; offsets, which are zero, follow those of the machine."""
        stated = found.possible.with_file if with_file and found.possible else [e.std for e in found.estimates]
        for e, std, true in zip(found.estimates, stated, truth, strict=False):
            if math.isfinite(std) and math.isfinite(true):
                self.z.append((e.value - true) / std)
                self.of_data.append((e.value - true) / e.std)
                self.widths.append(std / e.std)

    @property
    def figures(self) -> dict[str, Any]:
        """Share within 1.96 standard deviations, errors over those of least squares, median width over theirs."""
        if not self.z:
            return {"refused": self.refused, "estimates": 0}
        z, own = np.array(self.z), np.array(self.of_data)
        own = own[np.isfinite(own)]
        return {
            "refused": self.refused, "estimates": len(z), "within 95 %": float((np.abs(z) < 1.96).mean()),
            "rms": float(np.sqrt((z**2).mean())), "error / least squares": float(np.sqrt((own**2).mean())),
            "median width": float(np.nanmedian(self.widths)),
        }  # fmt: skip


def errors(seconds: float, runs: int, trust: float) -> dict[str, Errors]:
    """Return how far estimates of some runs are from the truth, by way."""
    arm, found = three_axis(), {way: Errors() for way in (PLAIN, ALONE, WITH_FILE)}
    whole = identify(arm.machine, arm.record(Sensing(), 0), Y=arm.regressor)
    truth = [e.unknown.nominal for e in whole.estimates]
    for seed in progress(range(runs), f"{seconds:g} s"):
        machine, record = off(arm.machine, WRONG, seed), cut(arm.record(Sensing(), seed), seconds)
        Y = regressor(machine)
        for way, trusted in ((PLAIN, None), (ALONE, math.inf), (WITH_FILE, trust)):
            try:
                one = identify(machine, record, Y=Y, trust=trusted)
            except InputError:
                found[way].refused += 1
                continue
            found[way].add(one, truth, way == WITH_FILE)
    return found


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m tests.benchmarks.possible", description=__doc__)
    parser.add_argument("--runs", type=int, default=RUNS)
    parser.add_argument("--trust", type=float, default=TRUST)
    parser.add_argument("--only", nargs="*", type=float, default=SECONDS)
    parser.add_argument("--json", type=Path, help="save the figures")
    given = parser.parse_args()
    found: dict[str, dict[str, Any]] = {}
    for seconds in given.only:
        each = errors(seconds, given.runs, given.trust)
        found |= {f"{seconds:g} s, {way}": one.figures for way, one in each.items()}
        if given.json:
            save_json(given.json, found)
    heads = ("record, way", *max(found.values(), key=len))
    rows = [(t, *(f"{x:.3g}" if isinstance(x, float) else str(x) for x in f.values())) for t, f in found.items()]
    print_table("truth within standard deviations", heads, rows)


if __name__ == "__main__":
    main()
