"""Borders of stability at every speed: beside scans of all frequencies, for sums of modes and machines with drives."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import symoro_elastic as se
from symoro_elastic.analysis.control import lobes
from symoro_elastic.analysis.control.borders import branches, least_deep, track_eigenvalues
from symoro_elastic.analysis.control.cutting import Cut, Milling
from symoro_elastic.foundation.array_types import Array, ComplexArray
from tests.analysis.control.test_lobes import CUTTING as OF_SPINDLE
from tests.analysis.control.test_lobes import MASS, RATIO, STIFFNESS, spindle

pytest.importorskip("scipy.linalg")

CUTTING = 2e9
Eigenvalues = Callable[[Array], ComplexArray]


def least_scanned(L: Eigenvalues, period: float, top: float) -> float:
    """The most negative Re L at a border, by 50 points in each turn of e^(-i w T) and bisection.

    Where turns are many, after those next to the least Re L only frequencies with lower Re L are scanned.
    """
    if top * period < 1000:
        return scanned(L, period, 1e-4, top, 40_000)
    f = np.unique(np.concatenate([np.geomspace(1e-3, top, 30_000), np.linspace(1e-3, top, 30_000)]))
    x = L(f).real.min(axis=1)
    middle = f[x.argmin()]
    best = scanned(L, period, max(middle - 2 / period, f[0]), middle + 2 / period, 200)
    lower = np.flatnonzero(x < 0.99 * best)
    ends = zip(f[np.maximum(lower - 1, 0)], f[np.minimum(lower + 1, len(f) - 1)], strict=True)
    return min([best, *(scanned(L, period, low, high, 200) for low, high in ends)])


def scanned(L: Eigenvalues, period: float, low: float, high: float, points: int) -> float:
    f = np.linspace(low, high, int((high - low) * period * 50) + points)
    least = 0.0
    for branch in track_eigenvalues(L(f)).T:
        products = (1 - np.exp(-2j * np.pi * f * period)) * branch
        k = np.flatnonzero((products.imag[:-1] * products.imag[1:] < 0) & (products.real[:-1] < 0))
        if len(k):
            least = min(least, bisected(L, period, f[k], f[k + 1], branch[k]))
    return least


def bisected(L: Eigenvalues, period: float, low: Array, high: Array, near: ComplexArray) -> float:
    def at(f: Array) -> tuple[ComplexArray, ComplexArray]:
        values = L(f)
        value = np.take_along_axis(values, np.abs(values - near[:, None]).argmin(axis=1)[:, None], axis=1)[:, 0]
        return (1 - np.exp(-2j * np.pi * f * period)) * value, value

    sign = np.sign(at(low)[0].imag)
    for _ in range(55):
        middle = (low + high) / 2
        is_left = np.sign(at(middle)[0].imag) == sign
        low, high = np.where(is_left, middle, low), np.where(is_left, high, middle)
    product, value = at((low + high) / 2)
    is_border = (product.real < 0) & (np.abs(product.imag) < 1e-6 * np.abs(product))
    return float(value.real[is_border].min(initial=0.0))


def modal(frequencies: list[float], ratios: list[float], shares: list[float]) -> Eigenvalues:
    """L of modes whose shares have either sign, as those of a force across the thickness of the chip."""
    w, zeta, share = (np.array(x)[:, None] for x in (2 * np.pi * np.array(frequencies), ratios, shares))

    def L(f: Array) -> ComplexArray:
        s = 2j * np.pi * f
        found: ComplexArray = (share * w**2 / (s * s + 2 * zeta * w * s + w**2)).sum(axis=0)[:, None]
        return found

    return L


def grid_of(frequencies: list[float], ratios: list[float], top: float) -> Array:
    around = [f * (1 + z * np.linspace(-4, 4, 17)) for f, z in zip(frequencies, ratios, strict=True)]
    return np.unique(np.concatenate([np.geomspace(1e-3, top, 1200), *around]))


SHARES = st.floats(-1, -0.05) | st.floats(0.05, 1)
MODES = st.lists(st.tuples(st.floats(20.0, 2000.0), st.floats(2e-3, 0.1), SHARES), min_size=1, max_size=4)


@given(MODES, st.floats(np.log(5e-5), np.log(0.3)))
@settings(max_examples=60, deadline=None)
def test_borders_are_those_of_a_scan(modes: list[tuple[float, float, float]], log_period: float) -> None:
    f, ratios, shares = (list(x) for x in zip(*modes, strict=True))
    L, period = modal(f, ratios, shares), float(np.exp(log_period))
    top = 4 * max(f) + 2 / period
    found = least_deep(branches(L, grid_of(f, ratios, top)), np.array([period])).reals[0]
    assert found == pytest.approx(least_scanned(L, period, top), rel=1e-9)


@pytest.mark.sampled(5)
@pytest.mark.parametrize("beyond", [1e-3, 1e-5, -1e-5])
def test_a_pair_of_borders_between_two_frequencies_is_seen(beyond: float) -> None:
    """Between a mode and a zero of L, where waves between two teeth turn back just above a whole number, or below."""
    L = modal([100.0, 140.0], [0.01, 0.012], [1.0, 0.3])
    fine = np.linspace(105.0, 126.0, 40_001)
    lag = np.angle(-L(fine)[:, 0]) / np.pi + 0.5
    low, high = 0.02, 0.05
    for _ in range(45):
        middle = (low + high) / 2
        low, high = (middle, high) if (fine * middle - lag).max() < 3 + beyond else (low, middle)
    found = least_deep(branches(L, np.linspace(105.0, 126.0, 30)), np.array([high])).reals[0]
    assert found == pytest.approx(scanned(L, high, 105.0, 126.0, 400_000), rel=1e-9)
    assert (found < 0) == (beyond > 0)


def planar(seed: int, dead_time: float = 1e-4) -> dict[str, Any]:
    """A slide and an arm that turns on it, three springs, tool beyond; drives of both motors."""
    draw = np.random.default_rng(seed)

    def between(low: float, high: float) -> float:
        return float(np.exp(draw.uniform(np.log(low), np.log(high))))

    stiffness = {"sx": between(2e7, 2e8), "sb": between(1e5, 1e6), "arm": between(1e5, 1e6)}
    return {
        "name": "planar",
        "joints": [
            {"name": "x", "kind": "motor", "sigma": 1, "gamma": "pi/2", "alpha": "pi/2", "r": "qx"},
            {"name": "sx", "kind": "elastic", "sigma": 1, "r": "dx"},
            {"name": "b", "kind": "motor", "sigma": 0, "alpha": "-pi/2", "theta": "qb + 0.7"},
            {"name": "sb", "kind": "elastic", "sigma": 0, "theta": "db"},
            {"name": "arm", "kind": "elastic", "sigma": 0, "d": between(0.2, 0.6), "theta": "da"},
            {"name": "tool", "kind": "fixed", "sigma": 2, "d": between(0.1, 0.4)},
        ],
        "bodies": {
            "sx": {"mass": between(20, 80)},
            "sb": {"mass": between(5, 30), "center_of_mass": [0.1, 0.02, 0], "inertia": [0.4, 0.4, between(0.1, 0.5)]},
            "arm": {"mass": between(2, 10), "center_of_mass": [0.15, 0, 0], "inertia": [0.1, 0.1, between(0.02, 0.1)]},
        },
        "springs": {name: {"stiffness": k, "damping": k * between(1e-5, 6e-5)} for name, k in stiffness.items()},
        "motors": {"x": {"rotor_inertia": 1e-3, "ratio": "2*pi/0.01"}, "b": {"rotor_inertia": 1e-4, "ratio": 100}},
        "drives": {
            name: {"Kv": 30.0, "Kp": Kp, "Tn": 0.01, "dead_time": dead_time, "current": {"lag": 2e-4}}
            for name, Kp in (("x", 5e4), ("b", 500.0))
        },
    }


def eigenvalues_of(machine: dict[str, Any], cut: Cut) -> Eigenvalues:
    """Those of -W Phi, from the linearization and the laws of the drives, both of them on their motors."""
    linear = se.linearize(machine, inputs=[], outputs=list(dict.fromkeys(cut.outputs)))
    names = [*dict.fromkeys(cut.outputs)]
    drives = machine.get("drives", {})

    def L(f: Array) -> ComplexArray:
        s = 2j * np.pi * f[:, None, None]
        Z = s * s * linear.M + s * linear.D + linear.K
        for row, one in zip(linear.motors, drives.values(), strict=True):
            C = one["Kp"] * (1 + 1 / (one["Tn"] * s)) * np.exp(-s * one["dead_time"]) / (1 + one["current"]["lag"] * s)
            Z = Z + C * (one["Kv"] + s) * np.outer(row, row)
        forces, rows = (np.array([linear.Cq[names.index(x)] for x in of]) for of in (cut.forces, cut.deflections))
        found: ComplexArray = np.linalg.eigvals(-cut.factors()[0] @ (rows @ np.linalg.solve(Z, forces.T[None] + 0j)))
        return found

    return L


def cut_options(cut: Cut) -> dict[str, Any]:
    options = {"direction": cut.direction, "cutting": cut.coefficient, "teeth": cut.teeth}
    if not cut.milling:
        return {**options, "thickness": cut.thickness}
    one = cut.milling
    return {**options, "across": one.across, "radial": one.radial, "immersion": one.immersion, "down": one.down}


CUTS = {
    "turning": Cut(CUTTING, 1, "tool.x", "tool.x"),
    "across": Cut(CUTTING, 1, "tool.x", "tool.y"),
    "teeth": Cut(CUTTING, 4, "tool.y", "tool.y"),
    "milling": Cut(CUTTING, 3, "tool.x", "tool.x", Milling("tool.y", 6e8, 0.4, True)),
}
SPEEDS = [1.0, 40.0, 2500.0, 60_000.0]


@pytest.mark.sampled(80)
@pytest.mark.parametrize(
    ("cut", "seed", "dead_time"),
    [
        ("turning", 0, 1e-4),
        ("across", 6, 4e-5),
        ("milling", 4, 1e-4),
        *(pytest.param(cut, seed, 4e-5, marks=pytest.mark.thorough) for cut in CUTS for seed in range(4)),
    ],
)
def test_depths_under_drives_are_those_of_a_scan(cut: str, seed: int, dead_time: float) -> None:
    """From one turn per minute on: within 1e-9, and never infinite above the least depth."""
    machine, one = planar(seed, dead_time), CUTS[cut]
    L = eigenvalues_of(machine, one)
    for speed in SPEEDS:
        (place,) = se.lobes(machine, speeds=(speed, speed, 1), **cut_options(one)).places
        expected = -1 / (2 * CUTTING * least_scanned(L, one.period(speed), 12_000.0 + 2 / one.period(speed)))
        assert place.depths[0] == pytest.approx(expected, rel=1e-9), speed
        assert place.least * (1 - 1e-12) <= place.depths[0] < np.inf


@pytest.mark.sampled(5)
@pytest.mark.parametrize("speed", [1.0, 2.0, 5.0])
def test_two_modes_at_low_speeds(speed: float) -> None:
    """Springs and masses in series: some thousand waves between two teeth, where limits were infinite."""
    machine = spindle(behind=2 * RATIO * np.sqrt(3 * MASS * STIFFNESS))
    machine["bodies"]["head"]["mass"], machine["springs"]["head"]["stiffness"] = 3 * MASS, STIFFNESS
    cut = Cut(OF_SPINDLE, 1, "tool.z", "tool.z")
    (place,) = se.lobes(machine, speeds=(speed, speed, 1), **cut_options(cut)).places
    expected = -1 / (2 * OF_SPINDLE * least_scanned(eigenvalues_of(machine, cut), 60 / speed, 5000.0))
    assert place.depths[0] == pytest.approx(expected, rel=1e-9)
    assert place.least <= place.depths[0] < place.least * (1 + 1e-3)


@pytest.mark.thorough
def test_few_responses_are_computed(monkeypatch: pytest.MonkeyPatch) -> None:
    """Some thousand for the machine, and 30 a speed, however low: turns of e^(-i w T) are not counted."""
    counted, eigenvalues = [0], lobes._Tool.eigenvalues

    def counting(tool: Any, frequencies: Array) -> ComplexArray:
        counted[0] += len(frequencies)
        return eigenvalues(tool, frequencies)

    monkeypatch.setattr(lobes._Tool, "eigenvalues", counting)
    numbers = []
    for count in (1, 200):
        counted[0] = 0
        se.lobes(planar(0), speeds=(0.1, 20_000.0, count), **cut_options(CUTS["turning"]))
        numbers.append(counted[0])
    assert numbers[0] < 4500 and numbers[1] - numbers[0] < 30 * 200


@pytest.mark.thorough
def test_a_minus_turns_the_sense() -> None:
    """Of the force and of the chip: both are the cut again, one of them the cut with the opposite response."""
    given = {"cutting": CUTTING, "speeds": (3000.0, 3000.0, 1)}
    plain, both, one = (
        se.lobes(planar(0), direction=direction, thickness=thickness, **given).places[0]
        for direction, thickness in (("tool.x", "tool.x"), ("-tool.x", "- tool.x"), ("tool.x", "-tool.x"))
    )
    assert both.depths[0] == pytest.approx(plain.depths[0], rel=1e-12)
    L = eigenvalues_of(planar(0), CUTS["turning"])
    expected = -1 / (2 * CUTTING * least_scanned(lambda f: -L(f), 60 / 3000, 12_000.0))
    assert one.depths[0] == pytest.approx(expected, rel=1e-9) and one.depths[0] != plain.depths[0]
