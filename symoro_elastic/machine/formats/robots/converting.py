"""Robots with changes on the way to their table."""

from __future__ import annotations

from dataclasses import replace

from symoro_elastic.errors import InputError
from symoro_elastic.machine.formats.format import Conversion
from symoro_elastic.machine.formats.robots.description import Description
from symoro_elastic.machine.formats.robots.modified_dh import Deviation, table_of
from symoro_elastic.machine.formats.robots.spring_joints import with_springs
from symoro_elastic.machine.machine import Machine

MOST_SNAP = 1e-3


def converted(description: Description, source: str, conversion: Conversion) -> Machine:
    """The machine of a robot with the changes of a conversion; raises `InputError`.

    Where angles and lengths are snapped, a remark says how far frames are from those of the robot, and how far those of
    the exact table are.
    """
    if conversion.snap is not None and not 0 < conversion.snap <= MOST_SNAP:
        what = f"{conversion.snap:g} is no tolerance, rad and m: give more than 0, at most {MOST_SNAP:g}"
        raise InputError("symoro-elastic", "--snap", what)
    robot = with_springs(description, conversion.springs, source)
    exact = table_of(robot, source)
    if conversion.snap is None:
        return exact.machine
    snapped = table_of(robot, source, conversion.snap)
    remark = (
        f"angles and lengths are snapped within {conversion.snap:g}: frames at position 0 are up to "
        f"{_shown(snapped.deviation)} off; those of the exact table {_shown(exact.deviation)}"
    )
    return replace(snapped.machine, remarks=(*snapped.machine.remarks, remark))


def _shown(deviation: Deviation) -> str:
    return f"{deviation.rotation:.1e} rad and {deviation.translation:.1e} m"
