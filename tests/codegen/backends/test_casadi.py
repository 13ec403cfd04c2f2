"""Models as functions of CasADi: the numbers of numpy, derivatives, names, parameters that may be left out."""

from __future__ import annotations

import inspect
import pickle
from typing import Any

import numpy as np
import pytest

import symoro_elastic as se
from tests.codegen.backends.compared import (
    BOTH,
    GOLDEN_MACHINES,
    ULP,
    apart,
    each_state,
    inputs,
    jacobians,
    loaded,
    machine,
    on,
)

pytestmark = pytest.mark.sampled(6)

casadi = pytest.importorskip("casadi")
EVERY = (
    ("planar_2r.toml", ("inertia_matrix", "geometric_model", "jacobian", "regressor", "energy", "base_parameters")),
    ("floating_arm.toml", (*BOTH, "inertia_matrix", "velocities")),
    ("four_bar.par", (*BOTH, "dependent_coordinates", "coupling_matrix", "constraint_forces")),
    ("puma560.par", ("inverse_geometric_model",)),
)


def on_casadi(example: str, *models: str) -> Any:
    from symoro_elastic.codegen.backends.casadi_functions import casadi_functions

    return on(casadi_functions, example, *models)


def as_columns(function: Any, arguments: list[Any]) -> list[Any]:
    """The arguments as a function of CasADi takes them: those of square inputs as matrices."""
    shapes = [function.size_in(k) for k in range(function.n_in())]
    return [x.reshape(shape) if shape[1] > 1 else x for x, shape in zip(arguments, shapes, strict=True)]


@pytest.mark.sampled(30)
@pytest.mark.parametrize("example", GOLDEN_MACHINES)
@pytest.mark.parametrize("name", BOTH)
def test_values_and_jacobians_of_golden_machines(example: str, name: str) -> None:
    """Values within 4 ulp of the largest, Jacobians by every argument within 1e-12 of the generated derivatives."""
    function = getattr(on_casadi(example), name)
    differentiated = function.jacobian()
    for arguments in each_state(inputs(example, name)):
        assert apart(function(*arguments), getattr(loaded(example), name)(*arguments)) <= 4
        given = [*arguments, *[0] * function.n_out()]
        found = dict(zip(differentiated.name_out(), differentiated.call(given), strict=True))
        for (result, argument), (rows, expected) in jacobians(example, name, arguments).items():
            assert apart(found[f"jac_{result}_{argument}"].full()[rows], expected) <= 1e-12 / ULP


@pytest.mark.parametrize(("example", "models"), EVERY)
def test_all_kinds_of_models(example: str, models: tuple[str, ...]) -> None:
    """Matrices, stacks of them, floating bases, closed loops, targets given as matrices."""
    model = on_casadi(example, *models)
    for name in models:
        function = getattr(model, name)
        for arguments in each_state(inputs(example, name, *models)):
            expected = getattr(loaded(example, *models), name)(*arguments)
            assert apart(function(*as_columns(function, arguments)), expected) <= 4, name


def test_loops_that_are_assembled() -> None:
    """The dependent variables are an argument and a result of `assemble`: their names differ in CasADi."""
    function = on_casadi("without_closed_form", "assemble").assemble
    assert function.name_in() == ["q", "q_dep", "p"] and function.name_out() == ["q_dep_out", "residual"]
    for arguments in each_state(inputs("without_closed_form", "assemble", "assemble")):
        assert apart(function(*arguments), loaded("without_closed_form", "assemble").assemble(*arguments)) <= 4


