"""Free motions of a base over many compiled steps: Euler's body, momentum, energy, rotations that stay rotations."""

from __future__ import annotations

import ctypes
from dataclasses import replace
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from symoro_elastic.codegen.c.steps import render_runs, runs
from symoro_elastic.codegen.compile import compile_library
from symoro_elastic.codegen.integration.tableaus import METHODS, times_of
from symoro_elastic.codegen.local_names import with_own_results
from symoro_elastic.codegen.precision import DOUBLE
from symoro_elastic.codegen.targets.c import render_c, source_text
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import Base, Body, Floating, Joint, Kind, Machine, Orientation
from symoro_elastic.machine.scene import Scene
from symoro_elastic.models.packaging import trace_models
from symoro_elastic.numerics.verification.implementations import numpy_model
from tests.codegen.integration.floating_motions import FloatingState, rotation, start
from tests.compiled_models import cell, vector
from tests.generated_code import COMPILERS
from tests.models.test_floating_base import on
from tests.references.random_machines import random_machine

METHODS_ON_BASE = ("w3", "w2", "rk4", "midpoint")
ACROSS, ALONG = 0.7, 1.1
"""Moments of inertia of the symmetric body."""

pytestmark = pytest.mark.skipif(not COMPILERS, reason="no C compiler")


def machine(name: str) -> Machine:
    if name.startswith("body"):
        inertia = tuple(cell(x) for x in (ACROSS, 0, 0, ACROSS, 0, ALONG))
        floating = Floating(Orientation(name.removeprefix("body ")), body=Body(cell(3.0), vector(0, 0, 0), inertia))
        tip = Joint("tip", 0, Kind.FIXED, 2)
        return Machine("body", (tip,), base=Base(), floating=floating)
    kinds = (Kind.ELASTIC, Kind.PASSIVE, Kind.ELASTIC)
    free = random_machine(5, joints=3, kinds=kinds, massless=0, friction=False, wrenches=False)
    undamped = (replace(row, spring=replace(row.spring, damping=Formula.parse("0"))) for row in free.joints)
    return on(replace(free, joints=tuple(undamped), base=Base()), turned=Orientation.QUATERNION)


@cache
def library(name: str) -> tuple[ctypes.CDLL, str]:
    package = trace_models(machine(name), Scene(models=("direct_dynamics",), steps=METHODS_ON_BASE)).package
    text = source_text(with_own_results(package), DOUBLE)
    files = render_c(package) | render_runs(package.name, text.steps)
    with TemporaryDirectory() as folder:
        made = ctypes.CDLL(str(compile_library(files, Path(folder), flags=("-O1",))))
    assert [run.kept for run in runs(text.steps) if not run.name.endswith(("servo", "driven"))] == [()] * 4
    return made, package.name


def moved(name: str, method: str, at: FloatingState, h: float, steps: int) -> Array:
    """The states (steps, entries) of a motion without torques and wrenches: q, qd, orientation, P0, V0."""
    made, called = library(name)
    nodes = len(dict.fromkeys(times_of(METHODS[method])))
    nothing = np.zeros(6 * nodes * steps)
    state = [x.copy() for x in (at.q, at.qd, at.turned, at.P0, at.V0)]
    record, p = np.empty((steps, at.whole.size)), np.ones(100)
    arrays = [ctypes.c_void_p(x.ctypes.data) for x in (nothing, nothing, p, *state, record)]
    made[f"{called}_step_{method}_run"](ctypes.c_size_t(steps), *arrays[:2], ctypes.c_double(h), *arrays[2:])
    return record


def body_at(turned: Orientation) -> FloatingState:
    quaternion = np.array([0.5, -0.1, 0.7, 0.5])
    quaternion /= np.linalg.norm(quaternion)
    by_matrix = turned is Orientation.ROTATION
    none, V0 = np.zeros(0), np.array([0.4, -0.2, 0.3, 1.2, -0.5, 2.0])
    return FloatingState(none, none, rotation(quaternion).ravel() if by_matrix else quaternion, np.ones(3), V0)


