"""What the processor can multiply and add in a second: independent chains in registers, fused or not."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence

import numpy as np

from tests.benchmarks.contest import Contestant, compiled, entry, fill, timed_batch

CHAINS, STEPS = 14, 64
"""As many chains as the sixteen registers of AVX2 hold beside a factor and a term: more would time loads and stores."""
PREAMBLE = """
typedef @SCALAR@ vector __attribute__((vector_size(@BYTES@)));
"""
PASS = """
    (void)states;
    vector v[@CHAINS@];
    const vector factor = (vector){0} + x[0], term = (vector){0} + x[1];
    for (int k = 0; k < @CHAINS@; ++k) v[k] = (vector){0} + x[2] + (@SCALAR@)k;
    for (int step = 0; step < @STEPS@; ++step) {
        @STEP@
    }
    for (int k = 0; k < @CHAINS@; ++k) y[k] = v[k][0];
"""


def limit(name: str, flags: Sequence[str], *, bytes_: int, fused: bool, scalar: str = "double") -> Contestant:
    """A contestant whose time is that of one operation; a fused one counts as two."""
    dtype = {"double": np.float64, "float": np.float32}[scalar]
    lanes = bytes_ // np.dtype(dtype).itemsize
    steps = " ".join(f"v[{k}] = v[{k}] * factor + term;" for k in range(CHAINS))
    text = timed_batch(fill(PREAMBLE, BYTES=bytes_), fill(PASS, CHAINS=CHAINS, STEPS=STEPS, STEP=steps), scalar=scalar)
    command = ["gcc", "-O3", "-fPIC", "-shared", f"-ffp-contract={'fast' if fused else 'off'}", *flags]
    library = ctypes.CDLL(str(compiled(command, {"limit.c": text})))
    x, y = np.array([0.5, 1, 2], dtype), np.zeros(CHAINS, dtype)
    return Contestant(name, entry(library), x, y, lambda y: y, 2 * CHAINS * STEPS * lanes)
