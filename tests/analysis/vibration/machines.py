"""Small machines whose vibrations are known in closed form, and the way from a machine to its modes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from symoro_elastic.analysis.vibration.linearization import Linearization, linearize, with_motors
from symoro_elastic.analysis.vibration.modes import Modes, modes
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import Base, Body, Friction, Joint, Kind, Machine, Parameter, Spring
from symoro_elastic.numerics.motion.equations_of_motion import motion_of
from symoro_elastic.numerics.motion.equilibrium import equilibrium
from tests.compiled_models import cell, vector

ZERO = Formula.parse(0)
NO_WEIGHT = Base()
WEIGHT = Base(gravity=vector(0, 0, -9.81))


def slide(name: str, before: int, kind: Kind, mass: float | str = 0, **more: Any) -> Joint:
    """A body on a slide along z of its antecedent."""
    return Joint(name, before, kind, 1, f"q_{name}", body=Body(cell(mass)), **more)


def spring(stiffness: float | str, damping: float | str = 0, neutral: float | str = 0) -> Spring:
    return Spring(cell(stiffness), cell(damping), cell(neutral))


def machine_of(
    name: str, *joints: Joint, base: Base = NO_WEIGHT, parameters: Mapping[str, float] | None = None
) -> Machine:
    given = tuple(Parameter(key, cell(x)) for key, x in (parameters or {}).items())
    return Machine(name, joints, given, base, source=f"{name}.toml")


def drive(m1: float = 3.0, m2: float = 5.0, k: float | str = 2e4, d: float = 0.0, friction: float = 0.0) -> Machine:
    """Two masses on one line, a spring between: motor and load."""
    motor = slide("motor", 0, Kind.MOTOR, m1, friction=Friction(cell(friction)))
    return machine_of("drive", motor, slide("load", 1, Kind.ELASTIC, m2, spring=spring(k, d)))


def twins(k1: float | str = 1e4, k2: float | str = 1e4, **more: Any) -> Machine:
    """Two equal masses on springs of their own, at right angles on a turntable: one frequency twice, at any angle."""
    table = Joint("table", 0, Kind.MOTOR, 0, "q_table", rotor_inertia=cell(50))
    one = slide("one", 1, Kind.ELASTIC, 4, alpha=cell("pi/2"), theta=ZERO, spring=spring(k1))
    other = slide("other", 1, Kind.ELASTIC, 4, gamma=cell("pi/2"), alpha=cell("pi/2"), theta=ZERO, spring=spring(k2))
    return machine_of("twins", table, one, other, **more)


def crossing() -> Machine:
    """An elastic turn that a motor loads at a radius, and a spring beside it: their frequencies cross at 0.5 m.

    sqrt(k/(m r^2)) against sqrt(K/M): 1e4/(4 r^2) = 1e4 at r = 0.5.
    """
    turn = Joint("turn", 0, Kind.ELASTIC, 0, "q_turn", spring=spring(1e4))
    radius = slide("radius", 1, Kind.MOTOR, 4, alpha=cell("pi/2"))
    return machine_of("crossing", turn, radius, slide("beside", 0, Kind.ELASTIC, 2, spring=spring(2e4)))


def linearized(
    machine: Machine, at: Mapping[str, float] | None = None, ins: Sequence[str] = (), outs: Sequence[str] = (),
    held: Sequence[str] = (), values: Mapping[str, float] | None = None,
    gains: Mapping[str, tuple[float, float]] | None = None,
) -> Linearization:  # fmt: skip
    motion = motion_of(machine, values, ins, outs)
    linear = linearize(motion, equilibrium(motion, at), ins or None, outs or None)
    return with_motors(linear, held, gains)


def modes_of(machine: Machine, at: Mapping[str, float] | None = None, **more: Any) -> Modes:
    return modes(linearized(machine, at, **more))
