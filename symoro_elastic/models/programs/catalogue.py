"""The models that can be requested, and their traces."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import cast

from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.arguments import column_names
from symoro_elastic.machine.frames import FrameNames, Points, points_of
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.resolve import resolve
from symoro_elastic.machine.restrict import names_to_fold, restrict
from symoro_elastic.machine.scene import INERTIA, RECURSION, Parts, RequestedPart, Scene
from symoro_elastic.models.bound.bind import EXTERNAL_WRENCHES, Bound
from symoro_elastic.models.bound.model import Frame, Frames, Joints, Model, Results, TracedModel
from symoro_elastic.models.bound.tracing import Trace, prune, schedule
from symoro_elastic.models.derivatives.derivatives import DERIVATIVES
from symoro_elastic.models.drives.control import CONTROL, CONTROLLERS
from symoro_elastic.models.drives.control import START as CONTROL_START
from symoro_elastic.models.dynamics.closed_chains import CLOSED_CHAINS, of_closed_chain
from symoro_elastic.models.dynamics.dynamic import DYNAMIC
from symoro_elastic.models.dynamics.feed_forward import FEED_FORWARD
from symoro_elastic.models.dynamics.floating_base import on_its_base
from symoro_elastic.models.dynamics.identification import IDENTIFICATION
from symoro_elastic.models.kinematics.geometric import DEFLECTIONS, GEOMETRIC, STATIC_SPRINGS
from symoro_elastic.models.kinematics.inverse_geometric import INVERSE_GEOMETRIC
from symoro_elastic.models.kinematics.inverse_kinematic import INVERSE_KINEMATIC
from symoro_elastic.models.parameters.base_parameters import GroupingOf, grouping_of_tree
from symoro_elastic.symbolic.expression import reachable
from symoro_elastic.symbolic.memory import no_collection
from symoro_elastic.symbolic.operations import SYMBOL
from symoro_elastic.symbolic.program import Input, Pruned

__all__ = ["DEFAULT_MODELS", "MODELS", "Model", "TracedModel", "trace", "trace_scene"]

FAMILIES = {
    "dynamics": DYNAMIC,
    "derivatives": DERIVATIVES,
    "feed-forward": FEED_FORWARD,
    "geometry and kinematics": GEOMETRIC,
    "inverse geometry": INVERSE_GEOMETRIC,
    "inverse kinematics": INVERSE_KINEMATIC,
    "identification": IDENTIFICATION,
    "closed chains": CLOSED_CHAINS,
    "static springs": STATIC_SPRINGS,
    "controllers": CONTROLLERS,
}
MODELS: dict[str, Model] = {
    model.name: replace(model, family=family) for family, models in FAMILIES.items() for model in models
}
DEFAULT_MODELS = ("direct_dynamics", "inverse_dynamics")
KINEMATIC_MODELS = ("geometric_model", "jacobian")
"""Default models of machines without mass."""
NO_ENTRIES: Mapping[str, tuple[str, ...]] = MappingProxyType({})
BY_INERTIA = {model.other_way_of: model for model in MODELS.values() if model.other_way_of}
"""Models that use the inertia matrix, by the name of the model with a recursion."""


@no_collection()
def trace(
    machine: Machine,
    name: str,
    requested: Joints | Frames = (),
    folded: Sequence[str] = (),
    merge_angles: bool = False,
    grouping_of: GroupingOf = grouping_of_tree,
) -> TracedModel:
    """The program of a model: its equations run on symbols by `expressions`, pruned and scheduled."""
    binding = Binding(folded, merge_angles=merge_angles, grouping_of=grouping_of)
    return schedule(prune(expressions(machine, name, requested, binding)))


@no_collection()
def needs_of(machine: Machine, name: str) -> Pruned:
    """The nodes that the results of a model need, unscheduled, for numeric evaluation."""
    return prune(expressions(machine, name)).needed


@dataclass(frozen=True)
class Binding:
    """How a model is bound to the symbols of a machine.

    `folded` are names of parameters that become constants. `points` are numbered before the requested ones;
    `merge_angles` allows sums of angles; `by` names columns of derivatives. `form` is that of the direct dynamic model,
    `grouping_of` finds base inertial parameters.
    """

    folded: Sequence[str] = ()
    points: Points = ()
    merge_angles: bool = False
    by: Sequence[str] = ()
    form: str = RECURSION
    grouping_of: GroupingOf = grouping_of_tree


def expressions(machine: Machine, name: str, requested: Joints | Frames = (), binding: Binding | None = None) -> Trace:
    """The results of a model as expressions: its equations run on the symbols of a machine.

    `requested` are joint numbers, or frames (all when empty). Raises `SingularPivot` where a joint has no inertia,
    `InputError` for a model not offered on a floating base.
    """
    _refuse_on_floating_base(machine, name)
    if MODELS[name] in FEED_FORWARD:
        machine.refuse_states_of_friction(name)
    binding = binding or Binding()
    model = on_its_base(in_form(name, binding.form), machine)
    machine = model.binds(machine) if model.binds else machine
    is_complete, requested = not requested, requested or _everything(machine, model)
    own = () if model.parts is Parts.BODIES else points_among(machine, requested)
    grouping = binding.grouping_of(machine) if model.is_grouped else None
    if grouping and (constants := [name for name in grouping.geometry if name not in binding.folded]):
        model = replace(model, title=f"{model.title}, for the values of {', '.join(constants)} in the table")
    points = tuple(dict.fromkeys((*binding.points, *own))) if own else ()
    bound = Bound(machine, binding.folded, points, binding.by, grouping=grouping)
    return trace_of(model, bound, model.run(bound, requested), is_complete=is_complete, merges=binding.merge_angles)


def trace_of(
    model: Model,
    bound: Bound,
    results: Results,
    *,
    is_complete: bool = True,
    merges: bool = False,
    own_entries: Mapping[str, tuple[str, ...]] = NO_ENTRIES,
) -> Trace:
    """The results of a model of a bound machine as a trace, with the arguments that the machine adds.

    `own_entries` are names of entries that replace those of the machine.
    """
    machine, entries = bound.machine, bound.arguments() | dict(own_entries)
    if model.own_arguments:
        entries = model.own_arguments(bound, results)
        model = replace(model, arguments=tuple(entries))
    if model.own_rows:
        model = replace(model, own=(*model.own, *model.own_rows(bound, results)))
    if machine.is_coupled:
        model = of_closed_chain(model, bound, results)
    if "qd" in model.arguments and "q" not in model.arguments:
        model = with_dampers(model, bound, results)
    if machine.forces:
        model = under_wrenches(model, bound, results)
    if machine.bristles or machine.loaded:
        model = with_friction_states(model, bound, results)
    inputs = tuple(Input(argument, entries[argument]) for argument in model.arguments)
    return Trace(model, inputs, results, bound.graph, bound.names, is_complete, bound.points, merges)


def with_dampers(model: Model, bound: Bound, results: Results) -> Model:
    """The model with q and V0 among its arguments, where dampers of ball joints and of a base need them."""
    before, after = ([x for x in (x,) if x in bound.arguments() and _holds(x, bound, results)] for x in ("q", "V0"))
    return replace(model, arguments=(*before, *model.arguments, *after))


def under_wrenches(model: Model, bound: Bound, results: Results) -> Model:
    """The model with external wrenches as its last argument, where its results depend on them."""
    if not _holds(EXTERNAL_WRENCHES, bound, results):
        return model
    return replace(model, arguments=(*model.arguments, EXTERNAL_WRENCHES))


def with_friction_states(model: Model, bound: Bound, results: Results) -> Model:
    """The model with states of friction after qd, and with loads as its last argument, where its results hold them."""
    arguments = model.arguments
    if "z" not in arguments and _holds("z", bound, results):
        after = arguments.index("qd") + 1
        arguments = (*arguments[:after], "z", *arguments[after:])
    if _holds("load", bound, results):
        arguments = (*arguments, "load")
    return replace(model, arguments=arguments, results=tuple(results))


def _holds(argument: str, bound: Bound, results: Results) -> bool:
    """Whether results depend on an argument."""
    names = {*bound.arguments()[argument]}
    used = reachable(x for result in results.values() for x in result.entries)
    return any(node.operation == SYMBOL and node.operands[0] in names for node in used)


def in_form(name: str, form: str) -> Model:
    """The model of this name, through the inertia matrix if that form exists and is requested."""
    if form != INERTIA or name not in BY_INERTIA:
        return MODELS[name]
    return replace(BY_INERTIA[name], name=name, title=f"{MODELS[name].title} through the inertia matrix")


def _refuse_on_floating_base(machine: Machine, name: str) -> None:
    if not machine.degrees_of_base:
        return
    if MODELS[name].on_base is None:
        offered = [model.name for model in MODELS.values() if model.on_base is not None]
        what = f"not offered on a floating base, which has: {', '.join(offered)}"
        raise machine.error(name, what)
    if machine.loops:
        loops = ", ".join(loop.name for loop in machine.loops)
        raise machine.error(name, f"not offered on a floating base with loops: {loops}; couplings are")


def points_among(machine: Machine, requested: Joints | Frames) -> Points:
    """Frames without a row among the requested frames and their observers."""
    frames = [frame for frame in requested if isinstance(frame, Frame)]
    places = [(frame.number, frame.at) for frame in frames]
    return points_of(machine, [*places, *((frame.seen_from or 0, None) for frame in frames)])


def _everything(machine: Machine, model: Model) -> Joints | Frames:
    """Default parts of a model: joints that move, all frames, frames of bodies, or the last frame."""
    names = FrameNames(machine)
    of_rows = [names.of_row(j) for j in range(1, len(machine.joints) + 1)]
    match model.parts:
        case Parts.POINTS:
            return tuple(map(Frame, names.all()))
        case Parts.BODIES:
            return tuple(map(Frame, of_rows))
        case Parts.FRAMES | Parts.COMPONENTS:
            return (Frame(of_rows[-1] if of_rows else 0),)
    return machine.independent


@no_collection()
def trace_scene(machine: Machine, scene: Scene, grouping_of: GroupingOf = grouping_of_tree) -> list[TracedModel]:
    """The programs of all models of a scene: `expressions_of_scene`, pruned and scheduled."""
    return [schedule(prune(traced)) for traced in expressions_of_scene(machine, scene, grouping_of)]


@no_collection()
def expressions_of_scene(
    machine: Machine, scene: Scene, grouping_of: GroupingOf = grouping_of_tree, without: Collection[str] = ()
) -> list[Trace]:
    """The results of all models of a scene as expressions; of the default models where it names none.

    `machine` is unrestricted; locks and gravity of the scene are applied here. `grouping_of` finds base inertial
    parameters, `without` are names of models that are left out. Raises `InputError` for what such a machine cannot
    give.
    """
    scene = resolve(scene, machine, MODELS)
    restricted = restrict(machine, scene)
    refuse_without_value(machine, scene)
    constants = names_to_fold(machine, scene)
    models = models_of(scene)
    _refuse_idle_outputs(restricted, scene, models)
    _refuse_changed_by_grouping(restricted, models)
    requested = {name: _requested_parts(restricted, scene, name) for name in models}
    points = tuple(dict.fromkeys(point for some in requested.values() for point in points_among(restricted, some)))
    merge = scene.merge_angles is not None
    by = {name: _columns(restricted, scene, name, constants) for name in models}
    return [
        expressions(restricted, name, some, Binding(constants, points, merge, by[name], scene.form, grouping_of))
        for name, some in requested.items()
        if name not in without
    ]


def models_of(scene: Scene) -> tuple[str, ...]:
    """Names of a scene's requested models, and of those that they imply: deflections, initial control states."""
    names = scene.models or DEFAULT_MODELS
    more = [DEFLECTIONS] if scene.static else []
    more += [CONTROL_START] if CONTROL in names else []
    return tuple(dict.fromkeys((*names, *more)))


