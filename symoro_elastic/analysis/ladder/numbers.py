"""What it costs to leave numbers of bodies and rotors out of a motion, and springs at rest that are held as neutral.

A number p that is zero changes the forces that a motion takes by ID(q, v, a; p) - ID(q, v, a; 0), a spring that is held
at its neutral position q0 instead of where the motion starts by ID(q) - ID(q0), its own force apart. The difference
drives the linear model of the motion as R does, so outputs change by the response to it: of the first order in what is
left out, with its sign, at the states that the machine goes through. Forces on frames are the same in both.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from symoro_elastic.analysis.simulation.prediction.path import LinearPath
from symoro_elastic.analysis.simulation.prediction.spring_errors import Deviations
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.scalar import Scalar
from symoro_elastic.machine.columns import with_cells
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import Joint, Machine, Parameter
from symoro_elastic.machine.zeroed import name_of, numbers_of
from symoro_elastic.numerics.arrays import values_along
from symoro_elastic.numerics.motion.equations_of_motion import EquationsOfMotion

LEAST_INERTIA = 0.5
"""Of the inertia that a motion sees along any combination of joints: how much stays of it."""


class LeftOutNumbers:
    """Changes of outputs along one motion where numbers are left out."""

    def __init__(self, path: LinearPath) -> None:
        self.path = path
        machine = path.reference.machine
        for j in machine.loaded:
            what = "a budget does not know how numbers change the torque that passes: leave load out, or the budget"
            raise machine.error(f"friction, {machine.joint(j).name}, load", what)
        named, self._symbols = with_symbols(machine)
        self.numbers = tuple(self._symbols)
        self._motion = EquationsOfMotion(named)
        self._joints = tuple(self._motion.names)
        neutral = [joint.spring.neutral.value(self._motion.parameters) for joint in machine.independent_joints]
        shifts = np.array(neutral) - path.reference.start.q
        self.neutral = {path.joints[k]: float(shifts[k]) for k in path.springs if shifts[k]}
        """By spring: from where the motion starts to its neutral position, rad or m."""

    def changes(self, sets: Sequence[Collection[str]], left_out: Collection[str]) -> Array:
        """Return the changes of outputs (N, sets, outputs) where springs and parts of drives follow, for each set.

        A name is that of a number, which is zero, or of a static spring, which is held at its neutral position.
        """
        path, springs = self.path.following(left_out)
        motion, n = path.driven_by(path.R[:, None], springs), len(self._joints)
        small = (motion.d, motion.dd, motion.ddd)
        states = [x[:, :n] + d[:, 0, :n] for x, d in zip(path.states(path.t), small, strict=True)]
        exact = self._forces(states, ())
        forces = np.stack([exact - self._forces(states, names) for names in sets], axis=1)
        more = len(path.joints) - n
        return Deviations(path).under(np.pad(forces, ((0, 0), (0, 0), (0, more))), springs)

    def has_inertia(self, names: Collection[str], left_out: Collection[str]) -> bool:
        """Whether enough of the inertia matrix is left along the motion."""
        rows = [k for k, name in enumerate(self._joints) if name not in left_out]
        whole, left = (self._inertia(x)[:, rows][:, :, rows] for x in ((), names))
        return bool((np.linalg.eigvalsh(left - LEAST_INERTIA * whole) >= 0).all())

    def _forces(self, states: Sequence[Array], names: Collection[str]) -> Array:
        """Return ID (N, n), less the forces of springs that are held at their neutral positions."""
        q, v, a = states
        shift = np.array([self.neutral[name] if name in names else 0.0 for name in self._joints])
        rows = self._values(self._motion.residual, (q + shift, v, a), names)
        forces: Array = rows - self.path.stiffness[: len(shift)] * shift
        return forces

    def _inertia(self, names: Collection[str]) -> Array:
        """Return M (N, n, n) along the reference."""
        n = len(self._joints)
        (M,) = (output.entries for output in self._motion.linear_model.outputs if output.name == "M")
        states = [x[:, :n] for x in self.path.states(self.path.t)]
        return self._values(M, states, names).reshape(-1, n, n)

    def _values(self, roots: Sequence[Scalar], states: Sequence[Array], names: Collection[str]) -> Array:
        """Return values of expressions (N, roots) at states, the numbers named being zero."""
        bound, zero = self._motion.bound, {self._symbols[name] for name in names if name in self._symbols}
        symbols: dict[str, Any] = {name: 0.0 if name in zero else x for name, x in self._motion.parameters.items()}
        for by_joint, block in zip((bound.q, bound.qd, bound.qdd), states, strict=True):
            symbols |= {str(x.operands[0]): row for x, row in zip(by_joint.values(), block.T, strict=True)}
        return values_along(roots, symbols, len(self.path.t)).T


def with_symbols(machine: Machine) -> tuple[Machine, dict[str, str]]:
    """Return the machine whose numbers of bodies and rotors are parameters, and these by the names of the numbers."""
    numbers, used = numbers_of(machine), {parameter.name for parameter in machine.parameters}
    stem = next(x for x in ("number", *(f"number{k}_" for k in range(len(used) + 1))) if f"{x}1" not in used)
    symbols = {name: f"{stem}{k}" for k, name in enumerate(numbers, 1)}
    values = {p.name: p.value.value() for p in machine.parameters if p.value is not None}
    new = tuple(Parameter(symbols[name], Formula.parse(x.value(values))) for name, x in numbers.items())
    joints = tuple(_with_symbols(joint, symbols) for joint in machine.joints)
    return replace(machine, joints=joints, parameters=(*machine.parameters, *new)), symbols


def _with_symbols(joint: Joint, symbols: Mapping[str, str]) -> Joint:
    names = {name: Formula.parse(symbol) for name, symbol in symbols.items()}
    return with_cells(joint, lambda cell, x: names.get(name_of(joint, cell), x))
