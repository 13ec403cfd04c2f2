"""The packed inertia matrix is the lower triangle of the inertia matrix, row by row."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from symoro_elastic.formats import read_machine
from symoro_elastic.machine.scene import Scene
from symoro_elastic.numerics.verification.implementations import numpy_model
from symoro_elastic.numerics.verification.verify import verify

EXAMPLES = Path(__file__).parents[2] / "examples"


@pytest.mark.parametrize("file", ["two_axis.toml", "floating_arm.toml", "linkage.toml", "planar_2r.toml"])
def test_it_is_the_lower_triangle(file: str) -> None:
    """Of a tree, on a floating base (six rows first), of a closed chain."""
    machine, _ = read_machine(EXAMPLES / file)
    model = numpy_model(machine, ("inertia_matrix", "inertia_matrix_packed"))
    q = np.random.default_rng(0).uniform(-0.1, 0.1, (3, len(model.JOINTS)))
    whole, packed = model.inertia_matrix(q), model.inertia_matrix_packed(q)
    n = whole.shape[-1]
    rows, columns = np.tril_indices(n)
    assert packed.shape == (3, n * (n + 1) // 2)
    assert np.array_equal(packed, whole[:, rows, columns])
    assert packed[0, 2] == whole[0, 1, 1]


def test_check_compares_it_with_the_reference() -> None:
    machine, _ = read_machine(EXAMPLES / "planar_2r.toml")
    assert verify(machine, Scene(("inertia_matrix_packed",)), states=(2, 1)).ok
