"""Measured machines: excite, identify, update."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from numbers import Real
from pathlib import Path
from typing import TYPE_CHECKING, Any

from symoro_elastic.api.declaration import operation
from symoro_elastic.api.machines import the_machine
from symoro_elastic.api.measuring_options import Exciting, Identifying, Updating
from symoro_elastic.api.rows import SEEKING, MachineLike, Range, Ranges, Record, Values
from symoro_elastic.foundation.errors import InputError, among
from symoro_elastic.machine.checks import parameter_values

if TYPE_CHECKING:
    from symoro_elastic.analysis.time_series.measurements import Measurements
    from symoro_elastic.analysis.time_series.preparation import Preparation
    from symoro_elastic.machine.machine import Machine
    from symoro_elastic.measured.logs.friction_laws import FrictionLaws
    from symoro_elastic.measured.logs.identified import Identified
    from symoro_elastic.measured.logs.result import Identification
    from symoro_elastic.measured.logs.trajectory import ExcitingTrajectory
    from symoro_elastic.measured.vibration_tests.updated import Updated


@operation(Exciting)
def excite(machine: MachineLike, options: Exciting) -> ExcitingTrajectory:
    """Return a trajectory that excites the dynamic parameters of a machine within limits.

    Limits are of all motors or by motor: (low, high), largest velocity, largest acceleration. What is left out is taken
    from the limits of the machine; torques keep those, too, by the parameters that it has.

    Raises
    ------
    InputError
        For a machine without motors, or limits that leave no room for a motion.
    """
    from symoro_elastic.measured.logs import trajectory
    from symoro_elastic.measured.logs.excitation import ExcitationSettings
    from symoro_elastic.measured.logs.excitation import excite as optimized
    from symoro_elastic.measured.logs.fourier_motion import Started
    from symoro_elastic.numerics.motion.independent_joints import with_independent_motors

    driven, rate = with_independent_motors(the_machine(machine)), options.sample_rate
    driven.refuse_without_motors("joints")
    velocity, acceleration = _up_to(options.velocity), _up_to(options.acceleration)
    ranges = {"--position": _of_all(options.position), "--velocity": velocity, "--acceleration": acceleration}
    limits = trajectory.limits_of(driven, ranges)
    trajectory.refuse_rate(rate, options.fundamental, options.harmonics, options.periods, len(driven.motors))
    _refuse_unknown(options.values, driven)
    settings = ExcitationSettings(
        options.harmonics, options.values, tuple(options.known), tuple(options.seek), options.workspace,
        options.payload, _laws(options, driven), evaluations=options.evaluations, seed=options.seed,
    )  # fmt: skip
    best = optimized(
        driven, limits, options.fundamental, settings, lambda done, total, _: options.progress(done, total)
    )
    sampled = trajectory.trajectory(Started(best.motion, best.start, options.periods), rate)
    return trajectory.ExcitingTrajectory(driven, best, sampled, limits, dict(options.payload))


def _of_all(ranges: Ranges | Range) -> dict[str, Range]:
    if isinstance(ranges, Mapping):
        return dict(ranges)
    if isinstance(ranges, Real) or len(ranges) != 2:
        raise InputError("symoro-elastic", "--position", f"{ranges} is not a range: give (low, high)")
    return {"": (float(ranges[0]), float(ranges[1]))}


def _up_to(largest: Values | Ranges | float) -> dict[str, Range]:
    """Return limits of a rate by motor as ranges."""
    by_motor: Mapping[str, Any] = largest if isinstance(largest, Mapping) else {"": largest}
    return {name: x if isinstance(x, tuple) else (-float(x), float(x)) for name, x in by_motor.items()}


@operation(Identifying)
def identify(machine: MachineLike, options: Identifying) -> Identified:
    """Return dynamic parameters estimated from measurements, with standard deviations and verdicts.

    Raises
    ------
    InputError
        For records without torques or without excitation, and for gaps that leave no piece long enough.
    """
    from symoro_elastic.analysis.time_series.preparation import Preparation
    from symoro_elastic.measured.logs.identified import Identified
    from symoro_elastic.measured.logs.identify import LogSettings
    from symoro_elastic.measured.logs.identify import identify as fit
    from symoro_elastic.measured.logs.validation import validation_of
    from symoro_elastic.numerics.motion.independent_joints import with_independent_motors

    of_file, records, values = the_machine(machine), options.records, dict(options.values)
    driven = with_independent_motors(of_file)
    prepare = options.preparation or Preparation(options.after, options.before, options.resample, options.gains)
    prepare.refuse(driven)
    _refuse_unknown(values, driven)
    fixed = _values_of(options.known)
    among((options.offsets,), SEEKING, "--offsets")
    among((options.delay,), SEEKING, "--delay")
    trust, laws = _trust(options), _laws(options, driven, options.temperatures)
    behind = _link_side(options, driven)
    options.announce("read")
    if not isinstance(records, str | Path | Mapping) and not len(records):
        raise InputError("symoro-elastic", "--records", "no record is given: give a file, or columns by name")
    several = [records] if isinstance(records, str | Path | Mapping) else list(records)
    lists = [source for source in several if not isinstance(source, Mapping) and Path(source).suffix == ".toml"]
    several = [source for source in several if source not in lists] if lists else several
    if lists and not several:
        raise InputError(str(lists[0]), "records", "vibration tests without a log: use update for tests alone")
    measured = tuple(_record(source, driven, prepare, options.columns) for source in several)
    other = None if options.validate is None else _record(options.validate, driven, prepare, options.columns)
    settings = LogSettings(
        values, fixed, tuple(options.seek), tuple(behind), options.bandwidth,
        offsets=options.offsets, delay=options.delay, trust=trust, laws=laws, robust=options.robust,
        is_evidence=bool(lists),
    )  # fmt: skip
    result = fit(driven, measured, settings, options.announce)
    checked = validation_of(result, other) if other else None
    joint = _joint_fit(of_file, result, values, lists, options) if lists else None
    return Identified(result, measured, of_file, settings, checked, joint)


def _joint_fit(
    machine: Machine, identified: Identification, values: Values, lists: Sequence[Any], options: Identifying
) -> Updated:
    """Return the fit to lists of vibration tests and the determined part of a log."""
    from symoro_elastic.measured.joint import Log, fit_jointly
    from symoro_elastic.measured.vibration_tests.measured import VibrationTests
    from symoro_elastic.measured.vibration_tests.reading import read_tests
    from symoro_elastic.measured.vibration_tests.updated import Settings

    several = [read_tests(path, machine) for path in lists]
    tests = tuple(test for listed in several for test in listed.tests)
    notes = tuple(note for listed in several for note in listed.notes)
    return fit_jointly(machine, Log(identified, values), VibrationTests(tests, notes), Settings(), options.announce)


def _rows(names: Sequence[str], machine: Machine, option: str) -> list[int]:
    """Return rows of the table of motors by name, or of all."""
    motors = {machine.joint(j).name: j for j in machine.motors}
    among(tuple(names), (*motors, "all"), option)
    return list(motors.values()) if "all" in names else [motors[name] for name in dict.fromkeys(names)]


def _link_side(options: Identifying, machine: Machine) -> list[str]:
    """Return labels of the parameters that a load-side torque does not contain."""
    from symoro_elastic.machine.labels import ParameterLabels

    labels = ParameterLabels(machine)
    rows = _rows(options.link_side, machine, "--link-side")
    return [labels(j, quantity) for j in rows for quantity in ("IA", "FV", "FS")]


def _laws(options: Identifying | Exciting, machine: Machine, changing: bool = False) -> FrictionLaws:
    """Return the laws of friction: requested ones, and those of the file."""
    from symoro_elastic.measured.logs.friction_laws import FrictionLaws, laws_of_file

    for name, velocity in options.stribeck.items():
        if not (math.isfinite(velocity) and velocity > 0):
            raise InputError("symoro-elastic", "--stribeck", f"{name}={velocity:g}: give a velocity above 0")
    rows = _rows(tuple(options.stribeck), machine, "--stribeck")
    of_file = laws_of_file(machine, options.values)
    velocities = {**of_file.stribeck, **dict(zip(rows, options.stribeck.values(), strict=True))}
    load = (*of_file.load, *_rows(options.load_friction, machine, "--load-friction"))
    orders = {**of_file.cogging, **_orders(options.cogging, machine)}
    return FrictionLaws(tuple(dict.fromkeys(load)), velocities, changing, cogging=orders)


def _orders(cogging: Values, machine: Machine) -> dict[int, float]:
    """Return orders of cogging by row, of the joint's own axis."""
    for name, order in cogging.items():
        if not (math.isfinite(order) and order > 0):
            raise InputError("symoro-elastic", "--cogging", f"{name}={order:g}: give periods per turn, above 0")
    rows = _rows(tuple(cogging), machine, "--cogging")
    ratios = [machine.joint(j).ratio.value(parameter_values(machine)) or 1.0 for j in rows]
    return {j: abs(n) * order for j, n, order in zip(rows, ratios, cogging.values(), strict=True)}


