"""Fixed steps by generated code on the nonlinear machine: what predictions of their errors are held to."""

from __future__ import annotations

import tempfile
from pathlib import Path
from types import ModuleType

import numpy as np

from symoro_elastic.analysis.simulation.reference_motion import Reference
from symoro_elastic.codegen.integration.tableaus import Method, nodes_of
from symoro_elastic.codegen.targets.numpy import render_numpy
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.scene import Scene
from symoro_elastic.models.packaging import trace_models
from symoro_elastic.numerics.verification.implementations import import_package


def with_steps(machine: Machine, *methods: str) -> ModuleType:
    """The generated numpy package with steps of these methods."""
    scene = Scene(models=("geometric_model",), steps=methods)
    with tempfile.TemporaryDirectory() as folder:
        return import_package(render_numpy(trace_models(machine, scene).package), Path(folder))


def stepped_motion(module: ModuleType, method: Method, reference: Reference, steps: int) -> Array:
    """q (steps + 1, n) of a method over a motion: motors driven, or under their servos with the torque of the start."""
    h = reference.duration / steps
    q, qd = reference.start.q, reference.start.qd
    times = np.array(nodes_of(method, driven=reference.servo is None), dtype=float)
    motors = list(reference.machine.motor_entries)
    found = [q]
    for k in range(steps):
        t = (k + times) * h
        y, yd, ydd = reference.at(t)
        pushed, rates = reference.wrenches(t)
        forces = (pushed,) if reference.loaded.forces else ()
        change = (rates[0],) if reference.loaded.forces and method.name == "rodas4" else ()
        if reference.servo is None:
            jerk = (reference.jerks(t)[0],) if method.name == "rodas4" else ()
            q, qd = getattr(module, f"step_{method.name}_driven")(y, yd, ydd, *forces, *jerk, *change, h, q, qd)
        else:
            kp, kd = reference.servo
            held = np.tile(reference.start.tau[motors], (len(t), 1))
            exact = (kp * yd[0] + kd * ydd[0],) if method.name == "rodas4" else ()
            step = getattr(module, f"step_{method.name}_servo")
            q, qd = step(held, y, yd, *forces, kp, kd, *exact, *change, h, q, qd)
        found.append(q)
    return np.array(found)
