"""Formulations of the equations: by recursion or inertia matrix, grouped, folded, on sums of angles."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

from symoro_elastic.codegen.package import Package
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.generation.pipeline import refuse_degenerate
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.restrict import names_to_fold
from symoro_elastic.machine.scene import ALL, Scene
from symoro_elastic.models.packaging import trace_models
from symoro_elastic.models.programs.catalogue import DEFAULT_MODELS, MODELS, TracedModel
from symoro_elastic.numerics.linear.grouping import checked_grouping, grouping_by_rank
from symoro_elastic.numerics.verification.states import ARGUMENTS, depends_on_state
from symoro_elastic.symbolic.program import OperationCount

Values = Mapping[str, float]

RECURSION, BY_MATRIX = "recursion", "A^-1"
MOST_OPERATIONS = 200_000


@dataclass(frozen=True, eq=False)
class Formulation:
    """A formulation of the requested models; `traced` by requested name, `values` of its parameters."""

    way: str
    base: bool
    folded: bool
    merged: bool
    package: Package
    traced: Mapping[str, TracedModel]
    values: Values
    bound: float | None = None

    @property
    def words(self) -> str:
        """Name of the formulation in tables."""
        options = {"base parameters": self.base, "folded": self.folded, "angles summed": self.merged}
        return ", ".join([self.way, *(name for name, chosen in options.items() if chosen)])

    def count(self, model: str) -> OperationCount:
        """Return the operation count of a call of a model."""
        return self.traced[model].program.count


def asked_models(scene: Scene) -> tuple[str, ...]:
    """Models that a scene asks for."""
    return scene.models or DEFAULT_MODELS


def refuse_stateless(machine: Machine, scene: Scene) -> None:
    """Raise `InputError` for a model whose arguments are not a state of a machine."""
    for name in asked_models(scene):
        arguments = MODELS[name].arguments
        if not arguments or not depends_on_state(arguments):
            what = f"it is not a function of a state: trade needs a model of {', '.join(ARGUMENTS)}, as direct_dynamics"
            raise machine.error(name, what)


def formulations(machine: Machine, scene: Scene, values: Values) -> tuple[list[Formulation], list[str]]:
    """All formulations of the requested models of a machine, the plainest first; notes on omitted ones.

    Raises `InputError` for a machine or scene that cannot be generated, or is too large to be compiled.
    """
    refuse_degenerate(machine, scene)
    bound, scene = scene.merge_angles, replace(scene, merge_angles=None)
    plain = _formulation(machine, scene, values)
    _refuse_large(machine, plain)
    forms, last = [plain], (machine, scene, values)
    notes: list[str] = []
    for other, its_scene, its_values in _variants(machine, scene, values, bound, notes):
        try:
            form = _formulation(other, its_scene, its_values)
        except InputError as error:
            notes.append(str(error))
            continue
        if not any(_counts(form) == _counts(other_form) and form.folded == other_form.folded for other_form in forms):
            forms.append(form)
            last = other, its_scene, its_values
    by_matrix = [_by_matrix(*other_form) for other_form in ((machine, scene, values), last)]
    return [*forms, *(other_form for some in by_matrix[: len(forms)] for other_form in some)], notes


def _variants(
    machine: Machine, scene: Scene, values: Values, bound: float | None, notes: list[str]
) -> Iterator[tuple[Machine, Scene, Values]]:
    scenes = [scene]
    if len(names_to_fold(machine, replace(scene, fold=ALL))) > len(names_to_fold(machine, scene)):
        scenes.append(replace(scene, fold=ALL))
    scenes += [replace(x, merge_angles=bound) for x in scenes] if bound else []
    yield from ((machine, other, values) for other in scenes[1:])
    ungrouped = machine.is_grouped or machine.degrees_of_base or machine.flexible
    grouped = None if ungrouped else _with_base_parameters(machine, values, notes)
    if grouped:
        yield from ((grouped[0], other, grouped[1]) for other in scenes)


def _with_base_parameters(machine: Machine, values: Values, notes: list[str]) -> tuple[Machine, Values] | None:
    """The machine with base parameters and their values."""
    grouping, check = checked_grouping(machine)
    if not check.agrees:
        notes.append(f"base parameters: {check.message}")
    if check.refused:
        return None
    values_of_base = {**values, **grouping.values(values)}
    if not grouping.machine.parameter_names <= values_of_base.keys():
        return None
    return grouping.machine, values_of_base


def _formulation(machine: Machine, scene: Scene, values: Values, ways: Mapping[str, str] | None = None) -> Formulation:
    """Trace the models of a scene without its steps; `ways` names models that replace requested ones."""
    models = asked_models(scene)
    written = tuple((ways or {}).get(name, name) for name in models)
    outputs = {other: scene.outputs[name] for name, other in zip(models, written, strict=True) if name in scene.outputs}
    programs = trace_models(machine, replace(scene, models=written, outputs=outputs, steps=()), grouping_by_rank)
    by_name = {x.model.name: x for x in programs.models}
    return Formulation(
        BY_MATRIX if ways else RECURSION,
        machine.is_grouped,
        scene.fold == ALL,
        any(model.merged for model in programs.models),
        programs.package,
        {name: by_name[other] for name, other in zip(models, written, strict=True)},
        values,
        scene.merge_angles,
    )


def _by_matrix(machine: Machine, scene: Scene, values: Values) -> list[Formulation]:
    """The formulations of the requested models by the inertia matrix, if there are any."""
    requested = asked_models(scene)
    ways = {model.other_way_of: name for name, model in MODELS.items() if model.other_way_of in requested}
    outputs = {name: joints for name, joints in scene.outputs.items() if name in ways}
    return [_formulation(machine, replace(scene, models=tuple(ways), outputs=outputs), values, ways)] if ways else []


def _counts(form: Formulation) -> list[OperationCount]:
    return [traced.program.count for traced in form.traced.values()]


def _refuse_large(machine: Machine, form: Formulation) -> None:
    operations = sum(count.products + count.add for count in _counts(form))
    if operations > MOST_OPERATIONS:
        what = f"{operations} operations are more than the {MOST_OPERATIONS} that trade compiles many times over"
        raise machine.error("trade", f"{what}: ask for one --model, or for parts (--scene)")
