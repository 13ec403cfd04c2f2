"""Natural frequencies of reduced models: as `modes` finds them, shifted by no more than allowed, none lost."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import symoro_elastic as se
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.generation.pipeline import programs
from symoro_elastic.generation.reduced_models.model import ReducedModel
from symoro_elastic.generation.reduced_models.search import reduced_models
from symoro_elastic.machine.described import DescribedMachine
from symoro_elastic.machine.scene import ALL, Scene
from symoro_elastic.machine.within import FREQUENCIES, Within, tolerance
from symoro_elastic.numerics.guarantees.box import box_of
from symoro_elastic.numerics.guarantees.running_error import ROUNDINGS
from symoro_elastic.numerics.within.frequencies import FrequencyShifts, NaturalFrequencies
from symoro_elastic.numerics.within.states import Bounds
from symoro_elastic.numerics.within.tape import NO_CHANGES, Change, Kind, Tape
from symoro_elastic.numerics.within.trials import candidates_of
from symoro_elastic.symbolic.program import Program
from tests.numerics.guarantees.boxes import limits_of_test
from tests.references.random_machines import chain

from .cases import EXAMPLES, results_of

TWO_AXIS, BALL_SCREW = EXAMPLES / "two_axis.toml", EXAMPLES / "ball_screw.toml"
STEP = 1e-6
CHECKS_ONE_BY_ONE = 429
"""Exact checks of the chain's search where each candidate is checked before it is taken."""


@cache
def machine(path) -> DescribedMachine:
    return se.read(path)


@cache
def elastic_chain() -> DescribedMachine:
    """Two slides and two elastic joints, under gravity."""
    found = chain(4, elastic=(2, 4), prismatic=(1, 3), symbolic=False)
    return replace(DescribedMachine.of(found), limits=limits_of_test(found))


def reduced(path, model: str, **tolerances: str) -> ReducedModel:
    return reduced_machine(machine(path), model, **tolerances)


def reduced_machine(of: DescribedMachine, model: str, **tolerances: str) -> ReducedModel:
    within = Within({name.removeprefix("all"): tolerance(text, name) for name, text in tolerances.items()})
    scene = Scene(models=(model,), within=within)
    return reduced_models(of, scene, programs, [ROUNDINGS["double"]])[1][0]


def whole_model(model: str) -> tuple[Program, Bounds]:
    """The program of the elastic chain, and its box."""
    asked = programs(elastic_chain(), Scene(models=(model,), fold=ALL))
    program = asked.package.functions[0].program
    box = box_of(asked.machine, elastic_chain().limits, program.inputs, program.used)
    return program, Bounds.of(Tape(program), box.ranges)


def shifts_of(program: Program, box: Bounds, motors: tuple[int, ...]) -> FrequencyShifts:
    return FrequencyShifts(NaturalFrequencies(tolerance("1 %"), motors), program, Tape(program), box, 5)


@pytest.mark.thorough
@pytest.mark.parametrize("model", ["direct_dynamics", "inverse_dynamics"])
@pytest.mark.parametrize("path", [TWO_AXIS, BALL_SCREW], ids=lambda path: path.stem)
def test_frequencies_of_whole_models_are_those_of_modes(path, model: str) -> None:
    asked = programs(machine(path), Scene(models=(model,), fold=ALL))
    program = asked.package.functions[0].program
    motors = asked.machine.motor_entries
    tape = Tape(program)
    names = {symbol: k for k, symbol in enumerate(tape.symbols)}
    at = {asked.machine.joint(j).name: 0.1 for j in asked.machine.motors}
    start = np.zeros((len(names), 1))
    for k in motors:
        if (symbol := program.inputs[0].symbols[k]) in names:
            start[names[symbol]] = 0.1
    box = Bounds(start, start, np.array(tape.is_position, dtype=bool)[:, None])
    shifts = FrequencyShifts(NaturalFrequencies(tolerance("1 %"), motors), program, tape, box, 0)
    found = shifts._roots(shifts._equilibria(start), NO_CHANGES)[0]
    held, free = (se.modes(machine(path), at=at, hold=hold).frequencies for hold in (["all"], []))
    expected = [*held[::-1], *(free[: len(motors) - 1 : -1] if model == "direct_dynamics" else ())]
    assert found.real / (2 * np.pi) == pytest.approx(expected, rel=1e-6)


