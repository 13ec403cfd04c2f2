"""What `show` says of a machine: tables and sentences, and the same values as plain data."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from symoro_elastic.foundation.results import Part, Table, plain
from symoro_elastic.generation.pipeline import zero_pivots
from symoro_elastic.machine.machine import Kind, Machine
from symoro_elastic.machine.restrict import restrict
from symoro_elastic.machine.scene import Scene
from symoro_elastic.machine.views import (
    beams_table,
    by_first_cell,
    catalogue_table,
    drives_table,
    frames_json,
    limits_json,
    machine_table,
    other_tables,
    parameter_lines,
)
from symoro_elastic.models.bound.joint_axes import PlacedMachine, placed_machine
from symoro_elastic.numerics.linear.grouping import BaseParameters, base_parameters
from symoro_elastic.pages.closed_chains import ClosedChain, closed_chain, closed_chain_json, closed_chain_lines


@dataclass(frozen=True)
class Description:
    """Description of a machine at a position: loops, axes, base parameters, and joints of singular inertia.

    Base parameters and singular inertias are determined when asked for; they raise `InputError` for a machine that has
    no regular position about its start.
    """

    full_machine: Machine
    scene: Scene
    chain: ClosedChain
    placement: PlacedMachine

    @cached_property
    def base(self) -> BaseParameters:
        """Base inertial parameters of the machine in the scene."""
        return base_parameters(self.chain.machine)

    @cached_property
    def degenerate(self) -> list[str]:
        """Joints whose inertia is singular at every position, each with the reason."""
        return [f"{joints}: {message}" for message, joints in zero_pivots(self.full_machine, self.scene)]

    def as_json(self) -> dict[str, Any]:
        """Return the description as plain data."""
        machine, base = self.chain.machine, self.base
        by_kind = {kind: [joint.name for joint in machine.joints if joint.kind is kind] for kind in Kind}
        return {
            "name": machine.name,
            "joints": [joint.name for joint in machine.independent_joints],
            "motors": by_kind[Kind.MOTOR],
            "elastic": by_kind[Kind.ELASTIC],
            **closed_chain_json(self.chain),
            "position": plain(self.placement.q),
            "axes": {
                one.joint.name: {"origin": plain(one.origin), "axis": plain(one.axis)} for one in self.placement.joints
            },
            "gravity": [str(x) for x in machine.base.gravity],
            "frames": frames_json(machine),
            "parameters": [p.name for p in machine.parameters],
            "beams": by_first_cell(beams_table(machine)),
            "catalogue_springs": by_first_cell(catalogue_table(machine)),
            "limits": limits_json(machine),
            "drives": by_first_cell(drives_table(machine)),
            "base_parameters": base.formulas,
            "base_parameters_parts": base.parts,
            "base_parameters_zero": base.zero,
            "base_parameters_check": base.check,
            "base_parameters_condition": base.condition,
            "degenerate": self.degenerate,
        }

    def parts(self, width: int) -> Iterator[Part]:
        """Yield tables and sentences in their order; lists of parameters are wrapped at the width."""
        machine, base, degenerate = self.chain.machine, self.base, self.degenerate
        yield machine_table(machine, machine.name)
        yield axes_table(self.placement, "origins and axes in frame 0")
        yield from other_tables(machine)
        yield machine.gravity_in_words
        for line in parameter_lines(machine):
            yield textwrap.fill(line, width, subsequent_indent="  ")
        if machine.floating:
            orientation, quantity = machine.floating.orientation, machine.floating.known
            yield f"floating base: {orientation} and {quantity} given, M = {machine.floating.body.mass}"
        yield from closed_chain_lines(self.chain)
        yield f"\nbase inertial parameters: {base.check}"
        for name, formula in {**base.parts, **base.formulas}.items():
            yield f"  {name} = {formula}"
        if base.zero:
            yield f"  zero for these bodies: {', '.join(base.zero)}"
        yield base.conditioning
        yield from [f"degenerate: {message}" for message in degenerate] or ["no degenerate joints"]


def description(machine: Machine, scene: Scene, position: Mapping[str, float]) -> Description:
    """Return the description of a machine restricted to a scene; raises `InputError`."""
    part = restrict(machine, scene)
    placement = placed_machine(part, position)
    return Description(machine, scene, closed_chain(part, placement), placement)


MOVES = ("turns about", "slides along", "is fixed, z:")
DIRECTIONS: dict[tuple[float, ...], str] = {
    **{(1, 0, 0): "x", (0, 1, 0): "y", (0, 0, 1): "z"},
    **{(-1, 0, 0): "-x", (0, -1, 0): "-y", (0, 0, -1): "-z"},
}
ROUNDING = 1e-12


def axes_table(placement: PlacedMachine, title: str = "") -> Table:
    """Return origin and axis of the joints in frame 0; `-` if they depend on parameters without value."""
    table = Table(("j", "name", "q", "origin x, m", "y, m", "z, m", "it", "this axis"), title=title, keys=2)
    size = max((abs(x) for joint in placement.joints for x in joint.origin if not math.isnan(x)), default=0.0)
    for j, joint in enumerate(placement.joints, start=1):
        q = _number(placement.q[joint.joint.name]) if joint.joint.name in placement.q else ""
        origin = (_number(_without_rounding(x, size)) for x in joint.origin)
        table.add_row(str(j), joint.joint.name, q, *origin, MOVES[joint.joint.sigma], _direction(joint.axis))
    return table


def _direction(axis: Sequence[float]) -> str:
    x, y, z = (_without_rounding(x, 1.0) for x in axis)
    return DIRECTIONS.get((x, y, z)) or f"{_number(x)}, {_number(y)}, {_number(z)}"


def _without_rounding(x: float, size: float) -> float:
    """Return the nearest integer if a number differs from it by rounding alone, else the number."""
    rounded = 0.0 if math.isnan(x) else float(round(x))
    return rounded if abs(x - rounded) <= ROUNDING * size else x


def _number(x: float) -> str:
    return "-" if math.isnan(x) else f"{x + 0.0:.6g}"
