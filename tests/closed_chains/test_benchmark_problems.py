"""Problems of the literature on multibody dynamics, from their published data to their reference solutions.

Andrews' squeezer: W. Schiehlen (ed.), Multibody Systems Handbook, 1990; data and solution at 0.03 s as in E. Hairer and
G. Wanner, Solving Ordinary Differential Equations II, VII.7. Chain of N four-bars: E. Bayo and A. Avello 1994; problem
A02 of M. Gonzalez, D. Dopico, U. Lugris, J. Cuadrado, A benchmarking system for MBS simulation software, 2006.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import symoro_elastic as se

CRANK, ROCKER = {"antecedent": 0, "kind": "motor", "sigma": 0}, {"antecedent": 0, "kind": "passive", "sigma": 0}
TORQUE, STIFFNESS, LENGTH_AT_REST = 0.033, 4530.0, 0.07785
PIVOT_A, PIVOT_B, ANCHOR = (-0.06934, -0.00227), (-0.03635, 0.03273), (0.014, 0.072)
ATTACHED = 0.018, 0.02
START = {
    "beta": -0.0617138900142764496,
    "Theta": 0.0,
    "gam": 0.455279819163070380,
    "Phi": 0.222668390165885885,
    "delta": 0.487364979543842550,
    "Omega": -0.222668390165885885,
    "eps": 1.23054744454982119,
}
AT_END = {"beta": 15.81077119629904, "gam": 0.04082224013073101, "delta": 0.5244099658805304, "eps": 1.048080741042263}
"""Variables of bodies that turn about fixed pivots, at 0.03 s, rad."""


def squeezer() -> dict[str, Any]:
    """Seven bodies in a plane: a four-bar with an output spring, and two dyads on its coupler."""
    (a, at_a), (b, at_b) = ((math.hypot(*p), math.atan2(p[1], p[0])) for p in (PIVOT_A, PIVOT_B))

    def body(mass: float, inertia: float, x: float, y: float = 0.0) -> dict[str, Any]:
        return {"mass": mass, "center_of_mass": [x, y, 0], "inertia": [0, 0, inertia]}

    def on_pivot(row: dict[str, Any], distance: float, angle: float, theta: str) -> dict[str, Any]:
        return {**row, "gamma": angle, "d": distance, "theta": f"{theta} - {angle!r}"}

    passive = {"kind": "passive", "sigma": 0}
    joints = [
        {"name": "K1", **CRANK, "theta": "beta"},
        {"name": "K2", "antecedent": "K1", **passive, "d": 0.007, "theta": "Theta"},
        {"name": "K3", **on_pivot(CRANK, b, at_b, "gam - pi/2")},
        {"name": "K5", **on_pivot(ROCKER, a, at_a, "delta")},
        {"name": "K4", "antecedent": "K5", **passive, "d": 0.04, "theta": "Phi - pi/2"},
        {"name": "K7", **on_pivot(ROCKER, a, at_a, "eps - pi/2")},
        {"name": "K6", "antecedent": "K7", **passive, "d": 0.04, "theta": "Omega + pi/2"},
    ]
    loops = {}
    for body_of_loop, length, variables in (
        ("K3", 0.035, "Theta gam"),
        ("K4", 0.02, "delta Phi"),
        ("K6", 0.02, "eps Omega"),
    ):
        pin, end, names = f"pin_{body_of_loop}", f"end_{body_of_loop}", variables.split()
        joints.append(
            {"name": pin, "antecedent": body_of_loop, "kind": "cut", "sigma": 0, "d": length, "theta": f"turn_{pin}"}
        )
        joints.append({"name": end, "antecedent": "K2", "kind": "fixed", "sigma": 2, "d": -0.028})
        start = {name: START[name] for name in dict.fromkeys(("beta", "Theta", *names))}
        loops[f"loop_{body_of_loop}"] = {"cut": pin, "meets": end, "dependent": names, "start": start}
    bodies = {
        "K1": body(0.04325, 2.194e-6, 0.00092),
        "K2": body(0.00365, 4.410e-7, -0.0115),
        "K3": body(0.02373, 5.255e-6, 0.01874, 0.01043),
        "K4": body(0.00706, 5.667e-7, 0.02 - 0.01421),
        "K5": body(0.07050, 1.169e-5, 0.02308, 0.00916),
        "K6": body(0.00706, 5.667e-7, 0.02 - 0.01421),
        "K7": body(0.05498, 1.912e-5, 0.01228, 0.00449),
    }
    return {"name": "squeezer", "joints": joints, "loops": loops, "bodies": bodies}


def torque_of_spring(gam: float) -> float:
    """Torque on body 3 of the spring between a point of it and an anchor."""
    c, d = ATTACHED
    x, y = d * math.cos(gam) + c * math.sin(gam), d * math.sin(gam) - c * math.cos(gam)
    to_x, to_y = x + PIVOT_B[0] - ANCHOR[0], y + PIVOT_B[1] - ANCHOR[1]
    length = math.hypot(to_x, to_y)
    pull = -STIFFNESS * (length - LENGTH_AT_REST) / length
    return pull * (to_y * x - to_x * y)


@pytest.mark.thorough
def test_the_squeezer_ends_where_the_reference_does() -> None:
    """Nine digits after two and a half turns of the crank; the reference and our own convergence agree no further."""
    integrate = pytest.importorskip("scipy.integrate")
    model = se.load(squeezer(), "direct_dynamics", "dependent_coordinates")
    joints = ("beta", "Theta", "gam", "delta", "Phi", "eps", "Omega")

    def at(beta: float) -> dict[str, float]:
        return dict(zip(joints, model.dependent_coordinates([beta]).tolist(), strict=True))

    for name, value in at(START["beta"]).items():
        assert value == pytest.approx(START[name], abs=1e-14)

    def rates(_: float, state: np.ndarray) -> list[float]:
        beta, rate = state
        tau = [TORQUE, torque_of_spring(at(beta)["gam"])]
        return [rate, model.direct_dynamics([beta], [rate], tau)[0]]

    found = integrate.solve_ivp(rates, (0, 0.03), [START["beta"], 0], method="DOP853", rtol=1e-12, atol=1e-12)
    end = at(found.y[0, -1])
    for name, value in AT_END.items():
        assert end[name] == pytest.approx(value, abs=5e-9)


def windows(count: int) -> dict[str, Any]:
    """Rods of 1 m and 1 kg: `count` parallelograms side by side."""
    rod = {"mass": 1, "center_of_mass": [0.5, 0, 0], "inertia": [0, 1 / 12, 1 / 12]}
    joints, loops, bodies = [{"name": "A0", **CRANK, "theta": "phi"}], {}, {"A0": rod}
    for k in range(1, count + 1):
        joints += [
            {"name": f"B{k}", "antecedent": f"A{k - 1}", "kind": "passive", "sigma": 0, "d": 1, "theta": f"b{k}"},
            {"name": f"A{k}", **ROCKER, "d": k, "theta": f"a{k}"},
            {"name": f"pin{k}", "antecedent": f"B{k}", "kind": "cut", "sigma": 0, "d": 1, "theta": f"c{k}"},
            {"name": f"end{k}", "antecedent": f"A{k}", "kind": "fixed", "sigma": 2, "d": 1},
        ]
        before = {f"a{k - 1}": 1.5} if k > 1 else {}
        start = {"phi": 1.5, **before, f"b{k}": -1.5, f"a{k}": 1.5}
        loops[f"window{k}"] = {"cut": f"pin{k}", "meets": f"end{k}", "start": start}
        bodies |= {f"B{k}": rod, f"A{k}": rod}
    return {"name": "windows", "gravity": [0, -9.81, 0], "joints": joints, "loops": loops, "bodies": bodies}


@pytest.mark.parametrize("count", [2, pytest.param(40, marks=pytest.mark.thorough)])
def test_a_chain_of_four_bars_is_a_pendulum(count: int) -> None:
    """At every position, flat ones too, where other formulations gain freedoms: 13 products, however long it is."""
    model = se.load(windows(count), "direct_dynamics")
    inertia, weight = (count + 1) / 3 + count, 9.81 * ((count + 1) / 2 + count)
    for phi in (math.pi / 2, 0.3, 0.0, -2.0, math.pi):
        expected = -weight / inertia * math.cos(phi)
        assert model.direct_dynamics([phi], [0.7], [0.0])[0] == pytest.approx(expected, rel=1e-14, abs=1e-14)
    assert "13x " in model.direct_dynamics.__doc__
