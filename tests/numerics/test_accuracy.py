"""Errors in ulps: right where the truth is known, proven by balls, whatever the number of states."""

from __future__ import annotations

import math
import sys
from collections.abc import Mapping
from fractions import Fraction
from typing import Any

import mpmath
import numpy as np
import pytest

from symoro_elastic.codegen.precision import DOUBLE, DOUBLE_DOUBLE, SINGLE
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.models.programs.catalogue import TracedModel, trace
from symoro_elastic.numerics.evaluation.arrays import EXTENDED, HAS_EXTENDED, evaluate_arrays
from symoro_elastic.numerics.evaluation.values import parameter_values
from symoro_elastic.numerics.verification import accuracy
from symoro_elastic.numerics.verification.accuracy import (
    NoEnclosure,
    Reference,
    distance,
    enclosures,
    measure,
    round_states,
    rounded_values,
    sums,
)
from symoro_elastic.numerics.verification.states import States
from symoro_elastic.symbolic.arithmetic import evaluate, multiprecision
from symoro_elastic.symbolic.expression import Graph
from symoro_elastic.symbolic.operations import COS, SIN
from symoro_elastic.symbolic.program import Input, Names, Output, build
from tests.extremes import states as at
from tests.extremes.machines import links, six_axes
from tests.references import multiprecision as reference
from tests.references.random_machines import chain, random_machine

pytest.importorskip("flint")

MACHINES = {"arm": chain(5, seed=3), "tree": random_machine(11, joints=7, symbolic=True, moving_base=True)}


def exact(traced: TracedModel, states: States, values: Mapping[str, float]) -> list[list[Any]]:
    """The one result of a model by state, in 60 digits."""
    arithmetic, (output,) = multiprecision(60), traced.program.outputs
    found = []
    for k in range(len(states)):
        symbols = {name: arithmetic.number(Fraction(x)) for name, x in symbols_of(traced, states, k, values).items()}
        found.append(list(map(evaluate(output.entries, symbols, arithmetic), output.entries)))
    return found


def symbols_of(traced: TracedModel, states: States, k: int, values: Mapping[str, float]) -> dict[str, float]:
    symbols = dict(values)
    for argument in traced.program.inputs:
        symbols |= zip(argument.symbols, getattr(states, argument.name)[k].tolist(), strict=True)
    return symbols


@pytest.mark.sampled(2)
@pytest.mark.parametrize("name", MACHINES)
def test_errors_that_are_put_in_come_out(name: str) -> None:
    """The exact result, rounded, then one entry of a state spoilt by 1000 u of the largest."""
    machine = MACHINES[name]
    traced, states, values = trace(machine, "direct_dynamics"), at.moderate(machine, 6), parameter_values(machine)
    truth = exact(traced, states, values)
    results = np.array([[float(x) for x in row] for row in truth])
    found = measure(Reference(traced, states, values), {"qdd": results})
    assert found.judged == 6 and found.worst <= 1 and 0 < found.typical <= found.worst < found.input_effect
    results[4, 1] += 1000 * 2.0**-53 * np.abs(results[4]).max()
    spoilt = measure(Reference(traced, states, values), {"qdd": results})
    assert spoilt.at == 4 and abs(spoilt.worst - 1000) <= 2
    assert spoilt.relative == spoilt.worst * 2.0**-53


@pytest.mark.thorough
def test_results_in_two_parts_are_judged_by_balls() -> None:
    machine = MACHINES["arm"]
    traced, states, values = trace(machine, "direct_dynamics"), at.moderate(machine, 3), parameter_values(machine)
    truth = exact(traced, states, values)
    high = np.array([[float(x) for x in row] for row in truth])
    low = np.array([[float(x - float(x)) for x in row] for row in truth])
    assert measure(Reference(traced, states, values), {"qdd": (high, low)}, DOUBLE_DOUBLE).worst <= 1
    assert measure(Reference(traced, states, values), {"qdd": high}, DOUBLE_DOUBLE).worst > 2.0**48


def test_every_way_to_the_truth_gives_the_same() -> None:
    """Extended precision and balls, and a reference that knows the machine but no recursion."""
    machine = MACHINES["arm"]
    traced, states, values = trace(machine, "direct_dynamics"), at.moderate(machine, 4), parameter_values(machine)
    extended = evaluate_arrays(traced, states, values, EXTENDED)["qdd"]
    for k in range(len(states)):
        entries = enclosures(traced.program, symbols_of(traced, states, k, values), 2.0**-100)["qdd"]
        scale = max(abs(float(x)) for x in entries)
        assert max(float(x.rad()) for x in entries) <= 2.0**-99 * scale
        high, low = extended[k].astype(float), (extended[k] - extended[k].astype(float)).astype(float)
        assert distance(sums([high.tolist(), low.tolist()]), entries) <= 2.0 ** (-55 if HAS_EXTENDED else -45)
        wanted = reference.direct_dynamics(
            machine, *(getattr(states, a)[k].tolist() for a in ("q", "qd", "tau")), values
        )
        with mpmath.workdps(40):
            apart = [abs(mpmath.mpf(x.mid().str(35, radius=False)) - y) for x, y in zip(entries, wanted, strict=True)]
        assert max(apart) <= 1e-25 * scale


