"""Lemma 4 for turns, arcs and slides: theta is Lipschitz, and bases have the orders that they say."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from symoro_elastic.machine.limits import Range
from symoro_elastic.numerics.guarantees.axes import ARC, SLIDE, TURN, Axis, axis_of

Array = NDArray[np.float64]
AXES = [
    Axis("q", TURN, 3, -math.pi, math.pi),
    Axis("q", ARC, 3, -0.5, 0.5),
    Axis("q", ARC, 2, 1.0, 6.9),
    Axis("q", ARC, 1, -0.001, 0.002),
    Axis("x", SLIDE, 4, -0.4, 0.1),
]


def functions(axis: Axis, x: Array) -> Array:
    """The powers of sine and cosine, or of x, that span the polynomials of an axis."""
    n = axis.degree
    if axis.kind == SLIDE:
        return np.stack([x**k for k in range(n + 1)])
    middle = x - axis.middle
    return np.stack([np.cos(k * middle) for k in range(n + 1)] + [np.sin(k * middle) for k in range(1, n + 1)])


@pytest.mark.parametrize("axis", AXES)
def test_values_at_the_nodes_determine_polynomials(axis: Axis) -> None:
    phi = np.linspace(0, 2 * math.pi, 200)
    for f, at_nodes in zip(functions(axis, axis.positions(phi)), functions(axis, axis.nodes), strict=True):
        assert np.allclose(axis.basis(phi) @ (axis.from_values @ at_nodes), f, rtol=0, atol=1e-11)
    assert np.abs(axis.basis(phi)).max() <= 1 + 1e-15
    assert np.allclose(axis.at_nodes @ axis.from_values, np.eye(len(axis.nodes)), atol=1e-11)


@pytest.mark.parametrize("axis", AXES)
def test_theta_is_lipschitz_with_the_order(axis: Axis) -> None:
    """Random polynomials, and the worst ones: |f'|^2 + m^2 f^2 <= m^2 M^2, by differences."""
    step = 1e-3
    phi = np.arange(0, 2 * math.pi, step)
    draw = np.random.default_rng(1)
    orders = np.array(axis.orders)
    for order in sorted({*axis.orders} - {0}):
        kept = axis.basis(phi)[:, orders <= order]
        for trial in range(30):
            f = kept @ (
                draw.normal(size=kept.shape[1]) if trial else np.eye(kept.shape[1])[-1 if axis.kind != ARC else -2]
            )
            theta = np.arccos(np.clip(f / np.abs(f).max() / (1 + 1e-5), -1, 1))
            assert np.abs(np.diff(theta)).max() <= order * step * (1 + 1e-3)


@pytest.mark.parametrize("axis", AXES)
def test_the_order_is_reached(axis: Axis) -> None:
    """cos(m phi) is in the span: a smaller order would be wrong."""
    phi = np.linspace(0, 2 * math.pi, 300)
    m = max(axis.orders)
    basis, wave = axis.basis(phi), np.cos(m * phi)
    assert np.abs(basis @ np.linalg.lstsq(basis, wave, rcond=None)[0] - wave).max() < 1e-9


def test_kinds() -> None:
    assert axis_of("q", 1, Range(-math.pi, math.pi), angle=True).kind == TURN
    assert axis_of("q", 1, Range(-100.0, 100.0), angle=True).kind == TURN
    assert axis_of("q", 1, Range(-3.0, 3.0), angle=True).kind == ARC
    assert axis_of("x", 1, Range(-100.0, 100.0), angle=False).kind == SLIDE


@pytest.mark.parametrize("angle", [True, False])
@pytest.mark.parametrize("width", [0.0, 1e-17, 1e-12, 1e-8, 1e-7])
def test_ranges_that_numbers_hardly_tell_apart_are_wider(width: float, angle: bool) -> None:
    """They were singular, or their coefficients all rounding: values at nodes determine polynomials there, too."""
    axis = axis_of("q", 3, Range(0.1, 0.1 + width), angle=angle)
    assert axis.low <= 0.1 and 0.1 + width <= axis.high <= 0.1 + width + 1e-8
    assert axis.mismatch < 0.05


@pytest.mark.parametrize("axis", AXES)
def test_cells_and_grids_cover_the_range(axis: Axis) -> None:
    middles = axis.cells(8)
    phi = np.linspace(0, math.pi if axis.is_even else 2 * math.pi, 1000)
    assert np.abs(phi[:, None] - middles).min(axis=1).max() <= math.pi / 8 + 1e-12
    points = axis.grid(8, 2)
    assert np.allclose(np.diff(points), 2 * math.pi / 16) and len(points) == (9 if axis.is_even else 16)
