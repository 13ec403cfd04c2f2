"""Exciting trajectories: periodic motions within the limits of the motors with a low condition number.

Finite Fourier series (Swevers et al. 1997), joint i at time t, with w the pulsation of the slowest harmonic:
q = q0 + sum_l (a_l sin(l w t) - b_l cos(l w t)) / (l w). The condition number is that of the stacked base
regressor (Gautier and Khalil 1992), its columns in units in which they all have length 1 on the motion that
the search starts from, so that more motion is better and units do not matter.
"""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.packages import for_identification
from symoro_elastic.machine.checks import parameter_values
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.limits import Range
from symoro_elastic.machine.machine import Machine
from symoro_elastic.measured.fitting.estimates import Unknown
from symoro_elastic.measured.logs.fourier_motion import (
    FINER,
    FourierMotion,
    Limits,
    Periodic,
    from_rest,
    random_motion,
    rise,
    with_neighbours,
    within,
)
from symoro_elastic.measured.logs.friction_laws import COSINE, SINE, FrictionLaws, refuse_laws, without_cogging
from symoro_elastic.measured.logs.identify import structural_grouping
from symoro_elastic.measured.logs.possible import Linear
from symoro_elastic.measured.logs.workspace import Box, corners
from symoro_elastic.numerics.linear.independence import IndependentColumns, independent_columns
from symoro_elastic.numerics.linear.regressor import Regressor, others_than, refuse_unknown_labels, regressor

Motion = tuple[Array, Array, Array]
PLACES = 30  # other centres of a motion that are tried
FEW_PLACES = 6  # the same, where a motion exists
SMALLER = 0.25  # of a motion, about another centre
SMALLEST = 0.15  # share of a motion below which other places are tried
EXCITED = 1e-4  # independence of columns that the search keeps
LEAST = 1e-6  # of a motion: dry friction is there as soon as it moves
STEP = 1e-4  # of the limits: step of differences
AWAY = 0.05  # of the limits, where a search starts again
OF_SPRINGS = ("K", "KQ")
PASSES = 3  # of the quasi-static response of springs


@dataclass(frozen=True)
class Excitation:
    """An exciting motion, its condition number and that of the first motion, and the excited parameters.

    Its start and its stop last `start` s. `torques` are bounds by motor from rest to rest, by the parameters of the
    machine; empty where `unknown` ones have no value. `natural` is the first natural frequency of springs, Hz.
    """

    motion: FourierMotion
    condition: float
    before: float
    history: tuple[float, ...]
    columns: tuple[str, ...]
    start: float
    torques: tuple[tuple[float, float], ...] = ()
    unknown: tuple[str, ...] = ()
    natural: float = math.inf


