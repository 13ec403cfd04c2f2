"""Libraries on the same motion and the same right side: evaluations and time for an error of the tool of 1e-6 m.

50 ms of the two-axis machine under servos, springs x1 and x1e4. scipy's DOP853, Radau, BDF, LSODA and CVODE's BDF call
generated numpy from Python; "in C" is the time of these evaluations alone in generated C. Implicit ones are given the
generated Jacobian. MuJoCo integrates the same machine by its own model in a loop of C; its tolerance is 1e-5 m.
"""

from __future__ import annotations

import importlib.util
import time
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from symoro_elastic.analysis.simulation.reference_motion import Reference
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.numerics.verification.implementations import numpy_model
from tests.analysis.simulation.with_parameters import StepsWithParameters
from tests.benchmarks.scene_machines import Tool, stiffer_tool, tool_moves
from tests.benchmarks.scene_stiffness import Search
from tests.benchmarks.tables import print_table

ERROR, OF_MUJOCO = 1e-6, 1e-5
TOLERANCES = (1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10)
MOST_EVALUATIONS, MOST_STEPS = 40_000, 400_000
STIFFER = (1.0, 1e4)
DAMPING = 0.0
Row = dict[str, Any]


class TooMany(Exception):
    """More evaluations than are waited for."""


class System:
    """y' = f(t, y) under servos, y = [q, qd], and its Jacobian."""

    def __init__(self, reference: Reference) -> None:
        assert reference.servo is not None
        self.reference, self.evaluations, self.jacobians = reference, 0, 0
        machine = reference.machine
        self.model = numpy_model(machine, ("direct_dynamics", "linearization"))
        self.motors = list(machine.motor_entries)
        self.kp, self.kd = reference.servo
        self.y = np.concatenate([reference.start.q, reference.start.qd])

    def rate(self, t: float, y: Array) -> Array:
        self.evaluations += 1
        if self.evaluations > MOST_EVALUATIONS:
            raise TooMany
        q, v = np.split(np.asarray(y), 2)
        return np.concatenate([v, self.model.direct_dynamics(q, v, self._torques(t, q, v))])

    def _torques(self, t: float, q: Array, v: Array) -> Array:
        wanted, moving, _ = (x[0] for x in self.reference.at(np.array([t])))
        servo = self.kp * (wanted - q[self.motors]) + self.kd * (moving - v[self.motors])
        return np.asarray(self.reference.start.tau[self.motors] + servo)

    def jacobian(self, t: float, y: Array) -> Array:
        self.jacobians += 1
        q, v = np.split(np.asarray(y), 2)
        M, D, K = self.model.linearization(q, v, self.model.direct_dynamics(q, v, self._torques(t, q, v)))
        K, D, n = K.copy(), D.copy(), len(q)
        K[self.motors, self.motors] += self.kp
        D[self.motors, self.motors] += self.kd
        found = np.zeros((2 * n, 2 * n))
        found[:n, n:] = np.eye(n)
        found[n:] = -np.linalg.solve(M, np.hstack([K, D]))
        return found


def of_scipy(method: str, system: System, tolerance: float) -> tuple[Array, Array]:
    from scipy.integrate import solve_ivp

    given = {"jac": system.jacobian} if method in ("Radau", "BDF") else {}
    span = (0.0, system.reference.duration)
    found = solve_ivp(
        system.rate, span, system.y, method, np.linspace(*span, 201), rtol=tolerance, atol=1e-2 * tolerance, **given
    )
    if not found.success:
        raise TooMany
    return found.t, found.y.T


def of_cvode(order: int) -> Callable[[System, float], tuple[Array, Array]]:
    def solved(system: System, tolerance: float) -> tuple[Array, Array]:
        from sksundae.cvode import CVODE

        def rate(t: float, y: Array, out: Array) -> None:
            out[:] = system.rate(t, y)

        def jacobian(t: float, y: Array, _: Array, out: Array) -> None:
            out[:] = system.jacobian(t, y)

        solver = CVODE(
            rate,
            method="BDF",
            rtol=tolerance,
            atol=1e-2 * tolerance,
            jacfn=jacobian,
            max_order=order,
            max_num_steps=MOST_EVALUATIONS,
        )
        t = np.linspace(0.0, system.reference.duration, 201)
        found = solver.solve(t, system.y)
        if not found.success:
            raise TooMany
        return found.t, found.y

    return solved


