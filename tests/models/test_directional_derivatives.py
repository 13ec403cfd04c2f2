"""Directional derivatives are the derivative models times the seeds, dependent variables moving along."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
import pytest

from symoro_elastic.machine.constants import with_free_numbers
from symoro_elastic.machine.machine import Machine
from symoro_elastic.models.bound.bind import Bound
from symoro_elastic.models.bound.tracing import Trace
from symoro_elastic.models.derivatives.directional_derivatives import directional_derivative
from symoro_elastic.models.programs.catalogue import MODELS, trace_of
from symoro_elastic.numerics.evaluation.closed_positions import Followed
from symoro_elastic.symbolic.arithmetic import FLOATS, evaluate
from tests.generation.fmu.machines import assembled, elastic_arm, four_bar

DIRECT = "direct_dynamics"
STATE = {"q": "dq", "qd": "dqd", "tau": "dtau"}


def traced(bound: Bound, name: str) -> Trace:
    model = MODELS[name]
    return trace_of(model, bound, model.run(bound, bound.machine.independent))


def numbers(trace: Trace, values: Mapping[str, float]) -> list[np.ndarray]:
    value = evaluate([x for result in trace.results.values() for x in result.entries], values, FLOATS)
    return [np.array([float(value(x)) for x in r.entries]).reshape(r.shape) for r in trace.results.values()]


def state_of(bound: Bound, source: np.random.Generator) -> dict[str, float]:
    """A position on which loops are closed, velocities, torques and the machine's parameters, by symbol."""
    machine, names = bound.machine, bound.arguments()
    parameters = {p.name: p.value.value() for p in machine.parameters if p.value is not None}
    q = 0.1 * source.uniform(-1, 1, len(machine.independent))
    if machine.loops:
        start = {name: x.value(parameters) for loop in machine.loops for name, x in loop.start.items()}
        q += [start.get(str(joint.variable), 0.0) for joint in machine.independent_joints]
    found = dict(zip(names["q"], q, strict=True))
    if bound.assembled:
        (closed,) = Followed(machine, parameters).at(q[None])
        found |= dict(zip(names["q_dep"], closed, strict=True))
    for name in ("qd", "tau"):
        found |= dict(zip(names[name], source.uniform(-1, 1, len(names[name])), strict=True))
    return parameters | found


@pytest.mark.sampled(5)
@pytest.mark.parametrize("machine", [elastic_arm, four_bar, assembled], ids=lambda one: one.__name__)
def test_directional_derivatives_are_columns_times_seeds(machine: Callable[[], Machine]) -> None:
    described = with_free_numbers(machine(), ("bodies", "springs"), {})
    bound = Bound(described)
    assert bool(bound.assembled) == (machine is assembled)
    along = directional_derivative(bound, traced(bound, DIRECT))
    source = np.random.default_rng(5)
    state = state_of(bound, source)
    seeds = {name: source.uniform(-1, 1, len(symbols)) for name, symbols in _seeds(along).items()}
    values = state | {
        s: x for name, symbols in _seeds(along).items() for s, x in zip(symbols, seeds[name], strict=True)
    }
    (found,) = numbers(along, values)
    by_state = dict(zip(STATE, numbers(traced(Bound(described), f"{DIRECT}_derivatives"), state), strict=True))
    by_parameters = traced(Bound(described), f"{DIRECT}_parameter_derivatives")
    (by_p,) = numbers(by_parameters, state)
    listed = [p.name for p in described.parameters]
    columns = [listed.index(name) for name in by_parameters.results["dqdd_dp"].column_labels]
    expected = by_p @ seeds["seed_p"][columns]
    expected += sum(by_state[name] @ seeds[f"seed_{name}"] for name in STATE)
    np.testing.assert_allclose(found, expected, rtol=1e-11)


def _seeds(along: Trace) -> dict[str, tuple[str, ...]]:
    return {one.name: one.symbols for one in along.inputs if one.name.startswith("seed_")}


def test_constants_have_no_seed() -> None:
    bound = Bound(elastic_arm(), ("L",))
    along = directional_derivative(bound, traced(bound, DIRECT), ("L",))
    assert "seed_p" not in _seeds(along)
    assert along.model.name == "direct_dynamics_directional"
