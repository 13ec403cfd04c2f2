"""Names of the quantities in inverse geometric models."""

from __future__ import annotations

from collections.abc import Sequence

from symoro_elastic.equations.inverse_geometry.model import Branch
from symoro_elastic.equations.spatial import AxialTransform
from symoro_elastic.models.bind import Bound
from symoro_elastic.scalar import Scalar
from symoro_elastic.symbolic.expression import Expression
from symoro_elastic.symbolic.operations import COS
from symoro_elastic.symbolic.program import Section


def name_branches(bound: Bound, branches: Sequence[Branch]) -> None:
    """Name angles, lengths, their sines and cosines and what vanishes, after joint and first solution."""
    for number, branch in enumerate(branches, start=1):
        for found in branch.found:
            here = Section(f"Solution {number}", found.joint)
            bound.names.give(found.measure, f"root{found.joint}_{number}", here)
            bound.names.give(found.motion.cosine, f"cos{found.joint}_{number}", here)
            bound.names.give(found.motion.sine, f"sin{found.joint}_{number}", here)
            bound.names.give(_angle(found.motion), f"angle{found.joint}_{number}", here)
            bound.names.give(found.motion.shift, f"length{found.joint}_{number}", here)


def _angle(motion: AxialTransform) -> Scalar:
    """The angle of which a motion holds the cosine."""
    cosine = motion.cosine
    return cosine.operands[0] if isinstance(cosine, Expression) and cosine.operation == COS else 0