class Response:
    """Motion of all joints, and torques of the motors, for a motion of the motors.

    Elastic joints follow quasi-statically: k (q - q0) balances their equation at the accelerations of the pass
    before, which holds below the first natural frequency; passive joints stay at zero, or where loops start.
    """

    def __init__(
        self,
        machine: Machine,
        Y: Regressor,
        box: Box | None = None,
        loaded: Sequence[Response] = (),
        laws: ExcitedLaws | None = None,
    ) -> None:
        """`loaded` are responses with payloads, whose torques and frames keep the limits, too; `laws` of friction."""
        self.machine, self.Y, self.box, self.loaded, self.laws = machine, Y, box, tuple(loaded), laws
        self._motors = list(machine.motor_entries)
        self._springs = self._stiffness()
        self._values = np.array([column.value for column in Y.columns])

    @property
    def unknown(self) -> tuple[str, ...]:
        """Labels of the parameters without value; torques cannot be computed without them."""
        return tuple(
            x.label for x, is_finite in zip(self.Y.columns, np.isfinite(self._values), strict=True) if not is_finite
        )

    def torques(self, motion: Periodic) -> tuple[Array, Array]:
        """Return lower and upper bounds of the motor torques along a motion, (m,) each, at the machine's parameters,
        between samples too: peaks of smooth torques, reversals of dry friction, peaks of cogging.
        """
        states, dry = self.states(motion, FINER), self._dry
        smooth = [c for c in range(len(self._values)) if c not in dry]
        felt = self.Y.torques(*states, smooth, self._values[smooth]) + self.Y.loads(states[0])
        friction = self.Y.evaluate(*states, dry) @ self._values[dry]
        friction = with_neighbours(friction + self.laws.torques(states) if self.laws else friction)
        more, motors = rise(felt), self._motors
        most, least = felt + more + friction.max(axis=0), felt - more + friction.min(axis=0)
        return least[:, motors].min(axis=0) - self.cogging, most[:, motors].max(axis=0) + self.cogging

    def excess(self, motion: Periodic, torque: Sequence[Range | None]) -> float:
        """Return by how much torques leave these ranges, or frames their box, at most, as a share of a half width.

        With all payloads; -1 where nothing is limited.
        """
        limited = [(k, allowed) for k, allowed in enumerate(torque) if allowed is not None]
        responses = (self, *self.loaded)
        reached = [response.torques(motion) for response in responses] if limited else []
        of_torques = [
            max(2 * largest[k] - a.low - a.high, a.low + a.high - 2 * least[k]) / (a.high - a.low) - 1
            for least, largest in reached
            for k, a in limited
        ]
        box = self.box
        of_box = [box.excess(response.states(motion, FINER)[0]) for response in responses] if box else []
        return float(max([-1.0, *of_torques, *of_box]))

    @cached_property
    def _dry(self) -> list[int]:
        """Columns of dry friction, which are discontinuous at reversals."""
        return [c for c, column in enumerate(self.Y.columns) if column.quantity == "FS"]

    @property
    def cogging(self) -> Array:
        """Return the amplitudes of the cogging of motors, (m,)."""
        return self.laws.amplitudes[self._motors] if self.laws else np.zeros(len(self._motors))

    def states(self, motion: Periodic, finer: int = 1) -> tuple[Array, Array, Array]:
        """Return q, qd, qdd (samples, n) of all joints along a motion."""
        times = motion.times(finer)
        shape = (len(times), len(self.machine.independent))
        q, qd, qdd = np.tile(self.Y.start, (shape[0], 1)), np.zeros(shape), np.zeros(shape)
        for x, motion_of_motors in zip((q, qd, qdd), motion.at(times), strict=True):
            x[:, self._motors] = motion_of_motors
        soft, stiffness, inertial, X = self._springs
        for _ in range(PASSES if soft else 0):
            load = self.Y.evaluate(q, qd, qdd, inertial) @ X + self.Y.loads(q)
            deflection = -load[:, soft] / stiffness
            q[:, soft] = deflection + self._neutral
            qd[:, soft], qdd[:, soft] = _periodic(deflection, motion.period)
        return q, qd, qdd

    def natural(self, motion: FourierMotion) -> float:
        """Return the first natural frequency of springs along a motion, motors held, Hz; infinite without springs."""
        soft, stiffness, inertial, X = self._springs
        if not soft:
            return math.inf
        q, qd, _ = self.states(motion)
        units = [np.where(np.arange(q.shape[1]) == k, 1.0, np.zeros_like(q)) for k in soft]
        without_accelerations = self.Y.evaluate(q, qd, np.zeros_like(q), inertial)
        M = np.stack(
            [(self.Y.evaluate(q, qd, unit, inertial) - without_accelerations)[:, soft] @ X for unit in units], axis=2
        )
        root = np.sqrt(stiffness)
        return 1 / (2 * np.pi * math.sqrt(np.linalg.eigvalsh(M / np.multiply.outer(root, root)).max()))

    def _stiffness(self) -> tuple[list[int], Array, list[int], Array]:
        """Return elastic joints with known stiffness, and the inertial parameters that load them."""
        columns = self.Y.columns
        own = {j: k for k, j in enumerate(self.machine.independent)}
        values = {(x.quantity, own[x.row]): x.value for x in columns if x.row in own}
        loading = [x.quantity not in (*OF_SPRINGS, "DA", "FV", "FS") for x in columns]
        loading = [a or (x.quantity in OF_SPRINGS and x.row not in own) for a, x in zip(loading, columns, strict=True)]
        inertial = [c for c, loads in enumerate(loading) if loads]
        X = np.array([columns[c].value for c in inertial])
        soft = [k for (quantity, k), value in values.items() if quantity == "K" and value > 0]
        if not np.isfinite(X).all():
            soft = []
        stiffness = np.array([values["K", k] for k in soft])
        self._neutral = np.nan_to_num(np.array([values.get(("KQ", k), 0.0) for k in soft])) / stiffness
        return soft, stiffness, inertial, X


