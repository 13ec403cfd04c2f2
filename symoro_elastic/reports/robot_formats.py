"""The part of the reference of file formats that is about robots as links and joints, and about distal tables."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from symoro_elastic.machine.formats.robots.distal_columns import COLUMNS, SCALES

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
| `<mimic>` | a coupled row, `multiplier` times the variable of the other joint plus `offset` |
| `<transmission>` | `drake:rotor_inertia` times the square of `drake:gear_ratio`: rotor inertia |

Frame 0 is that of the root link, gravity is [0, 0, -9.81] in it. Limits, shapes and materials are no part of a model.
Written are machines of motors, fixed frames and joints that follow one other in proportion, with values for all
parameters; a link has the frame of its row.
"""
MJCF = """## Robots in MJCF (`.xml`)

Read by every command through the package mujoco (`pip install 'symoro-elastic[mjcf]'`), not written: [what becomes of
its elements](robots.md#robots-in-mjcf). Frame 0 is that of the world, or of the body that floats; gravity is that of
`<option>`. Parts and meshes are read in the folder of the file only. Names of rows are those of joints, and of bodies
that are fixed and carry nothing; where the file gives none, `<body>_joint` and `body<number>`.
"""
DISTAL = """## Standard Denavit-Hartenberg tables (`.csv`)

A header line that names the columns, then a row for each joint of a chain, separated by commas: A = Rot(z, theta)
Trans(z, d) Trans(x, a) Rot(x, alpha), the joint about or along z of the frame before, the link in the frame after.
Cells are numbers or formulas of numbers, empty ones zero; lines that begin with # are comments. A unit may follow the
name of a column in brackets: {units}. The last frame is `tool`, gravity is
[0, 0, -9.81]. Such tables are read, not written; the machine has the modified parameters of the same robot.
"""


def blocks() -> Iterator[str]:
    """The sections on URDF, on MJCF and on distal tables."""
    yield URDF
    yield MJCF
    units = ", ".join(f"[{other}] for [{unit}]" for unit, others in SCALES.items() for other in others)
    yield DISTAL.replace("{units}", units)


def distal_columns() -> Iterator[Sequence[str]]:
    """Rows of the columns of distal tables."""
    for column in COLUMNS:
        yield f"`{column.name}`", column.unit, column.default, column.meaning, f"`{column.example}`"
