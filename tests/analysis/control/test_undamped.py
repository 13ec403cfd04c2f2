"""Machines without damping: frequencies of grids are their exact eigenfrequencies, where responses are infinite."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import symoro_elastic as se
from symoro_elastic.analysis.control.loops import loops_of
from symoro_elastic.analysis.vibration.linearization import moved_by
from symoro_elastic.foundation.errors import InputError
from tests.command_line import run

pytest.importorskip("scipy.linalg")

TINY = 1e-18
"""A damping ratio whose effect on figures is below their tolerance."""


def chain(masses: list[float], stiffness: list[float], **drive: Any) -> dict[str, Any]:
    """A motor with a mass, and masses on springs in a row."""
    names = [f"s{k}" for k in range(1, len(masses))]
    joints = [{"name": "x", "antecedent": 0, "kind": "motor", "sigma": 1, "r": "q1"}]
    joints += [{"name": name, "kind": "elastic", "sigma": 1, "r": f"d{name}"} for name in names]
    return {
        "name": "chain",
        "joints": joints,
        "bodies": {name: {"mass": m} for name, m in zip(("x", *names), masses, strict=True)},
        "springs": {name: {"stiffness": k} for name, k in zip(names, stiffness, strict=True)},
        **({"drives": {"x": drive}} if drive else {}),
    }


GIVEN = chain([30.0, 100.0], [1e7], Kv=50.0, Kp=1e5, Tn=0.01, dead_time=1.5e-4)
SIZES = st.integers(1, 40).map(lambda n: 5.0 * n)


@st.composite
def chains(draw: Any) -> dict[str, Any]:
    """Round numbers, of which many have exact eigenfrequencies; gains that are some of the mass.

    The motor feels all modes: where one moves it by 1e-13 only, double precision does not tell what it does.
    """
    n = draw(st.integers(1, 3))
    masses = [draw(SIZES) for _ in range(n + 1)]
    stiffness = [draw(st.integers(10, 50)) * 1e6 for _ in range(n)]
    Kp = sum(masses) * draw(st.integers(20, 400))
    return chain(masses, stiffness, Kv=draw(st.integers(5, 60)), Kp=Kp, Tn=0.05, dead_time=1.5e-4)


def figures(machine: dict[str, Any], damping: float) -> np.ndarray:
    (place,) = se.control(machine, damping=damping, compliances=("x.z",)).places
    (axis,), (compliance,) = place.axes, place.compliances
    margins = [x for one in (axis.velocity, axis.position) for x in (one.modulus, one.phase, one.gain)]
    limits = [limit.largest.gain if limit.largest else np.nan for limit in axis.limits]
    return np.array([*margins, *limits, axis.bandwidth, axis.velocity_error, compliance.static])


@given(chains())
@settings(max_examples=25, deadline=None)
def test_figures_are_those_of_next_to_no_damping(machine: dict[str, Any]) -> None:
    """Margins, gains and bandwidths by a ratio of 0, and by one of 1e-18: an infinite response limits nothing."""
    assert np.allclose(figures(machine, 0.0), figures(machine, TINY), rtol=1e-5, equal_nan=True)


@given(chains())
@settings(max_examples=25, deadline=None)
def test_responses_at_eigenfrequencies_are_large_or_left_out(machine: dict[str, Any]) -> None:
    """By the loops open they are numbers, of `response` NaN with a note, which neighbours do not have."""
    control = se.control(machine)
    (loops,) = loops_of(control.plants[0], control.cascades)
    poles = se.modes(machine).frequencies
    poles = poles[poles > 0]
    _, _, G = loops.responses(poles)
    _, _, beside = loops.responses(poles * (1 + 1e-5))
    assert np.isfinite(G).all() and (np.abs(G) > np.abs(beside)).all()
    found = se.response(machine, inputs=("x.tau",), outputs=("x.q",), frequencies=[*poles, *(poles * (1 + 1e-5))])
    assert np.isnan(found.values[: len(poles)]).all() and np.isfinite(found.values[len(poles) :]).all()
    assert len(found.notes) >= len(poles)


def test_a_singular_stiffness_does_not_touch_its_neighbours() -> None:
    """Two masses whose 10 rad/s is exact: before it the sign is one, behind it the other."""
    M, K = np.diag([1.0, 3.0]), np.array([[75.0, -75.0], [-75.0, 75.0]])
    w = np.array([9.0, 10.0, 11.0, 0.0])

    def stiffness(s: np.ndarray) -> np.ndarray:
        return s[:, None, None] ** 2 * M + K

    found = moved_by(stiffness, 1j * w, np.eye(2))
    assert np.array_equal(found[[0, 2]], np.linalg.inv(stiffness(1j * w[[0, 2]])))
    assert np.abs(found[1]).min() > 1e9 and np.isnan(found[3]).all()


@pytest.mark.thorough
@pytest.mark.parametrize("command", ["control", "lobes", "report", "response", "modes"])
def test_commands_answer_for_gains_that_are_given(command: str, tmp_path: Path) -> None:
    machine = tmp_path / "m.toml"
    se.write(se.read(GIVEN), machine)
    more = {"lobes": ("--direction", "s1.z", "--cutting", "1e9"), "report": ("--out", tmp_path / "report")}
    assert run(command, machine, *more.get(command, ()))


def test_a_cut_that_feels_a_mode_without_damping_is_refused() -> None:
    with pytest.raises(InputError, match=r"modes without damping: 1, the lowest at 50.33 Hz\. No depth is stable"):
        se.lobes(chain([30.0, 100.0], [1e7]), direction="s1.z", cutting=1e9)


def test_a_mode_without_damping_that_the_cut_does_not_feel_does_not_matter() -> None:
    """A slide of its own at a right angle, beside one with damping."""
    machine = chain([30.0, 100.0], [1e7])
    machine["springs"]["s1"]["damping"] = 1e3
    expected = se.lobes(machine, direction="s1.z", cutting=1e9).places[0]
    machine["joints"].append(
        {"name": "side", "antecedent": 0, "kind": "elastic", "sigma": 1, "alpha": "pi/2", "r": "y"}
    )
    machine["bodies"]["side"], machine["springs"]["side"] = {"mass": 10.0}, {"stiffness": 1e6}
    found = se.lobes(machine, direction="s1.z", cutting=1e9).places[0]
    assert np.allclose(found.depths, expected.depths, rtol=1e-9)


@pytest.mark.thorough
def test_a_mode_that_the_drive_hardly_feels_does_not_end_its_gains(tmp_path: Path) -> None:
    """The real part of its pole is rounding, of either sign."""
    machine = chain([5.0, 30.0, 5.0, 5.0, 5.0], [1e6, 1e6, 1e6, 46e6], Kv=5.0, Kp=1000.0, Tn=0.05, dead_time=1.5e-4)
    assert np.allclose(figures(machine, 0.0)[6:], figures(machine, 1e-14)[6:], rtol=1e-9)
    assert se.control(machine).places[0].growth == 0
    se.write(se.read(machine), tmp_path / "m.toml")
    assert "stable, but a motion lasts that no drive and no damping stops" in run("control", tmp_path / "m.toml").output
