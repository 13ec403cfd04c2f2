"""Reduction of a finite-element model of a solid to a body by modes, after Craig and Bampton.

Nodes that the joint holds are fixed. Deflections under unit forces and moments on each interface (six each, so that its
compliance is exact) and the lowest modes with free interfaces are the basis V; in

    (V^T K V) c = w^2 (V^T M V) c

modes are orthogonal in mass and stiffness. A unit of a mode is its largest displacement, 1 m. Interfaces are averaged:
loads act on all their nodes alike, and their displacement and turn are the means of least squares (RBE3); nodes of a
rigid one move as one body (RBE2).

Stresses s under inertial forces, of accelerations of the joint's frame that are constant or linear in the place, and
under unit forces on the interfaces have the geometric stiffness

    Kg_kl = int s_ab phi_k,a . phi_l,b,

which enters as foreshortening: Ct1_kl and T1s_kl of accelerations, -Kg_kl of a force, the displacement along it.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from symoro_elastic.analysis.flexible.rails import FITTED, loads_along, rail_of
from symoro_elastic.formats.modes_file import Interface, ModalBody, save
from symoro_elastic.foundation.array_types import AnyArray, Array
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.output_files import permission
from symoro_elastic.foundation.packages import for_vibrations
from symoro_elastic.foundation.results import Result
from symoro_elastic.machine.flexible import Surface

LOOSE = 1e-6
"""Force by a motion of the whole body, of the largest stiffness: a free model has rounding only."""
ROUGH = "polynomials of degree 8 are {:.1%} off at its nodes: split it, or leave out local modes by keep"
NO_NODES: Mapping[str, AnyArray] = {}
SAME = 1e-9
"""Of the largest entry: how far a matrix may be from symmetric, and a mass from one that acts alike in x, y, z."""
MOST_TRIANGLES = 1500
"""Of a surface that is drawn."""
DEPENDENT = 1e-10
"""Least squared norm of a shape's part that is orthogonal to the shapes before it, by its own norm."""


@dataclass(frozen=True, eq=False)
class FiniteElements:
    """A free solid: nodes x (n, 3), m; stiffness (3 n, 3 n), N/m, and scalar mass (n, n), kg, sparse matrices.

    Rows 3 k, 3 k + 1, 3 k + 2 belong to node k. `numbers` (n,) are those of the file, `groups` sets of nodes (indices)
    by name. `source` names the file in messages, `about` says where the model comes from. `geometric` returns the
    geometric stiffness (n, n), N/m, which acts on x, y and z alike, of the stresses under displacements (3 n,), m.
    `triangles` (M, 3) of nodes, seen from outside, are the surface.
    """

    x: Array
    K: Any
    m: Any
    numbers: AnyArray
    source: str
    about: str
    groups: Mapping[str, AnyArray] = field(default_factory=dict)
    geometric: Callable[[Array], Any] | None = None
    triangles: AnyArray = field(default_factory=lambda: np.empty((0, 3), dtype=np.int64))


