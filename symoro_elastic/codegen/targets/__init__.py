"""The targets: each renders a package as file names and their texts."""

from __future__ import annotations

from collections.abc import Iterable

from symoro_elastic.codegen.c import render_c
from symoro_elastic.codegen.described import Files
from symoro_elastic.codegen.package import Package
from symoro_elastic.codegen.precision import DOUBLE, Precision
from symoro_elastic.codegen.targets.numpy import render_numpy

TARGETS = ("numpy", "c")
_WORDS = """
    p c stride live sine cosine angle sign math np numpy all nan inf NaN Inf infinity
    JOINTS MOTORS ELASTIC PARAMETERS DEFAULTS FRAMES OUTPUTS parameters
    NUMBER ANGLE BITS OF WHOLE EXCESS EQUATIONS LOAD LOAD_ANGLE STORE NARROW WIDTH LANES VECTOR VECTOR_BYTES INLINE
    APART LARGEST_ANGLE numbers angles bits lanes_at put circle circles far_circles double_double pair
    pair_arc_tangent pair_cosine pair_difference pair_exact_product pair_exact_sum pair_negative pair_ordered_sum
    pair_polynomial pair_product pair_quotient pair_rounded pair_sign pair_sine pair_square_root pair_sum pair_turn
"""
RESERVED = frozenset(_WORDS.split())
"""Identifiers that some target uses itself."""


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
