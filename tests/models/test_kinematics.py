"""Frames in motion, reaction wrenches, the parts of H and energy, as generated code, against other derivations."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from symoro_elastic.codegen.compile import CompiledPackage, compile_library
from symoro_elastic.codegen.integration.tableaus import RK4, step
from symoro_elastic.codegen.targets.c import render_c
from symoro_elastic.codegen.targets.numpy import render_numpy
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.formula import ZERO
from symoro_elastic.machine.machine import NO_VECTOR, Base, Body, Friction, Joint, Kind, Machine, Wrench
from symoro_elastic.machine.resolve import resolve
from symoro_elastic.machine.restrict import names_to_fold, restrict
from symoro_elastic.machine.scene import ALL, Scene
from symoro_elastic.models.bound.bind import Bound
from symoro_elastic.models.bound.model import Frame
from symoro_elastic.models.packaging import package
from symoro_elastic.models.programs.catalogue import MODELS, TracedModel, trace, trace_scene
from symoro_elastic.numerics.verification.implementations import import_package
from symoro_elastic.symbolic.arithmetic import FLOATS, Arithmetic, evaluate, multiprecision
from symoro_elastic.symbolic.expression import Expression
from tests.compiled_models import Array, Built, cell, vector, worst
from tests.counted_calls import calls_of
from tests.references import multiprecision as reference
from tests.references.numbers_of_machine import MachineNumbers, numbers_of
from tests.references.random_machines import (
    WEIGHT,
    chain,
    first_joint_elastic,
    planar_2r,
    random_machine,
    random_state,
    two_children,
)

pytestmark = pytest.mark.sampled(6)

TOLERANCE = 1e-12
MOTIONS = ("velocities", "accelerations", "jacobian", "jacobian_dot_qd")
OF_FRAMES = ("geometric_model", *MOTIONS)
PARTS = ("coriolis_forces", "gravity_forces", "friction_forces", "external_forces")
CONSTANT = Scene(fold=ALL)


def made(machine: Machine, folder: Path, models: Sequence[str], scene: Scene | None = None) -> Built:
    """C and numpy of some models; a name that is given twice would not compile."""
    scene = replace(scene or Scene(), models=tuple(models))
    traced = trace_scene(machine, scene)
    described = package(restrict(machine, scene), traced, names_to_fold(machine, scene))
    library = compile_library(render_c(described), folder / "c", flags=("-O0",))
    module = import_package(render_numpy(described), folder / "numpy")
    return Built(module, CompiledPackage(described, library), {t.model.name: tuple(t.rows) for t in traced})


def error(found: Any, wanted: Any) -> float:
    """Largest difference over the largest wanted entry, or over 1 where all are smaller."""
    return worst(found, wanted) * min(1.0, max(map(abs, np.ravel(wanted)), default=1.0) or 1.0)


def whole_state(machine: Machine, seed: int) -> dict[str, Array]:
    """q, qd and qdd of all joints."""
    q, qd, _ = random_state(machine, seed)
    return {"q": np.array(q), "qd": np.array(qd), "qdd": np.random.default_rng(seed).uniform(-5, 5, len(q))}


def of_model(model: str, state: Mapping[str, Array]) -> dict[str, Array]:
    """The arguments that a model takes."""
    taken = {"q", "qd"}
    if model in ("geometric_model", "jacobian", "gravity_forces", "external_forces", "inertia_matrix"):
        taken = {"q"}
    if model in ("accelerations", "reaction_wrenches"):
        taken = {"q", "qd", "qdd"}
    return {name: state[name] for name in ({"qd"} if model == "friction_forces" else taken)}


def on_still_base(machine: Machine) -> Machine:
    return replace(machine, base=Base(machine.base.gravity))


def various_machines() -> list[tuple[Machine, Scene]]:
    trees = [
        (
            random_machine(
                700 + seed,
                joints=(1, 3, 5, 6, 8, 10)[seed % 6],
                symbolic=seed % 2 == 0,
                moving_base=seed % 3 == 1,
                branching=(0.0, 0.4, 0.8)[seed % 3],
                prismatic=(0.35, 0.0, 1.0, 0.5)[seed % 4],
            ),
            CONSTANT if seed % 4 == 2 else Scene(),
        )
        for seed in range(10)
    ]
    return [*trees, *((m, Scene()) for m in (chain(5, elastic=(2,), prismatic=(3,)), first_joint_elastic(), WELDED))]


def welded() -> Machine:
    """Fixed frames everywhere: on the base, between joints, in a row, at the tips."""
    mass = Body(cell(3), vector(0.1, "-1/5", 0.3), tuple(map(cell, (2, 0.1, 0.2, 3, 0.3, 4))))  # type: ignore[arg-type]
    places: list[dict[str, Any]] = [
        {"alpha": cell(a), "d": cell(d), "r": cell(r)} for a, d, r in ((0.3, 0.2, 0), ("pi/2", 0.1, 0.4), (0, 1, 1))
    ]
    rows = [
        Joint("foot", 0, Kind.FIXED, 2, gamma=cell(0.4), b=cell(0.2), body=mass, **places[0]),
        Joint("turn", 1, Kind.MOTOR, 0, "q1", body=mass, **places[1]),
        Joint("plate", 2, Kind.FIXED, 2, theta=cell(0.7), body=mass, **places[2]),
        Joint("slide", 3, Kind.ELASTIC, 1, "q2", body=mass, **places[1]),
        Joint("mount", 4, Kind.FIXED, 2, body=mass, **places[0]),
        Joint("tool", 5, Kind.FIXED, 2, wrench=Wrench(vector(1, 2, 3), vector(-4, 5, 6)), **places[1]),
        Joint("swing", 3, Kind.PASSIVE, 0, "q3", body=mass, **places[0]),
        Joint("probe", 7, Kind.FIXED, 2, theta=cell("pi/2"), **places[2]),
    ]
    motion = (vector(0.3, -1, 0.5), vector(1, 0.2, -0.7), vector(2, 0, 1), vector(-1, 0.4, 0.3))
    return Machine("welded", tuple(rows), (), Base(vector(1, -2, -9), *motion))


WELDED = welded()
VARIOUS = [pytest.param(*case, id=f"{k}-{case[0].name}") for k, case in enumerate(various_machines())]


# What the models should give, from the 50-digit reference


def both_halves(rotation: Any, screw: Any) -> Any:
    """Linear and angular parts turned."""
    return np.concatenate([rotation @ screw[:3], rotation @ screw[3:]])


class Wanted:
    """Every frame of a machine in one state; entry 0 is the base, seen as `model(frame, place)`."""

    def __init__(self, machine: Machine, state: Mapping[str, Array]) -> None:
        q, qd, qdd = (state[name].tolist() for name in ("q", "qd", "qdd"))
        still, zero = on_still_base(machine), [0.0] * len(q)
        units = np.eye(len(q)).tolist()
        self.T = [np.eye(4), *np.array(reference.geometric_model(machine, q), dtype=float)]
        self.own: dict[str, Any] = {
            "velocities": reference.velocities(machine, q, qd),
            "accelerations": reference.accelerations(machine, q, qd, qdd),
            "jacobian_dot_qd": reference.accelerations(still, q, qd, zero),
            "jacobian": np.moveaxis(np.array([reference.velocities(still, q, unit) for unit in units]), 0, -1),
        }

    def __call__(self, model: str, frame: int, place: int | None) -> Any:
        if place is None:
            place = 0 if model in ("geometric_model", "jacobian", "jacobian_dot_qd") else frame
        relative = np.linalg.inv(self.T[place]) @ self.T[frame]
        if model == "geometric_model":
            return relative
        return both_halves(relative[:3, :3], np.array(self.own[model][frame - 1], dtype=float))


@pytest.mark.sampled(12)
@pytest.mark.parametrize(("machine", "scene"), VARIOUS)
def test_motion_of_all_frames(machine: Machine, scene: Scene, tmp_path: Path) -> None:
    """C and numpy, one state and stacked states."""
    code = made(machine, tmp_path, OF_FRAMES, scene)
    states = [whole_state(machine, seed) for seed in range(2)]
    wanted = [Wanted(machine, state) for state in states]
    frames = range(1, len(machine.joints) + 1)
    for model in OF_FRAMES:
        exact = [[want(model, j, None) for j in frames] for want in wanted]
        stacked = of_model(model, {name: np.array([s[name] for s in states]) for name in states[0]})
        for run in code.both():
            assert error(run(model, **stacked)[0], exact) < TOLERANCE, model
        for state, entries in zip(states, exact, strict=True):
            assert error(code.numpy(model, **of_model(model, state))[0], entries) < TOLERANCE, model


def places_of(machine: Machine, seed: int) -> list[tuple[int, int | None]]:
    """Frames and where they are seen from: itself, the base, nothing said, its antecedent, what it carries, any."""
    rng, n = np.random.default_rng(seed), len(machine.joints)
    chosen: list[tuple[int, int | None]] = [
        (n, None),
        (n, 0),
        (n, n),
        (1, n),
        (n, 1),
        (n, machine.joints[-1].antecedent),
    ]
    return [*dict.fromkeys([*chosen, *((int(j), int(k)) for j, k in rng.integers([1, 0], n + 1, (4, 2)))])]


@pytest.mark.sampled(12)
@pytest.mark.parametrize(("machine", "scene"), VARIOUS)
def test_frames_seen_from_any_other(machine: Machine, scene: Scene, tmp_path: Path) -> None:
    asked = places_of(machine, 5)
    names = ["base", *(joint.name for joint in machine.joints)]
    outputs = tuple(names[j] if k is None else f"{names[j]} in {names[k]}" for j, k in asked)
    scene = resolve(replace(scene, outputs=dict.fromkeys(OF_FRAMES, outputs)), machine)
    code = made(machine, tmp_path, OF_FRAMES, scene)
    state = whole_state(machine, 3)
    wanted = Wanted(machine, state)
    for model in OF_FRAMES:
        (labels,) = code.module.OUTPUTS[model].values()
        assert labels == outputs
        for run in code.both():
            (found,) = run(model, **of_model(model, state))
            assert error(found, [wanted(model, j, k) for j, k in asked]) < TOLERANCE, model


@pytest.mark.thorough
@pytest.mark.parametrize(("machine", "scene"), VARIOUS)
def test_jacobians_make_velocities_and_accelerations(machine: Machine, scene: Scene, tmp_path: Path) -> None:
    """V = J qd and V' = J qdd + jacobian_dot_qd, in the axes of the base and in those of a moving frame."""
    still = on_still_base(machine)
    for place in ("base", machine.joints[-1].name):
        outputs = tuple(f"{joint.name} in {place}" for joint in machine.joints)
        asked = replace(scene, outputs=dict.fromkeys(MOTIONS, outputs))
        code = made(still, tmp_path / place, MOTIONS, asked)
        state = whole_state(machine, 7)
        for run in code.both():
            V, Vd, J, rest = (run(model, **of_model(model, state))[0] for model in MOTIONS)
            assert error(J @ state["qd"], V) < TOLERANCE
            assert error(J @ state["qdd"] + rest, Vd) < TOLERANCE


