"""Names of the entries of arguments of generated functions, and of what derivatives may be taken by."""

from __future__ import annotations

from symoro_elastic.machine.machine import Given, Machine

ON_BASE = {
    "R0": tuple(f"A0_{m}{n}" for m in range(1, 4) for n in range(1, 4)),
    "Q0": tuple(f"Q0_{x}" for x in "wxyz"),
    "P0": tuple(f"P0_{x}" for x in "xyz"),
    "V0": tuple(f"V0_{k}" for k in range(1, 7)),
    "V0d": tuple(f"Vd0_{k}" for k in range(1, 7)),
    "f0": tuple(f"F0_{k}" for k in range(1, 7)),
}
"""Entries of the arguments that belong to a floating base."""
POSE = tuple(f"pose_{k}" for k in range(1, 7))
"""A small displacement (m), then a small rotation (rad) of a floating base, in its axes."""
DIFFERENTIATED = {
    "inverse_dynamics_derivatives": ("q", "qd", "qdd_motor"),
    "direct_dynamics_derivatives": ("q", "qd", "tau"),
    "inverse_dynamics_parameter_derivatives": (),
    "direct_dynamics_parameter_derivatives": (),
}
"""Arguments that the columns of models of derivatives follow; none where they follow parameters."""


def arguments(machine: Machine) -> dict[str, tuple[str, ...]]:
    """Names of the entries of each argument that follows joints or the base."""
    return {
        "q": tuple(str(joint.variable) for joint in machine.moving_joints),
        "qd": tuple(f"qd{j}" for j in machine.moving),
        "qdd": tuple(f"qdd{j}" for j in machine.moving),
        "tau": tuple(f"tau{j}" for j in machine.motors),
        "qdd_motor": tuple(f"qdd{j}" for j in machine.motors),
        **ON_BASE,
        "pose": POSE,
    }


def may_be_asked_by(machine: Machine, model: str) -> tuple[str, ...]:
    """Names that a model of derivatives may be asked by: parameters, or arguments and their entries."""
    if not DIFFERENTIATED[model]:
        return tuple(parameter.name for parameter in machine.parameters)
    entries = arguments(machine)
    columns = (*DIFFERENTIATED[model], *columns_of_base(machine))
    return tuple(name for argument in columns for name in (argument, *entries[argument]))


def columns_of_base(machine: Machine) -> tuple[str, ...]:
    """What derivatives are taken by on a floating base, in addition."""
    if machine.floating is None:
        return ()
    return "pose", "V0", "V0d" if machine.floating.known is Given.ACCELERATION else "f0"
