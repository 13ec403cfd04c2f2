"""Base parameters of machines with couplings and loops: how many there are, and that torques stay."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from symoro_elastic.formats import read_machine
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.generation.pipeline import programs
from symoro_elastic.machine.checks import check
from symoro_elastic.machine.formula import ZERO, Formula
from symoro_elastic.machine.machine import Body, Joint, Kind, Machine
from symoro_elastic.machine.scene import Scene
from symoro_elastic.mechanics.regressor import parameters_of
from symoro_elastic.models.parameters.base_parameters import base_grouping
from symoro_elastic.models.programs.catalogue import trace
from symoro_elastic.numerics.evaluation.random_motion import random_motion
from symoro_elastic.numerics.linear.grouping import base_machine, base_parameters, checked_grouping
from symoro_elastic.numerics.linear.independence import rank
from symoro_elastic.numerics.linear.rank import RANK_TOLERANCE, cross_check, enough_states, stacked_regressor
from symoro_elastic.numerics.verification.implementations import numpy_model
from tests.closed_chains.machines import FILES, machine, reordered, situations
from tests.closed_chains.test_regressors import inputs_of
from tests.references.virtual_work import VirtualWork

pytestmark = pytest.mark.sampled(6)

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
OBLIQUE = (Formula.parse(3), Formula.parse("-2"), Formula.parse("-9"))
TORQUES = 1e-12

ALIKE = ("palletizer", "press_cut_at_crank", "ring_with_slide", "two_jack_arm")
"""Machines whose loops are like those of others."""
COUNTS = {"sr400": (55, 44), "parallelogram": (38, 27), "five_bar": (21, 20)}
"""Of the tree cut open and of the closed machine, by another program in an exact field (gravity in any direction)."""


@pytest.mark.parametrize("name", COUNTS)
def test_known_counts(name: str) -> None:
    described = machine(name)
    tilted = described if name == "five_bar" else replace(described, base=replace(described.base, gravity=OBLIQUE))
    rules = base_grouping(tilted)
    assert (rules.count, cross_check(tilted, rules).rank) == COUNTS[name]
    found, checked = checked_grouping(tilted)
    assert found.count == COUNTS[name][1]
    assert "couplings and loops leave" in checked.message


@pytest.mark.parametrize(("tilt", "count"), [("0", 40), ("0.4", 41)])
def test_counts_of_rx90_with_balanced_rotors(tilt: str, count: int) -> None:
    """Rotors add what Ia does; that of joint 2 is felt by joint 1 too where its axis is not square to the first one."""
    with_rotors = _with_rotors(read_machine(EXAMPLES / "rx90.par")[0], tilt)
    links = {j for j, joint in enumerate(with_rotors.joints, start=1) if joint.kind is Kind.MOTOR}
    stacked = stacked_regressor(random_motion(with_rotors, enough_states(with_rotors)))
    wanted = [(j, x) for j, x in stacked.labels if j in links or x == "ZZ"]
    assert len(wanted) == 66
    assert rank(stacked.columns(wanted), RANK_TOLERANCE, RANK_TOLERANCE) == count


def _with_rotors(arm: Machine, tilt: str) -> Machine:
    """A rotor for each joint, on the same antecedent, 50 times as fast, its axis turned about x of that."""
    joints: list[Joint] = []
    number = {0: 0}
    for j, joint in enumerate(arm.joints, start=1):
        on = number[joint.antecedent]
        spinning = replace(joint.with_selected(Formula.parse(f"50*{joint.variable}")), rotor_inertia=ZERO, body=Body())
        turned = replace(spinning, alpha=Formula.parse(f"{joint.alpha} + {tilt}"), variable=None)
        rotor = replace(turned, name=f"rotor{j}", kind=Kind.COUPLED, antecedent=on)
        joints += [rotor, replace(joint, antecedent=on, rotor_inertia=ZERO)]
        number[j] = len(joints)
    return replace(arm, joints=tuple(joints))


@pytest.mark.thorough
@pytest.mark.parametrize("name", [name for name in FILES if name not in ALIKE])
def test_torques_stay(name: str) -> None:
    """Against virtual work of both machines, at states that the grouping has not seen."""
    described = machine(name)
    regrouped, warnings = base_machine(described)
    assert all("couplings and loops leave" in line and "QR" in line for line in warnings)
    check(regrouped)
    assert regrouped.is_grouped
    for situation in situations(name)[:2]:
        before, after = (VirtualWork(some, situation.state) for some in (described, regrouped))
        udd, idle = inputs_of(described, situation, before.at)["qdd"], [0.0] * len(described.motors)
        one, other = (reference.residual(udd, idle).astype(float) for reference in (before, after))
        assert np.abs(one - other).max() < TORQUES * np.abs(one).max()


@pytest.mark.thorough
@pytest.mark.parametrize("name", ["sr400", "press", "coupled_wrist"])
def test_the_order_of_rows_does_not_matter(name: str) -> None:
    one, other = (checked_grouping(some)[0].count for some in (machine(name), reordered(machine(name))))
    assert one == other


def test_without_values_of_the_geometry_the_rules_of_the_tree_are_used() -> None:
    described = machine("sr400")
    unknown = replace(described, parameters=tuple(replace(p, value=None) for p in described.parameters))
    regrouped, (warning,) = base_machine(unknown)
    assert "give values to D2, D3, D4, D8, RL4; until then the grouping by the rules is used" in warning
    assert len(base_parameters(unknown).formulas) == len(base_grouping(described).parameters)
    assert {parameter.name for parameter in regrouped.parameters} >= {"D2", "D3", "D4", "D8", "RL4"}


def test_lengths_without_values_are_drawn_so_that_loops_close() -> None:
    """Three parallelograms in series, of any lengths; a pair of ratios of a press."""
    for name, unknown, count in (("palletizer", "LHKGM", 29), ("press", ("N", "Nf"), 12)):
        described = machine(name)
        given = (replace(p, value=None) if p.name in unknown else p for p in described.parameters)
        without = replace(described, parameters=tuple(given))
        assert cross_check(without, base_grouping(without)).rank == count


def test_ratios_and_shares_of_motors_stay_right() -> None:
    """Ia of a rotor on its own side times its ratio squared becomes a base parameter; shares stay."""
    described = machine("gantry")
    rows = tuple(
        replace(joint, sharing=Formula.parse(2)) if joint.name == "ram" else joint for joint in described.joints
    )
    regrouped, _ = base_machine(replace(described, joints=rows))
    assert all(joint.ratio.is_zero for joint in regrouped.joints)
    assert [joint.sharing.text for joint in regrouped.joints if not joint.sharing.is_zero] == ["2"]


ENTRIES = {"sr400": 42, "five_bar": 16, "gantry": 13, "gantry_rigid": 4, "quick_return": 11, "parallelogram": 25}
"""Entries of the model: as many as the rank of the columns of parameters that are not zero."""
SLOW_ENTRIES = {"delta": 37, "ring": 34, "palletizer": 29, "two_jack_arm": 41, "differential": 20}
SLOW = [pytest.param(*one, marks=pytest.mark.thorough) for one in SLOW_ENTRIES.items()]


@pytest.mark.parametrize(("name", "entries"), [*ENTRIES.items(), *SLOW])
def test_the_model_has_as_many_entries_as_the_rank(name: str, entries: int) -> None:
    """By numpy's singular values; torques of the entries in the columns of their labels are those of all parameters."""
    described = machine(name)
    model = next(m for m in programs(described, Scene(models=("base_parameters",))).models)
    labels = model.results["X"].column_labels
    X = numpy_model(described, ("base_parameters",)).base_parameters()
    motion = random_motion(described, enough_states(described), 5)
    stacked = stacked_regressor(motion)
    links = motion.mechanism.links
    values = {(j, x): v for j, link in enumerate(links, 1) for x, v in parameters_of(link.body).items()}
    values |= {(j, "IA"): link.rotor_inertia for j, link in enumerate(links, 1)}
    there = [label for label in stacked.labels if values[label]]
    W = stacked.columns(there)
    lengths = np.linalg.norm(W, axis=0)
    W = W[:, lengths > 1e-9 * lengths.max()] / lengths[lengths > 1e-9 * lengths.max()]
    assert len(X) == len(labels) == entries == np.linalg.matrix_rank(W, tol=1e-9 * np.sqrt(len(W)))
    kept = stacked.columns([(int(digits), entry) for entry, digits in map(split_label, labels)])
    torques = stacked.columns(there) @ [values[label] for label in there]
    assert np.abs(kept @ X - torques).max() < 1e-12 * np.abs(torques).max()


def split_label(label: str) -> tuple[str, str]:
    found = re.fullmatch(r"(IA|[A-Z]{1,2}?)R?_?(\d+)", label)
    assert found, label
    return found[1], found[2]


def test_the_model_says_for_which_geometry_it_holds() -> None:
    described = machine("sr400")
    model = next(m for m in programs(described, Scene(models=("base_parameters",))).models)
    assert model.model.title.endswith("for the values of D2, D3, D4, D8, RL4 in the table")
    unknown = replace(described, parameters=tuple(replace(p, value=None) for p in described.parameters))
    with pytest.raises(InputError, match=r"for one geometry only: give values to D2, D3, D4, D8, RL4$"):
        programs(unknown, Scene(models=("base_parameters",)))


def test_without_numbers_no_base_of_loops_is_traced() -> None:
    with pytest.raises(ValueError, match="couplings and loops group more"):
        trace(machine("five_bar"), "base_parameters")
