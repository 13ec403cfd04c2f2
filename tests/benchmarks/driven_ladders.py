"""Ladders of machines under drives, on unseen draws: `python -m tests.benchmarks.driven_ladders [FIRST COUNT]`.

Measured errors over predicted ones, where springs, lags, dead times and filters are left out. Odd draws have filters
of set points or the inverse model, windings, and limits that are not reached.
"""

from __future__ import annotations

import sys

import numpy as np

from symoro_elastic.analysis.ladder.rung import DOUBT
from tests.analysis.ladder.test_drives import drawn, equipped, ratios, rungs_of


def main() -> None:
    """Print ratios by draw, and their quantiles."""
    first, count = (int(x) for x in sys.argv[1:3] or (200, 20))
    found = list[float]()
    for seed in range(first, first + count):
        measurement, rungs = rungs_of(seed, (drawn, equipped)[seed % 2])
        new = ratios(measurement, rungs[1::2])
        found += new
        said = f"{min(new):.3f} to {max(new):.3f}" if new else "unstable, or nothing above a thousandth"
        print(f"draw {seed}: {len(new)} errors, {said}", flush=True)
    x = np.array(found)
    quantiles = ", ".join(f"{q:.3f}" for q in np.quantile(x, (0, 0.05, 0.5, 0.95, 1)))
    print(f"{len(x)} errors, measured over predicted {quantiles} (0, 5, 50, 95, 100 %)")
    print(f"within a factor of {DOUBT:g}: {np.mean((x > 1 / DOUBT) & (x < DOUBT)):.1%}")


if __name__ == "__main__":
    main()