def natural_frequencies(program: Program, at: dict[str, Array], motors: tuple[int, ...]) -> Array:
    """Those of a direct model, by central differences (states, modes), motors held by their torques, then free."""
    q, tau = (next(x.symbols for x in program.inputs if x.name == name) for name in ("q", "tau"))
    passive = [k for k in range(len(q)) if k not in motors]

    def slopes(name: str, step: float) -> Array:
        ends = [results_of(program, {**at, name: at[name] + sign * step}) for sign in (1, -1)]
        return (ends[0] - ends[1]) / (2 * step)

    J = np.array([slopes(name, STEP) for name in q]).transpose(2, 1, 0)
    B = np.array([slopes(name, 1.0) for name in tau]).transpose(2, 1, 0)
    held = np.linalg.solve(B[:, list(motors)], J[:, list(motors)])
    S = -(J[:, passive] - B[:, passive] @ held)[:, :, passive]
    return np.concatenate([frequencies(x)[:, : len(passive)] for x in (S, -J)], axis=1)


def frequencies(S: Array) -> Array:
    """Natural frequencies, by falling value; zero where a motion does not swing."""
    values = np.linalg.eigvals(S).astype(complex)
    roots = np.sqrt(values)
    return np.sort(np.where(values.real > 0, roots.real, 0.0), axis=1)[:, ::-1]


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("path", "results", "allowed"),
    [
        (TWO_AXIS, "1 %", "0.1 %"),
        (TWO_AXIS, "10 %", "2 %"),
        (BALL_SCREW, "5 %", "0.2 %"),
        (BALL_SCREW, "30 %", "100 %"),
    ],
)
def test_shifts_stay_within_their_tolerance_at_unseen_positions(path, results: str, allowed: str) -> None:
    one = reduced(path, "direct_dynamics", all=results, frequencies=allowed)
    whole, left = one.reduction.program, one.reduction.reduced
    assert one.reduction.left_out and one.reduction.shift is not None and one.reduction.shift <= 1
    box, motors = one.certificates[0].box, machine(path).motor_entries
    states = box.states(1000, np.random.default_rng(77))
    at = {
        name: states[name] if name in box.positions else np.zeros(1000)
        for a in whole.inputs
        for name in a.symbols
        if name in states
    }
    at |= {name: np.zeros(1000) for a in whole.inputs for name in a.symbols if name not in at}
    passive = [k for k in range(len(whole.inputs[0].symbols)) if k not in motors]
    at |= {whole.inputs[0].symbols[k]: np.zeros(1000) for k in passive}
    exact, found = (natural_frequencies(program, at, motors) for program in (whole, left))
    assert (found > 0).sum() == (exact > 0).sum()
    shift = np.abs(found - exact) / exact
    assert shift.max() <= tolerance(allowed, FREQUENCIES).value


@pytest.mark.thorough
def test_without_their_tolerance_frequencies_move_more() -> None:
    """The tolerance is what keeps them: of the ball screw 5 % of results shift one by a lot."""
    without = reduced(BALL_SCREW, "direct_dynamics", all="5 %")
    kept = reduced(BALL_SCREW, "direct_dynamics", all="5 %", frequencies="0.2 %")
    motors = machine(BALL_SCREW).motor_entries
    at = {name: np.zeros(1) for argument in kept.reduction.program.inputs for name in argument.symbols}
    exact, free, limited = (
        natural_frequencies(program, at, motors)
        for program in (kept.reduction.program, without.reduction.reduced, kept.reduction.reduced)
    )
    assert np.abs(free / exact - 1).max() > 0.002 >= np.abs(limited / exact - 1).max()


