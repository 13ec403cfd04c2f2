"""Energy of free motions that lose none: two bars of an arm, shoulder and elbow springs of some 10 Hz without dampers.

The energy at each step is that of the generated model `energy`, and of the servo, which is a spring at the shoulder.
Fourth-order steps may lose or make little over 2 s; that of the midpoint rule stays bounded over a million steps.
"""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import numpy as np

from symoro_elastic.analysis.simulation.compiled_steps import CompiledSteps
from symoro_elastic.analysis.simulation.reference_motion import Reference, reference_of
from symoro_elastic.formats.toml import reading as toml
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.prescribed_motion import Gains, PrescribedMotion
from symoro_elastic.numerics.verification.implementations import numpy_model
from tests.benchmarks.tables import met, print_table

ARM = """
name = "bars"
gravity = [0, -9.81, 0]
joints = [
  { name = "shoulder", kind = "motor", sigma = 0, theta = "q1" },
  { name = "elbow", kind = "elastic", sigma = 0, d = 0.5, theta = "q2" },
]
[bodies]
shoulder = { mass = 4, center_of_mass = [0.25, 0, 0], inertia = [0, 0.1, 0.1] }
elbow = { mass = 2, center_of_mass = [0.2, 0, 0], inertia = [0, 0.03, 0.03] }
[springs]
elbow = { stiffness = 600 }
"""
SERVO, LIFTED = Gains(4000.0, 0.0), np.array([0.0, 0.5])
"""Gains of the shoulder; rad from the equilibrium, at which the servo stays."""
LATE = 1.2
"""Largest ratio of the errors in the second and in the first half of a bounded one."""


class Row(NamedTuple):
    """A method, its step in s, how many steps, and the largest error that is allowed, J; none where it is bounded."""

    method: str
    step: float
    steps: int
    most: float | None = None


ROWS = (
    Row("rodas4", 2.5e-4, 8_000, 2e-5),
    Row("rk4", 6e-5, 33_334, 1e-7),
    Row("midpoint", 2.5e-4, 1_000_000),
)  # fmt: skip
"""RK4 in the place of DP5, which is not a generated step, at the step that was asked of that."""


def show() -> list[Any]:
    """Print the table and return its figures."""
    machine = toml.read(ARM, "bars.toml")
    with TemporaryDirectory() as folder:
        runner = CompiledSteps(machine, [row.method for row in ROWS], Path(folder))
    figures, rows = [], []
    for row in ROWS:
        reference = let_go(machine, row.step * row.steps)
        found = runner.run(reference, row.method, row.steps)
        total = energy(reference, found.q, found.qd)
        wrong = np.abs(total - total[0])
        half = len(wrong) // 2
        late = float(wrong[half:].max() / wrong[:half].max())
        worst = float(wrong.max())
        is_met = late <= LATE if row.most is None else worst <= row.most
        goal = f"bounded: second half at most {LATE:g} of the first" if row.most is None else f"{row.most:.0e} J"
        figures.append({**row._asdict(), "energy": float(total[0]), "worst": worst, "late": late, "met": is_met})
        numbers = f"{row.step:g}", f"{row.steps}", f"{worst:.1e}", f"{late:.2f}", goal
        rows.append((row.method, *numbers, met(is_met)))
    columns = ("method", "step, s", "steps", "error, J", "second half over first", "asked", "")
    print_table(f"energy of free motions, {figures[0]['energy']:.3g} J to swing", columns, rows)
    return figures


def let_go(machine: Machine, duration: float) -> Reference:
    """The elbow deflected from its equilibrium, at rest; the servo is a spring without damping."""
    motion = PrescribedMotion(duration, {}, servo={"shoulder": SERVO}, source="bars.toml")
    reference = reference_of(machine, motion)
    reference.start.q[:] += LIFTED
    return reference


def energy(reference: Reference, q: Array, qd: Array) -> Array:
    """Kinetic, gravity and elastic energy beyond those at the equilibrium, that of the servo included, J."""
    model, start = numpy_model(reference.machine, ("energy",)), reference.start
    rest = start.q - LIFTED

    def servo(q: Array) -> Array:
        turned = q[..., 0] - start.q[0]
        potential: Array = SERVO.kp * turned**2 / 2 - start.tau[0] * q[..., 0]
        return potential

    at_rest = model.energy(rest, np.zeros(2)).sum() + servo(rest)
    total: Array = model.energy(q, qd).sum(axis=1) + servo(q) - at_rest
    return total


if __name__ == "__main__":
    show()
