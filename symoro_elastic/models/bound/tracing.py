"""Stages from the equations of a model to its program: trace, prune, schedule."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

from symoro_elastic.machine.frames import Points
from symoro_elastic.models.bound.model import Model, Results, TracedModel
from symoro_elastic.symbolic import program
from symoro_elastic.symbolic.angle_sums import with_angle_sums
from symoro_elastic.symbolic.expression import Expression, Graph, Level, operand, reachable
from symoro_elastic.symbolic.program import Input, Names, OperationCount, Output, Pruned


@dataclass(frozen=True, eq=False)
class Trace:
    """The results of a model as expressions over the symbols of a machine, and the names of quantities among them.

    `whole` and `points` are those of `TracedModel`; `merges` allows sums of angles, `merged` says that it has some.
    """

    model: Model
    inputs: tuple[Input, ...]
    results: Results
    graph: Graph
    names: Names
    whole: bool
    points: Points
    merges: bool = False
    merged: bool = False

    @property
    def outputs(self) -> list[Output]:
        """The results as arrays."""
        return [Output(name, r.shape, tuple(map(operand, r.entries))) for name, r in self.results.items()]

    @cached_property
    def nodes(self) -> list[Expression]:
        """Every node that the results need, operands before their users."""
        return reachable(x for output in self.outputs for x in output.entries)


@dataclass(frozen=True, eq=False)
class PrunedTrace:
    """A trace and the nodes that its results need."""

    trace: Trace
    needed: Pruned

    @property
    def count(self) -> OperationCount:
        """Operations of a call."""
        return program.count(self.needed.nodes, Level.STATE)

    @property
    def count_once(self) -> OperationCount:
        """Operations once for each parameter set."""
        return program.count(self.needed.nodes, Level.PARAMETER)


def prune(trace: Trace) -> PrunedTrace:
    """The trace with only the nodes that its results need; with sums of angles where these save operations."""
    pruned = _prune_trace(trace)
    if not trace.merges:
        return pruned
    merged = _prune_trace(_on_angle_sums(trace))
    before, after = pruned.count, merged.count  # a further sine or cosine would outweigh other operations saved
    saves = after.sincos <= before.sincos and after.products + after.add < before.products + before.add
    return merged if saves else pruned


def schedule(pruned: PrunedTrace) -> TracedModel:
    """The model as a program, its statements in the order of the recursions and joints."""
    trace = pruned.trace
    scheduled = program.schedule(trace.inputs, pruned.needed)
    return TracedModel(trace.model, trace.results, scheduled, trace.whole, trace.points, trace.merged)


def _prune_trace(trace: Trace) -> PrunedTrace:
    return PrunedTrace(trace, program.prune(trace.outputs, trace.names))


def _on_angle_sums(trace: Trace) -> Trace:
    """The trace with sums of angles in place of products of sines and cosines."""
    roots = [x for result in trace.results.values() for x in result.entries]
    value = with_angle_sums(trace.graph, roots)
    names = trace.names.moved({node.id: value(node) for node in reachable(roots)})
    results = {name: replace(r, entries=tuple(map(value, r.entries))) for name, r in trace.results.items()}
    return replace(trace, results=results, names=names, merged=True)
