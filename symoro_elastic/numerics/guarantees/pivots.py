"""Lemmas 5 and 6: bounds of the pivots of a model that narrow its intervals, by node.

The recursion solves for one coordinate after another: a pivot H_j is the Schur complement of
entry j of the inertia matrix over the coordinates that it has solved for. On a tree these are the joints beyond j.

**Where joints are coupled or closed in loops**, they are solved for cluster by cluster. With the acceleration energy
G = (qdd' A qdd)/2 + ..., in which dependent accelerations are linear in the independent ones, each step takes the least
value of G over one coordinate, and H_j is the second derivative of the reduced G by coordinate j. So it is a Schur
complement here, too, over the coordinates solved for; the more, the smaller. Hence

    complement over all coordinates <= H_j <= A_jj

**Lemma 6**, pivots from bounds of the inertia matrix. Over a sub-box each entry of the inertia matrix A is in an
interval of the middle M and the radius R. With s_i > 0 and D = diag(sum_k R_ik s_k / s_i),

    M - D <= A <= M + D

in the sense of Loewner, for x'(A - M)x <= sum R_ik |x_i||x_k| <= sum D_ii x_i^2 by the inequality of means,
|x_i||x_k| <= (x_i^2 s_k/s_i + x_k^2 s_i/s_k)/2. Schur complements are monotone in this sense, so H_j is between those
of M - D and of M + D where M - D is positive definite. The scales s_i = M_ii^(-1/2) make D small.

The lower bound h is proven: M - D - h e_j e_j' is positive definite, as its Cholesky decomposition shows with a margin
for rounding (S. Rump, Verification of positive definiteness, BIT 46, 2006). The upper one is x'(M + D)x of some x with
x_j = 1, of which the Schur complement is the least.

**Lemma 5**, pivots are at least the inertia that a joint moves by itself. With the inertia J_j of body j about the
origin of its frame, e_j the axis of the joint, Ia_j its rotor:

    H_j >= Ia_j + e_j' J_j e_j

Proof: K_c - K_c e e' K_c / H_c, which joint c passes on, is positive semidefinite where K_c is, for H_c >= e' K_c e; so
K_j >= J_j by induction from the tips. It needs bodies that can exist, where there are rotors, too: no mass and no
central inertia below zero. Where joints are coupled, H_j >= Ia_j is left: the rotors of independent joints add a
diagonal matrix to one that is positive semidefinite. The whole bound holds where all joints from the base to j are
independent and solved for after j: H_j is the least energy 2 G with qdd_j = 1 and coordinates still to be solved for at
rest, so the antecedent of body j is at rest, and body j alone has e_j' J_j e_j.

It is valid at every position, at no cost. Base inertial parameters are not those of bodies: grouping does not change
H_j, so the lemma is applied to the machine before grouping.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import partial
from itertools import combinations
from typing import Any

import numpy as np

from symoro_elastic.codegen.package import Function
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.scalar import Scalar
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.restrict import restrict
from symoro_elastic.mechanics.spatial import Axis, RigidInertia
from symoro_elastic.models.bound.model import Pivots
from symoro_elastic.models.packaging import Traced, trace_models
from symoro_elastic.models.programs.catalogue import MODELS
from symoro_elastic.models.tree.tree import Tree
from symoro_elastic.numerics.guarantees.box import Box
from symoro_elastic.numerics.guarantees.intervals import INTERVALS, Interval, interval
from symoro_elastic.numerics.guarantees.running_error import ROUNDINGS, Known, running_errors
from symoro_elastic.symbolic.arithmetic import RATIONAL, Arithmetic, evaluate
from symoro_elastic.symbolic.expression import Expression, reachable
from symoro_elastic.symbolic.operations import DIVIDE, NEGATE
from symoro_elastic.symbolic.program import Program

SHRUNK = 1 - 2.0**-30
"""Factor that reduces a computed Schur complement to a proven lower bound."""
U = 2.0**-53
RATIONALS: Arithmetic[Fraction] = Arithmetic(Fraction, RATIONAL)


class PivotKnowledge:
    """Bounds of the pivots H_j in the program of a model, over any sub-boxes.

    Lemma 5 costs nothing; lemma 6 requires the inertia matrix. For coupled machines lemma 6 is used where models solve
    for all coordinates.
    """

    def __init__(self, traced: Traced, physical: Machine, parameters: Box, function: Function) -> None:
        """`physical` is the machine with parameters of bodies, `parameters` the box of their values."""
        machine = traced.machine
        pivots = MODELS[function.name].pivots if function.name in MODELS else None
        solved = [j for j in machine.independent if pivots is Pivots.ALL or j not in machine.motors]
        nodes = {j: function.program.quantities.get(f"H{j}") for j in (solved if pivots else ())}
        self._nodes = {j: x for j, x in nodes.items() if isinstance(x, Expression)}
        self._coupled = machine.is_coupled
        from_rest = _from_rest(machine, self._nodes) if self._coupled else {*self._nodes}
        self._own = own_inertias(restrict(physical, traced.scene), parameters.whole, from_rest) if self._nodes else {}
        over = {j: solved if self._coupled else [k for k in solved if _carries(machine, j, k)] for j in self._nodes}
        self._beyond = {j: [machine.independent.index(j) for j in joints] for j, joints in over.items()}
        self._entry = {j: machine.independent.index(j) for j in self._nodes}
        self._size = len(machine.independent)
        needs_inertia = self._nodes and (pivots is Pivots.ALL or not self._coupled)
        self._inertia = _inertia_matrix(traced) if needs_inertia else None

    def __call__(self, parts: Mapping[str, Interval]) -> Known:
        """Functions that narrow the intervals of pivots in sub-boxes, by number of the node."""
        matrix = self._matrix(parts)
        narrowings = {}
        for j, x in self._nodes.items():
            bounds = Interval(self._own.get(j, np.array(0.0)), np.array(np.inf))
            if matrix is not None:
                bounds = bounds.meeting(self._complement(matrix, j))
            narrowings[x.positive.id] = partial(Interval.meeting, -bounds if x.operation == NEGATE else bounds)
        return narrowings

    def _complement(self, matrix: Interval, j: int) -> Interval:
        """The interval of pivot j as a Schur complement."""
        k = self._entry[j]
        complement = schur_complements(matrix, self._beyond[j], k)
        return Interval(complement.low, matrix.high[k, k]) if self._coupled else complement

    def _matrix(self, parts: Mapping[str, Interval]) -> Interval | None:
        """The intervals of the inertia matrix, (n, n, sub-boxes)."""
        if self._inertia is None:
            return None
        program = self._inertia
        count = max((len(np.atleast_1d(x.low)) for x in parts.values()), default=1)
        bounds = running_errors(program.nodes, parts, ROUNDINGS["double"])
        entries = [bounds.range_of(x) for x in program.outputs[0].entries]
        low, high = ([np.broadcast_to(end, count) for end in ends] for ends in zip(*entries, strict=True))
        shape = (self._size, self._size, count)
        return Interval(np.array(low).reshape(shape), np.array(high).reshape(shape))


def _inertia_matrix(traced: Traced) -> Program:
    """The program of the inertia matrix, with parameters folded as in the models of the scene."""
    scene = replace(traced.scene, models=("inertia_matrix",), outputs={}, steps=())
    return trace_models(traced.whole, scene).models[0].program


def _from_rest(machine: Machine, pivots: Mapping[int, Expression]) -> set[int]:
    """Return the joints whose antecedents are all independent and solved for later, dividing by the joint's pivot."""
    joints, needs = set(), dict[int, set[int]]()
    for j, pivot in pivots.items():
        divisors = (node.operands[1] for node in reachable([pivot]) if node.operation == DIVIDE)
        needs[j] = {x.positive.id for x in divisors if isinstance(x, Expression)}
    for j, x in pivots.items():
        before = machine.joint(j).antecedent
        while before and x.positive.id in needs.get(before, ()):
            before = machine.joint(before).antecedent
        if not before:
            joints.add(j)
    return joints


