"""A program cut in two: values that do not depend on some variables are computed once, the others for each value."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

from symoro_elastic.symbolic.arithmetic import evaluate, nodes
from symoro_elastic.symbolic.expression import Expression, Graph, Level, Operand
from symoro_elastic.symbolic.operations import SYMBOL
from symoro_elastic.symbolic.program import Output, Pruned, prune


@dataclass(frozen=True, eq=False)
class TwoStages:
    """`first` computes values by the names `handed`, `second` the results from them."""

    first: Pruned
    second: Pruned
    handed: tuple[str, ...]


def in_two_stages(graph: Graph, pruned: Pruned, late: Collection[str], handed_over: str) -> TwoStages:
    """Cut a program where it begins to depend on the variables `late`; `handed_over` names the array between."""
    border = _border(pruned, late)
    names = _names(pruned, border)
    first = prune([Output(handed_over, (len(border),), tuple(border))], pruned.names)
    return TwoStages(first, _second(graph, pruned, dict(zip(border, names, strict=True))), tuple(names))


def _border(pruned: Pruned, late: Collection[str]) -> list[Expression]:
    """Nodes to hand over: they depend on the state, not on late variables; nodes that do, or results, use them."""
    depends: set[int] = set()
    border: dict[int, Expression] = {}
    for node in pruned.nodes:
        operands = [x for x in node.operands if type(x) is Expression]
        if (node.operation == SYMBOL and node.operands[0] in late) or any(x.id in depends for x in operands):
            depends.add(node.id)
            border |= {x.positive.id: x.positive for x in operands if x.id not in depends and x.level == Level.STATE}
    results = (x for output in pruned.outputs for x in output.entries if type(x) is Expression)
    border |= {x.positive.id: x.positive for x in results if x.id not in depends and x.level == Level.STATE}
    return [border[number] for number in sorted(border)]


def _names(pruned: Pruned, border: Collection[Expression]) -> list[str]:
    """Names of the passed values: those of their quantities, or numbered."""
    names = []
    for number, node in enumerate(border):
        label, negative = pruned.names.labels.get(node.id, (None, False))
        if node.operation == SYMBOL:
            names.append(str(node.operands[0]))
        else:
            names.append(label.name if label and not negative else f"handed{number}")
    return names


def _second(graph: Graph, pruned: Pruned, border: dict[Expression, str]) -> Pruned:
    """The results over the variables of the passed values."""
    border_symbols: dict[int, Operand] = {node.id: graph.symbol(name) for node, name in border.items()}
    symbols: dict[str, Operand] = {x.operands[0]: x for x in pruned.nodes if x.operation == SYMBOL}
    roots = [x for output in pruned.outputs for x in output.entries]
    value = evaluate(roots, symbols, nodes(graph), border_symbols)
    outputs = [Output(o.name, o.shape, tuple(map(value, o.entries))) for o in pruned.outputs]
    moved = pruned.names.moved({node.id: value(node) for node in pruned.nodes if node.id not in border_symbols})
    return prune(outputs, moved)
