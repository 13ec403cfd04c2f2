"""Pose and rates of a floating base within a time step, in 50 digits, and implicit systems that hold a base."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import mpmath
import numpy as np
import pytest
from mpmath import mpf

from symoro_elastic.machine.machine import Kind, Machine, Orientation
from symoro_elastic.models.programs.catalogue import trace
from symoro_elastic.models.steps.implicit_steps import Motors, base_models
from symoro_elastic.symbolic.program import Program
from tests.closed_chains.machines import machine as coupled_machine
from tests.closed_chains.machines import situations
from tests.models.test_creep import creeping
from tests.models.test_floating_base import damped, on
from tests.models.test_implicit_steps import assert_solved, dense, given_numbers, slope, solution, values_of
from tests.references import multiprecision as reference
from tests.references.closed_chains import DIGITS, Array, exact
from tests.references.random_machines import random_machine, random_state

SMALL = mpf(10) ** -15
SLIGHTLY = mpf(10) ** -40
BY_BASE = {turned: on(random_machine(1, joints=2), turned=turned) for turned in Orientation}


def values(program: Program, given: Mapping[str, Sequence[Any]]) -> dict[str, Array]:
    symbols = {s: x for i in program.inputs for s, x in zip(i.symbols, given[i.name], strict=True)}
    return {name: np.array(x, dtype=object) for name, x in values_of(program, symbols).items()}


def drawn(size: int, seed: int, scale: float = 1.0) -> Array:
    return np.array([exact(float(x)) for x in np.random.default_rng(seed).uniform(-scale, scale, size)], dtype=object)


def unit(Q: Array) -> Array:
    return Q / mpmath.sqrt(sum(x * x for x in Q))


def matrix(turned: Array) -> Array:
    """Of nine numbers, or of a quaternion by its action on the axes: Q e Q*."""
    if turned.size == 9:
        return turned.reshape(3, 3)
    inverse = turned * np.array([1, -1, -1, -1])
    axes = [product(product(turned, np.array([0, *e], dtype=object)), inverse)[1:] for e in np.eye(3, dtype=int)]
    return np.array(axes, dtype=object).T


def product(a: Array, b: Array) -> Array:
    """Hamilton's product."""
    left = np.array([
        [a[0], -a[1], -a[2], -a[3]],
        [a[1], a[0], -a[3], a[2]],
        [a[2], a[3], a[0], -a[1]],
        [a[3], -a[2], a[1], a[0]],
    ], dtype=object)  # fmt: skip
    return left @ b


def hat(w: Array) -> Array:
    x, y, z = w
    return np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]], dtype=object)


def start_of(turned: Orientation) -> Array:
    Q = unit(drawn(4, 3))
    return Q if turned is Orientation.QUATERNION else matrix(Q).ravel()


def placed(turned: Orientation, at: Array, x: Array) -> tuple[Array, Array]:
    """Rotation and displacement at coordinates x."""
    displacement, _ = base_models(BY_BASE[turned])
    name = "Q0" if turned is Orientation.QUATERNION else "R0"
    found = values(displacement.program, {name: at, "x0": x})
    return matrix(at + found[f"{name}_change"]), found["P0_change"]


def largest(x: Array) -> Any:
    return max(map(abs, np.ravel(x)))


@pytest.mark.parametrize("turned", Orientation)
def test_rates_are_those_of_the_pose(turned: Orientation) -> None:
    """Along x', the base moves with its velocity V and turns with w: R' = R hat(w), P' = R v."""
    with mpmath.workdps(DIGITS):
        at, x, V, Vd = start_of(turned), drawn(6, 5), drawn(6, 6), drawn(6, 7)
        _, rates = base_models(BY_BASE[turned])
        found = values(rates.program, {"x0": x, "V0": V, "V0d": Vd})
        R, _ = placed(turned, at, x)
        (R_more, P_more), (R_less, P_less) = (placed(turned, at, x + s * SMALL * found["x0d"]) for s in (1, -1))
        assert largest((R_more - R_less) / (2 * SMALL) - R @ hat(V[3:])) < 1e-25
        assert largest((P_more - P_less) / (2 * SMALL) - R @ V[:3]) < 1e-25
        assert largest(found["V0_rate"] - [*(Vd[:3] - np.cross(V[3:], V[:3])), *Vd[3:]]) < SLIGHTLY


@pytest.mark.parametrize("turned", Orientation)
def test_a_turn_is_about_its_vector(turned: Orientation) -> None:
    """u = 2 tan(angle/2) times the axis, which the turn leaves as it is; s is in axes of the base."""
    with mpmath.workdps(DIGITS):
        at, x = start_of(turned), drawn(6, 8)
        R, P = placed(turned, at, x)
        turn, u = matrix(at).T @ R, x[3:]
        length = mpmath.sqrt(sum(u * u))
        assert largest(turn.T @ turn - np.eye(3, dtype=int)) < SLIGHTLY
        assert largest(turn @ u - u) < SLIGHTLY
        assert abs(mpmath.acos((turn[0, 0] + turn[1, 1] + turn[2, 2] - 1) / 2) - 2 * mpmath.atan(length / 2)) < SLIGHTLY
        assert np.dot([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]], u) > 0
        assert largest(P - matrix(at) @ x[:3]) < SLIGHTLY


