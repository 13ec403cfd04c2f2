"""What is wanted of a simulated motion: accuracy of signals, and time of the steps. SI units, radians."""

from __future__ import annotations

from dataclasses import dataclass, field

from symoro_elastic.errors import InputError


@dataclass(frozen=True)
class Wanted:
    """Errors that are allowed, by signal ("tool.x", "motor_x.tau"), or one for all `outputs`, m or rad.

    `period` is that of a controller, which a whole number of steps fills, and `time` the largest time that these steps
    may take, s. None: nothing is wanted of it. `source` is the file.
    """

    tolerance: dict[str, float] | float | None = None
    outputs: tuple[str, ...] = ()
    period: float | None = None
    time: float | None = None
    source: str = field(default="", compare=False)

    def error(self, key: str, what: str) -> InputError:
        """The error to raise about one key."""
        return InputError(self.source, f"wanted, {key}", what)
