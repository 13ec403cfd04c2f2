"""Cells with full 6 x 6 stiffness and damping, against motors that exert -K x - C xd, and against closed forms."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import symoro_elastic as se
from symoro_elastic.formats.toml import reading as toml
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.checks import check
from symoro_elastic.machine.described import DescribedMachine
from symoro_elastic.machine.joints import Kind, Spring
from symoro_elastic.numerics.verification.implementations import numpy_model

DIRECTIONS = ("x", "y", "z", "rx", "ry", "rz")
IN_SEQUENCE = ("x", "y", "z", "rz", "ry", "rx")
SIZES = np.sqrt([1e6, 2e6, 3e6, 4e4, 5e4, 6e4])
TEXT = """
name = "cell"
gravity = GRAVITY
joints = [
  { name = "slide", kind = "motor", sigma = 1, antecedent = 0, axis = "x" },
  { name = "guide", kind = "elastic", sigma = 6, gamma = 0.4, alpha = 0.3, d = 0.2 },
  { name = "wrist", kind = "motor", sigma = 0, axis = "z", in = "guide", at = [0.1, 0.2, 0.3] },
]
[bodies]
slide = { mass = 10, center_of_mass = [0, 0, 0], inertia = [1, 1, 1] }
guide = { mass = 5, center_of_mass = [0.1, 0, 0.05], inertia = [0.1, 0.2, 0.15] }
wrist = { mass = 3, center_of_mass = [0.1, 0.1, 0], inertia = [0.05, 0.02, 0.03] }
[springs]
guide = { stiffness = STIFFNESS, damping = DAMPING, neutral = NEUTRAL }
"""


def drawn(seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """K, C of rank 4 in every other seed, and neutral positions."""
    rng = np.random.default_rng(seed)
    Q = np.linalg.qr(rng.standard_normal((6, 6)))[0]
    B = rng.standard_normal((6, 4 if seed % 2 else 6))
    K, C = ((A + A.T) / 2 * np.outer(SIZES, SIZES) for A in (Q * rng.uniform(0.3, 2, 6) @ Q.T, 1e-3 * B @ B.T))
    return K, C, rng.uniform(-1e-3, 1e-3, 6)


def read(K: np.ndarray, C: np.ndarray, neutral: np.ndarray, gravity: float = 9.81) -> DescribedMachine:
    text = TEXT.replace("STIFFNESS", repr(K.tolist())).replace("DAMPING", repr(C.tolist()))
    text = text.replace("NEUTRAL", repr(neutral.tolist())).replace("GRAVITY", f"[0, 0, {-gravity}]")
    machine = toml.read(text, "cell.toml")
    check(machine)
    return machine


def transformation(machine: DescribedMachine) -> np.ndarray:
    """T of x = T e, from the formulas of the coupled rows."""
    labels = [f"guide_e{k}" for k in range(1, 7)]
    cells = {joint.name: joint.selected for joint in machine.joints}
    zero = dict.fromkeys(labels, 0.0)
    unit = [zero | {label: 1.0} for label in labels]
    rows = [cells[f"guide_{direction}"] for direction in DIRECTIONS]
    return np.array([[row.value(e) - row.value(zero) for e in unit] for row in rows])


@pytest.mark.parametrize("seed", range(4))
def test_accelerations_are_those_under_the_forces_of_springs_and_dampers(seed: int) -> None:
    """The six rows as motors of a machine without springs; the matrices act on their positions and rates."""
    K, C, neutral = drawn(seed)
    machine, rows = read(K, C, neutral), read(np.diag(np.diag(K)), 0 * C, 0 * neutral)
    assert [joint.name for joint in rows.joints if joint.kind is Kind.ELASTIC] == [f"guide_{x}" for x in IN_SEQUENCE]
    as_motors = (replace(x, kind=Kind.MOTOR, spring=Spring()) if x.kind is Kind.ELASTIC else x for x in rows.joints)
    driven = numpy_model(replace(rows, joints=tuple(as_motors)), ("direct_dynamics",))
    rng, T = np.random.default_rng(100 + seed), transformation(machine)
    e, ed = rng.uniform(-0.3, 0.3, (2, 6))
    x, xd = T @ e, T @ ed
    q, qd, tau = np.array([[0.1, 0.2], [1.0, -0.5], [30.0, 4.0]])
    order = [DIRECTIONS.index(name) for name in IN_SEQUENCE]
    ours = numpy_model(machine, ("direct_dynamics",)).direct_dynamics(joined(q, e), joined(qd, ed), tau)
    force = -K @ (x - neutral) - C @ xd
    expected = driven.direct_dynamics(joined(q, x[order]), joined(qd, xd[order]), joined(tau, force[order]))
    np.testing.assert_allclose(joined(ours[[0, 7]], (T @ ours[1:7])[order]), expected, rtol=1e-9)


def joined(motors: np.ndarray, cell: np.ndarray) -> np.ndarray:
    return np.array([motors[0], *cell, motors[1]])


@pytest.mark.parametrize("seed", range(2))
def test_the_stiffness_of_the_carried_frame_is_the_matrix(seed: int) -> None:
    K, C, _ = drawn(seed)
    stiffness = np.linalg.inv(se.stiffness(read(K, C, np.zeros(6), gravity=0.0), frame="guide").compliance)
    frame = numpy_model(read(K, C, np.zeros(6)), ("geometric_model",), {"geometric_model": ("guide",)})
    R = np.kron(np.eye(2), frame.geometric_model(np.zeros(8))[-1][:3, :3])
    np.testing.assert_allclose(R.T @ stiffness @ R, K, rtol=1e-7, atol=1e-7 * np.outer(SIZES, SIZES).max())


def test_a_diagonal_matrix_has_the_frequencies_and_damping_of_a_list() -> None:
    """A damping of one pair, too small to matter, makes coupled rows of it."""
    K, C, neutral = np.diag(SIZES**2), np.diag(1e-4 * SIZES**2), np.zeros(6)
    C[0, 1] = C[1, 0] = 1e-12 * SIZES[0] * SIZES[1]
    text = TEXT.replace("STIFFNESS", repr((SIZES**2).tolist())).replace("DAMPING", repr(np.diag(C).tolist()))
    plain = toml.read(text.replace("NEUTRAL", repr([0] * 6)).replace("GRAVITY", "[0, 0, -9.81]"), "cell.toml")
    ours, theirs = (se.modes(x, hold=["all"]) for x in (read(K, C, neutral), plain))
    np.testing.assert_allclose(ours.frequencies, theirs.frequencies, rtol=1e-7)
    np.testing.assert_allclose(ours.damping_ratios, theirs.damping_ratios, rtol=1e-6)


@pytest.mark.thorough
def test_check_and_saved_rows(tmp_path: Path) -> None:
    """Of every model, against 50 digits; a written machine has the same rows."""
    machine = read(*drawn(1))
    assert se.check(machine).ok
    se.write(machine, tmp_path / "cell.toml")
    assert se.read(tmp_path / "cell.toml").joints == machine.joints


def test_entries_may_have_units() -> None:
    K, C, neutral = drawn(0)
    machine = read(K, C, neutral)
    text = TEXT.replace("DAMPING", repr(C.tolist())).replace("NEUTRAL", repr(neutral.tolist()))
    plain = repr(K.tolist())
    for value, unit in ((K[0, 0], "N/m"), (K[0, 4], "N"), (K[4, 5], "N m/rad")):
        plain = plain.replace(repr(float(value)), f'"{float(value)!r} {unit}"')
    again = toml.read(text.replace("STIFFNESS", plain).replace("GRAVITY", "[0, 0, -9.81]"), "cell.toml")
    assert again.joints == machine.joints


def test_held_directions_have_no_rows() -> None:
    K, C, neutral = drawn(0)
    K[2], K[:, 2] = 0, 0
    K[2, 2] = np.inf
    C[2], C[:, 2], C[2, 2] = 0, 0, 0
    names = [joint.name for joint in read(K, C, neutral).joints if "guide_" in joint.name]
    assert "guide_z" not in names
    assert "guide_e5" in names
    assert "guide_e6" not in names


STIFFNESS = [[4.0, 1, 0, 0, 0, 0], [1, 4.0, 0, 0, 0, 0], *([0.0] * k + [4.0] + [0.0] * (5 - k) for k in range(2, 6))]


def changed(*entries: tuple[int, int, object]) -> str:
    matrix: list[list[object]] = [[*row] for row in STIFFNESS]
    for i, k, value in entries:
        matrix[i][k] = value
    return repr(matrix).replace("'", '"').replace('"inf"', "inf")


@pytest.mark.parametrize(
    ("stiffness", "damping", "message"),
    [
        (changed((0, 1, 2)), "[0, 0, 0, 0, 0, 0]", "stiffness: is not symmetric"),
        (changed((0, 1, 5), (1, 0, 5)), "[0, 0, 0, 0, 0, 0]", "stiffness: has a negative eigenvalue"),
        (changed((0, 1, 4), (1, 0, 4)), "[0, 0, 0, 0, 0, 0]", "stiffness: leaves a direction without stiffness"),
        (changed((3, 3, 0)), "[0, 0, 0, 0, 0, 0]", "stiffness: entries of the diagonal must be above 0"),
        (changed((3, 3, "k")), "[0, 0, 0, 0, 0, 0]", "stiffness: 'k' is a name, and matrices are numbers"),
        (changed((0, 0, "inf")), "[0, 0, 0, 0, 0, 0]", "stiffness: couples a direction that is held"),
        (changed((0, 0, "3 kg")), "[0, 0, 0, 0, 0, 0]", "stiffness: "),
        ("[[1, 2], 3, 4, 5, 6, 7]", "[0, 0, 0, 0, 0, 0]", "stiffness: must be six numbers, or six rows of six"),
        ("[1, [2], 3, 4, 5, 6]", "[0, 0, 0, 0, 0, 0]", "stiffness: must be six numbers, or six rows of six"),
        ("[1, 1, 1, 1, 1, 1]", changed((0, 0, -4)), "damping: entries of the diagonal must not be negative"),
        ("[1, 1, 1, 1, 1, 1]", changed((0, 1, 9), (1, 0, 9)), "damping: has a negative eigenvalue"),
        ("[1, 1, 1, 1, 1, 1]", changed((0, 0, 0), (1, 1, 0)), "damping: has a negative eigenvalue"),
    ],
)
def test_refusals(stiffness: str, damping: str, message: str) -> None:
    text = TEXT.replace("STIFFNESS", stiffness).replace("DAMPING", damping).replace("NEUTRAL", "[0, 0, 0, 0, 0, 0]")
    with pytest.raises(InputError) as refusal:
        toml.read(text.replace("GRAVITY", "[0, 0, 0]"), "cell.toml")
    assert f"joint 2 (guide), {message}" in str(refusal.value)
    assert "\n" not in str(refusal.value)