def modal_body(
    model: FiniteElements,
    fixed: AnyArray,
    interfaces: Mapping[str, AnyArray],
    count: int,
    rails: Mapping[str, AnyArray] = NO_NODES,
    rigid: Collection[str] = (),
) -> ModalBody:
    """Return the body whose nodes `fixed` (indices) the joint fixes, with six modes an interface and `count` more.

    A rail has the modes under loads that are distributed along it. Interfaces that `rigid` names stiffen it. Raises
    `InputError` for a model that is fixed already, or that moves without deflection where it is fixed.
    """
    refuse_wrong(model, fixed, interfaces)
    linalg, sparse = for_vibrations("scipy.sparse.linalg"), for_vibrations("scipy.sparse")
    moves = _free_displacements(model, fixed, {name: nodes for name, nodes in interfaces.items() if name in rigid})
    full_M = sparse.kron(model.m, np.eye(3)).tocsr()
    K, M = ((moves.T @ matrix @ moves).tocsc() for matrix in (model.K, full_M))
    try:
        inverse = linalg.splu(K).solve
    except RuntimeError:
        raise InputError(model.source, "--fixed", "the body moves without deflection: hold more of its nodes") from None
    loads = [_loads(model.x, nodes) for nodes in interfaces.values()]
    loads += [loads_along(model.x, nodes, name, model.source) for name, nodes in rails.items()]
    shapes = moves @ inverse(moves.T @ np.hstack([*loads, np.zeros((3 * len(model.x), 0))]))
    forces = shapes[:, : 6 * len(interfaces)].reshape(len(shapes), -1, 6)[:, :, :3]
    if count:
        operator = linalg.LinearOperator(K.shape, matvec=inverse)
        start = np.random.default_rng(0).normal(size=K.shape[0])
        _, modes = linalg.eigsh(K, min(count, K.shape[0] - 1), M, sigma=0.0, OPinv=operator, v0=start)
        shapes = np.hstack([shapes, moves @ modes])
    columns, stiffness = _modes(shapes, model.K, full_M)
    phi = columns.T.reshape(-1, len(model.x), 3)
    about = "".join(f", rigid interface {name}" for name in rigid)
    fits = {name: rail_of(model.x, nodes, phi, stiffness, name, model.source) for name, nodes in rails.items()}
    doubts = tuple(f"rail {name}: {ROUGH.format(error)}" for name, (_, error) in fits.items() if error > FITTED)
    body = _body(replace(model, about=model.about + about), phi, stiffness, interfaces)
    body = replace(body, rails={name: rail for name, (rail, _) in fits.items()}, doubts=doubts)
    if model.geometric is None:
        return body
    # Forces (3 n, 12) of accelerations along x, y, z (i) that are 1 and proportional to x, y, z (j), i before j.
    fields = -(model.m @ np.hstack([np.ones((len(model.x), 1)), model.x]))
    inertial = np.einsum("nj,ic->ncij", fields, np.eye(3)).reshape(3 * len(model.x), 12)
    accelerations = moves @ inverse(moves.T @ inertial)
    return _with_foreshortening(body, model.geometric, phi, accelerations, forces)


def _free_displacements(model: FiniteElements, fixed: AnyArray, rigid: Mapping[str, AnyArray]) -> Any:
    """Sparse basis (3 n, ...) of the displacements that the fixed joint and rigid interfaces allow."""
    sparse, free = for_vibrations("scipy.sparse"), np.setdiff1d(np.arange(len(model.x)), fixed)
    motions = []
    for name, nodes in rigid.items():
        if not np.isin(nodes, free).all():
            what = "is rigid and has nodes of the joint, or of another rigid interface: leave them out"
            raise InputError(model.source, f"--interface {name}", what)
        free, motion = np.setdiff1d(free, nodes), np.zeros((len(model.x), 3, 6))
        motion[nodes, :, :3] = np.eye(3)
        for axis in range(3):
            motion[nodes, :, 3 + axis] = np.cross(np.eye(3)[axis], model.x[nodes] - model.x[nodes].mean(axis=0))
        motions.append(sparse.csc_matrix(motion.reshape(-1, 6)))
    rows = (3 * free[:, None] + np.arange(3)).ravel()
    return sparse.hstack([sparse.identity(3 * len(model.x), format="csc")[:, rows], *motions], format="csc")


