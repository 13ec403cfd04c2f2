"""Springs beside motors, as elastic joints about the same axes that loops weld to what the motors move; and back."""

from __future__ import annotations

from dataclasses import replace

from symoro_elastic.machine.described import AnyMachine, DescribedMachine
from symoro_elastic.machine.formula import ZERO
from symoro_elastic.machine.joints import Cogging, Electrics
from symoro_elastic.machine.loops import Closing, Loop
from symoro_elastic.machine.machine import Body, Friction, Joint, Kind, Machine, Spring
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
    bare = replace(bare, electrics=Electrics(), cogging=Cogging())
    return replace(bare, name=name, kind=Kind.ELASTIC, variable=variable)


def with_springs_in_motors(machine: AnyMachine) -> AnyMachine:
    """Return the machine with springs as `with_springs_beside` makes them in the rows of their motors again.

    Formats that hold both on a joint write such rows; no model takes them.
    """
    beside = {loop.cut: pair for loop in machine.loops if (pair := _pair(machine, loop))}
    if not beside:
        return machine
    sprung = {motor: machine.joint(spring).spring for spring, motor in beside.values()}
    gone = {spring for spring, _ in beside.values()} | set(beside)
    gone |= {loop.meets for loop in machine.loops if loop.cut in beside}
    numbered = enumerate(machine.joints, start=1)
    kept = [(j, replace(row, spring=sprung.get(j, row.spring))) for j, row in numbered if j not in gone]
    number = {0: 0} | {j: k for k, (j, _) in enumerate(kept, start=1)}
    loops = (loop for loop in machine.loops if loop.cut not in beside)
    return replace(
        machine,
        joints=tuple(replace(row, antecedent=number[row.antecedent]) for _, row in kept),
        loops=tuple(replace(loop, cut=number[loop.cut], meets=number[loop.meets]) for loop in loops),
    )


def _pair(machine: Machine, loop: Loop) -> tuple[int, int] | None:
    """Numbers of the spring and of the motor of a loop that `with_springs_beside` makes; None for others."""
    cut, end = machine.joint(loop.cut), machine.joint(loop.meets)
    if not cut.antecedent or not end.antecedent or loop.closes is not Closing.FRAME:
        return None
    spring, motor = machine.joint(cut.antecedent), machine.joint(end.antecedent)
    expected = _beside(motor, spring.name, str(spring.variable))
    ends = Joint(cut.name, cut.antecedent, Kind.CUT, 2), Joint(end.name, end.antecedent, Kind.FIXED, 2)
    others = machine.antecedents.count(cut.antecedent) + machine.antecedents.count(loop.meets)
    named = any(spring.variable in row.selected.names | row.spring.stiffness.names for row in machine.joints)
    alike = replace(spring, spring=Spring()) == replace(expected, spring=Spring())
    if not alike or ends != (cut, end) or others != 1 or named or motor.kind is not Kind.MOTOR:
        return None
    return (cut.antecedent, end.antecedent) if loop.dependent == (spring.name,) else None
