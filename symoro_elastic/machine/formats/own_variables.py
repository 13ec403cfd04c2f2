"""Variables that rows own, where their cells may hold the variables of other rows too, in any order of rows."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import replace

from symoro_elastic.errors import InputError
from symoro_elastic.machine.formats.cells import OTHER, SELECTED, not_alone, offset_of
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import Joint, Kind
from symoro_elastic.machine.names import quoted

Fail = Callable[[int, str, str], InputError]
"""The error to raise about a joint, by its number, and one of its keys."""


def with_own_variables(
    joints: Sequence[Joint], given: Mapping[int, str], parameters: Collection[str], fail: Fail
) -> tuple[Joint, ...]:
    """The joints with their own variables taken out of the cells that sigma selects.

    `given` are the variables that rows name as their own. Of several names in a cell that are no `parameters`, the own
    one is that which no other row owns. Raises what `fail` gives where that leaves none, or a doubt.
    """
    owning = [j for j, joint in enumerate(joints, start=1) if joint.sigma in SELECTED and joint.kind != Kind.COUPLED]
    for j, variable in given.items():
        if refusal := _not_own(joints[j - 1], variable, j in owning):
            raise fail(j, "variable", refusal)
    new = {j: new_names(joints[j - 1].selected, parameters) for j in owning}
    owned = _owned(joints, new, given)
    split = list(joints)
    for j in owning:
        joint = joints[j - 1]
        if j not in owned:
            raise fail(j, SELECTED[joint.sigma], _no_own(joint, new[j], set(owned.values()), parameters))
        offset = offset_of(joint.selected, owned[j])
        if offset is None:
            raise fail(j, SELECTED[joint.sigma], not_alone(joint.selected, owned[j]))
        split[j - 1] = replace(joint.with_selected(offset), variable=owned[j])
    return tuple(split)


def new_names(cell: Formula, parameters: Collection[str]) -> list[str]:
    """Names in a cell that are no parameters, in the order in which they first occur."""
    found = cell.names.difference(parameters)
    return [word for word in dict.fromkeys(re.findall(r"[A-Za-z_]\w*", cell.text, re.ASCII)) if word in found]


def _owned(joints: Sequence[Joint], new: Mapping[int, list[str]], given: Mapping[int, str]) -> dict[int, str]:
    """Own variables by row: those given, those alone in their cells, and those that others leave over."""
    alone = {j: names[0] for j, names in new.items() if len(names) == 1}
    owned = {j: name for j, name in alone.items() if offset_of(joints[j - 1].selected, name) is not None}
    elsewhere = set(owned.values())
    owned |= {j: name for j, name in alone.items() if name not in elsewhere}
    owned |= given
    _leave_over(new, owned)
    return owned


def _leave_over(new: Mapping[int, list[str]], owned: dict[int, str]) -> None:
    """Add the variables of the rows in whose cells all names but one are owned by others."""
    left = {j: {*names} for j, names in new.items() if j not in owned}
    holding: dict[str, list[int]] = {}
    for j, names in left.items():
        for name in names:
            holding.setdefault(name, []).append(j)
    taken = [*dict.fromkeys(owned.values())]
    for name in taken:
        for j in holding.pop(name, ()):
            left[j].discard(name)
            if len(left[j]) == 1 and j not in owned:
                (owned[j],) = left[j]
                taken.append(owned[j])


def _no_own(joint: Joint, new: Sequence[str], taken: Collection[str], parameters: Collection[str]) -> str:
    """Why a row that needs a variable of its own has none."""
    column, other = SELECTED[joint.sigma], OTHER[joint.sigma]
    left = [name for name in new if name not in taken]
    if left:
        likely = [name for name in left if offset_of(joint.selected, name) is not None] or left
        named = f"{', '.join(left[:-1])} and {left[-1]}"
        new_ones = "both new" if len(left) == 2 else "all new"
        advice = f'say variable = "{likely[-1]}"; parameters are declared in [parameters]'
        return f"the cell holds {named}, {new_ones}: {advice}"
    if new:
        holds = f"the cell holds variables of other joints only ({', '.join(new)})"
        return f'{holds}: add one of its own, or say kind = "coupled"'
    what = f"no joint variable in {quoted(getattr(joint, column))}, where sigma = {joint.sigma} expects it"
    elsewhere = sorted(getattr(joint, other).names.difference(parameters))
    if elsewhere:
        what += f"; {elsewhere[0]!r} stands in {other}, which is for sigma = {1 - joint.sigma}"
    return what


def _not_own(joint: Joint, variable: str, owns: bool) -> str:
    """Why a variable that a row names as its own cannot be; empty where it can."""
    if not owns:
        which = "a coupled joint" if joint.kind == Kind.COUPLED else "a fixed frame"
        return f"{which} has no variable of its own: leave it out"
    if variable not in joint.selected.names:
        return f"{quoted(variable)} does not stand in {SELECTED[joint.sigma]} = {quoted(joint.selected)}"
    return ""
