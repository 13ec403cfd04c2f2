"""An MJCF model as MuJoCo compiles it: defaults, copies, angles and inertias of shapes resolved."""

from __future__ import annotations

import math
import re
import warnings
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath
from typing import Any
from xml.etree.ElementTree import Element

import numpy as np

from symoro_elastic.formats.files import MAX_BYTES, load_text
from symoro_elastic.formats.robots.robot import LARGEST
from symoro_elastic.formats.robots.xml_text import root_element
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.input_files import is_plain_file, read_file
from symoro_elastic.foundation.packages import import_optional
from symoro_elastic.machine.described import BodyShape
from symoro_elastic.machine.names import quote

MOST_COPIES = 1000
MOST_COPIED = 20_000
"""Elements that all <replicate> of a model make together."""
MOST_NUMBERS = 10_000_000
MOST_IN_MESH = 100
"""Of each of the first two numbers of a mesh that MuJoCo makes: how finely it is divided."""
EACH = ("nuserdata", "nkey", "nsample", "actdim", "dim")
"""Attributes that give some elements so many numbers each; those of <size> that begin with nuser_, too."""
FIELDS = ("hfield", "texture")
"""Elements that are fields of so many rows and columns."""
SEEN_ONLY = ("sensors", "keys", "pairs", "tuples", "numerics", "texts", "skins", "cameras", "lights", "textures")
"""Lists of what moves nothing and may be large, or name files."""

OLDEST = 4
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


@dataclass
class Sizes:
    """Element counts of a model: with copies, the copies alone, and the largest list of an element."""

    elements: int = 0
    copied: int = 0
    each: int = 0

    def add(self, element: Element, copies: int, file: str) -> None:
        """Count an element; raises `InputError` where a model is too large for a machine."""
        if copies > MOST_COPIES:
            raise InputError(file, "replicate", f"it makes more than {MOST_COPIES} copies: too many for a machine")
        self.elements += copies
        self.copied += copies if copies > 1 else 0
        if self.copied > MOST_COPIED:
            what = f"copies make more than {MOST_COPIED} elements: too many for a machine"
            raise InputError(file, "replicate", what)
        for name in element.attrib:
            if name.startswith("nuser_") or name in EACH:
                self.each = max(self.each, _number(element, name))
                self._refuse(self.each * self.elements, f"<{element.tag}> {name}", file)
        if element.tag in FIELDS:
            numbers = math.prod(max(_number(element, key), 1) for key in ("nrow", "ncol", "width", "height"))
            self._refuse(numbers, f"<{element.tag}>", file)
        self._refuse(self.each * self.elements, f"<{element.tag}>", file)
        _refuse_mesh(element, file)

    def _refuse(self, numbers: float, place: str, file: str) -> None:
        if numbers > MOST_NUMBERS:
            what = f"the model would hold more than {MOST_NUMBERS:.0e} numbers: give a smaller size"
            raise InputError(file, place, what)


def _refuse_mesh(element: Element, file: str) -> None:
    """Raise `InputError` for a mesh that MuJoCo would generate with too many triangles."""
    if element.tag == "mesh" and "builtin" in element.attrib:
        for word in element.get("params", "").split()[:2]:
            if _value(word) > MOST_IN_MESH:
                what = f"params divide it into more than {MOST_IN_MESH} parts: give less"
                raise InputError(file, "<mesh>", what)


def with_copies(root: Element, before: int) -> Iterator[tuple[Element, int]]:
    """Yield each element with the number of copies by the <replicate> elements around it."""
    waiting = [(root, before)]
    while waiting:
        element, times = waiting.pop()
        if element.tag == "replicate":
            times *= int(min(_number(element, "count", 1), MOST_COPIES + 1))
        yield element, times
        waiting += ((child, times) for child in reversed(element))


