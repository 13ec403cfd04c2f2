"""ball_screw: generated models; needs numpy only.

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

_DIGEST = 367225390  # of the files of this package: those of another run are not imported
for _file in (_direct_dynamics, _inverse_dynamics, _runtime):
    if getattr(_file, "_DIGEST", None) != _DIGEST:
        raise ImportError(f"ball_screw: {_file.__file__} is of another run of symoro-elastic: generate all files again")

JOINTS = (
    "motor", "motor_pulley", "bearing", "screw_pulley", "screw", "nut", "table", "encoder",
)
# Joints whose variables follow from those of JOINTS by loops, and the joints of all motors.
DEPENDENT = ()
MOTOR_NAMES = ("motor",)
MOTORS = (0,)
ELASTIC = (1, 2, 3, 4, 5, 6, 7)
FRAMES = (
    "motor", "motor_pulley", "bearing", "screw_pulley", "screw", "nut", "table", "encoder",
)
PARAMETERS = ("A", "Rm", "Rv", "pitch", "kp")
DEFAULTS = np.array([0.1, 0.03, 0.045, 0.02, 1600000.0], dtype=float)
DEFAULTS.flags.writeable = False
# What the entries of each result belong to.
OUTPUTS = {
    "direct_dynamics": {
        "qdd": (
    "motor", "motor_pulley", "bearing", "screw_pulley", "screw", "nut", "table", "encoder",
),
    },
    "inverse_dynamics": {
        "tau": ("motor",),
        "qdd": (
    "motor", "motor_pulley", "bearing", "screw_pulley", "screw", "nut", "table", "encoder",
),
    },
}


def parameters(**values):
    """Array of parameter values: the defaults, replaced by those given by name."""
    unknown = sorted(set(values) - set(PARAMETERS))
    if unknown:
        raise TypeError(f"ball_screw has no parameter {', '.join(unknown)}")
    p = np.array([values.get(name, default) for name, default in zip(PARAMETERS, DEFAULTS.tolist())], dtype=float)
    missing = [name for name, value in zip(PARAMETERS, p.tolist()) if value != value and name not in values]
    if missing:
        raise ValueError(f"ball_screw needs a value for {', '.join(missing)}")
    return p


def trace(model, functions, *arguments, p=tuple(DEFAULTS.tolist())):
    """Entries of each result of a model, row by row, on numbers of another library: tuples of such numbers.

    Arguments and p are sequences of numbers, or of arrays of them; `functions` has their sin, cos, sqrt, sign, atan2.
    """
    if model not in OUTPUTS:
        raise ValueError(f"ball_screw has no model {model!r}: choose from {', '.join(OUTPUTS)}")
    return globals()[f"_{model}"].model.trace(functions, *arguments, p=p)


def direct_dynamics(q, qd, tau, p=DEFAULTS):
    """Direct dynamic model [12]-[36].

    22x 21+, 0 sin/cos a call; 6x 0+, 0 sin/cos once for each parameter set.
    q (8): joint variables, rad or m
    qd (8): joint velocities, rad/s or m/s
    tau (1): motor torques or forces, N m or N
    -> qdd (8): joint accelerations, rad/s2 or m/s2
    accelerations are inf or NaN, or large without meaning, where the inertia matrix is singular
    """
    return _direct_dynamics.model(q, qd, tau, p=p)


def inverse_dynamics(q, qd, qdd_motor, p=DEFAULTS):
    """Inverse dynamic model: motor torques and elastic accelerations [37]-[61].

    22x 21+, 0 sin/cos a call; 6x 0+, 0 sin/cos once for each parameter set.
    q (8): joint variables, rad or m
    qd (8): joint velocities, rad/s or m/s
    qdd_motor (1): motor accelerations, rad/s2 or m/s2
    -> tau (1): motor torques or forces, N m or N
    -> qdd (8): joint accelerations, rad/s2 or m/s2
    accelerations are inf or NaN, or large without meaning, where the inertia matrix is singular
    """
    return _inverse_dynamics.model(q, qd, qdd_motor, p=p)
