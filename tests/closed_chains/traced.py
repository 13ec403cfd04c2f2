"""Results of traced models in many digits, at states of `closed_chains`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from symoro_elastic.machine.machine import Machine
from symoro_elastic.models.bind import Bound
from symoro_elastic.models.catalogue import MODELS, points_of
from symoro_elastic.models.model import Frames, Joints
from symoro_elastic.symbolic.arithmetic import evaluate, multiprecision
from tests.references.closed_chains import DIGITS, Array, Chain, State, exact, in_many_digits


@in_many_digits
def results(
    machine: Machine,
    model: str,
    state: State,
    given: Mapping[str, Sequence[Any]] | None = None,
    asked: Joints | Frames = (),
    values: Mapping[str, Any] | None = None,
) -> dict[str, Array]:
    """Results of a model at u, ud and what is `given` by argument; `values` of parameters in place of the file's."""
    arithmetic, bound = multiprecision(DIGITS), Bound(machine, points=points_of(asked))
    traced = MODELS[model].run(bound, asked or machine.moving)
    symbols = {p.name: p.value.evaluate({}, {}, exact) for p in machine.parameters if p.value} | dict(values or {})
    symbols |= Chain(machine, symbols).assemble(state)
    arguments = {"q": state.u, "qd": state.ud, **(given or {})}
    for name, numbers in arguments.items():
        symbols |= dict(zip(bound.arguments()[name], map(exact, numbers), strict=True))
    value = evaluate([x for result in traced.values() for x in result.entries], symbols, arithmetic)
    return {
        name: np.array([exact(value(x)) for x in result.entries], dtype=object).reshape(result.shape)
        for name, result in traced.items()
    }