def test_motion_of_the_base_is_added() -> None:
    """At rest in its joints a machine moves with its base as one body."""
    machine = random_machine(720, joints=6, moving_base=True)
    frames, still = range(1, 7), [0.0] * len(machine.independent)
    numbers = numbers_of(machine)
    v, w, vd, wd = (
        getattr(numbers.base, x) for x in ("velocity", "angular_velocity", "acceleration", "angular_acceleration")
    )
    state = {"q": random_state(machine, 1)[0], "qd": still, "qdd": still}
    p = np.array(reference.geometric_model(machine, state["q"]), dtype=float)[:, :3, 3]
    in_base = tuple(Frame(j, 0) for j in frames)
    V = [[*(v + np.cross(w, x)), *w] for x in p]
    Vd = [[*(vd + np.cross(wd, x) + np.cross(w, np.cross(w, x))), *wd] for x in p]
    assert error(values(machine, trace(machine, "velocities", in_base), state), V) < TOLERANCE
    assert error(values(machine, trace(machine, "accelerations", in_base), state), Vd) < TOLERANCE
    assert not values(machine, trace(machine, "jacobian_dot_qd"), state).any()


# Pinocchio


@pytest.mark.parametrize("seed", range(8))
def test_against_pinocchio(seed: int, tmp_path: Path) -> None:
    """Its classical accelerations, its Jacobians in axes of the world and their time variation, the forces of rnea."""
    pin = pytest.importorskip("pinocchio")
    from tests.references import pinocchio_model

    moving_base = seed % 4 == 3
    machine = random_machine(740 + seed, joints=3 + seed % 7, symbolic=seed % 2 == 0, moving_base=moving_base)
    state = whole_state(machine, seed)
    there = pinocchio_model._build(machine, None)
    numbers, model, order = there.numbers, there.model, there.order
    frames = [
        model.addFrame(pin.Frame(f"frame {j}", carrier, 0, place, pin.FrameType.OP_FRAME))
        for j, (carrier, place) in enumerate(zip(there.carriers, there.places, strict=True))
    ]
    data = model.createData()
    q = pinocchio_model._put(there, state["q"], position=True)
    qd, qdd = pinocchio_model._put(there, state["qd"]), pinocchio_model._put(there, state["qdd"])
    if moving_base:
        base = numbers.base
        qd[:6] = [*base.velocity, *base.angular_velocity]
        spatial = base.acceleration - np.cross(base.angular_velocity, base.velocity)
        qdd[:6] = [*spatial, *base.angular_acceleration]
    external = pinocchio_model._external_forces(there)
    pin.rnea(model, data, q, qd, qdd, external)
    forces = np.array([data.f[there.carriers[j]].vector for j in numbers.moving])
    pin.forwardKinematics(model, data, q, qd, qdd)
    pin.computeJointJacobians(model, data, q)
    pin.computeJointJacobiansTimeVariation(model, data, q, qd)
    pin.updateFramePlacements(model, data)
    aligned = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED

    code = made(machine, tmp_path, (*MOTIONS, "reaction_wrenches"))
    found = {name: code.c(name, **of_model(name, state))[0] for name in code.results}
    V = [pin.getFrameVelocity(model, data, f, pin.ReferenceFrame.LOCAL).vector for f in frames]
    Vd = [pin.getFrameClassicalAcceleration(model, data, f, pin.ReferenceFrame.LOCAL).vector for f in frames]
    J = [pin.getFrameJacobian(model, data, f, aligned)[:, order] for f in frames]
    assert error(found["velocities"], V) < 1e-13
    assert error(found["accelerations"], Vd) < 1e-13
    assert error(found["jacobian"], J) < 1e-13
    if not moving_base:
        dJ = [pin.getFrameJacobianTimeVariation(model, data, f, aligned)[:, order] for f in frames]
        assert error(found["jacobian_dot_qd"], dJ @ state["qd"]) < 1e-13
    assert error(found["reaction_wrenches"][numbers.moving], forces) < 1e-12


