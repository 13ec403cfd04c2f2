"""flex4: generated models; needs numpy only.

SI units, radians. q, qd, qdd follow JOINTS, tau and qdd_motor follow MOTORS. States may be
stacked along leading axes, which broadcast. NaN in the inputs a result depends on gives NaN.

Results are new arrays and share no memory with the arguments, which are read only: one array may
serve as several of them. Results are float32 where all states are (more than a few states are
computed in it, too), float64 otherwise. Complex arguments raise TypeError; masks of masked arrays are
not looked at.
"""

import numpy as np

from . import _direct_dynamics, _inverse_dynamics, _runtime

_DIGEST = 738153786  # of the files of this package: those of another run are not imported
for _file in (_direct_dynamics, _inverse_dynamics, _runtime):
    if getattr(_file, "_DIGEST", None) != _DIGEST:
        raise ImportError(f"flex4: {_file.__file__} is of another run of symoro-elastic: generate all files again")

JOINTS = ("j1", "j2", "j3", "j4")
MOTORS = (0, 2)
ELASTIC = (1, 3)
FRAMES = ("j1", "j2", "j3", "j4")
PARAMETERS = (
    "XX1", "XY1", "XZ1", "YY1", "YZ1", "ZZ1", "MX1", "MY1", "MZ1", "M1", "IA1", "XX2", "XY2",
    "XZ2", "YY2", "YZ2", "ZZ2", "MX2", "MY2", "MZ2", "M2", "k2", "L2", "XX3", "XY3", "XZ3",
    "YY3", "YZ3", "ZZ3", "MX3", "MY3", "MZ3", "M3", "IA3", "XX4", "XY4", "XZ4", "YY4", "YZ4",
    "ZZ4", "MX4", "MY4", "MZ4", "M4", "k4", "G3",
)
DEFAULTS = np.array([
    np.nan, np.nan, np.nan, np.nan, np.nan, np.nan, np.nan, np.nan, np.nan, np.nan, np.nan,
    np.nan, np.nan, np.nan, np.nan, np.nan, np.nan, np.nan, np.nan, np.nan, np.nan, np.nan,
    np.nan, np.nan, np.nan, np.nan, np.nan, np.nan, np.nan, np.nan, np.nan, np.nan, np.nan,
    np.nan, np.nan, np.nan, np.nan, np.nan, np.nan, np.nan, np.nan, np.nan, np.nan, np.nan,
    np.nan, np.nan,
], dtype=float)
DEFAULTS.flags.writeable = False
# What the entries of each result belong to.
OUTPUTS = {
    "direct_dynamics": {
        "qdd": ("j1", "j2", "j3", "j4"),
    },
    "inverse_dynamics": {
        "tau": ("j1", "j3"),
        "qdd": ("j1", "j2", "j3", "j4"),
    },
}


def parameters(**values):
    """Array of parameter values: the defaults, replaced by those given by name."""
    unknown = sorted(set(values) - set(PARAMETERS))
    if unknown:
        raise TypeError(f"flex4 has no parameter {', '.join(unknown)}")
    p = np.array([values.get(name, default) for name, default in zip(PARAMETERS, DEFAULTS.tolist())], dtype=float)
    missing = [name for name, value in zip(PARAMETERS, p.tolist()) if value != value and name not in values]
    if missing:
        raise ValueError(f"flex4 needs a value for {', '.join(missing)}")
    return p


def trace(model, functions, *arguments, p=tuple(DEFAULTS.tolist())):
    """Entries of each result of a model, row by row, on numbers of another library: tuples of such numbers.

    Arguments and p are sequences of numbers, or of arrays of them; `functions` has their sin, cos, sqrt, sign, atan2.
    """
    if model not in OUTPUTS:
        raise ValueError(f"flex4 has no model {model!r}: choose from {', '.join(OUTPUTS)}")
    return globals()[f"_{model}"].model.trace(functions, *arguments, p=p)


def direct_dynamics(q, qd, tau, p=DEFAULTS):
    """Direct dynamic model [12]-[36].

    119x 97+, 4 sin/cos a call; 9x 4+, 0 sin/cos once for each parameter set.
    q (4): joint variables, rad or m
    qd (4): joint velocities, rad/s or m/s
    tau (2): motor torques or forces, N m or N
    -> qdd (4): joint accelerations, rad/s2 or m/s2
    accelerations are inf or NaN, or large without meaning, where the inertia matrix is singular
    """
    return _direct_dynamics.model(q, qd, tau, p=p)


def inverse_dynamics(q, qd, qdd_motor, p=DEFAULTS):
    """Inverse dynamic model: motor torques and elastic accelerations [37]-[61].

    125x 98+, 4 sin/cos a call; 3x 2+, 0 sin/cos once for each parameter set.
    q (4): joint variables, rad or m
    qd (4): joint velocities, rad/s or m/s
    qdd_motor (2): motor accelerations, rad/s2 or m/s2
    -> tau (2): motor torques or forces, N m or N
    -> qdd (4): joint accelerations, rad/s2 or m/s2
    accelerations are inf or NaN, or large without meaning, where the inertia matrix is singular
    """
    return _inverse_dynamics.model(q, qd, qdd_motor, p=p)
