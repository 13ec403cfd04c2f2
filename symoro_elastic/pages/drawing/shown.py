"""What is shown of a machine on its page: where it stands, how it vibrates there, and the motions of a scene."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

from symoro_elastic.analysis.vibration.linearization import linearize
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.machine import Machine
from symoro_elastic.numerics.motion.equations_of_motion import motion_of
from symoro_elastic.numerics.motion.equilibrium import equilibrium
from symoro_elastic.pages.drawing.figure import Figure, figure_of
from symoro_elastic.pages.drawing.meshes import Mesh, meshes_of
from symoro_elastic.pages.drawing.motions import Played
from symoro_elastic.pages.drawing.placements import Placements, placements_of
from symoro_elastic.pages.drawing.vibrations import ModeSet, mode_sets

MOST_IN_MODES = 100
"""Joint variables of a machine whose modes are shown: those of 300 take minutes and gigabytes."""


@dataclass(frozen=True)
class ShownMachine:
    """A machine at q (n,): modes about it, motions, and lines about what is `missing`."""

    placements: Placements
    q: Array
    modes: Sequence[ModeSet] = ()
    motions: Sequence[Played] = ()
    missing: Sequence[str] = ()

    @cached_property
    def meshes(self) -> tuple[list[Mesh], list[str]]:
        """Meshes of bodies that lie beside the file, and lines about those that do not."""
        return meshes_of(self.placements.machine)

    @cached_property
    def figure(self) -> Figure:
        """The figure of the machine where it stands."""
        return figure_of(self.placements, self.q)

    @property
    def remarks(self) -> tuple[str, ...]:
        """Lines about what is not shown, or shown differently."""
        return (*self.figure.remarks, *self.meshes[1], *self.missing)


def shown_machine(machine: Machine, at: Mapping[str, float], motions: Sequence[Played] = ()) -> ShownMachine:
    """Return what is shown of a machine, restricted to a scene, with motors at positions, rad or m.

    It stands in equilibrium there; where none is found, values are missing, or it is too large, springs are neutral
    and a remark says why. Raises `InputError` for positions of joints that do not move by themselves, and loops that do
    not close.
    """
    placements = placements_of(machine)
    q = placements.position(at)
    if len(machine.independent) > MOST_IN_MODES:
        return ShownMachine(placements, q, (), motions, _too_large(machine))
    try:
        q, sets = _vibrating(machine, at)
    except InputError as error:
        return ShownMachine(placements, q, (), motions, (f"no modes: {error.place}: {error.what}",))
    return ShownMachine(placements, q, sets, motions)


def _too_large(machine: Machine) -> tuple[str, ...]:
    """A line for a large machine that could have modes."""
    count = len(machine.independent)
    if set(machine.independent) <= set(machine.motors):
        return ()
    return (f"no modes, springs neutral: it has {count} joint variables, and modes are shown up to {MOST_IN_MODES}",)


def _vibrating(machine: Machine, at: Mapping[str, float]) -> tuple[Array, list[ModeSet]]:
    """The position of equilibrium, and the modes about it; modes are shown only for machines with springs."""
    motion = motion_of(machine)
    state = equilibrium(motion, at, carried=bool(machine.degrees_of_base))
    sets = mode_sets(linearize(motion, state))
    vibrates = any(one.modal for one in sets) and (bool(motion.springs) or not motion.motors)
    return state.q, sets if vibrates else []
