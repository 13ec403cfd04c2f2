"""Joints of beams with `joints = "auto"`: the fewest within a tolerance, by what the machine carries at their ends."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from symoro_elastic.formats.robots.robot import Placement
from symoro_elastic.formats.toml.beams import AUTO, END, HEADING, JOINTS, RULE, TOLERANCE, UP_TO
from symoro_elastic.formats.toml.flexible import place_of_row
from symoro_elastic.formats.toml.tables import Table
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.machine.beam_errors import errors_by_joints, kinds_of
from symoro_elastic.machine.beams import RULES, Beam
from symoro_elastic.machine.described import DescribedMachine
from symoro_elastic.machine.machine import Body

UPPER = ((0, 1, 2), (1, 3, 4), (2, 4, 5))
"""Entries XX XY XZ YY YZ ZZ of a symmetric tensor, by row and column."""


def with_chosen_joints(top: Table, machine: DescribedMachine, values: Mapping[str, float]) -> tuple[Table, list[str]]:
    """The top table of a file with numbers of joints in place of auto, and a sentence for each beam.

    `machine` is that of the file with 4 joints, `values` those of its parameters. Raises `InputError` where no number
    of joints is enough.
    """
    table, entries, sentences = top.table(HEADING), dict(top.table(HEADING).entries), list[str]()
    for beam in machine.origin.beams:
        entry = replace(table.table(beam.name), place=f"beam {beam.name}")
        own = dict(entry.entries)
        of_auto = [key for key in (UP_TO.name, TOLERANCE.name) if own.pop(key, None) is not None]
        if own.get(JOINTS.name) == AUTO:
            chosen, why = _chosen(entry, beam, machine, values)
            entries[beam.name] = {**own, JOINTS.name: chosen.joints, RULE.name: chosen.rule}
            sentences.append(f"beam {beam.name}: {chosen.joints} joints, {chosen.rule}: {why}")
        elif of_auto:
            raise entry.fail(of_auto[0], f'belongs to joints = "{AUTO}": write that, or leave it out')
    return replace(top, entries={**top.entries, HEADING: entries}) if sentences else top, sentences


def _chosen(entry: Table, beam: Beam, machine: DescribedMachine, values: Mapping[str, float]) -> tuple[Beam, str]:
    """The beam with the fewest joints that are enough, and why."""
    if UP_TO.name not in entry.entries:
        return beam, 'with up_to = "300 Hz", auto chooses them for that band'
    highest, tolerance = UP_TO.read(entry), TOLERANCE.read(entry)
    for key, value in ((UP_TO, highest), (TOLERANCE, tolerance)):
        if value <= 0:
            raise entry.fail(key.name, f"{value:g} must be above 0")
    carried = carried_by(machine, beam.name + END, values)
    kinds = kinds_of(beam, values, carried)
    if not kinds or np.isnan(carried).any():
        return beam, "auto needs values of all parameters of the beam and its load"
    fewer = ""
    for trial, error in errors_by_joints(beam, kinds, (beam.rule,) if RULE.name in entry.entries else RULES, highest):
        if error <= tolerance:
            what = f"errors up to {round(100 * error, 6):.2g} %{fewer} of frequencies up to {highest:g} Hz"
            return trial, f"{what} with the root clamped and {carried[3, 3]:.3g} kg at the end"
        fewer = f" ({100 * error:.2g} % with {trial.joints})" if np.isfinite(error) else ""
    what = f"no rule has joints enough for {100 * tolerance:g} % up to {highest:g} Hz"
    raise entry.fail(JOINTS.name, f"{what}: lower up_to, or raise tolerance")


def carried_by(machine: DescribedMachine, end: str, values: Mapping[str, float]) -> Array:
    """The integral (4, 4) of (x, y, z, 1) times itself over the mass that a row carries, joints at zero, in its frame.

    NaN where a body has no value.
    """
    at_zero = {joint.variable: 0.0 for joint in machine.joints if joint.variable} | dict(values)
    total, frames = np.zeros((4, 4)), dict[int, Placement]()
    for j, joint in enumerate(machine.joints, start=1):
        if joint.name == end:
            frames[j] = Placement()
        elif joint.antecedent in frames:
            frames[j] = frames[joint.antecedent] * (place_of_row(joint, at_zero) or Placement())
        if j in frames:
            T = frames[j].matrix
            total = total + T @ _spread(joint.body, values) @ T.T
    return np.asarray(total)


def _spread(body: Body, values: Mapping[str, float]) -> Array:
    """The same integral of one body in its own frame."""
    cells = [cell.known_value(values) for cell in (body.mass, *body.moments, *body.inertia)]
    mass, *rest = np.array([np.nan if cell is None else cell for cell in cells])
    tensor, first = np.array(rest[3:])[np.array(UPPER)], np.array(rest[:3])
    square = np.trace(tensor) / 2 * np.eye(3) - tensor
    if body.central:
        square, first = square + mass * np.outer(first, first), mass * first
    return np.block([[square, first[:, None]], [first, mass]])
