"""The corpus: what is extreme, how large the error may become there, and what a user is told."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from symoro_elastic.machine.machine import Machine
from symoro_elastic.numerics.verification.states import States
from tests.extremes import states as at
from tests.extremes.machines import (
    MASSES,
    QUARTER_TURNS,
    elastic_arm,
    general_alphas,
    gimbal,
    lever,
    links,
    massless_tip,
    nearly_parallel,
    no_stiffness,
    point_on_axis,
    series_springs,
    spindle,
)

DIRECT, INVERSE = "direct_dynamics", "inverse_dynamics"
FEW, MANY = 12, 200


@dataclass(frozen=True)
class Extreme:
    """Machine and states; no error is larger than `ulps`, or `share` times the effect of a one-ulp change of inputs.

    Errors are in units of 2^-53 of the largest entry of a result. `told` is what the documentation says of it.
    """

    name: str
    machine: Machine
    states: States
    ulps: float
    told: str
    share: float = 1.0


def stiffnesses() -> list[Extreme]:
    """Springs from none to rigid, in direct and inverse models alike."""
    told = "any stiffness from 0 on: the error is that of the other joints; a stiff spring costs the integrator only"
    machines = [(k, elastic_arm(k)) for k in (0.0, 1.0, 1e7, 1e14)]
    return [Extreme(f"stiffness {k:g}", machine, at.moderate(machine, MANY), 64, told) for k, machine in machines]


def angles() -> list[Extreme]:
    """Quarter turns, one ulp off them, and angles to 1e15: sines and cosines are those of the very double."""
    machine = elastic_arm(1000.0)
    told = "the angle is the double that is given: its ulp, 0.1 rad at 1e15, is the caller's"
    states = {
        "quarter turns": at.quarter_turns(machine, MANY),
        "an ulp off quarter turns": at.quarter_turns(machine, MANY, ulps=1),
        "angles to 1e15": at.far(machine, MANY),
    }
    return [Extreme(name, machine, some, 32, told, share=0.0) for name, some in states.items()]


def velocities() -> list[Extreme]:
    """From the smallest normal numbers to where squares still fit."""
    machine = elastic_arm(1000.0)
    told = "velocities to 1e150 square within range; beyond, results are inf or NaN, never a wrong number"
    spans = ((-300, -10), (-6, 6), (100, 150))
    return [
        Extreme(f"velocities 1e{low} to 1e{high}", machine, at.fast(machine, MANY, low, high), 64, told, share=1.5)
        for low, high in spans
    ]


def chains(n: int, count: int) -> list[Extreme]:
    """Masses along a chain: smooth and abrupt, quarter turns between axes and general angles."""
    turned = {"quarter turns": QUARTER_TURNS, "general angles": general_alphas(n)}
    return [
        Extreme(
            f"{n} links, {name}, {turns}", links(n, mass, alphas), at.gentle(links(n), count), *chain_bound(name, n)
        )
        for name, mass in MASSES.items()
        for turns, alphas in turned.items()
    ]


def chain_bound(masses: str, n: int) -> tuple[float, str]:
    """Ulps, and what a user is told, of a chain of n links; the bound of smooth chains holds to 1000 links."""
    if masses == "tip 1e6 heavier":
        return 2e6, "a tip 1e6 times heavier than the links that carry it costs six digits of the accelerations (open)"
    if masses == "1 to 1e6" and n < 60:
        return 1000, "masses that grow by more than a quarter from link to link cost a digit or two"
    return 64, "as exact as the inputs: no more than what one ulp of these changes"


def gimbals() -> list[Extreme]:
    """A gimbal without mass in its rings, an angle away from lock."""
    told = "near lock a digit is lost for each decade of the angle; at lock no result is finite"
    machine = gimbal()
    found = []
    for angle in (1e-1, 1e-4, 1e-7):
        states = at.moderate(machine, MANY)
        q = states.q.copy()
        q[:, 1] = angle
        found.append(Extreme(f"gimbal {angle:g} rad from lock", machine, at.changed(states, q=q), 200 / angle, told))
    return found


def locked_gimbal() -> tuple[Machine, States]:
    """Exactly at lock: no acceleration of the rings is determined."""
    machine = gimbal()
    states = at.moderate(machine, 4)
    return machine, at.changed(states, q=np.where(np.arange(3) == 1, 0.0, states.q))


def axes() -> list[Extreme]:
    """Two sliding springs in a row, their axes almost parallel and nothing between."""
    told = "warned of as an angle that is probably meant to be zero; a digit is lost for each decade of the angle"
    machines = [(angle, nearly_parallel(angle)) for angle in (1e-3, 1e-6, 1e-8)]
    return [
        Extreme(f"axes {angle:g} rad apart", machine, at.moderate(machine, MANY), 4 / angle, told)
        for angle, machine in machines
    ]


def levers() -> list[Extreme]:
    """A body far from all axes."""
    told = "where the arm is stretched, inertias differ by the square of the ratio: eight digits are left in the worst"
    machines = [(ratio, lever(ratio)) for ratio in (1e2, 1e5, 1e8)]
    return [
        Extreme(f"lever {ratio:g} times the gyration", machine, at.moderate(machine, MANY), 3e7, told)
        for ratio, machine in machines
    ]


def spins() -> list[Extreme]:
    """A shaft that turns a million times faster than the arm that holds it."""
    machine = spindle()
    states = at.moderate(machine, MANY)
    qd = states.qd * np.array([1, 1, 1e6])
    told = "a fast joint does not spoil the torques of slow ones: what does not depend on its velocity is found without"
    return [Extreme("fast spindle", machine, at.changed(states, qd=qd), 64, told)]


def corpus(chain_links: int = 30) -> list[Extreme]:
    """All that is judged by its error, chains of so many links among it."""
    small = [*stiffnesses(), *angles(), *velocities(), *gimbals(), *axes(), *levers(), *spins()]
    return small + chains(chain_links, FEW)


REFUSED: dict[str, tuple[Callable[[], Machine], str]] = {
    "series springs, massless body between": (
        series_springs,
        "replace the two springs by one of stiffness k1 k2/(k1 + k2)",
    ),
    "massless tip": (massless_tip, "moves no inertia; give a body beyond it inertia about this axis"),
    "point mass on the axis": (point_on_axis, "moves no inertia; give a body beyond it inertia about this axis"),
    "spring without stiffness": (no_stiffness, "an elastic joint needs a stiffness"),
}
"""Machines that no code is written for, and what the refusal says."""

WARNED: dict[str, tuple[Machine, str]] = {
    "nearly parallel axes": (nearly_parallel(1e-6), "alpha = ALPHA is 1e-06 rad off 0: taken as written")
}
"""Machines that are modelled with a warning."""

NOT_FINITE = {"NaN": math.nan, "infinity": math.inf}
