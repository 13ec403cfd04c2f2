"""Linear systems of implicit steps against dense ones of references, (I - g T) z = r, in many digits."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Any

import mpmath
import numpy as np
import pytest
from mpmath import mpf

from symoro_elastic.machine.machine import Kind, Machine
from symoro_elastic.models.steps.implicit_steps import Motors, implicit_system
from symoro_elastic.models.steps.time_steps import ways_to_give_motors
from symoro_elastic.symbolic.arithmetic import evaluate, multiprecision
from symoro_elastic.symbolic.program import Program
from tests.closed_chains.machines import machine, situations
from tests.models.test_creep import creeping
from tests.references import multiprecision as reference
from tests.references.closed_chains import DIGITS, Array, exact
from tests.references.constraint_multipliers import Multipliers
from tests.references.numbers_of_machine import JointNumbers
from tests.references.random_machines import random_machine, random_state, with_springs_beside_motors

pytestmark = pytest.mark.sampled(6)

G = Fraction("0.013")
MANY_DIGITS, DIGITS_OF_SLOPES = 1e-40, 1e-18

TREES = [creeping(random_machine(seed, joints=5, kinds=(Kind.MOTOR, Kind.ELASTIC, Kind.PASSIVE))) for seed in range(4)]
TREES += [with_springs_beside_motors(TREES[2])]
COUPLED = ("ball_screw", "coupled_wrist", "five_bar", "ring", "delta", "gantry_rigid")


def values_of(program: Program, symbols: Mapping[str, Any]) -> dict[str, list[Any]]:
    value = evaluate([x for o in program.outputs for x in o.entries], symbols, multiprecision(DIGITS))
    return {o.name: [mpf(value(x)) for x in o.entries] for o in program.outputs}


def solution(described: Machine, motors: Motors, given: Mapping[str, Sequence[Any]], symbols: dict[str, Any]) -> Array:
    """z_q, then z_v, by both models, one after the other."""
    factors, solve = (traced.program for traced in implicit_system(described, motors))
    known = symbols | {s: exact(x) for i in factors.inputs for s, x in zip(i.symbols, given[i.name], strict=True)}
    (handed,) = values_of(factors, known).values()
    entries = given | {"factors": handed}
    known = symbols | {s: exact(x) for i in solve.inputs for s, x in zip(i.symbols, entries[i.name], strict=True)}
    found = values_of(solve, known)
    return np.array([*found["z_q"], *found["z_v"]], dtype=object)


def dense(A: Array, K: Array, D: Array, held: Sequence[int], r: Array) -> Array:
    """z of (I - g T) z = r, T = [0 I; -A^-1 K, -A^-1 D]; what is held does not depend on the state, nor moves it."""
    n, g = len(A), exact(G)
    free = [k for k in range(n) if k not in held]
    matrix, sides = mpmath.eye(2 * n), [exact(x) for x in r]
    right = mpmath.matrix(sides)
    for i in range(n):
        matrix[i, n + i] = -g
    for i in free:
        right[n + i] = sum(A[i][j] * sides[n + j] for j in free)
        for j in free:
            matrix[n + i, j], matrix[n + i, n + j] = g * K[i][j], A[i][j] + g * D[i][j]
    return np.array(list(mpmath.lu_solve(matrix, right)), dtype=object)


def assert_solved(found: Array, wanted: Array, digits: float) -> None:
    largest = max(map(abs, wanted))
    assert largest > 0.01 and max(map(abs, found - wanted)) < digits * largest


def slope(row: JointNumbers, rate: Any) -> Any:
    """Derivative of friction by the velocity, by a difference: 1e-20 of its size is lost."""
    h = mpf(10) ** -12
    return (row.friction(exact(rate) + h) - row.friction(exact(rate) - h)) / (2 * h) if row.creep else row.viscous


def symbols_of(described: Machine) -> dict[str, Any]:
    return {p.name: p.value.evaluate({}, {}, exact) for p in described.parameters if p.value}


def given_numbers(described: Machine, q: Sequence[Any], qd: Sequence[Any], seed: int) -> dict[str, Any]:
    rng = np.random.default_rng(seed)
    n, m = len(described.independent), len(described.motors)
    gains = {name: rng.uniform(100, 1000, m).tolist() for name in ("kp", "kd")}
    sides = {name: rng.uniform(-1, 1, n).tolist() for name in ("r_q", "r_v")}
    return {"q": q, "qd": qd, "g": [G], **gains, **sides}


@pytest.mark.parametrize("motors", Motors)
@pytest.mark.parametrize("described", TREES, ids=lambda one: one.name)
def test_trees(described: Machine, motors: Motors) -> None:
    """Springs, dampers, friction that creeps, passive joints, rotors, slides."""
    if motors not in ways_to_give_motors(described):
        pytest.skip("all joints have motors, or none has")
    with mpmath.workdps(DIGITS):
        q, qd, _ = random_state(described, 2)
        given = given_numbers(described, q, qd, 2)
        rows = [reference._read(described, None).joints[j - 1] for j in described.independent]
        K = [row.stiffness for row in rows]
        D = [row.damping * (row.kind is Kind.ELASTIC) + slope(row, x) for row, x in zip(rows, qd, strict=True)]
        entries = list(described.motor_entries)
        if motors is Motors.SERVO:
            for k, kp, kd in zip(entries, given["kp"], given["kd"], strict=True):
                K[k], D[k] = K[k] + kp, D[k] + kd
        A = reference.inertia_matrix(described, q)
        held = entries if motors is Motors.DRIVEN else []
        wanted = dense(A, np.diag(K), np.diag(D), held, [*given["r_q"], *given["r_v"]])
        assert_solved(solution(described, motors, given, symbols_of(described)), wanted, DIGITS_OF_SLOPES)


@pytest.mark.parametrize("motors", Motors)
@pytest.mark.parametrize("name", COUPLED)
def test_couplings_and_loops(name: str, motors: Motors) -> None:
    """K and D over own variables, friction of coupled joints too: S^T K S."""
    described, situation = machine(name), situations(name)[0]
    if motors not in ways_to_give_motors(described):
        pytest.skip("all independent joints have motors")
    with mpmath.workdps(DIGITS):
        at = Multipliers(described, situation.state)
        given = given_numbers(described, situation.state.u, situation.state.ud, 3)
        given["q_dep"] = [at.at[variable] for variable in at.chain.dependent]
        table = at.chain.numbers(at.at).joints
        rows = [table[j - 1] for j in described.with_variable]
        K = [row.stiffness for row in rows]
        D = [row.damping + row.viscous for row in rows]
        if motors is Motors.SERVO:
            for j, kp, kd in zip(described.motors, given["kp"], given["kd"], strict=True):
                k = described.with_variable.index(j)
                K[k], D[k] = K[k] + kp, D[k] + kd
        moved = [j for j in described.articulated if j not in described.with_variable]
        on_joints = [at.S[list(described.articulated).index(j)] for j in moved]
        coupled = sum((table[j - 1].viscous * np.outer(s, s) for j, s in zip(moved, on_joints, strict=True)), 0)
        wanted = dense(
            at.inertia(),
            at.S_x.T @ np.diag(K) @ at.S_x,
            at.S_x.T @ np.diag(D) @ at.S_x + coupled,
            list(described.motor_entries) if motors is Motors.DRIVEN else [],
            [*given["r_q"], *given["r_v"]],
        )
        assert_solved(solution(described, motors, given, symbols_of(described)), wanted, MANY_DIGITS)
