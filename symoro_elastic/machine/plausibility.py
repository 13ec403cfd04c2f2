"""Valid but implausible numbers of a machine."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from fractions import Fraction

import numpy as np

from symoro_elastic.machine.columns import UPPER
from symoro_elastic.machine.format_names import is_robot
from symoro_elastic.machine.formula import Formula, Tree
from symoro_elastic.machine.joints import Friction
from symoro_elastic.machine.machine import Body, Joint, Kind, Machine
from symoro_elastic.machine.rounded_angles import ANGLES, multiple_of_pi

ROUNDING = 1e-9
NEARLY_A_TURN = 1e-3
FAST = 1e4
"""Ratio beyond which no gear is built."""


def warnings(machine: Machine, values: Mapping[str, float]) -> list[str]:
    """Warnings about implausible numbers, one line each; formulas over names without value are skipped."""
    lines = [f"base: {line}" for body in machine.free_bodies for line in _inertia(body, values)]
    impossible: list[str] = []
    for j, joint in enumerate(machine.joints, start=1):
        inertia = [] if machine.is_grouped or _turns_in_plane(machine, j, values) else [*_inertia(joint.body, values)]
        impossible += [f"joint {j} ({joint.name}): {line}" for line in inertia]
        doubts = (
            *_angles(joint, values),
            *_without_effect(joint, values),
            *_doubled_rotor(joint),
            *_rotor_of_a_sum(machine, joint),
            *_gears(machine, joint, values),
        )
        lines += [f"joint {j} ({joint.name}): {line}" for line in doubts]
    more = f"; {len(impossible) - 1} more bodies like this" if len(impossible) > 1 else ""
    lines = [*(f"{line}{more}" for line in impossible[:1]), *lines]
    return [*lines, *_off_quarter_turns(machine, values), *_moving_nothing(machine, values), *_starts(machine, values)]


def _turns_in_plane(machine: Machine, j: int, values: Mapping[str, float]) -> bool:
    """Whether body j turns about its axis z only, or not at all: then no other moment of inertia acts."""
    if machine.floating or any(not x.is_zero for x in machine.base.angular_velocity):
        return False
    rows: list[Joint] = []
    while j:
        rows.insert(0, machine.joint(j))
        j = machine.joint(j).antecedent
    has_turned = False
    for row in rows:
        alpha = row.alpha.known_value(values)
        if has_turned and (alpha is None or abs(math.sin(alpha)) > ROUNDING):
            return False
        has_turned = has_turned or row.sigma == 0
    return True


def _off_quarter_turns(machine: Machine, values: Mapping[str, float]) -> Iterator[str]:
    """One line about all angles that are nearly, but not quite, quarter turns."""
    angles = [
        (f"joint {j} ({joint.name})", *cell)
        for j, joint in enumerate(machine.joints, start=1)
        for cell in _nearly_quarters(joint, values)
    ]
    if not angles:
        return
    largest = max(abs(off) for _, _, off, _ in angles)
    most, power = f"{largest:.2g}", math.ceil(math.log10(largest))
    way_out = f"convert with --snap 1e{power} rounds them"
    if is_robot(machine.source):
        count = f"{len(angles)} angles are" if len(angles) > 1 else "an angle is"
        yield f"{count} up to {most} rad off quarter turns: taken as written; {way_out}"
    elif len(angles) == 1:
        ((place, written, off, turn),) = angles
        yield f"{place}: {written} is {off:.2g} rad off {turn}: taken as written; write {turn} if meant"
    else:
        cells = ", ".join(f"{place} {written.partition(' ')[0]}" for place, written, _, _ in angles)
        what = f"taken as written; write multiples of pi/2 if meant, or {way_out}: {cells}"
        yield f"{len(angles)} angles are up to {most} rad off quarter turns, {what}"


def _nearly_quarters(joint: Joint, values: Mapping[str, float]) -> Iterator[tuple[str, float, str]]:
    """Yield angles close to a quarter turn: the cell, its deviation, rad, and the exact angle."""
    for key in ANGLES:
        formula: Formula = getattr(joint, key)
        angle = formula.known_value(values)
        if formula.is_zero or angle is None or abs(angle) > 2 * math.pi:
            continue
        turns = round(angle / (math.pi / 2))
        exact = turns * math.pi / 2
        ulps = 8 if _holds_pi(formula.tree) else 1
        if ulps * math.ulp(exact) < abs(angle - exact) < NEARLY_A_TURN:
            yield f"{key} = {formula}", angle - exact, multiple_of_pi(Fraction(turns, 2))


def _angles(joint: Joint, values: Mapping[str, float]) -> Iterator[str]:
    for key in ANGLES:
        formula: Formula = getattr(joint, key)
        angle = formula.known_value(values)
        if angle is not None and abs(angle) > 2 * math.pi:
            yield f"{key} = {formula} is {angle / (2 * math.pi):.3g} turns, as angles are in rad{_from_degrees(angle)}"


def _starts(machine: Machine, values: Mapping[str, float]) -> Iterator[str]:
    """Warnings about start angles of loops above one turn, which may be in degrees; geared joints excepted."""
    turning = [joint for joint in machine.joints if joint.sigma == 0]
    geared = {name for joint in turning for name in joint.selected.names}
    owners = {joint.variable: joint for joint in machine.joints}
    for loop in machine.loops:
        for name, formula in loop.start.items():
            joint, angle = owners[name], formula.known_value(values)
            alone = name not in geared and machine.variables.keys().isdisjoint(joint.selected.names)
            if joint.sigma == 0 and alone and angle is not None and abs(angle) > 2 * math.pi:
                what = f"{name} = {formula} is {angle / (2 * math.pi):.3g} turns, as angles are in rad"
                yield f"loop {loop.name}, start: {what}{_from_degrees(angle)}"


def _from_degrees(angle: float) -> str:
    """Return the question whether an angle is in degrees, with its value in rad if that is simple."""
    part = Fraction(angle / 180).limit_denominator(360)
    if part.denominator > 36 or abs(angle - float(180 * part)) > 1e-9:
        return ": degrees? divide by 180 and write *pi"
    return f": degrees? write {multiple_of_pi(part)}"


def _holds_pi(tree: Tree) -> bool:
    return tree[0] == "pi" or any(_holds_pi(part) for part in tree[1:] if isinstance(part, tuple))


def _inertia(body: Body, values: Mapping[str, float]) -> Iterator[str]:
    numbers = [formula.known_value(values) for formula in (body.mass, *body.moments, *body.inertia)]
    entries = [number for number in numbers if number is not None]
    if len(entries) < len(numbers) or not any(entries):
        return
    mass, moments, tensor = entries[0], entries[1:4], entries[4:]
    if mass == 0 and not _turns_only(moments, tensor):
        yield "without mass there can be no " + ("inertia" if any(tensor) else "first moments")
    if mass == 0:
        return
    matrix, first = np.array(tensor)[np.array(UPPER)], np.array(moments)
    shift = (first @ first * np.eye(3) - np.outer(first, first)) / mass if not body.central else np.zeros((3, 3))
    scale = max(np.abs(matrix).max(), np.abs(shift).max())
    yield from _principal(np.linalg.eigvalsh(matrix - shift).tolist(), ROUNDING * float(scale))


def _turns_only(first_moments: list[float], tensor: list[float]) -> bool:
    """Whether a body consists of one moment of inertia about an axis, as in the table of a drive."""
    xx, xy, xz, yy, yz, zz = tensor
    axes = [x for x in (xx, yy, zz) if x]
    return not any((*first_moments, xy, xz, yz)) and len(axes) == 1 and axes[0] > 0


def _principal(moments: list[float], rounding: float) -> Iterator[str]:
    listed = ", ".join(f"{moment:.6g}" for moment in moments)
    subject = f"principal moments {listed} kg m2 about the centre of mass"
    if moments[0] < -rounding:
        yield f"{subject}: {moments[0]:.6g} is negative"
    elif moments[2] > moments[0] + moments[1] + rounding:
        yield f"{subject} violate the triangle inequality: {moments[2]:.6g} exceeds the sum of the other two"


def _moving_nothing(machine: Machine, values: Mapping[str, float]) -> list[str]:
    """Motors without mass, or inertia, beyond them in a machine that has some."""
    bodies = [_heaviness(joint.body, values) for joint in machine.joints]
    if machine.is_grouped or not any(map(any, bodies)):
        return []
    lines = []
    for j in machine.motors:
        masses, inertias = zip(*(bodies[k - 1] for k in _bodies_moved_by(machine, j)), strict=True)
        slides = machine.joint(j).sigma == 1
        if not any(masses) and (slides or not any(inertias)):
            lines.append(f"joint {j} ({machine.joint(j).name}): no body beyond this motor has mass{_or(slides)}")
    return lines


def _or(slides: bool) -> str:
    return "" if slides else " or inertia"


def _heaviness(body: Body, values: Mapping[str, float]) -> tuple[bool, bool]:
    """Whether a body has mass, and moments or inertia; formulas without value count as not zero."""
    mass, *inertias = (formula.known_value(values) != 0.0 for formula in (body.mass, *body.moments, *body.inertia))
    return mass, any(inertias)


def _bodies_moved_by(machine: Machine, j: int) -> list[int]:
    """Numbers of the bodies that joint j moves: beyond it, beyond its followers, and in its loops."""
    moved, followed, count = {j}, {j}, 0
    while len(moved) + len(followed) > count:
        count = len(moved) + len(followed)
        names = {machine.joint(k).variable for k in followed}
        for k, joint in enumerate(machine.joints, start=1):
            if joint.antecedent in moved or not names.isdisjoint(joint.selected.names):
                moved.add(k)
        for loop in machine.loops:
            if not moved.isdisjoint(machine.around(loop)):
                followed.update(machine.around(loop))
        moved |= followed
    return sorted(moved)


def _without_effect(joint: Joint, values: Mapping[str, float]) -> Iterator[str]:
    if joint.kind == Kind.FIXED and not (joint.rotor_inertia.is_zero and joint.friction.viscous.is_zero):
        yield "rotor inertia and friction of a fixed frame have no effect"
    if joint.friction.coulomb.is_zero and not joint.friction.creep.is_zero:
        yield "creep has no effect: the joint has no coulomb friction"
    yield from _gains_energy(joint.friction, values)
    if joint.kind == Kind.ELASTIC and not joint.rotor_inertia.is_zero:
        yield "rotor inertia on an elastic joint: kept, and counted in its inertia"


def _gains_energy(law: Friction, values: Mapping[str, float]) -> Iterator[str]:
    """The bound below which friction with a bristle may give energy: Fv > s1 (Fb - Fc)/Fc (D1)."""
    cells = (law.viscous, law.coulomb, law.static, law.bristle_damping)
    numbers = [x for cell in cells if (x := cell.known_value(values)) is not None]
    if law.bristle.is_zero or law.static.is_zero or len(numbers) < len(cells):
        return
    viscous, coulomb, static, damping = numbers
    least = damping * (static - coulomb) / coulomb
    if viscous <= least:
        yield f"friction may give energy: viscous = {viscous:g} is not above {least:.4g}, which suffices"


def _gears(machine: Machine, joint: Joint, values: Mapping[str, float]) -> Iterator[str]:
    """Questions about implausible ratios of gears and of joints that turn with others."""
    ratio = joint.ratio.known_value(values)
    if ratio is not None and abs(ratio) > FAST:
        yield f"ratio = {joint.ratio}: the rotor turns {abs(ratio):g} times as fast as the joint; is this meant?"
    followed = joint.selected.names & machine.variables.keys()
    leaders = sorted(name for name in followed if _turns(machine, name))
    for name in leaders if joint.sigma == 0 else ():
        rate = _rate(joint.selected, name, {**dict.fromkeys(leaders, 0.0), **values})
        if rate > FAST:
            yield f"theta = {joint.selected}: the joint turns {rate:g} times as fast as {name}; is this meant?"
        if 0 < rate * FAST < 1 and len(leaders) == 1:
            yield f"theta = {joint.selected}: {name} turns {1 / rate:g} times as fast as the joint; is this meant?"


def _turns(machine: Machine, variable: str) -> bool:
    return machine.joint(machine.variables[variable]).sigma == 0


def _rate(formula: Formula, name: str, values: Mapping[str, float]) -> float:
    """The absolute derivative of a formula by one name; 0 if it varies or has no value."""
    here, there, further = (formula.known_value({**values, name: x}) for x in (0.0, 1.0, 3.0))
    if here is None or there is None or further is None:
        return 0.0
    rate = there - here
    return abs(rate) if math.isclose(further - here, 3 * rate, rel_tol=ROUNDING) else 0.0


def _doubled_rotor(joint: Joint) -> Iterator[str]:
    """Warnings about a coupled joint whose row has both the body of a rotor and a rotor inertia."""
    both = not (joint.body.inertia[5].is_zero or joint.rotor_inertia.is_zero)
    if joint.kind == Kind.COUPLED and joint.body.is_balanced and both:
        yield "inertia ZZ of the body and rotor_inertia are both counted: one of them where they are of the same rotor"


def _rotor_of_a_sum(machine: Machine, joint: Joint) -> Iterator[str]:
    """Warning about the rotor inertia of a motor whose cell contains other joints' variables."""
    led = joint.selected.names & machine.variables.keys() - {joint.variable}
    if joint.kind == Kind.MOTOR and led and not joint.rotor_inertia.is_zero:
        cell = "r" if joint.sigma == 1 else "theta"
        yield (
            f"rotor_inertia moves with all of {cell}, {joint.selected} too, the torque of the motor acts on "
            f'{joint.variable}: a rotor that moves with {joint.variable} alone is a row of its own, kind = "coupled", '
            f'{cell} = "{joint.variable}", with the rotor_inertia'
        )
