"""Resolution of the names in a scene."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from typing import TypeVar

from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.arguments import column_names
from symoro_elastic.machine.formula import Formula, FormulaError
from symoro_elastic.machine.frames import FrameNames
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.names import did_you_mean, quote
from symoro_elastic.machine.restrict import refuse_locking
from symoro_elastic.machine.scene import Offer, Parts, RequestedPart, Scene
from symoro_elastic.machine.static_springs import Positions, without_spring
from symoro_elastic.machine.zeroed import refuse_unknown
from symoro_elastic.quantities.time_steps import TimeStep

Position = TypeVar("Position", bound=Formula | None)
Models = Mapping[str, Offer]
"""The models that there are, by name."""


def resolve(scene: Scene, machine: Machine, models: Models | None = None, source: str = "") -> Scene:
    """The scene with joints by their names; raises `InputError` for unknown names.

    A joint may be called by its name, its variable or its number in the table. Without `models`, names of models and
    what is asked of them are left as they are.
    """
    source = source or scene.source or machine.label
    joints = joints_by_any_name(machine)
    if models is not None:
        for model in (*scene.models, *scene.outputs):
            _known(model, models, "model", source, "models" if model in scene.models else "outputs")
    for name in () if isinstance(scene.fold, str) else scene.fold:
        _known(name, [parameter.name for parameter in machine.parameters], "parameter", source, "fold")
    outputs = {
        model: tuple(_output(text, model, machine, source) for text in texts) for model, texts in scene.outputs.items()
    }
    if models is not None:
        _check_offered(scene.outputs, machine, models, source)
    locked = _by_name(scene.locked, joints, source, "locked")
    static = _by_name(scene.static, joints, source, "static")
    _check_locked(locked, machine, source)
    _check_static(static, locked, machine, source)
    refuse_unknown(machine, scene.zero, source)
    forces = _frames(scene.forces, machine, source)
    for name in scene.steps:
        _known(name, list(TimeStep), "time step", source, "steps")
        if scene.steps.count(name) > 1:
            raise InputError(source, "scene, steps", f"{name} is named twice: keep one")
    return replace(scene, outputs=outputs, locked=locked, static=static, forces=forces, source=source)


def _frames(texts: Iterable[str], machine: Machine, source: str) -> tuple[str, ...]:
    """Frames, and points of them, on which wrenches act, with names of the machine."""
    found = [_frame(text, machine, source) for text in texts]
    for text in found:
        if found.count(text) > 1:
            raise InputError(source, "scene, forces", f"{text} is named twice: its wrench is the sum, keep one")
    return tuple(found)


def _frame(text: str, machine: Machine, source: str) -> str:
    try:
        asked = RequestedPart.parse(text)
    except FormulaError as error:
        raise InputError(source, "scene, forces", f"{quote(text)}: {error}") from None
    if asked.seen_from or asked.by or asked.component:
        what = f"{quote(text)}: wrenches are in axes of frame 0: name a frame, or a point as 'tool at (0.1, 0, 0)'"
        raise InputError(source, "scene, forces", what)
    name = machine.joint(_number(asked.name, machine, "frame", source, "forces")).name
    for loop in machine.loops:
        if name == machine.joint(loop.cut).name:
            what = f"{name} is the cut joint of loop {loop.name}: name the frame that it meets, "
            raise InputError(source, "scene, forces", what + machine.joint(loop.meets).name)
    for coordinate in asked.at or ():
        _check_value(coordinate, machine, source, "forces")
    return str(RequestedPart(name, asked.at))


def _by_name(
    positions: Mapping[str, Position], joints: Mapping[str, str], source: str, key: str
) -> dict[str, Position]:
    """Positions by the names of joints, which may be called by their variables or numbers."""
    found = {joints[_known(name, joints, "joint", source, key)]: value for name, value in positions.items()}
    if len(found) < len(positions) and any(positions.values()):
        raise InputError(source, f"scene, {key}", f"a joint is {key} twice, by two of its names")
    return found


def _output(text: str, model: str, machine: Machine, source: str) -> str:
    """A requested joint or frame in the form that `RequestedPart.parse` reads, with names of the machine."""
    asked, key = _asked(text, model, source), f"outputs, {model}"
    if asked.by and not asked.name:
        return str(asked)
    beside_frame_0 = asked.seen_from is not None
    number = _number(asked.name, machine, "joint", source, key, beside_frame_0)
    for coordinate in asked.at or ():
        _check_value(coordinate, machine, source, key)
    if asked.seen_from is None:
        return str(RequestedPart(machine.joint(number).name, asked.at, by=asked.by, component=asked.component))
    names, place = FrameNames(machine), _number(asked.seen_from, machine, "frame", source, key, or_frame_0=True)
    return str(RequestedPart(names.name(number), asked.at, names.name(place), component=asked.component))


def _number(text: str, machine: Machine, what: str, source: str, key: str, or_frame_0: bool = False) -> int:
    """The number of a frame or joint by any of its names."""
    names = FrameNames(machine, by_any_name=True)
    number = names.number(text, or_frame_0)
    if number is None:
        raise _unknown(text, names.choices(or_frame_0), what, source, key)
    return number


def _check_offered(outputs: Mapping[str, Iterable[str]], machine: Machine, models: Models, source: str) -> None:
    """Refuse parts and columns that a model does not have."""
    seen = [name for name, offer in models.items() if offer.parts in (Parts.FRAMES, Parts.POINTS, Parts.COMPONENTS)]
    at_points = [name for name, offer in models.items() if offer.parts in (Parts.POINTS, Parts.COMPONENTS)]
    by_component = [name for name, offer in models.items() if offer.parts is Parts.COMPONENTS]
    differentiated = [name for name, offer in models.items() if offer.columns]
    for model, texts in outputs.items():
        for text in texts:
            asked = _asked(text, model, source)
            if models[model].parts is not Parts.JOINTS:
                _check_not_cut(asked, model, machine, source)
            for is_asked, offering, how in (
                (asked.seen_from is not None, seen, "as seen from a frame"),
                (asked.at is not None, at_points, "at a point"),
                (bool(asked.by), differentiated, "by names of columns"),
                (bool(asked.component), by_component, "by components of twists"),
            ):
                if is_asked and model not in offering:
                    what = f"{quote(text)}: only {', '.join(offering)} can be requested {how}"
                    raise InputError(source, f"scene, outputs, {model}", what)
            if models[model].parts is Parts.WHOLE:
                what = "it has no parts for joints or frames: leave it out"
                raise InputError(source, f"scene, outputs, {model}", what)
            for name in asked.by:
                _check_column(name, model, machine, models, source)


def _check_not_cut(asked: RequestedPart, model: str, machine: Machine, source: str) -> None:
    """Refuse the frame of a cut joint, which is that of the row that it meets."""
    names, or_frame_0 = FrameNames(machine, by_any_name=True), asked.seen_from is not None
    named = {names.number(text, or_frame_0) for text in (asked.name, asked.seen_from) if text}
    for loop in machine.loops:
        if loop.cut in named:
            cut, meets = machine.joint(loop.cut).name, machine.joint(loop.meets).name
            what = f"{cut} is the cut joint of loop {loop.name}: ask for the frame that it meets, {meets}"
            raise InputError(source, f"scene, outputs, {model}", what)


def _check_column(name: str, model: str, machine: Machine, models: Models, source: str) -> None:
    """Refuse a column that a model of derivatives does not have."""
    known = {other: column_names(machine, offer.columns) for other, offer in models.items()}
    if name in known[model]:
        return
    elsewhere = [other for other, names in known.items() if name in names]
    way_out = f": it is a column of {', '.join(elsewhere)}" if elsewhere else did_you_mean(name, known[model])
    raise InputError(source, f"scene, outputs, {model}", f"no column {quote(name)}{way_out}")


def _asked(text: str, model: str, source: str) -> RequestedPart:
    try:
        return RequestedPart.parse(text)
    except FormulaError as error:
        raise InputError(source, f"scene, outputs, {model}", f"{quote(text)}: {error}") from None


def coordinates(scene: Scene, source: str) -> Iterator[Formula]:
    """The formulas of all points that a scene asks for; raises `InputError` for one that cannot be read."""
    for model, texts in scene.outputs.items():
        for text in texts:
            yield from _asked(text, model, source).at or ()


def joints_by_any_name(machine: Machine) -> dict[str, str]:
    """Names of joints; a joint's own name comes before the variable of another."""
    names = FrameNames(machine, by_any_name=True)
    return {text: machine.joint(j).name for text, j in names.joints.items()}


