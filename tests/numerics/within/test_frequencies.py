"""Natural frequencies of reduced models: as `modes` finds them, shifted by no more than allowed, none lost."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

import symoro_elastic as se
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.generation.pipeline import programs
from symoro_elastic.generation.reduced import ReducedModel, reduced_models
from symoro_elastic.machine.described import DescribedMachine
from symoro_elastic.machine.scene import ALL, Scene
from symoro_elastic.machine.within import Within, tolerance
from symoro_elastic.numerics.guarantees.running_error import ROUNDINGS
from symoro_elastic.numerics.within.frequencies import FrequencyShifts, NaturalFrequencies
from symoro_elastic.numerics.within.states import Bounds
from symoro_elastic.numerics.within.tape import NO_CHANGES, Tape
from symoro_elastic.symbolic.program import Program

from .cases import EXAMPLES, results_of

TWO_AXIS, BALL_SCREW = EXAMPLES / "two_axis.toml", EXAMPLES / "ball_screw.toml"
STEP = 1e-6


@cache
def machine(path) -> DescribedMachine:
    return se.read(path)


def reduced(path, model: str, **tolerances: str) -> ReducedModel:
    within = Within({name.removeprefix("all"): tolerance(text) for name, text in tolerances.items()})
    scene = Scene(models=(model,), within=within)
    return reduced_models(machine(path), scene, programs, [ROUNDINGS["double"]])[1][0]


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
    found = shifts._roots(shifts._balanced(start), NO_CHANGES)[0]
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
    assert shift.max() <= tolerance(allowed).value


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


def test_models_without_springs_are_refused() -> None:
    with pytest.raises(se.InputError, match="joints that swing"):
        reduced(EXAMPLES / "planar_2r.toml", "direct_dynamics", all="1 %", frequencies="1 %")
    with pytest.raises(se.InputError, match="direct_dynamics and inverse_dynamics"):
        reduced(TWO_AXIS, "inertia_matrix", all="1 %", frequencies="1 %")
    with pytest.raises(se.InputError, match="they limit what results allow"):
        reduced(TWO_AXIS, "direct_dynamics", frequencies="1 %")
