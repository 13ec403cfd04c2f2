"""Time loops in Python around a direct model: `python -m tests.benchmarks.python_loops [--json FILE] [--rounds N]`.

A 7R arm in three loops that users write: an environment of one state (controller, step, observation), SciPy's DOP853,
and a sampling predictive controller (many torques over a horizon). By backend c, by ctypes, by numpy and by Pinocchio's
binding, which has no batches. All reach the same states; the least time of all rounds counts.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from symoro_elastic.api.loaded import _by_ctypes, load
from symoro_elastic.codegen.compile import compile_package
from symoro_elastic.codegen.extension import FLAGS
from symoro_elastic.foundation.output_files import temporary_folder
from tests.benchmarks.contest import Array
from tests.benchmarks.machines import arm_7, with_base_parameters
from tests.benchmarks.match import require_pinocchio
from tests.benchmarks.python_calls import CTYPES, NUMPY, OURS, PINOCCHIO, take_turns
from tests.benchmarks.tables import print_table, progress, save_json

MODEL = "direct_dynamics"
JOINTS = 7
STEP_S = 1e-3
SAMPLES, HORIZON = 128, 20
Accelerations = Callable[[Array, Array, Array], Array]
"""From q, qd and tau, leading axes for many states."""


def environment(accelerations: Accelerations) -> Array:
    """Return the last observation of 200 steps with a PD controller."""
    q, qd = np.zeros(JOINTS), np.full(JOINTS, 0.1)
    for _ in range(200):
        qd = qd + STEP_S * accelerations(q, qd, -5.0 * q - 0.5 * qd)
        q = q + STEP_S * qd
    return np.concatenate([q, qd])


def integrated(accelerations: Accelerations) -> Array:
    """Return the state after 0.1 s by DOP853."""
    still = np.zeros(JOINTS)

    def rate(_: float, x: Array) -> Array:
        return np.concatenate([x[JOINTS:], accelerations(x[:JOINTS], x[JOINTS:], still)])

    start = np.concatenate([still, np.full(JOINTS, 0.1)])
    return np.asarray(solve_ivp(rate, (0.0, 0.1), start, method="DOP853", rtol=1e-9, atol=1e-11).y[:, -1])


def sampled(accelerations: Accelerations) -> Array:
    """Return the mean torques of samples, weighted by their costs over the horizon."""
    tau = 0.1 * np.random.default_rng(0).standard_normal((HORIZON, SAMPLES, JOINTS))
    q, qd, cost = np.zeros((SAMPLES, JOINTS)), np.full((SAMPLES, JOINTS), 0.1), np.zeros(SAMPLES)
    for k in range(HORIZON):
        qd = qd + STEP_S * accelerations(q, qd, tau[k])
        q = q + STEP_S * qd
        cost += (q * q).sum(axis=1)
    weights = np.exp(cost.min() - cost)
    return np.asarray(np.einsum("s,ksj->kj", weights / weights.sum(), tau))


LOOPS = {
    "environment, a step": (environment, 200),
    "DOP853, 0.1 s": (integrated, 1),
    f"{SAMPLES} samples of {HORIZON} steps": (sampled, 1),
}
"""Loops, and how many steps a time is divided by."""


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m tests.benchmarks.python_loops", description=__doc__)
    parser.add_argument("--json", type=Path, help="write the figures here too")
    parser.add_argument("--rounds", type=int, default=20)
    arguments = parser.parse_args()
    require_pinocchio()
    with temporary_folder() as folder:
        functions = contestants(Path(folder))
        figures = [figure(name, functions, arguments.rounds) for name in progress(list(LOOPS), "time")]
    columns = ["us", *functions, "times faster than Pinocchio"]
    print_table(
        "loops in Python around the direct model of a 7R arm",
        columns,
        ([x["loop"], *(f"{x[key]:.3g}" for key in functions), f"{x['ratio']:.3g}"] for x in figures),
    )
    if arguments.json:
        save_json(arguments.json, {"figures": figures})


def contestants(folder: Path) -> dict[str, Accelerations]:
    machine = with_base_parameters(arm_7())
    by_c, by_numpy = load(machine, MODEL, backend="c", fold=["all"]), load(machine, MODEL, fold=["all"])
    compiled = compile_package(by_c.package, folder, flags=FLAGS)
    (function,) = by_c.package.functions
    by_ctypes = _by_ctypes(compiled, by_c.package, function, by_numpy.direct_dynamics)
    functions = {OURS: by_c.direct_dynamics, CTYPES: by_ctypes, NUMPY: by_numpy.direct_dynamics}
    first = {name: partial(_first, call) for name, call in functions.items()}
    return first | {PINOCCHIO: of_pinocchio()}


def _first(call: Any, q: Array, qd: Array, tau: Array) -> Array:
    results = call(q, qd, tau)
    return results[0] if isinstance(results, tuple) else results


def of_pinocchio() -> Accelerations:
    import pinocchio as pin

    from tests.references import pinocchio_model

    built = pinocchio_model._build(arm_7(), None)
    model, data = built.model, built.model.createData()
    assert list(built.order) == list(range(JOINTS)), "joints of a chain keep their order"

    def accelerations(q: Array, qd: Array, tau: Array) -> Array:
        if q.ndim == 1:
            return np.asarray(pin.aba(model, data, q, qd, tau))
        return np.array([pin.aba(model, data, *state) for state in zip(q, qd, tau, strict=True)])

    return accelerations


def figure(name: str, functions: dict[str, Accelerations], rounds: int) -> dict[str, Any]:
    """Return the least time of a loop by contestant, us, after all have reached the same state."""
    loop, steps = LOOPS[name]
    expected = loop(functions[NUMPY])
    assert all(np.allclose(loop(call), expected, rtol=1e-8, atol=1e-10) for call in functions.values())
    ns = take_turns({key: partial(loop, call) for key, call in functions.items()}, rounds)
    us = {key: value / steps / 1e3 for key, value in ns.items()}
    return {"loop": name, **us, "ratio": us[PINOCCHIO] / us[OURS]}


if __name__ == "__main__":
    main()
