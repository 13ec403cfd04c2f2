"""Models in 50 digits, computed another way than by the recursions of the generated code.

The dynamic models are A and H, springs from the table, and the solution of linear systems; the
frames are products of 4x4 matrices. Constants are those of the table, folded or not. All is computed within
`in_digits(DIGITS)`.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from typing import Any

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.machine.arguments import known_of_base
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.frames import row_under, with_given_acceleration
from symoro_elastic.machine.joints import Cogging
from symoro_elastic.machine.loops import Closing
from symoro_elastic.machine.machine import Joint, Kind, Machine, NamedFrame, Spring
from symoro_elastic.mechanics.lagrange import inertia_matrix
from symoro_elastic.models.bound.bind import Bound
from symoro_elastic.models.bound.model import CheckedBy
from symoro_elastic.models.bound.state import position_blocks
from symoro_elastic.models.bound.tracing import Trace
from symoro_elastic.models.programs.catalogue import TracedModel, expressions
from symoro_elastic.numerics.evaluation.linear_systems import (
    NumberMatrix,
    Numbers,
    Screw,
    Singular,
    dot,
    inverse,
    product,
    screwed_about_x,
    screwed_about_z,
    solve,
)
from symoro_elastic.symbolic.arithmetic import Arithmetic, evaluate, evaluate_nodes
from symoro_elastic.symbolic.decimals import decimals
from symoro_elastic.symbolic.operations import ATAN2, COS, PI, SIN, SQRT
from symoro_elastic.symbolic.program import Program

DIGITS = 50
ULP = Fraction(1, 1 << 52)
STEP = Fraction(1, 10**17)
"""Step of the differences that differentiate a stiffness."""

StateArguments = Mapping[str, Array]
Column = Mapping[int, Any]
Rows = Mapping[int, Numbers]
"""Rows of a matrix by the joint that owns the variable."""
PARALLEL = 1e-12
"""Relative size of a row of dx/du, less the combination of other rows, below which it depends on them."""


class Reference:
    """Reference values of a machine's models in many digits, from the traced equations before simplification.

    `values` are the numbers given to the generated code; `folded` names have the
    exact values of the machine. `solved` False runs the traced models themselves, for
    machines so large that solving is too slow.
    """

    def __init__(self, machine: Machine, values: Mapping[str, float], folded: Sequence[str], solved: bool) -> None:
        self.machine, self.solved = machine, solved
        self.values = {name: value for name, value in values.items() if name not in folded}
        self.exact = {p.name: p.value for p in machine.parameters if p.name in folded and p.value is not None}
        changes = any(not joint.spring.stiffness.names.isdisjoint(machine.variables) for joint in machine.joints)
        self.coupled = CoupledPrograms(machine) if machine.is_coupled or changes else None

    def at(self, state: StateArguments) -> StateReference:
        """Return the models at a state."""
        return StateReference(self, state, decimals(DIGITS))

    def near(self, state: StateArguments, source: random.Random, forces: bool = False) -> StateReference:
        """Return the models with random errors of one ulp: state, parameters, rounded constants, sines and cosines.

        With `forces`, A and H too are off, by one ulp of their largest entry: no code in double
        precision gets these better.
        """
        return StateReference(self, state, _with_rounding(decimals(DIGITS), source), source, forces)

    @cached_property
    def inertia(self) -> Trace:
        """A of the machine."""
        return expressions(self.machine, "inertia_matrix")

    @cached_property
    def tree(self) -> Bound | None:
        """The machine if A is computed by recursion on numbers: a tree on a fixed base, not solved for; else None."""
        return None if self.solved or self.machine.is_coupled or self.machine.degrees_of_base else Bound(self.machine)

    @cached_property
    def bias(self) -> Trace:
        """H of the machine."""
        return expressions(self.machine, "bias_forces")

    @cached_property
    def newton_euler(self) -> Trace:
        """Gamma for given accelerations of all joints, as if every joint had a motor."""
        joints = tuple(
            replace(joint, kind=Kind.MOTOR, spring=Spring(), cogging=Cogging()) if joint.sigma != 2 else joint
            for joint in self.machine.joints
        )
        return expressions(replace(with_given_acceleration(self.machine), joints=joints), "inverse_dynamics")


@dataclass(frozen=True)
class StateReference:
    """A reference at one state."""

    reference: Reference
    state: StateArguments
    arithmetic: Arithmetic[Any]
    source: random.Random | None = None
    forces: bool = False
    digits: int = DIGITS

    def model(self, traced: TracedModel, solved: bool = False) -> dict[str, Numbers]:
        """Return reference results of a model; `solved` always solves the equations of motion. Raises `Singular`."""
        ways = {CheckedBy.FRAMES: self._frames, CheckedBy.INERTIA: self._inertia, CheckedBy.BIAS: self._bias}
        if solved or self.reference.solved:
            ways |= {CheckedBy.DIRECT: self._direct, CheckedBy.INVERSE: self._inverse}
        if traced.model.checked_by in ways:
            return ways[traced.model.checked_by](traced)
        return self.run(traced.program, self.arguments(traced.program))

    def arguments(self, program: Program | Trace, replaced: Mapping[str, Numbers] | None = None) -> dict[str, Numbers]:
        """Return arguments of a program: the `replaced` ones, else the state's."""
        replaced = replaced or {}
        names = [argument.name for argument in program.inputs]
        return {name: replaced[name] if name in replaced else self.numbers(name) for name in names}

    def run(self, program: Program | Trace, arguments: Mapping[str, Sequence[Any]]) -> dict[str, Numbers]:
        """Return results of a program or of traced equations in this arithmetic."""
        symbols = dict(self.names)
        for argument in program.inputs:
            symbols |= zip(argument.symbols, arguments[argument.name], strict=True)
        value = evaluate_nodes(program.nodes, symbols, self.arithmetic)
        return {output.name: [value(x) for x in output.entries] for output in program.outputs}

    def cell(self, formula: Formula, variables: Mapping[str, Any] | None = None) -> Any:
        """Return the value of a cell of the table, which may hold these variables."""
        names = {**self.names, **variables} if variables else self.names
        return formula.evaluate(names, self._functions, self.arithmetic.number)

    @cached_property
    def names(self) -> dict[str, Any]:
        """Values of pi and of the parameters."""
        names = {"pi": self.arithmetic.operations[PI]()}
        exact = {
            name: formula.evaluate(names, self._functions, self.arithmetic.number)
            for name, formula in self.reference.exact.items()
        }
        return names | exact | {name: self._input(x) for name, x in self.reference.values.items()}

    @cached_property
    def _functions(self) -> dict[str, Callable[..., Any]]:
        operations = self.arithmetic.operations
        functions = {name: operations[name] for name in (SIN, COS, SQRT, ATAN2)}
        return {**functions, "tan": lambda x: functions[SIN](x) / functions[COS](x)}

    @cached_property
    def q(self) -> Numbers:
        """Joint variables."""
        return self.numbers("q")

    @cached_property
    def qd(self) -> Numbers:
        """Joint velocities."""
        return self.numbers("qd")

    @cached_property
    def coupled(self) -> CoupledNumbers:
        """Joint coordinates of a machine whose joints are coupled, and how they follow from q."""
        programs = self.reference.coupled
        if programs is None:
            raise ValueError(f"{self.reference.machine.name} has no coupled joints")
        symbols = dict(self.names)
        for argument in programs.arguments:
            symbols |= zip(programs.entries[argument], self.numbers(argument), strict=True)
        return programs.at(self.arithmetic, symbols, self.qd)

    @cached_property
    def variables(self) -> dict[str, Any]:
        """Values of all joint coordinates by name."""
        machine = self.reference.machine
        by_joint = self.coupled.x if self.reference.coupled else dict(zip(machine.independent, self.q, strict=True))
        return machine.by_variable(by_joint)

    @cached_property
    def A(self) -> NumberMatrix:
        """The inertia matrix [8]."""
        n, tree = self.of_base + len(self.q), self.reference.tree
        trace = self.reference.inertia
        entries = self.run(trace, self.arguments(trace))["A"] if tree is None else self._composite(tree)
        entries = self._result(entries)
        return [entries[row * n : (row + 1) * n] for row in range(n)]

    def _composite(self, tree: Bound) -> Numbers:
        """Return A of a tree by recursion on numbers, cheaper at few states than expressions of pairs of joints."""
        symbols = self.names | dict(zip(tree.arguments()["q"], self.q, strict=True))
        value = evaluate(tree.mechanism.scalars(), symbols, self.arithmetic)
        A, rows = inertia_matrix(tree.mechanism.map(value)).A, tree.machine.independent
        return [A[i][j] for i in rows for j in rows]

    @cached_property
    def H(self) -> Numbers:
        """Bias forces, friction included."""
        arguments = {"q": self.q, "qd": self.qd}
        return self._result(self.run(self.reference.bias, self.arguments(self.reference.bias, arguments))["H"])

    @property
    def of_base(self) -> int:
        """Degrees of freedom of the base, the first ones."""
        return self.reference.machine.degrees_of_base

    def _result(self, entries: Numbers) -> Numbers:
        """Return entries unchanged, or moved by one ulp of the largest entry where forces are perturbed."""
        if self.source is None or not self.forces:
            return entries
        ulp = max(map(abs, entries), default=0) * self.arithmetic.number(ULP)
        return [x + self.source.choice((-1, 1)) * ulp for x in entries]

    def numbers(self, argument: str) -> Numbers:
        """Return an argument of the state."""
        return [self._input(x) for x in self.state[argument]]

    def _input(self, x: float) -> Any:
        """Return an input of the generated code, one ulp off if the state is a perturbed one."""
        exact = Fraction(float(x))
        return decimals(self.digits).number(_one_ulp_off(exact, self.source) if self.source else exact)

    def _of_joints(self, entries: Sequence[Any], rows: Sequence[int]) -> Numbers:
        """Return the entries of the joints with these numbers; each 0 means the next entry of the base."""
        base = iter(entries[: self.of_base])
        by_number = dict(zip(self.reference.machine.independent, entries[self.of_base :], strict=True))
        return [by_number[j] if j else next(base) for j in rows]

    def _inertia(self, traced: TracedModel) -> dict[str, Numbers]:
        if "A_packed" in traced.rows:
            return {"A_packed": [x for i, row in enumerate(self.A) for x in row[: i + 1]]}
        rows = traced.rows["A"]
        return {"A": [x for row in self._of_joints(self.A, rows) for x in self._of_joints(row, rows)]}

    def _bias(self, traced: TracedModel) -> dict[str, Numbers]:
        return {"H": self._of_joints(self.H, traced.rows["H"])}

    def _passive_forces(self) -> dict[int, Any]:
        """Return the forces of springs and dampers on joint coordinates, by the joint that owns them (L3).

        A spring has -k (x - x0) - d xd, and -k' (x - x0)^2 / 2 on each variable by which k changes.
        """
        machine, (x, xd) = self.reference.machine, self._joint_coordinates()
        forces = dict.fromkeys(machine.with_variable, self.arithmetic.number(0))
        for j in machine.sprung:
            spring = machine.joint(j).spring
            stretch = x[j] - self.cell(spring.neutral)
            pressed, share = self._backlash(spring, stretch)
            stiffness, damping = self.cell(spring.stiffness, self.variables), self.cell(spring.damping)
            forces[j] += -stiffness * pressed - damping * share * xd[j]
            for name in spring.stiffness.names & machine.variables.keys():
                forces[machine.variables[name]] -= self._slope(spring.stiffness, name) * stretch * stretch / 2
        for j in machine.motors:
            law = machine.joint(j).reflected_cogging
            if not law.amplitude.is_zero:
                angle = self.cell(law.order) * x[j] + self.cell(law.phase)
                forces[j] += self.cell(law.amplitude) * self._functions["sin"](angle)
        return forces

    def _backlash(self, spring: Spring, x: Any) -> tuple[Any, Any]:
        """Return D(x) of the spring and D'(x) of its damper (D3); x and 1 without backlash."""
        if spring.backlash.is_zero:
            return x, 1
        backlash = self.cell(spring.backlash)
        e = backlash / 50 if spring.rounding.is_zero else self.cell(spring.rounding)
        ends = [x + backlash / 2, x - backlash / 2]
        over, under = (self.arithmetic.operations[SQRT](u * u + e * e) for u in ends)
        return x - (over - under) / 2, 1 - (ends[0] / over - ends[1] / under) / 2

    def _joint_coordinates(self) -> tuple[Mapping[int, Any], Mapping[int, Any]]:
        """Return joint coordinates and their rates, by joint."""
        if self.reference.coupled:
            return self.coupled.x, self.coupled.xd
        joints = self.reference.machine.independent
        return dict(zip(joints, self.q, strict=True)), dict(zip(joints, self.qd, strict=True))

    def _slope(self, formula: Formula, name: str) -> Any:
        """Return the derivative of a formula by a variable."""
        h = self.arithmetic.number(STEP)
        after, before = ({**self.variables, name: self.variables[name] + way * h} for way in (1, -1))
        return (self.cell(formula, after) - self.cell(formula, before)) / (2 * h)

    def _on_independent(self, forces: Mapping[int, Any]) -> Numbers:
        """Return the forces on the independent coordinates that equal these on joint coordinates (L3)."""
        if self.reference.coupled:
            return projection(self.coupled.S_x, forces, self.arithmetic.number(0))
        return [forces[j] for j in self.reference.machine.independent]

    def _direct(self, traced: TracedModel) -> dict[str, Numbers]:
        forces = self._passive_forces()
        for j, tau in zip(self.reference.machine.motors, self.numbers("tau"), strict=True):
            forces[j] += tau
        return self._solve_mixed(traced, [None] * len(self.q), self._on_independent(forces))

    def _inverse(self, traced: TracedModel) -> dict[str, Numbers]:
        if self.reference.coupled:
            return self._driven(traced)
        machine = self.reference.machine
        qdd_motor = dict(zip(machine.motors, self.numbers("qdd_motor"), strict=True))
        given = [qdd_motor.get(j) for j in machine.independent]
        return self._solve_mixed(traced, given, self._on_independent(self._passive_forces()))

    def _driven(self, traced: TracedModel) -> dict[str, Numbers]:
        """Return torques of motors and accelerations of independent variables for accelerations of the motors (L30)."""
        machine, S_x = self.reference.machine, self.coupled.S_x
        qdd_motor = dict(zip(machine.motors, self.numbers("qdd_motor"), strict=True))
        S_m = {m: [*([0] * self.of_base), *S_x[m]] for m in machine.motors}
        wanted = {m: x - self.coupled.gam_x[m] for m, x in qdd_motor.items()}
        V0d, f0 = self._given_on_base()
        exerted = [*f0, *self._on_independent(self._passive_forces())]
        bias = [h - x for h, x in zip(self.H, exerted, strict=True)]
        udd, tau = driven_motion(self.A, bias, S_m, wanted, V0d)
        if len(tau) < len(S_m):
            tau = shared_torques(S_m, tau, {m: self._share(machine.joint(m).sharing) for m in S_m})
        wrench = [dot(row, udd) + h for row, h in zip(self.A[: self.of_base], self.H, strict=False)]
        on_base = {"V0d": udd[: self.of_base], "f0": wrench, **self._of_friction(traced)}
        by_joint = {"tau": tau, "qdd": dict(zip(machine.independent, udd[self.of_base :], strict=True))}
        return {
            name: on_base[name] if name in on_base else [by_joint[name][j] for j in asked]
            for name, asked in traced.rows.items()
        }

    def _of_friction(self, traced: TracedModel) -> dict[str, Numbers]:
        """Return rates of the states of friction, by the traced equations: they depend on the joint alone."""
        if "zd" not in traced.rows:
            return {}
        return {"zd": self.run(traced.program, self.arguments(traced.program))["zd"]}

    def _given_on_base(self) -> tuple[Numbers, Numbers]:
        """Return the known acceleration of the base, [] without one, and the wrench on it, zero without one."""
        numbers = {name: self.numbers(name) for name in known_of_base(self.reference.machine)}
        return numbers.get("V0d", []), numbers.get("f0", [self.arithmetic.number(0)] * self.of_base)

    def _share(self, sharing: Formula) -> Any:
        return self.arithmetic.number(1) if sharing.is_zero else self.cell(sharing)

    def _solve_mixed(self, traced: TracedModel, accelerations: Sequence[Any], exerted: Numbers) -> dict[str, Numbers]:
        """Solve Aee qdd_e = Gamma_e - He - Aer qdd_r, then Gamma_r = Arr qdd_r + Are qdd_e + Hr [11].

        Gamma_r is reduced by what is `exerted` in addition to the motors. `accelerations` are qdd_r, None for each
        unknown qdd_e; entries of the base come first.
        """
        zero, (V0d, f0) = self.arithmetic.number(0), self._given_on_base()
        accelerations, exerted = [*(V0d or [None] * self.of_base), *accelerations], [*f0, *exerted]
        soft = [k for k, x in enumerate(accelerations) if x is None]
        qdd, Gamma = [zero if x is None else x for x in accelerations], exerted
        right = [Gamma[k] - self.H[k] - dot(self.A[k], qdd) for k in soft]
        for k, x in zip(soft, solve([[self.A[k][i] for i in soft] for k in soft], right), strict=True):
            qdd[k] = x
        tau = [dot(row, qdd) + h for row, h in zip(self.A, self.H, strict=True)]
        base = {"V0d": qdd[: self.of_base], "f0": tau[: self.of_base], **self._of_friction(traced)}
        of_joints = {"tau": [x - known for x, known in zip(tau, exerted, strict=True)], "qdd": qdd}
        return {
            name: base[name] if name in base else self._of_joints(of_joints[name], rows)
            for name, rows in traced.rows.items()
        }

    def _frames(self, traced: TracedModel) -> dict[str, Numbers]:
        """Return 0Tj = 0Ti iTj [2]; a cut joint has the frame of the row that it meets."""
        placements, poses = self.placements(self.variables), []
        for loop in self.reference.machine.loops:
            if loop.closes is Closing.FRAME:
                placements[loop.cut] = placements[loop.meets]
        for frame in traced.results["T"].frames:
            pose = placements[frame.number]
            pose = product(pose, self._translation(frame.at)) if frame.at else pose
            poses.append(product(inverse(placements[frame.seen_from or 0]), pose))
        return {"T": [x for placement in poses for row in placement for x in row]}

    def placements(self, variables: Mapping[str, Any]) -> list[NumberMatrix]:
        """Return 0Tj of the base, all rows of the table and named frames, with these joint coordinates by name."""
        zero, one = self.arithmetic.number(0), self.arithmetic.number(1)
        placements: list[NumberMatrix] = [[[one if m == n else zero for n in range(4)] for m in range(4)]]
        for joint in self.reference.machine.joints:
            placements.append(self._place(placements[joint.antecedent], joint, variables))
        machine, rows = self.reference.machine, len(self.reference.machine.joints)
        for number, frame in enumerate(machine.frames, start=rows + 1):
            placements.append(product(placements[row_under(machine, number)], self._placement(frame)))
        return placements

    def _placement(self, frame: NamedFrame) -> NumberMatrix:
        """Return Trans(at) Rot(z, yaw) Rot(y, pitch) Rot(x, roll)."""
        (cr, sr), (cp, sp), (cy, sy) = (self._screw(self.cell(angle), 0)[:2] for angle in frame.rpy)
        turned = [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr, 0],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr, 0],
            [-sp, cp * sr, cp * cr, 0],
            [0, 0, 0, 1],
        ]
        return product(self._translation(frame.at), turned)

    def _translation(self, at: Sequence[Formula]) -> NumberMatrix:
        """Return Trans(x), Trans(y), Trans(z)."""
        unit = [[int(m == n) for n in range(3)] for m in range(3)]
        return [*([*row, self.cell(x)] for row, x in zip(unit, at, strict=True)), [0, 0, 0, 1]]

    def _place(self, antecedent: NumberMatrix, joint: Joint, variables: Mapping[str, Any]) -> NumberMatrix:
        """Return 0Ti Rot(z,gamma) Trans(z,b) Rot(x,alpha) Trans(x,d) Rot(z,theta) Trans(z,r) [1]."""
        about_z, about_x = self._before(joint)
        q = variables.get(str(joint.variable), 0)
        theta = self.cell(joint.theta, variables) + (q if joint.sigma == 0 else 0)
        r = self.cell(joint.r, variables) + (q if joint.sigma == 1 else 0)
        turned_frame = screwed_about_x(screwed_about_z(antecedent, *about_z), *about_x)
        return screwed_about_z(turned_frame, *self._screw(theta, r))

    def _before(self, joint: Joint) -> tuple[Screw, Screw]:
        """Return the constant screws of a row, about z and about x, computed once."""
        if joint.name not in self._known_screws:
            cells = ((joint.gamma, joint.b), (joint.alpha, joint.d))
            about_z, about_x = (self._screw(*map(self.cell, pair)) for pair in cells)
            self._known_screws[joint.name] = about_z, about_x
        return self._known_screws[joint.name]

    @cached_property
    def _known_screws(self) -> dict[str, tuple[Screw, Screw]]:
        return {}

    def _screw(self, angle: Any, shift: Any) -> Screw:
        return self._functions[COS](angle), self._functions[SIN](angle), shift


