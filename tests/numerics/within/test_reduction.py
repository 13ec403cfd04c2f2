"""Reduced programs: what is left out where it can be worked out by hand, errors at states that no search has seen."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from symoro_elastic.machine.within import Tolerance
from symoro_elastic.numerics.within.reduction import reduce_program
from symoro_elastic.numerics.within.results import Reduction
from symoro_elastic.numerics.within.search import Sample, Search, largest
from symoro_elastic.numerics.within.states import unseen
from symoro_elastic.numerics.within.tape import Changes, Kind, Tape
from symoro_elastic.numerics.within.trials import Requirements, candidates_of, climb
from symoro_elastic.symbolic.expression import Operand
from symoro_elastic.symbolic.program import Names

from .cases import Case, Range, drawn, of_expressions, operations, planar, puma, results_of, two_axis, values_of

FEW = 20_000
"""States, where a million takes too long for a test."""


def reduced(case: Case, tolerance: float, **options) -> Reduction:
    required = Requirements(**{"states": FEW, "names": case.names} | options)
    return reduce_program(case.program, case.box, case.tolerances(tolerance), required)


def left(found: Reduction) -> str:
    return ", ".join(map(str, found.reduced.outputs[0].entries))


def ends(**widths: float) -> dict[str, tuple[float, float]]:
    return {name: (-width, width) for name, width in widths.items()}


# By hand


def test_small_terms_are_left_out() -> None:
    """Of 100 x + 0.5 y + 0.4 z, largest 100.9: both small terms at 1 %, the smaller one at 0.45 %, none at 0.3 %."""
    box = ends(v1=1, v2=1, v3=1)
    case = of_expressions(lambda v1, v2, v3: [v1 * 100 + v2 * 0.5 + v3 * 0.4], box)
    assert left(reduced(case, 0.01)) == "(v1*100)"
    assert left(reduced(case, 0.0045)) == "((v1*100) + (v2*1/2))"
    assert left(reduced(case, 0.003)) == left(reduced(case, 0.0)) == str(case.program.outputs[0].entries[0])


def test_effects_of_opposite_sign_make_room_for_each_other() -> None:
    """Neither 2 x (1 + y) nor 2 x (1 - y/4) can go at 1.5 %: with signs, as a difference, both together can."""
    box = ends(v1=1, v2=0.01, v3=1)
    case = of_expressions(lambda v1, v2, v3: [v3 * 100 + ((v1 + v1 * v2) * 2 - (v1 - v1 * v2 * 0.25) * 2)], box)
    assert left(reduced(case, 0.015)) == "(v3*100)"


def test_a_sum_within_its_parts_is_charged_once() -> None:
    """Of 100 x + (0.6 y + 0.3 z): the sum can go at 1 %, if its parts do not count again."""
    box = ends(v1=1, v2=1, v3=1)
    case = of_expressions(lambda v1, v2, v3: [v1 * 100 + (v2 * 0.6 + v3 * 0.3)], box)
    found = reduced(case, 0.0095)
    assert left(found) == "(v1*100)" and found.errors[0].climbed == pytest.approx(0.9, rel=1e-6)


def test_sines_of_small_angles_are_their_angles_cosines_one() -> None:
    """sin q - q is q^3/6, 0.17 % of the largest at 0.1 rad; 1 - cos q is 0.5 %."""
    box = ends(q1=0.1, v1=1)

    def make(q1, v1):
        sine, cosine = q1.graph.node("sin", q1), q1.graph.node("cos", q1)
        return [sine * 5, cosine * v1]

    case = of_expressions(make, box)
    found = reduced(case, 0.006)
    assert left(found) == "(q1*5), v1"
    assert {one.kind for one in found.left_out} == {Kind.STRAIGHTEN, Kind.FREEZE}
    assert [one.climbed for one in found.errors] == pytest.approx(
        [5 * (0.1 - math.sin(0.1)), 1 - math.cos(0.1)], rel=1e-9
    )
    assert left(reduced(case, 0.001)) == "(sin(q1)*5), (v1*cos(q1))"


def test_numbers_that_are_frozen_are_exact_in_the_program() -> None:
    """A cosine about 1 rad is frozen at a round number: the error is what this number gives, to the last digit."""
    case = of_expressions(lambda q1, v1: [q1.graph.node("cos", q1) * v1], {"q1": (0.99, 1.01), "v1": (-2, 2)})
    found = reduced(case, 0.03)
    (one,) = found.left_out
    assert one.constant is not None and math.cos(1.01) < one.constant < math.cos(0.99)
    assert "cos" not in operations(found.reduced.outputs[0].entries)
    worst = 2 * max(one.constant - math.cos(1.01), math.cos(0.99) - one.constant)
    assert found.errors[0].climbed == pytest.approx(worst, rel=1e-12)


def test_results_that_are_zero_at_rest_stay_zero() -> None:
    """c c + s s - 1 is zero: it may be left out, but not a part of it, small as 1e-3 of it is beside v."""

    def make(q1, v1, p1):
        sine, cosine = q1.graph.node("sin", q1), q1.graph.node("cos", q1)
        return [v1 * 10 + (sine * sine * sine * p1 - sine * p1 + sine * cosine * cosine * p1)]

    case = of_expressions(make, ends(q1=math.pi, v1=1) | {"p1": (0.001, 0.001)})
    found = reduced(case, 0.01)
    assert left(found) == "(v1*10)"
    offset = of_expressions(lambda q1, v1: [v1 * 10 + v1 * 0.01 + q1.graph.node("cos", q1) * 0.001], ends(q1=1, v1=1))
    assert "cos" not in left(reduced(offset, 0.01))  # here it is not zero at rest


def test_positions_alone_have_no_rest() -> None:
    case = of_expressions(lambda q1, q2: [q1 * 10 + q2 * 0.01], ends(q1=1, q2=1))
    assert left(reduced(case, 0.01)) == "(q1*10)"


def test_each_entry_has_its_own_tolerance() -> None:
    box = ends(v1=1, v2=1)
    case = of_expressions(lambda v1, v2: [v1 * 2 + v2 * 0.01, v1 * 3 + v2 * 0.01, v1 * 3 + v2 * 0.01], box)
    tolerances = {"f": [Tolerance(0.0), Tolerance(0.02, relative=False), Tolerance(0.5)]}
    found = reduce_program(case.program, case.box, tolerances, Requirements(states=FEW))
    assert left(found) == "((v1*2) + (v2*1/100)), (v1*3), (v1*3)".replace("1/100", str(found_constant(case)))
    assert [one.tolerance for one in found.errors] == pytest.approx([0.0, 0.02, 0.02])


def found_constant(case: Case) -> object:
    return case.program.outputs[0].entries[0].operands[1].operands[1]


def test_a_denominator_changes_by_a_tenth_at_most() -> None:
    """x / (1 + 0.2 y): without 0.2 y the result is within 30 %, the denominator is not within 10 %."""
    case = of_expressions(lambda v1, v2: [v1 / (v2 * 0.2 + 1)], ends(v1=1, v2=1))
    assert left(reduced(case, 0.3)) == str(case.program.outputs[0].entries[0])
    case = of_expressions(lambda v1, v2: [v1 / (v2 * 0.05 + 1)], ends(v1=1, v2=1))
    assert left(reduced(case, 0.3)) == "v1"


@pytest.mark.sampled(2)
@pytest.mark.parametrize("make", [planar, puma])
def test_tolerance_zero_keeps_all(make) -> None:
    case = make()
    found = reduced(case, 0.0)
    assert found.left_out == () and found.reduced is case.program and found.outputs == case.program.outputs
    assert {one.climbed for one in found.errors} == {0.0}


# What is refused


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            lambda case: case._replace(box={k: x for k, x in case.box.items() if k != "v2"}),
            "no values over the box: v2",
        ),
        (lambda case: case._replace(box=case.box | {"v2": Range(1, -1)}), "v2: from 1.0 to -1.0 is not an interval"),
        (
            lambda case: case._replace(box=case.box | {"v2": Range(0, math.inf)}),
            "v2: from 0.0 to inf is not an interval",
        ),
    ],
)
def test_a_box_without_an_interval_is_refused(change, message) -> None:
    case = of_expressions(lambda v1, v2: [v1 + v2], ends(v1=1, v2=1))
    with pytest.raises(ValueError, match=message):
        reduced(change(case), 0.01)


@pytest.mark.parametrize(
    ("tolerances", "message"),
    [
        ({}, "no tolerance for f"),
        ({"f": [Tolerance(0.1)]}, "1 tolerances for the 2 entries of f"),
        ({"f": Tolerance(math.nan)}, "nan is not a tolerance of f"),
        ({"f": Tolerance(-0.1)}, "-0.1 is not a tolerance of f"),
    ],
)
def test_missing_tolerances_are_refused(tolerances, message) -> None:
    case = of_expressions(lambda v1, v2: [v1 + v2, v1 * v2], ends(v1=1, v2=1))
    with pytest.raises(ValueError, match=message):
        reduce_program(case.program, case.box, tolerances)


def test_results_that_are_not_finite_are_refused() -> None:
    case = of_expressions(lambda v1, v2: [v1.graph.node("sqrt", v1) + v2], ends(v1=1, v2=1))
    with pytest.raises(ValueError, match="not finite"):
        reduced(case, 0.01)


def test_a_program_without_work_stays() -> None:
    case = of_expressions(lambda v1: [v1, 3], ends(v1=1))
    assert reduced(case, 0.5).reduced is case.program


# Judges


def test_climbing_finds_the_worst_state() -> None:
    """Without it, 0.3 v^2 sin(q + 0.3) is at its largest where v is at a corner and q inside."""
    box = {"q1": (-math.pi, math.pi), "v1": (-2.0, 1.5), "v2": (-1.0, 1.0)}
    case = of_expressions(lambda q1, v1, v2: [v2 * 30 + q1.graph.node("sin", q1) * v1 * v1 * 0.3], box)
    found = reduced(case, 0.05)
    assert left(found) == "(v2*30)" and found.errors[0].climbed == pytest.approx(1.2, rel=1e-6)
    assert found.errors[0].unseen <= found.errors[0].climbed <= 1.2 * (1 + 1e-12)


@pytest.mark.sampled(2)
@pytest.mark.parametrize("make", [planar, puma])
def test_climbing_finds_more_than_states_that_are_drawn(make) -> None:
    case = make()
    tape, bounds = Tape(case.program), case.bounds()
    first = next(k for k, operation in enumerate(tape.operations) if operation == "cos")
    changes = Changes({*()}, {first: 0.0}, frozenset())  # type: ignore[arg-type]
    states = bounds.draw(1000, np.random.default_rng(0))
    weights = np.ones(len(tape.results))

    def errors(at):
        return tape.values(tape.rows(at, changes)) - tape.values(tape.rows(at))

    found = climb(tape, bounds, changes, states, errors(states), weights)
    reached = np.abs(errors(found.states)).max(axis=1)
    assert (bounds.inside(found.states) == found.states).all()
    assert (found.largest <= reached * (1 + 1e-12)).all()
    others = bounds.draw(50_000, np.random.default_rng(1))
    assert (found.largest >= np.abs(errors(others)).max(axis=1) * (1 - 1e-9)).all()


def test_the_worst_unseen_states_can_be_drawn_again() -> None:
    case = planar()
    found = reduced(case, 0.1)
    exact, other, bounds = Tape(case.program), Tape(found.reduced), case.bounds()
    seen = unseen(exact, other, bounds, np.ones(len(exact.results)), 10_000, (5,))
    worst = seen.worst_states(bounds, 1, 0.0)
    symbols = dict(zip(exact.symbols, worst, strict=True))
    errors = np.abs(results_of(found.reduced, symbols) - results_of(case.program, symbols)).max(axis=1)
    expected = dict(zip(exact.results, seen.worst, strict=True))
    places = [place for places in exact.entries for place in places]
    assert [errors[k] for k, place in enumerate(places) if place in expected] == pytest.approx(list(expected.values()))


@pytest.mark.thorough
def test_a_given_bound_is_kept() -> None:
    """A bound twice as large as the error lets half as much be left out; one that is never finite, nothing."""
    case = planar()
    calls = []

    def twice(program, other, changes):
        calls.append(other)
        symbols = drawn(case, 5000, 3)
        errors = 2 * np.abs(results_of(other, symbols) - results_of(program, symbols)).max(axis=1)
        return {"tau": errors[:2].tolist(), "qdd": errors[2:].tolist()}

    found, free = reduced(case, 0.1, bound=twice), reduced(case, 0.1)
    assert found.left_out and any(found.reduced is one for one in calls)
    assert all(one.bounded is not None and one.bounded <= one.tolerance for one in found.errors)
    assert all(one.bounded is None for one in free.errors)
    assert found.after.mul + found.after.add >= free.after.mul + free.after.add
    never = {output.name: [math.nan] * len(output.entries) for output in case.program.outputs}
    assert reduced(case, 0.1, bound=lambda program, other, changes: never, states=2000).reduced is case.program


def rare(*x: Operand) -> Operand:
    """A product that is large at rare states only, its 32nd power."""
    product: Any = math.prod(x)
    for _ in range(5):
        product = product * product
    return product


def test_what_is_said_with_confidence_is_no_less_than_what_is_known() -> None:
    """Many states are at the end of what is common; a rare one is beyond what their tail tells."""
    case = of_expressions(
        lambda v1, v2, **q: [v1 + (v2 + v2 * rare(*q.values())) * Fraction(1, 250)],
        dict.fromkeys(("v1", "v2", "q1", "q2", "q3", "q4", "q5"), (-1.0, 1.0)),
    )
    found = reduced(case, 0.01, confident=True)
    (error,) = found.errors
    assert found.left_out and error.confident is not None and error.unseen > 0.0040002
    assert error.confident >= max(error.sampled, error.climbed, error.unseen)


def test_the_same_seed_gives_the_same_program() -> None:
    case = planar()
    first, again, other = (reduced(case, 0.05, seed=seed) for seed in (4, 4, 5))
    assert first.left_out == again.left_out and first.errors == again.errors and first.outputs == again.outputs
    assert other.errors != first.errors


def searched(case: Case, limit: float, states: int) -> Search:
    tape = Tape(case.program)
    drawn_states = case.bounds().draw(states, np.random.default_rng(3))
    weights = 1 / (limit * np.abs(tape.values(tape.rows(drawn_states))).max(axis=1, keepdims=True))
    sample = Sample(drawn_states, np.repeat(weights, states, axis=1))
    return Search(tape, candidates_of(tape, tape.rows(drawn_states)), sample)


@pytest.mark.thorough
def test_a_search_goes_on_from_what_is_still_within_its_limits() -> None:
    former = searched(puma(), 0.05, 300).run()
    for limit, number in ((0.05, 2), (0.03, 0)):
        search = searched(puma(), limit, 900)
        found = search.run(former)
        kept = [count for count in former.steps if found.changes[:count] == former.changes[:count]]
        assert kept == former.steps[:number], limit
        assert largest(search.errors(list(found.changes))) <= 1, limit


def test_names_stay() -> None:
    """A quantity of the reduced program is that of the program without what is left out."""
    case, found = planar(), reduced(planar(), 0.1)
    before = {x.name for x in case.program.statements}
    named = {label.name for label, _ in case.names.labels.values()}
    kept = {x.name: x.node for x in found.reduced.statements if x.name in named}
    assert {*kept} <= before and len(kept) > len(before & named) // 3
    nodes = {label.name: number for number, (label, _) in case.names.labels.items()}
    values = {name: found.values[nodes[name]] for name in kept}
    symbols = drawn(case, 100, 2)
    expected, there = values_of([*values.values()], symbols), values_of([*kept.values()], symbols)
    same = np.abs(np.abs(there) - np.abs(expected)).max(axis=1)
    assert (same <= 1e-12 * np.abs(expected).max(axis=1)).all()


# Machines


def errors_at(case: Case, found: Reduction, states: int, seed: int, parts: int = 50) -> np.ndarray:
    """The largest error of each entry, of its tolerance, at states drawn here."""
    worst = np.zeros(sum(len(x.entries) for x in case.program.outputs))
    for part in range(parts):
        symbols = drawn(case, states // parts, seed * parts + part)
        worst = np.maximum(
            worst, np.abs(results_of(found.reduced, symbols) - results_of(case.program, symbols)).max(axis=1)
        )
    keys = [(output.name, k) for output in case.program.outputs for k in range(len(output.entries))]
    numbers = {key: number for number, key in enumerate(keys)}
    return np.array([worst[numbers[one.output, one.index]] / one.tolerance for one in found.errors])


@pytest.mark.parametrize(("make", "tolerance"), [(planar, 0.05), (planar, 0.1)])
def test_errors_at_other_states_are_within(make, tolerance) -> None:
    case = make()
    found = reduced(case, tolerance)
    assert found.left_out and errors_at(case, found, 50_000, 1).max() <= 1
    for one in found.errors:
        assert max(one.sampled, one.climbed, one.unseen, one.confident) <= one.tolerance


def total(found: Reduction) -> int:
    return found.after.mul + found.after.add + found.after.div


@pytest.mark.thorough
@pytest.mark.parametrize(("tolerance", "most"), [(0.01, 200), (0.003, 265)])
def test_puma_within_a_tolerance_at_a_million_states(tolerance, most) -> None:
    """Half of the states at corners; a set of states that has not been drawn before. Names would cost 2 or 3 more."""
    case = puma()
    found = reduced(case, tolerance, states=1_000_000, confident=False, names=Names())
    assert total(found) <= most and (found.before.mul, found.before.add) == (186, 157)
    assert errors_at(case, found, 1_000_000, 11).max() <= 1


@pytest.mark.thorough
def test_with_confidence_a_few_more_operations_are_needed() -> None:
    found = reduced(puma(), 0.01, states=200_000)
    assert total(found) <= 225 and all(one.confident <= one.tolerance for one in found.errors)


@pytest.mark.thorough
def test_a_machine_tool_needs_no_sines() -> None:
    found = reduced(two_axis(), 0.001, states=1_000_000)
    assert total(found) <= 140 and found.after.sincos == 0 and found.before.sincos == 4
    assert errors_at(two_axis(), found, 1_000_000, 12).max() <= 1
