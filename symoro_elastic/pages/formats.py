"""The reference of the file formats as Markdown, from the rows of the readers."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Sequence

from symoro_elastic.analysis.time_series.measurements import NAMED_COLUMNS
from symoro_elastic.formats.par.keys import KEYS, Place
from symoro_elastic.formats.reading import FORMATS
from symoro_elastic.formats.robots.standard_dh import COLUMNS
from symoro_elastic.formats.toml.key import Section
from symoro_elastic.formats.toml.keys import SCENE, SECTIONS
from symoro_elastic.formats.toml.motion_keys import OF_MOTION
from symoro_elastic.formats.toml.schema import SCHEMAS
from symoro_elastic.formats.toml.vibration_tests import TESTS
from symoro_elastic.foundation.errors import among
from symoro_elastic.machine.formula import FUNCTIONS, PI
from symoro_elastic.models.programs.catalogue import MODELS
from symoro_elastic.quantities.unit_reader import CUSTOMARY, PREFIXES, SI

URDF = """## Robots in URDF (`.urdf`)

Read by every command, and written by `convert`: [from a URDF to an elastic arm](robots.md). The table is exact but for
rounding; `convert --snap` makes it simpler, `--elastic JOINT=K:IA` puts springs behind motors.

| element | read as |
| --- | --- |
| `<link>`, `<inertial>` | body; without it, a frame without mass. `mass` and `ixx iyy izz` must be given |
| `<joint type>` | `revolute`, `continuous`, `prismatic`: a motor; `fixed`: merged, a leaf is a fixed row |
| `floating` | the base floats: for the only child of the root. `planar` is refused |
| `<axis>` | direction, of any length but 0 |
| `<dynamics>` | `damping`: viscous friction, `friction`: dry friction |
| `<limit>` | limits: `lower upper`, `velocity`, `effort`, `acceleration`; an empty range, 1e9 or more mean none |
| `<mimic>` | a coupled row, `multiplier` times the variable of the other joint plus `offset` |
| `<transmission>` | `drake:rotor_inertia` times the square of `drake:gear_ratio`: rotor inertia |

Frame 0 is that of the root link, gravity is [0, 0, -9.81] in it. Shapes and materials are not part of a model.
Written are machines of motors, fixed frames and joints that follow one other in proportion, with values for all
parameters; a link has the frame of its row. Limits are written as the machine has them, 1e9 where URDF demands one.
"""
MJCF = """## Robots in MJCF (`.xml`)

