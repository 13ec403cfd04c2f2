"""How many base parameters there are: one number for `show`, the model, the identification, and singular values.

In the regressor at random states, stacked:

- rank of all columns: those that `show` lists, with those that it calls zero for these bodies,
- `show` without those: the entries of the model `base_parameters`,
- rank of the columns that the identification has (bodies with any inertia, rotors): its base parameters.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest

from symoro_elastic.formats import read_machine
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.generation.pipeline import programs
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.scene import Scene
from symoro_elastic.measured.logs.identify import structural_grouping
from symoro_elastic.mechanics.regressor import INERTIAL, parameters_of
from symoro_elastic.numerics.evaluation.random_motion import random_motion
from symoro_elastic.numerics.evaluation.values import parameter_values
from symoro_elastic.numerics.linear.grouping import BaseParameters, base_parameters
from symoro_elastic.numerics.linear.rank import Stacked, enough_states, stacked_regressor
from symoro_elastic.numerics.linear.regressor import regressor
from tests.closed_chains.machines import FILES
from tests.closed_chains.test_base_parameters import ALIKE

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
UNGROUPED = ("floating_arm.toml", "all_keys.par", "flexible_arm.toml", "flexible_gantry.toml", "flexible_two_link.toml")
"""Floating bases, and bodies by modes: no base parameters are asked for."""
PATHS = {f"example {p.name}": p for p in sorted(EXAMPLES.glob("*.*")) if p.suffix in (".toml", ".par")}
PATHS = {name: path for name, path in PATHS.items() if path.name not in UNGROUPED}
PATHS |= {name: path for name, path in FILES.items() if name not in ALIKE}
FAST = ("example linkage.toml", "example two_axis.toml", "example sr400.par", "press", "gantry")
"""An example with sums that are zero by value, a tree, a robot with a loop, pairs of ratios, couplings."""
FELT = (*INERTIAL, "IA")
SMALL = 1e-9
"""Singular values of columns of length one beyond which they are rounding: those of these machines are above 1e-3."""

CASES = [pytest.param(name, marks=() if name in FAST else pytest.mark.thorough) for name in PATHS]
ZERO_BY_VALUE = {
    "example linkage.toml": (25, 9),
    "example sr400.par": (42, 20),
    "example palletizer.toml": (30, 12),
    "coupled_wrist": (71, 47),
    "geared_6r": (70, 40),
}
"""All base parameters, and those that are not zero for the bodies of the file."""
VARYING = ("screw", "geared_five_bar", "example carriage.toml")
"""Machines with stiffnesses that depend on positions, which no regressor has."""
AT_KNOWN_MOTION = {"example all_keys.toml": 30}
"""Of a base that moves: the identification knows how, the others hold for any motion of it."""


@cache
def machine(name: str) -> Machine:
    return read_machine(PATHS[name])[0]


@cache
def shown(name: str) -> BaseParameters:
    return base_parameters(machine(name))


@cache
def stacked(name: str) -> Stacked:
    """At states that neither the grouping nor the identification has seen."""
    return stacked_regressor(random_motion(machine(name), enough_states(machine(name)), 7))


def rank(W: Array) -> int:
    """By numpy's singular values, of columns of length one; none of them is doubtful."""
    lengths = np.linalg.norm(W, axis=0)
    there = lengths > SMALL * lengths.max(initial=0.0)
    sizes = np.linalg.svd(W[:, there] / lengths[there], compute_uv=False)
    assert not ((sizes > 1e-13) & (sizes < 1e-4)).any()
    return int((sizes > SMALL).sum())


@pytest.mark.parametrize("name", CASES)
def test_show_counts_the_rank_and_says_what_is_zero(name: str) -> None:
    found = shown(name)
    assert len(found.formulas) + len(found.zero) == rank(stacked(name).W)
    assert not {*found.formulas} & {*found.zero}
    counts = len(found.formulas) + len(found.zero), len(found.formulas)
    assert counts == ZERO_BY_VALUE.get(name, counts)


@pytest.mark.sampled(30)
@pytest.mark.parametrize("name", CASES)
def test_the_model_has_what_show_lists(name: str) -> None:
    (model,) = (m for m in programs(machine(name), Scene(models=("base_parameters",))).models if "X" in m.results)
    assert [*model.results["X"].column_labels] == [*shown(name).formulas]


@pytest.mark.sampled(16)
@pytest.mark.parametrize("name", CASES)
def test_the_identification_has_the_rank_of_its_columns(name: str) -> None:
    described = machine(name)
    if described.with_backlash or any(not joint.cogging.amplitude.is_zero for joint in described.joints):
        with pytest.raises(InputError, match="not linear in"):
            regressor(described, parameter_values(described))
        return
    if name in VARYING:
        with pytest.raises(InputError, match="it varies with"):
            regressor(described, parameter_values(described))
        return
    Y = regressor(described, parameter_values(described))
    labels = {c: (column.row, column.quantity) for c, column in enumerate(Y.columns) if column.quantity in FELT}
    sought = [c for c, label in labels.items() if label in stacked(name).labels]
    links = random_motion(described, 1).mechanism.links
    bodies = {j for j, link in enumerate(links, 1) if any(np.any(x) for x in parameters_of(link.body).values())}
    assert {labels[c][0] for c in sought if labels[c][1] != "IA"} == bodies
    expected = stacked(name).columns([labels[c] for c in sought])
    assert len(structural_grouping(Y, sought, described).kept) == AT_KNOWN_MOTION.get(name, rank(expected))
