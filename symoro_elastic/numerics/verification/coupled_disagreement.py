"""A and H against recursive Newton-Euler; where joints are coupled on the tree, moved by differences of positions.

There nothing of the traced couplings is used: positions of the tree close the loops by 4x4 matrices, in 100 digits,
along a motion with given velocities and accelerations of the independent variables. Differences give rates and
accelerations of all joints, dq/du and dx/du; the tree with all its joints free then needs forces that S^T brings to the
variables.
"""

from __future__ import annotations

import math
import random
from collections.abc import Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from typing import Any

from symoro_elastic.machine.formula import ZERO
from symoro_elastic.machine.frames import with_given_acceleration
from symoro_elastic.machine.joints import Cogging
from symoro_elastic.machine.loops import Closing
from symoro_elastic.machine.machine import Friction, Joint, Kind, Machine, Spring
from symoro_elastic.models.bound.state import DEPENDENT
from symoro_elastic.models.loops.plan import lacks_closed_form
from symoro_elastic.models.programs.catalogue import expressions
from symoro_elastic.numerics.evaluation.linear_systems import Numbers, distance, dot, solve
from symoro_elastic.numerics.verification.reference import Reference, StateArguments, StateReference
from symoro_elastic.symbolic.arithmetic import FLOATS, evaluate
from symoro_elastic.symbolic.decimals import decimals, in_digits
from symoro_elastic.symbolic.operations import SQRT

DIGITS, STEP = 100, Fraction(1, 10**25)
"""Differences over such steps have 50 digits."""
NEWTON_STEPS = 6
BRANCH = 1e-9
"""Largest difference of variables in closed form from continuation on the same branch (continuation errs by 1e-11)."""


def newton_euler_disagreement(point: StateReference, seed: int = 0) -> float:
    """Return A x + H minus the recursive Newton-Euler torques at random accelerations x, relative."""
    reference, source = point.reference, random.Random(seed)
    if reference.coupled:
        return _coupled_disagreement(point, seed)
    x = [point.arithmetic.number(Fraction(source.uniform(-1, 1))) for _ in point.A]
    wanted = [dot(row, x) + h for row, h in zip(point.A, point.H, strict=True)]
    arguments = {"V0d": x[: point.of_base], "qdd_motor": x[point.of_base :]}
    results = point.run(reference.newton_euler, point.arguments(reference.newton_euler, arguments))
    return distance([*results.get("f0", ()), *results["tau"]], wanted)


@in_digits(DIGITS)
def _coupled_disagreement(point: StateReference, seed: int) -> float:
    """Return A x + H minus the forces that the tree needs at random accelerations x, relative."""
    point, source = replace(point, arithmetic=decimals(DIGITS), digits=DIGITS), random.Random(seed)
    reference, number = point.reference, point.arithmetic.number
    machine = reference.machine
    x = [number(Fraction(source.uniform(-1, 1))) for _ in range(point.of_base + len(machine.independent))]
    motion = _Motion(point, x[point.of_base :])
    closed = motion.at_start
    dependent = [closed.x[str(machine.joint(j).variable)] for j in machine.dependent]
    arguments = {"V0d": x[: point.of_base], DEPENDENT: dependent}
    n = len(x)
    A = point.run(reference.inertia, point.arguments(reference.inertia, arguments))["A"]
    H = point.run(reference.bias, point.arguments(reference.bias, arguments))["H"]
    wanted = [dot(A[k * n : (k + 1) * n], x) + H[k] for k in range(n)]
    off = distance([*point.variables.values()], [closed.x[name] for name in point.variables])
    return max(distance(motion.forces(arguments), wanted), 0.0 if lacks_closed_form(machine) else off)


