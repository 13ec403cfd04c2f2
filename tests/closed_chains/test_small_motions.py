"""The linear model M, D, K of machines with couplings and loops: the tangent stiffness of constraint forces is in K."""

from __future__ import annotations

import numpy as np
import pytest

from symoro_elastic.models.programs.catalogue import trace
from symoro_elastic.symbolic.arithmetic import FLOATS, evaluate
from tests.closed_chains.machines import WITH_RESULTS, data, machine, situations
from tests.closed_chains.test_references import worst
from tests.closed_chains.traced import results
from tests.references.closed_chains import nearest_double
from tests.references.virtual_work import VirtualWork, small_motions

pytestmark = pytest.mark.sampled(6)

MACHINES = (
    "cam",
    "differential",
    "four_bar",
    "gantry",
    "gas_spring",
    "parallelogram_loop",
    "press",
    "screw",
    "spatial_four_bar",
)
"""Beside those with results of another program. Motors of the gantry are on dependent joints."""
FEW_DIGITS = 1e-19
"""The reference's D and K are differences of 23 digits or more."""


@pytest.mark.sampled(1000)
@pytest.mark.parametrize("name", MACHINES)
def test_matrices_are_differences_of_virtual_work(name: str) -> None:
    described, situation = machine(name), situations(name)[0]
    at = VirtualWork(described, situation.state)
    udd = at.direct(situation.tau)[[at.chain.own.index(variable) for variable in at.chain.independent]]
    found = results(described, "linearization", situation.state, {"qdd": udd, "tau": situation.tau})
    wanted = small_motions(described, situation.state, situation.tau)
    for label, matrix in zip(("M", "D", "K"), wanted, strict=True):
        assert worst(found[label], matrix) < FEW_DIGITS, label


@pytest.mark.parametrize("name", WITH_RESULTS)
def test_in_double_precision(name: str) -> None:
    """Sums of some hundred products, each rounded by 1.1e-16 of its size: 1e-14 of the largest entry is kept."""
    described, situation, known = machine(name), situations(name)[0], data(name)["linearization"]
    at = VirtualWork(described, situation.state, nearest_double)
    udd = at.direct(situation.tau)[[at.chain.own.index(variable) for variable in at.chain.independent]]
    program = trace(described, "linearization").program
    symbols = {p.name: p.value.value() for p in described.parameters if p.value}
    numbers = {"q": situation.state.u, "qd": situation.state.ud, "qdd": [float(x) for x in udd]}
    for entries in program.inputs:
        symbols |= dict(zip(entries.symbols, map(float, numbers[entries.name]), strict=True))
    value = evaluate((x for output in program.outputs for x in output.entries), symbols, FLOATS)
    for output in program.outputs:
        wanted = np.array(known[output.name], dtype=float).ravel()
        ours = np.array([float(value(x)) for x in output.entries])
        np.testing.assert_allclose(ours, wanted, rtol=0, atol=1e-14 * np.abs(wanted).max(initial=1e-12))
