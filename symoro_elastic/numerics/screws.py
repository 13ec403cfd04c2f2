"""Placements in any numbers, turned about and moved along one of their own axes."""

from __future__ import annotations

from typing import Any, TypeAlias

from symoro_elastic.numerics.linear_systems import NumberMatrix

Screw: TypeAlias = tuple[Any, Any, Any]
"""Cosine and sine of the angle, and the shift."""


def screwed_about_z(placement: NumberMatrix, c: Any, s: Any, shift: Any) -> NumberMatrix:
    """Return T Rot(z) Trans(z), by the columns of T."""
    return [*([x * c + y * s, y * c - x * s, z, p + z * shift] for x, y, z, p in placement[:3]), placement[3]]


def screwed_about_x(placement: NumberMatrix, c: Any, s: Any, shift: Any) -> NumberMatrix:
    """Return T Rot(x) Trans(x), by the columns of T."""
    return [*([x, y * c + z * s, z * c - y * s, p + x * shift] for x, y, z, p in placement[:3]), placement[3]]
