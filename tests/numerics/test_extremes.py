"""The corpus of extremes: errors within their bounds, refusals and warnings in words, nothing silent."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

from symoro_elastic.foundation.errors import InputError
from symoro_elastic.generation.pipeline import refuse_degenerate
from symoro_elastic.machine.checks import check
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.scene import Scene
from symoro_elastic.numerics.verification.accuracy import NoEnclosure, enclosures
from tests.extremes import states as at
from tests.extremes.code import compiled
from tests.extremes.corpus import DIRECT, INVERSE, NOT_FINITE, REFUSED, WARNED, Extreme, corpus, locked_gimbal
from tests.extremes.machines import elastic_arm, links

pytestmark = pytest.mark.sampled(5)

pytest.importorskip("flint")


@pytest.mark.sampled(30)
@pytest.mark.parametrize("case", corpus(), ids=lambda case: case.name)
def test_errors_are_within_their_bounds(case: Extreme) -> None:
    with compiled(case.machine) as code:
        for model in (DIRECT, INVERSE):
            found = code.errors(model, case.states)
            assert found.judged == len(case.states), model
            assert found.worst <= max(case.ulps, case.share * found.input_effect), model


@pytest.mark.parametrize(("make", "words"), REFUSED.values(), ids=REFUSED)
def test_refusals_say_what_to_do(make: Callable[[], Machine], words: str) -> None:
    with pytest.raises(InputError) as caught:
        check(make())
        refuse_degenerate(make(), Scene())
    assert words in str(caught.value) and "\n" not in str(caught.value)


@pytest.mark.parametrize(("machine", "words"), WARNED.values(), ids=WARNED)
def test_warnings_name_the_cell(machine: Machine, words: str) -> None:
    (warning,) = check(machine)
    assert words in warning


@pytest.mark.thorough
def test_overflow_gives_no_number() -> None:
    """Squares of these velocities are beyond double precision, exactly too."""
    machine = elastic_arm(1000.0)
    states = at.fast(machine, 20, 160, 308)
    with compiled(machine) as code:
        for model, result in ((DIRECT, "qdd"), (INVERSE, "tau")):
            assert code.errors(model, states).judged == 0
            assert not np.isfinite(code.results(model, states)[result]).all(axis=1).any()


def test_a_locked_gimbal_has_no_finite_acceleration() -> None:
    machine, states = locked_gimbal()
    with compiled(machine) as code:
        assert not np.isfinite(code.results(DIRECT, states)["qdd"]).all(axis=1).any()
        symbols = dict(zip(code.traced[DIRECT].program.inputs[0].symbols, states.q[0], strict=True))
        rates = dict(zip(code.traced[DIRECT].program.inputs[1].symbols, states.qd[0], strict=True))
        with pytest.raises(NoEnclosure):
            enclosures(code.traced[DIRECT].program, symbols | rates, 1e-20)


@pytest.mark.sampled(12)
@pytest.mark.parametrize("number", NOT_FINITE.values(), ids=NOT_FINITE)
@pytest.mark.parametrize("argument", ["q", "qd", "tau"])
def test_no_number_in_none_out(argument: str, number: float) -> None:
    """At any joint of a chain: every acceleration depends on it."""
    machine = links(6)
    states = at.moderate(machine, 6)
    poisoned = getattr(states, argument).copy()
    poisoned[np.arange(6), np.arange(6)] = number
    with compiled(machine, models=(DIRECT,)) as code:
        found = code.results(DIRECT, at.changed(states, **{argument: poisoned}))["qdd"]
    assert not np.isfinite(found).any() or (argument == "q" and math.isnan(found[-1, -1]))
