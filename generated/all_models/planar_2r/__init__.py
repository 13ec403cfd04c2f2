"""planar_2r: generated models; needs numpy only.

SI units, radians. q, qd, qdd follow JOINTS, tau and qdd_motor follow MOTORS. States may be
stacked along leading axes, which broadcast. NaN in the inputs a result depends on gives NaN.

Results are new arrays and share no memory with the arguments, which are read only: one array may
serve as several of them. Results are float32 where all states are (more than a few states are
computed in it, too), float64 otherwise. Complex arguments raise TypeError; masks of masked arrays are
not looked at.
"""

import numpy as np

from . import _direct_dynamics, _inverse_dynamics, _inertia_matrix, _bias_forces, _geometric_model, _runtime

_DIGEST = 568275864  # of the files of this package: those of another run are not imported
for _file in (_direct_dynamics, _inverse_dynamics, _inertia_matrix, _bias_forces, _geometric_model, _runtime):
    if getattr(_file, "_DIGEST", None) != _DIGEST:
        raise ImportError(f"planar_2r: {_file.__file__} is of another run of symoro-elastic: generate all files again")

JOINTS = ("shoulder", "elbow")
MOTORS = (0, 1)
ELASTIC = ()
FRAMES = ("shoulder", "elbow", "tip")
PARAMETERS = ("g0", "m1", "m2", "l1", "l2", "lc1", "lc2", "I1", "I2")
DEFAULTS = np.array([9.81, 2.5, 1.5, 0.4, 0.3, 0.2, 0.15, 0.035, 0.012], dtype=float)
DEFAULTS.flags.writeable = False
# What the entries of each result belong to.
OUTPUTS = {
    "direct_dynamics": {
        "qdd": ("shoulder", "elbow"),
    },
    "inverse_dynamics": {
        "tau": ("shoulder", "elbow"),
        "qdd": ("shoulder", "elbow"),
    },
    "inertia_matrix": {
        "A": ("shoulder", "elbow"),
    },
    "bias_forces": {
        "H": ("shoulder", "elbow"),
    },
    "geometric_model": {
        "T": ("shoulder", "elbow", "tip"),
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


def trace(model, functions, *arguments, p=tuple(DEFAULTS.tolist())):
    """Entries of each result of a model, row by row, on numbers of another library: tuples of such numbers.

    Arguments and p are sequences of numbers, or of arrays of them; `functions` has their sin, cos, sqrt, sign, atan2.
    """
    if model not in OUTPUTS:
        raise ValueError(f"planar_2r has no model {model!r}: choose from {', '.join(OUTPUTS)}")
    return globals()[f"_{model}"].model.trace(functions, *arguments, p=p)


def direct_dynamics(q, qd, tau, p=DEFAULTS):
    """Direct dynamic model [12]-[36].

    26x 15+, 4 sin/cos a call; 8x 4+, 0 sin/cos once for each parameter set.
    q (2): joint variables, rad or m
    qd (2): joint velocities, rad/s or m/s
    tau (2): motor torques or forces, N m or N
    -> qdd (2): joint accelerations, rad/s2 or m/s2
    accelerations are inf or NaN, or large without meaning, where the inertia matrix is singular
    """
    return _direct_dynamics.model(q, qd, tau, p=p)


def inverse_dynamics(q, qd, qdd_motor, p=DEFAULTS):
    """Inverse dynamic model: motor torques and elastic accelerations [37]-[61].

    21x 13+, 4 sin/cos a call; 4x 2+, 0 sin/cos once for each parameter set.
    q (2): joint variables, rad or m
    qd (2): joint velocities, rad/s or m/s
    qdd_motor (2): motor accelerations, rad/s2 or m/s2
    -> tau (2): motor torques or forces, N m or N
    -> qdd (2): joint accelerations, rad/s2 or m/s2
    """
    return _inverse_dynamics.model(q, qd, qdd_motor, p=p)


def inertia_matrix(q, p=DEFAULTS):
    """Inertia matrix [8].

    3x 5+, 1 sin/cos a call; 5x 2+, 0 sin/cos once for each parameter set.
    q (2): joint variables, rad or m
    -> A (2 x 2): inertia matrix, kg m2, kg m or kg
    """
    return _inertia_matrix.model(q, p=p)


def bias_forces(q, qd, p=DEFAULTS):
    """Forces at zero joint acceleration [8].

    17x 8+, 4 sin/cos a call; 2x 0+, 0 sin/cos once for each parameter set.
    q (2): joint variables, rad or m
    qd (2): joint velocities, rad/s or m/s
    -> H (2): Coriolis, centrifugal, gravity and friction forces, N m or N
    """
    return _bias_forces.model(q, qd, p=p)


def geometric_model(q, p=DEFAULTS):
    """Placement of frames [1], [2].

    8x 4+, 4 sin/cos a call.
    q (2): joint variables, rad or m
    -> T (3 x 4 x 4): placement of each frame, row by row, lengths in m
    """
    return _geometric_model.model(q, p=p)
