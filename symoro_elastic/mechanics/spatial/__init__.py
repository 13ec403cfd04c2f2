"""Spatial algebra generic in the scalar: vectors, twists and wrenches, transforms, inertias."""

from symoro_elastic.foundation.scalar import Scalar
from symoro_elastic.mechanics.spatial.axes import Axis
from symoro_elastic.mechanics.spatial.inertias import ArticulatedInertia, Outer, RigidInertia, rotated_matrix
from symoro_elastic.mechanics.spatial.transforms import AxialTransform, Rotation, Transform, roll_pitch_yaw, translation
from symoro_elastic.mechanics.spatial.twists import AT_REST, NO_WRENCH, SpatialVector, Twist, Wrench
from symoro_elastic.mechanics.spatial.vectors import (
    ENTRY,
    EX,
    EY,
    EZ,
    IDENTITY,
    ZERO,
    Matrix,
    Symmetric,
    Vector,
    X,
    Y,
    Z,
    cross,
    dot,
    hat_plus_hat_squared,
    is_zero,
)

__all__ = [
    "AT_REST",
    "ENTRY",
    "EX",
    "EY",
    "EZ",
    "IDENTITY",
    "NO_WRENCH",
    "ZERO",
    "ArticulatedInertia",
    "AxialTransform",
    "Axis",
    "Matrix",
    "Outer",
    "RigidInertia",
    "Rotation",
    "Scalar",
    "SpatialVector",
    "Symmetric",
    "Transform",
    "Twist",
    "Vector",
    "Wrench",
    "X",
    "Y",
    "Z",
    "cross",
    "dot",
    "hat_plus_hat_squared",
    "is_zero",
    "roll_pitch_yaw",
    "rotated_matrix",
    "translation",
]
