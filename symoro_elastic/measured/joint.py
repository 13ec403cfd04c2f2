"""Logs and vibration tests in one fit: what a log determines of the parameters that the tests depend on, as evidence.

Of torques tau = Y X least squares gives base parameters X = G theta with covariance C. Parameters theta(p) of masses,
principal inertias, rotors, springs, dampers and viscous friction are functions of the unknowns p of the tests; the
others, F in number (first moments, products of inertia, dry friction, offsets ...), are eliminated: with N G_F = 0

    N X = N G theta(p) + e,    cov(e) = N C N^T

is a block of residuals in addition to those of frequency responses.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.packages import for_identification
from symoro_elastic.foundation.progress import Announce, announce_nothing
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.named_cells import with_named_cells
from symoro_elastic.measured.fitting.estimates import ROUNDING
from symoro_elastic.measured.fitting.evidence import Evidence, OtherData
from symoro_elastic.measured.logs.result import Identification
from symoro_elastic.measured.vibration_tests.measured import VibrationTests
from symoro_elastic.measured.vibration_tests.unknowns import positive_inertias
from symoro_elastic.measured.vibration_tests.updated import Settings, Updated, update
from symoro_elastic.numerics.linear.independence import IndependentColumns
from symoro_elastic.numerics.linear.regressor import RegressorColumn, nominal_body

OF_TESTS = frozenset({"M", "XX", "YY", "ZZ", "IA", "FV", "K", "DA"})
"""Quantities of a log that are functions of the unknowns of vibration tests."""


@dataclass(frozen=True)
class Log:
    """Identification result of a log, and the values of named parameters that the user gave."""

    identification: Identification
    values: Mapping[str, float] = field(default_factory=dict)


def fit_jointly(
    machine: Machine, log: Log, tests: VibrationTests, settings: Settings, step: Announce = announce_nothing
) -> Updated:
    """Return the machine that explains vibration tests and a log; masses that the log depends on are unknown, too.

    Raises
    ------
    InputError
        As `update` does, and for a log that determines no combination of the unknowns of the tests.
    """
    named, identified = with_named_cells(machine), log.identification
    theta = partial(column_values, named, _sought_columns(identified))
    values = named.given_values | dict(log.values)
    candidates = [name for name in positive_inertias(machine) if _changes(theta, values, name)]
    informed = tuple(name for name in candidates if name not in settings.seek)
    other = OtherData(informed, partial(evidence_of, identified, theta, values))
    return update(machine, tests.tests, settings, step, tests.notes, other)


def evidence_of(
    identified: Identification,
    theta: Callable[[Mapping[str, float]], Array],
    values: Mapping[str, float],
    labels: Sequence[str],
) -> Evidence:
    """Return the estimates of a log as evidence on unknowns x = ln p with these labels; others keep their `values`."""
    columns, estimation = _sought_columns(identified), identified.driven or identified.estimation
    grouped = partial(_base_parameters, identified.equations.linear.structure, estimation.grouping)
    is_free = np.array([column.quantity not in OF_TESTS for column in columns])
    more = len(estimation.estimates) - len(identified.equations.estimated_columns)
    zero, none = np.zeros(len(columns)), np.zeros(more)
    free = [grouped(e, none) for e, freely in zip(np.eye(len(columns)), is_free, strict=True) if freely]
    free += [grouped(zero, e) for e in np.eye(more)]
    free += list(np.eye(len(estimation.grouping.kept))[estimation.hidden])
    rows = np.reshape(free, (len(free), len(estimation.grouping.kept)))
    N: Array = for_identification("scipy.linalg").null_space(rows, rcond=ROUNDING).T

    def combinations(x: Array) -> Array:
        theta_of_x = theta({**values, **dict(zip(labels, np.exp(x).tolist(), strict=True))})
        combined: Array = N @ grouped(np.where(is_free, 0.0, theta_of_x), none)
        return combined

    start = np.log([values[label] for label in labels])
    slopes = [combinations(start + h) - combinations(start - h) for h in 1e-3 * np.eye(len(labels))]
    if not len(N) or not np.any(slopes):
        raise InputError(identified.machine.label, "records", "this log determines no parameter of the tests")
    solution = estimation.solution
    return Evidence.of(combinations, N @ solution.X, N @ solution.covariance @ N.T)


def column_values(machine: Machine, columns: Sequence[RegressorColumn], values: Mapping[str, float]) -> Array:
    """Return the parameters theta of columns of a regressor at values of the parameters of a machine, 0 if unknown."""
    bodies = {row: nominal_body(machine.joint(row).body, values) for row in {column.row for column in columns}}
    theta_of_columns = []
    for column in columns:
        joint, body = machine.joint(column.row), bodies[column.row]
        cells = {
            "IA": [joint.reflected_inertia], "FV": [joint.friction.viscous], "FS": [joint.friction.coulomb],
            "K": [joint.spring.stiffness], "DA": [joint.spring.damping, joint.friction.viscous],
        }  # fmt: skip
        own = cells.get(column.quantity)
        theta_of_columns.append(
            body.get(column.quantity, 0.0) if own is None else sum(cell.value(values) for cell in own)
        )
    theta: Array = np.nan_to_num(np.array(theta_of_columns, dtype=float))
    return theta


def _sought_columns(identified: Identification) -> list[RegressorColumn]:
    linear = identified.equations.linear
    return [linear.columns[c] for c in linear.sought]


def _base_parameters(structure: IndependentColumns, grouping: IndependentColumns, theta: Array, more: Array) -> Array:
    """Return base parameters from the parameters `theta` of columns, and those of friction laws and sensors."""
    return grouping.apply(np.concatenate([structure.apply(theta), more]))


def _changes(theta: Callable[[Mapping[str, float]], Array], values: Mapping[str, float], name: str) -> bool:
    return bool((theta({**values, name: 2 * values[name]}) != theta(values)).any())
