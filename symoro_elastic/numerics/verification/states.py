"""Test states of a machine, stacked: moderate and extreme ones, deterministic by seed."""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from symoro_elastic.array_types import Array
from symoro_elastic.machine.domain import Domain
from symoro_elastic.machine.machine import Joint, Kind, Machine
from symoro_elastic.numerics.assembled_states import assembled_states, start_of
from symoro_elastic.numerics.base_states import base_states
from symoro_elastic.numerics.reference_motions import reference_motions
from symoro_elastic.numerics.values import ParameterValues, parameter_values
from symoro_elastic.quantities import MOTION, ON_BASE, QUANTITIES, STATE, Quantity

Rng = np.random.Generator

ARGUMENTS = tuple(row.name for row in STATE)
MOTIONS = tuple(row.name for row in MOTION)


def depends_on_state(arguments: Sequence[str]) -> bool:
    """Whether arguments are those of a state of joints and motors, or wanted motions."""
    return {*arguments} <= {*ARGUMENTS, *MOTIONS, "q_static", "f_ext"}


def _none() -> Array:
    return np.empty((0, 0))


ZERO = "everything zero"
WORKING_LOAD, EXTREME_LOAD = 1e3, 1e6  # of springs, N or N m


@dataclass(frozen=True)
class States:
    """States along the first axis: q, qd, qdd of the moving joints, tau and qdd_motor of the motors.

    SI units, radians; `titles` says what is special about each state. R0 to f0 belong to a floating base, q_dep to
    loops, q_static to static springs, f_ext to frames under wrenches, and are empty where there is none. `motion`
    (N, 13, m) holds reference motions: y, yd ... by their names.
    """

    q: Array
    qd: Array
    tau: Array
    qdd_motor: Array
    qdd: Array
    titles: tuple[str, ...]
    R0: Array = field(default_factory=_none)
    Q0: Array = field(default_factory=_none)
    P0: Array = field(default_factory=_none)
    V0: Array = field(default_factory=_none)
    V0d: Array = field(default_factory=_none)
    f0: Array = field(default_factory=_none)
    motion: Array = field(default_factory=_none)
    q_dep: Array = field(default_factory=_none)
    q_static: Array = field(default_factory=_none)
    f_ext: Array = field(default_factory=_none)

    def __getattr__(self, name: str) -> Array:
        """y or one of its derivatives (N, m)."""
        if name not in MOTIONS:
            raise AttributeError(name)
        rows: Array = self.motion[:, MOTIONS.index(name)]
        return rows

    @property
    def arguments(self) -> tuple[str, ...]:
        """Names of the arrays that have values."""
        on_base = tuple(row.name for row in ON_BASE) if self.V0.shape[1] else ()
        more = tuple(name for name in ("q_dep", "q_static", "f_ext") if getattr(self, name).shape[1])
        return (*ARGUMENTS, *more, *on_base, *(("motion",) if self.motion.size else ()))

    def __len__(self) -> int:
        return len(self.titles)

    def __add__(self, other: States) -> States:
        joined = {name: np.concatenate([getattr(self, name), getattr(other, name)]) for name in self.arguments}
        return States(**joined, titles=self.titles + other.titles)

    def part(self, rows: slice) -> States:
        """Some of the states."""
        return States(**{name: getattr(self, name)[rows] for name in self.arguments}, titles=self.titles[rows])

    def at(self, state: int) -> dict[str, Array]:
        """The arguments of one state, by name."""
        found = {name: getattr(self, name)[state] for name in self.arguments}
        return found | dict(zip(MOTIONS, found.get("motion", ()), strict=False))


@dataclass(frozen=True)
class _Variable:
    """What a state has to know of a joint: kind, place and extent of its ordinary motion, farthest reach."""

    revolute: bool
    motor: bool
    centre: float
    extent: float
    reach: float


@dataclass
class _State:
    q: list[float]
    qd: list[float]
    tau: list[float]
    qdd_motor: list[float]
    qdd: list[float]


def moderate_states(machine: Machine, count: int, seed: int = 0, values: ParameterValues | None = None) -> States:
    """Angles within pi, slides within 0.5 m, velocities within 2, torques within 20, accelerations within 5.

    Elastic joints are within 0.5 of their neutral position in every other state, and otherwise
    within the deflection of 1 kN or 1 kN m. Joints of loops are near their start, where the loops close. Where a cell
    has no value, the variables of cells are drawn again.
    """
    values = values or parameter_values(machine, seed)
    variables, motors = _variables(machine, values), len(machine.motors)
    rng = np.random.default_rng([seed, 1])
    drawn = [("moderate", _moderate(variables, motors, rng, wide=k % 2 == 0)) for k in range(count)]
    states = _assembled(machine, _stacked(drawn, len(variables), motors), values, seed)
    states = _defined(machine, states, values, seed)
    states = _with_motions(states, variables, np.random.default_rng([seed, 5]))
    states = _with_deflections(machine, states, values, np.random.default_rng([seed, 7]))
    states = _with_wrenches(machine, states, np.random.default_rng([seed, 9]))
    return _with_base(machine, states, np.random.default_rng([seed, 3]))


