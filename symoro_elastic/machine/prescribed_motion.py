"""A motion that is prescribed to the motors of a machine, and forces on it meanwhile. SI units, radians.

Nothing here computes a motion: `simulation.reference` does.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

from symoro_elastic.foundation.errors import InputError

WRENCH = ("fx", "fy", "fz", "mx", "my", "mz")
"""Components of a force (N) and a moment (N m)."""


@dataclass(frozen=True)
class Move:
    """A motor moves `by` rad or m from rest to rest: it begins at `begins` and lasts `lasts` s."""

    motor: str
    by: float
    begins: float
    lasts: float


@dataclass(frozen=True)
class Wobble:
    """A motor moves by amplitude (rad or m) times sin(2 pi frequency t), frequency in Hz.

    It is faded in over its first period and out over its last, so that it begins and ends at rest.
    """

    motor: str
    amplitude: float
    frequency: float


@dataclass(frozen=True)
class Gains:
    """A servo by its gains: tau = kp (y - q) + kd (yd - qd), kp in N m/rad or N/m, kd in N m s/rad or N s/m."""

    kp: float
    kd: float


@dataclass(frozen=True)
class Bandwidth:
    """A servo by its frequency (Hz) and damping ratio with springs locked."""

    frequency: float
    damping: float


Servo = Gains | Bandwidth


@dataclass(frozen=True)
class AppliedForce:
    """A wrench on frame `at`, in axes of frame 0, `WRENCH` in N and N m.

    It rises smoothly from the time `begins` within `lasts` s, then stays.
    """

    at: str
    wrench: tuple[float, ...]
    begins: float
    lasts: float


@dataclass(frozen=True)
class BaseStart:
    """Initial pose and velocity of a floating base, and a constant wrench on it.

    `position` of its origin in the world, m. `orientation` is a quaternion w x y z or a rotation to axes of the world,
    row by row. `velocity` (m/s, rad/s) and `wrench` (N, N m; weight is not included) have six entries each, in axes
    of the base.
    """

    position: tuple[float, ...] = (0.0,) * 3
    orientation: tuple[float, ...] = (1.0, 0.0, 0.0, 0.0)
    velocity: tuple[float, ...] = (0.0,) * 6
    wrench: tuple[float, ...] = (0.0,) * 6


@dataclass(frozen=True)
class PrescribedMotion:
    """Motion of the motors over `duration` s: the sum of moves, wobbles and the record in `file`.

    `start` gives joints (motors, or others where the search for the equilibrium begins) their position, rad or m.
    `servo` maps motors to their servos; where it is empty, motors follow exactly, or have the drives of the machine if
    `drives`. `base` is None where the file says
    nothing of a floating base. `source` is the file, and
    `place` the table in it, in which the motion stands.
    """

    duration: float
    start: dict[str, float] = field(default_factory=dict)
    moves: tuple[Move, ...] = ()
    wobbles: tuple[Wobble, ...] = ()
    file: str = ""
    servo: dict[str, Servo] = field(default_factory=dict)
    drives: bool = False
    forces: tuple[AppliedForce, ...] = ()
    base: BaseStart | None = None
    source: str = field(default="", compare=False)
    place: str = field(default="motion", compare=False)

    def error(self, key: str, what: str) -> InputError:
        """The error to raise about one key of the motion."""
        return InputError(self.source, f"{self.place}, {key}", what)

    @property
    def path(self) -> Path:
        """The record: `file`, in the folder of the motion's file."""
        return Path(self.source).parent / self.file
