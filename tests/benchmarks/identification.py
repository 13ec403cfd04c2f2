"""How far estimates are from the truth, in their own standard deviations, over many runs of simulated noise:
`python -m tests.benchmarks.identification [--runs N] [--json FILE] [--store] [--stored]`.

The stored table is of undisturbed records, of records with faults of sensors, and of friction that rises with load.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property, partial
from pathlib import Path
from typing import Any

import numpy as np

from symoro_elastic.analysis.simulation.simulated_measurements import Controller, Sensors, measure, simulate
from symoro_elastic.analysis.time_series.measurements import Measurements
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import Friction, Machine, Spring
from symoro_elastic.measured.fitting.estimates import Verdict
from symoro_elastic.measured.logs.fourier_motion import FourierMotion, Limits, random_motion
from symoro_elastic.measured.logs.friction_laws import LOAD, FrictionLaws
from symoro_elastic.measured.logs.identify import LogSettings, identify
from symoro_elastic.measured.logs.result import Identification
from symoro_elastic.numerics.linear.regressor import Regressor, regressor
from symoro_elastic.numerics.verification.implementations import numpy_model
from tests.benchmarks.machines import Row, arm_6, built, example
from tests.benchmarks.tables import Error, Run, add_options, has_table_run, print_table, progress, run_of, save_json

SAMPLING = 1000.0  # Hz
RUNS = 50
PERIODS = 2
SEED = 1000  # of the noise of the first run
TURN = 2 * np.pi
CONTAINED = 1e-9  # coefficient of an undetermined parameter in an estimate, below which the estimate has a truth
SPIKES, SPIKE_SIZE = 0.01, 0.5  # fraction of torques that are spikes; their size, of the range of the torque
LATE = 5  # samples
CLIPPED = 0.05  # fraction of the torques of a joint that are at the ends of its range
TABLE_RUNS = 6


@dataclass(frozen=True)
class Fault:
    """A fault of the sensors of a record, and words by which notes report it."""

    change: Callable[[Measurements, np.random.Generator], Measurements]
    reported: str


def _spiked(record: Measurements, rng: np.random.Generator) -> Measurements:
    hit = rng.uniform(size=record.tau.shape) < SPIKES
    sizes = SPIKE_SIZE * np.ptp(record.tau, axis=0) * rng.choice([-1.0, 1.0], record.tau.shape)
    return replace(record, tau=record.tau + np.where(hit, sizes, 0.0))


def _late(record: Measurements, _: np.random.Generator) -> Measurements:
    q = record.q.copy()
    q[LATE:, 0] = record.q[:-LATE, 0]
    return replace(record, t=record.t[LATE:], q=q[LATE:], tau=record.tau[LATE:])


def _clipped(record: Measurements, _: np.random.Generator) -> Measurements:
    tau = record.tau.copy()
    tau[:, 0] = np.clip(tau[:, 0], *np.quantile(tau[:, 0], [CLIPPED / 2, 1 - CLIPPED / 2]))
    return replace(record, tau=tau)


FAULTS = {
    "spikes": Fault(_spiked, "spikes"),
    "late column": Fault(_late, "buffered channel"),
    "clipped column": Fault(_clipped, "stays at"),
}


@dataclass(frozen=True)
class Case:
    """A machine, one period of its true motion, its sensors, the values that are not sought, and FL of its joints."""

    title: str
    machine: Machine
    period: Measurements
    sensors: Sensors
    known: Mapping[str, float]
    load: float = 0.0

    def record(self, periods: int, seed: int) -> Measurements:
        """Return measurements of some periods."""
        one = self.period
        t = np.arange(periods * len(one.t)) / SAMPLING
        q, tau = (np.tile(x, (periods, 1)) for x in (one.q, one.tau))
        return measure(Measurements(t, q, tau), self.sensors, seed)

    def identified(self, periods: int, seed: int, fault: Fault | None = None) -> Identification:
        """Return the parameters identified from a record of some periods, with a fault of its sensors."""
        record = self.record(periods, seed)
        record = fault.change(record, np.random.default_rng([seed, 5])) if fault else record
        laws = FrictionLaws(load=self.machine.motors if self.load else ())
        settings = LogSettings(known=self.known, laws=laws)
        return identify(self.machine, record, settings, Y=_regressor(self.machine.name))

    @cached_property
    def truth(self) -> dict[str, float] | None:
        """True values by label with those of load friction, None where all are of the file."""
        if not self.load:
            return None
        unknowns = [e.unknown for e in self.identified(PERIODS, SEED).estimates]
        return {bare(x.label): self.load if x.quantity == LOAD else x.nominal for x in unknowns}


@cache
def _case(title: str) -> Case:
    return (CASES | LOADED)[title](title)


@cache
def _regressor(name: str) -> Regressor:
    return regressor(next(_case(title).machine for title in LOADED | CASES if _case(title).machine.name == name))


def encoders(steps: Sequence[float], torque_noise: Array) -> Sensors:
    """Return encoders of steps in rad or m, with noise of half a step."""
    return Sensors(np.array(steps), np.array(steps) / 2, torque_noise)


def with_friction(machine: Machine, friction: Mapping[str, tuple[float, float]]) -> Machine:
    """Return the machine with viscous and dry friction of these joints."""
    joints = tuple(
        replace(j, friction=Friction(*map(Formula.parse, friction[j.name]))) if j.name in friction else j
        for j in machine.joints
    )
    return replace(machine, name=f"{machine.name}_with_friction", joints=joints)


def rigid_period(machine: Machine, motion: FourierMotion) -> Measurements:
    """Return one period of a motion and its torques."""
    t = np.arange(round(motion.period * SAMPLING)) / SAMPLING
    q, qd, qdd = motion.at(t)
    model = numpy_model(machine, ("inverse_dynamics",))
    tau = np.asarray(model.inverse_dynamics(q, qd, qdd)[0])
    return Measurements(t, q, tau)


def rigid(title: str, machine: Machine, limits: Limits, steps: Sequence[float], seed: int = 0) -> Case:
    """Return a case of a machine whose joints all have motors; torque noise is 0.5 % of the largest torque."""
    period = rigid_period(machine, random_motion(limits, 0.1, 5, seed))
    sensors = encoders(steps, 0.005 * np.abs(period.tau).max(axis=0))
    return Case(title, machine, period, sensors, {})


ARM = Limits.of([-2.0] * 6, [2.0] * 6, [2.0] * 6, [10.0] * 6)


def rigid_6r(title: str) -> Case:
    return rigid(title, arm_6(), ARM, [TURN / 2**17] * 6)


def rigid_6r_with_friction(title: str) -> Case:
    machine = arm_6()
    names = [joint.name for joint in machine.independent_joints]
    sizes = ((20.0, 15.0), (18.0, 15.0), (9.0, 8.0), (3.0, 3.0), (2.0, 2.0), (1.0, 1.2))
    return rigid(title, with_friction(machine, dict(zip(names, sizes, strict=True))), ARM, [TURN / 2**17] * 6)


def coarse_encoders(title: str) -> Case:
    rows = [Row("turn", 0, "0", mass=20), Row("lift", 1, "0", d=0.1, mass=12), Row("wrist", 2, "pi/2", d=0.3, mass=4)]
    machine = built("cylindrical", rows)
    joints = list(machine.joints)
    joints[1] = replace(joints[1], sigma=1)
    machine = with_friction(
        replace(machine, joints=tuple(joints)), {"turn": (3.0, 2.0), "lift": (30.0, 12.0), "wrist": (1.0, 0.5)}
    )
    limits = Limits.of([-2.0, -0.3, -2.0], [2.0, 0.3, 2.0], [2.0, 0.5, 3.0], [8.0, 3.0, 15.0])
    return rigid(title, machine, limits, [TURN / 2**13, 5e-5, TURN / 2**13], seed=2)


def light_arm() -> Machine:
    """Return an arm of three joints with dry friction, whose runs are quick."""
    rows = [
        Row("turn", 0, "0", mass=20),
        Row("lift", 1, "pi/2", d=0.1, mass=12),
        Row("wrist", 2, "pi/2", d=0.3, mass=4),
    ]
    return with_friction(built("light", rows), {"turn": (3.0, 2.0), "lift": (3.0, 2.0), "wrist": (1.0, 0.5)})


LIGHT = Limits.of([-2.0] * 3, [2.0] * 3, [3.0] * 3, [15.0] * 3)
LIGHT_NOISE = np.array([0.2, 0.2, 0.05])  # standard deviations of torques


def loaded(title: str, load: float, seed: int) -> Case:
    """Return a case of friction `load` times the torque that passes the transmission, of an otherwise known law."""
    machine, motion = light_arm(), random_motion(LIGHT, 0.2, 8, seed)
    zero, period = Formula.parse(0), rigid_period(machine, motion)
    joints = (replace(j, friction=Friction(zero, zero), rotor_inertia=zero, ratio=zero) for j in machine.joints)
    passing = rigid_period(replace(machine, joints=tuple(joints)), motion).tau
    more = load * np.abs(passing) * np.sign(motion.at(period.t)[1])
    sensors = encoders([TURN / 2**17] * 3, LIGHT_NOISE)
    return Case(title, machine, replace(period, tau=period.tau + more), sensors, {}, load)


GEOMETRY = {"L2": 0.5, "G3": -9.81}
LINKS = {
    "ZZ1": 0.05, "M1": 2, "YY2": 0.5, "ZZ2": 0.5, "XX2": 0.02, "MX2": 1.5, "M2": 6,
    "XX3": 0.004, "YY3": 0.003, "ZZ3": 0.005, "M3": 1,
    "XX4": 0.012, "XY4": -0.01, "YY4": 0.16, "ZZ4": 0.165, "MX4": 0.6, "MY4": 0.05, "M4": 3,
}  # fmt: skip
MOTORS_AND_SPRINGS = {"IA1": 0.5, "IA3": 0.15, "k2": 1500.0, "k4": 400.0}
DAMPING, NEUTRAL = {"j2": 0.4, "j4": 0.15}, {"j2": 0.01, "j4": -0.02}
BALANCED = {f"{name}3": 0.0 for name in ("XY", "XZ", "YZ", "MX", "MY")}


def elastic_two_axis(title: str) -> Case:
    """Return flex4 under control: two motors, two springs."""
    bare = with_friction(example("flex4.par"), {"j1": (3.0, 2.0), "j3": (1.0, 1.0)})
    numbers = {p.name: 0.0 for p in bare.parameters} | GEOMETRY | LINKS | MOTORS_AND_SPRINGS
    joints = []
    for joint in bare.joints:
        law = (joint.spring.stiffness, *(Formula.parse(x.get(joint.name, 0.0)) for x in (DAMPING, NEUTRAL)))
        joints.append(replace(joint, spring=Spring(*law)) if joint.name in DAMPING else joint)
    parameters = tuple(replace(p, value=Formula.parse(numbers[p.name])) for p in bare.parameters)
    machine = replace(bare, joints=tuple(joints), parameters=parameters)
    motion = random_motion(Limits.of([-1.2, -1.0], [1.2, 1.0], [2.5, 3.0], [15.0, 20.0]), 0.2, 8, 1)
    controller = Controller.of_bandwidth([2.0, 0.4], frequency=4.0)
    duration = motion.period - 1 / SAMPLING
    true = simulate(machine, {}, motion.at, controller, duration, SAMPLING, settle=4 * motion.period)
    return Case(title, machine, true, encoders([TURN / 2**20] * 4, np.array([0.3, 0.1])), BALANCED)


CASES: dict[str, Callable[[str], Case]] = {
    "rigid 6R arm": rigid_6r,
    "rigid 6R arm, dry friction": rigid_6r_with_friction,
    "elastic two-axis arm": elastic_two_axis,
    "cylindrical arm, coarse encoders": coarse_encoders,
}
LOADED: dict[str, Callable[[str], Case]] = {
    "load friction": partial(loaded, load=0.08, seed=1),
    "large load friction": partial(loaded, load=1.5, seed=2),
    "very large load friction": partial(loaded, load=20.0, seed=2),
}
"""Cases of load friction: of the last one Gauss-Newton steps settle in some runs only."""
UNSETTLED = "not settled"
"""Word by which notes report that."""


def bare(label: str) -> str:
    """Return a label without underscores, which are in it where a name of the machine is in use."""
    return label.replace("_", "")


def errors_of(identified: Identification, truth: Mapping[str, float] | None = None) -> dict[str, Error]:
    """Return errors by bare label; by the values of the file without `truth`, with the file where it is trusted.

    Values that contain the effect of parameters which this record does not determine have no truth of their own.
    """
    bodies, grouping = identified.possible, identified.estimation.grouping
    alone = dict.fromkeys(grouping.kept, True)
    if grouping.dropped:
        alone = {k: bool(np.abs(row).max() < CONTAINED) for k, row in zip(grouping.kept, grouping.beta, strict=True)}
    stds = bodies.with_file if bodies and math.isfinite(bodies.trust) else [e.std for e in identified.estimates]
    errors = {}
    for k, (e, std) in enumerate(zip(identified.estimates, stds, strict=True)):
        true = e.unknown.nominal if truth is None else truth.get(bare(e.unknown.label), math.nan)
        if alone.get(k, False) and math.isfinite(true):
            errors[bare(e.unknown.label)] = Error(
                e.value - true, float(std), abs(true), e.verdict is Verdict.IDENTIFIED
            )
    return errors


def run_of_log(
    seed: int, fit: Callable[[], Identification], reported: str = "", truth: Mapping[str, float] | None = None
) -> Run:
    """Return the run of a stored table; `reported` where notes contain these words, `rejected` for an `InputError`."""
    try:
        identified = fit()
    except InputError:
        return Run(seed, "rejected")
    is_reported = bool(reported) and any(reported in note for note in identified.notes)
    return run_of(seed, "reported" if is_reported else "accepted", errors_of(identified, truth).values())


TABLE = dict.fromkeys(
    (*CASES, *(f"{title}, {fault}" for title in list(CASES)[1:] for fault in FAULTS), *LOADED), TABLE_RUNS
)
"""Numbers of runs by row of the stored table: of cases, of all but the first with faults, of load friction."""


def table_run(row: str, seed: int) -> Run:
    """Return a run of a row of the stored table."""
    title = max((title for title in CASES | LOADED if row.startswith(title)), key=len)
    case, fault = _case(title), FAULTS.get(row.removeprefix(f"{title}, "))
    reported = fault.reported if fault else UNSETTLED
    return run_of_log(seed, lambda: case.identified(PERIODS, SEED + seed, fault), reported, case.truth)


def deviations(title: str, periods: int, runs: int, first: int = SEED) -> tuple[Array, Array, list[str]]:
    """Return (estimate - truth) / std and errors (runs, parameters), NaN where not found, and the labels."""
    case = _case(title)
    found = [case.identified(periods, first + run) for run in progress(range(runs), title)]
    errors = np.array([[e.value - np.nan_to_num(e.unknown.nominal) for e in run.estimates] for run in found])
    stds = np.array([[e.std for e in run.estimates] for run in found])
    return errors / stds, errors, [e.unknown.label for e in found[0].estimates]


def figures(title: str, runs: int) -> dict[str, Any]:
    """Return the share of estimates with the truth within 1, 2, 3 std, their shift, and how errors fall.

    `shift` is the mean of (estimate - truth) / std; `shift rms` that of each parameter's mean, which is 1 / sqrt(runs)
    by chance; `fall` the ratio of errors to those of records four times as long, 2 for errors like 1 / sqrt(length).
    """
    z, errors, _ = deviations(title, PERIODS, runs)
    longer = deviations(title, 4 * PERIODS, max(runs // 2, 3), SEED + runs)[1]
    inside = {f"{k} std": float(np.mean(np.abs(z[np.isfinite(z)]) < k)) for k in (1, 2, 3)}
    fall = np.sqrt(np.nanmean(errors**2, axis=0) / np.nanmean(longer**2, axis=0))
    shift = np.nanmean(z, axis=0)
    return {
        "estimates": int(np.isfinite(z).sum()),
        **inside,
        "worst": float(np.nanmax(np.abs(z))),
        "shift": float(np.mean(shift)),
        "shift rms": float(np.sqrt(np.mean(shift**2))),
        "by chance": 1 / runs**0.5,
        "fall": float(np.exp(np.mean(np.log(fall)))),
    }


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m tests.benchmarks.identification", description=__doc__)
    parser.add_argument("--runs", type=int, default=RUNS)
    parser.add_argument("--json", type=Path, help="save the figures")
    parser.add_argument("--only", nargs="*", default=list(CASES))
    add_options(parser)
    arguments = parser.parse_args()
    if has_table_run(arguments, "identification", TABLE, table_run):
        return
    found = {title: figures(title, arguments.runs) for title in arguments.only}
    heads = ("machine", *next(iter(found.values())))
    print_table(
        "truth within standard deviations", heads, [(t, *(f"{x:.4g}" for x in f.values())) for t, f in found.items()]
    )
    if arguments.json:
        save_json(arguments.json, found)


if __name__ == "__main__":
    main()
