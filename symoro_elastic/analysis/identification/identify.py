"""From measurements to parameters: filter, stack averages, group, solve, judge."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from symoro_elastic.analysis.identification.estimation import (
    Estimate,
    Estimation,
    Unknown,
    estimate,
    formula,
    refuse_short,
)
from symoro_elastic.analysis.identification.filtering import (
    Filter,
    FilteredMotion,
    as_measured,
    average,
    default_filter,
    filtered_motion,
    moving,
    openness,
)
from symoro_elastic.analysis.identification.regression import (
    Regressor,
    RegressorColumn,
    refuse_unknown_labels,
    regressor,
    zero_entries,
)
from symoro_elastic.analysis.time_series.measurements import Measurements
from symoro_elastic.foundation.array_types import Array, BoolArray
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.progress import Announce, announce_nothing
from symoro_elastic.foundation.results import Result
from symoro_elastic.foundation.sizes import refuse_numbers
from symoro_elastic.machine.machine import Machine
from symoro_elastic.numerics.independence import IndependentColumns, independent_columns
from symoro_elastic.numerics.independent_joints import moved_by

STRUCTURAL = 1e-8  # independence at random states, of columns of length 1
RANK_STATES = 60  # random states of the structural rank
PIECE = 4000  # samples evaluated at a time


@dataclass(frozen=True)
class Rows:
    """Rows of both sides of tau = Y X, joints that stand still, and noise of Y by twins of that of the positions."""

    t: Array
    Y: Array
    tau: Array
    still: tuple[int, ...]
    noise: tuple[Array, ...] = ()


@dataclass(frozen=True)
class Equations:
    """tau = Y X of a machine: its regressor, the columns to estimate, values of those that are known."""

    machine: Machine
    Y: Regressor
    kept: tuple[int, ...]
    known: Mapping[int, float]

    def rows(self, record: Measurements, chosen: Filter | None) -> Rows:
        """Return rows of both sides of a record.

        Samples at which a joint's dry friction reverses are left out of its rows. Rows are divided by the standard
        deviation that white noise of torques has in them, relative to that of rows from whole windows.
        """
        motion = filtered_motion(record, chosen) if chosen else as_measured(record)
        self._refuse_open(motion, record.source)
        counted = self._counted(motion, chosen)
        left = self.Y.joint_torques(motion.q, motion.tau)
        pieces = _pieces(len(motion.t), chosen)
        averages = zip(*(self._averages(motion, left, counted, piece, chosen) for piece in pieces), strict=True)
        t, tau, right, *noise = (np.concatenate(x) for x in averages)
        scale = _relative_deviation(counted, chosen)
        scaled = [x * scale[:, :, None] for x in (right, *noise)]
        return Rows(t, scaled[0], tau * scale, motion.still, tuple(scaled[1:]))

    def _refuse_open(self, motion: FilteredMotion, source: str) -> None:
        """Raise `InputError` for positions at which the loops do not close."""
        parted = np.flatnonzero(~self.Y.closes(motion.q))
        if len(parted):
            where = f"at {len(parted)} of {len(motion.t)} samples, first at t = {motion.t[parted[0]]:g} s"
            what = "do positions have the zero of the machine's file, in rad and m?"
            raise InputError(source, "q", f"loops do not close, or jump to another branch, {where}: {what}")

    def _counted(self, motion: FilteredMotion, chosen: Filter | None) -> BoolArray:
        """Return a mask of samples (N, n) that count in the rows of a joint."""
        dry = [self.Y.columns[c].row for c in self.kept if self.Y.columns[c].quantity == "FS"]
        rates, *noises = (self.Y.rates(dry, motion.q, qd) for qd in (motion.qd, *(x[1] for x in motion.twins)))
        fast, counted = moving(rates, noises, chosen), np.ones(motion.q.shape, dtype=bool)
        for k, row in enumerate(dry):
            counted[:, [i for i in self.Y.felt_by(row) if i not in motion.still]] &= fast[:, [k]]
        return counted

    def _averages(
        self, motion: FilteredMotion, left: Array, counted: BoolArray, piece: slice, chosen: Filter | None
    ) -> list[Array]:
        """Return averages of t, tau, Y, and of half the differences of Y between opposite noises."""
        motions = [motion.part(piece)]
        for twin in range(len(motion.twins)):
            motions += [motion.with_other_noise(twin, sign, piece) for sign in (1.0, -1.0)]
        columns = [self.Y.evaluate(*x, self.kept) for x in motions]
        halves = [(one - other) / 2 for one, other in zip(columns[1::2], columns[2::2], strict=True)]
        known = self.Y.evaluate(*motions[0], list(self.known)) @ np.array(list(self.known.values()))
        used = counted[piece].astype(float)
        tau = (left[piece] - self.Y.loads(motion.q[piece]) - known) * used
        both = [tau, *(x * used[:, :, None] for x in (columns[0], *halves))]
        return [average(x, chosen) if chosen else x for x in (motion.t[piece], *both)]


@dataclass(frozen=True, repr=False)
class Identification(Result):
    """What was found: the estimation, the rows it used (t, tau measured, averages), the filter, notes, what springs
    and dampers exert by the estimates (rows, n), neutral positions and their standard deviations."""

    equations: Equations
    estimation: Estimation
    t: Array
    tau: Array
    filter: Filter | None
    notes: tuple[str, ...]
    springs: Array
    neutral: dict[str, tuple[float, float]] = field(default_factory=dict)

    @property
    def machine(self) -> Machine:
        """The machine, with the values of its file."""
        return self.equations.machine

    @property
    def estimates(self) -> tuple[Estimate, ...]:
        """One for each parameter or group."""
        return self.estimation.estimates

    @property
    def headline(self) -> str:
        """Machine, parameters and samples."""
        return f"Identification of {self.machine.name}: {len(self.estimates)} parameters from {len(self.t)} samples"


def identify(
    machine: Machine,
    measured: Measurements | Sequence[Measurements],
    values: Mapping[str, float] | None = None,
    known: Mapping[str, float] | None = None,
    bandwidth: float | None = None,
    filtered: bool = True,
    step: Announce = announce_nothing,
    Y: Regressor | None = None,
) -> Identification:
    """Return the parameters of a machine from one or several records of measurements.

    `values` are numbers of its named parameters (geometry), `known` values of columns that are not sought
    (`M13`, `FS5`: weighed, or taken as zero), `bandwidth` that of the motion in Hz if the spectrum is not to
    decide. `filtered` False uses measurements as they are. Raises `InputError`.
    """
    records = [measured] if isinstance(measured, Measurements) else list(measured)
    step("filter")
    chosen = _filter(records, _driven(machine), bandwidth) if filtered else None
    step("trace")
    Y = Y or regressor(machine, values)
    fixed = _known(Y.columns, known or {}, machine)
    sought = [c for c in range(len(Y.columns)) if c not in fixed]
    step("group")
    structure = structural_grouping(Y, sought, machine)
    equations = Equations(machine, Y, tuple(sought[c] for c in structure.kept), fixed)
    correlation = chosen.correlation if chosen else (1.0,)
    refuse_short(_equations(records, chosen), len(structure.kept), correlation, records[0].source)
    _refuse_large(records, chosen, len(structure.kept))
    step("stack")
    stack = _joined([equations.rows(record, chosen) for record in records])
    _refuse_zero_torques(stack.tau, records[0].source)
    step("solve")
    unknowns = _unknowns(Y.columns, sought, structure)
    names = tuple(joint.name for joint in machine.independent_joints)
    source = records[0].source
    estimation = estimate(
        stack.Y, stack.tau, unknowns, names, stack.still, noise=stack.noise, correlation=correlation, source=source
    )
    notes = [line for record in records for line in record.warnings]
    notes += [*(chosen.described() if chosen else ()), *_without_effect(Y.columns, sought, structure)]
    notes += _zero_in_the_table(machine, [Y.columns[c] for c in equations.kept])
    springs, neutral = _springs(estimation, stack.Y, unknowns), _neutral(estimation, machine)
    all_notes = (*notes, *estimation.notes)
    return Identification(equations, estimation, stack.t, stack.tau, chosen, all_notes, springs, neutral)


def _refuse_zero_torques(tau: Array, source: str) -> None:
    if not tau.any():
        what = "is zero throughout, so every parameter could be zero: check the columns, or give known values"
        raise InputError(source, "tau", what)


def _equations(records: Sequence[Measurements], chosen: Filter | None) -> int:
    """Return how many rows records give at most."""
    if chosen is None:
        return sum(record.q.size for record in records)
    return sum(len(chosen.starts(len(record.t) - 2 * chosen.trim)) * record.q.shape[1] for record in records)


def _refuse_large(records: Sequence[Measurements], chosen: Filter | None, parameters: int) -> None:
    """Raise `InputError` for equations that have no room; those with both twins of noise count."""
    rows = _equations(records, chosen)
    what = f"{rows} equations after filtering for {parameters} parameters"
    way_out = "use less of the record (--after, --before), or a lower --bandwidth"
    refuse_numbers(3 * rows * parameters, what, records[0].source, "t", way_out)


def _springs(estimation: Estimation, Y: Array, unknowns: Sequence[Unknown]) -> Array:
    """Return the forces of springs and dampers by the estimates."""
    kept = [(k, c) for k, c in enumerate(estimation.grouping.kept) if unknowns[c].quantity in ("K", "DA", "KQ")]
    return Y[:, :, [c for _, c in kept]] @ estimation.solution.X[[k for k, _ in kept]]


def _joined(stacks: Sequence[Rows]) -> Rows:
    """Return all samples as one stack; joints stand still that do so in every record."""
    t, Y, tau = (np.concatenate(part) for part in zip(*((s.t, s.Y, s.tau) for s in stacks), strict=True))
    still = sorted(set.intersection(*(set(s.still) for s in stacks)))
    noise = (np.concatenate(part) for part in zip(*(s.noise for s in stacks), strict=True))
    return Rows(t, Y, tau, tuple(still), tuple(noise))


def _filter(records: Sequence[Measurements], motors: Sequence[int], bandwidth: float | None) -> Filter:
    """Return the filter of the record with the fastest motion, used for all."""
    return max((default_filter(record, motors, bandwidth) for record in records), key=lambda chosen: chosen.motion)


def _driven(machine: Machine) -> list[int]:
    """Return the indices in q of motors, and of joints that motors on dependent joints move."""
    moved = {k for j in machine.motors if j in machine.dependent for k in moved_by(machine, j)}
    return sorted({*machine.motor_entries, *machine.entries(moved)})


def _known(columns: Sequence[RegressorColumn], known: Mapping[str, float], machine: Machine) -> dict[int, float]:
    refuse_unknown_labels(machine, known, columns)
    numbers = {column.label: c for c, column in enumerate(columns)}
    for label, value in known.items():
        if not math.isfinite(value):
            raise machine.error(f"--known, {label}", "give it a number")
    return {numbers[label]: value for label, value in known.items()}


def structural_grouping(Y: Regressor, sought: Sequence[int], machine: Machine, seed: int = 0) -> IndependentColumns:
    """Return independent columns and how the others join them, at random states."""
    W = Y.evaluate(*Y.states(RANK_STATES, seed), sought)
    if not np.isfinite(W).all():
        raise machine.error("regressor", "has no value at ordinary positions")
    return independent_columns(W.reshape(-1, len(sought)), STRUCTURAL)


def _pieces(samples: int, chosen: Filter | None) -> list[slice]:
    """Return pieces of a record that hold whole windows, without large intermediate arrays."""
    if chosen is None:
        return [slice(k, k + PIECE) for k in range(0, samples, PIECE)]
    starts, each = chosen.starts(samples), max(1, max(PIECE, 4 * chosen.window) // chosen.step)
    firsts = [starts[k : k + each] for k in range(0, len(starts), each)]
    return [slice(some[0], some[-1] + chosen.window) for some in firsts]


def _relative_deviation(counted: BoolArray, chosen: Filter | None) -> Array:
    """Return 1 / std of white noise in each row (rows, n), 1 for whole windows, 0 for rows left out."""
    variance = openness(counted, chosen) if chosen else counted.astype(float)
    return np.where(variance > 0, 1 / np.sqrt(np.where(variance > 0, variance, 1.0)), 0.0)


def _unknowns(
    columns: Sequence[RegressorColumn], sought: Sequence[int], structure: IndependentColumns
) -> list[Unknown]:
    nominal = structure.apply(np.array([columns[c].value for c in sought]))
    unknowns = []
    for k, kept in enumerate(structure.kept):
        column = columns[sought[kept]]
        joined = [(columns[sought[c]].label, b) for c, b in structure.terms(k)]
        text = formula(column.label, joined)
        unknowns.append(Unknown(column.label, text, column.unit, column.joint, column.quantity, float(nominal[k])))
    return unknowns


def _without_effect(
    columns: Sequence[RegressorColumn], sought: Sequence[int], structure: IndependentColumns
) -> list[str]:
    labels = ", ".join(columns[sought[c]].label for c in structure.vanishing)
    return [f"without effect on any torque of this machine: {labels}"] if labels else []


def _neutral(estimation: Estimation, machine: Machine) -> dict[str, tuple[float, float]]:
    """Return q0 = KQ / K and its standard deviation by first order, for elastic joints with both estimates."""
    unknowns = [estimation.estimates[c].unknown for c in estimation.grouping.kept]
    places = {(unknown.joint, unknown.quantity): k for k, unknown in enumerate(unknowns)}
    neutral = {}
    for joint in map(machine.joint, machine.elastic):
        pair = [places.get((joint.name, quantity), -1) for quantity in ("KQ", "K")]
        if min(pair) >= 0:
            force, k = estimation.solution.X[pair]
            slope = np.array([1 / k, -force / k**2])
            variance = slope @ estimation.solution.covariance[np.ix_(pair, pair)] @ slope
            neutral[joint.name] = float(force / k), math.sqrt(float(variance))
    return neutral


def _zero_in_the_table(machine: Machine, columns: Iterable[RegressorColumn]) -> list[str]:
    """Return a note on parameters that are estimated although the table gives them as zero."""
    entries = zero_entries(machine)
    zero = [column.label for column in columns if (column.row, column.quantity) in entries]
    if not zero:
        return []
    what = "the table has zeros for them, so the generated regressor has no columns for them"
    return [f"also estimated: {', '.join(zero)}; {what}: write names or values instead to use both together"]
