"""Names in a scene, looked up in the machine."""

from __future__ import annotations

from collections.abc import Iterable

from symoro_elastic.errors import InputError
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.names import MODELS, SEEN_FROM_FRAMES, WHOLE, did_you_mean, quoted
from symoro_elastic.machine.scene import BASE, SEEN_FROM, Scene


def resolve(scene: Scene, machine: Machine, models: Iterable[str] = MODELS, source: str = "") -> Scene:
    """The scene with joints called by their names; raises `InputError` for what the machine has not.

    A joint may be called by its name, its variable or its number in the table.
    """
    source = source or machine.source or machine.name
    joints = _joints_by_any_name(machine)
    for model in (*scene.models, *scene.outputs):
        _known(model, models, "model", source, "models" if model in scene.models else "outputs")
    for name in () if isinstance(scene.fold, str) else scene.fold:
        _known(name, [parameter.name for parameter in machine.parameters], "parameter", source, "fold")
    outputs = {
        model: tuple(_output(name, model, joints, source) for name in names) for model, names in scene.outputs.items()
    }
    locked = {joints[_known(name, joints, "joint", source, "locked")]: value for name, value in scene.locked.items()}
    if len(locked) < len(scene.locked):
        raise InputError(source, "scene, locked", "a joint is locked twice, by two of its names")
    _check_locked(locked, machine, source)
    return Scene(scene.models, outputs, locked, scene.fold, scene.gravity)


def _output(name: str, model: str, joints: dict[str, str], source: str) -> str:
    """A joint, or a frame as in "tool in bed_x", by the names that the machine has."""
    first, *seen_from = name.split(SEEN_FROM)
    if seen_from and model not in SEEN_FROM_FRAMES:
        what = f"{quoted(name)}: only {', '.join(SEEN_FROM_FRAMES)} can be asked for as seen from a frame"
        raise InputError(source, f"scene, outputs, {model}", what)
    if model in WHOLE:
        raise InputError(source, f"scene, outputs, {model}", "it has no part for a joint or frame: leave it out")
    places = {**joints, BASE: BASE}
    known = places if seen_from else joints
    found = [known[_known(first.strip(), known, "joint", source, f"outputs, {model}")]]
    found += [places[_known(place.strip(), places, "frame", source, f"outputs, {model}")] for place in seen_from]
    if len(found) > 2:
        raise InputError(source, f"scene, outputs, {model}", f"{quoted(name)}: write one frame in one other")
    return SEEN_FROM.join(found)


def _joints_by_any_name(machine: Machine) -> dict[str, str]:
    """Names of joints; a joint's own name comes before the variable of another."""
    numbers = {str(j): joint.name for j, joint in enumerate(machine.joints, start=1)}
    variables = {joint.variable: joint.name for joint in machine.joints if joint.variable}
    return {**numbers, **variables, **{joint.name: joint.name for joint in machine.joints}}


def _known(name: str, known: Iterable[str], what: str, source: str, key: str) -> str:
    known = tuple(known)
    if name not in known:
        words = [word for word in known if not word.isdecimal()]
        raise InputError(source, f"scene, {key}", f"no {what} {quoted(name)}{did_you_mean(name, words)}")
    return name


def _check_locked(locked: dict[str, Formula], machine: Machine, source: str) -> None:
    fixed = {joint.name for joint in machine.joints if joint.sigma == 2}
    parameters = {parameter.name for parameter in machine.parameters}
    for joint, value in locked.items():
        if joint in fixed:
            raise InputError(source, f"scene, locked, {joint}", "a fixed frame has no variable to lock")
        for name in sorted(value.names - parameters):
            what = f"{quoted(name)} is no parameter of the machine{did_you_mean(name, parameters)}"
            raise InputError(source, f"scene, locked, {joint}", what)
