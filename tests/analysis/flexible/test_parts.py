"""Joints and modes that beams and bodies need: against errors of single beams, and against the machine as a whole."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import symoro_elastic as se
from symoro_elastic.machine.beams.deflections import Bending, Joints
from symoro_elastic.machine.beams.places import FITTED, places_of
from tests.command_line import EXAMPLES, refused, run

MAST = """
name = "mast"
gravity = [0, 0, 0]
joints = [
  { name = "foot", antecedent = 0, kind = "fixed" },
  { name = "top", kind = "fixed" },
]
bodies = { top = { mass = 1 } }
[beams]
foot = { along = "x", length = 1, EI = 1, mass_per_length = 1, bends = ["y"], COUNT }
"""


SIX_MODES = 5e-4
"""Relative error of the third frequency of a clamped beam by six modes, the reference."""


@pytest.mark.thorough
@pytest.mark.parametrize("joints", [2, 3, 4])
def test_errors_of_a_beam_are_those_of_its_deflections(tmp_path: Path, joints: int) -> None:
    """A clamped beam with its mass at the end, whose frequencies follow from the shapes of joints and of the beam."""
    file = tmp_path / "mast.toml"
    file.write_text(MAST.replace("COUNT", f"joints = {joints}"), encoding="utf-8")
    (row,) = se.flexible_parts(file).rows
    alone = Bending("y", 1 / (2 * np.pi), (1.0, 0.0, 0.0))
    here, following = (alone.of_joints(Joints(places_of(FITTED, k, False)))[:3] for k in (joints, joints + 1))
    count = min(len(here), 3)
    exact = np.abs(here[:count] / alone.exact[:count] - 1).max()
    assert row.measured[0] == pytest.approx(exact, abs=SIX_MODES)
    assert row.predicted[0] == pytest.approx(np.abs(here[:count] / following[:count] - 1).max(), rel=1e-6)
    assert max(row.predicted[1], row.measured[1]) < 1e-9, "static deflection at the end is exact"


@pytest.mark.thorough
def test_fewest_modes_that_are_enough() -> None:
    shown = run("flexible", EXAMPLES / "flexible_arm.toml", "--within", "2%")
    assert "within 2 %: shoulder 3 modes, elbow 2 modes, wrist 1 mode\n" in shown.stdout


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("example", "within"), [("flexible_arm", 0.05), ("cantilever", 0.01), ("flexible_gantry", 0.3)]
)
def test_advised_numbers_are_enough_for_the_machine(example: str, within: float) -> None:
    """Errors above 0.1 % are predicted within 0.7 to 1.4 of the measured ones."""
    result = se.flexible_parts(EXAMPLES / f"{example}.toml", within=within)
    for row in result.rows:
        for predicted, measured in zip(row.predicted, row.measured, strict=True):
            assert not measured > 1e-3 or np.isnan(predicted) or 0.7 < predicted / measured < 1.4
    assert all(row and max(row.measured) < 1.1 * within for row in result.advised.values())


@pytest.mark.parametrize(
    ("words", "what"),
    [
        (("planar_2r.toml",), "beams: no beam, and no body by modes in [flexible]: name a file that has one"),
        (("bracket.npz", "--within", "1%"), "--frame, --at or --within: belongs to a machine file (.toml)"),
        (("flexible_two_link.toml", "--fixed", "x=0"), "--rail, --mass, --nodes or --save: belongs to a"),
        (("flexible_two_link.toml", "--within", "0"), "--within: 0 must be above 0, as 1% or 0.01"),
        (("flexible_two_link.toml", "--within", "x"), "--within: 'x' is not a number"),
        (("flexible_two_link.toml", "--frame", "nose"), "--frame: unknown 'nose'"),
        (("flexible_two_link.toml", "--at", "nose=1"), "--at: no moving joint 'nose'"),
    ],
)
def test_refused(words: tuple[str, ...], what: str) -> None:
    assert what in refused("flexible", EXAMPLES / words[0], *words[1:])
