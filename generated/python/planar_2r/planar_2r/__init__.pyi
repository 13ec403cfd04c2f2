from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

JOINTS: Final[tuple[str, ...]]
MOTORS: Final[tuple[int, ...]]
ELASTIC: Final[tuple[int, ...]]
FRAMES: Final[tuple[str, ...]]
PARAMETERS: Final[tuple[str, ...]]
DEFAULTS: Final[Array]
OUTPUTS: Final[dict[str, dict[str, tuple[str, ...]]]]

def parameters(**values: float) -> Array: ...
def inertia_matrix(q: ArrayLike, p: ArrayLike = ..., *, out: Array | None = None) -> Array: ...
