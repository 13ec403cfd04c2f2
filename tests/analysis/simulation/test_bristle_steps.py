"""Steps of a mass on a bristle: hunting and stick-slip of the paper of 1995, drift, against scipy; orders; any lag."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from symoro_elastic.analysis.simulation.compiled_steps import CompiledSteps
from symoro_elastic.analysis.simulation.reference_motion import risen
from symoro_elastic.codegen.integration.tableaus import METHODS, nodes_of
from symoro_elastic.formats import read_machine
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.machine.described import DescribedMachine
from symoro_elastic.machine.drives import CurrentControl, Drive, Drives, LowPass, Notch
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.joints import Electrics
from symoro_elastic.machine.machine import Friction
from tests.models.test_friction_states import LAW, rate_of_bristle, slider

LUGRE = LAW | {"breakaway": 0.0}


class Steps:
    """Steps of a method of one machine, called from Python."""

    def __init__(self, machine: DescribedMachine, method: str, way: str, folder: Path) -> None:
        self.steps = CompiledSteps(machine, [method], folder)
        self.one = next(x for name, x in self.steps.runs.items() if name.endswith(f"_{method}{way}"))
        self.nodes = np.array(nodes_of(METHODS[method]), dtype=float)

    def run(self, count: int, h: float, given: dict[str, Array], state: list[Array]) -> Array:
        """States after each step."""
        record = np.empty((count, sum(self.one.written.values())))
        self.steps._call(self.one, count, [given[name] for name in self.one.read], h, [*state, record])
        return record

    def times(self, count: int, h: float) -> Array:
        found: Array = (np.arange(count)[:, None] + self.nodes) * h
        return found


def at_rest() -> list[Array]:
    return [np.zeros(1), np.zeros(1), np.zeros(1)]


def crossings(t: Array, x: Array) -> Array:
    """Times at which x rises through 0, by straight lines."""
    k = np.flatnonzero((x[:-1] < 0) & (x[1:] >= 0))
    found: Array = t[k] + (t[k + 1] - t[k]) * x[k] / (x[k] - x[k + 1])
    return found


def radau(law: dict[str, float], force: Callable[[float, Array], float], extra: int, until: float, dt: float) -> Array:
    """x, v, z and integrals by scipy at 1e-9, at even times."""
    from scipy.integrate import solve_ivp

    def rate(t: float, y: Array) -> list[float]:
        zd = rate_of_bristle(y[1], y[2], law)
        friction = law["bristle"] * y[2] + law["bristle_damping"] * zd + law["viscous"] * y[1]
        return [y[1], force(t, y) - friction, zd, *([y[0] - 1] if extra else [])]

    t = np.arange(0, until + dt / 2, dt)
    tolerances = {"rtol": 1e-7, "atol": np.array([1e-9, 1e-9, 1e-13, 1e-9][: 3 + extra])}
    found: Array = solve_ivp(rate, (0, until), np.zeros(3 + extra), "Radau", t_eval=t, **tolerances).y.T
    return found


def hunting(law: dict[str, float], h: float, until: float, folder: Path) -> Array:
    """Crossings of the set point 1 under 3 (1 - x) - 6 v - 4 times the integral of x - 1, kept beside the steps."""
    steps = Steps(DescribedMachine.of(slider(**law)), "w3", "_servo", folder)
    state, integral, xs = at_rest(), 0.0, [0.0]
    ones, c = np.ones(len(steps.nodes)), steps.nodes * h
    for _ in range(round(until / h)):
        x, v = state[0][0], state[1][0]
        tau = -4 * (integral + c * (x - 1) + c * c / 2 * v)
        given = {"tau": tau, "r": ones, "rd": 0 * ones, "kp": np.array([3.0]), "kd": np.array([6.0])}
        steps.run(1, h, given, state)
        integral += h * (x + state[0][0] - 2) / 2 - h * h / 12 * (state[1][0] - v)
        xs.append(state[0][0])
    return crossings(np.arange(len(xs)) * h, np.array(xs) - 1)


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("law", "printed"),
    [(LUGRE, [1.95, 13.00, 32.28, 56.62, 81.12]), (LAW, [1.95, 12.99, 32.11, 56.22, 80.53])],
    ids=["LuGre", "elasto-plastic"],
)
def test_hunting(law: dict[str, float], printed: list[float], tmp_path: Path) -> None:
    found = hunting(law, 2e-3, 82, tmp_path)
    assert np.abs(found - printed).max() < 0.04
    y = radau(law, lambda t, y: 3 * (1 - y[0]) - 6 * y[1] - 4 * y[3], 1, 14, 1e-3)
    wanted = crossings(np.arange(len(y)) * 1e-3, y[:, 0] - 1)
    assert len(wanted) == 2 and np.abs(found[:2] / wanted - 1).max() < 1e-3


@pytest.mark.thorough
def test_stick_slip(tmp_path: Path) -> None:
    """A spring of 2 N/m pulled at 0.1 m/s: slips every 6.36 to 6.37 s at up to 0.370 m/s."""
    steps, h, count = Steps(DescribedMachine.of(slider(**LUGRE)), "w3", "_servo", tmp_path), 1e-3, 35000
    t = steps.times(count, h)
    given = {"tau": 0 * t, "r": 0.1 * t, "rd": 0 * t + 0.1, "kp": np.array([2.0]), "kd": np.zeros(1)}
    v = steps.run(count, h, given, at_rest())[:, 1]
    slips = crossings(np.arange(1, count + 1) * h, v - 0.01)
    assert np.all((np.diff(slips) > 6.36) & (np.diff(slips) < 6.37)) and abs(v.max() - 0.370) < 4e-4
    y = radau(LUGRE, lambda t, y: 2 * (0.1 * t - y[0]), 0, 15, 1e-3)
    wanted = crossings(np.arange(len(y)) * 1e-3, y[:, 1] - 0.01)
    assert len(wanted) == 2 and np.abs(slips[:2] / wanted - 1).max() < 1e-3


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("law", "least", "most"), [(LUGRE, 1e-4, 1e-3), (LAW, 0, 5e-6)], ids=["LuGre", "elasto-plastic"]
)
def test_drift_under_a_vibrating_load(law: dict[str, float], least: float, most: float, tmp_path: Path) -> None:
    """35 +- 30 % of the dry friction at 20 Hz for 5 s: elasto-plastic friction holds, LuGre drifts."""
    steps, h, count = Steps(DescribedMachine.of(slider(**law)), "w3", "", tmp_path), 1e-3, 5000
    tau = 0.35 + 0.30 * np.sin(2 * np.pi * 20 * steps.times(count, h))
    x = steps.run(count, h, {"tau": tau}, at_rest())[:, 0]
    assert least <= x[-1] < most


@pytest.mark.thorough
@pytest.mark.parametrize("breakaway", [0.0, 0.7], ids=["LuGre", "elasto-plastic"])
@pytest.mark.parametrize("h", [1e-3, 1e-5])
def test_free_motions_gain_no_energy(breakaway: float, h: float, tmp_path: Path) -> None:
    """From 250 states with speeds of 1e-6 to 10 m/s, 1e5 steps in all: none ends with more than it began with."""
    law, rng = LAW | {"breakaway": breakaway, "viscous": 158.001}, np.random.default_rng(1)
    steps = Steps(DescribedMachine.of(slider(**law)), "w3", "", tmp_path)
    still = {"tau": np.zeros((100, len(steps.nodes)))}
    for _ in range(250):
        v = rng.choice([-1, 1]) * 10 ** rng.uniform(-6, 1)
        z = rng.uniform(-1, 1) * law["coulomb"] / law["bristle"]
        record = steps.run(100, h, still, [np.zeros(1), np.array([v]), np.array([z])])
        v, z = np.append(v, record[:, 1]), np.append(z, record[:, 2])
        energy = (v * v + law["bristle"] * z * z) / 2
        assert np.diff(energy).max() <= 1e-9 * energy[0]


@pytest.mark.thorough
def test_errors_with_elasto_plastic_friction(tmp_path: Path) -> None:
    """A mass under 3 N at 1 Hz, of an amplitude of 0.16 m."""
    steps, y = Steps(DescribedMachine.of(slider(**LAW)), "w3", "", tmp_path), []
    for h in (1e-3, 2.5e-4):
        tau = 3 * np.sin(2 * np.pi * steps.times(round(1 / h), h))
        y.append(steps.run(round(1 / h), h, {"tau": tau}, at_rest())[:, 0])
    exact = radau(LAW, lambda t, y: 3 * np.sin(2 * np.pi * t), 0, 1, 1e-3)[1:, 0]
    assert np.abs(y[0] - exact).max() < 2e-5 and np.abs(y[1][3::4] - exact).max() < 1e-6


def driven(lag: str, **changes: Any) -> DescribedMachine:
    """The ball screw with a drive, without dry friction; its motor has a winding."""
    machine = read_machine(Path(__file__).parents[3] / "examples" / "ball_screw.toml")[0]
    winding = Electrics(*map(Formula.parse, ("0.5", "2e-3", "0.2", "0.15")))
    joints = tuple(
        replace(one, friction=Friction(viscous=one.friction.viscous), electrics=winding) for one in machine.joints
    )
    drive = replace(Drive(*map(Formula.parse, ("30", "1.5", "0.02", lag))), **changes)
    return replace(machine, joints=joints, drives=Drives({"motor": drive}))


WOUND = {
    "current": CurrentControl(Formula.parse("4"), Formula.parse("3e-3")),
    "set_point": LowPass(Formula.parse("60"), 2),
    "filters": (Notch(*map(Formula.parse, ("80", "0.1", "0.7"))),),
}
"""A smooth drive with electrics and filters of both kinds."""
LIMITED = {"torque_limit": Formula.parse("2.5"), "windup": Formula.parse("0.02")}
"""Two thirds of the torque that the move needs."""


def moved(steps: Steps, h: float) -> Array:
    """States of a move of 2 rad in 0.2 s, over 0.3 s."""
    count = round(0.3 / h)
    r, rd, rdd, _ = 2 * risen(steps.times(count, h).ravel(), 0.0, 0.2)
    given = {"r": r, "rd": rd, "rdd": rdd, "tau": 0 * r}
    return steps.run(count, h, given, [np.zeros(n) for n in steps.one.written.values()])


def errors(machine: DescribedMachine, method: str, sizes: tuple[float, ...], folder: Path) -> Array:
    """Largest errors of the joints, for each step."""
    steps = Steps(machine, method, "_drives", folder)
    fine = moved(steps, 1e-3 / 64)[:, :8]
    every = [round(h * 64e3) for h in sizes]
    return np.array(
        [np.abs(moved(steps, h)[:, :8] - fine[k - 1 :: k]).max() for h, k in zip(sizes, every, strict=True)]
    )


@pytest.mark.sampled(1000)
@pytest.mark.parametrize(("method", "order"), [("w2", 1.9), ("w3", 2.7)])
@pytest.mark.parametrize("wound", [False, True], ids=["lag", "winding"])
def test_orders_with_a_drive(method: str, order: float, wound: bool, tmp_path: Path) -> None:
    machine = driven("0", **WOUND) if wound else driven("2e-4")
    found = errors(machine, method, (1e-3, 5e-4, 2.5e-4), tmp_path)
    assert np.log2(found[:-1] / found[1:]).min() >= order


@pytest.mark.thorough
def test_errors_with_a_limit(tmp_path: Path) -> None:
    """Corners take the order; what is asked are bars: 3e-4 rad at 1 ms, 5e-6 rad at 0.25 ms of a move of 2 rad."""
    found = errors(driven("2e-4", **LIMITED), "w3", (1e-3, 2.5e-4), tmp_path)
    assert found[0] < 4e-4 and found[1] < 1e-5


@pytest.mark.thorough
@pytest.mark.parametrize("changes", [{}, LIMITED], ids=["free", "limited"])
@pytest.mark.parametrize("lag", ["2e-3", "2e-6"])
def test_steps_of_1_ms_are_stable_at_any_lag(lag: str, changes: dict[str, Any], tmp_path: Path) -> None:
    end = moved(Steps(driven(lag, **changes), "w3", "_drives", tmp_path), 1e-3)
    if changes:
        assert abs(end[-1, 0] - 2) < 0.06 and np.abs(end[:, 0]).max() < 2.6
    else:
        assert abs(end[-1, 0] - 2) < 3e-3 and np.abs(end[:, 0]).max() < 2.1
