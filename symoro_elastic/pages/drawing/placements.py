"""Where the frames of a machine are: their placements at positions, as numbers and as a program for a page."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.machine.checks import parameter_values
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.free_base import with_base_coordinates
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.scene import ALL, Scene
from symoro_elastic.models.catalogue import trace
from symoro_elastic.models.joint_axes import placed_machine
from symoro_elastic.models.state import State, closing_models
from symoro_elastic.models.traced import trace_models
from symoro_elastic.numerics.closed_positions import drawn_values, with_dependent
from symoro_elastic.numerics.independent_joints import with_independent_motors
from symoro_elastic.symbolic.arithmetic import FLOATS, evaluate_nodes
from symoro_elastic.symbolic.program import Program

STAND_IN = 1.0
"""Length, m, or angle, rad, that is drawn where the machine gives none."""


@dataclass(frozen=True)
class Placements:
    """Placements of the frames of `machine`, which has coordinates for its base and motors that are independent.

    `not_given` are the parameters of its geometry that have no value; stand-ins are drawn for them.
    """

    machine: Machine
    not_given: tuple[str, ...]

    @cached_property
    def programs(self) -> dict[str, Program]:
        """The programs of its frames by the name of their model; `assemble` is one where loops have no closed form."""
        models = ("geometric_model", *closing_models(self.machine))
        programs = trace_models(self.machine, Scene(models=models, fold=ALL)).models
        return {one.model.name: one.program for one in programs}

    @cached_property
    def start(self) -> Array:
        """q (n,) with springs neutral, loops at their start, and other joints at zero, rad or m."""
        return self.position({})

    def position(self, at: Mapping[str, float]) -> Array:
        """Return q (n,) with joints at given positions, rad or m, else where they start; raises `InputError`."""
        placed = placed_machine(self.machine, at).q
        found = np.array([placed[joint.name] for joint in self.machine.independent_joints], dtype=float)
        return np.where(np.isnan(found), 0.0, found)

    def closed(self, q: Array) -> State:
        """Return all blocks of the position q (n,), NaN where the loops do not close."""
        return with_dependent(self.machine, State({"q": q[None]}), parameter_values(self.machine))[0]

    @property
    def _not_there(self) -> str:
        """Why frames are nowhere at a position."""
        loops = ", ".join(loop.name for loop in self.machine.loops)
        if loops:
            return f"loop {loops} does not close there: give another position"
        return "frames are out of the range of numbers there: check lengths and their units"

    def at(self, q: Array) -> Array:
        """Return the placements (1 + rows, 4, 4) of frame 0 and of the rows at q (n,) in frame 0, lengths in m.

        Raises `InputError` where a loop does not close.
        """
        program = self.programs["geometric_model"]
        state = self.closed(q)
        symbols: dict[str, float] = {}
        for block in program.inputs:
            symbols |= zip(block.symbols, map(float, getattr(state, block.name)), strict=True)
        try:
            value = evaluate_nodes(program.nodes, symbols, FLOATS)
            T = np.array([float(value(x)) for x in program.outputs[0].entries]).reshape(-1, 4, 4)
        except (ArithmeticError, ValueError):
            T = np.full((1, 4, 4), math.nan)
        if not np.isfinite(T).all():
            raise self.machine.error("--at", self._not_there)
        return np.concatenate([np.eye(4)[None], T])


def placements_of(machine: Machine) -> Placements:
    """Return the placements of a machine that a scene has restricted; raises `InputError`."""
    machine = with_base_coordinates(machine)
    missing = _missing(machine)
    if missing:
        machine = _with_stand_ins(machine, missing)
    return Placements(with_independent_motors(machine), missing)


def _missing(machine: Machine) -> tuple[str, ...]:
    """Parameters without value on which the places of frames depend."""
    without = [p.name for p in machine.parameters if p.value is None]
    used = trace(machine, "geometric_model").program.used if without else frozenset()
    return tuple(name for name in without if name in used)


def _with_stand_ins(machine: Machine, names: Sequence[str]) -> Machine:
    """The machine with values for these parameters of its geometry; those with which its loops close."""
    values = drawn_values(machine) if machine.loops else dict.fromkeys(names, STAND_IN)
    parameters = (replace(p, value=Formula.parse(values[p.name])) if p.name in names else p for p in machine.parameters)
    return replace(machine, parameters=tuple(parameters))
