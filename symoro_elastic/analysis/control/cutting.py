"""Cutting force by the tool's deflection: F = K b W (y(t) - y(t - T)), in turning and in milling.

y are the deflections, K the tangential coefficient, b the depth, T the time between teeth. In turning W = -1: the force
along one direction by the thickness of the chip. In milling x is the feed and y is across it; a tooth is at the angle
phi from y towards x, its chip gets thicker along rho = (sin phi, cos phi), it moves along tau = (cos phi, -sin phi):

    W(phi) = -sum over teeth that cut (tau + K_r/K rho) rho^T

Teeth cut from phi = 0 to arccos(1 - 2 a/D) in up-milling, from arccos(2 a/D - 1) to pi in down-milling, a/D being the
radial immersion (Altintas and Budak 1995; Insperger and Stepan 2004). The mean of W over a turn is that of their
zeroth-order theory.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import InputError, reported_places
from symoro_elastic.machine.frames import with_base_coordinates
from symoro_elastic.machine.machine import Machine
from symoro_elastic.numerics.motion.signals import FrameSignal, Signal, output_unit, outputs

PER_TURN = 60.0
"""Seconds in a minute: speeds are in turns per minute."""


@dataclass(frozen=True)
class Milling:
    """Output `across` the feed, radial coefficient, N/m2, radial immersion a/D, and whether it is climb milling."""

    across: str
    radial: float
    immersion: float = 1.0
    down: bool = False

    @property
    def angles(self) -> tuple[float, float]:
        """Angles at which a tooth enters and leaves the workpiece, rad."""
        swept = float(np.arccos(1 - 2 * self.immersion))
        return (np.pi - swept, np.pi) if self.down else (0.0, swept)


@dataclass(frozen=True)
class Cut:
    """Tangential coefficient, N/m2, teeth; the outputs along which the force acts and the chip thickens.

    With `milling`, `direction` is the output along the feed, and `thickness` is not used. An output with a minus in
    front, -tool.x, is that of the opposite sense.
    """

    coefficient: float
    teeth: int
    direction: str
    thickness: str
    milling: Milling | None = None

    @property
    def forces(self) -> tuple[str, ...]:
        """Outputs along which forces act, with their signs."""
        return (self.direction, self.milling.across) if self.milling else (self.direction,)

    @property
    def deflections(self) -> tuple[str, ...]:
        """Outputs whose deflections change the chip thickness, with their signs."""
        return self.forces if self.milling else (self.thickness,)

    @property
    def outputs(self) -> tuple[str, ...]:
        """Names of all outputs, without signs."""
        return tuple(sign_and_name(name)[1] for name in (*self.forces, *self.deflections))

    def period(self, speed: float) -> float:
        """Return the time between teeth, s, at a speed in turns per minute."""
        return PER_TURN / (self.teeth * speed)

    def factors(self, intervals: int = 1) -> Array:
        """Return means (intervals, m, m) of the cutting matrix W over equal parts of a tooth period from phi = 0."""
        if not self.milling:
            return np.full((intervals, 1, 1), -1.0)
        pitch = 2 * np.pi / self.teeth
        teeth = pitch * np.arange(self.teeth)
        ends = np.clip(teeth + np.linspace(0, pitch, intervals + 1)[:, None], *self.milling.angles)
        passed = _integral(ends, self.milling.radial / self.coefficient).sum(axis=1)
        return np.asarray(np.diff(passed, axis=0) * intervals / pitch)


def _integral(phi: Array, ratio: float) -> Array:
    """Return the integral of -(tau + ratio rho) rho^T over phi, (..., 2, 2)."""
    half, double = phi / 2, np.sin(2 * phi) / 4
    ss, cc, sc = half - double, half + double, -np.cos(2 * phi) / 4
    rows = [[sc + ratio * ss, cc + ratio * sc], [ratio * sc - ss, ratio * cc - sc]]
    return -np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def refuse_wrong(cut: Cut, speeds: Array, machine: Machine) -> None:
    """Raise `InputError` for impossible numbers of a cut, and for speeds that are not positive."""
    source = machine.label
    along = _signal(machine, "--direction", cut.direction)
    if cut.milling:
        across = _signal(machine, "--across", cut.milling.across)
        components = [x.component for x in (along, across) if isinstance(x, FrameSignal)]
        if across == along or (len(components) == 2 and components[0] == components[1]):
            what = f"{across.name} is along {along.name}, the feed: name an output at right angles to it"
            raise InputError(source, "--across", what)
    else:
        _signal(machine, "--thickness", cut.thickness)
    if not (cut.coefficient > 0 and np.isfinite(cut.coefficient)):
        raise InputError(source, "--cutting", f"{cut.coefficient:g} N/m2 is not above zero: steel has some 2e9")
    if cut.milling and not np.isfinite(cut.milling.radial):
        raise InputError(source, "--radial", f"{cut.milling.radial:g} N/m2 is not a coefficient")
    if not (len(speeds) and (speeds > 0).all() and np.isfinite(speeds).all()):
        raise InputError(source, "--speeds", "spindle speeds are numbers above zero, turns per minute")


def sign_and_name(name: str) -> tuple[float, str]:
    """Return the sign of an output, -1 with a leading minus, and its name."""
    name = name.strip()
    return (-1.0, name[1:].strip()) if name.startswith("-") else (1.0, name)


def _signal(machine: Machine, option: str, name: str) -> Signal:
    """Return the displacement that an option names; raises `InputError` for velocities and rotations."""
    machine, name = with_base_coordinates(machine), sign_and_name(name)[1]
    with reported_places({"--output": option}):
        (signal,) = outputs(machine, [name])
        if output_unit(machine, name) != "m":
            what = f"{signal.name} is not a displacement in m: name one, such as tool.x"
            raise InputError(machine.label, option, what)
    return signal
