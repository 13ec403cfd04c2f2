"""Commented TOML files to start a machine from: the entries of its kind, and every other key as a comment."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

from symoro_elastic.formats.toml.catalogue import TABLES as OF_CATALOGUES
from symoro_elastic.formats.toml.drives import DRIVES, OF_DRIVES
from symoro_elastic.formats.toml.drives import HEADING as OF_MOTORS
from symoro_elastic.formats.toml.flexible.beams import BEAMS
from symoro_elastic.formats.toml.flexible.beams import HEADING as OF_BEAMS
from symoro_elastic.formats.toml.key import Section
from symoro_elastic.formats.toml.keys import (
    BASE,
    EXTRAS,
    FRAMES,
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
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.formula import FormulaError, number
from symoro_elastic.machine.names import quote
from symoro_elastic.quantities.unit_reader import UnitError, in_si


@dataclass(frozen=True)
class Start:
    """A template of a new machine: its title, the rows of its joints, and the lines of its tables by heading."""

    title: str
    joints: str
    tables: Mapping[str, str]


RANGES = {
    "0": "position = [-2.9, 2.9], velocity = 3, acceleration = 15",
    "1": "position = [-0.4, 0.4], velocity = 1, acceleration = 10",
}
"""Of motors that turn, rad, and of slides, m."""
TUNED = 'Kv = "tuned", Kp = "tuned", Tn = "tuned", current = { lag = 5e-4 }'
"""A drive whose gains `tune` finds."""


def with_drives(start: Start) -> Start:
    """Return the template with limits and drives of all motors, whose gains are to be tuned."""
    motors = re.findall(r'name = "(\w+)",.*kind = "motor",\s+sigma = (\d)', start.joints)
    width = max((len(name) for name, _ in motors), default=0)
    limits = "\n".join(f"{name:{width}} = {{ {RANGES[sigma]} }}" for name, sigma in motors)
    drives = "\n".join(f"{name:{width}} = {{ {TUNED} }}" for name, _ in motors)
    return replace(start, tables={**start.tables, OF_LIMITS: limits, OF_MOTORS: drives})


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


MOTIONS = {"x": (1, "x"), "y": (1, "y"), "z": (1, "z"), "a": (0, "x"), "b": (0, "y"), "c": (0, "z")}
"""Axes of a machine tool by letter: sigma (1 for a slide, 0 for a turn) and its direction."""


def start_of_axes(axes: str, screws: str = "") -> Start:
    """Template with slides x, y, z and turns a, b, c about x, y, z in this order, from frame to tool; `InputError`.

    Each has a motor. With `screws`, a pitch with its unit or in m, an elastic ball screw is between that and a slide.
    """
    letters = re.sub(r"[\s,]", "", axes).lower()
    if not letters or not set(letters) <= MOTIONS.keys() or len(set(letters)) < len(letters):
        what = "write X, Y, Z and turns A, B, C about these, in order from the frame to the tool, as in"
        raise InputError("symoro-elastic", "--axes", f'{quote(axes)} is not a list of axes: {what} "X Y Z B C"')
    pitch = _pitch(screws) if screws else ""
    rows, bodies, springs, motors, carrier = [], [], [], [], ""
    for k, x in enumerate(letters):
        sigma, axis = MOTIONS[x]
        has_screw = bool(screws) and sigma == 1
        carrier, mass = f"{x}_screw" if has_screw else f"{x}_axis", max(400 >> k, 25)
        place = f'sigma = {sigma}, axis = "{axis}", at = [0, 0, {0.2 * k:.1g}]'
        rows.append(f'  {{ name = "{x}_axis",  kind = "motor",   {place} }},')
        if has_screw:
            rows.append(f'  {{ name = "{x}_screw", kind = "elastic", {place} }},')
            springs.append(f"{x}_screw = {{ stiffness = 1.5e8, damping = 2e4 }}")
        inertia = ", ".join([f"{0.04 * mass:g}"] * 3)
        bodies.append(f"{carrier} = {{ mass = {mass}, center_of_mass = [0, 0, 0], inertia = [{inertia}] }}")
        rotor = f'2e-3, ratio = "2*pi/{pitch}"' if has_screw else 80 if sigma else 0.5
        motors.append(f"{x}_axis = {{ rotor_inertia = {rotor} }}")
    rows.append(f'  {{ name = "tool",    kind = "fixed", at = [0, 0, "-L1"], in = "{carrier}" }},')
    tables = {"parameters": 'L1 = { value = 0.2, unit = "m" }', "bodies": "\n".join(bodies)}
    tables |= {"springs": "\n".join(springs)} if springs else {}
    tables["motors"] = "\n".join(motors)
    title = f"axes {', '.join(letters.upper())} from the frame to the tool"
    title += ", slides on elastic ball screws" * bool(springs)
    return with_drives(Start(title, "\n".join(rows), tables))


def _pitch(text: str) -> str:
    """Pitch of a screw, m, as a formula text."""
    try:
        pitch = in_si(text, "m")
        if 0 < number(pitch) < MOST_PITCH:
            return pitch if re.fullmatch(r"[\d.]+", pitch) else f"({pitch})"
        what = f"is {pitch} m"
    except (UnitError, FormulaError) as error:
        what = str(error)
    raise InputError("symoro-elastic", "--screws", f"{quote(text)} {what}: write the pitch of the screws, as in 20mm")


MOST_PITCH = 1.0
"""Of a ball screw, m: a larger number lacks its unit."""
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
SCARA = Start(
    "a SCARA: two revolute axes and a slide with a revolute axis at its end, all vertical",
    """
  { name = "shoulder", kind = "motor", sigma = 0, axis = "z" },
  { name = "elbow",    kind = "motor", sigma = 0, axis = "z", at = ["L1", 0, 0] },
  { name = "quill",    kind = "motor", sigma = 1, axis = "z", at = ["L1 + L2", 0, 0] },
  { name = "wrist",    kind = "motor", sigma = 0, axis = "z", at = ["L1 + L2", 0, 0] },
  { name = "tool",     kind = "fixed", at = [0, 0, -0.1], in = "wrist" },
