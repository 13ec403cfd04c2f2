"""Positions and velocities of motors on dependent joints, as servos inside time steps need them."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from symoro_elastic.foundation.scalar import Scalar
from symoro_elastic.machine.machine import Machine
from symoro_elastic.models.bind import Bound
from symoro_elastic.models.implicit_steps import FAMILY
from symoro_elastic.models.model import Model, Result, Results, TracedModel
from symoro_elastic.models.naming import name_geometry
from symoro_elastic.models.state import position_blocks
from symoro_elastic.models.tracing import Trace, prune, schedule
from symoro_elastic.symbolic.program import Input, Section

MOTOR_COORDINATES = "motor_coordinates"


def dependent_motors(machine: Machine) -> tuple[int, ...]:
    """Return the numbers of the motors whose variables follow from loops."""
    return tuple(j for j in machine.motors if j not in machine.independent)


def motor_coordinates(
    machine: Machine, folded: Sequence[str] = (), position: Callable[[Bound, int], Scalar] | None = None
) -> TracedModel:
    """Return the model of the variables of all motors, x_m(u), and of their rates S_m ud (L1), (L2).

    `position` gives what is measured in place of the variable of a motor.
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
        FAMILY,
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
