"""Robots that are changed before their table is made."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from functools import partial
from importlib import import_module
from typing import TYPE_CHECKING

from symoro_elastic.formats.files import UTF_8, WESTERN
from symoro_elastic.formats.format import Conversion, Format, SpringOnJoint
from symoro_elastic.formats.robots.modified_dh import Deviation, table_of
from symoro_elastic.formats.robots.robot import Description, JointType, Link, LinkJoint, Placement
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine import format_names
from symoro_elastic.machine.described import DescribedMachine
from symoro_elastic.machine.format_names import FormatName
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.names import no_such, quote

if TYPE_CHECKING:
    from symoro_elastic.formats.robots.robot import Description


def machine_with_changes(description: Description, source: str, conversion: Conversion) -> DescribedMachine:
    """Convert a robot to a machine with the changes of a conversion; raises `InputError`.

    Where angles and lengths are snapped, a remark says how far frames are from those of the robot, and how far those of
    the exact table are.
    """
    robot = with_springs(description, conversion.springs, source)
    exact = table_of(robot, source)
    if conversion.snap is None:
        return exact.machine
    snapped = table_of(robot, source, conversion.snap)
    remark = (
        f"angles and lengths are snapped within {conversion.snap:g}: frames at position 0 are up to "
        f"{_deviation_text(snapped.deviation)} off; those of the exact table {_deviation_text(exact.deviation)}"
    )
    return snapped.machine.with_remarks(remark)


def _deviation_text(deviation: Deviation) -> str:
    return f"{deviation.rotation:.1e} rad and {deviation.translation:.1e} m"


SPRING, ROTOR = "_spring", "_rotor"


def with_springs(description: Description, springs: Mapping[str, SpringOnJoint], source: str) -> Description:
    """Return the robot with springs between motor and load of some joints; raises `InputError`.

    The motor keeps the name of the joint, its friction and its rotor; the spring is that name with `_spring` and
    carries the link. Both turn about, or move along, the axis of the joint.
    """
    for name, spring in springs.items():
        _refuse(description, name, spring, source)
    links = tuple(Link(name + ROTOR) for name in springs)
    joints = tuple(part for joint in description.joints for part in _split(joint, springs.get(joint.name)))
    return replace(description, links=(*description.links, *links), joints=joints)


def _split(joint: LinkJoint, spring: SpringOnJoint | None) -> Iterator[LinkJoint]:
    if spring is None:
        yield joint
        return
    rotor = joint.rotor_inertia if spring.rotor_inertia is None else spring.rotor_inertia
    yield replace(joint, child=joint.name + ROTOR, rotor_inertia=rotor)
    yield LinkJoint(
        joint.name + SPRING,
        joint.type,
        joint.name + ROTOR,
        joint.child,
        Placement(),
        joint.axis,
        stiffness=spring.stiffness,
        driven=False,
    )


def _refuse(description: Description, name: str, spring: SpringOnJoint, source: str) -> None:
    """Raise `InputError` for a joint that cannot have a spring between motor and load."""
    joints = {joint.name: joint for joint in description.joints if joint.type is not JointType.FIXED}
    joint = joints.get(name)
    if joint is None:
        raise InputError(source, "--elastic", no_such("moving joint", name, joints))
    place = f"joint {quote(name)}"
    if not 0 < spring.stiffness < math.inf or not 0 <= (spring.rotor_inertia or 0) < math.inf:
        raise InputError(source, place, f"--elastic {name}: stiffness and inertia of the rotor must be positive")
    if joint.follows or not joint.driven or joint.type is JointType.FLOATING:
        raise InputError(source, place, "it has no motor: --elastic splits a joint into its motor and a spring")
    followers = [other.name for other in joints.values() if other.follows and other.follows.joint == name]
    if followers:
        what = f"joint {quote(followers[0])} follows it: whether motor or link is not known; split it by hand"
        raise InputError(source, place, what)
    if not joint.rotor_inertia and not spring.rotor_inertia:
        what = f"its motor would have no inertia: give --elastic {name}=K:IA, IA in kg m2, or kg where it slides"
        raise InputError(source, place, what)
    used = {link.name for link in description.links} | {other.name for other in description.joints}
    for new in (name + SPRING, name + ROTOR):
        if new in used:
            raise InputError(source, place, f"the name {quote(new)}, which its spring gets, is taken")


def _describe(module: str, text: str, source: str) -> Description:
    """The robot in a text, read by the function `describe` of a module of this folder."""
    describe: Callable[[str, str], Description] = import_module(f"{__package__}.{module}").describe
    return describe(text, source)


def _read(module: str, text: str, source: str) -> DescribedMachine:
    """The machine of the robot in a text, by an exact table of modified DH parameters."""
    from symoro_elastic.formats.robots.modified_dh import machine_of

    return machine_of(_describe(module, text, source), source)


def _write(module: str, machine: Machine) -> str:
    """The text of a machine, written by the function `write` of a module of this folder."""
    write: Callable[[Machine], str] = import_module(f"{__package__}.{module}").write
    return write(machine)


def _format(named: FormatName, module: str, write: Callable[[Machine], str] | None = None) -> Format:
    describe, read = partial(_describe, module), partial(_read, module)
    return Format(named, read, write, (UTF_8, WESTERN), describe)


URDF = _format(format_names.URDF, "urdf", partial(_write, "urdf_writing"))
MJCF = _format(format_names.MJCF, "mjcf", partial(_write, "mjcf_writing"))
DISTAL = _format(format_names.DISTAL, "standard_dh")
