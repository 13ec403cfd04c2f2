"""Types of numpy arrays in annotations."""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

Array: TypeAlias = NDArray[np.float64]
"""Real numbers in double precision."""
ComplexArray: TypeAlias = NDArray[np.complex128]
"""Complex numbers in double precision."""
BoolArray: TypeAlias = NDArray[np.bool_]
"""Truth values."""
IndexArray: TypeAlias = NDArray[np.intp]
"""Indices."""
AnyArray: TypeAlias = NDArray[Any]
"""Entries of any type."""
