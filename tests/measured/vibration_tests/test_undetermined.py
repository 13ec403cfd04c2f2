"""What vibration tests cannot tell: 20 machines built so that they cannot, all of them reported, none of them moved.

Springs in series and in parallel, springs that symmetry locks, springs at whose node the test is made.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import symoro_elastic as se
from symoro_elastic.measured.fitting.estimates import Verdict, directions
from symoro_elastic.measured.vibration_tests.measured import VibrationTest
from tests.benchmarks.updating import measured_response

F = np.geomspace(5, 400, 120)
LIGHT = 1e-5
Built = tuple[dict[str, Any], str, list[str], str]
"""Tables, the place of the blow, what is not told, and the words that say so."""

pytestmark = pytest.mark.sampled(4)


def slide(name: str, **cells: Any) -> dict[str, Any]:
    return {"name": name, "kind": "elastic", "sigma": 1, "r": f"x_{name}", **cells}


def turn(name: str, **cells: Any) -> dict[str, Any]:
    return {"name": name, "kind": "elastic", "sigma": 0, "theta": f"t_{name}", **cells}


def machine(
    joints: list[dict[str, Any]], masses: dict[str, Any], springs: dict[str, Any], **more: Any
) -> dict[str, Any]:
    linked = [{"antecedent": joints[k - 1]["name"] if k else 0, **joint} for k, joint in enumerate(joints)]
    bodies = {name: x if isinstance(x, dict) else {"mass": x} for name, x in masses.items()}
    return {"name": "built", "joints": linked, "bodies": bodies, "springs": springs, **more}


def spring(k: Any, d: float = 40.0) -> dict[str, Any]:
    return {"stiffness": k, "damping": d}


def series(k1: float, k2: float, mass: float) -> Built:
    """Two springs in a row with hardly any mass between them; by one that is far stiffer, dampers join the sentence."""
    tables = machine([slide("nut"), slide("table")], {"nut": LIGHT, "table": mass},
                     {"nut": spring(k1, 1e-3 * k1**0.5), "table": spring(k2, 1e-3 * k2**0.5)})  # fmt: skip
    sentence = "in series: these tests determine only 1/" if max(k1 / k2, k2 / k1) < 8 else "are not distinguishable"
    return tables, "table.z", ["nut.stiffness", "table.stiffness"], sentence


def parallel(k1: float, k2: float, mass: float) -> Built:
    """Two strands of a belt, whose stiffness adds up."""
    tables = machine([slide("table")], {"table": mass}, {"table": spring("ka + kb", 2e-3 * ((k1 + k2) * mass) ** 0.5)},
                     parameters={"ka": {"value": k1}, "kb": {"value": k2}})  # fmt: skip
    return tables, "table.z", ["ka", "kb"], "in parallel: these tests determine only k"


def locked(axis: int, k: float, mass: float) -> Built:
    """A spring across the blow: nothing couples the two directions."""
    joints = [slide("along"), slide("across", alpha=["pi/2", "-pi/2"][axis % 2])]
    tables = machine(joints, {"along": 30.0, "across": mass}, {"along": spring(4e6, 200.0), "across": spring(k)})
    return tables, "along.z", ["across.stiffness", "across.damping"], "do not determine"


def node(distance: float, k: float, mass: float) -> Built:
    """A spring that turns about the line of the blow, which its centre of mass is on."""
    body = {"mass": mass, "center_of_mass": [0, 0, distance], "inertia": [0.5, 0.6, 0.7]}
    joints = [slide("along"), turn("twist")]
    tables = machine(joints, {"along": 20.0, "twist": body}, {"along": spring(6e6, 300.0), "twist": spring(k, 5.0)})
    return tables, "twist.z", ["twist.stiffness", "twist.damping"], "do not determine"


CASES = [
    *(series(k1, k2, mass) for k1, k2, mass in (
        (1e6, 3e6, 20), (2e6, 2e6, 20), (8e5, 9e6, 15), (5e6, 1e6, 40), (3e6, 2e6, 8), (1e7, 4e6, 100))),
    *(parallel(k1, k2, mass) for k1, k2, mass in ((1e6, 3e6, 20), (2e6, 2e6, 10), (4e5, 6e5, 5), (5e6, 2e6, 60))),
    *(locked(axis, k, mass) for axis, k, mass in ((0, 2e6, 12), (1, 5e5, 3), (0, 8e6, 30), (1, 3e6, 9), (0, 1e6, 60))),
    *(node(z, k, mass) for z, k, mass in ((0, 2e4, 9), (0.2, 5e4, 20), (-0.1, 1e5, 5), (0.4, 3e4, 12), (0.1, 8e3, 30))),
]  # fmt: skip


@pytest.mark.sampled(30)
@pytest.mark.parametrize("case", range(len(CASES)))
def test_what_cannot_be_told_is_said_and_stays_at_the_file(case: int) -> None:
    """A verdict on at least one of the parameters, a sentence with all of them, no value beyond one prior std."""
    tables, place, labels, sentence = CASES[case]
    rng = np.random.default_rng(case)
    pair = (place.replace(".z", ".az"), place.replace(".z", ".fz"))
    exact = se.response(tables, inputs=[pair[1]], outputs=[pair[0]], frequencies=F).values[:, 0, 0]
    test = VibrationTest("blow", {}, averages=10, responses=(measured_response(*pair, F, exact, rng),))
    off = {label: x * 2 ** rng.uniform(-0.9, 0.9) for label, x in numbers(tables).items()}
    found = se.update(se.read(tables), [test], values=off)
    by_label = {one.unknown.label: one for one in found.estimates}
    assert any(by_label[label].verdict is Verdict.NOT for label in labels)
    said = [line for line in found.undetermined if sentence in line and all(label in line for label in labels)]
    assert len(said) == 1, found.undetermined
    for label in labels:
        one = by_label[label]
        assert abs(np.log(one.value / one.unknown.nominal)) <= np.log(2.0)
    assert not found.bands


def numbers(tables: dict[str, Any]) -> dict[str, float]:
    springs = {f"{name}.{key}": x for name, one in tables["springs"].items() for key, x in one.items()}
    found = {label: x for label, x in springs.items() if not isinstance(x, str)}
    return found | {name: one["value"] for name, one in tables.get("parameters", {}).items()}


def test_directions_have_a_parameter_of_their_own() -> None:
    rng = np.random.default_rng(3)
    basis = np.linalg.qr(rng.normal(size=(7, 3)))[0]
    found = np.array(directions(basis)).T
    np.testing.assert_allclose(basis @ (basis.T @ found), found, atol=1e-12)
    own = [[k for k in range(7) if np.allclose(found[k], np.eye(3)[column], atol=1e-12)] for column in range(3)]
    assert all(own)
