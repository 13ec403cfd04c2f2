"""Parameters that bodies, friction and springs can have, nearest to data and to the machine's file.

Data enter by their least-squares estimate X and its covariance C, so that noise of positions, correlated rows and
doubts of sensors are in it: with x the standard parameters and U = P x the groups that torques depend on, the misfit is
(U - X)^T C^-1 (U - X) / 2. The null space of P stays inside: there the file decides (`pseudo_inertia`), so all bodies
are complete, and groups are their linear image. `trust` is about how far the file's bodies are from the truth: a mass
and its inertia scaled by 1 + e cost 2 lam e^2, which is e^2 / (2 trust^2) for lam = 1 / (4 trust^2).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.machine.joints import INERTIAL
from symoro_elastic.machine.machine import Machine
from symoro_elastic.measured.fitting.estimates import Estimate, Unknown, Verdict, is_identified
from symoro_elastic.measured.fitting.evidence import information_root, largest_chi2
from symoro_elastic.measured.logs.estimation import ABSORBED, Estimation
from symoro_elastic.measured.logs.pseudo_inertia import RADIUS, Nearest, Prior, lifted, nearest, pseudo_inertia
from symoro_elastic.measured.logs.sensors import OFFSET
from symoro_elastic.numerics.linear.independence import IndependentColumns
from symoro_elastic.numerics.linear.regressor import RegressorColumn

LEAST_LAM = 1e-6  # of constraints alone
GUESSES = {"IA": 0.01, "FV": 0.02, "FS": 0.02, "DA": 0.02, "K": 1.0}
"""Scalars that are positive, and what they exert where the file gives none, of the largest torque."""
OFFSETS = 0.03  # of the largest torque: standard deviation of offsets in short records
NEUTRAL = 0.1  # of the largest torque: least standard deviation of K q0
PINNED = 1e-5  # of the size of a known value of a body: its standard deviation
FROM_FILE = 3.0  # times narrower with the file than from data
FLOOR = 0.02  # of the largest torque: least noise of records that are short
OF_MOTORS = ("IA", "FV", "FS")
SLOWEST = 0.3  # of the fastest motor: slower ones are taken to be as fast, for those at rest would have huge guesses
TRUST_OF_SHORT = 1.0  # in the file, of short records if none is given, and in values that it does not give
STEEPER = 1e3  # times lam where rounding makes a body singular
ROOM = 1e-15  # least eigenvalue over the largest of a body that is not
SHORT = (
    "the record is short (fewer than two equations for each parameter, or joints that reverse less than twice), "
    f"so noise is taken for at least {100 * FLOOR:g} % of the largest torque, offsets within {100 * OFFSETS:g} %"
)
MORE_THAN_CHANCE = (
    "that is more than chance: least squares asks for bodies that do not exist, or that are far from the file, so the "
    "model lacks something (friction, a sensor's law), the file is trusted too much, or a torque is not in its unit "
    "(--gain)"
)
TRUSTED = (
    f"no trust is given, so bodies of the file are taken as right to about {100 * TRUST_OF_SHORT:g} %: "
    "say how far they may be off (--trust 0.3)"
)


@dataclass(frozen=True)
class Linear:
    """Parameters of the linear torque equations: regressor columns, those that are estimated, their grouping, and the
    values of the others."""

    columns: Sequence[RegressorColumn]
    sought: Sequence[int]
    structure: IndependentColumns
    known: Mapping[int, float]


@dataclass(frozen=True)
class Data:
    """Data of the fit: rows (rows, n, unknowns), torques (rows, n), largest torque by a unit of each regressor column
    on each joint (n, columns), and whether rows are too few for least squares alone."""

    Y: Array
    tau: Array
    exerted: Array
    is_short: bool

    @property
    def largest(self) -> Array:
        """Largest torques by joint (n); where no torque is measured, the median of the others."""
        largest: Array = np.abs(self.tau).max(axis=0, initial=0.0)
        return np.where(largest > 0, largest, float(np.median(largest[largest > 0])) if largest.any() else 1.0)

    def alone(self, c: int, alike: Sequence[int] = ()) -> float:
        """Return the value with which parameter c alone causes the largest torque of the joint that it loads most;
        its torque per unit is taken as at least a fraction of that of the equal columns `alike`."""
        row = int(np.argmax(self.exerted[:, c]))
        most = float(self.exerted[:, list(alike)].max(initial=0.0))
        return float(self.largest[row]) / (max(float(self.exerted[row, c]), SLOWEST * most) or 1.0)

    def sizes(self, U: Array, sigma: Array) -> tuple[float, Array]:
        """Return residuals with parameters U in per cent of torques, rows weighted: of all joints, and by joint (n)."""
        remaining, total = (((x / sigma) ** 2).sum(axis=0) for x in (self.tau - self.Y @ U, self.tau))
        percent = 100 * np.sqrt(remaining / np.where(total > 0, total, np.inf))
        return float(100 * np.sqrt(remaining.sum() / total.sum())), percent


@dataclass(frozen=True)
class Possible:
    """Physically consistent values by row of the table and quantity, standard deviations of estimates with the file
    (NaN without trust in it), the misfit over that of least squares (chi squared), and notes."""

    trust: float
    values: Mapping[tuple[int, str], float]
    with_file: tuple[float, ...]
    misfit: float
    notes: tuple[str, ...]

    def bodies(self) -> dict[int, Array]:
        """Return pseudo-inertias by row of the table."""
        return _bodies(self.values)


def made_possible(
    machine: Machine, linear: Linear, data: Data, estimation: Estimation, trust: float
) -> tuple[Estimation, Possible]:
    """Return the estimation with physically consistent values, and the bodies with these.

    Standard deviations from data stay as least squares gives them; verdicts judge the values by them. Raises
    `InputError` for known values that no body has.
    """
    unknowns = [e.unknown for e in estimation.estimates]
    is_trusted = math.isfinite(trust)
    trust = trust if is_trusted or not data.is_short else TRUST_OF_SHORT
    lam = max(LEAST_LAM, 1 / (4 * trust**2))
    start = _Start(machine, linear, data, unknowns)
    P, (A, b) = start.groups(), _of_data(estimation)
    A = A @ P
    nearest, values = start.nearest(A, b, lam)
    U, misfit = P @ nearest.x, float(((A @ nearest.x - b) ** 2).sum())
    with_file = np.sqrt(np.diag(P @ nearest.covariance @ P.T)) if math.isfinite(trust) else np.full(len(U), math.nan)
    notes = [*start.notes(is_trusted), *_rise(estimation, data, U, misfit, len(A))]
    notes += _of_deviations(estimation, with_file, trust)
    return _with_values(estimation, U, data), Possible(trust, values, tuple(with_file.tolist()), misfit, tuple(notes))


@dataclass(frozen=True)
class _Start:
    """Unknowns of the physically consistent fit, and their initial values: bodies, positive scalars, free values."""

    machine: Machine
    linear: Linear
    data: Data
    unknowns: Sequence[Unknown]

    @cached_property
    def places(self) -> dict[tuple[int, str], int]:
        """Numbers of regressor columns by row of the table and quantity."""
        return {(column.row, column.quantity): c for c, column in enumerate(self.linear.columns)}

    @cached_property
    def rows(self) -> list[int]:
        """Rows of the table with a body."""
        return sorted({row for row, quantity in self.places if quantity == "M"})

    @cached_property
    def scalars(self) -> list[int]:
        """Numbers of regressor columns of positive scalars, such as friction and stiffness."""
        return [c for c in self.linear.sought if self.linear.columns[c].quantity in GUESSES]

    @cached_property
    def neutral(self) -> list[int]:
        """Numbers of regressor columns of K q0, which may be negative."""
        return [c for c in self.linear.sought if self.linear.columns[c].quantity == "KQ"]

    @cached_property
    def order(self) -> list[int]:
        """Numbers of regressor columns in the order of x; sensor terms follow them."""
        bodies = [self.places[j, name] for j in self.rows for name in INERTIAL]
        return [*bodies, *self.scalars, *self.neutral]

    @property
    def sensors(self) -> list[Unknown]:
        """Sensor terms among the unknowns: offsets and the delay."""
        return list(self.unknowns[len(self.linear.structure.kept) :])

    def groups(self) -> Array:
        """Return the matrix P of base parameters U = P x."""
        structure, own = self.linear.structure, {c: k for k, c in enumerate(self.order)}
        P = np.zeros((len(self.unknowns), len(own) + len(self.sensors)))
        for k, column in enumerate(structure.kept):
            for c, factor in ((column, 1.0), *structure.terms(k)):
                P[k, own[self.linear.sought[c]]] = factor
        last = np.arange(len(self.sensors))
        P[len(structure.kept) + last, len(own) + last] = 1.0
        return P

    @cached_property
    def _bodies(self) -> list[tuple[Array, bool]]:
        """Pseudo-inertias of the file's bodies, made physically consistent, and whether they had to be changed."""
        of_file = {j: np.array([self._of_file(self.places[j, name]) for name in INERTIAL]) for j in self.rows}
        masses = [x[-1] for x in of_file.values() if x[-1] > 0]
        mass = float(np.median(masses)) if masses else 1.0
        return [lifted(pseudo_inertia(_with_mass(x, mass)), mass) for x in of_file.values()]

    def _of_file(self, c: int) -> float:
        return self.linear.known.get(c, self.linear.columns[c].value)

    def prior(self, lam: float) -> Prior:
        """Return the prior of bodies, scalars and free values, from the values of the file."""
        columns = self.linear.columns
        of_file = [columns[c].value for c in self.scalars]
        guessed = [GUESSES[columns[c].quantity] * self.data.alone(c, self._columns_like(c)) for c in self.scalars]
        scalars = [x if x > 0 else other for x, other in zip(of_file, guessed, strict=True)]
        weights = [1.0 if x > 0 else min(1.0, 1 / (4 * TRUST_OF_SHORT**2 * lam)) for x in of_file]
        neutral = [float(np.nan_to_num(columns[c].value)) for c in self.neutral]
        neutral_sizes = [max(abs(x), NEUTRAL * self.data.alone(c)) for x, c in zip(neutral, self.neutral, strict=True)]
        of_sensors = [self._deviation(k, unknown) for k, unknown in enumerate(self.sensors)]
        by_lam = [True] * len(neutral) + [False] * len(of_sensors)
        bodies = np.array([J for J, _ in self._bodies]).reshape(-1, 4, 4)
        free = np.array([*neutral, *[0.0] * len(of_sensors)])
        deviations = np.array([*neutral_sizes, *of_sensors])
        return Prior(bodies, np.array(scalars), np.array(weights), free, deviations, np.array(by_lam, dtype=bool))

    def _columns_like(self, c: int) -> list[int]:
        """Return the columns of other motors with the same quantity as column c."""
        own, columns = self.linear.columns[c], self.linear.columns
        if own.quantity not in OF_MOTORS:
            return []
        return [k for k, x in enumerate(columns) if (x.quantity, x.unit) == (own.quantity, own.unit)]

    def nearest(self, A: Array, b: Array, lam: float) -> tuple[Nearest, dict[tuple[int, str], float]]:
        """Return the consistent values nearest to rows A x = b and to the file, and all values by row and quantity.

        Bodies without room in rounded numbers are nearer to the file. Raises `InputError` where known ones leave none.
        """
        pins, pinned = self.pins()
        while True:
            minimum = nearest(self.prior(lam), np.concatenate([A, pins]), np.concatenate([b, pinned]), lam)
            values = self.values(minimum.x)
            eigenvalues = {j: np.linalg.eigvalsh(J) for j, J in _bodies(values).items()}
            without = [j for j, sizes in eigenvalues.items() if sizes[0] <= ROOM * sizes[-1]]
            fixed = [j for j in without if any(self.places[j, name] in self.linear.known for name in INERTIAL)]
            if fixed:
                what = "no body has the values that are given as known, with any others: give fewer, or other ones"
                raise self.machine.error(f"--known, joint {fixed[0]} ({self.machine.joint(fixed[0]).name})", what)
            if not without:
                return minimum, values
            lam *= STEEPER

    def _deviation(self, k: int, unknown: Unknown) -> float:
        """Return the prior standard deviation of an offset or a delay."""
        column = self.data.Y[:, :, len(self.linear.structure.kept) + k]
        row = int(np.abs(column).max(axis=0).argmax())
        size = float(self.data.largest[row]) / (float(np.abs(column[:, row]).max()) or 1.0)
        return OFFSETS * size if unknown.quantity == OFFSET and self.data.is_short else size

    def pins(self) -> tuple[Array, Array]:
        """Return rows A x = b that fix the known values of bodies."""
        fixed = [(k, c) for k, c in enumerate(self.order) if c in self.linear.known]
        rows, right = np.zeros((len(fixed), len(self.order) + len(self.sensors))), np.zeros(len(fixed))
        sizes = _sizes([J for J, _ in self._bodies])
        for row, (k, c) in enumerate(fixed):
            rows[row, k] = 1 / (PINNED * sizes[k])
            right[row] = self.linear.known[c] * rows[row, k]
        return rows, right

    def values(self, x: Array) -> dict[tuple[int, str], float]:
        """Return the values of all parameters by row of the table and quantity, with fixed values unchanged."""
        values = dict(zip(self.order, x.tolist(), strict=False)) | dict(self.linear.known)
        return {key: values[c] for key, c in self.places.items()}

    def notes(self, is_trusted: bool) -> list[str]:
        """Return notes on a short record, and on file values that are not physically consistent or not positive."""
        changed = [self.machine.joint(j).name for j, (_, is_new) in zip(self.rows, self._bodies, strict=True) if is_new]
        columns = self.linear.columns
        guessed = [columns[c].label for c in self.scalars if not columns[c].value > 0]
        notes = [SHORT, *([] if is_trusted else [TRUSTED])] if self.data.is_short else []
        if changed:
            what = "no body has the values of the file (or they are not known), the nearest possible ones are its prior"
            notes.append(f"{', '.join(changed)}: {what}")
        if guessed:
            what = "a share of the torques is their prior"
            notes.append(f"the file has no positive value of {', '.join(guessed)}: {what}")
        return notes


