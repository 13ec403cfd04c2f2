"""The targets: each renders a package as file names and their texts."""

from __future__ import annotations

from collections.abc import Iterable

from symoro_elastic.codegen.c import render_c
from symoro_elastic.codegen.described import Files
from symoro_elastic.codegen.package import Package
from symoro_elastic.codegen.precision import DOUBLE, Precision
from symoro_elastic.codegen.targets.numpy import render_numpy

TARGETS = ("numpy", "c")


def render_targets(package: Package, targets: Iterable[str], precisions: Iterable[Precision] = (DOUBLE,)) -> Files:
    """The files of all targets; C in each of the precisions. Raises `OverflowError` for constants no double holds."""
    files: Files = {}
    for target in targets:
        if target == "numpy":
            files |= render_numpy(package)
        else:
            for precision in precisions:
                files |= render_c(package, precision)
    return files