def _with_rounding(arithmetic: Arithmetic[Any], source: random.Random) -> Arithmetic[Any]:
    """Return the arithmetic with constants that double precision rounds, sines and cosines, one ulp off."""
    moved: dict[Fraction | tuple[str, Any], Any] = {}

    def number(x: Fraction | int) -> Any:
        if isinstance(x, int) or Fraction(float(x)) == x:
            return arithmetic.number(x)
        if x not in moved:
            moved[x] = arithmetic.number(_one_ulp_off(x, source))
        return moved[x]

    def rounded(name: str) -> Callable[[Any], Any]:
        def value(x: Any) -> Any:
            if (name, x) not in moved:
                moved[name, x] = exact = arithmetic.operations[name](x)
                if exact not in (-1, 0, 1):
                    moved[name, x] = exact * arithmetic.number(_one_ulp_off(Fraction(1), source))
            return moved[name, x]

        return value

    return Arithmetic(number, {**arithmetic.operations, **{name: rounded(name) for name in (SIN, COS)}})


def _one_ulp_off(x: Fraction, source: random.Random) -> Fraction:
    return x * (1 + source.choice((-1, 1)) * ULP)


@dataclass(frozen=True)
class CoupledNumbers:
    """By joint: coordinate x, row of S_x = dx/du, gam_x of xdd = S_x udd + gam_x, and rate xd."""

    x: Column
    S_x: Rows
    gam_x: Column
    xd: Column


