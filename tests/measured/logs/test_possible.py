"""Possible bodies: the cone, its Newton method, machines that are saved, and what standard deviations mean."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("scipy")

import symoro_elastic as se
from symoro_elastic.analysis.time_series.measurements import Measurements
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.machine import Machine
from symoro_elastic.measured.fitting.estimates import Verdict
from symoro_elastic.measured.logs.identified import Identified
from symoro_elastic.measured.logs.possible import Possible
from symoro_elastic.measured.logs.pseudo_inertia import Prior, inertial_parameters, lifted, nearest, pseudo_inertia
from symoro_elastic.measured.logs.views import table
from symoro_elastic.mechanics.regressor import INERTIAL
from symoro_elastic.numerics.linear.regressor import nominal_body, regressor
from tests.benchmarks.identification import CASES
from tests.benchmarks.possible import cut, off
from tests.benchmarks.sensors import CASES as SENSORS
from tests.benchmarks.sensors import three_axis

ALONE = 1e-6


def bodies(count: int, rng: np.random.Generator, thin: float = 0.02) -> Array:
    """Return random pseudo-inertias, of points scattered in ellipsoids as thin as a share of their length."""
    found = []
    for _ in range(count):
        points = rng.normal(size=(30, 3)) * rng.uniform(thin, 1, 3) * 0.3 + rng.normal(size=3) * 0.2
        masses = rng.uniform(0.01, 0.5, 30)
        v = np.concatenate([points, np.ones((30, 1))], axis=1)
        found.append(np.einsum("p,pi,pk->ik", masses, v, v))
    return np.array(found)


def with_scalars(J: Array, count: int) -> Prior:
    return Prior(J, np.full(count, 0.5), np.ones(count), np.zeros(1), np.ones(1), np.array([False]))


def test_pseudo_inertia_is_the_second_moment_of_points() -> None:
    rng = np.random.default_rng(0)
    r, m = rng.normal(size=(7, 3)), rng.uniform(0.1, 1, 7)
    tensor = sum(k * (x @ x * np.eye(3) - np.outer(x, x)) for k, x in zip(m, r, strict=True))
    x = np.array([*tensor[np.triu_indices(3)], *(m @ r), m.sum()])
    v = np.concatenate([r, np.ones((7, 1))], axis=1)
    J = pseudo_inertia(x)
    assert np.allclose(J, np.einsum("p,pi,pk->ik", m, v, v), rtol=1e-13, atol=1e-13)
    assert np.allclose(inertial_parameters(J), x, rtol=1e-13)


@pytest.mark.parametrize("body", ["point", "rod", "massless", "negative"])
def test_lifted_bodies_are_possible(body: str) -> None:
    x = {
        "point": [0.0] * 6 + [0.2, 0.0, 0.0, 2.0],
        "rod": [0, 0, 0, 0.3, 0, 0.3, 0, 0, 0, 4.0],
        "massless": [0.1, 0, 0, 0, 0, 0, 0, 0, 0, 0],
        "negative": [0.1, 0.3, 0, -0.1, 0, 0.1, 1.0, 0, 0, 0.5],
    }[body]
    J, is_new = lifted(pseudo_inertia(np.array(x)), 1.5)
    assert is_new and np.linalg.eigvalsh(J).min() > 0
    if body == "massless":
        assert J[3, 3] == pytest.approx(1.5)


def test_possible_bodies_are_not_lifted() -> None:
    for J in bodies(20, np.random.default_rng(1), thin=0.2):
        same, is_new = lifted(J, 1.0)
        assert not is_new and np.array_equal(same, J)


def cost_of(prior: Prior, A: Array, b: Array, lam: float, x: Array) -> float:
    """Return the cost, written anew."""
    J0, count = prior.bodies, len(prior.bodies)
    J = pseudo_inertia(x[: 10 * count].reshape(count, 10))
    divergence = sum(np.trace(np.linalg.solve(a, c)) - np.linalg.slogdet(c)[1] for a, c in zip(J0, J, strict=True))
    s = x[10 * count : 10 * count + len(prior.scalars)]
    of_scalars = lam * (prior.weights * (s / prior.scalars - np.log(s))).sum()
    return float(((A @ x - b) ** 2).sum() / 2 + lam * divergence + of_scalars + (x[-1] ** 2) / 2)


@pytest.mark.sampled(12)
@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("lam", [2.8, 1e-2])
def test_least_cost_from_any_start(seed: int, lam: float) -> None:
    """Data ask for bodies that do not exist; no neighbour costs less than what is found."""
    rng = np.random.default_rng(seed)
    truth, start = bodies(3, rng), bodies(3, rng)
    prior = with_scalars(start, 2)
    A = rng.normal(size=(25, 33)) * 10.0 ** rng.uniform(-1, 2, 33)
    x = np.concatenate([inertial_parameters(truth).ravel(), [0.3, -0.2], [0.1]])
    b = A @ (x + 0.1 * rng.normal(size=len(x)))
    found = nearest(prior, A, b, lam)
    assert np.linalg.eigvalsh(pseudo_inertia(found.x[:30].reshape(3, 10))).min() > 0 and (found.x[30:32] > 0).all()
    least = cost_of(prior, A, b, lam, found.x)
    size = np.sqrt(np.diag(found.covariance))
    spread = size[:, None] * np.linalg.cholesky(found.covariance / np.outer(size, size))
    for _ in range(40):
        near = found.x + 1e-2 * spread @ rng.normal(size=len(x))
        assert cost_of(prior, A, b, lam, near) > least
    for k in range(0, len(x), 4):
        rises = [cost_of(prior, A, b, lam, found.x + sign * 0.01 * spread[:, k]) - least for sign in (1, -1)]
        assert sum(rises) == pytest.approx(1e-4, rel=1e-2)


def by_clarabel(prior: Prior, A: Array, b: Array) -> tuple[float, bool]:
    """Return the least misfit over possible parameters by an interior-point method of its own, and if it is sure."""
    clarabel = pytest.importorskip("clarabel", reason="clarabel judges the constraints: pip install clarabel")
    from scipy import sparse

    count, factors = len(prior.bodies), np.linalg.cholesky(prior.bodies)
    T = np.diag(np.concatenate([np.ones(10 * count), prior.scalars, np.ones(1)]))
    for j, L in enumerate(factors):
        units = inertial_parameters(L @ pseudo_inertia(np.eye(10)) @ L.T)
        T[10 * j : 10 * j + 10, 10 * j : 10 * j + 10] = units.T
    size = len(T)
    cones, rows, right = [], [], []
    order = [(i, k) for k in range(4) for i in range(k + 1)]  # upper triangles, column by column
    for j in range(count):
        block = np.zeros((10, size))
        for c in range(10):
            J = pseudo_inertia(T[10 * j : 10 * j + 10, 10 * j + c])
            scaled = np.linalg.solve(factors[j], np.linalg.solve(factors[j], J).T)
            block[:, 10 * j + c] = [-scaled[i, k] * (1.0 if i == k else math.sqrt(2)) for i, k in order]
        rows.append(block)
        cones.append(clarabel.PSDTriangleConeT(4))
    positive = np.zeros((len(prior.scalars), size))
    positive[:, 10 * count : 10 * count + len(prior.scalars)] = -np.eye(len(prior.scalars))
    cones.append(clarabel.NonnegativeConeT(len(prior.scalars)))
    G = np.concatenate([*rows, positive])
    right = np.zeros(len(G))
    AT = np.concatenate([A @ T, np.eye(size)[-1:]])
    level = np.append(b, 0.0)
    settings = clarabel.DefaultSettings()
    settings.verbose, settings.tol_gap_abs, settings.tol_gap_rel, settings.tol_feas = False, 1e-11, 1e-11, 1e-11
    P, q = sparse.csc_matrix(np.triu(AT.T @ AT)), -AT.T @ level
    solution = clarabel.DefaultSolver(P, q, sparse.csc_matrix(G), right, cones, settings).solve()
    y = np.array(solution.x)
    return float(((AT @ y - level) ** 2).sum() / 2), str(solution.status) == "Solved"


@pytest.mark.sampled(5)
@pytest.mark.parametrize("seed", range(5))
def test_constraints_alone_cost_as_clarabel_says(seed: int) -> None:
    rng = np.random.default_rng(seed)
    prior = with_scalars(bodies(4, rng), 3)
    A = rng.normal(size=(35, 44)) * 10.0 ** rng.uniform(0, 2, 44)
    x = np.concatenate([inertial_parameters(bodies(4, rng)).ravel(), [0.3, -0.2, 0.5], [0.1]])
    b = A @ (x + 0.3 * rng.normal(size=len(x)))
    found = nearest(prior, A, b, ALONE)
    own = found.misfit + found.x[-1] ** 2 / 2
    judged, is_sure = by_clarabel(prior, A, b)
    assert own <= judged * (1 + 1e-5)
    assert not is_sure or own == pytest.approx(judged, rel=1e-5)


@cache
def light(seconds: float, seed: int = 1) -> Measurements:
    record = three_axis().record(SENSORS["17 bits, 500 Hz"], seed)
    return cut(record, seconds)


def columns(record: Measurements, machine: Machine) -> dict[str, Array]:
    named = {"t": record.t}
    named |= {f"q_{j.name}": x for j, x in zip(machine.independent_joints, record.q.T, strict=True)}
    return named | {f"tau_{j.name}": x for j, x in zip(machine.motor_joints, record.tau.T, strict=True)}


def found_in(found: Identified) -> Possible:
    assert found.found.possible is not None
    return found.found.possible


@pytest.mark.thorough
@pytest.mark.parametrize("trust", [None, 0.3])
@pytest.mark.parametrize("suffix", [".toml", ".par"])
def test_saved_bodies_are_possible_when_read_back(trust: float | None, suffix: str, tmp_path: Path) -> None:
    machine = off(three_axis().machine, 0.3, 3)
    found = se.identify(machine, columns(light(5.0), machine), possible=True, trust=trust)
    fitted, _ = found.saved()
    path = se.write(fitted, tmp_path / f"fitted{suffix}")
    read = se.read(path)
    values = {p.name: p.value.value() for p in read.parameters if p.value is not None}
    for joint in read.joints:
        x = nominal_body(joint.body, values)
        if x["M"] != 0:
            assert np.linalg.eigvalsh(pseudo_inertia(np.array([x[name] for name in INERTIAL]))).min() > 0
    if suffix == ".toml":
        Y, states = regressor(read), regressor(machine).states(20)
        predicted = Y.evaluate(*states, range(len(Y.columns))) @ np.array([c.value for c in Y.columns])
        of = {(c.row, c.quantity): k for k, c in enumerate(Y.columns)}
        X = np.zeros(len(Y.columns))
        for key, value in found_in(found).values.items():
            X[of[key]] = value
        assert np.allclose(predicted, Y.evaluate(*states, range(len(X))) @ X, rtol=1e-12, atol=1e-12)


@pytest.mark.thorough
def test_right_bodies_lose_nothing() -> None:
    """A long record: least squares within its deviations, whatever the file says of bodies."""
    machine, record = off(three_axis().machine, 0.3, 5), light(20.0)
    plain = se.identify(machine, columns(record, machine), validate=columns(light(20.0, 2), machine))
    found = se.identify(machine, columns(record, machine), possible=True, validate=columns(light(20.0, 2), machine))
    for a, b in zip(plain.found.estimates, found.found.estimates, strict=True):
        assert b.std == a.std and b.verdict == a.verdict and abs(a.value - b.value) < 2 * a.std
    assert plain.validation and found.validation
    for name, percent in found.validation.percent.items():
        assert percent <= plain.validation.percent[name] + 0.1


@pytest.mark.thorough
def test_short_records_are_identified() -> None:
    machine = off(three_axis().machine, 0.3, 4)
    short, unseen = columns(light(1.5), machine), columns(light(20.0, 2), machine)
    with pytest.raises(InputError, match="equations after filtering"):
        se.identify(machine, short)
    found = se.identify(machine, short, possible=True, trust=0.3, validate=unseen)
    assert found.validation and max(found.validation.percent.values()) < 30
    assert any("short" in note for note in found.found.notes)
    assert all(np.linalg.eigvalsh(J).min() > 0 for J in found_in(found).bodies().values())


@pytest.mark.sampled(2)
@pytest.mark.parametrize("seed", range(2))
def test_no_sentence_and_no_verdict_of_a_short_record_are_of_the_fit_that_is_refused(seed: int) -> None:
    """A verdict is that of the value and the standard deviation in its row; the torque of the wrist is mostly noise."""
    machine, record = off(three_axis().machine, 0.3, 4), light(2.0, seed)
    weak = 0.05 * record.tau[:, 2]
    noise = 10 * weak.std() * np.random.default_rng(seed).normal(size=len(weak))
    record = replace(record, tau=np.column_stack([record.tau[:, :2], weak + noise]))
    found = se.identify(machine, columns(record, machine), possible=True).found
    judged = [e for e in found.estimates if e.verdict is Verdict.IDENTIFIED]
    assert judged and all(e.std <= 0.1 * abs(e.value) for e in judged)
    for word in ("least squares alone", "physically impossible", "asks for bodies", "stay correlated"):
        assert not [note for note in found.notes if word in note], word


def test_a_joint_that_rests_in_a_short_record_has_the_guesses_of_the_others() -> None:
    """Its torque may be zero throughout; friction that a share of it would need at its velocity is no guess."""
    machine, record = three_axis().machine, light(1.5)
    q, tau = record.q.copy(), record.tau.copy()
    q[:, 2], tau[:, 2] = q[0, 2] + 1e-3 * (q[:, 2] - q[0, 2]), 0.0
    found = se.identify(machine, columns(replace(record, q=q, tau=tau), machine), possible=True)
    values = found_in(found).values
    assert found_in(found).trust == 1.0 and any("no trust is given" in note for note in found.found.notes)
    assert max(values[3, name] for name in ("FV", "IA")) < 20.0
    assert all(np.linalg.eigvalsh(J).min() > 0 for J in found_in(found).bodies().values())


@pytest.mark.thorough
def test_a_torque_in_another_unit_is_named() -> None:
    machine, record = three_axis().machine, light(5.0)
    tau = record.tau * [1.0, 0.02, 1.0]
    found = se.identify(machine, columns(replace(record, tau=tau), machine), possible=True)
    (note,) = (x for x in found.found.notes if "more than chance" in x)
    assert "(--gain); most of it at lift: " in note


@pytest.mark.thorough
def test_springs_are_positive() -> None:
    case = CASES["elastic two-axis arm"]("elastic two-axis arm")
    found = se.identify(case.machine, columns(case.record(1, 0), case.machine), possible=True, known=case.known)
    values = found_in(found).values
    assert {"K", "DA", "KQ"} <= {quantity for _, quantity in values}
    assert all(x > 0 for (_, quantity), x in values.items() if quantity in ("M", "K", "DA", "FV", "FS", "IA"))
    for e in found.found.estimates:
        if e.unknown.quantity == "K":
            assert abs(e.value - e.unknown.nominal) < 4 * e.std
    assert not found.saved()[0].is_grouped


@pytest.mark.thorough
def test_known_values_are_kept_and_impossible_ones_refused() -> None:
    machine, record = three_axis().machine, light(5.0)
    found = se.identify(machine, columns(record, machine), possible=True, known={"M3": 5.0})
    assert found_in(found).values[3, "M"] == 5.0
    with pytest.raises(InputError, match="no body has the values that are given as known"):
        se.identify(machine, columns(record, machine), possible=True, known={"M3": -1.0})


def test_trust_is_of_possible_bodies() -> None:
    machine = three_axis().machine
    with pytest.raises(InputError, match="possible bodies only"):
        se.identify(machine, columns(light(5.0), machine), trust=0.3)


@pytest.mark.thorough
def test_two_columns_of_deviations() -> None:
    machine = three_axis().machine
    found = se.identify(machine, columns(light(5.0), machine), possible=True, trust=0.05)
    both = zip(found.found.estimates, found_in(found).with_file, strict=True)
    assert all(with_file < 1.001 * e.std for e, with_file in both)
    assert "std with file" in str(table(found.found))
