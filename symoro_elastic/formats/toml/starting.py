"""Commented TOML files to start a machine from: what each kind gives, and every other key as a comment."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from symoro_elastic.formats.toml.drives import DRIVES, OF_DRIVES
from symoro_elastic.formats.toml.drives import HEADING as OF_MOTORS
from symoro_elastic.formats.toml.key import Section
from symoro_elastic.formats.toml.keys import (
    BASE,
    EXTRAS,
    GRAVITY,
    JOINTS,
    LOOPS,
    NOTES,
    OF_JOINTS,
    PARAMETERS,
    SCENE,
    section_of,
)
from symoro_elastic.formats.toml.limits import HEADING as OF_LIMITS
from symoro_elastic.formats.toml.limits import LIMITS
from symoro_elastic.formats.toml.motion_keys import MOTION, WANTED


@dataclass(frozen=True)
class Start:
    """A machine to start from: what it is, the rows of its joints, and the lines of its tables by their headings."""

    title: str
    joints: str
    tables: Mapping[str, str]


ARM = Start(
    "an arm of three revolute joints: the first about the vertical, the others about horizontal axes",
    """
  { name = "waist",    kind = "motor", sigma = 0, alpha = 0,      d = 0,    theta = "q1", r = "L1" },
  { name = "shoulder", kind = "motor", sigma = 0, alpha = "pi/2", d = 0,    theta = "q2", r = 0 },
  { name = "elbow",    kind = "motor", sigma = 0, alpha = 0,      d = "L2", theta = "q3", r = 0 },
  { name = "tool",     kind = "fixed", sigma = 2, alpha = 0,      d = "L3", theta = 0,    r = 0 },
""",
    {
        "parameters": """
L1 = { value = 0.4, unit = "m" }
L2 = { value = 0.35, unit = "m" }
L3 = { value = 0.3, unit = "m" }
""",
        "bodies": """
waist    = { mass = 6, center_of_mass = [0, 0, -0.1], inertia = [0.05, 0.05, 0.03] }
shoulder = { mass = 4, center_of_mass = [0.15, 0, 0], inertia = [0.01, 0.05, 0.05] }
elbow    = { mass = 2, center_of_mass = [0.12, 0, 0], inertia = [0.004, 0.02, 0.02] }
""",
        "motors": """
waist    = { rotor_inertia = 0.8 }
shoulder = { rotor_inertia = 0.8 }
elbow    = { rotor_inertia = 0.3 }
""",
        "friction": """
waist    = { viscous = 2, coulomb = 4 }
""",
    },
)
CARTESIAN = Start(
    "three prismatic axes along x, y and z of frame 0, with a tool whose frame has the axes of frame 0",
    """
  { name = "x_axis", kind = "motor", sigma = 1, gamma = "pi/2", alpha = "pi/2", d = 0, theta = "pi/2", r = "qx" },
  { name = "y_axis", kind = "motor", sigma = 1, gamma = 0,      alpha = "pi/2", d = 0, theta = "pi/2", r = "qy" },
  { name = "z_axis", kind = "motor", sigma = 1, gamma = 0,      alpha = "pi/2", d = 0, theta = 0,      r = "qz" },
  { name = "tool",   kind = "fixed", sigma = 2, gamma = 0,      alpha = 0,      d = 0, theta = 0,      r = "-L4" },
""",
    {
        "parameters": """
L4 = { value = 0.2, unit = "m" }
""",
        "bodies": """
x_axis = { mass = 120, center_of_mass = [0, 0, 0], inertia = [4, 4, 4] }
y_axis = { mass = 60,  center_of_mass = [0, 0, 0], inertia = [2, 2, 2] }
z_axis = { mass = 25,  center_of_mass = [0, 0, 0.1], inertia = [0.5, 0.5, 0.1] }
""",
        "motors": """
x_axis = { rotor_inertia = 80 }
y_axis = { rotor_inertia = 40 }
z_axis = { rotor_inertia = 30 }
""",
    },
)
ELASTIC = Start(
    "a motor that drives an arm through a spring: the joint of the motor, then that of the spring",
    """
  { name = "drive", kind = "motor",   sigma = 0, alpha = "pi/2", d = 0,    theta = "q1", r = 0 },
  { name = "arm",   kind = "elastic", sigma = 0, alpha = 0,      d = 0,    theta = "q2", r = 0 },
  { name = "tool",  kind = "fixed",   sigma = 2, alpha = 0,      d = "L3", theta = 0,    r = 0 },
""",
    {
        "parameters": """
L3 = { value = 0.5, unit = "m" }
k2 = { value = 2.0e4, unit = "N m/rad" }
""",
        "bodies": """
