"""Joints of beams with `joints = "auto"`: the fewest within a tolerance, by what the machine carries at their ends."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np

from symoro_elastic.formats.robots.robot import Placement
from symoro_elastic.formats.toml.beams import AUTO, END, HEADING, JOINTS, RULE, TOLERANCE, UP_TO, USUAL
from symoro_elastic.formats.toml.flexible import place_of_row
from symoro_elastic.formats.toml.tables import Table
from symoro_elastic.machine.beam_errors import Carried, Choice, fewest_joints, kinds_of
from symoro_elastic.machine.beams import RULES, Beam
from symoro_elastic.machine.described import DescribedMachine

UPPER = ((0, 1, 2), (1, 3, 4), (2, 4, 5))
"""Entries XX XY XZ YY YZ ZZ of a symmetric tensor, by row and column."""


def with_chosen_joints(top: Table, machine: DescribedMachine, values: Mapping[str, float]) -> tuple[Table, list[str]]:
    """The top table of a file with numbers of joints in place of auto, and a sentence for each beam.

    `machine` is that of the file with 4 joints, `values` those of its parameters. Raises `InputError` where no number
    of joints is enough.
    """
    table, entries, said = top.table(HEADING), dict(top.table(HEADING).entries), list[str]()
    for beam in machine.origin.beams:
        entry = replace(table.table(beam.name), place=f"beam {beam.name}")
        if entry.entries.get(JOINTS.name) != AUTO:
            for key in (UP_TO, TOLERANCE):
                if key.name in entry.entries:
                    raise entry.fail(key.name, f'belongs to joints = "{AUTO}": write that, or leave it out')
            continue
        rule, joints, sentence = _chosen(entry, beam, machine, values)
        others = {key: x for key, x in entry.entries.items() if key not in (UP_TO.name, TOLERANCE.name)}
        entries[beam.name] = {**others, JOINTS.name: joints, RULE.name: rule}
        said.append(f"beam {beam.name}: {sentence}")
    return replace(top, entries={**top.entries, HEADING: entries}) if said else top, said


def _chosen(entry: Table, beam: Beam, machine: DescribedMachine, values: Mapping[str, float]) -> tuple[str, int, str]:
    """Rule, number of joints, and the sentence that says why."""
    rule = RULE.read(entry)
    if UP_TO.name not in entry.entries:
        return rule, USUAL, f'{USUAL} joints, {rule}: with up_to = "300 Hz", auto chooses them for that band'
    highest, tolerance = UP_TO.read(entry), TOLERANCE.read(entry)
    for key, value in ((UP_TO, highest), (TOLERANCE, tolerance)):
        if value <= 0:
            raise entry.fail(key.name, f"{value:g} must be above 0")
    carried = carried_by(machine, beam.name + END, values)
    kinds = kinds_of(beam, values, carried) if carried else None
    if not carried or not kinds:
        return rule, USUAL, f"{USUAL} joints, {rule}: auto needs values of all parameters of the beam and its load"
    rules = (rule,) if RULE.name in entry.entries else RULES
    choice = fewest_joints(beam, kinds, rules, highest, tolerance)
    if choice is None:
        what = f"no rule has joints enough for {100 * tolerance:g} % up to {highest:g} Hz"
        raise entry.fail(JOINTS.name, f"{what}: lower up_to, or raise tolerance")
    return choice.rule, choice.joints, _sentence(choice, carried.mass, highest)


def _sentence(choice: Choice, mass: float, highest: float) -> str:
    fewer = f" ({100 * choice.of_fewer:.2g} % with {choice.joints - 1})" if np.isfinite(choice.of_fewer) else ""
    what = f"errors up to {100 * choice.error:.2g} %{fewer} of frequencies up to {highest:g} Hz"
    return f"{choice.joints} joints, {choice.rule}: {what} with the root clamped and {mass:.3g} kg at the end"


def carried_by(machine: DescribedMachine, end: str, values: Mapping[str, float]) -> Carried | None:
    """What a row carries, joints at zero, in its frame as if rigid; None where a body has no value."""
    mass, moments, inertia = 0.0, np.zeros(3), np.zeros((3, 3))
    at_zero = {joint.variable: 0.0 for joint in machine.joints if joint.variable} | dict(values)
    for j, frame in _carried_frames(machine, end, at_zero):
        body = machine.joint(j).body
        cells = [cell.known_value(values) for cell in (body.mass, *body.moments, *body.inertia)]
        if None in cells:
            return None
        own, *rest = (cell or 0.0 for cell in cells)
        first, tensor = np.array(rest[:3]) * (own if body.central else 1), np.array(rest[3:])[np.array(UPPER)]
        if body.central and own:
            tensor = tensor + (first @ first * np.eye(3) - np.outer(first, first)) / own
        R, p = frame.rotation, frame.translation
        turned = R @ first
        cross = 2 * turned @ p * np.eye(3) - np.outer(turned, p) - np.outer(p, turned)
        inertia += R @ tensor @ R.T + cross + own * (p @ p * np.eye(3) - np.outer(p, p))
        mass, moments = mass + own, moments + turned + own * p
    return Carried(mass, moments, inertia)


def _carried_frames(
    machine: DescribedMachine, end: str, values: Mapping[str, float]
) -> Iterator[tuple[int, Placement]]:
    """Rows below a row, with their placements in its frame."""
    frames: dict[int, Placement] = {}
    for j, joint in enumerate(machine.joints, start=1):
        if joint.name == end:
            frames[j] = Placement()
        elif joint.antecedent in frames:
            frames[j] = frames[joint.antecedent] * (place_of_row(joint, values) or Placement())
        if j in frames:
            yield j, frames[j]
