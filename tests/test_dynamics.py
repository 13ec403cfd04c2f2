"""The generated models, C and numpy, against references that know nothing of the recursions."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from types import ModuleType
from typing import Any

import mpmath
import numpy as np
import pytest
from numpy.typing import NDArray

from symoro_elastic.codegen.compile import CompiledPackage, compile_library
from symoro_elastic.codegen.targets import render_c, render_numpy
from symoro_elastic.equations.dynamics import dynamics
from symoro_elastic.generate import package
from symoro_elastic.machine.formula import ZERO, Formula
from symoro_elastic.machine.machine import (
    Base,
    Body,
    Friction,
    Joint,
    Kind,
    Machine,
    Parameter,
    Spring,
    Vector3,
    Wrench,
)
from symoro_elastic.machine.restrict import folded, restricted
from symoro_elastic.machine.scene import ALL, Scene
from symoro_elastic.models.bind import Bound
from symoro_elastic.models.catalogue import trace, trace_scene
from symoro_elastic.numerics.candidates import import_package
from tests.references import multiprecision as reference
from tests.references.lagrange import lagrange
from tests.references.numbers_of_machine import numbers_of
from tests.references.random_machines import (
    ALL_KINDS,
    chain,
    first_joint_elastic,
    planar_2r,
    random_machine,
    random_state,
    two_children,
)

Array = NDArray[np.float64]

FIVE = ("direct_dynamics", "inverse_dynamics", "inertia_matrix", "bias_forces", "geometric_model")
TOLERANCE = 1e-12
WEIGHT = Base(gravity=(ZERO, ZERO, Formula.parse("-9.81")))


def cell(value: float | str) -> Formula:
    return Formula.parse(value)


def vector(*values: float | str) -> Vector3:
    x, y, z = map(cell, values)
    return x, y, z


@dataclass(frozen=True)
class Built:
    """Generated code of a machine, ready to be called."""

    module: ModuleType
    compiled: CompiledPackage
    results: dict[str, tuple[str, ...]]

    def c(self, model: str, **arrays: Any) -> tuple[Array, ...]:
        return tuple(self.compiled.call(model, **arrays).values())

    def numpy(self, model: str, **arrays: Any) -> tuple[Array, ...]:
        found = getattr(self.module, model)(**arrays)
        return found if isinstance(found, tuple) else (found,)

    def both(self) -> tuple[Callable[..., tuple[Array, ...]], ...]:
        return self.c, self.numpy


def built(machine: Machine, folder: Path, scene: Scene | None = None) -> Built:
    scene = replace(scene or Scene(), models=FIVE)
    traced = trace_scene(machine, scene)
    described = package(restricted(machine, scene), traced, folded(machine, scene))
    library = compile_library(render_c(described), folder / "c", flags=("-O0",))
    module = import_package(render_numpy(described), folder / "numpy")
    results = {model.model.name: tuple(model.rows) for model in traced}
    return Built(module, CompiledPackage(described, library), results)


def worst(found: Any, wanted: Any) -> float:
    """Largest difference over the largest wanted entry; infinite for what is no number."""
    with mpmath.workdps(50):
        exact = np.array(wanted, dtype=object)
        found = np.asarray(found, dtype=float)
        assert found.shape == exact.shape
        if not exact.size:
            return 0.0
        if not np.isfinite(found).all():
            return np.inf
        scale = max(map(abs, exact.ravel()))
        difference = max(map(abs, (found.astype(object) - exact).ravel()))
        return float(difference / scale) if scale else float(difference)


# Against 50 digits, by Jacobians in frame 0

CONSTANT = Scene(fold=ALL)


def various_machines() -> list[tuple[Machine, Scene]]:
    kinds: Sequence[Sequence[Kind]] = (ALL_KINDS, (Kind.MOTOR, Kind.ELASTIC), (Kind.ELASTIC,), (Kind.MOTOR,))
    trees = [
        (
            random_machine(
                seed,
                joints=(1, 2, 4, 5, 7, 9, 12, 15)[seed % 8],
                kinds=kinds[(seed // 2) % 4],
                symbolic=seed % 3 > 0,
                moving_base=seed % 4 == 1,
                gamma=seed % 5 != 0,
                branching=(0.0, 0.4, 0.8)[seed % 3],
                prismatic=(0.35, 0.0, 1.0, 0.5)[seed % 4],
            ),
            CONSTANT if seed % 3 == 2 else Scene(),
        )
        for seed in range(32)
    ]
    machines = [
        chain(6),
        chain(5, elastic=(1, 2), prismatic=(3,)),
        chain(7, elastic=(2, 4), quarter_turns=True, symbolic=False),
        first_joint_elastic(),
        first_joint_elastic(5, symbolic=True),
        two_children(),
        two_children(symbolic=True),
        planar_2r(elastic=(1,)),
    ]
    return [*trees, *((machine, Scene()) for machine in machines), (two_children(symbolic=True), CONSTANT)]


@pytest.mark.parametrize(
    ("machine", "scene"),
    [
        pytest.param(*case, id=f"{k}-{case[0].name}-{case[1].fold or 'symbols'}")
        for k, case in enumerate(various_machines())
    ],
)
def test_against_50_digits(machine: Machine, scene: Scene, tmp_path: Path) -> None:
    """C, numpy on one state and numpy on stacked states, to 1e-12 of the largest component."""
    code = built(machine, tmp_path, scene)
    states = [random_state(machine, seed) for seed in range(3)]
    q, qd, u = (np.array([state[k] for state in states]).reshape(3, -1) for k in range(3))
    arguments = {
        "direct_dynamics": {"q": q, "qd": qd, "tau": u},
        "inverse_dynamics": {"q": q, "qd": qd, "qdd_motor": u},
        "inertia_matrix": {"q": q},
        "bias_forces": {"q": q, "qd": qd},
        "geometric_model": {"q": q},
    }
    for model, arrays in arguments.items():
        stacked = [run(model, **arrays) for run in code.both()]
        for k in range(3):
            one = {name: array[k] for name, array in arrays.items()}
            wanted = getattr(reference, model)(machine, *(array.tolist() for array in one.values()))
            wanted = wanted if isinstance(wanted, tuple) else (wanted,)
            for found in (*((result[k] for result in results) for results in stacked), code.numpy(model, **one)):
                for result, entries in zip(found, wanted, strict=True):
                    assert worst(result, entries) < TOLERANCE, model


@pytest.mark.parametrize("seed", range(6))
def test_direct_and_inverse_undo_each_other(seed: int, tmp_path: Path) -> None:
    machine = random_machine(seed, joints=4 + seed, symbolic=seed % 2 == 0)
    code = built(machine, tmp_path)
    for state in range(4):
        q, qd, tau = random_state(machine, state)
        for run in code.both():
            (qdd,) = run("direct_dynamics", q=q, qd=qd, tau=tau)
            torques, accelerations = run("inverse_dynamics", q=q, qd=qd, qdd_motor=qdd[list(code.module.MOTORS)])
            assert worst(accelerations, qdd) < 1e-10
            (inertia,), (bias,) = run("inertia_matrix", q=q), run("bias_forces", q=q, qd=qd)
            size = np.abs(inertia) @ np.abs(qdd) + np.abs(bias)
            assert np.all(np.abs(torques - tau) < 1e-13 * np.max(size))


# Against other derivations


@pytest.mark.parametrize("seed", range(16))
def test_against_pinocchio(seed: int, tmp_path: Path) -> None:
    pytest.importorskip("pinocchio")
    from tests.references import pinocchio_model

    machine = random_machine(100 + seed, joints=3 + seed % 10, symbolic=seed % 2 == 0, moving_base=seed % 5 == 4)
    code = built(machine, tmp_path).module
    q, qd, u = random_state(machine, seed)
    inertia = pinocchio_model.inertia_matrix(machine, q)
    spoiled = max(1.0, float(np.linalg.cond(inertia)) / 1e3)  # the library's solution, by the condition of A
    assert worst(code.inertia_matrix(q), inertia) < 1e-13
    assert worst(code.geometric_model(q), pinocchio_model.frames(machine, q)) < 1e-13
    assert worst(code.bias_forces(q, qd), pinocchio_model.bias_forces(machine, q, qd)) < 1e-12
    qdd = pinocchio_model.direct_dynamics(machine, q, qd, u)
    assert worst(code.direct_dynamics(q, qd, u), qdd) < 1e-12 * spoiled
    for found, wanted in zip(
        code.inverse_dynamics(q, qd, u), pinocchio_model.inverse_dynamics(machine, q, qd, u), strict=True
    ):
        assert worst(found, wanted) < 1e-11 * spoiled


LAGRANGE = [
    pytest.param(planar_2r(), id="planar 2R"),
    pytest.param(chain(3), id="generic 3R"),
    pytest.param(chain(3, prismatic=(1, 3), elastic=(2,), symbolic=False), id="PRP"),
    pytest.param(random_machine(2, joints=3, friction=False, wrenches=False, moving_base=True), id="moving base"),
    pytest.param(random_machine(3, joints=4, friction=False, wrenches=False), id="tree"),
]


@pytest.mark.parametrize("machine", LAGRANGE)
def test_against_lagrange(machine: Machine, tmp_path: Path) -> None:
    """A and H from the Lagrangian, differentiated in SymPy."""
    inertia, bias = lagrange(machine)
    code = built(machine, tmp_path)
    for seed in range(3):
        q, qd, _ = random_state(machine, seed)
        for run in code.both():
            assert worst(run("inertia_matrix", q=q)[0], inertia(q)) < 1e-14
            assert worst(run("bias_forces", q=q, qd=qd)[0], bias(q, qd)) < 1e-13


def test_planar_2r_by_hand(tmp_path: Path) -> None:
    """The textbook's two links in a vertical plane, other values than the defaults."""
    given = {"ZZ1": 0.4, "ZZ2": 0.2, "MX1": 1.0, "MY1": 0.3, "MX2": 0.7, "MY2": -0.2, "M2": 3.0, "L1": 0.8, "G": 9.0}
    code = built(planar_2r(), tmp_path)
    p = code.module.parameters(**given, IA1=0.1, IA2=0.05)
    (q1, q2), (qd1, qd2), tau = (0.7, -1.1), (1.3, -0.4), np.array([3.0, -2.0])
    zz1, zz2, mx1, my1, mx2, my2, m2, l1, g = given.values()
    c2, s2, c12, s12 = np.cos(q2), np.sin(q2), np.cos(q1 + q2), np.sin(q1 + q2)
    reach, swing = l1 * (mx2 * c2 - my2 * s2), -l1 * (mx2 * s2 + my2 * c2)
    inertia = np.array([[zz1 + zz2 + m2 * l1**2 + 2 * reach + 0.1, zz2 + reach], [zz2 + reach, zz2 + 0.05]])
    weight2 = g * (mx2 * c12 - my2 * s12)
    weight1 = g * ((mx1 + m2 * l1) * np.cos(q1) - my1 * np.sin(q1)) + weight2
    bias = np.array([swing * qd2 * (2 * qd1 + qd2) + weight1, -swing * qd1**2 + weight2])
    state = {"q": (q1, q2), "qd": (qd1, qd2), "p": p}
    for run in code.both():
        assert run("inertia_matrix", q=(q1, q2), p=p)[0] == pytest.approx(inertia, rel=1e-14)
        assert run("bias_forces", **state)[0] == pytest.approx(bias, rel=1e-14)
        qdd = run("direct_dynamics", **state, tau=tau)[0]
        assert qdd == pytest.approx(np.linalg.solve(inertia, tau - bias), rel=1e-13)
        assert run("inverse_dynamics", **state, qdd_motor=qdd)[0] == pytest.approx(tau, rel=1e-13)