""",
    {
        "parameters": """
L1 = { value = 0.35, unit = "m" }
L2 = { value = 0.25, unit = "m" }
""",
        "bodies": """
shoulder = { mass = 8, center_of_mass = [0.17, 0, 0], inertia = [0.02, 0.12, 0.12] }
elbow    = { mass = 5, center_of_mass = [0.12, 0, 0], inertia = [0.01, 0.05, 0.05] }
quill    = { mass = 1.2, center_of_mass = [0, 0, 0.1], inertia = [0.005, 0.005, 0.0002] }
wrist    = { mass = 0.3, center_of_mass = [0, 0, -0.05], inertia = [0.0002, 0.0002, 0.0001] }
""",
        "motors": """
shoulder = { rotor_inertia = 3e-5, ratio = 80 }
elbow    = { rotor_inertia = 2e-5, ratio = 50 }
quill    = { rotor_inertia = 2e-5, ratio = "2*pi/0.02" }
wrist    = { rotor_inertia = 0.004 }
""",
    },
)
GANTRY = Start(
    "a portal: a bridge that yaws on its guides, a cross slide on the bridge and a ram, driven by ball screws",
    """
  { name = "bridge",      kind = "motor",   sigma = 1, axis = "y", at = [0, 0, "H"] },
  { name = "guides",      kind = "elastic", sigma = 0, axis = "z", at = [0, 0, "H"] },
  { name = "cross_slide", kind = "motor",   sigma = 1, axis = "x", at = [0, 0, "H"] },
  { name = "carriage",    kind = "elastic", sigma = 0, axis = "y", at = [0, 0, "H"] },
  { name = "ram",         kind = "motor",   sigma = 1, axis = "z", at = [0, 0, "H"] },
  { name = "tool",        kind = "fixed",   at = [0, 0, "-L"], in = "ram" },
""",
    {
        "parameters": """
H = { value = 1.2, unit = "m" }
L = { value = 0.6, unit = "m" }
""",
        "bodies": """
guides   = { mass = 220, center_of_mass = [0, 0, 0], inertia = [4, 80, 80] }
carriage = { mass = 60, center_of_mass = [0, 0, 0.05], inertia = [1.6, 1.2, 1.2] }
ram      = { mass = 35, center_of_mass = [0, 0, -0.2], inertia = [2.4, 2.4, 0.3] }
""",
        "springs": """
guides   = { stiffness = 4e7, damping = 4e4 }
carriage = { stiffness = 6e6, damping = 3e3 }
""",
        "motors": """
