"""Chains of a motor and the springs that it drives, and a machine in the coordinates of their loads.

A spring is behind a joint on its axis (mechanics/feed_forward), or behind a transmission: its cell follows the chain,

    z_j = F_j + x_j,    F_j = ratio z_before + others,

where z_before is the part of F_j that belongs to the chain, and others that of joints outside it. On the axis F_j =
z_before, and x_j counts in the sense of the axis. So every cell of the machine is a formula of the coordinates z: the
variable of a motor, z_j of the springs that it drives. The bodies of a chain are then in parallel.
"""

from __future__ import annotations

import random
from collections import Counter
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

from symoro_elastic.foundation.scalar import Scalar
from symoro_elastic.machine.constants import substitute
from symoro_elastic.machine.formula import ZERO, Formula
from symoro_elastic.machine.machine import Joint, Kind, Machine
from symoro_elastic.mechanics.feed_forward import Drive, mounted_in_parallel, sense
from symoro_elastic.mechanics.mechanism import Link
from symoro_elastic.mechanics.spatial import AxialTransform, Z, is_zero
from symoro_elastic.models.bound.bind import Bound
from symoro_elastic.models.tree.tree import Coupling, Tree
from symoro_elastic.symbolic.arithmetic import FLOATS, ModularAngles, evaluate
from symoro_elastic.symbolic.differentiation import Differentiation
from symoro_elastic.symbolic.differentiation import substitute as in_place_of_symbols
from symoro_elastic.symbolic.expression import Expression, is_constant
from symoro_elastic.symbolic.functions import cosine_sine

SEED, ROUNDING = 20264, 1e-12


@dataclass(frozen=True)
class Stage:
    """A spring driven by a joint: z_joint = ratio z_before + others + sense x; `others` is None on the same axis."""

    joint: int
    before: int
    sense: int = 1
    ratio: Scalar = 1
    others: Formula | None = None


@dataclass(frozen=True)
class Chain:
    """A motor and the springs that it drives in series, from the motor outwards."""

    motor: int
    stages: tuple[Stage, ...]

    @property
    def joints(self) -> tuple[int, ...]:
        """The motor and the springs."""
        return self.motor, *(stage.joint for stage in self.stages)

    @property
    def runs(self) -> Iterator[Drive]:
        """Joints on one axis each, with their senses against the first."""
        joints, senses = [self.motor], [1]
        for stage in self.stages:
            if stage.others is not None:
                yield Drive(tuple(joints), tuple(senses))
                joints, senses = [], []
            joints.append(stage.joint)
            senses.append(stage.sense)
        yield Drive(tuple(joints), tuple(senses))


def chains(tree: Tree) -> list[Chain]:
    """Every motor with the springs in series that it drives, as long as exactly one spring follows the last.

    All chains grow together: a spring belongs to the motor that it is nearest to, and to none where two are as near.
    """
    candidates = [_Growing(tree, motor) for motor in tree.motors if motor in tree.machine.independent]
    claimed: set[int] = set()
    while any(chain.grows for chain in candidates):
        extensions = {chain.motor: chain.behind(claimed) for chain in candidates if chain.grows}
        claims = Counter(stage.joint for stages in extensions.values() for stage in stages)
        for chain in candidates:
            chain.grow([stage for stage in extensions.get(chain.motor, ()) if claims[stage.joint] == 1])
        claimed |= claims.keys()
    return [Chain(chain.motor, tuple(chain.stages)) for chain in candidates]


