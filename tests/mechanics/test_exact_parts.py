"""Parts of equations in exact arithmetic: systems of loops, energies of unit parameters, axes that meet, motions."""

from __future__ import annotations

import random
from fractions import Fraction
from itertools import permutations
from math import prod

import pytest

from symoro_elastic.mechanics.base_parameters import carried_motions
from symoro_elastic.mechanics.inverse_geometry.equation_types import Functions, Pose
from symoro_elastic.mechanics.inverse_geometry.points import Mover, meeting
from symoro_elastic.mechanics.loops.closing import KEPT
from symoro_elastic.mechanics.loops.linear import BY_COFACTORS, determinant, solve
from symoro_elastic.mechanics.mechanism import Link, Mechanism
from symoro_elastic.mechanics.regressor import unit_energies
from symoro_elastic.mechanics.spatial import ZERO, Axis, Matrix, Transform, Twist, Vector, dot


def columns(n: int, count: int) -> list[list[Fraction]]:
    source = random.Random(n)
    return [[Fraction(source.randint(-9, 9)) for _ in range(n)] for _ in range(count)]


def by_permutations(matrix: list[list[Fraction]]) -> Fraction:
    """Leibniz' formula."""
    n = len(matrix)
    total = Fraction(0)
    for order in permutations(range(n)):
        inversions = sum(order[i] > order[j] for i in range(n) for j in range(i + 1, n))
        total += (-1) ** inversions * prod((matrix[k][order[k]] for k in range(n)), start=Fraction(1))
    return total


@pytest.mark.parametrize("n", range(BY_COFACTORS + 3))
def test_determinants_are_sums_over_permutations(n: int) -> None:
    assert determinant(columns(n, n)) == by_permutations(columns(n, n))


@pytest.mark.parametrize("n", range(1, BY_COFACTORS + 3))
def test_solutions_satisfy_the_system(n: int) -> None:
    *W, right = columns(n, n + 1)
    found, zero = solve(W, [right, [Fraction(0)] * n])
    assert [sum(W[k][row] * found[k] for k in range(n)) for row in range(n)] == right
    assert zero == [0] * n


def test_singular_systems_have_no_solution() -> None:
    for n in range(2, BY_COFACTORS + 3):
        with pytest.raises(ZeroDivisionError):
            solve([[Fraction(1)] * n] * n, [[Fraction(1)] * n])


def test_a_unit_mass_has_its_kinetic_energy_where_there_is_no_gravity() -> None:
    v, w = Vector(*map(Fraction, (1, 2, 3))), Vector(*map(Fraction, (4, 5, 6)))
    energies = unit_energies(Twist(v, w))
    assert energies["M"] == Fraction(1 + 4 + 9, 2)
    assert [energies[name] for name in ("XX", "XY", "XZ", "YY", "YZ", "ZZ")] == [8, 20, 24, Fraction(25, 2), 30, 18]
    assert [energies[name] for name in ("MX", "MY", "MZ")] == [2 * 6 - 3 * 5, 3 * 4 - 1 * 6, 1 * 5 - 2 * 4]
    raised = unit_energies(Twist(v, w), Vector(0, 0, Fraction(-10)), Fraction(-20))
    assert raised["M"] == energies["M"] + 20 and raised["MZ"] == energies["MZ"] + 10


@pytest.mark.parametrize("axis", [(0, 3, 4, 5), (3, 0, 4, 5), (2, 3, 6, 7), (0, 1, 0, 1), (1, 0, 0, 1)])
def test_axes_that_meet_do_so_at_one_point(axis: tuple[int, int, int, int]) -> None:
    *entries, length = axis
    a, here, there = Vector(*(Fraction(x, length) for x in entries)), Fraction(7, 3), Fraction(-5, 2)
    rotation = Matrix(*(Vector(0, 0, x) for x in a))  # its last column is all that counts
    exact = Functions(abs, lambda x, y, z: (x, y, z), lambda x: x, lambda x: x == 0, lambda x: False)
    pair = (Mover(1, Axis.REVOLUTE), Mover(2, Axis.REVOLUTE))
    assert meeting(exact, pair, Pose(rotation, Vector(0, 0, here) - there * a)) == (here, there)


def test_motions_that_are_drawn_are_turns_and_shifts() -> None:
    """A turn keeps the length of gravity, its part along the axis, and the angular velocity along it."""
    source = random.Random(3)
    links = tuple(Link(k, axis, Transform(())) for k, axis in enumerate((Axis.REVOLUTE, Axis.REVOLUTE, Axis.PRISMATIC)))
    gravity = Vector(Fraction(1), Fraction(2), Fraction(-3))
    mechanism = Mechanism((*links, Link(3, Axis.NONE, Transform(()))), acceleration=Twist(-gravity, ZERO))
    found = carried_motions(mechanism, lambda: Fraction(source.randint(1, 99), source.randint(1, 99)), free_base=False)
    fields = [found[j].gravity for j in range(1, 5)]
    assert fields[0] == gravity != fields[1] != fields[2] == fields[3]
    assert {(dot(g, g), g.z) for g in fields} == {(14, -3)}
    assert not found[1].turning and found[2].turning and found[3].parallel and not found[3].shifting
    assert found[4].shifting and not found[4].level


def test_a_cut_joint_keeps_all_from_moving_but_its_own_motion() -> None:
    own = {Axis.REVOLUTE: {5}, Axis.PRISMATIC: {2}, Axis.NONE: set()}
    assert {axis: list(rows) for axis, rows in KEPT.items()} == {a: sorted({*range(6)} - x) for a, x in own.items()}
