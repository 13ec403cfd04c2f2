"""Files of flexible bodies, .npz: modes, their integrals over the mass, stiffness, and interfaces.

With Psi = [1, x, y, z, phi_1x, phi_1y, phi_1z, phi_2x ...] over the mass, in the frame of the joint at which the modes
vanish, `G` = int Psi^T Psi holds mass, moments and all integrals of linear modes. `K` is their stiffness, `D` their
damping, `Ct1` and `T1s` are integrals of foreshortening s_kl and of x s_kl^T. An interface NAME has the point
`NAME_r`, displacements `NAME_phi` (3, m) and turns `NAME_psi` (3, m) of the modes there, and with foreshortening
`NAME_s` (m, m, 3): it moves by s_kl e_k e_l/2 in addition. A rail begins at `NAME_r` and ends at `NAME_end`, on an axis
of the frame; its `NAME_phi` and `NAME_psi` (n, 3, m) are the coefficients of polynomials by powers of the distance from
its beginning, m. `surface` (N, 3), `triangles` (M, 3) and `surface_modes` (m, N, 3) are drawn. `about` is a text.
"""

from __future__ import annotations

import io
import zlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any
from zipfile import BadZipFile, ZipFile

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.input_files import read_file
from symoro_elastic.foundation.output_files import write_file
from symoro_elastic.machine.flexible import Surface

SAME = 1e-9
"""Of the largest entry: how far matrices may be from symmetric, and eigenvalues below zero."""
MOST_BYTES = 50_000_000
LOST = 0.1
"""Of a compliance: what is worth a remark where modes are left out."""
OWN = ("G", "K", "D", "Ct1", "T1s", "frequencies", "about")
ENDS, SHORTER, OF_RAIL = ("_r", "_phi", "_psi"), "_s", "_end"
SURFACE = ("surface", "triangles", "surface_modes")


@dataclass(frozen=True, eq=False)
class Interface:
    """A point of a flexible body: its position at rest (3,), its displacements and rotations (m, 3) per mode.

    `shorter` (m, m, 3) is its foreshortening.
    """

    point: Array
    shift: Array
    turn: Array
    shorter: Array | None = None


@dataclass(frozen=True, eq=False)
class Rail:
    """A straight line on a body, from a point to an end (3,): its displacement and rotation by modes, polynomials.

    Coefficients are by powers of the distance from the point, m.
    """

    point: Array
    end: Array
    shift: Array
    turn: Array

    @property
    def length(self) -> float:
        """Length of the rail, m."""
        return float(np.linalg.norm(self.end - self.point))

    @property
    def axes(self) -> Array:
        """Axes of the rail (3, 3), columns in the frame of the body, the first along the rail."""
        along = int(np.argmax(np.abs(self.end - self.point)))
        sign = np.sign((self.end - self.point)[along])
        u, v = sign * np.eye(3)[along], np.eye(3)[(along + 1) % 3]
        return np.column_stack([u, v, np.cross(u, v)])

    def at(self, place: float) -> Interface:
        """Return the interface at a distance from the rail's beginning, m."""
        powers = place ** np.arange(len(self.shift))
        shift, turn = (np.einsum("n,nka->ka", powers, x) for x in (self.shift, self.turn))
        return Interface(self.point + place * self.axes[:, 0], shift, turn)


