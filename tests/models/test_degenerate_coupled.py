"""Motions of machines with couplings and loops that meet no inertia: all of them are found and no others."""

from __future__ import annotations

import random
from dataclasses import replace
from typing import Any

import mpmath
import pytest

from symoro_elastic.foundation.errors import InputError
from symoro_elastic.generation.pipeline import refuse_degenerate
from symoro_elastic.machine.formula import ZERO
from symoro_elastic.machine.machine import Body, Machine
from symoro_elastic.machine.scene import Scene
from symoro_elastic.models.checks.degenerate import degeneracies
from tests.closed_chains.machines import FILES, machine, situations
from tests.references.closed_chains import State
from tests.references.constraint_multipliers import Multipliers
from tests.references.stored import stored

pytestmark = pytest.mark.sampled(5)


def without_inertia(whole: Machine, joints: set[int]) -> Machine:
    """The machine without bodies and rotor inertias of some joints, by number."""
    rows = enumerate(whole.joints, start=1)
    bare = tuple(replace(row, body=Body(), rotor_inertia=ZERO, ratio=ZERO) if j in joints else row for j, row in rows)
    return replace(whole, joints=bare)


def directions(whole: Machine, name: str) -> int:
    """Dimension of the null space of the inertia matrix of the reference, at the state where it is smallest."""
    states = [situation.state for situation in situations(name)[:2]]
    given = [(s.u, s.ud, [list(pair) for pair in sorted(s.guess.items())]) for s in states]
    return min(stored(null_space, whole, *state, digits=70) for state in given)


def null_space(whole: Machine, u: list[float], ud: list[float], guess: list[list[Any]]) -> int:
    """Dimension of the null space of the inertia matrix of the reference at a state."""
    with mpmath.workdps(70):
        A = mpmath.matrix(Multipliers(whole, State(u, ud, dict(guess))).inertia().tolist())
        scale = [mpmath.sqrt(abs(A[k, k])) or mpmath.mpf(1) for k in range(A.rows)]
        scaled = mpmath.matrix(A.rows, A.cols)
        for m in range(A.rows):
            for n in range(A.cols):
                scaled[m, n] = A[m, n] / (scale[m] * scale[n])
        return sum(abs(x) < mpmath.mpf(10) ** -40 for x in mpmath.eigsy(scaled, eigvals_only=True))


@pytest.mark.sampled(16)
@pytest.mark.parametrize("name", FILES)
def test_directions_are_those_of_the_inertia_matrix(name: str) -> None:
    whole, source = machine(name), random.Random(name)
    assert degeneracies(whole, False) == []
    for share in (0.4, 1.0):
        bare = without_inertia(whole, {j for j in whole.articulated if source.random() < share})
        assert len(degeneracies(bare, False)) == directions(bare, name)


def test_a_loop_without_bodies_is_named() -> None:
    four_bar = machine("four_bar")
    bare = without_inertia(four_bar, {1, 2, 3, 6})
    assert [one.moving_together for one in degeneracies(bare, False)] == [(1, 2, 3), (6,)]
    with pytest.raises(InputError, match="no body has mass or inertia"):
        refuse_degenerate(bare, Scene())
    first, _ = degeneracies(bare, False)
    assert "joint 1 (crank), joint 2 (coupler) and joint 3 (rocker) move together" in first.message(bare)


def test_known_motors_need_no_inertia() -> None:
    four_bar = machine("four_bar")
    bare = without_inertia(four_bar, {1, 2, 3})
    carried = degeneracies(bare, False), degeneracies(bare, True)
    assert carried == ([], [])
    empty = without_inertia(four_bar, {1, 2, 3, 6})
    assert [found.moving_together for found in degeneracies(empty, True)] == [(6,)]
