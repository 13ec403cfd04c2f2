"""Springs that no motor torque makes follow: held at their neutral positions by feed-forward, and what that costs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from symoro_elastic.analysis.vibration.linearization import linearize, with_motors
from symoro_elastic.analysis.vibration.modes import modes
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.machine import Kind, Machine
from symoro_elastic.machine.restrict import restrict
from symoro_elastic.machine.scene import Scene
from symoro_elastic.numerics.motion.equations_of_motion import EquationsOfMotion
from symoro_elastic.numerics.motion.equilibrium import equilibrium

MOST_PLACES = 200


@dataclass(frozen=True)
class LeftOut:
    """Springs that are left out: by name the largest deflection that loads of the motion give, rad or m.

    The deflection is that of a load that changes slowly. `frequency` is the lowest that these springs vibrate at, Hz,
    with all else held, at the start; None where there is none.
    """

    deflections: Mapping[str, float]
    units: Mapping[str, str]
    frequency: float | None


def with_springs_held(machine: Machine, names: list[str]) -> Machine:
    """Return the machine with these springs at their neutral positions."""
    if not names:
        return machine
    return restrict(machine, Scene(locked={j.name: j.spring.neutral for j in machine.joints if j.name in names}))


def cost(machine: Machine, names: list[str], t: Array, q: Array, qd: Array) -> LeftOut | None:
    """Return what it costs to leave springs out on a motion, t (N,), q and qd (N, n) of all moving joints."""
    if not names:
        return None
    motion = EquationsOfMotion(machine)
    rows = [motion.names.index(name) for name in names]
    qdd = np.gradient(qd, t, axis=0)
    places = np.unique(np.linspace(0, len(t) - 1, MOST_PLACES).astype(int))
    loads = np.array([motion.forces(q[k], qd[k], qdd[k])[rows] for k in places])
    stiffness = dict(zip(motion.springs, motion.spring_stiffnesses(q[0]), strict=True))
    bent = np.abs(loads).max(axis=0) / [stiffness[name] for name in names]
    units = {name: motion.joints[row].unit for name, row in zip(names, rows, strict=True)}
    return LeftOut(dict(zip(names, bent.tolist(), strict=True)), units, _frequency(machine, names, q[0], motion.names))


def _frequency(machine: Machine, names: list[str], start: Array, joints: list[str]) -> float | None:
    """Return the lowest frequency of springs with all other joints held, Hz."""
    others = [j.name for j in machine.joints if j.kind is Kind.ELASTIC and j.name not in names]
    motion = EquationsOfMotion(with_springs_held(machine, others))
    motors = [motion.names[k] for k in motion.motors]
    at = {name: float(start[joints.index(name)]) for name in motors}
    try:
        state = equilibrium(motion, at)
        frequencies = modes(with_motors(linearize(motion, state, (), ()), motors)).frequencies
    except InputError:
        return None
    return float(frequencies[frequencies > 0].min()) if (frequencies > 0).any() else None


def line(cost: LeftOut) -> str:
    """Return a line that names the springs and what leaving them out costs."""
    bent = ", ".join(f"{name} {x:.3g} {cost.units[name]}" for name, x in cost.deflections.items())
    said = "no motor controls these springs, so they are held at their neutral positions; the loads of this "
    said += f"motion would bend them by {bent}"
    return said if cost.frequency is None else f"{said}; they vibrate from {cost.frequency:.4g} Hz"
