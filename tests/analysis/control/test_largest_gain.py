"""The largest gain: the quadratic of each frequency, the gap that is stable, and a two-mass drive in closed form."""

from __future__ import annotations

from typing import Any

import mpmath
import numpy as np
import pytest

import symoro_elastic as se
from symoro_elastic.analysis.control.largest_gain import forbidden, gaps, largest_gain

MOTOR, LOAD, STIFFNESS, DAMPING, LAG, DEAD, MODULUS = 0.02, 0.05, 1000.0, 0.1, 2e-4, 1.5e-4, 0.5


def drive(**changes: Any) -> dict[str, Any]:
    given = {"Kv": "tuned", "Kp": "tuned", "current": {"lag": LAG}, "dead_time": DEAD} | changes
    return {
        "name": "drive",
        "joints": [
            {"name": "motor", "kind": "motor", "sigma": 0, "theta": "q1"},
            {"name": "arm", "antecedent": "motor", "kind": "elastic", "sigma": 0, "theta": "q2"},
        ],
        "bodies": {"arm": {"inertia_at_origin": [0, 0, LOAD]}},
        "motors": {"motor": {"rotor_inertia": MOTOR}},
        "springs": {"arm": {"stiffness": STIFFNESS, "damping": DAMPING}},
        "drives": {"motor": given},
    }


def test_intervals_are_those_between_the_roots() -> None:
    rng = np.random.default_rng(1)
    a, b = (rng.normal(size=500) + 1j * rng.normal(size=500) for _ in range(2))
    low, high = forbidden(a, b, 0.5)
    for k in np.geomspace(1e-3, 1e3, 40):
        inside = (low < k) & (k < high)
        assert np.array_equal(np.abs(a + k * b) < 0.5, inside)


def test_gaps_lie_between_intervals() -> None:
    low, high = np.array([np.nan, 5.0, 1.0, 2.0]), np.array([np.nan, 6.0, 3.0, 4.0])
    assert gaps(low, high) == [(0.0, 1.0), (4.0, 5.0), (6.0, np.inf)]
    assert gaps(np.array([1.0, np.nan]), np.array([2.0, np.nan])) == [(2.0, np.inf)], "ended by the first frequency"


def test_the_stable_gap_is_taken() -> None:
    def terms(f: np.ndarray) -> Any:
        return np.ones_like(f, complex), -1 / (3 + np.cos(f)) + 0j

    f = np.linspace(0.1, 10, 2001)
    below = largest_gain(terms, f, 0.5, lambda k: k < 5)
    assert largest_gain(terms, f, 0.5, lambda k: k > 5) is None, "nothing bounds what is above all intervals"
    open_ended = largest_gain(lambda f: (terms(f)[0], -terms(f)[1]), f, 0.5, lambda _: True)
    assert open_ended is not None and open_ended.gain == np.inf
    assert below is not None and below.gain == pytest.approx(0.5 * 2, rel=1e-12)
    assert largest_gain(terms, f, 0.5, lambda _: False) is None


def test_an_integral_part_requires_a_least_gain_and_limits_none() -> None:
    """A motor and a load without dead time and lag: L falls as 1/s, from a crossover on that Tn requires."""
    given = {"Kv": 1, "Kp": 100, "Tn": 0.02, "current": {}, "dead_time": 0}
    velocity, _ = se.control(drive(**given)).places[0].axes[0].limits
    assert velocity.largest is not None and velocity.largest.gain == np.inf


def test_gains_below_those_that_an_integral_part_forbids_are_not_the_largest() -> None:
    """Friction makes small gains stable, too; between both gaps the loop is stable, but nearer to instability."""
    with_friction = drive(Kv=20, Tn=0.03) | {"friction": {"motor": {"viscous": 1e-3}}}
    (found,), (without,) = (se.control(one).cascades for one in (with_friction, drive(Kv=20, Tn=0.03)))
    assert found.Kp == pytest.approx(without.Kp, rel=1e-2) and found.Kp > 1


# A motor, a spring, a load: in closed form, 40 digits


def velocity_loop(w: Any, k: Any, p: dict[str, Any]) -> Any:
    """1 + L at s = i w of the proportional velocity loop of two masses."""
    s = 1j * w
    spring = p["c"] * s + p["k"]
    response = (p["load"] * s**2 + spring) / (
        p["motor"] * s**2 * (p["load"] * s**2 + spring) + p["load"] * s**2 * spring
    )
    return 1 + k * mpmath.exp(-s * p["dead"]) / (1 + p["lag"] * s) * s * response


def closed_form(start: tuple[float, float], **changes: Any) -> Any:
    """The gain and the frequency at which |1 + L|^2 = modulus^2 touches: both equations solved in 40 digits."""
    p = {"motor": MOTOR, "load": LOAD, "k": STIFFNESS, "c": DAMPING, "lag": LAG, "dead": DEAD} | changes
    p = {key: mpmath.mpf(x) for key, x in p.items()}
    with mpmath.workdps(40):

        def square(w: Any, k: Any) -> Any:
            return abs(velocity_loop(w, k, p)) ** 2

        def touch(w: Any, k: Any) -> list[Any]:
            return [square(w, k) - mpmath.mpf(MODULUS) ** 2, mpmath.diff(lambda x: square(x, k), w)]

        return mpmath.findroot(touch, start, tol=1e-50)


@pytest.fixture(scope="module")
def tuned() -> Any:
    return se.control(drive(), tune=True, modulus=MODULUS)


def test_the_gain_is_that_of_two_equations_in_40_digits(tuned: Any) -> None:
    limit = tuned.places[0].axes[0].limits[0]
    w, k = closed_form((2 * np.pi * limit.largest.frequency, limit.largest.gain))
    assert limit.largest.gain == pytest.approx(float(k), rel=1e-12)
    assert limit.largest.frequency == pytest.approx(float(w) / 2 / np.pi, rel=1e-9)
    assert tuned.cascades[0].Kp == limit.largest.gain


@pytest.mark.parametrize(
    ("name", "key", "value"),
    [
        *(("arm.stiffness", "k", STIFFNESS), ("arm.damping", "c", DAMPING), ("motor.rotor_inertia", "motor", MOTOR)),
        *(("arm.ZZ", "load", LOAD), ("dead time", "dead", DEAD), ("lag of the current loop", "lag", LAG)),
    ],
)
def test_influences_are_derivatives_of_that_gain(tuned: Any, name: str, key: str, value: float) -> None:
    """By differences in 40 digits."""
    limit = tuned.places[0].axes[0].limits[0]
    start = (2 * np.pi * limit.largest.frequency, limit.largest.gain)
    step = mpmath.mpf(10) ** -12
    with mpmath.workdps(40):
        up, down = (closed_form(start, **{key: mpmath.mpf(value) * mpmath.exp(x)})[1] for x in (step, -step))
        slope = (mpmath.log(up) - mpmath.log(down)) / (2 * step)
    assert limit.influences[name] == pytest.approx(float(slope), rel=1e-9)


def test_more_than_the_gain_is_nearer_to_instability(tuned: Any) -> None:
    gain = tuned.cascades[0].Kp
    for factor, is_near in ((0.999, False), (1.001, True)):
        changed = se.control(drive(Kp=factor * gain, Kv=1.0), modulus=MODULUS)
        assert (changed.places[0].axes[0].velocity.modulus < MODULUS) == is_near
