"""Packages that only identification needs, imported when they are."""

from __future__ import annotations

from importlib import import_module
from typing import Any

from symoro_elastic.errors import InputError


def optional(module: str) -> Any:
    """A module of scipy or matplotlib; raises `InputError` that says how to install it."""
    package = module.partition(".")[0]
    try:
        return import_module(module)
    except ImportError:
        what = f"identification needs {package}: pip install 'symoro-elastic[identify]'"
        raise InputError("symoro-elastic", package, what) from None
