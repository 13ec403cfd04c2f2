"""Finite-element models from files: matrices with their nodes, and meshes that are assembled here."""

from __future__ import annotations

import re
from collections.abc import Mapping
from math import inf
from pathlib import Path
from typing import Any

import numpy as np

from symoro_elastic.analysis.flexible.matrix_files import matrix_of_nodes
from symoro_elastic.analysis.flexible.reduction import SAME, FiniteElements
from symoro_elastic.analysis.flexible.solid_elements import ORDER, SolidElements
from symoro_elastic.foundation.array_types import AnyArray, Array
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.input_files import read_file
from symoro_elastic.foundation.output_files import temporary_folder
from symoro_elastic.foundation.packages import for_vibrations, import_optional
from symoro_elastic.machine.names import did_you_mean, quote

MATERIALS: Mapping[str, tuple[float, float, float]] = {
    "steel": (210e9, 0.30, 7850.0),
    "cast-iron": (110e9, 0.26, 7200.0),
    "aluminium": (70e9, 0.33, 2700.0),
    "titanium": (114e9, 0.34, 4430.0),
    "mineral-casting": (40e9, 0.25, 2400.0),
}
"""Modulus of elasticity, Pa, Poisson's ratio, density, kg/m3: usual values, within 5 %, mineral casting within 20 %."""
DECIMAL = r"([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)"
PLANE = re.compile(rf"([xyz])={DECIMAL}(?::{DECIMAL})?")
NUMBERS = re.compile(r"\d+(-\d+)?(,\d+(-\d+)?)*")
SOLIDS = (".step", ".stp", ".iges", ".igs", ".brep")
"""Files of solids that are meshed here."""
NEAR = 1e-6
"""Of the largest size: how far a node may be from a plane."""


def of_matrices(stiffness: str, mass: str, nodes: str, scale: float, unit: float) -> FiniteElements:
    """Return the model of matrices in files and of nodes in a table "number, x, y, z"; raises `InputError`.

    Coordinates times `scale` are metres, entries of the mass matrix times `unit` are kg, and those of the stiffness
    matrix times `unit` are N/m, since their unit is that of mass by s2.
    """
    numbers, x = _nodes(nodes)
    K, M = (matrix_of_nodes(file, numbers, letter) for file, letter in ((stiffness, "K"), (mass, "M")))
    used = K.diagonal().reshape(-1, 3).any(axis=1)
    rows = np.repeat(used, 3)
    K, M = K[rows][:, rows], M[rows][:, rows]
    m = M[0::3, 0::3]
    if abs(M - for_vibrations("scipy.sparse").kron(m, np.eye(3))).max() > SAME * abs(M).max():
        what = "is not the same in x, y, z and zero between them: export solid elements, not beams or shells"
        raise InputError(mass, "M", what)
    if not m.sum() > 0:
        raise InputError(mass, "M", "adds up to no mass: give the material a density")
    about = ", ".join(Path(file).name for file in dict.fromkeys((stiffness, mass, nodes)))
    return FiniteElements(scale * x[used], unit * K, unit * m, numbers[used], stiffness, about)


def _nodes(file: str) -> tuple[AnyArray, Array]:
    """Numbers and coordinates of nodes; a first line without numbers is a heading, lines with * are comments."""
    lines = map(str.strip, read_file(file).decode("utf-8-sig", "replace").splitlines())
    rows = [re.split(r"[,;\s]+", line) for line in lines if line and not line.startswith("*")]
    if rows and not re.fullmatch(r"[-+.\deE]+", rows[0][0]):
        rows = rows[1:]
    try:
        table = np.array([[float(cell) for cell in row] for row in rows])
        if table.ndim != 2 or table.shape[1] != 4 or not np.isfinite(table).all() or np.abs(table[:, 0]).max() > 2**53:
            raise ValueError
    except ValueError:
        raise InputError(file, "file", "must have lines of a node's number, x, y, z") from None
    numbers, counts = np.unique(table[:, 0].astype(np.int64), return_counts=True)
    if counts.max() > 1:
        raise InputError(file, "file", f"has node {numbers[counts.argmax()]} {counts.max()} times")
    return table[:, 0].astype(np.int64), table[:, 1:]


def of_mesh(file: str, material: str, scale: float, size: float | None = None) -> FiniteElements:
    """Return the model of a mesh of tetrahedra or hexahedra, with quadratic displacements; raises `InputError`.

    Named sets of faces are groups. Coordinates times `scale` are metres. A solid (STEP, IGES, BREP) is meshed with
    elements up to `size`, m, by default a tenth of its size.
    """
    skfem = import_optional("skfem", "a body from a mesh", "fe")
    mesh = _mesh(skfem, file, size).scaled(scale)
    element = skfem.ElementTetP2() if "Tet" in type(mesh).__name__ else skfem.ElementHex2()
    E, nu, density = material_of(material)
    basis = skfem.Basis(mesh, element, intorder=ORDER)
    solid = SolidElements.of(basis, (E * nu / ((1 + nu) * (1 - 2 * nu)), E / (2 * (1 + nu))))
    groups = {name: basis.get_dofs(facets).flatten() for name, facets in (mesh.boundaries or {}).items()}
    about = f"{Path(file).name}, {material}"
    numbers, matrices = np.arange(1, basis.N + 1), (solid.stiffness(), solid.mass(density))
    triangles = basis.nodal_dofs[0][_outer_triangles(mesh)]
    return FiniteElements(basis.doflocs.T, *matrices, numbers, file, about, groups, solid.geometric, triangles)