# Physics


def conservative() -> Machine:
    """A tree whose energy nothing takes: no friction, no damping, no wrench."""
    machine = two_children()
    undamped = (replace(j, spring=replace(j.spring, damping=ZERO)) for j in machine.joints)
    return replace(machine, joints=tuple(undamped))


def energy(machine: Machine, code: Built, q: Array, qd: Array) -> float:
    """1/2 qd^T A qd - sum g (M p + R MS) + 1/2 k (q - q0)^2, J."""
    numbers = numbers_of(machine)
    total = 0.5 * qd @ code.c("inertia_matrix", q=q)[0] @ qd
    for joint, frame in zip(numbers.joints, code.c("geometric_model", q=q)[0], strict=True):
        weighed = joint.body.mass * frame[:3, 3] + frame[:3, :3] @ joint.body.first_moment
        total -= numbers.base.gravity @ weighed
    for x, j in zip(q, numbers.moving, strict=True):
        joint = numbers.joints[j]
        total += 0.5 * joint.stiffness * (x - joint.neutral) ** 2
    return float(total)


def simulated(code: Built, q: Array, qd: Array, step: float, steps: int) -> tuple[Array, Array]:
    """Runge and Kutta's fourth-order method with motors that exert nothing."""
    tau, n = np.zeros(len(code.module.MOTORS)), len(q)

    def rate(x: Array) -> Array:
        return np.concatenate([x[n:], code.c("direct_dynamics", q=x[:n], qd=x[n:], tau=tau)[0]])

    x = np.concatenate([q, qd])
    for _ in range(steps):
        k1 = rate(x)
        k2 = rate(x + step / 2 * k1)
        k3 = rate(x + step / 2 * k2)
        k4 = rate(x + step * k3)
        x = x + step / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    return x[:n], x[n:]