# Forces


@pytest.mark.sampled(12)
@pytest.mark.parametrize(("machine", "scene"), VARIOUS)
def test_reaction_wrenches(machine: Machine, scene: Scene, tmp_path: Path) -> None:
    """Against 50 digits; along their axes they are the torques, less rotors and friction."""
    code = made(machine, tmp_path, ("reaction_wrenches", "inertia_matrix", "bias_forces", "friction_forces"), scene)
    state = whole_state(machine, 11)
    wanted = reference.reaction_wrenches(machine, *(state[name].tolist() for name in ("q", "qd", "qdd")))
    numbers = numbers_of(machine)
    rotors = [numbers.joints[j].rotor_inertia for j in numbers.moving]
    for run in code.both():
        f, A, H, friction = (run(model, **of_model(model, state))[0] for model in code.results)
        assert error(f, wanted) < TOLERANCE
        along = [f[j, 2 if numbers.joints[j].sigma == 1 else 5] for j in numbers.moving]
        assert error(along + rotors * state["qdd"] + friction, A @ state["qdd"] + H) < TOLERANCE


def test_some_reaction_wrenches_are_those_of_all(tmp_path: Path) -> None:
    machine = two_children(symbolic=True)
    state = whole_state(machine, 2)
    names = tuple(machine.joints[j - 1].name for j in (7, 3, 1))
    code = made(machine, tmp_path, ("reaction_wrenches",), Scene(outputs={"reaction_wrenches": names}))
    wanted = reference.reaction_wrenches(machine, *(state[name].tolist() for name in ("q", "qd", "qdd")))
    for run in code.both():
        (f,) = run("reaction_wrenches", **state)
        assert error(f, [wanted[j - 1] for j in (7, 3, 1)]) < TOLERANCE


