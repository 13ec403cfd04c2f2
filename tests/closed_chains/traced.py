"""Results of traced models in many digits, at states of `closed_chains`."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from symoro_elastic.machine.machine import Machine
from symoro_elastic.models.bound.bind import Bound
from symoro_elastic.models.bound.model import Frames, Joints
from symoro_elastic.models.programs.catalogue import MODELS, points_among
from symoro_elastic.symbolic.arithmetic import evaluate_nodes, multiprecision
from symoro_elastic.symbolic.expression import reachable
from tests.references.closed_chains import DIGITS, Array, Chain, State, exact, in_many_digits

Results = dict[str, Array]


def results(
    machine: Machine,
    model: str,
    state: State,
    given: Mapping[str, Sequence[Any]] | None = None,
    asked: Joints | Frames = (),
) -> Results:
    """Results of a model at u, ud and what is `given` by argument."""
    return traced(machine, model, asked)(state, given or {}, {})


def traced(machine: Machine, model: str, asked: Joints | Frames = ()) -> Callable[..., Results]:
    """The function of a state, further arguments and values of parameters in place of the file's that a model is."""
    bound = Bound(machine, points=points_among(machine, asked))
    found = MODELS[model].run(bound, asked or machine.independent)
    nodes = list(reachable(x for result in found.values() for x in result.entries))

    @in_many_digits
    def evaluated(state: State, given: Mapping[str, Sequence[Any]], values: Mapping[str, Any]) -> Results:
        symbols = {p.name: p.value.evaluate({}, {}, exact) for p in machine.parameters if p.value} | dict(values)
        symbols |= Chain(machine, symbols).assemble(state)
        for name, numbers in {"q": state.u, "qd": state.ud, **given}.items():
            symbols |= dict(zip(bound.arguments()[name], map(exact, numbers), strict=True))
        value = evaluate_nodes(nodes, symbols, multiprecision(DIGITS))
        return {
            name: np.array([exact(value(x)) for x in result.entries], dtype=object).reshape(result.shape)
            for name, result in found.items()
        }

    return evaluated