drive = { mass = 3, center_of_mass = [0, 0, 0], inertia = [0.01, 0.01, 0.01] }
arm   = { mass = 5, center_of_mass = [0.25, 0, 0], inertia = [0.01, 0.12, 0.12] }
""",
        "springs": """
arm = { stiffness = "k2", damping = 5 }
""",
        "motors": """
drive = { rotor_inertia = 1.5 }
""",
    },
)
FLOATING = Start(
    "a flying base with an arm of two revolute joints",
    """
  { name = "shoulder", kind = "motor", sigma = 0, alpha = "pi/2", d = 0,    theta = "q1", r = 0 },
  { name = "elbow",    kind = "motor", sigma = 0, alpha = 0,      d = "L2", theta = "q2", r = 0 },
  { name = "tool",     kind = "fixed", sigma = 2, alpha = 0,      d = 0.15, theta = 0,    r = 0 },
""",
    {
        "parameters": """
L2 = { value = 0.2, unit = "m" }
""",
        "bodies": """
shoulder = { mass = 0.3, center_of_mass = [0.1, 0, 0], inertia = [0.0001, 0.001, 0.001] }
elbow    = { mass = 0.2, center_of_mass = [0.08, 0, 0], inertia = [0.0001, 0.0005, 0.0005] }
""",
        "motors": """
shoulder = { rotor_inertia = 0.002 }
elbow    = { rotor_inertia = 0.001 }
""",
        "base": """
floating = "rotation"
body = { mass = 3, center_of_mass = [0, 0, 0.02], inertia = [0.05, 0.05, 0.08] }
""",
    },
)
LINKAGE = Start(
    "an arm whose forearm is moved through a parallelogram, and a waist with the rotor of its gear",
    """
  { name = "waist",   antecedent = 0,         kind = "motor",   sigma = 0, alpha = 0,      d = 0,     theta = "q1" },
  { name = "rotor",   antecedent = 0,         kind = "coupled", sigma = 0, alpha = 0,      d = 0,     theta = "N1*q1" },
  { name = "arm",     antecedent = "waist",   kind = "motor",   sigma = 0, alpha = "pi/2", d = 0,     theta = "q2" },
  { name = "forearm", antecedent = "arm",     kind = "passive", sigma = 0, alpha = 0,      d = "L2",  theta = "q3" },
  { name = "crank",   antecedent = "waist",   kind = "motor",   sigma = 0, alpha = "pi/2", d = 0,     theta = "q4" },
  { name = "rod",     antecedent = "crank",   kind = "passive", sigma = 0, alpha = 0,      d = "L3",  theta = "q5" },
  { name = "pin",     antecedent = "rod",     kind = "cut",     sigma = 0, alpha = 0,      d = "L2",  theta = "q6" },
  { name = "pin_end", antecedent = "forearm", kind = "fixed",   sigma = 2, alpha = 0,      d = "L3",  theta = 0 },
  { name = "tool",    antecedent = "forearm", kind = "fixed",   sigma = 2, alpha = 0,      d = "-L4", theta = 0 },
""",
    {
        "loops": """
parallelogram = { cut = "pin", meets = "pin_end", start = { q2 = 1.0, q3 = 1.5, q4 = 2.5, q5 = -1.5 } }
""",
        "parameters": """
N1 = 100
L2 = { value = 0.7, unit = "m" }
L3 = { value = 0.2, unit = "m" }
L4 = { value = 0.6, unit = "m" }
""",
        "bodies": """
waist   = { mass = 40, center_of_mass = [0, 0, 0.1], inertia = [1, 1, 0.8] }
rotor   = { mass = 1, center_of_mass = [0, 0, 0], inertia = [0.0004, 0.0004, 0.0007] }
arm     = { mass = 15, center_of_mass = [0.35, 0, 0], inertia = [0.05, 0.6, 0.6] }
forearm = { mass = 10, center_of_mass = [-0.2, 0, 0], inertia = [0.03, 0.3, 0.3] }
crank   = { mass = 6, center_of_mass = [0.1, 0, 0], inertia = [0.01, 0.02, 0.02] }
rod     = { mass = 3, center_of_mass = [0.35, 0, 0], inertia = [0.002, 0.1, 0.1] }
""",
        "motors": """
