"""Optional packages, imported when a function needs them."""

from __future__ import annotations

from importlib import import_module
from typing import Any

from symoro_elastic.foundation.errors import InputError

DISTRIBUTIONS = {"flint": "python-flint"}
"""Names under which packages are installed, where they differ from the name of the module."""


def import_optional(module: str, work: str, extra: str) -> Any:
    """Return a module of a package that `work` needs; raises `InputError` that says how to install the extra."""
    package = module.partition(".")[0]
    package = DISTRIBUTIONS.get(package, package)
    try:
        return import_module(module)
    except (ImportError, OSError) as error:  # OSError: a library of the system is missing
        missing = isinstance(error, ModuleNotFoundError) and error.name == module.partition(".")[0]
        what = f"{work} needs {package}: pip install 'symoro-elastic[{extra}]'"
        broken = f"{package} is installed, but cannot be loaded: {error}"
        raise InputError("symoro-elastic", package, what if missing else broken) from None


def for_identification(module: str) -> Any:
    """Return a module of scipy that identification needs; raises `InputError`."""
    return import_optional(module, "identification", "identify")


def for_vibrations(module: str) -> Any:
    """Return a module of scipy that the analysis of vibrations needs; raises `InputError`."""
    return import_optional(module, "the analysis of vibrations", "analysis")