class _Growing:
    """A chain that grows from a motor, with dz/dx of its last joint by the variables of the chain."""

    def __init__(self, tree: Tree, motor: int) -> None:
        self.tree, self.motor = tree, motor
        self.elastic = [j for j in tree.machine.independent if tree.machine.joint(j).kind is not Kind.MOTOR]
        self.couplings = tree.couplings
        self.slopes: dict[int, Scalar] = {motor: 1}
        self.senses = {motor: 1}
        self.stages: list[Stage] = []
        self.grows = True

    def grow(self, extensions: list[Stage]) -> None:
        """Append the only spring among `extensions` to the chain; the chain ends if there is none or several."""
        self.grows = self.grows and len(extensions) == 1
        for stage in extensions if self.grows else ():
            self.stages.append(stage)
            self.slopes = {v: stage.ratio * x for v, x in self.slopes.items()} | {stage.joint: stage.sense}
            self.senses[stage.joint] = stage.sense

    def behind(self, claimed: Collection[int]) -> list[Stage]:
        """Springs that follow the last joint directly."""
        followers = [stage for j in self.elastic if j not in claimed and (stage := self._stage(j))]
        names = {str(self.tree.machine.joint(stage.joint).variable) for stage in followers}
        return [s for s in followers if names.isdisjoint(self.tree.machine.joint(s.joint).selected.names)]

    def _stage(self, j: int) -> Stage | None:
        last = self.stages[-1].joint if self.stages else self.motor
        if j in self.couplings:
            return self._transmission(last, j)
        if not self.stages and last in self.couplings:
            return None
        same_sense = sense(self.tree.mechanism, last, j)
        return Stage(j, last, same_sense * self.senses[last]) if same_sense else None

    def _transmission(self, last: int, j: int) -> Stage | None:
        """The spring of joint j as the next stage, if its cell follows the whole chain with one ratio; else None."""
        follows = self.couplings[j].partials
        ratio = self.senses[last] * follows.get(last, 0)
        of_chain = [*(follows.get(v, 0) - ratio * x for v, x in self.slopes.items())]
        if is_zero(ratio) or not all(_vanishes(self.tree, x) for x in of_chain) or not is_constant(ratio):
            return None
        names = {str(self.tree.machine.joint(v).variable): ZERO for v in self.slopes}
        return Stage(j, last, 1, ratio, substitute(self.tree.machine.joint(j).selected, names))


def _vanishes(tree: Tree, x: Scalar) -> bool:
    """Whether a coefficient is zero at any values of the parameters."""
    if is_zero(x) or not is_constant(x):
        return is_zero(x)
    source = random.Random(SEED)
    values = {p.name: source.uniform(0.5, 1.5) for p in tree.machine.parameters}
    return abs(evaluate([x], values, FLOATS)(x)) <= ROUNDING


@dataclass(frozen=True)
class Linear(Coupling):
    """A linear formula of joint coordinates: only those with coefficients that do not cancel."""

    bound: Bound
    constant: Scalar
    slopes: Mapping[int, Scalar]

    @property
    def value(self) -> Scalar:
        """The formula at the values of the variables."""
        total = self.constant
        for v, x in self.slopes.items():
            total = total + x * self.bound.variables[v]
        return total

    @property
    def partials(self) -> dict[int, Scalar]:
        """Derivatives by joint coordinates, by number of the joint."""
        return dict(self.slopes)

    def second(self, rates: Mapping[int, Scalar]) -> Scalar:
        """Zero: the formula is linear."""
        return 0


class LoadVariables:
    """Load coordinates z of chains in place of joint coordinates; the variable of joint j is sense_j z_j."""

    def __init__(self, table: Machine, chains: Sequence[Chain]) -> None:
        self.table, self.chains = table, tuple(chains)
        self.stages = {stage.joint: stage for chain in chains for stage in chain.stages}
        self.senses = dict.fromkeys(table.independent, 1) | {j: stage.sense for j, stage in self.stages.items()}

    def machine(self) -> Machine:
        """The machine in these coordinates: springs behind transmissions are at theirs, others follow."""
        first = {j: run.joints[0] for chain in self.chains for run in chain.runs for j in run.joints}
        joints = [_with_cell(joint, self._cell(j)) for j, joint in enumerate(self.table.joints, start=1)]
        for j, head in first.items():
            joints[j - 1] = replace(joints[j - 1], antecedent=self.table.joint(head).antecedent)
        return replace(self.table, joints=tuple(joints))

    def name(self, j: int) -> str:
        """The variable of joint j, which also names its load coordinate."""
        return str(self.table.joint(j).variable)

    @cached_property
    def formulas(self) -> dict[str, Formula]:
        """Joint coordinates of the springs of chains as formulas of the load coordinates, by name."""
        formulas: dict[str, Formula] = {}
        for j in self.stages:
            self._add(j, formulas)
        return formulas

    def _cell(self, j: int) -> Formula:
        if j in self.stages and self.stages[j].others is not None:
            return ZERO
        return substitute(self.table.joint(j).selected, self.formulas)

    def _add(self, j: int, formulas: dict[str, Formula]) -> None:
        name, stage = self.name(j), self.stages[j]
        if name in formulas:
            return
        terms = ZERO if stage.others is None else stage.others
        for other in self.stages:
            if self.name(other) in terms.names:
                self._add(other, formulas)
        followed = self._ratio_times(j, stage)
        text = f"({self._coordinate(j)}) - ({followed}) - ({substitute(terms, formulas)})"
        formulas[name] = Formula.parse(text if stage.sense > 0 else f"-({text})")

    def _ratio_times(self, j: int, stage: Stage) -> Formula:
        """The part ratio z_before of joint j's position, as a formula: what follows the chain's joint before it."""
        before = self._coordinate(stage.before)
        if stage.others is None:
            return Formula.parse(before)
        chain = next(chain.joints for chain in self.chains if j in chain.joints)
        zero = {self.name(v): ZERO for v in chain}
        cell = self.table.joint(j).selected
        last = {**zero, self.name(stage.before): Formula.parse(f"{self.senses[stage.before]}*({before})")}
        return Formula.parse(f"({substitute(cell, last)}) - ({substitute(cell, zero)})")

    def _coordinate(self, j: int) -> str:
        """z_j as a formula of its variable, which is sense times z."""
        return self.name(j) if self.senses[j] > 0 else f"-({self.name(j)})"