def branch_error(reference: Reference, state: StateArguments) -> float:
    """Return 1 where closed forms give dependent variables on another branch than the state's, else 0."""
    machine, coupled = reference.machine, reference.coupled
    if coupled is None or not machine.loops:
        return 0.0
    symbols: dict[str, float] = {"pi": math.pi, **reference.values}
    symbols |= {name: float(value.value()) for name, value in reference.exact.items()}
    for argument in ("q", DEPENDENT):
        symbols |= zip(coupled.entries[argument], map(float, state[argument]), strict=True)
    value = evaluate([coupled.bound.variables[j] for j in machine.dependent], symbols, FLOATS)
    values = [(j, float(value(coupled.bound.variables[j]))) for j in machine.dependent]
    turns = {j: 2 * math.pi if machine.joint(j).sigma == 0 else math.inf for j in machine.dependent}
    away = [math.remainder(x - float(y), turns[j]) for (j, x), y in zip(values, state[DEPENDENT], strict=True)]
    return float(any(abs(x) > BRANCH for x in away))


@dataclass(frozen=True)
class _Position:
    """A position: joint variables by name, cut joints included, and values of the tree's joints by number."""

    x: dict[str, Any]
    q: dict[int, Any]


class _Motion:
    """Positions along u + ud t + udd t^2/2 from a state, for differences about its start."""

    def __init__(self, point: StateReference, udd: Numbers) -> None:
        self.point, self.machine, self.udd = point, point.reference.machine, udd
        self.h = point.arithmetic.number(STEP)
        self.names = [str(self.machine.joint(j).variable) for j in self.machine.independent]
        dependent = [str(self.machine.joint(j).variable) for j in self.machine.dependent]
        of_cuts = [self.machine.joint(loop.cut).variable for loop in self.machine.loops]
        self.cuts = [str(variable) for variable in of_cuts if variable is not None]
        self.sought = [*dependent, *self.cuts]

    @cached_property
    def at_start(self) -> _Position:
        """The position of the state, its loops closed."""
        variables = {**self.point.variables, **self._cut_variables()}
        for _ in range(NEWTON_STEPS):
            variables = self._nearer(variables, self._jacobian(variables))
        return self._position(variables)

    def _cut_variables(self) -> dict[str, Any]:
        """Return values of the cut joints: the position of e relative to m, with the cut joint at zero."""
        variables: dict[str, Any] = {}
        at_zero = dict.fromkeys(self.cuts, self.point.arithmetic.number(0))
        placements = self.point.placements({**self.point.variables, **at_zero})
        for loop in self.machine.loops:
            joint = self.machine.joint(loop.cut)
            e, m = placements[loop.cut], placements[loop.meets]
            if joint.sigma == 1:
                variables[str(joint.variable)] = sum((m[k][3] - e[k][3]) * e[k][2] for k in range(3))
            elif joint.variable is not None:
                cosine, sine = (sum(e[k][n] * m[k][0] for k in range(3)) for n in (0, 1))
                variables[str(joint.variable)] = self.point.arithmetic.number(Fraction(math.atan2(sine, cosine)))
        return variables

    def _gaps(self, variables: Mapping[str, Any]) -> Numbers:
        """Entries of 0T_e - 0T_m, positions only where points meet."""
        if not self.machine.loops:
            return []
        placements = self.point.placements(variables)
        return [
            placements[loop.cut][row][column] - placements[loop.meets][row][column]
            for loop in self.machine.loops
            for row in range(3)
            for column in ((3,) if loop.closes is Closing.POINT else range(4))
        ]

    def _jacobian(self, at: Mapping[str, Any]) -> list[Numbers]:
        """Return the derivatives of the gaps by each unknown variable."""
        columns = []
        for name in self.sought:
            after, before = (self._gaps({**at, name: at[name] + way * self.h}) for way in (1, -1))
            columns.append([(a - b) / (2 * self.h) for a, b in zip(after, before, strict=True)])
        return columns

    def _nearer(self, at: Mapping[str, Any], columns: list[Numbers]) -> dict[str, Any]:
        """The variables after a step of Newton's method, of least squares."""
        if not columns:
            return dict(at)
        gaps = self._gaps(at)
        normal = [[dot(a, b) for b in columns] for a in columns]
        steps = solve(normal, [dot(a, gaps) for a in columns])
        return {**at, **{name: at[name] - step for name, step in zip(self.sought, steps, strict=True)}}

    def _position(self, variables: Mapping[str, Any]) -> _Position:
        machine, cell = self.machine, self.point.cell
        q = {
            j: cell(machine.joint(j).selected, variables) + variables.get(str(machine.joint(j).variable), 0)
            for j in machine.articulated
        }
        own = [str(machine.joint(j).variable) for j in machine.with_variable]
        return _Position({name: variables[name] for name in (*own, *self.cuts)}, q)

    @cached_property
    def _columns(self) -> list[Numbers]:
        return self._jacobian(self.at_start.x)

    def _neighbour(self, moves: Mapping[str, Any]) -> _Position:
        """The position with independent variables changed by this much."""
        variables = {**self.at_start.x, **{name: self.at_start.x[name] + move for name, move in moves.items()}}
        for _ in range(NEWTON_STEPS):
            variables = self._nearer(variables, self._columns)
        return self._position(variables)

    def forces(self, given: Mapping[str, Numbers]) -> Numbers:
        """Forces on the base and on the independent variables that the motion needs, friction included."""
        h, start = self.h, self.at_start
        rates = list(zip(self.names, self.point.qd, self.udd, strict=True))
        moves = ({name: t * v + t * t * a / 2 for name, v, a in rates} for t in (h, -h))
        after, before = map(self._neighbour, moves)
        qd = {j: (after.q[j] - before.q[j]) / (2 * h) for j in start.q}
        qdd = {j: (after.q[j] - 2 * start.q[j] + before.q[j]) / (h * h) for j in start.q}
        xd = {name: (after.x[name] - before.x[name]) / (2 * h) for name in start.x}
        tree = expressions(_free_tree(self.machine), "inverse_dynamics")
        arguments = {**given, "q": [*start.q.values()], "qd": [*qd.values()], "qdd_motor": [*qdd.values()]}
        results = self.point.run(tree, self.point.arguments(tree, arguments))
        Gamma = dict(zip(start.q, results["tau"], strict=True))
        return [*results.get("f0", ()), *(self._on(name, Gamma, qd, xd) for name in self.names)]

    def _on(self, name: str, Gamma: Mapping[int, Any], qd: Mapping[int, Any], xd: Mapping[str, Any]) -> Any:
        """The force on one independent variable."""
        after, before = (self._neighbour({name: way * self.h}) for way in (1, -1))
        total = sum(x * (after.q[j] - before.q[j]) for j, x in Gamma.items())
        for j in self.machine.articulated:
            joint = self.machine.joint(j)
            own = str(joint.variable)
            if joint.variable is None:
                total += self._friction(joint, qd[j]) * (after.q[j] - before.q[j])
            else:
                total += self._friction(joint, xd[own]) * (after.x[own] - before.x[own])
        return total / (2 * self.h)

    def _friction(self, joint: Joint, rate: Any) -> Any:
        creep = self.point.cell(joint.friction.creep)
        root = self.point.arithmetic.operations[SQRT]
        way = rate / root(rate * rate + creep * creep) if creep else (rate > 0) - (rate < 0)
        return self.point.cell(joint.friction.viscous) * rate + self.point.cell(joint.friction.coulomb) * way


def _free_tree(machine: Machine) -> Machine:
    """The tree with a motor on each of its joints, and no other force there; cut joints are fixed frames."""
    joints = tuple(_free(j, joint) for j, joint in enumerate(machine.joints, start=1))
    return replace(with_given_acceleration(machine), joints=joints, loops=())


def _free(j: int, joint: Joint) -> Joint:
    if joint.sigma == 2 or joint.kind is Kind.CUT:
        return replace(joint, kind=Kind.FIXED, sigma=2, variable=None)
    bare = replace(joint, spring=Spring(), friction=Friction(), cogging=Cogging())
    free = replace(bare, kind=Kind.MOTOR, variable=f"free_joint_{j}")
    return free.with_selected(ZERO)
