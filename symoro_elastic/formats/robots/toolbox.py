"""Robots of the Robotics Toolbox for Python, read by attributes: the toolbox need not be installed.

A robot of Denavit-Hartenberg rows (`DHRobot`) is read row by row, one that was read from a URDF by that file. What
has neither is refused: a chain of elementary transforms (`ETS`, `ELink`), of screws (`PoERobot`).
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from symoro_elastic.formats.files import load_text, name_of
from symoro_elastic.formats.robots import urdf
from symoro_elastic.formats.robots.modified_dh import machine_of
from symoro_elastic.formats.robots.robot import Description, JointType, Link, LinkJoint, Placement
from symoro_elastic.formats.robots.standard_dh import BASE, GRAVITY, TOOL, DistalLink, describe_links
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.described import DescribedMachine
from symoro_elastic.machine.names import NONE, Reasons, quote
from symoro_elastic.machine.valid_names import with_valid_names

OF_ROWS = ("a", "d", "alpha", "theta", "offset", "sigma")
"""Attributes of links with Denavit-Hartenberg parameters; a link has some."""
WORLD = "world"


def of_robot(robot: Any, name: str = "", reserved: Reasons = NONE) -> DescribedMachine:
    """Convert a robot of the Robotics Toolbox, or an object with the same attributes of `links`, to a machine.

    These are a, d, alpha, theta, offset, sigma (0 revolute, 1 prismatic), mdh, flip, m, r, I, Jm, G, B, Tc; without one
    it is zero. `base`, `tool` and `gravity` of the robot are taken too: the acceleration of gravity in axes of the
    world, in which the base is placed. Friction and rotors are on the side of the motor, G their turns for one of the
    joint. Where the robot has a `urdf_string`, or a `urdf_filepath` that is a URDF, that is read. `reserved` are names
    that generated code uses. Raises `InputError` that names the link.
    """
    title = name or str(getattr(robot, "name", "") or "robot")
    text = _urdf_of(robot, title)
    described = _of_urdf(robot, text, title) if text else _of_rows(robot, title)
    return with_valid_names(machine_of(described, title), reserved)


def _urdf_of(robot: Any, title: str) -> str:
    """The text of the URDF that a robot was read from; empty without one."""
    text = getattr(robot, "urdf_string", "") or ""
    path = Path(str(getattr(robot, "urdf_filepath", "") or ""))
    if text or path.suffix != ".urdf":
        return str(text)
    try:
        return load_text(path)
    except InputError as error:
        raise InputError(title, "urdf_filepath", f"{quote(path)} cannot be read: {error.what}") from None


def _of_urdf(robot: Any, text: str, title: str) -> Description:
    """The robot of a URDF, placed in the world by `base` of the robot, under its gravity."""
    described = replace(urdf.describe(text, title), name=name_of(title), gravity=_gravity(robot, title))
    if not _is_none(_placement(getattr(robot, TOOL, None), title, TOOL)):
        what = "a robot of a URDF may have several ends: write its tool into the URDF, as a link on a fixed joint"
        raise InputError(title, TOOL, what)
    base = _placement(getattr(robot, BASE, None), title, BASE)
    if _is_none(base):
        return described
    children = {joint.child for joint in described.joints}
    roots = [link.name for link in described.links if link.name not in children]
    mount = LinkJoint(f"{WORLD} joint", JointType.FIXED, f"{WORLD} of {roots[0]}", roots[0], base)
    return replace(described, links=(Link(mount.parent), *described.links), joints=(mount, *described.joints))


def _of_rows(robot: Any, title: str) -> Description:
    rows, remarks = [], []
    for k, link in enumerate(robot.links, start=1):
        row, remark = _row_of(link, f"joint{k}", title)
        rows.append(row)
        remarks += [remark] if remark else []
    base, tool = (_placement(getattr(robot, end, None), title, end) for end in (BASE, TOOL))
    described = describe_links(name_of(title), rows, base, tool, _gravity(robot, title))
    return replace(described, remarks=tuple(remarks))


def _row_of(link: Any, name: str, source: str) -> tuple[DistalLink, str]:
    """Row of a link, and a remark on attributes that are lost."""
    if not any(hasattr(link, key) for key in OF_ROWS):
        kind = type(link).__name__
        what = f"a {kind} has no Denavit-Hartenberg parameters ({', '.join(OF_ROWS)}): give a DHRobot, or a URDF file"
        raise InputError(source, name, what)

    def number(key: str, count: int = 1) -> Array:
        return _numbers(getattr(link, key, None), count, source, name, key)

    theta, d, a, alpha, offset, sigma, m, Jm, G, B = (
        float(number(key)[0]) for key in ("theta", "d", "a", "alpha", "offset", "sigma", "m", "Jm", "G", "B")
    )
    slides, turns = bool(sigma), abs(G)
    dry = number("Tc", 2)
    row = DistalLink(
        name,
        JointType.PRISMATIC if slides else JointType.REVOLUTE,
        theta if slides else theta + offset,
        d + offset if slides else d,
        *(a, alpha, m, number("r", 3), number("I", 9).reshape(3, 3)),
        rotor_inertia=Jm * turns**2,
        viscous=B * turns**2,
        coulomb=turns * float(dry[0] - dry[1]) / 2,
        modified=bool(getattr(link, "mdh", False)),
        flipped=bool(getattr(link, "isflip", False) or getattr(link, "flip", False)),
    )
    return row, f"{name}: dry friction differs by direction: its mean is taken" if dry[0] != -dry[1] else ""


def _numbers(value: Any, count: int, source: str, place: str, key: str) -> Array:
    """Attribute as finite numbers (count,); zeros for None."""
    try:
        numbers = np.zeros(count) if value is None else np.asarray(value, dtype=float).ravel()
    except (TypeError, ValueError):
        raise InputError(source, place, f"{key} = {quote(value)} is not a number") from None
    if numbers.size != count or not np.isfinite(numbers).all():
        raise InputError(source, place, f"{key} = {quote(value)} must be {count} finite numbers")
    return numbers


def _gravity(robot: Any, title: str) -> tuple[float, float, float]:
    """The acceleration of gravity in axes of the world, m/s2; 9.81 against z by default."""
    value = getattr(robot, "gravity", None)
    x, y, z = GRAVITY if value is None else _numbers(value, 3, title, "gravity", "it").tolist()
    return x, y, z


def _placement(end: Any, source: str, what: str) -> Placement:
    """Placement from a matrix or an object with a matrix `A`; the identity for None."""
    if end is None:
        return Placement()
    matrix = np.asarray(getattr(end, "A", end), dtype=float)
    if matrix.shape != (4, 4) or not np.isfinite(matrix).all():
        raise InputError(source, what, "must be a matrix (4, 4)")
    return Placement(matrix[:3, :3], matrix[:3, 3])


def _is_none(place: Placement) -> bool:
    return not (place.rotation - np.eye(3)).any() and not place.translation.any()
