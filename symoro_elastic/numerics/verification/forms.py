"""The form of the direct dynamic model, by recursion or by the inertia matrix: operations, and errors as predicted.

Errors are predicted in single precision: in units of rounding they are the same in any precision,
as long as they are small. States are drawn from a seed and sines are rounded from double precision, so that a machine
gets the same form on every computer.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import cache
from typing import Any

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.restrict import restrict
from symoro_elastic.machine.scene import AUTO, INERTIA, RECURSION, Scene
from symoro_elastic.models.packaging import trace_models
from symoro_elastic.models.programs.catalogue import BY_INERTIA, TracedModel, models_of
from symoro_elastic.numerics.evaluation.arrays import evaluate_arrays
from symoro_elastic.numerics.evaluation.values import NoValues, parameter_values
from symoro_elastic.numerics.verification.states import States, moderate_states
from symoro_elastic.symbolic.arithmetic import Arithmetic, library
from symoro_elastic.symbolic.operations import ATAN2, COS, COSPI, PI, SIN
from symoro_elastic.symbolic.program import OperationCount

MODEL = "direct_dynamics"
WITHIN = 2.0
"""Largest error of a form, relative to the error of the recursion."""
DOUBT = 1.25
"""Predicted ratios of errors are true to this factor (`python -m tests.benchmarks.forms`)."""
STATES, DRAWS, SHARE = 1000, 4, 0.99
"""States for predicted errors in each draw of parameters, number of draws, share of states within the error."""
LONGEST = 20_000
"""Operations of a form whose error is predicted although it has more of them."""
LEAST, LARGEST = 0.5, 1e5
"""Smallest and largest predicted errors that count, in u: smaller ones are equal, larger ones predict nothing."""
NUMBERS_AT_ONCE = 2_000_000
U = 2.0**-24


@dataclass(frozen=True)
class Form:
    """A form of the model: its operations, and the predicted error that 99 of 100 states do not exceed.

    The error of a state is the largest one over the largest entry of the result, in units of half an ulp of 1.
    """

    name: str
    count: OperationCount
    error: float

    @property
    def operations(self) -> int:
        """Products, divisions and sums."""
        return self.count.products + self.count.add


@dataclass(frozen=True)
class Choice:
    """The chosen form, and the reason; `forms` are the traced forms, the recursion first.

    `traced` is the model of the scene in the form that was chosen: it is not traced again.
    """

    chosen: str
    reason: str
    forms: tuple[Form, ...]
    traced: TracedModel = field(repr=False, compare=False)

    @property
    def ratio(self) -> float:
        """Predicted error of the inertia matrix over that of the recursion; NaN without predictions."""
        errors = [max(form.error, LEAST) for form in self.forms]
        return errors[-1] / errors[0] if len(errors) > 1 else np.nan

    @property
    def sentence(self) -> str:
        """The choice with its reason."""
        return f"{MODEL} by the {WORDS[self.chosen]}: {self.reason}"


WORDS = {RECURSION: "recursion", INERTIA: "inertia matrix"}


def with_form(machine: Machine, scene: Scene) -> tuple[Scene, Choice | None]:
    """Return the scene with the form decided if it is `AUTO`, and the choice, None if there was nothing to choose.

    Where no model of the scene has forms, nothing is chosen. Raises `InputError` where the inertia matrix is asked for.
    """
    if not has_forms(scene):
        if scene.form == INERTIA:
            what = f"is of {MODEL}, which is not requested: add it to the models, or leave out --form"
            raise InputError(scene.source or machine.label, "--form", what)
        return replace(scene, form=RECURSION), None
    if scene.form != AUTO:
        return scene, None
    choice = chosen_form(machine, scene)
    return replace(scene, form=choice.chosen), choice


def has_forms(scene: Scene) -> bool:
    """Return whether a model of the scene has more than one form."""
    return bool(BY_INERTIA.keys() & {*models_of(scene)})


def chosen_form(machine: Machine, scene: Scene, with_errors: bool = False) -> Choice:
    """Return the form with the fewest operations whose predicted error is at most `WITHIN` times that of the recursion.

    It is decided by counts and seeded states, never by a clock. Where errors cannot be predicted it is the recursion.
    `with_errors` predicts them also where the recursion has the fewest operations.
    """
    recursion = _trace(machine, scene, RECURSION)
    first = Form(RECURSION, recursion.program.count, np.nan)
    least = fewest_operations(restrict(machine, scene))
    if least >= first.operations > 0:
        return Choice(RECURSION, f"{first.operations} operations, the inertia matrix needs more", (first,), recursion)
    inertia = _trace(machine, scene, INERTIA)
    second = Form(INERTIA, inertia.program.count, np.nan)
    if second.operations >= (LONGEST if with_errors else first.operations):
        return Choice(RECURSION, _more(first, second), (first, second), recursion)
    try:
        errors = predicted_errors(machine, scene, (recursion, inertia))
    except (InputError, NoValues) as error:
        return Choice(RECURSION, f"errors cannot be predicted: {error}", (first, second), recursion)
    forms = (replace(first, error=errors[0]), replace(second, error=errors[1]))
    chosen, reason = _choose(*forms)
    return Choice(chosen, reason, forms, inertia if chosen == INERTIA else recursion)


def _more(recursion: Form, inertia: Form) -> str:
    return f"{recursion.operations} operations, the inertia matrix needs {inertia.operations}"


def _choose(recursion: Form, inertia: Form) -> tuple[str, str]:
    """Return the form that is chosen of the two, and why."""
    counts = f"{inertia.operations} operations instead of {recursion.operations}"
    errors = f"predicted error {inertia.error:.3g} u, {recursion.error:.3g} u of the recursion"
    if inertia.operations >= recursion.operations:
        return RECURSION, _more(recursion, inertia)
    if not max(inertia.error, recursion.error) <= LARGEST:
        return RECURSION, "errors are too large to be predicted"
    if max(inertia.error, LEAST) * DOUBT > WITHIN * max(recursion.error, LEAST):
        return RECURSION, f"the inertia matrix needs {counts}, but it is less accurate: {errors}"
    return INERTIA, f"{counts}, {errors}"


def fewest_operations(machine: Machine) -> int:
    """Return the products and sums to factor the inertia matrix of the rotating joints; 0 for a machine with loops.

    Joints that follow others move with these: they add to entries of the matrix, and make none zero.
    """
    if machine.loops:
        return 0
    turning = {j for j in machine.independent if machine.joint(j).sigma == 0}
    below, total = [0], 0
    for j, joint in enumerate(machine.joints, start=1):
        k = below[joint.antecedent]
        below.append(k + (j in turning))
        total += k * (k + 1) if j in turning else 0
    return total


def predicted_errors(machine: Machine, scene: Scene, forms: tuple[TracedModel, ...]) -> list[float]:
    """Return, for each form, the error that 99 of 100 moderate states do not exceed, in u; infinite without a value.

    Parameters without value get a plausible one. Raises `InputError`, `NoValues`.
    """
    restricted = restrict(machine, scene)
    draws = [_draw(restricted, seed) for seed in range(DRAWS)]
    errors = [np.concatenate([_errors(form, states, values) for states, values in draws]) for form in forms]
    return [float(np.quantile(row, SHARE, method="higher")) for row in errors]


def _draw(machine: Machine, seed: int) -> tuple[States, dict[str, float]]:
    """Return states and values of parameters that single precision holds."""
    values = {name: _round(x) for name, x in parameter_values(machine, seed).items()}
    states = moderate_states(machine, STATES, seed, values)
    return states.map(_round), values


def _trace(machine: Machine, scene: Scene, form: str) -> TracedModel:
    outputs = {name: asked for name, asked in scene.outputs.items() if name == MODEL}
    only = replace(scene, models=(MODEL,), outputs=outputs, steps=(), form=form)
    return next(model for model in trace_models(machine, only).models if model.model.name == MODEL)


def _errors(form: TracedModel, states: States, values: dict[str, float]) -> Array:
    """Return the error at each state, in u."""
    step = max(1, NUMBERS_AT_ONCE // (1 + len(form.program.nodes)))
    parts = [states[k : k + step] for k in range(0, len(states), step)]
    return np.concatenate([_distance(form, part, values) for part in parts])


def _distance(form: TracedModel, states: States, values: dict[str, float]) -> Array:
    worst = np.zeros(len(states))
    found = evaluate_arrays(form, states, values, np.float32, _single())
    with np.errstate(all="ignore"):
        for name, exact in evaluate_arrays(form, states, values, np.float64).items():
            scale = np.abs(exact).max(axis=1, initial=0)
            apart = np.abs(found[name] - exact).max(axis=1, initial=0) / np.where(scale > 0, scale, 1) / U
            worst = np.maximum(worst, np.where(np.isnan(apart), np.inf, apart))
    return worst


@cache
def _single() -> Arithmetic[Any]:
    """Return single precision with functions rounded from double precision: equal on every processor."""

    def of(function: Callable[..., Any]) -> Callable[..., Any]:
        return lambda *xs: function(*(np.float64(x) for x in xs)).astype(np.float32)

    def number(x: Fraction | int) -> Any:
        return np.float32(float(x))

    own = {SIN: of(np.sin), COS: of(np.cos), ATAN2: of(np.arctan2), COSPI: of(lambda x: np.cos(np.pi * x))}
    return Arithmetic(number, library(np, {**own, PI: lambda: np.float32(np.pi)}))


def _round(x: Any) -> Any:
    """Return numbers that single precision holds."""
    return np.float64(np.float32(x))
