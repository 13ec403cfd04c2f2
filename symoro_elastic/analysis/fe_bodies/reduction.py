"""Reduction of a finite-element model of a solid to a body by modes, after Craig and Bampton.

Nodes that the joint holds are fixed. Deflections under unit forces and moments on each interface (six each, so that its
compliance is exact) and the lowest modes with free interfaces are the basis V; in

    (V^T K V) c = w^2 (V^T M V) c

modes are orthogonal in mass and stiffness. A unit of a mode is its largest displacement, 1 m. Interfaces are averaged:
loads act on all their nodes alike, and their displacement and turn are the means of least squares (RBE3).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from symoro_elastic.analysis.fe_bodies.rails import FITTED, loads_along, rail_of
from symoro_elastic.formats.modes_file import Interface, ModalBody
from symoro_elastic.foundation.array_types import AnyArray, Array
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.packages import for_vibrations

LOOSE = 1e-6
"""Force by a motion of the whole body, of the largest stiffness: a free model has rounding only."""
ROUGH = "polynomials of degree 8 are {:.1%} off at its nodes: split it, or leave out local modes by keep"
NO_NODES: Mapping[str, AnyArray] = {}
SAME = 1e-9
"""Of the largest entry: how far a matrix may be from symmetric, and a mass from one that acts alike in x, y, z."""
DEPENDENT = 1e-10
"""Least squared norm of a shape's part that is orthogonal to the shapes before it, by its own norm."""


@dataclass(frozen=True, eq=False)
class FiniteElements:
    """A free solid: nodes x (n, 3), m; stiffness (3 n, 3 n), N/m, and scalar mass (n, n), kg, sparse matrices.

    Rows 3 k, 3 k + 1, 3 k + 2 belong to node k. `numbers` (n,) are those of the file, `groups` sets of nodes (indices)
    by name. `source` names the file in messages, `about` says where the model comes from.
    """

    x: Array
    K: Any
    m: Any
    numbers: AnyArray
    source: str
    about: str
    groups: Mapping[str, AnyArray] = field(default_factory=dict)


def modal_body(
    model: FiniteElements,
    fixed: AnyArray,
    interfaces: Mapping[str, AnyArray],
    count: int,
    rails: Mapping[str, AnyArray] = NO_NODES,
) -> ModalBody:
    """Return the body whose nodes `fixed` (indices) the joint fixes, with six modes an interface and `count` more.

    A rail has the modes under loads that are distributed along it.

    Raises `InputError` for a model that is fixed already, or that moves without deflection where it is fixed.
    """
    refuse_wrong(model, fixed, interfaces)
    linalg, sparse = for_vibrations("scipy.sparse.linalg"), for_vibrations("scipy.sparse")
    n = len(model.x)
    free = np.setdiff1d(np.arange(n), fixed)
    rows = (3 * free[:, None] + np.arange(3)).ravel()
    K = sparse.csc_matrix(model.K)[rows][:, rows]
    M = sparse.kron(sparse.csc_matrix(model.m)[free][:, free], np.eye(3)).tocsc()
    try:
        solve = linalg.splu(K).solve
    except RuntimeError:
        raise InputError(model.source, "--fixed", "the body moves without deflection: hold more of its nodes") from None
    loads = [_loads(model.x, nodes) for nodes in interfaces.values()]
    loads += [loads_along(model.x, nodes, name, model.source) for name, nodes in rails.items()]
    shapes = solve(np.hstack([*loads, np.zeros((3 * n, 0))])[rows])
    if count:
        inverse = linalg.LinearOperator(K.shape, matvec=solve)
        start = np.random.default_rng(0).normal(size=len(rows))
        _, modes = linalg.eigsh(K, min(count, len(rows) - 1), M, sigma=0.0, OPinv=inverse, v0=start)
        shapes = np.hstack([shapes, modes])
    phi, stiffness = _modes(shapes, K, M)
    full = np.zeros((3 * n, phi.shape[1]))
    full[rows] = phi
    moved = full.T.reshape(-1, n, 3)
    body = _body(model, moved, stiffness, interfaces)
    fits = {name: rail_of(model.x, nodes, moved, stiffness, name, model.source) for name, nodes in rails.items()}
    doubts = tuple(f"rail {name}: {ROUGH.format(error)}" for name, (_, error) in fits.items() if error > FITTED)
    return replace(body, rails={name: rail for name, (rail, _) in fits.items()}, doubts=doubts)


