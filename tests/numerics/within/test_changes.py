"""Changes of a program: their values, effects, what they save, and the expressions they give."""

from __future__ import annotations

import numpy as np
import pytest

from symoro_elastic.numerics.within.effects import Sweep, node_shift
from symoro_elastic.numerics.within.liveness import COSTS, Liveness
from symoro_elastic.numerics.within.tape import Change, Changes, Kind, Tape, changed_values, with_values
from symoro_elastic.numerics.within.trials import candidates_of, short_number
from symoro_elastic.symbolic.expression import Expression, Level, reachable
from symoro_elastic.symbolic.operations import OPERATIONS, SYMBOL

from .cases import Case, of_expressions, planar, puma, results_of, two_axis, values_of

MACHINES = pytest.mark.parametrize("make", [planar, puma, two_axis])


def some_changes(case: Case, seed: int, count: int) -> tuple[Tape, list[Change]]:
    """Changes drawn from all candidates, each possible after those before it."""
    tape, rng = Tape(case.program), np.random.default_rng(seed)
    candidates = candidates_of(tape, tape.rows(case.bounds().draw(200, rng)))
    live, found = Liveness(tape), []
    for number in rng.permutation(len(candidates))[:count]:
        if live.is_possible(candidates[number]):
            live.apply(candidates[number])
            found.append(candidates[number])
    return tape, found


def states_of(case: Case, count: int = 50) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    states = case.bounds().draw(count, np.random.default_rng(1))
    return states, dict(zip(Tape(case.program).symbols, states, strict=True))


@MACHINES
@pytest.mark.parametrize("seed", range(4))
def test_the_rebuilt_program_is_the_end_of_the_homotopy(make, seed) -> None:
    case = make()
    tape, taken = some_changes(case, seed, 12)
    changes = Changes.of(taken)
    states, symbols = states_of(case)
    new = with_values(case.program, changed_values(tape, changes))
    found = values_of([x for output in new for x in output.entries], symbols)
    rows = tape.rows(states, changes)
    expected = np.array([rows[place] for places in tape.entries for place in places])
    size = np.abs(expected).max(axis=1, keepdims=True)
    assert len(taken) > 3 and (np.abs(found - expected) <= 1e-12 * size).all()


@MACHINES
def test_the_program_is_its_beginning(make) -> None:
    case = make()
    tape, taken = some_changes(case, 0, 12)
    states, symbols = states_of(case)
    rows = tape.rows(states, Changes.of(taken), 1.0)
    found = np.array([rows[place] for places in tape.entries for place in places])
    expected = results_of(case.program, symbols)
    assert (np.abs(found - expected) <= 1e-12 * np.abs(expected).max(axis=1, keepdims=True)).all()


def test_each_change_on_the_way() -> None:
    case = of_expressions(
        lambda q1, v1, v2: [v1 * q1 + v2, v1 - v2 * q1, q1.graph.node("cos", q1) * v1, q1.graph.node("sin", q1)],
        {"q1": (-1, 1), "v1": (-1, 1), "v2": (-1, 1)},
    )
    tape = Tape(case.program)
    add, subtract, product, sine = (places for places in tape.entries[0])
    cosine = next(x for x in tape.operands[product] if tape.operations[x] == "cos")
    of = {name: np.array([x]) for name, x in (("q1", 0.7), ("v1", 0.4), ("v2", -0.3))}
    states = np.array([of[name] for name in tape.symbols])
    s, (q, v, w) = 0.25, (0.7, 0.4, -0.3)
    taken = [
        Change(Kind.DROP, add, tape.operands[add].index(tape.symbols["v2"])),
        Change(Kind.DROP, subtract, 0),
        Change(Kind.FREEZE, cosine, constant=0.8),
        Change(Kind.STRAIGHTEN, sine),
    ]
    found = tape.values(tape.rows(states, Changes.of(taken), s))[:, 0]
    frozen = 0.8 + s * (np.cos(q) - 0.8)
    assert found == pytest.approx([v * q + s * w, s * v - w * q, frozen * v, q + s * (np.sin(q) - q)], rel=1e-15)


@MACHINES
def test_effects_are_derivatives_along_the_homotopy(make) -> None:
    """At the exact program the effect of a change is -df/ds at s = 1; at a changed one likewise, for further ones."""
    case, step = make(), 1e-6
    tape, taken = some_changes(case, 3, 20)
    states, _ = states_of(case, 20)
    rows = tape.rows(states)
    exact = tape.values(rows)
    adjoints = Sweep(tape, len(tape.results), states.shape[1]).adjoints(rows, np.ones_like(exact))
    for change in taken:
        adjoint = adjoints[change.place]
        assert adjoint is not None
        effect = adjoint * node_shift(tape, rows, change)
        ahead, behind = (tape.values(tape.rows(states, Changes.of([change]), 1 + h)) for h in (step, -step))
        size = np.abs(exact).max(axis=1, keepdims=True) + np.abs(effect).max(axis=1, keepdims=True)
        assert (np.abs((behind - ahead) / (2 * step) - effect) <= 1e-6 * size).all(), change


