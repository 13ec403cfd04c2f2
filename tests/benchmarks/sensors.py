"""How honest standard deviations are with sensors as they are: coarse encoders, delays, offsets, coloured noise,
spikes: `python -m tests.benchmarks.sensors [--light] [--runs N] [--only CASE ...] [--json FILE] [--store] [--stored]`.

A 6R arm with dry friction (`--light`: a 3R arm) moves below 2.5 Hz for 20 s, four times the same; motion, noise and the
zeros of encoders, within half a step, are drawn anew in each run. Encoders round, without noise of their own. The
stored table is of the 3R arm.

Estimates of a run are correlated: of 22 a run shows about 8 that are independent, so a share of 75 % in a run may be
chance. The test of a run is its sum of squares z^T z beside what its correlations R allow: about p / h times chi^2 of
h = p^2 / |R|^2 degrees of freedom (Satterthwaite 1946). It leaves out z^T R^-1 z, for with coarse encoders R is from a
few draws, whose least eigenvalues are too small.
"""

from __future__ import annotations

import argparse
from collections import Counter
from dataclasses import dataclass
from functools import cache, cached_property
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import chi2

from symoro_elastic.analysis.time_series.measurements import Measurements
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.machine import Machine
from symoro_elastic.measured.logs.fourier_motion import Limits, random_motion
from symoro_elastic.measured.logs.identify import identify
from symoro_elastic.measured.logs.result import Identification
from symoro_elastic.numerics.linear.regressor import Regressor, regressor
from symoro_elastic.numerics.verification.implementations import numpy_model
from tests.benchmarks.identification import ARM, FAULTS, LIGHT, LIGHT_NOISE, light_arm, run_of_log, with_friction
from tests.benchmarks.machines import arm_6
from tests.benchmarks.tables import Run, add_options, has_table_run, print_table, progress, save_json

RUNS, DURATION, FUNDAMENTAL, HARMONICS = 30, 20.0, 0.2, 12
SPIKES = 20.0  # standard deviations of torque noise
SAYS = ("encoder", "has an offset", "from gravity by this motion", "no offset", "behind", "correlated", "spikes")


@dataclass(frozen=True)
class Sensing:
    """Bits of encoders, sampling in Hz, samples that torques are late, whether they have offsets, the corner of
    their noise in Hz (0: white), the share of samples that are spikes."""

    bits: int = 17
    rate: float = 500.0
    late: float = 0.0
    offset: bool = False
    corner: float = 0.0
    spikes: float = 0.0

    @property
    def numbers(self) -> tuple[float, ...]:
        """What it is made of, as whole numbers."""
        return self.bits, self.rate, self.late, self.offset, self.corner, 100 * self.spikes


CASES = {
    **{f"{bits} bits, {rate:g} Hz": Sensing(bits, rate) for bits in (12, 14, 17, 20) for rate in (500.0, 1000.0)},
    "delay of 1 sample": Sensing(late=1),
    "delay of 3 samples": Sensing(late=3),
    "offsets": Sensing(offset=True),
    "noise below 20 Hz": Sensing(corner=20.0),
    "3 % spikes": Sensing(spikes=0.03),
    "12 bits, offsets, 3 samples": Sensing(12, late=3, offset=True),
    "delay of 3 samples, 1000 Hz": Sensing(rate=1000.0, late=3),
    "noise below 20 Hz, 1000 Hz": Sensing(rate=1000.0, corner=20.0),
}

TABLE = dict.fromkeys((*CASES, "late column", "clipped column"), 6)
"""Numbers of runs by row of the stored table."""
REPORTED = {"delay of 3 samples": "compensated", "offsets": "has an offset", "3 % spikes": "spikes"}
"""Words by which notes report what disturbs a case."""