def _refuse_idle_outputs(restricted: Machine, scene: Scene, models: Sequence[str]) -> None:
    """Reject outputs of a model that is not requested, which would otherwise be ignored."""
    for name, outputs in scene.outputs.items():
        if outputs and name not in models:
            what = f"{name} is not requested: add it to models (or --model {name}), or leave its outputs out"
            raise InputError(_source(restricted, scene), f"scene, outputs, {name}", what)


def _refuse_changed_by_grouping(machine: Machine, models: Sequence[str]) -> None:
    """Reject models whose results change with base inertial parameters."""
    for name in models if machine.is_grouped else ():
        if not MODELS[name].keeps_grouping:
            what = f"base inertial parameters keep the torques, not the {name.replace('_', ' ')}: leave out --base"
            raise machine.error(name, what)


def _source(machine: Machine, scene: Scene) -> str:
    """The file to be named in a message about a scene."""
    return scene.source or machine.label


def _requested_parts(restricted: Machine, scene: Scene, model: str) -> Joints | Frames:
    """Joints (or frames) that a scene requests of a model; empty for all."""
    if MODELS[model].is_of_frames:
        return requested_frames(restricted, scene, model)
    names = FrameNames(restricted)
    parts = [RequestedPart.parse(text) for text in scene.outputs.get(model, ())]
    joints = tuple(names.rows[a.name] for a in parts if a.name)
    for j in joints:
        if j not in restricted.independent:
            joint = restricted.joint(j).name
            reason = "is locked" if joint in scene.locked else "is static" if joint in scene.static else ""
            state = reason or "is a fixed frame"
            what = f"joint {j} ({joint}) {state} and has no part in this model: choose joints that move"
            raise InputError(_source(restricted, scene), f"scene, outputs, {model}", what)
    return joints