def within_torques(motion: FourierMotion, torque: Sequence[Range | None], response: Response) -> FourierMotion:
    """Return the motion made smaller about its centre until its torques are in these ranges, and frames in their box.

    At rest where none are.
    """

    def excess(share: float) -> float:
        return response.excess(motion.smaller(share), torque)

    if not excess(1.0) > 0:
        return motion
    if not excess(LEAST) < 0:
        return motion.smaller(0.0)
    optimize = for_identification("scipy.optimize")
    share, less = float(optimize.brentq(excess, LEAST, 1.0, xtol=1e-10)), 1e-6
    while excess(share) > 0:
        share, less = max(share * (1 - less), LEAST), min(2 * less, 0.5)
    return motion.smaller(share)


class Condition:
    """Condition number of the base regressor along a motion of the motors, with scaled rows and columns."""

    def __init__(self, response: Response, reference: FourierMotion, known: Sequence[str] = ()) -> None:
        self.Y, self.response, machine = response.Y, response, response.machine
        labels = [column.label for column in self.Y.columns]
        refuse_unknown_labels(machine, known, self.Y.columns)
        sought = [c for c, label in enumerate(labels) if label not in known]
        structure = structural_grouping(self.Y, sought, machine)
        self._kept, laws = [sought[c] for c in structure.kept], response.laws
        of_laws = laws.labels if laws else ()
        self._of_laws = [k for k, label in enumerate(of_laws) if label not in known]
        W = self._regressor_rows(reference)
        if not np.isfinite(W).all():
            what = "loops do not close all along a motion within them: give narrower positions"
            raise machine.error("limits", what)
        self._rows = np.sqrt((W**2).mean(axis=(0, 2)))
        self._rows[self._rows == 0.0] = 1.0
        flat = (W / self._rows[:, None]).reshape(-1, W.shape[2])
        excited = list(independent_columns(flat, EXCITED).kept)
        if not excited:
            raise machine.error("limits", "no motion within them excites a parameter")
        self._lengths, count = np.linalg.norm(flat[:, excited], axis=0), len(self._kept)
        self._of_laws = [self._of_laws[c - count] for c in excited if c >= count]
        self._kept = [self._kept[c] for c in excited if c < count]
        self._named = (*(labels[c] for c in self._kept), *(of_laws[k] for k in self._of_laws))

    @property
    def labels(self) -> tuple[str, ...]:
        """Parameters whose columns are independent on the reference motion."""
        return self._named

    def __call__(self, motion: FourierMotion) -> float:
        """Return the condition number of a motion."""
        return condition_number(self.scaled(motion))

    def scaled(self, motion: FourierMotion) -> Array:
        """Return the regressor along a motion, in units of rows and lengths of columns."""
        W = self._regressor_rows(motion) / self._rows[:, None]
        scaled: Array = W.reshape(-1, W.shape[2]) / self._lengths
        return scaled

    def _regressor_rows(self, motion: FourierMotion) -> Array:
        states, laws = self.response.states(motion), self.response.laws
        W = self.Y.evaluate(*states, self._kept)
        return np.concatenate([W, laws.columns(states)[:, :, self._of_laws]], axis=2) if laws else W


def condition_number(A: Array) -> float:
    """Return the ratio of the largest and the least singular value; infinite where entries are not finite."""
    return float(np.linalg.cond(A)) if np.isfinite(A).all() else math.inf


