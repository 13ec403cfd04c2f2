"""What there is to say about the loops of a machine: how each closes, on which branch, where it is singular."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from symoro_elastic.machine.checks import parameter_values
from symoro_elastic.machine.machine import Machine
from symoro_elastic.mechanics.spatial import Axis
from symoro_elastic.models.bind import closed_forms
from symoro_elastic.models.loops.closed_forms import loop_circuit
from symoro_elastic.models.loops.plan import Form, LoopPlan, Plan, plan_of
from symoro_elastic.symbolic.arithmetic import FLOATS, evaluate

NEAR_SINGULAR = 1e-6
"""Of the smallest singular value of W_d, relative, columns of length 1."""
COMPONENTS = ("force x", "force y", "force z", "moment x", "moment y", "moment z")
ROUNDING = 1e-12


@dataclass(frozen=True)
class DescribedLoop:
    """One loop: its plan, and what there is to say.

    `maps` are angles as sums of angles by variable, `start` the assembled values of its dependent variables, rad or m,
    `found` those of variables of its joints that no start gives, where some do;
    `dropped` what became of equations that follow from others, `undetermined` components of the reaction at the cut
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

    @property
    def is_near_singular(self) -> bool:
        """Whether the start is within 1e-6 of a singular position."""
        return self.distance is not None and self.distance < NEAR_SINGULAR


def described_loops(machine: Machine) -> list[DescribedLoop]:
    """The loops of a machine in the order in which they are closed; raises `InputError` where they do not close."""
    if not machine.loops:
        return []
    plan = plan_of(machine)
    return [_described(machine, plan, one) for one in plan.loops]


def singular_starts(loops: Iterable[DescribedLoop]) -> list[str]:
    """A warning for each loop that starts next to a singular position."""
    near = (loop for loop in loops if loop.is_near_singular)
    what = "start is within 1e-6 of a singular position: {}; branches meet there: move start to the intended side"
    return [f"loop {x.plan.loop.name}: {what.format(x.singular)}" for x in near]


def _described(machine: Machine, plan: Plan, one: LoopPlan) -> DescribedLoop:
    variables = {str(machine.joint(j).variable): j for j in one.dependent}
    return DescribedLoop(
        one,
        dict(_maps(machine, one)),
        {name: plan.positions[0][j] for name, j in variables.items()},
        {str(machine.joint(j).variable): plan.positions[0][j] for j in _found(machine, one)},
        _dropped(one),
        tuple(COMPONENTS[row] for row in one.dropped),
        _singular(machine, plan, one),
        None if one.form in (Form.MAP, Form.ONE) else _distance(machine, plan, one),
    )


def _found(machine: Machine, one: LoopPlan) -> list[int]:
    """Numbers of the joints of a loop with a start that no start gives."""
    around = machine.with_variable_in(one.loop) if one.loop.start else ()
    return [j for j in machine.not_started if j in around]


def _dropped(one: LoopPlan) -> str:
    count, total = len(one.dropped), len(one.dropped) + len(one.kept)
    if not count:
        return f"all {total} equations are needed"
    reason = (
        "follow from the others"
        if one.form in (Form.ONE, Form.INVERSE, Form.ASSEMBLED)
        else "are fulfilled by the plane"
    )
    return f"{count} of {total} equations {reason}"


def _maps(machine: Machine, one: LoopPlan) -> Iterator[tuple[str, str]]:
    """Angles of a parallelogram as sums; none where they hold parameters without value."""
    if one.form is not Form.MAP:
        return
    forms = closed_forms(machine)
    names = [str(joint.variable) for joint in machine.independent_joints]
    values = {parameter.name: math.nan for parameter in machine.parameters} | parameter_values(machine)

    def at(j: int, **unit: float) -> float:
        known = dict.fromkeys((*names, *map(str, machine.variables)), 0.0)
        return float(evaluate([forms[j]], values | known | unit, FLOATS)(forms[j]))

    for j in one.dependent:
        constant = at(j)
        terms = [(at(j, **{name: 1.0}) - constant, name) for name in names]
        if not any(math.isnan(factor) for factor, _ in terms):
            yield str(machine.joint(j).variable), _sum(terms, constant)


def _sum(terms: Sequence[tuple[float, str]], constant: float) -> str:
    """`q4 - 0.5 q2 + pi/2`."""
    found = sorted(((factor, name) for factor, name in terms if abs(factor) > ROUNDING), key=lambda term: term[0] < 0)
    quarters = round(constant / (math.pi / 2))
    if quarters and abs(constant - quarters * math.pi / 2) < ROUNDING:
        found.append((math.copysign(1.0, quarters), {1: "pi/2", 2: "pi", 3: "3 pi/2"}.get(abs(quarters), "2 pi")))
    elif abs(constant) > ROUNDING:
        found.append((constant, ""))
    text = ""
    for factor, name in found:
        size = "" if abs(abs(factor) - 1) < ROUNDING and name else f"{abs(factor):.6g}"
        sign = (" - " if factor < 0 else " + ") if text else "-" if factor < 0 else ""
        text += sign + " ".join(x for x in (size, name) if x)
    return text or "0"


def _singular(machine: Machine, plan: Plan, one: LoopPlan) -> str:
    """Where a loop is singular, in words that name its joints."""
    if not one.dependent:
        return "nowhere: other loops close it already"
    dependent = _listed([str(machine.joint(j).name) for j in one.dependent])
    if one.form is Form.MAP:
        return "nowhere: angles are sums of angles, in the flat position too"
    if one.form is Form.ONE:
        return f"nowhere: {dependent} compensates the motion of the other joints"
    if one.form in (Form.INVERSE, Form.ASSEMBLED):
        return f"where the rates of {dependent} do not follow from the others: det W_d = 0"
    unknown = loop_circuit(plan.assembly.tree, one.loop, one.dependent).unknown
    named = [(joint.axis, machine.joint(joint.joint or one.loop.cut).name) for joint in unknown]
    turns = [name for axis, name in named if axis is Axis.REVOLUTE]
    slides = [name for axis, name in named if axis is not Axis.REVOLUTE]
    if one.form is Form.TRIANGLE:
        return f"where the links between {_listed(turns)} meet stretched or folded: area of the triangle zero"
    if one.form is Form.SLIDE:
        return f"at the dead centre: the link between {_listed(turns)} stands at right angles to the slide {slides[0]}"
    return f"where the slides {_listed(slides)} are parallel"


def _listed(names: Sequence[str]) -> str:
    return " and ".join(x for x in (", ".join(names[:-1]), names[-1]) if x)


def _distance(machine: Machine, plan: Plan, one: LoopPlan) -> float:
    """Smallest singular value of W_d at the start, columns of length 1; of all loops where this one is not alone."""
    alone = len(one.kept) == len(one.dependent)
    rows = {(loop.loop.name, row) for loop in ([one] if alone else plan.loops) for row in loop.kept}
    dependent = one.dependent if alone else machine.dependent
    W = plan.assembly.numbers(plan.positions[0])[1]
    kept = [k for k, equation in enumerate(plan.assembly.equations) if (equation.loop, equation.row) in rows]
    W_d = W[np.ix_(kept, [machine.with_variable.index(j) for j in dependent])]
    lengths = np.linalg.norm(W_d, axis=0)
    if not np.all(lengths > 0):
        return 0.0
    return float(np.linalg.svd(W_d / lengths, compute_uv=False)[-1])
