"""two_axis: generated models; needs numpy only.

SI units, radians. q, qd, qdd follow JOINTS, tau and qdd_motor follow MOTORS. States may be
stacked along leading axes, which broadcast. NaN in the inputs a result depends on gives NaN.

Results are new arrays and share no memory with the arguments, which are read only: one array may
serve as several of them. Results are float32 where all states are (more than a few states are
computed in it, too), float64 otherwise. Complex arguments raise TypeError; masks of masked arrays are
not looked at.
"""

import numpy as np

from . import _direct_dynamics, _inverse_dynamics, _runtime

_DIGEST = 991358372  # of the files of this package: those of another run are not imported
for _file in (_direct_dynamics, _inverse_dynamics, _runtime):
    if getattr(_file, "_DIGEST", None) != _DIGEST:
        raise ImportError(f"two_axis: {_file.__file__} is of another run of symoro-elastic: generate all files again")

JOINTS = (
    "bed_yaw", "bed_y", "bed_x", "motor_secondary", "motor_x", "cart_yaw", "cart_x", "cart_y",
    "motor_y", "y_chain_1", "ram", "sensor_head",
)
MOTORS = (4, 8)
ELASTIC = (0, 1, 2, 3, 5, 6, 7, 9, 10, 11)
FRAMES = (
    "bed_yaw", "bed_y", "bed_x", "motor_secondary", "motor_x", "cart_yaw", "cart_x", "cart_y",
    "motor_y", "y_chain_1", "ram", "tool", "sensor_head",
)
PARAMETERS = ("D4", "D12", "L12", "D13")
DEFAULTS = np.array([0.35, 0.15, 0.25, 0.12], dtype=float)
DEFAULTS.flags.writeable = False
# What the entries of each result belong to.
OUTPUTS = {
    "direct_dynamics": {
        "qdd": (
    "bed_yaw", "bed_y", "bed_x", "motor_secondary", "motor_x", "cart_yaw", "cart_x", "cart_y",
    "motor_y", "y_chain_1", "ram", "sensor_head",
),
    },
    "inverse_dynamics": {
        "tau": ("motor_x", "motor_y"),
        "qdd": (
    "bed_yaw", "bed_y", "bed_x", "motor_secondary", "motor_x", "cart_yaw", "cart_x", "cart_y",
    "motor_y", "y_chain_1", "ram", "sensor_head",
),
    },
}


def parameters(**values):
    """Array of parameter values: the defaults, replaced by those given by name."""
    unknown = sorted(set(values) - set(PARAMETERS))
    if unknown:
        raise TypeError(f"two_axis has no parameter {', '.join(unknown)}")
    p = np.array([values.get(name, default) for name, default in zip(PARAMETERS, DEFAULTS.tolist())], dtype=float)
    missing = [name for name, value in zip(PARAMETERS, p.tolist()) if value != value and name not in values]
    if missing:
        raise ValueError(f"two_axis needs a value for {', '.join(missing)}")
    return p


def trace(model, functions, *arguments, p=tuple(DEFAULTS.tolist())):
    """Entries of each result of a model, row by row, on numbers of another library: tuples of such numbers.

    Arguments and p are sequences of numbers, or of arrays of them; `functions` has their sin, cos, sqrt, sign, atan2.
    """
    if model not in OUTPUTS:
        raise ValueError(f"two_axis has no model {model!r}: choose from {', '.join(OUTPUTS)}")
    return globals()[f"_{model}"].model.trace(functions, *arguments, p=p)


def direct_dynamics(q, qd, tau, p=DEFAULTS):
    """Direct dynamic model [12]-[36].

    124x 116+, 4 sin/cos a call.
    q (12): joint variables, rad or m
    qd (12): joint velocities, rad/s or m/s
    tau (2): motor torques or forces, N m or N
    -> qdd (12): joint accelerations, rad/s2 or m/s2
    accelerations are inf or NaN, or large without meaning, where the inertia matrix is singular
    """
    return _direct_dynamics.model(q, qd, tau, p=p)


def inverse_dynamics(q, qd, qdd_motor, p=DEFAULTS):
    """Inverse dynamic model: motor torques and elastic accelerations [37]-[61].

    125x 118+, 4 sin/cos a call.
    q (12): joint variables, rad or m
    qd (12): joint velocities, rad/s or m/s
    qdd_motor (2): motor accelerations, rad/s2 or m/s2
    -> tau (2): motor torques or forces, N m or N
    -> qdd (12): joint accelerations, rad/s2 or m/s2
    accelerations are inf or NaN, or large without meaning, where the inertia matrix is singular
    """
    return _inverse_dynamics.model(q, qd, qdd_motor, p=p)
