"""planar_2r: generated models; needs numpy only.

SI units, radians. q, qd, qdd follow JOINTS, tau and qdd_motor follow MOTORS. States may be
stacked along leading axes, which broadcast. NaN in the inputs a result depends on gives NaN.

Results are new arrays and share no memory with the arguments, which are read only: one array may
serve as several of them. Results are float32 where all states are (more than a few states are
computed in it, too), float64 otherwise. Complex arguments raise TypeError; masks of masked arrays are
not looked at.
"""

import numpy as np

from . import _direct_dynamics, _inverse_dynamics, _implicit_factors, _implicit_solve, _implicit_factors_servo, _implicit_solve_servo, _runtime, _steps

_DIGEST = 786373309  # of the files of this package: those of another run are not imported
for _file in (_direct_dynamics, _inverse_dynamics, _implicit_factors, _implicit_solve, _implicit_factors_servo, _implicit_solve_servo, _runtime, _steps):
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
    "implicit_factors": {
        "factors": (),
    },
    "implicit_solve": {
        "z_q": ("shoulder", "elbow"),
        "z_v": ("shoulder", "elbow"),
    },
    "implicit_factors_servo": {
        "factors": (),
    },
    "implicit_solve_servo": {
        "z_q": ("shoulder", "elbow"),
        "z_v": ("shoulder", "elbow"),
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


def implicit_factors(q, qd, g, p=DEFAULTS):
    """Factors of the linear system of an implicit step [28]-[32].

    0x 0+, 0 sin/cos a call.
    q (2): joint variables, rad or m
    qd (2): joint velocities, rad/s or m/s
    g (1): gamma h: the step times the coefficient gamma of the method, s
    -> factors (1): factors of A + g D + g^2 K, and what else the right side does not change
    """
    return _implicit_factors.model(q, qd, g, p=p)


def implicit_solve(factors, r_q, r_v, p=DEFAULTS):
    """Solution z of (I - g T) z = r, by the factors [28]-[36].

    2x 2+, 0 sin/cos a call.
    factors (1): factors of A + g D + g^2 K, and what else the right side does not change
    r_q (2): right side, of positions, rad/s or m/s
    r_v (2): right side, of velocities, rad/s2 or m/s2
    -> z_q (2): solution, of positions, rad/s or m/s
    -> z_v (2): solution, of velocities, rad/s2 or m/s2
    """
    return _implicit_solve.model(factors, r_q, r_v, p=p)


def implicit_factors_servo(q, qd, g, kp, kd, p=DEFAULTS):
    """Factors of the linear system of an implicit step [28]-[32].

    16x 11+, 2 sin/cos a call; 4x 2+, 0 sin/cos once for each parameter set.
    q (2): joint variables, rad or m
    qd (2): joint velocities, rad/s or m/s
    g (1): gamma h: the step times the coefficient gamma of the method, s
    kp (2): position gains of servos, N m/rad or N/m
    kd (2): velocity gains of servos, N m s/rad or N s/m
    -> factors (11): factors of A + g D + g^2 K, and what else the right side does not change
    """
    return _implicit_factors_servo.model(q, qd, g, kp, kd, p=p)


def implicit_solve_servo(factors, r_q, r_v, p=DEFAULTS):
    """Solution z of (I - g T) z = r, by the factors [28]-[36].

    15x 10+, 0 sin/cos a call.
    factors (11): factors of A + g D + g^2 K, and what else the right side does not change
    r_q (2): right side, of positions, rad/s or m/s
    r_v (2): right side, of velocities, rad/s2 or m/s2
    -> z_q (2): solution, of positions, rad/s or m/s
    -> z_v (2): solution, of velocities, rad/s2 or m/s2
    """
    return _implicit_solve_servo.model(factors, r_q, r_v, p=p)


def step_w3(tau, h, q, qd, p=DEFAULTS):
    """One step h [s] of the W-method ROS34PW2, order 3.

    tau (..., 4, 2): a row for each of the times t, t + 0.871733043016918 h, t + 0.7315799577888524 h, t + h.
    -> q, qd at t + h
    """
    h, q, qd, tau = _steps.arrays(h, q, qd, tau)

    def rate(q, qd, node):
        qdd = direct_dynamics(q, qd, tau[..., node, :], p)
        return qd, qdd

    def factors(g):
        return implicit_factors(q, qd, g, p)

    def solve(factors, r_q, r_v):
        return implicit_solve(factors, r_q, r_v, p)

    q, qd, error = _steps.w(_steps.W3, rate, factors, solve, h, q, qd)
    return q, qd


def step_w3_error(tau, h, q, qd, p=DEFAULTS):
    """One step h [s] of the W-method ROS34PW2, order 3.

    tau (..., 4, 2): a row for each of the times t, t + 0.871733043016918 h, t + 0.7315799577888524 h, t + h.
    -> q, qd at t + h; difference of q, then of qd, from the embedded method
    """
    h, q, qd, tau = _steps.arrays(h, q, qd, tau)

    def rate(q, qd, node):
        qdd = direct_dynamics(q, qd, tau[..., node, :], p)
        return qd, qdd

    def factors(g):
        return implicit_factors(q, qd, g, p)

    def solve(factors, r_q, r_v):
        return implicit_solve(factors, r_q, r_v, p)

    q, qd, error = _steps.w(_steps.W3, rate, factors, solve, h, q, qd)
    return q, qd, error


def step_w3_servo(tau, r, rd, kp, kd, h, q, qd, p=DEFAULTS):
    """One step h [s] of the W-method ROS34PW2, order 3, motors under tau + kp (r - q) + kd (rd - qd).

    tau, r, rd (..., 4, 2): a row for each of the times t, t + 0.871733043016918 h, t + 0.7315799577888524 h, t + h.
    kp, kd (2): gains of the servos.
    -> q, qd at t + h
    """
    h, q, qd, tau, r, rd, kp, kd = _steps.arrays(h, q, qd, tau, r, rd, kp, kd)

    def rate(q, qd, node):
        torque = tau[..., node, :] + kp * (r[..., node, :] - q[..., MOTORS]) + kd * (rd[..., node, :] - qd[..., MOTORS])
        qdd = direct_dynamics(q, qd, torque, p)
        return qd, qdd

    def factors(g):
        return implicit_factors_servo(q, qd, g, kp, kd, p)

    def solve(factors, r_q, r_v):
        return implicit_solve_servo(factors, r_q, r_v, p)

    q, qd, error = _steps.w(_steps.W3, rate, factors, solve, h, q, qd)
    return q, qd


def step_w3_servo_error(tau, r, rd, kp, kd, h, q, qd, p=DEFAULTS):
    """One step h [s] of the W-method ROS34PW2, order 3, motors under tau + kp (r - q) + kd (rd - qd).

    tau, r, rd (..., 4, 2): a row for each of the times t, t + 0.871733043016918 h, t + 0.7315799577888524 h, t + h.
    kp, kd (2): gains of the servos.
    -> q, qd at t + h; difference of q, then of qd, from the embedded method
    """
    h, q, qd, tau, r, rd, kp, kd = _steps.arrays(h, q, qd, tau, r, rd, kp, kd)

    def rate(q, qd, node):
        torque = tau[..., node, :] + kp * (r[..., node, :] - q[..., MOTORS]) + kd * (rd[..., node, :] - qd[..., MOTORS])
        qdd = direct_dynamics(q, qd, torque, p)
        return qd, qdd

    def factors(g):
        return implicit_factors_servo(q, qd, g, kp, kd, p)

    def solve(factors, r_q, r_v):
        return implicit_solve_servo(factors, r_q, r_v, p)

    q, qd, error = _steps.w(_steps.W3, rate, factors, solve, h, q, qd)
    return q, qd, error
