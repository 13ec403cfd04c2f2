"""Generated models of machines with couplings and loops, against two references in 70 digits."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from types import ModuleType
from typing import Any

import mpmath
import numpy as np
import pytest
from mpmath import mpf

from symoro_elastic.codegen.targets.numpy import render_numpy
from symoro_elastic.machine.machine import Kind, Machine
from symoro_elastic.machine.scene import Scene
from symoro_elastic.models.packaging import trace_models
from symoro_elastic.numerics.verification.implementations import import_package
from tests.closed_chains.machines import FILES, WITH_RESULTS, data, in_order, machine, reordered, situations
from tests.references import multiprecision
from tests.references.closed_chains import DIGITS, Array, Chain, State, nearest_double
from tests.references.constraint_multipliers import Multipliers
from tests.references.elimination import zeros

pytestmark = pytest.mark.sampled(8)

TOLERANCE = {"gantry": 1e-11, "gantry_rigid": 1e-11}
"""Relative to the largest entry; the yaw of a beam between two motors is a small difference of large forces."""
ORDINARY = 1e-13
CASES = [(name, k) for name in FILES for k in range(2 if name in WITH_RESULTS else 1)]
COUPLED = [(name, k) for name, k in CASES if name != "coaxial_rigid"]
CONSTRAINED = [(name, k) for name, k in COUPLED if name not in ("ball_screw", "screw")]
"""Those with loops or joints without a variable of their own."""
ASSEMBLED = ("ring", "ring_with_slide")
"""Loops without a closed form."""
TOGETHER = (
    "direct_dynamics",
    "direct_dynamics_by_inertia_matrix",
    "inverse_dynamics",
    "inertia_matrix",
    "bias_forces",
    "energy",
    "reaction_wrenches",
    "linearization",
    "geometric_model",
    "velocities",
    "accelerations",
    "jacobian",
    "jacobian_dot_qd",
)
"""Models of all machines; `CLOSED_CHAINS` are those of machines with couplings and loops."""
CLOSED_CHAINS = ("dependent_coordinates", "coupling_matrix")

Results = dict[str, Any]


@cache
def reference(name: str, k: int) -> Multipliers:
    """Decimals of the file are rounded to double precision, as generated code holds them."""
    return Multipliers(machine(name), situations(name)[k].state, nearest_double)


def generated(name: str, model: str) -> tuple[ModuleType, tuple[str, ...]]:
    """A numpy package of a machine that has this model, and the names of its results."""
    module, results = _generated(name, models_of(name) if model in models_of(name) else (model,))
    return module, results[model]


@cache
def _generated(name: str, models: tuple[str, ...]) -> tuple[ModuleType, dict[str, tuple[str, ...]]]:
    return package_of(machine(name), *models)


def models_of(name: str) -> tuple[str, ...]:
    """Models that are generated together, so that the machine is traced once."""
    coupled = CLOSED_CHAINS if (name, 0) in COUPLED else ()
    return (*TOGETHER, *coupled, *(("constraint_forces",) if (name, 0) in CONSTRAINED else ()))


def package_of(described: Machine, *models: str) -> tuple[ModuleType, dict[str, tuple[str, ...]]]:
    """The numpy package of some models, and the names of the results of each."""
    found = trace_models(described, Scene(models=models))
    with TemporaryDirectory() as folder:
        module = import_package(render_numpy(found.package), Path(folder) / "numpy")
    return module, {one.model.name: tuple(one.rows) for one in found.models}


def computed(name: str, k: int, model: str, **more: Any) -> Results:
    """Results of a generated model by name; its arguments are those that its signature names."""
    module, names = generated(name, model)
    situation, chain = situations(name)[k], reference(name, k).chain
    given = {
        "q": situation.state.u,
        "qd": situation.state.ud,
        "q_dep": [float(reference(name, k).at[variable]) for variable in chain.dependent],
        "tau": situation.tau,
        "qdd_motor": situation.qdd_motor,
        **more,
    }
    function = getattr(module, model)
    found = function(**{key: given[key] for key in inspect.signature(function).parameters if key in given})
    return dict(zip(names, found if isinstance(found, tuple) else (found,), strict=True))


def assert_near(name: str, found: Any, wanted: Any, tolerance: float = ORDINARY, scale: Any = 0.001) -> None:
    """Differences are relative to the largest wanted entry, or to `scale` where that is larger."""
    with mpmath.workdps(DIGITS):
        exact = np.array(wanted, dtype=object)
        assert np.asarray(found).shape == exact.shape
        assert np.isfinite(np.asarray(found, dtype=float)).all()
        scale = max([mpf(scale), *map(abs, exact.ravel())])
        error = max(map(abs, (np.asarray(found, dtype=float).astype(object) - exact).ravel()), default=mpf(0))
        assert error < TOLERANCE.get(name, tolerance) * scale


def independent(found: Multipliers, entries: Array) -> Array:
    """Of entries by own variables those of the independent ones."""
    return entries[[found.chain.own.index(name) for name in found.chain.independent]]


def against_references(model: str) -> Callable[..., Any]:
    """The test of one model on every machine: it takes the results, the reference and the situation."""

    def tested(compare: Callable[[str, Results, Multipliers, Any], None]) -> Callable[[str, int], None]:
        @pytest.mark.parametrize(("name", "k"), CASES)
        def test(name: str, k: int) -> None:
            compare(name, computed(name, k, model), reference(name, k), situations(name)[k])

        return test

    return tested


@pytest.mark.sampled(80)
@pytest.mark.parametrize("model", ["direct_dynamics", "direct_dynamics_by_inertia_matrix"])
@pytest.mark.parametrize(("name", "k"), CASES)
def test_direct_dynamics(name: str, k: int, model: str) -> None:
    wanted = reference(name, k).direct(situations(name)[k].tau)
    assert_near(name, computed(name, k, model)["qdd"], independent(reference(name, k), wanted))


@pytest.mark.sampled(30)
@against_references("inverse_dynamics")
def test_inverse_dynamics(name: str, results: Results, found: Multipliers, situation: Any) -> None:
    tau, accelerations = found.inverse(situation.qdd_motor)
    assert_near(name, results["tau"], tau)
    assert_near(name, results["qdd"], independent(found, accelerations))


@pytest.mark.sampled(30)
@against_references("inertia_matrix")
def test_inertia_matrix(name: str, results: Results, found: Multipliers, _: Any) -> None:
    assert_near(name, results["A"], found.inertia())


@pytest.mark.sampled(30)
@against_references("bias_forces")
def test_bias_forces(name: str, results: Results, found: Multipliers, _: Any) -> None:
    assert_near(name, results["H"], found.bias())


@against_references("energy")
def test_energy(name: str, results: Results, found: Multipliers, _: Any) -> None:
    assert_near(name, results["E"], found.energies())


@pytest.mark.thorough
@pytest.mark.parametrize(("name", "k"), COUPLED)
def test_dependent_coordinates(name: str, k: int) -> None:
    assert_near(name, computed(name, k, "dependent_coordinates")["x"], reference(name, k).x)


@pytest.mark.sampled(30)
@pytest.mark.parametrize(("name", "k"), COUPLED)
def test_coupling_matrix(name: str, k: int) -> None:
    results, found = computed(name, k, "coupling_matrix"), reference(name, k)
    assert_near(name, results["S"], found.S)
    squared_rates = max([mpf(0), *map(abs, found.zd)]) ** 2
    assert_near(name, results["gam"], found.gam, scale=squared_rates)


@pytest.mark.thorough
@pytest.mark.sampled(12)
@pytest.mark.parametrize("name", ["five_bar", "geared_6r", "palletizer", "press"])
@pytest.mark.parametrize("model", ["direct_dynamics", "inverse_dynamics"])
def test_rows_in_another_order(name: str, model: str) -> None:
    """Accelerations and torques by variable are those of the machine as it is written."""
    whole, situation = machine(name), situations(name)[0]
    other = reordered(whole)
    known, chain = Chain(whole), Chain(other)
    module = package_of(other, model)[0]
    at = reference(name, 0).at
    given = {
        "q": [float(at[variable]) for variable in chain.independent],
        "qd": in_order(situation.state.ud, known.independent, chain.independent),
        "q_dep": [float(at[variable]) for variable in chain.dependent],
        "tau": in_order(situation.tau, known.motors, chain.motors),
        "qdd_motor": in_order(situation.qdd_motor, known.motors, chain.motors),
    }
    function = getattr(module, model)
    found = function(**{key: given[key] for key in inspect.signature(function).parameters if key in given})
    if model == "inverse_dynamics":
        tau, found = found
        assert_near(name, in_order(tau, chain.motors, known.motors), computed(name, 0, model)["tau"])
    wanted = computed(name, 0, model)["qdd"]
    assert_near(name, in_order(found, chain.independent, known.independent), wanted)


def test_the_sr400_stays_on_its_branch() -> None:
    """Over a grid of positions, through the flat one too: never the crossed bars."""
    module, _ = generated("sr400", "dependent_coordinates")
    chain = reference("sr400", 0).chain
    for th2 in np.linspace(-2.6, 0.4, 7):
        for th7 in np.linspace(-1.5, 1.5, 7):
            at = {"th1": 0.3, "th2": th2, "th4": 0.1, "th5": 0.2, "th6": -0.4, "th7": th7}
            x = dict(
                zip(chain.own, module.dependent_coordinates(q=[at[name] for name in chain.independent]), strict=True)
            )
            assert abs(x["th3"] - (th7 - th2 - np.pi / 2)) < 1e-15 * 8
            assert abs(x["th8"] - (th2 - th7)) < 1e-15 * 8


@pytest.mark.parametrize("name", ASSEMBLED)
@pytest.mark.parametrize("sign", [1, -1])
def test_assembly_from_an_error_of_a_tenth(name: str, sign: int) -> None:
    """In five steps; errors of neighbours have opposite signs."""
    chain, at = reference(name, 0).chain, reference(name, 0).at
    wanted = [at[variable] for variable in chain.dependent]
    guess = [float(x) + 0.1 * sign * (-1) ** k for k, x in enumerate(wanted)]
    results = computed(name, 0, "assemble", q_dep=guess)
    assert_near(name, results["q_dep"], wanted, 1e-14)
    assert float(np.squeeze(results["residual"])) < 1e-14


@pytest.mark.parametrize("model", ["direct_dynamics", "direct_dynamics_by_inertia_matrix", "inertia_matrix"])
@pytest.mark.parametrize("distance", [0, 1e-8])
def test_a_parallelogram_closed_by_a_loop_passes_its_flat_position(distance: float, model: str) -> None:
    """There, where the loop's equations are singular, it is the one whose angles are sums of angles."""
    q = [0.2, -0.7, -0.7 + distance, 0.001]
    given = {"q": q, "qd": [0.4, -0.8, 0.5, 0.01], "tau": [30.0, -12.0, 9.0]}
    wanted = Multipliers(machine("parallelogram"), State(q, given["qd"], {}), nearest_double)
    found = next(iter(computed("parallelogram_loop", 0, model, **given).values()))
    exact = wanted.inertia() if model == "inertia_matrix" else wanted.direct(given["tau"])
    assert_near("parallelogram_loop", found, exact, 1e-14)