@dataclass(frozen=True, eq=False)
class ModalBody:
    """A flexible body with m modes orthogonal in stiffness: `G` (4 + 3 m, 4 + 3 m), stiffness and damping (m,), N/m."""

    G: Array
    stiffness: Array
    damping: Array
    interfaces: Mapping[str, Interface] = field(default_factory=dict)
    Ct1: Array | None = None
    T1s: Array | None = None
    about: str = ""
    doubts: tuple[str, ...] = ()
    rails: Mapping[str, Rail] = field(default_factory=dict)
    surface: Surface | None = None

    @property
    def count(self) -> int:
        """The number m of modes."""
        return len(self.stiffness)

    @property
    def masses(self) -> Array:
        """Modal mass matrix Mee (m, m)."""
        return np.asarray(self._pairs.trace(axis1=2, axis2=3))

    @property
    def frequencies(self) -> Array:
        """Frequencies (m,) of the modes with the joint locked, Hz, if they are orthogonal in mass, too."""
        return np.asarray(np.sqrt(self.stiffness / np.diag(self.masses)) / (2 * np.pi))

    @property
    def rigid(self) -> tuple[float, Array, Array]:
        """Mass, first moments (3,) and inertia (3, 3) of the undeformed body about the joint."""
        P = self.G[1:4, 1:4]
        return float(self.G[0, 0]), self.G[0, 1:4], np.trace(P) * np.eye(3) - P

    @property
    def integrals(self) -> dict[str, Array]:
        """Mass integrals Ct0, Ct1, T0, T1, Mee of a flexible body, by name."""
        m = self.count
        Ct1 = np.zeros((m, m, 3)) if self.Ct1 is None else self.Ct1
        T1s = np.zeros((m, m, 3, 3)) if self.T1s is None else self.T1s
        T0 = self.G[1:4, 4:].reshape(3, m, 3).transpose(1, 0, 2)
        T1 = self._pairs.transpose(1, 0, 2, 3) + T1s
        return {"Ct0": self.G[0, 4:].reshape(m, 3), "Ct1": Ct1, "T0": T0, "T1": T1, "Mee": self.masses}

    @property
    def _pairs(self) -> Array:
        """Mass integrals int phi_k phi_l^T dm of pairs of modes, (m, m, 3, 3)."""
        return self.G[4:, 4:].reshape(self.count, 3, self.count, 3).transpose(0, 2, 1, 3)

    @property
    def places(self) -> dict[str, Interface]:
        """Interfaces by name, with both ends and the middle of each rail."""
        ends = {name: np.linspace(0, rail.length, 3).tolist() for name, rail in self.rails.items()}
        on_rails = {f"{name} at {x:.3g} m": self.rails[name].at(x) for name, places in ends.items() for x in places}
        return {**self.interfaces, **on_rails}

    def compliance(self, name: str) -> Array:
        """The compliance (6, 6) at an interface with the joint locked, by force and moment: m/N, 1/N, rad/(N m)."""
        moved = np.hstack([self.places[name].shift, self.places[name].turn])
        return np.asarray(moved.T @ (moved / self.stiffness[:, None]))

    def keep(self, chosen: Array) -> ModalBody:
        """The body with the modes of a mask (m,); its warnings name interfaces that lose much compliance."""
        at = np.flatnonzero(chosen)
        rows = np.concatenate([np.arange(4), (4 + 3 * at[:, None] + np.arange(3)).ravel()])

        def pairs(x: Array | None) -> Array | None:
            return None if x is None else x[np.ix_(at, at)]

        interfaces = {
            key: Interface(x.point, x.shift[at], x.turn[at], pairs(x.shorter)) for key, x in self.interfaces.items()
        }
        rails = {key: Rail(x.point, x.end, x.shift[:, at], x.turn[:, at]) for key, x in self.rails.items()}
        Ct1, T1s = pairs(self.Ct1), pairs(self.T1s)
        numbers = self.stiffness[at], self.damping[at], interfaces, Ct1, T1s, self.about
        surface = self.surface and replace(self.surface, modes=self.surface.modes[at])
        smaller = ModalBody(self.G[np.ix_(rows, rows)], *numbers, rails=rails, surface=surface)
        return replace(smaller, doubts=tuple(x for name in self.places for x in self._lost(smaller, name)))

    @property
    def without_foreshortening(self) -> ModalBody:
        """The body without foreshortening, so that its stiffness does not depend on loads."""
        interfaces = {name: replace(x, shorter=None) for name, x in self.interfaces.items()}
        return replace(self, Ct1=None, T1s=None, interfaces=interfaces)

    def _lost(self, smaller: ModalBody, name: str) -> Iterator[str]:
        """Warnings for directions of an interface that lose much compliance by the omitted modes."""
        before, after = (np.diag(body.compliance(name)) for body in (self, smaller))
        directions = ("along x", "along y", "along z", "about x", "about y", "about z")
        shares = {key: 1 - x / y for key, x, y in zip(directions, after, before, strict=True) if x < (1 - LOST) * y}
        if shares:
            listed = ", ".join(f"{share:.0%} {key}" for key, share in shares.items())
            yield f"keep leaves out compliance of {name}: {listed}"