def _number(element: Element, key: str, default: int = 0) -> int:
    """Return the integer of an attribute, 0 for a negative one."""
    value = _value(element.get(key, "")) if element.get(key, "").strip() else default
    return int(min(value, 10**18))


def _value(word: str) -> float:
    """Return a number, infinite for another word that MuJoCo may accept as a number."""
    for read in (float, lambda text: float(int(text, 0))):
        try:
            value = read(word.strip())
        except (ValueError, OverflowError):
            continue
        return math.inf if math.isnan(value) else max(value, 0.0)
    return math.inf


@dataclass(frozen=True, eq=False)
class Compiled:
    """A compiled model: MuJoCo's `model`, and `mujoco` itself, the module with its constants.

    `name` is that of the file, empty where it gives none; `has_contacts` says that shapes may touch. `meshes` are those
    of shapes, by their numbers.
    """

    mujoco: Any
    model: Any
    name: str
    source: str
    has_contacts: bool
    meshes: Mapping[int, BodyShape]

    def error(self, place: str, what: str) -> InputError:
        """The error to raise about one place of the model."""
        return InputError(self.source, place, what)


def mujoco_model(text: str, source: str) -> Compiled:
    """Compile an MJCF text by MuJoCo; raises `InputError`.

    Shapes are dropped where they give no inertia, so their files are not needed.
    """
    sources = sources_of(text, source)
    mujoco = _mujoco()
    try:
        with _in_silence(mujoco):
            spec = mujoco.MjSpec.from_string(sources.text, include=sources.parts)
            spec.compiler.LRopt.mode = mujoco.mjtLRMode.mjLRMODE_NONE  # ranges of muscles are not needed, and take time
            has_contacts = any(geom.contype or geom.conaffinity for geom in spec.geoms)
            _drop_what_is_seen_only(spec)
            dropped = [*_drop_shapes(spec, mujoco)]
            _take_meshes(spec, sources)
            model = spec.compile()
            meshes = {geom.id: mesh for geom, mesh in dropped if geom.id >= 0}
    except (ValueError, RuntimeError, mujoco.FatalError) as error:
        raise _said(str(error), source) from None
    _refuse_without_measure(model, source)
    name = "" if spec.modelname == "MuJoCo Model" else spec.modelname
    return Compiled(mujoco, model, name, source, has_contacts, meshes)


def _mujoco() -> Any:
    """Return the package mujoco; raises `InputError` for a version that does not distinguish linear springs."""
    mujoco = import_optional("mujoco", "reading MJCF", "mjcf")
    if int(mujoco.__version__.partition(".")[0]) < OLDEST:
        what = f"version {mujoco.__version__} is installed, reading MJCF needs {OLDEST}: pip install -U mujoco"
        raise InputError("symoro-elastic", "mujoco", what)
    return mujoco


@contextmanager
def _in_silence(mujoco: Any) -> Iterator[None]:
    """Context in which MuJoCo's warnings are neither printed nor written to a file in the working folder."""
    before = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(lambda _: None)
    try:
        with warnings.catch_warnings(action="ignore"):
            yield
    finally:
        mujoco.set_mju_user_warning(before)


def _refuse_without_measure(model: Any, source: str) -> None:
    """Raise `InputError` for infinite and huge numbers, which MuJoCo accepts."""
    for array, (kind, key) in READ.items():
        for k in np.argwhere(~(np.abs(getattr(model, array)) < LARGEST))[:1, 0]:
            owner = model.dof_jntid[k] if array.startswith("dof") else k
            place = f"{kind} {quote(getattr(model, kind)(int(owner)).name or f'number {owner}')}" if kind else "joints"
            raise InputError(source, place, f"{key} holds a number {WITHOUT_MEASURE}")
    if not (np.abs(model.opt.gravity) < LARGEST).all():
        raise InputError(source, "option", f"gravity holds a number {WITHOUT_MEASURE}")


def _said(message: str, source: str) -> InputError:
    """Return MuJoCo's message as an error of one line, with the line of the file if the message has one."""
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


