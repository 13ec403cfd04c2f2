"""Coverage of the standard deviations of modes from ring-downs, on noise that no choice of the program has seen.

    python -m tests.benchmarks.ring_downs [--store] [--stored]

Of sizes of noise, of damping ratios from 0.2 to 5 %, and of faults of sensors. Without options, the stored table is
printed.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from symoro_elastic.foundation.errors import InputError
from symoro_elastic.measured.vibration_tests.ring_downs import modes_of_ring_down
from tests.benchmarks.tables import Error, Run, print_or_run_table, run_of

Array = np.ndarray[Any, Any]
TRUE = np.array([[12.0, 0.02], [31.0, 0.03], [34.0, 0.02], [90.0, 0.01]])
"""Frequencies in Hz, damping ratios."""
EVERYWHERE = (0.0, 1e12)
SECONDS, RATE = 1.6, 500.0
NEAR = 0.2  # relative distance from a true frequency within which it is that of a mode
IDENTIFIED = 0.1  # relative standard deviation of an identified value


def ring_down(t: Array, noise: float, seed: int, modes: Array = TRUE) -> tuple[dict[str, Array], Array]:
    """Two signals, one 100 times the other, with white noise of a share of their first amplitude; amplitudes (2, 4)."""
    rng = np.random.default_rng(seed)
    phases = np.random.default_rng([seed, 1]).uniform(0, 2 * np.pi, len(TRUE))
    A = np.array([[1.0, 0.6, 0.5, 0.4], [100.0, -60.0, 40.0, 20.0]]) * np.exp(1j * phases)
    w, zeta = 2 * np.pi * modes[:, 0], modes[:, 1]
    waves = np.exp(np.multiply.outer(t, -zeta * w + 1j * w * np.sqrt(1 - zeta**2)))
    signals = np.real(waves @ A.T)
    signals += np.array([1.0, 100.0]) * (0.3 + noise * rng.normal(size=signals.shape))
    return {"a": signals[:, 0], "b": signals[:, 1]}, A


def _spiked(x: Array, rng: np.random.Generator) -> Array:
    return x + np.where(rng.uniform(size=x.shape) < 0.005, np.abs(x).max() * rng.choice([-1, 1], x.shape), 0.0)


def _clipped(x: Array, _: np.random.Generator) -> Array:
    most = 0.6 * np.abs(x).max()
    return np.clip(x, -most, most)


def _hum(x: Array, _: np.random.Generator) -> Array:
    return x + 0.2 * np.ptp(x) * np.sin(2 * np.pi * 50 * np.arange(len(x)) / RATE)


@dataclass(frozen=True)
class Row:
    """A row of the stored table: noise, damping of all modes (0: that of TRUE), and a change of the first signal."""

    noise: float = 0.01
    damping: float = 0.0
    fault: Callable[[Array, np.random.Generator], Array] | None = None


ROWS = {
    **{f"noise {noise:g}": Row(noise) for noise in (0.001, 0.003, 0.01, 0.03, 0.1)},
    **{f"damping {100 * x:g} %": Row(damping=x) for x in (0.002, 0.005, 0.01, 0.02, 0.05)},
    "damping 0.2 %, noise 0.1": Row(0.1, 0.002), "damping 5 %, noise 0.1": Row(0.1, 0.05),
    "spikes": Row(fault=_spiked), "clipped": Row(fault=_clipped), "hum": Row(fault=_hum),
}  # fmt: skip

TABLE = dict.fromkeys(ROWS, 40)


def table_run(row: str, seed: int) -> Run:
    """Return a run of a row of the stored table; modes that are missing have no interval."""
    case, t, modes = ROWS[row], np.arange(int(SECONDS * RATE)) / RATE, TRUE.copy()
    modes[:, 1] = case.damping or modes[:, 1]
    signals, _ = ring_down(t, case.noise, 1000 + seed, modes)
    if case.fault:
        signals["a"] = case.fault(signals["a"], np.random.default_rng([seed, 5]))
    try:
        found, notes = modes_of_ring_down(t, signals, EVERYWHERE, "simulated")
    except InputError:
        return Run(seed, "rejected")
    errors = []
    for f, zeta in modes:
        k = int(np.argmin(np.abs(found.f - f)))
        for values, stds, true in ((found.f, found.std_f, f), (found.zeta, found.std_zeta, zeta)):
            assert values is not None and stds is not None
            std = float(stds[k]) if abs(found.f[k] - f) < NEAR * f else np.nan
            errors.append(Error(float(values[k] - true), std, true, std < IDENTIFIED * true))
    return run_of(seed, "reported" if notes else "accepted", errors)


def main() -> None:
    """Run or print the table."""
    print_or_run_table("ring_downs", TABLE, table_run)


if __name__ == "__main__":
    main()
