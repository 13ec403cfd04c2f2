"""Motions of machines with couplings or loops that meet no inertia: null directions of the inertia matrix.

Closed forms and assembled positions are no rational numbers, so this is decided in double precision, at several
assembled positions and with random values for the parameters that no position depends on.
"""

from __future__ import annotations

import random
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress

import numpy as np

from symoro_elastic.array_types import Array
from symoro_elastic.machine.columns import cells
from symoro_elastic.machine.domain import Domain
from symoro_elastic.machine.machine import Machine
from symoro_elastic.models.bind import Bound
from symoro_elastic.models.coordinate_inertia import coordinate_inertia
from symoro_elastic.models.floating_base import inertia
from symoro_elastic.models.loops.plan import Plan, plan_of
from symoro_elastic.scalar import Scalar
from symoro_elastic.symbolic.arithmetic import FLOATS, evaluate

SEED = 20261
VANISHING = 1e-9
"""An eigenvalue of the inertia matrix with ones on its diagonal, or an entry of a direction, that counts as zero."""
PLACING = "joints"
"""The section of a machine's file with the cells that place its frames."""


def motions_without_inertia(machine: Machine, known_motors: bool, folded: Sequence[str]) -> Iterator[tuple[int, ...]]:
    """Joints that move in each of these motions, 0 for a floating base; with `known_motors` no motor moves.

    Positions at which loops are singular tell nothing; raises `InputError` where all of them are, and for a cell that
    has a value at none.
    """
    bound, plan = Bound(machine, folded), plan_of(machine, Bound)
    found = []
    for symbols in _symbols(machine, plan):
        with suppress(ZeroDivisionError):
            found.append(_directions(bound, symbols, known_motors))
    if not found and not machine.loops:
        raise machine.error("joints", "no position was found at which all their formulas have a value")
    if not found:
        loops = ", ".join(loop.name for loop in machine.loops)
        what = "start is a singular position, as where two links are stretched: write one beside it"
        raise machine.error(f"loop {loops}", what)
    directions, S = min(found, key=lambda one: one[0].shape[1])
    of_base = len(directions) - S.shape[1]
    for direction in _apart(directions):
        rates = S @ direction[of_base:]
        base = (0,) if np.any(np.abs(direction[:of_base]) > VANISHING) else ()
        yield (*base, *(j for j, x in zip(machine.articulated, rates, strict=True) if abs(x) > VANISHING))


def _symbols(machine: Machine, plan: Plan) -> Iterator[dict[str, float]]:
    """Values of all parameters and variables at assembled positions."""
    source = random.Random(SEED)
    placing = {
        name
        for joint in machine.joints
        for cell, formula in cells(joint)
        if cell.column.section == PLACING
        for name in formula.names
    }
    values = {p.name: source.uniform(0.5, 1.5) for p in machine.parameters if p.name not in placing}
    domain = Domain(machine)
    for position in plan.positions:
        symbols = plan.assembly.symbols(position) | values
        defined = domain.defined(symbols, source)
        if defined is not None:
            yield defined
        elif refusal := domain.refusal(symbols):
            raise refusal


def _directions(bound: Bound, symbols: Mapping[str, float], known_motors: bool) -> tuple[Array, Array]:
    """Columns that span the velocities of base and coordinates which meet no inertia, and S, at one position."""
    machine, coordinates = bound.machine, bound.coordinates
    moving = machine.moving
    held = [coordinates.S_x[j].get(k, 0) for j in (bound.motors if known_motors else ()) for k in moving]
    S = [coordinates.S[j].get(k, 0) for j in machine.articulated for k in moving]
    A = inertia(bound, coordinate_inertia(bound), moving).entries
    size = len(moving) + (6 if machine.floating else 0)
    rows = [_numbers(entries, symbols) for entries in (A, held, S)]
    A_here, held_here, S_here = (x.reshape(-1, n) for x, n in zip(rows, (size, len(moving), len(moving)), strict=True))
    of_base = size - len(moving)
    still = np.pad(held_here, ((0, 0), (of_base, 0)))
    if machine.floating and bound.base_rule is None:
        still = np.vstack([still, np.eye(6, size)])
    return _null(A_here, _kernel(still)), S_here


def _numbers(entries: Sequence[Scalar], symbols: Mapping[str, float]) -> Array:
    value = evaluate(entries, symbols, FLOATS)
    return np.array([float(value(x)) for x in entries])


def _kernel(rows: Array) -> Array:
    """Columns that span the directions in which all rows are zero."""
    if not len(rows):
        return np.eye(rows.shape[1])
    _, sizes, V = np.linalg.svd(rows)
    return V[int(np.sum(sizes > VANISHING * max(1.0, sizes.max(initial=0)))) :].T


def _null(A: Array, free: Array) -> Array:
    """Columns among those that span `free` that a positive semidefinite A takes to zero."""
    inner = free.T @ A @ free
    lengths = np.sqrt(np.abs(np.diag(inner)))
    scale = np.where(lengths > VANISHING * max(1e-300, lengths.max(initial=0)), lengths, 1.0)
    sizes, V = np.linalg.eigh(inner / np.outer(scale, scale))
    found: Array = free @ (V[:, np.abs(sizes) < VANISHING] / scale[:, None])
    return found


def _apart(directions: Array) -> Iterator[Array]:
    """Directions that span the same, with as few entries in common as elimination gives, the largest entry one."""
    left = directions.copy()
    for column in range(left.shape[1]):
        row = int(np.argmax(np.abs(left[:, column:]).max(axis=1, initial=0)))
        pivot = column + int(np.argmax(np.abs(left[row, column:])))
        left[:, [column, pivot]] = left[:, [pivot, column]]
        left[:, column] /= left[row, column]
        others = np.arange(left.shape[1]) != column
        left[:, others] -= np.outer(left[:, column], left[row, others])
    yield from (x / np.abs(x).max() for x in left.T)