def _drop_shapes(spec: Any, mujoco: Any) -> Iterator[tuple[Any, BodyShape]]:
    """Yield shapes from files with their meshes; a point replaces each, unless inertia needs it.

    Shapes without mass and mesh, and height fields, are deleted.
    """
    files = _files_of(spec, mujoco)
    of_shapes = spec.compiler.inertiafromgeom == mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_TRUE
    least, most = spec.compiler.inertiagrouprange
    for geom in list(spec.geoms):
        is_read = geom.meshname or geom.hfieldname
        body = geom.parent
        has_inertia = body.name == "world" or (body.explicitinertial and not of_shapes)
        is_seen = geom.type == mujoco.mjtGeom.mjGEOM_MESH and geom.meshname in files and np.isnan(geom.fromto[0])
        if is_seen:
            yield geom, files[geom.meshname]
        if is_read and (has_inertia or geom.mass == 0 or not least <= geom.group <= most):
            if is_seen:
                geom.type, geom.meshname, geom.size, geom.mass = mujoco.mjtGeom.mjGEOM_SPHERE, "", [1.0, 0.0, 0.0], 0.0
            else:
                spec.delete(geom)
    for heights in list(spec.hfields):
        spec.delete(heights)


def _files_of(spec: Any, mujoco: Any) -> dict[str, BodyShape]:
    """Meshes from files by name, with their scales and reference points; no file is opened."""
    meshes = {}
    for mesh in spec.meshes:
        path = PurePosixPath(mesh.file)
        if mesh.file:
            turned = np.zeros(9)
            mujoco.mju_quat2Mat(turned, np.asarray(mesh.refquat) / np.linalg.norm(mesh.refquat))
            points = np.eye(4)
            points[:3, :3] = np.diag(mesh.scale) @ turned.reshape(3, 3).T
            points[:3, 3] = -points[:3, :3] @ mesh.refpos
            meshes[mesh.name or path.stem] = BodyShape(points, _path_of(spec, mesh.file))
    return meshes


def _path_of(spec: Any, file: str) -> str:
    """Path of a mesh file, relative to the folder of the model."""
    path = PurePosixPath(file)
    return path.name if spec.strippath else str(PurePosixPath(spec.compiler.meshdir) / path)


def _take_meshes(spec: Any, sources: Sources) -> None:
    """Load the meshes that inertias require, and delete the others."""
    needed = {geom.meshname: geom.parent.name for geom in spec.geoms if geom.meshname}
    for k, mesh in enumerate(list(spec.meshes)):
        path = PurePosixPath(mesh.file)
        mesh.name = mesh.name or path.stem
        if mesh.name not in needed:
            spec.delete(mesh)
        elif mesh.file:
            content = sources.shape(_path_of(spec, mesh.file), needed[mesh.name])
            mesh.file = f"mesh{k}{path.suffix}"
            spec.assets[mesh.file] = content


MOST_PARTS, MOST_SHAPE_BYTES = 100, 100_000_000
OTHER_ROOTS = {
    "robot": "this is a URDF: give it the suffix .urdf",
    "sdf": "SDF is not read: write it as URDF or MJCF",
    "mujocoinclude": "it is a part of a model: read the file that includes it",
}
DEFORMABLE = {"flexcomp", "flex", "composite"}