Read by every command through the package mujoco (`pip install '.[mjcf]'`), and written without it: [what
becomes of its elements](robots.md#robots-in-mjcf). Frame 0 is that of the world, or of the body that floats; gravity is
that of `<option>`. Parts and meshes are read in the folder of the file only. Names of rows are those of joints, and of
bodies that are fixed and carry nothing; where the file gives none, `<body>_joint` and `body<number>`. Limits of
positions are `range`; of torques `forcerange`, and `ctrlrange` of plain motors, times the gear, within
`actuatorfrcrange`.
"""
DISTAL = """## Denavit-Hartenberg tables (`.csv`)

A header line that names the columns, then a row for each joint of a chain, separated by commas. In the standard
(distal) convention A = Rot(z, theta) Trans(z, d) Trans(x, a) Rot(x, alpha), the joint about or along z of the frame
before, the link in the frame after; a line `# convention = modified` above the table says that A = Rot(x, alpha)
Trans(x, a) Rot(z, theta) Trans(z, d), the joint about or along z of the frame after. Without such a line, or a column
`convention`, a warning names the convention by which the table is read. Fixed rows place a base or a tool. Cells are
numbers or formulas of numbers, empty ones zero; other lines that begin with # are comments. A unit may follow the name
of a column in brackets, `alpha [deg]`. The last frame is `tool`; gravity is [0, 0, -9.81], or that of a line
`# gravity = 0, -9.81, 0`. Such tables are read, not written; the machine has the modified parameters of the same robot.
"""

INTRODUCTION = f"""# File formats

Written by `symoro-elastic formats` from the rows that the readers read by. `symoro-elastic new NAME` writes a commented
machine file to start from. `symoro-elastic schema machine`, `schema scene` and `schema tests` print JSON Schemas, by
which editors complete and check keys: Taplo and VS Code read `#:schema machine.schema.json` in the first line of a TOML
file.

Quantities are in SI units, angles in rad: where a unit reads "N m/rad or N/m", the first is that of a revolute, the
second of a prismatic joint. In TOML a number may have a unit, `"120 kg"`, `"8 N/um"`, `"30 deg"` or, as a table,
`{{ value = 350, unit = "mm" }}`: it is converted, and checked by its dimension. [Units](#units) are the same in all
files and on the command line. A *formula* is a text such as
`"L2*cos(pi/6) + 0.1"`: numbers, parameters, {PI[0]}, `+ - * / ^`, brackets, and {", ".join(FUNCTIONS)}. A *name* begins
with a letter; letters, digits and single underscores follow; words of the generated languages are refused.

Every key is in an example: `examples/all_keys.toml`, `examples/floating_arm.toml`, `examples/linkage.toml`,
`examples/backlash.toml`, `examples/cantilever.toml`, `examples/carriage.toml`, `examples/spindle.toml`,
`examples/all_keys.par`, `examples/four_bar.par`, `examples/scenes/tool.toml`,
`examples/scenes/puma_within.toml`, `examples/scenes/two_axis_move.toml`, `examples/scenes/ball_screw_drives.toml`,
`examples/lathe_tests/tests.toml`, `examples/two_axis_tests/tests.toml`.
"""
UNITS = f"""## Units

Products and powers of {", ".join(SI)}, with the prefixes {" ".join(PREFIXES)}, and of {", ".join(CUSTOMARY)}, and
their names in full. Products have a space or one of `* . -` and the middle dot between words, one word or brackets
follow a slash: `kg m2`, `kgcm2`, `N m/(rad s)`, `mV/min-1`, `V/1000 rpm`, `1/s`. Signs are read: superscripts, the
degree, micro and ohm sign, `'` for arcmin, `"` for arcsec. What is not known, or has two meanings, is refused.

| where | what is read |
| --- | --- |
| rad per time, or per rad, is needed | `min-1`, `1/min` and `Hz` are turns, 3000 min-1 is 314.159 rad/s; not `1/s` |
| 1/s is needed (Kv) | `1/s`, `1/min`, `rad/s`; `Hz` and `rpm` are refused |
| Hz is needed | `Hz`, `rad/s`, `rpm`, `1/min`; `1/s` is refused |
| rad with units of force is needed | rad may be left out: `N m s` is N m s/rad |
| a force or an acceleration is needed | `lb`, `oz` are weights, `g` is 9.80665 m/s2; else they are masses |
| a number is needed | `%` |
| labels of universal files | case does not count |

"""
TOML = """## Machine file in TOML (`.toml`)

The joint variable is the one name in the cell that sigma selects (theta or r) which is not declared in `[parameters]`.

### Couplings

A cell may hold the variables of other joints, of rows above or below: `theta = "q4 + N*q2"` is the joint's own variable
plus a formula of others, with `sin cos tan sqrt atan2` too. Its own is the name that no other joint owns; where several
are new, `variable` says which. Names mean variables, not positions of joints: a formula repeats what its
leader adds. A joint without a variable of its own is `kind = "coupled"`.

| to say | write |
| --- | --- |
| gear, body of a rotor | a row `rotor` on the body of the stator, `kind = "coupled"`, `theta = "N2*q2"`, and a body |
| inertia of a rotor, without its gyroscopic effect | `[motors] axis_2 = { rotor_inertia = 2e-4, ratio = 100 }` |
| elastic gear | `rotor` is the motor, `theta = "qm2"`; the elastic joint: `theta = "qm2/N2 + q2"` |
| ball screw with an elastic nut | `r = "pitch/(2*pi)*(qm + d_torsion) + d_nut"`, `variable = "d_nut"` |
| stiffness that varies with the position | `[springs] screw = { stiffness = "k1/(L0 + x_table)" }` |
| rack, differential, coupled wrist | `r = "R*q1"`; `theta = "(qa + qb)/2"`; `theta = "N6*(q6 + c65*q5)"` |
| parallelogram by hand | `theta = "q4 - q2"`, no loop |

The variable of an elastic gear is its deflection: `variable = "q2"`.
Friction and springs act on the variable of the joint, friction of a coupled joint on its own rate.

### Limits and tolerances

`[limits]` says what joints and motors can do, and `tolerance` beside the value of a parameter how well it is known. No
model and no generated code depends on them. A number is the range both ways, a list its two ends; both ends are finite,
and a quantity without a limit is left out.

```toml
[limits]
motor_x  = { position = ["-400 mm", "400 mm"], velocity = 2, acceleration = 20, torque = 3000 }
shoulder = { position = ["-170 deg", "120 deg"], velocity = "90 deg/s", torque = [-40, 60] }
[parameters]
k_gear = { value = 2e4, unit = "N m/rad", tolerance = "10 %" }
L2     = { value = "350 mm", tolerance = "0.2 mm" }
```

Positions are values of the joint's variable, also where loops give it. A coupled joint has no limits of its own: it
follows others, and its range follows from theirs. Torques are those of motors, and of springs; passive joints have
none.

| where | what becomes of them |
| --- | --- |
| `show`, `report` | a table of limits; tolerances as ranges of parameters |
| `view` | sliders go from end to end of positions |
| `excite` | limits that no option gives; torques are kept by the parameters of the machine |
| `sweep` | `--over k_gear=tolerance:5`, `--over q.motor_x=limits:5`; without a count to draw from |
| `simulate`, `compare` | a line for each limit that the motion leaves: joint, quantity, time |
| `convert` | TOML and `.par` hold them; URDF no tolerances, and rates and torques that are the same both ways |
| URDF, MJCF | filled on reading, in the joint's variable: [robots](robots.md) |

In Python: `machine.limits.joints["motor_x"].position.low`, `machine.limits.parameters["k_gear"].high`.

### Closed loops

Cut one joint of each loop: its row, `kind = "cut"`, ends one branch and carries no body. A fixed frame ends the other;
where the loop is closed, both coincide. `[loops]` names both rows. The variables of `dependent` joints follow from the
others; `start` is one rough position, which selects the branch. A ball joint is `closes = "point"` with sigma = 2 for
the row of kind cut, a weld sigma = 2 alone.

```toml
joints = [
  ...
  { name = "pin",     antecedent = "rod",     kind = "cut",   sigma = 0, d = "L2", theta = "q6" },
  { name = "pin_end", antecedent = "forearm", kind = "fixed", sigma = 2, d = "L3" },
]
[loops]
parallelogram = { cut = "pin", meets = "pin_end", start = { q2 = 1.0, q3 = 1.5, q4 = 2.5, q5 = -1.5 } }
```
"""
PAR = """## Machine file of SYMORO (`.par`)

`key = value` and `key = {v1, v2, ...}`; comments are `(* ... *)`. Inertias are about the origin of the frame. Names in
the table that are not joint variables are parameters. A comment `(* Robotname = 'RX90' *)` names the machine.

### What SYMORO's format lacks

Comments that begin with `(*toml` hold TOML, with the tables and keys of a machine file in TOML: names of joints, values
and units of parameters, damping, gear ratios, loops, the scene and the rest. SYMORO skips each line in which a comment
begins, and no others, so every line of TOML is a comment of its own.

```
(*toml joints = [{ name = "shoulder" }, { name = "elbow" }] *)
(*toml [parameters] *)
(*toml L2 = { value = 0.35, unit = "m" } *)
(*toml [springs] *)
(*toml elbow = { damping = "d2" } *)
```

A row of `joints` is given for each joint or for none, with `name` and, where several names in its cell may be meant,
`variable`. Where cut joints are not the last rows of a table, `joints` has its order and `[loops]` names `cut` and
`meets`; else both may be left out. `[parameters]` orders the parameters where it names all of them. A number stands in
a list or in TOML, not in both; a body about its centre of mass is in both, and they must agree. `IA` of a row with
a `ratio` in TOML is that of the rotor's own axis: SYMORO, which skips the ratio, needs ratio^2 IA there. In texts `*)`
is written `*\\u0029`.

Lines `(*! key = value *)`, which earlier versions wrote, are still read; writing the machine turns them into TOML.

### Couplings in `.par`

A cell may hold the variables of other joints. A row with a motor or a spring (`mu = 1` or `eta = 1`) owns the name in
its cell that no other row owns; with `mu = 0` a row is passive where its cell holds a name of its own, else it is
coupled: `theta = {q1, N2*q1}` with `mu = {1, 0}` is a gear. A name that also stands where no variable can stand, such
as in `d`, is a parameter; so are the names in `[parameters]`. What stays in doubt is refused, and `variable` says what
is meant.

### Closed loops in `.par`

NL bodies and NJ joints make B = NJ - NL closed loops and NF = NJ + B frames. Rows NL + 1 to NJ are the cut joints,
which carry no body, rows NJ + 1 to NF in the same order the frames that they meet, with sigma = 2. Lists of bodies
have NL entries, of joints NJ, of frames NF; `mu` and lists of bodies and joints may have any of the three: rows
without an entry have 0. The passive joints of a loop are dependent, unless `[loops]` names others.
"""
SERIES = """## Motions and measurements (`.csv`, `.npz`)

A `.csv` file has one header line that names the columns, then a line for each sample, separated by commas; semicolons
or tabs are read as well, and decimal commas between them. A joint is called by its name or by its variable. A unit may
follow, as in `q_elbow [deg]`, `q_elbow (deg)` or `q_elbow/deg`, or all of them in a second line: the column is
converted; without, it is in SI units. Other columns are skipped with a warning. Spaces between columns, comment lines
and a header behind `#`, lines above it, and UTF-16 are read; a last line that is cut is left out with a note. `excite`
and `feed-forward` write such files; `identify`,
`compare --motion` and `feed-forward` read them.

A `.npz` file holds the same names as arrays of one axis, or blocks: `t` (N), `q` (N x joints that move), `tau`
(N x motors), and likewise `qd`, `qdd`, `y`, `yd`.
"""
TESTS_AND_FILES = """### Measured responses and modes (`.csv`, `.npz`, `.uff`, `.unv`)

Tables are as those of motions: one header line, units in it or below, commas, or semicolons or tabs with decimal
commas; a `.npz` file holds the same names as arrays of one axis. OUT and IN are signals of `response`, such as
`tool.ax`, `motor_x.qdd`, `"tool at (0.1, 0, L2).ay"`, `tool.fx`, `motor_x.tau`; a minus before one turns its
direction. Units are those of OUT over IN, such as [g/N], [um/N], [mm/s2/N], with g = 9.80665 m/s2; without, SI.
Frequencies increase. The line at 0 Hz, and lines that are nan, are left out with a note. What `response --out` writes,
`.csv` or `.npz`, is read as it is.

A ring-down becomes natural frequencies, damping ratios and shapes with standard deviations, by least squares, which are
those of white noise. Modes that do not decay in the record are left out with a note.

A universal file holds frequency responses (data set 58, function 4) and their coherences (function 6), or modes (data
sets 55; `rename` names nodes and directions of shapes, `"3:+Z" = "tool.az"`); reading it needs the package pyuff
(`pip install '.[uff]'`). `rename` names nodes and directions, `"3:+Z/1:-RX"`, S for a
scalar. Units are those of its labels, else those of its data types in its system of units (data set 164), else SI;
one in `rename` replaces them. The format has six digits for frequencies.
"""
COLUMN = ("column", "units", "meaning", "example")
HEAD = ("key", "type", "unit", "default", "meaning", "example")


TEST_COLUMNS = (
    ("`f`", "Hz", "frequency", "`f [Hz]`"),
    (
        "`re OUT/IN`, `im OUT/IN`",
        "of OUT over IN",
        "real and imaginary part of a response",
        "`re tool.ax/tool.fx [g/N]`",
    ),
    ("`mag OUT/IN`", "of OUT over IN, dB, dB re a unit", "amplitude", "`mag tool.ax/tool.fx [dB re 1 g/N]`"),
    ("`phase OUT/IN`", "rad", "phase; the unit must be given", "`phase tool.ax/tool.fx [deg]`"),
    ("`coherence OUT/IN`", "1", "coherence, 0 to 1", "`coherence tool.ax/tool.fx`"),
    ("`frequency`", "Hz", "natural frequencies, in a file without `f`", "`frequency [Hz]`"),
    ("`damping_ratio`", "1", "their damping ratios; nan: unknown", "`damping_ratio [%]`"),
    ("`std_frequency`", "Hz", "standard deviations of frequencies", "`std_frequency [Hz]`"),
    ("`std_damping`", "1", "standard deviations of damping ratios", "`std_damping [%]`"),
    ("`OUT`", "of OUT", "amplitudes of the modes there, each mode to any scale", "`-tool.ax`"),
    ("`t`", "s", "even time of a ring-down from the stop on, with columns `OUT`", "`t [ms]`"),
)
"""Columns of measured responses and modes: name, units, meaning, example."""
SCENES = (SCENE, *OF_MOTION)
"""The tables that may also be in a separate file."""


def formats_page() -> str:
    """Return the page about files, as Markdown."""
    blocks = [
        INTRODUCTION,
        UNITS,
        _table(("format of machines", "files", ""), _formats()),
        TOML,
        *(block for section in SECTIONS if section not in SCENES for block in _section(section)),
    ]
    blocks += ["## Scene (`[scene]`, or a file for `--scene`)", *_section(SCENE)[1:]]
    blocks += [*(block for section in OF_MOTION for block in _section(section)), PAR, *_par()]
    distal = ((f"`{x.name}`", x.unit, x.default, x.meaning, f"`{x.example}`") for x in COLUMNS)
    blocks += [URDF, MJCF, DISTAL, _table(("column", "unit", "default", "meaning", "example"), distal)]
    series = ((f"`{x.name}`", x.unit, x.meaning, f"`{x.example}`") for x in NAMED_COLUMNS)
    blocks += [SERIES, _table(COLUMN, series), "## Vibration tests (`.toml`)", *_section(TESTS)]
    blocks += [TESTS_AND_FILES, _table(COLUMN, TEST_COLUMNS)]
    return "\n\n".join(block.strip("\n") for block in blocks) + "\n"


def _formats() -> Iterator[tuple[str, str, str]]:
    """Name, suffixes and use of every format."""
    for form in FORMATS:
        use = "read and written" if form.write else "read"
        yield form.title, ", ".join(f"`{suffix}`" for suffix in form.suffixes), use


def _section(section: Section) -> list[str]:
    """Heading, meaning and table of keys of a section."""
    heading = f"### `{section.heading}`" if section.heading != "top" else "### Top of the file"
    form = f" One table for each {section.entries}." if section.entries and not section.rows else ""
    rows = (
        (
            f"`{key.name}`",
            key.type.title,
            key.unit,
            "must be given" if key.is_required else key.default_in_words,
            key.meaning,
            key.example and f"`{key.example}`",
        )
        for key in section.keys
    )
    return [heading, section.meaning + form, _table(HEAD, rows)]


def _par() -> Iterator[str]:
    """Yield headings and tables of the keys of a .par file, grouped by their place in it."""
    for place in Place:
        yield f"### {place.value[0].upper()}{place.value[1:]}"
        rows = ((f"`{k.name}`", k.unit, k.default, k.meaning, f"`{k.example}`") for k in KEYS if k.place is place)
        yield _table(("key", "unit", "default", "meaning", "example"), rows)


def _table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join(f"| {' | '.join(line)} |".replace("|  |", "| |") for line in lines)


def schema(kind: str) -> str:
    """Return the JSON Schema of a kind of TOML files (machine, scene, tests); raises `InputError` for others."""
    among((kind,), [*SCHEMAS], "FILE")
    return json.dumps(SCHEMAS[kind](MODELS), indent=2) + "\n"
