"""All gains together: slopes against differences, the optimum against a search without slopes, distances kept."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import symoro_elastic as se
from symoro_elastic.analysis.control.loops import loops_of, margins
from symoro_elastic.analysis.control.optimum import _Closed, _Responses, _Search
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import InputError

optimize = pytest.importorskip("scipy.optimize")
EXAMPLES = Path(__file__).parents[3] / "examples"


def axis(**changes: Any) -> dict[str, Any]:
    """A motor, a spring and a load, with gains that are sought."""
    given = {"Kv": "tuned", "Kp": "tuned", "Tn": "tuned", "current": {"lag": 4e-4}, "dead_time": 3e-4} | changes
    return {
        "name": "axis",
        "joints": [
            {"name": "motor", "kind": "motor", "sigma": 1, "r": "q1"},
            {"name": "load", "antecedent": "motor", "kind": "elastic", "sigma": 1, "r": "q2"},
        ],
        "bodies": {"motor": {"mass": 20}, "load": {"mass": 30}},
        "springs": {"load": {"stiffness": 2e7, "damping": 400.0}},
        "drives": {"motor": given},
    }


@pytest.mark.thorough
def test_distances_and_compliance_are_those_of_the_loops() -> None:
    machine = EXAMPLES / "two_axis.toml"
    found = se.control(machine, damping=0.02, compliances=["tool.x", "tool.y"])
    responses = _Responses.of(found.plants[0], found.cascades, ["tool.x", "tool.y"])
    search = _Search((responses,), found.cascades, found.distances)
    x = search.start + np.array([0.1, -0.2, -0.1, 0.3])
    drives = search.drives(x)
    high = responses.part(np.flatnonzero(responses.frequencies > 1))
    closed = _Closed(high, drives)
    for k, loop in enumerate(loops_of(found.plants[0], drives)):
        for name, values in loop.open_loops(high.frequencies).items():
            assert closed.distance(k, name) == pytest.approx(np.log(np.abs(1 + values)), abs=1e-8)

    def logarithms(x: Array) -> Array:
        one = _Closed(high, search.drives(x))
        peaks = [np.log(np.abs(one.compliance(o))) for o in (0, 1)]
        return np.array([one.distance(*loop) for loop in search.loops] + peaks)

    slopes = [closed.distance_slopes(*loop, search.keys) for loop in search.loops]
    slopes += [closed.compliance_slopes(o, search.keys) for o in (0, 1)]
    for k in range(len(x)):
        step = 1e-4 * np.eye(len(x))[k]
        by_difference = (8 * (logarithms(x + step) - logarithms(x - step)) - logarithms(x + 2 * step)
                         + logarithms(x - 2 * step)) / 12e-4  # fmt: skip
        assert np.array(slopes)[:, :, k] == pytest.approx(by_difference, abs=2e-8)


@pytest.mark.thorough
def test_no_gains_by_a_search_without_slopes_are_better() -> None:
    """Differential evolution over Kp, Tn, Kv of the same problem, by the loops themselves."""
    found = se.control(axis(), optimum=True, compliances=["load.z"])
    one, tuned = found.cascades[0], se.control(axis(), compliances=["load.z"])
    frequencies = np.geomspace(0.5, 3000, 500)

    def cost(x: Array) -> float:
        kp, rate, kv = np.exp(x)
        (loop,) = loops_of(found.plants[0], [one.with_gains(Kp=kp, Tn=1 / rate, Kv=kv)])
        distances = (np.abs(1 + loop.velocity_loop(frequencies)), np.abs(1 + loop.position_loop(frequencies)))
        lacks = sum(max(np.log(mu / d.min()), 0) for mu, d in zip((0.5, 0.7), distances, strict=True))
        s, row = 2j * np.pi * frequencies, found.plants[0].linear.Cq[0]
        peak = np.abs(found.plants[0].response(s, [loop.cascade], row, row)).max()
        return float(np.log(peak) + 50 * lacks + (0 if loop.is_stable() else 50))

    start = np.log([one.Kp, 1 / one.Tn, one.Kv])
    bounds = [(x - 1.5, x + 1.5) for x in start]
    best = optimize.differential_evolution(cost, bounds, seed=26, maxiter=25, popsize=8, polish=False)
    peaks = [x.places[0].compliances[0].peak for x in (found, tuned)]
    assert peaks[0] < 0.95 * peaks[1]
    assert np.log(peaks[0]) < best.fun + 0.01


@pytest.mark.thorough
def test_distances_are_kept_at_all_positions() -> None:
    with (EXAMPLES / "ball_screw.toml").open("rb") as file:
        screw = tomllib.load(file)
    given = {"Kv": "tuned", "Kp": "tuned", "Tn": "tuned", "current": {"lag": 2e-4}, "dead_time": 1.5e-4}
    screw["drives"] = {"motor": given}
    options = {"damping": 0.01, "compliances": ["table.x"], "along": {"motor": [0.0, 3.0]}}
    found, tuned = se.control(screw, optimum=True, **options), se.control(screw, **options)
    assert found.places[0].compliances[0].peak < 0.6 * tuned.places[0].compliances[0].peak
    for plant in found.plants:
        (loop,) = loops_of(plant, found.cascades)
        least = [margins(of, loop.frequencies).modulus for of in (loop.velocity_loop, loop.position_loop)]
        assert least[0] > 0.5 * (1 - 1e-4) and least[1] > 0.7 * (1 - 1e-4)
    assert all(place.growth < 0 for place in found.places)
    assert found.notes[-1].startswith("optimum of motor: peak of table.x")


def test_displacements_and_rotations_have_no_largest_compliance() -> None:
    with pytest.raises(InputError, match="displacements and rotations"):
        se.control(EXAMPLES / "two_axis.toml", damping=0.02, optimum=True, compliances=["tool.x", "tool.rz"])
