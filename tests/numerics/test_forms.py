"""`--form auto`: the inertia matrix where it takes fewer operations, and its errors are those that were predicted."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from symoro_elastic.formats import read_machine
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.generation.pipeline import programs
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.restrict import restrict
from symoro_elastic.machine.scene import AUTO, INERTIA, RECURSION, Scene
from symoro_elastic.models.programs.catalogue import trace_scene
from symoro_elastic.numerics.evaluation.arrays import EXTENDED, HAS_EXTENDED, evaluate_arrays
from symoro_elastic.numerics.evaluation.values import parameter_values
from symoro_elastic.numerics.verification.forms import WITHIN, Choice, chosen_form, fewest_operations, with_form
from symoro_elastic.numerics.verification.implementations import numpy_model
from symoro_elastic.numerics.verification.states import States, moderate_states
from tests.benchmarks.commands import coupled
from tests.references.random_machines import chain, planar_2r, random_machine

pytestmark = pytest.mark.sampled(5)

EXAMPLES = Path(__file__).parents[2] / "examples"
DIRECT = Scene(("direct_dynamics",))
UNSEEN = 3000
BY_INERTIA = ("random 107", "random 113", "random 123", "random 137")
"""Machines whose choice is the inertia matrix; nothing was tuned by the random ones."""


@cache
def machine(name: str) -> Machine:
    """An example, a chain or a random machine."""
    kind, _, number = name.partition(" ")
    if kind == "chain":
        return chain(int(number))
    if kind == "random":
        return random_machine(int(number), joints=3 + (int(number) - 100) % 6)
    return read_machine(EXAMPLES / name)[0]


@cache
def choice(name: str) -> Choice:
    return chosen_form(machine(name), DIRECT, with_errors=True)


def errors(name: str, form: str, states: States, values: dict[str, float]) -> Array:
    """Measured errors of double precision over the largest acceleration, by state."""
    (traced,) = trace_scene(machine(name), Scene(("direct_dynamics",), form=form))
    exact = evaluate_arrays(traced, states, values, EXTENDED)
    found = evaluate_arrays(traced, states, values, np.float64)
    each = [abs(found[r] - exact[r]).max(axis=1) / abs(exact[r]).max(axis=1) for r in exact]
    return np.maximum.reduce(each).astype(float)


@pytest.mark.skipif(not HAS_EXTENDED, reason="errors are measured in extended precision")
@pytest.mark.parametrize("name", BY_INERTIA)
def test_where_it_is_chosen_its_measured_error_is_within_twice_that_of_the_recursion(name: str) -> None:
    """At states, and for values of parameters, that the prediction has not seen."""
    assert choice(name).chosen == INERTIA
    values = parameter_values(machine(name), 77)
    states = moderate_states(machine(name), UNSEEN, 77, values)
    measured = {form: errors(name, form, states, values) for form in (RECURSION, INERTIA)}
    worst = {form: np.quantile(each, 0.99) for form, each in measured.items()}
    assert worst[INERTIA] <= WITHIN * worst[RECURSION]


@pytest.mark.skipif(not HAS_EXTENDED, reason="errors are measured in extended precision")
def test_a_predicted_loss_is_there() -> None:
    """On eight bodies in a chain the inertia matrix is less accurate: so is it predicted, so is it measured."""
    found = choice("chain 8")
    values = parameter_values(machine("chain 8"), 77)
    states = moderate_states(machine("chain 8"), 1000, 77, values)
    measured = [np.quantile(errors("chain 8", form, states, values), 0.99) for form in (RECURSION, INERTIA)]
    assert found.chosen == RECURSION and found.ratio > WITHIN
    assert found.ratio / 1.25 < measured[1] / measured[0] < 1.25 * found.ratio
    assert "but it is less accurate: predicted error" in found.reason


@pytest.mark.thorough
def test_more_operations_are_never_chosen() -> None:
    found = choice("two_axis.toml")
    recursion, inertia = found.forms
    assert found.chosen == RECURSION and inertia.operations > recursion.operations
    assert found.sentence == "direct_dynamics by the recursion: 240 operations, the inertia matrix needs 585"


@pytest.mark.thorough
def test_long_chains_are_decided_without_a_trace_of_the_inertia_matrix() -> None:
    long = chain(40)
    found = chosen_form(long, DIRECT)
    assert [one.name for one in found.forms] == [RECURSION]
    assert fewest_operations(long) == sum(k * (k + 1) for k in range(40))


@pytest.mark.thorough
def test_fewest_operations_are_fewer_than_those_of_chains_with_couplings() -> None:
    for n in (4, 9, 14):
        through_the_matrix = trace_scene(coupled(n), replace(DIRECT, form=INERTIA))[0].program.count
        assert 0 < fewest_operations(coupled(n)) < through_the_matrix.products + through_the_matrix.add


@pytest.mark.thorough
def test_the_choice_is_the_same_each_time() -> None:
    assert chosen_form(machine("random 107"), DIRECT, with_errors=True) == choice("random 107")


def test_the_function_keeps_its_name_and_its_numbers() -> None:
    """By the inertia matrix it is, bit for bit, the model that is called so."""
    asked = Scene(("direct_dynamics", "direct_dynamics_by_inertia_matrix"), form=INERTIA)
    package = programs(planar_2r(), asked).package
    one, other = package.functions
    assert [one.name, other.name] == list(asked.models)
    assert [s.name for s in one.program.statements] == [s.name for s in other.program.statements]
    assert package.scene == "direct_dynamics through the inertia matrix"
    by_recursion = numpy_model(planar_2r())
    assert programs(planar_2r(), DIRECT).package.scene == "" == programs(planar_2r(), Scene()).package.scene
    assert by_recursion.direct_dynamics([0.1, 0.2], [0.0, 0.0], [1.0, 2.0]).shape == (2,)


@pytest.mark.thorough
def test_auto_generates_what_is_chosen() -> None:
    name = "random 107"
    found = programs(machine(name), Scene(("direct_dynamics",), form=AUTO))
    assert found.scene.form == choice(name).chosen == INERTIA
    assert restrict(machine(name), found.scene) == machine(name)


def test_it_is_refused_where_no_model_has_forms() -> None:
    with pytest.raises(InputError, match="--form: is of direct_dynamics, which is not requested"):
        with_form(planar_2r(), Scene(("jacobian",), form=INERTIA))
    asked, choice_ = with_form(planar_2r(), Scene(("jacobian",), form=AUTO))
    assert asked.form == RECURSION and choice_ is None
