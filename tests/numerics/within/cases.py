"""Programs and boxes that tests reduce."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.generation.pipeline import prepare
from symoro_elastic.machine.machine import Kind, Machine
from symoro_elastic.machine.scene import Scene
from symoro_elastic.machine.within import Tolerance
from symoro_elastic.models.bound.tracing import prune, schedule
from symoro_elastic.models.programs.catalogue import expressions_of_scene
from symoro_elastic.numerics.linear.grouping import grouping_by_rank
from symoro_elastic.numerics.within.states import Bounds
from symoro_elastic.numerics.within.tape import Tape
from symoro_elastic.symbolic.arithmetic import evaluate
from symoro_elastic.symbolic.expression import Expression, Graph, Operand
from symoro_elastic.symbolic.program import Input, Names, Output, Program, build

EXAMPLES = Path(__file__).parents[3] / "examples"


class Range(NamedTuple):
    """The values of an argument."""

    low: float
    high: float


Box = dict[str, Range]


class Case(NamedTuple):
    """A program of a model, the names of its quantities, and a box."""

    program: Program
    names: Names
    box: Box

    def tolerances(self, value: float) -> dict[str, Tolerance]:
        """The same relative tolerance for all results."""
        return {output.name: Tolerance(value) for output in self.program.outputs}

    def bounds(self) -> Bounds:
        """The box in the order of the symbols."""
        return Bounds.of(Tape(self.program), self.box)


def traced(machine: Machine, model: str) -> tuple[Program, Names]:
    """The program of a model with its parameters as numbers, and the names of its quantities."""
    (found,) = expressions_of_scene(machine, Scene((model,), fold="all"), grouping_by_rank)
    needed = prune(found)
    return schedule(needed).program, needed.needed.names


@cache
def puma() -> Case:
    """The inverse dynamic model of the PUMA 560, full turns, 2 rad/s, 5 rad/s2."""
    machine = prepare(EXAMPLES / "puma560_measured.toml", print, base=True)
    ends = {"q": np.pi, "qd": 2.0, "qdd_motor": 5.0}
    program, names = traced(machine, "inverse_dynamics")
    return Case(program, names, boxed(program, lambda name, k: ends[name]))


@cache
def planar() -> Case:
    """The inverse dynamic model of the planar arm, small."""
    machine = prepare(EXAMPLES / "planar_2r.toml", print)
    ends = {"q": np.pi, "qd": 2.0, "qdd_motor": 5.0}
    program, names = traced(machine, "inverse_dynamics")
    return Case(program, names, boxed(program, lambda name, k: ends[name]))


@cache
def two_axis() -> Case:
    """The direct dynamic model of a machine tool: 1 m of stroke, deflections of 1 mm and 1 mrad, 3000 N."""
    machine = prepare(EXAMPLES / "two_axis.toml", print)
    motors = [joint.kind == Kind.MOTOR for joint in machine.independent_joints]
    ends = {"q": (1e-3, 0.5), "qd": (0.1, 2.0)}
    program, names = traced(machine, "direct_dynamics")
    return Case(program, names, boxed(program, lambda name, k: ends[name][motors[k]] if name in ends else 3000.0))


def boxed(program: Program, end: Callable[[str, int], float]) -> Box:
    """A box about zero, its ends by the name of an argument and the number of the entry."""
    return {
        symbol: Range(-end(argument.name, k), end(argument.name, k))
        for argument in program.inputs
        for k, symbol in enumerate(argument.symbols)
    }


def of_expressions(make: Callable[..., Sequence[Operand]], box: Mapping[str, tuple[float, float]]) -> Case:
    """The program of results `f` of symbols: those named q are positions, all others move."""
    graph = Graph()
    symbols = {name: graph.symbol(name) for name in box}
    entries = tuple(make(**symbols))
    positions = tuple(name for name in box if name.startswith("q"))
    inputs = (Input("q", positions), Input("v", tuple(name for name in box if name not in positions)))
    names = Names()
    return Case(
        build(inputs, [Output("f", (len(entries),), entries)], names),
        names,
        {name: Range(*ends) for name, ends in box.items()},
    )


def values_of(entries: Sequence[Operand], symbols: Mapping[str, Array]) -> Array:
    """Values of expressions at states, apart from any tape."""
    from symoro_elastic.numerics.evaluation.arrays import arithmetic

    states = len(next(iter(symbols.values())))
    value = evaluate(entries, symbols, arithmetic(np.float64))
    return np.array([np.broadcast_to(value(x), states) for x in entries])


def results_of(program: Program, symbols: Mapping[str, Array]) -> Array:
    """Values of all entries of a program."""
    return values_of([x for output in program.outputs for x in output.entries], symbols)


def drawn(case: Case, states: int, seed: int) -> dict[str, Array]:
    """States by symbol, drawn here: all but positions of the second half at corners."""
    rng, found = np.random.default_rng(seed), {}
    positions = {s for x in case.program.inputs if x.name == "q" for s in x.symbols}
    for name, (low, high) in case.box.items():
        part = rng.random(states)
        if name not in positions:
            part[states // 2 :] = part[states // 2 :] < 0.5
        found[name] = low + (high - low) * part
    return found


def operations(entries: Sequence[Operand]) -> dict[str, int]:
    """How often each operation occurs in expressions, sines and all."""
    found: dict[str, int] = {}
    seen: set[int] = set()
    pending = [x for x in entries if isinstance(x, Expression)]
    while pending:
        node = pending.pop()
        if node.id not in seen:
            seen.add(node.id)
            found[node.operation] = found.get(node.operation, 0) + 1
            pending += [x for x in node.operands if isinstance(x, Expression)]
    return found
