"""Modes over positions: paired through crossings and repeated frequencies."""

from __future__ import annotations

import numpy as np
import pytest

from symoro_elastic.analysis.vibration.modes import clusters
from symoro_elastic.analysis.vibration.tracking import Tracked, over_grid, pair
from symoro_elastic.numerics.motion.equations_of_motion import EquationsOfMotion
from tests.analysis.vibration.machines import crossing, modes_of, twins
from tests.analysis.vibration.test_modes import two_axis

pytestmark = pytest.mark.sampled(4)


def through_the_crossing(positions: list[float]) -> Tracked:
    return over_grid(EquationsOfMotion(crossing()), {"radius": positions}, held=["radius"])


def test_frequencies_cross_and_keep_their_modes() -> None:
    """The turn slows down as its load moves out, and passes the other spring, also exactly where both are equal."""
    radii = np.linspace(0.3, 0.8, 11)
    found = through_the_crossing(radii.tolist())
    turn, beside = np.sqrt(1e4 / 4) / radii / (2 * np.pi), np.full(11, 100 / (2 * np.pi))
    np.testing.assert_allclose(found.frequencies, np.stack([beside, turn], axis=1), rtol=1e-14)
    assert found.mac.min() > 1 - 1e-12 and not found.doubtful
    exactly = found.modes[4]
    assert radii[4] == 0.5 and len(clusters(np.sort(exactly.eigenvalues))) == 1
    np.testing.assert_allclose(np.abs(exactly.shapes[:, 1]), [1.0, 0.0], atol=1e-12)


def test_sorted_modes_would_be_mixed_up() -> None:
    """What pairing is for: without it, columns change their shape at the crossing."""
    near, far = (modes_of(crossing(), {"radius": r}, held=["radius"]) for r in (0.45, 0.55))
    mass = (near.linear.M + far.linear.M) / 2
    assert abs(near.shapes[:, 0] @ mass @ far.shapes[:, 0]) < 1e-12
    paired, mac = pair(near, far)
    assert mac.min() > 1 - 1e-12 and paired.frequencies[0] < paired.frequencies[1] + 3
    np.testing.assert_array_equal(paired.frequencies, far.frequencies[::-1])


def test_a_repeated_frequency_keeps_its_shapes() -> None:
    """Any basis of the subspace is right; the one before is kept."""
    found = over_grid(EquationsOfMotion(twins()), {"table": np.linspace(0, 3, 7).tolist()}, held=["table"])
    first = found.modes[0].shapes
    for each in found.modes:
        np.testing.assert_allclose(each.shapes, first, atol=1e-12)
    assert found.mac.min() > 1 - 1e-12


def test_a_turned_basis_is_turned_back() -> None:
    here = modes_of(twins(), held=["table"])
    c, s = np.cos(0.7), np.sin(0.7)
    from dataclasses import replace

    turned = replace(here, shapes=here.shapes @ np.array([[c, -s], [s, c]]))
    paired, mac = pair(here, turned)
    np.testing.assert_allclose(paired.shapes, here.shapes, atol=1e-14)
    np.testing.assert_allclose(mac, 1.0, rtol=1e-14)


def test_a_grid_of_two_joints() -> None:
    """Every point is paired with its neighbour; frequencies there are those found alone."""
    grid = {"motor_x": [0.0, 0.3], "motor_y": [0.0, 0.2, 0.4]}
    found = over_grid(EquationsOfMotion(two_axis()), grid, held=["motor_x", "motor_y"])
    assert found.lengths == (2, 3) and found.before == (0, 0, 1, 0, 3, 4)
    assert found.positions[4].tolist() == [0.3, 0.2]
    alone = modes_of(two_axis(), {"motor_x": 0.3, "motor_y": 0.2}, held=["motor_x", "motor_y"])
    np.testing.assert_allclose(np.sort(found.frequencies[4]), alone.frequencies, rtol=1e-12)
    assert found.frequencies.shape == (6, 10)


def test_a_coarse_grid_says_so() -> None:
    """Far apart, positions of the two-axis machine leave pairs in doubt that neighbours do not."""
    positions = [0.0, 40.0]
    coarse = over_grid(EquationsOfMotion(two_axis()), {"motor_y": positions})
    fine = over_grid(EquationsOfMotion(two_axis()), {"motor_y": np.linspace(0, 0.4, 5).tolist()})
    assert coarse.doubtful and not fine.doubtful


@pytest.mark.parametrize("values", [[0.0, 0.0, 3.0], [2.0, 2.0 + 1e-12, 5.0], [-1.0, 0.0, 1.0]])
def test_clusters(values: list[float]) -> None:
    lengths = [cluster.stop - cluster.start for cluster in clusters(np.array(values))]
    assert lengths == ([2, 1] if values[0] >= 0 else [1, 1, 1])
