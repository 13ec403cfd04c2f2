"""Arguments and results of machines whose joints are coupled: a row each."""

from __future__ import annotations

from symoro_elastic.quantities.quantity import Quantity
from symoro_elastic.quantities.signatures import BOTH, CARRIED, RESULT
from symoro_elastic.quantities.units import ACCELERATION, FORCE, POSITION, VELOCITY

# fmt: off
OF_CLOSED_CHAINS = (
    Quantity("q_dep", "variables of the joints that loops make dependent", "d", POSITION, "d", (*BOTH, *CARRIED),
             plural="dependent variables"),
    Quantity("x", "joint coordinates of all joints, dependent ones too", "x", POSITION, "joints", RESULT),
    Quantity("residual", "length of the closing errors of all loops: distances in m and small angles in rad", "r", None,
             "1", RESULT),
    Quantity("S", "derivatives of the positions of all joints by q", "S", VELOCITY / VELOCITY, "joints x n", RESULT,
             note="the velocity of a joint is its row of S times qd", says_unit=False),
    Quantity("gam", "accelerations of all joints where qdd is zero", r"\gamma", ACCELERATION, "joints", RESULT),
    Quantity("mu", "force, then moment, that the body of the frame met exerts on that of each cut joint", r"\mu", FORCE,
             "loops x 6", RESULT, frame="at the cut joint, in axes of the frame met",
             note="components that the loop leaves undetermined are zero"),
    Quantity("lam", "forces that couplings exert on the joints that have no variable of their own", r"\lambda", FORCE,
             "joints", RESULT),
)
# fmt: on
