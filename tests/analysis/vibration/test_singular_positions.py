"""Positions at which links are stretched or folded are told from those at which a loop does not close."""

from __future__ import annotations

import pytest

from symoro_elastic.formats.toml import reading as toml
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.numerics.motion.equations_of_motion import EquationsOfMotion
from symoro_elastic.numerics.motion.equilibrium import given_state

pytestmark = pytest.mark.sampled(4)

FOUR_BAR = """name = "bars"
joints = [
  { name = "crank", antecedent = 0, kind = "motor", sigma = 0, theta = "q1" },
  { name = "rod", antecedent = "crank", kind = "passive", sigma = 0, d = 0.15, theta = "q2" },
  { name = "rocker", antecedent = 0, kind = "passive", sigma = 0, d = 0.5, theta = "q3" },
  { name = "pin", antecedent = "rod", kind = "cut", sigma = 0, d = ROD, theta = "q4" },
  { name = "end", antecedent = "rocker", kind = "fixed", sigma = 2, d = 0.3 },
]
[loops]
bars = { cut = "pin", meets = "end", start = { q1 = 1.0, q2 = -0.6, q3 = 1.6 } }
[bodies]
crank = { mass = 1, inertia = [0.001, 0.003, 0.003] }
rod = { mass = 1, inertia = [0.001, 0.02, 0.02] }
rocker = { mass = 1, inertia = [0.001, 0.01, 0.01] }
"""


@pytest.mark.parametrize(
    ("rod", "said"),
    [
        ("0.65", "loop bars: it is singular at crank=0, where links are stretched or folded: give a position beside"),
        ("0.651", "loop bars: it does not close at crank=0: give another position"),
    ],
)
def test_a_folded_position_is_called_singular_one_beyond_open(rod: str, said: str) -> None:
    """The ends of rod and rocker are 0.65 - 0.3 = 0.5 - 0.15 apart where the crank points at the rocker's pivot."""
    motion = EquationsOfMotion(toml.read(FOUR_BAR.replace("ROD", rod), "bars.toml"))
    with pytest.raises(InputError, match=said):
        given_state(motion, {"crank": 0.0})
    assert given_state(motion, {"crank": 1.0}).q.tolist() == [1.0]
