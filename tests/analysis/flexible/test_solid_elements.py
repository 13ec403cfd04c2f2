"""Matrices of solid elements: those of scikit-fem, on distorted meshes."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from symoro_elastic.analysis.flexible.solid_elements import ORDER, SolidElements

skfem = pytest.importorskip("skfem")
DENSITY, LAME = 7.0, (3.0, 2.0)


def _distorted(kind: str) -> Any:
    mesh = getattr(skfem, kind)().refined(1)
    return type(mesh)(mesh.p + 0.05 * np.random.default_rng(0).normal(size=mesh.p.shape), mesh.t)


@pytest.mark.thorough
@pytest.mark.parametrize(("kind", "element"), [("MeshTet", "ElementTetP2"), ("MeshHex", "ElementHex2")])
def test_matrices_are_those_of_scikit_fem(kind: str, element: str) -> None:
    from skfem.models.elasticity import linear_elasticity
    from skfem.models.poisson import mass

    mesh, shape = _distorted(kind), getattr(skfem, element)()
    scalar, vector = (skfem.Basis(mesh, x, intorder=ORDER) for x in (shape, skfem.ElementVector(shape)))
    solid = SolidElements.of(scalar, LAME)
    exact = {"K": linear_elasticity(*LAME).assemble(vector), "m": DENSITY * mass.assemble(scalar)}
    for name, matrix in {"K": solid.stiffness(), "m": solid.mass(DENSITY)}.items():
        assert abs(matrix - exact[name]).max() < 1e-13 * abs(exact[name]).max(), name


@pytest.mark.thorough
def test_many_elements_are_added() -> None:
    """More than are computed at once: a displacement of the whole body meets no force, and has all of the mass."""
    mesh = skfem.MeshHex().refined(3)
    solid = SolidElements.of(skfem.Basis(mesh, skfem.ElementHex2(), intorder=ORDER), LAME)
    K, m = solid.stiffness(), solid.mass(DENSITY)
    assert m.sum() == pytest.approx(DENSITY, rel=1e-12)
    assert np.abs(K @ np.ones(K.shape[0])).max() < 1e-13 * abs(K).max() * 27
