"""Large machines: what is computed in another way, and what is not computed and says so."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from symoro_elastic.formats import read_machine
from symoro_elastic.machine.described import DescribedMachine
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import Base, Machine
from symoro_elastic.models.programs.catalogue import trace
from symoro_elastic.numerics.evaluation.values import parameter_values
from symoro_elastic.numerics.linear import rank
from symoro_elastic.numerics.linear.grouping import base_parameters, checked_grouping
from symoro_elastic.numerics.motion import equations_of_motion
from symoro_elastic.numerics.motion.equations_of_motion import motion_of
from symoro_elastic.numerics.verification import verify
from symoro_elastic.pages.report import sections
from symoro_elastic.symbolic.expression import reachable
from tests.references.random_machines import chain, led_by_the_first, random_machine

EXAMPLES = Path(__file__).parents[2] / "examples"


def refused(*_: object, **__: object) -> Any:
    raise AssertionError("not for large machines")


def test_the_rank_of_a_large_tree_is_not_compared(monkeypatch: pytest.MonkeyPatch) -> None:
    machine = random_machine(4)
    compared, known = checked_grouping(machine)
    monkeypatch.setattr(rank, "MOST_COMPARED", 3)
    monkeypatch.setattr(rank, "stacked_regressor", refused)
    found, check = checked_grouping(machine)
    assert found.formulas == compared.formulas and check.count == known.rank
    assert check.rank is None and check.conditioning is None and check.torques_stay
    shown_ones = base_parameters(machine)
    assert f"{check.count} base parameters, by the rules (torques stay within" in shown_ones.check
    assert shown_ones.condition is None and "no condition number" in shown_ones.conditioning


def test_a_wrong_grouping_of_a_large_tree_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rank, "MOST_COMPARED", 3)
    machine = random_machine(4)
    found = checked_grouping(machine)[0]
    wrong = replace(found, machine=replace(found.machine, base=Base(gravity=(Formula.parse(7),) * 3)))
    assert "torques change by" in rank.cross_check(machine, wrong).doubt


def test_a_large_machine_with_couplings_says_what_is_not_compared(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rank, "MOST_COMPARED", 3)
    monkeypatch.setattr(rank, "stacked_regressor", refused)
    shown = base_parameters(led_by_the_first(random_machine(4)))
    assert "by the rules (torques stay within" in shown.check and "couplings and loops may leave fewer" in shown.check


LOOPS = ("four_bar.par", "sr400.par", "two_axis.toml")


def machines_in_motion() -> list[Machine]:
    trees = [random_machine(seed, joints=7, massless=0.0) for seed in range(4)]
    return [*trees, *map(led_by_the_first, trees), *(read_machine(EXAMPLES / name)[0] for name in LOOPS)]


@pytest.mark.sampled(12)
@pytest.mark.parametrize("machine", machines_in_motion(), ids=lambda machine: machine.name)
@pytest.mark.parametrize("at_rest", [False, True])
def test_slopes_in_numbers_are_the_traced_linear_model(
    machine: Machine, at_rest: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Both sum some hundred products along a chain, each rounded by 1.1e-16 of its size."""
    motion = motion_of(machine, parameter_values(machine))
    rng, n = np.random.default_rng(3), len(motion.names)
    q = motion.neutral_positions() + 0.01 * rng.normal(size=n)
    qd, qdd = np.zeros((2, n)) if at_rest else rng.normal(size=(2, n))
    torques = rng.normal(size=len(motion.bound.tau))
    wanted = motion.matrices("MDK", q, qd, qdd, torques)
    monkeypatch.setattr(equations_of_motion, "MOST_PAIRS", -1)
    monkeypatch.setattr(equations_of_motion, "LARGEST_BLOCK", 2 * len(reachable(motion.residual)))
    for ours, theirs in zip(motion.matrices("MDK", q, qd, qdd, torques), wanted, strict=True):
        np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-13 * np.abs(theirs).max(initial=1.0))


@pytest.mark.thorough
def test_the_linear_model_of_a_long_chain_is_not_traced(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its formulas grow with the pairs of joints; r at rest is less than half as long as in motion."""
    motion = motion_of(chain(60))
    monkeypatch.setattr(equations_of_motion, "needs_of", refused)
    assert motion.forces_and_stiffness(motion.neutral_positions())[1].shape == (60, 60)
    at_rest, moving = len(reachable(motion.residual_at_rest)), len(reachable(motion.residual))
    assert 2 * at_rest < moving


def test_formulas_of_r_grow_with_the_joints() -> None:
    short, long = (len(reachable(motion_of(chain(n)).residual)) for n in (20, 40))
    assert long < 2.2 * short


@pytest.mark.thorough
def test_sections_of_a_report_that_are_too_long_say_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sections, "MOST_JOINTS", 3)
    monkeypatch.setattr(sections, "verify", refused)
    machine = DescribedMachine.of(random_machine(4))
    made = {one.title: "".join(one.blocks) for one in sections.sections(sections.Subject(machine, None))}
    left_out = [title for title, text in made.items() if "this section is for up to 3" in text]
    assert left_out == ["Summary", "Accuracy", "Equations"]


def test_fewer_states_are_checked_the_more_statements_there_are() -> None:
    models = [trace(chain(2), "inverse_dynamics")]
    statements = len(models[0].program.once) + len(models[0].program.statements)
    counts = [sum(verify._how_many(models * (size // statements + 1))) for size in (1, 10_000, 15_000)]
    assert counts == [64, 24, 6]