def requested_frames(machine: Machine, scene: Scene, model: str) -> Frames:
    """Frames that a scene with resolved names requests of a model."""
    names, frames = FrameNames(machine), []
    for part in map(RequestedPart.parse, scene.outputs.get(model, ())):
        number = names.number(part.name, or_frame_0=part.seen_from is not None)
        place = None if part.seen_from is None else names.number(part.seen_from, or_frame_0=True)
        frames.append(Frame(cast(int, number), place, part.at, part.component))
    return tuple(frames)


def _columns(restricted: Machine, scene: Scene, model: str, constants: Sequence[str]) -> tuple[str, ...]:
    """Names by which a scene requests derivatives; empty for all."""
    names = tuple(dict.fromkeys(x for text in scene.outputs.get(model, ()) for x in RequestedPart.parse(text).by))
    for name in names:
        if name in constants or name not in column_names(restricted, MODELS[model].columns):
            why = "becomes a constant: do not fold it" if name in constants else "belongs to a locked joint"
            raise InputError(_source(restricted, scene), f"scene, outputs, {model}", f"no column {name!r}: it {why}")
    return names


def refuse_without_value(machine: Machine, scene: Scene) -> None:
    """Raise `InputError` for a parameter without value that is to become a constant."""
    valued = {parameter.name for parameter in machine.parameters if parameter.value is not None}
    for name in names_to_fold(machine, scene):
        if name not in valued:
            what = f"{name} has no value, so it cannot become a constant: give it one or leave it out"
            raise InputError(_source(machine, scene), "scene, fold", what)