@dataclass(frozen=True, eq=False)
class Arm:
    """A machine, the limits of its motion, noise and offsets of its torques."""

    machine: Machine
    limits: Limits
    noise: Array
    offsets: Array

    @cached_property
    def regressor(self) -> Regressor:
        """Y of the machine."""
        return regressor(self.machine)

    @cached_property
    def model(self) -> Any:
        """Inverse dynamics of the machine."""
        return numpy_model(self.machine, ("inverse_dynamics",))

    def record(self, sensing: Sensing, seed: int) -> Measurements:
        """Return a record of sensors along a motion of its own."""
        rng = np.random.default_rng([seed, *(int(x) for x in sensing.numbers)])
        motion = random_motion(self.limits, FUNDAMENTAL, HARMONICS, 100 + seed)
        t = np.arange(round(DURATION * sensing.rate)) / sensing.rate
        tau = np.array(self.model.inverse_dynamics(*motion.at(t - sensing.late / sensing.rate))[0])
        step, q = 2 * np.pi / 2**sensing.bits, motion.at(t)[0]
        zero = step * rng.uniform(-0.5, 0.5, size=q.shape[1])
        tau += self.noise * _noise(tau.shape, sensing, rng) + (self.offsets if sensing.offset else 0.0)
        return Measurements(t, np.round((q + zero) / step) * step, tau)

    def identified(self, sensing: Sensing, seed: int) -> Identification:
        """Return the parameters found from such a record."""
        return identify(self.machine, self.record(sensing, seed), Y=self.regressor)


def _noise(shape: tuple[int, ...], sensing: Sensing, rng: np.random.Generator) -> Array:
    """Return noise of variance 1, with spikes beside."""
    noise = rng.standard_normal(shape)
    if sensing.corner:
        a = np.exp(-2 * np.pi * sensing.corner / sensing.rate)
        for k in range(1, len(noise)):
            noise[k] = a * noise[k - 1] + np.sqrt(1 - a * a) * noise[k]
    beside = np.where(rng.uniform(size=shape) < sensing.spikes, SPIKES * np.sign(rng.standard_normal(shape)), 0.0)
    return noise + beside


@cache
def six_axis() -> Arm:
    """Return an arm of six joints with dry friction."""
    machine = arm_6()
    sizes = ((20.0, 15.0), (18.0, 15.0), (9.0, 8.0), (3.0, 3.0), (2.0, 2.0), (1.0, 1.2))
    friction = dict(zip((joint.name for joint in machine.independent_joints), sizes, strict=True))
    noise, offsets = np.array([2.0, 2.0, 1.0, 0.3, 0.2, 0.1]), np.array([3.0, -4.0, 2.0, 0.5, 0.3, 0.2])
    return Arm(with_friction(machine, friction), ARM, noise, offsets)


@cache
def three_axis() -> Arm:
    """Return an arm of three joints with dry friction, whose runs are quick."""
    return Arm(light_arm(), LIGHT, LIGHT_NOISE, np.array([0.5, -0.8, 0.1]))


@dataclass(frozen=True)
class Squares:
    """Sum of squares of correlated estimates over their standard deviations, its mean and its variance."""

    total: float
    mean: float
    variance: float

    @property
    def independent(self) -> float:
        """How many independent estimates have a sum of squares that varies so much."""
        return 2 * self.mean**2 / self.variance

    @property
    def chance(self) -> float:
        """Share of right covariances beside which the sum of squares is at least so large."""
        return float(chi2.sf(self.total * self.independent / self.mean, self.independent))

    def __add__(self, other: Squares) -> Squares:
        return Squares(self.total + other.total, self.mean + other.mean, self.variance + other.variance)