def _with_foreshortening(
    body: ModalBody, geometric: Callable[[Array], Any], phi: Array, accelerations: Array, forces: Array
) -> ModalBody:
    """The body with foreshortening, by displacements under accelerations (3 n, 12) and forces (3 n, interfaces, 3)."""

    def of_modes(displacements: Array) -> Array:
        """Kg (m, m, ...) under displacements (3 n, ...), without rounding of the solutions."""
        matrices = map(geometric, displacements.T)
        Kg = np.stack([sum(x @ (matrix @ x.T) for x in phi.transpose(2, 0, 1)) for matrix in matrices], axis=2)
        Kg = (Kg + Kg.swapaxes(0, 1)) / 2
        return np.where(np.abs(Kg) > SAME * np.abs(Kg).max(), Kg, 0.0)

    Kg = of_modes(accelerations).reshape(body.count, body.count, 3, 4)
    shorter = (-of_modes(force) for force in np.moveaxis(forces, 1, 0))
    interfaces = {name: replace(x, shorter=next(shorter)) for name, x in body.interfaces.items()}
    return replace(body, Ct1=Kg[:, :, :, 0], T1s=Kg[:, :, :, 1:].swapaxes(2, 3), interfaces=interfaces)


def refuse_wrong(model: FiniteElements, fixed: AnyArray, interfaces: Mapping[str, AnyArray]) -> None:
    """Raise `InputError` for matrices that are not those of a free solid, and nodes that determine no position."""
    for name, matrix in (("K", model.K), ("M", model.m)):
        if abs(matrix - matrix.T).max() > SAME * abs(matrix).max():
            raise InputError(model.source, name, "is not symmetric")
    center = model.x - model.x.mean(axis=0)
    size = np.abs(center).max()
    turns = [np.cross(axis, center / size).ravel() for axis in np.eye(3)]
    motions = np.vstack([np.tile(np.eye(3), len(center)), *turns])
    if np.abs(model.K @ motions.T).max() > LOOSE * abs(model.K).max():
        what = "a motion of the whole body meets forces: export the free model with all digits, --fixed holds it"
        raise InputError(model.source, "K", what)
    for name, nodes in {"--fixed": fixed, **{f"--interface {key}": x for key, x in interfaces.items()}}.items():
        if np.linalg.matrix_rank(model.x[nodes] - model.x[nodes].mean(axis=0), tol=SAME * size) < 2:
            raise InputError(model.source, name, f"{len(nodes)} nodes on a line or point: add nodes off that line")


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
    """Sum of r.r 1 - r r^T (3, 3) over lever arms r."""
    return np.asarray(np.sum(arms * arms) * np.eye(3) - arms.T @ arms)


def _modes(shapes: Array, K: Any, M: Any) -> tuple[Array, Array]:
    """Modes (rows, m) in the span of shapes, and their stiffnesses: omega^2 times modal mass."""
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
    damping, surface = np.zeros(len(stiffness)), _surface(model, phi)
    return ModalBody((G + G.T) / 2, stiffness, damping, followers, about=model.about, surface=surface)


def _surface(model: FiniteElements, phi: Array) -> Surface | None:
    """The surface of a model with its modes phi (m, n, 3), coarse enough to be drawn."""
    if not len(model.triangles):
        return None
    nodes, corners = np.unique(model.triangles, return_inverse=True)
    return Surface(model.x[nodes], corners.reshape(-1, 3), phi[:, nodes]).coarse(MOST_TRIANGLES)


@dataclass(frozen=True, repr=False)
class FlexibleModes(Result):
    """The body of a file of modes, or of a finite-element model that was reduced to one."""

    source: str
    body: ModalBody

    @property
    def headline(self) -> str:
        """Source, mass and first frequency of the body."""
        about = f" ({self.body.about})" if self.body.about else ""
        count = f"{self.body.count} mode{'s' * (self.body.count > 1)}"
        return f"{self.source}{about}: {self.body.rigid[0]:.6g} kg, {count}, the first at {self.first:.5g} Hz"

    @property
    def first(self) -> float:
        """The lowest frequency with the joint held, Hz."""
        return float(self.body.frequencies.min())

    def write(self, file: str | Path, *, force: bool = False) -> Path:
        """Write the body to a .npz file, which `[flexible]` of a machine names; raises `InputError` if it exists."""
        with permission(force=force):
            save(self.body, file)
        return Path(file)