bridge      = { rotor_inertia = 4e-3, ratio = "2*pi/0.02" }
cross_slide = { rotor_inertia = 1.2e-3, ratio = "2*pi/0.02" }
ram         = { rotor_inertia = 8e-4, ratio = "2*pi/0.01" }
""",
    },
)
LIMB = """
  {{ name = "side_{k}", antecedent = 0, kind = "fixed", sigma = 2, gamma = "{g}", d = "Rb" }},
  {{ name = "motor_{k}", kind = "motor", sigma = 0, alpha = "pi/2", theta = "a{k}" }},
  {{ name = "arm_{k}", kind = "elastic", sigma = 0, theta = "e{k}" }},
  {{ name = "cross_{k}", kind = "passive", sigma = 0, d = "La", theta = "b{k}" }},
  {{ name = "rod_{k}", kind = "passive", sigma = 0, alpha = "pi/2", theta = "c{k}" }},
  {{ name = "ball_{k}", kind = "cut", sigma = 2, d = "Lr" }},
  {{ name = "socket_{k}", antecedent = "platform", kind = "fixed", sigma = 2, gamma = "{g}", d = "Rp" }},
"""
LIMB_LOOP = """
[loops.limb_{k}]
cut = "ball_{k}"
meets = "socket_{k}"
closes = "point"
dependent = ["a{k}", "b{k}", "c{k}"]
start = {{ pz = -0.75, a{k} = -0.45, b{k} = -1.71 }}
"""
LIMB_BODIES = """
arm_{k} = {{ mass = 1.2, center_of_mass = [0.12, 0, 0], inertia = [0.002, 0.01, 0.01] }}
rod_{k} = {{ mass = 0.35, center_of_mass = [0.375, 0, 0], inertia = [0.0004, 0.02, 0.02] }}
"""


def _of_limbs(lines: str) -> str:
    """Lines of a limb, repeated for three limbs a third of a turn apart."""
    turns = ("0", "2*pi/3", "4*pi/3")
    return "\n".join(lines.strip("\n").format(k=k, g=turn) for k, turn in enumerate(turns, 1))


DELTA = Start(
    "a Delta: a platform on three equal limbs, whose motors turn arms through elastic gears",
    f"""
  {{ name = "along_x", antecedent = 0, kind = "passive", sigma = 1, gamma = "pi/2", alpha = "pi/2", r = "px" }},
  {{ name = "along_y", kind = "passive", sigma = 1, gamma = "pi/2", alpha = "pi/2", r = "py" }},
  {{ name = "platform", kind = "passive", sigma = 1, gamma = "pi/2", alpha = "pi/2", r = "pz" }},
{_of_limbs(LIMB)}
  {{ name = "tool", antecedent = "platform", kind = "fixed", sigma = 2, r = "-Lt" }},
""",
    {
        "loops": _of_limbs(LIMB_LOOP),
        "parameters": """
