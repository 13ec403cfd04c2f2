"""An MJCF model as MuJoCo compiles it: defaults, copies, angles and inertias of shapes resolved."""

from __future__ import annotations

import re
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import PurePosixPath
from typing import Any

import numpy as np

from symoro_elastic.errors import InputError
from symoro_elastic.machine.formats.robots.mjcf_files import Sources, sources_of
from symoro_elastic.machine.names import quoted
from symoro_elastic.packages import imported

SEEN_ONLY = ("sensors", "keys", "pairs", "tuples", "numerics", "texts", "skins", "cameras", "lights", "textures")
"""Lists of what moves nothing and may be large, or name files."""

OLDEST = 4
LARGEST = 1e50
WITHOUT_MEASURE = f"that is not finite, or beyond {LARGEST:g}"
READ = {
    "body_pos": ("body", "pos"),
    "body_quat": ("body", "its orientation"),
    "body_ipos": ("body", "pos of <inertial>"),
    "body_iquat": ("body", "the orientation of <inertial>"),
    "body_mass": ("body", "mass"),
    "body_inertia": ("body", "inertia"),
    "jnt_pos": ("joint", "pos"),
    "jnt_axis": ("joint", "axis"),
    "jnt_stiffness": ("joint", "stiffness"),
    "dof_damping": ("joint", "damping"),
    "dof_armature": ("joint", "armature"),
    "dof_frictionloss": ("joint", "frictionloss"),
    "qpos0": ("", "ref"),
    "qpos_spring": ("", "springref"),
    "actuator_gear": ("actuator", "gear"),
    "actuator_damping": ("actuator", "damping"),
    "actuator_armature": ("actuator", "armature"),
    "eq_data": ("equality", "it"),
}
"""Arrays of MuJoCo that are read: the kind of element that owns a row, and what it is in the file."""


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
    mujoco = _mujoco()
    try:
        with _in_silence(mujoco):
            spec = mujoco.MjSpec.from_string(sources.text, include=sources.parts)
            has_contacts = any(geom.contype or geom.conaffinity for geom in spec.geoms)
            _drop_what_is_seen_only(spec)
            _drop_shapes(spec, mujoco)
            _take_meshes(spec, sources)
            model = spec.compile()
    except (ValueError, RuntimeError, mujoco.FatalError) as error:
        raise _said(str(error), source) from None
    _refuse_without_measure(model, source)
    name = "" if spec.modelname == "MuJoCo Model" else spec.modelname
    return Compiled(mujoco, model, name, source, has_contacts)


def _mujoco() -> Any:
    """The package, in a version whose models tell which springs are linear."""
    mujoco = imported("mujoco", "reading MJCF", "mjcf")
    if int(mujoco.__version__.partition(".")[0]) < OLDEST:
        what = f"version {mujoco.__version__} is installed, reading MJCF needs {OLDEST}: pip install -U mujoco"
        raise InputError("symoro-elastic", "mujoco", what)
    return mujoco


@contextmanager
def _in_silence(mujoco: Any) -> Iterator[None]:
    """Take MuJoCo's warnings, which it would print and write to a file in the working folder."""
    before = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(lambda _: None)
    try:
        with warnings.catch_warnings(action="ignore"):
            yield
    finally:
        mujoco.set_mju_user_warning(before)


def _refuse_without_measure(model: Any, source: str) -> None:
    """Raise `InputError` for infinite and huge numbers, which MuJoCo takes."""
    for array, (kind, key) in READ.items():
        for k in np.argwhere(~(np.abs(getattr(model, array)) < LARGEST))[:1, 0]:
            owner = model.dof_jntid[k] if array.startswith("dof") else k
            place = f"{kind} {quoted(getattr(model, kind)(int(owner)).name or f'number {owner}')}" if kind else "joints"
            raise InputError(source, place, f"{key} holds a number {WITHOUT_MEASURE}")
    if not (np.abs(model.opt.gravity) < LARGEST).all():
        raise InputError(source, "option", f"gravity holds a number {WITHOUT_MEASURE}")


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
