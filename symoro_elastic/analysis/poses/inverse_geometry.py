"""Positions of the joints at which a frame has a pose, by damped least squares from several starts.

    minimize |x(q) - x*|^2 + L^2 |log(R(q) R*^T)|^2    within the limits of joints

x and R are position and orientation of the frame, L a length of the machine that makes angles comparable, log the
rotation vector. Where a closed form of the inverse geometric model exists its branches are starts, too. Joints that do
not change the pose stay near the given position: of a redundant machine each solution is one of a family.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.packages import for_vibrations
from symoro_elastic.foundation.results import Result

Model = Callable[[Array], Array]
REACHED = 1e-9
"""m, and rad times the length of the machine: residual of a solution."""
SAME = 1e-6
"""rad or m: two solutions that are one."""
SINGULAR = 1e-6
"""Ratio of singular values of the Jacobian below which a direction is lost."""
EVALUATIONS = 200
"""Of the model from one start."""


@dataclass(frozen=True)
class Pose:
    """A wanted pose in frame 0: position (3,), m, and orientation (3, 3), None where it is free."""

    position: Array
    orientation: Array | None = None


@dataclass(frozen=True)
class Reached:
    """One solution: positions by joint, joints at their limits, and whether the position is singular for the frame."""

    joints: Mapping[str, float]
    at_limits: tuple[str, ...]
    is_singular: bool


@dataclass(frozen=True, repr=False)
class InverseGeometry(Result):
    """Solutions for a pose, the nearest to the start position first, or the residual of the best attempt.

    `redundant` is the number of motions of the joints that leave the pose. `miss` is the distance, m, and `turned` the
    angle, rad, that remain without a solution. `starts` is the number of starts.
    """

    machine: str
    frame_name: str
    pose: Pose = field(repr=False)
    units: Mapping[str, str] = field(repr=False)
    solutions: tuple[Reached, ...]
    redundant: int
    miss: float
    turned: float
    nearest: Mapping[str, float]
    starts: int

    @property
    def headline(self) -> str:
        """Machine, frame and number of solutions."""
        return f"{self.machine}: {len(self.solutions)} solutions for {self.frame_name}"


@dataclass(frozen=True)
class Chain:
    """A frame of a machine: its homogeneous matrix (4, 4) and Jacobian (6, n) by positions q (n,) of the joints.

    `moved` are the entries of q that may change, between `low` and `high` (n,), infinite without a limit; searches
    start within `ranges` (n, 2). `length` makes angles comparable.
    """

    names: tuple[str, ...]
    matrix: Model
    jacobian: Model
    moved: tuple[int, ...]
    low: Array
    high: Array
    ranges: Array
    length: float
    angles: tuple[bool, ...]

    def error(self, q: Array, pose: Pose) -> Array:
        """Return the pose error: x - x* (3,), and L times the rotation vector (3,) if an orientation is required."""
        T = self.matrix(q)
        apart = T[:3, 3] - pose.position
        if pose.orientation is None:
            return apart
        rotation = for_vibrations("scipy.spatial.transform").Rotation
        turned = rotation.from_matrix(T[:3, :3] @ pose.orientation.T).as_rotvec()
        return np.concatenate([apart, self.length * turned])

    def slopes(self, q: Array, pose: Pose) -> Array:
        """Return the Jacobian of the pose error by the joints that may change, exact where the error is zero."""
        J = self.jacobian(q)[:, list(self.moved)]
        return J[:3] if pose.orientation is None else np.vstack([J[:3], self.length * J[3:]])


def solve(
    chain: Chain, pose: Pose, near: Array, starts: int, closed: Sequence[Array] = (), seed: int = 0
) -> tuple[list[Reached], int, Array]:
    """Return distinct solutions, the number of joint motions that keep the pose, and the best position found."""
    tries = [_from(chain, pose, start) for start in _starts(chain, near, starts, closed, seed)]
    errors = [float(np.abs(chain.error(q, pose)).max()) for q in tries]
    solved = [q for q, error in zip(tries, errors, strict=True) if error <= REACHED * max(1.0, chain.length)]
    distinct: list[Array] = []
    for q in sorted(solved, key=lambda q: float(np.linalg.norm(_apart(chain, q, near)))):
        if all(np.abs(_apart(chain, q, other)).max() > SAME for other in distinct):
            distinct.append(q)
    nearest = tries[int(np.argmin(errors))]
    free = len(chain.moved) - _rank(chain.slopes(distinct[0] if distinct else nearest, pose))
    if free and distinct:
        distinct = distinct[:1]
    return [_solution(chain, pose, q) for q in distinct], free, nearest


def _starts(chain: Chain, near: Array, count: int, closed: Sequence[Array], seed: int) -> list[Array]:
    """Return start positions: the given one, branches of closed forms, and a Latin hypercube."""
    moved, starts = list(chain.moved), [near, *closed]
    if moved and count > 1:
        sample = for_vibrations("scipy.stats.qmc").LatinHypercube(len(moved), seed=seed).random(count - 1)
        for row in sample:
            q = near.copy()
            low, high = chain.ranges[moved].T
            q[moved] = low + row * (high - low)
            starts.append(q)
    return starts


def _from(chain: Chain, pose: Pose, start: Array) -> Array:
    """Return the positions that minimize the pose error, from one start."""
    moved, q = list(chain.moved), start.copy()
    if not moved:
        return q

    def full(x: Array) -> Array:
        placed = start.copy()
        placed[moved] = x
        return placed

    inside = np.clip(start[moved], chain.low[moved], chain.high[moved])
    fit = for_vibrations("scipy.optimize").least_squares(
        lambda x: chain.error(full(x), pose), inside, lambda x: chain.slopes(full(x), pose),
        bounds=(chain.low[moved] - SAME, chain.high[moved] + SAME), xtol=1e-15, ftol=1e-15, gtol=1e-15,
        max_nfev=EVALUATIONS,
    )  # fmt: skip
    q = full(np.asarray(fit.x, dtype=float))
    turning = np.array(chain.angles) & np.isinf(chain.low) & np.isinf(chain.high)
    q[turning] = (q[turning] + np.pi) % (2 * np.pi) - np.pi
    return q


def _apart(chain: Chain, q: Array, other: Array) -> Array:
    """Return the difference q - other of joint positions, angles within half a turn."""
    apart = q - other
    turns = np.array(chain.angles)
    apart[turns] = (apart[turns] + np.pi) % (2 * np.pi) - np.pi
    return apart


def _rank(J: Array) -> int:
    values = np.linalg.svd(J, compute_uv=False)
    return int((values > SINGULAR * values.max(initial=0.0)).sum()) if values.size else 0


def _solution(chain: Chain, pose: Pose, q: Array) -> Reached:
    J = chain.slopes(q, pose)
    at = [k for k in chain.moved if min(abs(q[k] - chain.low[k]), abs(q[k] - chain.high[k])) <= 10 * SAME]
    joints = {name: float(x) for name, x in zip(chain.names, q, strict=True)}
    return Reached(joints, tuple(chain.names[k] for k in at), _rank(J) < min(J.shape))


def of_angles(angles: Sequence[float]) -> Array:
    """Return the orientation (3, 3) of rotations by angles (3,), rad, about the fixed x, y and z axes, in turn."""
    matrix: Any = for_vibrations("scipy.spatial.transform").Rotation.from_euler("xyz", list(angles)).as_matrix()
    return np.asarray(matrix, dtype=float)
