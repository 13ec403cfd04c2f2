"""Base inertial parameters by numbers: rank of the regressor stacked at random states, relations of its columns.

Structural rank is not practical rank: `Conditioning` measures how far the columns of each base
parameter are from all other columns.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.machine.machine import Machine
from symoro_elastic.mechanics.base_parameters import ROTOR
from symoro_elastic.mechanics.coordinates import projection
from symoro_elastic.mechanics.newton_euler import newton_euler
from symoro_elastic.mechanics.regressor import INERTIAL, body_of, torques
from symoro_elastic.mechanics.spatial import Axis, hat_plus_hat_squared, is_zero
from symoro_elastic.models.parameters.base_parameters import Grouping, Label, Relations
from symoro_elastic.numerics.evaluation.closed_positions import drawn_values
from symoro_elastic.numerics.evaluation.random_motion import RandomMotion, random_motion
from symoro_elastic.numerics.linear.independence import independent_columns, rank, triangle, unit_columns

RANK_TOLERANCE = 1e-9
"""Length of a remaining column, relative, below which the column is zero or dependent."""
NEGLIGIBLE_COEFFICIENT = 1e-12
"""Coefficients of columns of length one that are rounding."""
PSEUDOINVERSE = 1e-15
"""Share of the largest singular value below which directions have no inverse."""
TORQUES_AGREE = 1e-12
LEAST_STATES = 40
MOST_COMPARED = 80
"""Most joints of a machine whose count is compared with the rank: the regressor of 300 needs minutes and a gigabyte."""
ROWS_PER_COLUMN = 4


@dataclass(frozen=True)
class Stacked:
    """Rows of Y at all states, one below the other; `labels` name the columns."""

    W: Array
    labels: tuple[Label, ...]

    def columns(self, labels: Sequence[Label]) -> Array:
        """Return the columns of some parameters."""
        places = {label: k for k, label in enumerate(self.labels)}
        return self.W[:, [places[label] for label in labels]]


@dataclass(frozen=True)
class Conditioning:
    """Conditioning of a base regressor on a motion.

    `condition` is that of the base regressor, columns scaled to length one. `distinct` gives for each
    parameter the part of its column that no combination of the others imitates, from 1 (orthogonal)
    to 0 (cannot be found), the weakest first.
    """

    condition: float
    distinct: dict[str, float]


@dataclass(frozen=True)
class CrossCheck:
    """A grouping against numbers: its count, the rank of the regressor, and the change of torques, relative.

    `rank` and `conditioning` are None for large machines, and `unknown` says what that leaves open. `doubt` says where
    they disagree and the consequence, `refused` that no grouping can be used.
    """

    count: int
    rank: int | None
    torque_error: float
    conditioning: Conditioning | None
    doubt: str = ""
    refused: bool = False
    unknown: str = ""

    @property
    def agrees(self) -> bool:
        """Whether count and torques agree."""
        return not self.doubt

    @property
    def torques_stay(self) -> bool:
        """Whether grouping leaves the torques unchanged."""
        return self.torque_error <= TORQUES_AGREE

    @property
    def message(self) -> str:
        """Result of the check, as one line."""
        count = f"{self.count} base parameter{'s' * (self.count != 1)}"
        checked = "by the rules" if self.rank is None else "as the rank of the regressor"
        compared = f"the rank is compared up to {MOST_COMPARED} joints{self.unknown}"
        beyond = f" (torques stay within {self.torque_error:.1g}; {compared})"
        return self.doubt or f"{count}, {checked}" + beyond * (self.rank is None)


def stacked_regressor(motion: RandomMotion) -> Stacked:
    """Return the regressor of all inertial parameters of all bodies, and of nonzero rotor inertias."""
    links = motion.mechanism.links
    joints = [j for j, link in motion.mechanism.from_base() if link.axis is not Axis.NONE]
    rotors = [j for j in joints if not is_zero(links[j - 1].rotor_inertia)]
    W = np.zeros((len(links) * len(INERTIAL) + len(rotors), len(motion.independent), motion.states))
    for j, _ in motion.mechanism.from_base():
        first = (j - 1) * len(INERTIAL)
        by_coordinate: Mapping[int, Any] = projection(motion.S, _unit_torques(motion, j))
        for k, forces in by_coordinate.items():
            W[first : first + len(INERTIAL), motion.independent.index(k)] = forces
    for row, j in enumerate(rotors, start=len(links) * len(INERTIAL)):
        W[row] = motion.on_independent({j: motion.qdd[j]}).T
    labels = [(j, name) for j, _ in motion.mechanism.from_base() for name in INERTIAL] + [(j, ROTOR) for j in rotors]
    return Stacked(W.reshape(len(labels), -1).T, tuple(labels))


def _unit_torques(motion: RandomMotion, j: int) -> dict[int, Any]:
    """Return the torques for a unit of every inertial parameter of body j: (parameters, states) by joint."""
    dynamics = motion.dynamics
    units = body_of(dict(zip(INERTIAL, np.eye(len(INERTIAL))[:, :, None], strict=True)))
    U = hat_plus_hat_squared(dynamics.w[j], dynamics.wd[j])
    wrench = newton_euler(units, dynamics.w[j], dynamics.wd[j], dynamics.vd[j], U)
    return torques(motion.mechanism, j, wrench)


def enough_states(machine: Machine) -> int:
    """Return a number of random states at which the stacked regressor has its structural rank."""
    columns = 11 * len(machine.joints)
    return max(LEAST_STATES, math.ceil(ROWS_PER_COLUMN * columns / max(1, len(machine.independent))))


def numerical_relations(machine: Machine, first: Collection[Label] = (), seed: int = 0) -> Relations:
    """Return a base set, with the independent labels of `first`, and by member the parameters grouped with it."""
    stacked = stacked_regressor(random_motion(machine, enough_states(machine), seed))
    labels = stacked.labels
    wanted = [k for k, label in enumerate(labels) if label in first]
    columns = independent_columns(stacked.W, RANK_TOLERANCE, RANK_TOLERANCE, wanted, NEGLIGIBLE_COEFFICIENT)
    return {labels[k]: {labels[c]: b for c, b in columns.terms(i)} for i, k in enumerate(columns.kept)}


def conditioning(W: Array, names: Sequence[str]) -> Conditioning:
    """Return the conditioning of a base regressor, whose columns are independent."""
    if not names:
        return Conditioning(1.0, {})
    _, sizes, V = np.linalg.svd(triangle(unit_columns(W, RANK_TOLERANCE)[0]))
    inverse = np.divide(1.0, sizes, out=np.zeros_like(sizes), where=sizes > PSEUDOINVERSE * sizes[0])
    rows = np.linalg.norm(inverse[:, None] * V, axis=0)
    apart = np.divide(1.0, rows, out=np.zeros_like(rows), where=rows > 0)
    weakest_first = sorted(zip(names, apart.tolist(), strict=True), key=lambda pair: pair[1])
    return Conditioning(float(sizes[0] / sizes[-1]) if sizes[-1] > 0 else math.inf, dict(weakest_first))


def cross_check(machine: Machine, grouping: Grouping, seed: int = 0) -> CrossCheck:
    """Return a grouping's count, the rank of the stacked regressor, and the change of torques by grouping.

    Parameters without value are drawn at random. The rank of large machines is not compared.
    """
    values = drawn_values(machine, seed)
    motion = random_motion(machine, enough_states(machine), seed, values)
    if len(machine.joints) > MOST_COMPARED:
        error = torque_error(machine, grouping, motion, values, seed)
        doubt = _doubt(machine, grouping.count, grouping.count, error)
        unknown = "; couplings and loops may leave fewer" if machine.is_coupled else ""
        return CrossCheck(grouping.count, None, error, None, doubt, unknown=unknown)
    stacked = stacked_regressor(motion)
    stacked = replace(stacked, W=triangle(stacked.W))  # lengths of columns and angles between them are the same
    count = rank(stacked.W, RANK_TOLERANCE, RANK_TOLERANCE)
    labels = grouping.kept
    spread = conditioning(stacked.columns(labels), [grouping.labels[label] for label in labels])
    error = torque_error(machine, grouping, motion, values, seed)
    return CrossCheck(grouping.count, count, error, spread, _doubt(machine, grouping.count, count, error))


def torque_error(
    machine: Machine, grouping: Grouping, motion: RandomMotion, values: Mapping[str, float], seed: int = 0
) -> float:
    """Return the largest difference of torques before and after grouping, relative to the largest torque."""
    regrouped = {**grouping.values(values), **values}
    other = random_motion(grouping.machine, motion.states, seed, regrouped, motion.closed)
    before, after = motion.torques(), other.torques()
    return float(np.abs(after - before).max(initial=0.0) / max(np.abs(before).max(initial=0.0), 1e-300))


def _doubt(machine: Machine, count: int, rank: int, error: float) -> str:
    if machine.is_coupled and count > rank:
        return f"the tree of the joints has {count} base parameters by the rules, couplings and loops leave {rank}"
    if count != rank:
        return f"the rules give {count} base parameters, the rank of the regressor at random states is {rank}"
    return f"torques change by {error:.2g} after grouping by the rules" if error > TORQUES_AGREE else ""
