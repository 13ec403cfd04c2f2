"""States at the limits, `count` of each kind: the joint variables, velocities and torques of a machine."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from symoro_elastic.machine.machine import Kind, Machine
from symoro_elastic.numerics.verification.states import States

Array = NDArray[np.float64]
Draw = Callable[[Machine, int], States]


def moderate(machine: Machine, count: int, seed: int = 0) -> States:
    """Angles within pi, velocities within 2, torques within 20, accelerations within 5."""
    n, motors, rng = _joints(machine), _motors(machine), np.random.default_rng(seed)
    return _states(
        rng.uniform(-math.pi, math.pi, (count, n)),
        rng.uniform(-2, 2, (count, n)),
        rng.uniform(-20, 20, (count, motors)),
        rng.uniform(-5, 5, (count, motors)),
    )


def extreme(machine: Machine, count: int, seed: int = 0) -> States:
    """Angles to 1e8, slides to 10 m, velocities from 1e-6 to 1e6, decades evenly; torques as at moderate states."""
    slides = np.array([machine.joints[j - 1].sigma == 1 for j in machine.independent])
    n = _joints(machine)
    return changed(
        moderate(machine, count, seed),
        q=np.where(slides, decades(n, count, -3, 1, seed), decades(n, count, 0, 8, seed)),
        qd=decades(n, count, -6, 6, seed + 1),
    )


def gentle(machine: Machine, count: int, seed: int = 0) -> States:
    """Angles within 3, velocities and torques within 1: what chains of a thousand links bear."""
    n, motors, rng = _joints(machine), _motors(machine), np.random.default_rng(seed)
    return _states(
        *(rng.uniform(-size, size, (count, width)) for size, width in ((3, n), (1, n), (1, motors), (1, motors)))
    )


def quarter_turns(machine: Machine, count: int, seed: int = 0, ulps: int = 0) -> States:
    """Multiples of a quarter turn up to 1e6, as near as a double comes, or some ulps off."""
    rng = np.random.default_rng(seed)
    turns = rng.integers(-4, 5, (count, _joints(machine))) * 10 ** rng.integers(0, 6, (count, 1))
    q = turns * (math.pi / 2)
    for _ in range(ulps):
        q = np.nextafter(q, np.inf)
    return changed(moderate(machine, count, seed), q=q)


def far(machine: Machine, count: int, seed: int = 0) -> States:
    """|q| to 1e15, in every decade."""
    return changed(moderate(machine, count, seed), q=decades(_joints(machine), count, 0, 15, seed))


def fast(machine: Machine, count: int, low: float, high: float, seed: int = 0) -> States:
    """Velocities from 10^low to 10^high."""
    return changed(moderate(machine, count, seed), qd=decades(_joints(machine), count, low, high, seed))


def changed(states: States, **arrays: Array) -> States:
    """The states, some of their arrays others."""
    return states.with_blocks(**arrays)


def decades(width: int, count: int, low: float, high: float, seed: int) -> Array:
    """Numbers of either sign, their sizes spread evenly over the decades from 10^low to 10^high."""
    rng = np.random.default_rng([seed, 1])
    return 10 ** rng.uniform(low, high, (count, width)) * rng.choice([-1.0, 1.0], (count, width))


def _states(q: Array, qd: Array, tau: Array, qdd_motor: Array) -> States:
    blocks = {"q": q, "qd": qd, "tau": tau, "qdd_motor": qdd_motor, "qdd": np.zeros_like(q)}
    return States(blocks, ("",) * len(q))


def _joints(machine: Machine) -> int:
    return len(machine.independent)


def _motors(machine: Machine) -> int:
    return sum(joint.kind == Kind.MOTOR for joint in machine.joints)
