"""What vibration tests measured: frequency responses and modes of a machine at known positions, in SI units."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

from symoro_elastic.foundation.array_types import Array, ComplexArray
from symoro_elastic.measured.vibration_tests.windows import Window, WindowKind, usual_window

ROUGH_F = 0.05  # relative standard deviation of frequencies by which values far off are compared


@dataclass(frozen=True)
class MeasuredResponse:
    """H (N), complex, from an input to an output, at frequencies f (N) in Hz that increase from above 0.

    Names are those of signals of `response`, without a sign: signs and units of files are in H. Every number is finite.
    `coherence` (N), 0 to 1, is None where it was not measured.
    """

    output: str
    input: str
    f: Array
    H: ComplexArray
    coherence: Array | None = None

    @property
    def pair(self) -> str:
        """Output and input, as files head them."""
        return f"{self.output}/{self.input}"


@dataclass(frozen=True)
class MeasuredModes:
    """Natural frequencies f (k) in Hz that increase, damping ratios zeta (k), and standard deviations of both.

    `std_f` in Hz and `std_zeta`, (k) each, are None where they are unknown; entries of `zeta`, `std_f` and `std_zeta`
    are NaN where they are unknown for one mode. `shapes` (k, outputs), complex, each mode scaled arbitrarily, are
    amplitudes at `outputs`, names without signs; None where no shape was measured.
    """

    f: Array
    zeta: Array | None = None
    std_f: Array | None = None
    std_zeta: Array | None = None
    outputs: tuple[str, ...] = ()
    shapes: ComplexArray | None = None


@dataclass(frozen=True)
class VibrationTest:
    """One test: responses or modes of a machine in equilibrium at positions `at` (rad or m, by joint).

    Motors in `hold` do not move; those in `pd` are driven by Kp (N m/rad or N/m) and Kv (N m s/rad or N s/m), None
    where the gains are unknown; those in `drives` by their cascades of the machine file; others are free. `averages`
    are those of each response. With `validate` the test is predicted, not fitted. `window` is the one over records that
    responses were made of, None where it is not named.
    """

    name: str
    at: Mapping[str, float]
    hold: tuple[str, ...] = ()
    pd: Mapping[str, tuple[float, float] | None] = field(default_factory=dict)
    averages: int | None = None
    validate: bool = False
    responses: tuple[MeasuredResponse, ...] = ()
    modes: MeasuredModes | None = None
    drives: tuple[str, ...] = ()
    window: Window | None = None

    def with_zero(self, joint: str, zero: float) -> VibrationTest:
        """Return the test with this added to the position of a joint."""
        return replace(self, at={**self.at, joint: self.at.get(joint, 0.0) + zero})


def roughly(test: VibrationTest) -> VibrationTest:
    """Return a test whose modes are known roughly, so that those far off differ by more than being far."""
    if (modes := test.modes) is None:
        return test
    return replace(test, modes=replace(modes, std_f=ROUGH_F * modes.f, std_zeta=None))


def with_windows(
    tests: Sequence[VibrationTest], kind: WindowKind, named: Window | None = None
) -> tuple[VibrationTest, ...] | None:
    """Return the tests with this window where they have the one named and it may be; None where there are none."""
    changed = []
    for test in tests:
        usual = usual_window(kind, test.responses[0].f) if test.responses and test.window == named else None
        changed.append(test if usual in (None, test.window) else replace(test, window=usual))
    return tuple(changed) if any(new is not old for new, old in zip(changed, tests, strict=True)) else None


@dataclass(frozen=True)
class VibrationTests:
    """The vibration tests of a machine; `notes` are lines for the user about what files left out."""

    tests: tuple[VibrationTest, ...]
    notes: tuple[str, ...] = ()