class CoupledPrograms:
    """Joint coordinates, dx/du and gam of a machine as expressions, of the `arguments` by name."""

    def __init__(self, machine: Machine) -> None:
        self.machine, self.bound = machine, Bound(machine)
        self.entries = self.bound.arguments()
        self.arguments = (*position_blocks(machine), "qd")

    def at(self, arithmetic: Arithmetic[Any], symbols: Mapping[str, Any], ud: Numbers) -> CoupledNumbers:
        """Return the numbers; `symbols` has the arguments and parameters, `ud` the independent rates."""
        owners, coordinates = self.machine.with_variable, self.bound.coordinates
        x = {j: self.bound.variables[j] for j in owners}
        S_x = {j: [coordinates.S_x[j].get(k, 0) for k in self.machine.independent] for j in owners}
        gam_x = {j: coordinates.gam_x[j] for j in owners}
        value = evaluate([*x.values(), *gam_x.values(), *(s for row in S_x.values() for s in row)], symbols, arithmetic)
        rows = {j: [value(s) for s in row] for j, row in S_x.items()}
        rates = {j: dot(row, ud) for j, row in rows.items()}
        return CoupledNumbers(_values(value, x), rows, _values(value, gam_x), rates)


def _values(value: Any, expressions: Column) -> Column:
    return {j: value(x) for j, x in expressions.items()}


