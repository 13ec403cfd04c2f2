"""Machines of formats with arbitrary names, renamed so that generated code can use them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import count

from symoro_elastic.foundation.errors import some_of
from symoro_elastic.machine.described import DescribedMachine
from symoro_elastic.machine.joints import NamedFrame
from symoro_elastic.machine.loops import Loop
from symoro_elastic.machine.names import NONE, Reasons, free_name, quote, why_no_joint, why_no_machine, why_reserved
from symoro_elastic.quantities.frames import kind_and_name


def with_valid_names(machine: DescribedMachine, reserved: Reasons = NONE) -> DescribedMachine:
    """Return the machine with valid and distinct names; a remark lists renamed joints.

    `reserved` are names that generated code uses, with reasons.
    """
    variables = {joint.variable: j for j, joint in enumerate(machine.joints) if joint.variable}
    used: dict[str, int] = {}
    new = {j: joint.name for j, joint in enumerate(machine.joints)}
    for j, name in new.items():
        if why_no_joint(name, reserved) is None and name not in used and variables.get(name, j) == j:
            used[name] = j
    for j, name in new.items():
        if used.get(name) != j:
            new[j] = next(x for x in _candidates(name, reserved) if x not in used and x not in variables)
            used[new[j]] = j
    reason = why_no_machine(machine.name, reserved)
    title = next(_candidates(machine.name, {**reserved, machine.name: reason})) if reason else machine.name
    changed = [(machine.name, title)] * (title != machine.name)
    changed += [(joint.name, new[j]) for j, joint in enumerate(machine.joints) if new[j] != joint.name]
    joints = tuple(replace(joint, name=new[j]) for j, joint in enumerate(machine.joints))
    old = {joint.name: new[j] for j, joint in reversed([*enumerate(machine.joints)])}
    loops = tuple(_loop(loop, k, old, reserved) for k, loop in enumerate(machine.loops, start=1))
    limits = replace(machine.limits, joints={old.get(name, name): x for name, x in machine.limits.joints.items()})
    frames, of_frames = _frames(machine, old, reserved)
    changed += of_frames
    shapes = tuple(replace(shape, joint=old.get(shape.joint, shape.joint)) for shape in machine.origin.shapes)
    origin = replace(machine.origin, shapes=shapes)
    renamed = replace(machine, name=title, joints=joints, loops=loops, frames=frames, limits=limits, origin=origin)
    return renamed.with_remarks(*_remarks(changed))


def _frames(
    machine: DescribedMachine, joints: dict[str, str], reserved: Reasons
) -> tuple[tuple[NamedFrame, ...], list[tuple[str, str]]]:
    """Return the named frames with valid names, and the names that changed."""
    used, changed, frames = {*joints.values()}, [], []
    for frame in machine.frames:
        what, name = kind_and_name(frame.name)
        new = joints[name] if name == frame.on else name
        if name != frame.on and why_no_joint(name, reserved) is not None:
            new = next(candidate for candidate in _candidates(name, reserved) if candidate not in used)
            changed.append((name, new))
        used.add(new)
        frames.append(replace(frame, name=f"{what} {new}".lstrip(), on=joints.get(frame.on, "")))
    return tuple(frames), changed


def _candidates(name: str, reserved: Reasons) -> Iterator[str]:
    """Yield valid names similar to an invalid one."""
    first = free_name(name, reserved)
    yield first
    numbered = (f"{first[:55].rstrip('_')}_{k}" for k in count(2))
    yield from (candidate for candidate in numbered if why_reserved(candidate, reserved) is None)


def _remarks(changed: list[tuple[str, str]]) -> Iterator[str]:
    if changed:
        pairs = some_of([f"{quote(old)} is {new}" for old, new in changed])
        yield f"names that are invalid in generated code are changed: {pairs}"


def _loop(loop: Loop, number: int, names: dict[str, str], reserved: Reasons) -> Loop:
    """A loop with the new names of joints, and a valid name of its own."""
    name = loop.name if why_reserved(loop.name, reserved) is None else f"loop_{number}"
    return replace(loop, name=name, dependent=tuple(names.get(other, other) for other in loop.dependent))
