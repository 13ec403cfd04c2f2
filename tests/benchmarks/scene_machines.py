"""The machine of the benchmarks of time steps: stiffness and damping of springs are parameters, its tool moves."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from symoro_elastic.analysis.simulation.reference_motion import Reference, reference_of
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import Machine, Parameter, Spring
from symoro_elastic.machine.prescribed_motion import Bandwidth, Move, PrescribedMotion
from symoro_elastic.numerics.verification.implementations import numpy_model
from tests.analysis.ladder.scenes import two_axis

TIMES = 201
"""Times at which motions are compared."""
DURATION, LASTS = 0.05, 0.04


@dataclass(frozen=True)
class Stiffer:
    """A machine with springs so many times as stiff, each alone at a damping ratio; numbers are parameters or not."""

    machine: Machine
    times: float
    damping: float

    @property
    def values(self) -> dict[str, float]:
        """Those of the parameters of `with_parameters`."""
        found = {p.name: p.value.value() for p in self.machine.parameters if p.value is not None}
        inertia = _inertia(self.machine)
        for name, k in _stiffness(self.machine).items():
            found[f"K_{name}"] = self.times * k
            found[f"C_{name}"] = 2 * self.damping * float(np.sqrt(self.times * k * inertia[name]))
        return found

    @property
    def numbers(self) -> Machine:
        """The machine with all numbers in its table."""
        return replace(
            self.with_parameters,
            parameters=tuple(
                replace(p, value=Formula.parse(self.values[p.name])) for p in self.with_parameters.parameters
            ),
        )

    @cached_property
    def with_parameters(self) -> Machine:
        springs = _stiffness(self.machine)
        joints = tuple(
            replace(j, spring=Spring(Formula.parse(f"K_{j.name}"), Formula.parse(f"C_{j.name}")))
            if j.name in springs
            else j
            for j in self.machine.joints
        )
        more = tuple(Parameter(f"{letter}_{name}", Formula.parse(1)) for name in springs for letter in "KC")
        return replace(self.machine, joints=joints, parameters=(*self.machine.parameters, *more))


def _stiffness(machine: Machine) -> dict[str, float]:
    return {j.name: j.spring.stiffness.value() for j in machine.joints if j.spring.stiffness.value()}


def _inertia(machine: Machine) -> dict[str, float]:
    n = len(machine.independent)
    A = numpy_model(machine, ("inertia_matrix",)).inertia_matrix(np.zeros(n))
    return dict(zip((joint.name for joint in machine.independent_joints), np.diag(A).tolist(), strict=True))


def tool_moves(machine: Machine, values: Mapping[str, float] | None = None) -> Reference:
    """The two-axis machine under servos: 10 x 6 mm in 40 of 50 ms."""
    moves = (Move("motor_x", 0.01, 0.0, LASTS), Move("motor_y", 0.006, 0.0, LASTS))
    servo = {joint.name: Bandwidth(25, 0.8) for joint in machine.motor_joints}
    motion = PrescribedMotion(DURATION, {"motor_x": 0.0, "motor_y": 0.1}, moves, servo=dict(servo))
    return reference_of(machine, motion, values)


def stiffer_tool(times: float, damping: float = 0.0) -> Stiffer:
    return Stiffer(two_axis(), times, damping)


class Tool:
    """Positions of the tool (N, 2) of a motion, at even times whatever its steps are: cubics between them."""

    def __init__(self) -> None:
        self.model = numpy_model(two_axis(), ("geometric_model",), {"geometric_model": ("tool",)})

    def positions(self, t: Array, q: Array, qd: Array) -> Array:
        from scipy.interpolate import CubicHermiteSpline

        even = np.linspace(0.0, t[-1], TIMES)
        with np.errstate(all="ignore"):
            if not (np.isfinite(q).all() and np.isfinite(qd).all()):
                return np.full((TIMES, 2), np.inf)
            placed = CubicHermiteSpline(t, q, qd)(even)
            found: Array = self.model.geometric_model(placed)[:, 0, :2, 3]
        return found
