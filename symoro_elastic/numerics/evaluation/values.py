"""Values for parameters without one: physically possible, deterministic by seed.

The name of a parameter says nothing about its size; the cells of the table in which it occurs do.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from symoro_elastic.machine.columns import Dimension, cells
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import Base, Body, Joint, Machine
from symoro_elastic.models.loops.plan import plan_of

ParameterValues = dict[str, float]
Draw = Callable[[np.random.Generator], float]

ATTEMPTS = 50
DIAGONAL = (0, 3, 5)
PAIRS = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))


class NoValues(Exception):
    """Raised, with the name of the cell, where a cell of the table has no real value in any draw."""


def _between(low: float, high: float) -> Draw:
    return lambda rng: float(rng.uniform(low, high))


def _either_sign(low: float, high: float) -> Draw:
    return lambda rng: float(rng.uniform(low, high) * rng.choice([-1.0, 1.0]))


ORDER_ONE = _between(0.3, 1.5)
ANGLE, LENGTH = _either_sign(0.3, 1.2), _either_sign(0.2, 1.0)  # rad, m
ROTOR, STIFFNESS, DAMPING, NEUTRAL = _between(0.1, 1.0), _between(100, 1000), _between(0.1, 1.0), _between(-0.2, 0.2)
FRICTION, FORCE, GRAVITY, MOTION = _between(0.1, 1.0), _either_sign(1, 10), _either_sign(5, 10), _either_sign(0.3, 2)
MASS, CREEP = _between(1.0, 5.0), _between(0.05, 0.5)  # kg; rad/s, m/s


def _one(rng: np.random.Generator) -> float:
    return 1.0


DRAWS: dict[Dimension, Draw] = {
    Dimension.ANGLE: ANGLE,
    Dimension.LENGTH: LENGTH,
    Dimension.ROTOR_INERTIA: ROTOR,
    Dimension.STIFFNESS: STIFFNESS,
    Dimension.DAMPING: DAMPING,
    Dimension.POSITION: NEUTRAL,
    Dimension.VISCOUS_FRICTION: FRICTION,
    Dimension.COULOMB_FRICTION: FRICTION,
    Dimension.CREEP: CREEP,
    Dimension.SHARE: _between(0.1, 0.8),
    Dimension.BACKLASH: _between(0.05, 0.5),
    Dimension.RESISTANCE: ORDER_ONE,
    Dimension.INDUCTANCE: ORDER_ONE,
    Dimension.TORQUE_CONSTANT: ORDER_ONE,
    Dimension.BACK_EMF: ORDER_ONE,
    Dimension.FORCE: FORCE,
    Dimension.MOMENT: FORCE,
    Dimension.VELOCITY: MOTION,
    Dimension.ANGULAR_VELOCITY: MOTION,
    Dimension.ACCELERATION: MOTION,
    Dimension.ANGULAR_ACCELERATION: MOTION,
    Dimension.GRAVITY: GRAVITY,
    Dimension.NUMBER: _one,
    Dimension.RATIO: _one,
}
"""Distributions by dimension, in the order of the draws; a cell without a name draws, too, as bodies use its number."""

DRAWS_WHERE_NAMED: dict[Dimension, Draw] = {
    Dimension.COGGING: FRICTION,
    Dimension.PER_TURN: _between(1.0, 3.0),
    Dimension.PHASE: _either_sign(0.1, 1),
    Dimension.LINEAR_DAMPING: DAMPING,
    Dimension.ANGULAR_DAMPING: DAMPING,
}
"""Distributions drawn last, for named cells only: a new kind of cell does not change the numbers of other machines."""


def parameter_values(machine: Machine, seed: int = 0) -> ParameterValues:
    """Return a value for every parameter: its own where the machine gives one, else a random one.

    Masses of some kg, tensors of bodies that exist, positive rotor inertias (kg m2 or kg) and
    stiffnesses (N m/rad or N/m), lengths near 1 m. A name that no cell holds alone is a positive
    number of order one. Raises `NoValues` where a formula stays undefined, such as sqrt(1 - A^2).
    """
    undefined = ""
    for attempt in range(ATTEMPTS):
        values = _draw(machine, np.random.default_rng([seed, attempt]))
        undefined = _undefined_cell(machine, values)
        if not undefined:
            return values
    raise NoValues(f"{undefined}: no real value in {ATTEMPTS} draws of the parameters; give them values")


def given_values(machine: Machine) -> ParameterValues:
    """Return the values that the machine gives to its parameters."""
    return machine.given_values


def _draw(machine: Machine, rng: np.random.Generator) -> ParameterValues:
    values = given_values(machine) | _assembled_values(machine)
    for joint in machine.joints:
        _settle_cells(values, joint, rng)
        _settle_body(values, joint.body, rng)
    for body in machine.free_bodies:
        _settle_body(values, body, rng)
    _settle_cells(values, machine.base, rng)
    for parameter in machine.parameters:
        values.setdefault(parameter.name, ORDER_ONE(rng))
    return {parameter.name: values[parameter.name] for parameter in machine.parameters}


def _assembled_values(machine: Machine) -> ParameterValues:
    """Return values of the parameters that place the frames of a machine with loops, such that its loops close."""
    if not machine.loops:
        return {}
    values = plan_of(machine).assembly.values
    placing = (formula for joint in machine.joints for cell, formula in cells(joint) if cell.column.section == "joints")
    return {name: values[name] for formula in placing for name in formula.names if name in values}


def _settle(values: ParameterValues, formula: Formula, value: float) -> None:
    """Set the value of a cell that is one name, or its negative, unless the name has a value."""
    match formula.tree:
        case ("name", name):
            values.setdefault(name, value)
        case ("neg", ("name", name)):
            values.setdefault(name, abs(value))


def _settle_cells(values: ParameterValues, owner: Joint | Base, rng: np.random.Generator) -> None:
    """Draw values for the cells of a joint or base, except those of its body."""
    formulas = [(cell.column, formula) for cell, formula in cells(owner) if cell.column.section != "bodies"]
    draws = DRAWS | DRAWS_WHERE_NAMED
    order = list(draws)
    for column, formula in sorted(formulas, key=lambda row: order.index(row[0].dimension)):
        if formula.names or column.dimension in DRAWS:
            _settle(values, formula, draws[column.dimension](rng))


def _settle_body(values: ParameterValues, body: Body, rng: np.random.Generator) -> None:
    """Draw the mass of a body, then its centre, then its inertia: a nearly round body about the centre of mass.

    Any tensor so drawn, and any mixture of several, is possible: its moments about the centre of
    mass are m (0.05 .. 0.065) m2, its products at most m 0.0025 m2.
    """
    _settle(values, body.mass, MASS(rng))
    mass = body.mass.known_value(values) or 1.0
    for formula in body.moments:
        _settle(values, formula, float(rng.uniform(-0.1, 0.1)) * (1.0 if body.central else mass))
    moments = [formula.known_value(values) or 0.0 for formula in body.moments]
    square = sum(x * x for x in moments)
    for k, (m, n) in enumerate(PAIRS):
        about_centre = rng.uniform(1.0, 1.3) if k in DIAGONAL else rng.uniform(-0.05, 0.05)
        shift = 0.0 if body.central else ((square if m == n else 0.0) - moments[m] * moments[n]) / mass
        _settle(values, body.inertia[k], float(0.05 * mass * about_centre + shift))


def _undefined_cell(machine: Machine, values: ParameterValues) -> str:
    """Return the first cell without a finite real value, "" without one; cells with joint variables are skipped."""
    for j, joint in enumerate(machine.joints, start=1):
        for _, formula in cells(joint):
            if formula.names.isdisjoint(machine.variables) and formula.known_value(values) is None:
                return f"joint {j} ({joint.name}), {formula}"
    for cell, formula in (pair for owner in (*machine.free_bodies, machine.base) for pair in cells(owner)):
        if formula.known_value(values) is None:
            return cell.column.key
    return ""
