"""The models that generated time steps call, and the machines that have time steps.

Friction that rises with load needs the torques that pass through the transmissions of joints, of motors and springs
less friction and rotors: lambda = Gamma_m - Gamma_f(lambda) - Ia qdd(lambda), an input of generated models. As its
share of lambda is below 0.9 and rotors need only a part of a torque, lambda is found by substitution.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

from symoro_elastic.foundation.scalar import Scalar, sum_of
from symoro_elastic.machine.arguments import known_of_base
from symoro_elastic.machine.machine import Machine
from symoro_elastic.models.bound.bind import Bound
from symoro_elastic.models.bound.model import Model, Result, Results, TracedModel
from symoro_elastic.models.bound.naming import name_geometry
from symoro_elastic.models.bound.state import closing_models, position_blocks
from symoro_elastic.models.bound.tracing import Trace, prune, schedule
from symoro_elastic.models.drives.drive_states import driven_motors, why_not_driven
from symoro_elastic.models.programs.catalogue import trace, with_friction_states
from symoro_elastic.models.steps.closed_dynamics import closed_dynamics
from symoro_elastic.models.steps.implicit_steps import Motors, base_models, implicit_system
from symoro_elastic.quantities import quantity
from symoro_elastic.quantities.time_steps import TimeStep
from symoro_elastic.symbolic.functions import amount
from symoro_elastic.symbolic.program import Input, Section

EXPLICIT, ROSENBROCK = (TimeStep.RK4,), (TimeStep.RODAS4,)
WITHOUT_STATES = (TimeStep.RODAS4, TimeStep.MIDPOINT)
"""Methods that do not support states of friction and drives, whose slopes are inexact and jump."""
MOTOR_COORDINATES = "motor_coordinates"
PASSED_TORQUES, PASSED, TERMS = "passed_torques", "load_passed", "load_terms"


def models_of_steps(
    machine: Machine, steps: Sequence[str], folded: Sequence[str], at_hand: Sequence[TracedModel]
) -> Iterator[TracedModel]:
    """Yield the models that the steps of a scene call, except models `at_hand`; raises `InputError`."""
    if not steps:
        return
    refuse_machines(machine, steps)
    _refuse_drives(machine, steps)
    needed = ["direct_dynamics"]
    needed += ["inverse_dynamics"] if Motors.DRIVEN in ways_to_give_motors(machine) else []
    needed += [] if {*steps}.isdisjoint(ROSENBROCK) else ["linearization"]
    at_hand_by_name = {model.model.name: model for model in at_hand}
    new = [trace(machine, name, folded=folded) for name in needed if name not in at_hand_by_name]
    yield from new
    yield from (trace(machine, name, folded=folded) for name in closing_models(machine) if name not in at_hand_by_name)
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
    """Raise `InputError` for a machine without time steps, or without those of a requested method."""
    refuse_base(machine, steps)
    if not machine.independent and not machine.degrees_of_base:
        raise machine.error("steps", "no joint moves, so there is no state to take a step: leave them out")
    with_jumps = [
        joint.name
        for joint in machine.joints
        if joint.friction.creep.is_zero and joint.friction.bristle.is_zero and not joint.friction.coulomb.is_zero
    ]
    if with_jumps:
        what = "coulomb friction jumps at rest, where no step is small enough: give creep beside it, or bristle"
        raise machine.error(f"friction, {', '.join(with_jumps)}", what)
    _refuse_friction(machine, steps)
    dependent = [machine.joint(j).name for j in dependent_motors(machine)]
    if dependent and not {*steps}.isdisjoint(ROSENBROCK):
        what = "is not offered where the motor is on a joint that follows by loops or couplings: use w3"
        raise machine.error(f"steps, {', '.join(dependent)}", f"{ROSENBROCK[0]} {what}")


def _refuse_friction(machine: Machine, steps: Sequence[str]) -> None:
    """Raise `InputError` for laws of friction that the methods do not support."""
    lacking = [name for name in steps if name in WITHOUT_STATES]
    if machine.loaded and lacking:
        what = f"{lacking[0]} is not offered with friction that rises with load: use w3"
        raise machine.error(f"friction, {machine.joint(machine.loaded[0]).name}, load", what)
    if machine.bristles and lacking:
        what = f"{lacking[0]} is not offered with states of friction (bristle): use w3"
        raise machine.error(f"steps, {machine.joint(machine.bristles[0]).name}", what)


def _refuse_drives(machine: Machine, steps: Sequence[str]) -> None:
    """Raise `InputError` for methods that do not support states of drives."""
    lacking = [name for name in steps if name in WITHOUT_STATES]
    driven = [machine.joint(j).name for j in driven_motors(machine)]
    if lacking and driven:
        what = f"{lacking[0]} is not offered with drives: use w3, or leave [drives] out"
        raise machine.error(f"drives, {', '.join(driven)}", what)


def refuse_base(machine: Machine, steps: Sequence[str] = ()) -> None:
    """Raise `InputError` for a base with prescribed motion, and for methods that need exact derivatives."""
    if "V0d" in known_of_base(machine):
        what = 'the acceleration of the base is given, so it is not a state: write known = "wrench"'
        raise machine.error("base, known", what)
    if machine.degrees_of_base and not {*steps}.isdisjoint(ROSENBROCK):
        what = "needs exact derivatives, and linearization is not offered on a floating base: use w3"
        raise machine.error("steps", f"{ROSENBROCK[0]} {what}")


def ways_to_give_motors(machine: Machine) -> list[Motors]:
    """Return the possible inputs of motors; prescribed motion only where all motors are independent."""
    if not machine.motors:
        return [Motors.TORQUE]
    moves = len(machine.motors) < len(machine.independent) + machine.degrees_of_base
    follows = moves and not dependent_motors(machine)
    return [Motors.TORQUE, Motors.SERVO, *([Motors.DRIVEN] if follows else [])]


def dependent_motors(machine: Machine) -> tuple[int, ...]:
    """Return the numbers of the motors whose variables follow from loops."""
    return tuple(j for j in machine.motors if j not in machine.independent)


def motor_coordinates(
    machine: Machine, folded: Sequence[str] = (), position: Callable[[Bound, int], Scalar] | None = None
) -> TracedModel:
    """Return the model of the variables of all motors, x_m(u), and of their rates S_m ud (L1), (L2).

    `position` returns the measured position that replaces the variable of a motor.
    """
    bound = Bound(machine, folded)
    if bound.loops:
        name_geometry(bound, lambda j: Section("Geometry", j, "[1]"))
    results = _results(bound, position)
    model = Model(
        MOTOR_COORDINATES,
        "positions and velocities of the motors",
        "(L1), (L2)",
        (*position_blocks(machine), "qd"),
        tuple(results),
        lambda other, _: _results(other, position),
    )
    entries = bound.arguments()
    inputs = tuple(Input(name, entries[name]) for name in model.arguments)
    return schedule(prune(Trace(model, inputs, results, bound.graph, bound.names, True, ())))


def _results(bound: Bound, position: Callable[[Bound, int], Scalar] | None) -> Results:
    rates = bound.coordinates.rates_x
    read = position or (lambda bound, j: bound.variables[j])
    return {
        "q_motor": Result(bound.motors, tuple(read(bound, j) for j in bound.motors)),
        "qd_motor": Result(bound.motors, tuple(rates[j] for j in bound.motors)),
    }


def passed_torques(machine: Machine, folded: Sequence[str] = ()) -> TracedModel:
    """Return the model of lambda (l,), by the torques of motors, accelerations, and the lambda in friction.

    A second result (l,) are the sums of the amounts of its terms, with which rounding grows.
    """
    return schedule(prune(passed_trace(Bound(machine, folded))))


def passed_trace(bound: Bound) -> Trace:
    """Return the model of `passed_torques` as a trace."""
    results = _passed_results(bound)
    model = Model(
        PASSED_TORQUES,
        "torques through transmissions",
        "[12]",
        (*position_blocks(bound.machine), "qd", "qdd", "tau"),
        tuple(results),
        lambda other, _: _passed_results(other),
        own=(
            replace(quantity("load"), name=PASSED),
            replace(quantity("load"), name=TERMS, meaning="sum of the amounts of the terms of the load"),
        ),
    )
    model = with_friction_states(model, bound, results)
    entries = bound.arguments()
    inputs = tuple(Input(name, entries[name]) for name in model.arguments)
    return Trace(model, inputs, results, bound.graph, bound.names, True, ())


def _passed_results(bound: Bound) -> Results:
    qdd, loaded = bound.given_accelerations(), bound.machine.loaded
    links = bound.mechanism.links
    of_rotors = {j: links[j - 1].rotor_inertia * qdd[j] for j in loaded}
    passed = tuple(bound.exerted_torque(j) - of_rotors[j] for j in loaded)
    terms = ((bound.exerted_torque(j) + bound.friction(j), bound.friction(j), of_rotors[j]) for j in loaded)
    sizes = tuple(sum_of(amount(bound.graph, x) for x in of_joint) for of_joint in terms)
    return {PASSED: Result(loaded, passed), TERMS: Result(loaded, sizes)}
