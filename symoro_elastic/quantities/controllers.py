"""Arguments and results of the sampled controllers of drives."""

from __future__ import annotations

from symoro_elastic.quantities.quantity import Quantity
from symoro_elastic.quantities.signatures import ARGUMENT, BOTH, RESULT
from symoro_elastic.quantities.units import ACCELERATION, FORCE, POSITION, VELOCITY

OF_CONTROLLERS = (
    Quantity(
        name="measured",
        meaning="measured positions that are controlled, over what they change with their motors",
        symbol="q^{c}",
        unit=POSITION,
        shape="m",
        roles=ARGUMENT,
        entries="qc@",
    ),
    Quantity(
        name="speed",
        meaning="measured velocities of the motors",
        symbol="v^{c}",
        unit=VELOCITY,
        shape="m",
        roles=ARGUMENT,
        entries="vc@",
    ),
    Quantity(
        name="r",
        meaning="set points of the motors",
        symbol="r",
        unit=POSITION,
        shape="m",
        roles=ARGUMENT,
        entries="rs@",
    ),
    Quantity(
        name="rd",
        meaning="velocities of the set points",
        symbol=r"\dot{r}",
        unit=VELOCITY,
        shape="m",
        roles=ARGUMENT,
        entries="rsd@",
    ),
    Quantity(
        name="rdd",
        meaning="accelerations of the set points",
        symbol=r"\ddot{r}",
        unit=ACCELERATION,
        shape="m",
        roles=ARGUMENT,
        entries="rsdd@",
    ),
    Quantity(name="zc", meaning="states of the controllers", symbol="z", unit=None, shape="states", roles=BOTH),
    Quantity(
        name="zc_next",
        meaning="states of the controllers a period later",
        symbol="z^{+}",
        unit=None,
        shape="states",
        roles=RESULT,
    ),
    Quantity(
        name="u",
        meaning="set points of the torques, held over a period",
        symbol="u",
        unit=FORCE,
        shape="m",
        roles=RESULT,
    ),
)
