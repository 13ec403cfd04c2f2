"""A force that crosses a beam by modes, against the series of the beam's own modes."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import symoro_elastic as se
from symoro_elastic.formats.toml.reading import read
from symoro_elastic.foundation.array_types import Array

MODES = 4
CANTILEVER = f"""
name = "crossing"
gravity = [0, 0, 0]
joints = [
  {{ name = "wall", antecedent = 0, kind = "fixed" }},
  {{ name = "load", kind = "motor", sigma = 1, along = "wall", from = 0 }},
]
[beams]
wall = {{ along = "x", length = 1, EI = 1, mass_per_length = 1, bends = ["y"], modes = {MODES} }}
"""
ROOTS = (1.8751040687119611, 4.694091132974175, 7.854757438237612, *(np.pi * (np.arange(4, 13) - 0.5)))
"""Of cosh(b) cos(b) = -1, from the fourth within 2e-5; the terms of the series fall as 1/b^4."""
PERIOD = 2 * np.pi / ROOTS[0] ** 2
FORCE = 1e-3
"""N, on a beam of 1 m and 1 N m2: deflections whose squares do not matter."""


def series(t: Array, speed: float, at: Array | float) -> Array:
    """The deflection at places `at` under a force that enters at the root at t = 0.

    The modes phi = cosh - cos - s (sinh - sin) of b x are sums of c exp(k x), so that q'' + b^4 q = F phi(v t) has a
    closed solution: the sum of c F (exp(k v t) - cos(b^2 t) - k v/b^2 sin(b^2 t))/(k^2 v^2 + b^4).
    """
    deflection = np.zeros_like(t)
    for b in ROOTS:
        w, s = b**2, (np.cosh(b) + np.cos(b)) / (np.sinh(b) + np.sin(b))
        rising = (np.sin(b) - np.cos(b) - np.exp(-b)) / (np.sinh(b) + np.sin(b))  # 1 - s
        parts = [(b, rising / 2), (-b, (1 + s) / 2), (1j * b, -1 - 1j * s)]
        phi = sum((c * np.exp(k * at)).real for k, c in parts)
        free = [(k, c / ((k * speed) ** 2 + w**2)) for k, c in parts]
        q = sum((c * (np.exp(k * speed * t) - np.cos(w * t) - k * speed / w * np.sin(w * t))).real for k, c in free)
        deflection += FORCE * q * phi
    return deflection


@pytest.mark.parametrize("periods", [0.5, 1.0, 4.0])
def test_a_force_crosses_a_cantilever(periods: float) -> None:
    """Deflections of the tip and at the force, at speeds by how many first periods of the beam a crossing lasts."""
    machine = read(CANTILEVER, "crossing.toml")
    names = [joint.name for joint in machine.independent_joints]
    load, modes = names.index("load"), [k for k, name in enumerate(names) if name != "load"]
    model = se.load(machine, "inverse_dynamics", fold=["all"], scene={"forces": ["load_body"]}).inverse_dynamics
    place = se.load(machine, "geometric_model", fold=["all"], only={"geometric_model": ["load_body", "wall_end"]})
    duration, force = periods * PERIOD, np.array([0.0, FORCE, 0.0, 0.0, 0.0, 0.0])

    def state(t: Array | float, e: Array) -> Array:
        return np.insert(e, load, t / duration, axis=-1)

    def rate(t: float, x: Array) -> Array:
        qd = np.insert(x[MODES:], load, 1 / duration)
        return np.concatenate([x[MODES:], model(state(t, x[:MODES]), qd, np.zeros(1), force)[1][modes]])

    t = np.linspace(0.0, duration, 201)
    x = solve_ivp(rate, (0, duration), np.zeros(2 * MODES), "DOP853", t, rtol=1e-8, atol=1e-12).y[:MODES].T
    T = place.geometric_model(state(t, x))
    tip, moving = (series(t, 1 / duration, at) for at in (1.0, t / duration))
    most = np.abs(tip).max()
    assert np.abs(T[:, 1, 1, 3] - tip).max() < 1e-3 * most
    assert np.abs(T[:, 0, 1, 3] - moving).max() < 2e-3 * most, "where the third derivative jumps, and shapes have none"
    assert tip.max() > {0.5: 0.24, 1.0: 0.36, 4.0: 0.33}[periods] * FORCE, "1/3 by F L^3/(E I), and vibrations"