@dataclass(frozen=True)
class Coverage:
    """Estimates less truth over their standard deviations, for each run (NaN where not found), correlations of those
    that were found, refusals, notes."""

    z: list[Array]
    correlations: list[Array]
    refused: list[str]
    notes: list[tuple[str, ...]]

    @property
    def squares(self) -> list[Squares]:
        """Sums of squares of the runs."""
        each = zip(self.z, self.correlations, strict=True)
        return [Squares(float(np.nansum(z**2)), float(len(R)), 2 * float((R**2).sum())) for z, R in each]

    @property
    def figures(self) -> dict[str, Any]:
        """Return shares inside 1, 2, 3 standard deviations, in all and in the worst run; how often what is said.

        `chance` is how likely the sum of squares of all runs is, `worst by chance` that of the least likely of so many.
        """
        z = np.abs(np.concatenate(self.z)) if self.z else np.zeros(0)
        z = z[np.isfinite(z)]
        if not len(z):
            return {"runs": 0, "refused": len(self.refused)}
        said = Counter(word for notes in self.notes for word in SAYS if any(word in line for line in notes))
        squares = self.squares
        least = min(x.chance for x in squares)
        return {
            "runs": len(self.z), "refused": len(self.refused), "estimates": len(z),
            **{f"{k} std": float((z < k).mean()) for k in (1, 2, 3)},
            "rms": float(np.sqrt((z**2).mean())), "worst": float(z.max()),
            "independent": float(np.mean([x.independent for x in squares])),
            "chance": sum(squares[1:], squares[0]).chance,
            "worst run, 2 std": min(float((np.abs(x[np.isfinite(x)]) < 2).mean()) for x in self.z),
            "worst by chance": 1 - (1 - least) ** len(squares),
            "says": ", ".join(f"{word} {count}" for word, count in said.items()) or "-",
        }  # fmt: skip


def coverage(arm: Arm, sensing: Sensing, runs: int, first: int = 0, title: str = "") -> Coverage:
    """Return how far estimates of some runs are from the truth."""
    found = Coverage([], [], [], [])
    for seed in progress(range(first, first + runs), title):
        try:
            one = arm.identified(sensing, seed)
        except InputError as error:
            found.refused.append(str(error))
            continue
        of_machine = [e for e in one.estimates if np.isfinite(e.unknown.nominal)]
        found.z.append(np.array([(e.value - e.unknown.nominal) / e.std for e in of_machine]))
        found.correlations.append(_correlations(one))
        found.notes.append(one.notes)
    return found


def _correlations(found: Identification) -> Array:
    """Return the correlations of the estimates of a machine's parameters that were found."""
    estimation = found.estimation
    kept = [estimation.estimates[c] for c in estimation.grouping.kept]
    own = [k for k, e in enumerate(kept) if np.isfinite([e.unknown.nominal, e.std]).all()]
    std = estimation.solution.std[own]
    R: Array = estimation.solution.covariance[np.ix_(own, own)] / np.outer(std, std)
    return R


def table_run(row: str, seed: int) -> Run:
    """Return a run of a row of the stored table."""
    arm, sensing, fault = three_axis(), CASES.get(row, Sensing()), FAULTS.get(row)
    record = arm.record(sensing, seed)
    if fault:
        record = fault.change(record, np.random.default_rng([seed, 5]))
    reported = fault.reported if fault else next((said for case, said in REPORTED.items() if case in row), "")
    return run_of_log(seed, lambda: identify(arm.machine, record, Y=arm.regressor), reported)


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m tests.benchmarks.sensors", description=__doc__)
    parser.add_argument("--runs", type=int, default=RUNS)
    parser.add_argument("--first", type=int, default=0, help="number of the first draw")
    parser.add_argument("--light", action="store_true", help="three joints instead of six")
    parser.add_argument("--only", nargs="*", default=list(CASES))
    parser.add_argument("--json", type=Path, help="save the figures")
    add_options(parser)
    given = parser.parse_args()
    if has_table_run(given, "sensors", TABLE, table_run):
        return
    arm = three_axis() if given.light else six_axis()
    found: dict[str, dict[str, Any]] = {}
    for title in given.only:
        found[title] = coverage(arm, CASES[title], given.runs, given.first, title).figures
        if given.json:
            save_json(given.json, found)
    heads = ("sensors", *max(found.values(), key=len))
    rows = [(t, *(f"{x:.4g}" if isinstance(x, float) else str(x) for x in f.values())) for t, f in found.items()]
    print_table("truth within standard deviations", heads, rows)


if __name__ == "__main__":
    main()
