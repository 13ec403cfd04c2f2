"""Joints of beams with `joints = "auto"`: the fewest within a tolerance, by what the machine carries at their ends."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from symoro_elastic.formats.robots.robot import Placement
from symoro_elastic.formats.toml.flexible.beams import AUTO, END, HEADING, JOINTS, RULE, TOLERANCE, UP_TO
from symoro_elastic.formats.toml.flexible.parts import place_of_row
from symoro_elastic.formats.toml.tables import Table
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.machine.beams.beam import Beam
from symoro_elastic.machine.beams.errors import bending_of, errors_by_joints
from symoro_elastic.machine.beams.places import RULES
from symoro_elastic.machine.columns import UPPER
from symoro_elastic.machine.described import DescribedMachine
from symoro_elastic.machine.machine import Body, Kind

ZERO = np.zeros((4, 4))


def with_chosen_joints(
    top: Table, machine: DescribedMachine, values: Mapping[str, float]
) -> tuple[Table, dict[str, str]]:
    """Replace joints = "auto" of beams by numbers; return the top table, and reasons by beam.

    `machine` is that of the file with 4 joints, `values` those of its parameters. Raises `InputError` where no number
    of joints is enough.
    """
    table, entries, sentences = top.table(HEADING), dict(top.table(HEADING).entries), dict[str, str]()
    for beam in machine.origin.beams:
        entry = replace(table.table(beam.name), place=f"beam {beam.name}")
        own = dict(entry.entries)
        of_auto = [key for key in (UP_TO.name, TOLERANCE.name) if own.pop(key, None) is not None]
        if own.get(JOINTS.name) == AUTO:
            chosen, sentences[beam.name] = _chosen(entry, beam, machine, values)
            entries[beam.name] = {**own, JOINTS.name: chosen.joints, RULE.name: chosen.rule}
        elif of_auto:
            raise entry.fail(of_auto[0], f'belongs to joints = "{AUTO}": write that, or leave it out')
    return replace(top, entries={**top.entries, HEADING: entries}) if sentences else top, sentences


def _chosen(entry: Table, beam: Beam, machine: DescribedMachine, values: Mapping[str, float]) -> tuple[Beam, str]:
    """Beam with the fewest joints that are accurate enough, and the reason."""
    if UP_TO.name not in entry.entries:
        return beam, "no up_to"
    highest, tolerance = UP_TO.read(entry), TOLERANCE.read(entry)
    for key, value in ((UP_TO, highest), (TOLERANCE, tolerance)):
        if value <= 0:
            raise entry.fail(key.name, f"{value:g} must be above 0")
    carried, hub = bodies_beside(machine, beam, values)
    kinds = bending_of(beam, values, carried, hub)
    if not kinds or np.isnan(carried).any() or (hub is not None and np.isnan(hub).any()):
        return beam, "parameters without value"
    fewer = ""
    for trial, error in errors_by_joints(beam, kinds, (beam.rule,) if RULE.name in entry.entries else RULES, highest):
        if error <= tolerance:
            root = "clamped" if hub is None else f"clamped or free with {hub[3, 3]:.3g} kg"
            what = f"{round(100 * error, 6):.2g} % up to {highest:g} Hz{fewer}"
            return trial, f"{what}, root {root}, {carried[3, 3]:.3g} kg at the end"
        fewer = f" ({trial.joints} joints: {100 * error:.2g} %)" if np.isfinite(error) else ""
    what = f"no rule has joints enough for {100 * tolerance:g} % up to {highest:g} Hz"
    raise entry.fail(JOINTS.name, f"{what}: lower up_to, or raise tolerance")


def bodies_beside(machine: DescribedMachine, beam: Beam, values: Mapping[str, float]) -> tuple[Array, Array | None]:
    """Rigid bodies at a beam: those carried by its end, and those between its root and a motor, joints at zero.

    Integrals (4, 4) of (x, y, z, 1) times itself over the mass, in axes of the beam's row about end and root; NaN where
    a body has no value. None where nothing moves there.
    """
    at_zero = {joint.variable: 0.0 for joint in machine.joints if joint.variable} | dict(values)
    places = [place_of_row(joint, at_zero) or Placement() for joint in machine.joints]
    frames = {machine.rows[beam.name + END]: Placement()}
    for j, joint in enumerate(machine.joints, start=1):
        if joint.antecedent in frames:
            frames[j] = frames[joint.antecedent] * places[j - 1]
    j, hub, frame = machine.rows[beam.name], dict[int, Placement](), Placement()
    while j and machine.joint(j).kind is not Kind.MOTOR:
        hub[j] = frame
        j, frame = machine.joint(j).antecedent, frame * places[j - 1].inverse
    moves = any(machine.joint(j).kind is not Kind.FIXED for j in hub)
    both = ([_spread(machine.joint(j).body, T, values) for j, T in x.items()] for x in (frames, hub))
    carried, held = (np.sum([ZERO, *parts], axis=0) for parts in both)
    return carried, held if moves else None


def _spread(body: Body, frame: Placement, values: Mapping[str, float]) -> Array:
    """Integral (4, 4) of (x, y, z, 1) times itself over the mass of a body placed in the axes of the beam's row."""
    cells = [cell.known_value(values) for cell in (body.mass, *body.moments, *body.inertia)]
    mass, *rest = np.array([np.nan if cell is None else cell for cell in cells])
    tensor, first = np.array(rest[3:])[np.array(UPPER)], np.array(rest[:3])
    square = np.trace(tensor) / 2 * np.eye(3) - tensor
    if body.central:
        square, first = square + mass * np.outer(first, first), mass * first
    return np.asarray(frame.matrix @ np.block([[square, first[:, None]], [first, mass]]) @ frame.matrix.T)
