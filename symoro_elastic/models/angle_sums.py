"""Models with sums of angles in place of products of sines and cosines, where that saves operations."""

from __future__ import annotations

from dataclasses import replace

from symoro_elastic.models.model import TracedModel
from symoro_elastic.symbolic.angle_sums import with_angle_sums
from symoro_elastic.symbolic.expression import Graph, operand, reachable
from symoro_elastic.symbolic.program import Names, OperationCount, Output, build


def on_angle_sums(traced: TracedModel, graph: Graph, names: Names) -> TracedModel:
    """The model on sums of angles; as it is where they save nothing, a sine or cosine more outweighs what they save."""
    roots = [x for result in traced.results.values() for x in result.entries]
    value = with_angle_sums(graph, roots)
    moved = names.moved({node.id: value(node) for node in reachable(roots)})
    results = {name: replace(r, entries=tuple(map(value, r.entries))) for name, r in traced.results.items()}
    outputs = [Output(name, r.shape, tuple(map(operand, r.entries))) for name, r in results.items()]
    program = build(traced.program.inputs, outputs, moved)
    if not _saves(traced.program.count, program.count):
        return traced
    return replace(traced, results=results, program=program, merged=True)


def _saves(before: OperationCount, after: OperationCount) -> bool:
    return after.sincos <= before.sincos and after.products + after.add < before.products + before.add
