"""A fast move of axis X of the two-axis machine: motor forces, and how far the tool lags behind.

Motors follow a given acceleration and the elastic joints respond: the paper's inverse model.
Run `symoro-elastic generate examples/two_axis.toml` first, then this file.
"""

import sys
from pathlib import Path

import numpy as np

from symoro_elastic.codegen.integration.tableaus import RK4, step

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "generated"))
import two_axis

X, Y = two_axis.MOTORS
ELASTIC = list(two_axis.ELASTIC)
STROKE, DURATION, STEP = 0.02, 0.06, 2e-5


def acceleration(t: float) -> np.ndarray:
    """Smooth motor accelerations that move axis X by STROKE; axis Y is held."""
    s = t / DURATION
    peak = 60 * STROKE / DURATION**2
    return np.array([peak * s * (1 - s) * (1 - 2 * s) if s < 1 else 0.0, 0.0])


def rate(t: float, y: np.ndarray) -> np.ndarray:
    """qd and qdd, from q and qd."""
    return np.array([y[1], two_axis.inverse_dynamics(*y, acceleration(t))[1]])


def at_rest() -> np.ndarray:
    """Deflections under gravity: Newton on the elastic accelerations, motors held."""
    q, qd = np.zeros(len(two_axis.JOINTS)), np.zeros(len(two_axis.JOINTS))
    for _ in range(3):
        moved = q + 1e-6 * np.eye(len(q))[ELASTIC]
        qdd, qdd_moved = (two_axis.inverse_dynamics(x, qd, acceleration(0.0))[1][..., ELASTIC] for x in (q, moved))
        q[ELASTIC] -= np.linalg.solve((qdd_moved - qdd).T / 1e-6, qdd)
    return q


def main() -> None:
    q = at_rest()
    y = np.array([q, np.zeros_like(q)])
    tau, _ = two_axis.inverse_dynamics(*y, acceleration(0.0))
    names = list(two_axis.JOINTS)
    print(f"holding force of motor Y {tau[1]:.1f} N, sag of the ram {1e6 * q[names.index('ram')]:.2f} um")
    print("  t ms   motor X mm   force X N   bed um   cart um")
    for k in range(int(1.2 * DURATION / STEP) + 1):
        t = k * STEP
        if k % 300 == 0:
            q, (tau, _) = y[0], two_axis.inverse_dynamics(*y, acceleration(t))
            bed, cart = 1e6 * q[names.index("bed_x")], 1e6 * q[names.index("cart_x")]
            print(f"{1e3 * t:6.1f} {1e3 * q[X]:12.4f} {round(tau[0], 1) + 0.0:11.1f} {bed:8.2f} {cart:9.2f}")
        y = step(RK4, rate, t, y, STEP)


if __name__ == "__main__":
    main()
