"""The options of `update`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import KW_ONLY
from pathlib import Path
from typing import TYPE_CHECKING

from symoro_elastic.api import kinds
from symoro_elastic.api.declaration import Options, argument, option, switch
from symoro_elastic.api.rows import Values, announce_row, values_row

if TYPE_CHECKING:
    from symoro_elastic.analysis.updating.measured import VibrationTest, VibrationTests
    from symoro_elastic.foundation.progress import Announce


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
    trust: float = option(
        2.0, "X", "Factor within which values of the file are right: the prior of what no test tells.", kinds.NUMBER,
        above=1,
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
