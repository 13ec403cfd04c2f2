"""An MJCF model as MuJoCo compiles it: defaults, copies, angles and inertias of shapes resolved."""

from __future__ import annotations

import re
import warnings
from dataclasses import dataclass
from pathlib import PurePosixPath
from typing import Any

from symoro_elastic.errors import InputError
from symoro_elastic.machine.formats.robots.mjcf_files import Sources, sources_of
from symoro_elastic.packages import imported

SEEN_ONLY = ("sensors", "keys", "pairs", "tuples", "numerics", "texts", "skins", "cameras", "lights", "textures")
"""Lists of what moves nothing and may be large, or name files."""


@dataclass(frozen=True, eq=False)
class Compiled:
    """A compiled model: MuJoCo's `model`, and `mujoco` itself, the module with its constants.

    `name` is that of the file, empty where it gives none; `has_contacts` says that shapes may touch.
    """

    mujoco: Any
    model: Any
    name: str
    source: str
    has_contacts: bool

    def error(self, place: str, what: str) -> InputError:
        """The error to raise about one place of the model."""
        return InputError(self.source, place, what)


def compiled(text: str, source: str) -> Compiled:
    """Return the model that MuJoCo makes of an MJCF text; raises `InputError`.

    Shapes are dropped where they give no inertia, so their files are not needed.
    """
    sources = sources_of(text, source)
    mujoco = imported("mujoco", "reading MJCF", "mjcf")
    try:
        spec = mujoco.MjSpec.from_string(sources.text, include=sources.parts)
        has_contacts = any(geom.contype or geom.conaffinity for geom in spec.geoms)
        _drop_what_is_seen_only(spec)
        _drop_shapes(spec, mujoco)
        _take_meshes(spec, sources)
        with warnings.catch_warnings(action="ignore"):
            model = spec.compile()
    except (ValueError, RuntimeError, mujoco.FatalError) as error:
        raise _said(str(error), source) from None
    name = "" if spec.modelname == "MuJoCo Model" else spec.modelname
    return Compiled(mujoco, model, name, source, has_contacts)


def _said(message: str, source: str) -> InputError:
    """What MuJoCo says, as one line, with the line of the file if it names one."""
    line = re.search(r"line\s*(?:number=)?\s*([1-9]\d*)", message)
    text = " ".join(re.sub(r"[^\x20-\x7e]+", " ", re.sub(r"(?i)^(XML )?Error:?", "", message)).split())
    return InputError(source, f"line {line[1]}" if line else "file", f"MuJoCo does not read it: {text[:200]}")


def _drop_what_is_seen_only(spec: Any) -> None:
    for name in SEEN_ONLY:
        for element in list(getattr(spec, name)):
            spec.delete(element)
    for element in (*spec.geoms, *spec.sites, *spec.tendons):
        element.material = ""
    for material in list(spec.materials):
        spec.delete(material)


def _drop_shapes(spec: Any, mujoco: Any) -> None:
    """Delete shapes from files, and fields of heights, where the inertia of their body does not need them."""
    of_shapes = spec.compiler.inertiafromgeom == mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_TRUE
    least, most = spec.compiler.inertiagrouprange
    for geom in list(spec.geoms):
        is_read = geom.meshname or geom.hfieldname
        body = geom.parent
        given = body.name == "world" or (body.explicitinertial and not of_shapes)
        if is_read and (given or geom.mass == 0 or not least <= geom.group <= most):
            spec.delete(geom)
    for field in list(spec.hfields):
        spec.delete(field)


def _take_meshes(spec: Any, sources: Sources) -> None:
    """Give the meshes that inertias need, and delete the others."""
    needed = {geom.meshname: geom.parent.name for geom in spec.geoms if geom.meshname}
    for k, mesh in enumerate(list(spec.meshes)):
        path = PurePosixPath(mesh.file)
        mesh.name = mesh.name or path.stem
        if mesh.name not in needed:
            spec.delete(mesh)
        elif mesh.file:
            folder = "" if spec.strippath else spec.compiler.meshdir
            name = path.name if spec.strippath else mesh.file
            content = sources.shape(str(PurePosixPath(folder) / name), needed[mesh.name])
            mesh.file = f"mesh{k}{path.suffix}"
            spec.assets[mesh.file] = content
