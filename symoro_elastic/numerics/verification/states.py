"""Test states of a machine, stacked: moderate and extreme ones, deterministic by seed."""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np

from symoro_elastic.foundation.array_types import Array, BoolArray
from symoro_elastic.machine.arguments import arguments
from symoro_elastic.machine.domain import Domain
from symoro_elastic.machine.machine import Joint, Kind, Machine
from symoro_elastic.mechanics.base_body import rotation_of
from symoro_elastic.models.bound.state import DEPENDENT, State, rows_of_state
from symoro_elastic.numerics.evaluation.assembled_states import assembled_states, start_of
from symoro_elastic.numerics.evaluation.values import ParameterValues, parameter_values
from symoro_elastic.quantities import MOTION, OF_JOINTS, ON_BASE, QUANTITIES, VELOCITIES, Quantity, Samples

STILL = ("at rest", "everything zero")
FAST = ("very fast and very slow", "everything extreme")
LOADED = ("large torques", "everything extreme")
ROTATIONS = ("R0", "Q0")

Rng = np.random.Generator

ARGUMENTS = tuple(row.name for row in OF_JOINTS)
MOTIONS = tuple(row.name for row in MOTION)


def depends_on_state(arguments: Sequence[str]) -> bool:
    """Return whether all arguments belong to a state of joints and motors, or to prescribed motions."""
    return {*arguments} <= {*ARGUMENTS, *MOTIONS, "q_static", "f_ext"}


ZERO = "everything zero"
MODERATE, EXTREME = 1, 2
"""Kinds of states: a part of their seeds."""
WORKING_LOAD, EXTREME_LOAD = 1e3, 1e6  # of springs, N or N m


@dataclass(frozen=True)
class States(State):
    """Test states; `titles` describe each state."""

    titles: tuple[str, ...]

    def __getitem__(self, samples: Any) -> Self:
        titles = np.atleast_1d(np.array(self.titles, dtype=object)[samples])
        return replace(super().__getitem__(samples), titles=tuple(titles.tolist()))

    def __add__(self, other: States) -> States:
        joined = {name: np.concatenate([block, other.blocks[name]]) for name, block in self.blocks.items()}
        return States(joined, self.titles + other.titles)


@dataclass(frozen=True)
class _Variable:
    """Properties of a joint that states depend on: kind, centre and extent of its ordinary motion, farthest reach."""

    revolute: bool
    motor: bool
    centre: float
    extent: float
    reach: float


_State = dict[str, list[float]]
"""Numbers by argument of a state of joints and motors."""


def moderate_states(machine: Machine, count: int, seed: int = 0, values: ParameterValues | None = None) -> States:
    """Angles within pi, slides within 0.5 m, velocities within 2, torques within 20, accelerations within 5.

    Elastic joints are within 0.5 of their neutral position in every other state, and otherwise
    within the deflection of 1 kN or 1 kN m. Joints of loops are near their start, where the loops close. Where a cell
    has no value, the variables of cells are drawn again.
    """
    values = values or parameter_values(machine, seed)
    variables, rng = _variables(machine, values), np.random.default_rng([seed, MODERATE])
    drawn = _moderate(variables, len(machine.motors), rng, np.arange(count) % 2 == 0)
    return _whole(machine, States(drawn, ("moderate",) * count), variables, values, seed, MODERATE)


def extreme_states(machine: Machine, count: int, seed: int = 0, values: ParameterValues | None = None) -> States:
    """States at the limits, each kind in turn; the rest of such a state is moderate.

    Rest; quarter turns, and one ulp off them; angles to 1e8 rad and slides to 10 m; velocities
    from 1e-6 to 1e6; torques and accelerations to 1e8; these together; everything zero. Elastic
    joints stay within the deflection of 1 MN or 1 MN m. Joints of loops stay near their start, where the loops close.
    """
    values = values or parameter_values(machine, seed)
    variables, rng = _variables(machine, values), np.random.default_rng([seed, EXTREME])
    blocks = _moderate(variables, len(machine.motors), rng, np.zeros(0, dtype=bool))
    titles = [EXTREMES[k % len(EXTREMES)] for k in range(count)]
    for k, (_, change) in enumerate(titles):
        moderate = _moderate(variables, len(machine.motors), rng, np.array([k % 2 == 0]))
        state = {name: block[0].tolist() for name, block in moderate.items()}
        change(state, variables, rng)
        blocks = {name: np.concatenate([block, [state[name]]]) for name, block in blocks.items()}
    states = States(blocks, tuple(title for title, _ in titles))
    return _whole(machine, states, variables, values, seed, EXTREME)


