"""Compliance of a frame under forces and moments on it, motors held, and the shares of springs in it.

    C = J K^-1 J^T,    S = C^-1,    u = K^-1 J^T w,    share of a spring = its strain energy over w^T C w / 2

K is the stiffness of springs, gravity and loads in the equilibrium, J the Jacobian of the frame, w a unit force or
moment in axes of frame 0. The worst direction is the one in which a unit force moves the frame most.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from symoro_elastic.analysis.vibration.linearization import Linearization
from symoro_elastic.analysis.vibration.point_stiffness import spring_shares
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.results import Result
from symoro_elastic.quantities.units import MICRO

COMPONENTS = ("x", "y", "z", "rx", "ry", "rz")
FORCES = ("fx", "fy", "fz", "mx", "my", "mz")
RIGID = 1e-10
"""Ratio to the largest deflection below which a deflection is rounding."""
STIFFER = 0.1
"""Relative increase of a spring's stiffness in the advice."""


@dataclass(frozen=True, repr=False)
class FrameStiffness(Result):
    """Compliance (6, 6) of a frame, m/N, rad/N, m/(N m), rad/(N m), in axes of frame 0, motors held.

    `shares` are those of springs in the strain energy under a unit force in the `worst` direction (3,), the largest
    first, `shares_by_axis` under unit forces and moments along each axis. `at` are the positions by joint.
    """

    machine: str
    frame_name: str
    at: Mapping[str, float]
    compliance: Array
    worst: Array
    shares: Mapping[str, float]
    shares_by_axis: Mapping[str, Mapping[str, float]] = field(repr=False)

    @property
    def stiffness(self) -> Array:
        """The inverse (6, 6), N/m, N/rad, N m/m, N m/rad; NaN for rigid axes.

        NaN everywhere where a combination of the other axes bends no spring: that stiffness has no bound.
        """
        root = np.sqrt(np.diagonal(self.compliance))
        yields = np.flatnonzero(root > RIGID * root.max(initial=0.0))
        stiffness: Array = np.full(self.compliance.shape, np.nan)
        scaled = self.compliance[np.ix_(yields, yields)] / np.outer(root[yields], root[yields])
        if len(yields) and np.linalg.cond(scaled) < 1 / RIGID:
            stiffness[np.ix_(yields, yields)] = np.linalg.inv(scaled) / np.outer(root[yields], root[yields])
        return stiffness

    @property
    def worst_compliance(self) -> float:
        """The largest displacement by a unit force, m/N."""
        return float(self.worst @ self.compliance[:3, :3] @ self.worst)

    @property
    def least_stiffness(self) -> float:
        """The stiffness in the worst direction, N/m; infinite for a rigid frame."""
        return 1 / self.worst_compliance if self.worst_compliance > 0 else np.inf

    @property
    def headline(self) -> str:
        """Machine, frame, least stiffness."""
        least = f"at least {self.least_stiffness / MICRO:.3g} N/um" if self.worst_compliance > 0 else "rigid"
        return f"Stiffness of {self.frame_name} of {self.machine}: {least}"

    @property
    def advice(self) -> str:
        """The effect of stiffening the spring with the largest share, as a sentence."""
        if not self.shares:
            return "no spring yields to a force on this frame"
        name, share = next(iter(self.shares.items()))
        less = share * (1 - 1 / (1 + STIFFER))
        return f"stiffen {name} first: {STIFFER:.0%} more lower the compliance in the worst direction by {less:.1%}"


@dataclass(frozen=True, repr=False)
class StiffnessMap(Result):
    """The stiffness of a frame at several positions."""

    points: tuple[FrameStiffness, ...]

    @property
    def headline(self) -> str:
        """The range of the stiffness in the worst direction over the positions, as a sentence."""
        least, first = [x.least_stiffness / MICRO for x in self.points], self.points[0]
        if min(least) == np.inf:
            return first.headline
        return f"Stiffness of {first.frame_name} of {first.machine}: at least {min(least):.3g} to {max(least):.3g} N/um"


def signals_of(frame: str) -> tuple[list[str], list[str]]:
    """Return the inputs and outputs of a linear model that the stiffness of a frame needs."""
    return [f"{frame}.{name}" for name in FORCES], [f"{frame}.{name}" for name in COMPONENTS]


def frame_stiffness(linear: Linearization, frame: str, at: Mapping[str, float]) -> FrameStiffness:
    """Return the stiffness of a frame by a model with the signals of `signals_of`, motors held.

    Raises `InputError` for machines without springs, and where a joint moves freely.
    """
    machine, names = linear.motion.given, linear.coordinates
    if not names:
        raise machine.error("springs", "every joint is held by a motor or locked: nothing yields to a force")
    values, shapes = np.linalg.eigh((linear.K + linear.K.T) / 2)
    if values.min() <= np.finfo(float).eps * len(names) * np.abs(values).max():
        free = names[int(np.abs(shapes[:, 0]).argmax())]
        raise machine.error(f"joint {free}", "it moves freely under a force: hold or lock it, or give it a spring")
    moved = np.linalg.solve(linear.K, linear.F)
    compliance = linear.Cq @ moved
    compliance = (compliance + compliance.T) / 2
    _, vectors = np.linalg.eigh(compliance[:3, :3])
    worst = vectors[:, -1] * np.sign(vectors[np.abs(vectors[:, -1]).argmax(), -1])
    by_axis = {name: spring_shares(linear, moved[:, k]) for k, name in enumerate(COMPONENTS)}
    shares = spring_shares(linear, moved[:, :3] @ worst)
    return FrameStiffness(machine.name, frame, dict(at), compliance, worst, shares, by_axis)
