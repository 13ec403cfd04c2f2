"""From measurements to parameters: filter, stack averages, group, solve, judge."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from symoro_elastic.analysis.identification.equations import Equations, Rows, Sampled
from symoro_elastic.analysis.identification.estimation import (
    FEWEST_ROWS,
    FROM_DATA,
    Draws,
    Estimate,
    Estimation,
    Unknown,
    balanced,
    estimate,
    fewest_rows,
    formula,
    refuse_short,
    solve,
)
from symoro_elastic.analysis.identification.filtering import DRAWS, Filter, average
from symoro_elastic.analysis.identification.friction_laws import (
    CONVERGED,
    EXACT,
    LAWS,
    LOAD,
    ROUNDS,
    FrictionLaws,
    Motion,
    groups_of,
    refuse_laws,
    without_cogging,
)
from symoro_elastic.analysis.identification.late_columns import (
    Delays,
    Late,
    delays_of,
    late_velocities,
    moved_back,
    said_of_late,
)
from symoro_elastic.analysis.identification.mistakes import mistakes_of, refuse_wrapped
from symoro_elastic.analysis.identification.noise import usual_correlation
from symoro_elastic.analysis.identification.notes import of_encoders, of_sensors
from symoro_elastic.analysis.identification.outliers import outliers_of, said_of, without
from symoro_elastic.analysis.identification.pieces import filter_of, in_pieces, refuse_rest
from symoro_elastic.analysis.identification.possible import FLOOR, Data, Linear, Possible, made_possible
from symoro_elastic.analysis.identification.regression import (
    Regressor,
    RegressorColumn,
    others_than,
    refuse_unknown_labels,
    regressor,
    zero_entries,
)
from symoro_elastic.analysis.identification.sensors import (
    AUTO,
    DELAY,
    NEVER,
    Columns,
    Sensors,
    Torques,
    sensors_of_few,
    sought_sensors,
)
from symoro_elastic.analysis.identification.spikes import without_spikes
from symoro_elastic.analysis.time_series.measurements import Measurements
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.progress import Announce, announce_nothing
from symoro_elastic.foundation.results import Result
from symoro_elastic.foundation.sizes import refuse_numbers
from symoro_elastic.machine.machine import Machine
from symoro_elastic.numerics.independence import IndependentColumns, independent_columns
from symoro_elastic.numerics.independent_joints import moved_by

STRUCTURAL = 1e-8  # independence at random states, of columns of length 1
RANK_STATES = 60  # random states of the structural rank
FEWEST_REVERSALS, SLOW = 2, 0.1  # of joints in a record that is not short; slow: of the largest velocity
MOST_LATE = 6  # steps to late columns
FAR = 200  # samples that tell what a unit of a parameter exerts


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
    sensors: Sensors = field(default_factory=Sensors)
    possible: Possible | None = None
    laws: FrictionLaws = field(default_factory=FrictionLaws)

    @property
    def machine(self) -> Machine:
        """The machine, with the values of its file."""
        return self.equations.machine

    @property
    def estimates(self) -> tuple[Estimate, ...]:
        """One for each parameter or group."""
        return self.estimation.estimates

    @property
    def delay(self) -> float:
        """How much later torques are than positions, s; zero where it is not sought."""
        late = [e.value for e in self.estimates if e.unknown.quantity == DELAY and math.isfinite(e.value)]
        return late[0] if late else 0.0

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
    offsets: str = AUTO,
    delay: str = AUTO,
    trust: float | None = None,
    laws: FrictionLaws | None = None,
    robust: bool = False,
    unseen: Sequence[str] = (),
    seek: Sequence[str] = (),
) -> Identification:
    """Return the parameters of a machine from one or several records of measurements.

    `values` are numbers of its named parameters (geometry), `known` values of columns that are not sought
    (`M13`, `FS5`: weighed, or taken as zero), `bandwidth` that of the motion in Hz if the spectrum is not to
    decide. `filtered` False uses measurements as they are. `offsets` of torques and their `delay` are sought "auto",
    "always" or "never". `trust` is how far the file may be from the truth: bodies are possible, records may be short.
    `laws` are of friction beyond FV and FS. `robust` leaves out averages that stand out. Torques do not show `unseen`
    columns; `seek` are bodies or labels that alone are sought. Raises `InputError`.
    """
    records = [measured] if isinstance(measured, Measurements) else list(measured)
    step("filter")
    chosen = filter_of(records, _driven(machine), bandwidth) if filtered else None
    parted = [_continuous(record, chosen, machine) for record in records]
    step("trace")
    Y = Y or regressor(without_cogging(machine), values)
    step("group")
    equations = _grouped(machine, Y, _known(Y.columns, known or {}, machine, unseen, seek))
    _refuse_amount(parted, chosen, len(equations.kept), trust is not None)
    step("stack")
    stack, late = _in_time(partial(_Stack, equations, chosen=chosen, laws=laws or FrictionLaws()), parted, delay)
    step("solve")
    stack.hide(unseen)
    sensors, estimation, tau, bodies = stack.estimated(offsets, delay, trust, robust)
    notes = *stack.notes(), *said_of_late(late, machine), *estimation.notes, *of_sensors(estimation, sensors, machine)
    notes += *(bodies.notes if bodies else ()), *mistakes_of(equations, stack.sampled, estimation.estimates)
    springs = _springs(estimation, stack.columns.Y, len(equations.kept))
    rest = springs, _neutral(estimation, machine), sensors, bodies, stack.laws
    return Identification(equations, estimation, stack.t, tau, chosen, notes, *rest)


def _in_time(
    stacked: Callable[[Sequence[Sequence[Measurements]]], _Stack], parted: Sequence[Sequence[Measurements]], delay: str
) -> tuple[_Stack, list[Late]]:
    """Return the rows of records whose columns are moved back that lag others by whole samples, and these.

    None is moved unless all are in time then.
    """
    first = stack = stacked(parted)
    if delay == NEVER or (chosen := first.sampled[0].chosen) is None:
        return first, []
    longest = max((record for pieces in parted for record in pieces), key=lambda record: len(record.t))
    late = {one.key: one for one in late_velocities(longest, chosen)}

    def moved() -> _Stack:
        return stacked([[moved_back(record, late.values()) for record in pieces] for pieces in parted])

    if late:
        stack = moved()
    for _ in range(MOST_LATE):
        delays = stack.delays()
        if delays is None or (one := delays.clear) is None:
            break
        before = late[one.key].whole if one.key in late else 0
        late[one.key] = replace(one, samples=one.whole + before)
        stack = moved()
    in_time = delays is None or (not delays.clear and all(map(delays.leaves, late.values())))
    if not in_time:
        return first, []
    found = [one for one in late.values() if one.whole]
    return stack, [replace(one, std=delays.now(one).std) for one in found] if delays else found


class _Stack:
    """Rows of the pieces of several records, and what is estimated from them."""

    def __init__(
        self, equations: Equations, parted: Sequence[Sequence[Measurements]], chosen: Filter | None, laws: FrictionLaws
    ) -> None:
        refuse_laws(equations.machine, laws)
        records = [piece for pieces in parted for piece in pieces]
        self._numbers = [k for k, pieces in enumerate(parted) for _ in pieces]
        self._equations, self._source, self.laws = equations, records[0].source, replace(laws, records=len(parted))
        self.sampled = [equations.sampled(record, chosen) for record in records]
        rows = [equations.rows(sampled) for sampled in self.sampled]
        self.t = np.concatenate([x.t for x in rows])
        given = np.concatenate([x.given for x in rows])
        self._still = tuple(sorted(set.intersection(*(set(x.still) for x in rows))))
        noise = _noises(rows)
        Y, offsets = np.concatenate([x.Y for x in rows]), np.concatenate([x.offsets for x in rows])
        correlation, period = np.concatenate([x.correlation for x in rows], axis=1), records[0].period
        fastest = 1 / chosen.motion if chosen else float(records[0].t[-1] - records[0].t[0])
        repeating = any(x.motion.staircases for x in self.sampled)
        torques, draws = _torques(equations, self.sampled, given), _draws(equations, self.sampled)
        self.columns = Columns(
            Y, noise, offsets, torques, correlation, period, fastest, repeating, draws if repeating else None
        )
        _refuse_zero_torques(self.columns.torques(0.0)[0], self._source)
        self._plain = self.columns
        self._said: list[str] = []
        self._unsettled: list[str] = []

    def notes(self) -> list[str]:
        """Return notes on records, filters, columns and encoders."""
        machine, columns, kept = self._equations.machine, self._equations.Y.columns, self._equations.kept
        of_columns = *_without_effect(self._equations.linear), *_zero_in_the_table(machine, [columns[c] for c in kept])
        first, names = self.sampled[0], [joint.name for joint in self._equations.machine.independent_joints]
        silent = {k: None for x in self.sampled for k in self._equations.unmeasured(x.record, x.motion.still)}
        unmeasured = [f"{names[k]} is held still, and its torques are zero throughout: not measured" for k in silent]
        notes = [line for x in self.sampled for line in x.record.warnings]
        notes += [*(first.chosen.described() if first.chosen else ()), *of_columns, *unmeasured, *self._said]
        notes += self._unsettled
        longest = dict(sorted(zip(self._numbers, self.sampled, strict=True), key=_samples)).values()
        return notes + [line for x in longest for line in of_encoders(x.record, x.motion, x.chosen, names)]

    def delays(self) -> Delays | None:
        """Return how late columns are; None where rows are too few."""
        if self._is_short(self.columns.Y.shape[2]):
            return None
        return delays_of(self._equations, self.sampled, self.columns)

    def _is_short(self, parameters: int) -> bool:
        """Return whether rows are too few for least squares alone, or joints hardly reverse."""
        few = _used(self.columns.Y) < fewest_rows(parameters, usual_correlation(self.columns.correlation))
        return few or float(np.median(sum(_reversals(x.motion.qd) for x in self.sampled))) < FEWEST_REVERSALS

    def _of_laws(self) -> tuple[Array, Array]:
        """Return columns of groups with those of laws of friction, and what load friction adds to right sides."""
        Y, linear, plain = self._equations.Y, self._equations.linear, self._plain.Y
        used = np.asarray(plain.any(axis=2))
        more = self._averaged(lambda k, motion: self.laws.columns(Y, linear, motion, k)) * used[:, :, None]
        right = np.zeros(used.shape)
        if self.laws.gains:
            slopes = self._averaged(lambda _, motion: self.laws.slopes(Y, linear, motion)) * used[:, :, None]
            plain, right = plain + slopes[:, :, :-1], slopes[:, :, -1]
        return np.concatenate([plain, more], axis=2), right

    def _averaged(self, columns_of: Callable[[int, Motion], Array]) -> Array:
        """Return averages of columns, which number of record and motion give, (rows, n, k)."""
        found = []
        for k, x in zip(self._numbers, self.sampled, strict=True):
            used = x.counted[:, :, None].astype(float)
            each = [columns_of(k, x.motion.part(piece)) * used[piece] for piece in x.pieces]
            found += [np.concatenate([average(y, x.chosen) if x.chosen else y for y in each]) * x.scale[:, :, None]]
        return np.concatenate(found)

    def hide(self, unseen: Sequence[str]) -> None:
        """Say what it changes that columns are not sought, which torques do not show."""
        if not unseen:
            return
        Y, joined = self._equations.Y, self.columns.joined(range(self.columns.offsets.shape[2]), None)[0]
        hidden = [c for c, column in enumerate(Y.columns) if column.label in unseen]
        more = np.concatenate([joined, self._averaged(lambda _, motion: Y.evaluate(*motion, hidden))], axis=2)
        tau = self.columns.torques(0.0)[0]
        what = f"torques behind transmissions, {', '.join(unseen)} are not sought: residuals {_left(joined, tau):.3g} %"
        self._said.append(f"{what} of the torque, {_left(more, tau):.3g} % if they were")

    def _leave_out(self) -> None:
        """Leave out rows that stand out, and name them."""
        rows, used = outliers_of(self.columns), np.asarray(self.columns.Y.any(axis=2))
        names = [joint.name for joint in self._equations.machine.independent_joints]
        self._said += said_of(self.t, rows, used, names)
        self.columns, self._plain = without(self.columns, rows), without(self._plain, rows)

    def _with_laws(self, sensors: Sensors) -> None:
        """Add the columns of laws of friction, about a fit beside what is sought of sensors."""
        linear, plain = self._equations.linear, self._plain
        (tau, slopes), count, self._unsettled = plain.torques(sensors.delay), plain.Y.shape[2], []
        beside = plain.joined(sensors.offsets, slopes if sensors.has_delay else None)[0][:, :, count:]
        if self.laws.load and not self.laws.X:
            X = groups_of(np.concatenate([plain.Y, beside], axis=2), tau, count)[0]
            self.laws = self.laws.about(linear, X.tolist())
        own = count + len(self.laws.load)
        for _ in range(ROUNDS):
            Y, right = self._of_laws()
            if own == count:
                break
            X, std = groups_of(np.concatenate([Y, beside], axis=2), tau - right, own)
            before = np.array([*self.laws.X.values(), *(self.laws.gains.get(j, 0.0) for j in self.laws.load)])
            X[count:] += before[count:]
            if (np.abs(X - before) <= CONVERGED * std + EXACT * np.abs(X)).all():
                break
            self.laws = self.laws.about(linear, X[:count].tolist(), X[count:].tolist())
        else:
            self._unsettled = [
                f"load friction: not settled after {ROUNDS} steps, so its standard deviations are too small"
            ]
        noise = tuple(np.concatenate([D, np.zeros((*D.shape[:2], Y.shape[2] - count))], axis=2) for D in plain.noise)
        torques: Torques = lambda delay: (plain.torques(delay)[0] - right, plain.torques(delay)[1])  # noqa: E731
        self.columns = replace(plain, Y=Y, noise=noise, torques=torques)

    def _say_of_laws(self) -> None:
        """Say what laws of friction change."""
        with_it, plain = self.columns, self._plain
        count, unknowns = plain.Y.shape[2], self.laws.unknowns(self._equations.machine, self._equations.linear)
        for title, kinds in LAWS.items():
            rest = [count + k for k, x in enumerate(unknowns) if x.quantity not in kinds]
            if len(rest) < len(unknowns):
                own = plain if LOAD in kinds else with_it
                Y = np.concatenate([own.Y[:, :, :count], with_it.Y[:, :, rest], plain.offsets], axis=2)
                both = np.concatenate([with_it.Y, plain.offsets], axis=2)
                self._say(title, (both, with_it.torques(0.0)[0]), (Y, own.torques(0.0)[0]))

    def _say(self, title: str, with_it: tuple[Array, Array], without_it: tuple[Array, Array]) -> None:
        """Say by how much residuals of columns and torques change."""
        after, before = _left(*with_it), _left(*without_it)
        self._said.append(f"{title}: residuals {after:.3g} % of the torque with it, {before:.3g} % without")

    def _say_of(self, sensors: Sensors, Y: Array, tau: Array, slopes: Array) -> None:
        """Say what offsets and a delay change."""
        columns = self.columns
        if sensors.offsets:
            self._say(
                "offset of torques", (Y, tau), (columns.joined((), slopes if sensors.has_delay else None)[0], tau)
            )
        if sensors.has_delay:
            at_once = columns.joined(sensors.offsets, None)[0], columns.torques(0.0)[0]
            self._say("delay of torques", (Y, tau), at_once)

    def _exerted(self) -> Array:
        """Return what a unit of each column exerts at most on each joint, (n, columns)."""
        Y = self._equations.Y
        some = [x.motion.part(slice(None, None, max(1, len(x.motion.t) // FAR))) for x in self.sampled]
        every = [np.abs(Y.evaluate(*motion, range(len(Y.columns)))).max(axis=0, initial=0.0) for motion in some]
        most: Array = np.max(every, axis=0)
        return most

    def _sought(self, offsets: str, delay: str, may_be_few: bool, robust: bool) -> tuple[Sensors, bool]:
        """Return what is sought of sensors, and whether rows are few; columns are then with laws of friction."""
        has_laws = bool(self.laws.unknowns(self._equations.machine, self._equations.linear))
        if has_laws:
            self._with_laws(Sensors(tuple(range(self.columns.offsets.shape[2]))))
        if robust:
            self._leave_out()
        columns, count = self.columns, self.columns.Y.shape[2]
        if not may_be_few:
            refuse_short(_used(columns.Y), count, usual_correlation(columns.correlation), self._source)
        is_short = self._is_short(count)
        sensors = sensors_of_few(columns, offsets, delay) if is_short else sought_sensors(columns, offsets, delay)
        if self.laws.load:
            self._with_laws(sensors)
        if has_laws:
            self._say_of_laws()
        return sensors, is_short

    def estimated(
        self, offsets: str, delay: str, trust: float | None, robust: bool
    ) -> tuple[Sensors, Estimation, Array, Possible | None]:
        """Return what is sought of sensors, the estimation, left sides, and bodies if they are to be possible.

        Records may then be short: offsets are sought, a delay only where it must be.
        """
        machine, linear = self._equations.machine, self._equations.linear
        sensors, is_short = self._sought(offsets, delay, trust is not None, robust)
        columns, unknowns = self.columns, [*_unknowns(linear), *self.laws.unknowns(machine, linear)]
        tau, slopes = columns.torques(sensors.delay)
        Y, noise = columns.joined(sensors.offsets, slopes if sensors.has_delay else None)
        if not is_short:
            self._say_of(sensors, Y, tau, slopes)
        every = [*unknowns, *sensors.unknowns(machine)]
        names = tuple(joint.name for joint in machine.independent_joints)
        data = None if trust is None else Data(Y, tau, self._exerted(), is_short)
        sigma = FLOOR * data.largest if data and is_short else None
        estimation = estimate(
            Y, tau, every, names, self._still, noise=noise, correlation=columns.correlation,
            repeating=columns.repeating, draws=columns.draws, doubts=sensors.doubts(columns),
            source=self._source, least=0 if trust is not None else FEWEST_ROWS, sigma=sigma,
        )  # fmt: skip
        bodies = None
        if data and trust is not None:
            estimation, bodies = made_possible(machine, linear, data, estimation, trust)
        measured = self._plain.torques(sensors.delay)[0]
        solution = replace(estimation.solution, predicted=estimation.solution.predicted + (measured - tau))
        return sensors, replace(estimation, solution=solution), measured, bodies


def _noises(rows: Sequence[Rows]) -> tuple[Array, ...]:
    """Return noises of Y of all records; those of records with fewer repeat, for their mean square counts."""
    count = max(len(x.noise) for x in rows)
    each = [[x.noise[i % len(x.noise)] if x.noise else np.zeros_like(x.Y) for x in rows] for i in range(count)]
    return tuple(np.concatenate(part) for part in each)


def _left(Y: Array, tau: Array) -> float:
    """Return residuals of least squares in per cent of torques, joints alike."""
    kept = list(independent_columns(balanced(Y), FROM_DATA).kept)
    found = solve(Y[:, :, kept], tau)
    moved = np.flatnonzero(tau.any(axis=0))
    return float(100 * np.mean([np.linalg.norm(found.residuals[:, k]) / np.linalg.norm(tau[:, k]) for k in moved]))


def _torques(equations: Equations, records: Sequence[Sampled], given: Array) -> Torques:
    """Return the function from a delay to left sides, torques so much later than positions, and their slopes."""

    def late(delay: float) -> tuple[Array, Array]:
        each = zip(*(equations.torques(sampled, delay) for sampled in records), strict=True)
        left, slopes = (np.concatenate(x) for x in each)
        return left - given, slopes

    return late


def _draws(equations: Equations, records: Sequence[Sampled]) -> Draws:
    """Return the function from X, of the machine and others, to what draws of noise of positions make of Y X."""

    def drawn(X: Array) -> list[Array]:
        own = X[: len(equations.kept)]
        each = [equations.draws(sampled, own) or [np.zeros_like(sampled.scale)] for sampled in records]
        return [np.concatenate([rows[i % len(rows)] for rows in each]) for i in range(DRAWS)]

    return drawn


def _samples(numbered: tuple[int, Sampled]) -> tuple[int, int]:
    """Return the number of a record, and how many samples a piece of it has."""
    return numbered[0], len(numbered[1].motion.t)


def _reversals(qd: Array) -> Array:
    """Return how often velocities (samples, n) change their sign, (n), slow ones aside: these may be noise."""
    fast = np.abs(qd) > SLOW * np.abs(qd).max(axis=0, initial=0.0)
    each = [np.sign(rate[used]) for rate, used in zip(qd.T, fast.T, strict=True)]
    return np.array([np.count_nonzero(np.diff(signs)) for signs in each])


def _used(Y: Array) -> int:
    """Return how many rows are not zero."""
    return int((np.abs(Y).max(axis=2, initial=0.0) > 0).sum())


def _refuse_zero_torques(tau: Array, source: str) -> None:
    if not tau.any():
        what = "is zero throughout, so every parameter could be zero: check the columns, or give known values"
        raise InputError(source, "tau", what)


def _equations(records: Sequence[Measurements], chosen: Filter | None) -> int:
    """Return how many rows records give at most."""
    if chosen is None:
        return sum(record.q.size for record in records)
    return sum(len(chosen.starts(len(record.t) - 2 * chosen.trim)) * record.q.shape[1] for record in records)


def _refuse_amount(
    parted: Sequence[Sequence[Measurements]], chosen: Filter | None, parameters: int, may_be_few: bool
) -> None:
    """Raise `InputError` for records at rest, for too few equations, unless they may be few, and for those that have no
    room; those with both twins of noise count."""
    records = [piece for pieces in parted for piece in pieces]
    if chosen:
        refuse_rest(records, chosen)
    rows, source = _equations(records, chosen), records[0].source
    if not may_be_few:
        refuse_short(rows, parameters, chosen.correlation if chosen else (1.0,), source)
    what = f"{rows} equations after filtering for {parameters} parameters"
    way_out = "use less of the record (--after, --before), or a lower --bandwidth"
    refuse_numbers(3 * rows * parameters, what, source, "t", way_out)


def _springs(estimation: Estimation, Y: Array, count: int) -> Array:
    """Return the forces of springs and dampers by the estimates."""
    own = [(k, c) for k, c in enumerate(estimation.grouping.kept) if c < count]
    kept = [(k, c) for k, c in own if estimation.estimates[c].unknown.quantity in ("K", "DA", "KQ")]
    return Y[:, :, [c for _, c in kept]] @ estimation.solution.X[[k for k, _ in kept]]


def _continuous(record: Measurements, chosen: Filter | None, machine: Machine) -> list[Measurements]:
    """Return the pieces of a record without gaps and spikes."""
    if chosen is None:
        return in_pieces(record, chosen)
    pieces = [without_spikes(piece, chosen, machine) for piece in in_pieces(record, chosen)]
    for piece in pieces:
        refuse_wrapped(piece, machine)
    return pieces


def _driven(machine: Machine) -> list[int]:
    """Return the indices in q of motors, and of joints that motors on dependent joints move."""
    moved = {k for j in machine.motors if j in machine.dependent for k in moved_by(machine, j)}
    return sorted({*machine.motor_entries, *machine.entries(moved)})


def _known(
    columns: Sequence[RegressorColumn],
    known: Mapping[str, float],
    machine: Machine,
    unseen: Sequence[str],
    seek: Sequence[str],
) -> dict[int, float]:
    """Return values of columns that are not sought, by number."""
    refuse_unknown_labels(machine, known, columns)
    known = {**others_than(machine, seek, columns), **dict.fromkeys(unseen, 0.0), **known}
    numbers = {column.label: c for c, column in enumerate(columns)}
    for label, value in known.items():
        if not math.isfinite(value):
            raise machine.error(f"--known, {label}", "give it a number")
    return {numbers[label]: value for label, value in known.items()}


def _grouped(machine: Machine, Y: Regressor, known: Mapping[int, float]) -> Equations:
    """Return the equations of a machine with the columns that are not known, grouped."""
    sought = tuple(c for c in range(len(Y.columns)) if c not in known)
    if not sought:
        raise machine.error("bodies", "no parameter has a part in the torques, or all are known: nothing is sought")
    return Equations(machine, Y, Linear(Y.columns, sought, structural_grouping(Y, sought, machine), known))


def structural_grouping(Y: Regressor, sought: Sequence[int], machine: Machine, seed: int = 0) -> IndependentColumns:
    """Return independent columns and how the others join them, at random states."""
    W = Y.evaluate(*Y.states(RANK_STATES, seed), sought)
    if not np.isfinite(W).all():
        raise machine.error("regressor", "has no value at ordinary positions")
    return independent_columns(W.reshape(-1, len(sought)), STRUCTURAL)


def _unknowns(linear: Linear) -> list[Unknown]:
    columns, sought, structure = linear.columns, linear.sought, linear.structure
    nominal = structure.apply(np.array([columns[c].value for c in sought]))
    unknowns = []
    for k, kept in enumerate(structure.kept):
        column = columns[sought[kept]]
        joined = [(columns[sought[c]].label, b) for c, b in structure.terms(k)]
        text = formula(column.label, joined)
        unknowns.append(Unknown(column.label, text, column.unit, column.joint, column.quantity, float(nominal[k])))
    return unknowns


def _without_effect(linear: Linear) -> list[str]:
    labels = ", ".join(linear.columns[linear.sought[c]].label for c in linear.structure.vanishing)
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
