"""Arguments and results of the sampled controllers of drives."""

from __future__ import annotations

from symoro_elastic.quantities.quantity import Quantity
from symoro_elastic.quantities.signatures import ARGUMENT, BOTH, RESULT
from symoro_elastic.quantities.units import ACCELERATION, FORCE, POSITION, VELOCITY

# fmt: off
OF_CONTROLLERS = (
    Quantity("measured", "measured positions that are controlled, over what they change with their motors", "q^{c}",
             POSITION, "m", ARGUMENT, entries="qc@"),
    Quantity("speed", "measured velocities of the motors", "v^{c}", VELOCITY, "m", ARGUMENT, entries="vc@"),
    Quantity("r", "set points of the motors", "r", POSITION, "m", ARGUMENT, entries="rs@"),
    Quantity("rd", "velocities of the set points", r"\dot{r}", VELOCITY, "m", ARGUMENT, entries="rsd@"),
    Quantity("rdd", "accelerations of the set points", r"\ddot{r}", ACCELERATION, "m", ARGUMENT, entries="rsdd@"),
    Quantity("zc", "states of the controllers", "z", None, "states", BOTH),
    Quantity("zc_next", "states of the controllers a period later", "z^{+}", None, "states", RESULT),
    Quantity("u", "set points of the torques, held over a period", "u", FORCE, "m", RESULT),
)
# fmt: on