@pytest.mark.thorough
def test_total_derivatives_of_loops_that_are_assembled() -> None:
    """By q alone q_dep is held; where `assemble` gives it, the Jacobian is the generated one."""
    models = ("assemble", "direct_dynamics", "direct_dynamics_derivatives")
    model, expected = on_casadi("without_closed_form", *models), loaded("without_closed_form", *models)
    guess, *others = (casadi.SX.sym(name, model.direct_dynamics.size_in(name)) for name in ("q_dep", "qd", "tau", "p"))
    q, p = casadi.SX.sym("q", model.assemble.size_in("q")), others[-1]
    closed, _ = model.assemble(q, guess, p)
    total = casadi.jacobian(model.direct_dynamics(q, closed, *others), q)
    jacobian = casadi.Function("total", [q, guess, *others], [total])
    for arguments in each_state(inputs("without_closed_form", "direct_dynamics", *models)):
        assert apart(jacobian(*arguments), expected.direct_dynamics_derivatives(*arguments)[0]) <= 1e-12 / ULP


def test_names_shapes_and_parameters() -> None:
    model = se.load(machine("planar_2r.toml"), "direct_dynamics", "geometric_model", backend="casadi")
    function = model.direct_dynamics
    assert isinstance(function, casadi.Function) and function.name() == "planar_2r_direct_dynamics"
    assert function.name_in() == ["q", "qd", "tau", "p"] and function.name_out() == ["qdd"]
    assert str(inspect.signature(function)).startswith("(q, qd, tau, p=")
    state, heavier = ([0.3, -0.2], [1.0, 2.0], [0.5, 0.1]), model.parameters(m1=3.0)
    expected = loaded("planar_2r.toml").direct_dynamics
    assert apart(function(*state), expected(*state)) <= 4
    assert apart(function(*state, heavier), expected(*state, heavier)) <= 4
    assert apart(function(*state, p=heavier), expected(*state, heavier)) <= 4
    by_name = function(**dict(zip(("q", "qd", "tau"), state, strict=True)))
    assert by_name.keys() == {"qdd"} and apart(by_name["qdd"], expected(*state)) <= 4
    assert casadi.vertsplit(model.geometric_model([0.0, 0.0]), 4)[2][0, 3] == 0.4 + 0.3


def test_arguments_left_out_are_refused() -> None:
    """CasADi alone takes zeros for them where arguments are given by name."""
    function = on_casadi("planar_2r.toml").direct_dynamics
    with pytest.raises(TypeError, match="'qd'"):
        function(q=[0.0, 0.0], tau=[0.0, 0.0])
    with pytest.raises(TypeError, match="'tau'"):
        function([0.0, 0.0], [0.0, 0.0])


def test_symbols_batches_and_copies() -> None:
    function = on_casadi("planar_2r.toml").direct_dynamics
    q, expected = casadi.MX.sym("q", 2), loaded("planar_2r.toml").direct_dynamics
    called = casadi.Function("called", [q], [function(q, q, q)])
    states = np.random.default_rng(0).normal(size=(5, 2))
    wanted = expected(states, states, states)
    assert apart(called.map(5)(states.T).full().T, wanted) <= 4
    assert apart(function(states.T, states.T, states.T).full().T, wanted) <= 4
    copy = pickle.loads(pickle.dumps(function))
    assert apart(copy(states[0], states[0], states[0]), wanted[0]) <= 4


def test_friction_has_a_derivative_at_rest() -> None:
    """A sign counts as constant, as in the generated derivatives."""
    table = {
        "name": "slider",
        "joints": [{"name": "x", "kind": "motor", "sigma": 1, "r": "q1"}],
        "friction": {"x": {"coulomb": 3.0, "viscous": 2.0}},
        "bodies": {"x": {"mass": 4.0}},
    }
    function = se.load(table, "direct_dynamics", backend="casadi").direct_dynamics
    assert function.jacobian()(0.0, 0.0, 1.0, [], 0)[1] == -0.5


def test_machines_without_parameters() -> None:
    table = {
        "name": "slider",
        "joints": [{"name": "x", "kind": "motor", "sigma": 1, "r": "q1"}],
        "bodies": {"x": {"mass": 4.0}},
    }
    function = se.load(table, "direct_dynamics", backend="casadi").direct_dynamics
    assert function.size_in("p") == (0, 1) and function(0.0, 0.0, 2.0) == 0.5
