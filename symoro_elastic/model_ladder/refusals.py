"""Machines that the linear model along a motion does not hold for."""

from __future__ import annotations

from symoro_elastic.machine.machine import Machine
from symoro_elastic.vibration.equations_of_motion import EquationsOfMotion, State
from symoro_elastic.vibration.following import refuse_sticking
from symoro_elastic.vibration.inertia import refuse_singular


def refuse_machine(motion: EquationsOfMotion, start: State) -> None:
    """Raise `InputError` for joints that depend on others, dry friction without a motor, and no inertia."""
    refuse_coupled(motion.given)
    refuse_sticking(motion)
    (M,) = motion.matrices("M", start.q, start.qd, start.qdd)
    refuse_singular(motion, M, range(len(start.q)), can_hold=False)


def refuse_coupled(machine: Machine) -> None:
    """Raise `InputError` where joints depend on the variables of others."""
    if not machine.is_coupled:
        return
    if machine.loops:
        raise machine.error(f"loop {machine.loops[0].name}", "the ladder treats trees without loops: use simulate")
    variables = set(machine.variables)
    for joint in machine.joints:
        others = variables & set(joint.selected.names) - {str(joint.variable)}
        if others:
            what = f"it follows {', '.join(sorted(others))}, and the ladder treats no coupled joints: use simulate"
            raise machine.error(f"joint {joint.name}", what)
