"""Motions of motors to try predictions on."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from symoro_elastic.analysis.simulation.reference_motion import Reference, reference_of
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.prescribed_motion import AppliedForce, Move, PrescribedMotion, Servo


def moved(
    machine: Machine,
    duration: float,
    moves: Mapping[str, tuple[float, float]],
    start: Mapping[str, float] | None = None,
    servo: Mapping[str, Servo] | None = None,
    forces: Sequence[AppliedForce] = (),
) -> Reference:
    """Each motor by so much in so many s, from 0."""
    rows = tuple(Move(name, by, 0.0, lasts) for name, (by, lasts) in moves.items())
    given = PrescribedMotion(duration, dict(start or {}), rows, servo=dict(servo or {}), forces=tuple(forces))
    return reference_of(machine, given)
