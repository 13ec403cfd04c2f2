"""Coverage of the standard deviations of modes from ring-downs, on noise that no choice of the program has seen.

python -m tests.benchmarks.ring_downs --count 100
"""

from __future__ import annotations

import argparse
from collections.abc import Iterable
from typing import Any

import numpy as np

from symoro_elastic.analysis.updating.ring_downs import modes_of_ring_down

Array = np.ndarray[Any, Any]
TRUE = np.array([[12.0, 0.02], [31.0, 0.03], [34.0, 0.02], [90.0, 0.01]])
"""Frequencies in Hz, damping ratios."""
EVERYWHERE = (0.0, 1e12)
SECONDS, RATE = 1.6, 500.0


def ring_down(t: Array, noise: float, seed: int) -> tuple[dict[str, Array], Array]:
    """Two signals, one 100 times the other, with white noise of a share of their first amplitude; amplitudes (2, 4)."""
    rng = np.random.default_rng(seed)
    phases = np.random.default_rng([seed, 1]).uniform(0, 2 * np.pi, len(TRUE))
    A = np.array([[1.0, 0.6, 0.5, 0.4], [100.0, -60.0, 40.0, 20.0]]) * np.exp(1j * phases)
    w, zeta = 2 * np.pi * TRUE[:, 0], TRUE[:, 1]
    waves = np.exp(np.multiply.outer(t, -zeta * w + 1j * w * np.sqrt(1 - zeta**2)))
    signals = np.real(waves @ A.T)
    signals += np.array([1.0, 100.0]) * (0.3 + noise * rng.normal(size=signals.shape))
    return {"a": signals[:, 0], "b": signals[:, 1]}, A


def coverage(noise: float, seeds: Iterable[int]) -> tuple[int, int, float]:
    """Values within 1.96 standard deviations of the truth, all values, and the median of the numbers of modes."""
    t, within, count, modes = np.arange(int(SECONDS * RATE)) / RATE, 0, 0, []
    for seed in seeds:
        found, _ = modes_of_ring_down(t, ring_down(t, noise, seed)[0], EVERYWHERE, "simulated")
        modes.append(len(found.f))
        for f, zeta in TRUE:
            k = int(np.argmin(np.abs(found.f - f)))
            assert found.zeta is not None and found.std_f is not None and found.std_zeta is not None
            within += int(abs(found.f[k] - f) < 1.96 * found.std_f[k])
            within += int(abs(found.zeta[k] - zeta) < 1.96 * found.std_zeta[k])
            count += 2
    return within, count, float(np.median(modes))


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=100, help="records for each size of noise")
    count = parser.parse_args().count
    for noise in (0.001, 0.003, 0.01, 0.03, 0.1):
        within, values, modes = coverage(noise, range(1000, 1000 + count))
        print(f"noise {noise:5.3f}: coverage {within / values:.3f} of {values}, modes {modes:g}", flush=True)


if __name__ == "__main__":
    main()
