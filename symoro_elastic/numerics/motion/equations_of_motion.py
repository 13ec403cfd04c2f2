"""The equations of motion of a machine at a state, and their exact derivatives.

    r(q, qd, qdd, p) = A qdd + H(q, qd) + friction + springs and dampers = tau of the motors, else 0    [8], [9]

Where joints depend on others, q are the independent variables and r what acts on them: S^T Gamma (L3), (L20).

M = dr/dqdd, D = dr/dqd and K = dr/dq are those of the traced model `linearization`. Dual numbers differentiate what no
model gives: velocities and accelerations of frames by the state, r and its changes by parameters. Coulomb friction
jumps at rest and is left out. Frames are in axes of frame 0.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import zip_longest
from typing import Any

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.scalar import Scalar
from symoro_elastic.machine.checks import require_fixed_base
from symoro_elastic.machine.domain import NEXT, Domain
from symoro_elastic.machine.formula import STEP, ZERO, FormulaError
from symoro_elastic.machine.frames import Points, with_base_coordinates
from symoro_elastic.machine.machine import Friction, Kind, Machine
from symoro_elastic.machine.named_cells import refuse_values, refuse_wrong_values, with_named_cells, with_named_drives
from symoro_elastic.machine.names import no_such
from symoro_elastic.machine.scene import Point
from symoro_elastic.mechanics.coordinates import product, projection
from symoro_elastic.mechanics.dynamics import dynamics
from symoro_elastic.mechanics.energy import gravity_energy
from symoro_elastic.mechanics.joint_laws import friction_slope
from symoro_elastic.mechanics.kinematics import frame_set, motion_expressed_in, velocities
from symoro_elastic.mechanics.mechanism import Mechanism
from symoro_elastic.mechanics.spatial import is_zero
from symoro_elastic.models.bound.bind import Bound
from symoro_elastic.models.bound.rules import given_rules
from symoro_elastic.models.programs.catalogue import needs_of
from symoro_elastic.numerics.motion.assembled_loops import AssembledLoops, traced_once
from symoro_elastic.numerics.motion.independent_joints import followers, share_torques, shares, with_independent_motors
from symoro_elastic.numerics.motion.signals import inputs, outputs, points_of_signals
from symoro_elastic.symbolic.arithmetic import FLOATS, evaluate, evaluate_nodes, nodes
from symoro_elastic.symbolic.differentiation import gradient
from symoro_elastic.symbolic.duals import Dual, differentiating
from symoro_elastic.symbolic.expression import Expression, Operand, reachable
from symoro_elastic.symbolic.operations import SYMBOL
from symoro_elastic.symbolic.program import Pruned
from symoro_elastic.symbolic.tape import Tape

DUALS = differentiating(FLOATS)
MOST_PAIRS = 300
"""Most pairs of a joint and a joint between it and the base for which formulas pay, as in a chain of 24 joints: beyond,
they need 400 evaluations and more."""
LARGEST_BLOCK = 1 << 24
"""Most slopes in memory at a time."""
LARGEST_INPUT = 1e9
"""Largest magnitude of an input position, velocity or torque, SI units."""


@dataclass(frozen=True)
class State:
    """q, qd, qdd (n,) of the moving joints, tau (n,) that motors exert on them, `torques` (m,) of the motors.

    SI units, radians. tau is S_m^T torques (L3): by joint, the torque of its motor and of motors that follow it, or 0.
    `sought` are indices of the coordinates that an equilibrium was solved for, `residual` is its largest
    unbalanced force, N or N m. `started` are indices of the coordinates at the start of loops.
    """

    q: Array
    qd: Array
    qdd: Array
    tau: Array
    torques: Array
    sought: tuple[int, ...] = ()
    residual: float = 0.0
    started: tuple[int, ...] = ()


class EquationsOfMotion:
    """The equations of motion of a machine with values for all its parameters; rows follow the moving joints."""

    def __init__(self, machine: Machine, values: Mapping[str, float] | None = None, points: Points = ()) -> None:
        """Set wrenches that are arguments of models to zero. Raises `InputError` for parameters without a value."""
        require_fixed_base(machine, "linear models")
        self.asked, self.driven = machine, with_named_drives(machine)
        machine = replace(machine, forces=())
        machine = with_independent_motors(machine)
        self.given, self.points = machine, points
        self.followers = followers(machine)
        self._judged = with_named_cells(machine)
        self._numbered = with_named_drives(self._judged)
        without_coulomb = (replace(x, friction=Friction(x.friction.viscous)) for x in self._judged.joints)
        self.machine = replace(self._judged, joints=tuple(without_coulomb))
        self.joints = self.machine.independent_joints
        self.names = [joint.name for joint in self.joints]
        self.motors = list(self.machine.motor_entries)
        self.bound = Bound(self.machine, points=points)
        self._take(values or {})
        self.assembled = AssembledLoops(self.bound, self.parameters)
        self.traced: dict[Any, Any] = {}

    def at_values(self, values: Mapping[str, float]) -> EquationsOfMotion:
        """Return the equations at other values of parameters, with the same expressions. Raises `InputError`."""
        equations = object.__new__(EquationsOfMotion)
        equations.__dict__.update(self.__dict__)
        equations._take(values)
        equations.assembled = self.assembled.at_values(equations.parameters)
        return equations

    def _take(self, values: Mapping[str, float]) -> None:
        """Set the values of parameters: `parameters` are those of the mechanics, `numbers` also those of the drives."""
        self.given_values, self.numbers = dict(values), _values(self._numbered, values)
        self.parameters = {p.name: self.numbers[p.name] for p in self._judged.parameters}

    def __reduce__(self) -> tuple[Any, ...]:
        """Return machine, values and points for pickling; unpickling traces the expressions anew."""
        return EquationsOfMotion, (self.asked, self.given_values, self.points)

    @property
    def source(self) -> str:
        """The file, or the name of the machine: its name in messages."""
        return self.machine.label

    def index(self, name: str, place: str) -> int:
        """Return the index in q of a joint by its name or variable; raises `InputError`."""
        indices = {str(joint.variable): k for k, joint in enumerate(self.joints)}
        indices |= {joint.name: k for k, joint in enumerate(self.joints)}
        dependent = {x: j for j in map(self.machine.joint, self.machine.dependent) for x in (j.name, str(j.variable))}
        if name in dependent:
            raise InputError(self.source, place, self.machine.why_dependent(dependent[name].name))
        if name not in indices:
            raise InputError(self.source, place, no_such("moving joint", name, indices))
        return indices[name]

    def indices_of(self, named: Mapping[str, float], place: str) -> dict[int, float]:
        """Return numbers by index in q; raises `InputError` for joints that do not move and numbers out of range."""
        numbers = {self.index(name, place): float(x) for name, x in named.items()}
        self.refuse_large(named, place)
        return numbers

    def refuse_large(self, named: Mapping[str, float], place: str) -> None:
        """Raise `InputError` for numbers out of range."""
        for name, x in named.items():
            if not abs(x) <= LARGEST_INPUT:
                what = f"{name}={x:g} is out of range: give a number up to {LARGEST_INPUT:g}"
                raise InputError(self.source, place, what)

    @property
    def motor_names(self) -> list[str]:
        """Names of all motors, in the order of their torques."""
        return [joint.name for joint in self.machine.motor_joints]

    def motor(self, name: str, place: str) -> int:
        """Return the index of a motor among all, by the name of its joint or variable; raises `InputError`."""
        motors = self.machine.motors_by_name
        if name not in motors:
            joint = self.names[self.index(name, place)]
            raise InputError(self.source, place, self.machine.why_no_motor(joint))
        return self.motor_names.index(motors[name])

    def motor_slopes(self, q: Array) -> Array:
        """Return S_m = dx_m/du (m, n), the changes of the motors' variables with the coordinates (L1)."""
        return self.slopes(q, self.machine.motors)

    def slopes(self, q: Array, joints: Sequence[int]) -> Array:
        """Return rows (joints, n) of dx/du of joint coordinates, of dq/du of coupled joints, by their numbers (L1)."""
        coordinates, independent = self.bound.coordinates, self.machine.independent
        rows = [coordinates.S_x[j] if j in self.machine.with_variable else coordinates.S[j] for j in joints]
        return self._at(q, [row.get(k, 0) for row in rows for k in independent]).reshape(len(rows), len(independent))

    def torques(self, q: Array, tau: Array) -> Array:
        """Return torques (m,) of the motors that exert tau (n,); motors that move as one share it (L31)."""
        if not self.followers:
            return tau[self.motors]
        S_m = self.motor_slopes(q)[:, self.motors]
        return share_torques(S_m, tau[self.motors], shares(self.machine, self.parameters))

    @traced_once
    def residual(self) -> list[Scalar]:
        """Expressions of r by joint, less the torques of motors that follow others."""
        bound = self.bound
        Gamma = dynamics(self.bodies, bound.rates(), given_rules(bound)).Gamma
        needed, passive = bound.on_independent(Gamma), bound.passive_forces()
        moved_along = projection(bound.coordinates.S_x, {j: bound.tau[j] for j in self.followers})
        return [needed[j] - passive[j] - moved_along.get(j, 0) for j in self.machine.independent]

    @traced_once
    def domain(self) -> Domain:
        """The formulas of joint variables in cells, and the positions where they have values."""
        return Domain(self.given)

    @traced_once
    def linear_model(self) -> Pruned:
        """The traced matrices M, D, K of the model `linearization`."""
        return needs_of(self.machine, "linearization")

    @traced_once
    def bodies(self) -> Mechanism:
        """The mechanism of the table's rows alone, without points of signals."""
        return replace(self.bound.mechanism, links=self.bound.mechanism.links[: len(self.machine.joints)])

    @traced_once
    def potential(self) -> Scalar:
        """Energy of gravity, of the base's acceleration, and of springs; r at rest without wrenches is its gradient."""
        elastic = [self.bound.spring_of(j).energy() for j in self.machine.with_variable]
        return sum(elastic, gravity_energy(self.bodies, -self.bodies.acceleration.linear))

    @traced_once
    def frame_motions(self) -> tuple[list[Scalar], list[Scalar]]:
        """V_j [3] and V'_j [6] of every frame and point, base included, linear part first, in axes of frame 0."""
        mechanism = replace(self.bound.mechanism, acceleration=self.bound.base_acceleration)
        qd, qdd = self.bound.rates(), self.bound.given_accelerations()
        motion = motion_expressed_in(mechanism, frame_set(mechanism), qd, qdd)
        V, Vd = ([x for twist in twists for x in twist.entries] for twists in motion)
        return V, Vd

    @traced_once
    def joint_coordinate_rates(self) -> tuple[list[Scalar], list[Scalar]]:
        """Rates and accelerations of all joint coordinates, dependent ones too, in table order (L2)."""
        coordinates, owners = self.bound.coordinates, self.machine.with_variable
        accelerations = [product(coordinates.S_x[j], self.bound.qdd) + coordinates.gam_x[j] for j in owners]
        return [coordinates.rates_x[j] for j in owners], accelerations

    @traced_once
    def body_velocities(self) -> list[Scalar]:
        """V_j [3] of every frame and the base, each in its own axes."""
        return [x for twist in velocities(self.bound.mechanism, self.bound.rates()) for x in twist.entries]

    @traced_once
    def springs(self) -> dict[str, tuple[Scalar, Scalar, Scalar]]:
        """Local stiffness, force and rate of all springs, by the name of its joint."""
        laws = {j: self.bound.spring_of(j) for j in self.machine.sprung}
        return {self.machine.joint(j).name: (law.slope, law.force, self.bound.rate(j)) for j, law in laws.items()}

    @traced_once
    def rotors(self) -> dict[str, tuple[Scalar, Scalar]]:
        """Ia and the rate of joints with a rotor, by the name of the joint."""
        links, rates = self.bound.mechanism.links, self.bound.rates()
        numbered = [j for j in self.machine.articulated if not is_zero(links[j - 1].rotor_inertia)]
        return {self.machine.joint(j).name: (links[j - 1].rotor_inertia, rates[j]) for j in numbered}

    def row_of(self, number: int, at: Point | None = None) -> int:
        """Return the first of the six rows in `frame_motions` of a frame, or of a point of it."""
        return 6 * self.bound.link_of(number, at)

    def potential_energy(self, q: Array) -> float:
        """Return the potential energy in J, up to a constant."""
        return float(evaluate([self.potential], self._symbols(q), FLOATS)(self.potential))

    def forces(self, q: Array, qd: Array | None = None, qdd: Array | None = None) -> Array:
        """Return r (n,), N m or N, at rest unless qd and qdd are given; NaN where a loop does not close."""
        return self._numbers(self.residual, self._symbols(q, qd, qdd))

    def forces_and_stiffness(self, q: Array) -> tuple[Array, Array]:
        """Return r (n,) and K (n, n) at rest, SI units."""
        return self.forces(q), self.matrices("K", q)[0]

    def matrices(
        self,
        names: Iterable[str],
        q: Array,
        qd: Array | None = None,
        qdd: Array | None = None,
        torques: Array | None = None,
    ) -> list[Array]:
        """Return some of the matrices M, D, K (n, n) of small motions about q, qd, qdd, SI units, radians.

        `torques` (m,) are those of the motors; they act on K where motors move with others. What is not given is zero.
        """
        if self._many_pairs:
            return [self._slopes(name, q, qd, qdd, torques) for name in names]
        entries = {output.name: output.entries for output in self.linear_model.outputs}
        names, n = list(names), len(q)
        numbers = self._numbers([x for name in names for x in entries[name]], self._symbols(q, qd, qdd, torques))
        return list(numbers.reshape(len(names), n, n))

    @property
    def _many_pairs(self) -> bool:
        """Whether K has so many entries that formulas for them cost more than derivatives of r at numerical values."""
        depths = [0]
        for joint in self.machine.joints:
            depths.append(depths[joint.antecedent] + (joint.sigma != 2))
        return sum(depths) > MOST_PAIRS

    @traced_once
    def residual_at_rest(self) -> list[Scalar]:
        """Expressions of r where velocities and accelerations are zero: less than half as long."""
        still = {x.operands[0] for rates in (self.bound.qd, self.bound.qdd) for x in rates.values()}
        symbols: dict[str, Operand] = {x.operands[0]: x for x in reachable(self.residual) if x.operation == SYMBOL}
        value = evaluate(self.residual, symbols | dict.fromkeys(still, 0), nodes(self.bound.graph))
        return [value(x) for x in self.residual]

    def _slopes(self, name: str, q: Array, qd: Array | None, qdd: Array | None, torques: Array | None) -> Array:
        """Return one of M, D, K (n, n) as the slopes of r, some columns at a time, so that their memory is bounded."""
        n, k = len(q), "KDM".index(name)
        qd, qdd = (np.zeros(n) if x is None else x for x in (qd, qdd))
        at_rest = name == "K" and not (np.any(qd) or np.any(qdd))
        roots = self.residual_at_rest if at_rest else self.residual
        needed, slopes = reachable(roots), np.zeros((n, n))
        width = max(1, LARGEST_BLOCK // max(1, len(needed)))
        for first in range(0, n, width):
            columns = slice(first, first + width)
            moved: list[Any] = [q, qd, qdd]
            moved[k] = _seed(moved[k], np.eye(n)[:, columns])
            symbols = self._symbols(*moved, torques)
            try:
                value = evaluate_nodes(needed, symbols, DUALS)
            except (ArithmeticError, ValueError):
                if not self.machine.loops:
                    raise
                return np.full((n, n), np.nan)
            for row, x in enumerate(map(value, roots)):
                slopes[row, columns] = x.tangent if x.__class__ is Dual else 0.0
        return (slopes + slopes.T) / 2 if name == "M" else slopes

    def jacobians(self, roots: Sequence[Scalar], state: State) -> tuple[Array, Array, Array]:
        """Return the derivatives of expressions by q, qd and qdd, each (roots, n)."""
        n = len(state.q)
        seeds = np.split(np.eye(3 * n), 3)
        q, qd, qdd = map(_seed, (state.q, state.qd, state.qdd), seeds)
        value = evaluate(roots, self._symbols(q, qd, qdd, state.torques), DUALS)
        slopes = np.zeros((len(roots), 3 * n))
        for row, x in enumerate(map(value, roots)):
            if x.__class__ is Dual:
                slopes[row] = x.tangent
        return slopes[:, :n], slopes[:, n : 2 * n], slopes[:, 2 * n :]

    def work_slopes(self, state: State, left: Array) -> Mapping[str, Any]:
        """Return the derivatives of left^T r by symbol, (m,) each, for the columns of `left` (n, m)."""
        symbols = self._symbols(state.q, state.qd, state.qdd, state.torques)
        return self.assembled.total(gradient(self.residual, list(left), symbols, FLOATS), symbols, FLOATS)

    def parameter_slopes(
        self, state: State, left: Array, dq: Array, dqd: Array, dqdd: Array, roots: Sequence[Scalar] | None = None
    ) -> dict[str, Array]:
        """Return the derivatives of left^T dr by all parameters, (m,) each, where the equilibrium changes with them.

        dr is the change of r, or of other expressions `roots`, along dq, dqd and dqdd; the columns of `left` (roots, m)
        and of dq, dqd, dqdd (n, m) correspond.
        """
        by_q, by_symbol = self.change_slopes(state, left, dq, dqd, dqdd, roots)
        none, moved = np.zeros(left.shape[1]), self.position_slopes(state)
        return {name: by_symbol.get(name, none) + moved[name] @ by_q for name in self.parameters}

    def position_slopes(self, state: State) -> dict[str, Array]:
        """Return the derivatives of q (n,) by all parameters: dq/dp = -K^-1 dr/dp where an equilibrium was solved for.

        Those of the start of loops where it is one, zero for other coordinates.
        """
        n, sought, names = len(state.q), list(state.sought), list(self.parameters)
        moved = np.zeros((len(names), n))
        starts = {variable: x for loop in self.machine.loops for variable, x in loop.start.items()}
        for k in state.started:
            start = starts.get(str(self.joints[k].variable), ZERO)
            for name in start.names:
                moved[names.index(name), k] = start.with_slope(self.parameters, name).imag / STEP
        if sought:
            stiffness, none = self.forces_and_stiffness(state.q)[1][sought], np.zeros(len(sought))
            by_symbol = self.work_slopes(state, np.eye(n)[:, sought])
            own = np.array([by_symbol.get(name, none) for name in names])
            forces = moved @ stiffness.T + own.reshape(-1, len(sought))
            moved[:, sought] = -np.linalg.lstsq(stiffness[:, sought], forces.T, rcond=None)[0].T
        return dict(zip(names, moved, strict=True))

    def change_slopes(
        self, state: State, left: Array, dq: Array, dqd: Array, dqdd: Array, roots: Sequence[Scalar] | None = None
    ) -> tuple[Array, dict[str, Array]]:
        """Return the derivatives of left^T dr by q (n, m), and by parameter symbol, (m,) each."""
        q, qd, qdd = _seed(state.q, dq), _seed(state.qd, dqd), _seed(state.qdd, dqdd)
        symbols = self._symbols(q, qd, qdd, state.torques)
        roots = self.residual if roots is None else roots
        by_symbol = self.assembled.total(gradient(roots, list(left), symbols, DUALS), symbols, DUALS)
        none = np.zeros(left.shape[1])
        changed = {name: x.tangent + none if x.__class__ is Dual else none for name, x in by_symbol.items()}
        by_q = np.array([changed.get(symbol.operands[0], none) for symbol in self.bound.q.values()])
        return by_q, changed

    def body_inertias(self, q: Array) -> Array:
        """Return the spatial inertias JJ_j [13], (bodies, 6, 6), in the frames of the bodies, linear part first."""
        cells = [[link.body.mass, *link.body.moments, *link.body.inertia] for link in self.bodies.links]
        numbers = self._at(q, [x for row in cells for x in row]).reshape(len(cells), -1)
        return np.array([_spatial_inertia(row) for row in numbers.tolist()])

    def modal_inertias(self, q: Array) -> dict[int, tuple[tuple[int, ...], Array, Array]]:
        """Return the numbers of modes, U (modes, 6) and Mee by the number of the flexible body (L55)."""
        inertias = {}
        for j, link in self.bodies.from_base():
            if (modes := link.modes) is not None:
                U = self._at(q, [x for wrench in modes.wrenches().values() for x in wrench.entries]).reshape(-1, 6)
                inertias[j] = modes.numbers, U, np.array(modes.Mee, dtype=float)
        return inertias

    def spring_stiffnesses(self, q: Array) -> Array:
        """Return k (springs,) in the order of `springs`, N m/rad or N/m: the slopes there, where there is backlash."""
        return self._at(q, [stiffness for stiffness, _, _ in self.springs.values()])

    def spring_forces(self, q: Array) -> Array:
        """Return k (x - x0), or k D(x - x0) (D3), (springs,) in the order of `springs`, N m or N."""
        return self._at(q, [force for _, force, _ in self.springs.values()])

    def joint_laws(self, start: Array, v: Array) -> tuple[Array, Array, Array]:
        """Return stiffness (n,) of joints, their damping (N, n) at v (N, n), forces (n,) of springs at the start.

        The slope of dry friction that creeps is damping, too.
        """
        laws = [(joint.spring, joint.friction) for joint in self.given.independent_joints]
        cells = [(s.stiffness, s.damping, s.neutral, f.viscous, f.coulomb, f.creep) for s, f in laws]
        at_start = {str(joint.variable): x for joint, x in zip(self.given.independent_joints, start, strict=True)}
        values = {**self.parameters, **at_start}
        numbers = np.array([[cell.value(values) for cell in row] for row in cells], dtype=float)
        stiffness, damping, neutral, viscous, coulomb, creep = numbers.T
        speed = np.hypot(v, np.where(creep > 0, creep, 1.0))
        slope: Any = friction_slope(viscous, np.where(creep > 0, coulomb, 0.0), creep, speed)
        return stiffness.copy(), damping + slope, stiffness * (start - neutral)

    def refuse_open(self, q: Array) -> None:
        """Raise `InputError` where a cell has no value, and where a loop does not close or is singular."""
        at = ", ".join(f"{name}={x:g}" for name, x in zip(self.names, q, strict=True))
        if self._is_closed(q):
            own = self.machine.by_variable(self.own_positions(q))
            undefined = self.domain.first_undefined(self._symbols(q) | own)
            if undefined:
                raise undefined.error(self.machine, f"at {at}: give another position (--at)")
            return
        loops = ", ".join(loop.name for loop in self.machine.loops)
        neighbours = (q + way * NEXT * unit for unit in np.eye(len(q)) for way in (1, -1))
        what = f"it does not close at {at}: give another position (--at)"
        if any(self._is_closed(x) for x in neighbours):
            what = f"it is singular at {at}, where links are stretched or folded: give a position beside it (--at)"
        raise InputError(self.source, f"loop {loops}", what)

    def _is_closed(self, q: Array) -> bool:
        return bool(np.isfinite(self._at(q, [self.bound.variables[j] for j in self.machine.dependent])).all())

    def _at(self, q: Array, roots: Sequence[Scalar]) -> Array:
        return self._numbers(roots, self._symbols(q))

    def _numbers(self, roots: Sequence[Scalar], symbols: Mapping[str, Any]) -> Array:
        """Return values of expressions; NaN where a square root or a quotient of a loop has none."""
        key = tuple(x.id if type(x) is Expression else (type(x), x) for x in roots)
        if key not in self.traced:
            self.traced[key] = Tape(roots, FLOATS)
        try:
            return np.array(self.traced[key].values(symbols), dtype=float)
        except (ArithmeticError, ValueError):
            if not self.machine.loops:
                raise
            return np.full(len(roots), np.nan)

    def neutral_positions(self) -> Array:
        """Return q0 (n,) of the springs, rad or m; for other joints their start in a loop, else zero."""
        neutral = self.values(self.bound.cell(joint.spring.neutral) for joint in self.joints)
        rigid = [k for k, joint in enumerate(self.joints) if joint.kind is not Kind.ELASTIC]
        neutral[rigid] = self.position_of_loops()[rigid]
        return neutral

    def position_of_loops(self) -> Array:
        """Return q (n,) as far as loops have a start, rad or m, zero elsewhere."""
        start = {name: x.value(self.parameters) for loop in self.machine.loops for name, x in loop.start.items()}
        return np.array([start.get(str(joint.variable), 0.0) for joint in self.joints], dtype=float)

    def own_positions(self, q: Array) -> dict[int, float]:
        """Return the variables of all joints with one, rad or m, by number; NaN where a loop does not close."""
        owners = self.machine.with_variable
        return dict(zip(owners, self._at(q, [self.bound.variables[j] for j in owners]).tolist(), strict=True))

    def values(self, roots: Iterable[Scalar]) -> Array:
        """Return the values of expressions of parameters."""
        roots = list(roots)
        value = evaluate(roots, self.parameters, FLOATS)
        return np.array([float(value(x)) for x in roots])

    def _symbols(self, *blocks: Iterable[Any] | None) -> dict[str, Any]:
        """Return the values of symbols: of parameters, and of q, qd, qdd and torques, zero where they are left out."""
        symbols: dict[str, Any] = dict(self.parameters)
        bound = self.bound
        for by_joint, block in zip_longest((bound.q, bound.qd, bound.qdd, bound.tau), blocks):
            numbers = np.zeros(len(by_joint)) if block is None else block
            for symbol, x in zip(by_joint.values(), numbers, strict=True):
                symbols[symbol.operands[0]] = x if x.__class__ is Dual else float(x)
        self.assembled.add_to(symbols, [symbols[symbol.operands[0]] for symbol in self.bound.q.values()])
        return symbols


def _seed(x: Array, slopes: Array) -> list[Dual]:
    return [Dual(float(value), slope) for value, slope in zip(x, slopes, strict=True)]


def _spatial_inertia(ten: Sequence[float]) -> Array:
    mass, mx, my, mz, xx, xy, xz, yy, yz, zz = ten
    hat = np.array([[0, -mz, my], [mz, 0, -mx], [-my, mx, 0]])
    tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    return np.block([[mass * np.eye(3), -hat], [hat, tensor]])


def _values(machine: Machine, given: Mapping[str, float]) -> dict[str, float]:
    """Return the values of all parameters; raises `InputError`."""
    source, names = machine.label, [parameter.name for parameter in machine.parameters]
    refuse_values(machine, given, names)
    machine.refuse_missing_values("parameters", "--value", given)
    try:
        own = {p.name: p.value.value() for p in machine.parameters if p.value is not None and p.name not in given}
    except FormulaError as error:
        raise InputError(source, "parameters", str(error)) from None
    values = {name: float(given.get(name, own.get(name, 0.0))) for name in names}
    return refuse_wrong_values(machine, given.keys(), values)


def motion_of(
    machine: Machine, values: Mapping[str, float] | None = None, ins: Sequence[str] = (), outs: Sequence[str] = ()
) -> EquationsOfMotion:
    """Return the equations of motion of a machine, with the points of its input and output signals.

    A base that moves freely has six coordinates more: base.x, base.y, base.z, base.rx, base.ry, base.rz.
    """
    machine = with_independent_motors(with_base_coordinates(machine))
    signals = [*inputs(machine, ins), *outputs(machine, outs)]
    return EquationsOfMotion(machine, values, points_of_signals(machine, signals))
