"""The two references of closed chains reproduce figures of another program, and each other's."""

from __future__ import annotations

from typing import Any

import mpmath
import numpy as np
import pytest
from mpmath import mpf

from tests.closed_chains.machines import FILES, WITH_RESULTS, data, machine, situations
from tests.references.closed_chains import DIGITS, exact, nearest_double
from tests.references.constraint_multipliers import Multipliers
from tests.references.virtual_work import VirtualWork, small_motions

pytestmark = pytest.mark.sampled(6)

FIGURES = 1e-23
"""Results are kept to 25 digits."""
AGREEMENT = 1e-45
"""In 70 digits, of which stiff springs and heavy gears take some."""
REFERENCES = (Multipliers, VirtualWork)
KNOWN = [(name, k) for name in WITH_RESULTS for k in range(4)]


def worst(found: Any, wanted: Any) -> float:
    """Largest difference over the largest wanted entry, in many digits; entries that are zero differ by rounding."""
    with mpmath.workdps(DIGITS):
        found, wanted = (np.array(entries, dtype=object).ravel() for entries in (found, wanted))
        wanted = np.array([mpf(x) for x in wanted], dtype=object)
        assert found.shape == wanted.shape
        scale = max([*map(abs, wanted), mpf(10) ** -12])
        return float(max(map(abs, found - wanted), default=mpf(0)) / scale)


@pytest.mark.sampled(10)
@pytest.mark.parametrize("reference", REFERENCES)
@pytest.mark.parametrize(("name", "k"), KNOWN)
def test_figures_of_another_program(name: str, k: int, reference: type[Multipliers] | type[VirtualWork]) -> None:
    """Decimals of the file were rounded to double precision there."""
    situation, results = situations(name)[k], data(name)["results"][k]
    found = reference(machine(name), situation.state, nearest_double)
    torques, accelerations = found.inverse(situation.qdd_motor)
    for quantity, value in {
        "x": [found.at[variable] for variable in found.chain.own],
        "xd": found.xd,
        "cut": [found.at[variable] for variable in found.chain.cuts],
        "direct_xdd": found.direct(situation.tau),
        "inverse_tau": torques,
        "inverse_xdd": accelerations,
        "inertia_matrix": found.inertia(),
        "S_x": found.S_x,
        "right_side": found.right_side(),
    }.items():
        assert worst(value, results[quantity]) < FIGURES, quantity


@pytest.mark.thorough
@pytest.mark.parametrize("name", ["five_bar", "sr400", "cam", "spatial_four_bar"])
def test_small_motions(name: str) -> None:
    """Of another program, whose D and K are differences of 23 digits or more, and as `states` kept them."""
    situation, known = situations(name)[0], data(name)["linearization"]
    found = small_motions(machine(name), situation.state, situation.tau, nearest_double)
    for label, matrix in zip(("M", "D", "K"), found, strict=True):
        assert worst(matrix, known[label]) < 1e-19, label


@pytest.mark.sampled(30)
@pytest.mark.parametrize("name", FILES)
def test_the_references_agree(name: str) -> None:
    for situation in situations(name)[:1]:
        one, other = (reference(machine(name), situation.state, exact) for reference in REFERENCES)
        for quantity, a, b in zip(QUANTITIES, _all(one, situation), _all(other, situation), strict=True):
            assert worst(a, b) < AGREEMENT, quantity


QUANTITIES = ("xd", "S", "S_x", "gam", "gam_x", "A", "H", "right side", "direct xdd", "inverse tau", "inverse xdd")


def _all(found: Multipliers | VirtualWork, situation: Any) -> list[Any]:
    direct, inverse = found.direct(situation.tau), found.inverse(situation.qdd_motor)
    motion = [found.xd, found.S, found.S_x, found.gam, found.gam_x]
    return [*motion, found.inertia(), found.bias(), found.right_side(), direct, *inverse]
