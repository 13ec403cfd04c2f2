"""Packages that only the analysis of vibrations needs, imported when they are."""

from __future__ import annotations

from typing import Any

from symoro_elastic.packages import imported


def optional(module: str) -> Any:
    """A module of scipy; raises `InputError` that says how to install it."""
    return imported(module, "the analysis of vibrations", "analysis")
