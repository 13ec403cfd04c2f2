"""Models on JAX: the numbers of numpy; jit, vmap, grad and Jacobians; single precision is said."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from functools import partial
from typing import Any

import numpy as np
import pytest

import symoro_elastic as se
from symoro_elastic.codegen.backends.array_libraries import on_arrays
from tests.codegen.backends.compared import BOTH, ULP, apart, each_state, inputs, jacobians, loaded, machine, on

pytestmark = pytest.mark.sampled(6)

jax = pytest.importorskip("jax")
SMALL = ("planar_2r.toml", "flex4.par")


@pytest.fixture(autouse=True)
def double_precision() -> Iterator[None]:
    before = jax.config.jax_enable_x64
    jax.config.update("jax_enable_x64", True)
    yield
    jax.config.update("jax_enable_x64", before)


def on_jax(example: str, *models: str) -> Any:
    return on(lambda package, module: on_arrays(package, module, jax.numpy), example, *models)


@pytest.mark.parametrize("example", SMALL)
def test_values_of_two_machines(example: str) -> None:
    """Within 4 ulp of the largest entry; all golden machines, compiled: `python -m tests.benchmarks.backends`."""
    model, expected = on_jax(example), loaded(example)
    for name in BOTH:
        *states, p = inputs(example, name).values()
        compiled = jax.jit(partial(getattr(model, name), p=p))
        assert apart(compiled(*states), getattr(expected, name)(*states, p)) <= 4


@pytest.mark.parametrize("name", BOTH)
def test_jacobians_are_the_generated_ones(name: str) -> None:
    """By q, qd and the third argument."""
    function = getattr(on_jax("planar_2r.toml"), name)
    differentiated = jax.jit(jax.jacfwd(function, argnums=(0, 1, 2)))
    for arguments in each_state(inputs("planar_2r.toml", name)):
        expected = getattr(loaded("planar_2r.toml"), name)(*arguments)
        found = differentiated(*arguments)
        by_result = found if isinstance(expected, tuple) else (found,)
        results = dict(zip(loaded("planar_2r.toml").OUTPUTS[name], by_result, strict=True))
        names = [*inputs("planar_2r.toml", name)]
        for (result, argument), (rows, matrix) in jacobians("planar_2r.toml", name, arguments).items():
            assert apart(np.asarray(results[result][names.index(argument)])[rows], matrix) <= 1e-12 / ULP


def test_vmap_and_gradients_by_parameters() -> None:
    """Of the inertia lc1^2 m1 + ...: by m1, and by the angle of the elbow."""
    model = se.load(machine("planar_2r.toml"), "inertia_matrix", backend="jax")
    q = np.random.default_rng(0).normal(size=(4, 2))
    mapped = jax.jit(jax.vmap(model.inertia_matrix))(q)
    assert apart(mapped, loaded("planar_2r.toml", "inertia_matrix").inertia_matrix(q)) <= 4
    by_p = jax.jit(jax.grad(lambda p: model.inertia_matrix(q[0], p)[0, 0]))(jax.numpy.asarray(model.DEFAULTS))
    assert by_p[model.PARAMETERS.index("m1")] == pytest.approx(0.2**2, rel=1e-15)
    by_number = jax.jit(jax.grad(lambda x: model.inertia_matrix([0.0, x])[0, 0]))(0.3)
    assert by_number == pytest.approx(-2 * 1.5 * 0.4 * 0.15 * np.sin(0.3), rel=1e-14)


def test_friction_has_a_derivative_at_rest() -> None:
    """A sign counts as constant, as in the generated derivatives."""
    table = {
        "name": "slider",
        "joints": [{"name": "x", "kind": "motor", "sigma": 1, "r": "q1"}],
        "friction": {"x": {"coulomb": 3.0, "viscous": 2.0}},
        "bodies": {"x": {"mass": 4.0}},
    }
    function = se.load(table, "direct_dynamics", backend="jax").direct_dynamics
    for derivative in (jax.jacfwd, jax.jacrev):
        compiled = jax.jit(derivative(function, argnums=1))
        assert compiled(np.zeros(1), np.zeros(1), np.ones(1)).item() == -0.5


def test_single_precision_is_said() -> None:
    """One warning where it is loaded; results are then of single precision."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        se.load(machine("planar_2r.toml"), "inertia_matrix", backend="jax")
    jax.config.update("jax_enable_x64", False)
    with pytest.warns(se.MachineWarning, match=r"single precision.*jax_enable_x64") as issued:
        model = se.load(machine("planar_2r.toml"), "inertia_matrix", backend="jax")
    assert len(issued) == 1
    found = model.inertia_matrix([0.1, 0.2])
    expected = loaded("planar_2r.toml", "inertia_matrix").inertia_matrix([0.1, 0.2])
    assert found.dtype == np.float32 and apart(found, expected) <= 4 * float(np.finfo(np.float32).eps) / ULP