def _carries(machine: Machine, j: int, k: int) -> bool:
    """Whether joint k is joint j or is carried by it."""
    while k and k != j:
        k = machine.joint(k).antecedent
    return k == j


def schur_complements(A: Interval, joints: Sequence[int], entry: int) -> Interval:
    """The interval of the Schur complement of an `entry` over all `joints`, by sub-box.

    `A` (n, n, sub-boxes) holds the inertia matrix, `joints` are indices into it, `entry` among them. The lower end is
    0 where nothing is proven, the upper one infinite.
    """
    rows = np.ix_(joints, joints)
    low, high = (np.moveaxis(end[rows], -1, 0) for end in (A.low, A.high))
    k = list(joints).index(entry)
    with np.errstate(all="ignore"):
        middle = low / 2 + high / 2
        radius = np.maximum(high - middle, middle - low) * (1 + 4 * U)
        scale = 1 / np.sqrt(np.diagonal(middle, axis1=1, axis2=2))
        spread = np.einsum("bik,bk->bi", radius, scale) / scale * (1 + 8 * len(joints) * U)
        ends = [_bounds(middle[b], spread[b], scale[b], k) for b in range(len(middle))]
    return Interval(np.array([least for least, _ in ends]), np.array([most for _, most in ends]))


def _bounds(middle: Array, spread: Array, scale: Array, k: int) -> tuple[float, float]:
    """Lower and upper bound of the Schur complement in a sub-box."""
    if not (np.isfinite(middle).all() and np.isfinite(spread).all() and np.isfinite(scale).all()):
        return 0.0, np.inf
    return _least(middle - np.diag(spread), scale, k), _most(middle + np.diag(spread), k)


def _least(matrix: Array, scale: Array, k: int) -> float:
    """A proven lower bound of the Schur complement of a matrix; 0 for one that is not positive definite."""
    try:
        bound = SHRUNK / float(np.linalg.inv(matrix)[k, k])
    except np.linalg.LinAlgError:
        return 0.0
    if not bound > 0:
        return 0.0
    reduced = matrix.copy()
    reduced[k, k] -= bound
    return bound if _is_positive_definite(reduced, scale) else 0.0