def _with_mass(x: Array, mass: float) -> Array:
    """Return parameters of a body with those of a ball in place of unknown values (NaN)."""
    x = x.copy()
    x[-1] = mass if math.isnan(x[-1]) else x[-1]
    x[6:9] = np.nan_to_num(x[6:9])
    if np.isnan(x[:6]).any():
        m, h = max(x[-1], 0.0) or mass, x[6:9]
        tensor = m * RADIUS**2 * np.eye(3) + (h @ h * np.eye(3) - np.outer(h, h)) / m
        x[:6] = np.where(np.isnan(x[:6]), tensor[(0, 0, 0, 1, 1, 2), (0, 1, 2, 1, 2, 2)], x[:6])
    return x


def _sizes(bodies: Sequence[Array]) -> Array:
    """Return typical sizes of inertias, first moments and masses of bodies, ten for each body."""
    traces = [(float(np.trace(J[:3, :3])), J[3, 3]) for J in bodies]
    return np.array([x for s, m in traces for x in (*[s] * 6, *[math.sqrt(s * m)] * 3, m)])


def _bodies(values: Mapping[tuple[int, str], float]) -> dict[int, Array]:
    rows = sorted({row for row, quantity in values if quantity == "M"})
    return {j: pseudo_inertia(np.array([values[j, name] for name in INERTIAL])) for j in rows}


