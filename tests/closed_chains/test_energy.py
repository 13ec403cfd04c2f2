"""Free motion of a four-bar without losses, by the compiled direct model: its energy stays, its loop stays closed."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from symoro_elastic.codegen.compile import CompiledPackage, compile_package
from symoro_elastic.codegen.integration.tableaus import RK4, step
from symoro_elastic.machine.formula import ZERO
from symoro_elastic.machine.machine import Joint, Machine, Wrench
from symoro_elastic.machine.scene import Scene
from symoro_elastic.models.packaging import trace_models
from tests.closed_chains.machines import machine
from tests.generated_code import COMPILERS

pytestmark = pytest.mark.sampled(5)

STEPS, STEP = 10_000, 1e-3
"""10 s."""
START = [0.8, 0.0, 6.0, 0.0]
"""q1, d_load and their rates: the crank goes round."""
FRAMES = ("coupler at (0.6, 0, 0)", "pin_end")
"""Where the coupler and the rocker are pinned together."""


def without_losses(described: Machine) -> Machine:
    def kept(joint: Joint) -> Joint:
        return replace(joint, spring=replace(joint.spring, damping=ZERO), wrench=Wrench())

    return replace(described, joints=tuple(map(kept, described.joints)))


def motion(code: CompiledPackage) -> Any:
    """States (q, qd) of a free motion, one a row."""
    tau = [0.0]

    def rate(_: float, y: Any) -> Any:
        return np.concatenate([y[2:], code.call("direct_dynamics", q=y[:2], qd=y[2:], tau=tau)["qdd"]])

    states = [np.array(START)]
    for k in range(STEPS):
        states.append(step(RK4, rate, k * STEP, states[-1], STEP))
    return np.array(states)


@pytest.mark.skipif(not COMPILERS, reason="no C compiler")
def test_energy_stays_and_the_loop_stays_closed(tmp_path: Path) -> None:
    models = ("direct_dynamics", "energy", "geometric_model")
    scene = Scene(models=models, outputs={"geometric_model": FRAMES})
    code = compile_package(trace_models(without_losses(machine("four_bar")), scene).package, tmp_path)
    states = motion(code)
    q, qd = states[:, :2], states[:, 2:]
    assert np.ptp(q[:, 0]) > 4 * np.pi
    energies = code.call_batch("energy", q=q, qd=qd)["E"].sum(axis=1)
    assert np.abs(energies - energies[0]).max() < 1e-4
    T = code.call_batch("geometric_model", q=q)["T"]
    gaps = T[:, 0, :3, 3] - T[:, 1, :3, 3]
    assert np.linalg.norm(gaps, axis=1).max() < 1e-14
