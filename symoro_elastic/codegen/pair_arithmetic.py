"""Functions on sums of two doubles in C: which of them need which."""

from __future__ import annotations

from collections.abc import Iterable

NEEDS: dict[str, tuple[str, ...]] = {
    "make": (),
    "negative": ("make",),
    "exact_sum": ("make",),
    "ordered_sum": ("make",),
    "exact_product": ("make",),
    "sum": ("exact_sum", "ordered_sum"),
    "difference": ("sum", "negative"),
    "product": ("exact_product", "ordered_sum"),
    "quotient": ("difference", "product", "ordered_sum", "sum", "make"),
    "sqrt": ("exact_product", "difference", "ordered_sum", "make"),
    "sign": ("make",),
    "sincos": ("make", "exact_product", "difference", "product", "sum", "negative"),
    "sin": ("sincos",),
    "cos": ("sincos",),
    "atan2": ("sincos", "make", "difference", "product", "sum", "quotient"),
}


def with_needed(called: Iterable[str], has_angles: bool) -> frozenset[str]:
    """Return the functions that are called, and all that they call."""
    found: set[str] = set()
    stack = [*called, *(["sincos"] if has_angles else [])]
    while stack:
        name = stack.pop()
        if name not in found:
            found.add(name)
            stack += NEEDS[name]
    return frozenset(found)
