"""The generated models, C and numpy, against references that know nothing of the recursions."""

from __future__ import annotations

import random
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import mpmath
import numpy as np
import pytest

from symoro_elastic.machine.formula import ZERO, Formula
from symoro_elastic.machine.machine import Base, Body, Joint, Kind, Machine, Parameter
from symoro_elastic.machine.scene import ALL, Scene
from symoro_elastic.mechanics.dynamics import TorqueKnown, dynamics
from symoro_elastic.mechanics.mechanism import Link, Mechanism
from symoro_elastic.mechanics.spatial import ZERO as ZERO_VECTOR
from symoro_elastic.mechanics.spatial import (
    AxialTransform,
    Axis,
    RigidInertia,
    Symmetric,
    Transform,
    Twist,
    Vector,
    X,
    Z,
)
from symoro_elastic.models.bound.bind import Bound
from symoro_elastic.models.bound.rules import direct_motion
from symoro_elastic.models.parameters.base_parameters import base_grouping
from symoro_elastic.models.programs.catalogue import trace, trace_scene
from symoro_elastic.numerics.evaluation.values import parameter_values
from symoro_elastic.symbolic.arithmetic import evaluate, multiprecision
from tests.compiled_models import built, cell, worst
from tests.examples import example
from tests.references import multiprecision as reference
from tests.references.lagrange import inertia_and_bias
from tests.references.random_machines import (
    ALL_KINDS,
    chain,
    first_joint_elastic,
    planar_2r,
    random_machine,
    random_state,
    two_children,
    with_springs_beside_motors,
)
from tests.references.stored import stored
from tests.references.test_references import TOLERANCE_50_DIGITS
from tests.references.test_references import worst as worst_of_many_digits

pytestmark = pytest.mark.sampled(6)

TOLERANCE = 1e-12


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
        for seed in range(24)
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
        *(with_springs_beside_motors(random_machine(k, joints=4 + k, symbolic=k > 0), k) for k in range(2)),
    ]
    return [*trees, *((machine, Scene()) for machine in machines), (two_children(symbolic=True), CONSTANT)]


@pytest.mark.sampled(80)
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
            wanted = stored(getattr(reference, model), machine, *(array.tolist() for array in one.values()))
            wanted = wanted if len(stacked[0]) > 1 else (wanted,)
            for found in (*((result[k] for result in results) for results in stacked), code.numpy(model, **one)):
                for result, entries in zip(found, wanted, strict=True):
                    assert worst(result, entries) < TOLERANCE, model


@pytest.mark.parametrize("seed", range(8))
def test_direct_model_by_the_inertia_matrix_agrees(seed: int) -> None:
    """A qdd = Gamma - H and the recursion, as two programs in 50 digits; trees and fixed frames too."""
    machine = random_machine(seed, joints=3 + seed, branching=0.4 * (seed % 2))
    values = {p.name: parameter_values(machine)[p.name] for p in machine.parameters}
    q, qd, tau = random_state(machine, seed)
    found = []
    for model in ("direct_dynamics", "direct_dynamics_by_inertia_matrix"):
        program = trace(machine, model).program
        symbols = {
            n: v for i, x in zip(program.inputs, (q, qd, tau), strict=True) for n, v in zip(i.symbols, x, strict=True)
        }
        numbers = {name: mpmath.mpf(x) for name, x in (values | symbols).items()}
        value = evaluate(program.outputs[0].entries, numbers, multiprecision(50))
        found.append([value(x) for x in program.outputs[0].entries])
    assert worst(np.array(found[0], float), np.array(found[1], float)) < 1e-15


@pytest.mark.sampled(12)
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


@pytest.mark.sampled(12)
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


SMALL = [
    pytest.param(planar_2r(), id="planar 2R"),
    pytest.param(chain(3, prismatic=(1, 3), elastic=(2,), symbolic=False), id="PRP"),
    pytest.param(random_machine(2, joints=3, friction=False, wrenches=False, moving_base=True), id="moving base"),
    pytest.param(random_machine(3, joints=4, friction=False, wrenches=False), id="tree"),
]


@pytest.mark.parametrize("machine", SMALL)
def test_against_lagrange(machine: Machine, tmp_path: Path) -> None:
    """A and H from the Lagrangian, differentiated in SymPy: of the generated code and of the reference in 50 digits."""
    code = built(machine, tmp_path)
    for seed in range(3):
        q, qd, _ = random_state(machine, seed)
        A, H = stored(inertia_and_bias, machine, q, qd)
        assert worst_of_many_digits(A, reference.inertia_matrix(machine, q)) < TOLERANCE_50_DIGITS
        assert worst_of_many_digits(H, reference.bias_forces(machine, q, qd)) < TOLERANCE_50_DIGITS
        for run in code.both():
            assert worst(run("inertia_matrix", q=q)[0], A) < 1e-14
            assert worst(run("bias_forces", q=q, qd=qd)[0], H) < 1e-13


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


# What the generator promises


def without_rotors(machine: Machine) -> Machine:
    return replace(machine, joints=tuple(replace(joint, rotor_inertia=ZERO) for joint in machine.joints))


def named_quantities(machine: Machine) -> set[str]:
    program = trace(machine, "direct_dynamics").program
    return {statement.name for statement in (*program.once, *program.statements)}