@pytest.mark.sampled(30)
@pytest.mark.parametrize(("name", "k"), CONSTRAINED)
def test_constraint_forces(name: str, k: int) -> None:
    """On the motion of the direct model, motors on one freedom with the torques of the inverse model."""
    found, tau, qdd = driven(name, k)
    results = computed(name, k, "constraint_forces", qdd=qdd, tau=tau)
    wrenches, on_coupled = found.constraint_forces(qdd, tau)
    if wrenches:
        assert_near(name, results["mu"], wrenches)
    if on_coupled:
        assert_near(name, results["lam"], on_coupled)


@pytest.mark.parametrize(("name", "k"), CASES)
def test_reaction_wrenches(name: str, k: int) -> None:
    found, tau, qdd = driven(name, k)
    rows = _rows(found)
    wanted = found.reaction_wrenches(qdd, tau)
    results = computed(name, k, "reaction_wrenches", qdd=qdd, tau=tau)
    assert_near(name, results["f"][rows], [wanted[j] for j in rows])


@cache
def driven(name: str, k: int) -> tuple[Multipliers, Array, Array]:
    """The reference, torques of its motors as the inverse model gives them, and qdd under these, in doubles."""
    found = reference(name, k)
    accelerations = found.direct(situations(name)[k].tau)
    tau, _ = found.inverse([accelerations[found.chain.own.index(motor)] for motor in found.chain.motors])
    return found, tau.astype(float), independent(found, accelerations).astype(float)


