"""The example of optimal control: the arm ends at rest, within its limits, where finer steps end, too."""

from __future__ import annotations

import importlib.util
from types import ModuleType

import numpy as np
import pytest

import symoro_elastic as se
from symoro_elastic.codegen.integration.tableaus import RK4, step
from tests.golden import ROOT

casadi = pytest.importorskip("casadi")
FINER = 20
LIMIT = 0.4


@pytest.fixture(scope="module")
def example() -> ModuleType:
    if not casadi.has_nlpsol("ipopt"):
        pytest.skip("this CasADi has no IPOPT")
    spec = importlib.util.spec_from_file_location("optimal_arm", ROOT / "examples" / "optimal_arm.py")
    assert spec and spec.loader
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_optimum_ends_at_rest_within_its_limits(example: ModuleType) -> None:
    """Its torques, linear in each interval, on the functions on numpy by steps a fifth as long.

    What is left of the swing is the error of its own steps, less than a hundredth of the limit.
    """
    x = example.by_ipopt(example.problem(LIMIT))
    n, intervals = example.N, example.INTERVALS
    numpy_model = se.load(example.ARM, "direct_dynamics", scene={"locked": {"waist": 0.0, "wrist": 0.0}})
    swings = np.abs(x[n : 2 * n][example.SPRINGS]).max(axis=1)
    assert swings.max() == pytest.approx(LIMIT, rel=1e-6)
    h, y = example.DURATION / intervals, np.array([x[:n, 0], x[n : 2 * n, 0]])
    at_rest = numpy_model.direct_dynamics(y[0], y[1], x[2 * n :, 0])
    np.testing.assert_allclose(at_rest, 0.0, atol=1e-9)
    for before, after in zip(x[2 * n :, :-1].T, x[2 * n :, 1:].T, strict=True):

        def rate(t: float, y: np.ndarray, before: np.ndarray = before, after: np.ndarray = after) -> np.ndarray:
            return np.array([y[1], numpy_model.direct_dynamics(*y, before + (after - before) * t / h)])

        for k in range(FINER):
            y = step(RK4, rate, k * h / FINER, y, h / FINER)
    np.testing.assert_allclose(y[0], x[:n, -1], atol=1e-3 * LIMIT)
    np.testing.assert_allclose(y[1], 0.0, atol=1e-2 * LIMIT)