def _whole(
    machine: Machine, states: States, variables: Sequence[_Variable], values: ParameterValues, seed: int, kind: int
) -> States:
    """Return states with all blocks that the machine has: loops closed, static joints, wrenches, base, motions."""
    states = _make_defined(machine, _assemble(machine, states, values, seed), values, seed)
    motors = [k for k, variable in enumerate(variables) if variable.motor]
    q, qd, qdd = (block[:, motors] for block in (states.q, states.qd, states.qdd))
    motions = reference_motions(q, qd, qdd, states.titles, np.random.default_rng([seed, 4 + kind]))
    more = {
        "q_static": _deflections(machine, len(states), values, np.random.default_rng([seed, 6 + kind])),
        "f_ext": _wrenches(machine, states.titles, np.random.default_rng([seed, 8 + kind])),
        **(base_states(states.titles, np.random.default_rng([seed, 2 + kind])) if machine.degrees_of_base else {}),
        **dict(zip(MOTIONS, motions.transpose(1, 0, 2), strict=True)),
    }
    rng, entries = np.random.default_rng([seed, 10 + kind]), arguments(machine)
    for row in rows_of_state(machine):
        if row.name not in states.blocks and row.name not in more:
            more[row.name] = drawn_entries(rng, len(entries[row.name]), row.samples, states.titles)
    had = {row.name for row in rows_of_state(machine)}
    return states.with_blocks(**{name: block for name, block in more.items() if name in had})


def _assemble(machine: Machine, states: States, values: ParameterValues, seed: int) -> States:
    """The states, the joints of loops at assembled positions near their start."""
    if not machine.loops:
        return states
    q, q_dep = assembled_states(machine, len(states), seed, values)
    in_loops = np.array([j in machine.in_loops for j in machine.independent], dtype=bool)
    return states.with_blocks(q=np.where(in_loops, q, states.q), **{DEPENDENT: q_dep})


def _make_defined(machine: Machine, states: States, values: ParameterValues, seed: int) -> States:
    """Return states at which all cells have values; raises `InputError` for a cell that has none at any position."""
    domain, source = Domain(machine), random.Random(seed)
    if not domain.free:
        return states
    rows, dependent = states.q.copy(), [str(machine.joint(j).variable) for j in machine.dependent]
    names = [str(machine.joint(j).variable) for j in machine.independent]
    for k in range(len(states)):
        symbols = {**values, **dict(zip(names, rows[k].tolist(), strict=True))}
        symbols |= zip(dependent, states.q_dep[k].tolist(), strict=True)
        defined = domain.nearest_defined(symbols, source)
        if defined is not None:
            rows[k] = [defined[name] for name in names]
        elif refusal := domain.refusal(symbols):
            raise refusal
    return states.with_blocks(q=rows)


def _deflections(machine: Machine, count: int, values: ParameterValues, rng: Rng) -> Array:
    """Positions of static joints, within the deflections of a working load."""
    variables = [_variable(joint, values) for joint in machine.static_springs.values()]
    drawn = [[x.centre + x.extent * float(rng.uniform(-1, 1)) for _ in range(count)] for x in variables]
    return np.array(drawn).reshape(len(drawn), count).T


