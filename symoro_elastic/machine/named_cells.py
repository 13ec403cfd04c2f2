"""Numbers of the table as parameters, so that a frequency has a sensitivity to each of them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

from symoro_elastic.errors import InputError
from symoro_elastic.machine.constants import with_constants
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import Body, Inertia6, Joint, Machine, Parameter, Vector3
from symoro_elastic.machine.names import did_you_mean, quoted

CENTRE = ("center_of_mass.x", "center_of_mass.y", "center_of_mass.z")
MOMENTS = ("MX", "MY", "MZ")
INERTIA = ("XX", "XY", "XZ", "YY", "YZ", "ZZ")


def with_named_cells(machine: Machine) -> Machine:
    """Return the machine with masses, stiffnesses, lengths ... as parameters `<joint>.<quantity>` with values.

    Parameters keep their names. Zeros and angles stay as they are: they are the structure of a machine.
    """
    named: list[Parameter] = []
    joints = tuple(_Namer(joint.name, named).joint(joint) for joint in machine.joints)
    return replace(machine, joints=joints, parameters=(*machine.parameters, *named))


def with_values(machine: Machine, values: Mapping[str, float]) -> Machine:
    """Return the machine with other values of parameters, or of the cells named by `with_named_cells`.

    Raises `InputError` for names that do not exist.
    """
    named = with_named_cells(machine)
    names = [parameter.name for parameter in named.parameters]
    refuse_values(machine, values, names)
    given = {name: Formula.parse(float(x)) for name, x in values.items()}
    parameters = tuple(replace(p, value=given.get(p.name, p.value)) for p in named.parameters)
    cells = names[len(machine.parameters) :]
    return with_constants(replace(named, parameters=parameters), cells)


def refuse_values(machine: Machine, values: Mapping[str, float], names: Sequence[str]) -> None:
    """Raise `InputError` for a value of a parameter that does not exist, or that is no finite number."""
    source = machine.label
    for name, x in values.items():
        if name not in names:
            raise InputError(source, "parameters", f"no parameter {quoted(name)}{did_you_mean(name, names)}")
        if not math.isfinite(x):
            raise InputError(source, name, f"{x:g} is no number to compute with")


class _Namer:
    """Names the cells of one joint."""

    def __init__(self, joint: str, named: list[Parameter]) -> None:
        self.name, self.named = joint, named

    def cell(self, formula: Formula, quantity: str) -> Formula:
        if formula.names or formula.is_zero:
            return formula
        name = f"{self.name}.{quantity}"
        self.named.append(Parameter(name, formula))
        return Formula(name, ("name", name))

    def joint(self, joint: Joint) -> Joint:
        spring, friction = joint.spring, joint.friction
        return replace(
            joint,
            b=self.cell(joint.b, "b"),
            d=self.cell(joint.d, "d"),
            r=self.cell(joint.r, "r"),
            rotor_inertia=self.cell(joint.rotor_inertia, "rotor_inertia"),
            body=self.body(joint.body),
            spring=replace(
                spring, **{name: self.cell(getattr(spring, name), name) for name in ("stiffness", "damping", "neutral")}
            ),
            friction=replace(friction, viscous=self.cell(friction.viscous, "viscous")),
        )

    def body(self, body: Body) -> Body:
        x, y, z = map(self.cell, body.moments, CENTRE if body.central else MOMENTS)
        xx, xy, xz, yy, yz, zz = map(self.cell, body.inertia, INERTIA)
        moments: Vector3 = (x, y, z)
        inertia: Inertia6 = (xx, xy, xz, yy, yz, zz)
        return Body(self.cell(body.mass, "mass"), moments, inertia, body.central)