def test_energy_is_conserved(tmp_path: Path) -> None:
    """Over half a second, to the order of the integrator, and to 1e-9 of what is exchanged."""
    machine = conservative()
    code = built(machine, tmp_path)
    q, qd, _ = map(np.array, random_state(machine, 1))
    q = q / 3
    before = energy(machine, code, q, qd)
    drifts = []
    for steps in (500, 1000, 2000):
        after = energy(machine, code, *simulated(code, q, qd, 0.5 / steps, steps))
        drifts.append(abs(after - before))
    kinetic = 0.5 * float(qd @ code.c("inertia_matrix", q=q)[0] @ qd)
    assert drifts[2] < 1e-9 * kinetic
    assert drifts[1] < drifts[0] / 10 and drifts[2] < drifts[1] / 10


def test_stiff_springs_make_a_rigid_machine(tmp_path: Path) -> None:
    """At the deflection that carries the load, motor accelerations tend to the rigid machine's as 1/k."""
    machine = chain(4, elastic=(2, 4))
    locked = {"joint2": cell("Q02"), "joint4": cell("Q04")}
    rigid = built(machine, tmp_path / "rigid", Scene(locked=locked))
    soft = built(machine, tmp_path / "soft")
    values = dict(zip(soft.module.PARAMETERS, soft.module.DEFAULTS.tolist(), strict=True))
    q = np.array([0.4, values["Q02"], -0.7, values["Q04"]])
    qd, tau, motors, springs = np.array([0.5, 0.0, -0.9, 0.0]), np.array([3.0, -4.0]), [0, 2], [1, 3]
    (wanted,) = rigid.c("direct_dynamics", q=q[motors], qd=qd[motors], tau=tau)
    qdd = np.zeros(4)
    qdd[motors] = wanted
    loads = soft.c("inertia_matrix", q=q)[0] @ qdd + soft.c("bias_forces", q=q, qd=qd)[0]
    errors = []
    for k in (1e5, 1e7, 1e9):
        deflected = q.copy()
        deflected[springs] -= loads[springs] / k
        (found,) = soft.c("direct_dynamics", q=deflected, qd=qd, tau=tau, p=soft.module.parameters(K2=k, K4=k))
        errors.append(np.max(np.abs(found - qdd)))
    assert errors[0] < 1e-2 * np.max(np.abs(qdd))
    assert errors[1] < errors[0] / 50 and errors[2] < errors[1] / 50


