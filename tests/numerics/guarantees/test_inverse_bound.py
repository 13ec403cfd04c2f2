"""Lemma 7: bounds of all solutions of A x = d for A in intervals and |d| within bounds, against drawn ones."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

from symoro_elastic.numerics.guarantees.intervals import Interval
from symoro_elastic.numerics.guarantees.inverse_on_cells import allowed_right_sides, largest_solutions, widened


def matrices(size: int, radius: float, rng: np.random.Generator, parts: int = 3) -> Interval:
    """Symmetric positive definite matrices, and as much room around each as their least eigenvalue allows."""
    low, high = (np.empty((size, size, parts)) for _ in range(2))
    for k in range(parts):
        factor = rng.normal(size=(size, size))
        A = factor @ factor.T + 0.3 * np.eye(size)
        room = rng.uniform(0, radius, (size, size)) * np.linalg.eigvalsh(A)[0] / size
        room = (room + room.T) / 2
        low[..., k], high[..., k] = A - room, A + room
    return Interval(low, high)


def drawn(A: Interval, k: int, count: int, rng: np.random.Generator) -> np.ndarray:
    """Symmetric matrices in a sub-box, most of them at its corners."""
    size = len(A.low)
    share = np.round(rng.random((count, size, size)))
    share[::3] = rng.random(share[::3].shape)
    share = np.triu(share) + np.triu(share, 1).transpose(0, 2, 1)
    return A.low[..., k] + (A.high[..., k] - A.low[..., k]) * share


@pytest.mark.parametrize("size", [1, 2, 4, 6])
@pytest.mark.parametrize("seed", range(3))
def test_no_solution_is_larger(size: int, seed: int) -> None:
    rng = np.random.default_rng([size, seed])
    A, e = matrices(size, 0.5, rng), rng.uniform(0.1, 2, size)
    bounds = largest_solutions(A, e)
    assert np.isfinite(bounds).all()
    for k in range(A.low.shape[-1]):
        signs = np.array(list(product((-1, 1), repeat=size))) * e
        x = np.linalg.solve(drawn(A, k, 200, rng), np.broadcast_to(signs.T, (200, size, 2**size)))
        worst = np.abs(x).max(axis=(0, 2))
        assert (worst <= bounds[:, k]).all()
        assert (bounds[:, k] <= 6 * worst).all()


def test_a_point_is_bounded_by_its_own_inverse() -> None:
    A = np.array([[2.0, 1.0], [1.0, 3.0]])
    e = np.array([1.0, 2.0])
    found = largest_solutions(Interval(A[..., None], A[..., None]), e)[:, 0]
    assert found == pytest.approx(np.abs(np.linalg.inv(A)) @ e, rel=1e-5)


def test_matrices_that_may_be_singular_have_no_bound() -> None:
    low, high = np.array([[1.0, 0.0], [0.0, 1.0]]), np.array([[1.0, 1.0], [1.0, 1.0]])
    assert (largest_solutions(Interval(low[..., None], high[..., None]), np.ones(2)) == np.inf).all()
    infinite = np.full((2, 2, 1), np.inf)
    assert (largest_solutions(Interval(-infinite, infinite), np.ones(2)) == np.inf).all()
    assert (allowed_right_sides(Interval(low[..., None], high[..., None]), np.ones(2)) == 0).all()


@pytest.mark.parametrize("seed", range(5))
def test_allowed_right_sides_keep_what_is_asked(seed: int) -> None:
    rng = np.random.default_rng(seed)
    A, most = matrices(4, 0.4, rng), rng.uniform(0.01, 10, 4)
    allowed = allowed_right_sides(A, most)
    reached = largest_solutions(A, allowed)
    assert (allowed > 0).all() and (reached <= most[:, None]).all()
    assert (reached / most[:, None]).max() > 0.999


def test_widened_matrices_hold_all_that_differ_by_as_much() -> None:
    rng = np.random.default_rng(3)
    A, by = matrices(3, 0.2, rng), rng.uniform(0, 0.1, (3, 3))
    wide = widened(A, by)
    assert (wide.low <= A.low - by[..., None]).all() and (wide.high >= A.high + by[..., None]).all()
