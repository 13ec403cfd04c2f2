"""What is wrong with closed loops, as far as it shows without numbers; and warnings about them."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping

from symoro_elastic.machine.columns import cells
from symoro_elastic.machine.described import DescribedMachine
from symoro_elastic.machine.formula import Formula, FormulaError
from symoro_elastic.machine.joints import Joint
from symoro_elastic.machine.loops import Closing, Loop
from symoro_elastic.machine.machine import Kind, Machine
from symoro_elastic.machine.names import Reasons, did_you_mean, quote, why_reserved

Fault = tuple[str, str]
"""A key, and what is wrong with it."""
SAME = 1e-9
"""Largest difference, rad or m, of positions that are the same but for rounding."""


def missing_rows(machine: Machine) -> Iterator[Fault]:
    """Rows of loops that the table does not have, in a machine built in Python."""
    for loop in machine.loops:
        for key, row in (("cut", loop.cut), ("meets", loop.meets)):
            if not 1 <= row <= len(machine.joints):
                yield f"loop {loop.name}, {key}", f"there is no row {row}: the table has {len(machine.joints)}"


def cut_faults(machine: Machine) -> Iterator[tuple[int, Fault]]:
    """Faults of cut joints and of rows on them, with the number of the joint."""
    cut = {j for j, joint in enumerate(machine.joints, start=1) if joint.kind == Kind.CUT}
    named = {loop.cut: loop for loop in machine.loops}
    for j, joint in enumerate(machine.joints, start=1):
        if joint.antecedent in cut:
            carrier = machine.joint(joint.antecedent)
            where = machine.joint(carrier.antecedent).name if carrier.antecedent else "the base"
            yield j, ("antecedent", f"{carrier.name} is a cut joint, which carries no other: hang it on {where}")
        if j not in cut:
            continue
        for what, key in _carried(joint):
            yield (
                j,
                (key, f"the cut joint carries no {what}: cut the loop elsewhere{_elsewhere(machine, named.get(j))}"),
            )
        if j not in named:
            example = f'[loops] name = {{ cut = "{joint.name}", meets = "..." }}'
            yield j, ("kind", f"no loop is closed by this cut joint: write {example}, or give it another kind")


def _carried(joint: Joint) -> Iterator[tuple[str, str]]:
    """What stands on a cut joint, with its key."""
    body = [cell.label for cell, formula in cells(joint.body) if not formula.is_zero]
    acting = [(cell, formula) for cell, formula in cells(joint) if cell.column.section in ("springs", "motors")]
    yield from (("motor, spring or body", key) for key in body)
    yield from (("motor, spring or body", cell.label) for cell, formula in acting if not formula.is_zero)
    for what in ("friction", "wrench"):
        found = [cell.label for cell, formula in cells(getattr(joint, what)) if formula != cell.column.default]
        yield from ((what, key) for key in found)


def _elsewhere(machine: Machine, loop: Loop | None) -> str:
    """The passive joints of a loop, in brackets, by their variables."""
    around = map(machine.joint, machine.around(loop)) if loop else ()
    passive = [str(joint.variable) for joint in around if joint.kind == Kind.PASSIVE]
    return f" (passive joints of it: {', '.join(passive)})" if passive else ""


def loop_faults(machine: Machine, taken: Reasons) -> Iterator[Fault]:
    """Faults of the entries of loops, with their place."""
    ends: dict[int, str] = {}
    for loop in machine.loops:
        reason = why_reserved(loop.name, taken)
        if reason or loop.name in (other.name for other in machine.loops if other is not loop):
            yield f"loop {quote(loop.name)}", f"this name cannot be used: {reason or 'two loops have it'}"
        yield from _placed(loop, (*_ends(machine, loop, ends), *_dependent(machine, loop), *_start(machine, loop)))
        ends |= {loop.cut: loop.name, loop.meets: loop.name}
    yield from _twice_dependent(machine)


def _placed(loop: Loop, faults: Collection[Fault]) -> Iterator[Fault]:
    yield from ((f"loop {loop.name}, {key}", what) for key, what in faults)


def _ends(machine: Machine, loop: Loop, ends: Mapping[int, str]) -> Iterator[Fault]:
    """Faults of the rows that a loop joins; `ends` are those of the loops before."""
    cut, meets = machine.joint(loop.cut), machine.joint(loop.meets)
    if loop.cut == loop.meets:
        yield "meets", f"{meets.name} is the cut joint itself: name the fixed frame that it meets"
    if cut.kind != Kind.CUT:
        known = [joint.name for joint in machine.joints if joint.kind == Kind.CUT]
        yield "cut", f'{cut.name} is not a cut joint: its row needs kind = "cut"{did_you_mean(cut.name, known)}'
    if meets.kind != Kind.FIXED and loop.cut != loop.meets:
        yield "meets", f"{meets.name} is not a fixed frame: the cut joint meets a row of its own, of kind fixed"
    for key, row, joint in (("cut", loop.cut, cut), ("meets", loop.meets, meets)):
        if row in ends:
            yield (
                key,
                f"{joint.name} belongs to loop {ends[row]}: each loop has a cut joint and a fixed frame of its own",
            )
    if loop.closes is Closing.POINT and cut.sigma != 2:
        yield "closes", f"a ball joint has no variable in the table: give {cut.name} sigma = 2"
    if not machine.around(loop):
        yield "cut", f"no joint between {cut.name} and {meets.name} moves: all of the loop is fixed"


def _dependent(machine: Machine, loop: Loop) -> Iterator[Fault]:
    """Faults of the joints whose variables depend on the others of the loop."""
    names = {joint.name: j for j, joint in enumerate(machine.joints, start=1)}
    inside = [machine.joint(j).name for j in machine.with_variable_in(loop)]
    for name in loop.dependent:
        if name not in names:
            yield "dependent", f"no joint {quote(name)}{did_you_mean(name, inside)}"
        elif names[name] == loop.cut:
            yield "dependent", f"{name} is the cut joint, whose variable follows anyway: leave it out"
        elif names[name] in machine.articulated and names[name] not in machine.with_variable:
            yield "dependent", f"{name} is coupled and has no variable of its own: name the joint that it follows"
        elif name not in inside:
            yield "dependent", f"{name} is not a joint of the loop: those are {', '.join(inside)}"
    if len(set(loop.dependent)) < len(loop.dependent):
        yield "dependent", "a joint is named twice"
    if not loop.dependent and machine.around(loop) and not machine.dependent_in(loop):
        yield "dependent", "the loop has no passive joint: name those that follow from the others"


def _start(machine: Machine, loop: Loop) -> Iterator[Fault]:
    """Faults of the rough position of a loop."""
    known = {joint.variable for joint in machine.joints if joint.variable}
    for name in loop.start:
        if name not in known:
            yield "start", f"no joint variable {quote(name)}{did_you_mean(name, sorted(known))}"


def _twice_dependent(machine: Machine) -> Iterator[Fault]:
    """Joints that two loops name as dependent."""
    named: dict[str, str] = {}
    for loop in machine.loops:
        for name in loop.dependent:
            if named.setdefault(name, loop.name) != loop.name:
                what = f"{name} follows from loop {named[name]} already: name another joint of the loop"
                yield f"loop {loop.name}, dependent", what


def start_faults(machine: Machine, values: Mapping[str, float]) -> Iterator[Fault]:
    """Positions of loops that have no value, or differ from those of another loop, with their place."""
    before: dict[str, tuple[str, float]] = {}
    for loop in machine.loops:
        for variable, formula in loop.start.items():
            place = f"loop {loop.name}, start, {variable}"
            try:
                value = formula.value(values)
            except KeyError:
                yield place, _without_value(machine, formula, values)
                continue
            except FormulaError as error:
                yield place, str(error)
                continue
            other, first = before.setdefault(variable, (loop.name, value))
            if not math.isclose(first, value, rel_tol=SAME, abs_tol=SAME):
                yield place, f"{value:g} contradicts {first:g} of loop {other}: a joint has one position"


def _without_value(machine: Machine, formula: Formula, values: Mapping[str, float]) -> str:
    """Why a formula has no value: a name that is not declared, or a parameter without a value."""
    parameters = {parameter.name for parameter in machine.parameters}
    for name in sorted(formula.names - parameters):
        return f"{name!r} is not declared{did_you_mean(name, parameters)}"
    missing = ", ".join(sorted(formula.names - values.keys()))
    return f"{missing} has no value, but numbers select the branch: give it one, or write a number"


def loop_warnings(machine: DescribedMachine) -> list[str]:
    """Warnings about loops around the same joints as another, and about a SYMORO type without its loops."""
    lines, seen = [], dict[tuple[int, ...], str]()
    for loop in machine.loops:
        other = seen.setdefault(machine.around(loop), loop.name)
        if other != loop.name:
            lines.append(f"loop {loop.name}: it closes around the same joints as loop {other}: closed twice?")
    return lines + [f"Type = {said}: {what}" for said, what in _structure(machine)]


def _structure(machine: DescribedMachine) -> Iterator[Fault]:
    """The type of structure that a .par file gives, where it is not that of its rows."""
    said, count = machine.origin.extras.get("Type", ""), len(machine.loops)
    if said == "2" and not count:
        what = "a .par file with closed loops has NJ > NL, with rows for cut joints and for the frames that they meet"
        yield said, f"there is no closed loop, the machine is taken as a tree; {what}"
    if said in ("0", "1") and count:
        kind, loops = "a chain" if said == "0" else "a tree", "a closed loop" if count == 1 else f"{count} closed loops"
        yield (
            said,
            f"that is {kind}, but NJ > NL: the machine is taken with {loops}; write Type = 2, or leave those rows out",
        )
