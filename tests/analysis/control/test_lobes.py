"""Stability lobes: one mode in closed form, two modes against the semi-discretization of the delayed equations."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import symoro_elastic as se
from symoro_elastic.foundation.errors import InputError

scipy_linalg = pytest.importorskip("scipy.linalg")

MASS, FREQUENCY, RATIO, CUTTING = 0.03993, 922.0, 0.011, 6e8
STIFFNESS = MASS * (2 * np.pi * FREQUENCY) ** 2


def spindle(**damping: float) -> dict[str, Any]:
    """One mass on a spring; with `behind`, a second one in series."""
    joints = [{"name": "tool", "kind": "elastic", "sigma": 1, "r": "x"}]
    bodies, springs = {"tool": {"mass": MASS}}, {"tool": {"stiffness": STIFFNESS, "damping": 2 * RATIO * MASS}}
    springs["tool"]["damping"] *= 2 * np.pi * FREQUENCY
    if damping:
        joints = [{"name": "head", "kind": "elastic", "sigma": 1, "r": "y"}, *joints]
        joints[1]["antecedent"] = "head"
        bodies["head"] = {"mass": 0.1}
        springs["head"] = {"stiffness": 3e6, "damping": damping["behind"]}
    return {"name": "spindle", "joints": joints, "bodies": bodies, "springs": springs}


def test_one_mode_in_closed_form() -> None:
    """2 k zeta (1 + zeta)/K, and the figure of Insperger and Stepan's example at 12 000 turns per minute."""
    found = se.lobes(spindle(), direction="tool.z", cutting=CUTTING, speeds=(12_000, 12_000, 1))
    (place,) = found.places
    assert place.least == pytest.approx(2 * STIFFNESS * RATIO * (1 + RATIO) / CUTTING, rel=1e-9)
    assert place.least == pytest.approx(4.967564e-5, rel=1e-6)
    assert place.depths[0] == pytest.approx(5.416e-5, rel=1e-4)
    assert place.frequency == pytest.approx(FREQUENCY * np.sqrt(1 + 2 * RATIO), rel=1e-6)
    assert place.influences["tool.stiffness"] == pytest.approx(1 - (1 + 2 * RATIO) / (2 + 2 * RATIO), rel=1e-5)


@pytest.mark.parametrize(
    ("options", "place", "what"),
    [
        ({"direction": "tool.rx"}, "--direction", "tool.rx is not a displacement in m"),
        ({"direction": "tool.z", "thickness": "tool.vz"}, "--thickness", "tool.vz is not a displacement in m"),
        ({"direction": "tool.z", "across": "tool.rx", "radial": 1e8}, "--across", "tool.rx is not a displacement in m"),
        ({"direction": "tool.z", "across": " tool.z", "radial": 1e8}, "--across", "tool.z is along tool.z, the feed"),
        ({"direction": "tool.z", "across": "tool at (0, 0, 1).z", "radial": 1e8}, "--across", "the feed"),
    ],
)
def test_directions_without_meaning_are_refused(options: dict[str, Any], place: str, what: str) -> None:
    with pytest.raises(InputError, match=what) as error:
        se.lobes(spindle(), cutting=CUTTING, speeds=(12_000, 12_000, 1), **options)
    assert error.value.place.strip("-") == place.strip("-")


def test_a_joint_alone_is_its_position() -> None:
    found = [se.lobes(spindle(), direction=one, cutting=CUTTING, speeds=(9e3, 9e3, 1)) for one in ("tool", "tool.z")]
    assert found[0].places[0].least == pytest.approx(found[1].places[0].least, rel=1e-12)


def growth(machine: dict[str, Any], depth: float, speed: float, intervals: int) -> float:
    """Largest multiplier of a period by semi-discretization of order 0, of x' = A x + K b B (y(t - T) - y(t))."""
    linear = se.linearize(machine, outputs=["tool.z"])
    space, n = linear.space, 2 * len(linear.M)
    push = np.concatenate([np.zeros(n // 2), np.linalg.solve(linear.M, linear.Cq[0])])
    row = np.concatenate([linear.Cq[0], np.zeros(n // 2)])
    A, h = space.A - CUTTING * depth * np.outer(push, row), 60 / speed / intervals
    whole = scipy_linalg.expm(np.block([[A, CUTTING * depth * push[:, None]], [np.zeros((1, n + 1))]]) * h)
    step = np.zeros((n + intervals, n + intervals))
    step[:n, :n] = whole[:n, :n]
    step[:n, -2:] += whole[:n, n:] / 2  # the mean of the two samples around a delayed time
    step[n, :n] = row
    step[n + 1 :, n:-1] = np.eye(intervals - 1)
    return float(np.abs(np.linalg.eigvals(np.linalg.matrix_power(step, intervals))).max())


@pytest.mark.sampled(2)
@pytest.mark.parametrize("speed", [9_000.0, 17_000.0])
def test_the_limit_is_where_delayed_equations_begin_to_grow(speed: float) -> None:
    machine = spindle(behind=40.0)
    depth = se.lobes(machine, direction="tool.z", cutting=CUTTING, speeds=(speed, speed, 1)).places[0].depths[0]
    assert growth(machine, 0.97 * depth, speed, 200) < 1 < growth(machine, 1.03 * depth, speed, 200)


def test_no_speed_is_limited_below_the_least_depth() -> None:
    found = se.lobes(spindle(behind=40.0), direction="tool.z", cutting=CUTTING, speeds=(3_000, 30_000, 120))
    (place,) = found.places
    assert place.least * (1 - 1e-9) <= place.depths.min() < 1.1 * place.least
    assert np.array_equal(found.worst, place.depths)


def test_teeth_and_speed_are_one_period() -> None:
    few, many = (
        se.lobes(spindle(), direction="tool.z", cutting=CUTTING, teeth=n, speeds=(x, x, 1)).places[0].depths[0]
        for n, x in ((1, 12_000), (4, 3_000))
    )
    assert few == pytest.approx(many, rel=1e-12)


@pytest.mark.parametrize(
    ("options", "what"),
    [
        ({"cutting": 0.0}, "is not above zero"),
        ({"cutting": CUTTING, "speeds": (-1.0, 5.0, 3)}, "spindle speeds are numbers above zero"),
        ({"cutting": CUTTING, "direction": "tool.vz"}, "tool.vz is not a displacement in m"),
        ({"cutting": CUTTING, "direction": "tol.z"}, "tol"),
    ],
)
def test_cuts_that_are_none_are_refused(options: dict[str, Any], what: str) -> None:
    with pytest.raises(InputError) as error:
        se.lobes(spindle(), **{"direction": "tool.z", **options})
    assert what in str(error.value)