def _wrenches(machine: Machine, titles: Sequence[str], rng: Rng) -> Array:
    """Moderate wrenches on frames; none where everything is zero."""
    drawn = _within(QUANTITIES["f_ext"], rng.random((len(titles), 6 * len(machine.forces))))
    acting = np.array([title != ZERO for title in titles], dtype=float)
    return np.asarray(acting[:, None] * drawn)


def _variables(machine: Machine, values: ParameterValues) -> list[_Variable]:
    at_start = values | start_of(machine).by_variable
    return [_variable(joint, at_start) for joint in machine.independent_joints]


def _variable(joint: Joint, values: ParameterValues) -> _Variable:
    revolute = joint.sigma == 0
    if joint.kind is not Kind.ELASTIC:
        return _Variable(revolute, joint.kind is Kind.MOTOR, 0.0, math.pi if revolute else 0.5, math.inf)
    stiffness, neutral = joint.spring.stiffness.value(values), joint.spring.neutral.value(values)
    compliance = 1 / stiffness if stiffness > 0 else math.inf
    extent = min(0.5, max(WORKING_LOAD * compliance, 1e-2 * abs(neutral)))
    return _Variable(revolute, False, neutral, extent, EXTREME_LOAD * compliance)


def _moderate(variables: Sequence[_Variable], motors: int, rng: Rng, wide: BoolArray) -> dict[str, Array]:
    """Return moderate blocks of joints, by state; where `wide`, positions range at least 0.5 about the centre."""
    sizes = [motors if row.shape == "m" else len(variables) for row in OF_JOINTS]
    positions, *others = np.split(rng.random((len(wide), sum(sizes))), np.cumsum(sizes)[:-1], axis=1)
    extents = np.array([v.extent for v in variables])
    extents = np.where(wide[:, None], np.maximum(extents, 0.5), extents)
    blocks = {ARGUMENTS[0]: np.array([v.centre for v in variables]) + extents * (2 * positions - 1)}
    return blocks | {row.name: _within(row, x) for row, x in zip(OF_JOINTS[1:], others, strict=True)}


def _within(row: Quantity, numbers: Array) -> Array:
    """Map numbers from 0 to 1 to the moderate range of a quantity, -size to size."""
    size = row.samples.size if row.samples else 0.0
    return 2 * size * numbers - size


def _magnitude(rng: Rng, low: float, high: float) -> float:
    """Either sign, its size spread evenly over the decades from 10^low to 10^high."""
    return float(10 ** rng.uniform(low, high) * rng.choice([-1.0, 1.0]))


def _extreme(rng: Rng, argument: str) -> float:
    samples = QUANTITIES[argument].samples
    return _magnitude(rng, *samples.decades) if samples and samples.decades else 0.0


def _rest(state: _State, variables: Sequence[_Variable], rng: Rng) -> None:
    state.update({name: [0.0] * len(x) for name, x in state.items() if name != "q"})


def _quarter_turns(state: _State, variables: Sequence[_Variable], rng: Rng) -> None:
    for k, variable in enumerate(variables):
        turn = int(rng.integers(-4, 5)) * math.pi / 2
        if variable.revolute and abs(turn - variable.centre) <= variable.reach:
            state["q"][k] = turn


def _nearly_quarter_turns(state: _State, variables: Sequence[_Variable], rng: Rng) -> None:
    _quarter_turns(state, variables, rng)
    for k, variable in enumerate(variables):
        if variable.revolute:
            state["q"][k] = math.nextafter(state["q"][k], math.copysign(math.inf, rng.uniform(-1, 1)))


def _far(state: _State, variables: Sequence[_Variable], rng: Rng) -> None:
    for k, variable in enumerate(variables):
        away = _magnitude(rng, 2, 8) if variable.revolute else _magnitude(rng, -3, 1)
        state["q"][k] = variable.centre + min(variable.reach, max(-variable.reach, away))


def _velocities(state: _State, variables: Sequence[_Variable], rng: Rng) -> None:
    state["qd"] = [0.0 if rng.random() < 0.2 else _extreme(rng, "qd") for _ in state["qd"]]


