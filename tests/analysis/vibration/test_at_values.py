"""Equations of motion at other values of parameters, whose trace is shared."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np
import pytest

from symoro_elastic.machine.machine import Machine
from symoro_elastic.numerics.motion.equations_of_motion import EquationsOfMotion
from symoro_elastic.numerics.motion.equilibrium import equilibrium
from tests.analysis.ladder.scenes import two_axis
from tests.closed_chains.machines import machine

pytestmark = pytest.mark.sampled(4)


@pytest.mark.thorough
@pytest.mark.parametrize("described", [two_axis, partial(machine, "ring")], ids=["springs", "assembled loops"])
def test_they_are_those_of_a_machine_traced_anew(described: Callable[[], Machine]) -> None:
    """To the last bit, wherever the equations were used before: also joints of loops that are assembled."""
    given = described()
    base = EquationsOfMotion(given)
    start = dict(zip(base.names, base.position_of_loops().tolist(), strict=True))
    moved = base.names[base.motors[0]]
    equilibrium(base, {moved: start[moved] + 0.05})
    values = {x: value * 1.5 for x, value in base.parameters.items() if x.endswith((".mass", ".stiffness"))}
    shared, anew = base.at_values(values), EquationsOfMotion(given, values)
    states = [equilibrium(motion, {moved: start[moved]}) for motion in (shared, anew)]
    assert (states[0].q == states[1].q).all()
    found, expected = (
        np.array(motion.matrices("MDK", s.q, s.qd, s.qdd)) for motion, s in zip((shared, anew), states, strict=True)
    )
    assert (found == expected).all()
    assert (
        shared.jacobians(shared.frame_motions[0], states[0])[0] == anew.jacobians(anew.frame_motions[0], states[1])[0]
    ).all()
    assert base.parameters == EquationsOfMotion(given).parameters