def unloaded(machine: Machine, *, wrenches: bool = False) -> Machine:
    joints = (
        replace(joint, friction=Friction(), wrench=joint.wrench if wrenches else Wrench()) for joint in machine.joints
    )
    return replace(machine, joints=tuple(joints))


@pytest.mark.sampled(12)
@pytest.mark.parametrize(("machine", "scene"), VARIOUS)
def test_parts_of_the_bias_forces(machine: Machine, scene: Scene, tmp_path: Path) -> None:
    """Each part is H of a machine on which nothing else acts, and they add up to H; a moving base included."""
    code = made(machine, tmp_path, (*PARTS, "bias_forces"), scene)
    state = whole_state(machine, 4)
    q, qd = state["q"].tolist(), state["qd"].tolist()
    rest, weightless = [0.0] * len(q), replace(machine.base, gravity=NO_VECTOR)
    numbers = numbers_of(machine)
    rows = [numbers.joints[j] for j in numbers.moving]
    wanted = {
        "coriolis_forces": reference.bias_forces(replace(unloaded(machine), base=weightless), q, qd),
        "gravity_forces": reference.bias_forces(on_still_base(unloaded(machine)), q, rest),
        "external_forces": reference.bias_forces(replace(unloaded(machine, wrenches=True), base=Base()), q, rest),
        "friction_forces": [row.coulomb * np.sign(x) + row.viscous * x for row, x in zip(rows, qd, strict=True)],
    }
    for run in code.both():
        parts = {name: run(name, **of_model(name, state))[0] for name in PARTS}
        for name, found in parts.items():
            assert error(found, wanted[name]) < TOLERANCE, name
        (whole,) = run("bias_forces", q=q, qd=qd)
        assert error(sum(parts.values()), whole) < TOLERANCE
        assert error(whole, reference.bias_forces(machine, q, qd)) < TOLERANCE


