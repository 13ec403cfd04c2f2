"""Measured machines: excite, identify."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from numbers import Real
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from symoro_elastic.api.machines import NO_VALUES, MachineLike, Values, the_machine
from symoro_elastic.errors import InputError, among
from symoro_elastic.output_files import permission
from symoro_elastic.progress import Announce, Progress, announce_nothing, no_progress
from symoro_elastic.results import Part, Result, Titled

if TYPE_CHECKING:
    from symoro_elastic.array_types import Array
    from symoro_elastic.identification.excitation import Excitation, Limits
    from symoro_elastic.identification.identify import Identification
    from symoro_elastic.identification.trajectory import Trajectory
    from symoro_elastic.identification.validation import Fit
    from symoro_elastic.machine.machine import Machine
    from symoro_elastic.time_series.measurements import Measurements
    from symoro_elastic.time_series.preparation import Preparation

Range: TypeAlias = tuple[float, float]
Ranges: TypeAlias = Mapping[str, Range]
Record: TypeAlias = str | Path | Mapping[str, Any]
"""A file of measurements, or its columns by name."""


@dataclass(frozen=True, repr=False)
class Exciting(Result):
    """An exciting trajectory: the optimized Fourier series, its samples with start and stop, the limits it keeps."""

    machine: Machine
    best: Excitation
    sampled: Trajectory
    limits: Limits

    @property
    def figures(self) -> dict[str, Any]:
        """Condition number, parameters it excites, what of the limits is reached."""
        from symoro_elastic.identification import trajectory

        return trajectory.figures(self.best, self.sampled, self.limits, self.machine)

    @property
    def headline(self) -> str:
        """Machine, duration, condition number."""
        condition = f"condition {self.best.condition:.4g}"
        return f"Exciting trajectory of {self.machine.name}: {self.sampled.t[-1]:g} s, {condition}"

    def parts(self) -> list[Part]:
        """Return the table of what is reached of the limits, and sentences about the parameters it excites."""
        from symoro_elastic.identification import trajectory

        found = self.figures
        return [
            Titled(trajectory.table(found), f"{self.machine.name}: reached of the limits"),
            *trajectory.lines(found),
        ]

    def as_json(self) -> dict[str, Any]:
        """Return the figures."""
        return self.figures

    def arrays(self) -> dict[str, Array]:
        """Return t, q_<motor>, qd_<motor>, qdd_<motor>, a row a sample."""
        from symoro_elastic.identification import trajectory

        return trajectory.columns(self.sampled, self.machine)

    def columns(self) -> dict[str, Array]:
        """Return the same as `arrays`."""
        return self.arrays()

    def write(self, path: str | Path, *, force: bool = False) -> Path:
        """Write t, q_<motor>, qd_, qdd_ to a .csv or .npz file, and return its path; raises `InputError`."""
        from symoro_elastic.identification import trajectory

        with permission(force=force):
            trajectory.write(self.sampled, self.machine, path)
        return Path(path)


def excite(
    machine: MachineLike,
    position: Ranges | Range,
    velocity: Values | float,
    acceleration: Values | float,
    *,
    frequency: float = 0.1,
    harmonics: int = 5,
    periods: int = 3,
    rate: float = 1000.0,
    evaluations: int = 1500,
    seed: int = 0,
    values: Values = NO_VALUES,
    known: Sequence[str] = (),
    progress: Progress = no_progress,
) -> Exciting:
    """Return a trajectory that excites the dynamic parameters of a machine within limits.

    Parameters
    ----------
    machine
        A machine, its file or its tables.
    position, velocity, acceleration
        (low, high), largest velocity and largest acceleration, of all motors or by motor; SI units.
    frequency, harmonics, periods, rate
        Fundamental frequency of the Fourier series, Hz, its harmonics and periods, and the sample rate, Hz.
    evaluations, seed
        Motions that the search evaluates, and the seed of the first ones.
    values, known
        Values of parameters; labels of parameters that are not to be identified.

    Raises
    ------
    InputError
        For a machine without motors, and limits without room.
    """
    from symoro_elastic.identification import trajectory
    from symoro_elastic.identification.excitation import excite as optimized
    from symoro_elastic.numerics.independent_joints import with_independent_motors

    found = with_independent_motors(the_machine(machine))
    trajectory.refuse_without_motors(found)
    given = {"--position": _of_all(position), "--velocity": _up_to(velocity), "--acceleration": _up_to(acceleration)}
    limits = trajectory.limits_of(found, given)
    trajectory.refuse_rate(rate, frequency, harmonics, periods, len(found.motors))
    _refuse_unknown(values, found)
    best = optimized(
        found, limits, frequency, harmonics, values, known, evaluations=evaluations, seed=seed,
        progress=lambda done, total, _: progress(done, total),
    )  # fmt: skip
    return Exciting(found, best, trajectory.trajectory(best.motion, limits, periods, rate), limits)


def _of_all(ranges: Ranges | Range) -> dict[str, Range]:
    if isinstance(ranges, Mapping):
        return dict(ranges)
    if isinstance(ranges, Real) or len(ranges) != 2:
        raise InputError("symoro-elastic", "--position", f"{ranges} is no range: give (low, high)")
    return {"": (float(ranges[0]), float(ranges[1]))}


def _up_to(largest: Values | Ranges | float) -> dict[str, Range]:
    """Return limits of a rate by motor as ranges."""
    each: Mapping[str, Any] = largest if isinstance(largest, Mapping) else {"": largest}
    return {name: x if isinstance(x, tuple) else (-float(x), float(x)) for name, x in each.items()}


@dataclass(frozen=True, repr=False)
class Identified(Result):
    """Identified parameters of a machine, and what they predict of another record.

    `saved` are the machine with the estimates and lines about what of them no machine has.
    """

    found: Identification
    records: tuple[Measurements, ...]
    of_file: Machine
    values: Values
    known: Values
    bandwidth: float | None
    validation: Fit | None = None

    @property
    def estimates(self) -> Mapping[str, float]:
        """Estimated values by label of the parameter or group."""
        return {e.unknown.label: e.value for e in self.found.estimates}

    @property
    def headline(self) -> str:
        """Machine, parameters and samples."""
        return self.found.headline

    def parts(self) -> list[Part]:
        """Return the table of parameters, neutral positions, residuals and notes."""
        from symoro_elastic.identification import report
        from symoro_elastic.identification.validation import lines, own_fit

        result = self.found
        fits = [own_fit(result), *([self.validation] if self.validation else [])]
        figures = [line for fit in fits for line in lines(fit, result.machine)]
        table = report.table(result, report.file_values(result) or None, "file")
        return [table, *report.neutral_positions(result), *figures, *result.notes]

    def as_json(self) -> dict[str, Any]:
        """Return parameters, residuals and the condition number as plain data."""
        from symoro_elastic.identification import report

        return report.as_json(self.found, self.validation)

    def columns(self) -> dict[str, list[Any]]:
        """Return a row for each parameter or group."""
        return self.found.columns()

    def saved(self, step: Announce = announce_nothing) -> tuple[Machine, list[str]]:
        """Return the machine with the estimates, and lines about estimates that no physical machine has."""
        from symoro_elastic.identification.identified import identified, possible
        from symoro_elastic.identification.identify import identify as fit

        result = self.found

        def again(fixed: Mapping[str, float]) -> Identification:
            known, Y = {**self.known, **fixed}, result.equations.Y
            return fit(result.machine, self.records, self.values, known, self.bandwidth, step=step, Y=Y)

        fitted, lines = possible(result, again)
        return replace(identified(fitted, self.values), loops=self.of_file.loops), lines


def identify(
    machine: MachineLike,
    records: Record | Sequence[Record],
    *,
    values: Values = NO_VALUES,
    known: Values = NO_VALUES,
    bandwidth: float | None = None,
    preparation: Preparation | None = None,
    validate: Record | None = None,
    step: Announce = announce_nothing,
) -> Identified:
    """Return dynamic parameters estimated from measurements, with standard deviations and verdicts.

    Parameters
    ----------
    machine
        A machine, its file or its tables.
    records
        CSV or NPZ files with t, q_<joint>, tau_<motor>, or such columns as arrays by name; one or several.
    values, known
        Values of named parameters, and of identifiable ones that are not to be estimated, by label.
    bandwidth
        Bandwidth of the motion, Hz (default: from its spectrum).
    preparation
        Cuts, resampling and gains of the records.
    validate
        Another record, whose torques are predicted.

    Raises
    ------
    InputError
        For records with gaps, without torques, or that do not excite.
    """
    from symoro_elastic.identification.identify import identify as fit
    from symoro_elastic.identification.validation import validated
    from symoro_elastic.numerics.independent_joints import with_independent_motors
    from symoro_elastic.time_series.preparation import Preparation

    of_file = the_machine(machine)
    found, prepare = with_independent_motors(of_file), preparation or Preparation()
    prepare.refuse(found)
    _refuse_unknown(values, found)
    step("read")
    if not isinstance(records, str | Path | Mapping) and not len(records):
        raise InputError("symoro-elastic", "--records", "there is none: give a file, or columns by name")
    several = [records] if isinstance(records, str | Path | Mapping) else records
    read = tuple(_record(one, found, prepare) for one in several)
    other = None if validate is None else _record(validate, found, prepare)
    result = fit(found, read, dict(values), dict(known), bandwidth, step=step)
    checked = validated(result, other) if other else None
    return Identified(result, read, of_file, values, known, bandwidth, checked)


def _record(record: Record, machine: Machine, prepare: Preparation) -> Measurements:
    """Return the measurements in a file, or in arrays by name."""
    import numpy as np

    from symoro_elastic.time_series.measurements import measurements_of, read_measurements

    if not isinstance(record, Mapping):
        return read_measurements(record, machine, prepare)
    columns = {name: np.asarray(x, dtype=float) for name, x in record.items()}
    return measurements_of(columns, machine, "records", prepare)


def _refuse_unknown(values: Values, machine: Machine) -> None:
    among(tuple(values), tuple(parameter.name for parameter in machine.parameters), "--value")