arm   = { rotor_inertia = 0.0005, ratio = 100 }
crank = { rotor_inertia = 0.0005, ratio = 80 }
""",
    },
)
STARTS = {"arm": ARM, "cartesian": CARTESIAN, "elastic": ELASTIC, "floating": FLOATING, "linkage": LINKAGE}
"""Machines to start from, by kind."""
OTHERWISE = {
    "bodies": ("first_moments", "inertia_at_origin"),
    "springs": ("backlash", "rounding"),
    "friction": ("static", "stribeck", "load", "bristle", "bristle_damping", "breakaway"),
    "motion": ("drives",),
    OF_MOTORS: ("feed_forward", "limits", "filters", "set_point", "measured", "period"),
}
"""Keys by table that an example leaves out: others stand in their place, or the line would be long."""
PARTS = {OF_MOTORS: OF_DRIVES[1:]}
"""Tables within the tables of others."""
WIDTH = 120
HEAD = """# {title}
# Numbers are examples: SI units, angles in rad ("pi/2"). Lines that begin with # are options: remove the # to use one.
# Write the name of a joint in place of joint_name. All keys: symoro-elastic formats. Editors complete and
# check this file after  symoro-elastic schema > machine.schema.json  with the first line  #:schema machine.schema.json
"""


BRIEF = """# {title}
# Numbers are examples: SI units, angles in rad ("pi/2"). All keys: symoro-elastic formats
"""


def starting_text(name: str, kind: str, brief: bool = False) -> str:
    """The text of a machine file of this kind, with all other keys as comments unless `brief`."""
    start = STARTS[kind]
    blocks = _brief_blocks(name, start) if brief else _blocks(name, start)
    return "\n\n".join(block.strip("\n") for block in blocks) + "\n"


def _brief_blocks(name: str, start: Start) -> Iterator[str]:
    """The tables of a machine, without comments."""
    yield BRIEF.format(title=f"{name}: {start.title}.")
    yield f'name = "{name}"\ngravity = {GRAVITY.example}'
    yield f"joints = [\n{start.joints.strip(chr(10))}\n]"
    for table in ("loops", "parameters", *OF_JOINTS, "base"):
        if table in start.tables:
            yield f"[{table}]\n{start.tables[table].strip(chr(10))}"


def _blocks(name: str, start: Start) -> list[str]:
    """All tables, those that are not needed as comments."""
    blocks = [
        HEAD.format(title=f"{name}: {start.title}."),
        f'name = "{name}"\n# notes = {NOTES.example}  # {NOTES.meaning}\n'
        f"gravity = {GRAVITY.example}  # {GRAVITY.unit}: {GRAVITY.meaning}",
        "\n".join([*_comments(JOINTS), f"joints = [\n{start.joints.strip(chr(10))}\n]"]),
        _of_section("loops", LOOPS, start),
        _table("parameters", f"# {PARAMETERS.meaning}", start.tables, ""),
    ]
    blocks += [_of_section(name, section_of(name), start) for name in OF_JOINTS]
    blocks += [_of_section("base", BASE, start), _of_section(OF_LIMITS, LIMITS, start)]
    blocks += [_of_section(OF_MOTORS, DRIVES, start)]
    blocks += [_of_section("scene", SCENE, start)]
    blocks += [_of_section("motion", MOTION, start), _of_section("wanted", WANTED, start)]
    blocks.append(_table("extras", f"# {EXTRAS.meaning}", {}, '# Type = "0"'))
    return blocks


def _of_section(name: str, section: Section, start: Start) -> str:
    """A table as the kind gives it, or as a comment, below its keys."""
    if section is LOOPS:
        example = ", ".join(f"{key.name} = {key.example}" for key in section.keys)
        lines = f"loop_name = {{ {example} }}"
    elif section.entries:
        own = [key for key in section.keys if key.name not in OTHERWISE.get(name, ())]
        example = ", ".join(f"{key.name} = {key.example}" for key in own)
        lines = f"{section.entries}_name = {{ {example} }}"
    else:
        fixed = name == "motion" and "base" not in start.tables
        left_out = {*OTHERWISE.get(name, ()), *(("base",) if fixed else ())}
        keys = [key for key in section.keys if key.name not in left_out]
        lines = "\n".join(f"{key.name} = {key.example}" for key in keys)
    comments = [line for one in (section, *PARTS.get(name, ())) for line in _comments(one)]
    return _table(name, "\n".join(comments), start.tables, "\n".join(f"# {x}" for x in lines.splitlines()))


def _table(name: str, comments: str, tables: Mapping[str, str], otherwise: str) -> str:
    heading = f"[{name}]" if name in tables else f"# [{name}]"
    return "\n".join([comments, heading, tables.get(name, otherwise).strip("\n")])


def _comments(section: Section) -> Iterator[str]:
    """Lines that say what a table and each of its keys mean."""
    yield from _wrapped(section.meaning, "# ")
    for key in section.keys:
        unit = f" ({key.unit})" if key.unit else ""
        default = f"; default: {key.otherwise}" if key.otherwise else ""
        yield from _wrapped(f"{key.name}: {key.meaning}{unit}{default}", "#   ")


def _wrapped(text: str, indent: str) -> list[str]:
    following = indent if len(indent) == 2 else indent + "  "
    return textwrap.wrap(text, WIDTH, initial_indent=indent, subsequent_indent=following, break_on_hyphens=False)
