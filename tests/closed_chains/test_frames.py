"""Frames of machines with couplings and loops: placements, velocities, accelerations and Jacobians by 4x4 matrices."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import Closing
from symoro_elastic.models.bound.model import Frame, Frames
from tests.closed_chains.machines import machine, situations
from tests.closed_chains.test_references import worst
from tests.closed_chains.traced import results
from tests.references.closed_chains import Array, in_many_digits
from tests.references.series import coefficient
from tests.references.virtual_work import VirtualWork

pytestmark = pytest.mark.sampled(6)

MACHINES = ("coupled_wrist", "five_bar", "gantry", "parallelogram_loop", "press", "screw", "spatial_four_bar", "sr400")
EXACT = 1e-45
POINT = tuple(Formula.parse(x) for x in (0.1, -0.2, 0.3))


def coefficients(frame: Array, order: int) -> Array:
    return np.array([[coefficient(x, order) for x in row] for row in frame], dtype=object)


def vector(hat: Array) -> Array:
    return np.array([hat[2, 1] - hat[1, 2], hat[0, 2] - hat[2, 0], hat[1, 0] - hat[0, 1]], dtype=object) / 2


@in_many_digits
def motion(at: VirtualWork, udd: Array, ud: Array | None = None) -> list[tuple[Array, Array, Array]]:
    """T, V and V' of each row in axes of frame 0, linear part first."""
    if ud is not None:
        at.ud = ud
    found = []
    for frame in at.chain.placements(at._motion(udd)):
        T, Td, Tdd = coefficients(frame, 0), coefficients(frame, 1), 2 * coefficients(frame, 2)
        R, Rd, Rdd = T[:3, :3], Td[:3, :3], Tdd[:3, :3]
        V = np.concatenate([Td[:3, 3], vector(Rd @ R.T)])
        found.append((T, V, np.concatenate([Tdd[:3, 3], vector(Rdd @ R.T + Rd @ Rd.T)])))
    return found


@in_many_digits
def in_axes(T: Array, V: Array) -> Array:
    return np.concatenate([T[:3, :3].T @ V[:3], T[:3, :3].T @ V[3:]])


@in_many_digits
def seen_from(T_k: Array, T: Array) -> Array:
    """kTj of 0Tk and 0Tj."""
    R, P = T_k[:3, :3].T, T_k[:3, 3]
    inverse = np.concatenate([np.concatenate([R, -(R @ P)[:, None]], axis=1), T_k[3:]], axis=0)
    placed: Array = inverse @ T
    return placed


def whole(name: str) -> Frames:
    return tuple(Frame(j) for j in range(1, len(machine(name).joints) + 1))


@pytest.mark.parametrize("name", MACHINES)
def test_placements_and_motions(name: str) -> None:
    """Frames of cut rows are those of the rows they meet."""
    described, situation = machine(name), situations(name)[0]
    at = VirtualWork(described, situation.state)
    udd = np.array([at.chain.arithmetic.number(x) for x in range(1, len(described.independent) + 1)], dtype=object)
    known = motion(at, udd)

    def ours(model: str, asked: Frames) -> Array:
        (found,) = results(described, model, situation.state, {"qdd": udd}, asked).values()
        return found

    assert worst(ours("geometric_model", whole(name)), [T for T, _, _ in known]) < EXACT
    assert worst(ours("velocities", whole(name)), [in_axes(T, V) for T, V, _ in known]) < EXACT
    assert worst(ours("accelerations", whole(name)), [in_axes(T, Vd) for T, _, Vd in known]) < EXACT
    last = len(described.joints)
    seen = tuple(Frame(j, last) for j in range(1, last + 1))
    T_last = known[-1][0]
    assert worst(ours("geometric_model", seen), [seen_from(T_last, T) for T, _, _ in known]) < EXACT
    assert worst(ours("velocities", seen), [in_axes(T_last, V) for _, V, _ in known]) < EXACT
    assert worst(ours("accelerations", seen), [in_axes(T_last, Vd) for _, _, Vd in known]) < EXACT


@pytest.mark.parametrize("name", MACHINES)
def test_jacobians(name: str) -> None:
    """J S is dV/dud, and what is left of V' without accelerations is its rate of change times ud."""
    described, situation = machine(name), situations(name)[0]
    at = VirtualWork(described, situation.state)
    n = len(described.independent)
    still = np.array([at.ud[0] * 0] * n, dtype=object)
    bias = [Vd for _, _, Vd in motion(at, still)]
    units = [motion(at, still, np.array([still[0] + (k == m) for m in range(n)])) for k in range(n)]
    columns: list[Any] = [np.array([unit[j][1] for unit in units]).T for j in range(len(described.joints))]
    (J,) = results(described, "jacobian", situation.state, asked=whole(name)).values()
    assert worst(J, columns) < EXACT
    (found,) = results(described, "jacobian_dot_qd", situation.state, asked=whole(name)).values()
    assert worst(found, bias) < EXACT


@pytest.mark.parametrize("name", ["five_bar", "press"])
def test_points_of_cut_rows_are_those_of_the_rows_they_meet(name: str) -> None:
    described, situation = machine(name), situations(name)[0]
    (loop,) = described.loops
    assert loop.closes is Closing.FRAME
    for model in ("geometric_model", "velocities", "accelerations", "jacobian", "jacobian_dot_qd"):
        asked = tuple(Frame(row, seen, POINT) for row in (loop.cut, loop.meets) for seen in (None, loop.cut))
        (found,) = results(described, model, situation.state, {"qdd": situation.state.u}, asked).values()
        of_cut, of_met = found[:2], found[2:]
        assert worst(of_cut[0], of_met[0]) < EXACT, model
        assert worst(of_cut[1], of_met[1]) < EXACT, model
