"""Linear systems of implicit steps with states of friction and drives (D7), (D8), against dense ones in many digits."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import mpmath
import numpy as np
import pytest
from mpmath import mpf

from symoro_elastic.machine.described import DescribedMachine
from symoro_elastic.machine.drives import CurrentControl, Drive, Drives, LowPass, Notch
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.joints import Electrics
from symoro_elastic.machine.machine import Friction, Kind, Machine
from symoro_elastic.models.bound.bind import Bound
from symoro_elastic.models.drives.drive_states import chains_of
from symoro_elastic.models.programs.catalogue import trace
from symoro_elastic.models.steps.implicit_steps import Motors, implicit_system
from tests.closed_chains.machines import machine, situations
from tests.models.test_floating_base import on
from tests.models.test_implicit_steps import G, values_of
from tests.references.closed_chains import DIGITS, Array, exact
from tests.references.constraint_multipliers import Multipliers
from tests.references.drive_in_time import DriveInTime, Given
from tests.references.random_machines import random_machine, random_state

pytestmark = pytest.mark.sampled(6)

CLOSE = 1e-12
LUGRE, ELASTO_PLASTIC = "0", "0.6"
COUPLED = ("ball_screw", "coupled_wrist", "five_bar", "ring", "delta", "gantry_rigid")


def formula(x: float) -> Formula:
    return Formula.parse(repr(float(x)))


def some_drive(rng: np.random.Generator) -> Drive:
    """Each part of a drive is there or not."""
    numbers = {key: formula(10 ** rng.uniform(*decades)) for key, decades in {"Kv": (0, 2), "Kp": (-1, 2)}.items()}
    notch = Notch(formula(rng.uniform(30, 300)), formula(0.1), formula(0.7))
    filters = (notch, LowPass(formula(200), 2), LowPass(formula(500)))
    optional = {
        "Tn": formula(0.02),
        "lag": formula(10 ** rng.uniform(-6, -3)),
        "dead_time": formula(1.5e-4),
        "filters": tuple(one for one in filters if rng.random() < 0.5),
        "set_point": LowPass(formula(40), int(rng.integers(1, 3))),
        "acceleration_forward": formula(0.3),
        "torque_limit": formula(10 ** rng.uniform(-1, 4)),
        "windup": formula(10 ** rng.uniform(-3, -1)),
    }
    electric: dict[str, Any] = {}
    if rng.random() < 0.5:
        electric["current"] = CurrentControl(formula(4.0), formula(3e-3), formula(rng.choice([0, 0.6, 1])))
        electric["current_limit"] = formula(10 ** rng.uniform(-1, 4)) if rng.random() < 0.5 else None
        electric["voltage_limit"] = formula(10 ** rng.uniform(0, 4)) if rng.random() < 0.7 else None
        optional["lag"] = formula(0)
    return Drive(**numbers, **electric, **{key: x for key, x in optional.items() if rng.random() < 0.7})


def with_states(described: Machine, seed: int) -> DescribedMachine:
    """The machine with 0 to 3 drives, and with bristles on about half of its joints."""
    rng = np.random.default_rng(seed)
    joints = []
    for joint in described.joints:
        keys = ("viscous", "coulomb", "static", "stribeck", "bristle", "bristle_damping")
        law = dict(zip(keys, map(formula, rng.uniform([0, 1, 2, 0.5, 200, 1], [1, 2, 3, 1, 300, 5])), strict=True))
        kind = rng.choice([LUGRE, ELASTO_PLASTIC])
        bent = Friction(**law, breakaway=Formula.parse(kind))
        moves = joint.kind not in (Kind.FIXED, Kind.CUT) and rng.random() < 0.5
        winding = Electrics(*map(formula, rng.uniform([0.1, 1e-3, 0.05, 0.05], [1, 1e-2, 0.5, 0.5])))
        joints.append(replace(joint, friction=bent if moves else joint.friction, electrics=winding))
    motors = [joint.name for joint in described.motor_joints]
    chosen = rng.permutation(motors)[: int(rng.integers(0, 4))]
    made = DescribedMachine.of(replace(described, joints=tuple(joints)))
    return replace(made, drives=Drives({str(name): some_drive(rng) for name in chosen}))


def bristle_slopes(law: Friction, v: Any, z: Any) -> tuple[Any, Any, Any, Any, Any]:
    """dzd/dv and dzd/dz as steps take them, the latter of a bristle that slips; s0, s1 and s2, of (D1) and (D2)."""
    cell = {key: mpf(getattr(law, key).value()) for key in vars(law)}
    s0, beta = cell["bristle"], cell["breakaway"]
    g = cell["coulomb"] + (cell["static"] - cell["coulomb"]) / (1 + (v / cell["stribeck"]) ** 2)
    zs, zb = g / s0, beta * g / s0
    alpha = mpf(1)
    if beta:
        x = min(max((abs(z) - zb) / (zs - zb), 0), 1) if v * z > 0 else mpf(0)
        alpha = 3 * x**2 - 2 * x**3
    a = s0 * abs(v) / g
    return max(mpf(0), 1 - alpha * s0 * mpmath.sign(v) * z / g), -a, s0, cell["bristle_damping"], cell["viscous"]


def dense(A: Array, K: Array, D: Array, parts: list[Any], r: list[Any]) -> list[Any]:
    """x of (I - g T) x = r. Each of the parts has a row of the rate of its joint, and rates and a force by q, v, z."""
    n, g = len(A), exact(G)
    m = sum(len(part["Z"]) for part in parts)
    matrix = mpmath.eye(2 * n + m)
    right = mpmath.matrix([*r[:n], *(A @ np.array(r[n : 2 * n], dtype=object)), *r[2 * n :]])
    for i in range(n):
        matrix[i, n + i] = -g
        for j in range(n):
            matrix[n + i, j], matrix[n + i, n + j] = g * K[i][j], A[i][j] + g * D[i][j]
    first = 2 * n
    for part in parts:
        row, size = part["row"], len(part["Z"])
        for i in range(n):
            for j in range(n):
                matrix[n + i, j] -= g * row[i] * part["by_q"] * row[j]
                matrix[n + i, n + j] -= g * row[i] * part["by_v"] * row[j]
            for k in range(size):
                matrix[n + i, first + k] -= g * row[i] * part["by_z"][k]
                matrix[first + k, i] -= g * part["Q"][k] * row[i]
                matrix[first + k, n + i] -= g * part["V"][k] * row[i]
        for k in range(size):
            for other in range(size):
                matrix[first + k, first + other] -= g * part["Z"][k][other]
        first += size
    return list(mpmath.lu_solve(matrix, right))


def parts_of(described: DescribedMachine, rows: Any, at: dict[str, Any]) -> list[Any]:
    """Bristles by joint, then drives by motor, at the state and the set points of `at`."""
    found, z = [], [*at["z"]]
    for j in described.bristles:
        slope, a, s0, s1, s2 = bristle_slopes(described.joint(j).friction, at["speed"][j], z.pop(0))
        by_z, by_v = [-(s0 + s1 * a)], -(s2 + s1 * slope)
        found.append({"row": rows(j), "Z": [[a]], "Q": [0], "V": [slope], "by_q": 0, "by_v": by_v, "by_z": by_z})
    for k, j in enumerate(described.motors):
        drive = described.drives.by_motor.get(described.joint(j).name)
        if drive:
            law = DriveInTime(described.joint(j), drive)
            own, z = z[: at["sizes"][j]], z[at["sizes"][j] :]
            given = Given(*(at[key][k] for key in ("r", "rd", "rdd")), at["position"][j], at["speed"][j], at["tau"][k])
            found.append({"row": rows(j), **law.slopes(own, given)})
    return found


def solution(described: Machine, given: dict[str, Any], symbols: dict[str, Any]) -> list[Any]:
    factors, solve = (traced.program for traced in implicit_system(described, Motors.DRIVES))
    known = symbols | {
        s: exact(x) for i in factors.inputs for s, x in zip(i.symbols, given[i.name][: len(i.symbols)], strict=True)
    }
    handed = values_of(factors, known)["factors"]
    entries = given | {"factors": handed}
    sides = {i.name: i for i in solve.inputs}
    known = symbols | {s: exact(x) for i in sides.values() for s, x in zip(i.symbols, entries[i.name], strict=True)}
    found = values_of(solve, known)
    return [*found["z_q"], *found["z_v"], *found.get("z_z", [])]


def inertia(described: Machine, q: Any) -> Array:
    program = trace(described, "inertia_matrix").program
    (A,) = values_of(program, {s: exact(x) for i in program.inputs for s, x in zip(i.symbols, q, strict=True)}).values()
    return np.array(A, dtype=object).reshape(int(len(A) ** 0.5), -1)


def compare(described: DescribedMachine, at: dict[str, Any], K: Any, D: Any, A: Array, rows: Any, symbols: Any) -> None:
    """`at` has q and qd, and the positions of motors; states and set points are drawn."""
    rng = np.random.default_rng(5)
    sizes = {j: len(chain.names) for j, chain in chains_of(Bound(described)).items()}
    z = [mpf(x) for x in rng.normal(size=len(described.bristles)) * 8e-3]
    z += [mpf(x) for x in rng.normal(size=sum(sizes.values()))]
    qd = [exact(x) for x in at["qd"]]
    speed = {j: sum(np.array(rows(j)[-len(qd) :]) * np.array(qd)) for j in described.articulated}
    motors = len(described.motors)
    drawn = {name: [mpf(x) for x in rng.normal(size=motors)] for name in ("r", "rd", "rdd", "tau")}
    at = {**at, **drawn, "z": z, "sizes": sizes, "speed": speed}
    parts = parts_of(described, rows, at)
    n, m = len(A), sum(len(part["Z"]) for part in parts)
    sides = {name: rng.uniform(-1, 1, size).tolist() for name, size in (("r_q", n), ("r_v", n), ("r_z", m))}
    wanted = dense(A, K, D, parts, [exact(x) for side in sides.values() for x in side])
    found = solution(described, {**at, "g": [G], **sides}, symbols)
    assert len(found) == 2 * n + m
    for first, last in ((0, n), (n, 2 * n), (2 * n, 2 * n + m)):
        largest = max(map(abs, wanted[first:last]), default=1)
        assert all(abs(x - y) <= CLOSE * largest for x, y in zip(found[first:last], wanted[first:last], strict=True))


@pytest.mark.parametrize("seed", range(14))
def test_trees(seed: int) -> None:
    """On a fixed base, and on one that floats."""
    floating = seed >= 10
    made = random_machine(seed, joints=5, kinds=(Kind.MOTOR, Kind.ELASTIC, Kind.PASSIVE))
    described = with_states(without_dry_friction(on(made) if floating else made), seed)
    with mpmath.workdps(DIGITS):
        q, qd, _ = random_state(described, 2)
        n, base = len(described.independent), described.degrees_of_base
        own = [described.joint(j) for j in described.independent]
        elastic = [joint.kind is Kind.ELASTIC for joint in own]
        K = [mpf(joint.spring.stiffness.value()) * e for joint, e in zip(own, elastic, strict=True)]
        D = [mpf(joint.spring.damping.value()) * e for joint, e in zip(own, elastic, strict=True)]
        for k, j in enumerate(described.independent):
            D[k] += mpf(own[k].friction.viscous.value()) if j not in described.bristles else 0
        whole = [np.diag([mpf(0)] * base + x) for x in (K, D)]
        unit = np.eye(base + n, dtype=int)
        rows = lambda j: unit[base + described.independent.index(j)]  # noqa: E731
        position = dict(zip(described.independent, map(exact, q), strict=True))
        compare(described, {"q": q, "qd": qd, "position": position}, *whole, inertia(described, q), rows, {})


def without_dry_friction(described: Machine) -> Machine:
    return replace(
        described,
        joints=tuple(replace(one, friction=Friction(viscous=one.friction.viscous)) for one in described.joints),
    )


@pytest.mark.parametrize("name", COUPLED)
def test_couplings_and_loops(name: str) -> None:
    situation = situations(name)[0]
    described = with_states(without_dry_friction(machine(name)), len(name))
    with mpmath.workdps(DIGITS):
        at = Multipliers(described, situation.state)
        table = at.chain.numbers(at.at).joints
        owners = list(described.with_variable)
        K = np.diag([table[j - 1].stiffness if table[j - 1].kind is Kind.ELASTIC else mpf(0) for j in owners])
        D = np.diag([table[j - 1].damping for j in owners])

        def rows(j: int) -> Any:
            return at.S_x[owners.index(j)] if j in owners else at.S[list(described.articulated).index(j)]

        viscous = [j for j in described.articulated if j not in described.bristles]
        damped = sum((table[j - 1].viscous * np.outer(rows(j), rows(j)) for j in viscous), 0)
        given = {"q": situation.state.u, "qd": situation.state.ud}
        given["q_dep"] = [at.at[variable] for variable in at.chain.dependent]
        given["position"] = {j: at.at[str(described.joint(j).variable)] for j in described.motors}
        symbols = {p.name: p.value.evaluate({}, {}, exact) for p in described.parameters if p.value}
        matrices = (at.S_x.T @ K @ at.S_x, at.S_x.T @ D @ at.S_x + damped)
        compare(described, given, *matrices, at.inertia(), rows, symbols)
