"""The models that a scene asks of a machine, as programs: restricted, traced, pruned, scheduled, packaged."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

from symoro_elastic.codegen.package import Package
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.restrict import names_to_fold, restrict
from symoro_elastic.machine.scene import INERTIA, Scene
from symoro_elastic.machine.series_springs import condense
from symoro_elastic.models.base_parameters import GroupingOf, grouping_of_tree
from symoro_elastic.models.catalogue import BY_INERTIA, trace_scene
from symoro_elastic.models.model import TracedModel
from symoro_elastic.models.packaging import package
from symoro_elastic.models.time_steps import models_of_steps


@dataclass(frozen=True, eq=False)
class Traced:
    """The models that a scene asks of a machine `whole`, as programs."""

    whole: Machine
    scene: Scene
    models: Sequence[TracedModel]

    @cached_property
    def machine(self) -> Machine:
        """The machine restricted to the scene."""
        return restrict(self.whole, self.scene)

    @cached_property
    def folded(self) -> tuple[str, ...]:
        """Names of the parameters that are constants in the programs."""
        return names_to_fold(self.whole, self.scene)

    @cached_property
    def package(self) -> Package:
        """The package for the targets; raises `InputError` for reserved names."""
        notes = condense(self.whole).notes if self.scene.condense else ()
        scene = ", ".join(filter(None, (summary(self.scene, self.models), *notes)))
        return package(self.machine, self.models, self.folded, scene, self.scene.steps)


def trace_models(machine: Machine, scene: Scene, grouping_of: GroupingOf = grouping_of_tree) -> Traced:
    """The programs of the models that a scene asks of a machine; raises `InputError`."""
    return with_steps(machine, scene, trace_scene(machine, scene, grouping_of))


def with_steps(machine: Machine, scene: Scene, models: Sequence[TracedModel]) -> Traced:
    """The programs of these models, and of those that the time steps of the scene call."""
    whole = [one for one in models if one.whole]
    called = models_of_steps(restrict(machine, scene), scene.steps, names_to_fold(machine, scene), whole)
    return Traced(machine, scene, [*models, *called])


def summary(scene: Scene, models: Sequence[TracedModel] = ()) -> str:
    """Summary of a scene and its models; empty for the whole machine."""
    parts = [f"{name} held at {value}" for name, value in scene.locked.items()]
    parts += [f"{name} static, held {_position(value)}" for name, value in scene.static.items()]
    parts += [f"without {', '.join(scene.zero)}"] if scene.zero else []
    parts += ["without gravity"] if not scene.gravity else []
    if scene.form == INERTIA:
        formed = [one.model.name for one in models if one.model.name in BY_INERTIA]
        parts += [f"{name} through the inertia matrix" for name in formed]
    if any(model.merged for model in models):
        parts.append(f"angles are summed: valid for |q| <= {scene.merge_angles:g} rad")
    return ", ".join(parts)


def _position(value: Formula | None) -> str:
    return "where its spring is neutral" if value is None else f"at {value}"
