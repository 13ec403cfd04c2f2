"""Time steps that can be generated; arguments and results of the linear systems that implicit ones solve."""

from __future__ import annotations

from enum import StrEnum

from symoro_elastic.quantities.quantity import Quantity
from symoro_elastic.quantities.signatures import ARGUMENT, BOTH, RESULT
from symoro_elastic.quantities.units import ACCELERATION, FORCE, NUMBER, POSITION, VELOCITY, Unit, same


class TimeStep(StrEnum):
    """The time steps that can be generated, by the name of their method."""

    W2 = "w2"
    W3 = "w3"
    RK4 = "rk4"
    RODAS4 = "rodas4"
    MIDPOINT = "midpoint"


# fmt: off
OF_TIME_STEPS = (
    Quantity("g", "gamma h: the step times the coefficient gamma of the method", "g", same("s"), "1", ARGUMENT,
             entries=("gh0",)),
    Quantity("kp", "position gains of servos", "k_p", Unit("N m/rad", "N/m"), "m", ARGUMENT, entries="kpm@"),
    Quantity("kd", "velocity gains of servos", "k_d", Unit("N m s/rad", "N s/m"), "m", ARGUMENT, entries="kdm@"),
    Quantity("tau_m", "torques or forces of motors", r"\Gamma_m", FORCE, "m", RESULT),
    Quantity("factors", "factors of A + g D + g^2 K, and what else the right side does not change", "F", None,
             "factors", BOTH),
    Quantity("r_q", "right side, of positions", "r_q", VELOCITY, "n", ARGUMENT, entries="rhq@"),
    Quantity("r_v", "right side, of velocities", "r_v", ACCELERATION, "n", ARGUMENT, entries="rhv@"),
    Quantity("r_z", "right side, of states of friction and drives", "r_z", None, "b", ARGUMENT, entries="rhz@"),
    Quantity("z_q", "solution, of positions", "z_q", VELOCITY, "n", RESULT),
    Quantity("z_v", "solution, of velocities", "z_v", ACCELERATION, "n", RESULT),
    Quantity("z_z", "solution, of states of friction and drives", "z_z", None, "b", RESULT),
    Quantity("x0", "displacement of the base in a step, then 2 tan(angle/2) times the axis of its turn", "x", POSITION,
             "6", ARGUMENT, frame="in its axes at the start", index="0",
             entries=tuple(f"xb0_{k}" for k in range(1, 7))),
    Quantity("x0d", "rates of x0", r"\dot{x}", VELOCITY, "6", RESULT, index="0"),
    Quantity("V0_rate", "derivatives by time of the components of V0", r"\dot{V}", ACCELERATION, "6", RESULT,
             index="0"),
    Quantity("P0_change", "change of P0", r"\Delta P", same("m"), "3", RESULT, index="0"),
    Quantity("Q0_change", "change of Q0, with what gives it the length 1", r"\Delta Q", NUMBER, "4", RESULT, index="0"),
    Quantity("R0_change", "change of R0, with what keeps it orthogonal", r"\Delta A", NUMBER, "9", RESULT, index="0"),
    Quantity("q_motor", "motor positions", "x_m", POSITION, "m", RESULT),
    Quantity("qd_motor", "motor velocities", r"\dot{x}_m", VELOCITY, "m", RESULT),
)
# fmt: on
