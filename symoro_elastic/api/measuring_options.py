"""The options of `excite`, `identify` and `update`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY
from pathlib import Path
from typing import TYPE_CHECKING, Any

from symoro_elastic.api import kinds
from symoro_elastic.api.declaration import Options, argument, option, switch
from symoro_elastic.api.quantities import of_joints, of_parameters, of_signals
from symoro_elastic.api.rows import (
    SEEKING,
    Range,
    Ranges,
    Record,
    Values,
    announce_row,
    known_row,
    motors_or_all,
    progress_row,
    sample_rate_row,
    seed_row,
    seek_row,
    values_row,
)

if TYPE_CHECKING:
    from symoro_elastic.analysis.time_series.preparation import Preparation
    from symoro_elastic.foundation.progress import Announce, Progress
    from symoro_elastic.measured.vibration_tests.measured import VibrationTest, VibrationTests


def _limits(metavar: str, meaning: str, quantity: str) -> Any:
    what = f"{meaning} of all motors, or of one (NAME=...), SI units (default: [limits] of the machine)."
    return option({}, metavar, what, kinds.LIMITS, unit=of_joints(quantity))


def _load_friction() -> Any:
    return option(
        (), "MOTOR|all", "Motor whose dry friction rises with the torque through its transmission (FL).", kinds.TEXTS,
        of_machine=motors_or_all,
    )  # fmt: skip


def _stribeck() -> Any:
    what = "Velocity, rad/s or m/s, at which friction is halfway between static and Coulomb (FB)."
    return option({}, "MOTOR=V", what, kinds.NUMBERS, unit=of_joints("velocity"))


def _cogging() -> Any:
    what = "Cogging periods per turn of the rotor, whose amplitudes are estimated (CC, CS)."
    return option({}, "MOTOR=N", what, kinds.NUMBERS)


class Exciting(Options, kw_only=False):
    """Options of `excite`."""

    position: Ranges | Range = _limits("[NAME=]LOW:HIGH", "Range of positions", "position")
    velocity: Values | Ranges | float = _limits("[NAME=]MAX", "Largest velocity", "velocity")
    acceleration: Values | Ranges | float = _limits("[NAME=]MAX", "Largest acceleration", "acceleration")
    _: KW_ONLY
    workspace: Ranges = option(
        {}, "SIGNAL=LOW:HIGH", "Range of a position of a frame or point, such as tool.x, m, that the motion keeps.",
        kinds.RANGES, unit=of_signals,
    )  # fmt: skip
    payload: Ranges = option(
        {}, "NAME=LOW:HIGH", "Range of a parameter, such as a payload mass, for which torques stay within [limits].",
        kinds.RANGES, unit=of_parameters,
    )  # fmt: skip
    load_friction: Sequence[str] = _load_friction()
    stribeck: Values = _stribeck()
    cogging: Values = _cogging()
    fundamental: float = option(
        0.1, "HZ", "Fundamental frequency of the motion, Hz.", kinds.NUMBER, above=0, unit="Hz",
        gone=("--frequency", "frequency"),
    )  # fmt: skip
    harmonics: int = option(5, "N", "Harmonics of the Fourier series.", kinds.WHOLE, least=1, most=50)
    periods: int = option(3, "N", "Periods of the motion, without start and stop.", kinds.WHOLE, least=1, most=1000)
    sample_rate: float = sample_rate_row(1000.0, above=0)
    evaluations: int = option(2000, "N", "Maximum number of evaluated motions.", kinds.WHOLE, least=1, most=1_000_000)
    seed: int = seed_row()
    values: Values = values_row()
    known: Sequence[str] | Mapping[str, float | None] = known_row()
    seek: Sequence[str] = seek_row()
    progress: Progress = progress_row()


class Identifying(Options, kw_only=False):
    """Options of `identify`."""

    records: Record | Sequence[Record] = argument(
        ...,
        "CSV or NPZ files with t, q_<joint>, tau_<motor>, or such columns as arrays by name, one or several; "
        "lists (.toml) of vibration tests among them are fitted together with them.",
    )
    _: KW_ONLY
    values: Values = values_row()
    known: Mapping[str, float | None] = known_row()
    seek: Sequence[str] = seek_row()
    bandwidth: float | None = option(
        None, "HZ", "Bandwidth of the motion, Hz (default: from its spectrum).", kinds.NUMBER, unit="Hz"
    )
    gains: Values = option(
        {}, "MOTOR=K", "Factor from a measured column (a current, say) to motor torque.", kinds.NUMBERS
    )
    columns: Mapping[str, str] = option(
        {}, "NAME=COLUMN", "Column of the record that is q_<joint>, tau_<motor> or t, with a factor before or a unit "
        "behind: q_elbow='Position_2 [deg]', q_lift='2*pi/4096*Counts_1'.", kinds.TEXTS_BY_NAME,
    )  # fmt: skip
    resample: float | None = option(
        None, "HZ", "Sample the records evenly at this frequency, Hz.", kinds.NUMBER, unit="Hz"
    )
    after: float | None = option(
        None, "S", "Use samples from this time on, s.", kinds.NUMBER, gone=("--from",), unit="s"
    )
    before: float | None = option(None, "S", "Use samples up to this time, s.", kinds.NUMBER, gone=("--to",), unit="s")
    offsets: str = option(
        "auto", "WHEN", "Estimate constant torque offsets: {names} (auto: unless data exclude them).",
        names=lambda: SEEKING,
    )  # fmt: skip
    delay: str = option(
        "auto", "WHEN", "Estimate a delay of torques after positions: {names} (auto: if data indicate one).",
        names=lambda: SEEKING,
    )  # fmt: skip
    load_friction: Sequence[str] = _load_friction()
    stribeck: Values = _stribeck()
    cogging: Values = _cogging()
    link_side: Sequence[str] = option(
        (), "MOTOR|all", "Motor with a torque sensor on its load side, without rotor inertia and friction.",
        kinds.TEXTS, of_machine=motors_or_all,
    )  # fmt: skip
    robust: bool = switch("Reject outliers (contacts, collisions), and list them.")
    temperatures: bool = switch("Estimate friction per record, as at other temperatures; the first's is saved.")
    possible: bool = switch(
        "Only physically consistent bodies, friction and springs; initial values decide what data do not determine."
    )
    trust: float | None = option(
        None, "SHARE", "Expected relative error of the initial values, with --possible: 0.3 is 30 % (default: data "
        "alone decide what they determine; 1 for short records).", kinds.NUMBER, above=0, unit="",
    )  # fmt: skip
    preparation: Preparation | None = argument(None, "`gains`, `resample`, `after` and `before` as one object.")
    validate: Record | None = option(None, "FILE", "Validation record, whose torques are predicted.", kinds.INPUT_FILE)
    announce: Announce = announce_row(gone=("step",))


class Updating(Options, kw_only=False):
    """Options of `update`."""

    tests: str | Path | VibrationTests | Sequence[VibrationTest] = argument(
        ..., "A list of vibration tests (.toml), or tests as objects."
    )
    _: KW_ONLY
    seek: Sequence[str] = option(
        (), "LABEL", "Parameter that is sought: ram.stiffness, table.mass (default: every stiffness, damping and "
        "viscous friction).", kinds.TEXTS,
    )  # fmt: skip
    factor: float = option(
        2.0, "X", "Prior: initial values are right within this factor.",
        kinds.NUMBER, above=1,
    )  # fmt: skip
    mass_doubt: float = option(
        0.0, "X", "Prior relative standard deviation of masses and inertias, which are fitted, too: 0.05 is 5 %.",
        kinds.NUMBER, least=0, most=1, unit="",
    )  # fmt: skip
    without: Sequence[tuple[float, float]] = option((), "LOW:HIGH", "Frequency band, Hz, that is omitted.", kinds.BANDS)
    plain: bool = switch("Weight all frequencies equally (default: outliers are down-weighted by Cauchy's weights).")
    predict: Sequence[str] = option((), "TEST", "Test that is predicted instead of fitted, by its name.", kinds.TEXTS)
    values: Values = values_row()
    announce: Announce = announce_row()
