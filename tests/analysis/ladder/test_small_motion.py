"""The linear model is integrated as in closed form, several systems side by side."""

from __future__ import annotations

import numpy as np
import pytest

from symoro_elastic.analysis.simulation.prediction.small_motion import LinearMotion, small_motion
from symoro_elastic.foundation.array_types import Array

W, W_FORCE, LENGTH = 7.0, 3.0, 10.0
DAMPING = (0.0, 0.02)


def forced(steps: int) -> tuple[Array, Array]:
    """d of q'' + 2 z w q' + w^2 q = sin(3 t) from rest for two damping ratios, and the closed form, (N, 2)."""
    t, one = np.linspace(0.0, LENGTH, steps + 1), np.ones((steps + 1, 2, 1, 1))
    z = np.array(DAMPING)[:, None, None]
    R = np.sin(W_FORCE * t)[:, None, None] * np.ones((2, 1))
    found = small_motion(LinearMotion(LENGTH / steps, one, 2 * z * W * one, W**2 * one, R)).d[..., 0]
    return found, np.stack([closed_form(t, ratio) for ratio in DAMPING], axis=1)


def closed_form(t: Array, z: float) -> Array:
    gain = 1 / (W**2 - W_FORCE**2 + 2j * z * W * W_FORCE)
    s = -z * W
    v = W * np.sqrt(1 - z**2)
    q0, v0 = gain.imag, W_FORCE * gain.real
    free = np.exp(s * t) * (-q0 * np.cos(v * t) + (s * q0 - v0) / v * np.sin(v * t))
    return np.imag(gain * np.exp(1j * W_FORCE * t)) + free


@pytest.mark.parametrize("steps", [100, 200, 400])
def test_the_error_is_of_fourth_order(steps: int) -> None:
    """(w h)^4 / 720 of the phase at each of w t rad, and that of a force in cubics between samples."""
    found, exact = forced(steps)
    h = LENGTH / steps
    allowed = W * LENGTH * (W * h) ** 4 / 720 + (W_FORCE * h) ** 4
    assert np.abs(found - exact).max() < allowed * np.abs(exact).max()


def test_masses_may_be_coupled_and_matrices_need_no_symmetry() -> None:
    """Against expm of the same matrices, with a force that grows evenly: exact up to the phase, (w h)^4 / 720 a rad."""
    from scipy.linalg import expm

    rng = np.random.default_rng(4)
    M, K = np.array([[2.0, 0.5], [0.5, 1.0]]), np.array([[9.0, -2.0], [-1.0, 5.0]])
    D = 0.1 * rng.standard_normal((2, 2))
    t = np.linspace(0.0, 4.0, 401)
    rate = np.array([0.7, -0.4])
    everywhere = [np.broadcast_to(x, (401, 2, 2)) for x in (M, D, K)]
    found = small_motion(LinearMotion(0.01, *everywhere, t[:, None] * rate))
    whole = np.zeros((6, 6))
    whole[:2, 2:4] = np.eye(2)
    whole[2:4] = np.linalg.solve(M, np.hstack([-K, -D, rate[:, None], np.zeros((2, 1))]))
    whole[4, 5] = 1.0
    exact = expm(4.0 * whole) @ [0, 0, 0, 0, 0, 1]
    np.testing.assert_allclose(np.concatenate([found.d[-1], found.dd[-1]]), exact[:4], rtol=1e-6)
    np.testing.assert_allclose(M @ found.ddd[-1] + D @ found.dd[-1] + K @ found.d[-1], 4.0 * rate, rtol=1e-12)


def test_springs_without_end_follow_statically() -> None:
    """Stiffness 1e16 beside 1: R/k, and no trace of it in the other."""
    t = np.linspace(0.0, 1.0, 201)
    R = np.stack([np.sin(t) ** 4, np.sin(t) ** 4], axis=1)
    K = np.broadcast_to(np.diag([1e16, 1.0]), (201, 2, 2))
    M = np.broadcast_to(np.eye(2), (201, 2, 2))
    found = small_motion(LinearMotion(t[1], M, 0 * M, K, R))
    alone = small_motion(LinearMotion(t[1], M[:, :1, :1], 0 * M[:, :1, :1], K[:, 1:, 1:], R[:, 1:]))
    np.testing.assert_allclose(found.d[:, 1], alone.d[:, 0], rtol=1e-12)
    np.testing.assert_allclose(found.d[:, 0], R[:, 0] / 1e16, rtol=0, atol=1e-5 * R.max() / 1e16)
