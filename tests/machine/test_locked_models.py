"""Models of machines with locked joints are those of the whole machine, at rest in these joints."""

from __future__ import annotations

import numpy as np
import pytest

from symoro_elastic.formats.toml import reading as toml
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.restrict import restrict
from symoro_elastic.machine.scene import Scene
from symoro_elastic.numerics.verification.implementations import numpy_model
from tests.machine.samples import COUPLED

BODIES = "\n".join(
    f"{name} = {{ mass = {mass}, center_of_mass = [0.2, 0.05, 0.01], inertia = [0.1, 0.01, 0.02, 0.3, 0.03, 0.35] }}"
    for name, mass in (("waist", 40), ("rotor", 1), ("arm", 15), ("forearm", 9), ("crank", 6), ("drive", 1), ("rod", 3))
)
NEAR = {"q1": 0.3, "q2": 1.0, "q4": 0.02, "qm": 250.0}


def linkage() -> Machine:
    text = COUPLED.replace("forearm = { mass = 9 }", f"{BODIES}\njaw = {{ mass = 2 }}")
    return toml.read(text.replace("gravity = [0, 0, 0]", "gravity = [1, 2, -9]", 1), "arm.toml")


@pytest.mark.sampled(2)
@pytest.mark.parametrize(
    "locked", [("waist",), ("crank",), ("drive",), ("waist", "crank"), ("arm", "crank", "drive")], ids="-".join
)
def test_inertia_and_bias_are_those_of_the_whole_machine(locked: tuple[str, ...]) -> None:
    """A and H at any rates of the joints that are left; rows and columns of the locked ones are left out."""
    machine, rng = linkage(), np.random.default_rng(7)
    names = [machine.joint(j).name for j in machine.independent]
    q = np.array([NEAR[str(machine.joint(j).variable)] for j in machine.independent]) + 0.05 * rng.normal(
        size=len(names)
    )
    kept = [k for k, name in enumerate(names) if name not in locked]
    qd = np.zeros(len(names))
    qd[kept] = rng.normal(size=len(kept))
    values = {name: Formula.parse(float(x)) for name, x in zip(names, q, strict=True) if name in locked}
    whole, still = (
        numpy_model(one, ("inertia_matrix", "bias_forces"))
        for one in (machine, restrict(machine, Scene(locked=values)))
    )
    A, H = whole.inertia_matrix(q), whole.bias_forces(q, qd)
    np.testing.assert_allclose(
        still.inertia_matrix(q[kept]), A[np.ix_(kept, kept)], rtol=1e-12, atol=1e-14 * abs(A).max()
    )
    np.testing.assert_allclose(still.bias_forces(q[kept], qd[kept]), H[kept], rtol=1e-12, atol=1e-14 * abs(H).max())