def _trust(options: Identifying) -> float | None:
    """Return the relative error of initial values; None without physical constraints."""
    if options.possible:
        return math.inf if options.trust is None else options.trust
    if options.trust is not None:
        raise InputError("symoro-elastic", "--trust", "the file is a prior of possible bodies only: give --possible")
    return None


def _values_of(fixed: Mapping[str, float | None]) -> dict[str, float]:
    """Return the values of fixed parameters; raises `InputError` for one without."""
    for label, x in fixed.items():
        if x is None:
            raise InputError("symoro-elastic", "--known", f"{label} has no value here: give {label}=X")
    return {label: x for label, x in fixed.items() if x is not None}


def _record(record: Record, machine: Machine, prepare: Preparation, names: Mapping[str, str]) -> Measurements:
    """Return the measurements in a file, or in arrays by name, with renamed columns."""
    import numpy as np

    from symoro_elastic.analysis.time_series.measurements import measurements_of, read_columns, renamed_columns

    source = "records" if isinstance(record, Mapping) else str(record)
    columns: Mapping[str, Any] = (
        {name: np.asarray(x, dtype=float) for name, x in record.items()}
        if isinstance(record, Mapping)
        else read_columns(record, machine, may_be_empty=True)
    )
    return measurements_of(renamed_columns(columns, names, source), machine, source, prepare)


