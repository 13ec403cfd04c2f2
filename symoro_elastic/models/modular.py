"""A mechanism modulo a large prime at random values of its variables and parameters: zero means zero for all values."""

from __future__ import annotations

from symoro_elastic.mechanics.mechanism import Mechanism
from symoro_elastic.symbolic.arithmetic import ModularAngles

SEED = 20260


def modulo_prime(mechanism: Mechanism, angles: ModularAngles | None = None) -> Mechanism:
    """Return a mechanism of expressions as one of residues; `angles` holds values of other expressions too."""
    return mechanism.map((angles or ModularAngles(SEED)).values(mechanism.scalars()))
