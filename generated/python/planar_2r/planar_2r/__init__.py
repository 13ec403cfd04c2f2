"""planar_2r: generated models, compiled; needs numpy only.

SI units, radians. Arguments are arrays, lists or numbers, by position or by name. States may be stacked along leading
axes, which broadcast. NaN in the inputs a result depends on gives NaN. Results are new arrays of float64, or `out`: an
array, or a tuple of arrays, in which they are written. Text, dates and complex numbers raise TypeError.
"""

import numpy as np

from . import _arguments, _calls, _real_numbers

JOINTS = ("shoulder", "elbow")
MOTORS = (0, 1)
ELASTIC = ()
FRAMES = ("shoulder", "elbow", "tip")
PARAMETERS = ("g0", "m1", "m2", "l1", "l2", "lc1", "lc2", "I1", "I2")
DEFAULTS = np.array([9.81, 2.5, 1.5, 0.4, 0.3, 0.2, 0.15, 0.035, 0.012], dtype=float)
DEFAULTS.flags.writeable = False
# What the entries of each result belong to.
OUTPUTS = {
    "inertia_matrix": {
        "A": ("shoulder", "elbow"),
    },
}


def parameters(**values):
    """Array of parameter values: the defaults, replaced by those given by name."""
    unknown = sorted(set(values) - set(PARAMETERS))
    if unknown:
        raise TypeError(f"planar_2r has no parameter {', '.join(unknown)}")
    p = np.array([values.get(name, default) for name, default in zip(PARAMETERS, DEFAULTS.tolist())], dtype=float)
    missing = [name for name, value in zip(PARAMETERS, p.tolist()) if value != value and name not in values]
    if missing:
        raise ValueError(f"planar_2r needs a value for {', '.join(missing)}")
    return p


def compiled(**shapes):
    """Replace a description by the compiled function of its name; inputs have one of these shapes at a state."""

    def described(description):
        function = _calls.Function(description.__name__, _arguments.call_anyhow)
        return _arguments.describe(function, description, shapes, _real_numbers.real_numbers)

    return described


@compiled(q=((2,),), p=((9,),))
def inertia_matrix(q, p=DEFAULTS):
    """Inertia matrix [8].

    3x 5+, 1 sin/cos a call; 5x 2+, 0 sin/cos once for each parameter set.
    q (2): joint variables, rad or m
    -> A (2 x 2): inertia matrix, kg m2, kg m or kg
    """
