"""Boxes of equal inertia have the inertia of the body."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from symoro_elastic.machine.machine import Body
from symoro_elastic.pages.drawing.figure import box_of
from tests.compiled_models import cell

NO_NAMES: dict[str, float] = {}


def of_points(rng: np.random.Generator, central: bool) -> tuple[Body, float, np.ndarray, np.ndarray]:
    """A body of point masses: its mass, its centre, and its tensor about the origin of the frame."""
    masses, points = rng.uniform(0.1, 2.0, 9), rng.normal(0.0, 0.3, (9, 3))
    mass, centre = float(masses.sum()), masses @ points / masses.sum()

    def about(origin: np.ndarray) -> np.ndarray:
        away = points - origin
        return sum(m * (x @ x * np.eye(3) - np.outer(x, x)) for m, x in zip(masses, away, strict=True))

    given = about(centre if central else np.zeros(3))
    moments = centre if central else mass * centre
    body = Body(
        cell(mass),
        tuple(map(cell, moments.tolist())),  # type: ignore[arg-type]
        tuple(map(cell, given[np.triu_indices(3)].tolist())),  # type: ignore[arg-type]
        central,
    )
    return body, mass, centre, about(np.zeros(3))


@pytest.mark.parametrize("central", [False, True])
@pytest.mark.parametrize("seed", range(8))
def test_a_box_of_equal_inertia_has_that_inertia(seed: int, central: bool) -> None:
    """Integrated over the box: the mean of x x^T of an evenly filled edge a is a^2 / 12."""
    body, mass, centre, tensor = of_points(np.random.default_rng(seed), central)
    box = box_of(body, NO_NAMES)
    assert box is not None
    R = box.placement[:3, :3]
    np.testing.assert_allclose(R @ R.T, np.eye(3), atol=1e-14)
    assert np.linalg.det(R) > 0
    second = mass * (R @ np.diag(box.edges**2 / 12) @ R.T + np.outer(box.placement[:3, 3], box.placement[:3, 3]))
    np.testing.assert_allclose(np.trace(second) * np.eye(3) - second, tensor, rtol=1e-11, atol=1e-12)
    np.testing.assert_allclose(box.placement[:3, 3], centre, atol=1e-14)
    assert box.mass == pytest.approx(mass)


@pytest.mark.parametrize("inertia", [(0, 0, 0, 0, 0, 0.03), ("XX1", 0, 0, 0, 0, 1), (0,) * 6])
def test_bodies_without_a_box_are_points_at_their_centres(inertia: tuple[float | str, ...]) -> None:
    """A flat body, one whose tensor has no value, a point mass."""
    body = Body(cell(2), tuple(map(cell, (0.1, 0, 0.3))), tuple(map(cell, inertia)), central=True)  # type: ignore[arg-type]
    box = box_of(body, NO_NAMES)
    assert box is not None and not box.edges.any()
    np.testing.assert_array_equal(box.placement[:3, 3], [0.1, 0, 0.3])


def test_bodies_without_mass_or_values_have_no_box() -> None:
    assert box_of(Body(), NO_NAMES) is None
    unknown = replace(Body(), mass=cell("M1"))
    assert box_of(unknown, NO_NAMES) is None and box_of(unknown, {"M1": 2.0}) is not None
