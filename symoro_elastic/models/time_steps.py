"""The models that generated time steps call, and the machines that have time steps."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from symoro_elastic.machine.arguments import known_of_base
from symoro_elastic.machine.machine import Machine
from symoro_elastic.models.base_steps import base_models
from symoro_elastic.models.catalogue import trace
from symoro_elastic.models.drives.closed_dynamics import closed_dynamics
from symoro_elastic.models.drives.drive_states import driven_motors, why_not_driven
from symoro_elastic.models.implicit_steps import Motors, implicit_system
from symoro_elastic.models.model import TracedModel
from symoro_elastic.models.motor_coordinates import dependent_motors, motor_coordinates
from symoro_elastic.models.passed_torques import passed_torques
from symoro_elastic.models.state import closing_models
from symoro_elastic.quantities.time_steps import TimeStep

EXPLICIT, ROSENBROCK = (TimeStep.RK4,), (TimeStep.RODAS4,)
WITHOUT_STATES = (TimeStep.RODAS4, TimeStep.MIDPOINT)
"""Methods that carry no states of friction and drives: the slopes of these are not exact, and jump."""


def models_of_steps(
    machine: Machine, steps: Sequence[str], folded: Sequence[str], at_hand: Sequence[TracedModel]
) -> Iterator[TracedModel]:
    """Yield the models that steps of some methods call, without those `at_hand`; raises `InputError`."""
    if not steps:
        return
    refuse_machines(machine, steps)
    _refuse_drives(machine, steps)
    needed = ["direct_dynamics"]
    needed += ["inverse_dynamics"] if Motors.DRIVEN in ways_to_give_motors(machine) else []
    needed += [] if {*steps}.isdisjoint(ROSENBROCK) else ["linearization"]
    known = {one.model.name: one for one in at_hand}
    new = [trace(machine, name, folded=folded) for name in needed if name not in known]
    yield from new
    yield from (trace(machine, name, folded=folded) for name in closing_models(machine) if name not in known)
    yield from base_models(machine, folded)
    if dependent_motors(machine) and not {*steps} <= {*ROSENBROCK}:
        yield motor_coordinates(machine, folded)
    if machine.loaded:
        yield passed_torques(machine, folded)
    drives = bool(driven_motors(machine))
    if drives:
        yield closed_dynamics(machine, folded)
    if not {*steps} <= {*EXPLICIT, *ROSENBROCK}:
        for motors in (*ways_to_give_motors(machine), *([Motors.DRIVES] if drives else [])):
            yield from implicit_system(machine, motors, folded)


def notes_on_steps(machine: Machine, steps: Sequence[str]) -> tuple[str, ...]:
    """Return a note where time steps are without the drives of a machine."""
    why = why_not_driven(machine) if steps else ""
    return (f"time steps are without [drives]: {why}",) if why else ()


def refuse_machines(machine: Machine, steps: Sequence[str]) -> None:
    """Raise `InputError` where a machine has no time steps, or not those of some method."""
    _refuse_base(machine, steps)
    if not machine.independent and not machine.degrees_of_base:
        raise machine.error("steps", "no joint moves, so there is no state to take a step: leave them out")
    jumping = [
        joint.name
        for joint in machine.joints
        if joint.friction.creep.is_zero and joint.friction.bristle.is_zero and not joint.friction.coulomb.is_zero
    ]
    if jumping:
        what = "coulomb friction jumps at rest, where no step is small enough: give creep beside it, or bristle"
        raise machine.error(f"friction, {', '.join(jumping)}", what)
    _refuse_friction(machine, steps)
    dependent = [machine.joint(j).name for j in dependent_motors(machine)]
    if dependent and not {*steps}.isdisjoint(ROSENBROCK):
        what = "is not offered where the motor is on a joint that follows by loops or couplings: take w3"
        raise machine.error(f"steps, {', '.join(dependent)}", f"{ROSENBROCK[0]} {what}")


def _refuse_friction(machine: Machine, steps: Sequence[str]) -> None:
    """Raise `InputError` for laws of friction that steps do not have."""
    lacking = [name for name in steps if name in WITHOUT_STATES]
    if machine.loaded and lacking:
        what = f"{lacking[0]} is not offered with friction that rises with load: take w3"
        raise machine.error(f"friction, {machine.joint(machine.loaded[0]).name}, load", what)
    if machine.bristles and lacking:
        what = f"{lacking[0]} is not offered with states of friction (bristle): take w3"
        raise machine.error(f"steps, {machine.joint(machine.bristles[0]).name}", what)


def _refuse_drives(machine: Machine, steps: Sequence[str]) -> None:
    """Raise `InputError` for methods that carry no states of drives."""
    lacking = [name for name in steps if name in WITHOUT_STATES]
    driven = [machine.joint(j).name for j in driven_motors(machine)]
    if lacking and driven:
        what = f"{lacking[0]} is not offered with drives: take w3, or leave [drives] out"
        raise machine.error(f"drives, {', '.join(driven)}", what)


def _refuse_base(machine: Machine, steps: Sequence[str]) -> None:
    """Raise `InputError` where the motion of a base is given, and for methods that need exact derivatives."""
    if "V0d" in known_of_base(machine):
        what = 'the acceleration of the base is given, so it is not a state of a time step: write known = "wrench"'
        raise machine.error("base, known", what)
    if machine.degrees_of_base and not {*steps}.isdisjoint(ROSENBROCK):
        what = "needs exact derivatives, and linearization is not offered on a floating base: take w3"
        raise machine.error("steps", f"{ROSENBROCK[0]} {what}")


def ways_to_give_motors(machine: Machine) -> list[Motors]:
    """Return what may be known of motors: motions only where all own independent variables."""
    if not machine.motors:
        return [Motors.TORQUE]
    moves = len(machine.motors) < len(machine.independent) + machine.degrees_of_base
    follows = moves and not dependent_motors(machine)
    return [Motors.TORQUE, Motors.SERVO, *([Motors.DRIVEN] if follows else [])]
