"""The tables and keys of a TOML machine file and of a scene, a row each: what the reader takes them from."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import Any

from symoro_elastic.formats.toml import key as keys
from symoro_elastic.formats.toml.drives import DRIVES, OF_DRIVES
from symoro_elastic.formats.toml.drives import HEADING as OF_MOTORS
from symoro_elastic.formats.toml.key import Key, Section, Type, one_of, reference_to, some_of
from symoro_elastic.formats.toml.limits import HEADING as OF_LIMITS
from symoro_elastic.formats.toml.limits import LIMITS, TOLERANCE
from symoro_elastic.formats.toml.motion_keys import MOTIONS, OF_MOTION, WANTED
from symoro_elastic.formats.toml.tables import Number, Table, is_not_finite, is_plain_number
from symoro_elastic.formats.toml.with_units import unit_in
from symoro_elastic.formats.toml.within import TOLERANCES_OF_SCENE
from symoro_elastic.machine.columns import AXES, CENTRAL, Column, declared_columns
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import Base, Body, Closing, Joint, Kind, KnownOfBase, Orientation
from symoro_elastic.machine.scene import ALL
from symoro_elastic.quantities.scaled_units import scaled
from symoro_elastic.quantities.time_steps import TimeStep


def key_of(column: Column) -> Key:
    """The key under which a column stands."""
    if column.parts:
        kind = keys.VECTOR if column.parts == AXES else keys.TENSOR
    else:
        kind = keys.NOT_NEGATIVE if column.dimension.is_nonnegative else keys.FORMULA
    unit = " or ".join(dict.fromkeys(column.dimension.units))
    usual = keys.NOTHING[kind] if column.parts else column.default
    return Key(column.key, kind, column.meaning, column.example, usual, column.default.text, unit)


def keys_of(columns: Iterable[Column]) -> tuple[Key, ...]:
    """The keys of columns, each once."""
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
    if is_plain_number(value) and (known := scaled(unit)) and not known.is_si:
        value, unit = f"{value} {unit}".replace("_", ""), known.text
    if unit_of_value := unit_in(value) if keys.is_text(value) else None:
        unit = unit or unit_of_value.text
    return replace(table, units=unit).cell(value, key), unit


def _all_or_texts(table: Table, key: str) -> str | tuple[str, ...]:
    return ALL if table.entries[key] == ALL else table.texts(key)


def _names_or_positions(table: Table, key: str) -> dict[str, Formula | None]:
    """Joints with the position of each, None where only names are listed."""
    if isinstance(table.entries[key], dict):
        return {**keys.FORMULAS.read(table, key)}
    return dict.fromkeys(table.texts(key))


VALUE = Key("value", keys.FORMULA, "value, in its unit", "0.35", otherwise="no value")
UNIT = Key(
    "unit",
    keys.TEXT,
    "unit in kg, m, s, rad, N, J, W, Pa, Hz, as in N m/rad: formulas are checked by it, and it is printed; a number in "
    "mm, deg and the like is converted, a formula in them is refused; other text is printed only",
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
ALL_OR_TEXTS = Type('list of texts, or "all"', {"anyOf": [{"const": ALL}, reference_to("names")]}, _all_or_texts)
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
    *("sigma", keys.WHOLE, "0 revolute, 1 prismatic, 2 fixed frame", "0"),
    otherwise="2 where the kind is fixed, else it must be given",
)
VARIABLE = Key(
    *("variable", keys.NAMED, "variable of the joint itself, where its cell holds several names", '"d_nut"'),
    otherwise="the name in the cell that is not the variable of another joint",
)


def _where(kinds: Iterable[Kind], rules: keys.Schema) -> keys.Schema:
    """The schema that holds for rows of these kinds."""
    return {"if": {"properties": {"kind": {"enum": [kind.value for kind in kinds]}}}, "then": rules}


BY_KIND = {
    "allOf": [
        _where([Kind.FIXED], {"properties": {"sigma": {"const": 2}}}),
        _where([Kind.CUT], {"properties": {"sigma": {"enum": [0, 1, 2]}}, "required": ["sigma"]}),
        _where(
            [kind for kind in Kind if kind not in (Kind.FIXED, Kind.CUT)],
            {"properties": {"sigma": {"enum": [0, 1]}}, "required": ["sigma"]},
        ),
        _where([Kind.FIXED, Kind.COUPLED], {"properties": {"variable": False}}),
    ]
}
JOINTS = Section(
    "joints",
    "A row for each joint, from the base outwards: "
    "iTj = Rot(z, gamma) Trans(z, b) Rot(x, alpha) Trans(x, d) Rot(z, theta) Trans(z, r).",
    (NAME, ANTECEDENT, KIND, SIGMA, VARIABLE, *keys_of(declared_columns(Joint, "joints"))),
    "joint",
    rows=True,
    rules=BY_KIND,
)

CUT = Key("cut", keys.NAMED, "joint of kind cut, whose frame closes the loop", '"pin"')
MEETS = Key("meets", keys.NAMED, "fixed frame of the other branch that the frame of the cut joint meets", '"pin_end"')
CLOSES = Key(
    *("closes", one_of(tuple(Closing)), "what of the two frames meets: all of it, or its origin (a ball joint)"),
    '"point"',
    default=Closing.FRAME.value,
    otherwise='"frame"',
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

ABOUT_ORIGIN, ABOUT_CENTER = (keys_of(declared_columns(Body, form=form)) for form in ("column", CENTRAL))
_NOT_AT_ORIGIN = {"properties": {key.name: False for key in ABOUT_ORIGIN[1:]}}
BODY = Section(
    "[bodies]",
    "Inertial parameters by joint, about the centre of mass or about the origin of the frame. A joint that is not "
    "listed carries a body without mass.",
    tuple(dict.fromkeys((*ABOUT_CENTER, *ABOUT_ORIGIN[1:]))),
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
    """The table of this name, which has an entry for each joint."""
    if name == "bodies":
        return BODY
    return Section(f"[{name}]", MEANINGS.get(name, ""), keys_of(declared_columns(owner, name)), "joint")


OF_JOINTS = tuple(dict.fromkeys(column.section for column in declared_columns(Joint) if column.section != "joints"))
"""Names of the tables with an entry for each joint."""
FLOATING = Key(
    *("floating", one_of(tuple(Orientation)), "the base floats; how its orientation is given", '"quaternion"'),
    otherwise="the base does not float",
)
KNOWN = Key(
    *(
        "known",
        one_of(tuple(KnownOfBase)),
        "what is known about a floating base: the wrench on it, or its acceleration",
    ),
    '"wrench"',
    default=KnownOfBase.WRENCH.value,
    otherwise='"wrench"',
)
OF_BASE = Key(
    *("body", Section("", "", BODY.keys, rules=BODY.rules).type, "the body of a floating base, as in [bodies]"),
    "{ mass = 3, center_of_mass = [0, 0, 0.02], inertia = [0.05, 0.05, 0.08] }",
    otherwise="no mass",
)
BASE = Section(
    "[base]",
    "Motion of the base: given in the file, or an argument of the models where the base floats.",
    (*keys_of(declared_columns(Base, "base")), FLOATING, KNOWN, OF_BASE),
    rules={"dependentRequired": {key.name: [FLOATING.name] for key in (KNOWN, OF_BASE)}},
)

SCENE = Section(
    "[scene]",
    "What is generated. The same keys may stand in a file of their own for `--scene`, under [scene] or without it.",
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
            otherwise="none",
            unit="rad or m",
        ),
        Key(
            *("static", NAMES_OR_POSITIONS),
            "elastic joints that are left out of the motion: held at the neutral position of the spring, or at the one "
            "given; their deflections follow from the reactions there, `static_deflections`",
            '["wrist"]',
            default={},
            otherwise="none",
            unit="rad or m",
        ),
        Key(
            *("condense", keys.TRUTH),
            "whether springs in series with massless bodies between become one",
            "true",
            default=False,
            otherwise="false",
        ),
        Key(
            *("zero", keys.TEXTS),
            "numbers of bodies and rotors, parts of drives (lag, dead_time, filter_1) that are left out: a joint and a "
            "key, as `elbow.mass`, `elbow.center_of_mass.x`, `elbow.XX`",
            '["elbow.mass"]',
            default=(),
            otherwise="none",
        ),
        Key(
            *("forces", keys.TEXTS),
            "frames on which wrenches act that models and steps take as arguments, in axes of frame 0",
            '["tool"]',
            default=(),
            otherwise="none",
        ),
        Key(
            *("fold", ALL_OR_TEXTS, "parameters that become constants of the code", '["L2"]'),
            default=(),
            otherwise="none",
        ),
        Key(
            *("steps", some_of(TimeStep), f"time steps beside the models: {', '.join(TimeStep)}"),
            '["w3"]',
            default=(),
            otherwise="none",
        ),
        Key("gravity", keys.TRUTH, "whether gravity acts", "false", default=True, otherwise="true"),
        *TOLERANCES_OF_SCENE,
    ),
)

(GRAVITY,) = keys_of(declared_columns(Base, "")[:1])
FILE_NAME = Key(
    *("name", keys.NAMED, "name of the machine: of the folder and of the functions in C", '"arm"'),
    otherwise="the name of the file",
)
NOTES = Key("notes", keys.TEXTS, "remarks", '["masses are estimates"]', default=(), otherwise="none")
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
    otherwise="none",
)


def _table(name: str, section: Section) -> Key:
    return Key(name, section.type, section.meaning, "", otherwise="none")


MACHINE = Section(
    "top",
    "Keys at the top of a machine file, above the first [table].",
    (
        *(FILE_NAME, NOTES, GRAVITY),
        Key("joints", JOINTS.type, "The table of geometric parameters, a row for each joint.", ""),
        *(_table("loops", LOOPS), PARAMETERS),
        *(_table(name, section_of(name)) for name in OF_JOINTS),
        *(
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
SECTIONS = (MACHINE, JOINTS, LOOPS, WITH_UNIT, *map(section_of, OF_JOINTS), BASE, LIMITS, *OF_DRIVES, SCENE, *OF_MOTION)
"""All tables of a machine file, in the order of the reference."""
