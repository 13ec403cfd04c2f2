"""Finite-element bodies, and the flexible parts of machines: flexible, flexible_parts."""

from __future__ import annotations

from collections.abc import Mapping
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING

from symoro_elastic.api.declaration import operation
from symoro_elastic.api.kinds import COMMAND
from symoro_elastic.api.options import CountingModes
from symoro_elastic.foundation.errors import InputError

if TYPE_CHECKING:
    from symoro_elastic.analysis.flexible.parts import FlexibleParts
    from symoro_elastic.analysis.flexible.reduction import FiniteElements, FlexibleModes

NOTHING: Mapping[str, str] = {}
MOST_MODES = 200
RIGID = ":rigid"
MASSES: Mapping[str, float] = {"kg": 1.0, "t": 1000.0}
"""Units of mass matrices, kg."""


def flexible(
    source: str | Path,
    fixed: str = "",
    interfaces: Mapping[str, str] = NOTHING,
    rails: Mapping[str, str] = NOTHING,
    *,
    mass: str | Path | None = None,
    nodes: str | Path | None = None,
    modes: int = 6,
    material: str = "steel",
    scale: float = 1.0,
    mass_unit: str = "",
    size: float | None = None,
) -> FlexibleModes:
    """Return a body by modes: that of a .npz file, or of a finite-element model, which is reduced to one.

    `source` is a .npz file, a mesh, or a stiffness matrix (Matrix Market, CalculiX, Nastran DMIG, Abaqus) with `mass`
    and `nodes`. Nodes that the joint holds (`fixed`) and those of interfaces are named sets of the mesh, planes "x=0.5"
    in m, or numbers "1-40,77"; interfaces are averaged, or rigid as "x=0.5:rigid". The body has six modes for each
    interface, so that its compliance is exact, and `modes` more. Rails are strips of nodes along x, y or z, on which a
    row slides (`along`); each has twelve modes under loads along it. `material` of a mesh is a name or "E,nu,density";
    coordinates times `scale` are metres, 0.001 for mm, where matrices need `mass_unit`: "t" with N, or "kg". A solid
    (.step) is meshed with elements up to `size`, m. The origin of the file is that of the joint's frame.

    Raises
    ------
    InputError
        For files that hold no model, models that are fixed already, and nodes that determine no position.
    """
    from symoro_elastic.analysis.flexible.reduction import FlexibleModes, modal_body
    from symoro_elastic.analysis.flexible.sources import nodes_of, of_mesh
    from symoro_elastic.formats.modes_file import load

    file = str(source)
    if file.endswith(".npz"):
        if fixed or interfaces or rails or mass or nodes:
            raise InputError(COMMAND, "--fixed", "a file of modes is reduced already: leave it out")
        return FlexibleModes(file, load(file))
    _refuse(fixed, len(interfaces) + len(rails), modes, scale)
    model = _of_matrices(file, mass, nodes, scale, mass_unit) or of_mesh(file, material, scale, size)
    rigid = [name for name, text in interfaces.items() if text.endswith(RIGID)]
    ends = {name: nodes_of(model, text.removesuffix(RIGID), f"--interface {name}") for name, text in interfaces.items()}
    strips = {name: nodes_of(model, text, f"--rail {name}") for name, text in rails.items()}
    return FlexibleModes(file, modal_body(model, nodes_of(model, fixed, "--fixed"), ends, modes, strips, rigid))


def _of_matrices(
    file: str, mass: str | Path | None, nodes: str | Path | None, scale: float, mass_unit: str
) -> FiniteElements | None:
    """The model of matrices; None for a mesh."""
    from symoro_elastic.analysis.flexible.matrix_files import SUFFIXES
    from symoro_elastic.analysis.flexible.sources import of_matrices

    if not (mass or nodes or Path(file).suffix.lower() in SUFFIXES):
        return None
    _refuse_part(mass, nodes, scale, mass_unit)
    return of_matrices(file, str(mass), str(nodes), scale, MASSES[mass_unit or "kg"])


@operation(CountingModes, "Machine file (.toml).")
def flexible_parts(file: str | Path, options: CountingModes) -> FlexibleParts:
    """Return the beams and bodies by modes of a machine file (.toml), with errors by their joints and modes.

    Errors are those of the first three frequencies and of the compliance of the frame, with motors held. Rows are the
    numbers of the file; or 1, 2, 3 ... joints or modes, up to the first whose errors are predicted to be within a
    fraction.

    Raises
    ------
    InputError
        For files without such parts, unknown frames and joints, and machines without a static compliance.
    """
    from symoro_elastic.analysis.flexible.parts import flexible_parts
    from symoro_elastic.api.poses import frame_of

    if options.within is not None and not 0 < options.within < inf:
        raise InputError(COMMAND, "--within", f"{options.within:g} must be above 0, as 1% or 0.01")
    return flexible_parts(file, lambda machine: frame_of(machine, options.frame), options.at, options.within)


def _refuse(fixed: str, interfaces: int, modes: int, scale: float) -> None:
    if not fixed:
        raise InputError(COMMAND, "--fixed", "says which nodes the joint holds: a set of the mesh, x=0, or numbers")
    if not 0 <= modes <= MOST_MODES or modes + interfaces == 0:
        raise InputError(COMMAND, "--modes", f"must be from 0 to {MOST_MODES}, with an interface or a mode at least")
    if not 0 < scale < inf:
        raise InputError(COMMAND, "--scale", f"{scale:g} must be above 0: coordinates times it are metres")


def _refuse_part(mass: str | Path | None, nodes: str | Path | None, scale: float, mass_unit: str) -> None:
    """Raise `InputError` for matrices without mass, without coordinates of nodes, or with an unknown unit of mass."""
    if not mass:
        what = "a stiffness without mass has no frequencies: export M, too, which substructures of CalculiX leave out"
        raise InputError(COMMAND, "--mass", what)
    if not nodes:
        what = "integrals over the mass need coordinates: give lines of number, x, y, z of every node"
        raise InputError(COMMAND, "--nodes", what)
    if mass_unit not in MASSES and (mass_unit or scale != 1):
        what = "says the unit of mass in matrices whose lengths are not m: t, as with N and mm, or kg"
        raise InputError(COMMAND, "--mass-unit", what)
