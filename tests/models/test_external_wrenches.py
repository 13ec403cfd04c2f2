"""Wrenches on frames as arguments of the models: by the transposed Jacobian, which products of transforms give."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from symoro_elastic.analysis.simulation.prediction.output_matrices import slopes
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.generation.pipeline import verify
from symoro_elastic.machine.formula import ZERO
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.resolve import resolve
from symoro_elastic.machine.restrict import under_forces
from symoro_elastic.machine.scene import Scene
from symoro_elastic.numerics.motion.equations_of_motion import EquationsOfMotion
from symoro_elastic.numerics.verification.implementations import numpy_model
from tests.analysis.ladder.scenes import random_springs
from tests.closed_chains.machines import machine as closed_chain
from tests.closed_chains.machines import situations
from tests.models.test_creep import creeping

STATES = 3
MODELS = ("direct_dynamics", "inverse_dynamics", "linearization", "inertia_matrix")


def tree() -> tuple[Machine, tuple[str, ...]]:
    """A tree of motors and springs, and frames of two branches, one with a point."""
    machine = random_springs(11, 6, (40, 90))
    last, other = machine.joints[-1].name, machine.joints[2].name
    return machine, (f"{last} at (0.1, -0.2, 0.3)", other)


def test_they_act_by_the_transposed_jacobian() -> None:
    """Accelerations A^-1 (Gamma + J^T w - H), torques of motors less J^T w, stiffness less its derivative."""
    machine, frames = tree()
    rng, n, motors = np.random.default_rng(1), len(machine.independent), list(machine.motor_entries)
    q, qd, qdd, w = (rng.normal(size=(STATES, k)) for k in (n, n, n, 12))
    tau, driven = rng.normal(size=(2, STATES, len(motors)))
    plain = numpy_model(machine, (*MODELS, "jacobian"), {"jacobian": tuple(f"{frame} in base" for frame in frames)})
    pushed = numpy_model(under_forces(machine, frames), MODELS)

    def forces(q: np.ndarray) -> np.ndarray:
        return np.einsum("sfci,sfc->si", plain.jacobian(q), w.reshape(STATES, 2, 6))

    def close(found: np.ndarray, wanted: np.ndarray, rounding: float = 1e-12) -> None:
        np.testing.assert_allclose(found, wanted, rtol=0, atol=rounding * np.abs(wanted).max())

    A, acting = plain.inertia_matrix(q), forces(q)
    by_forces = np.linalg.solve(A, acting[..., None])[..., 0]
    close(pushed.direct_dynamics(q, qd, tau, w), plain.direct_dynamics(q, qd, tau) + by_forces)
    free = [k for k in range(n) if k not in motors]
    yielding = np.linalg.solve(A[:, free][:, :, free], acting[:, free, None])
    (tau_with, qdd_with), (tau_without, qdd_without) = (
        pushed.inverse_dynamics(q, qd, driven, w),
        plain.inverse_dynamics(q, qd, driven),
    )
    close(qdd_with[:, free], qdd_without[:, free] + yielding[..., 0])
    close(tau_with, tau_without + (A[:, motors][:, :, free] @ yielding)[..., 0] - acting[:, motors])
    K, bare = pushed.linearization(q, qd, qdd, w)[2], plain.linearization(q, qd, qdd)[2]
    close(K, bare - slopes(forces, q), 1e-9)


@pytest.mark.thorough
def test_machines_whose_loops_are_assembled() -> None:
    """Virtual work of the wrench: A qdd changes by J^T w."""
    machine = creeping(closed_chain("ring"))
    frame = machine.joint(machine.loops[0].meets).name
    models = ("direct_dynamics", "inertia_matrix", "jacobian", "assemble")
    plain = numpy_model(machine, models, {"jacobian": (f"{frame} in base",)})
    pushed = numpy_model(under_forces(machine, (frame,)), ("direct_dynamics",))
    state, variables = situations("ring")[0].state, {row.name: str(row.variable) for row in machine.joints}
    q, qd = np.array(state.u), np.array(state.ud)
    q_dep = plain.assemble(q, [float(state.guess[variables[name]]) for name in plain.DEPENDENT])[0]
    tau, w = np.ones(len(plain.MOTOR_NAMES)), np.arange(1.0, 7.0)
    more = pushed.direct_dynamics(q, q_dep, qd, tau, w) - plain.direct_dynamics(q, q_dep, qd, tau)
    acting = np.einsum("fci,c->i", plain.jacobian(q, q_dep), w)
    np.testing.assert_allclose(plain.inertia_matrix(q, q_dep) @ more, acting, rtol=0, atol=1e-10 * np.abs(acting).max())


@pytest.mark.thorough
def test_generated_code_under_them_is_verified() -> None:
    machine, frames = tree()
    scene = resolve(Scene(models=("direct_dynamics", "inverse_dynamics", "linearization"), forces=frames), machine)
    assert verify(machine, scene).ok


def test_they_are_zero_in_linear_analyses() -> None:
    """Modes and responses of a scene that names frames are those without."""
    machine, frames = tree()
    q, rest = np.full(len(machine.independent), 0.2), np.zeros(len(machine.independent))
    pushed = under_forces(machine, frames)
    with_them, without = (EquationsOfMotion(one).forces(q, rest, rest) for one in (pushed, machine))
    np.testing.assert_array_equal(with_them, without)


def test_models_that_no_wrench_changes_do_not_take_them() -> None:
    machine, frames = tree()
    module = numpy_model(under_forces(machine, frames), ("inertia_matrix", "direct_dynamics"))
    assert module.inertia_matrix(np.zeros(6)).shape == (6, 6)


@pytest.mark.parametrize(
    ("forces", "said"),
    [
        (("tol",), "scene, forces: no frame 'tol'"),
        (("joint3 in base",), "wrenches are in axes of frame 0: name a frame"),
        (("joint3 at (0, 1)",), "a point has three coordinates"),
        (("joint3 at (0, 1, L9)",), "'L9' is not declared"),
        (("joint3", "joint3"), "joint3 is given twice"),
    ],
)
def test_what_is_no_frame_is_refused(forces: tuple[str, ...], said: str) -> None:
    machine, _ = tree()
    plain = replace(machine, joints=tuple(replace(j, rotor_inertia=ZERO) for j in machine.joints))
    with pytest.raises(InputError, match=said):
        resolve(Scene(forces=forces), plain)
