"""What single precision of the right side costs is estimated: against compiled C in single precision."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from symoro_elastic.analysis.ladder.predicted_rungs import single_precision_errors
from symoro_elastic.analysis.simulation.prediction.path import linear_path
from symoro_elastic.analysis.simulation.reference_motion import Reference
from symoro_elastic.codegen.compile import CompiledPackage, compile_package
from symoro_elastic.codegen.integration.tableaus import RK4, step
from symoro_elastic.codegen.precision import DOUBLE, SINGLE
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.machine.scene import Scene
from symoro_elastic.models.packaging import trace_models
from tests.analysis.ladder.scenes import moving, random_springs

STEPS = 150


def springs_moved(compiled: CompiledPackage, reference: Reference) -> Array:
    """q (STEPS + 1, n) by RK4, states in double, motors where they are prescribed to be."""
    motors, n = list(reference.machine.motor_entries), len(reference.start.q)
    h = reference.duration / STEPS

    def placed(t: float, y: Array) -> Array:
        found = y.copy()
        found[motors], found[[n + k for k in motors]] = (x[0] for x in reference.at(np.array([t]))[:2])
        return found

    def rate(t: float, y: Array) -> Array:
        q, qd = np.split(placed(t, y), 2)
        ydd = reference.at(np.array([t]))[2][0]
        return np.concatenate([qd, compiled.call("inverse_dynamics", q=q, qd=qd, qdd_motor=ydd)["qdd"]])

    y = [np.concatenate([reference.start.q, reference.start.qd])]
    for k in range(STEPS):
        y.append(placed((k + 1) * h, step(RK4, rate, k * h, y[-1], h)))
    return np.array(y)[:, :n]


def test_the_estimate_is_of_the_size_of_the_error(tmp_path: Path) -> None:
    """Between a fifth of the error and five times it: roundings are not random numbers."""
    scene = moving("random", random_springs(1, 6, (30, 50, 70)), 0.3, 0.15, 1e-5)
    package = trace_models(scene.reference.machine, Scene(models=("inverse_dynamics", "geometric_model"))).package
    double, single = (
        compile_package(package, tmp_path / precision.name, precision=precision, flags=("-O1",))
        for precision in (DOUBLE, SINGLE)
    )
    exact, rounded = (
        double.call("geometric_model", q=springs_moved(compiled, scene.reference))["T"][:, -1, :3, 3]
        for compiled in (double, single)
    )
    found = np.abs(rounded - exact).max(axis=0)
    estimated = single_precision_errors(linear_path(scene.reference, scene.outputs, 200), STEPS)
    ratios = found / np.array(list(estimated.values()))
    assert ((ratios > 0.2) & (ratios < 5)).all()