@pytest.mark.sampled(30)
@pytest.mark.parametrize("name", FILES)
def test_linearization(name: str) -> None:
    """About the direct model's motion, motor torques held: K holds the tangent stiffness of constraint forces (L40)."""
    found = reference(name, 0)
    qdd = independent(found, found.direct(situations(name)[0].tau)).astype(float)
    results = computed(name, 0, "linearization", qdd=qdd)
    for label in "MDK":
        with mpmath.workdps(DIGITS):
            wanted = [[mpf(x) for x in row] for row in data(name)["linearization"][label]]
        assert_near(name, results[label], wanted, 1e-11)


@against_references("geometric_model")
def test_geometric_model(name: str, results: Results, found: Multipliers, _: Any) -> None:
    rows = _rows(found)
    assert_near(name, results["T"][rows], [found.frames[j].transform for j in rows])


@against_references("velocities")
def test_velocities(name: str, results: Results, found: Multipliers, _: Any) -> None:
    rows = _rows(found)
    with mpmath.workdps(DIGITS):
        frames = _motion(found, found.zd)
        wanted = [[*(frames[j].rotation.T @ frames[j].v), *(frames[j].rotation.T @ frames[j].w)] for j in rows]
    assert_near(name, results["V"][rows], wanted)


@pytest.mark.parametrize(("name", "k"), CASES)
def test_accelerations(name: str, k: int) -> None:
    found = reference(name, k)
    rows = _rows(found)
    with mpmath.workdps(DIGITS):
        qdd = independent(found, found.direct(situations(name)[k].tau)).astype(float)
        zdd = found.S_y[: len(found.z)] @ [mpf(x) for x in qdd] + found.gam_y[: len(found.z)]
        frames = _motion(found, found.zd, zdd)
        wanted = [[*(frames[j].rotation.T @ frames[j].a), *(frames[j].rotation.T @ frames[j].wd)] for j in rows]
    assert_near(name, computed(name, k, "accelerations", qdd=qdd)["Vd"][rows], wanted)