@dataclass
class Sources:
    """Texts of a model and of its included files, by their paths relative to its folder."""

    text: str
    path: str
    parts: dict[str, bytes] = field(default_factory=dict)
    sizes: Sizes = field(default_factory=Sizes)

    @property
    def folder(self) -> Path:
        """Folder of the model; no file outside it is read."""
        return Path(self.path).resolve().parent

    def shape(self, name: str, needed_by: str) -> bytes:
        """Return the content of the file of a shape; raises `InputError` that names what needs it."""
        remedy = f"body {quote(needed_by)} has no <inertial>, so its shape gives its mass: add an <inertial>"
        file = self._inside(name, f"mesh {quote(name)}", remedy)
        if not is_plain_file(file):
            raise self.error(f"mesh {quote(name)}", f"no such file; {remedy}, or the file")
        content = read_file(file, most=MOST_SHAPE_BYTES + 1)
        if len(content) > MOST_SHAPE_BYTES:
            raise self.error(f"mesh {quote(name)}", f"larger than {MOST_SHAPE_BYTES // 10**6} MB; {remedy}")
        return content

    def error(self, place: str, what: str) -> InputError:
        """Return the error about one place of the file."""
        return InputError(self.path, place, what)

    def _inside(self, name: str, place: str, remedy: str) -> Path:
        """Return the resolved path of a file in the folder of the model; raises `InputError` for one outside."""
        try:
            file = (self.folder / name).resolve()
        except (OSError, ValueError, RuntimeError):
            raise self.error(place, "this is not the path of a file") from None
        if not file.is_relative_to(self.folder):
            raise self.error(place, f"it is outside the folder of the model, where nothing is read: {remedy}")
        return file

    def include(self, name: str, by: str) -> tuple[str, str]:
        """Return the relative path and the text of a file included by the file `by`."""
        place = f"include {quote(name)}"
        remedy = "copy it into the folder"
        sibling = str(PurePosixPath(by).parent / name)
        for path in dict.fromkeys((name, sibling)):
            file = self._inside(path, place, remedy)
            if is_plain_file(file):
                return path, load_text(file)
        raise self.error(place, f"no such file next to {quote(Path(self.path).name)}")


def sources_of(text: str, path: str) -> Sources:
    """Return the texts of a model and of its included files; raises `InputError` for unreadable ones."""
    sources = Sources(text, path)
    root = root_element(text, path)
    if root.tag != "mujoco":
        what = OTHER_ROOTS.get(root.tag, f"its root element is <{quote(root.tag)[1:-1]}>, that of MJCF is <mujoco>")
        raise sources.error("file", what)
    _take(root, path, "", sources)
    return sources


def _take(root: Element, file: str, path: str, sources: Sources, copies: int = 1) -> None:
    """Count the elements of a file and of its included files, which are added; reject unsupported ones."""
    for element, times in with_copies(root, copies):
        _refuse(element, file)
        sources.sizes.add(element, times, file)
        if element.tag == "include":
            _include(element, path, sources, times)


def _include(element: Element, by: str, sources: Sources, copies: int) -> None:
    name = element.get("file", "")
    place = f"include {quote(name)}"
    if not name:
        raise sources.error("include", "it names no file")
    path, text = sources.include(name, by)
    if any(PurePosixPath(path).name == PurePosixPath(other).name for other in sources.parts):
        raise sources.error(place, "a file is included once, and MuJoCo knows it by its name: rename or remove one")
    sources.parts[path] = text.encode()
    if len(sources.parts) > MOST_PARTS or sum(map(len, sources.parts.values())) > MAX_BYTES:
        raise sources.error(place, f"at most {MOST_PARTS} files of {MAX_BYTES // 10**6} MB together are read")
    file = str(Path(sources.path).parent / path)
    _take(root_element(text, file), file, path, sources, copies)


def _refuse(element: Element, file: str) -> None:
    """Raise `InputError` for elements of models that are not trees of rigid bodies."""
    if element.tag in DEFORMABLE:
        raise InputError(file, f"<{element.tag}>", "it makes deformable bodies: only rigid ones are modelled")
    if element.tag == "plugin":
        raise InputError(file, "<plugin>", "forces of plugins are not modelled: remove it")
    if element.tag == "model" and "file" in element.attrib:
        what = "it attaches another model: let MuJoCo write both into one file, and read that"
        raise InputError(file, f"model {quote(element.attrib['file'])}", what)
