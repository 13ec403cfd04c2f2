"""Arguments and results of machines whose joints are coupled: a row each."""

from __future__ import annotations

from symoro_elastic.quantities.quantity import Quantity
from symoro_elastic.quantities.signatures import BOTH, CARRIED, RESULT
from symoro_elastic.quantities.units import ACCELERATION, FORCE, POSITION, VELOCITY

OF_CLOSED_CHAINS = (
    Quantity(
        name="q_dep",
        meaning="variables of the joints that loops make dependent",
        symbol="d",
        unit=POSITION,
        shape="d",
        roles=(*BOTH, *CARRIED),
        plural="dependent variables",
    ),
    Quantity(
        name="x",
        meaning="joint coordinates of all joints, dependent ones too",
        symbol="x",
        unit=POSITION,
        shape="joints",
        roles=RESULT,
    ),
    Quantity(
        name="residual",
        meaning="length of the closing errors of all loops: distances in m and small angles in rad",
        symbol="r",
        unit=None,
        shape="1",
        roles=RESULT,
    ),
    Quantity(
        name="S",
        meaning="derivatives of the positions of all joints by q",
        note="the velocity of a joint is its row of S times qd",
        symbol="S",
        unit=VELOCITY / VELOCITY,
        shape="joints x n",
        roles=RESULT,
        says_unit=False,
    ),
    Quantity(
        name="gam",
        meaning="accelerations of all joints where qdd is zero",
        symbol=r"\gamma",
        unit=ACCELERATION,
        shape="joints",
        roles=RESULT,
    ),
    Quantity(
        name="mu",
        meaning="force, then moment, that the body of the frame met exerts on that of each cut joint",
        frame="at the cut joint, in axes of the frame met",
        note="components that the loop leaves undetermined are zero",
        symbol=r"\mu",
        unit=FORCE,
        shape="loops x 6",
        roles=RESULT,
    ),
    Quantity(
        name="lam",
        meaning="forces that couplings exert on the joints that have no variable of their own",
        symbol=r"\lambda",
        unit=FORCE,
        shape="joints",
        roles=RESULT,
    ),
)
