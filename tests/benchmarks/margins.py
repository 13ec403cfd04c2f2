"""Whether intervals of shares of margins hold at unseen draws: `python -m tests.benchmarks.margins [MACHINE]`.

Stiffnesses of all springs are drawn, 15 % each; the share of unseen draws that keep nine tenths of each distance beside
the intervals that a few draws give, each from another seed, and how many of these hold.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

import symoro_elastic as se

EXAMPLES = Path(__file__).parents[2] / "examples"
UNSEEN, SEEN, SEEDS = 1000, 50, range(1, 21)
KEPT = {"*: velocity_modulus": (0.48, np.inf), "*: position_modulus": (0.68, np.inf)}


def main() -> None:
    """Try a machine, or two_axis."""
    path = sys.argv[1] if sys.argv[1:] else EXAMPLES / "two_axis.toml"
    motion = se.linearize(path).motion
    over = {n: f"lognormal:{x}:0.15" for n, x in motion.parameters.items() if n.endswith(".stiffness")}

    def drawn(count: int, seed: int) -> se.Sweep:
        return se.sweep(path, over=over, of="control", damping=0.02, outputs=["tool.x"], samples=count,
                        sampling="random", seed=seed, require=KEPT, workers=2)  # fmt: skip

    samples = [drawn(SEEN, seed).shares for seed in SEEDS]
    print(f"{'margin':28} {f'share of {UNSEEN} unseen':>22} {f'intervals of {SEEN} that hold':>28}")
    for k, one in enumerate(drawn(UNSEEN, 0).shares):
        intervals = [sample[k].interval or (0, 1) for sample in samples]
        held = sum(low <= one.share <= high for low, high in intervals)
        print(f"{one.name:28} {one.share:22.1%} {held:>25}/{len(intervals)}")


if __name__ == "__main__":
    main()