def contestants() -> dict[str, Callable[[System, float], tuple[Array, Array]]]:
    found: dict[str, Callable[[System, float], tuple[Array, Array]]] = {
        f"scipy {name}": partial(of_scipy, name) for name in ("DOP853", "Radau", "BDF", "LSODA")
    }
    if importlib.util.find_spec("sksundae"):
        found |= {"CVODE BDF": of_cvode(5), "CVODE BDF, order 2": of_cvode(2)}
    return found


def show() -> list[Row]:
    """Print a table and return its figures."""
    tool = Tool()
    with TemporaryDirectory() as folder:
        runner = StepsWithParameters(stiffer_tool(1).with_parameters, ("w3", "rodas4", "rk4"), Path(folder))
    figures: list[Row] = []
    for times in STIFFER:
        machine = stiffer_tool(times, DAMPING)
        runner.p[:] = [machine.values[p.name] for p in runner.machine.parameters]
        search = Search(runner, tool_moves(machine.with_parameters, machine.values), tool)
        plain = tool_moves(machine.numbers)
        each = 1e3 * search.seconds("rk4", 1000) / 4000
        for row in (*_ours(search), *_libraries(plain, search, each), *_mujoco(plain, search)):
            figures.append({"stiffer": times, **row})
    rows = [
        (
            f"{one['stiffer']:g}",
            one["name"],
            f"{one['error']:.1e}",
            one["evaluations"],
            _text(one.get("ms")),
            _text(one.get("in_c")),
        )
        for one in figures
    ]
    print_table(
        "50 ms of the two-axis machine",
        ("springs times", "integrator", "error, m", "evaluations", "ms", "in C, ms"),
        rows,
    )
    return figures


def _text(ms: float | None) -> str:
    return "-" if ms is None else f"{ms:.3g}"


def _ours(search: Search) -> Iterator[Row]:
    for method, stages, error in (("w3", 4, ERROR), ("rodas4", 6, ERROR), ("rk4", 4, ERROR), ("w3", 4, OF_MUJOCO)):
        steps = search.fewest(method, error)
        if not steps:
            yield {"name": f"generated {method}", "error": np.inf, "evaluations": "too many"}
            continue
        at = ", 1e-5 m" if error == OF_MUJOCO else ""
        jacobians = f" + {steps} J" if method == "rodas4" else ""
        ms = 1e3 * search.seconds(method, steps)
        yield {
            "name": f"generated {method}{at}",
            "error": search.error(method, steps),
            "evaluations": f"{stages * steps}{jacobians}",
            "ms": ms,
            "in_c": ms,
        }


def _libraries(reference: Reference, search: Search, each: float) -> Iterator[Row]:
    """`each`: milliseconds of an evaluation in C."""
    for name, solve in contestants().items():
        row: Row = {"name": name, "error": np.inf, "evaluations": "too many"}
        for tolerance in TOLERANCES:
            system, began = System(reference), time.perf_counter()
            try:
                t, y = solve(system, tolerance)
            except TooMany:
                break
            ms, n = 1e3 * (time.perf_counter() - began), y.shape[1] // 2
            error = float(np.abs(search.tool.positions(t, y[:, :n], y[:, n:]) - search.truth).max())
            row = {
                "name": name,
                "error": error,
                "ms": ms,
                "in_c": each * system.evaluations,
                "evaluations": f"{system.evaluations}" + (f" + {system.jacobians} J" if system.jacobians else ""),
            }
            if error <= ERROR:
                break
        yield row


def _mujoco(reference: Reference, search: Search) -> Iterator[Row]:
    if not importlib.util.find_spec("mujoco"):
        return
    from tests.benchmarks.peers.mujoco_steps import INTEGRATORS, motion

    for name in INTEGRATORS:
        row: Row = {"name": f"MuJoCo {name}", "error": np.inf, "evaluations": "too many"}
        steps = 50
        while steps <= MOST_STEPS:
            seconds, t, q, qd = motion(reference, name, steps)
            error = float(np.abs(search.tool.positions(t, q, qd) - search.truth).max())
            row = {
                "name": f"MuJoCo {name}",
                "error": error,
                "evaluations": f"{steps} steps",
                "ms": 1e3 * seconds,
                "in_c": 1e3 * seconds,
            }
            if error <= OF_MUJOCO:
                break
            steps *= 2
        yield row