def test_single_precision_is_measured_in_its_own_ulps() -> None:
    machine = six_axes()
    traced = trace(machine, "inverse_dynamics")
    states, values = round_states(at.moderate(machine, 50), SINGLE), rounded_values(parameter_values(machine), SINGLE)
    results = evaluate_arrays(traced, states, values, np.float32)
    found = measure(Reference(traced, states, values), results, SINGLE)
    assert 0.25 < found.typical < found.worst < 4 * found.input_effect < 4000
    assert measure(Reference(traced, states, values), results, DOUBLE).worst == pytest.approx(found.worst * 2**29)


def test_constants_are_rounded_once_as_in_generated_code() -> None:
    """sin(1.12) in single precision, not the sine of 1.12 in single precision."""
    machine = links(1, alphas=("1.12",))
    states = at.changed(at.moderate(machine, 1), q=np.zeros((1, 1)))
    found = evaluate_arrays(trace(machine, "geometric_model"), states, parameter_values(machine), np.float32)
    placed = next(iter(found.values())).reshape(4, 4)
    assert placed[2, 1] == np.float32(math.sin(1.12)) != np.sin(np.float32(1.12))


def test_without_extended_precision_balls_judge_every_state(monkeypatch: pytest.MonkeyPatch) -> None:
    machine = MACHINES["tree"]
    traced, states, values = trace(machine, "inverse_dynamics"), at.moderate(machine, 5), parameter_values(machine)
    results = evaluate_arrays(traced, states, values, np.float64)
    found = measure(Reference(traced, states, values), results)
    monkeypatch.setattr(accuracy, "HAS_EXTENDED", False)
    rigorous = measure(Reference(traced, states, values), results)
    assert (rigorous.worst, rigorous.at) == (found.worst, found.at) and math.isnan(rigorous.input_effect)
    assert rigorous.typical == pytest.approx(found.typical, rel=1e-2)


@pytest.mark.thorough
def test_what_cannot_be_judged_is_not_and_what_is_no_number_is_infinitely_wrong() -> None:
    machine = MACHINES["arm"]
    traced, states, values = trace(machine, "direct_dynamics"), at.moderate(machine, 4), parameter_values(machine)
    rates = states.qd.copy()
    rates[2] = 1e200
    beyond = at.changed(states, qd=rates)
    results = evaluate_arrays(traced, beyond, values, np.float64)["qdd"]
    assert measure(Reference(traced, beyond, values), {"qdd": results}).judged == 3
    results[1, 0] = math.nan
    found = measure(Reference(traced, beyond, values), {"qdd": results})
    assert found.at == 1 and found.worst == math.inf and found.typical < 10
    nothing = measure(Reference(traced, beyond[2:3], values), {"qdd": results[2:3]})
    assert nothing.judged == 0 and math.isnan(nothing.worst)


def test_division_by_zero_has_no_enclosure() -> None:
    graph = Graph()
    x = graph.symbol("x")
    program = build([Input("q", ("x",))], [Output("y", (1,), (1 / (graph.node(SIN, x) - x),))], Names())
    assert float(enclosures(program, {"x": 1e-3}, 1e-20)["y"][0]) == pytest.approx(-6e9)
    with pytest.raises(NoEnclosure, match="divides by"):
        enclosures(program, {"x": 0.0}, 1e-20)


def test_zero_is_proven_and_its_error_absolute() -> None:
    """sin2 + cos2 - 1."""
    graph = Graph()
    c, s = (graph.node(f, graph.symbol("x")) for f in (COS, SIN))
    program = build([Input("q", ("x",))], [Output("y", (1,), (c * c + s * s - 1,))], Names())
    zero = enclosures(program, {"x": 0.7}, 1e-20)["y"]
    assert distance(sums([[0.25]]), zero) == pytest.approx(0.25) and distance(sums([[math.nan]]), zero) == math.inf


def test_the_library_that_is_missing_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "flint", None)
    accuracy._flint.cache_clear()
    with pytest.raises(InputError, match=r"python-flint: pip install 'symoro-elastic\[accuracy\]'"):
        distance(sums([[0.0]]), [])
    accuracy._flint.cache_clear()
