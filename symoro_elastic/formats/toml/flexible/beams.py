"""The table [beams] of a machine file: beams as rigid pieces with elastic joints, as ordinary rows.

u is the direction of the beam, v and w those across it, in the order of a right-handed frame.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np

from symoro_elastic.formats.robots.joint_tree import QUARTER, about_x, about_z
from symoro_elastic.formats.toml import key as keys
from symoro_elastic.formats.toml.key import Key, Section, Type, one_of, reference_to
from symoro_elastic.formats.toml.tables import Table
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.machine.beams.beam import IN_SHEAR, MOST_MODES, TRANSVERSE, Beam
from symoro_elastic.machine.beams.errors import error_of_first
from symoro_elastic.machine.beams.places import FITTED, FITTED_BENDING, MOST_JOINTS, RULES
from symoro_elastic.machine.beams.sections import AXIAL, SIZES, TORSION, Piece, Profile, operand, product, section_of
from symoro_elastic.machine.formula import ZERO, Formula
from symoro_elastic.machine.joints import SELECTED
from symoro_elastic.machine.names import did_you_mean, quote
from symoro_elastic.machine.rounded_angles import multiple_of_pi

Entries = dict[str, Any]
HEADING = "beams"
END = "_end"
"""End of the name of the row that carries what the beam carries."""
AUTO, USUAL = "auto", 4
"""Joints that are chosen when the file is read, and those of any beam until then."""
STIFF = (1e7, 2e12)
"""Moduli of elasticity, Pa, from soft rubber to diamond."""
DENSE = (20, 23000)
"""Densities, kg/m3, from foam to osmium."""
WELL_FITTED = 0.06
"""Error of a first frequency above which fitted joints are doubted: one joint of torsion has up to 0.05 in a taper."""
STEEPEST = 20
"""Ratio of sizes at both ends of a piece up to which polynomials resolve EI, the fourth power of sizes."""
SLENDER = 5
"""Length by size of the section below which shear lowers the first frequency by 2 % (bars) to 4 % (thin tubes)."""


def _sizes(table: Table, key: str) -> tuple[str, tuple[Formula, ...]]:
    """Shape and dimensions of a cross-section."""
    sizes = replace(table.table(key), units="m").only(SIZES)
    if len(sizes.entries) != 1:
        raise table.fail(key, f"must be one of {', '.join(SIZES)}, as {{ tube = [0.12, 0.1] }}")
    (kind,) = sizes.entries
    if SIZES[kind] == 1:
        return kind, (sizes.formula(kind),)
    return kind, sizes.formulas(kind, (SIZES[kind],))


def _joints(table: Table, key: str) -> int:
    return USUAL if table.entries[key] == AUTO else table.whole(key)


def _list(title: str, length: int) -> Mapping[str, Any]:
    return {"type": "array", "items": reference_to(title), "minItems": length, "maxItems": length}


_SIZES = {kind: reference_to("formula") if n == 1 else _list("formula", n) for kind, n in SIZES.items()}
SIGNED = tuple(sign + axis for axis in TRANSVERSE for sign in ("", "-"))
ALONG = Key("along", one_of(SIGNED), "direction of the beam, in the frame of its row", '"x"')
LENGTH = Key(
    "length", keys.FORMULA, "length of the beam, or of the piece", '"1.2 m"', otherwise="that of pieces", unit="m"
)
OF_SECTION = Type(
    "table of a section",
    {"type": "object", "properties": _SIZES, "additionalProperties": False, "minProperties": 1, "maxProperties": 1},
    _sizes,
)
SECTION = Key(
    "section",
    OF_SECTION,
    "section: rod, its diameter; tube, outer and inner diameter; bar, its two sides; box, its two sides and its wall. "
    "Sides are along those of x, y, z that are across the beam, in this order",
    '{ tube = ["120 mm", 0.1] }',
    otherwise="EI, GJ, EA and mass_per_length instead",
)
END_SECTION = Key(
    "end_section",
    OF_SECTION,
    "section at the end, of the same kind: sizes are numbers, and change linearly in between",
    '{ tube = ["80 mm", 0.07] }',
    otherwise="section",
)
PIECES = Key(
    "pieces",
    Section("pieces", "", (LENGTH, SECTION, END_SECTION), rows=True).type,
    "pieces of the beam from its root, each with length, section and end_section, in numbers, in place of the beam's",
    "[{ length = 0.5, section = { rod = 0.1 } }, { length = 0.3, section = { rod = 0.08 } }]",
    otherwise="length and section",
)
MODULUS = Key("E", keys.FORMULA, "modulus of elasticity", '"210 GPa"', otherwise="needed with section", unit="N/m2")
SHEAR = Key("G", keys.FORMULA, "shear modulus, for torsion", '"81 GPa"', otherwise="E/2.6", unit="N/m2")
DENSITY = Key("density", keys.FORMULA, "density", "7850", otherwise="needed with section", unit="kg/m3")
BENDING = Key(
    "EI",
    Type(
        "number or formula, or two of them",
        {"anyOf": [reference_to("formula"), _list("formula", 2)]},
        lambda table, key: table.formulas(key, (2,)) if isinstance(table.entries[key], list) else (table.formula(key),),
    ),
    "bending stiffness, or those of deflections in both directions across the beam, in the order of x, y, z",
    "[2.1e4, 5e3]",
    otherwise="that of section",
    unit="N m2",
)
OF_TORSION = Key("GJ", keys.FORMULA, "stiffness of torsion", "3e3", otherwise="that of section", unit="N m2")
OF_TENSION = Key("EA", keys.FORMULA, "stiffness of tension", "4e7", otherwise="that of section", unit="N")
OF_SHEAR = Key(
    "kGA",
    BENDING.type,
    "stiffness in shear, or those of deflections in both directions across the beam, in the order of x, y, z; the "
    "beam is given in numbers then",
    "[4e7, 3e7]",
    otherwise="with shear that of section",
    unit="N",
)
IN_SHEARING = Key(
    "shear",
    keys.TRUTH,
    "whether sections yield in shear (Timoshenko), by G and their area with the factor of Cowper (1966); half as many "
    "slides NAME_shear_y1 ... as bending joints have this compliance. The beam is given in numbers then",
    "true",
    default=False,
    otherwise="false, but with kGA",
)
LINE_MASS = Key("mass_per_length", keys.FORMULA, "mass per length", "12", otherwise="that of section", unit="kg/m")
LINE_INERTIA = Key(
    *("inertia_per_length", keys.FORMULA, "inertia about the axis of the beam, per length", "0.02"),
    otherwise="that of section",
    unit="kg m",
)
DAMPING = Key(
    "damping",
    keys.FORMULA,
    "damping ratio at the first frequency of every kind of deflection, with the root clamped and the tip free; of a "
    "lower frequency it is lower in proportion",
    "0.01",
    default=ZERO,
)
JOINTS = Key(
    "joints",
    Type('whole number, or "auto"', {"anyOf": [{"type": "integer", "minimum": 1}, {"const": AUTO}]}, _joints),
    "number of bending joints in each direction; fitted has 2 to 5. Torsion and tension have half as many. auto: the "
    "fewest that give frequencies up to `up_to` within `tolerance`, by the load at the end and what the root is on",
    "4",
    default=USUAL,
)
UP_TO = Key(
    *("up_to", keys.NUMBER, "highest frequency that the joints of auto are for", '"300 Hz"'),
    otherwise="none: auto is 4 joints",
    unit="Hz",
)
TOLERANCE = Key(
    *("tolerance", keys.NUMBER, "relative error of frequencies and tip compliance with auto", "0.005"), default=0.01
)
MODES = Key(
    *("modes", Type("whole number", {"type": "integer", "minimum": 1}, lambda table, key: table.whole(key))),
    "number of modes in each direction, in place of joints: small deflections; of torsion and tension half as many",
    "3",
    default=0,
    otherwise="joints",
)
STIFFENING = Key(
    *("stiffening", keys.TRUTH),
    "whether tension and turning stiffen a beam by modes, and pressure weakens it",
    "true",
    default=False,
)
RULE = Key(
    *("rule", one_of(RULES), "where the joints are: fitted to frequencies, at the points of Gauss, or in equal pieces"),
    '"gauss"',
    default=FITTED,
)
BENDS = Key(
    "bends",
    keys.some_of([*TRANSVERSE, TORSION, AXIAL]),
    "kinds of deflection: in directions across the beam, torsion, axial",
    '["y", "z", "torsion", "axial"]',
    otherwise="both directions across the beam, and torsion if GJ or a section is given",
)
BEAMS = Section(
    "[beams]",
    "Beams, by the joint whose frame the root is fixed to. What that joint carries, and frames on it, are at "
    f"the end of the beam, the row NAME{END}; its body, motor and limits stay at the root. A beam becomes "
    "rows NAME_y1, NAME_z1, NAME_torsion1 ... of kind elastic, with rigid pieces between them.",
    (
        *(ALONG, LENGTH, SECTION, END_SECTION, PIECES, MODULUS, SHEAR, DENSITY, BENDING, OF_TORSION, OF_TENSION),
        *(
            OF_SHEAR,
            IN_SHEARING,
            LINE_MASS,
            LINE_INERTIA,
            DAMPING,
            JOINTS,
            UP_TO,
            TOLERANCE,
            RULE,
            MODES,
            STIFFENING,
            BENDS,
        ),
    ),
    "joint",
)


MAY_BE_ZERO = (LINE_MASS, LINE_INERTIA, DAMPING)
"""Keys of numbers that a beam may be without."""


def beam_of(table: Table, name: str, values: Mapping[str, float]) -> Beam:
    """Read the beam in an entry of [beams]; raises `InputError`.

    `values` are those of parameters: sections are checked by them as far as they have values.
    """
    table.only(BEAMS.names)
    _refuse_values(table, values)
    along, pieces = ALONG.read(table), _pieces(table)
    both = TRANSVERSE[along[-1]]
    is_by_section = SECTION.name in pieces[0].entries
    length, profile = _profile(table, pieces, values)
    properties = _of_section(table, pieces[0], both, values) if is_by_section else _of_cells(table, both)
    stiffness, mass, inertia, shear = properties
    usual = tuple(kind for kind in (*sorted(both), TORSION) if kind in stiffness)
    bends = tuple(dict.fromkeys(BENDS.read(table, usual)))
    for kind in bends:
        if kind not in (*both, TORSION, AXIAL):
            raise table.fail(BENDS.name, f"no deflection {quote(kind)} along {along}{did_you_mean(kind, stiffness)}")
        if kind not in stiffness:
            raise table.fail(BENDS.name, f"{kind} needs {'GJ' if kind == TORSION else 'EA'}, or a section and E")
    if TORSION in bends and TORSION not in inertia:
        raise table.fail(LINE_INERTIA.name, "is missing: torsion needs it, as 2*I*density; or give a section")
    modes, stiffening = _modes(table)
    rule, joints = RULE.read(table), JOINTS.read(table)
    least, most = (min(FITTED_BENDING), max(FITTED_BENDING)) if rule == FITTED else (1, MOST_JOINTS)
    if not least <= joints <= most:
        way = ': rule = "gauss" or "equal" have others' if rule == FITTED and joints > 0 else ""
        raise table.fail(JOINTS.name, f"{joints} is not from {least} to {most}, which the rule {rule} has{way}")
    inertia = {TORSION: "0", **dict.fromkeys(both, "0"), **inertia}
    damping = DAMPING.read(table).text
    doubts = tuple(_doubts(table, pieces, length, values)) if is_by_section else ()
    kind, sizes = SECTION.read(pieces[0]) if is_by_section else ("", ())
    section = (kind, tuple(size.text for size in sizes))
    numbers = (stiffness, mass, inertia, damping, rule, joints, bends, doubts, modes, stiffening)
    beam = Beam(name, along, length, *numbers, section=section, profile=profile, shear=shear)
    if modes and profile.pieces:
        raise table.fail(MODES.name, "modes are those of uniform beams: write joints for others")
    names = sorted({x for text in beam.cells for x in Formula.parse(text).names} - {"pi"}) if modes else []
    if names:
        what = f"modes are numbers of the file, and {quote(names[0])} is a name: write its value, or joints"
        raise table.fail(MODES.name, what)
    beam = _with_shear(table, beam) if shear else beam
    return replace(beam, doubts=(*doubts, *_doubts_of_fit(beam)))


def _doubts_of_fit(beam: Beam) -> Iterator[str]:
    """Warnings on kinds of deflection whose joints do not reproduce the first frequency."""
    for kind in beam.bends if beam.rule == FITTED and not beam.modes else ():
        if not beam.line(kind).is_uniform and (error := error_of_first(beam, kind)) > WELL_FITTED:
            what = f"joints of {kind} have an error of {100 * error:.2g} % in the first frequency"
            yield f'{what}: write more joints, or rule = "equal" with many'


def _with_shear(table: Table, beam: Beam) -> Beam:
    """Return the beam with numerical shear softness and gyration, which place its joints; `InputError` for names."""
    square = f"{operand(beam.length)}^2"
    softness = {x: product(beam.stiffness[x], over=(shear, square)) for x, shear in beam.shear.items()}
    gyration = {x: product(beam.inertia[x], over=(beam.mass, square)) for x in beam.shear}
    for text in (*softness.values(), *gyration.values()):
        for name in sorted(Formula.parse(text).names):
            what = f"with shear, places of joints follow from numbers, and {quote(name)} is a name: write its value"
            raise table.fail(IN_SHEARING.name if IN_SHEARING.name in table.entries else OF_SHEAR.name, what)
    both = ({kind: Formula.parse(text).value() for kind, text in texts.items()} for texts in (softness, gyration))
    of_shear, of_section = both
    return replace(beam, softness=of_shear, gyration=of_section)


def _pieces(table: Table) -> list[Table]:
    """Tables with length and section: those of the beam's pieces, or the beam's own."""
    if PIECES.name not in table.entries:
        return [table]
    for key in (LENGTH, SECTION, END_SECTION):
        if key.name in table.entries:
            raise table.fail(key.name, "follows from the pieces: remove one of the two")
    pieces = [replace(piece, place=f"{table.place}, piece {k}") for k, piece in enumerate(PIECES.read(table), start=1)]
    for piece in pieces:
        piece.only((LENGTH.name, SECTION.name, END_SECTION.name))
        if SECTION.name not in piece.entries:
            raise piece.fail(SECTION.name, "is missing")
    if not pieces:
        raise table.fail(PIECES.name, "is empty: give the length and the section of at least one piece")
    return pieces


def _profile(table: Table, pieces: list[Table], values: Mapping[str, float]) -> tuple[str, Profile]:
    """Length of a beam, and the profile of its sections along it."""
    for piece in pieces:
        if LENGTH.name not in piece.entries:
            raise piece.fail(LENGTH.name, "is missing")
        _refuse_values(piece, values)
    if PIECES.name not in table.entries and END_SECTION.name not in table.entries:
        return LENGTH.read(table).text, Profile()
    if SECTION.name not in pieces[0].entries:
        raise table.fail(END_SECTION.name, "needs a section: give that of the root")
    lengths = [LENGTH.read(piece) for piece in pieces]
    numbers = [_numbers(x, LENGTH, [y])[0] for x, y in zip(pieces, lengths, strict=True) if len(pieces) > 1] or [1.0]
    ends, parts = np.cumsum(numbers) / sum(numbers), list[Piece]()
    for end, piece in zip([*ends[:-1], 1.0], pieces, strict=True):
        kind, first = SECTION.read(piece)
        last_kind, last = END_SECTION.read(piece) if END_SECTION.name in piece.entries else (kind, first)
        if last_kind != kind:
            raise piece.fail(END_SECTION.name, f"is a {last_kind}, and the section is a {kind}: they need one kind")
        both = [_numbers(piece, key, x) for key, x in ((SECTION, first), (END_SECTION, last))]
        for key, sizes in zip((SECTION, END_SECTION), both, strict=True):
            if fault := _fault_of_section(kind, [*sizes]):
                raise piece.fail(key.name, fault)
        if max(max(a, b) / min(a, b) for a, b in zip(*both, strict=True)) > STEEPEST:
            what = f"sizes change more than {STEEPEST} times, which its integrals do not resolve: write several pieces"
            raise piece.fail(END_SECTION.name, what)
        parts.append(Piece(float(end), kind, *both))
    return lengths[0].text if len(lengths) == 1 else f"{sum(numbers):.15g}", Profile(tuple(parts))


def _numbers(table: Table, key: Key, cells: Sequence[Formula]) -> tuple[float, ...]:
    """Values of cells that hold no name."""
    for cell in cells:
        for name in sorted(cell.names):
            what = f"{quote(name)} is a name, and sections that change are numbers of the file: write its value"
            raise table.fail(key.name, what)
    return tuple(cell.value() for cell in cells)


def _modes(table: Table) -> tuple[int, bool]:
    """Number of modes, 0 for a beam by joints, and whether the beam is stiffened by tension."""
    modes, stiffening = MODES.read(table), STIFFENING.read(table)
    if modes and (other := next((key.name for key in (JOINTS, RULE) if key.name in table.entries), "")):
        raise table.fail(other, "belongs to a beam by joints: leave it out, or modes")
    if MODES.name in table.entries and not 1 <= modes <= MOST_MODES:
        raise table.fail(MODES.name, f"{modes} is not from 1 to {MOST_MODES}")
    if modes and not BENDS.read(table, ("y",)):
        raise table.fail(BENDS.name, "names no deflection: name one, or leave modes out")
    if modes and (mass := LINE_MASS.read(table) if LINE_MASS.name in table.entries else None) and mass.is_zero:
        raise table.fail(LINE_MASS.name, "is 0, and modes have mass: give one, or joints in place of modes")
    if stiffening and not modes:
        raise table.fail(STIFFENING.name, "belongs to a beam by modes: joints follow large deflections by themselves")
    return modes, stiffening


def _refuse_values(table: Table, values: Mapping[str, float]) -> None:
    """Raise `InputError` for negative numbers, and for zeros where positive numbers are required."""
    for key in BEAMS.keys:
        if key.type in (keys.FORMULA, BENDING.type) and key.name in table.entries:
            cells = key.read(table)
            for cell in cells if isinstance(cells, tuple) else (cells,):
                value = cell.known_value(values)
                if value is not None and (value < 0 or (value == 0 and key not in MAY_BE_ZERO)):
                    raise table.fail(
                        key.name, f"{quote(cell)} must {'not be negative' if key in MAY_BE_ZERO else 'be above 0'}"
                    )


Properties = tuple[dict[str, str], str, dict[str, str], dict[str, str]]
"""Stiffness by kind of deflection, mass per length, inertia per length, stiffness in shear by direction."""


def _of_section(table: Table, piece: Table, both: tuple[str, str], values: Mapping[str, float]) -> Properties:
    """Properties of a beam from the section of its first piece, E, G and density."""
    for key in (BENDING, OF_TORSION, OF_TENSION, OF_SHEAR, LINE_MASS, LINE_INERTIA):
        if key.name in table.entries:
            raise table.fail(key.name, "follows from the section: remove one of the two")
    kind, sizes = SECTION.read(piece)
    numbers = [size.known_value(values) for size in sizes]
    if fault := _fault_of_section(kind, numbers):
        raise piece.fail(SECTION.name, fault)
    for key in (MODULUS, DENSITY):
        if key.name not in table.entries:
            raise table.fail(key.name, "is missing, which the section needs")
    longer = int(len(numbers) > 1 and (numbers[0] or 0.0) < (numbers[1] or 0.0))
    section = section_of(kind, [size.text for size in sizes], longer)
    E, density = MODULUS.read(table).text, DENSITY.read(table).text
    G = SHEAR.read(table).text if SHEAR.name in table.entries else product(1 / 2.6, E)
    squares = dict(zip(sorted(both), section.squares, strict=True))
    stiffness = {axis: product(E, square) for axis, square in squares.items()}
    inertia = {axis: product(density, square) for axis, square in squares.items()}
    polar = product(density, " + ".join(section.squares))
    more = {TORSION: product(G, section.torsion), AXIAL: product(E, section.area)}
    areas = zip(sorted(both), section.shear, strict=True) if IN_SHEARING.read(table) else ()
    shear = {axis: product(G, area) for axis, area in areas}
    return {**stiffness, **more}, product(density, section.area), {**inertia, TORSION: polar}, shear


def _doubts(table: Table, pieces: list[Table], text: str, values: Mapping[str, float]) -> Iterator[str]:
    """Warnings on implausible properties of a beam with a section, as by mm, MPa and t/mm3 without units."""
    for key, (low, high), likely in ((MODULUS, STIFF, "MPa"), (DENSITY, DENSE, "t/mm3")):
        value = key.read(table).known_value(values)
        if value is not None and not low <= value <= high:
            yield f'{key.name} = {value:g} {key.unit} is no solid\'s; write the unit, as "{value:g} {likely}", if meant'
    length = Formula.parse(text).known_value(values)
    widest = max(size.known_value(values) or 0.0 for piece in pieces for size in SECTION.read(piece)[1])
    if length is not None and length < SLENDER * widest and not IN_SHEARING.read(table):
        what = "shear, which is left out (shear = true), lowers its frequencies"
        yield f"length {length:g} m is below {SLENDER} times the size {widest:g} m of the section: {what}; units in mm?"


def _fault_of_section(kind: str, sizes: list[float | None]) -> str:
    """Reason why a section with these dimensions is impossible; empty if it is possible."""
    if any(size is not None and size <= 0 for size in sizes):
        return f"sizes of a {kind} must be above 0"
    if kind == "bar" and None in sizes:
        return "sides of a bar need values, by which the longer one is known: give the parameters values, or EI and GJ"
    if None in sizes or kind not in ("tube", "box"):
        return ""
    numbers = [size for size in sizes if size is not None]
    if kind == "tube" and numbers[1] >= numbers[0]:
        return f"the inner diameter {numbers[1]:g} m is not below the outer one, {numbers[0]:g} m"
    if kind == "box" and 2 * numbers[2] >= min(numbers[:2]):
        return f"two walls of {numbers[2]:g} m fill the side of {min(numbers[:2]):g} m: write a bar, or a thinner wall"
    return ""


def _of_cells(table: Table, both: tuple[str, str]) -> Properties:
    """Properties of a beam that are stated directly: EI, GJ, EA, kGA, mass and inertia per length."""
    for key in (MODULUS, SHEAR, DENSITY):
        if key.name in table.entries:
            raise table.fail(key.name, "needs a section: give one, or EI, GJ, EA and mass_per_length")
    for key in (BENDING, LINE_MASS):
        if key.name not in table.entries:
            raise table.fail(key.name, "is missing: give it, or a section with E and density")
    stiffness = _by_direction(both, BENDING.read(table))
    shear = _by_direction(both, OF_SHEAR.read(table)) if OF_SHEAR.name in table.entries else {}
    if IN_SHEARING.read(table) and not shear:
        raise table.fail(IN_SHEARING.name, "needs a section, or kGA")
    stiffness |= {
        kind: key.read(table).text
        for kind, key in ((TORSION, OF_TORSION), (AXIAL, OF_TENSION))
        if key.name in table.entries
    }
    inertia = {TORSION: LINE_INERTIA.read(table).text} if LINE_INERTIA.name in table.entries else {}
    return stiffness, LINE_MASS.read(table).text, inertia, shear


def _by_direction(both: tuple[str, str], cells: Sequence[Formula]) -> dict[str, str]:
    """Texts of two cells by direction across the beam; one cell applies to both."""
    return dict(zip(sorted(both), [cell.text for cell in cells] * (3 - len(cells)), strict=True))


def rows_of(beam: Beam) -> tuple[list[Entries], dict[str, dict[str, Entries]]]:
    """Rows of a beam below its root, and their bodies and springs by name."""
    first, second = beam.transverse
    root = own_axes(beam)
    frames = {first: np.eye(3), second: np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])}
    frames |= {IN_SHEAR + first: frames[second], IN_SHEAR + second: frames[first]}
    frames |= dict.fromkeys((TORSION, AXIAL), np.array([[0.0, 0, 1], [1, 0, 0], [0, 1, 0]]))
    rows = [{"name": f"{beam.name}_root", "kind": "fixed", **displacement(root, np.eye(3))}]
    bodies, springs = dict[str, Entries](), dict[str, Entries]()
    axes, last = np.eye(3), 0.0
    for place, label, kind, share in [*_joints_along(beam), (1.0, beam.name + END, "", 0.0)]:
        if place > last:
            bodies[rows[-1]["name"]] = _body(beam, axes, last, place)
        new = frames[kind] if kind else root
        cells = displacement(axes, new, product(place - last, beam.length) if place > last else "")
        axes, last = new, place
        if kind:
            sigma = int(kind == AXIAL or kind.startswith(IN_SHEAR))
            own = SELECTED[sigma]
            cells = {
                "kind": "elastic",
                "sigma": sigma,
                **cells,
                own: " + ".join([label, *([cells[own]] if own in cells else [])]),
            }
            springs[label] = dict(zip(("stiffness", "damping"), beam.spring(kind, share), strict=True))
        rows.append({"name": label, **({} if kind else {"kind": "fixed"}), **cells})
    return rows, {"bodies": bodies, "springs": springs}


def own_axes(beam: Beam) -> Array:
    """Axes u, v, w of a beam (3, 3), rows in the frame of its row."""
    u = np.eye(3)["xyz".index(beam.along[-1])] * (-1 if beam.along[0] == "-" else 1)
    w = np.eye(3)["xyz".index(beam.transverse[1])]
    return np.array([u, np.cross(w, u), w])


def _joints_along(beam: Beam) -> Iterator[tuple[float, str, str, float]]:
    """Position, name, kind and compliance fraction of a beam's joints, from the root to the end."""
    joints = (
        (place, f"{beam.name}_{kind}{k}", kind, share)
        for kind in beam.kinds
        for k, (place, share) in enumerate(zip(*beam.places(kind), strict=True), start=1)
    )
    yield from sorted(joints, key=lambda joint: joint[0])


