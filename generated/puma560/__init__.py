"""puma560: generated models; needs numpy only.

SI units, radians. q, qd, qdd follow JOINTS, tau and qdd_motor follow MOTORS. States may be
stacked along leading axes, which broadcast. NaN in the inputs a result depends on gives NaN.

Results are new arrays and share no memory with the arguments, which are read only: one array may
serve as several of them. Results are float32 where all states are (more than a few states are
computed in it, too), float64 otherwise. Complex arguments raise TypeError; masks of masked arrays are
not looked at.
"""

import numpy as np

from . import _direct_dynamics, _inverse_dynamics, _runtime

_DIGEST = 476191822  # of the files of this package: those of another run are not imported
for _file in (_direct_dynamics, _inverse_dynamics, _runtime):
    if getattr(_file, "_DIGEST", None) != _DIGEST:
        raise ImportError(f"puma560: {_file.__file__} is of another run of symoro-elastic: generate all files again")

JOINTS = ("j1", "j2", "j3", "j4", "j5", "j6")
MOTORS = (0, 1, 2, 3, 4, 5)
ELASTIC = ()
FRAMES = ("j1", "j2", "j3", "j4", "j5", "j6")
PARAMETERS = (
    "XX1", "XY1", "XZ1", "YY1", "YZ1", "ZZ1", "MX1", "MY1", "MZ1", "M1", "IA1", "R2", "XX2",
    "XY2", "XZ2", "YY2", "YZ2", "ZZ2", "MX2", "MY2", "MZ2", "M2", "IA2", "D3", "R3", "XX3",
    "XY3", "XZ3", "YY3", "YZ3", "ZZ3", "MX3", "MY3", "MZ3", "M3", "IA3", "D4", "RL4", "XX4",
    "XY4", "XZ4", "YY4", "YZ4", "ZZ4", "MX4", "MY4", "MZ4", "M4", "IA4", "XX5", "XY5", "XZ5",
    "YY5", "YZ5", "ZZ5", "MX5", "MY5", "MZ5", "M5", "IA5", "XX6", "XY6", "XZ6", "YY6", "YZ6",
    "ZZ6", "MX6", "MY6", "MZ6", "M6", "IA6", "G3",
)
DEFAULTS = np.array([
    np.nan, np.nan, np.nan, np.nan, np.nan, np.nan, np.nan, np.nan, np.nan, np.nan, np.nan,
    np.nan, np.nan, np.nan, np.nan, np.nan, np.nan, np.nan, np.nan, np.nan, np.nan, np.nan,
    np.nan, np.nan, np.nan, np.nan, np.nan, np.nan, np.nan, np.nan, np.nan, np.nan, np.nan,
    np.nan, np.nan, np.nan, np.nan, np.nan, np.nan, np.nan, np.nan, np.nan, np.nan, np.nan,
    np.nan, np.nan, np.nan, np.nan, np.nan, np.nan, np.nan, np.nan, np.nan, np.nan, np.nan,
    np.nan, np.nan, np.nan, np.nan, np.nan, np.nan, np.nan, np.nan, np.nan, np.nan, np.nan,
    np.nan, np.nan, np.nan, np.nan, np.nan, np.nan,
], dtype=float)
DEFAULTS.flags.writeable = False
# What the entries of each result belong to.
OUTPUTS = {
    "direct_dynamics": {
        "qdd": ("j1", "j2", "j3", "j4", "j5", "j6"),
    },
    "inverse_dynamics": {
        "tau": ("j1", "j2", "j3", "j4", "j5", "j6"),
        "qdd": ("j1", "j2", "j3", "j4", "j5", "j6"),
    },
}


def parameters(**values):
    """Array of parameter values: the defaults, replaced by those given by name."""
    unknown = sorted(set(values) - set(PARAMETERS))
    if unknown:
        raise TypeError(f"puma560 has no parameter {', '.join(unknown)}")
    p = np.array([values.get(name, default) for name, default in zip(PARAMETERS, DEFAULTS.tolist())], dtype=float)
    missing = [name for name, value in zip(PARAMETERS, p.tolist()) if value != value and name not in values]
    if missing:
        raise ValueError(f"puma560 needs a value for {', '.join(missing)}")
    return p


def trace(model, functions, *arguments, p=tuple(DEFAULTS.tolist())):
    """Entries of each result of a model, row by row, on numbers of another library: tuples of such numbers.

    Arguments and p are sequences of numbers, or of arrays of them; `functions` has their sin, cos, sqrt, sign, atan2.
    """
    if model not in OUTPUTS:
        raise ValueError(f"puma560 has no model {model!r}: choose from {', '.join(OUTPUTS)}")
    return globals()[f"_{model}"].model.trace(functions, *arguments, p=p)


def direct_dynamics(q, qd, tau, p=DEFAULTS):
    """Direct dynamic model [12]-[36].

    680x 596+, 10 sin/cos a call; 5x 4+, 0 sin/cos once for each parameter set.
    q (6): joint variables, rad or m
    qd (6): joint velocities, rad/s or m/s
    tau (6): motor torques or forces, N m or N
    -> qdd (6): joint accelerations, rad/s2 or m/s2
    accelerations are inf or NaN, or large without meaning, where the inertia matrix is singular
    """
    return _direct_dynamics.model(q, qd, tau, p=p)


def inverse_dynamics(q, qd, qdd_motor, p=DEFAULTS):
    """Inverse dynamic model: motor torques and elastic accelerations [37]-[61].

    307x 290+, 10 sin/cos a call; 0x 15+, 0 sin/cos once for each parameter set.
    q (6): joint variables, rad or m
    qd (6): joint velocities, rad/s or m/s
    qdd_motor (6): motor accelerations, rad/s2 or m/s2
    -> tau (6): motor torques or forces, N m or N
    -> qdd (6): joint accelerations, rad/s2 or m/s2
    """
    return _inverse_dynamics.model(q, qd, qdd_motor, p=p)