@pytest.mark.parametrize("prismatic", [(), (2, 3)])
def test_inertia_left_after_a_joint_is_exactly_zero_along_it(prismatic: tuple[int, ...]) -> None:
    """K a = U Ia / H: without rotors the row and column of K are the integer 0, and no statement names them."""
    machine = without_rotors(chain(4, prismatic=prismatic, elastic=(3,)))
    bound = Bound(machine)
    found = dynamics(bound.mechanism, bound.rates(), direct_motion(bound).rules)
    names = named_quantities(machine)
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
    assert named_quantities(chain(4, prismatic=prismatic)) & {"K3_66", "K3_33"}


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
        turn = named(angle) if angle.startswith("AL") else cell(angle)
        joint = Joint(f"joint{j}", j - 1, Kind.MOTOR, 0, f"t{j}", alpha=turn, d=named(x), r=named(z), body=body)
        joints.append(replace(joint, rotor_inertia=rotor))
    base = Base(gravity=(ZERO, ZERO, named("G3")))
    return Machine("benchmark", tuple(joints), tuple(parameters), base)


def rx90(rotors: bool) -> Machine:
    alpha = ("0", "pi/2", "0", "-pi/2", "pi/2", "-pi/2")
    return benchmark(alpha, ("0", "0", "D3", "0", "0", "0"), ("0", "0", "0", "RL4", "0", "0"), rotors)


def chain80(*alpha: str) -> Machine:
    lengths = range(1, 81)
    angles = [alpha[k % len(alpha)].replace("AL", f"AL{k}") for k in range(80)]
    return benchmark(angles, [f"D{k}" for k in lengths], [f"R{k}" for k in lengths], False)


QUARTERS = ("0", "pi/2", "-pi/2")


@pytest.mark.parametrize(
    ("machine", "model", "products", "sums"),
    [
        pytest.param(rx90(True), "inverse_dynamics", 280, 264, id="RX90 inverse"),
        pytest.param(rx90(True), "direct_dynamics", 586, 496, id="RX90 direct"),
        pytest.param(rx90(False), "direct_dynamics", 512, 440, id="RX90 direct, no rotors"),
        pytest.param(rx90(True), "direct_dynamics_by_inertia_matrix", 480, 434, id="RX90 direct, by A"),
        pytest.param(rx90(True), "inertia_matrix", 118, 118, id="RX90 inertia matrix"),
        pytest.param(base_grouping(example("rx90.par")).machine, "inverse_dynamics", 239, 223, id="RX90 inverse, base"),
        pytest.param(base_grouping(example("rx90.par")).machine, "direct_dynamics", 565, 450, id="RX90 direct, base"),
        pytest.param(
            base_grouping(example("puma560.par")).machine, "inverse_dynamics", 262, 245, id="PUMA inverse, base"
        ),
        pytest.param(
            base_grouping(example("puma560.par")).machine, "direct_dynamics", 654, 542, id="PUMA direct, base"
        ),
        pytest.param(chain80(*QUARTERS), "inverse_dynamics", 5362, 5196, id="80 joints inverse"),
        pytest.param(chain80(*QUARTERS), "direct_dynamics", 12667, 11893, id="80 joints direct"),
        pytest.param(chain80(*QUARTERS, "AL"), "inverse_dynamics", 5822, 5456, id="80 joints, general, inverse"),
        pytest.param(chain80(*QUARTERS, "AL"), "direct_dynamics", 13605, 12554, id="80 joints, general, direct"),
    ],
)
def test_operation_counts_do_not_grow(machine: Machine, model: str, products: int, sums: int) -> None:
    """In each call, without what depends on parameters only."""
    count = trace(machine, model).program.count
    assert count.products <= products and count.add <= sums


def test_two_axis_machine_takes_238_operations() -> None:
    machine = example("two_axis.toml")
    count = trace_scene(machine, Scene(models=("direct_dynamics",), fold=ALL))[0].program.count
    assert count.products + count.add <= 238


# On chains where a plain recursion fails


def hard_chain(masses: Sequence[float], context: Any, source: random.Random) -> tuple[Mechanism, list[Any], list[Any]]:
    """100 links in all directions with their velocities and torques, in the arithmetic of a context."""
    links = []
    for j, mass in enumerate(masses):
        angle, m = context.mpf(source.uniform(-3, 3)), context.mpf(mass)
        alpha = (AxialTransform(X, 1, 0, 1), AxialTransform(X, 0, 1, 1), AxialTransform(X, 0, -1, 1))[j % 3]
        steps = (AxialTransform(Z, 1, 0, 0), alpha, AxialTransform(Z, context.cos(angle), context.sin(angle), 0))
        inertia = Symmetric(m / 100, 0, 0, m / 12, 0, m / 12)
        body = RigidInertia.about_center(m, Vector(context.mpf(0.5), 0, 0), inertia)
        links.append(Link(j, Axis.REVOLUTE, Transform(steps), body))
    rates, torques = ([context.mpf(source.uniform(-1, 1)) for _ in masses] for _ in range(2))
    acceleration = Vector(context.mpf(3), context.mpf(9), context.mpf(-2))
    return Mechanism(tuple(links), acceleration=Twist(acceleration, ZERO_VECTOR)), [0, *rates], torques


@pytest.mark.parametrize(
    ("masses", "bound"),
    [
        pytest.param([1.0] * 100, 4e-15, id="equal"),
        pytest.param([10 ** (6 * j / 99) for j in range(100)], 4e-15, id="growing to 1e6"),
        pytest.param([1.0] * 99 + [1e6], 5e-10, id="heavy tip"),
    ],
)
def test_hard_chains(masses: list[float], bound: float) -> None:
    """The recursion in double precision against 50 digits, relative to the largest acceleration."""
    precise = mpmath.MPContext()
    precise.dps = 50
    results = []
    for context in (precise, mpmath.fp):
        mechanism, rates, torques = hard_chain(masses, context, random.Random(1))
        found = dynamics(mechanism, rates, [None, *map(TorqueKnown, torques)])
        results.append([found.qdd[j] for j in range(1, 101)])
    wanted, got = results
    assert max(abs(x - y) for x, y in zip(got, wanted, strict=True)) < bound * max(map(abs, wanted))
