"""Spong's reduced model, and the full model with spinning rotors, each as a machine.

A rotor of inertia Jr about z_j, N turns a turn of its joint, on a body that turns with w has the energy
    T = Jr (N qd + z.w)^2 / 2 = Ia qd^2 / 2 + (Ia / N) qd z.w + (Ia / N^2) (z.w)^2 / 2,    Ia = N^2 Jr.
Spong (1987) keeps the first term only: the kinetic energy that a rotor owes to the motion of its body is neglected.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import replace

from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.described import AnyMachine
from symoro_elastic.machine.formula import ZERO, Formula
from symoro_elastic.machine.machine import Body, Joint, Kind, Machine
from symoro_elastic.machine.names import no_such

ZZ = 5


def rotors(machine: Machine) -> tuple[int, ...]:
    """Return the numbers of revolute motors whose body is a rotor: a coaxial elastic joint carries the next body.

    Rotors are also balanced bodies that carry nothing, on joints that are geared: they follow other joints' variables,
    or others follow theirs.
    """
    coaxial = {
        joint.antecedent
        for joint in machine.joints
        if joint.kind is Kind.ELASTIC and joint.sigma == 0 and joint.alpha.is_zero and joint.d.is_zero
        if joint.selected.names.isdisjoint(machine.variables)
    }
    carriers = {joint.antecedent for joint in machine.joints}
    followed = {name for j in machine.articulated for name in machine.joint(j).selected.names}
    turning = [(j, joint) for j, joint in enumerate(machine.joints, start=1) if joint.sigma == 0]
    motors = [j for j, joint in turning if joint.kind is Kind.MOTOR]
    geared = {j for j in motors if machine.joint(j).variable in followed}
    geared |= {j for j, joint in turning if joint.kind is Kind.COUPLED}
    on_gears = {j for j in geared if j not in carriers and machine.joint(j).body.is_balanced}
    return tuple(sorted(on_gears.union(j for j in motors if j in coaxial)))


def spins(machine: Machine) -> dict[str, Formula]:
    """Return the inertia of rotors about their own axes, by joint, that turns with the bodies that carry them, too."""
    inertia = {machine.joint(j).name: machine.joint(j).body.inertia[ZZ] for j in rotors(machine)}
    return {name: x for name, x in inertia.items() if not x.is_zero}


def reduced_model(machine: AnyMachine, names: Collection[str] | None = None) -> AnyMachine:
    """Return Spong's reduced model: the inertia of rotors about their own axes turns with their joints only.

    ZZ of the bodies that are rotors becomes part of Ia; Ia itself is decoupled from other bodies anyway. `names` are
    the joints of the rotors that are decoupled, by default all.
    """
    coupled = [name for name in spins(machine) if names is None or name in names]
    return replace(machine, joints=tuple(with_coupling(x, "0") if x.name in coupled else x for x in machine.joints))


def with_coupling(joint: Joint, factor: str) -> Joint:
    """Return a joint of whose rotor's own inertia this factor turns with its carrier, the rest with the joint alone."""
    xx, xy, xz, yy, yz, spin = joint.body.inertia
    coupled = Formula.parse(f"({factor})*({spin})") if factor != "0" else ZERO
    alone = spin if coupled.is_zero else Formula.parse(f"(1 - ({factor}))*({spin})")
    body = replace(joint.body, inertia=(xx, xy, xz, yy, yz, coupled))
    return replace(joint.reflected, ratio=ZERO, body=body, rotor_inertia=_sum(joint.reflected_inertia, alone))


def with_ratios(machine: Machine, ratios: Mapping[str, float]) -> Machine:
    """Return the full model: rotors behind gears that turn N times as fast, coupled with their bodies.

    Of Ia, the part Ia / N becomes a body on the joint, and (Ia / N^2 - Ia / N) z z^T joins the inertia of the body
    that carries the rotor; the kinetic energy is then exactly T. Raises `InputError` for joints without a rotor
    about their axis.
    """
    joints = list(machine.joints)
    for name, ratio in ratios.items():
        j = _geared_joint(machine, name, ratio)
        joint = joints[j - 1]
        reflected = joint.reflected_inertia
        coupled = f"({reflected}) / ({ratio!r})"
        joints[j - 1] = replace(
            joint,
            rotor_inertia=Formula.parse(f"({reflected}) - {coupled}"),
            ratio=ZERO,
            electrics=joint.reflected_electrics,
            cogging=joint.reflected_cogging,
            body=_with_inertia(joint.body, {ZZ: coupled}),
        )
        if joint.antecedent:
            carrier = joints[joint.antecedent - 1]
            surplus = f"({coupled} / ({ratio!r}) - {coupled})"
            joints[joint.antecedent - 1] = replace(carrier, body=_with_inertia(carrier.body, _along(joint, surplus)))
    return replace(machine, joints=tuple(joints))


def _geared_joint(machine: Machine, name: str, ratio: float) -> int:
    source = machine.label
    names = [joint.name for joint in machine.joints]
    if name not in names:
        raise InputError(source, "--ratio", no_such("joint", name, names))
    j = names.index(name) + 1
    joint = machine.joint(j)
    if joint.kind is not Kind.MOTOR or joint.sigma != 0 or joint.rotor_inertia.is_zero:
        able = [o.name for o in machine.joints if o.kind is Kind.MOTOR and o.sigma == 0 and not o.rotor_inertia.is_zero]
        what = f"{name} is not a revolute motor with a rotor inertia, so no gear ratio belongs to it"
        raise InputError(source, "--ratio", f"{what}; such motors are {', '.join(able) or 'none here'}")
    if not joint.ratio.is_zero and (joint.ratio.names or joint.ratio.value() != ratio):
        what = f"{name}: the file gives ratio = {joint.ratio}: remove one of the two"
        raise InputError(source, "--ratio", what)
    if not (abs(ratio) >= 1 and abs(ratio) < float("inf")):
        raise InputError(source, "--ratio", f"{name}: {ratio:g} is not a gear ratio: rotor turns per joint turn")
    return j


def _along(joint: Joint, inertia: str) -> dict[int, str]:
    """Return entries of `inertia` z_j z_j^T in the frame of the antecedent, z_j = (sg sa, -cg sa, ca)."""
    x = f"sin({joint.gamma})*sin({joint.alpha})"
    y = f"(-cos({joint.gamma})*sin({joint.alpha}))"
    z = f"cos({joint.alpha})"
    pairs = ((x, x), (x, y), (x, z), (y, y), (y, z), (z, z))
    return {k: f"{inertia}*{first}*{second}" for k, (first, second) in enumerate(pairs)}


def _with_inertia(body: Body, added: Mapping[int, str]) -> Body:
    """Return a body with additional inertia about its centre of mass; its mass stays."""
    cells = [_sum(cell, Formula.parse(added[k])) if k in added else cell for k, cell in enumerate(body.inertia)]
    return replace(body, inertia=(cells[0], cells[1], cells[2], cells[3], cells[4], cells[5]))


def _sum(first: Formula, second: Formula) -> Formula:
    if second.is_zero:
        return first
    return second if first.is_zero else Formula.parse(f"({first}) + ({second})")