def projection(S: Rows, Gamma: Column, zero: Any) -> Numbers:
    """Return Gamma_u = S^T Gamma (L3), entry by entry from `zero`."""
    columns = range(len(next(iter(S.values()), [])))
    return [sum((S[j][k] * force for j, force in Gamma.items()), zero) for k in columns]


def driven_motion(
    A: NumberMatrix, rest: Numbers, S_m: Rows, wanted: Column, known: Numbers
) -> tuple[Numbers, Mapping[int, Any]]:
    """Return accelerations and torques for accelerations of the motors, less gam_m, that are `wanted` (L30).

        [ A   -S_m^T ] [udd]   [  -rest ]
        [ S_m    0   ] [tau] = [ wanted ]

    `rest` is H less all forces but those of motors. The first accelerations may be `known`, as those of a base, in the
    place of the forces there. Torques are those of motors whose rows of S_m are not a combination of rows before them.
    """
    S_n = {m: S_m[m] for m in _independent(S_m)}
    matrix = [[*row, *(-s[k] for s in S_n.values())] for k, row in enumerate(A)]
    matrix += [[*s, *([0] * len(S_n))] for s in S_n.values()]
    unknown = _solution(matrix, [*(-x for x in rest), *(wanted[m] for m in S_n)], known)
    return unknown[: len(A)], dict(zip(S_n, unknown[len(A) :], strict=True))


