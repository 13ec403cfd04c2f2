"""Machines and motions that predictions are tried on."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from symoro_elastic.analysis.simulation.reference_motion import Reference
from symoro_elastic.formats import read_machine
from symoro_elastic.machine.formula import ZERO
from symoro_elastic.machine.machine import Body, Joint, Kind, Machine, Spring
from symoro_elastic.machine.prescribed_motion import AppliedForce, Bandwidth, Servo
from symoro_elastic.numerics.evaluation.values import parameter_values
from symoro_elastic.numerics.motion.equations_of_motion import EquationsOfMotion
from tests.analysis.ladder.motions import moved
from tests.command_line import EXAMPLES
from tests.compiled_models import cell
from tests.references.random_machines import random_machine


@dataclass(frozen=True)
class Scene:
    """A motion, outputs, and the tolerance of all of them, m or rad."""

    title: str
    reference: Reference
    outputs: tuple[str, ...]
    tolerance: float

    @property
    def tolerances(self) -> dict[str, float]:
        return dict.fromkeys(self.outputs, self.tolerance)


def two_axis() -> Machine:
    return read_machine(EXAMPLES / "two_axis.toml")[0]


def flex4() -> Machine:
    machine, _ = read_machine(EXAMPLES / "flex4.par")
    values = parameter_values(machine, 3)
    return replace(machine, parameters=tuple(replace(p, value=cell(values[p.name])) for p in machine.parameters))


def with_springs(machine: Machine) -> Machine:
    """The machine with a spring behind each motor, on its axis; the motor keeps its rotor, the spring has the body."""
    joints: list[Joint] = []
    number = {0: 0}
    for j, joint in enumerate(machine.joints, start=1):
        before = number[joint.antecedent]
        if joint.kind is not Kind.MOTOR:
            joints.append(replace(joint, antecedent=before))
        else:
            joints.append(replace(joint, antecedent=before, body=Body()))
            behind = Joint(f"{joint.name}_spring", len(joints), Kind.ELASTIC, joint.sigma, f"{joint.variable}_s")
            joints.append(replace(behind, body=joint.body, spring=Spring(cell(1))))
        number[j] = len(joints)
    return replace(machine, joints=tuple(joints))


def tuned(machine: Machine, frequencies: Sequence[float], damping: float = 0.0) -> Machine:
    """The machine with springs that vibrate at so many Hz, in turn, all else held at q = 0; neutral at 0.

    `damping` is the damping ratio of each.
    """
    motion = EquationsOfMotion(machine)
    zero = np.zeros(len(motion.joints))
    (M,) = motion.matrices("M", zero, zero, zero)
    inertia = dict(zip(motion.names, np.diag(M), strict=True))
    found, springs = [], 0
    for joint in machine.joints:
        if joint.kind is Kind.ELASTIC:
            w = 2 * np.pi * frequencies[springs % len(frequencies)]
            law = Spring(cell(_short(inertia[joint.name] * w**2)), cell(_short(2 * damping * w * inertia[joint.name])))
            found.append(replace(joint, spring=law))
            springs += 1
        else:
            found.append(joint)
    return replace(machine, joints=tuple(found))


def _short(x: float) -> float:
    return float(f"{x:.6g}")


def random_springs(seed: int, joints: int, frequencies: Sequence[float], damping: float = 0.0) -> Machine:
    """A random tree of motors and springs, with gravity."""
    kinds = (Kind.MOTOR, Kind.ELASTIC, Kind.ELASTIC)
    machine = random_machine(seed, joints=joints, kinds=kinds, friction=False, wrenches=False, massless=0.0)
    plain = tuple(
        replace(j, spring=Spring(cell(1)), rotor_inertia=j.rotor_inertia if j.kind is Kind.MOTOR else ZERO)
        if j.kind is Kind.ELASTIC
        else j
        for j in machine.joints
    )
    return tuned(replace(machine, joints=plain), frequencies, damping)


def last_frame(machine: Machine, axes: str = "xyz") -> tuple[str, ...]:
    return tuple(f"{machine.joints[-1].name}.{axis}" for axis in axes)


def all_motors(machine: Machine, by: float, lasts: float) -> dict[str, tuple[float, float]]:
    """Motors by so much, every other one backwards."""
    return {joint.name: (by * (-1) ** k, lasts) for k, joint in enumerate(machine.motor_joints)}


def moving(
    title: str, machine: Machine, by: float, lasts: float, tolerance: float, servo: Servo | None = None
) -> Scene:
    """All motors from rest to rest, and as long again by a half to settle; position of the last frame."""
    servos = {joint.name: servo for joint in machine.motor_joints} if servo else None
    reference = moved(machine, 1.5 * lasts, all_motors(machine, by, lasts), servo=servos)
    return Scene(title, reference, last_frame(machine), tolerance)


def tool_scene(title: str, lasts: float, servo: Servo | None = None, forces: Sequence[AppliedForce] = ()) -> Scene:
    """The two-axis machine: 80 x 50 mm in so many s."""
    machine = two_axis()
    servos = {joint.name: servo for joint in machine.motor_joints} if servo else None
    moves = {"motor_x": (0.08, lasts), "motor_y": (0.05, lasts)}
    reference = moved(machine, 1.5 * lasts, moves, {"motor_x": 0.0, "motor_y": 0.1}, servos, forces)
    return Scene(title, reference, ("tool.x", "tool.y"), 1e-5)


def arm(file: str, frequencies: Sequence[float], damping: float = 0.0) -> Machine:
    """An arm of the examples with a spring behind each motor."""
    machine, _ = read_machine(EXAMPLES / file)
    values = parameter_values(machine, 5)
    named = tuple(replace(p, value=cell(_short(values[p.name]))) for p in machine.parameters)
    return tuned(with_springs(replace(machine, parameters=named)), frequencies, damping)


def many() -> dict[str, Callable[[], Scene]]:
    """Scenes of a benchmark: machine tools, arms and random trees, motors that follow exactly and servos."""
    slow, stiff = Bandwidth(8, 0.7), Bandwidth(25, 0.8)
    push = AppliedForce("tool", (200.0, 0.0, 100.0, 0.0, 0.0, 0.0), 0.02, 0.03)
    found: dict[str, Callable[[], Scene]] = {
        "two_axis, 150 ms": lambda: tool_scene("", 0.15),
        "two_axis, 60 ms": lambda: tool_scene("", 0.06),
        "two_axis, 100 ms, servos": lambda: tool_scene("", 0.1, stiff),
        "two_axis, 80 ms, pushed": lambda: tool_scene("", 0.08, forces=[push]),
        "flex4": lambda: moving("", tuned(flex4(), (40,)), 0.5, 0.3, 1e-5),
        "flex4, fast": lambda: moving("", tuned(flex4(), (40, 60)), 0.3, 0.1, 1e-5),
        "flex4, servos": lambda: moving("", tuned(flex4(), (40,)), 0.3, 0.3, 1e-5, slow),
        "rx90": lambda: moving("", arm("rx90.par", (40, 60)), 0.5, 0.4, 1e-5),
        "rx90, damped": lambda: moving("", arm("rx90.par", (30, 90), 0.01), 0.3, 0.2, 1e-5),
        "rx90, servos": lambda: moving("", arm("rx90.par", (30, 60), 0.01), 0.3, 0.4, 1e-5, Bandwidth(6, 0.7)),
        "puma560": lambda: moving("", arm("puma560.par", (50, 80)), 0.5, 0.4, 1e-5),
        "puma560, fast": lambda: moving("", arm("puma560.par", (25, 40), 0.02), 0.2, 0.15, 1e-5),
    }
    for seed in (11, 12, 13, 14, 15, 16, 18, 19, 20, 21):
        machine = partial(random_springs, seed, 6 + seed % 4, (20 + seed, 90, 50), 0.01 * (seed % 3))
        lasts, servo = 0.15 + 0.05 * (seed % 3), slow if seed % 5 == 0 else None
        found[f"random {seed}"] = partial(
            lambda made, t, law: moving("", made(), 0.2, t, 1e-5, law), machine, lasts, servo
        )
    return found