@pytest.mark.parametrize("turned", Orientation)
def test_what_rounding_took_is_given_back(turned: Orientation) -> None:
    """A rotation wrong by e in its lengths is wrong by e^2 after a step."""
    with mpmath.workdps(DIGITS):
        e = mpf(10) ** -10
        at = start_of(turned) * (1 + e)
        for x in (drawn(6, 9), 0 * drawn(6, 9)):
            R, _ = placed(turned, at, x)
            assert largest(R.T @ R - np.eye(3, dtype=int)) < 10 * e**2


# Implicit systems


def inertia(described: Machine, given: Mapping[str, Sequence[Any]], symbols: Mapping[str, Any]) -> Array:
    """A of base and joints, by the model that other tests compare with references."""
    program = trace(described, "inertia_matrix").program
    entries = {s: exact(x) for i in program.inputs for s, x in zip(i.symbols, given[i.name], strict=True)}
    found = values_of(program, {**symbols, **entries})["A"]
    n = 6 + len(described.independent)
    return np.array(found, dtype=object).reshape(n, n)


def with_base(K: Array, of_base: Sequence[Any] = (0,) * 6) -> Array:
    """With the diagonal of the base, before that of the joints."""
    whole = np.zeros((6 + len(K), 6 + len(K)), dtype=object)
    whole[:6, :6] = np.diag(of_base)
    whole[6:, 6:] = K
    return whole


def sides(given: dict[str, Any], seed: int) -> dict[str, Any]:
    """Right sides of the base before those of the joints."""
    return given | {name: [*drawn(6, seed + k), *given[name]] for k, name in enumerate(("r_q", "r_v"))}


@pytest.mark.parametrize("motors", Motors)
def test_implicit_systems_of_trees(motors: Motors) -> None:
    """The base moves with the joints in (I - g T) z = r, without stiffness of its own, but with dampers."""
    kinds = (Kind.MOTOR, Kind.ELASTIC, Kind.PASSIVE)
    described = damped(on(creeping(random_machine(2, joints=4, kinds=kinds))))
    with mpmath.workdps(DIGITS):
        q, qd, _ = random_state(described, 2)
        given = sides(given_numbers(described, q, qd, 2), 20)
        rows = [reference._read(described, None).joints[j - 1] for j in described.independent]
        K = [row.stiffness * (row.kind is Kind.ELASTIC) for row in rows]
        D = [row.damping * (row.kind is Kind.ELASTIC) + slope(row, x) for row, x in zip(rows, qd, strict=True)]
        entries = list(described.motor_entries)
        if motors is Motors.SERVO:
            for k, kp, kd in zip(entries, given["kp"], given["kd"], strict=True):
                K[k], D[k] = K[k] + kp, D[k] + kd
        held = [6 + k for k in entries] if motors is Motors.DRIVEN else []
        A, r = inertia(described, given, {}), [*given["r_q"], *given["r_v"]]
        of_base = [exact(cell.value()) for cell in described.damping_of_base]
        wanted = dense(A, with_base(np.diag(K)), with_base(np.diag(D), of_base), held, r)
        assert_solved(solution(described, motors, given, {}), wanted, 1e-18)


def test_implicit_systems_of_coupled_joints() -> None:
    """A differential: S and g K are those that its system has on a fixed base, from all unit right sides."""
    fixed, state = creeping(coupled_machine("differential")), situations("differential")[0].state
    described, n = on(fixed), len(fixed.independent)
    with mpmath.workdps(DIGITS):
        given = sides(given_numbers(described, state.u, [0] * n, 3), 30)
        symbols = {p.name: p.value.evaluate({}, {}, exact) for p in described.parameters if p.value}
        A, one = inertia(described, given, symbols), np.eye(n, dtype=int)
        answers = {
            name: np.array([unit_answer(fixed, given, symbols, name, e) for e in one], dtype=object).T
            for name in ("r_q", "r_v")
        }
        left = A[6:, 6:] @ inverse(one - answers["r_v"])
        S, gK = left - A[6:, 6:], left @ answers["r_q"]
        r_q, r_v = (np.array(given[name], dtype=object) for name in ("r_q", "r_v"))
        right = np.array([*np.zeros(6, dtype=int), *(S @ r_v[6:] + gK @ r_q[6:])], dtype=object)
        z_v = r_v - inverse(A + with_base(S)) @ right
        wanted = np.array([*(r_q + exact(given["g"][0]) * z_v), *z_v], dtype=object)
        assert_solved(solution(described, Motors.TORQUE, given, symbols), wanted, 1e-35)


def unit_answer(described: Machine, given: Mapping[str, Any], symbols: dict[str, Any], name: str, e: Array) -> Array:
    """x = r_v - z_v of the system of a machine, for one right side that is one."""
    right = {side: e.tolist() if side == name else [0] * len(e) for side in ("r_q", "r_v")}
    z_v = solution(described, Motors.TORQUE, {**given, **right}, symbols)[len(e) :]
    found: Array = np.array(right["r_v"], dtype=object) - z_v
    return found


def inverse(A: Array) -> Array:
    return np.array(mpmath.matrix(A.tolist()) ** -1, dtype=object).reshape(A.shape)