def save(body: ModalBody, file: str | Path) -> None:
    """Write a modal body to a .npz file; raises `InputError`."""
    arrays: dict[str, Any] = {"G": body.G, "K": np.diag(body.stiffness), "D": np.diag(body.damping)}
    arrays |= {"frequencies": body.frequencies, "about": np.array(body.about)}
    arrays |= {key: x for key, x in (("Ct1", body.Ct1), ("T1s", body.T1s)) if x is not None}
    for name, interface in body.interfaces.items():
        parts = (interface.point, interface.shift.T, interface.turn.T)
        arrays |= {name + end: x for end, x in zip(ENDS, parts, strict=True)}
        arrays |= {} if interface.shorter is None else {name + SHORTER: interface.shorter}
    if body.surface is not None:
        parts = (body.surface.points, body.surface.triangles, body.surface.modes)
        arrays |= {key: x.astype(kind) for key, x, kind in zip(SURFACE, parts, ("f4", "i4", "f4"), strict=True)}
    for name, rail in body.rails.items():
        arrays |= {name + "_r": rail.point, name + OF_RAIL: rail.end}
        arrays |= {name + "_phi": rail.shift.transpose(0, 2, 1), name + "_psi": rail.turn.transpose(0, 2, 1)}
    stream = io.BytesIO()
    np.savez_compressed(stream, **arrays)
    write_file(stream.getvalue(), file)


def load(file: str | Path) -> ModalBody:
    """Read a modal body from a .npz file; raises `InputError` for other content."""
    content, source = read_file(file, most=MOST_BYTES + 1), str(file)
    if len(content) > MOST_BYTES:
        raise InputError(source, "file", f"larger than {MOST_BYTES // 10**6} MB: keep fewer modes")
    try:
        with ZipFile(io.BytesIO(content)) as parts:
            if sum(part.file_size for part in parts.infolist()) > MOST_BYTES:
                raise InputError(source, "file", f"arrays of more than {MOST_BYTES // 10**6} MB: keep fewer modes")
        with np.load(io.BytesIO(content), allow_pickle=False) as stored:
            arrays = {key: stored[key] for key in stored.files}
    except (ValueError, OSError, BadZipFile, KeyError, TypeError, EOFError, MemoryError, zlib.error) as error:
        raise InputError(source, "file", f"not a .npz file of arrays: {str(error)[:120]}") from None
    return _body(arrays, source)


def _body(arrays: Mapping[str, Array], source: str) -> ModalBody:
    for key in ("G", "K"):
        if key not in arrays:
            raise InputError(source, key, "is missing: symoro-elastic flexible writes such files")
    K = _symmetric(arrays, "K", source)
    m = len(K)
    if m == 0:
        raise InputError(source, "K", "has no modes: a rigid body is described in [bodies]")
    G = _symmetric(arrays, "G", source, 4 + 3 * m)
    D = _symmetric(arrays, "D", source, m) if "D" in arrays else np.zeros((m, m))
    for key, x in (("K", K), ("D", D)):
        if np.abs(x - np.diag(np.diag(x))).max() > SAME * np.abs(x).max():
            raise InputError(source, key, "is not diagonal: use modes that are orthogonal in it")
    if not (np.diag(K) > 0).all():
        raise InputError(source, "K", "a mode without stiffness is a motion of the whole body: fix it at its joint")
    optional = {"Ct1": (m, m, 3), "T1s": (m, m, 3, 3)}
    more = {key: _of_shape(arrays, key, shape, source) for key, shape in optional.items()}
    interfaces, rails = _interfaces(arrays, m, source), _rails(arrays, m, source)
    about, surface = str(arrays.get("about", "")), _surface(arrays, m, source)
    return ModalBody(G, np.diag(K), np.diag(D), interfaces, **more, about=about, rails=rails, surface=surface)


