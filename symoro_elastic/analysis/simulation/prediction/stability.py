"""Largest stable steps of explicit methods, and the frequencies that implicit methods damp."""

from __future__ import annotations

from functools import cache

import numpy as np

from symoro_elastic.analysis.simulation.prediction.path import LinearPath
from symoro_elastic.analysis.simulation.prediction.step_error import growth
from symoro_elastic.codegen.integration.tableaus import Method
from symoro_elastic.foundation.array_types import Array, BoolArray, ComplexArray

ROUNDING = 1e-9
"""Growth in a step that is due to rounding of a pole, not to instability."""
GROWING = 1e-6
"""Real part of a pole, of its magnitude, above which its motion grows by itself."""
FARTHEST, APART = 15.0, 0.005
"""Of |lambda h| in the search for a limit: beyond the explicit methods in use."""
HALVINGS, ANGLES = 40, 721
PLACES = 40
"""Positions along a motion at which poles are taken."""
KEPT = 0.9
"""Part of its amplitude that a vibration keeps over a period, up to which it counts as damped."""
SLOWEST, FREQUENCIES = 1e-2, 2000
"""w h of the slowest vibration that is evaluated, and the number of vibrations up to pi."""


def poles(path: LinearPath, left_out: tuple[int, ...] = ()) -> ComplexArray:
    """Return the poles, rad/s, at places along a motion, with springs (entries of q) left out."""
    places = np.unique(np.linspace(0, len(path.t) - 1, PLACES).astype(int))
    rows = np.array([k for k in path.moved if k not in left_out], dtype=int)
    M, D, K = (x[places][:, rows[:, None], rows] for x in (path.M, path.D, path.K))
    r = len(rows)
    system = np.zeros((len(places), 2 * r, 2 * r))
    system[:, :r, r:] = np.eye(r)
    system[:, r:] = -np.linalg.solve(M, np.concatenate([K, D], axis=2))
    values: ComplexArray = np.linalg.eigvals(system).astype(complex).ravel()
    return values


def largest_stable_step(method: Method, of: ComplexArray) -> float:
    """Return the largest step, s, up to which no motion with poles `of` (rad/s) grows; may be infinite.

    Poles of motions that grow by themselves, such as that of a pendulum upside down, set no limit.
    """
    speeds = np.abs(of)
    directions = of / np.where(speeds, speeds, 1.0)
    counted = (speeds > ROUNDING * speeds.max(initial=0.0)) & (directions.real <= GROWING)
    if not counted.any():
        return np.inf
    chosen = directions[counted]
    angles, reach = _boundary(method)
    towards = np.angle(np.minimum(chosen.real, 0.0) + 1j * np.abs(chosen.imag))
    return float(np.min(np.interp(towards, angles, reach) / speeds[counted]))


@cache
def _boundary(method: Method) -> tuple[Array, Array]:
    """Return angles of z in the upper left quadrant, and by angle how far |R(z)| <= 1 holds."""
    angles = np.linspace(np.pi / 2, np.pi, ANGLES)
    return angles, _reach(method, np.minimum(np.cos(angles), 0.0) + 1j * np.sin(angles))


def _reach(method: Method, directions: ComplexArray) -> Array:
    """Return by direction the largest |z| up to which |R(z)| <= 1; infinite beyond the search."""
    radii = np.arange(APART, FARTHEST, APART)
    stable = _stable(method, directions[:, None] * radii)
    first = np.argmin(stable, axis=1)
    high = radii[first]
    low = high - APART
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        is_stable = _stable(method, directions * middle)
        low, high = np.where(is_stable, middle, low), np.where(is_stable, high, middle)
    return np.where(stable.all(axis=1), np.inf, low)


def _stable(method: Method, z: ComplexArray) -> BoolArray:
    return np.asarray(np.abs(growth(method, z)) <= 1 + ROUNDING)


def damped_above(method: Method, h: float) -> float | None:
    """Return the frequency, Hz, above which vibrations are damped by steps h: by a tenth in a period, or faster.

    Vibrations of less than two steps a period are not followed at all. None where such steps damp none: they keep
    the energy, or make it grow.
    """
    wh = np.geomspace(SLOWEST, np.pi, FREQUENCIES)
    gain = np.abs(growth(method, 1j * wh))
    if not gain[-1] < 1 - ROUNDING:
        return None
    damped = gain ** (2 * np.pi / wh) <= KEPT
    return float(wh[int(np.argmax(damped)) if damped.any() else -1] / (2 * np.pi * h))
