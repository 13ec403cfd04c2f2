"""Packages that only a part of the work needs, imported when it is asked for."""

from __future__ import annotations

from importlib import import_module
from typing import Any

from symoro_elastic.errors import InputError


def imported(module: str, work: str, extra: str) -> Any:
    """A module of a package that `work` needs; raises `InputError` that says how to install the extra."""
    package = module.partition(".")[0]
    try:
        return import_module(module)
    except ImportError:
        what = f"{work} needs {package}: pip install 'symoro-elastic[{extra}]'"
        raise InputError("symoro-elastic", package, what) from None
