"""Steps of a gear with backlash: energy of free rattling, orders against scipy."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.machine.described import DescribedMachine
from symoro_elastic.machine.formula import Formula
from symoro_elastic.numerics.verification.implementations import numpy_model
from tests.analysis.simulation.test_bristle_steps import Steps
from tests.models.test_backlash import geared

pytestmark = pytest.mark.thorough


def rattling(**cells: str) -> DescribedMachine:
    """The example without gravity."""
    machine = geared(**cells)
    return DescribedMachine.of(replace(machine, base=replace(machine.base, gravity=(Formula.parse(0),) * 3)))


def states(machine: DescribedMachine, method: str, h: float, until: float, folder: Path) -> Array:
    """q and qd after each step from rest of the motor, while the gear crosses its play at 1 rad/s."""
    steps, count = Steps(machine, method, "", folder), round(until / h)
    start = [np.zeros(2), np.array([0.0, 1.0])]
    zero = np.zeros((count, len(steps.nodes)))
    return np.vstack([[0.0, 0.0, 0.0, 1.0], steps.run(count, h, {"tau": zero, "taud": zero}, start)])


@pytest.mark.parametrize("method", ["w2", "w3", "rk4", "rodas4"])
def test_free_rattling_gains_no_energy(method: str, tmp_path: Path) -> None:
    """2 s, some 500 impacts without damping: at most 5e-4 above the start."""
    machine = rattling(damping="0")
    found = states(machine, method, 2.5e-5, 2.0, tmp_path)
    q, qd = found[:, :2], found[:, 2:]
    energy = numpy_model(machine, ("energy",)).energy(q, qd).sum(axis=1)
    assert np.count_nonzero(np.diff(np.sign(q[:, 1]))) > 300
    assert (energy / energy[0]).max() - 1 <= 5e-4


@pytest.mark.parametrize(("method", "order"), [("w2", 1.8), ("w3", 2.7), ("rodas4", 3.8)])
def test_orders_on_smooth_edges(method: str, order: float, tmp_path: Path) -> None:
    machine = rattling(rounding="1e-3")
    fine = reference(machine, 0.01)
    sizes = (2e-4, 1e-4, 5e-5)
    errors = [np.abs(states(machine, method, h, 0.01, tmp_path)[-1, :2] - fine[:2]).max() for h in sizes]
    assert np.log2(np.array(errors[:-1]) / errors[1:]).min() >= order


def reference(machine: DescribedMachine, until: float) -> Array:
    """By scipy at 1e-11, on the direct model."""
    from scipy.integrate import solve_ivp

    model = numpy_model(machine, ("direct_dynamics",))

    def rate(t: float, y: Array) -> Array:
        return np.concatenate([y[2:], model.direct_dynamics(y[:2], y[2:], np.zeros(1))])

    y = solve_ivp(rate, (0, until), [0.0, 0.0, 0.0, 1.0], "DOP853", rtol=1e-11, atol=1e-14).y
    found: Array = y[:, -1]
    return found
