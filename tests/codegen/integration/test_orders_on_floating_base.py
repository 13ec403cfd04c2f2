"""Steps on a floating base: orders against Pinocchio's free-flyer, free motions against what is conserved."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from symoro_elastic.codegen.integration.tableaus import METHODS
from symoro_elastic.codegen.targets.numpy import render_numpy
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.machine.machine import Kind, Machine, Orientation
from symoro_elastic.machine.scene import Scene
from symoro_elastic.models.packaging import trace_models
from symoro_elastic.numerics.verification.implementations import import_package
from tests.closed_chains.machines import machine as coupled_machine
from tests.codegen.integration.floating_motions import course, integrated, start, stepped
from tests.models.test_creep import creeping
from tests.models.test_floating_base import on
from tests.references.random_machines import random_machine

pytestmark = pytest.mark.sampled(5)

METHODS_ON_BASE = ("w3", "w2", "rk4", "midpoint")
DURATION = 0.08
CASES = [
    *(("quaternion", name, "_servo") for name in METHODS_ON_BASE),
    *(("quaternion", name, "_driven") for name in ("w3", "rk4")),
    *(("rotation", name, "") for name in METHODS_ON_BASE),
]


def machine(name: str) -> Machine:
    """Motors, a spring and a passive joint on a base with weight and wrenches; a differential; two bodies in space."""
    if name == "differential":
        return on(creeping(coupled_machine(name)), turned=Orientation.QUATERNION)
    kinds = (Kind.MOTOR, Kind.ELASTIC, Kind.MOTOR, Kind.PASSIVE)
    return on(random_machine(11, joints=4, kinds=kinds, massless=0, friction=False), turned=Orientation(name))


@cache
def generated(name: str) -> ModuleType:
    scene = Scene(models=("direct_dynamics", "inertia_matrix", "bias_forces", "energy"), steps=METHODS_ON_BASE)
    with TemporaryDirectory() as folder:
        return import_package(render_numpy(trace_models(machine(name), scene).package), Path(folder))


@cache
def exact(name: str, variant: str) -> Array:
    """The state at the end, with Pinocchio's inertia matrix and bias forces."""
    pinocchio: Any = pytest.importorskip("pinocchio") and pytest.importorskip("tests.references.pinocchio_model")
    described = machine(name)
    reference, at = pinocchio.FreeFlyer(described), start(described)

    def equations(R: Array, V0: Array, q: Array, qd: Array) -> tuple[Array, Array]:
        found: tuple[Array, Array] = reference.equations(pinocchio.BaseState(R, V0, np.zeros(6)), q, qd)
        return found

    return integrated(described, equations, at, variant, DURATION, course(described, at))


@pytest.mark.parametrize(("name", "method", "variant"), CASES)
def test_orders_against_pinocchio(name: str, method: str, variant: str) -> None:
    """The error of joints, pose and velocities falls by 2^p where steps are halved."""
    at, module, wanted = start(machine(name)), generated(name), exact(name, variant)
    given = course(machine(name), at)
    order = METHODS[method].order
    counts = (16, 32) if order > 2 else (64, 128)
    errors = [np.abs(stepped(module, method, variant, at, DURATION, n, given) - wanted).max() for n in counts]
    assert 1e-10 < errors[1] < errors[0] < 0.05
    assert order - 0.5 < np.log2(errors[0] / errors[1]) < order + 0.6


def test_coupled_joints_on_a_floating_base() -> None:
    """A differential, with its own models of dynamics, which other tests compare with references."""
    described, module = machine("differential"), generated("differential")
    at = replace(start(described), q=np.full(len(described.independent), 1e-3))
    given = course(described, at)

    def equations(R: Array, V0: Array, q: Array, qd: Array) -> tuple[Array, Array]:
        Q0 = np.roll(Rotation.from_matrix(R).as_quat(), 1)
        A, nothing = module.inertia_matrix(q), np.zeros(len(described.motors))
        qdd, V0d = module.direct_dynamics(q, qd, nothing, Q0, V0, np.zeros(6))
        return A, A @ np.concatenate([V0d, qdd])

    wanted = integrated(described, equations, at, "", DURATION / 4, given, 1e-10)
    errors = [np.abs(stepped(module, "w3", "", at, DURATION / 4, n, given) - wanted).max() for n in (32, 64)]
    assert 1e-8 < errors[1] < errors[0] < 0.05 and 2.5 < np.log2(errors[0] / errors[1]) < 3.6