def _of_data(estimation: Estimation) -> tuple[Array, Array]:
    """Return rows R Q and R X of unit standard deviation: Q maps unknowns to base parameters, R^T R = C^-1."""
    solution, grouping = estimation.solution, estimation.grouping
    Q = np.zeros((len(grouping.kept), len(estimation.estimates)))
    Q[np.arange(len(grouping.kept)), list(grouping.kept)] = 1.0
    Q[:, list(grouping.dropped)] = grouping.beta
    R = information_root(solution.covariance)
    return R @ Q, R @ solution.X


def _with_values(estimation: Estimation, U: Array, data: Data) -> Estimation:
    """Return the estimation with other values of all unknowns."""
    independent, count = list(estimation.grouping.kept), len(U)
    covariance = np.full((count, count), math.nan)
    covariance[np.ix_(independent, independent)] = estimation.solution.covariance
    predicted = data.Y @ U
    solution = replace(
        estimation.solution, X=U, covariance=covariance, predicted=predicted, residuals=data.tau - predicted
    )
    pairs = zip(estimation.estimates, U.tolist(), strict=True)
    estimates = tuple(_verdict_of(replace(e, value=e.unknown.about + x)) for e, x in pairs)
    every = IndependentColumns(tuple(range(count)), (), (), np.zeros((count, 0)))
    notes = tuple(note for note in estimation.notes if not note.startswith(ABSORBED))
    return replace(estimation, estimates=estimates, solution=solution, grouping=every, notes=notes)