def _surface(arrays: Mapping[str, Array], m: int, source: str) -> Surface | None:
    """The surface mesh in the arrays of a file; None without one."""
    if SURFACE[0] not in arrays:
        return None
    sizes = [len(arrays[key]) if key in arrays and arrays[key].ndim else 0 for key in SURFACE[:2]]
    shapes = ((sizes[0], 3), (sizes[1], 3), (m, sizes[0], 3))
    points, corners, modes = (_of_shape(arrays, key, x, source) for key, x in zip(SURFACE, shapes, strict=True))
    if corners is None or modes is None or not np.isin(corners, np.arange(len(points))).all():
        raise InputError(source, SURFACE[1], "must be indices of points of a surface, which has surface_modes")
    return Surface(points, corners.astype(np.int64), modes)


def _interfaces(arrays: Mapping[str, Array], m: int, source: str) -> dict[str, Interface]:
    names = [key.removesuffix("_r") for key in arrays if key.endswith("_r") and key not in OWN]
    names = [name for name in names if name + OF_RAIL not in arrays]
    sizes = dict(zip(ENDS, ((3,), (3, m), (3, m)), strict=True))
    parts = {name: [_of_shape(arrays, name + end, size, source) for end, size in sizes.items()] for name in names}
    for name, (point, phi, psi) in parts.items():
        if point is None or phi is None or psi is None:
            raise InputError(source, name, f"an interface has {', '.join(name + end for end in ENDS)}")
    shorter = {name: _of_shape(arrays, name + SHORTER, (m, m, 3), source) for name in names}
    return {name: Interface(point, phi.T, psi.T, shorter[name]) for name, (point, phi, psi) in parts.items()}


def _rails(arrays: Mapping[str, Array], m: int, source: str) -> dict[str, Rail]:
    rails = {}
    for name in [key.removesuffix(OF_RAIL) for key in arrays if key.endswith(OF_RAIL) and key not in OWN]:
        count = len(np.atleast_1d(arrays.get(name + "_phi", np.zeros(1))))
        sizes = zip((*ENDS, OF_RAIL), ((3,), (count, 3, m), (count, 3, m), (3,)), strict=True)
        point, phi, psi, end = (_of_shape(arrays, name + key, size, source) for key, size in sizes)
        if point is None or phi is None or psi is None:
            raise InputError(source, name, f"a rail has {', '.join(name + key for key in (*ENDS, OF_RAIL))}")
        if np.count_nonzero(end - point) != 1:
            raise InputError(source, name + OF_RAIL, "must lie on an axis of the frame through the beginning")
        rails[name] = Rail(point, end, phi.transpose(0, 2, 1), psi.transpose(0, 2, 1))
    return rails


def _of_shape(arrays: Mapping[str, Array], key: str, shape: Sequence[int], source: str) -> Any:
    if key not in arrays:
        return None
    x = arrays[key]
    if x.shape != tuple(shape) or x.dtype.kind not in "fiu" or not np.isfinite(x).all():
        raise InputError(source, key, f"must be numbers of the shape {tuple(shape)}, is {x.dtype} {x.shape}")
    return x.astype(float)


def _symmetric(arrays: Mapping[str, Array], key: str, source: str, size: int | None = None) -> Array:
    """A symmetric, positive semidefinite matrix from a file; raises `InputError`."""
    x = arrays[key]
    size = len(x) if size is None and x.ndim else size or 0
    matrix: Array = _of_shape(arrays, key, (size, size), source)
    largest = np.abs(matrix).max(initial=0.0)
    if np.abs(matrix - matrix.T).max(initial=0.0) > SAME * largest:
        raise InputError(source, key, "is not symmetric")
    if size and np.linalg.eigvalsh(matrix).min() < -SAME * largest:
        raise InputError(source, key, "has a negative eigenvalue: no body has such an energy")
    return (matrix + matrix.T) / 2