@against_references("jacobian")
def test_jacobian(name: str, results: Results, found: Multipliers, _: Any) -> None:
    """In frame 0, V = J ud on a base at rest: its columns are velocities under unit rates of each u."""
    rows = _rows(found)
    columns = [[[*f.v, *f.w] for f in _motion(found, column, at_rest=True)] for column in found.S_y[: len(found.z)].T]
    assert_near(name, results["J"][rows], np.array(columns, dtype=object)[:, rows].transpose(1, 2, 0))


@against_references("jacobian_dot_qd")
def test_jacobian_dot_qd(name: str, results: Results, found: Multipliers, _: Any) -> None:
    rows = _rows(found)
    frames = _motion(found, found.zd, found.gam_y[: len(found.z)], at_rest=True)
    assert_near(name, results["Vd"][rows], [[*frames[j].a, *frames[j].wd] for j in rows])


def _rows(found: Multipliers) -> list[int]:
    """Rows that are not cut joint."""
    return [j for j, joint in enumerate(found.chain.machine.joints) if joint.kind is not Kind.CUT]


def _motion(found: Multipliers, zd: Array, zdd: Array | None = None, at_rest: bool = False) -> list[Any]:
    """Motion of all frames, in frame 0; the base as the file says or at rest."""
    with mpmath.workdps(DIGITS):
        still = dict.fromkeys(("velocity", "angular_velocity", "acceleration", "angular_acceleration"), zeros(3))
        tree = replace(found.tree, base=replace(found.tree.base, **still)) if at_rest else found.tree
        accelerations = None if zdd is None else list(zdd)
        return multiprecision._frames(tree, list(found.z), list(zd), accelerations)