# Energy


def energies(machine: Machine, numbers: MachineNumbers, q: Sequence[float], qd: Sequence[float]) -> list[float]:
    """Kinetic, gravity, elastic: sums over bodies and joints, from the reference's frames and velocities."""
    kinetic = gravity = elastic = 0.0
    frames = np.array(reference.geometric_model(machine, q), dtype=float)
    screws = np.array(reference.velocities(machine, q, qd), dtype=float)
    for joint, frame, (*v, wx, wy, wz) in zip(numbers.joints, frames, screws, strict=True):
        w, body = np.array([wx, wy, wz]), joint.body
        kinetic += body.mass * np.dot(v, v) / 2 + body.first_moment @ np.cross(v, w) + w @ body.inertia @ w / 2
        gravity -= numbers.base.gravity @ (body.mass * frame[:3, 3] + frame[:3, :3] @ body.first_moment)
    for k, j in enumerate(numbers.moving):
        joint = numbers.joints[j]
        kinetic += joint.rotor_inertia * qd[k] ** 2 / 2
        elastic += joint.stiffness * (q[k] - joint.neutral) ** 2 / 2
    return [kinetic, gravity, elastic]


@pytest.mark.parametrize(("machine", "scene"), VARIOUS)
def test_energy(machine: Machine, scene: Scene, tmp_path: Path) -> None:
    code = made(machine, tmp_path, ("energy",), scene)
    q, qd, _ = random_state(machine, 8)
    wanted = energies(machine, numbers_of(machine), q, qd)
    for run in code.both():
        (found,) = run("energy", q=q, qd=qd)
        for part, exact in zip(found, wanted, strict=True):
            assert part == pytest.approx(exact, rel=1e-12, abs=1e-12 * max(map(abs, wanted)))


def values(machine: Machine, model: TracedModel, state: Mapping[str, Any], arithmetic: Arithmetic = FLOATS) -> Any:
    """The only result of a traced model in some arithmetic."""
    known = {p.name: Bound(machine).cell(p.value) for p in machine.parameters if p.value}
    of = evaluate(known.values(), {}, arithmetic)
    symbols = {name: of(x) if isinstance(x, Expression) else arithmetic.number(x) for name, x in known.items()}
    for argument in model.program.inputs:
        symbols |= zip(argument.symbols, state[argument.name], strict=True)
    (output,) = model.program.outputs
    of = evaluate(output.entries, symbols, arithmetic)
    return np.array([of(x) for x in output.entries]).reshape(output.shape)


MANY = multiprecision(50)
BALANCED = [
    *(pytest.param(random_machine(760 + k, joints=3 + k, symbolic=k % 2 == 0), id=f"tree {k}") for k in range(5)),
    pytest.param(on_still_base(WELDED), id="welded"),
    pytest.param(planar_2r(elastic=(2,)), id="planar 2R"),
]