def slide(**changed: Any) -> Machine:
    """A vertical slide of 2 kg with a rotor of 1 kg."""
    joint = Joint("z", 0, Kind.MOTOR, 1, "q1", body=Body(cell(2)), rotor_inertia=cell(1))
    return Machine("slide", (replace(joint, **changed),), base=Base(gravity=vector(0, 0, -10)))


@pytest.mark.parametrize(("velocity", "force"), [(-2.0, -1.25), (3.0, 1.75), (0.0, 0.0)])
def test_friction_opposes_motion(velocity: float, force: float, tmp_path: Path) -> None:
    """Fs sign(qd) + Fv qd, none at rest."""
    code = built(slide(friction=Friction(viscous=cell(0.5), coulomb=cell(0.25))), tmp_path)
    for run in code.both():
        assert run("direct_dynamics", q=[0], qd=[velocity], tau=[50])[0] == [(50 - 20 - force) / 3]
        assert run("inverse_dynamics", q=[0], qd=[velocity], qdd_motor=[4])[0] == [12 + 20 + force]
        assert run("bias_forces", q=[0], qd=[velocity])[0] == [20 + force]


def test_wrench_is_exerted_on_the_surroundings(tmp_path: Path) -> None:
    code = built(slide(wrench=Wrench(force=vector(0, 0, 7))), tmp_path)
    for run in code.both():
        assert run("direct_dynamics", q=[0], qd=[0], tau=[33])[0] == [2]
        assert run("inverse_dynamics", q=[0], qd=[0], qdd_motor=[2])[0] == [33]


