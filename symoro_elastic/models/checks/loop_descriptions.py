"""Descriptions of the loops of a machine: closed form, branch, singular positions."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from symoro_elastic.foundation.errors import enumeration
from symoro_elastic.machine.checks import parameter_values
from symoro_elastic.machine.machine import Machine
from symoro_elastic.mechanics.spatial import Axis
from symoro_elastic.models.bound.bind import closed_forms
from symoro_elastic.models.loops.closed_forms import loop_circuit
from symoro_elastic.models.loops.plan import Form, LoopPlan, Plan, plan_of
from symoro_elastic.symbolic.arithmetic import FLOATS, evaluate

NEAR_SINGULAR = 1e-6
"""Smallest singular value of W_d, columns scaled to length 1, below which a start is near singular."""
COMPONENTS = ("force x", "force y", "force z", "moment x", "moment y", "moment z")
ROUNDING = 1e-12


@dataclass(frozen=True)
class DescribedLoop:
    """Description of a loop: its plan, closed form, start and singular positions.

    `maps` are angles as sums of angles by variable, `start` the assembled values of its dependent variables, rad or m,
    `found` those of variables of its joints that no start gives, where some do;
    `dropped` the number of redundant equations and why, `undetermined` components of the reaction at the cut
    joint. `distance` from a singular position at the start is 1 at most, None where there is none.
    """

    plan: LoopPlan
    maps: dict[str, str]
    start: dict[str, float]
    found: dict[str, float]
    dropped: str
    undetermined: tuple[str, ...]
    singular: str
    distance: float | None


def described_loops(machine: Machine) -> list[DescribedLoop]:
    """The loops of a machine in the order in which they are closed; raises `InputError` where they do not close."""
    if not machine.loops:
        return []
    plan = plan_of(machine)
    return [_describe(machine, plan, loop) for loop in plan.loops]


def singular_starts(loops: Iterable[DescribedLoop]) -> list[str]:
    """Warnings for loops that start next to a singular position."""
    singular = (loop for loop in loops if loop.distance is not None and loop.distance < NEAR_SINGULAR)
    what = "start is within 1e-6 of a singular position: {}; branches meet there: move start to the intended side"
    return [f"loop {x.plan.loop.name}: {what.format(x.singular)}" for x in singular]


def _describe(machine: Machine, plan: Plan, loop_plan: LoopPlan) -> DescribedLoop:
    variables = {str(machine.joint(j).variable): j for j in loop_plan.dependent}
    return DescribedLoop(
        loop_plan,
        dict(_maps(machine, loop_plan)),
        {name: plan.positions[0][j] for name, j in variables.items()},
        {str(machine.joint(j).variable): plan.positions[0][j] for j in _joints_without_start(machine, loop_plan)},
        _dropped_equations(loop_plan),
        tuple(COMPONENTS[row] for row in loop_plan.dropped),
        _singular(machine, plan, loop_plan),
        None if loop_plan.form in (Form.MAP, Form.ONE) else _distance(machine, plan, loop_plan),
    )


def _joints_without_start(machine: Machine, loop_plan: LoopPlan) -> list[int]:
    """Joints of a loop with a start, whose own position the start omits."""
    around = machine.with_variable_in(loop_plan.loop) if loop_plan.loop.start else ()
    return [j for j in machine.not_started if j in around]


def _dropped_equations(loop_plan: LoopPlan) -> str:
    count, total = len(loop_plan.dropped), len(loop_plan.dropped) + len(loop_plan.kept)
    if not count:
        return f"all {total} equations are needed"
    reason = (
        "follow from the others"
        if loop_plan.form in (Form.ONE, Form.INVERSE, Form.ASSEMBLED)
        else "are fulfilled by the plane"
    )
    return f"{count} of {total} equations {reason}"


def _maps(machine: Machine, loop_plan: LoopPlan) -> Iterator[tuple[str, str]]:
    """Angles of a parallelogram as sums of angles; none where they depend on parameters without value."""
    if loop_plan.form is not Form.MAP:
        return
    forms = closed_forms(machine)
    names = [str(joint.variable) for joint in machine.independent_joints]
    values = {parameter.name: math.nan for parameter in machine.parameters} | parameter_values(machine)

    def at(j: int, **unit: float) -> float:
        zeros = dict.fromkeys((*names, *map(str, machine.variables)), 0.0)
        return float(evaluate([forms[j]], values | zeros | unit, FLOATS)(forms[j]))

    for j in loop_plan.dependent:
        constant = at(j)
        terms = [(at(j, **{name: 1.0}) - constant, name) for name in names]
        if not any(math.isnan(factor) for factor, _ in terms):
            yield str(machine.joint(j).variable), _sum(terms, constant)


def _sum(terms: Sequence[tuple[float, str]], constant: float) -> str:
    """The text of a sum of angles, such as `q4 - 0.5 q2 + pi/2`."""
    shown = sorted(((factor, name) for factor, name in terms if abs(factor) > ROUNDING), key=lambda term: term[0] < 0)
    quarters = round(constant / (math.pi / 2))
    if quarters and abs(constant - quarters * math.pi / 2) < ROUNDING:
        shown.append((math.copysign(1.0, quarters), {1: "pi/2", 2: "pi", 3: "3 pi/2"}.get(abs(quarters), "2 pi")))
    elif abs(constant) > ROUNDING:
        shown.append((constant, ""))
    text = ""
    for factor, name in shown:
        size = "" if abs(abs(factor) - 1) < ROUNDING and name else f"{abs(factor):.6g}"
        sign = (" - " if factor < 0 else " + ") if text else "-" if factor < 0 else ""
        text += sign + " ".join(x for x in (size, name) if x)
    return text or "0"


def _singular(machine: Machine, plan: Plan, loop_plan: LoopPlan) -> str:
    """Sentence about where a loop is singular, by names of its joints."""
    if not loop_plan.dependent:
        return "nowhere: other loops close it already"
    dependent = enumeration([str(machine.joint(j).name) for j in loop_plan.dependent])
    if loop_plan.form is Form.MAP:
        return "nowhere: angles are sums of angles, in the flat position too"
    if loop_plan.form is Form.ONE:
        return f"nowhere: {dependent} compensates the motion of the other joints"
    if loop_plan.form in (Form.INVERSE, Form.ASSEMBLED):
        return f"where the rates of {dependent} do not follow from the others: det W_d = 0"
    unknown = loop_circuit(plan.assembly.tree, loop_plan.loop, loop_plan.dependent).unknown
    joints = [(joint.axis, machine.joint(joint.joint or loop_plan.loop.cut).name) for joint in unknown]
    turns = [name for axis, name in joints if axis is Axis.REVOLUTE]
    slides = [name for axis, name in joints if axis is not Axis.REVOLUTE]
    if loop_plan.form is Form.TRIANGLE:
        return f"where the links between {enumeration(turns)} meet stretched or folded: area of the triangle zero"
    if loop_plan.form is Form.SLIDE:
        link = f"the link between {enumeration(turns)}"
        return f"at the dead centre: {link} stands at right angles to the slide {slides[0]}"
    return f"where the slides {enumeration(slides)} are parallel"


def _distance(machine: Machine, plan: Plan, loop_plan: LoopPlan) -> float:
    """Smallest singular value of W_d at the start, columns of length 1; of all loops if this loop shares equations."""
    alone = len(loop_plan.kept) == len(loop_plan.dependent)
    rows = {(loop.loop.name, row) for loop in ([loop_plan] if alone else plan.loops) for row in loop.kept}
    dependent = loop_plan.dependent if alone else machine.dependent
    W = plan.assembly.numbers(plan.positions[0])[1]
    selected = [k for k, equation in enumerate(plan.assembly.equations) if (equation.loop, equation.row) in rows]
    W_d = W[np.ix_(selected, [machine.with_variable.index(j) for j in dependent])]
    lengths = np.linalg.norm(W_d, axis=0)
    if not np.all(lengths > 0):
        return 0.0
    return float(np.linalg.svd(W_d / lengths, compute_uv=False)[-1])
