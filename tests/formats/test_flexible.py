"""Cells of six springs become ordinary rows: against a rigid body on six springs, by axis, held, and refused."""

from __future__ import annotations

import numpy as np
import pytest

import symoro_elastic as se
from symoro_elastic.formats.toml import reading as toml
from symoro_elastic.formats.toml.schema import machine_schema
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.checks import check
from symoro_elastic.machine.machine import Machine
from symoro_elastic.models.programs.catalogue import MODELS
from symoro_elastic.numerics.verification.implementations import numpy_model

STIFFNESS = (3e7, 5e7, 9e7, 4e5, 7e5, 2e5)
CENTER, MASS = np.array([0.1, 0.02, 0.03]), 12.0
INERTIA = np.array([[0.2, 0.01, -0.02], [0.01, 0.3, 0.03], [-0.02, 0.03, 0.4]])
CELL = """
name = "guided"
gravity = [0, 0, 0]
joints = [
  { name = "bed", kind = "fixed", axis = "z", at = [0.1, 0.2, 0.3] },
  { name = "carriage", kind = "elastic", sigma = 6 },
  { name = "tool", kind = "fixed", d = 0.4 },
]
[bodies]
carriage = { mass = 12, center_of_mass = [0.1, 0.02, 0.03], inertia = [0.2, 0.01, -0.02, 0.3, 0.03, 0.4] }
[springs]
carriage = { stiffness = ["30 N/um", 5e7, 9e7, 4e5, 7e5, 2e5], damping = [1, 2, 3, 4, 5, 6] }
"""


def read(text: str) -> Machine:
    machine = toml.read(text, "guided.toml")
    check(machine)
    return machine


def frequencies(kept: list[int]) -> np.ndarray:
    """Frequencies, Hz, of the body on the springs of these directions, the others held."""
    arm = np.array([[0, -CENTER[2], CENTER[1]], [CENTER[2], 0, -CENTER[0]], [-CENTER[1], CENTER[0], 0]])
    inertia = np.block([[MASS * np.eye(3), -MASS * arm], [MASS * arm, INERTIA - MASS * arm @ arm]])[np.ix_(kept, kept)]
    squares = np.linalg.eigvals(np.linalg.solve(inertia, np.diag(np.array(STIFFNESS)[kept]))).real
    return np.asarray(np.sqrt(np.sort(squares)) / (2 * np.pi))


@pytest.mark.parametrize("held", [[], [0], [1, 3], [2, 4, 5]])
@pytest.mark.parametrize(
    "place", ["", ", alpha = 'pi/2', d = 0.3, r = 0.1", ", at = [0.3, 0, 0.1], in = 'bed'", ", antecedent = 1"]
)
def test_a_cell_is_a_body_on_six_springs(held: list[int], place: str) -> None:
    text = CELL.replace("sigma = 6", f"sigma = 6{place}")
    numbers = ['"30 N/um"', "5e7", "9e7", "4e5", "7e5", "2e5"]
    entries = ", ".join("inf" if k in held else number for k, number in enumerate(numbers))
    machine = read(text.replace(", ".join(numbers), entries))
    assert [joint.name for joint in machine.joints if joint.variable] == [
        f"carriage_{direction}"
        for k, direction in zip([0, 1, 2, 5, 4, 3], ["x", "y", "z", "rz", "ry", "rx"], strict=True)
        if k not in held
    ]
    kept = [k for k in range(6) if k not in held]
    np.testing.assert_allclose(se.modes(machine).frequencies, frequencies(kept), rtol=1e-9)


def test_stiffness_and_damping_are_those_of_the_direction() -> None:
    springs = {joint.name: joint.spring for joint in read(CELL).joints}
    for direction, k, d in zip(("x", "y", "z", "rx", "ry", "rz"), STIFFNESS, range(1, 7), strict=True):
        spring = springs[f"carriage_{direction}"]
        assert (spring.stiffness.value(), spring.damping.value()) == (k, d)


def test_frames_beyond_a_cell_are_as_beyond_a_fixed_row() -> None:
    """Also where directions are held, and for a row that names the cell by its number."""
    fixed = CELL.replace('"elastic", sigma = 6', '"fixed", d = 0.1, alpha = 0.3').partition("[springs]")[0]
    texts = [CELL, CELL.replace("5e7, 9e7", "inf, 9e7"), CELL.replace("9e7, 4e5", "9e7, inf")]
    for text in [text.replace("sigma = 6", "sigma = 6, d = 0.1, alpha = 0.3") for text in texts]:
        for other in (text, text.replace('"tool",', '"tool", antecedent = 2,')):
            place, expected = (numpy_model(x, ("geometric_model",)) for x in (read(other), read(fixed)))
            zero = np.zeros(len(read(other).with_variable))
            np.testing.assert_allclose(
                place.geometric_model(zero)[-1], expected.geometric_model(np.zeros(0))[-1], atol=1e-15
            )


def test_the_schema_has_cells() -> None:
    jsonschema = pytest.importorskip("jsonschema")
    import tomllib

    validator = jsonschema.Draft202012Validator(machine_schema(tuple(MODELS)))
    assert not [*validator.iter_errors(tomllib.loads(CELL))]
    assert [*validator.iter_errors(tomllib.loads(CELL.replace('"elastic"', '"motor"')))]


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('"elastic"', '"motor"', 'joint 2 (carriage), sigma: 6 is a cell of six springs: write kind = "elastic"'),
        ("sigma = 6", 'sigma = 6, axis = "x"', "joint 2 (carriage), axis: a cell of six springs has the axes of"),
        ("sigma = 6", 'sigma = 6, variable = "q"', "joint 2 (carriage), variable: a cell"),
        (", 2e5]", "]", "joint 2 (carriage), stiffness: must be a list of six: along x, y, z, about x, y, z"),
        ("damping = [1, 2, 3, 4, 5, 6]", "damping = 3", "joint 2 (carriage), damping: must be a list of six"),
        ("damping = [1, 2, 3, 4, 5, 6]", "backlash = 3", "joint 2 (carriage), backlash: a cell of six springs has"),
        ("damping = [1, 2, 3, 4, 5, 6]", "neutral = [[1]]", "neutral: must be a list of six"),
        ("stiffness = ", "neutral = ", "joint 2 (carriage), stiffness: is missing: write carriage = { stiffness"),
        ('["30 N/um", 5e7, 9e7, 4e5, 7e5, 2e5]', "[inf, inf, inf, inf, inf, inf]", "all directions are held"),
        ("[springs]", "[motors]\ncarriage = { rotor_inertia = 1 }\n[springs]", "motors: a cell of six springs has"),
        ("[springs]", "[friction]\ncarriage = { viscous = 1 }\n[springs]", "friction: a cell of six springs has"),
        ('"30 N/um"', '"30 N"', "(carriage_x), stiffness"),
    ],
)
def test_refusals(old: str, new: str, message: str) -> None:
    assert old in CELL
    with pytest.raises(InputError) as refusal:
        read(CELL.replace(old, new, 1))
    assert message in str(refusal.value)
    assert "\n" not in str(refusal.value)