@pytest.mark.parametrize("machine", BALANCED)
def test_energy_changes_by_the_power_of_what_acts(machine: Machine) -> None:
    """dE/dt = tau.qd - damping - friction - power given to the surroundings, along the motion."""
    q, qd, tau = (np.array([MANY.number(Fraction(x)) for x in part]) for part in random_state(machine, 6))

    def found(model: str, **state: Any) -> Any:
        return values(machine, trace(machine, model), state, MANY)

    qdd = found("direct_dynamics", q=q, qd=qd, tau=tau)
    h = MANY.number(1) / 10**14
    after, before = (sum(found("energy", q=q + t * qd + t**2 / 2 * qdd, qd=qd + t * qdd)) for t in (h, -h))
    numbers = numbers_of(machine)
    torques = -found("friction_forces", qd=qd) - found("external_forces", q=q)
    torques[numbers.motors] += tau
    torques = torques - np.array([MANY.number(numbers.joints[j].damping) for j in numbers.moving]) * qd
    power = torques @ qd
    assert abs((after - before) / (2 * h) - power) < 1e-14 * abs(power)


@pytest.mark.parametrize("machine", BALANCED)
def test_gravity_forces_are_the_slope_of_the_gravity_energy(machine: Machine) -> None:
    """Along a random direction of motion, to 20 digits."""
    q, qd, _ = (np.array([MANY.number(Fraction(x)) for x in part]) for part in random_state(machine, 9))
    model, h = trace(machine, "energy"), MANY.number(1) / 10**14
    after, before = (values(machine, model, {"q": q + t * qd, "qd": qd}, MANY)[1] for t in (h, -h))
    slope = values(machine, trace(machine, "gravity_forces"), {"q": q}, MANY) @ qd
    assert abs((after - before) / (2 * h) - slope) < 1e-20 * abs(slope)


def test_energy_along_a_simulated_motion(tmp_path: Path) -> None:
    """Generated code, RK4, the work of all forces integrated alongside."""
    machine = random_machine(3, joints=4, kinds=("motor", "elastic"))
    smooth = (replace(joint, friction=replace(joint.friction, coulomb=ZERO)) for joint in machine.joints)
    machine = replace(machine, joints=tuple(smooth))
    code = made(machine, tmp_path, ("direct_dynamics", "energy", "friction_forces", "external_forces")).module
    numbers = numbers_of(machine)
    n, damping = len(numbers.moving), np.array([numbers.joints[j].damping for j in numbers.moving])
    tau = np.array([10.0, -20.0, 5.0, 30.0])[: len(numbers.motors)]

    def rate(t: float, x: Array) -> Array:
        q, qd = x[:n], x[n : 2 * n]
        torques = -damping * qd - code.friction_forces(qd) - code.external_forces(q)
        torques[numbers.motors] += tau
        return np.array([*qd, *code.direct_dynamics(q, qd, tau), torques @ qd])

    x, dt = np.array([*random_state(machine, 1)[0], *[0.1] * n, 0.0]), 2.5e-4
    kept = [code.energy(x[:n], x[n : 2 * n])]
    for _ in range(400):
        x = step(RK4, rate, 0.0, x, dt)
        kept.append(code.energy(x[:n], x[n : 2 * n]))
        assert abs(sum(kept[-1]) - sum(kept[0]) - x[-1]) < 1e-7 * np.abs(kept).max()
    swing = np.ptp(kept, axis=0)
    assert np.all(swing > 1) and abs(x[-1]) > 1


# Only what matters


def used(machine: Machine, model: str, *outputs: str) -> set[str]:
    """Variables of the joints on which the code of a model depends."""
    scene = Scene((model,), {model: outputs} if outputs else {})
    (traced,) = trace_scene(machine, scene)
    return {name for name in traced.program.used if name in {str(j.variable) for j in machine.joints}}