def _known(name: str, known: Iterable[str], what: str, source: str, key: str) -> str:
    known = tuple(known)
    if name not in known:
        raise _unknown(name, [word for word in known if not word.isdecimal()], what, source, key)
    return name


def _unknown(name: str, choices: Iterable[str], what: str, source: str, key: str) -> InputError:
    return InputError(source, f"scene, {key}", f"no {what} {quote(name)}{did_you_mean(name, choices)}")


def _check_locked(locked: dict[str, Formula], machine: Machine, source: str) -> None:
    refuse_locking(machine, locked, source)
    for joint, value in locked.items():
        _check_value(value, machine, source, f"locked, {joint}")


def _check_static(static: Positions, locked: Mapping[str, Formula], machine: Machine, source: str) -> None:
    """Refuse static joints without a spring, and those that are locked."""
    rows = {joint.name: joint for joint in machine.joints}
    for name, value in static.items():
        reason = without_spring(machine, rows[name])
        if reason or name in locked:
            raise InputError(source, f"scene, static, {name}", reason or "it is locked too: remove one of the two")
        if value is not None:
            _check_value(value, machine, source, f"static, {name}")


def _check_value(value: Formula, machine: Machine, source: str, key: str) -> None:
    parameters = {parameter.name for parameter in machine.parameters}
    for name in sorted(value.names - parameters):
        what = f"{quote(name)} is not a parameter of the machine{did_you_mean(name, parameters)}"
        raise InputError(source, f"scene, {key}", what)
    if not value.names:
        try:
            value.table_value()
        except FormulaError as error:
            raise InputError(source, f"scene, {key}", str(error)) from None
