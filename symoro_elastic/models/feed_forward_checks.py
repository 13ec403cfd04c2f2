"""Checks of feed-forward: machines whose motor torques have no closed form in the outboard motion."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NoReturn

from symoro_elastic.foundation.scalar import Scalar
from symoro_elastic.machine.checks import place_of
from symoro_elastic.machine.machine import Base, Joint, Kind
from symoro_elastic.mechanics.spatial import is_zero
from symoro_elastic.models.bind import Bound
from symoro_elastic.models.load_coordinates import Chain
from symoro_elastic.quantities import HIGHEST_DERIVATIVE


def damping_of(bound: Bound, j: int) -> Scalar:
    """Return damping and viscous friction of a spring, N m s/rad or N s/m."""
    joint = bound.machine.joint(j)
    return bound.cell(joint.spring.damping) + bound.cell(joint.friction.viscous)


def refuse_unfit(bound: Bound, found: Sequence[Chain], damped: bool) -> None:
    """Raise `InputError` for a joint that no motor drives, whose spring has damping unless `damped`, a moving base."""
    machine = bound.machine
    if not _at_rest(bound, machine.base):
        _refuse(bound, "base", "it moves, and derivatives of its motion by time are not known: give a base at rest")
    if not bound.motors:
        _refuse(bound, "joints", "there is no motor whose torque could be found: make a joint a motor")
    _refuse_loops(bound)
    driven = {j for chain in found for j in chain.joints}
    for j in machine.independent:
        for cell, what in _faults(bound, j, machine.joint(j), j in driven, damped):
            _refuse(bound, place_of(j, machine.joint(j), cell), what)


def _refuse_loops(bound: Bound) -> None:
    """Raise `InputError` for motors on dependent joints, and for loops without closed form."""
    machine = bound.machine
    for one in bound.loops:
        if one.is_assembled:
            what = "it has no closed form whose derivatives by time could be taken: with other dependent joints "
            _refuse(bound, f"loop {one.loop.name}", what + "(dependent = [...]) it may have one; simulate needs none")
    for j in machine.dependent:
        joint = machine.joint(j)
        if joint.kind is Kind.MOTOR:
            what = "its variable follows from a loop: use the command feed-forward, to which the motion of the "
            what += "independent joints is given, or choose other dependent joints (dependent = [...])"
            _refuse(bound, place_of(j, joint, "kind"), what)


def refuse_circle(bound: Bound, joints: Sequence[int]) -> NoReturn:
    """Raise `InputError` for springs whose deflections need each other."""
    names = [bound.machine.joint(j).name for j in dict.fromkeys(joints)]
    what = "the springs behind them need each other's deflections, so there is no closed form: lock one in a scene"
    if len(names) == 1:
        what = "the load of the spring behind it needs its deflection, so there is no closed form: lock it in a scene"
    _refuse(bound, f"joint{'s' if len(names) > 1 else ''} {', '.join(names)}", what)


def _at_rest(bound: Bound, base: Base) -> bool:
    cells = (*base.velocity, *base.angular_velocity, *base.acceleration, *base.angular_acceleration)
    return all(map(is_zero, bound.cells(cells)))


def _faults(bound: Bound, j: int, joint: Joint, driven: bool, damped: bool) -> Iterator[tuple[str, str]]:
    if joint.kind is Kind.MOTOR:
        return
    if joint.kind is Kind.PASSIVE:
        yield "kind", "nothing drives it, so it cannot be made to follow: lock it in a scene, or make it a motor"
    if not driven:
        yield (
            "kind",
            "it is elastic, but not the single spring behind a motor on its axis: it vibrates by itself, whatever the "
            "motors do, and the desired motion has no torques in closed form: lock it in a scene",
        )
    if not is_zero(bound.cell(joint.spring.backlash)):
        yield "backlash", "the motor would have to jump where the spring changes flanks: leave it out"
    linear = (("damping", joint.spring.damping), ("viscous friction", joint.friction.viscous))
    for cell, formula in () if damped else linear:
        if not is_zero(bound.cell(formula)):
            what = "it makes the deflection of the spring a differential equation, without closed form: make it 0, or "
            yield cell, f"{what}use the command feed-forward, which integrates it"
    if not is_zero(bound.cell(joint.friction.coulomb)):
        yield "coulomb friction", "it lets the spring stick, so its deflection is unknown: make it 0"
    if not is_zero(bound.cell(joint.rotor_inertia)):
        yield "rotor_inertia", "an elastic joint has no rotor here: give the inertia to the motor or to a body"
    if not joint.spring.stiffness.names.isdisjoint(bound.machine.variables):
        if not is_zero(damping_of(bound, j)):
            yield "stiffness", "it depends on positions, and the spring has damping: make it a constant, or the other 0"
    elif is_zero(bound.cell(joint.spring.stiffness)):
        yield "stiffness", "a spring without stiffness transmits no torque: give it one"


def refuse_high_order(bound: Bound, j: int, order: int) -> NoReturn:
    """Raise `InputError` for a motion that is needed with more derivatives than can be given."""
    given = f"at most {HIGHEST_DERIVATIVE} can be given"
    what = f"{order} derivatives of its motion are needed, {given}: lock springs in a scene"
    _refuse(bound, place_of(j, bound.machine.joint(j)), what)


def _refuse(bound: Bound, place: str, what: str) -> NoReturn:
    raise bound.machine.error(place, f"feed_forward: {what}")