NEEDED = [
    pytest.param("geometric_model", ("joint5 in joint3",), "45", id="between two frames"),
    pytest.param("geometric_model", ("joint3 in joint5",), "45", id="and back"),
    pytest.param("geometric_model", ("joint4 in joint4",), "", id="a frame in itself"),
    pytest.param("velocities", ("joint6",), "23456", id="velocity in its own axes"),
    pytest.param("velocities", ("joint6 in base",), "12345", id="velocity in the axes of the base"),
    pytest.param("velocities", ("joint6 in joint3",), "2345", id="velocity in the axes of another frame"),
    pytest.param("accelerations", ("joint6 in joint6",), "23456", id="acceleration in its own axes"),
    pytest.param("accelerations", ("joint4 in base",), "123", id="acceleration in the axes of the base"),
    pytest.param("jacobian", ("joint6",), "12345", id="Jacobian in the axes of the base"),
    pytest.param("jacobian", ("joint6 in joint6",), "23456", id="Jacobian in its own axes"),
    pytest.param("jacobian", ("joint6 in joint3",), "2345", id="Jacobian in the axes of another frame"),
    pytest.param("jacobian_dot_qd", ("joint6",), "12345", id="rest of the acceleration in the axes of the base"),
    pytest.param("jacobian_dot_qd", ("joint4 in joint2",), "23", id="rest of the acceleration in other axes"),
    pytest.param("coriolis_forces", (), "23456", id="Coriolis forces"),
    pytest.param("gravity_forces", (), "23456", id="gravity forces under a vertical axis"),
    pytest.param("friction_forces", (), "", id="friction forces"),
    pytest.param("external_forces", (), "", id="no external wrench"),
    pytest.param("reaction_wrenches", (), "23456", id="reaction wrenches on a vertical axis"),
    pytest.param("energy", (), "23456", id="energy on a vertical axis"),
]


@pytest.mark.parametrize(("model", "outputs", "needed"), NEEDED)
def test_angles_that_do_not_matter_are_absent(model: str, outputs: tuple[str, ...], needed: str) -> None:
    assert used(chain(6), model, *outputs) == {f"q{j}" for j in needed}


def test_no_sine_nor_unused_variable_in_the_code(tmp_path: Path) -> None:
    """What the last test says of the graph, in the text; the compiler refuses variables that are not used."""
    scene = Scene(MOTIONS, dict.fromkeys(MOTIONS, ("joint6 in joint3",)))
    machine = chain(6)
    files = render_c(package(machine, trace_scene(machine, scene), ()))
    assert all(f"q[{j - 1}]" in files["chain6.c"] for j in (2, 3, 4, 5))
    assert not any(word in files["chain6.c"] for word in ("q[0]", "q[5]", "P_XX1]", "P_M3]"))
    compile_library(files, tmp_path)


def inclined(machine: Machine, seed: int) -> Machine:
    """The machine with alpha and d drawn anew: no axis is parallel to another or meets it."""
    drawn = np.random.default_rng(seed).uniform(0.2, 1.2, (len(machine.joints), 2)).round(3).tolist()
    rows = zip(machine.joints, drawn, strict=True)
    return replace(machine, joints=tuple(replace(joint, alpha=cell(a), d=cell(d)) for joint, (a, d) in rows))


@pytest.mark.thorough
@pytest.mark.parametrize("seed", range(6))
def test_every_variable_in_the_code_matters(seed: int) -> None:
    """On a tree without parallel axes: a change of a variable that the code reads changes the result."""
    machine = inclined(random_machine(780 + seed, joints=7, moving_base=seed % 4 == 0), seed)
    state = whole_state(machine, seed)
    for model in OF_FRAMES:
        for j, k in places_of(machine, seed):
            traced = trace(machine, model, (Frame(j, k),))
            before = values(machine, traced, state)
            for argument in traced.program.inputs:
                for entry, name in enumerate(argument.symbols):
                    if name not in traced.program.used:
                        continue
                    moved = {**state, argument.name: state[argument.name].copy()}
                    moved[argument.name][entry] += 0.3
                    change = abs(values(machine, traced, moved) - before).max()
                    assert change > 1e-9, (model, j, k, name)


LINEAR = ("velocities", "accelerations", "jacobian_dot_qd", "reaction_wrenches", *PARTS, "energy", "geometric_model")


@pytest.mark.thorough
@pytest.mark.parametrize("model", [*LINEAR, "jacobian"])
def test_operations_of_long_machines(model: str) -> None:
    """Twice as many joints, twice (or four times) the operations."""
    tree = trace(random_machine(1, joints=30, symbolic=True), model).program.count
    chains = [trace(chain(n, base=WEIGHT), model).program.count for n in (15, 30)]
    (few, some), (many, more) = ((count.products, count.add) for count in chains)
    growth = 4.1 if model == "jacobian" else 2.3
    assert many <= growth * few and more <= growth * some
    assert (tree.products <= many and tree.add <= more) or model in ("friction_forces", "external_forces")