class LoadCoordinates(Bound):
    """A machine bound in the coordinates of its loads, which shares the graph of the machine in joint coordinates.

    Formulas are over coordinates; in linear ones, coefficients that cancel are dropped.
    """

    def __init__(self, bound: Bound, chains: list[Chain]) -> None:
        self.table, self.of_load = bound.machine, LoadVariables(bound.machine, chains)
        self.chains, self.stages, self.senses = chains, self.of_load.stages, self.of_load.senses
        super().__init__(self.of_load.machine(), sharing=bound, mounted=_on_axes(bound, chains))

    def offset(self, j: int) -> Scalar:
        """Value of the cell of joint j."""
        return self.coupling(self.machine.joint(j).selected).value

    def coupling(self, formula: Formula) -> Coupling:
        """A formula of coordinates; in a linear one, coefficients that cancel are dropped."""
        formula_of_z = super().coupling(formula)
        if not all(map(is_constant, formula_of_z.partials.values())):
            return formula_of_z
        at_zero = self.cell(
            formula, self.values_by_name(dict.fromkeys(formula.names & self.machine.variables.keys(), 0))
        )
        return Linear(self, at_zero, {v: x for v, x in formula_of_z.partials.items() if not _vanishes(self, x)})

    @cached_property
    def others(self) -> dict[int, Coupling]:
        """Terms of the cells of springs behind transmissions that do not depend on their chain, by joint."""
        formulas = {j: stage.others for j, stage in self.stages.items() if stage.others is not None}
        return {j: self.coupling(substitute(x, self.of_load.formulas)) for j, x in formulas.items()}

    def lost_forces(self) -> dict[int, Scalar]:
        """Forces on the coordinates of friction, dampers and springs of dependent joints and of changes of stiffness.

        Changes of a spring's stiffness by its own coordinate belong to `spring_law`.
        """
        dependent = {j: self.friction(j) - self.passive_torque(j) for j in self.machine.dependent}
        forces = self._projection(dependent, {j: self.friction(j) for j in self._coupled_joints})
        for j, slopes in self.stiffness_slopes.items():
            for k, slope in slopes.items():
                forces[k] = forces[k] + (0 if k == j else self._of_change(j, slope))
        return forces

    def _of_change(self, j: int, slope: Scalar) -> Scalar:
        """Force of a change of stiffness of joint j: k' (x - x0)^2/2."""
        _, deflection = self.spring(j)
        return slope * deflection * deflection / 2

    def stiffening(self, j: int) -> Scalar:
        """Force on z_j of the change of stiffness of joint j with z_j."""
        return self.senses[j] * self._of_change(j, self.stiffness_slopes.get(j, {}).get(j, 0))

    def spring(self, j: int) -> tuple[Scalar, Scalar]:
        """Stiffness of joint j and deflection of its spring; zero for joints without."""
        joint = self.table.joint(j)
        if not joint.has_spring:
            return 0, 0
        return self._stiffness(j, self._own(j)), self._own(j) - self.cell(joint.spring.neutral)

    def _own(self, j: int) -> Scalar:
        """Joint coordinate of joint j, over the load coordinates where it is that of a spring of a chain."""
        return (
            self.coupling(self.of_load.formulas[self.of_load.name(j)]).value if j in self.stages else self.variables[j]
        )

    def _stiffness(self, j: int, own: Scalar) -> Scalar:
        """Stiffness of joint j at its joint coordinate, over the coordinates, without those that cancel in it."""
        formula = self.table.joint(j).spring.stiffness
        names = formula.names & self.table.variables.keys()
        if not names:
            return self.cell(formula)
        of_own = self.cell(formula, self.values_by_name({name: self.graph.symbol(name) for name in names}))
        values = {name: self._own(self.table.variables[name]) for name in names}
        stiffness = self._with(of_own, values | ({self.of_load.name(j): own} if self.of_load.name(j) in names else {}))
        slopes = {x.operands[0]: _slope(stiffness, x) for x in self.q.values()}
        value = ModularAngles(SEED).values(slopes.values())
        return self._with(stiffness, {name: 0 for name, x in slopes.items() if not value(x)})

    def _with(self, x: Scalar, values: Mapping[str, Scalar]) -> Scalar:
        return in_place_of_symbols(self.graph, [x], values)[0]

    @cached_property
    def stiffness_slopes(self) -> dict[int, dict[int, Scalar]]:
        """Derivatives of stiffnesses that change with positions, by joint and coordinate."""
        cells = {j: self.table.joint(j).spring.stiffness for j in self.machine.elastic}
        varying = {j: self.spring(j)[0] for j, x in cells.items() if not x.names.isdisjoint(self.table.variables)}
        slopes = {j: {k: _slope(stiffness, x) for k, x in self.q.items()} for j, stiffness in varying.items()}
        return {j: {k: x for k, x in row.items() if not is_zero(x)} for j, row in slopes.items()}

    def spring_law(self, j: int, deflection: Expression) -> Scalar:
        """Force against the variable of spring j at a deflection, which the coordinate before the spring follows."""
        stage, coordinate = self.stages[j], self.q[j]
        own = deflection + self.cell(self.table.joint(j).spring.neutral)
        stiffness = self._stiffness(j, own)
        change = Differentiation([stiffness]).along({deflection: 1, coordinate: 1}).of(stiffness)
        terms = self.others[j].value if j in self.others else 0
        before = (stage.sense * (coordinate - own) - terms) / stage.ratio
        force = stiffness * deflection + change * deflection * deflection / 2
        return self._with(force, {self.of_load.name(stage.before): self.senses[stage.before] * before})


