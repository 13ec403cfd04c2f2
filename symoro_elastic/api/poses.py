"""A machine at one position, and where frames are singular: evaluate, ik, stiffness, singularities."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from symoro_elastic.api.declaration import operation, operation_on_models
from symoro_elastic.api.loaded import LoadedModel, load
from symoro_elastic.api.machines import the_machine
from symoro_elastic.api.options import Evaluating, Locating, OperatingPoint, Reaching, Yielding
from symoro_elastic.api.rows import MachineLike
from symoro_elastic.api.scenes import kept_machine
from symoro_elastic.api.vibrations import linearized_at, motion_at
from symoro_elastic.foundation.errors import InputError, among, reported_places, without_value
from symoro_elastic.machine.frames import FrameNames
from symoro_elastic.machine.machine import Kind
from symoro_elastic.machine.scene import COMPONENTS, RequestedPart

if TYPE_CHECKING:
    from symoro_elastic.analysis.poses.evaluation import Evaluation
    from symoro_elastic.analysis.poses.frame_stiffness import FrameStiffness, StiffnessMap
    from symoro_elastic.analysis.poses.inverse_geometry import Chain, InverseGeometry
    from symoro_elastic.analysis.singularities.singularities import Singularities
    from symoro_elastic.machine.described import DescribedMachine

INVERSE = "inverse_geometric_model"
TURN = np.pi
"""Range of an angle without limits, rad, to both sides."""
REACH = 1.0
"""Range of a slide without limits, m, to both sides, where the machine has no lengths."""
UNKNOWN = 0.2, 0.9
"""Bounds of random values of parameters without value, in the search for a position."""


@operation_on_models(Evaluating)
def evaluate(machine: MachineLike, options: Evaluating) -> Evaluation:
    """Return the results of models at a state given by joint: positions, velocities, accelerations, torques.

    Raises
    ------
    InputError
        For unknown joints, and for models whose arguments are no state of joints.
    """
    from symoro_elastic.analysis.poses.evaluation import evaluation

    whole = the_machine(machine, options.values)
    model = load(whole, *options.models, only=options.only or {}, scene=options.scene, form=options.form)
    _refuse_without_values(model, whole.label)
    return evaluation(model, model.package, options.at, whole.label)


def _refuse_without_values(model: LoadedModel, source: str) -> None:
    missing = [p.name for p in model.package.parameters if np.isnan(p.value)]
    if missing:
        raise InputError(source, "parameters", without_value(missing, "--value"))


@operation(Reaching)
def ik(machine: MachineLike, options: Reaching) -> InverseGeometry:
    """Return positions of the joints at which a frame has a pose, within the limits, the nearest to a position first.

    Angles of the orientation are about the fixed axes x, y, z of frame 0, in this order. Springs stay neutral. Raises
    `InputError` for unknown frames and machines whose loops have no closed form.
    """
    from symoro_elastic.analysis.poses.inverse_geometry import InverseGeometry, Pose, of_angles, solve

    whole = kept_machine(the_machine(machine, options.values), options.scene)
    frame = frame_of(whole, options.frame)
    model = load(whole, "geometric_model", "jacobian", only={"geometric_model": [frame], "jacobian": [frame]})
    _refuse_without_values(model, whole.label)
    chain = _chain(whole, model)
    among(tuple(options.at), chain.names, "--at")
    near = np.array([options.at.get(name, x) for name, x in zip(chain.names, _neutral(whole), strict=True)])
    orientation = None if options.orientation is None else of_angles(options.orientation)
    pose = Pose(np.array(options.position, dtype=float), orientation)
    closed = _closed_forms(whole, frame, pose, near)
    solutions, redundant, nearest = solve(chain, pose, near, options.starts, closed, options.seed)
    error = chain.error(nearest, pose)
    units = {axis.name: axis.unit.rpartition(", ")[2] for axis in model.package.axes}
    return InverseGeometry(
        whole.name,
        frame,
        pose,
        units,
        tuple(solutions),
        redundant,
        float(np.linalg.norm(error[:3])),
        float(np.linalg.norm(error[3:]) / chain.length),
        dict(zip(chain.names, nearest.tolist(), strict=True)),
        options.starts + len(closed),
    )


def frame_of(machine: DescribedMachine, name: str) -> str:
    """Return the name of a frame, the last fixed one by default, else the last row; raises `InputError`."""
    frames = FrameNames(machine)
    fixed = [j for j, joint in enumerate(machine.joints, 1) if joint.kind is Kind.FIXED]
    last = frames.name(frames.of_row(fixed[-1] if fixed else len(machine.joints)))
    wanted = RequestedPart.parse(name).name if name else last
    if frames.number(wanted) is None:
        among((wanted,), tuple(frames.own), "--frame")
    return name or wanted


def _neutral(machine: DescribedMachine) -> list[float]:
    values = machine.given_values
    return [x.spring.neutral.value(values) if x.kind is Kind.ELASTIC else 0.0 for x in machine.independent_joints]


def _chain(machine: DescribedMachine, model: LoadedModel) -> Chain:
    """Return the frame of a loaded model by positions of the joints; springs do not move."""
    from symoro_elastic.analysis.poses.inverse_geometry import Chain

    for function in model.package.functions:
        if [x.name for x in function.arguments if x.name != "p"] != ["q"]:
            what = "its loops have no closed form: give the positions of its motors to `evaluate` instead"
            raise machine.error("ik", what)
    joints = machine.independent_joints
    ranges = [machine.limits.of(joint.name).position for joint in joints]
    origins = model.geometric_model(np.zeros(len(joints)))
    length = float(np.linalg.norm(np.asarray(origins).reshape(-1, 4, 4)[-1][:3, 3])) or REACH
    wide = [TURN if joint.sigma == 0 else max(length, REACH) for joint in joints]
    low, high = np.array([(x.low, x.high) if x else (-np.inf, np.inf) for x in ranges]).T
    starts = np.array([(x.low, x.high) if x else (-w, w) for x, w in zip(ranges, wide, strict=True)])
    moved = tuple(k for k, joint in enumerate(joints) if joint.kind is not Kind.ELASTIC)
    return Chain(
        tuple(joint.name for joint in joints),
        lambda q: np.asarray(model.geometric_model(q)).reshape(-1, 4, 4)[-1],
        lambda q: np.asarray(model.jacobian(q)).reshape(-1, 6, len(joints))[-1],
        moved,
        low,
        high,
        starts,
        length,
        tuple(joint.sigma == 0 for joint in joints),
    )


def _closed_forms(machine: DescribedMachine, frame: str, pose: Any, near: np.ndarray) -> list[np.ndarray]:
    """Return the branches of the inverse geometric model where it has a closed form; else none."""
    if pose.orientation is None:
        return []
    try:
        model = load(machine, INVERSE, only={INVERSE: [frame]})
    except InputError:
        return []
    target = np.eye(4)
    target[:3, :3], target[:3, 3] = pose.orientation, pose.position
    branches = getattr(model, INVERSE)(target)
    positions = np.atleast_2d(branches[0] if isinstance(branches, tuple) else branches)
    return [row for row in positions if row.size == near.size and np.isfinite(row).all()]


@operation(Yielding)
def stiffness(machine: MachineLike, options: Yielding) -> FrameStiffness | StiffnessMap:
    """Return the stiffness (6, 6) of a frame with motors held, the springs that limit it, and the worst direction.

    With positions along joints: at each of them. Raises `InputError` for machines without springs, and where a joint
    moves freely.
    """
    from symoro_elastic.analysis.poses.frame_stiffness import StiffnessMap, frame_stiffness, signals_of
    from symoro_elastic.analysis.vibration.tracking import places_of

    kept = kept_machine(machine, options.scene)
    frame = frame_of(kept, options.frame)
    inputs, outputs = signals_of(frame)
    motion, points = motion_at(OperatingPoint(), kept, options.values, inputs, outputs), []
    for place in places_of(motion, options.along, options.at):
        at = {**options.at, **place}
        linear = linearized_at(OperatingPoint(hold=("all",), at=at), motion, inputs, outputs)
        points.append(frame_stiffness(linear, frame, at))
    return StiffnessMap(tuple(points)) if options.along else points[0]


@operation(Locating)
def singularities(machine: MachineLike, options: Locating) -> Singularities:
    """Return the determinant of the Jacobian of a frame, factored, and the positions where it vanishes, in words.

    As many components of the twist of the frame as joints that move them are taken: all that some joint changes, or
    those named, as in "tool.x", "tool.y" (Khalil and Dombre 2002, 5.3). Each factor is a condition on the joint
    variables; at such a position the result names the joints that are dependent there, and the lost motion.

    Raises
    ------
    InputError
        Where the Jacobian is not square, where it is singular at every position, or too long to be factored.
    """
    from symoro_elastic.analysis.singularities.singularities import (
        Samples,
        Singularities,
        Task,
        latex,
        singular_positions,
    )

    full = the_machine(machine)
    frames = FrameNames(full)
    components = [*options.components] or [frames.name(frames.of_row(len(full.joints)))]
    frame = str(replace(RequestedPart.parse(components[0]), component=""))
    symbols, numbers = {"jacobian_determinant": components}, {"inverse_jacobian": components, "jacobian": [frame]}
    with reported_places({"--only, jacobian_determinant": "--component"}):
        symbolic = load(full, *symbols, only=symbols, scene=options.scene, backend="sympy")
    model = load(full, *numbers, only=numbers, scene=options.scene)
    (inverse,) = (f.results[0] for f in model.package.functions if f.name == "inverse_jacobian")
    names = [axis.name for axis in model.package.axes]
    rows, columns = map(COMPONENTS.index, inverse.columns), map(names.index, inverse.rows)
    variables = dict(axis.unit.split(", ") for axis in model.package.axes)
    task = Task(full.label, variables, inverse.rows, tuple(f"{frame}.{x}" for x in inverse.columns), _values(model))
    samples = Samples(model.jacobian, tuple(rows), tuple(columns), task)
    determinant, positions = singular_positions(symbolic.jacobian_determinant()[0], task, samples)
    return Singularities(full.name, task.components, inverse.rows, str(determinant), latex(determinant), positions)


def _values(model: LoadedModel) -> dict[str, float]:
    """Values of the parameters, typical ones of robots for parameters without value."""
    parameters = model.package.parameters
    lengths = np.linspace(*UNKNOWN, len(parameters))
    return {p.name: x if np.isnan(p.value) else p.value for p, x in zip(parameters, lengths.tolist(), strict=True)}
