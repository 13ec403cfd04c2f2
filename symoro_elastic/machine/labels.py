"""Labels of the parameters on which torques depend linearly: `XX3`, `IA2`, `FV1`, `K4`."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property
from itertools import count

from symoro_elastic.machine.columns import cells
from symoro_elastic.machine.machine import Joint, Machine

OF_SPRINGS = {"stiffness": "K", "damping": "DA"}
"""Entries of cells that have no key of this name in .par files."""


def named_entries(joint: Joint) -> dict[str, str]:
    """Return by entry (XX, IA, K ...) the names that cells of a joint consist of.

    Inertias and first moments of a body about its centre of mass are not among them, nor is a rotor behind a ratio,
    whose inertia counts with the square of the ratio: they are other quantities.
    """
    named = {}
    for cell, formula in cells(joint):
        is_central = joint.body.central and cell.column.section == "bodies" and cell.column.parts
        is_geared = cell.column.key == "rotor_inertia" and not joint.ratio.is_zero
        if formula.tree[0] == "name" and not is_central and not is_geared:
            named[OF_SPRINGS.get(cell.name, cell.par)] = formula.tree[1]
    return named


class ParameterLabels:
    """Labels for one machine, distinct from the names of its other quantities.

    `taken` are the names of its parameters, joint variables and joints.
    """

    def __init__(self, machine: Machine) -> None:
        self._machine = machine
        variables = {joint.variable for joint in machine.joints if joint.variable is not None}
        self.taken = {*(p.name for p in machine.parameters), *(joint.name for joint in machine.joints), *variables}

    def __call__(self, j: int, entry: str) -> str:
        """`XX3` for the entry XX of joint 3; `XX_3` where XX3 is the name of something else in the machine."""
        return next(label for label in _candidates(j, entry) if label not in self.taken or (j, label) in self._own)

    def grouped_name(self, j: int, entry: str) -> str:
        """`XXR3` for the sum that is grouped in the entry XX of joint 3, `XXRR3` ... where that is taken."""
        return next(label for label in (f"{entry}{'R' * k}{j}" for k in count(1)) if label not in self.taken)

    @cached_property
    def _own(self) -> set[tuple[int, str]]:
        """Joints and names of the cells that are the parameter of their own label: XX of joint 3 is XX3."""
        joints = enumerate(self._machine.joints, start=1)
        named = ((j, entry, name) for j, joint in joints for entry, name in named_entries(joint).items())
        return {(j, name) for j, entry, name in named if name == f"{entry}{j}"}


def _candidates(j: int, entry: str) -> Iterator[str]:
    yield from (f"{entry}{j}", f"{entry}_{j}")
    yield from (f"{entry}_{j}_{k}" for k in count(2))