def test_elastic_law(tmp_path: Path) -> None:
    """-k (q - q0) - d qd; the inverse model finds the same acceleration without a motor."""
    law = Spring(stiffness=cell(600), damping=cell(3), neutral=cell(0.5))
    code = built(slide(kind=Kind.ELASTIC, spring=law), tmp_path)
    wanted = [(-600 * 0.25 - 3 * 2 - 20) / 3]
    for run in code.both():
        assert run("direct_dynamics", q=[0.75], qd=[2], tau=[])[0] == pytest.approx(wanted, rel=1e-15)
        torques, qdd = run("inverse_dynamics", q=[0.75], qd=[2], qdd_motor=[])
        assert torques.shape == (0,) and qdd == pytest.approx(wanted, rel=1e-15)


def test_moving_base(tmp_path: Path) -> None:
    """A base that accelerates feels heavier; a uniform velocity is not felt; a turning base adds to joint 1."""
    machine = two_children(symbolic=False)
    q, qd, tau = map(np.array, random_state(machine, 4))
    state = {"q": q, "qd": qd, "tau": tau}

    def qdd(name: str, base: Base, **changed: Any) -> Array:
        return built(replace(machine, base=base), tmp_path / name).c("direct_dynamics", **{**state, **changed})[0]

    lifted = qdd("lifted", Base(gravity=vector(0, 0, -9.81), acceleration=vector(1, -2, 3)))
    assert worst(lifted, qdd("heavy", Base(gravity=vector(-1, 2, -12.81)))) < 1e-13
    sailing = qdd("sailing", replace(WEIGHT, velocity=vector(3, -1, 2)))
    assert worst(sailing, qdd("still", WEIGHT)) == 0
    turning = qdd("turning", replace(WEIGHT, angular_velocity=vector(0, 0, 0.7)))
    faster = qdd("faster", WEIGHT, qd=qd + 0.7 * np.eye(6)[0])
    assert worst(turning, faster) < 1e-13


# Calling conventions


