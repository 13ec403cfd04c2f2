"""Lobes of milling: published factors and depths, borders of averaged and of turning forces, integration in time."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest

import symoro_elastic as se
from symoro_elastic.analysis.control.borders import track_eigenvalues
from symoro_elastic.analysis.control.cutting import Cut, Milling
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import InputError
from tests.analysis.control.test_lobes import CUTTING, MASS, RATIO, STIFFNESS, growth, spindle

pytest.importorskip("scipy.linalg")

RADIAL = 2e8
X, Y = "tool.z", "tool.y"


@cache
def tool() -> dict[str, Any]:
    """A mass on two springs at 60 degrees to each other: each direction responds to the force along the other one."""
    joints = [
        {"name": "head", "kind": "elastic", "sigma": 1, "r": "x"},
        {"name": "tool", "antecedent": "head", "kind": "elastic", "sigma": 1, "alpha": "pi/3", "r": "y"},
    ]
    damping = 2 * RATIO * np.sqrt(STIFFNESS * MASS)
    springs = {name: {"stiffness": k * STIFFNESS, "damping": damping} for name, k in (("head", 1), ("tool", 1.6))}
    return {"name": "mill", "joints": joints, "bodies": {"tool": {"mass": MASS}}, "springs": springs}


def milled(**options: Any) -> Any:
    """The limits of a cut by this tool."""
    usual = {"direction": X, "across": Y, "cutting": CUTTING, "radial": RADIAL, "teeth": 2}
    return se.lobes(tool(), **{**usual, **options}).places[0]


@pytest.mark.parametrize(("immersion", "down"), [(1.0, False), (0.3, False), (0.3, True), (0.75, True)])
def test_mean_factors_as_published(immersion: float, down: bool) -> None:
    """Altintas and Budak 1995, equation 20: N/(2 pi) alpha, alpha_xx = [cos 2 phi - 2 k phi + k sin 2 phi]/2, ..."""
    milling = Milling(Y, RADIAL, immersion, down)
    first, last = milling.angles
    k = RADIAL / CUTTING

    def alpha(phi: float) -> Array:
        c, s = np.cos(2 * phi), np.sin(2 * phi)
        return np.array(
            [[c - 2 * k * phi + k * s, -s - 2 * phi + k * c], [-s + 2 * phi + k * c, -c - 2 * k * phi - k * s]]
        )

    found = Cut(CUTTING, 3, X, X, milling).factors()[0]
    # The force is K b/2 [A] Delta there, K b W Delta here.
    assert found == pytest.approx(3 / (2 * np.pi) * (alpha(last) - alpha(first)) / 2 / 2, rel=1e-12, abs=1e-15)
    swept = np.arccos(1 - 2 * immersion)
    assert last - first == pytest.approx(swept) and (last == np.pi if down else first == 0)


@pytest.mark.thorough
def test_factors_of_parts_are_those_of_teeth_at_their_angles() -> None:
    cut = Cut(CUTTING, 3, X, X, Milling(Y, RADIAL, 0.4, True))
    first, last = cut.milling.angles if cut.milling else (0, 0)
    phi = 2 * np.pi / 3 * (np.arange(600_000) + 0.5) / 600_000
    direct = np.zeros((6, 2, 2))
    for j in range(3):
        at = phi + j * 2 * np.pi / 3
        rho, tau = np.array([np.sin(at), np.cos(at)]), np.array([np.cos(at), -np.sin(at)])
        each = -np.einsum("ik,jk,k->kij", tau + RADIAL / CUTTING * rho, rho, (at >= first) & (at <= last))
        direct += each.reshape(6, -1, 2, 2).mean(axis=1)
    assert cut.factors(6) == pytest.approx(direct, abs=1e-5)
    assert cut.factors(6).mean(axis=0) == pytest.approx(cut.factors()[0], abs=1e-14)


@pytest.mark.thorough
def test_semi_discretization_of_the_published_example() -> None:
    """Insperger and Stepan's mass at 12 000 turns per minute, one tooth: depths of theirs at 40 and 160 intervals.

    Forces have one direction, so the depth of the lobes is exact: with means of two values 8.8 % and 0.5 % are the
    error of their intervals, which falls with the square; with polynomials it is 0.4 % and 0.0016 %.
    """
    solve = pytest.importorskip("scipy.optimize").brentq
    given = {"direction": "tool.z", "cutting": CUTTING, "speeds": (12_000, 12_000, 1)}
    for intervals, depth, error in ((40, 5.89046e-5, 4e-3), (160, 5.44411e-5, 2e-5)):
        theirs = solve(lambda b: growth(spindle(), b, 12_000, intervals) - 1, 4e-5, 7e-5, xtol=1e-13)  # noqa: B023
        assert theirs == pytest.approx(depth, abs=1e-10)
        (place,) = se.lobes(spindle(), intervals=intervals, **given).places
        assert place.periodic == pytest.approx(place.depths, rel=error)


@pytest.mark.thorough
def test_errors_of_intervals_fall_with_their_fourth_power() -> None:
    """At 5000 to 20 000 turns per minute, up to 11 waves between two teeth: 0.6 % at 80 intervals, 0.04 % at 160."""
    given = {"direction": "tool.z", "cutting": CUTTING, "speeds": (5_000, 20_000, 4)}
    errors = []
    for intervals in (80, 160):
        (place,) = se.lobes(spindle(), intervals=intervals, **given).places
        assert place.periodic is not None
        errors.append(np.abs(place.periodic / place.depths - 1))
    assert errors[0].max() < 7e-3 and errors[1].max() < 5e-4
    assert (errors[0] / errors[1] > 12).all()


def test_a_note_says_where_the_mean_of_forces_does_not_do() -> None:
    given = {"direction": X, "across": Y, "cutting": CUTTING, "radial": RADIAL, "speeds": (9e3, 9e3, 1)}
    notes = [se.lobes(tool(), teeth=teeth, immersion=share, **given).notes for teeth, share in ((2, 0.1), (8, 1.0))]
    assert "give --intervals" in notes[0][-1] and notes[1] == ()


@pytest.mark.thorough
@pytest.mark.parametrize(("immersion", "down"), [(1.0, False), (0.5, True)])
def test_the_averaged_cut_is_at_its_border(immersion: float, down: bool) -> None:
    """det(I - K b (1 - e^(-i w T)) W Phi) = 0 at the depth and wave; no depth below has such a frequency."""
    speed, teeth = 9_000.0, 2
    place = milled(speeds=(speed, speed, 1), immersion=immersion, down=down)
    linear = se.linearize(tool(), outputs=[X, Y])
    W = Cut(CUTTING, teeth, X, X, Milling(Y, RADIAL, immersion, down)).factors()[0]

    def determinant(f: Array, depth: float) -> Any:
        s = 2j * np.pi * f[:, None, None]
        moved = linear.Cq[:2] @ np.linalg.solve(s * s * linear.M + s * linear.D + linear.K, linear.Cq[:2].T[None])
        late = 1 - np.exp(-s * 60 / (teeth * speed))
        return np.linalg.det(np.eye(2) - CUTTING * depth * late * (W @ moved))

    assert abs(determinant(place.waves, place.depths[0])[0]) < 1e-9
    frequencies = np.linspace(1, 4000, 400_001)
    for share in (0.2, 0.6, 0.97):  # stable below: the curve of the determinant does not turn around zero
        angles = np.unwrap(np.angle(determinant(frequencies, share * place.depths[0])))
        assert abs(angles[-1] - angles[0]) < np.pi / 2
    angles = np.unwrap(np.angle(determinant(frequencies, 1.03 * place.depths[0])))
    assert abs(angles[-1] - angles[0]) == pytest.approx(2 * np.pi, abs=0.3)
    assert place.least <= place.depths[0]


@pytest.mark.thorough
def test_influences_in_milling_are_slopes_of_the_least_depth() -> None:
    step = 1e-4
    given = milled(speeds=(9e3, 9e3, 1))
    names = [name for name, x in given.strongest if abs(x) > 1e-3]
    assert {"head.stiffness", "tool.stiffness", "tool.mass"} < {*names}
    values = se.linearize(tool()).motion.parameters
    for name in names:
        low, high = (milled(speeds=(9e3, 9e3, 1), values={name: values[name] * x}).least for x in (1 - step, 1 + step))
        assert given.influences[name] == pytest.approx(np.log(high / low) / (2 * step), rel=1e-5)


def test_eigenvalues_are_followed_through_a_crossing() -> None:
    t = np.linspace(-1, 1, 200)
    lines = np.stack([t + 0.2j, -t - 0.1j], axis=1)
    shuffled = np.where(np.random.default_rng(5).random(200)[:, None] < 0.5, lines, lines[:, ::-1])
    found = track_eigenvalues(shuffled)
    assert np.array_equal(found, lines if found[0, 0] == lines[0, 0] else lines[:, ::-1])


def integrated(depths: Array, speeds: Array, cuts: list[Cut], steps: int, periods: int) -> Array:
    """Growth of the deflection per tooth of delayed equations in time by Runge-Kutta 4, forces at their angles.

    Delayed values between steps are cubic. The factors are evaluated at each instant.
    """
    linear = se.linearize(tool(), outputs=[X, Y])
    C, inverse, teeth = linear.Cq[:2], np.linalg.inv(linear.M), cuts[0].teeth
    h = 60 / (teeth * speeds) / steps
    entry, leave = np.array([cut.milling.angles for cut in cuts if cut.milling]).T
    ratio = np.array([cut.milling.radial / CUTTING for cut in cuts if cut.milling])

    def factors(share: float) -> Array:
        found = np.zeros((len(depths), 2, 2))
        for j in range(teeth):
            phi = 2 * np.pi / teeth * (share + j)
            rho, tau = np.array([np.sin(phi), np.cos(phi)]), np.array([np.cos(phi), -np.sin(phi)])
            each = -(tau + ratio[:, None] * rho)[:, :, None] * rho
            found += np.where(((phi >= entry) & (phi <= leave))[:, None, None], each, 0.0)
        return found * (CUTTING * depths)[:, None, None]

    W = [factors(k / (2 * steps)) for k in range(2 * steps)]

    def rate(q: Array, v: Array, k: int, late: Array) -> Array:
        force = np.einsum("kij,kj->ki", W[k % (2 * steps)], q @ C.T - late)
        return (force @ C - q @ linear.K - v @ linear.D) @ inverse

    q = np.random.default_rng(26).normal(size=(len(depths), len(C[0])))
    v = np.zeros_like(q)
    past = [(np.zeros((len(depths), 2)), np.zeros((len(depths), 2)))] * steps
    sizes = np.zeros((periods, len(depths)))
    c, d = h[:, None], h[:, None] / 2
    for n in range(periods * steps):
        (y0, r0), (y1, r1) = past[n], past[n + 1]
        middle = (y0 + y1) / 2 + c * (r0 - r1) / 8
        k = 2 * (n % steps)
        a1 = rate(q, v, k, y0)
        a2 = rate(q + d * v, v + d * a1, k + 1, middle)
        a3 = rate(q + d * (v + d * a1), v + d * a2, k + 1, middle)
        a4 = rate(q + c * (v + d * a2), v + c * a3, k + 2, y1)
        past.append((q @ C.T, v @ C.T))
        q, v = q + c * (v + c / 6 * (a1 + a2 + a3)), v + c / 6 * (a1 + 2 * a2 + 2 * a3 + a4)
        sizes[n // steps] += (q @ C.T).__pow__(2).sum(axis=1)
    early, last = sizes[periods // 4 : periods // 2].sum(axis=0), sizes[3 * periods // 4 :].sum(axis=0)
    return np.asarray(np.log(last / early) / 2 / (periods / 2))


@pytest.mark.thorough
def test_in_time_depths_below_die_out_and_depths_above_grow() -> None:
    """Drawn cuts, 4 % on both sides of the border by semi-discretization."""
    rng = np.random.default_rng(2604)
    cuts, speeds, borders = [], [], []
    for _ in range(8):
        immersion, down, speed = float(rng.uniform(0.05, 1)), bool(rng.integers(2)), float(rng.uniform(9e3, 2.5e4))
        place = milled(speeds=(speed, speed, 1), immersion=immersion, down=down, intervals=120)
        cuts.append(Cut(CUTTING, 2, X, X, Milling(Y, RADIAL, immersion, down)))
        speeds.append(speed)
        borders.append(place.periodic[0])
    both = np.array([0.96, 1.04])[:, None] * np.array(borders)
    growth = integrated(both.ravel(), np.tile(speeds, 2), cuts * 2, 200, 120).reshape(2, -1)
    assert (growth[0] < 0).all() and (growth[1] > 0).all()


@pytest.mark.parametrize(
    ("options", "what"),
    [
        ({"across": None}, "belongs to milling"),
        ({"radial": None}, "milling needs it"),
        ({"thickness": X}, "leave it out"),
        ({"across": X}, "the feed: name an output at right angles"),
        ({"across": "tol.y"}, "across: "),
        ({"immersion": 1.5}, "immersion: 1.5 is"),
        ({"radial": np.nan}, "radial: nan"),
    ],
)
def test_millings_that_are_none_are_refused(options: dict[str, Any], what: str) -> None:
    with pytest.raises(InputError) as error:
        milled(**options)
    assert what in str(error.value)