@pytest.mark.thorough
def test_models_without_springs_are_refused() -> None:
    with pytest.raises(se.InputError, match="joints that swing"):
        reduced(EXAMPLES / "planar_2r.toml", "direct_dynamics", all="1 %", frequencies="1 %")
    with pytest.raises(se.InputError, match="direct_dynamics and inverse_dynamics"):
        reduced(TWO_AXIS, "inertia_matrix", all="1 %", frequencies="1 %")
    with pytest.raises(se.InputError, match="they limit what results allow"):
        reduced(TWO_AXIS, "direct_dynamics", frequencies="1 %")


@pytest.mark.thorough
@pytest.mark.parametrize("model", ["direct_dynamics", "inverse_dynamics"])
def test_first_order_is_what_small_changes_do(model: str) -> None:
    """Single changes that shift by up to a tenth of the tolerance of 1 %: what is left is of the second order.

    Half a percent is that the estimate is scaled by what an eigenvalue may fall by, allowed (2 omega - allowed). A few
    changes are large, and cancel in what they shift: of these the second order is larger.
    """
    program, bounds = whole_model(model)
    tape, compared = Tape(program), list[tuple[Kind, bool]]()
    shifts = shifts_of(program, bounds, elastic_chain().motor_entries)
    effect = shifts.effects([])
    for change in candidates_of(tape, tape.rows(bounds.draw(200, np.random.default_rng(1)))):
        estimate, found = effect(change), shifts.errors([change])
        most = np.abs(found).max()
        if 1e-4 < most < 0.1:
            compared.append((change.kind, bool(np.abs(estimate - found).max() <= (0.0051 + 0.5 * most) * most)))
    assert len(compared) >= 50
    assert len({kind for kind, _ in compared}) >= 2
    assert np.mean([is_near for _, is_near in compared]) > 0.9


def test_a_position_that_becomes_a_number_takes_its_stiffness_away() -> None:
    program, bounds = whole_model("direct_dynamics")
    motors = elastic_chain().motor_entries
    (swinging, *_) = (k for k in range(4) if k not in motors)
    place = Tape(program).symbols[program.inputs[0].symbols[swinging]]
    found = shifts_of(program, bounds, motors).errors([Change(Kind.FREEZE, place, constant=0.0)])
    assert np.isinf(found).any()


def test_frequencies_are_checked_once_a_pass_and_kept_at_unseen_positions(monkeypatch) -> None:
    """A tenth of the checks that one for each candidate took; independent derivatives at 1000 other equilibria."""
    counted: list[int] = []
    errors = FrequencyShifts.errors
    monkeypatch.setattr(FrequencyShifts, "errors", lambda self, x: counted.append(len(x)) or errors(self, x))
    one = reduced_machine(elastic_chain(), "direct_dynamics", all="3 %", frequencies="0.5 %")
    assert 0 < len(counted) <= CHECKS_ONE_BY_ONE / 10
    assert one.reduction.shift is not None and one.reduction.shift <= 1
    whole, left = one.reduction.program, one.reduction.reduced
    assert one.operations[1] <= 140 < one.operations[0]
    motors = elastic_chain().motor_entries
    tape = Tape(whole)
    bounds = Bounds.of(tape, one.certificates[0].box.ranges)
    states = shifts_of(whole, bounds, motors)._equilibria(bounds.at_rest(1000, np.random.default_rng(78)))
    at = {name: np.zeros(1000) for argument in whole.inputs for name in argument.symbols}
    at |= dict(zip(tape.symbols, states, strict=True))
    exact, found = (natural_frequencies(program, at, motors) for program in (whole, left))
    assert (exact[:, :4] > 0).all()
    assert (np.abs(found - exact) <= 0.005 * exact).all()
