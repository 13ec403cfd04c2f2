"""What an MJCF file holds and the robot has not, a line each."""

from __future__ import annotations

from collections.abc import Iterator

from symoro_elastic.machine.formats.robots.mjcf_bodies import Bodies
from symoro_elastic.machine.formats.robots.mjcf_equalities import Equalities
from symoro_elastic.machine.formats.robots.mjcf_forces import Forces
from symoro_elastic.machine.names import listed

OF_TENDONS = ("stiffness", "damping", "frictionloss", "armature", "limited")


def remarks_of(bodies: Bodies, forces: Forces, equalities: Equalities) -> tuple[str, ...]:
    """Return what is not taken of a file, and what is taken otherwise than it stands there."""
    return tuple(_remarks(bodies, forces, equalities))


def _remarks(bodies: Bodies, forces: Forces, equalities: Equalities) -> Iterator[str]:
    model = bodies.model
    if bodies.objects:
        yield f"free bodies beside the robot are not taken: {listed(bodies.names[b] for b in bodies.objects)}"
    balls = [
        bodies.joint_names[j]
        for j in range(model.njnt)
        if bodies.type_of(j) is None and model.jnt_bodyid[j] in bodies.taken
    ]
    if balls:
        what = "ball joints are turns about x, y and z, singular where the second is at a right angle"
        yield f"{what}: {listed(balls)}"
    if not model.nu:
        yield "the file has no actuator: joints without springs are taken as driven"
    elif any(map(forces.is_more_than_torque, range(model.nu))):
        yield "torques act on the joints: gears and control laws of actuators are not taken"
    if forces.elsewhere:
        names = (model.actuator(a).name or f"actuator {a + 1}" for a in forces.elsewhere)
        yield f"actuators that act on no joint are not taken: {listed(names)}"
    driven = [bodies.joint_names[j] for j in equalities.followers if j in forces.actuators]
    if driven:
        yield f"these joints follow others, so their actuators are not taken: {listed(driven)}"
    if equalities.left_out:
        yield f"equality constraints that are not taken: {listed(equalities.left_out)}"
    without = [*_without_model(bodies, forces)]
    if without:
        yield f"not modelled: {', '.join(without)}"


def _without_model(bodies: Bodies, forces: Forces) -> Iterator[str]:
    """Forces that no machine has here."""
    model = bodies.model
    if bodies.compiled.has_contacts and not forces.off("CONTACT"):
        yield "contacts"
    if model.jnt_limited.any() and not forces.off("LIMIT"):
        yield "limits of joints"
    tendons = [t for t in range(model.ntendon) if any(getattr(model, f"tendon_{key}")[t] for key in OF_TENDONS)]
    if tendons:
        yield f"forces of tendons ({listed(model.tendon(t).name or f'tendon {t + 1}' for t in tendons)})"
    if model.opt.density or model.opt.viscosity:
        yield "forces of the fluid around it"
    if model.body_gravcomp.any():
        yield "forces that compensate gravity (gravcomp)"
