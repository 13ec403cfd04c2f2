"""The models that generated time steps call, and the machines that have time steps."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from symoro_elastic.machine.machine import Given, Machine
from symoro_elastic.models.base_steps import base_models
from symoro_elastic.models.catalogue import trace
from symoro_elastic.models.implicit_steps import Motors, implicit_system
from symoro_elastic.models.model import TracedModel
from symoro_elastic.models.motor_coordinates import dependent_motors, motor_coordinates

EXPLICIT, ROSENBROCK = ("rk4",), ("rodas4",)


def models_of_steps(
    machine: Machine, steps: Sequence[str], folded: Sequence[str], at_hand: Sequence[TracedModel]
) -> Iterator[TracedModel]:
    """Yield the models that steps of some methods call, without those `at_hand`; raises `InputError`."""
    if not steps:
        return
    refuse_machines_without_steps(machine, steps)
    needed = ["direct_dynamics"]
    needed += ["inverse_dynamics"] if Motors.DRIVEN in ways_to_give_motors(machine) else []
    needed += [] if {*steps}.isdisjoint(ROSENBROCK) else ["linearization"]
    known = {one.model.name: one for one in at_hand}
    new = [trace(machine, name, folded=folded) for name in needed if name not in known]
    yield from new
    takes_dependent = any("q_dep" in one.model.arguments for one in (*at_hand, *new))
    if takes_dependent and "assemble" not in known:
        yield trace(machine, "assemble", folded=folded)
    if machine.floating:
        yield from base_models(machine, folded)
    if dependent_motors(machine) and not {*steps} <= {*ROSENBROCK}:
        yield motor_coordinates(machine, folded)
    if not {*steps} <= {*EXPLICIT, *ROSENBROCK}:
        for motors in ways_to_give_motors(machine):
            yield from implicit_system(machine, motors, folded)


def refuse_machines_without_steps(machine: Machine, steps: Sequence[str]) -> None:
    """Raise `InputError` where a machine has no time steps, or not those of some method."""
    if machine.floating:
        _refuse_base(machine, steps)
    if not machine.moving and not machine.floating:
        raise machine.error("steps", "no joint moves, so there is no state to take a step: leave them out")
    jumping = [
        joint.name for joint in machine.joints if joint.friction.creep.is_zero and not joint.friction.coulomb.is_zero
    ]
    if jumping:
        what = "coulomb friction jumps at rest, where no step is small enough: give creep beside it, as 1e-4"
        raise machine.error(f"friction, {', '.join(jumping)}", what)
    dependent = [machine.joint(j).name for j in dependent_motors(machine)]
    if dependent and not {*steps}.isdisjoint(ROSENBROCK):
        what = "is not offered where the motor is on a joint that follows by loops or couplings: take w3"
        raise machine.error(f"steps, {', '.join(dependent)}", f"{ROSENBROCK[0]} {what}")


def _refuse_base(machine: Machine, steps: Sequence[str]) -> None:
    """Raise `InputError` where the motion of a base is given, and for methods that need exact derivatives."""
    if machine.floating and machine.floating.known is Given.ACCELERATION:
        what = 'the acceleration of the base is given, so it is no state of a time step: write known = "wrench"'
        raise machine.error("base, known", what)
    if not {*steps}.isdisjoint(ROSENBROCK):
        what = "needs exact derivatives, and linearization is not offered on a floating base: take w3"
        raise machine.error("steps", f"{ROSENBROCK[0]} {what}")


def ways_to_give_motors(machine: Machine) -> list[Motors]:
    """Return what may be known of motors: motions only where all own independent variables."""
    if not machine.motors:
        return [Motors.TORQUE]
    moves = len(machine.motors) < len(machine.moving) or machine.floating is not None
    follows = moves and not dependent_motors(machine)
    return [Motors.TORQUE, Motors.SERVO, *([Motors.DRIVEN] if follows else [])]
