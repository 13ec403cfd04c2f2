"""The keys of a .par file, a row each: numbers, and lists of joints, of bodies and of the base."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from enum import Enum

from symoro_elastic.machine.columns import cells
from symoro_elastic.machine.machine import Base, Joint, Kind


class Place(Enum):
    """Form of a key's value in a .par file (a number, or a list by frames, bodies or joints) and its subject."""

    NUMBER = "a number: `NJ = 6`"
    GEOMETRIC = "a list with an entry for each frame (NF): geometry"
    INERTIAL = "a list with an entry for each body (NL; one more for the base, where it floats): body"
    ACTING = "a list with an entry for each body (NL): forces"
    JOINT = "a list with an entry for each joint (NJ): law of the joint"
    BASE = "a list of 3 numbers or formulas: base"
    FRAME = "a list of 16 numbers: base"


@dataclass(frozen=True)
class ParKey:
    """A key of a .par file: its meaning, unit and default, and an example of its value."""

    name: str
    place: Place
    meaning: str
    example: str
    default: str = "0"
    unit: str = ""


def _of_columns() -> Iterator[tuple[str, str, str]]:
    """Key, meaning and unit of the .par columns of joints and of the base."""
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
)


def names(*places: Place) -> tuple[str, ...]:
    """The keys that belong in some places of a file."""
    return tuple(key.name for key in KEYS if key.place in places)
