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


OF_TIME_STEPS = (
    Quantity(
        name="g",
        meaning="gamma h: the step times the coefficient gamma of the method",
        symbol="g",
        unit=same("s"),
        shape="1",
        roles=ARGUMENT,
        entries=("gh0",),
    ),
    Quantity(
        name="kp",
        meaning="position gains of servos",
        symbol="k_p",
        unit=Unit("N m/rad", "N/m"),
        shape="m",
        roles=ARGUMENT,
        entries="kpm@",
    ),
    Quantity(
        name="kd",
        meaning="velocity gains of servos",
        symbol="k_d",
        unit=Unit("N m s/rad", "N s/m"),
        shape="m",
        roles=ARGUMENT,
        entries="kdm@",
    ),
    Quantity(
        name="tau_m", meaning="torques or forces of motors", symbol=r"\Gamma_m", unit=FORCE, shape="m", roles=RESULT
    ),
    Quantity(
        name="factors",
        meaning="factors of A + g D + g^2 K, and what else the right side does not change",
        symbol="F",
        unit=None,
        shape="factors",
        roles=BOTH,
    ),
    Quantity(
        name="r_q",
        meaning="right side, of positions",
        symbol="r_q",
        unit=VELOCITY,
        shape="n",
        roles=ARGUMENT,
        entries="rhq@",
    ),
    Quantity(
        name="r_v",
        meaning="right side, of velocities",
        symbol="r_v",
        unit=ACCELERATION,
        shape="n",
        roles=ARGUMENT,
        entries="rhv@",
    ),
    Quantity(
        name="r_z",
        meaning="right side, of states of friction and drives",
        symbol="r_z",
        unit=None,
        shape="b",
        roles=ARGUMENT,
        entries="rhz@",
    ),
    Quantity(name="z_q", meaning="solution, of positions", symbol="z_q", unit=VELOCITY, shape="n", roles=RESULT),
    Quantity(name="z_v", meaning="solution, of velocities", symbol="z_v", unit=ACCELERATION, shape="n", roles=RESULT),
    Quantity(
        name="z_z",
        meaning="solution, of states of friction and drives",
        symbol="z_z",
        unit=None,
        shape="b",
        roles=RESULT,
    ),
    Quantity(
        name="x0",
        meaning="displacement of the base in a step, then 2 tan(angle/2) times the axis of its turn",
        frame="in its axes at the start",
        symbol="x",
        index="0",
        unit=POSITION,
        shape="6",
        roles=ARGUMENT,
        entries=tuple(f"xb0_{k}" for k in range(1, 7)),
    ),
    Quantity(name="x0d", meaning="rates of x0", symbol=r"\dot{x}", index="0", unit=VELOCITY, shape="6", roles=RESULT),
    Quantity(
        name="V0_rate",
        meaning="derivatives by time of the components of V0",
        symbol=r"\dot{V}",
        index="0",
        unit=ACCELERATION,
        shape="6",
        roles=RESULT,
    ),
    Quantity(
        name="P0_change", meaning="change of P0", symbol=r"\Delta P", index="0", unit=same("m"), shape="3", roles=RESULT
    ),
    Quantity(
        name="Q0_change",
        meaning="change of Q0, with what gives it the length 1",
        symbol=r"\Delta Q",
        index="0",
        unit=NUMBER,
        shape="4",
        roles=RESULT,
    ),
    Quantity(
        name="R0_change",
        meaning="change of R0, with what keeps it orthogonal",
        symbol=r"\Delta A",
        index="0",
        unit=NUMBER,
        shape="9",
        roles=RESULT,
    ),
    Quantity(name="q_motor", meaning="motor positions", symbol="x_m", unit=POSITION, shape="m", roles=RESULT),
    Quantity(name="qd_motor", meaning="motor velocities", symbol=r"\dot{x}_m", unit=VELOCITY, shape="m", roles=RESULT),
)
