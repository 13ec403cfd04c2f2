"""Springs beside motors, as elastic joints about the same axes that loops weld to what the motors move."""

from __future__ import annotations

from dataclasses import replace

from symoro_elastic.machine.described import DescribedMachine
from symoro_elastic.machine.formula import ZERO
from symoro_elastic.machine.loops import Loop
from symoro_elastic.machine.machine import Body, Friction, Joint, Kind, Spring
from symoro_elastic.machine.names import distinct, list_of_names

SPRING, CUT, END = "_spring", "_spring_cut", "_spring_end"


def with_springs_beside(machine: DescribedMachine) -> DescribedMachine:
    """Return the machine with the springs in the rows of its motors as joints of their own, which a remark says.

    Such a joint carries no body and has the cells of the motor's row, so its position is that of the motor's joint,
    over whole turns too. Its rows are at the end of the table.
    """
    sprung = [j for j, joint in enumerate(machine.joints, start=1) if _has_both(joint)]
    if not sprung:
        return machine
    joints = [replace(joint, spring=Spring()) if _has_both(joint) else joint for joint in machine.joints]
    loops = list(machine.loops)
    for j in sprung:
        motor = machine.joint(j)
        taken = {joint.name for joint in joints}
        spring, cut, end = (distinct(motor.name + suffix, taken) for suffix in (SPRING, CUT, END))
        first = len(joints) + 1
        joints += [_beside(motor, spring, f"q{first}"), Joint(cut, first, Kind.CUT, 2), Joint(end, j, Kind.FIXED, 2)]
        loops.append(Loop(spring, first + 1, first + 2, dependent=(spring,)))
    what = "springs beside motors are elastic joints of their own, each in a loop with the joint of its motor"
    remark = f"{what}: {list_of_names(machine.joint(j).name for j in sprung)}"
    return replace(machine, joints=tuple(joints), loops=tuple(loops)).with_remarks(remark)


def _has_both(joint: Joint) -> bool:
    return joint.kind is Kind.MOTOR and not joint.spring.stiffness.is_zero


def _beside(motor: Joint, name: str, variable: str) -> Joint:
    """The elastic joint of a spring in the row of a motor."""
    bare = replace(motor, body=Body(), friction=Friction(), rotor_inertia=ZERO, ratio=ZERO, sharing=ZERO)
    return replace(bare, name=name, kind=Kind.ELASTIC, variable=variable)
