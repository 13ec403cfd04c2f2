"""MuJoCo: the same machine as MJCF, its shipped library called from C.

Inverse: mj_kinematics, mj_comPos, mj_comVel, mj_rne and the rotor inertias, which is what torques need; direct:
mj_forward without contacts and constraints. Its bodies must have mass, so joints of massless bodies are put on the
next body that has some, their axes seen from there.
"""

from __future__ import annotations

import ctypes
import importlib.util
from functools import cache
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

from symoro_elastic.machine.machine import Kind, Machine
from tests.benchmarks.contest import MARCH, Array, Contestant, compiled, entry, keeping_results
from tests.references.numbers_of_machine import JointNumbers
from tests.references.pinocchio_model import model_of

HERE = Path(__file__).parent
FUNCTIONS = {"inverse_dynamics": ("inverse", "mj_rne"), "direct_dynamics": ("direct", "mj_forward")}
OFF = ("contact", "constraint", "equality", "limit", "frictionloss", "actuation")


@cache
def library() -> ctypes.CDLL:
    found = importlib.util.find_spec("mujoco")
    assert found and found.submodule_search_locations
    folder = Path(next(iter(found.submodule_search_locations)))
    shipped = next(folder.glob("libmujoco.so*"))
    command = ["gcc", "-O3", MARCH, "-fPIC", "-shared", f"-isystem{folder / 'include'}"]
    source = {"mujoco_c.c": (HERE / "mujoco_c.c").read_text(encoding="utf-8")}
    return ctypes.CDLL(str(compiled(command, source, [str(shipped), f"-Wl,-rpath,{folder}"])))


def contestant(file: Path, machine: Machine, model: str, x: Array) -> Contestant:
    """`inverse_dynamics` or `direct_dynamics` on the states of `x`."""
    import mujoco

    compiled_model = mujoco.MjModel.from_xml_string(mjcf(machine))
    mujoco.mj_saveModel(compiled_model, str(file))
    kinds = [machine.joints[j - 1].kind for j in machine.independent]
    motors = [k for k, kind in enumerate(kinds) if kind is Kind.MOTOR]
    dofs = (ctypes.c_int * len(motors))(*motors)
    assert library().read_model(str(file).encode(), dofs, len(motors)), "MuJoCo cannot read its model"
    function, name = FUNCTIONS[model]
    return keeping_results(f"MuJoCo {name}", entry(library(), function), x, len(kinds), keep=dofs)


def mjcf(machine: Machine) -> str:
    """The machine as MJCF; frames of bodies are those of the table at q = 0."""
    model, _, numbers = model_of(machine)
    root = ElementTree.Element("mujoco")
    ElementTree.SubElement(root, "compiler", angle="radian", boundmass="0", autolimits="false")
    option = ElementTree.SubElement(root, "option", gravity=_text(model.gravity.linear))
    ElementTree.SubElement(option, "flag", dict.fromkeys(OFF, "disable"))
    elements = {0: ElementTree.SubElement(root, "worldbody")}
    waiting: dict[int, tuple[Any, list[tuple[int, Any]]]] = {}
    rows = [numbers.joints[j] for j in numbers.moving]
    for joint in range(1, model.njoints):
        parent, place = model.parents[joint], model.jointPlacements[joint]
        origin, joints = waiting.get(parent, (type(place).Identity(), []))
        here = origin * place
        joints = [(k, place.inverse() * axis) for k, axis in joints] + [(joint, type(place).Identity())]
        if not model.inertias[joint].mass:
            waiting[joint] = here, joints
            elements[joint] = elements[parent]
            continue
        elements[joint] = _body(elements[parent], here, model.inertias[joint])
        for k, axis in joints:
            _joint(elements[joint], rows[k - 1], axis)
    return ElementTree.tostring(root, encoding="unicode")


def _body(parent: ElementTree.Element, place: Any, inertia: Any) -> ElementTree.Element:
    quaternion = _quaternion(place.rotation)
    body = ElementTree.SubElement(parent, "body", pos=_text(place.translation), quat=_text(quaternion))
    tensor = inertia.inertia
    six = (tensor[0, 0], tensor[1, 1], tensor[2, 2], tensor[0, 1], tensor[0, 2], tensor[1, 2])
    about = {"pos": _text(inertia.lever), "mass": repr(float(inertia.mass)), "fullinertia": _text(six)}
    ElementTree.SubElement(body, "inertial", about)
    return body


def _joint(body: ElementTree.Element, row: JointNumbers, axis: Any) -> None:
    """A joint on a body, where its axis is at q = 0; the law of its spring, the inertia of its rotor."""
    law = {"stiffness": row.stiffness, "damping": row.damping, "springref": row.neutral, "armature": row.rotor_inertia}
    texts = {name: repr(float(value)) for name, value in law.items()}
    kind = {
        "type": "slide" if row.sigma else "hinge",
        "pos": _text(axis.translation),
        "axis": _text(axis.rotation[:, 2]),
    }
    ElementTree.SubElement(body, "joint", kind | texts)


def _quaternion(rotation: Array) -> list[float]:
    import pinocchio as pin

    x, y, z, w = pin.Quaternion(rotation).coeffs()
    return [w, x, y, z]


def _text(numbers: Any) -> str:
    return " ".join(repr(float(x)) for x in numbers)
