"""Models on array libraries: the functions on numpy, with numpy, the Python array API and PyTorch as libraries."""

from __future__ import annotations

from importlib import import_module
from typing import Any

import mpmath
import numpy as np
import pytest

import symoro_elastic as se
from generated import planar_2r
from symoro_elastic.codegen.backends.array_libraries import on_arrays
from tests.codegen.backends.compared import apart, inputs, loaded, machine, on

pytestmark = pytest.mark.sampled(6)

Q = np.array([[0.3, -0.2], [0.1, 0.4], [-1.0, 2.0]])


def on_library(library: Any, example: str, *models: str) -> Any:
    return on(lambda package, module: on_arrays(package, module, library), example, *models)


@pytest.mark.thorough
@pytest.mark.parametrize("example", ["two_axis.toml", "planar_2r.toml"])
def test_results_are_those_of_the_functions_on_numpy(example: str) -> None:
    """With known parameters, and with a row of them for each state."""
    model = on_library(_Library(), example)
    *states, p = inputs(example, "direct_dynamics").values()
    expected = loaded(example).direct_dynamics(*states, p)
    assert apart(model.direct_dynamics(*states, p), expected) <= 4
    assert apart(model.direct_dynamics(*states, np.tile(p, (len(states[0]), 1))), expected) <= 4


class _Library:
    """What a library needs: the functions that numpy has."""

    def __getattr__(self, name: str) -> Any:
        if name == "unstack":
            raise AttributeError(name)
        return getattr(np, name)


@pytest.mark.parametrize("name", ["array_api_strict", "torch"])
def test_other_libraries(name: str) -> None:
    """Shapes, leading axes, precision, placements as matrices or row by row, results without entries."""
    library = pytest.importorskip(name)
    models = ("direct_dynamics", "geometric_model", "base_parameters", "regressor")
    model, expected = on_library(library, "planar_2r.toml", *models), loaded("planar_2r.toml", *models)
    q, one = library.asarray(Q), library.asarray(Q[0])
    found = model.direct_dynamics(q[:, None, :], one, one)
    assert tuple(found.shape) == (3, 1, 2)
    assert apart(np.asarray(found), expected.direct_dynamics(Q[:, None], Q[0], Q[0])) <= 4
    assert apart(np.asarray(model.geometric_model(q)), expected.geometric_model(Q)) <= 4
    assert apart(np.asarray(model.base_parameters()), expected.base_parameters()) <= 4
    single = library.asarray(Q.astype(np.float32))
    assert model.direct_dynamics(single, single, single).dtype == library.float32
    p = library.asarray(expected.parameters(m1=3.0))
    assert apart(np.asarray(model.regressor(q, q, q, p)), expected.regressor(Q, Q, Q, np.asarray(p))) <= 4


def test_torch_differentiates_and_maps() -> None:
    torch = pytest.importorskip("torch")
    model = on_library(torch, "planar_2r.toml", "inertia_matrix")
    one = torch.tensor(Q[0], requires_grad=True)
    model.inertia_matrix(one)[0, 0].backward()
    assert one.grad.tolist() == pytest.approx([0.0, -2 * 1.5 * 0.4 * 0.15 * np.sin(-0.2)], rel=1e-15)
    mapped = torch.func.vmap(model.inertia_matrix)(torch.tensor(Q))
    assert torch.equal(mapped, model.inertia_matrix(torch.tensor(Q)))


def test_targets_are_matrices_or_rows() -> None:
    model = on_library(_Library(), "puma560.par", "inverse_geometric_model")
    arguments = inputs("puma560.par", "inverse_geometric_model", "inverse_geometric_model")
    T, p = arguments["T"], arguments["p"]
    with np.errstate(invalid="ignore"):
        found = model.inverse_geometric_model(T.reshape(-1, 4, 4), p)
        assert apart(found, model.inverse_geometric_model(T, p)) == 0
    expected = loaded("puma560.par", "inverse_geometric_model").inverse_geometric_model(T, p)
    assert apart(found, expected) <= 4 and not np.isnan(found[0]).all()


def test_numbers_are_reals_of_the_right_count() -> None:
    model = on_library(_Library(), "planar_2r.toml")
    with pytest.raises(ValueError, match=r"qd has shape \(3,\): \(\.\.\., 2\) is expected"):
        model.direct_dynamics([0, 0], [0, 0, 0], [0, 0])
    with pytest.raises(ValueError, match=r"p has shape \(2,\): \(\.\.\., 9\) is expected"):
        model.direct_dynamics([0, 0], [0, 0], [0, 0], np.zeros(2))
    with pytest.raises(TypeError, match="real numbers"):
        model.direct_dynamics(np.zeros(2) * 1j, [0, 0], [0, 0])
    with pytest.raises(TypeError, match="'tau'"):
        model.direct_dynamics([0, 0], [0, 0])


def test_parameters_that_floats_cannot_take_give_nan() -> None:
    """A division by zero on floats, as in the function on numpy: lengths and inertias zero."""
    model = on_library(_Library(), "planar_2r.toml")
    with np.errstate(all="ignore"):
        found = model.direct_dynamics(Q, Q, Q, np.zeros(9))
    assert np.isnan(found).all()


@pytest.mark.parametrize("m1", [2.5, 3.0])
def test_generated_packages_run_on_any_numbers(m1: float) -> None:
    """In 50 digits: the functions on numpy have the rounding of double precision only."""
    p = planar_2r.parameters(m1=m1)
    with mpmath.workdps(50):
        given = {} if m1 == 2.5 else {"p": _exact(p)}
        (found,) = planar_2r.trace("direct_dynamics", mpmath.mp, *map(_exact, Q), **given)
    assert isinstance(found[0], mpmath.mpf)
    assert apart(np.array(found, dtype=float), planar_2r.direct_dynamics(*Q, p)) <= 4
    with pytest.raises(ValueError, match="planar_2r has no model 'jacobian': choose from direct_dynamics, inverse"):
        planar_2r.trace("jacobian", mpmath.mp, [0, 0])


def _exact(x: Any) -> list[Any]:
    return [mpmath.mpf(float(each)) for each in x]


def test_what_is_no_backend_is_refused() -> None:
    with pytest.raises(se.InputError, match=r"^symoro_elastic: backend: unknown backend 'matlab': choose from numpy, "):
        se.load(machine("planar_2r.toml"), backend="matlab")
    with pytest.raises(se.InputError, match=r"^symoro_elastic: backend: numpy.linalg has no sin: give the name of a"):
        se.load(machine("planar_2r.toml"), backend=np.linalg)
    with pytest.raises(se.InputError, match=r"^symoro_elastic: steps: time steps are loaded with backend=\"numpy\""):
        se.load(machine("planar_2r.toml"), steps=["w3"], backend=np.linalg)


@pytest.mark.parametrize("name", ["casadi", "jax"])
def test_missing_packages_are_named_with_their_extra(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    from symoro_elastic.foundation import packages

    def fails(module: str) -> Any:
        if module == name:
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)
        return import_module(module)

    monkeypatch.setattr(packages, "import_module", fails)
    monkeypatch.delitem(__import__("sys").modules, "symoro_elastic.codegen.backends.casadi_functions", raising=False)
    with pytest.raises(se.InputError, match=rf"{name}: backend=\"{name}\" needs {name}: pip install 'symoro-elastic"):
        se.load(machine("planar_2r.toml"), "inertia_matrix", backend=name)
