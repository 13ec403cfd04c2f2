"""The tables and keys of a TOML machine file and of a scene, a row each: the source of the reader."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from dataclasses import replace
from typing import Any

from symoro_elastic.formats.toml import key as keys
from symoro_elastic.formats.toml.catalogue import TABLES as OF_CATALOGUES
from symoro_elastic.formats.toml.drives import DRIVES, OF_DRIVES
from symoro_elastic.formats.toml.drives import HEADING as OF_MOTORS
from symoro_elastic.formats.toml.flexible.beams import BEAMS
from symoro_elastic.formats.toml.flexible.beams import HEADING as OF_BEAMS
from symoro_elastic.formats.toml.flexible.bodies import FLEXIBLE
from symoro_elastic.formats.toml.flexible.bodies import HEADING as OF_FLEXIBLE
from symoro_elastic.formats.toml.flexible.parts import OF_CELL, SIX
from symoro_elastic.formats.toml.key import Key, Section, Type, one_of, reference_to, some_of
from symoro_elastic.formats.toml.limits import HEADING as OF_LIMITS
from symoro_elastic.formats.toml.limits import LIMITS, TOLERANCE
from symoro_elastic.formats.toml.motion_keys import MOTIONS, OF_MOTION, WANTED
from symoro_elastic.formats.toml.tables import Number, Table, is_not_finite, is_plain_number
from symoro_elastic.formats.toml.within import TOLERANCES_OF_SCENE
from symoro_elastic.machine.columns import AXES, CENTRAL, Column, declared_columns
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import (
    Base,
    Body,
    Closing,
    Floating,
    Joint,
    Kind,
    KnownOfBase,
    NamedFrame,
    Orientation,
)
from symoro_elastic.machine.names import quote
from symoro_elastic.machine.scene import ALL
from symoro_elastic.quantities.time_steps import TimeStep
from symoro_elastic.quantities.unit_reader import in_two, number_in_si, read_unit


def key_of(column: Column) -> Key:
    """Key of a column of the data model."""
    if column.parts:
        kind = keys.VECTOR if len(column.parts) == 3 else keys.TENSOR
    else:
        kind = keys.NOT_NEGATIVE if column.dimension.is_nonnegative else keys.FORMULA
    unit = " or ".join(filter(None, dict.fromkeys(column.dimension.units)))
    usual = keys.NOTHING[kind] if column.parts else column.default
    return Key(column.key, kind, column.meaning, column.example, usual, column.default.text, unit)


def keys_of(columns: Iterable[Column]) -> tuple[Key, ...]:
    """Keys of columns, without repetitions."""
    return tuple({column.key: key_of(column) for column in columns}.values())


def _joint_or_row(table: Table, key: str) -> int | str:
    value = table.entries[key]
    return value if keys.is_text(value) else table.whole(key)


def _value_and_unit(table: Table, key: str) -> tuple[Formula | None, str]:
    """Value of a parameter, None for nan, and its unit."""
    value: Any = table.entries[key]
    unit = ""
    if isinstance(value, dict):
        entry = table.table(key).only(WITH_UNIT.names)
        value, unit = entry.entries.get(VALUE.name, Number("nan")), UNIT.read(entry)
        if VALUE.name in entry.entries and is_not_finite(value):
            raise entry.fail(VALUE.name, f"{value} is not finite: leave out what is not known")
    if is_not_finite(value) and "nan" in value:
        return None, unit
    with table.refusing(key):
        if is_plain_number(value) and unit and not (read := read_unit(unit)).is_si:
            value, unit = number_in_si(str(value).replace("_", ""), unit, read.text), read.text
        elif keys.is_text(value) and not unit and (parts := in_two(value)):
            unit = read_unit(parts[1]).text
    return replace(table, units=unit).cell(value, key), unit


def _names_or_positions(table: Table, key: str) -> dict[str, Formula | None]:
    """Joint positions by name under a key; None for the joints of a list of names."""
    if isinstance(table.entries[key], dict):
        return {**keys.FORMULAS.read(table, key)}
    return dict.fromkeys(table.texts(key))


VALUE = Key("value", keys.FORMULA, "value, in its unit", "0.35", otherwise="no value")
UNIT = Key(
    "unit",
    keys.TEXT,
    "unit, as in N m/rad: formulas are checked by it, and it is printed; a number in another unit than that of SI is "
    "converted, a formula in one is refused, and so is a unit that is not known",
    '"m"',
    default="",
    otherwise='""',
)
WITH_UNIT = Section("[parameters], an entry", "Value, unit and tolerance of a parameter.", (VALUE, UNIT, TOLERANCE))
PARAMETER = Type(
    "number or formula of numbers, nan for none, or a table",
    {"anyOf": [reference_to("formula"), WITH_UNIT.schema]},
    _value_and_unit,
)
JOINT_OR_ROW = Type(
    "name or whole number", {"anyOf": [{"type": "integer", "minimum": 0}, reference_to("name")]}, _joint_or_row
)
ALL_OR_TEXTS = Type(
    'list of texts, or "all"',
    {"anyOf": [{"const": ALL}, reference_to("names")]},
    lambda table, key: ALL if table.entries[key] == ALL else table.texts(key),
)
NAMES_OR_POSITIONS = Type(
    "list of texts, or table of numbers or formulas",
    {"anyOf": [reference_to("names"), keys.FORMULAS.schema]},
    _names_or_positions,
)

NAME = Key("name", keys.NAMED, "name of the joint, of its frame and of the body that it carries", '"elbow"')
ANTECEDENT = Key(
    *("antecedent", JOINT_OR_ROW, "joint that carries this one, by name or row; 0 is the base", '"shoulder"'),
    otherwise="the row above",
)
KIND = Key(
    *("kind", one_of(tuple(Kind))),
    "what acts on the joint: a motor, a spring (elastic), friction only (passive); fixed: it does not move; coupled: "
    "it follows the variables of other joints; cut: it closes a loop",
    '"motor"',
)
SIGMA = Key(
    *("sigma", keys.WHOLE),
    "0 revolute, 1 prismatic, 2 fixed frame; 6 of an elastic row: springs along and about x, y, z of its frame, "
    "which become rows NAME_x ... NAME_rx and a fixed one, NAME",
    "0",
    otherwise="2 where the kind is fixed, else it must be given",
)
VARIABLE = Key(
    *("variable", keys.NAMED, "variable of the joint itself, where its cell holds several names", '"d_nut"'),
    otherwise="the name in the cell that is not the variable of another joint; q and the row's number with axis",
)


def _axis(table: Table, key: str) -> tuple[float, ...]:
    """Direction of an axis under a key, as a unit vector."""
    value = table.entries[key]
    if keys.is_text(value):
        if not re.fullmatch("[-+]?[xyz]", value):
            raise table.fail(key, f"{quote(value)} is not an axis: {OF_AXES}")
        return tuple((-1.0 if value[0] == "-" else 1.0) * (value[-1] == letter) for letter in AXES)
    if not isinstance(value, list):
        raise table.fail(key, f"is not an axis: {OF_AXES}")
    entries = keys.list_of_numbers(3).read(table, key)
    length = math.hypot(*entries)
    if not length:
        raise table.fail(key, f"is zero, without a direction: {OF_AXES}")
    unit = [0.0 if abs(x) < NO_COMPONENT * length else x / length for x in entries]
    if abs(length - 1) > UNIT_LENGTH:
        listed = ", ".join(f"{x:.12g}" for x in unit)
        raise table.fail(key, f"has length {length:.6g}: write the unit vector [{listed}]")
    return tuple(unit)


OF_AXES = 'write "x", "y", "z", "-x" ... or a unit vector as [0, 0.6, 0.8]'
UNIT_LENGTH = 1e-6
"""Error of the length of a unit vector: entries of six digits."""
NO_COMPONENT = 1e-15
"""Part of a unit vector that is the rounding of cos(pi/2)."""
AXIS = Key(
    "axis",
    Type(
        '"x", "y", "z", "-x" ..., or a unit vector of three numbers',
        {"anyOf": [{"enum": [sign + x for sign in ("", "-", "+") for x in AXES]}, keys.VECTOR.schema]},
        _axis,
    ),
    "axis about which the joint turns or along which it slides, in axes of frame 0 at position zero, in place of "
    "gamma, b, alpha, d, theta, r; of a fixed frame and a cut joint z of the frame, whose x is then the axis that "
    "follows z in x, y, z, x",
    '"y"',
    otherwise="the row is given by gamma to r; a fixed frame has the axes of frame 0",
)
AT = Key(
    *("at", keys.VECTOR, "a point of the axis, origin of the frame, in frame 0 at position zero", '[0, 0, "L1"]'),
    otherwise="[0, 0, 0]",
    unit="m",
)
IN = Key(
    *("in", JOINT_OR_ROW),
    "row above in whose frame at position zero axis and at are given; that of a joint by axis is at its point, with "
    "axes of frame 0",
    '"shoulder"',
    default=0,
    otherwise="frame 0",
)
BY_AXIS = (AXIS, AT, IN)
ALONG = Key(
    *("along", keys.NAMED, "beam by modes, or rail BODY_RAIL of a body by modes, along which a prismatic row slides"),
    '"rail"',
    otherwise="the row is where its cells say",
)
FROM = Key(
    *(
        "from",
        keys.FORMULA,
        "distance of a row that slides along a body from the root or the first end, where its variable is zero",
    ),
    '"0.2 m"',
    otherwise="0",
    unit="m",
)


def _where(kinds: Iterable[Kind], rules: keys.Schema) -> keys.Schema:
    """Return a schema that applies rules to rows of some kinds."""
    return {"if": {"properties": {"kind": {"enum": [kind.value for kind in kinds]}}}, "then": rules}


BY_KIND = {
    "allOf": [
        _where([Kind.FIXED], {"properties": {"sigma": {"const": 2}}}),
        _where([Kind.CUT], {"properties": {"sigma": {"enum": [0, 1, 2]}}, "required": ["sigma"]}),
        _where(
            [kind for kind in Kind if kind not in (Kind.FIXED, Kind.CUT)],
            {"properties": {"sigma": {"enum": [0, 1, SIX]}}, "required": ["sigma"]},
        ),
        {
            "if": {"properties": {"sigma": {"const": SIX}}, "required": ["sigma"]},
            "then": {"properties": {"kind": {"const": Kind.ELASTIC}, "axis": False, "variable": False}},
        },
        _where([Kind.FIXED, Kind.COUPLED], {"properties": {"variable": False}}),
    ],
    "dependentSchemas": {
        key.name: {"properties": dict.fromkeys(("gamma", "b", "alpha", "d"), False)} for key in BY_AXIS
    },
}
JOINTS = Section(
    "joints",
    "A row for each joint, from the base outwards: "
    "iTj = Rot(z, gamma) Trans(z, b) Rot(x, alpha) Trans(x, d) Rot(z, theta) Trans(z, r), or axis and at.",
    (NAME, ANTECEDENT, KIND, SIGMA, VARIABLE, *BY_AXIS, ALONG, FROM, *keys_of(declared_columns(Joint, "joints"))),
    "joint",
    rows=True,
    least=0,
    rules=BY_KIND,
)

CUT = Key("cut", keys.NAMED, "joint of kind cut, whose frame closes the loop", '"pin"')
MEETS = Key("meets", keys.NAMED, "fixed frame of the other branch that the frame of the cut joint meets", '"pin_end"')
CLOSES = Key(
    *("closes", one_of(tuple(Closing)), "what of the two frames meets: all of it, or its origin (a ball joint)"),
    '"point"',
    default=Closing.FRAME.value,
)
DEPENDENT = Key(
    *("dependent", keys.TEXTS, "joints whose variables follow from the others of the loop, by name or variable"),
    '["q3"]',
    default=(),
    otherwise="the passive joints of the loop",
)
START = Key(
    *(
        "start",
        keys.FORMULAS,
        "one rough position of the loop, by joint variable: it selects the branch; joints that it leaves out are found",
    ),
    "{ q2 = 1, q3 = 0.5 }",
    default={},
    otherwise="zero is tried",
    unit="rad or m",
)
LOOPS = Section(
    "[loops]",
    "Closed loops: how each closes, and which of its variables follow from the others.",
    (CUT, MEETS, CLOSES, DEPENDENT, START),
    "loop",
)

ON = Key("on", keys.NAMED, "joint whose body carries it", '"wrist"', default="", otherwise="frame 0")
FRAMES = Section(
    "[frames]",
    "Frames without a row of the table, by name: tools, sensors, the links of a robot. A frame of the name of a joint "
    "replaces the frame of its row, which is then `row NAME`; where two would have one name they are `link NAME`, "
    "`joint NAME`, `site NAME`.",
    (ON, *keys_of(declared_columns(NamedFrame))),
    "frame",
    naming={"type": "string", "pattern": rf"^((link|joint|site) )?{keys.NAME[1:]}"},
)

ABOUT_ORIGIN, ABOUT_CENTER = (keys_of(declared_columns(Body, form=form)) for form in ("column", CENTRAL))
_NOT_AT_ORIGIN = {"properties": {key.name: False for key in ABOUT_ORIGIN[1:]}}
BODY_AXES = Key(
    *("axes", one_of(("joint", "base"))),
    "frame of the numbers: joint, that of the row in the table; base, at the point of the joint (its origin), with "
    "axes of frame 0 at position zero",
    '"base"',
    default="",
    otherwise="base of a joint that is given by axis, else joint",
)
OF_BODY = tuple(dict.fromkeys((*ABOUT_CENTER, *ABOUT_ORIGIN[1:])))
BODY = Section(
    "[bodies]",
    "Inertial parameters by joint, about the centre of mass or about the origin of the frame. A joint that is not "
    "listed carries a body without mass.",
    (*OF_BODY, BODY_AXES),
    "joint",
    rules={"dependentSchemas": {key.name: _NOT_AT_ORIGIN for key in ABOUT_CENTER[1:]}},
)
MEANINGS = {
    "springs": "Law of the spring (and damper) of each elastic joint.",
    "motors": "Rotors, by joint.",
    "friction": "Friction, by joint.",
    "wrenches": "Force and moment that a body exerts on its surroundings, by joint: a load, a tool.",
}


def section_of(name: str, owner: type = Joint) -> Section:
    """The section `name`, with an entry for each joint."""
    if name == "bodies":
        return BODY
    of_section = keys_of(declared_columns(owner, name))
    if name == "springs":
        of_section = tuple(_also_of_cell(key) if key.name in OF_CELL else key for key in of_section)
    return Section(f"[{name}]", MEANINGS.get(name, ""), of_section, "joint")


def _also_of_cell(key: Key) -> Key:
    """The key of a spring, whose value may be six entries, or six rows of six, if sigma is 6."""
    row = {"type": "array", "items": reference_to("formula"), "minItems": SIX, "maxItems": SIX}
    rows = [] if key.name == "neutral" else [{**row, "items": row}]
    title = f"{key.type.title}; six of them{', or six rows of six,' if rows else ''} where sigma = 6"
    schema = {"anyOf": [key.type.schema, row, *rows]}
    return replace(key, type=replace(key.type, title=title, schema=schema))


OF_JOINTS = tuple(dict.fromkeys(column.section for column in declared_columns(Joint) if column.section != "joints"))
"""Names of the tables with an entry for each joint."""
FLOATING = Key(
    *("floating", one_of(tuple(Orientation)), "the base floats; how its orientation is given", '"quaternion"'),
    otherwise="the base does not float",
)
KNOWN = Key(
    *("known", one_of(tuple(KnownOfBase)), "known quantity of a floating base: the wrench on it, or its acceleration"),
    '"wrench"',
    default=KnownOfBase.WRENCH.value,
)
OF_BASE = Key(
    *("body", Section("", "", OF_BODY, rules=BODY.rules).type, "the body of a floating base, as in [bodies]"),
    "{ mass = 3, center_of_mass = [0, 0, 0.02], inertia = [0.05, 0.05, 0.08] }",
    otherwise="no mass",
)
DAMPING_OF_BASE = keys_of(declared_columns(Floating, "base"))
BASE = Section(
    "[base]",
    "Motion of the base: given in the file, or an argument of the models where the base floats.",
    (*keys_of(declared_columns(Base, "base")), FLOATING, KNOWN, OF_BASE, *DAMPING_OF_BASE),
    rules={"dependentRequired": {key.name: [FLOATING.name] for key in (KNOWN, OF_BASE, *DAMPING_OF_BASE)}},
)

SCENE = Section(
    "[scene]",
    "What is generated. A separate file for `--scene` has the same keys, under [scene] or without it.",
    (
        Key(
            *("models", keys.TEXTS, "models to generate", '["inverse_dynamics", "jacobian"]'),
            default=(),
            otherwise="direct_dynamics and inverse_dynamics",
        ),
        Key(
            *("outputs", keys.LISTS_OF_TEXTS),
            "parts of models: joints, frames as 'tool', 'tool in ram', 'tool at (0.1, 0, L2) in base' (frame 0; a "
            "joint of that name is 'joint base'), or columns of derivatives as 'by q2, qd'",
            '{ jacobian = ["tool"] }',
            default={},
            otherwise="all",
        ),
        Key(
            *("locked", keys.FORMULAS),
            "joints that are held, and the value of their variable; their springs act on nothing",
            '{ elbow = "pi/2" }',
            default={},
            unit="rad or m",
        ),
        Key(
            *("static", NAMES_OR_POSITIONS),
            "elastic joints that are left out of the motion: held at the neutral position of the spring, or at the one "
            "given; their deflections follow from the reactions there, `static_deflections`",
            '["wrist"]',
            default={},
            unit="rad or m",
        ),
        Key(
            *("condense", keys.TRUTH),
            "whether springs in series with massless bodies between become one",
            "true",
            default=False,
        ),
        Key(
            *("zero", keys.TEXTS),
            "numbers of bodies and rotors, couplings of rotors with their carriers (rotor_coupling), parts of drives "
            "(lag, dead_time, filter_1) that are left out: a joint and a key, as `elbow.mass`, "
            "`elbow.center_of_mass.x`, `elbow.XX`",
            '["elbow.mass"]',
            default=(),
        ),
        Key(
            *("forces", keys.TEXTS),
            "frames with wrenches as arguments of models and steps, in axes of frame 0",
            '["tool"]',
            default=(),
        ),
        Key(*("fold", ALL_OR_TEXTS, "parameters that become constants of the code", '["L2"]'), default=()),
        Key(
            *("steps", some_of(TimeStep), f"time steps beside the models: {', '.join(TimeStep)}"), '["w3"]', default=()
        ),
        Key("gravity", keys.TRUTH, "whether gravity acts", "false", default=True),
        *TOLERANCES_OF_SCENE,
    ),
)

(GRAVITY,) = keys_of(declared_columns(Base, "")[:1])
FILE_NAME = Key(
    *("name", keys.NAMED, "name of the machine: of the folder and of the functions in C", '"arm"'),
    otherwise="the name of the file",
)
NOTES = Key("notes", keys.TEXTS, "remarks", '["masses are estimates"]', default=())
PARAMETERS = Key(
    "parameters",
    Type(
        "table of parameters",
        {"type": "object", "propertyNames": reference_to("name"), "additionalProperties": PARAMETER.schema},
        Table.table,
    ),
    "Named numbers, which stay arguments of the generated code.",
    '{ L2 = { value = 0.35, unit = "m" }, k2 = nan }',
    otherwise="none",
)
EXTRAS = Key(
    *("extras", keys.TABLE_OF_TEXTS, "Entries of another format that no model uses, kept for writing it."),
    '{ Type = "0" }',
    default={},
)


def _table(name: str, section: Section) -> Key:
    return Key(name, section.type, section.meaning, "", otherwise="none")


MACHINE = Section(
    "top",
    "Keys at the top of a machine file, above the first [table].",
    (
        *(FILE_NAME, NOTES, GRAVITY),
        Key("joints", JOINTS.type, "The table of geometric parameters, a row for each joint.", ""),
        *(_table("loops", LOOPS), _table("frames", FRAMES), PARAMETERS),
        *(_table(name, section_of(name)) for name in OF_JOINTS),
        *(_table(name, section) for name, section in OF_CATALOGUES.items()),
        *(
            _table(OF_BEAMS, BEAMS),
            _table(OF_FLEXIBLE, FLEXIBLE),
            _table("base", BASE),
            _table(OF_LIMITS, LIMITS),
            _table(OF_MOTORS, DRIVES),
            _table("scene", SCENE),
            MOTIONS,
            _table("wanted", WANTED),
            EXTRAS,
        ),
    ),
)
SECTIONS = (
    *(MACHINE, JOINTS, LOOPS, FRAMES, WITH_UNIT),
    *(*map(section_of, OF_JOINTS), *OF_CATALOGUES.values()),
    *(BEAMS, FLEXIBLE, BASE, LIMITS, *OF_DRIVES, SCENE, *OF_MOTION),
)
"""All tables of a machine file, in the order of the reference."""