def refuse_wrong(model: FiniteElements, fixed: AnyArray, interfaces: Mapping[str, AnyArray]) -> None:
    """Raise `InputError` for matrices that are not those of a free solid, and nodes that determine no position."""
    for name, matrix in (("K", model.K), ("M", model.m)):
        if abs(matrix - matrix.T).max() > SAME * abs(matrix).max():
            raise InputError(model.source, name, "is not symmetric")
    center = model.x - model.x.mean(axis=0)
    size = np.abs(center).max()
    motions = np.vstack([np.tile(np.eye(3), len(center)), _rotations(center / size)])
    if np.abs(model.K @ motions.T).max() > LOOSE * abs(model.K).max():
        what = "a motion of the whole body meets forces: export the free model, --fixed holds it"
        raise InputError(model.source, "K", what)
    for name, nodes in {"--fixed": fixed, **{f"--interface {key}": x for key, x in interfaces.items()}}.items():
        if np.linalg.matrix_rank(model.x[nodes] - model.x[nodes].mean(axis=0), tol=SAME * size) < 2:
            raise InputError(model.source, name, f"{len(nodes)} nodes on a line or point: add nodes off that line")


def _rotations(x: Array) -> Array:
    """Displacements (3, 3 n) by small rotations about x, y, z."""
    return np.array([np.cross(axis, x).ravel() for axis in np.eye(3)])


def _loads(x: Array, nodes: AnyArray) -> Array:
    """Forces (3 n, 6) on nodes that sum up to unit forces and moments about their centre, linear in the place."""
    center = x[nodes].mean(axis=0)
    arms = x[nodes] - center
    loads = np.zeros((len(x), 3, 6))
    loads[nodes, :, :3] = np.eye(3) / len(nodes)
    inverse = np.linalg.inv(_spread(arms))
    for k in range(3):
        loads[nodes, :, 3 + k] = np.cross(inverse[:, k], arms)
    return loads.reshape(3 * len(x), 6)


def _spread(arms: Array) -> Array:
    """Sum of r.r 1 - r r^T (3, 3)."""
    return np.asarray(np.sum(arms * arms) * np.eye(3) - arms.T @ arms)


def _modes(shapes: Array, K: Any, M: Any) -> tuple[Array, Array]:
    """Modes (rows, m) in the span of shapes, and squares of w times their modal mass."""
    basis = np.zeros((len(shapes), 0))
    for column in shapes.T:
        outside = column
        for _ in range(2):
            outside = outside - basis @ (basis.T @ (M @ outside))
        square = outside @ (M @ outside)
        if square > DEPENDENT * (column @ (M @ column)):
            basis = np.hstack([basis, (outside / np.sqrt(square))[:, None]])
    squares, vectors = np.linalg.eigh(basis.T @ (K @ basis))
    modes = basis @ vectors
    largest = np.linalg.norm(modes.reshape(-1, 3, modes.shape[1]), axis=1)
    at = largest.argmax(axis=0)
    signs = np.sign(modes.reshape(-1, 3, modes.shape[1])[at, :, range(len(at))].sum(axis=1))
    scale = np.where(signs == 0, 1.0, signs) / largest.max(axis=0)
    return modes * scale, squares * scale**2


def _body(model: FiniteElements, phi: Array, stiffness: Array, interfaces: Mapping[str, AnyArray]) -> ModalBody:
    """The body of modes phi (m, n, 3)."""
    psi = np.hstack([np.ones((len(model.x), 1)), model.x, phi.transpose(1, 0, 2).reshape(len(model.x), -1)])
    G = psi.T @ (model.m @ psi)
    followers = {}
    for name, nodes in interfaces.items():
        center = model.x[nodes].mean(axis=0)
        arms = model.x[nodes] - center
        turns = np.cross(arms, phi[:, nodes]).sum(axis=1) @ np.linalg.inv(_spread(arms)).T
        followers[name] = Interface(center, phi[:, nodes].mean(axis=1), turns)
    return ModalBody((G + G.T) / 2, stiffness, np.zeros(len(stiffness)), followers, about=model.about)
