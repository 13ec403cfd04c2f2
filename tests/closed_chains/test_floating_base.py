"""Coupled joints on a floating base: the reference moves the same body by three slides and three turns."""

from __future__ import annotations

import inspect
from dataclasses import replace
from functools import cache
from typing import Any

import mpmath
import numpy as np
import pytest
from mpmath import mpf

from symoro_elastic.machine.machine import Base, Joint, Kind, Machine
from tests.closed_chains.machines import machine, situations
from tests.closed_chains.test_models import assert_near, package_of
from tests.compiled_models import cell
from tests.models.test_floating_base import HULL, on
from tests.references import multiprecision
from tests.references.closed_chains import DIGITS, Array, State, nearest_double
from tests.references.constraint_multipliers import Multipliers
from tests.references.elimination import identity

pytestmark = pytest.mark.sampled(5)

COUPLED = ("coaxial_geared", "coupled_wrist", "differential", "geared_6r")
POSITION, RATES = [0.3, -0.2, 0.5, 0.4, 1.1, -0.7], [0.2, -0.4, 0.3, 0.6, -0.5, 0.8]
"""Of the slides and turns; the second turn keeps the others' axes apart."""


def carried(described: Machine) -> Machine:
    """The machine on a body that six passive joints carry, instead of a floating base."""
    turned = (("0", "0"), ("0", "pi/2"), ("pi/2", "pi/2"), ("0", "0"), ("0", "pi/2"), ("0", "pi/2"))
    rows = [
        Joint(f"base_{j}", j - 1, Kind.PASSIVE, int(j <= 3), f"x_base_{j}", gamma=cell(gamma), alpha=cell(alpha))
        for j, (gamma, alpha) in enumerate(turned, start=1)
    ]
    rows[-1] = replace(rows[-1], body=HULL)
    moved = (replace(joint, antecedent=joint.antecedent + len(rows)) for joint in described.joints)
    return replace(described, joints=(*rows, *moved), base=Base(described.base.gravity))


@cache
def reference(name: str) -> Multipliers:
    state = situations(name)[0].state
    moving = State([*POSITION, *state.u], [*RATES, *state.ud], state.guess)
    return Multipliers(carried(machine(name)), moving, nearest_double)


def frame_of_base(found: Multipliers, zd: Array, zdd: Array | None = None) -> Any:
    frames = multiprecision._frames(found.tree, list(found.z), list(zd), None if zdd is None else list(zdd))
    return frames[5]


def twist(frame: Any, linear: str, angular: str) -> list[Any]:
    """In axes of the base."""
    turned = frame.rotation.T
    return [*(turned @ getattr(frame, linear)), *(turned @ getattr(frame, angular))]


def acceleration_of_base(found: Multipliers, accelerations: Array) -> list[Any]:
    """V'0 in its axes, of accelerations of all own variables."""
    with mpmath.workdps(DIGITS):
        udd = accelerations[[found.chain.own.index(name) for name in found.chain.independent]]
        n = len(found.z)
        return twist(frame_of_base(found, found.zd, found.S_y[:n] @ udd + found.gam_y[:n]), "a", "wd")


def computed(name: str, model: str) -> tuple[Any, ...]:
    found, situation = reference(name), situations(name)[0]
    with mpmath.workdps(DIGITS):
        base = frame_of_base(found, found.zd)
        V0, R0 = twist(base, "v", "w"), base.rotation
    given = {
        "q": situation.state.u,
        "qd": situation.state.ud,
        "tau": situation.tau,
        "qdd_motor": situation.qdd_motor,
        "R0": R0.astype(float),
        "V0": [float(x) for x in V0],
        "f0": np.zeros(6),
    }
    function = getattr(package_of(on(replace(machine(name), base=Base(machine(name).base.gravity))), model)[0], model)
    results = function(**{key: given[key] for key in inspect.signature(function).parameters if key in given})
    return results if isinstance(results, tuple) else (results,)


@pytest.mark.parametrize("name", COUPLED)
def test_direct_dynamics(name: str) -> None:
    found = reference(name)
    accelerations = found.direct(situations(name)[0].tau)
    qdd, V0d = computed(name, "direct_dynamics")
    assert_near(name, qdd, [accelerations[found.chain.own.index(name)] for name in found.chain.independent[6:]])
    assert_near(name, V0d, acceleration_of_base(found, accelerations))


@pytest.mark.parametrize("name", COUPLED)
def test_inverse_dynamics(name: str) -> None:
    found = reference(name)
    torques, accelerations = found.inverse(situations(name)[0].qdd_motor)
    tau, qdd, V0d = computed(name, "inverse_dynamics")
    assert_near(name, tau, torques)
    assert_near(name, qdd, [accelerations[found.chain.own.index(name)] for name in found.chain.independent[6:]])
    assert_near(name, V0d, acceleration_of_base(found, accelerations))


@pytest.mark.parametrize("name", COUPLED)
def test_inertia_matrix(name: str) -> None:
    """By rates of the slides and turns: V0 = T (their rates)."""
    found = reference(name)
    (A,) = computed(name, "inertia_matrix")
    with mpmath.workdps(DIGITS):
        n, size = len(found.z), len(A)
        T = identity(size)
        columns = [twist(frame_of_base(found, column), "v", "w") for column in found.S_y[:n, :6].T]
        T[:6, :6] = np.array(columns, dtype=object).T
        by_rates = T.T @ np.array([[mpf(x) for x in row] for row in A], dtype=object) @ T
    assert_near(name, by_rates, found.inertia())