Rb = { value = 0.2, unit = "m" }
La = { value = 0.3, unit = "m" }
Lr = { value = 0.75, unit = "m" }
Rp = { value = 0.05, unit = "m" }
Lt = { value = 0.05, unit = "m" }
""",
        "bodies": "platform = { mass = 0.9, center_of_mass = [0, 0, -0.02], inertia = [0.0013, 0.0013, 0.0018] }\n"
        + _of_limbs(LIMB_BODIES),
        "springs": _of_limbs("arm_{k} = {{ stiffness = 2e4, damping = 20 }}"),
        "motors": _of_limbs("motor_{k} = {{ rotor_inertia = 3e-5, ratio = 33 }}"),
        "friction": _of_limbs("motor_{k} = {{ viscous = 2 }}"),
        OF_LIMITS: _of_limbs("motor_{k} = {{ position = [-1.2, 0.4], velocity = 10, acceleration = 300 }}"),
        OF_MOTORS: _of_limbs(f"motor_{{k}} = {{{{ {TUNED.replace('{', '{{').replace('}', '}}')} }}}}"),
    },
)
STARTS = {
    **{"arm": with_drives(ARM), "cartesian": start_of_axes("X Y Z"), "delta": DELTA, "elastic": with_drives(ELASTIC)},
    **{"floating": FLOATING, "gantry": with_drives(GANTRY), "linkage": LINKAGE, "scara": with_drives(SCARA)},
    **{name: start_of_axes(axes, "20mm") for name, axes in (("lathe", "Z X"), ("mill", "X Y Z"))},
}
"""Machines to start from, by kind."""
OTHERWISE = {
    "bodies": ("first_moments", "inertia_at_origin"),
    "springs": ("backlash", "rounding"),
    "friction": ("static", "stribeck", "load", "bristle", "bristle_damping", "breakaway"),
    **{"guides": ("moments", "rails", "normal"), "screws": ("modulus", "bearing", "torsional", "lead")},
    "bearings": ("contact_angle", "pitch_diameter", "axis"),
    OF_BEAMS: tuple(name for name in BEAMS.names if name not in ("along", "length", "section", "E", "density")),
    "motion": ("drives",),
    OF_MOTORS: ("feed_forward", "limits", "filters", "set_point", "measured", "period"),
}
"""Keys by table that an example leaves out: others replace them, or the line would be long."""
PARTS = {OF_MOTORS: OF_DRIVES[1:]}
"""Tables within other tables."""
WIDTH = 120
HEAD = """# {title}
# Numbers are examples: SI units, angles in rad ("pi/2"). Lines that begin with # are options: remove the # to use one.
# Write the name of a joint in place of joint_name. All keys: symoro-elastic formats. Editors complete and
# check this file after  symoro-elastic schema > machine.schema.json  with the first line  #:schema machine.schema.json
"""


BRIEF = """# {title}
# Numbers are examples: SI units, angles in rad ("pi/2"). All keys: symoro-elastic formats
"""


def starting_text(name: str, kind: str | Start, full: bool = False) -> str:
    """Text of a new machine file of this kind, with all other keys as comments if `full`."""
    start = STARTS[kind] if isinstance(kind, str) else kind
    blocks = _blocks(name, start) if full else _brief_blocks(name, start)
    return "\n\n".join(block.strip("\n") for block in blocks) + "\n"


def _brief_blocks(name: str, start: Start) -> Iterator[str]:
    """Tables of a new machine, without comments."""
    yield BRIEF.format(title=f"{name}: {start.title}.")
    yield f'name = "{name}"\ngravity = {GRAVITY.example}'
    yield f"joints = [\n{start.joints.strip(chr(10))}\n]"
    for table in ("loops", "parameters", *OF_JOINTS, OF_BEAMS, "base", OF_LIMITS, OF_MOTORS):
        if table in start.tables:
            yield f"[{table}]\n{start.tables[table].strip(chr(10))}"


def _blocks(name: str, start: Start) -> list[str]:
    """Tables of a new machine with comments on all keys; unused optional tables as comments."""
    blocks = [
        HEAD.format(title=f"{name}: {start.title}."),
        f'name = "{name}"\n# notes = {NOTES.example}  # {NOTES.meaning}\n'
        f"gravity = {GRAVITY.example}  # {GRAVITY.unit}: {GRAVITY.meaning}",
        "\n".join([*_comments(JOINTS), f"joints = [\n{start.joints.strip(chr(10))}\n]"]),
        _of_section("loops", LOOPS, start),
        _of_section("frames", FRAMES, start),
        _table("parameters", f"# {PARAMETERS.meaning}", start.tables, ""),
    ]
    sections = {name: section_of(name) for name in OF_JOINTS} | OF_CATALOGUES
    sections |= {OF_BEAMS: BEAMS, "base": BASE, OF_LIMITS: LIMITS, OF_MOTORS: DRIVES}
    sections |= {"scene": SCENE, "motion": MOTION, "wanted": WANTED}
    blocks += [_of_section(name, section, start) for name, section in sections.items()]
    return [*blocks, _table("extras", f"# {EXTRAS.meaning}", {}, '# Type = "0"')]


def _of_section(name: str, section: Section, start: Start) -> str:
    """Text of a table with its entries in the template, or as a comment, below comments on its keys."""
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
    comments = [line for part in (section, *PARTS.get(name, ())) for line in _comments(part)]
    return _table(name, "\n".join(comments), start.tables, "\n".join(f"# {x}" for x in lines.splitlines()))


def _table(name: str, comments: str, tables: Mapping[str, str], otherwise: str) -> str:
    heading = f"[{name}]" if name in tables else f"# [{name}]"
    return "\n".join([comments, heading, tables.get(name, otherwise).strip("\n")])


def _comments(section: Section) -> Iterator[str]:
    """Comment lines on the meaning of a table and of its keys."""
    yield from _wrap(section.meaning, "# ")
    for key in section.keys:
        unit = f" ({key.unit})" if key.unit else ""
        otherwise = f"; where left out: {key.default_in_words}" if key.default_in_words else ""
        yield from _wrap(f"{key.name}: {key.meaning.removesuffix('.')}{unit}{otherwise}", "#   ")


def _wrap(text: str, indent: str) -> list[str]:
    following = indent if len(indent) == 2 else indent + "  "
    return textwrap.wrap(text, WIDTH, initial_indent=indent, subsequent_indent=following, break_on_hyphens=False)
