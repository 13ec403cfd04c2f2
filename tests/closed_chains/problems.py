"""Machines of published problems of multibody dynamics, as tables of joints.

Andrews' squeezer: W. Schiehlen (ed.), Multibody Systems Handbook, 1990; data and solution at 0.03 s as in E. Hairer and
G. Wanner, Solving Ordinary Differential Equations II, VII.7. Chain of N four-bars: E. Bayo and A. Avello 1994; problem
A02 of M. Gonzalez, D. Dopico, U. Lugris, J. Cuadrado, A benchmarking system for MBS simulation software, 2006. Its
problem A04 is Bricard's mechanism; A05 is a flyball governor, whose springs stand between points of two bodies: here a
spring holds the slider, with numbers of our own.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

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


RECTANGULAR = (1.0, 0.9, 1.1, 1.2, 0.8, 0.6**0.5)
"""Links of a rectangular Bricard mechanism, m, the last one on the ground: a1^2 + a3^2 + a5^2 = a2^2 + a4^2 + a6^2."""


def bricard(links: Sequence[float] = (1.0,) * 6, crank: float | str = "pi/2") -> dict[str, Any]:
    """Five rods of 1 kg between six hinges without offsets, neighbouring axes at right angles: one freedom.

    The last link is the ground. As it stands the rods and the ground are the six edges of a cube, and gravity acts
    along the second rod. `crank` is where the first hinge starts; the others are found from there.
    """
    passive, turns = {"kind": "passive", "sigma": 0}, ("-pi/2", "pi/2")
    joints: list[dict[str, Any]] = [{"name": "J1", **CRANK, "theta": "q1"}]
    for k in range(2, 6):
        before = {"antecedent": f"J{k - 1}", "alpha": turns[k % 2 == 0]}
        joints.append({"name": f"J{k}", **before, **passive, "d": links[k - 2], "theta": f"q{k}"})
    last = {"kind": "cut", "sigma": 0, "alpha": "pi/2", "d": links[4], "theta": "q6"}
    joints += [
        {"name": "J6", "antecedent": "J5", **last},
        {"name": "ground", "antecedent": 0, "kind": "fixed", "sigma": 2, "alpha": "pi/2", "d": -links[5]},
    ]
    names = [f"q{k}" for k in range(1, 6)]
    start = {**dict.fromkeys(names, "pi/2"), "q1": crank}
    ring = {"cut": "J6", "meets": "ground", "dependent": names[1:], "start": start}
    bodies = {
        f"J{k}": {"mass": 1, "center_of_mass": [a / 2, 0, 0], "inertia": [0, a * a / 12, a * a / 12]}
        for k, a in enumerate(links[:5], start=1)
    }
    return {"name": "bricard", "gravity": [0, 0, 9.81], "joints": joints, "loops": {"ring": ring}, "bodies": bodies}


ROD, BALL, SLIDER, TURNING = 1.0, 5.0, 2.0, 0.07
"""Masses of a governor, kg; moment of inertia of its axis with the slider, kg m2. Rods have 1 m."""


def governor(stiffness: float, damping: float, neutral: float) -> dict[str, Any]:
    """A vertical axis with two arms, a ball at the end of each, and two rods from there to a slider on a spring."""
    joints: list[dict[str, Any]] = [
        {"name": "axis", **CRANK, "theta": "psi"},
        {"name": "slider", "antecedent": "axis", "kind": "elastic", "sigma": 1, "r": "s"},
    ]
    mass, moment = ROD + BALL, ROD / 2 + BALL
    about = ROD / 3 + BALL - moment**2 / mass
    bodies: dict[str, Any] = {"axis": {"inertia": [0, 0, TURNING - 0.02]}}
    bodies["slider"] = {"mass": SLIDER, "inertia": [0.01, 0.01, 0.02]}
    loops = {}
    for side, turned in (("left", 0), ("right", "pi")):
        arm, rod, on_axis = f"arm_{side}", f"rod_{side}", {"gamma": turned, "alpha": "pi/2"}
        passive = {"kind": "passive", "sigma": 0}
        joints += [
            {"name": arm, "antecedent": "axis", **passive, **on_axis, "theta": f"a_{side} - pi/2"},
            {"name": rod, "antecedent": arm, **passive, "d": 1, "theta": f"b_{side}"},
            {"name": f"pin_{side}", "antecedent": rod, "kind": "cut", "sigma": 0, "d": 1, "theta": f"c_{side}"},
            {"name": f"eye_{side}", "antecedent": "slider", "kind": "fixed", "sigma": 2, **on_axis},
        ]
        bodies[arm] = {"mass": mass, "center_of_mass": [moment / mass, 0, 0], "inertia": [0, about, about]}
        bodies[rod] = {"mass": ROD, "center_of_mass": [0.5, 0, 0], "inertia": [0, ROD / 12, ROD / 12]}
        start = {"s": -math.sqrt(3), f"a_{side}": math.pi / 6, f"b_{side}": -math.pi / 3}
        loops[side] = {"cut": f"pin_{side}", "meets": f"eye_{side}", "start": start}
    springs = {"slider": {"stiffness": stiffness, "damping": damping, "neutral": neutral}}
    return {
        "name": "governor",
        "gravity": [0, 0, -9.81],
        "joints": joints,
        "loops": loops,
        "bodies": bodies,
        "springs": springs,
    }