def _refuse_unknown(values: Values, machine: Machine) -> None:
    among(tuple(values), tuple(parameter.name for parameter in machine.parameters), "--value")


@operation(Updating)
def update(machine: MachineLike, options: Updating) -> Updated:
    """Return springs, dampers and masses estimated from vibration tests, with verdicts and undetermined parameters.

    Raises
    ------
    InputError
        For wrong tests, signals that do not exist, and responses with the opposite sign.
    """
    from symoro_elastic.measured.vibration_tests.measured import VibrationTest, VibrationTests
    from symoro_elastic.measured.vibration_tests.reading import read_tests
    from symoro_elastic.measured.vibration_tests.updated import Settings
    from symoro_elastic.measured.vibration_tests.updated import update as fit

    of_file, of_options = the_machine(machine, options.values), options.tests
    options.announce("read")
    if isinstance(of_options, str | Path):
        of_options = read_tests(of_options, of_file)
    listed = of_options if isinstance(of_options, VibrationTests) else VibrationTests(tuple(of_options))
    if other := [entry for entry in listed.tests if not isinstance(entry, VibrationTest)]:
        raise InputError("symoro-elastic", "--tests", f"{other[0]!r} is not a vibration test: give a file, or tests")
    among(tuple(options.predict), tuple(test.name for test in listed.tests), "--predict")
    tests = [replace(test, validate=test.validate or test.name in options.predict) for test in listed.tests]
    settings = Settings(
        tuple(options.seek), options.factor, options.mass_doubt, tuple(options.without), not options.plain
    )  # fmt: skip
    return fit(of_file, tests, settings, options.announce, listed.notes)