@pytest.mark.sampled(12)
@pytest.mark.parametrize("model", [*LINEAR, "jacobian"])
def test_work_of_tracing_long_machines(model: str) -> None:
    """Twice as many joints, twice (or four times) the work; 30 joints are traced in a moment."""
    trace(chain(2, base=WEIGHT), model)
    few, many = (calls_of(lambda n=n: trace(chain(n, base=WEIGHT), model)) for n in (15, 30))  # type: ignore[misc]
    tree = calls_of(lambda: trace(random_machine(1, joints=30, symbolic=True), model))
    assert many <= (4.1 if model == "jacobian" else 2.3) * few
    assert max(many, tree) < 2_000_000, "some tenths of a second"


@pytest.mark.parametrize(
    ("model", "outputs", "products", "sums"),
    [
        pytest.param("geometric_model", ("joint6",), 136, 78, id="placement"),
        pytest.param("velocities", ("joint6",), 90, 55, id="velocity"),
        pytest.param("jacobian", ("joint6",), 142, 80, id="Jacobian in the axes of the base"),
        pytest.param("jacobian", ("joint6 in joint3",), 88, 51, id="Jacobian in the axes of the forearm"),
        pytest.param("jacobian_dot_qd", ("joint6",), 222, 159, id="rest of the acceleration"),
        pytest.param("energy", (), 296, 199, id="energy"),
    ],
)
def test_operation_counts_do_not_grow(model: str, outputs: tuple[str, ...], products: int, sums: int) -> None:
    (traced,) = trace_scene(chain(6), Scene((model,), {model: outputs} if outputs else {}))
    count = traced.program.count
    assert count.products <= products and count.add <= sums


# What cannot be had


@pytest.mark.parametrize(
    ("model", "output", "reason"),
    [
        ("velocities", "joint9", "no frame 'joint9'; did you mean"),
        ("jacobian", "joint2 in tabel", "no frame 'tabel'"),
        ("jacobian", "tool in base", "no frame 'tool'"),
        ("accelerations", "joint1 in joint2 in joint3", "write one frame in one other"),
        ("geometric_model", "joint1 in ", "no frame ''"),
        ("reaction_wrenches", "joint1 in base", "only geometric_model, velocities"),
        ("coriolis_forces", "joint1 in joint2", "only geometric_model, velocities"),
        ("velocity", "joint1", "no model 'velocity'; did you mean 'velocities'"),
        ("gravity_forces", "joint7", "no joint 'joint7'"),
    ],
)
def test_names_that_the_machine_has_not(model: str, output: str, reason: str) -> None:
    with pytest.raises(InputError) as caught:
        resolve(Scene((model,), {model: (output,)}), chain(3), MODELS)
    said = str(caught.value)
    assert said.startswith("chain3: scene, ") and reason in said and "\n" not in said


@pytest.mark.parametrize("model", ["coriolis_forces", "gravity_forces", "friction_forces", "external_forces"])
def test_forces_of_a_fixed_frame(model: str) -> None:
    with pytest.raises(InputError, match=r"joint 3 \(plate\) is a fixed frame and has no part in this model"):
        trace_scene(WELDED, resolve(Scene((model,), {model: ("plate",)}), WELDED))


@pytest.mark.parametrize("model", ["jacobian", "jacobian_dot_qd"])
def test_no_jacobian_where_nothing_moves(model: str) -> None:
    scene = Scene((model,), locked={f"joint{j}": cell(0.1) for j in (1, 2)})
    with pytest.raises(InputError, match=rf"^planar_2r: {model}: no joint moves, so no frame has a Jacobian"):
        trace_scene(planar_2r(), scene)


def test_frames_and_wrenches_where_nothing_moves(tmp_path: Path) -> None:
    """A locked machine on a moving base still has these."""
    machine = random_machine(721, joints=4, moving_base=True)
    locked = {machine.joints[j - 1].name: cell(0.25) for j in machine.independent}
    models = ("velocities", "accelerations", "reaction_wrenches", "energy")
    code = made(machine, tmp_path, models, Scene(locked=locked))
    still = [0.0] * len(machine.independent)
    state = {"q": [0.25] * len(still), "qd": still, "qdd": still}
    exact = (state["q"], still, still)
    wanted = {
        "velocities": reference.velocities(machine, state["q"], still),
        "accelerations": reference.accelerations(machine, *exact),
        "reaction_wrenches": reference.reaction_wrenches(machine, *exact),
        "energy": [*energies(machine, numbers_of(machine), state["q"], still)[:2], 0.0],
    }
    for model in models:
        for run in code.both():
            (found,) = run(model, **of_model(model, dict.fromkeys(state, np.zeros(0))))
            assert error(found, wanted[model]) < TOLERANCE, model
