"""Time steps of planar_2r: coefficients of the methods, and one step of each kind of method.

`rate(q, qd, node)` gives velocities and accelerations at the time of a node. Tables of methods: nodes of the stages,
coefficients by stage, weights b of the result and error of the difference from the embedded method.
"""

import numpy as np

_DIGEST = 786373309  # of the files of this package: those of another run are not imported

# W-method ROS34PW2, order 3; times of the nodes: t, t + 0.871733043016918 h, t + 0.7315799577888524 h, t + h.
W3 = {
    "stages": [0, 1, 2, 3],
    "a": [
        [],
        [0.871733043016918],
        [0.8445706001536942, -0.11299064236484185],
        [0.0, 0.0, 1.0],
    ],
    "gamma": 0.435866521508459,
    "c": [
        [],
        [-2.0],
        [-2.072608299907954, 0.12430565256672008],
        [0.5554998952959375, -2.806479790351998, 1.2509798950560604],
    ],
    "b": [0.24212380706095346, -1.2232505839045147, 1.545260255335102, 0.435866521508459],
    "error": [-0.13598522439724023, -1.1272082916920916, 1.045260255335102, 0.2179332607542295],
}


def combined(coefficients, k):
    """Sum of coefficients times the k of the stages."""
    return sum((c * x for c, x in zip(coefficients, k) if c), np.zeros_like(k[0]) if k else 0.0)


def w(method, rate, factors, solve, h, q, qd):
    """A step of a W-method and its error: (I - g T) z = f(Y) + w, k = z - w."""
    handed = factors(method["gamma"] * h)
    k_q, k_v = [], []
    for node, a, c in zip(method["stages"], method["a"], method["c"]):
        v, qdd = rate(q + h * combined(a, k_q), qd + h * combined(a, k_v), node)
        w_q, w_v = combined(c, k_q), combined(c, k_v)
        z_q, z_v = solve(handed, v + w_q, qdd + w_v)
        k_q.append(z_q - w_q)
        k_v.append(z_v - w_v)
    return finished(method, h, q, qd, k_q, k_v)


def finished(method, h, q, qd, k_q, k_v):
    """Result of a step, and its difference from that of the embedded method."""
    q, qd = q + h * combined(method["b"], k_q), qd + h * combined(method["b"], k_v)
    if not method["error"]:
        return q, qd
    error = h * combined(method["error"], k_q), h * combined(method["error"], k_v)
    return q, qd, np.concatenate(error, axis=-1)


def arrays(h, *others):
    """A step, or one for each state, with an axis for the joints; other arrays as they are."""
    return np.asarray(h, dtype=float)[..., None], *(np.asarray(x, dtype=float) for x in others)


def placed(q, y, motors):
    """q with the entries of motors in their places."""
    q = np.broadcast_to(q, (*np.broadcast_shapes(q.shape[:-1], y.shape[:-1]), q.shape[-1])).copy()
    q[..., motors] = y
    return q


def added(matrix, gains, motors):
    """A matrix with gains of motors added to its diagonal."""
    matrix = np.array(matrix)
    matrix[..., motors, motors] += gains
    return matrix


def on_motors(x, motors, joints):
    """Numbers of motors in an array for all joints."""
    found = np.zeros((*x.shape[:-1], joints))
    found[..., motors] = x
    return found