def _solution(matrix: NumberMatrix, right: Numbers, known: Numbers) -> Numbers:
    """Return all unknowns of a linear system whose first ones are known and replace as many equations."""
    n = len(known)
    rhs = [x - dot(row[:n], known) for row, x in zip(matrix[n:], right[n:], strict=True)]
    return [*known, *solve([row[n:] for row in matrix[n:]], rhs)]


def _independent(rows: Rows) -> list[int]:
    """Return the joints whose rows are not a combination of earlier rows."""
    joints: list[int] = []
    orthogonal: list[Numbers] = []
    for j, row in rows.items():
        across = row
        for other in orthogonal:
            factor = dot(across, other) / dot(other, other)
            across = [x - factor * y for x, y in zip(across, other, strict=True)]
        if max(map(abs, across), default=0) > PARALLEL * float(max(map(abs, row), default=0)):
            joints.append(j)
            orthogonal.append(across)
    return joints


def shared_torques(S_m: Rows, tau_n: Column, w: Column) -> Column:
    """Return torques of all motors equivalent to tau_n of some, with the least sum of tau^2 / w (L31).

    tau = w B (B^T w B)^-1 tau_n, where S_m = B S_n. Raises `Singular` where rows of S_m are not a combination of S_n.
    """
    gram = [[dot(S_m[m], S_m[n]) for n in tau_n] for m in tau_n]
    B = {m: solve(gram, [dot(row, S_m[n]) for n in tau_n]) for m, row in S_m.items()}
    size = range(len(tau_n))
    BwB = [[sum(w[m] * B[m][a] * B[m][b] for m in S_m) for a in size] for b in size]
    y = solve(BwB, [*tau_n.values()])
    tau = {m: w[m] * dot(B[m], y) for m in S_m}
    for k in range(len(next(iter(S_m.values())))):
        Gamma = sum(S_m[m][k] * x for m, x in tau_n.items())
        if abs(sum(S_m[m][k] * x for m, x in tau.items()) - Gamma) > PARALLEL * float(abs(Gamma) + 1):
            raise Singular("the torques of the motors are not determined here")
    return tau
