"""The models that a scene asks of a machine, as programs: restricted, traced, pruned, scheduled, packaged."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

from symoro_elastic.codegen.package import Package
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.restrict import folded, restricted
from symoro_elastic.machine.scene import INERTIA, Scene
from symoro_elastic.machine.series_springs import condensed
from symoro_elastic.models.catalogue import BY_INERTIA, trace_scene
from symoro_elastic.models.model import TracedModel
from symoro_elastic.models.time_steps import models_of_steps
from symoro_elastic.packaging import package


@dataclass(frozen=True, eq=False)
class Traced:
    """The models that a scene asks of a machine `whole`, as programs."""

    whole: Machine
    scene: Scene
    models: Sequence[TracedModel]

    @cached_property
    def machine(self) -> Machine:
        """The machine restricted to the scene."""
        return restricted(self.whole, self.scene)

    @cached_property
    def folded(self) -> tuple[str, ...]:
        """Names of the parameters that are constants in the programs."""
        return folded(self.whole, self.scene)

    @cached_property
    def package(self) -> Package:
        """The package for the targets; raises `InputError` for reserved names."""
        notes = condensed(self.whole).notes if self.scene.condense else ()
        scene = ", ".join(filter(None, (summary(self.scene, self.models), *notes)))
        return package(self.machine, self.models, self.folded, scene, self.scene.steps)


def traced(machine: Machine, scene: Scene) -> Traced:
    """The programs of the models that a scene asks of a machine; raises `InputError`."""
    return with_steps(machine, scene, trace_scene(machine, scene))


def with_steps(machine: Machine, scene: Scene, models: Sequence[TracedModel]) -> Traced:
    """The programs of these models, and of those that the time steps of the scene call."""
    whole = [one for one in models if one.whole]
    called = models_of_steps(restricted(machine, scene), scene.steps, folded(machine, scene), whole)
    return Traced(machine, scene, [*models, *called])


def summary(scene: Scene, models: Sequence[TracedModel] = ()) -> str:
    """Summary of a scene and its models; empty for the whole machine."""
    parts = [f"{name} held at {value}" for name, value in scene.locked.items()]
    parts += [f"{name} static, held {_position(value)}" for name, value in scene.static.items()]
    parts += ["without gravity"] if not scene.gravity else []
    if scene.form == INERTIA:
        formed = [one.model.name for one in models if one.model.name in BY_INERTIA]
        parts += [f"{name} through the inertia matrix" for name in formed]
    if any(model.merged for model in models):
        parts.append(f"angles are summed: valid for |q| <= {scene.merge_angles:g} rad")
    return ", ".join(parts)


def _position(value: Formula | None) -> str:
    return "where its spring is neutral" if value is None else f"at {value}"
