"""Which unknowns of an FMU depend on which knowns: exactly what their equations hold."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from symoro_elastic.fmu.programs import Programs
from symoro_elastic.fmu.variables import Layout, Variable
from symoro_elastic.models.tracing import Trace
from symoro_elastic.scalar import Scalar
from symoro_elastic.symbolic.expression import reachable
from symoro_elastic.symbolic.operations import SYMBOL


@dataclass(frozen=True)
class Unknown:
    """An unknown and the references of what it depends on; `kinds` where it is linear in them, else empty."""

    reference: int
    knowns: tuple[int, ...]
    kinds: tuple[str, ...] = ()

    def numbered(self, numbers: Mapping[int, int]) -> list[int]:
        """Return the knowns by their number among the variables."""
        return [numbers[one] for one in self.knowns]


@dataclass(frozen=True)
class Structure:
    """Outputs, derivatives, and unknowns of the initialization, which depend on parameters too."""

    outputs: tuple[Unknown, ...]
    derivatives: tuple[Unknown, ...]
    initial: tuple[Unknown, ...]


def structure_of(programs: Programs, layout: Layout) -> Structure:
    """Return what depends on what."""
    symbols = _references(programs, layout)
    known = {one.reference for one in layout.block("P")}
    accelerations, *others = programs.traces
    found = _unknowns(layout.block("DER_QD"), _roots(accelerations), symbols)
    outputs = [one for trace in others for one in _unknowns(layout.block("Y"), _roots(trace), symbols)]
    velocities = [
        Unknown(rate.reference, (state.reference,), ("constant",))
        for rate, state in zip(layout.block("DER_Q"), layout.block("QD"), strict=True)
    ]
    states = [Unknown(one.reference, (one.reference,), ("constant",)) for one in layout.states]
    return Structure(
        (*states, *(_without(one, known) for one in outputs)),
        (*velocities, *(_without(one, known) for one in found)),
        tuple(sorted((*velocities, *found, *outputs), key=lambda one: one.reference)),
    )


def _roots(trace: Trace) -> Iterable[Scalar]:
    return (x for result in trace.results.values() for x in result.entries)


def _unknowns(
    variables: Sequence[Variable], roots: Iterable[Scalar], symbols: Mapping[str, frozenset[int]]
) -> list[Unknown]:
    return [
        Unknown(one.reference, tuple(sorted(_needed(root, symbols))))
        for one, root in zip(variables, roots, strict=True)
    ]


def _needed(root: Scalar, symbols: Mapping[str, frozenset[int]]) -> frozenset[int]:
    names = (node.operands[0] for node in reachable([root]) if node.operation == SYMBOL)
    return frozenset().union(*(symbols.get(name, frozenset()) for name in names))


def _references(programs: Programs, layout: Layout) -> dict[str, frozenset[int]]:
    """Return the references of variables by symbol; those of what closes loops without closed form for q_dep."""
    of_inputs = {one.name: one.symbols for trace in programs.traces for one in trace.inputs}
    inputs = [*of_inputs.get("tau", ()), *of_inputs.get("f_ext", ())]
    motors = len(programs.machine.motors)
    references = [one.reference for one in layout.block("INPUT")]
    found = dict(zip(of_inputs.get("tau", ()), references[:motors], strict=True)) if of_inputs.get("tau") else {}
    found |= dict(zip(of_inputs.get("f_ext", ()), references[motors:], strict=True)) if len(inputs) > motors else {}
    found |= _pairs(of_inputs["q"], layout.block("Q")) | _pairs(of_inputs.get("qd", ()), layout.block("QD"))
    found |= _pairs([one.name for one in programs.package.parameters], layout.block("P"))
    closing = {one.reference for block in ("Q", "P") for one in layout.block(block)}
    return {name: frozenset({one}) for name, one in found.items()} | dict.fromkeys(
        of_inputs.get("q_dep", ()), frozenset(closing)
    )


def _pairs(symbols: Sequence[str], variables: Sequence[Variable]) -> dict[str, int]:
    return dict(zip(symbols, (one.reference for one in variables), strict=True)) if symbols else {}


def _without(unknown: Unknown, left_out: set[int]) -> Unknown:
    return Unknown(unknown.reference, tuple(one for one in unknown.knowns if one not in left_out))