def _verdict_of(e: Estimate) -> Estimate:
    """Return an estimate, with verdict "poor" if its standard deviation from data is large against its value."""
    if e.verdict is not Verdict.IDENTIFIED or is_identified(e.value, e.std):
        return e
    return replace(e, verdict=Verdict.POOR, reason="; ".join(filter(None, ["the file decides it", e.reason])))


def _rise(estimation: Estimation, data: Data, U: Array, misfit: float, freedom: int) -> list[str]:
    """Return notes on the residuals with physical consistency, and whether their increase exceeds chance."""
    own, sigma = np.zeros(len(U)), estimation.solution.sigma
    own[list(estimation.grouping.kept)] = estimation.solution.X
    (before, own_each), (after, each) = data.sizes(own, sigma), data.sizes(U, sigma)
    what = f"physically consistent solution: residuals {after:.3g} % of the torque"
    if data.is_short:
        return [what]
    what += f", {before:.3g} % unconstrained"
    notes = [f"{what}; chi2 {misfit:.3g}, {freedom} degrees of freedom"]
    if misfit > freedom * largest_chi2(freedom):
        k = int(np.argmax(each - own_each))
        where = f"most of it at {estimation.joints[k]}: {each[k]:.3g} % of its torque, {own_each[k]:.3g} % alone"
        notes.append(f"{MORE_THAN_CHANCE}; {where}")
    return notes


def _of_deviations(estimation: Estimation, with_file: Array, trust: float) -> list[str]:
    """Return notes on the meaning of the standard deviations."""
    if not math.isfinite(trust):
        return ["standard deviations are those of least squares, which are conservative here"]
    pairs = zip(estimation.estimates, with_file.tolist(), strict=True)
    own = [e.unknown.label for e, std in pairs if not e.std < FROM_FILE * std]
    what = f"standard deviations with the file are as good as the trust: bodies right to about {100 * trust:.3g} %"
    return [what, *([f"not determined by the data, close to the initial values: {', '.join(own)}"] if own else [])]
