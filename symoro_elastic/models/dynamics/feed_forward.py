"""Feed-forward through elastic joints: motor torques for a prescribed motion of the outboard side.

This is not the paper's inverse model, whose input is the motion of motors: here the motion beyond the
springs is prescribed, with as many derivatives by time as the chain needs. External wrenches count as constant.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import partial
from graphlib import CycleError, TopologicalSorter
from itertools import islice
from math import factorial
from typing import NoReturn

from symoro_elastic.foundation.scalar import Scalar
from symoro_elastic.machine.checks import place_of
from symoro_elastic.machine.machine import NO_MOTOR, Joint, Kind, Machine
from symoro_elastic.mechanics.dynamics import dynamics
from symoro_elastic.mechanics.spatial import is_zero
from symoro_elastic.models.bound.bind import Bound
from symoro_elastic.models.bound.model import CheckedBy, Joints, Model, Result, Results
from symoro_elastic.models.bound.naming import name_dynamics
from symoro_elastic.models.bound.rules import given_rules
from symoro_elastic.models.dynamics.load_coordinates import Chain, LoadCoordinates, chains, springs_behind
from symoro_elastic.models.tree.tree import Tree
from symoro_elastic.quantities import COEFFICIENT, HIGHEST_DERIVATIVE, MOTION, quantity
from symoro_elastic.symbolic.differentiation import Differentiation, substitute
from symoro_elastic.symbolic.expression import Expression, Graph, reachable
from symoro_elastic.symbolic.functions import sign
from symoro_elastic.symbolic.operations import COS, NEGATE, SIN, SYMBOL
from symoro_elastic.symbolic.program import Label, Section
from symoro_elastic.symbolic.time_series import TimeSeries, VariableCoefficient

SPRINGS = "Deflections of springs, motion of motors"

Reach = dict[int, int]
"""The highest needed derivative of the coordinate, by joint."""


@dataclass(frozen=True)
class Balance:
    """Equations of motion of chains in load coordinates z_j, and the machine bound in these coordinates.

    `springs` holds the loads on z_j that springs balance, `tau` torques of motors; `outer[j]` is the next joint
    outwards, whose spring determines z_j. Without it z_j is the prescribed motion y of the motor `motors[j]`.
    """

    loads: LoadCoordinates
    springs: dict[int, Scalar]
    tau: dict[int, Scalar]
    outer: Mapping[int, int]
    motors: dict[int, int]

    @property
    def senses(self) -> Mapping[int, int]:
        """Signs of z_j relative to the joint variables, by joint."""
        return {j: self.loads.senses[j] for j in self.motors}


@dataclass(frozen=True)
class Solution:
    """Coefficients in time of coordinates z_j and of the deflections of springs.

    `undamped` holds those that springs with damping would have without: then theirs are symbols (`deflection_symbol`).
    """

    needed: Reach
    series: TimeSeries
    z: dict[int, VariableCoefficient]
    deflections: dict[int, list[Scalar]]
    undamped: dict[int, list[Scalar]]


@dataclass(frozen=True)
class OverTime:
    """Formulas of a feed-forward with lagging, damped springs: torques of motors, positions and velocities of joints.

    A spring of stiffness k and damping d obeys q + d/k q' = u, u being its deflection without damping. `lagging` holds
    u and its derivatives by spring, in an order in which they need only the q of earlier springs; `q`,
    `qd` and `tau` need all. The symbols are y_<j>, its derivatives (`motion_symbol`) and those of `deflection_symbol`.
    """

    bound: Bound
    lagging: dict[int, list[Scalar]]
    tau: dict[int, Scalar]
    q: dict[int, Scalar]
    qd: dict[int, Scalar]


def over_time(machine: Machine) -> OverTime:
    """Return the feed-forward of a machine whose springs may have damping. Raises `InputError`."""
    machine.refuse_states_of_friction("a feed-forward")
    bound = Bound(machine)
    balance = _balance(bound, damped=True)
    solution, q, tau = _solve(bound, balance)
    lagging = {j: [x * factorial(k) for k, x in enumerate(u)] for j, u in solution.undamped.items()}
    return OverTime(bound, lagging, tau, *({j: x[k] for j, x in q.items()} for k in (0, 1)))


def left_out_springs(machine: Machine) -> list[str]:
    """Return the springs that no motor drives on its axis, and whose deflection no torque can control."""
    followed = {j for chain in chains(Tree(machine)) for j in chain.joints}
    elastic = (machine.joint(j) for j in machine.independent if j not in followed)
    return [joint.name for joint in elastic if joint.kind is Kind.ELASTIC]


def motion_symbol(motor: int, k: int) -> str:
    """Return the symbol of derivative k of the outboard coordinate of a motor."""
    return f"y{motor}_{k}"


def deflection_symbol(j: int, k: int) -> str:
    """Return the symbol of derivative k of a deflection that is a result of integration."""
    return f"spring.{j}.{k}"


def _feed_forward(bound: Bound, requested: Joints) -> Results:
    balance = _balance(bound)
    solution, q, tau = _solve(bound, balance)
    z = {j: [solution.z[j](k) for k in range(highest + 1)] for j, highest in solution.needed.items()}
    _name_results(bound, q, tau)
    _name_coordinates(bound, z, {j: motor for j, motor in balance.motors.items() if j not in balance.outer})
    _name_series(bound, solution.series)
    motors = tuple(j for j in requested if j in tau)
    return {
        "tau": Result(motors, tuple(tau[j] for j in motors)),
        "q": Result(requested, tuple(q[j][0] for j in requested)),
        "qd": Result(requested, tuple(q[j][1] for j in requested)),
    }


def _solve(bound: Bound, balance: Balance) -> tuple[Solution, dict[int, list[Scalar]], dict[int, Scalar]]:
    """Return the solution, coefficients of q of all joints, and torques of motors."""
    solution = _solution(bound, balance)
    tau: dict[int, Scalar] = {j: solution.series.of(x, 0)[0] for j, x in balance.tau.items()}
    motors = {j: [solution.z[j](k) for k in range(solution.needed[j] + 1)] for j in tau}
    return solution, solution.deflections | motors, tau


def _balance(bound: Bound, damped: bool = False) -> Balance:
    """Newton-Euler torques of the machine in coordinates of its loads, in which bodies of a chain are parallel."""
    motor_chains = chains(bound)
    refuse_unfit(bound, motor_chains, damped)
    loads = LoadCoordinates(bound, motor_chains)
    motion = dynamics(loads.without_tip_angles, loads.rates(), given_rules(loads))
    name_dynamics(bound, motion, "[15]", "[61]")
    on_loads = loads.on_independent(motion.Gamma)
    if bound.machine.is_coupled or loads.stiffness_slopes:
        lost = loads.lost_forces()
        on_loads = {j: x + lost[j] for j, x in on_loads.items()}
    springs = _forces_of_chains(loads, on_loads)
    tau = {
        chain.motor: springs.pop(chain.motor) + loads.friction(chain.motor) - loads.passive_torque(chain.motor)
        for chain in motor_chains
    }
    motors = {j: chain.motor for chain in motor_chains for j in chain.joints}
    return Balance(loads, springs, tau, springs_behind(motor_chains), motors)


def _forces_of_chains(loads: LoadCoordinates, on_loads: Mapping[int, Scalar]) -> dict[int, Scalar]:
    """Loads on the coordinates z_j of bodies and of joints that follow them.

    T_k = s_k Gamma_k + sum of ratio_j F_j and of d others_j / dz_k F_j, over the springs j that follow k. F_j is T_j
    and what z_j changes of the stiffness of its spring.
    """
    followers: dict[int, dict[int, Scalar]] = {j: {} for chain in loads.chains for j in chain.joints}
    for j, stage in loads.stages.items():
        followers[stage.before][j] = stage.ratio
        for k, slope in loads.others[j].partials.items() if j in loads.others else ():
            followers[k][j] = followers[k].get(j, 0) + loads.senses[k] * slope
    loaded: dict[int, Scalar] = {}
    forces: dict[int, Scalar] = {}
    for k in TopologicalSorter(followers).static_order():
        transmitted: Scalar = 0
        for j, ratio in followers[k].items():
            transmitted = transmitted + ratio * forces[j]
        loaded[k] = transmitted + loads.senses[k] * on_loads[k]
        forces[k] = loaded[k] + loads.stiffening(k)
    return {j: loaded[j] for chain in loads.chains for j in reversed(chain.joints)}


def _solution(bound: Bound, balance: Balance) -> Solution:
    """q = q0 - s T / k of each spring [9], and z_before = (z - s q - others) / ratio, each after those that it needs.

    Where k changes with positions, `deflection_coefficients` solves the law of the spring for q.
    In a tree no two of them need each other: a spring feels what it carries, never its own motor.
    """
    loads = balance.loads
    reach = {j: _needs(bound, balance, j, behind) for j, behind in balance.outer.items()}
    order = _order(bound, reach)
    needed = _needed_derivatives(bound, balance, reach, order)
    z: dict[int, VariableCoefficient] = {j: partial(_motion, bound, balance.motors[j]) for j in balance.senses}
    variables: dict[str, VariableCoefficient] = {}
    for j, sense in balance.senses.items():
        for rate, symbols in enumerate((bound.q, bound.qd, bound.qdd)):
            variables[symbols[j].operands[0]] = partial(_rate, z, j, sense, rate)
    solution = Solution(needed, TimeSeries(variables), z, {}, {})
    for j in order:
        behind = balance.outer[j]
        sense, outside = balance.senses[behind], z[behind]
        spring = bound.machine.joint(behind).spring
        neutral, torque = bound.cell(spring.neutral), solution.series.of(balance.springs[behind], needed[j])
        if behind in loads.stiffness_slopes:
            deflection = bound.graph.symbol(deflection_symbol(behind, 0))
            law = loads.spring_law(behind, deflection)
            bent = deflection_coefficients(deflection, law, [-sense * T for T in torque], variables)
            bent[0] = bent[0] + neutral
        else:
            compliance = Fraction(1) / bound.cell(spring.stiffness)
            bent = [(0 if k else neutral) - sense * (compliance * T) for k, T in enumerate(torque)]
        if damping_of(bound, behind) != 0:
            solution.undamped[behind] = bent
            bent = [_lagging_coefficient(bound, behind, k) for k in range(len(bent))]
        solution.deflections[behind] = bent
        inner = [outside(k) - sense * x for k, x in enumerate(bent)]
        if behind in loads.others:
            other_terms = solution.series.of(loads.others[behind].value, needed[j])
            inner = [(x - y) / loads.stages[behind].ratio for x, y in zip(inner, other_terms, strict=True)]
        z[j] = inner.__getitem__
    return solution


def _needs(bound: Bound, balance: Balance, j: int, behind: int) -> Reach:
    """The coordinates, with their highest derivatives, from which z_j follows through its outer spring."""
    reach = _reach(bound, _terms_before(balance, behind))
    if behind in balance.loads.stiffness_slopes:
        law = _reach(bound, [balance.loads.spring_law(behind, bound.graph.symbol(deflection_symbol(behind, 0)))])
        reach = {k: max(rate, reach.get(k, 0)) for k, rate in (law | reach).items()}
    return reach


def _terms_before(balance: Balance, behind: int) -> list[Scalar]:
    """Expressions that determine the coordinate on the motor side of a spring."""
    other_terms = [balance.loads.others[behind].value] if behind in balance.loads.others else []
    return [balance.springs[behind], balance.loads.q[behind], *other_terms]


def _order(bound: Bound, reach: Mapping[int, Reach]) -> list[int]:
    """Joints in an order in which each depends on earlier ones only. Raises `InputError` for a cycle."""
    try:
        return [j for j in TopologicalSorter(reach).static_order() if j in reach]
    except CycleError as error:
        refuse_circle(bound, error.args[1])


def _motion(bound: Bound, motor: int, k: int) -> Scalar:
    """Taylor coefficient k of the outboard coordinate of a motor, by its symbols."""
    return bound.graph.symbol(motion_symbol(motor, k)) * Fraction(1, factorial(k))


def _lagging_coefficient(bound: Bound, j: int, k: int) -> Scalar:
    """Taylor coefficient k of the deflection of a spring with damping, by its symbols."""
    return bound.graph.symbol(deflection_symbol(j, k)) * Fraction(1, factorial(k))


def _rate(z: Mapping[int, VariableCoefficient], j: int, sense: int, rate: int, k: int) -> Scalar:
    """Taylor coefficient k of s_j z_j (`rate` 0), of its velocity (1) or of its acceleration (2)."""
    return z[j](k + rate) * (sense * factorial(k + rate) // factorial(k))


def _reach(bound: Bound, roots: Iterable[Scalar]) -> Reach:
    """The coordinates on which expressions depend, with their highest derivatives."""
    names = {
        x.operands[0]: (j, rate) for rate, group in enumerate((bound.q, bound.qd, bound.qdd)) for j, x in group.items()
    }
    highest: Reach = {}
    for node in reachable(roots):
        if node.operation == SYMBOL and node.operands[0] in names:
            j, rate = names[node.operands[0]]
            highest[j] = max(rate, highest.get(j, 0))
    return highest


def _needed_derivatives(bound: Bound, balance: Balance, reach: Mapping[int, Reach], order: Sequence[int]) -> Reach:
    """Highest derivatives of the coordinates that torques and velocities of motors need. Raises `InputError`."""
    needed = dict.fromkeys(balance.senses, 1) | {
        j: max(1, rate) for j, rate in _reach(bound, balance.tau.values()).items()
    }
    for j in reversed(order):
        for other, rate in reach[j].items():
            needed[other] = max(needed[other], needed[j] + rate)
    for j, highest in needed.items():
        if highest > HIGHEST_DERIVATIVE:
            refuse_high_order(bound, j, highest)
    return needed


def _arguments(bound: Bound, results: Results) -> dict[str, tuple[str, ...]]:
    """y and the derivatives of y on which the results depend: names of their entries, by motor."""
    used = {x.operands[0] for x in reachable(x for r in results.values() for x in r.entries) if x.operation == SYMBOL}
    entries = {row.name: bound.arguments()[row.name] for row in MOTION}
    highest = max((k for k, names in enumerate(entries.values()) if used & set(names)), default=0)
    return dict(islice(entries.items(), highest + 1))


def _name_series(bound: Bound, series: TimeSeries) -> None:
    """Name the Taylor coefficients in time of named quantities."""
    for number, (label, negative) in list(bound.names.labels.items()):
        coefficients = series.found.get(number, ())
        name = _angle_name(bound, coefficients[0], label) or label.name if coefficients else ""
        for k, x in enumerate(coefficients):
            bound.names.give(-x if negative else x, f"{COEFFICIENT}_{k}_{name}" if k else name, label.section)


def _angle_name(bound: Bound, x: Scalar, label: Label) -> str:
    """The name `sin_y3_0` for the sine of a prescribed angle, `sin_y3_motor` for that of a motor; else empty."""
    node = x.operands[0] if isinstance(x, Expression) and x.operation == NEGATE else x
    if not isinstance(node, Expression) or node.operation not in (SIN, COS):
        return ""
    angle, j = node.operands[0], label.section.joint
    if isinstance(angle, Expression) and angle.operation == SYMBOL:
        return f"{node.operation}_{angle.operands[0]}"
    return f"{node.operation}_y{j}_motor" if j in bound.motors else ""


def _name_coordinates(bound: Bound, coordinates: Mapping[int, Sequence[Scalar]], prescribed: Mapping[int, int]) -> None:
    """Name coefficients in time of z_j, z'_j and z''_j; `wanted` names the motor whose prescribed motion z_j is."""
    for j, coefficients in coordinates.items():
        motor = (f"y{j}_motor", f"qd{j}", f"qdd{j}") if j in bound.motors else (f"y{j}_link",)
        outboard = [f"y{prescribed[j]}_{rate}" for rate in range(3)] if j in prescribed else ()
        for rate, name in enumerate(outboard or motor):
            for k, x in enumerate(coefficients[rate:]):
                scaled = x * (factorial(k + rate) // factorial(k))
                bound.names.give(scaled, f"{COEFFICIENT}_{k}_{name}" if k else name, Section(SPRINGS, j, "[9]"))


def _name_results(bound: Bound, q: Mapping[int, Sequence[Scalar]], tau: Mapping[int, Scalar]) -> None:
    """Name the compliance of springs, variables and velocities of joints, and torques."""
    for j, (variable, velocity, *_) in q.items():
        here = Section(SPRINGS, j, "[9]")
        if j not in tau and bound.machine.joint(j).spring.stiffness.names.isdisjoint(bound.machine.variables):
            bound.names.give(1 / bound.cell(bound.machine.joint(j).spring.stiffness), f"y{j}_compliance", here)
        bound.names.give(variable, f"y{j}_{'motor' if j in tau else 'spring'}", here)
        bound.names.give(velocity, f"qd{j}", here)
    for j, torque in tau.items():
        bound.names.give(torque, f"tau{j}", Section("Motor torques", j, "[61]"))


FEED_FORWARD = (
    Model(
        "feed_forward",
        "feed-forward: motor torques for a desired motion beyond the springs",
        "[9], [15]",
        tuple(row.name for row in MOTION),
        ("tau", "q", "qd"),
        _feed_forward,
        own=(replace(quantity("q"), meaning="joint variables: motor positions and deflections of springs"),),
        own_arguments=_arguments,
        checked_by=CheckedBy.EQUATIONS_OF_MOTION,
    ),
)


NEWTON_STEPS = 8
"""Sufficient where df/dd triples along the deflection, or falls to a quarter."""
SMALL_STEP = Fraction(1, 2**30)
"""The step before the last one, against the deflection: the last one then is its square, below rounding."""
NO_LOAD = Fraction(1, 2**200)
"""Square of a step that is small without any deflection, m2 or rad2."""


def deflection_coefficients(
    d: Expression, f: Scalar, loads: Sequence[Scalar], variables: Mapping[str, VariableCoefficient]
) -> list[Scalar]:
    """Coefficients in time of the symbol d, a deflection, where f(d) has those of `loads`.

    A load c on the coordinate behind a spring of energy k d^2/2 is balanced where f(d) = k d + k' d^2/2 = c, k' being
    the derivative of k by this coordinate. Newton's method finds d; every further coefficient needs a division by
    df/dd. Where f is not linear and the steps do not converge, it divides by zero and has no value. `variables`
    are coefficients of the other symbols of f.
    """
    name, graph = d.operands[0], d.graph
    now = {key: coefficient(0) for key, coefficient in variables.items() if graph.symbol(key) in {*reachable([f])}}
    force, slope = substitute(graph, [f, Differentiation([f]).by(d).of(f)], now)
    coefficients = [_root(d, force, slope, loads[0])]
    (rate,) = substitute(graph, [slope], {name: coefficients[0]})
    for n in range(1, len(loads)):
        coefficients_so_far = [*coefficients, 0]
        so_far = TimeSeries({**variables, name: coefficients_so_far.__getitem__}).of(f, n)[n]
        coefficients.append((loads[n] - so_far) / rate)
    return coefficients


def _root(d: Expression, force: Scalar, slope: Scalar, load: Scalar) -> Scalar:
    """The solution d of force(d) = load, by Newton's method; a single step from zero where the force is linear."""
    is_linear = d not in {*reachable([slope])}
    deflection: Scalar = 0
    steps: list[Scalar] = []
    for _ in range(1 if is_linear else NEWTON_STEPS):
        here, rate = substitute(d.graph, [force, slope], {d.operands[0]: deflection})
        steps.append((here - load) / rate)
        deflection = deflection - steps[-1]
    return deflection if is_linear else deflection / _one_where_small(d.graph, steps[-2], deflection)


def _one_where_small(graph: Graph, step: Scalar, deflection: Scalar) -> Scalar:
    """Return 1 where a step is small against the deflection, else 0."""
    slack = SMALL_STEP * SMALL_STEP * (deflection * deflection) + NO_LOAD - step * step
    return (1 + sign(graph, slack)) * Fraction(1, 2)


def damping_of(bound: Bound, j: int) -> Scalar:
    """Return damping and viscous friction of a spring, N m s/rad or N s/m."""
    joint = bound.machine.joint(j)
    return bound.cell(joint.spring.damping) + bound.cell(joint.friction.viscous)


def refuse_unfit(bound: Bound, motor_chains: Sequence[Chain], damped: bool) -> None:
    """Raise `InputError` for machines without feed-forward: moving base, undriven joints, damped springs, loops."""
    machine = bound.machine
    base = machine.base
    motion = (*base.velocity, *base.angular_velocity, *base.acceleration, *base.angular_acceleration)
    if not all(map(is_zero, bound.cells(motion))):
        _refuse(bound, "base", "it moves, and derivatives of its motion by time are not known: give a base at rest")
    if not bound.motors:
        _refuse(bound, "joints", NO_MOTOR)
    _refuse_loops(bound)
    driven = {j for chain in motor_chains for j in chain.joints}
    for j in machine.independent:
        for cell, what in _faults(bound, j, machine.joint(j), j in driven, damped):
            _refuse(bound, place_of(j, machine.joint(j), cell), what)


def _refuse_loops(bound: Bound) -> None:
    """Raise `InputError` for motors on dependent joints, and for loops without closed form."""
    machine = bound.machine
    for loop in bound.loops:
        if loop.is_assembled:
            what = "it has no closed form whose derivatives by time could be taken: with other dependent joints "
            _refuse(bound, f"loop {loop.loop.name}", what + "(dependent = [...]) it may have one; simulate needs none")
    for j in machine.dependent:
        joint = machine.joint(j)
        if joint.kind is Kind.MOTOR:
            what = "its variable follows from a loop: use the command feed-forward, to which the motion of the "
            what += "independent joints is given, or choose other dependent joints (dependent = [...])"
            _refuse(bound, place_of(j, joint, "kind"), what)


def refuse_circle(bound: Bound, joints: Sequence[int]) -> NoReturn:
    """Raise `InputError` for springs whose deflections depend on each other in a cycle."""
    names = [bound.machine.joint(j).name for j in dict.fromkeys(joints)]
    what = "the springs behind them need each other's deflections, so there is no closed form: lock one in a scene"
    if len(names) == 1:
        what = "the load of the spring behind it needs its deflection, so there is no closed form: lock it in a scene"
    _refuse(bound, f"joint{'s' if len(names) > 1 else ''} {', '.join(names)}", what)


def _faults(bound: Bound, j: int, joint: Joint, driven: bool, damped: bool) -> Iterator[tuple[str, str]]:
    if joint.kind is Kind.MOTOR:
        return
    if joint.kind is Kind.PASSIVE:
        yield "kind", "nothing drives it, so it cannot be made to follow: lock it in a scene, or make it a motor"
    if not driven:
        yield (
            "kind",
            "it is elastic, but not the single spring behind a motor on its axis: it vibrates by itself, whatever the "
            "motors do, and the desired motion has no torques in closed form: lock it in a scene",
        )
    if not is_zero(bound.cell(joint.spring.backlash)):
        yield "backlash", "the motor would have to jump where the spring changes flanks: leave it out"
    linear = (("damping", joint.spring.damping), ("viscous friction", joint.friction.viscous))
    for cell, formula in () if damped else linear:
        if not is_zero(bound.cell(formula)):
            what = "it makes the deflection of the spring a differential equation, without closed form: make it 0, or "
            yield cell, f"{what}use the command feed-forward, which integrates it"
    if not is_zero(bound.cell(joint.friction.coulomb)):
        yield "coulomb friction", "it lets the spring stick, so its deflection is unknown: make it 0"
    if not is_zero(bound.cell(joint.rotor_inertia)):
        yield "rotor_inertia", "an elastic joint has no rotor here: give the inertia to the motor or to a body"
    if not joint.spring.stiffness.names.isdisjoint(bound.machine.variables):
        if not is_zero(damping_of(bound, j)):
            yield "stiffness", "it depends on positions, and the spring has damping: make it a constant, or the other 0"
    elif is_zero(bound.cell(joint.spring.stiffness)):
        yield "stiffness", "a spring without stiffness transmits no torque: give it one"


def refuse_high_order(bound: Bound, j: int, order: int) -> NoReturn:
    """Raise `InputError` for a prescribed motion that is required with too many derivatives."""
    limit = f"at most {HIGHEST_DERIVATIVE} can be given"
    what = f"{order} derivatives of its motion are needed, {limit}: lock springs in a scene"
    _refuse(bound, place_of(j, bound.machine.joint(j)), what)


def _refuse(bound: Bound, place: str, what: str) -> NoReturn:
    raise bound.machine.error(place, f"feed_forward: {what}")
