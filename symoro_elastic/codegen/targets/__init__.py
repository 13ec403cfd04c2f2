"""The targets by name; a new one is a module here and an entry in `TARGETS`."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from symoro_elastic.codegen.package import Package
from symoro_elastic.codegen.package_context import Files
from symoro_elastic.codegen.precision import DOUBLE, Precision
from symoro_elastic.codegen.target import Target
from symoro_elastic.codegen.targets import c, numpy
from symoro_elastic.codegen.targets.c import C
from symoro_elastic.codegen.targets.c_batch import C_BATCH
from symoro_elastic.codegen.targets.c_fixed import C_FIXED
from symoro_elastic.codegen.targets.cpp import CPP
from symoro_elastic.codegen.targets.cuda import CUDA
from symoro_elastic.codegen.targets.linuxcnc import LINUXCNC
from symoro_elastic.codegen.targets.matlab import MATLAB
from symoro_elastic.codegen.targets.numpy import NUMPY
from symoro_elastic.codegen.targets.python import PYTHON
from symoro_elastic.codegen.targets.st import ST

TARGETS: dict[str, Target] = {
    target.name: target for target in (NUMPY, C, C_BATCH, CPP, PYTHON, MATLAB, CUDA, ST, LINUXCNC)
}
SCALED_TARGETS: dict[str, Target] = {target.name: target for target in (C_FIXED,)}
"""Targets that need packages with scales, which `numerics` proves for the limits of a machine."""
FMU = "fmu"
"""The target that needs the machine itself: `generation` writes it."""
TARGET_NAMES = (*TARGETS, *SCALED_TARGETS, FMU)
"""All values of `--target`."""
DEFAULT_TARGETS = (NUMPY.name, C.name)
RESERVED: frozenset[str] = frozenset().union(*(target.reserved for target in TARGETS.values()))
"""Identifiers that the language or the libraries of some target use."""
KEYWORDS = c.KEYWORDS | numpy.KEYWORDS
"""Reserved names that are keywords."""


def render_targets(package: Package, targets: Iterable[str], precisions: Sequence[Precision] = (DOUBLE,)) -> Files:
    """Return the files of targets in the precisions that they support, else in their default precision.

    Raises `OverflowError` for constants outside the range of double precision.
    """
    files: Files = {}
    for target in (TARGETS[name] for name in targets):
        possible = [precision for precision in precisions if precision in target.precisions]
        files |= target.render(package, possible or target.precisions[:1])
    return files