def euler(at: FloatingState, t: float) -> tuple[Array, Array, Array]:
    """Rotation, position and V of a symmetric body in free motion, in closed form.

    L is constant; the body turns about it at |L|/A, and about its own axis at (A - C)/A w_z beside.
    """
    R, w = rotation(at.turned), at.V0[3:]
    L = R @ (np.array([ACROSS, ACROSS, ALONG]) * w)
    own = (1 - ALONG / ACROSS) * w[2]
    about_axis = Rotation.from_rotvec([0, 0, own * t]).as_matrix()
    turned = Rotation.from_rotvec(L / ACROSS * t).as_matrix() @ R @ about_axis
    speed = R @ at.V0[:3]
    return turned, at.P0 + speed * t, np.concatenate([turned.T @ speed, about_axis.T @ w])


@pytest.mark.sampled(2)
@pytest.mark.parametrize("method", METHODS_ON_BASE)
@pytest.mark.parametrize("turned", Orientation)
def test_a_symmetric_body_turns_as_euler_says(turned: Orientation, method: str) -> None:
    """Errors of the order of the method, after five turns."""
    at, duration, errors = body_at(turned), 12.0, []
    R, P, V = euler(at, duration)
    for steps in (1000, 2000):
        end = moved(f"body {turned.value}", method, at, duration / steps, steps)[-1]
        found = rotation(end[:-9]), end[-9:-6], end[-6:]
        errors.append(max(np.abs(x - y).max() for x, y in zip(found, (R, P, V), strict=True)))
    assert 1e-12 < errors[1] < 0.01
    assert METHODS[method].order - 0.4 < np.log2(errors[0] / errors[1]) < METHODS[method].order + 1.2


@pytest.mark.parametrize("turned", Orientation)
def test_a_rotation_stays_one_over_a_million_steps(turned: Orientation) -> None:
    """To rounding, at every step: it does not grow with their number."""
    at = body_at(turned)
    worst = 0.0
    for _ in range(20):
        found = moved(f"body {turned.value}", "w2", at, 1e-3, 50_000)
        at = FloatingState(at.q, at.qd, found[-1, :-9].copy(), found[-1, -9:-6].copy(), found[-1, -6:].copy())
        x = found[::100, :-9]
        lengths = np.einsum("si,si->s", x, x) - 1 if turned is Orientation.QUATERNION else orthogonality(x)
        worst = max(worst, float(np.abs(lengths).max()))
    assert 0 < worst < 3e-15


def orthogonality(x: Array) -> Array:
    R = x.reshape(-1, 3, 3)
    found: Array = np.einsum("ski,skj->sij", R, R) - np.eye(3)
    return found


def momentum(states: Array) -> Array:
    """Linear momentum, and the angular one about the origin of the world, in its axes (states, 6)."""
    model = numpy_model(machine("arm"), ("inertia_matrix",))
    q, qd, Q, P, V = np.split(states, [3, 6, 10, 13], axis=1)
    A = model.inertia_matrix(q)
    own = np.einsum("sij,sj->si", A[:, :6], np.concatenate([V, qd], axis=1))
    found = []
    for turned, place, both in zip(Q, P, own, strict=True):
        p, L = rotation(turned) @ both[:3], rotation(turned) @ both[3:]
        found.append([*p, *(L + np.cross(place, p))])
    return np.array(found)


@pytest.mark.sampled(5)
@pytest.mark.parametrize("method", METHODS_ON_BASE)
def test_momentum_stays_in_free_flight(method: str) -> None:
    """An arm of springs and a free joint: what the steps lose of it is of their order."""
    at, lost = start(machine("arm"), 3), []
    for steps in (1000, 2000):
        states = moved("arm", method, at, 1.0 / steps, steps)
        found = momentum(np.concatenate([at.whole[None], states[steps // 20 - 1 :: steps // 20]]))
        lost.append(np.abs(found - found[0]).max() / np.abs(found[0]).max())
    assert lost[1] < 1e-3 and np.log2(lost[0] / lost[1]) > METHODS[method].order - 0.5


@pytest.mark.thorough
def test_energy_stays_over_a_long_free_motion() -> None:
    """Midpoint rule, 200 000 steps without losses: the energy swings, and does not drift."""
    at = start(machine("arm"), 3)
    states = moved("arm", "midpoint", at, 5e-4, 200_000)[::50]
    q, qd, Q, P, V = np.split(states, [3, 6, 10, 13], axis=1)
    energy = numpy_model(machine("arm"), ("energy",)).energy(q, qd, Q, P, V).sum(axis=1)
    halves = np.split(energy, 2)
    swing = np.ptp(halves[0])
    assert swing < 1e-3 * energy[0] and abs(halves[1].mean() - halves[0].mean()) < 0.1 * swing