def _torques(state: _State, variables: Sequence[_Variable], rng: Rng) -> None:
    for name in ("tau", "qdd_motor", "qdd"):
        state[name] = [_extreme(rng, name) for _ in state[name]]


def _everything(state: _State, variables: Sequence[_Variable], rng: Rng) -> None:
    _far(state, variables, rng)
    _velocities(state, variables, rng)
    _torques(state, variables, rng)


def _zero(state: _State, variables: Sequence[_Variable], rng: Rng) -> None:
    state.update({name: [0.0] * len(x) for name, x in state.items()})


EXTREMES: tuple[tuple[str, Callable[[_State, Sequence[_Variable], Rng], None]], ...] = (
    ("at rest", _rest),
    ("at quarter turns", _quarter_turns),
    ("one ulp off quarter turns", _nearly_quarter_turns),
    ("far away", _far),
    ("very fast and very slow", _velocities),
    ("large torques", _torques),
    ("everything extreme", _everything),
    (ZERO, _zero),
)


# Test trajectories of feed-forward: all their derivatives are as moderate or extreme as their state.
def reference_motions(q: Array, qd: Array, qdd: Array, titles: Sequence[str], rng: np.random.Generator) -> Array:
    """Return y and its derivatives, (N, 13, m), from q, qd, qdd of motors (N, m).

    Each further derivative is up to w times the one before, w from 1 to 100 1/s; with large loads all are to 1e8.
    """
    motions = np.zeros((len(titles), len(MOTION), q.shape[1]))
    motions[:, 0], motions[:, 1], motions[:, 2] = q, qd, qdd
    for state, title in enumerate(titles):
        further = motions[state, 3:]
        if title in LOADED:
            further[:] = 10 ** rng.uniform(2, 8, further.shape) * rng.choice([-1.0, 1.0], further.shape)
        elif title not in STILL:
            rate = 10 ** rng.uniform(0, 2)
            further[:] = rng.uniform(-5, 5, further.shape) * rate ** np.arange(1, len(further) + 1)[:, None]
    return motions


# Test states of a base that moves freely, as moderate or extreme as those of the joints it carries.
def base_states(titles: Sequence[str], rng: np.random.Generator) -> dict[str, Array]:
    """Return R0, Q0, P0, V0, V0d, f0 of all states, stacked: any orientation, within 10 m, velocities within 2,
    accelerations within 5 and wrenches within 20; of an extreme state as the title says.
    """
    drawn = [_base_state(title, rng) for title in titles]
    return {row.name: np.array([state[row.name] for state in drawn]).reshape(-1, len(row.entries)) for row in ON_BASE}


def drawn_entries(rng: np.random.Generator, count: int, samples: Samples | None, titles: Sequence[str]) -> Array:
    """Return entries of an argument at each state, by its samples and the titles; zeros without samples."""
    rows = [_entries(rng, count, samples or Samples(0), title) for title in titles]
    return np.array(rows).reshape(len(titles), count)


def _base_state(title: str, rng: np.random.Generator) -> dict[str, Array]:
    quaternion = np.array([1.0, 0.0, 0.0, 0.0]) if title == "everything zero" else rng.normal(size=4)
    quaternion = quaternion / np.linalg.norm(quaternion)
    rotations = dict(zip(ROTATIONS, (np.array(rotation_of(quaternion.tolist())).ravel(), quaternion), strict=True))
    sampled = ((row, row.samples) for row in ON_BASE if row.samples)
    return rotations | {row.name: _entries(rng, len(row.entries), samples, title) for row, samples in sampled}


def _entries(rng: np.random.Generator, count: int, samples: Samples, title: str) -> Array:
    """Return random numbers: moderate ones, extreme ones where the title says so, or zeros."""
    if title in STILL:
        return np.zeros(count)
    if samples.decades is None or title not in (FAST if samples is VELOCITIES else LOADED):
        return rng.uniform(-samples.size, samples.size, count)
    return np.asarray(10 ** rng.uniform(*samples.decades, count) * rng.choice([-1.0, 1.0], count))
