"""The hull of the motions of a scene as the box of certificates and tolerances."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import symoro_elastic as se
from symoro_elastic.api.models import hull
from symoro_elastic.foundation.errors import InputError

EXAMPLES = Path(__file__).parents[2] / "examples"
PLANAR, SCENE = EXAMPLES / "planar_2r.toml", EXAMPLES / "scenes" / "planar_2r_move.toml"


@pytest.mark.thorough
def test_the_hull_holds_the_motion_and_a_tenth_more() -> None:
    motions = se.simulate(PLANAR, scene=SCENE)
    joints = hull(motions)
    for k, name in enumerate(("shoulder", "elbow")):
        found = joints[name]
        columns = (motions[0].motion.q, motions[0].motion.qd, motions[0].motion.qdd, motions[0].motion.tau)
        for limits, values in zip(
            (found.position, found.velocity, found.acceleration, found.torque), columns, strict=True
        ):
            assert limits is not None
            assert limits.high - limits.low == pytest.approx(1.1 * np.ptp(values[:, k]))
            assert limits.low <= values[:, k].min() and values[:, k].max() <= limits.high


@pytest.mark.thorough
def test_certificates_are_for_the_motion() -> None:
    whole = se.certify(PLANAR, "inverse_dynamics").certificates[0]
    found = se.certify(PLANAR, "inverse_dynamics", scene=SCENE, limits="motion").certificates[0]
    assert found.box.ranges["q1"].high < whole.box.ranges["q1"].high
    assert found.entries[0].error < whole.entries[0].error


@pytest.mark.thorough
def test_generated_code_is_for_the_motion(tmp_path: Path) -> None:
    se.generate(PLANAR, "inverse_dynamics", out=tmp_path, scene=SCENE, limits="motion", certify=True)
    found = se.certify(PLANAR, "inverse_dynamics", scene=SCENE, limits="motion").certificates[0]
    assert found.box.digest in (tmp_path / "planar_2r" / "planar_2r.h").read_text(encoding="utf-8")


def test_a_scene_without_motion_is_refused() -> None:
    with pytest.raises(InputError, match="motion: missing"):
        se.certify(PLANAR, "inverse_dynamics", limits="motion")
    with pytest.raises(InputError, match=r"'path'.*file, motion"):
        se.certify(PLANAR, limits="path")