def test_nan_in_gives_nan_out(tmp_path: Path) -> None:
    """On one state, and on one of several stacked ones; the others are as they were."""
    machine = chain(3, elastic=(2,))
    code = built(machine, tmp_path)
    q, qd, u = (np.tile(np.array(row), (3, 1)) for row in random_state(machine, 1))
    for run in code.both():
        good = run("direct_dynamics", q=q, qd=qd, tau=u)[0]
        for name in ("q", "qd", "tau"):
            arrays = {"q": q.copy(), "qd": qd.copy(), "tau": u.copy()}
            arrays[name][1] = np.nan
            found = run("direct_dynamics", **arrays)[0]
            assert np.isnan(found[1]).all() and np.array_equal(found[[0, 2]], good[[0, 2]])
            one = {key: array[1] for key, array in arrays.items()}
            assert np.isnan(run("direct_dynamics", **one)[0]).all()
        poisoned = {"q": np.full(3, np.nan), "qd": qd[0]}
        assert all(np.isnan(x).all() for x in run("inverse_dynamics", **poisoned, qdd_motor=u[0])[:1])
        assert np.isnan(run("bias_forces", **poisoned)[0]).all()
        p = np.full(len(code.module.PARAMETERS), np.nan)
        assert np.isnan(run("direct_dynamics", q=q[0], qd=qd[0], tau=u[0], p=p)[0]).all()


def test_wrong_shapes_are_refused(tmp_path: Path) -> None:
    code = built(chain(3, elastic=(2,)), tmp_path)
    for run in code.both():
        with pytest.raises(ValueError, match=r"tau has shape \(3,\): \(\.\.\., 2\) is expected"):
            run("direct_dynamics", q=np.zeros(3), qd=np.zeros(3), tau=np.zeros(3))
        with pytest.raises(ValueError, match=r"q has shape \(5, 2\): \(\.\.\., 3\) is expected"):
            run("inertia_matrix", q=np.zeros((5, 2)))
        with pytest.raises(ValueError, match=r"q has shape \(\)"):
            run("inertia_matrix", q=0.0)
        with pytest.raises(ValueError, match=r"p has shape \(1,\)"):
            run("inertia_matrix", q=np.zeros(3), p=[1.0])
        with pytest.raises(ValueError, match="broadcast"):
            run("bias_forces", q=np.zeros((2, 3)), qd=np.zeros((4, 3)))
        with pytest.raises(TypeError):
            run("bias_forces", q=np.zeros(3), speed=np.zeros(3))


def test_states_broadcast(tmp_path: Path) -> None:
    machine = chain(3, elastic=(2,))
    code = built(machine, tmp_path)
    q, qd, u = map(np.array, random_state(machine, 1))
    many = q + np.linspace(0, 1, 8).reshape(4, 2, 1)
    for run in code.both():
        found = run("direct_dynamics", q=many, qd=qd, tau=np.tile(u, (2, 1)))[0]
        assert found.shape == (4, 2, 3)
        for i, k in np.ndindex(4, 2):
            assert found[i, k] == pytest.approx(run("direct_dynamics", q=many[i, k], qd=qd, tau=u)[0], rel=1e-13)
        assert run("inertia_matrix", q=many)[0].shape == (4, 2, 3, 3)
        assert run("geometric_model", q=np.zeros((0, 3)))[0].shape == (0, 3, 4, 4)
        p = code.module.DEFAULTS * np.array([[1.0], [1.1]])
        scaled = run("inertia_matrix", q=q, p=p)[0]
        assert scaled.shape == (2, 3, 3) and not np.allclose(scaled[0], scaled[1])


# What the generator promises


def without_rotors(machine: Machine) -> Machine:
    return replace(machine, joints=tuple(replace(joint, rotor_inertia=ZERO) for joint in machine.joints))


