"""Names of the quantities in inverse geometric models."""

from __future__ import annotations

from collections.abc import Sequence

from symoro_elastic.equations.inverse_geometry import Branch
from symoro_elastic.models.bind import Bound
from symoro_elastic.symbolic.program import Section


def name_branches(bound: Bound, branches: Sequence[Branch]) -> None:
    """Name angles, lengths, their sines and cosines and what vanishes, after joint and first solution."""
    for number, branch in enumerate(branches, start=1):
        for found in branch.found:
            here = Section(f"Solution {number}", found.joint)
            bound.names.give(found.measure, f"root{found.joint}_{number}", here)
            bound.names.give(found.variable, f"angle{found.joint}_{number}", here)
            bound.names.give(found.motion.cosine, f"cos{found.joint}_{number}", here)
            bound.names.give(found.motion.sine, f"sin{found.joint}_{number}", here)