def extreme_states(machine: Machine, count: int, seed: int = 0, values: ParameterValues | None = None) -> States:
    """States at the limits, each kind in turn; the rest of such a state is moderate.

    Rest; quarter turns, and one ulp off them; angles to 1e8 rad and slides to 10 m; velocities
    from 1e-6 to 1e6; torques and accelerations to 1e8; these together; everything zero. Elastic
    joints stay within the deflection of 1 MN or 1 MN m. Joints of loops stay near their start, where the loops close.
    """
    values = values or parameter_values(machine, seed)
    variables, motors = _variables(machine, values), len(machine.motors)
    rng = np.random.default_rng([seed, 2])
    found = []
    for k in range(count):
        title, change = EXTREMES[k % len(EXTREMES)]
        state = _moderate(variables, motors, rng, wide=k % 2 == 0)
        change(state, variables, rng)
        found.append((title, state))
    states = _assembled(machine, _stacked(found, len(variables), motors), values, seed)
    states = _defined(machine, states, values, seed)
    states = _with_motions(states, variables, np.random.default_rng([seed, 6]))
    states = _with_deflections(machine, states, values, np.random.default_rng([seed, 8]))
    states = _with_wrenches(machine, states, np.random.default_rng([seed, 10]))
    return _with_base(machine, states, np.random.default_rng([seed, 4]))


def _assembled(machine: Machine, states: States, values: ParameterValues, seed: int) -> States:
    """The states, the joints of loops at assembled positions near their start."""
    if not machine.loops:
        return states
    q, q_dep = assembled_states(machine, len(states), seed, values)
    in_loops = np.array([j in machine.in_loops for j in machine.moving], dtype=bool)
    return replace(states, q=np.where(in_loops, q, states.q), q_dep=q_dep)


def _defined(machine: Machine, states: States, values: ParameterValues, seed: int) -> States:
    """The states, others where cells have no value; raises `InputError` for a cell that has one nowhere."""
    domain, source = Domain(machine), random.Random(seed)
    if not domain.free:
        return states
    rows, dependent = states.q.copy(), [str(machine.joint(j).variable) for j in machine.dependent]
    names = [str(machine.joint(j).variable) for j in machine.moving]
    for k in range(len(states)):
        symbols = {**values, **dict(zip(names, rows[k].tolist(), strict=True))}
        symbols |= zip(dependent, states.q_dep[k].tolist() if dependent else (), strict=True)
        found = domain.defined(symbols, source)
        if found is not None:
            rows[k] = [found[name] for name in names]
        elif refusal := domain.refusal(symbols):
            raise refusal
    return replace(states, q=rows)


def _with_base(machine: Machine, states: States, rng: Rng) -> States:
    """The states, those of a floating base too."""
    if machine.floating is None:
        return states
    kept = {name: getattr(states, name) for name in states.arguments}
    return States(**kept | base_states(states.titles, rng), titles=states.titles)


def _with_deflections(machine: Machine, states: States, values: ParameterValues, rng: Rng) -> States:
    """The states, positions of static joints too, within the deflections of a working load."""
    drawn = [
        [variable.centre + variable.extent * float(rng.uniform(-1, 1)) for _ in states.titles]
        for variable in (_variable(joint, values) for joint in machine.static.values())
    ]
    return replace(states, q_static=np.array(drawn).reshape(len(drawn), len(states)).T)


def _with_wrenches(machine: Machine, states: States, rng: Rng) -> States:
    """The states, moderate wrenches on frames too; where everything is zero, none."""
    drawn = [_uniform(QUANTITIES["f_ext"], rng, 6 * len(machine.forces)) for _ in states.titles]
    acting = np.array([title != ZERO for title in states.titles], dtype=float)
    return replace(states, f_ext=acting[:, None] * np.array(drawn).reshape(len(states), 6 * len(machine.forces)))


def _with_motions(states: States, variables: Sequence[_Variable], rng: Rng) -> States:
    """The states, reference motions of their motors too."""
    motors = [k for k, variable in enumerate(variables) if variable.motor]
    q, qd, qdd = (getattr(states, name)[:, motors] for name in ("q", "qd", "qdd"))
    return replace(states, motion=reference_motions(q, qd, qdd, states.titles, rng))


