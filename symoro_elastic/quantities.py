"""The quantities of generated code: what its arguments and results are."""

from __future__ import annotations

from symoro_elastic.models.feed_forward import MEANINGS as MOTION_WANTED

ARGUMENTS = {
    "q": "joint variables, rad or m",
    "qd": "joint velocities, rad/s or m/s",
    "qdd": "joint accelerations, rad/s2 or m/s2",
    "tau": "motor torques or forces, N m or N",
    "qdd_motor": "motor accelerations, rad/s2 or m/s2",
    "T": "placement of the frame, 4 x 4, row by row, lengths in m",
    "P": "place of the origin of the frame, m",
    "R0": "rotation from the axes of the base to those of the world, 3 x 3, row by row",
    "Q0": "turn of the base in the world, a quaternion w x y z of length 1, which is taken as it is",
    "P0": "place of the origin of the base in the world, m",
    "V0": "velocity of the origin of the base (m/s), its angular velocity (rad/s), in its axes",
    "V0d": "acceleration of the origin of the base (m/s2; dv/dt + w x v of V0), angular one (rad/s2), in its axes",
    "f0": "force on the base (N), moment about its origin (N m), in its axes; its weight is no part of it",
} | MOTION_WANTED
RESULTS = {
    "qdd": "joint accelerations, rad/s2 or m/s2",
    "tau": "motor torques or forces, N m or N",
    "A": "inertia matrix, kg m2, kg m or kg",
    "H": "Coriolis, centrifugal, gravity and friction forces, N m or N",
    "T": "placement of each frame, row by row, lengths in m",
    "V": "velocity of the origin (m/s), angular velocity (rad/s) of each frame, in its axes unless seen from another",
    "Vd": "acceleration of the origin (m/s2), angular one (rad/s2) of each frame, in its axes unless seen from another",
    "J": "Jacobian of each frame, in the axes of the base unless seen from another: V = J qd on a base at rest",
    "f": "force (N), then moment (N m) about its origin, that the antecedent exerts on each body, in its frame",
    "q": "joint variables of each solution, rad or m; NaN where there is none",
    "singularity": "zero where a solution is singular: product of the square roots and distances that vanish there",
    "E": "kinetic energy, gravity energy (zero at the origin of frame 0) and elastic energy, J",
    "Y": "regressor: torques are Y times the parameters that its columns name",
    "V0d": "acceleration of the origin of the base (m/s2; dv/dt + w x v of V0), angular one (rad/s2), in its axes",
    "f0": "force (N) and moment about its origin (N m) that move the base so, in its axes",
    "M": "inertia matrix, kg m2, kg m or kg",
    "D": "damping: derivatives of motor torques by qd, friction included, N m s/rad, N s or N s/m",
    "K": "stiffness: derivatives of motor torques by q, those of springs, gravity and inertia, N m/rad, N or N/m",
    "h": "energy regressor: energy is h times the parameters that its entries name, up to a constant",
    "X": "base inertial parameters",
    "dtau_dq": "derivatives of motor torques by q, springs and friction included",
    "dtau_dqdd_motor": "derivatives of motor torques by qdd_motor: the inertia matrix where every joint has a motor",
    "dqdd_dtau": "derivatives of joint accelerations by tau: columns of the inverse of the inertia matrix",
}
ROWS = {
    "tau": "motor torques",
    "qdd": "joint accelerations",
    "V0d": "the acceleration of the base",
    "f0": "the wrench on the base",
}
COLUMNS = {
    "q": "q",
    "qd": "qd",
    "qdd_motor": "qdd_motor",
    "tau": "tau",
    "p": "the parameters that its columns name",
    "pose": "pose: displacement, rotation (m, rad) in axes of the base, as are V0, V0d, f0",
    "V0": "V0",
    "V0d": "V0d",
    "f0": "f0",
}
RESULTS = {
    f"d{of}_d{by}": f"derivatives of {rows} by {columns}"
    for of, rows in ROWS.items()
    for by, columns in COLUMNS.items()
} | RESULTS
PARTICULAR = {
    ("jacobian_dot_qd", "Vd"): "(dJ/dt) qd of each frame (m/s2, rad/s2), in axes of the base unless seen from another",
    ("coriolis_forces", "H"): "Coriolis and centrifugal forces, and those of a moving base, N m or N",
    ("gravity_forces", "H"): "gravity forces, N m or N",
    ("friction_forces", "H"): "friction forces, N m or N",
    ("feed_forward", "q"): "joint variables: motor positions and deflections of springs, rad or m",
    ("feed_forward", "qd"): "joint velocities, rad/s or m/s",
    ("inverse_dynamics_derivatives", "dqdd_dq"): "derivatives of accelerations of elastic and passive joints by q",
    ("inverse_dynamics_derivatives", "dqdd_dqd"): "derivatives of accelerations of elastic and passive joints by qd",
    ("inverse_dynamics_derivatives", "dqdd_dqdd_motor"): (
        "derivatives of accelerations of elastic and passive joints by qdd_motor"
    ),
    ("inverse_dynamics_parameter_derivatives", "dqdd_dp"): (
        "derivatives of accelerations of elastic and passive joints by the parameters that its columns name"
    ),
    ("external_forces", "H"): "forces that balance the external wrenches, N m or N",
}
"""What results are in the models where `RESULTS` does not say it."""
