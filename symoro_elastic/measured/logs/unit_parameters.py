"""Machines whose parameters have names, so that torques by a unit of a parameter can be computed."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from itertools import count

from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.labels import ParameterLabels
from symoro_elastic.machine.machine import Body, Friction, Joint, Kind, Machine, Parameter, Spring, Wrench
from symoro_elastic.mechanics.regressor import INERTIA, INERTIAL, MOMENTS

OF_JOINTS = ("IA", "FV", "FS", "K", "DA", "KQ")  # quantities of joints on which torques depend linearly
Units = Mapping[tuple[int, str], str]
"""Names by row and quantity."""


def has_body(body: Body) -> bool:
    """Return whether the table gives the body any inertia; a body without has no columns."""
    return not all(formula.is_zero for formula in (body.mass, *body.moments, *body.inertia))


def units_of(machine: Machine) -> dict[tuple[int, str], str]:
    """Return by row and quantity a name, free in the machine, for each parameter of bodies with inertia and joints."""
    used_names = ParameterLabels(machine).taken
    bodies = [j for j, x in enumerate(machine.joints, 1) if has_body(x.body)]
    prefix = next(prefix for k in count(1) if not any(name.startswith(prefix := "X" * k + "_") for name in used_names))
    keys = [(j, name) for j in bodies for name in INERTIAL]
    keys += [(j, name) for j in machine.articulated for name in OF_JOINTS]
    return {(j, name): f"{prefix}{name}{j}" for j, name in keys}


def _with_names(machine: Machine, unit_joint: Callable[[int, Joint, Units], Joint]) -> Machine:
    """Return the machine with its parameters named by `units_of`, as `unit_joint` puts them into a row."""
    units = units_of(machine)
    joints = tuple(unit_joint(j, joint, units) for j, joint in enumerate(machine.joints, start=1))
    return replace(machine, joints=joints, parameters=(*machine.parameters, *map(Parameter, units.values())))


def rigid_machine(machine: Machine) -> Machine:
    """Return the machine with every independent joint a motor without friction, every body's parameters named."""
    kinds = dict.fromkeys(machine.independent, Kind.MOTOR) | dict.fromkeys(machine.dependent, Kind.PASSIVE)

    def rigid(j: int, joint: Joint, units: Units) -> Joint:
        zero = Formula.parse(0)
        bare = replace(joint, spring=Spring(), friction=Friction(), rotor_inertia=zero, ratio=zero, sharing=zero)
        return replace(_with_unit_body(j, bare, units), kind=kinds.get(j, joint.kind))

    return _with_names(machine, rigid)


def machine_of_units(machine: Machine) -> Machine:
    """Return the machine without wrenches, all parameters on which torques depend linearly named."""

    def of_units(j: int, joint: Joint, units: Units) -> Joint:
        bare = replace(_with_unit_body(j, joint, units), wrench=Wrench(), ratio=Formula.parse(0))
        if j not in machine.articulated:
            return bare
        cell = {name: Formula.parse(units[j, name]) for name in OF_JOINTS}
        friction = Friction(cell["FV"], cell["FS"], joint.friction.creep)
        spring = Spring(cell["K"], cell["DA"], cell["KQ"])
        if joint.kind is Kind.MOTOR:
            spring = replace(spring, damping=joint.spring.damping)
        spring = spring if joint.has_spring else joint.spring
        return replace(bare, rotor_inertia=cell["IA"], friction=friction, spring=spring)

    return _with_names(machine, of_units)


def _with_unit_body(j: int, joint: Joint, units: Units) -> Joint:
    if not has_body(joint.body):
        return joint
    named = {name: Formula.parse(units[j, name]) for name in INERTIAL}
    mx, my, mz = (named[name] for name in MOMENTS)
    xx, xy, xz, yy, yz, zz = (named[name] for name in INERTIA)
    return replace(joint, body=Body(named["M"], (mx, my, mz), (xx, xy, xz, yy, yz, zz)))