def _on_axes(bound: Bound, chains: Sequence[Chain]) -> dict[int, Link]:
    """Links of springs on the axis of the previous joint, mounted in parallel with it."""
    stages = {stage.joint: stage for chain in chains for stage in chain.stages}
    runs = [run for chain in chains for run in chain.runs]
    at_zero = {j: _at_zero(bound, j, stages.get(j)) for run in runs for j in run.joints}
    mounted = mounted_in_parallel(bound.mechanism, runs, at_zero)
    return {j: mounted.link(j) for run in runs for j in run.joints[1:]}


def _at_zero(bound: Bound, j: int, stage: Stage | None) -> AxialTransform:
    """The last screw of joint j at zero of its coordinate."""
    joint = bound.machine.joint(j)
    follows = stage is not None and stage.others is not None
    theta, r = (0 if follows and joint.sigma == k else bound.cell(x) for k, x in enumerate((joint.theta, joint.r)))
    return AxialTransform(Z, *cosine_sine(bound.graph, theta), r)


def _with_cell(joint: Joint, cell: Formula) -> Joint:
    return joint if cell is joint.selected else joint.with_selected(cell)


def _slope(x: Scalar, variable: Expression) -> Scalar:
    return Differentiation([x]).by(variable).of(x)


def load_positions(bound: Bound, chains: list[Chain]) -> dict[int, Scalar]:
    """Coordinates z of the last joints of chains over joint coordinates, by motor."""
    positions: dict[int, Scalar] = {}
    for chain in chains:
        z: Scalar = bound.variables[chain.motor]
        for stage in chain.stages:
            z = bound.angle(stage.joint) if stage.others is not None else z + stage.sense * bound.variables[stage.joint]
        positions[chain.motor] = z
    return positions


def springs_behind(chains: list[Chain]) -> Mapping[int, int]:
    """The next joint outwards, by joint of the chains."""
    return {i: j for chain in chains for i, j in pairwise(chain.joints)}
