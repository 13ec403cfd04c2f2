"""The models that can be asked for, and their traces."""

from __future__ import annotations

from collections.abc import Sequence

from symoro_elastic.errors import InputError
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.restrict import folded, restricted
from symoro_elastic.machine.scene import BASE, SEEN_FROM, Scene
from symoro_elastic.models.bind import Bound
from symoro_elastic.models.dynamic import DYNAMIC
from symoro_elastic.models.geometric import GEOMETRIC
from symoro_elastic.models.identification import IDENTIFICATION
from symoro_elastic.models.inverse_geometric import INVERSE_GEOMETRIC
from symoro_elastic.models.model import FRAMES, Frame, Frames, Joints, Model, TracedModel
from symoro_elastic.symbolic.program import Input, Output, build

__all__ = ["DEFAULT_MODELS", "MODELS", "Model", "TracedModel", "trace", "trace_scene"]

MODELS: dict[str, Model] = {model.name: model for model in (*DYNAMIC, *GEOMETRIC, *INVERSE_GEOMETRIC, *IDENTIFICATION)}
DEFAULT_MODELS = ("direct_dynamics", "inverse_dynamics")


def trace(machine: Machine, name: str, asked: Joints | Frames = (), folded: Sequence[str] = ()) -> TracedModel:
    """Run the equations of a model on the symbols of a machine, prune and schedule.

    `asked` are joint numbers, or frames (all when empty), `folded` names of parameters that become constants.
    Raises `SingularPivot` where a joint has no inertia.
    """
    model = MODELS[name]
    bound = Bound(machine, folded)
    results = model.run(bound, tuple(asked) or _everything(machine, model))
    inputs = [Input(argument, bound.arguments()[argument]) for argument in model.arguments]
    outputs = [Output(name, r.shape, r.entries) for name, r in results.items()]
    return TracedModel(model, results, build(inputs, outputs, bound.names))


def _everything(machine: Machine, model: Model) -> Joints | Frames:
    if model.rows == FRAMES:
        return tuple(Frame(j) for j in range(1, len(machine.joints) + 1))
    return machine.moving


def trace_scene(machine: Machine, scene: Scene) -> list[TracedModel]:
    """Every model that a scene asks of a machine; the default models where it names none.

    `machine` is the whole machine; locked joints and gravity are seen to here. Raises `InputError`
    for what such a machine cannot give.
    """
    kept, constants = restricted(machine, scene), _constants(machine, scene)
    if kept.is_grouped and "reaction_wrenches" in scene.models:
        what = "base inertial parameters keep the torques, not the reaction wrenches: leave out --base"
        raise InputError(kept.source or kept.name, "reaction_wrenches", what)
    return [trace(kept, name, _asked(kept, scene, name), constants) for name in scene.models or DEFAULT_MODELS]


def _asked(kept: Machine, scene: Scene, model: str) -> Joints | Frames:
    """Joints (or frames) that a scene asks of a model; none when it asks for all."""
    numbers = {BASE: 0} | {joint.name: j for j, joint in enumerate(kept.joints, start=1)}
    asked = [name.split(SEEN_FROM) for name in scene.outputs.get(model, ())]
    if MODELS[model].rows == FRAMES:
        return tuple(Frame(numbers[name], *(numbers[place] for place in seen_from)) for name, *seen_from in asked)
    joints = tuple(numbers[name] for name, *_ in asked)
    for j in joints:
        if j not in kept.moving:
            joint = kept.joints[j - 1].name
            why = "is locked" if joint in scene.locked else "is a fixed frame"
            what = f"joint {j} ({joint}) {why} and has no part in this model: ask for joints that move"
            raise InputError(kept.source or kept.name, f"scene, outputs, {model}", what)
    return joints


def _constants(machine: Machine, scene: Scene) -> tuple[str, ...]:
    """Names of the parameters that become constants; each must have a value."""
    names = folded(machine, scene)
    valued = {parameter.name for parameter in machine.parameters if parameter.value is not None}
    for name in names:
        if name not in valued:
            what = f"{name} has no value, so it cannot become a constant: give it one or leave it out"
            raise InputError(machine.source or machine.name, "scene, fold", what)
    return names
