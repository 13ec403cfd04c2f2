"""Outputs of an FMU that are not states: positions of frames, deflections, joints that follow from others."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from symoro_elastic.foundation.scalar import Scalar
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.scene import RequestedPart, Scene
from symoro_elastic.models.bind import Bound
from symoro_elastic.models.catalogue import requested_frames
from symoro_elastic.models.geometric import geometric_model
from symoro_elastic.models.model import Frame, Model, Result
from symoro_elastic.quantities import Quantity, Role
from symoro_elastic.quantities.frames import frame_names
from symoro_elastic.symbolic.expression import Expression, Level

FRAMES = "geometric_model"
"""The model whose outputs in a scene name frames."""
OUTPUTS, Y = "outputs", "y"


@dataclass(frozen=True)
class Output:
    """An output that is not a state: its owner and quantity, `tool` and `x`, its unit, what it is, its value."""

    owner: str
    quantity: str
    unit: str
    meaning: str
    value: Scalar


def asked_frames(machine: Machine, scene: Scene) -> tuple[Frame, ...]:
    """Return the frames that a scene asks of the geometric model, else those at the ends of the tree."""
    if scene.outputs.get(FRAMES):
        return requested_frames(machine, scene, FRAMES)
    cut = {loop.cut for loop in machine.loops}
    ends = {*range(1, len(machine.joints) + 1)} - {*machine.antecedents} - cut
    return tuple(map(Frame, sorted(ends)))


def outputs_of(bound: Bound, frames: tuple[Frame, ...]) -> list[Output]:
    """Return the outputs that depend on the state and are not a state themselves."""
    found = [*_dependent_joints(bound), *_deflections(bound), *_positions(bound, frames)]
    return [one for one in found if isinstance(one.value, Expression) and one.value.level is Level.STATE]


def outputs_model(outputs: Sequence[Output], bound: Bound) -> tuple[Model, dict[str, Result]]:
    """Return the model that gives outputs, and its results."""
    row = Quantity(
        name=Y, meaning="outputs that are not states", symbol="y", unit=None, shape="outputs", roles=(Role.RESULT,)
    )
    arguments = ("q", "qd") if bound.machine.is_coupled else ("q",)
    results = {Y: Result(None, tuple(one.value for one in outputs), (len(outputs),))}
    model = Model(OUTPUTS, "outputs of the FMU", "[1], [9]", arguments, (Y,), _not_in_catalogue, own=(row,))
    return model, results


def _not_in_catalogue(_: Bound, __: object) -> dict[str, Result]:
    raise NotImplementedError("bound by outputs_model")


def _dependent_joints(bound: Bound) -> Iterator[Output]:
    """Positions and velocities of joints whose variables follow from loops."""
    for j in bound.machine.dependent:
        joint = bound.machine.joint(j)
        yield Output(joint.name, "q", joint.unit, "position, which follows from a loop", bound.variables[j])
        yield Output(joint.name, "qd", f"{joint.unit}/s", "velocity, which follows from a loop", bound.rate(j))


def _deflections(bound: Bound) -> Iterator[Output]:
    """Deflections of springs that are not joint variables themselves."""
    for j in bound.machine.elastic:
        joint, (_, deflection) = bound.machine.joint(j), bound.spring(j)
        if deflection is not bound.variables[j]:
            yield Output(joint.name, "deflection", joint.unit, "deflection of its spring", deflection)


def _positions(bound: Bound, frames: tuple[Frame, ...]) -> Iterator[Output]:
    placements = geometric_model(bound, frames)["T"].entries
    names = frame_names(joint.name for joint in bound.machine.joints)
    for number, frame in enumerate(frames):
        seen = "frame 0" if frame.seen_from is None else names[frame.seen_from]
        owner = str(
            RequestedPart(names[frame.number], frame.at, None if frame.seen_from is None else names[frame.seen_from])
        )
        for k, axis in enumerate("xyz"):
            value = placements[16 * number + 4 * k + 3]
            yield Output(owner, axis, "m", f"position of its origin along {axis} of {seen}", value)
