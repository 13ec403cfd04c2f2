"""How honest standard deviations are for logs as they are, and for each option of `identify`:
`python -m tests.benchmarks.logs [--runs N] [--first N] [--only CASE ...] [--json FILE] [--store] [--stored]`
(OPENBLAS_NUM_THREADS=1).

An arm of two joints, gravity, dry friction; motion, noise of torques, zeros of encoders (17 bits), lost samples and
gaps are drawn anew in each run. Torques are those of the model plus laws that are written out here. `wider` is the
median of standard deviations over those of the plain log, `zeros` the share of values sought in vain (an offset, a
delay, a law of friction that is not there) that are within 1.96 standard deviations.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache, cached_property
from pathlib import Path
from typing import Any

import numpy as np

from symoro_elastic.analysis.simulation.simulated_measurements import Controller, Sensors, measure, simulate
from symoro_elastic.analysis.time_series.clocks import part_of, tidy
from symoro_elastic.analysis.time_series.measurements import Measurements
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.labels import ParameterLabels
from symoro_elastic.machine.machine import Body, Friction, Kind, Machine, Spring
from symoro_elastic.measured.logs.fourier_motion import FourierMotion, Limits, random_motion
from symoro_elastic.measured.logs.friction_laws import FrictionLaws
from symoro_elastic.measured.logs.identify import LogSettings, identify
from symoro_elastic.measured.logs.result import Identification
from symoro_elastic.numerics.linear.regressor import Regressor, regressor
from symoro_elastic.numerics.verification.implementations import numpy_model
from tests.benchmarks.identification import FAULTS, Fault, bare, errors_of, run_of_log, with_friction
from tests.benchmarks.machines import Row, built
from tests.benchmarks.possible import TWICE, off
from tests.benchmarks.tables import Run, add_options, has_table_run, print_table, progress, save_json

RUNS, DURATION, RATE = 40, 15.0, 250.0
NOISE, STEP, FINE = np.array([0.3, 0.1]), 2 * np.pi / 2**17, 2e-6
OFFSETS, LATE = np.array([0.8, -0.3]), 0.006
LOAD, STATIC, VELOCITY, WARMER = 0.08, 1.2, 0.15, 0.7
WRONG = 0.3  # relative deviation of the bodies of a wrong file


@cache
def arm() -> Machine:
    """Return an arm of two joints with rotors and dry friction, about a horizontal axis each."""
    machine = built("log_arm", [Row("lift", 0, "pi/2", mass=12), Row("elbow", 1, "0", d=0.4, mass=5)])
    return with_friction(machine, {"lift": (3.0, 2.5), "elbow": (1.0, 1.2)})


@cache
def _y(name: str) -> Regressor:
    return regressor(next(one() for one in (arm, elastic, wrist) if one().name == name))


@cache
def _torques(is_bare: bool) -> Callable[..., Array]:
    """Return the torques of a motion, of the arm or of its bodies alone."""
    zero = Formula.parse(0)
    bare = tuple(replace(j, friction=Friction(zero, zero), rotor_inertia=zero, ratio=zero) for j in arm().joints)
    model = numpy_model(replace(arm(), joints=bare) if is_bare else arm(), ("inverse_dynamics",))
    return lambda *motion: np.array(model.inverse_dynamics(*motion)[0])


Record = Callable[[int], Measurements | list[Measurements]]
"""From the number of a run, its log, or several."""


@dataclass(frozen=True)
class Draw:
    """A run: its motion, its times and its noise."""

    seed: int
    late: float = 0.0
    jitter: float = 0.0

    @cached_property
    def rng(self) -> np.random.Generator:
        """Numbers of the run."""
        return np.random.default_rng([self.seed, 27])

    @cached_property
    def motion(self) -> FourierMotion:
        """A motion of its own."""
        return random_motion(Limits.of([-2.0] * 2, [2.0] * 2, [3.0] * 2, [15.0] * 2), 0.2, 10, self.seed)

    @cached_property
    def t(self) -> Array:
        """Times of the samples."""
        count = round(DURATION * RATE)
        return (np.arange(count) + self.jitter * self.rng.uniform(-1, 1, count)) / RATE

    @cached_property
    def exact(self) -> tuple[Array, Array, Array]:
        """Motion when torques are taken."""
        return self.motion.at(self.t - self.late)

    @cached_property
    def bodies(self) -> Array:
        """Torques without friction and rotors."""
        return _torques(True)(*self.exact)

    def record(self, more: Array | float = 0.0, tau: Array | None = None) -> Measurements:
        """Return what is measured, with more torques, or others."""
        q = self.motion.at(self.t)[0]
        zero = STEP * self.rng.uniform(-0.5, 0.5, 2)
        tau = _torques(False)(*self.exact) if tau is None else tau
        noisy = tau + more + NOISE * self.rng.standard_normal(tau.shape)
        return Measurements(self.t, np.round((q + zero) / STEP) * STEP, noisy)


def _plain(seed: int) -> Measurements:
    return Draw(seed).record()


def _lost(seed: int) -> Measurements:
    draw = Draw(seed)
    return part_of(draw.record(), draw.rng.uniform(size=len(draw.t)) > 0.05)


def _gaps(seed: int) -> Measurements:
    draw = Draw(seed)
    kept = np.ones(len(draw.t), dtype=bool)
    for first in draw.rng.integers(500, len(kept) - 500, 3):
        kept[first : first + 200] = False
    return part_of(draw.record(), kept)


def _stamps(seed: int) -> Measurements:
    draw = Draw(seed)
    record = draw.record()
    return replace(record, t=record.t + 0.3 / RATE * draw.rng.uniform(-1, 1, len(record.t)))


def _damaged(seed: int) -> Measurements:
    draw = Draw(seed)
    record = draw.record()
    record.tau[draw.rng.uniform(size=len(draw.t)) < 0.02, 1] = np.nan
    return record


def _touched(seed: int) -> Measurements:
    """Return a log with two contacts of a quarter of a second."""
    draw = Draw(seed)
    more = np.zeros((len(draw.t), 2))
    for first in draw.rng.integers(500, len(more) - 500, 2):
        more[first : first + 60] = [25.0, 12.0]
    return draw.record(more)


def _spiked(seed: int, size: float | Array = 10 * NOISE) -> Measurements:
    draw = Draw(seed)
    hit = draw.rng.uniform(size=(len(draw.t), 2)) < 0.01
    return draw.record(np.where(hit, size * np.sign(draw.rng.standard_normal(hit.shape)), 0.0))


def _loaded(seed: int) -> Measurements:
    draw = Draw(seed)
    return draw.record(LOAD * np.abs(draw.bodies) * np.sign(draw.exact[1]))


def _stribeck(seed: int) -> Measurements:
    draw = Draw(seed)
    return draw.record(STATIC * np.sign(draw.exact[1]) / (1 + (draw.exact[1] / VELOCITY) ** 2))


def _behind(seed: int) -> Measurements:
    draw = Draw(seed)
    return draw.record(tau=draw.bodies)


def _two(seed: int) -> list[Measurements]:
    """Return a cold record and a warm one, of less friction."""
    cold, warm = Draw(seed), Draw(seed + 1000)
    rate = warm.exact[1]
    return [cold.record(), warm.record((WARMER - 1) * (np.array([3.0, 1.0]) * rate + [2.5, 1.2] * np.sign(rate)))]


@cache
def elastic() -> Machine:
    """Return the arm with a spring in place of the second motor."""
    zero, machine = Formula.parse(0), arm()
    spring = Spring(*map(Formula.parse, (600.0, 0.8, 0.01)))
    soft = replace(
        machine.joints[1],
        kind=Kind.ELASTIC,
        spring=spring,
        friction=Friction(zero, zero),
        rotor_inertia=zero,
        ratio=zero,
    )
    return replace(machine, name="elastic_arm", joints=(machine.joints[0], soft))


def _shaken(seed: int, step: float = STEP / 8) -> Measurements:
    """Return a log of the elastic arm; `step` is that of the encoder at the spring."""
    motion = random_motion(Limits.of([-2.0], [2.0], [3.0], [15.0]), 0.2, 10, seed)
    controller = Controller.of_bandwidth([6.0], frequency=4.0)
    true = simulate(elastic(), {}, motion.at, controller, DURATION, RATE, settle=2 * motion.period)
    return measure(true, Sensors(np.array([STEP, step]), np.full(2, FINE), NOISE[:1]), seed)


@cache
def wrist() -> Machine:
    """Return the arm whose second motor turns by the sum of both joints, with friction of motor and joint."""
    lift, elbow = arm().joints
    drive = replace(lift, name="drive", variable="qm", body=Body(), friction=elbow.friction)
    motor = replace(drive, rotor_inertia=elbow.reflected_inertia, ratio=Formula.parse(0))
    driven = replace(elbow, kind=Kind.COUPLED, variable=None, rotor_inertia=Formula.parse(0), ratio=Formula.parse(0))
    law = Friction(*map(Formula.parse, (0.5, 0.4)))
    driven = replace(driven, theta=Formula.parse(f"qm - {lift.variable}"), friction=law)
    return replace(arm(), name="wrist_arm", joints=(lift, motor, driven))


def _coupled(seed: int) -> Measurements:
    """Return a log of the wrist: positions and torques of its motors."""
    draw = Draw(seed)
    return draw.record(tau=_of_wrist()(*draw.exact))


@cache
def _of_wrist() -> Callable[..., Array]:
    """Return the torques of a motion of the wrist."""
    model = numpy_model(wrist(), ("inverse_dynamics",))
    return lambda *motion: np.array(model.inverse_dynamics(*motion)[0])


@dataclass(frozen=True)
class Case:
    """A log of a run, what is asked of `identify`, and true values of what is no parameter of the file."""

    record: Record = _plain
    asked: Mapping[str, Any] = field(default_factory=dict)
    truth: Mapping[str, float] = field(default_factory=dict)
    wrong: float = 0.0
    machine: Callable[[], Machine] = arm

    def identified(self, seed: int) -> Identification:
        """Return what is found in a run."""
        machine = self.machine()
        given = self.record(seed)
        records = [tidy(x, machine) for x in (given if isinstance(given, list) else [given])]
        if self.wrong:
            return identify(off(machine, self.wrong, seed), records, LogSettings(**self.asked))
        return identify(machine, records, LogSettings(**self.asked), Y=_y(machine.name))


BOTH = (1, 2)
NEVER: dict[str, Any] = {"offsets": "never", "delay": "never"}
HIDDEN = [ParameterLabels(arm())(j, quantity) for j in BOTH for quantity in ("IA", "FV", "FS")]
LAWS: dict[str, tuple[FrictionLaws, Record, dict[str, float]]] = {
    "load friction": (FrictionLaws(load=BOTH), _loaded, {"FL1": LOAD, "FL2": LOAD}),
    "Stribeck": (FrictionLaws(stribeck=dict.fromkeys(BOTH, VELOCITY)), _stribeck, {"FB1": STATIC, "FB2": STATIC}),
    "temperatures": (
        FrictionLaws(changing=True), _two,
        {"FV1_2": 3.0 * (WARMER - 1), "FV2_2": WARMER - 1, "FS1_2": 2.5 * (WARMER - 1), "FS2_2": 1.2 * (WARMER - 1)},
    ),
}  # fmt: skip
CASES = {
    "plain": Case(),
    "plain, nothing sought": Case(asked=NEVER),
    "5 % of samples lost": Case(_lost),
    "3 gaps of 0.8 s": Case(_gaps),
    "uneven by 40 %": Case(lambda seed: Draw(seed, jitter=0.4).record()),
    "stamps scatter by 30 %": Case(_stamps),
    "2 % NaN": Case(_damaged),
    "1 % spikes of 10 std": Case(_spiked),
    "1 % spikes of 10 torques": Case(lambda seed: _spiked(seed, 10 * float(np.ptp(Draw(seed).record().tau)))),
    "contacts": Case(_touched),
    "contacts, robust": Case(_touched, {"robust": True}),
    "plain, robust": Case(asked={"robust": True}),
    "offsets": Case(lambda seed: Draw(seed).record(OFFSETS), truth={"OFF1": OFFSETS[0], "OFF2": OFFSETS[1]}),
    "offsets of an eighth": Case(
        lambda seed: Draw(seed).record(OFFSETS / 8), truth={"OFF1": OFFSETS[0] / 8, "OFF2": OFFSETS[1] / 8}
    ),
    "offsets of zero": Case(asked={"offsets": "always"}, truth={"OFF1": 0.0, "OFF2": 0.0}),
    "delay of 6 ms": Case(lambda seed: Draw(seed, late=LATE).record(), truth={"delay": LATE}),
    "delay of zero": Case(asked={"delay": "always"}, truth={"delay": 0.0}),
    **{name: Case(record, {"laws": law}, truth) for name, (law, record, truth) in LAWS.items()},
    "load friction of zero": Case(asked={"laws": LAWS["load friction"][0]}, truth={"FL1": 0.0, "FL2": 0.0}),
    "Stribeck of zero": Case(asked={"laws": LAWS["Stribeck"][0]}, truth={"FB1": 0.0, "FB2": 0.0}),
    "link side": Case(_behind, {"unseen": HIDDEN}),
    "possible": Case(asked={"trust": math.inf}, wrong=WRONG),
    "possible, trust 0.3": Case(asked={"trust": WRONG}, wrong=WRONG),
    "possible, trust 0.1 named wrongly": Case(asked={"trust": 0.1}, wrong=WRONG),
    "file off by 2": Case(wrong=TWICE),
    "possible, file off by 2": Case(asked={"trust": math.inf}, wrong=TWICE),
    "load friction, possible": Case(
        _loaded, {"laws": LAWS["load friction"][0], "trust": math.inf}, LAWS["load friction"][2], wrong=WRONG
    ),
    "springs": Case(_shaken, machine=elastic),
    "springs, 17 bits": Case(lambda seed: _shaken(seed, STEP), machine=elastic),
    "springs, possible": Case(_shaken, {"trust": math.inf}, wrong=WRONG, machine=elastic),
    "springs, possible, trust 0.3": Case(_shaken, {"trust": WRONG}, wrong=WRONG, machine=elastic),
    "coupled wrist": Case(_coupled, machine=wrist),
}


def _factors(k: int, factor: float) -> Array:
    return np.where(np.arange(2) == k, factor, 1.0)


def _dead_band(tau: Array) -> Array:
    """Torques of the elbow by a sensor that shows zero for most of them."""
    return np.where((abs(tau) < np.quantile(abs(tau), 0.8, axis=0)) & (np.arange(2) == 1), 0.0, tau)


Change = Callable[[Measurements], Measurements]


def replaced(block: str, change: Callable[[Array], Array]) -> Change:
    """Return a change of one of t, q, tau."""
    return lambda record: replace(record, **{block: change(getattr(record, block))})  # type: ignore[arg-type]


def _of_motor(record: Measurements) -> Measurements:
    ratio = _factors(1, -50.0)
    return replace(record, q=record.q * ratio, tau=record.tau / ratio)


_MISTAKES: dict[str, tuple[Change, str]] = {
    "degrees": (replaced("q", np.rad2deg), "positions are in degrees"),
    "sign of q": (replaced("q", lambda q: q * _factors(1, -1.0)), "q_elbow has the opposite sign"),
    "tau exchanged": (replaced("tau", lambda tau: tau[:, ::-1]), "tau_lift and tau_elbow are exchanged"),
    "joints exchanged": (
        lambda x: replace(x, q=x.q[:, ::-1], tau=x.tau[:, ::-1]), "columns of lift and elbow are exchanged"
    ),
    "gain 0.01": (replaced("tau", lambda tau: tau * _factors(0, 0.01)), "give --gain"),
    "gain 1000": (replaced("tau", lambda tau: tau * _factors(1, 1000.0)), "give --gain elbow="),
    "zero torque": (
        replaced("tau", lambda tau: tau * _factors(1, 0.0)), "tau_elbow does not change while the joint moves"
    ),
    "dead band": (replaced("tau", _dead_band), "tau_elbow is 0 at "),
    "signs of tau": (replaced("tau", lambda tau: -tau), "all torques have the opposite sign"),
    "all torques 0.01": (replaced("tau", lambda tau: tau / 100), "all values are 0.0"),
    "minutes": (replaced("t", lambda t: t / 60), "t is in minutes"),
    "q of the motor": (
        replaced("q", lambda q: q * _factors(0, 81.0)), "q_lift is of the motor, not the joint, with a ratio of about "
    ),
    "motor": (_of_motor, "q_elbow and tau_elbow are of the motor, not the joint, with a ratio of about -"),
    "velocity": (lambda x: replace(x, tau=np.gradient(x.q, x.t, axis=0)), "is the velocity of"),
    "absolute values": (replaced("tau", np.abs), "tau_lift, tau_elbow: absolute values, whose signs are lost"),
}  # fmt: skip


def _fault(change: Change, reported: str) -> Fault:
    return Fault(lambda record, _: change(record), reported)


MISTAKES = {name: _fault(*mistake) for name, mistake in _MISTAKES.items()}
"""Mistakes in the columns of a log of the arm."""
REPORTED = {"1 % spikes of 10 torques": "spikes", "contacts, robust": "stand out"}
"""Words by which notes report what disturbs a case."""
TABLE = {
    **{title: 3 if case.machine is elastic else 6 for title, case in CASES.items()},
    **{f"plain, {name}": 6 for name in ("late column", "clipped column")},
    **{f"mistake: {name}": 3 for name in MISTAKES},
}

OF_MACHINES = {arm().name: "plain", elastic().name: "springs", wrist().name: "coupled wrist"}
"""Logs whose file is right, by machine."""


def truth_of(case: Case) -> dict[str, float]:
    """Return true values by label: of groups of the right file, and of what is no parameter."""
    right = case if "unseen" in case.asked else CASES[OF_MACHINES[case.machine().name]]
    found = {e.unknown.label: e.unknown.nominal for e in right.identified(0).estimates} | dict(case.truth)
    return {bare(label): x for label, x in found.items()}


def deviations(found: Identification, truth: Mapping[str, float]) -> dict[str, tuple[float, float]]:
    """Return (estimate - truth) / std and std by label, of those with a standard deviation."""
    errors = errors_of(found, truth)
    return {label: (e.error / e.std, e.std) for label, e in errors.items() if math.isfinite(e.std)}


def table_run(row: str, seed: int) -> Run:
    """Return a run of a row of the stored table."""
    if row in CASES:
        case = CASES[row]
        return run_of_log(seed, lambda: case.identified(seed), REPORTED.get(row, ""), _truth(row))
    kind, name = row.split(": " if row.startswith("mistake") else ", ")
    fault = MISTAKES[name] if kind == "mistake" else FAULTS[name]
    case = Case(lambda seed: fault.change(Draw(seed).record(), np.random.default_rng([seed, 5])))
    return run_of_log(seed, lambda: case.identified(seed), fault.reported, _truth("plain"))


@cache
def _truth(title: str) -> dict[str, float]:
    return truth_of(CASES[title])


def figures(title: str, runs: int, first: int, plain: Mapping[str, float]) -> tuple[dict[str, Any], dict[str, float]]:
    """Return shares within 95 % intervals, and median standard deviations by label."""
    case = CASES[title]
    truth, each, refused = truth_of(case), [], 0
    for seed in progress(range(first, first + runs), title):
        try:
            each.append(deviations(case.identified(seed), truth))
        except InputError as error:
            refused += 1
            print(title, seed, error)
    z = np.array([x for one in each for x, _ in one.values()])
    own = np.array([one[label][0] for one in each for label in map(bare, case.truth) if label in one])
    std = {label: float(np.median([one[label][1] for one in each if label in one])) for label in each[0]}
    wider = [x / plain[label] for label, x in std.items() if label in plain] or [1.0]
    return {
        "runs": len(each), "refused": refused, "estimates": len(z), "within 95 %": float((np.abs(z) < 1.96).mean()),
        "rms": float(np.sqrt((z**2).mean())), "largest": float(np.abs(z).max()), "wider": float(np.median(wider)),
        "own, within 95 %": float((np.abs(own) < 1.96).mean()) if len(own) else math.nan,
    }, std  # fmt: skip


def table(titles: Sequence[str], runs: int, first: int = 0) -> dict[str, dict[str, Any]]:
    """Return the figures of cases."""
    found: dict[str, dict[str, Any]] = {}
    plain: dict[str, float] = {}
    for title in titles:
        found[title], std = figures(title, runs, first, plain)
        plain = plain or std
        print(title, found[title], flush=True)
    return found


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m tests.benchmarks.logs", description=__doc__)
    parser.add_argument("--runs", type=int, default=RUNS)
    parser.add_argument("--first", type=int, default=0, help="number of the first draw")
    parser.add_argument("--only", nargs="*", default=list(CASES))
    parser.add_argument("--json", type=Path, help="save the figures")
    add_options(parser)
    given = parser.parse_args()
    if has_table_run(given, "logs", TABLE, table_run):
        return
    found = table(given.only, given.runs, given.first)
    if given.json:
        save_json(given.json, found)
    heads = ("log, options", *next(iter(found.values())))
    rows = [(t, *(f"{x:.3g}" if isinstance(x, float) else str(x) for x in f.values())) for t, f in found.items()]
    print_table("truth within standard deviations", heads, rows)


if __name__ == "__main__":
    main()