def cost_of(entries) -> int:
    nodes = [x for x in reachable(entries) if x.level == Level.STATE and x.operation != SYMBOL]
    return sum(COSTS.get(OPERATIONS[node.operation].counted_as, 0) for node in nodes)


@pytest.mark.sampled(3)
@MACHINES
@pytest.mark.parametrize("seed", range(4))
def test_what_changes_save_is_saved_in_the_rebuilt_program(make, seed) -> None:
    """Rebuilding may fold a little more: equal expressions become one, numbers meet."""
    case = make()
    tape, taken = some_changes(case, seed, 10)
    live, done = Liveness(tape), []
    before = cost_of([x for output in case.program.outputs for x in output.entries])
    assert live.cost == before
    for change in taken:
        done.append(change)
        expected = live.cost - live.saved_by(change)
        assert live.cost >= expected and Liveness(tape, done[:-1]).cost == live.cost
        live.apply(change)
        new = with_values(case.program, changed_values(tape, Changes.of(done)))
        left = cost_of([x for output in new for x in output.entries])
        assert live.cost == expected and expected - 6 <= left <= expected


def test_no_operation_is_saved_twice() -> None:
    """Of x y + (z w + v), the product z w is saved once, by itself or with the sum that it is part of."""
    box = dict.fromkeys(("q1", "v1", "v2", "v3", "v4"), (-1, 1))
    case = of_expressions(lambda q1, v1, v2, v3, v4: [q1 * v1 + (v2 * v3 + v4)], box)
    tape = Tape(case.program)
    (outer,) = tape.results
    inner = next(x for x in tape.operands[outer] if tape.operations[x] == "+")
    product = next(x for x in tape.operands[inner] if tape.operations[x] == "*")
    small = Change(Kind.DROP, inner, tape.operands[inner].index(product))
    large = Change(Kind.DROP, outer, tape.operands[outer].index(inner))
    live = Liveness(tape)
    assert (live.cost, live.saved_by(small), live.saved_by(large)) == (4, 2, 3)
    live.apply(small)
    assert (live.cost, live.saved_by(large)) == (2, 1)
    live.apply(large)
    assert live.cost == 1 and not live.is_possible(small) and not live.is_possible(large)


def test_zeros_and_ones_go_upwards() -> None:
    """With q = 0 its sine is 0 and its cosine 1: of (v cos q + w sin q) u + sin q only v u is left."""
    box = dict.fromkeys(("q1", "v1", "v2", "v3"), (-1, 1))

    def make(q1, v1, v2, v3):
        sine, cosine = q1.graph.node("sin", q1), q1.graph.node("cos", q1)
        return [(v1 * cosine + v2 * sine) * v3 + sine]

    tape = Tape(of_expressions(make, box).program)
    live = Liveness(tape)
    sine, cosine = (tape.operations.index(name) for name in ("sin", "cos"))
    assert live.cost == 16 + 5
    live.apply(Change(Kind.FREEZE, sine, constant=0.0))
    assert live.cost == 8 + 2
    live.apply(Change(Kind.FREEZE, cosine, constant=1.0))
    assert live.cost == 1


def test_only_positions_are_frozen() -> None:
    box = {"q1": (-1, 1), "v1": (-1, 1)}
    case = of_expressions(lambda q1, v1: [v1 * q1.graph.node("cos", q1) + v1 * v1], box)
    tape = Tape(case.program)
    rows = tape.rows(case.bounds().draw(100, np.random.default_rng(0)))
    frozen = [c for c in candidates_of(tape, rows) if c.kind is Kind.FREEZE]
    assert {tape.operations[c.place] for c in frozen} == {SYMBOL, "cos"}
    assert {c.constant for c in frozen if tape.operations[c.place] == "cos"} >= {1.0}
    assert all(tape.nodes[c.place] is not case.program.outputs[0].entries[0] for c in frozen)


@pytest.mark.parametrize(
    ("x", "step", "found"), [(0.995123, 1e-4, 0.9951), (1e-5, 0.02, 0.0), (123.4, 10, 120), (3, 0, 3)]
)
def test_numbers_are_round(x, step, found) -> None:
    assert short_number(x, step) == found


def test_signs_leave_sines() -> None:
    """sin(x - y) without x is -sin y, its cosine cos y."""
    box = {"q1": (-1, 1), "q2": (-1, 1)}
    case = of_expressions(lambda q1, q2: [q1.graph.node(name, q1 - q2) for name in ("sin", "cos")], box)
    tape = Tape(case.program)
    angle = tape.operations.index("-")
    (output,) = with_values(case.program, changed_values(tape, Changes.of([Change(Kind.DROP, angle, 0)])))
    sine, cosine = output.entries
    assert isinstance(sine, Expression) and isinstance(cosine, Expression)
    assert (str(sine), str(cosine)) == ("-sin(q2)", "cos(q2)")
