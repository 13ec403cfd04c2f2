"""Machines of formats with names of any kind, under names that generated code can take."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import count

from symoro_elastic.foundation.errors import some_of
from symoro_elastic.machine.described import DescribedMachine
from symoro_elastic.machine.loops import Loop
from symoro_elastic.machine.names import (
    IMPORTED,
    IN_USE,
    NONE,
    Reasons,
    free_name,
    quote,
    why_no_joint,
    why_no_machine,
    why_reserved,
)


def with_valid_names(machine: DescribedMachine, taken: Reasons = NONE) -> DescribedMachine:
    """The machine with valid names, each once: those of joints that are not are changed, which a remark says.

    `taken` are names that generated code uses, with reasons.
    """
    variables = {joint.variable: j for j, joint in enumerate(machine.joints) if joint.variable}
    used: dict[str, int] = {}
    new = {j: joint.name for j, joint in enumerate(machine.joints)}
    for j, name in new.items():
        if why_no_joint(name, taken) is None and name not in used and variables.get(name, j) == j:
            used[name] = j
    for j, name in new.items():
        if used.get(name) != j:
            new[j] = next(one for one in _candidates(name, taken) if one not in used and one not in variables)
            used[new[j]] = j
    own = {**taken, **dict.fromkeys(IMPORTED, IN_USE)}
    title = machine.name if why_no_machine(machine.name, taken) is None else next(_candidates(machine.name, own))
    changed = [(machine.name, title)] * (title != machine.name)
    changed += [(joint.name, new[j]) for j, joint in enumerate(machine.joints) if new[j] != joint.name]
    joints = tuple(replace(joint, name=new[j]) for j, joint in enumerate(machine.joints))
    old = {joint.name: new[j] for j, joint in enumerate(machine.joints)}
    loops = tuple(_loop(loop, k, old, taken) for k, loop in enumerate(machine.loops, start=1))
    limits = replace(machine.limits, joints={old.get(name, name): x for name, x in machine.limits.joints.items()})
    shapes = tuple(replace(shape, joint=old.get(shape.joint, shape.joint)) for shape in machine.origin.shapes)
    origin = replace(machine.origin, shapes=shapes)
    renamed = replace(machine, name=title, joints=joints, loops=loops, limits=limits, origin=origin)
    return renamed.with_remarks(*_remarks(changed))


def _candidates(name: str, taken: Reasons) -> Iterator[str]:
    """Valid names like this one."""
    first = free_name(name, taken)
    yield first
    numbered = (f"{first[:55].rstrip('_')}_{k}" for k in count(2))
    yield from (one for one in numbered if why_reserved(one, taken) is None)


def _remarks(changed: list[tuple[str, str]]) -> Iterator[str]:
    if changed:
        pairs = some_of([f"{quote(old)} is {new}" for old, new in changed])
        yield f"names that generated code cannot take are changed: {pairs}"


def _loop(loop: Loop, number: int, names: dict[str, str], taken: Reasons) -> Loop:
    """A loop with the new names of joints, and a valid name of its own."""
    name = loop.name if why_reserved(loop.name, taken) is None else f"loop_{number}"
    return replace(loop, name=name, dependent=tuple(names.get(other, other) for other in loop.dependent))
