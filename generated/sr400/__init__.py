"""sr400: generated models (direct_dynamics through the inertia matrix); needs numpy only.

SI units, radians. q, qd, qdd follow JOINTS, the joints whose variables are independent; q_dep follows
DEPENDENT, tau and qdd_motor follow MOTOR_NAMES. States may be stacked along leading axes, which
broadcast. NaN in the inputs a result depends on gives NaN.

Results are new arrays and share no memory with the arguments, which are read only: one array may
serve as several of them. Results are float32 where all states are (more than a few states are
computed in it, too), float64 otherwise. Complex arguments raise TypeError; masks of masked arrays are
not looked at.
"""

import numpy as np

from . import _direct_dynamics, _inverse_dynamics, _runtime

_DIGEST = 354700140  # of the files of this package: those of another run are not imported
for _file in (_direct_dynamics, _inverse_dynamics, _runtime):
    if getattr(_file, "_DIGEST", None) != _DIGEST:
        raise ImportError(f"sr400: {_file.__file__} is of another run of symoro-elastic: generate all files again")

JOINTS = ("waist", "shoulder", "wrist_1", "wrist_2", "wrist_3", "crank")
# Joints whose variables follow from those of JOINTS by loops, and the joints of all motors.
DEPENDENT = ("elbow", "rod")
MOTOR_NAMES = ("waist", "shoulder", "wrist_1", "wrist_2", "wrist_3", "crank")
MOTORS = (0, 1, 2, 3, 4, 5)
ELASTIC = ()
FRAMES = (
    "waist", "shoulder", "elbow", "wrist_1", "wrist_2", "wrist_3", "crank", "rod", "pin",
    "pin_end",
)
PARAMETERS = ("D2", "D3", "D4", "RL4", "D8")
DEFAULTS = np.array([0.25, 0.8, 0.12, 0.9, 0.35], dtype=float)
DEFAULTS.flags.writeable = False
# What the entries of each result belong to.
OUTPUTS = {
    "direct_dynamics": {
        "qdd": ("waist", "shoulder", "wrist_1", "wrist_2", "wrist_3", "crank"),
    },
    "inverse_dynamics": {
        "tau": ("waist", "shoulder", "wrist_1", "wrist_2", "wrist_3", "crank"),
        "qdd": ("waist", "shoulder", "wrist_1", "wrist_2", "wrist_3", "crank"),
    },
}


def parameters(**values):
    """Array of parameter values: the defaults, replaced by those given by name."""
    unknown = sorted(set(values) - set(PARAMETERS))
    if unknown:
        raise TypeError(f"sr400 has no parameter {', '.join(unknown)}")
    p = np.array([values.get(name, default) for name, default in zip(PARAMETERS, DEFAULTS.tolist())], dtype=float)
    missing = [name for name, value in zip(PARAMETERS, p.tolist()) if value != value and name not in values]
    if missing:
        raise ValueError(f"sr400 needs a value for {', '.join(missing)}")
    return p


def trace(model, functions, *arguments, p=tuple(DEFAULTS.tolist())):
    """Entries of each result of a model, row by row, on numbers of another library: tuples of such numbers.

    Arguments and p are sequences of numbers, or of arrays of them; `functions` has their sin, cos, sqrt, sign, atan2.
    """
    if model not in OUTPUTS:
        raise ValueError(f"sr400 has no model {model!r}: choose from {', '.join(OUTPUTS)}")
    return globals()[f"_{model}"].model.trace(functions, *arguments, p=p)


def direct_dynamics(q, qd, tau, p=DEFAULTS):
    """Direct dynamic model through the inertia matrix [8].

    371x 315+, 8 sin/cos a call; 7x 0+, 0 sin/cos once for each parameter set.
    q (6): joint variables, rad or m
    qd (6): joint velocities, rad/s or m/s
    tau (6): motor torques or forces, N m or N
    -> qdd (6): joint accelerations, rad/s2 or m/s2
    accelerations are inf or NaN, or large without meaning, where the inertia matrix is singular
    """
    return _direct_dynamics.model(q, qd, tau, p=p)


def inverse_dynamics(q, qd, qdd_motor, p=DEFAULTS):
    """Inverse dynamic model: motor torques and elastic accelerations [37]-[61].

    235x 200+, 8 sin/cos a call.
    q (6): joint variables, rad or m
    qd (6): joint velocities, rad/s or m/s
    qdd_motor (6): motor accelerations, rad/s2 or m/s2
    -> tau (6): motor torques or forces, N m or N
    -> qdd (6): joint accelerations, rad/s2 or m/s2
    """
    return _inverse_dynamics.model(q, qd, qdd_motor, p=p)
