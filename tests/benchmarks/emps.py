"""The electro-mechanical positioning system of Janot, Gautier and Brunot: `python -m tests.benchmarks.emps FILE.mat`.

"Data Set and Reference Models of EMPS", Workshop on Nonlinear System Identification Benchmarks, Eindhoven, 2019
(https://www.nonlinearbenchmark.org/benchmarks/emps). FILE is a record with qm, qg, vir, gtau and the published
simulation q_s, as `nlid_emps_sim_data_training.mat` of github.com/meco-group/nlgreyfast has them. Printed are errors of
both simulations with the published parameters, and parameters that are identified.
"""

from __future__ import annotations

import csv
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

import symoro_elastic as se

M1, FV1, FC1 = 95.1089, 203.5034, 20.3935
KP, KV, VOLTS, PERIOD = 160.18, 243.45, 10.0, 1e-3
CREEP = 1e-4
"""Velocity, m/s, within which dry friction rises; reversals of the record take 0.01 s at 0.8 m/s2."""


def axis(gtau: float) -> dict[str, Any]:
    """The axis with its sampled drive: position and velocity controllers, a delay of a period, the limit of voltage."""
    drive = {"Kv": KP, "Kp": KV * gtau, "feed_forward": {"velocity": 0}, "period": PERIOD, "dead_time": PERIOD}
    return {
        "name": "emps",
        "gravity": [0, 0, 0],
        "joints": [{"name": "slide", "kind": "motor", "sigma": 1, "r": "x"}],
        "bodies": {"slide": {"mass": M1}},
        "friction": {"slide": {"viscous": FV1, "coulomb": FC1, "creep": CREEP}},
        "drives": {"slide": drive | {"limits": {"torque": VOLTS * gtau}}},
        "wanted": {"outputs": ["slide.q"]},
    }


def simulated(record: dict[str, Any], step: float) -> tuple[Any, float]:
    """Return the position at the samples of the record, m, and the error of the steps."""
    t = PERIOD * np.arange(len(record["qm"]))
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "set_point.csv"
        with file.open("w", newline="") as text:
            csv.writer(text).writerows([("t", "q_slide"), *zip(t, record["qg"], strict=True)])
        motion = {"file": str(file), "duration": float(t[-1]), "drives": True}
        (found,) = se.simulate(axis(float(record["gtau"][0])) | {"motion": [motion]}, method="w3", step=step)
    return np.interp(t, found.motion.t, found.outputs[:, 0]), found.errors["slide.q"]


def main() -> None:
    """Print errors relative to the record, and estimates."""
    from scipy.io import loadmat

    record = {name: np.ravel(x) for name, x in loadmat(sys.argv[1]).items() if not name.startswith("__")}
    qm = record["qm"]
    q, of_steps = simulated(record, 5e-4)
    for name, x in (("published", record["q_s"]), ("here", q)):
        error = qm - x
        share = 100 * np.linalg.norm(error) / np.linalg.norm(qm)
        print(f"{name}: position {share:.4f} % off, rms {1e6 * np.sqrt(np.mean(error**2)):.1f} um")
    print(f"error of steps {of_steps:.1e} m")
    force = record["gtau"] * record["vir"]
    machine = {name: x for name, x in axis(1.0).items() if name not in ("drives", "friction", "wanted")}
    found = se.identify(machine, {"t": record["t"], "q_slide": qm, "tau_slide": force})
    for one in found.found.estimates:
        print(f"{one.unknown.label} {one.value:.4g} +- {one.std:.2g} {one.unknown.unit}")


if __name__ == "__main__":
    main()
