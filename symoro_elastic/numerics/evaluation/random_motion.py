"""A machine of numbers in random motion: at many states at once, its loops closed."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from symoro_elastic.foundation.array_types import Array, BoolArray
from symoro_elastic.machine.machine import Machine
from symoro_elastic.mechanics.coordinates import Rows, projection
from symoro_elastic.mechanics.dynamics import AccelerationKnown, Dynamics, Rule, dynamics
from symoro_elastic.mechanics.mechanism import Link, Mechanism
from symoro_elastic.mechanics.spatial import AxialTransform, Axis, Transform, Twist, Vector, Z
from symoro_elastic.models.bound.bind import Bound
from symoro_elastic.models.bound.state import State
from symoro_elastic.models.parameters.base_parameters import ZeroPosition
from symoro_elastic.numerics.evaluation.arrays import arithmetic
from symoro_elastic.numerics.evaluation.assembled_states import start_of
from symoro_elastic.numerics.evaluation.closed_positions import drawn_values, with_dependent
from symoro_elastic.symbolic.arithmetic import evaluate

SLIDE, VELOCITY, ACCELERATION, OF_BASE = 0.5, 3.0, 5.0, 5.0
REGULAR = 10.0
"""Times the median: entries of S and gam, condition numbers of W_d beyond it are of positions nearly singular."""
DRAWN, HALVINGS = 4, 6
"""States that are drawn for one that is wanted; how often twice as many are drawn half as far from the start."""


@dataclass(frozen=True)
class RandomMotion:
    """Numeric mechanism at many states at once, with its dynamics, accelerations of its joints, and S = dq/du.

    `closed` are the arguments of a machine with couplings or loops at these states.
    """

    mechanism: Mechanism
    dynamics: Dynamics
    qdd: Mapping[int, Any]
    S: Rows
    independent: tuple[int, ...]
    states: int
    closed: Mapping[str, Array]

    def torques(self) -> Array:
        """Return S^T Gamma (states, independent): inertia, gravity and external wrenches."""
        return self.on_independent(self.dynamics.Gamma)

    def on_independent(self, Gamma: Mapping[int, Any]) -> Array:
        """Return S^T Gamma (states, independent) of forces of joints."""
        rows = np.zeros((len(self.independent), self.states))
        forces: Mapping[int, Any] = projection(self.S, Gamma)
        for k, force in forces.items():
            rows[self.independent.index(k)] = force
        return rows.T


def random_motion(
    machine: Machine,
    states: int,
    seed: int = 0,
    values: Mapping[str, float] | None = None,
    closed: Mapping[str, Array] | None = None,
) -> RandomMotion:
    """Return a machine at random states: angles within pi, slides 0.5 m, velocities 3, accelerations 5.

    A base that moves does so at random too, whatever its values. Parameters without value are drawn. Loops are closed,
    at positions about their start; `closed` are those of another machine of this geometry, at the same seed.
    """
    values = drawn_values(machine, seed) if values is None else values
    rng = np.random.default_rng([seed, 3])
    if machine.is_coupled:
        return _of_coupled(machine, states, rng, values, closed)
    return _of_tree(machine, states, rng, values)


def _of_tree(machine: Machine, states: int, rng: np.random.Generator, values: Mapping[str, float]) -> RandomMotion:
    zero = ZeroPosition(machine)
    mechanism = zero.floats(values)
    n = len(machine.joints) + 1
    angles = rng.uniform(-math.pi, math.pi, (n, states))
    qd, qdd = rng.uniform(-VELOCITY, VELOCITY, (n, states)), rng.uniform(-ACCELERATION, ACCELERATION, (n, states))
    links = tuple(_displace(link, angles[j]) for j, link in mechanism.from_base())
    moved = replace(mechanism, links=links, **_moving_base(zero, rng, states))
    S = {j: {j: 1} for j in machine.independent}
    rates, accelerations = dict(enumerate(qd)), dict(enumerate(qdd))
    return RandomMotion(moved, _motion(moved, rates, accelerations), accelerations, S, machine.independent, states, {})


def _displace(link: Link, variable: Any) -> Link:
    if link.axis is Axis.NONE:
        return link
    moved = AxialTransform(Z, np.cos(variable), np.sin(variable), 0)
    if link.axis is Axis.PRISMATIC:
        moved = AxialTransform(Z, 1, 0, variable * (SLIDE / math.pi))
    return replace(link, transform=Transform((*link.transform.steps, moved)))


def _moving_base(zero: ZeroPosition, rng: np.random.Generator, states: int) -> dict[str, Any]:
    """Velocity and acceleration of a base that moves."""
    if not zero.free_base:
        return {}
    velocity, angular, acceleration, turning = (Vector(*rng.uniform(-OF_BASE, OF_BASE, (3, states))) for _ in range(4))
    return {"velocity": Twist(velocity, angular), "acceleration": Twist(acceleration, turning)}


def _motion(mechanism: Mechanism, qd: Mapping[int, Any], qdd: Mapping[int, Any]) -> Dynamics:
    """Return the motion of a mechanism with these rates and accelerations."""
    rules: list[Rule | None] = [None] * (len(mechanism.links) + 1)
    rates: list[Any] = [0.0] * (len(mechanism.links) + 1)
    for j, link in mechanism.from_base():
        if link.axis is not Axis.NONE:
            rules[j], rates[j] = AccelerationKnown(qdd[j]), qd[j]
    return dynamics(mechanism, rates, rules)


def _of_coupled(
    machine: Machine,
    states: int,
    rng: np.random.Generator,
    values: Mapping[str, float],
    closed: Mapping[str, Array] | None,
) -> RandomMotion:
    """Positions q = F(u), rates S ud and accelerations S udd + gam, by the equations bound to the machine."""
    bound = Bound(machine)
    base = _moving_base(ZeroPosition(machine), rng, states)
    blocks = closed or closed_states(bound, states, rng, values)
    symbols = _symbols(bound, blocks)
    leaves = [*bound.mechanism.scalars(), *_coupling(bound), *bound.rates(), *bound.given_accelerations()]
    number = evaluate(leaves, {**values, **symbols}, arithmetic(float))
    S = {j: {k: number(x) for k, x in row.items()} for j, row in bound.coordinates.S.items()}
    qd, qdd = (dict(enumerate(map(number, x))) for x in (bound.rates(), bound.given_accelerations()))
    mechanism = replace(bound.mechanism.map(number), **base)
    return RandomMotion(mechanism, _motion(mechanism, qd, qdd), qdd, S, machine.independent, states, blocks)


def closed_states(bound: Bound, states: int, rng: np.random.Generator, values: Mapping[str, float]) -> dict[str, Array]:
    """Return random q, qd, qdd (states, n) and the other position arguments, with loops closed and not nearly singular.

    Positions are about the start, on its branch. Raises `InputError` where too few are found.
    """
    for halving in range(HALVINGS):
        drawn = DRAWN * 2**halving * states
        blocks = _draw_arguments(bound, drawn, 0.5**halving, rng, values)
        leaves = [*_coupling(bound), *(x for columns in _matrices(bound) for column in columns for x in column)]
        with np.errstate(all="ignore"):
            value = evaluate(leaves, {**values, **_symbols(bound, blocks)}, arithmetic(float))
            good = np.flatnonzero(_regular(bound, partial(_at_all, value, drawn)))
        if len(good) >= states:
            return {name: block[good[:states]] for name, block in blocks.items()}
    what = "no positions about start at which they close and are not singular: move start to the intended side"
    if not bound.machine.loops:
        what = "too few random positions at which their cells have a value"
    raise bound.machine.error(", ".join(f"loop {loop.name}" for loop in bound.machine.loops) or "joints", what)


def _at_all(value: Callable[[Any], Any], states: int, x: Any) -> Array:
    return np.broadcast_to(value(x), states)


def _draw_arguments(
    bound: Bound, states: int, reach: float, rng: np.random.Generator, values: Mapping[str, float]
) -> dict[str, Array]:
    """Arguments at random states about the start, the first one there."""
    machine, n = bound.machine, len(bound.machine.independent)
    far = np.array([reach * (SLIDE if joint.sigma == 1 else math.pi) for joint in machine.independent_joints])
    q = start_of(machine).q + far * rng.uniform(-1, 1, (states, n))
    q[:1] = start_of(machine).q
    qd = rng.uniform(-VELOCITY, VELOCITY, (states, n))
    qdd = rng.uniform(-ACCELERATION, ACCELERATION, (states, n))
    return dict(with_dependent(machine, State({"q": q, "qd": qd, "qdd": qdd}), values).blocks)


def _symbols(bound: Bound, blocks: Mapping[str, Array]) -> dict[str, Array]:
    names = bound.arguments()
    return {name: column for key, block in blocks.items() for name, column in zip(names[key], block.T, strict=True)}


def _coupling(bound: Bound) -> list[Any]:
    """Entries of S, and gam."""
    coordinates = bound.coordinates
    return [x for row in coordinates.S.values() for x in row.values()] + list(coordinates.gam.values())


def _matrices(bound: Bound) -> list[list[list[Any]]]:
    """Return the columns of W_d for each block of loops."""
    return [bound.coordinates.columns_of(block) for block in bound.coordinates.blocks]


def _regular(bound: Bound, value: Callable[[Any], Array]) -> BoolArray:
    """Return where loops close on the branch of the first state, which is the start, and none is nearly singular."""
    values, good = [value(x) for x in _coupling(bound)], np.array(True)
    for columns in _matrices(bound):
        W = np.moveaxis(np.nan_to_num(np.array([[value(x) for x in column] for column in columns])), -1, 0)
        side = np.sign(np.linalg.det(W))
        good = good & (side == side[0])
        values.append(np.linalg.cond(W))
    for entries in values:
        finite = np.isfinite(entries)
        usual = np.median(np.abs(entries[finite])) if finite.any() else 0.0
        good = good & finite & ((np.abs(entries) <= REGULAR * usual) | (usual == 0.0))
    return good