@pytest.mark.parametrize("prismatic", [(), (2, 3)])
def test_inertia_left_after_a_joint_is_exactly_zero_along_it(prismatic: tuple[int, ...]) -> None:
    """K a = U Ia / H: without rotors the row and column of K are the integer 0, and no statement names them."""
    machine = without_rotors(chain(4, prismatic=prismatic, elastic=(3,)))
    bound = Bound(machine)
    found = dynamics(bound.mechanism, bound.rates(), bound.direct_rules())
    names = {s.name for s in trace(machine, "direct_dynamics").program.statements}
    for j, joint in enumerate(machine.joints, start=1):
        K = found.eliminated[j].K
        if joint.sigma == 0:
            along = [*(K.B[m][2] for m in range(3)), K.D[2], K.D[4], K.D[5]]
            row = [f"K{j}_{m}6" for m in range(1, 7)]
        else:
            along = [K.A[2], K.A[4], K.A[5], *K.B[2]]
            row = [f"K{j}_{min(m, 3)}{max(m, 3)}" for m in range(1, 7)]
        assert all(isinstance(x, int) and x == 0 for x in along)
        assert not names & set(row)
    assert any(name.startswith("K4_") for name in names)
    rotors = {s.name for s in trace(chain(4, prismatic=prismatic), "direct_dynamics").program.statements}
    assert rotors & {"K3_66", "K3_33", "K3_36"}


def benchmark(alpha: Sequence[str], d: Sequence[str], r: Sequence[str], rotors: bool) -> Machine:
    """A rigid chain with general symbolic inertias and symbolic lengths, vertical first axis."""
    parameters: list[Parameter] = []

    def named(name: str) -> Formula:
        if name != "0":
            parameters.append(Parameter(name))
        return cell(name)

    joints = []
    for j, (angle, x, z) in enumerate(zip(alpha, d, r, strict=True), start=1):
        mx, my, mz = (named(f"{name}{j}") for name in ("MX", "MY", "MZ"))
        xx, xy, xz, yy, yz, zz = (named(f"{name}{j}") for name in ("XX", "XY", "XZ", "YY", "YZ", "ZZ"))
        body = Body(named(f"M{j}"), (mx, my, mz), (xx, xy, xz, yy, yz, zz))
        rotor = named(f"IA{j}") if rotors else ZERO
        joint = Joint(f"joint{j}", j - 1, Kind.MOTOR, 0, f"t{j}", alpha=cell(angle), d=named(x), r=named(z), body=body)
        joints.append(replace(joint, rotor_inertia=rotor))
    base = Base(gravity=(ZERO, ZERO, named("G3")))
    return Machine("benchmark", tuple(joints), tuple(parameters), base)


def rx90(rotors: bool) -> Machine:
    alpha = ("0", "pi/2", "0", "-pi/2", "pi/2", "-pi/2")
    return benchmark(alpha, ("0", "0", "D3", "0", "0", "0"), ("0", "0", "0", "RL4", "0", "0"), rotors)


def chain80() -> Machine:
    alpha = [("0", "pi/2", "-pi/2")[k % 3] for k in range(80)]
    lengths = range(1, 81)
    return benchmark(alpha, [f"D{k}" for k in lengths], [f"R{k}" for k in lengths], False)


@pytest.mark.parametrize(
    ("machine", "model", "products", "sums"),
    [
        pytest.param(rx90(True), "inverse_dynamics", 294, 292, id="RX90 inverse"),
        pytest.param(rx90(False), "direct_dynamics", 690, 522, id="RX90 direct"),
        pytest.param(rx90(True), "inertia_matrix", 206, 157, id="RX90 inertia matrix"),
        pytest.param(chain80(), "inverse_dynamics", 5599, 5669, id="80 joints inverse"),
        pytest.param(chain80(), "direct_dynamics", 15808, 13109, id="80 joints direct"),
    ],
)
def test_operation_counts_do_not_grow(machine: Machine, model: str, products: int, sums: int) -> None:
    """At most what the best peer needs, or a plain trace."""
    count = trace(machine, model).program.count
    assert count.products <= products and count.add <= sums
