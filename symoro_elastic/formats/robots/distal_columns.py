"""The columns of a table of standard Denavit-Hartenberg parameters, a row each."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class DistalColumn:
    """One column: what it means, its unit, what it is where it is left out, and an example of its cell."""

    name: str
    unit: str
    default: str
    meaning: str
    example: str
    is_nonnegative: bool = False


SCALES = {"rad": {"deg": math.pi / 180}, "m": {"mm": 1e-3}}
"""Units that a header may name instead, with what their numbers are multiplied by."""
TYPES = {"R": 0, "P": 1, "revolute": 0, "prismatic": 1}
"""Words for the type of a joint, with its sigma."""


def _inertia(name: str) -> DistalColumn:
    what = f"entry {name[1:]} of the inertia tensor about the centre of mass, in the frame of the link"
    return DistalColumn(name, "kg m2", "0", what, "0.01")


def _center(name: str) -> DistalColumn:
    what = f"coordinate {name[1]} of the centre of mass, in the frame of the link"
    return DistalColumn(name, "m", "0", what, "-0.1")


COLUMNS = (
    DistalColumn("name", "", "joint1 ...", "name of the joint", "elbow"),
    DistalColumn("type", "", "R", f"type of the joint: {', '.join(TYPES)}", "P"),
    DistalColumn("theta", "rad", "0", "angle about z; of a revolute joint the offset of its variable", "pi/2"),
    DistalColumn("d", "m", "must be given", "distance along z; of a prismatic joint the offset of its variable", "0.4"),
    DistalColumn("a", "m", "must be given", "distance along x", "0.425"),
    DistalColumn("alpha", "rad", "must be given", "angle about x", "-pi/2"),
    DistalColumn("mass", "kg", "0", "mass of the link", "8.4", is_nonnegative=True),
    *map(_center, ("cx", "cy", "cz")),
    *map(_inertia, ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")),
    DistalColumn("rotor_inertia", "kg m2", "0", "inertia of the rotor about its own axis", "2e-4", is_nonnegative=True),
    DistalColumn("ratio", "", "1", "rotor turns per joint turn, rad/m where it slides", "100"),
    DistalColumn("viscous", "N m s/rad", "0", "viscous friction of the joint", "0.8", is_nonnegative=True),
    DistalColumn("coulomb", "N m", "0", "dry friction of the joint", "1.5", is_nonnegative=True),
)
