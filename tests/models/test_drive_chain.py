"""Drives as expressions: rates and torque of equations by hand, shares of implicit steps that are never negative."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import mpmath
import numpy as np
import pytest
from mpmath import mpf

from symoro_elastic.machine.described import DescribedMachine
from symoro_elastic.machine.drives import Drives
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.joints import Electrics
from symoro_elastic.models.bound.bind import Bound
from symoro_elastic.models.drives.drive_chain import Inputs, Slopes
from symoro_elastic.models.drives.drive_states import chains_of
from symoro_elastic.symbolic.arithmetic import evaluate, multiprecision
from tests.models.test_drive_steps import formula, some_drive
from tests.models.test_friction_states import LAW, slider
from tests.references.closed_chains import DIGITS
from tests.references.drive_in_time import DriveInTime, Given


def driven(seed: int) -> DescribedMachine:
    """A mass with some drive; the ratio of its motor may be negative."""
    rng = np.random.default_rng(seed)
    machine = DescribedMachine.of(slider(**LAW))
    winding = Electrics(*map(formula, rng.uniform([0.1, 1e-3, 0.05, 0.05], [1, 1e-2, 0.5, 0.5])))
    joint = replace(machine.joints[0], electrics=winding, ratio=Formula.parse(str(rng.choice([-40, 0, 3]))))
    return replace(machine, joints=(joint,), drives=Drives({joint.name: some_drive(rng)}))


@pytest.mark.parametrize("seed", range(30))
def test_rates_and_torque_are_those_of_equations_by_hand(seed: int) -> None:
    machine, rng = driven(seed), np.random.default_rng(seed)
    (chain,) = chains_of(bound := Bound(machine)).values()
    names = [f"s{k}" for k in range(len(chain.names))]
    z, u = rng.normal(size=len(names)), rng.normal(size=6)
    symbols = [bound.graph.symbol(name) for name in names]
    given = Inputs(*(bound.graph.symbol(f"u{k}") for k in range(6)))
    rates, torque = chain.answer([*symbols], given)
    with mpmath.workdps(DIGITS):
        known = {name: mpf(x) for name, x in zip(names, z, strict=True)} | {f"u{k}": mpf(x) for k, x in enumerate(u)}
        value = evaluate([*rates, torque], known, multiprecision(DIGITS))
        expected, wanted = DriveInTime(machine.joints[0], machine.drives.by_motor["mass"]).answer(
            [mpf(x) for x in z], Given(*map(mpf, u))
        )
        for found, x in zip([*rates, torque], [*expected, wanted], strict=True):
            assert abs(mpf(value(found)) - x) <= 1e-12 * (1 + abs(x))


@pytest.mark.sampled(2)
@pytest.mark.parametrize("seed", range(30))
def test_no_share_is_negative(seed: int) -> None:
    """C and Y of the inertia that a drive is, for slopes within, at and beyond limits, from 0.1 us to 10 s."""
    (chain,) = chains_of(bound := Bound(driven(seed))).values()
    g, nothing = bound.graph.symbol("g"), [0] * len(chain.names)
    for slopes in (Slopes(x, y) for x in (0, Fraction(1, 2), 1) for y in (0, Fraction(1, 2), 1)):
        by_error, by_velocity = (chain.implicit(g, [*nothing], *way, slopes)[1] for way in ((1, 0), (0, 1)))
        with mpmath.workdps(DIGITS):
            for size in np.logspace(-7, 1, 9):
                value = evaluate([by_error, by_velocity], {"g": mpf(size)}, multiprecision(DIGITS))
                C, Y = mpf(value(by_error)), -mpf(value(by_velocity))
                assert C >= 0 and Y >= 0
                assert C > 0 or 0 in slopes