def _periodic(x: Array, period: float) -> tuple[Array, Array]:
    """Return first and second derivatives of samples (N, ...) of a period, by its Fourier series."""
    n = len(x)
    series = np.fft.rfft(x, axis=0)
    factor = 2j * np.pi * np.fft.rfftfreq(n, period / n)
    factor[np.arange(len(factor)) > n // 3] = 0.0
    return np.fft.irfft(series * factor[:, None], n, axis=0), np.fft.irfft(series * factor[:, None] ** 2, n, axis=0)


@dataclass(frozen=True)
class ExcitationSettings:
    """How an exciting motion is searched.

    `values` are numbers of named parameters, `fixed` labels that are not estimated, `seek` bodies or labels that alone
    are. `box` are ranges of positions of frames by signal (`tool.x`, m), `payloads` those of parameters by name, within
    which limits are kept. `laws` are of friction beyond FV and FS, and of cogging. The search starts from the best of
    `starts` random motions, by `seed`, and ends after so many `evaluations`.
    """

    harmonics: int = 5
    values: Mapping[str, float] = field(default_factory=dict)
    fixed: Sequence[str] = ()
    seek: Sequence[str] = ()
    box: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    payloads: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    laws: FrictionLaws = field(default_factory=FrictionLaws)
    starts: int = 10
    evaluations: int = 2000
    seed: int = 0


def excite(
    machine: Machine,
    limits: Limits,
    frequency: float,
    settings: ExcitationSettings | None = None,
    progress: Callable[[int, int, float], None] = lambda done, total, condition: None,
) -> Excitation:
    """Return an exciting trajectory: the best of random motions, then L-BFGS-B of scipy.optimize on its coefficients,
    started again near the best until the evaluations are used up.

    Any coefficients are scaled into the limits, so the search is free of constraints and every motion it visits
    keeps them. `progress` is called with evaluations done, their number, and the best condition number. Motors are
    independent joints. Deterministic by the seed. Raises `InputError`.
    """
    settings = settings or ExcitationSettings()
    optimize = for_identification("scipy.optimize")
    _refuse_following(machine)
    if len(machine.motors) != len(limits.low):
        raise machine.error("limits", f"{len(limits.low)} given, the machine has {len(machine.motors)} motors")
    response = _response(machine, settings)
    limits = replace(limits, torque=()) if response.unknown else limits
    motions = _random_motions(response, limits, frequency, settings)
    fixed = (*others_than(machine, settings.seek, response.Y.columns), *settings.fixed)
    condition = Condition(response, motions[0], fixed)
    search = _Search(condition, limits, motions[0], settings.evaluations, progress)
    for motion in motions:
        search(search.coefficients(motion))
    first = search.history[0]
    rng, start = np.random.default_rng(settings.seed), search.coefficients(search.best)
    with contextlib.suppress(_Enough):
        while True:
            optimize.minimize(search.with_slope, start, jac=True, method="L-BFGS-B", options={"maxfun": 10**6})
            start = search.coefficients(search.best)
            start += AWAY * rng.standard_normal(len(start))
    best = Excitation(search.best, search.lowest, first, tuple(search.history), condition.labels, 0.0)
    return _from_rest(best, condition, limits)


def _from_rest(excitation: Excitation, condition: Condition, limits: Limits) -> Excitation:
    """Return an excitation that starts from rest within limits, if need be a smaller one; raises `InputError`."""
    response = condition.response
    motion = from_rest(excitation.motion, limits, lambda started: response.excess(started, limits.torque) <= 0)
    if motion is None:
        what = "no start from rest, and no stop, keeps the torques in [limits] or the box of --workspace"
        raise response.machine.error("limits", f"{what}: give them more room, or other positions")
    return replace(
        excitation, motion=motion.motion, condition=condition(motion.motion), start=motion.start,
        torques=_ranges(response, motion), unknown=response.unknown, natural=response.natural(motion.motion),
    )  # fmt: skip


def _response(machine: Machine, settings: ExcitationSettings) -> Response:
    """Return the response of a machine, and those at the corners of ranges of payloads."""
    values, laws = settings.values, settings.laws
    smooth, has_laws = without_cogging(machine), laws.load or laws.stribeck or laws.cogging
    Y = regressor(smooth, values)
    within_box = Box(Y.machine, settings.box) if settings.box else None

    def of(Y: Regressor, values: Mapping[str, float], loaded: Sequence[Response] = ()) -> Response:
        return Response(smooth, Y, within_box, loaded, ExcitedLaws(machine, Y, laws, values) if has_laws else None)

    return of(Y, values, [of(regressor(smooth, x), x) for x in corners(smooth, values, settings.payloads)])


def _random_motions(
    response: Response, limits: Limits, frequency: float, settings: ExcitationSettings
) -> list[FourierMotion]:
    """Return random motions within all limits, those at rest last; raises `InputError` where all are at rest."""
    count = max(1, min(settings.starts, settings.evaluations))
    seeds = range(settings.seed, settings.seed + count)
    motions = [_first(limits, frequency, settings.harmonics, seed, response) for seed in seeds]
    motions.sort(key=lambda motion: not motion.a.any())
    if not motions[0].a.any():
        what = "gravity alone requires more than the torques in [limits] at the positions that were tried: give others"
        if response.box:
            what = "at rest, a frame is outside its box, or torques outside [limits], at the positions that were tried"
            what += ": give positions in the box (--position), or a larger box (--workspace)"
        raise response.machine.error("limits", what)
    return motions


def _first(limits: Limits, frequency: float, harmonics: int, seed: int, response: Response) -> FourierMotion:
    """Return a random motion within all limits: about the middle, or about another place where that has little room."""
    motion, rng = random_motion(limits, frequency, harmonics, seed), np.random.default_rng(seed)
    largest, size = within_torques(motion, limits.torque, response), float(np.abs(motion.a).max())
    for k in range(PLACES):
        if np.abs(largest.a).max() >= SMALLEST * size or (largest.a.any() and k >= FEW_PLACES):
            break
        elsewhere = replace(motion.smaller(SMALLER), centre=rng.uniform(limits.low, limits.high))
        other = within_torques(within(elsewhere, limits), limits.torque, response)
        largest = max(largest, other, key=lambda candidate: float(np.abs(candidate.a).max()))
    return largest


def _ranges(response: Response, motion: Periodic) -> tuple[tuple[float, float], ...]:
    """Return the least and the largest torques of motors, with all payloads; empty if parameters have no value."""
    if response.unknown:
        return ()
    least, largest = zip(*(loaded.torques(motion) for loaded in (response, *response.loaded)), strict=True)
    return tuple(zip(np.min(least, axis=0).tolist(), np.max(largest, axis=0).tolist(), strict=True))


def _refuse_following(machine: Machine) -> None:
    """Raise `InputError` for motors on dependent joints, whose motion follows from other joints."""
    following = [machine.joint(j).name for j in machine.motors if j in machine.dependent]
    if following:
        what = f"{', '.join(following)} follow from other joints, so no motion of their own excites them: name others "
        what += "in dependent ([loops]), or, where they move with other motors, make them passive in a copy of the file"
        raise machine.error("motors", what)


class _Enough(Exception):
    """Raised when the allowed number of evaluations is used up."""


class _Search:
    """Logarithm of the condition number as a function of coefficients; remembers the best motion."""

    def __init__(self, condition: Condition, limits: Limits, like: FourierMotion, most: int,
                 progress: Callable[[int, int, float], None]) -> None:  # fmt: skip
        self._condition, self._limits, self._most, self._progress = condition, limits, most, progress
        self._size = np.maximum(limits.velocity, 1e-300)[:, None]
        self.best, self.lowest, self.done = like, np.inf, 0
        self.history: list[float] = []

    def coefficients(self, motion: FourierMotion) -> Array:
        """Return centre and series of a motion as one vector, relative to the limits."""
        room = self._limits.high - self._limits.low
        middle = (motion.centre - self._limits.low) / room - 0.5
        return np.concatenate([middle, (motion.a / self._size).ravel(), (motion.b / self._size).ravel()])

    def motion(self, x: Array) -> FourierMotion:
        """Return the motion of a vector, within the limits."""
        m = len(self._limits.low)
        centre = self._limits.low + (x[:m] + 0.5) * (self._limits.high - self._limits.low)
        a, b = x[m:].reshape(2, m, -1) * self._size
        motion = within(FourierMotion(self.best.frequency, centre, a, b), self._limits)
        return within_torques(motion, self._limits.torque, self._condition.response)

    def __call__(self, x: Array) -> float:
        motion = self.motion(x)
        return self._logarithm(motion, self._condition.scaled(motion))

    def _logarithm(self, motion: FourierMotion, A: Array) -> float:
        """Count a motion with this regressor, and return the logarithm of its condition number."""
        value = condition_number(A)
        value = value if np.isfinite(value) else 1e300
        if value < self.lowest:
            self.best, self.lowest = motion, value
        self._count()
        return float(np.log(value))

    def _count(self) -> None:
        """Count an evaluated motion; raises `_Enough` where they are used up."""
        if self.done >= self._most:
            raise _Enough
        self.done += 1
        self.history.append(self.lowest)
        self._progress(self.done, self._most, self.lowest)

    def with_slope(self, x: Array) -> tuple[float, Array]:
        """Return the logarithm and its gradient.

        d log cond A = u_1' dA v_1/s_1 - u_n' dA v_n/s_n by the largest and the least singular value: dA by differences.
        """
        motion = self.motion(x)
        A = self._condition.scaled(motion)
        value = self._logarithm(motion, A)
        U, s, V = np.linalg.svd(np.nan_to_num(A), full_matrices=False)
        if not (np.isfinite(A).all() and s[-1] > 0):
            return value, np.zeros_like(x)
        weights = np.outer(U[:, 0], V[0] / s[0]) - np.outer(U[:, -1], V[-1] / s[-1])
        slope = np.zeros_like(x)
        for k, step in enumerate(STEP * np.eye(len(x))):
            self._count()
            slope[k] = np.vdot(weights, self._condition.scaled(self.motion(x + step)) - A) / STEP
        return value, slope


@dataclass(frozen=True)
class ExcitedLaws:
    """Laws beyond FV qd + FS sign(qd) of a machine with the regressor Y, about its parameters in the file.

    `values` are those of named parameters.
    """

    machine: Machine
    Y: Regressor
    laws: FrictionLaws
    values: Mapping[str, float]

    def __post_init__(self) -> None:
        """Refuse load friction if parameters have no value, and joints that follow others."""
        refuse_laws(self.machine, self.laws)
        unknown = [column.label for column in self.Y.columns if not np.isfinite(column.value)]
        if self.laws.load and unknown:
            what = f"the torques that it rises with need {', '.join(unknown)}: give values by --value"
            raise self.machine.error("--load-friction", what)

    @property
    def labels(self) -> tuple[str, ...]:
        """Labels of the columns."""
        return tuple(x.label for x in self._unknowns)

    def columns(self, motion: Motion) -> Array:
        """Return the columns of these friction laws along a motion, (samples, n, k)."""
        return self.laws.columns(self.Y, self._linear, motion)

    def torques(self, motion: Motion) -> Array:
        """Return the torques of friction beyond FV and FS by the file, (samples, n); cogging is in `amplitudes`.

        Between samples of a period they are largest: those by load as their rise, Stribeck's at the slowest rate near.
        """
        q, qd, _ = motion
        if not (self.laws.load or self.laws.stribeck):
            return np.zeros_like(q)
        count = len(self.laws.load) + len(self.laws.stribeck)
        by_column, load = self.columns(motion)[:, :, :count] * self._numbers[:count], len(self.laws.load)
        by_column[:, :, :load] += np.sign(by_column[:, :, :load]) * rise(np.abs(by_column[:, :, :load]))
        rates, half = self.Y.rates(list(self.laws.stribeck), q, qd), np.array(list(self.laws.stribeck.values()))
        near, more = with_neighbours(rates), rise(rates)
        slowest = np.maximum(np.abs(near).min(axis=0) - more, 0.0) * (near.min(axis=0) * near.max(axis=0) > 0)
        by_column[:, :, load:] *= ((1 + (rates / half) ** 2) / (1 + (slowest / half) ** 2))[:, None]
        torques: Array = by_column.sum(axis=2)
        return torques

    @cached_property
    def amplitudes(self) -> Array:
        """The amplitudes of cogging by the file, (n,): its peaks may be between samples."""
        amplitudes = np.zeros(len(self.machine.independent))
        for j in self.laws.cogging:
            amplitude = self.machine.joint(j).reflected_cogging.amplitude
            amplitudes[self.machine.independent.index(j)] = abs(self._value(amplitude))
        return amplitudes

    @cached_property
    def _unknowns(self) -> Sequence[Unknown]:
        return self.laws.unknowns(self.machine, self._linear)

    @cached_property
    def _linear(self) -> Linear:
        columns = self.Y.columns
        nothing = IndependentColumns((), (), (), np.zeros((0, 0)))
        return Linear(columns, (), nothing, {c: column.value for c, column in enumerate(columns)})

    @cached_property
    def _numbers(self) -> Array:
        """Parameters of the columns from the machine file, zero where it has none."""
        laws = {j: self.machine.joint(j).friction for j in (*self.laws.load, *self.laws.stribeck)}
        rising = [self._value(laws[j].load) for j in self.laws.load]
        static = [self._value(laws[j].static) for j in self.laws.stribeck]
        more = [x - self._value(laws[j].coulomb) if x else 0.0 for j, x in zip(self.laws.stribeck, static, strict=True)]
        return np.array([*rising, *more, *(0.0 for _ in self.laws.cogging for _ in (COSINE, SINE))])

    def _value(self, formula: Formula) -> float:
        return float(formula.value({**parameter_values(self.machine), **self.values}))
