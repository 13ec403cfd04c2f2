"""A mechanism modulo a large prime at random values of its variables and parameters: zero means zero for all values."""

from __future__ import annotations

from collections.abc import Callable

from symoro_elastic.foundation.scalar import Scalar
from symoro_elastic.mechanics.mechanism import Mechanism
from symoro_elastic.symbolic.arithmetic import ModularAngles
from symoro_elastic.symbolic.expression import Expression

SEED = 20260


def modulo_prime(mechanism: Mechanism, angles: ModularAngles | None = None) -> Mechanism:
    """Return a mechanism of expressions as one of residues; `angles` holds values of other expressions too."""
    return mechanism.map((angles or ModularAngles(SEED)).values(mechanism.scalars()))


def zero_test(seed: int = SEED) -> Callable[[Scalar], bool]:
    """Return a test of whether an expression is zero at all values of its variables and parameters."""
    residues = ModularAngles(seed)

    def is_zero(x: Scalar) -> bool:
        return not residues.values([x])(x) if isinstance(x, Expression) else x == 0

    return is_zero
