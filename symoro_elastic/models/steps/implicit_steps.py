"""Linear systems of implicit time steps, (I - g T) z = r with T = [0 I; -A^-1 K, -A^-1 D]: factors, and a solution.

K and D are the stiffness and the damping of springs, friction and servos, diagonal over joint coordinates. With
S = g D + g^2 K the system is

    (A + S) x = S r_v + g K r_q,    z_v = r_v - x,    z_q = r_q + g z_v:

the direct model at rest, without loads, with rotor inertias Ia + S. Factors by q and g are computed once.
States of friction and of drives are eliminated: they add to D and K of their joint (D7), and a force (D8)
to the right side. A floating base has six more rows, before those of the joints, without stiffness and
damping.
Where joints depend on others, A + S is the matrix over the independent variables, and is factored.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from enum import Enum
from functools import partial

from symoro_elastic.foundation.scalar import Scalar
from symoro_elastic.machine.machine import Machine
from symoro_elastic.mechanics.base_body import (
    WrenchKnown,
    pose_rates,
    quaternion_change,
    rotation_change,
    shift,
    velocity_rates,
)
from symoro_elastic.mechanics.coordinates import product
from symoro_elastic.mechanics.dynamics import AccelerationKnown, TorqueKnown, dynamics
from symoro_elastic.mechanics.elimination import Rule
from symoro_elastic.mechanics.factorization import Factorization, factorization, share_or_one, solution
from symoro_elastic.mechanics.lagrange import InertiaMatrix, free_solution
from symoro_elastic.mechanics.mechanism import without_loads
from symoro_elastic.mechanics.spatial import AT_REST, NO_WRENCH, RigidInertia, Symmetric, Twist, Vector, Wrench
from symoro_elastic.models.bound.bind import Bound, coordinate_inertia
from symoro_elastic.models.bound.model import Model, Result, Results, TracedModel
from symoro_elastic.models.bound.naming import name_composites, name_dynamics, name_factors
from symoro_elastic.models.bound.state import orientation_of, position_blocks
from symoro_elastic.models.drives.drive_chain import WITHIN
from symoro_elastic.models.drives.drive_states import SET_POINTS, chains_of, inputs_of, state_symbols
from symoro_elastic.models.tree.tree import Tree
from symoro_elastic.symbolic.expression import operand
from symoro_elastic.symbolic.functions import square_root
from symoro_elastic.symbolic.program import Input, Output, Section, prune, schedule
from symoro_elastic.symbolic.two_stages import in_two_stages

Scalars = dict[int, Scalar]
DISPLACEMENT, RATES = "base_displacement", "base_rates"


class Motors(Enum):
    """Inputs of the motors in a step: torques, torques and gains of servos, prescribed motion, or drives."""

    TORQUE = ""
    SERVO = "servo"
    DRIVEN = "driven"
    DRIVES = "drives"

    @property
    def suffix(self) -> str:
        """Suffix of the names of functions."""
        return f"_{self.value}" if self.value else ""


def implicit_system(machine: Machine, motors: Motors, folded: Sequence[str] = ()) -> tuple[TracedModel, TracedModel]:
    """Return the models `implicit_factors` and `implicit_solve` of a machine."""
    bound = Bound(machine, folded)
    system = _System(bound, motors)
    results = system.results
    outputs = [Output(name, r.shape, tuple(map(operand, r.entries))) for name, r in results.items()]
    entries = bound.arguments() | system.sides | ({"z": system.states} if system.states else {})
    late = {name for side in system.sides.values() for name in side}
    cut = in_two_stages(bound.graph, prune(outputs, bound.names), late, "factors")
    first = _factors(motors, bound, system)
    second = _solve(motors, tuple(system.sides), tuple(results))
    (handed,) = cut.first.outputs
    factors = {"factors": Result(None, handed.entries, handed.shape)}
    inputs = [Input(name, entries[name]) for name in first.arguments]
    sides = [Input("factors", cut.handed), *(Input(name, entries[name]) for name in system.sides)]
    return (
        TracedModel(first, factors, schedule(inputs, cut.first)),
        TracedModel(second, results, schedule(sides, cut.second)),
    )


def _factors(motors: Motors, bound: Bound, system: _System) -> Model:
    """The model `implicit_factors`; slopes of limits depend on the state and set points at the start of the step."""
    gains = ("kp", "kd") if motors is Motors.SERVO else (*SET_POINTS, "tau") if system.is_limited else ()
    load = ["load"] if bound.machine.loaded else []
    return Model(
        f"implicit_factors{motors.suffix}",
        "factors of the linear system of an implicit step",
        "[28]-[32]",
        (*position_blocks(bound.machine), "qd", *(["z"] if bound.z or system.states else []), "g", *gains, *load),
        ("factors",),
    )


def _solve(motors: Motors, sides: tuple[str, ...], results: tuple[str, ...]) -> Model:
    return Model(
        f"implicit_solve{motors.suffix}",
        "solution z of (I - g T) z = r, by the factors",
        "[28]-[36]",
        ("factors", *sides),
        results,
    )


@dataclass(frozen=True)
class _Diagonals:
    """Stiffness and damping over joint coordinates, and damping of joints without one."""

    K: Mapping[int, Scalar]
    D: Mapping[int, Scalar]
    coupled: Mapping[int, Scalar]


class _System:
    """Linear system (A + S) x = S r_v + g K r_q of an implicit step; rows of a floating base come first."""

    def __init__(self, bound: Bound, motors: Motors) -> None:
        self.bound, self.motors = bound, motors
        self.g = bound.graph.symbol(bound.arguments()["g"][0])
        on_base = [f"0_{k}" for k in range(1, bound.machine.degrees_of_base + 1)]
        self.sides = {
            name: (*(stem + k for k in on_base), *bound.arguments()[name])
            for name, stem in (("r_q", "rhq"), ("r_v", "rhv"))
        }
        self.chains = chains_of(bound) if motors is Motors.DRIVES else {}
        of_drives = state_symbols(self.chains, "rhz")
        of_states = (*bound.arguments()["r_z"], *(name for own in of_drives.values() for name in own))
        if of_states:
            self.sides["r_z"] = of_states
        self.r_z = self._symbols(dict(zip(bound.machine.bristles, bound.arguments()["r_z"], strict=True)))
        self.is_limited = any(chain.is_limited for chain in self.chains.values())
        z = state_symbols(self.chains, "z") if self.is_limited else {}
        self.states = (*bound.arguments()["z"], *(name for own in z.values() for name in own)) if z else ()
        """Names of all states that determine the slopes of limits at the start of the step."""
        slopes = {j: self.chains[j].slopes([*map(bound.graph.symbol, z[j])], inputs_of(bound, j)) for j in z}

        def answers(r: Mapping[int, Sequence[Scalar]], e: Scalar, xd: Scalar) -> dict[int, tuple[list[Scalar], Scalar]]:
            return {j: x.implicit(self.g, r[j], e, xd, slopes.get(j, WITHIN)) for j, x in self.chains.items()}

        zeros = {j: (0,) * len(own) for j, own in of_drives.items()}
        self.by_error, self.by_velocity = answers(zeros, 1, 0), answers(zeros, 0, 1)
        self.left = answers({j: [*map(bound.graph.symbol, own)] for j, own in of_drives.items()}, 0, 0)
        self.bristles = {j: bound.friction_of(j).implicit_bristle(self.g) for j in bound.machine.bristles}
        self.rows = (0,) * len(on_base) + bound.machine.independent
        self.r_q, self.r_v = (self._per_joint(name) for name in ("r_q", "r_v"))
        self.held = frozenset(bound.motors) if motors is Motors.DRIVEN else frozenset()
        self.x, self.x_0 = self._of_matrix() if bound.machine.is_coupled else self._of_recursion()

    @property
    def results(self) -> dict[str, Result]:
        """Results of the implicit step: z_v = r_v - x, z_q = r_q + g z_v, and z_z of eliminated states."""
        r_q, r_v = (list(map(self.bound.graph.symbol, self.sides[name])) for name in ("r_q", "r_v"))
        x = [*self.x_0.entries[: self.bound.machine.degrees_of_base], *self.x.values()]
        z_v = [r - change for r, change in zip(r_v, x, strict=True)]
        z_q = [r + self.g * z for r, z in zip(r_q, z_v, strict=True)]
        results = {"z_q": Result(self.rows, tuple(z_q)), "z_v": Result(self.rows, tuple(z_v))}
        q, v = (dict(zip(self.bound.machine.independent, z[len(z) - len(self.x) :], strict=True)) for z in (z_q, z_v))
        z_z = [bristle.solution(self.r_z[j], product(self._row(j), v)) for j, bristle in self.bristles.items()]
        for j, chain in self.chains.items():
            row = self._row(j)
            xd = product(row, v)
            demand = chain.Kv * product(row, q) + xd
            parts = (self.left[j][0], self.by_error[j][0], self.by_velocity[j][0])
            z_z += [x - a * demand + b * xd for x, a, b in zip(*parts, strict=True)]
        return results | ({"z_z": Result(None, tuple(z_z), (len(z_z),))} if z_z else {})

    def _symbols(self, names: Mapping[int, str]) -> Scalars:
        return {j: self.bound.graph.symbol(name) for j, name in names.items()}

    def _row(self, j: int) -> Mapping[int, Scalar]:
        """Row of S: the rate of a joint by the rates of the independent variables."""
        coordinates = self.bound.coordinates
        return coordinates.S_x[j] if j in self.bound.machine.with_variable else coordinates.S[j]

    def _push(self) -> Scalars:
        """g times the forces on the independent variables from the right sides of eliminated states (D8)."""
        push: Scalars = dict.fromkeys(self.bound.machine.independent, 0)
        forces = {j: bristle.push(self.r_z[j]) for j, bristle in self.bristles.items()}
        for j, (_, torque) in self.left.items():
            forces[j] = forces.get(j, 0) - torque
        for j, force in forces.items():
            for k, x in self._row(j).items():
                push[k] = push[k] + x * (self.g * force)
        return push

    def _per_joint(self, argument: str) -> Scalars:
        names = self.bound.arguments()[argument]
        return dict(zip(self.bound.machine.independent, map(self.bound.graph.symbol, names), strict=True))

    def _of_recursion(self) -> tuple[Scalars, Twist]:
        """Joints and base by the direct model [28]-[36] with rotor inertias Ia + S."""
        bound, of = self.bound, self._diagonals()
        gK = {j: self.g * x for j, x in of.K.items()}
        S = {j: self.g * (of.D[j] + gK[j]) for j in gK}
        self._name(gK, S)
        unloaded = without_loads(bound.mechanism)
        links = tuple(replace(link, rotor_inertia=link.rotor_inertia + S.get(j, 0)) for j, link in unloaded.from_base())
        rules: list[Rule | None] = [None] * (len(links) + 1)
        push = self._push()
        for j in bound.machine.independent:
            torque = S[j] * self.r_v[j] + gK[j] * self.r_q[j] + push[j]
            rules[j] = AccelerationKnown(0) if j in self.held else TorqueKnown(torque)
        dampers, wrench = self._of_base()
        body = None if unloaded.body is None else unloaded.body + dampers
        base = WrenchKnown(wrench) if bound.machine.degrees_of_base else None
        recursion = dynamics(replace(unloaded, links=links, body=body), [0] * len(rules), rules, base)
        name_dynamics(bound, recursion, "[28]-[32]", "[33]-[36]")
        return {j: recursion.qdd[j] for j in bound.machine.independent}, Twist(recursion.vd[0], recursion.wd[0])

    def _name(self, gK: Mapping[int, Scalar], S: Mapping[int, Scalar]) -> None:
        section = Section("Implicit step: springs, dampers and servos as rotor inertias")
        for j in S:
            self.bound.names.give(gK[j], f"gK{j}", section)
            self.bound.names.give(S[j], f"Sg{j}", section)

    def _of_matrix(self) -> tuple[Scalars, Twist]:
        """Joints and base by factors of A + S over the independent variables."""
        bound, g = self.bound, self.g
        free = [j for j in bound.machine.independent if j not in self.held]
        K, D = self._matrices(free)
        matrix = coordinate_inertia(bound)
        S = {i: {j: g * (D[i][j] + g * K[i][j]) for j in free} for i in free}
        system = {i: {j: matrix.A[i][j] + S[i][j] for j in free} for i in free}
        factors = factorization(free[::-1], system, share_or_one)
        push = self._push()
        right = {i: product(S[i], self.r_v) + g * product(K[i], self.r_q) + push[i] for i in free}
        on_fixed_base = not bound.machine.degrees_of_base
        x, x_0 = (solution(factors, right), AT_REST) if on_fixed_base else self._with_base(factors, matrix, right)
        name_composites(bound, matrix)
        name_factors(bound.names, factors, right, x)
        return dict.fromkeys(bound.machine.independent, 0) | x, x_0

    def _with_base(self, factors: Factorization, matrix: InertiaMatrix, right: Scalars) -> tuple[Scalars, Twist]:
        dampers, wrench = self._of_base()
        damped = replace(matrix, composite=[matrix.composite[0] + dampers, *matrix.composite[1:]])
        x_0, x = free_solution(factors, damped, wrench, right)
        return x, x_0

    def _of_base(self) -> tuple[RigidInertia, Wrench]:
        """Damping S of a floating base as mass and inertia that do not depend on its rotation, and the wrench S r_v."""
        S = [self.g * self.bound.cell(damping) for damping in self.bound.machine.damping_of_base]
        if not S:
            return RigidInertia(), NO_WRENCH
        forces = [s * self.bound.graph.symbol(name) for s, name in zip(S, self.sides["r_v"], strict=False)]
        inertia = Symmetric(S[3], 0, 0, S[3], 0, S[3])
        return RigidInertia(S[0], inertia=inertia), Wrench(Vector(*forces[:3]), Vector(*forces[3:]))

    def _matrices(self, free: Sequence[int]) -> tuple[dict[int, Scalars], dict[int, Scalars]]:
        """K and D over the independent variables: S^T K S with K over joint coordinates."""
        of, coordinates = self._diagonals(), self.bound.coordinates

        def weighted_sum(rows: Mapping[int, Mapping[int, Scalar]], weights: Mapping[int, Scalar]) -> dict[int, Scalars]:
            total: dict[int, Scalars] = {i: dict.fromkeys(free, 0) for i in free}
            for j, weight in weights.items():
                for i in free:
                    for k in free:
                        total[i][k] = total[i][k] + rows[j].get(i, 0) * (weight * rows[j].get(k, 0))
            return total

        K, D, coupled = (
            weighted_sum(coordinates.S_x, of.K),
            weighted_sum(coordinates.S_x, of.D),
            weighted_sum(coordinates.S, of.coupled),
        )
        return K, {i: {k: D[i][k] + coupled[i][k] for k in free} for i in free}

    def _diagonals(self) -> _Diagonals:
        bound = self.bound
        owners = bound.machine.with_variable
        springs = {j: bound.spring_of(j) for j in owners}
        K = {j: spring.slope for j, spring in springs.items()}
        D = {j: spring.damper + self._friction(j) for j, spring in springs.items()}
        coupled = {j: self._friction(j) for j in bound.machine.articulated if j not in owners}
        if self.motors is Motors.SERVO:
            gains = [map(bound.graph.symbol, bound.arguments()[name]) for name in ("kp", "kd")]
            for j, kp, kd in zip(bound.motors, *gains, strict=True):
                K[j], D[j] = K[j] + kp, D[j] + kd
        for j, chain in self.chains.items():
            gain, drag = self.by_error[j][1], self.by_velocity[j][1]
            K[j], D[j] = K[j] + chain.Kv * gain, D[j] + gain - drag
        return _Diagonals(K, D, coupled)

    def _friction(self, j: int) -> Scalar:
        """The damping of friction, including that of the eliminated state of a bristle (D7)."""
        slope = self.bound.friction_of(j).slope_at_level() + self.bound.damping_of_balls.get(j, 0)
        return slope + self.bristles[j].damper if j in self.bristles else slope


def base_models(machine: Machine, folded: Sequence[str] = ()) -> tuple[TracedModel, ...]:
    """Return the models `base_displacement` and `base_rates`; none where the base is fixed."""
    if not machine.degrees_of_base:
        return ()
    orientation = orientation_of(machine)
    displacement = Model(
        DISPLACEMENT,
        "displacement of a floating base within a time step",
        "[2]",
        (orientation, "x0"),
        (f"{orientation}_change", "P0_change"),
        _displacement,
    )
    rates = Model(
        RATES,
        "rates of the coordinates and of the velocity of a floating base",
        "[3], [6]",
        ("x0", "V0", "V0d"),
        ("x0d", "V0_rate"),
        _rates,
    )
    trees = Tree(machine, folded), Tree(machine, folded)
    results = _displacement(trees[0], ()), _rates(trees[1], ())
    return _trace(displacement, trees[0], results[0]), _trace(rates, trees[1], results[1])


def _trace(model: Model, tree: Tree, results: Results) -> TracedModel:
    entries = tree.arguments()
    outputs = [Output(name, r.shape, tuple(map(operand, r.entries))) for name, r in results.items()]
    inputs = [Input(name, entries[name]) for name in model.arguments]
    return TracedModel(model, results, schedule(inputs, prune(outputs, tree.names)))


def _displacement(tree: Tree, _: object) -> Results:
    s, u = _twist(tree, "x0")
    changed: tuple[Scalar, ...]
    if orientation_of(tree.machine) == "Q0":
        changed = quaternion_change(tree.on_base["Q0"], u, partial(square_root, tree.graph))
    else:
        changed = tuple(x for row in rotation_change(tree.base_rotation, u) for x in row)
    name = f"{orientation_of(tree.machine)}_change"
    return {name: _vector(changed), "P0_change": _vector(shift(tree.base_rotation, s))}


def _rates(tree: Tree, _: object) -> Results:
    (_, u), V, Vd = (_twist(tree, name) for name in ("x0", "V0", "V0d"))
    return {"x0d": _vector(pose_rates(u, V).entries), "V0_rate": _vector(velocity_rates(V, Vd).entries)}


def _twist(tree: Tree, argument: str) -> Twist:
    entries = list(map(tree.graph.symbol, tree.arguments()[argument]))
    return Twist(Vector(*entries[:3]), Vector(*entries[3:]))


def _vector(entries: Sequence[Scalar]) -> Result:
    return Result(None, tuple(entries), (len(entries),))
