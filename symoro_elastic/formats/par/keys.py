"""The keys of a .par file, a row each: lists of joints, of bodies and of the base, numbers, extension lines."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from enum import Enum

from symoro_elastic.machine.columns import cells
from symoro_elastic.machine.machine import Base, Joint, Kind


class Place(Enum):
    """Where a key of a .par file stands, and what it holds."""

    NUMBER = "a number: `NJ = 6`"
    GEOMETRIC = "a list with an entry for each frame (NF): geometry"
    INERTIAL = "a list with an entry for each body (NL; one more for the base, where it floats): body"
    ACTING = "a list with an entry for each body (NL): forces"
    JOINT = "a list with an entry for each joint (NJ): law of the joint"
    BASE = "a list of 3 numbers or formulas: base"
    FRAME = "a list of 16 numbers: base"
    EXTENSION = "a line `(*! key = value *)`, which SYMORO reads as a comment"


@dataclass(frozen=True)
class ParKey:
    """One key: what it means, its unit, what it is where it is left out, and an example of its value."""

    name: str
    place: Place
    meaning: str
    example: str
    default: str = "0"
    unit: str = ""


def _of_columns() -> Iterator[tuple[str, str, str]]:
    """Key, meaning and unit of the cells of a joint and of the base that have one."""
    for owner in (Joint("", 0, Kind.FIXED, 2), Base()):
        for cell, _ in cells(owner):
            column = cell.column
            part = f"{column.parts[cell.index]} of " if len(column.par) > 1 else ""
            meaning = column.meaning.split(":")[0] if part else column.meaning
            yield cell.par, part + meaning, " or ".join(dict.fromkeys(column.dimension.units))


_MEANINGS = {key: (meaning, unit) for key, meaning, unit in _of_columns()}


def _cells(place: Place, names: str, example: str) -> Iterator[ParKey]:
    for name in names.split():
        meaning, unit = _MEANINGS[name]
        yield ParKey(name, place, meaning, example.replace("@", name), unit=unit)


GEOMETRY = Place.GEOMETRIC
KEYS = (
    ParKey("NL", Place.NUMBER, "number of bodies", "3", "must be given"),
    ParKey(
        *(
            "NJ",
            Place.NUMBER,
            "number of joints: bodies and closed loops; rows NL + 1 to NJ are cut joints, without body",
        ),
        "3",
        "NL",
    ),
    ParKey(
        *("NF", Place.NUMBER, "number of frames, 2 NJ - NL; rows NJ + 1 to NF are the frames that the cut joints meet"),
        "3",
        "2 NJ - NL",
    ),
    ParKey(
        "Type",
        Place.NUMBER,
        "0 chain, 1 tree, 2 closed loops; kept, not used: a warning where NJ says otherwise",
        "0",
        "by `ant` and NJ",
    ),
    ParKey("is_floating", Place.NUMBER, "1 where the base floats and the wrench on it is known", "1"),
    ParKey("is_mobile", Place.NUMBER, "1 where the base floats and its acceleration is known", "0"),
    ParKey("ant", GEOMETRY, "row of the joint that carries this one; 0 is the base", "{0, 1, 2}", "must be given"),
    ParKey("sigma", GEOMETRY, "0 revolute, 1 prismatic, 2 fixed frame", "{0, 0, 2}", "must be given"),
    *_cells(GEOMETRY, "b d r gamma alpha", "{0, @2, 0}"),
    ParKey(
        *("mu", GEOMETRY, "1 where a motor drives the joint, 0 where it is passive, coupled, cut or fixed"),
        "{1, 1, 0}",
        "1, 0 in rows beyond NL",
    ),
    *_cells(GEOMETRY, "theta", "{th1, th2, 0}"),
    *_cells(Place.INERTIAL, "XX XY XZ YY YZ ZZ MX MY MZ M", "{@1, @2, 0}"),
    *_cells(Place.ACTING, "IA FV FS FX FY FZ CX CY CZ", "{@1, @2, 0}"),
    ParKey("eta", Place.JOINT, "1 where the joint is elastic", "{0, 1, 0}"),
    *_cells(Place.JOINT, "k", "{0, k2, 0}"),
    ParKey("QP", Place.JOINT, "joint velocities; kept, not used: they are arguments", "{qp1, qp2, 0}", "nothing"),
    ParKey("QDP", Place.JOINT, "joint accelerations; kept, not used", "{qdp1, qdp2, 0}", "nothing"),
    ParKey("GAM", Place.JOINT, "joint torques; kept, not used", "{GAM1, GAM2, 0}", "nothing"),
    *_cells(Place.BASE, "W0 WP0 V0 VP0", "{0, 0, 0}"),
    *_cells(Place.BASE, "G", "{0, 0, G3}"),
    ParKey("Z", Place.FRAME, "placement of frame 0, row by row; kept, not used", "{1, 0, 0, 0, ...}", "nothing"),
    ParKey("name", Place.EXTENSION, "name of the machine", "arm", "Robotname, or the name of the file"),
    ParKey("names", Place.EXTENSION, "names of the joints", "{shoulder, elbow, tip}", "j1, j2 ..."),
    ParKey(
        *("parameters", Place.EXTENSION, "names that are parameters, where they could be joint variables; their order"),
        "{L2, k2}",
        "all names but the joint variables",
    ),
    ParKey("values", Place.EXTENSION, "values of parameters", "{L2 = 0.35}", "none"),
    ParKey("units", Place.EXTENSION, "units of parameters, SI", "{L2 = m}", "none"),
    ParKey(
        *("variable", Place.EXTENSION, "joint variables, by joint, of cells in which several names may be meant"),
        "{nut = d_nut}",
        "the name in the cell that is new: no parameter, and no variable of another joint",
    ),
    ParKey(
        *("loops", Place.EXTENSION, "closed loops in the order of the cut joints: names, and the keys of TOML"),
        "{left = {closes = point, dependent = {th3, th8}, start = {th3 = 0.2}}, right = {}}",
        "loop_1, loop_2 ...; frames meet; passive joints are dependent",
    ),
    ParKey(
        *("start", Place.EXTENSION, "one rough position of all loops, by joint variable: it tells the branch"),
        "{th2 = -1.0, th3 = -0.27}",
        "none",
    ),
    ParKey(
        *("order", Place.EXTENSION, "names of all joints in the order of the table, where it is not that of the rows"),
        "{b1, pin, b2, pin_end}",
        "the order of the rows",
    ),
    *_cells(Place.EXTENSION, "damping neutral ratio sharing creep", "{0, @2, 0}"),
    ParKey(
        *("central", Place.EXTENSION, "bodies given about the centre of mass: x y z XX XY XZ YY YZ ZZ by joint"),
        "{elbow = {0.1, 0, 0, XX2, 0, 0, YY2, 0, ZZ2}}",
        "none",
    ),
    ParKey("notes", Place.EXTENSION, "remarks that are no plain comment", '{"!checked"}', "none"),
    ParKey("scene", Place.EXTENSION, "the scene, with the keys of TOML", "{models = {jacobian}}", "none"),
    ParKey("motion", Place.EXTENSION, "motions, with the keys of TOML", "{{start = {q1 = 0.1}, duration = 1}}", "none"),
    ParKey("wanted", Place.EXTENSION, "what is wanted, with the keys of TOML", "{period = 1e-3}", "none"),
    ParKey("extras", Place.EXTENSION, "entries of other formats", "{origin = workshop}", "none"),
    ParKey(
        *("orientation", Place.EXTENSION, "orientation of a base that floats: rotation or quaternion", "quaternion"),
        "rotation",
    ),
)


def names(*places: Place) -> tuple[str, ...]:
    """The keys that stand in some places."""
    return tuple(key.name for key in KEYS if key.place in places)
