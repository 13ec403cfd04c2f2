"""The options of `excite`, `identify` and `update`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY
from pathlib import Path
from typing import TYPE_CHECKING, Any

from symoro_elastic.api import kinds
from symoro_elastic.api.declaration import Options, argument, option, switch
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
    from symoro_elastic.analysis.updating.measured import VibrationTest, VibrationTests
    from symoro_elastic.foundation.progress import Announce, Progress


def _limits(metavar: str, meaning: str) -> Any:
    what = f"{meaning} of all motors, or of one (NAME=...), SI units (default: [limits] of the machine)."
    return option({}, metavar, what, kinds.LIMITS)


def _load_friction() -> Any:
    return option(
        (), "MOTOR|all", "Motor whose dry friction rises with the torque through its transmission (FL).", kinds.TEXTS,
        of_machine=motors_or_all,
    )  # fmt: skip


def _stribeck() -> Any:
    what = "Velocity, rad/s or m/s, at which half of static less coulomb friction is left (FB)."
    return option({}, "MOTOR=V", what, kinds.NUMBERS)


def _cogging() -> Any:
    what = "Periods of cogging in a turn of the rotor, whose amplitudes are sought (CC, CS)."
    return option({}, "MOTOR=N", what, kinds.NUMBERS)


class Exciting(Options, kw_only=False):
    """What `excite` takes."""

    position: Ranges | Range = _limits("[NAME=]LOW:HIGH", "Range of positions")
    velocity: Values | Ranges | float = _limits("[NAME=]MAX", "Largest velocity")
    acceleration: Values | Ranges | float = _limits("[NAME=]MAX", "Largest acceleration")
    _: KW_ONLY
    workspace: Ranges = option(
        {}, "SIGNAL=LOW:HIGH", "Range of a position of a frame or point, such as tool.x, m, that the motion keeps.",
        kinds.RANGES,
    )  # fmt: skip
    payload: Ranges = option(
        {}, "NAME=LOW:HIGH", "Range of a parameter, such as the mass of a payload, within which torques keep [limits].",
        kinds.RANGES,
    )  # fmt: skip
    load_friction: Sequence[str] = _load_friction()
    stribeck: Values = _stribeck()
    cogging: Values = _cogging()
    fundamental: float = option(
        0.1, "HZ", "Fundamental frequency of the motion, Hz.", kinds.NUMBER, above=0,
        formerly=("--frequency", "frequency"),
    )  # fmt: skip
    harmonics: int = option(5, "N", "Harmonics of the Fourier series.", kinds.WHOLE, least=1, most=50)
    periods: int = option(3, "N", "Periods of the motion, without start and stop.", kinds.WHOLE, least=1, most=1000)
    sample_rate: float = sample_rate_row(1000.0, above=0)
    evaluations: int = option(1500, "N", "Motions that the search evaluates.", kinds.WHOLE, least=1, most=1_000_000)
    seed: int = seed_row()
    values: Values = values_row()
    known: Sequence[str] | Mapping[str, float | None] = known_row()
    seek: Sequence[str] = seek_row()
    progress: Progress = progress_row()


class Identifying(Options, kw_only=False):
    """What `identify` takes."""

    records: Record | Sequence[Record] = argument(
        ..., "CSV or NPZ files with t, q_<joint>, tau_<motor>, or such columns as arrays by name; one or several."
    )
    _: KW_ONLY
    values: Values = values_row()
    known: Mapping[str, float | None] = known_row()
    seek: Sequence[str] = seek_row()
    bandwidth: float | None = option(
        None, "HZ", "Bandwidth of the motion, Hz (default: from its spectrum).", kinds.NUMBER
    )
    gains: Values = option(
        {}, "MOTOR=K", "Factor from a measured column (a current, say) to motor torque.", kinds.NUMBERS
    )
    resample: float | None = option(None, "HZ", "Sample the records evenly at this frequency, Hz.", kinds.NUMBER)
    after: float | None = option(None, "S", "Use samples from this time on, s.", kinds.NUMBER, formerly=("--from",))
    before: float | None = option(None, "S", "Use samples up to this time, s.", kinds.NUMBER, formerly=("--to",))
    offsets: str = option(
        "auto", "WHEN", "Whether constant offsets of torques are sought: {names} (auto: unless data rule them out).",
        names=lambda: SEEKING,
    )  # fmt: skip
    delay: str = option(
        "auto", "WHEN", "Whether a delay of torques behind positions is sought: {names} (auto: where data show it).",
        names=lambda: SEEKING,
    )  # fmt: skip
    load_friction: Sequence[str] = _load_friction()
    stribeck: Values = _stribeck()
    cogging: Values = _cogging()
    link_side: Sequence[str] = option(
        (), "MOTOR|all", "Motor whose torque is measured behind its transmission, so that no rotor or friction shows.",
        kinds.TEXTS, of_machine=motors_or_all,
    )  # fmt: skip
    robust: bool = switch("Leave out averages that stand out (contacts, collisions), and name them.")
    temperatures: bool = switch("Records have friction of their own, as at other temperatures; saved is the first's.")
    possible: bool = switch(
        "Seek only possible bodies, friction and springs; the machine's file decides what the data do not determine."
    )
    trust: float | None = option(
        None, "SHARE", "How far values of the file may be from the truth, with --possible: 0.3 is 30 % (default: data "
        "alone decide what they determine; 1 for short records).", kinds.NUMBER, above=0,
    )  # fmt: skip
    preparation: Preparation | None = argument(None, "`gains`, `resample`, `after` and `before` as one object.")
    validate: Record | None = option(None, "FILE", "Record whose torques are predicted, too.", kinds.INPUT_FILE)
    announce: Announce = announce_row(formerly=("step",))


class Updating(Options, kw_only=False):
    """What `update` takes."""

    tests: str | Path | VibrationTests | Sequence[VibrationTest] = argument(
        ..., "A list of vibration tests (.toml), or tests as objects."
    )
    _: KW_ONLY
    seek: Sequence[str] = option(
        (), "LABEL", "Parameter that is sought: ram.stiffness, table.mass (default: every stiffness, damping and "
        "viscous friction).", kinds.TEXTS,
    )  # fmt: skip
    factor: float = option(
        2.0, "X", "Factor within which values of the file are right: the prior of what no test determines.",
        kinds.NUMBER, above=1,
    )  # fmt: skip
    mass_doubt: float = option(
        0.0, "X", "Relative standard deviation of masses and inertias, which are fitted within it: 0.05 is 5 %.",
        kinds.NUMBER, least=0, most=1,
    )  # fmt: skip
    without: Sequence[tuple[float, float]] = option(
        (), "LOW:HIGH", "Band of frequencies, Hz, that is left out.", kinds.BANDS
    )
    plain: bool = switch("Count all lines in full (default: lines far off count less, by Cauchy's weights).")
    predict: Sequence[str] = option((), "TEST", "Test that is predicted, and not fitted, by its name.", kinds.TEXTS)
    values: Values = values_row()
    announce: Announce = announce_row()
