"""From measurements to parameters: filter, stack averages, group, solve, judge."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from symoro_elastic.analysis.time_series.measurements import Measurements, refuse_wrapped
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.progress import Announce, announce_nothing
from symoro_elastic.machine.machine import Machine
from symoro_elastic.measured.fitting.estimates import ROUNDING, Unknown
from symoro_elastic.measured.logs import friction_laws
from symoro_elastic.measured.logs.equations import Equations, Rows, Sampled
from symoro_elastic.measured.logs.estimation import (
    FEWEST_ROWS,
    Estimation,
    LinearModel,
    estimate,
    fewest_rows,
    formula,
    independent_solution,
    refuse_short,
    without_hidden_rows,
)
from symoro_elastic.measured.logs.filtering import DRAWS, Filter, average, notes_on_encoders
from symoro_elastic.measured.logs.late_columns import (
    Delays,
    Late,
    delays_of,
    late_velocities,
    moved_back,
    notes_on_late_columns,
)
from symoro_elastic.measured.logs.mistakes import mistakes_of
from symoro_elastic.measured.logs.noise import Draws, RowNoise, usual_correlation
from symoro_elastic.measured.logs.outliers import notes_on_outliers, outliers_of, without, without_spikes
from symoro_elastic.measured.logs.pieces import filter_of, in_pieces, refuse_amount
from symoro_elastic.measured.logs.possible import FLOOR, Data, Linear, Possible, made_possible
from symoro_elastic.measured.logs.result import Identification, agree
from symoro_elastic.measured.logs.sensors import (
    AUTO,
    NEVER,
    ROUNDS,
    Columns,
    Sensors,
    Torques,
    notes_on_sensors,
    sensors_of_short_record,
    sought_sensors,
)
from symoro_elastic.numerics.linear.independence import IndependentColumns, independent_columns
from symoro_elastic.numerics.linear.regressor import (
    Regressor,
    RegressorColumn,
    others_than,
    refuse_unknown_labels,
    regressor,
    zero_entries,
)
from symoro_elastic.numerics.motion.independent_joints import moved_by

STRUCTURAL = 1e-8  # independence at random states, of columns of length 1
RANK_STATES = 60  # random states of the structural rank
FEWEST_REVERSALS = 2  # of a joint, in the median, in a record that is not short
SLOW = 0.1  # of the largest velocity: slower samples do not count as reversals
MOST_STAYING = 0.9  # of the samples at an end of a range: the others are within the noise
SAMPLES = 200  # of the torques by a unit of a parameter


@dataclass(frozen=True)
class LogSettings:
    """Settings of an identification from logs.

    `values` are numbers of named parameters (geometry), `known` values of columns that are not estimated (`M13`, `FS5`:
    weighed, or zero), `seek` bodies or labels that alone are estimated, `unseen` columns that torques do not depend on
    (measured behind transmissions). `bandwidth` of the motion, Hz, if the spectrum is not to decide; with `filtered`
    False measurements are used as they are. `offsets` of torques and their `delay` are estimated "auto", "always" or
    "never". `trust` is the relative deviation of the file's values from the truth: bodies are physically consistent
    then, records may be short. `laws` are of friction beyond FV and FS. `robust` omits averages that stand out. With
    `is_evidence` for a joint fit, driven joints are estimated alone where noise hides parameters of the others.
    """

    values: Mapping[str, float] | None = None
    known: Mapping[str, float] = field(default_factory=dict)
    seek: tuple[str, ...] = ()
    unseen: tuple[str, ...] = ()
    bandwidth: float | None = None
    filtered: bool = True
    offsets: str = AUTO
    delay: str = AUTO
    trust: float | None = None
    laws: friction_laws.FrictionLaws = field(default_factory=friction_laws.FrictionLaws)
    robust: bool = False
    is_evidence: bool = False


def identify(
    machine: Machine,
    measured: Measurements | Sequence[Measurements],
    settings: LogSettings | None = None,
    step: Announce = announce_nothing,
    Y: Regressor | None = None,
) -> Identification:
    """Return the parameters of a machine from one or several records of measurements.

    Raises `InputError` for records without torques or excitation, and for labels that do not exist.
    """
    settings = settings or LogSettings()
    records = [measured] if isinstance(measured, Measurements) else list(measured)
    for record in records:
        refuse_wrapped(record, machine)
    step("filter")
    chosen = filter_of(records, _driven(machine), settings.bandwidth) if settings.filtered else None
    pieces_of_records = [in_pieces(record, chosen) for record in records]
    if chosen:
        pieces_of_records = [[without_spikes(piece, chosen, machine) for piece in some] for some in pieces_of_records]
    step("trace")
    Y = Y or regressor(friction_laws.without_cogging(machine), settings.values)
    step("group")
    equations = _base_equations(machine, Y, _fixed_columns(Y.columns, settings, machine))
    refuse_amount(pieces_of_records, chosen, len(equations.estimated_columns), settings.trust is not None)
    step("stack")
    stacked = partial(_Stack, equations, chosen=chosen, laws=settings.laws)
    fit = partial(_fit, stacked, pieces_of_records, settings, step)
    result, staying = fit(())
    agreeing = [m for m in staying if agree(result, fit([m])[0])]
    return fit(agreeing)[0] if agreeing else result


def _fit(
    stacked: Callable[..., _Stack],
    pieces_of_records: Sequence[Sequence[Measurements]],
    settings: LogSettings,
    step: Announce,
    trusted: Collection[int],
) -> tuple[Identification, list[int]]:
    """Return the identification, and the motors whose torques saturate; saturation of `trusted` motors is ignored."""
    stack, late = _in_time(partial(stacked, trusted=trusted), pieces_of_records, settings.delay)
    step("solve")
    try:
        return stack.identification(late, settings), stack.staying
    except InputError as error:
        raise InputError(error.file, error.place, "; ".join([error.what, *stack.notes_on_clipping()])) from None


def _in_time(
    stacked: Callable[[Sequence[Sequence[Measurements]]], _Stack],
    pieces_of_records: Sequence[Sequence[Measurements]],
    delay: str,
) -> tuple[_Stack, list[Late]]:
    """Return rows of records whose columns are shifted to be in time by whole samples, and the late columns.

    None is moved unless all are in time then.
    """
    first = stack = stacked(pieces_of_records)
    if delay == NEVER or (chosen := first.sampled[0].chosen) is None:
        return first, []
    longest = max((record for pieces in pieces_of_records for record in pieces), key=lambda record: len(record.t))
    late = {column.key: column for column in late_velocities(longest, chosen)}

    def shifted_stack() -> _Stack:
        return stacked([[moved_back(record, late.values()) for record in pieces] for pieces in pieces_of_records])

    if late:
        stack = shifted_stack()
    for _ in range(ROUNDS):
        delays = stack.delays()
        if delays is None or (column := delays.clear or delays.still(late.values())) is None:
            break
        before = late[column.key].whole if column.key in late else 0
        late[column.key] = replace(column, samples=column.whole + before)
        stack = shifted_stack()
    in_time = delays is None or (not delays.clear and all(map(delays.leaves, late.values())))
    if not in_time:
        stack, late, delays = first, {}, first.delays()
    moved_columns = [replace(column, torques=None) for column in late.values() if column.whole]
    if delays is None:
        return stack, moved_columns
    return stack, [*(replace(x, std=delays.now(x).std) for x in moved_columns), *(delays.likely or delays.rivals)]


class _Stack:
    """Rows of the pieces of several records, and the estimation from them."""

    def __init__(
        self,
        equations: Equations,
        pieces: Sequence[Sequence[Measurements]],
        chosen: Filter | None,
        laws: friction_laws.FrictionLaws,
        trusted: Collection[int] = (),
    ) -> None:
        """`pieces` are listed by record; torques of `trusted` motors (0-based) count at an end of their range."""
        friction_laws.refuse_laws(equations.machine, laws)
        records = [piece for some in pieces for piece in some]
        self._numbers = [k for k, some in enumerate(pieces) for _ in some]
        self._equations, self._source, self.laws = equations, records[0].source, replace(laws, records=len(pieces))
        self.sampled = [equations.sample(record, chosen, trusted) for record in records]
        rows = [equations.rows(sampled) for sampled in self.sampled]
        self.t = np.concatenate([x.t for x in rows])
        fixed_torques = np.concatenate([x.given for x in rows])
        self._still = tuple(sorted(set.intersection(*(set(x.still) for x in rows))))
        Y, offsets = np.concatenate([x.Y for x in rows]), np.concatenate([x.offsets for x in rows])
        correlation, period = np.concatenate([x.correlation for x in rows], axis=1), records[0].period
        fastest = 1 / chosen.motion if chosen else float(records[0].t[-1] - records[0].t[0])
        repeating = any(x.motion.staircases for x in self.sampled)
        torques, draws = _torques(equations, self.sampled, fixed_torques), _draws(equations, self.sampled)
        noise = RowNoise(_noises(rows), correlation, repeating, draws if repeating else None)
        self.columns = Columns(Y, offsets, torques, noise, period, fastest)
        if max((x.staying.mean(axis=0).max(initial=0.0) for x in self.sampled), default=0.0) > MOST_STAYING:
            raise InputError(
                self._source, "tau", f"hardly anything is left of it: {'; '.join(self.notes_on_clipping())}"
            )
        if not self.columns.torques(0.0)[0].any():
            what = "is zero throughout, so every parameter could be zero: check the columns, or give known values"
            raise InputError(self._source, "tau", what)
        self._plain = self.columns
        self.driven: Estimation | None = None
        self._notes: list[str] = []
        self._unsettled: list[str] = []

    @property
    def staying(self) -> list[int]:
        """Motors (0-based) whose torques stay at an end of their range, or do not change."""
        motors: list[int] = np.flatnonzero(np.any([x.staying.any(axis=0) for x in self.sampled], axis=0)).tolist()
        return motors

    def notes_on_clipping(self) -> list[str]:
        """Return a line for each motor whose torques stay at an end of their range, or do not change."""
        staying = np.concatenate([x.staying for x in self.sampled])
        tau = np.concatenate([x.motion.tau for x in self.sampled])
        lines = []
        for m, joint in enumerate(self._equations.machine.motor_joints):
            if not (where := staying[:, m]).any():
                continue
            values = " and ".join(f"{x:.4g}" for x in np.unique(tau[where, m].round(12))[:3])
            first, share = int(np.argmax(where)), 100 * where.mean()
            what = f"stays at {values} {joint.force_unit} at {share:.2g} % of the samples, from sample {first + 1} on"
            lines.append(f"tau_{joint.name} {what}, as beyond the range of a sensor: these samples are left out")
        return lines

    def identification(self, late: Sequence[Late], settings: LogSettings) -> Identification:
        """Return the estimates with notes."""
        self._note_unseen(settings.unseen)
        equations, machine = self._equations, self._equations.machine
        sensors, estimation, tau, bodies = self.estimation_with_sensors(settings, late)
        notes = [*self.notes(), *notes_on_late_columns(late, machine), *estimation.notes]
        notes += [*notes_on_sensors(estimation, sensors, machine), *(bodies.notes if bodies else ())]
        notes += mistakes_of(equations, self.sampled, estimation.estimates)
        springs = _springs(estimation, self.columns.Y, len(equations.estimated_columns))
        parts = springs, _neutral(estimation, machine), sensors, bodies, self.laws, self.driven
        return Identification(equations, estimation, self.t, tau, self.sampled[0].chosen, tuple(notes), *parts)

    def notes(self) -> list[str]:
        """Return notes on records, filters, columns and encoders."""
        machine, columns, kept = self._equations.machine, self._equations.Y.columns, self._equations.estimated_columns
        of_columns = *_without_effect(self._equations.linear), *_zero_in_the_table(machine, [columns[c] for c in kept])
        first, names = self.sampled[0], [joint.name for joint in self._equations.machine.independent_joints]
        silent = {k: None for x in self.sampled for k in self._equations.unmeasured_joints(x.record, x.motion.still)}
        unmeasured = [f"{names[k]} is held still, and its torques are zero throughout: not measured" for k in silent]
        notes = [*(line for x in self.sampled for line in x.record.warnings), *self.notes_on_clipping()]
        notes += [*(first.chosen.description() if first.chosen else ()), *of_columns, *unmeasured, *self._notes]
        notes += self._unsettled
        by_length = sorted(zip(self._numbers, self.sampled, strict=True), key=lambda pair: len(pair[1].motion.t))
        longest = [dict(by_length)[k] for k in sorted({*self._numbers})]
        return notes + [line for x in longest for line in notes_on_encoders(x.record, x.motion, x.chosen, names)]

    def delays(self) -> Delays | None:
        """Return the delays of columns; None where rows are too few."""
        if self._is_short(self.columns.Y.shape[2]):
            return None
        return delays_of(self._equations, self.sampled, self.columns)

    def _is_short(self, parameters: int) -> bool:
        """Return whether rows are too few for least squares alone, or joints hardly reverse."""
        few = _nonzero_rows(self.columns.Y) < fewest_rows(parameters, usual_correlation(self.columns.correlation))
        return few or float(np.median(sum(_reversals(x.motion.qd) for x in self.sampled))) < FEWEST_REVERSALS

    def _of_laws(self) -> tuple[Array, Array]:
        """Return regressor columns with those of friction laws, and the load friction to add to right-hand sides."""
        Y, linear, plain = self._equations.Y, self._equations.linear, self._plain.Y
        used = np.asarray(plain.any(axis=2))
        more = self._averages_of(lambda k, motion: self.laws.columns(Y, linear, motion, k)) * used[:, :, None]
        right = np.zeros(used.shape)
        if self.laws.gains:
            slopes = self._averages_of(lambda _, motion: self.laws.slopes(Y, linear, motion)) * used[:, :, None]
            plain, right = plain + slopes[:, :, :-1], slopes[:, :, -1]
        return np.concatenate([plain, more], axis=2), right

    def _averages_of(self, columns_of: Callable[[int, friction_laws.Motion], Array]) -> Array:
        """Return averages (rows, n, k) of the columns that `columns_of` computes from record number and motion."""
        averages = []
        for k, x in zip(self._numbers, self.sampled, strict=True):
            used, scale = x.counted[:, :, None].astype(float), x.scale[:, :, None]
            columns = (columns_of(k, x.motion.part(piece)) * used[piece] for piece in x.pieces)
            averages.append(np.concatenate([average(y, x.chosen) if x.chosen else y for y in columns]) * scale)
        return np.concatenate(averages)

    def _note_unseen(self, unseen: Sequence[str]) -> None:
        """Note how residuals change without the parameters that load-side torques do not contain."""
        if not unseen:
            return
        Y, joined = self._equations.Y, self.columns.with_sensor_columns(range(self.columns.offsets.shape[2]), None)[0]
        hidden = [c for c, column in enumerate(Y.columns) if column.label in unseen]
        more = np.concatenate([joined, self._averages_of(lambda _, motion: Y.evaluate(*motion, hidden))], axis=2)
        before, after = (_residual_percent(columns, self.columns.torques(0.0)[0]) for columns in (joined, more))
        what = f"torques behind transmissions, {', '.join(unseen)} are not sought: residuals {before:.3g} %"
        self._notes.append(f"{what} of the torque, {after:.3g} % if they were")

    def _with_laws(self, sensors: Sensors) -> None:
        """Add the columns of laws of friction, linear about a fit with the terms of sensors."""
        linear, plain = self._equations.linear, self._plain
        (tau, slopes), count, self._unsettled = plain.torques(sensors.delay), plain.Y.shape[2], []
        sensor_columns = plain.with_sensor_columns(sensors.offsets, slopes if sensors.has_delay else None)[0][
            :, :, count:
        ]
        if self.laws.load and not self.laws.X:
            X = friction_laws.groups_of(np.concatenate([plain.Y, sensor_columns], axis=2), tau, count)[0]
            self.laws = self.laws.about(linear, X.tolist())
        own = count + len(self.laws.load)
        for _ in range(friction_laws.ROUNDS):
            Y, right = self._of_laws()
            if own == count:
                break
            X, std = friction_laws.groups_of(np.concatenate([Y, sensor_columns], axis=2), tau - right, own)
            before = np.array([*self.laws.X.values(), *(self.laws.gains.get(j, 0.0) for j in self.laws.load)])
            X[count:] += before[count:]
            if (np.abs(X - before) <= friction_laws.CONVERGED * std + ROUNDING * np.abs(X)).all():
                break
            self.laws = self.laws.about(linear, X[:count].tolist(), X[count:].tolist())
        else:
            steps = f"load friction: not settled after {friction_laws.ROUNDS} steps"
            self._unsettled = [f"{steps}, so its standard deviations are too small"]
        noise = plain.noise.with_exact(Y.shape[2] - count)
        torques: Torques = lambda delay: (plain.torques(delay)[0] - right, plain.torques(delay)[1])  # noqa: E731
        self.columns = replace(plain, Y=Y, noise=noise, torques=torques)

    def _note_friction_laws(self) -> None:
        """Note how residuals change without laws of friction."""
        with_it, plain = self.columns, self._plain
        count, unknowns = plain.Y.shape[2], self.laws.unknowns(self._equations.machine, self._equations.linear)
        for title, kinds in friction_laws.LAWS.items():
            other_laws = [count + k for k, x in enumerate(unknowns) if x.quantity not in kinds]
            if len(other_laws) < len(unknowns):
                own = plain if friction_laws.LOAD in kinds else with_it
                Y = np.concatenate([own.Y[:, :, :count], with_it.Y[:, :, other_laws], plain.offsets], axis=2)
                both = np.concatenate([with_it.Y, plain.offsets], axis=2)
                self._note_residuals(title, (both, with_it.torques(0.0)[0]), (Y, own.torques(0.0)[0]))

    def _note_residuals(self, title: str, with_it: tuple[Array, Array], without_it: tuple[Array, Array]) -> None:
        """Note by how much residuals of columns and torques change."""
        after, before = _residual_percent(*with_it), _residual_percent(*without_it)
        self._notes.append(f"{title}: residuals {after:.3g} % of the torque with it, {before:.3g} % without")

    def _note_sensor_terms(self, sensors: Sensors, Y: Array, tau: Array, slopes: Array) -> None:
        """Note how residuals change without offsets and a delay."""
        columns = self.columns
        if sensors.offsets:
            without = columns.with_sensor_columns((), slopes if sensors.has_delay else None)[0]
            self._note_residuals("offset of torques", (Y, tau), (without, tau))
        if sensors.has_delay:
            at_once = columns.with_sensor_columns(sensors.offsets, None)[0], columns.torques(0.0)[0]
            self._note_residuals("delay of torques", (Y, tau), at_once)

    def _largest_torques(self) -> Array:
        """Return the largest joint torques per unit of each regressor column, (n, columns)."""
        Y = self._equations.Y
        some = [x.motion.part(slice(None, None, max(1, len(x.motion.t) // SAMPLES))) for x in self.sampled]
        every = [np.abs(Y.evaluate(*motion, range(len(Y.columns)))).max(axis=0, initial=0.0) for motion in some]
        most: Array = np.max(every, axis=0)
        return most

    def _sensor_terms(self, settings: LogSettings) -> tuple[Sensors, bool]:
        """Return the sensor terms to estimate, and whether rows are few; adds columns of friction laws."""
        has_laws = bool(self.laws.unknowns(self._equations.machine, self._equations.linear))
        if has_laws:
            self._with_laws(Sensors(tuple(range(self.columns.offsets.shape[2]))))
        if settings.robust:
            rows, used = outliers_of(self.columns), np.asarray(self.columns.Y.any(axis=2))
            self._notes += notes_on_outliers(
                self.t, rows, used, [x.name for x in self._equations.machine.independent_joints]
            )
            self.columns, self._plain = without(self.columns, rows), without(self._plain, rows)
        columns, count = self.columns, self.columns.Y.shape[2]
        if settings.trust is None:
            refuse_short(_nonzero_rows(columns.Y), count, usual_correlation(columns.correlation), self._source)
        is_short = self._is_short(count)
        sensors = (sensors_of_short_record if is_short else sought_sensors)(columns, settings.offsets, settings.delay)
        if self.laws.load:
            self._with_laws(sensors)
        if has_laws:
            self._note_friction_laws()
        return sensors, is_short

    def estimation_with_sensors(
        self, settings: LogSettings, late: Sequence[Late] = ()
    ) -> tuple[Sensors, Estimation, Array, Possible | None]:
        """Return sensor terms, the estimation, measured torques, and consistent bodies if these are requested.

        Records may then be short: offsets are sought, a delay only where it must be.
        """
        machine, linear = self._equations.machine, self._equations.linear
        sensors, is_short = self._sensor_terms(settings)
        trust = settings.trust
        columns, unknowns = self.columns, [*_unknowns(linear), *self.laws.unknowns(machine, linear)]
        tau, slopes = columns.torques(sensors.delay)
        Y, noise = columns.with_sensor_columns(sensors.offsets, slopes if sensors.has_delay else None)
        if not is_short:
            self._note_sensor_terms(sensors, Y, tau, slopes)
        every = [*unknowns, *sensors.unknowns(machine)]
        names = tuple(joint.name for joint in machine.independent_joints)
        data = None if trust is None else Data(Y, tau, self._largest_torques(), is_short)
        sigma = FLOOR * data.largest if data and is_short else None
        of_late = [x.torques for x in late if x.torques is not None]
        noise = replace(noise, systematic=[*sensors.doubts(columns), *of_late])
        model = LinearModel(Y, tau, every, names, noise, self._still, self._source)
        estimation = estimate(model, 0 if trust is not None else FEWEST_ROWS, sigma)
        if settings.is_evidence and estimation.hidden:
            self.driven = without_hidden_rows(model, estimation)
        bodies = None
        if data and trust is not None:
            estimation, bodies = made_possible(machine, linear, data, estimation, trust)
        measured = self._plain.torques(sensors.delay)[0]
        solution = replace(estimation.solution, predicted=estimation.solution.predicted + (measured - tau))
        return sensors, replace(estimation, solution=solution), measured, bodies


def _noises(rows: Sequence[Rows]) -> tuple[Array, ...]:
    """Return noises of Y of all records, equal in number: those of records with fewer repeat."""
    count = max(len(x.noise) for x in rows)
    twins = [[x.noise[i % len(x.noise)] if x.noise else np.zeros_like(x.Y) for x in rows] for i in range(count)]
    return tuple(np.concatenate(part) for part in twins)


def _residual_percent(Y: Array, tau: Array) -> float:
    """Return residuals of least squares in per cent of torques, the mean over joints."""
    solution = independent_solution(Y, tau)[1]
    moved = np.flatnonzero(tau.any(axis=0))
    return float(100 * np.mean([np.linalg.norm(solution.residuals[:, k]) / np.linalg.norm(tau[:, k]) for k in moved]))


def _torques(equations: Equations, records: Sequence[Sampled], fixed: Array) -> Torques:
    """Return the function from a delay, s, to measured torques less fixed ones, and their derivatives by time."""

    def late(delay: float) -> tuple[Array, Array]:
        pairs = zip(*(equations.torques(sampled, delay) for sampled in records), strict=True)
        torques, slopes = (np.concatenate(x) for x in pairs)
        return torques - fixed, slopes

    return late


def _draws(equations: Equations, records: Sequence[Sampled]) -> Draws:
    """Return the function from parameters X to changes of Y X for drawn position noise."""

    def draws_of_records(X: Array) -> list[Array]:
        own = X[: len(equations.estimated_columns)]
        draws = [equations.draws(sampled, own) or [np.zeros_like(sampled.scale)] for sampled in records]
        return [np.concatenate([rows[i % len(rows)] for rows in draws]) for i in range(DRAWS)]

    return draws_of_records


def _reversals(qd: Array) -> Array:
    """Return how often velocities (samples, n) change their sign, (n), slow ones aside: these may be noise."""
    fast = np.abs(qd) > SLOW * np.abs(qd).max(axis=0, initial=0.0)
    signs_of_joints = [np.sign(rate[used]) for rate, used in zip(qd.T, fast.T, strict=True)]
    return np.array([np.count_nonzero(np.diff(signs)) for signs in signs_of_joints])


def _nonzero_rows(Y: Array) -> int:
    """Return how many rows are not zero."""
    return int((np.abs(Y).max(axis=2, initial=0.0) > 0).sum())


def _springs(estimation: Estimation, Y: Array, count: int) -> Array:
    """Return the estimated torques of springs and dampers."""
    own = [(k, c) for k, c in enumerate(estimation.grouping.kept) if c < count]
    of_springs = [(k, c) for k, c in own if estimation.estimates[c].unknown.quantity in ("K", "DA", "KQ")]
    return Y[:, :, [c for _, c in of_springs]] @ estimation.solution.X[[k for k, _ in of_springs]]


def _driven(machine: Machine) -> list[int]:
    """Return the indices in q of motors, and of joints that motors on dependent joints move."""
    moved = {k for j in machine.motors if j in machine.dependent for k in moved_by(machine, j)}
    return sorted({*machine.motor_entries, *machine.entries(moved)})


def _fixed_columns(columns: Sequence[RegressorColumn], settings: LogSettings, machine: Machine) -> dict[int, float]:
    """Return fixed values of columns that are not estimated, by number."""
    fixed = settings.known
    refuse_unknown_labels(machine, fixed, columns)
    fixed = {**others_than(machine, settings.seek, columns), **dict.fromkeys(settings.unseen, 0.0), **fixed}
    numbers = {column.label: c for c, column in enumerate(columns)}
    for label, value in fixed.items():
        if not math.isfinite(value):
            raise machine.error(f"--known, {label}", "give it a number")
    return {numbers[label]: value for label, value in fixed.items()}


def _base_equations(machine: Machine, Y: Regressor, fixed: Mapping[int, float]) -> Equations:
    """Return the equations of a machine with its free columns grouped into base parameters."""
    sought = tuple(c for c in range(len(Y.columns)) if c not in fixed)
    if not sought:
        raise machine.error("bodies", "no parameter has a part in the torques, or all are known: nothing is sought")
    return Equations(machine, Y, Linear(Y.columns, sought, structural_grouping(Y, sought, machine), fixed))


def structural_grouping(Y: Regressor, sought: Sequence[int], machine: Machine, seed: int = 0) -> IndependentColumns:
    """Return independent columns, and the combinations that give the others, from random states."""
    W = Y.evaluate(*Y.states(RANK_STATES, seed), sought)
    if not np.isfinite(W).all():
        raise machine.error("regressor", "has no value at ordinary positions")
    return independent_columns(W.reshape(-1, len(sought)), STRUCTURAL)


def _unknowns(linear: Linear) -> list[Unknown]:
    columns, sought, structure = linear.columns, linear.sought, linear.structure
    nominal = structure.apply(np.array([columns[c].value for c in sought]))
    unknowns = []
    for k, column_of_group in enumerate(structure.kept):
        column = columns[sought[column_of_group]]
        joined = [(columns[sought[c]].label, b) for c, b in structure.terms(k)]
        text = formula(column.label, joined)
        value = float(nominal[k])
        unknowns.append(
            Unknown(column.label, column.unit, value, formula=text, joint=column.joint, quantity=column.quantity)
        )
    return unknowns


def _without_effect(linear: Linear) -> list[str]:
    labels = ", ".join(linear.columns[linear.sought[c]].label for c in linear.structure.vanishing)
    return [f"without effect on any torque of this machine: {labels}"] if labels else []


def _neutral(estimation: Estimation, machine: Machine) -> dict[str, tuple[float, float]]:
    """Return q0 = KQ / K and its standard deviation by first order, for elastic joints with both estimates."""
    unknowns = [estimation.estimates[c].unknown for c in estimation.grouping.kept]
    places = {(unknown.joint, unknown.quantity): k for k, unknown in enumerate(unknowns)}
    neutral = {}
    for joint in map(machine.joint, machine.sprung):
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