def _outer_triangles(mesh: Any) -> AnyArray:
    """Vertices (M, 3) of the triangles of a mesh's surface, counterclockwise from outside."""
    faces = mesh.boundary_facets()
    corners, inside = mesh.facets[:, faces].T, mesh.p[:, mesh.t[:, mesh.f2t[0, faces]]].mean(axis=1).T
    if corners.shape[1] == 4:  # the two diagonals of a face are longer than any two of its sides that do not meet
        pairs = np.array([[0, 1, 2, 3], [0, 2, 1, 3], [0, 3, 1, 2]])
        x = mesh.p.T[corners[:, pairs]]  # (faces, pairings, 4, 3)
        lengths = np.linalg.norm(x[:, :, [0, 2]] - x[:, :, [1, 3]], axis=3).sum(axis=2)
        a, c, b, d = np.take_along_axis(corners, pairs[lengths.argmax(axis=1)], axis=1).T
        corners, inside = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)]), np.tile(inside, (2, 1))
    p = mesh.p.T[corners]
    outward = np.einsum("fi,fi->f", np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]), p[:, 0] - inside)
    return np.asarray(np.where((outward > 0)[:, None], corners, corners[:, ::-1]))


def _mesh(skfem: Any, file: str, size: float | None) -> Any:
    """Return a mesh of solid elements from a mesh file, or from a CAD file with elements up to `size`, m."""
    read_file(file, most=1)
    if Path(file).suffix.lower() in SOLIDS:
        with temporary_folder() as folder:
            return _loaded(skfem, file, _mesh_of_solid(file, size, Path(folder) / "solid.msh"))
    if size is not None:
        raise InputError(file, "--size", f"is of solids that are meshed here, {', '.join(SOLIDS)}: leave it out")
    return _loaded(skfem, file, file)


def _mesh_of_solid(file: str, size: float | None, mesh: Path) -> str:
    """Mesh the solid in a CAD file with tetrahedra, m, and return the path of the mesh file."""
    if size is not None and not 0 < size < inf:
        raise InputError(file, "--size", f"{size:g} must be above 0, m")
    gmsh = import_optional("gmsh", "a mesh of a solid", "step")
    gmsh.initialize([], readConfigFiles=False, interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.option.setString("Geometry.OCCTargetUnit", "M")
        gmsh.merge(file)
        if not gmsh.model.getEntities(3):
            raise InputError(file, "file", "has no solid: export closed surfaces as a solid")
        if size is not None:
            gmsh.option.setNumber("Mesh.MeshSizeMax", size)
        gmsh.model.mesh.generate(3)
        gmsh.write(str(mesh))
    except InputError:
        raise
    except Exception as error:  # whatever the mesher raises
        raise InputError(file, "file", f"cannot be meshed: {str(error)[:120]}") from None
    finally:
        gmsh.finalize()
    return str(mesh)


def _loaded(skfem: Any, source: str, file: str) -> Any:
    """Read a mesh from `file`; messages name `source` instead."""
    try:
        mesh = skfem.Mesh.load(file)
    except Exception as error:
        raise InputError(source, "file", f"no mesh can be read: {str(error)[:120]}") from None
    if not any(kind in type(mesh).__name__ for kind in ("Tet", "Hex")):
        raise InputError(source, "file", "has no tetrahedra and no hexahedra: mesh the volume")
    return mesh


def material_of(text: str) -> tuple[float, float, float]:
    """Return E, Pa, Poisson's ratio and density, kg/m3, of a name, or of "E,nu,density"; raises `InputError`."""
    if text in MATERIALS:
        return MATERIALS[text]
    try:
        E, nu, density = map(float, text.split(","))
    except ValueError:
        what = f"no material {quote(text)}{did_you_mean(text, MATERIALS)}; or give E,nu,density, as 210e9,0.3,7850"
        raise InputError("symoro-elastic", "--material", what) from None
    if not (E > 0 and 0 <= nu < 0.5 and density > 0):
        raise InputError("symoro-elastic", "--material", "E and density must be above 0, nu from 0 to below 0.5")
    return E, nu, density


def nodes_of(model: FiniteElements, text: str, option: str) -> AnyArray:
    """Return indices of nodes: a group of the mesh, planes in m, or numbers "1-40,77"; raises `InputError`.

    A plane is "x=0.5", what is between two of them "x=0.1:0.5"; & joins several.
    """
    if text in model.groups:
        return model.groups[text]
    planes = [PLANE.fullmatch(part) for part in text.replace(" ", "").split("&")]
    if all(planes):
        near = NEAR * np.ptp(model.x, axis=0).max()
        chosen = np.arange(len(model.x))
        for axis, low, high in (plane.groups() for plane in planes if plane):
            at = model.x[chosen, "xyz".index(axis)]
            chosen = chosen[(at >= float(low) - near) & (at <= float(high or low) + near)]
    elif NUMBERS.fullmatch(text):
        ends = [[int(x) for x in part.split("-")] for part in text.split(",")]
        wanted = np.concatenate([np.arange(part[0], part[-1] + 1) for part in ends])
        chosen = np.flatnonzero(np.isin(model.numbers, wanted))
    else:
        ways_out = "or give planes, z=0.3&x=0.1:0.5, or numbers, 1-40,77"
        what = f"no group {quote(text)}{did_you_mean(text, model.groups)}; {ways_out}"
        raise InputError(model.source, option, what)
    if not len(chosen):
        raise InputError(model.source, option, f"no node at {quote(text)}: coordinates are in m")
    return chosen