def _stacked(states: Sequence[tuple[str, _State]], variables: int, motors: int) -> States:
    def stack(name: str) -> Array:
        size = motors if QUANTITIES[name].shape == "m" else variables
        return np.array([getattr(state, name) for _, state in states], dtype=float).reshape(len(states), size)

    return States(**{name: stack(name) for name in ARGUMENTS}, titles=tuple(title for title, _ in states))


def _variables(machine: Machine, values: ParameterValues) -> list[_Variable]:
    at_start = values | start_of(machine).by_variable
    return [_variable(joint, at_start) for joint in machine.moving_joints]


def _variable(joint: Joint, values: ParameterValues) -> _Variable:
    revolute = joint.sigma == 0
    if joint.kind is not Kind.ELASTIC:
        return _Variable(revolute, joint.kind is Kind.MOTOR, 0.0, math.pi if revolute else 0.5, math.inf)
    stiffness, neutral = joint.spring.stiffness.value(values), joint.spring.neutral.value(values)
    compliance = 1 / stiffness if stiffness > 0 else math.inf
    extent = min(0.5, max(WORKING_LOAD * compliance, 1e-2 * abs(neutral)))
    return _Variable(revolute, False, neutral, extent, EXTREME_LOAD * compliance)


def _moderate(variables: Sequence[_Variable], motors: int, rng: Rng, wide: bool) -> _State:
    extents = [max(v.extent, 0.5) if wide else v.extent for v in variables]
    return _State(
        [v.centre + extent * float(rng.uniform(-1, 1)) for v, extent in zip(variables, extents, strict=True)],
        *(_uniform(row, rng, motors if row.shape == "m" else len(variables)) for row in STATE[1:]),
    )


def _uniform(row: Quantity, rng: Rng, count: int) -> list[float]:
    size = row.samples.size if row.samples else 0.0
    found: list[float] = rng.uniform(-size, size, count).tolist()
    return found


def _magnitude(rng: Rng, low: float, high: float) -> float:
    """Either sign, its size spread evenly over the decades from 10^low to 10^high."""
    return float(10 ** rng.uniform(low, high) * rng.choice([-1.0, 1.0]))


def _extreme(rng: Rng, argument: str) -> float:
    samples = QUANTITIES[argument].samples
    return _magnitude(rng, *samples.decades) if samples and samples.decades else 0.0


def _rest(state: _State, variables: Sequence[_Variable], rng: Rng) -> None:
    state.qd = [0.0] * len(state.qd)
    state.tau = [0.0] * len(state.tau)
    state.qdd_motor = [0.0] * len(state.qdd_motor)
    state.qdd = [0.0] * len(state.qdd)


def _quarter_turns(state: _State, variables: Sequence[_Variable], rng: Rng) -> None:
    for k, variable in enumerate(variables):
        turn = int(rng.integers(-4, 5)) * math.pi / 2
        if variable.revolute and abs(turn - variable.centre) <= variable.reach:
            state.q[k] = turn


def _nearly_quarter_turns(state: _State, variables: Sequence[_Variable], rng: Rng) -> None:
    _quarter_turns(state, variables, rng)
    for k, variable in enumerate(variables):
        if variable.revolute:
            state.q[k] = math.nextafter(state.q[k], math.copysign(math.inf, rng.uniform(-1, 1)))


def _far(state: _State, variables: Sequence[_Variable], rng: Rng) -> None:
    for k, variable in enumerate(variables):
        away = _magnitude(rng, 2, 8) if variable.revolute else _magnitude(rng, -3, 1)
        state.q[k] = variable.centre + min(variable.reach, max(-variable.reach, away))


def _velocities(state: _State, variables: Sequence[_Variable], rng: Rng) -> None:
    state.qd = [0.0 if rng.random() < 0.2 else _extreme(rng, "qd") for _ in state.qd]


def _torques(state: _State, variables: Sequence[_Variable], rng: Rng) -> None:
    state.tau = [_extreme(rng, "tau") for _ in state.tau]
    state.qdd_motor = [_extreme(rng, "qdd_motor") for _ in state.qdd_motor]
    state.qdd = [_extreme(rng, "qdd") for _ in state.qdd]


def _everything(state: _State, variables: Sequence[_Variable], rng: Rng) -> None:
    _far(state, variables, rng)
    _velocities(state, variables, rng)
    _torques(state, variables, rng)


def _zero(state: _State, variables: Sequence[_Variable], rng: Rng) -> None:
    _rest(state, variables, rng)
    state.q = [0.0] * len(state.q)


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