def _is_positive_definite(matrix: Array, scale: Array) -> bool:
    """Whether a symmetric matrix with rounding errors in its entries is proven positive definite."""
    size = len(matrix)
    powers = np.exp2(np.round(np.log2(scale)))  # exact scaling
    scaled = matrix * powers[:, None] * powers
    margin = 64 * size**2 * U * max(1.0, float(np.abs(np.diagonal(scaled)).max()))
    try:
        np.linalg.cholesky(scaled - margin * np.eye(size))
    except np.linalg.LinAlgError:
        return False
    return True


def _most(matrix: Array, k: int) -> float:
    """Upper bound x' B x of the Schur complement, for an x with x_k = 1 that is nearly optimal."""
    try:
        x = np.linalg.inv(matrix)[:, k]
    except np.linalg.LinAlgError:
        return float(matrix[k, k]) * (1 + 4 * U)
    x = x / x[k]
    x[k] = 1.0
    terms = matrix * x[:, None] * x
    return float(terms.sum() + 4 * len(matrix) ** 2 * U * np.abs(terms).sum())


def own_inertias(machine: Machine, box: Mapping[str, Interval], from_rest: Collection[int]) -> dict[int, Array]:
    """Positive lower bounds of H_j by joint, from rotor and body inertia; empty for flexible or impossible bodies.

    `machine` has the inertial parameters of bodies; `box` has its parameters; `from_rest` are the joints whose body has
    an antecedent at rest where the joint is solved for.
    """
    mechanism = Tree(machine).mechanism
    links = {j: mechanism.link(j) for j in machine.independent}
    least_inertias: dict[int, Array] = {}
    bodies = [link.body for link in mechanism.links] + ([mechanism.body] if mechanism.body else [])
    if machine.flexible or not all(_is_possible(body, box) for body in bodies):
        return least_inertias
    for j, link in links.items():
        least = _low(link.rotor_inertia, box)
        if j in from_rest:
            least = least + _low(link.body.inertia[5] if link.axis is Axis.REVOLUTE else link.body.mass, box)
        if np.all(least > 0):
            least_inertias[j] = np.nextafter(least, -np.inf)
    return least_inertias


def _low(x: Scalar, box: Mapping[str, Interval]) -> Array:
    """The least value of an expression of parameters, not below zero."""
    with np.errstate(all="ignore"):
        value = evaluate([x], box, INTERVALS)(x) if isinstance(x, Expression) else interval(_exact(x))
    return np.maximum(np.where(np.isfinite(value.low), value.low, 0.0), 0.0)


def _exact(x: Scalar) -> Any:
    return x if isinstance(x, int | Fraction) else Fraction(x)  # type: ignore[arg-type]


def _is_possible(body: RigidInertia, box: Mapping[str, Interval]) -> bool:
    """Whether m >= 0, and the central tensor has no negative principal minor; by intervals where they have ranges."""
    entries = (body.mass, *body.moments, *body.inertia)
    exact = {name: Fraction(float(x.low.flat[0])) for name, x in box.items() if np.all(x.low == x.high)}
    try:
        value: Callable[[Scalar], Any] = evaluate(entries, exact, RATIONALS)
        mass, mx, my, mz, xx, xy, xz, yy, yz, zz = map(value, entries)
    except KeyError:
        value = evaluate(entries, box, INTERVALS)
        mass, mx, my, mz, xx, xy, xz, yy, yz, zz = (interval(value(x)) for x in entries)
    if isinstance(mass, Fraction | int) and mass <= 0:
        return mass == 0 and not (mx or my or mz) and _is_semidefinite(((xx, xy, xz), (xy, yy, yz), (xz, yz, zz)))
    if not _least_end(mass) > 0:
        return False
    x, y, z = mx / mass, my / mass, mz / mass
    central = (
        (xx - my * y - mz * z, xy + mx * y, xz + mx * z),
        (xy + mx * y, yy - mx * x - mz * z, yz + my * z),
        (xz + mx * z, yz + my * z, zz - mx * x - my * y),
    )
    return _is_semidefinite(central)


def _least_end(x: Any) -> Any:
    return np.min(x.low) if isinstance(x, Interval) else x


def _is_semidefinite(matrix: tuple[tuple[Any, ...], ...]) -> bool:
    """Whether all principal minors of a symmetric matrix are zero or positive."""
    sizes = range(1, len(matrix) + 1)
    index_sets = (rows for size in sizes for rows in combinations(range(len(matrix)), size))
    return all(_least_end(_determinant([[matrix[i][k] for k in rows] for i in rows])) >= 0 for rows in index_sets)


def _determinant(matrix: list[list[Any]]) -> Any:
    if len(matrix) == 1:
        return matrix[0][0]
    first, *below = matrix
    minors = ([row[:k] + row[k + 1 :] for row in below] for k in range(len(first)))
    signed = ((-1) ** k * x for k, x in enumerate(first))
    return sum((x * _determinant(minor) for x, minor in zip(signed, minors, strict=True)), Fraction(0))
