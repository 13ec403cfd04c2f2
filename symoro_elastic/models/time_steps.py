"""The models that generated time steps call."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence

from symoro_elastic.machine.machine import Machine
from symoro_elastic.models.catalogue import trace
from symoro_elastic.models.implicit_steps import Motors, implicit_system
from symoro_elastic.models.model import TracedModel

EXPLICIT, ROSENBROCK = ("rk4",), ("rodas4",)


def models_of_steps(
    machine: Machine, steps: Sequence[str], folded: Sequence[str], at_hand: Collection[str]
) -> Iterator[TracedModel]:
    """Yield the models that steps of some methods call, without those `at_hand`; raises `InputError`."""
    if not steps:
        return
    if machine.floating:
        what = "time steps are not offered on a floating base, whose pose is no entry of q: leave them out"
        raise machine.error("steps", what)
    names = {"direct_dynamics": True, "linearization": not {*steps}.isdisjoint(ROSENBROCK)}
    names["inverse_dynamics"] = Motors.DRIVEN in ways_to_give_motors(machine)
    found = [trace(machine, name, folded=folded) for name, needed in names.items() if needed and name not in at_hand]
    yield from found
    takes_dependent = any("q_dep" in model.model.arguments for model in found)
    if takes_dependent and "assemble" not in at_hand:
        yield trace(machine, "assemble", folded=folded)
    if not {*steps} <= {*EXPLICIT, *ROSENBROCK}:
        for motors in ways_to_give_motors(machine):
            yield from implicit_system(machine, motors, folded)


def ways_to_give_motors(machine: Machine) -> list[Motors]:
    """Return what may be known of motors: servos and motions only where they own independent variables."""
    if not machine.motors or not {*machine.motors} <= {*machine.moving}:
        return [Motors.TORQUE]
    follows = len(machine.motors) < len(machine.moving)
    return [Motors.TORQUE, Motors.SERVO, *([Motors.DRIVEN] if follows else [])]