def _body(beam: Beam, axes: Array, start: float, end: float) -> Entries:
    """Body of the rigid piece between two positions, in the frame at the first of them."""
    mass, center, about = beam.piece(start, end)
    return {
        "mass": mass,
        "center_of_mass": [center if axis[0] else "0" for axis in axes.T],
        "inertia": [about[int(np.argmax(np.abs(axis)))] for axis in axes.T],
    }


def displacement(start: Array, end: Array, distance: str = "") -> Entries:
    """Cells of a row from one frame to another, `distance` along u: axes (3, 3) in columns, each along u, v or w.

    A distance needs u along x or z of the first frame.
    """
    between = start.T @ end
    x, y, z = between[:, 2]
    if start[0, 2]:
        gamma, alpha, cell = (0.0, math.acos(z), "b") if z else (math.atan2(x, -y), math.pi / 2, "b")
    elif x:
        gamma, alpha, cell = math.atan2(x, 0.0), math.pi / 2, "r"
    else:
        gamma, alpha, cell = 0.0, math.atan2(-y, z), "d"
    turned = (about_z(gamma, 0.0) * about_x(alpha, 0.0)).rotation.T @ between
    angles = {"gamma": gamma, "alpha": alpha, "theta": math.atan2(turned[1, 0], turned[0, 0])}
    quarters = {key: round(angle / QUARTER) for key, angle in angles.items()}
    cells: Entries = {key: multiple_of_pi(Fraction(n, 2)) for key, n in quarters.items() if n}
    sign = "-" if cell == "r" and x * start[0, 0] < 0 else ""
    return {**cells, cell: sign + distance} if distance else cells
