"""MuJoCo's integrators on a machine under servos, carried out in one loop of C."""

from __future__ import annotations

import ctypes
import importlib.util
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from symoro_elastic.analysis.simulation.reference_motion import Reference
from symoro_elastic.foundation.array_types import Array
from tests.benchmarks.contest import compiled
from tests.benchmarks.peers.mujoco_c import mjcf

INTEGRATORS = {"Euler": 0, "RK4": 1, "implicit": 2, "implicitfast": 3}
HERE = Path(__file__).parent


@cache
def _library() -> Any:
    found = importlib.util.find_spec("mujoco")
    assert found and found.submodule_search_locations
    folder = Path(next(iter(found.submodule_search_locations)))
    shipped = next(folder.glob("libmujoco.so*"))
    command = ["gcc", "-O3", "-march=native", "-fPIC", "-shared", f"-isystem{folder / 'include'}"]
    source = {"mujoco_steps.c": (HERE / "mujoco_steps.c").read_text(encoding="utf-8")}
    library = ctypes.CDLL(str(compiled(command, source, [str(shipped), f"-Wl,-rpath,{folder}"])))
    pointers = [ctypes.c_void_p] * 6
    library.carry_out.argtypes = [ctypes.c_char_p, ctypes.c_int, ctypes.c_double, *[ctypes.c_int] * 2, *pointers]
    library.carry_out.restype = ctypes.c_double
    return library


def motion(reference: Reference, integrator: str, steps: int) -> tuple[float, Array, Array, Array]:
    """Seconds, and t, q, qd (steps + 1, ...) of a motion."""
    import mujoco

    assert reference.servo is not None
    machine, h = reference.machine, reference.duration / steps
    t = np.arange(steps + 1, dtype=np.float64) * h
    motors = np.array(machine.motor_entries, dtype=np.intc)
    kp, kd = (np.ascontiguousarray(x) for x in reference.servo)
    y, yd, _ = reference.at(t[:-1])
    rows = np.ascontiguousarray(np.stack([y, reference.start.tau[motors] + kd * yd], axis=2))
    q = reference.start.q.copy()
    record = np.zeros((steps + 1, 2 * len(q)))
    record[0] = [*q, *reference.start.qd]
    with TemporaryDirectory() as folder:
        file = Path(folder) / "machine.mjb"
        mujoco.mj_saveModel(mujoco.MjModel.from_xml_string(mjcf(machine)), str(file))
        arrays = (x.ctypes.data for x in (motors, kp, kd, q, rows, record[1:]))
        seconds = _library().carry_out(str(file).encode(), INTEGRATORS[integrator], h, steps, len(motors), *arrays)
    assert seconds >= 0, "MuJoCo cannot read its model"
    return seconds, t, record[:, : len(q)], record[:, len(q) :]
