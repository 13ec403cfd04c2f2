"""Stiffnesses, dampings, masses and friction of the two-axis machine from simulated, noisy measurements.

    python examples/identify_two_axis.py [FOLDER]

Deflections are some 10 um, so they are measured with 10 nm (1e-8 rad) resolution, the axes with 100 nm, forces with a
noise of 10 N. The model is perfect here: a real machine is a harder case. The true values are the estimates of
two_axis.toml; damping and friction are chosen here. Writes three pictures and the data to FOLDER (default:
identified_two_axis).
"""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

from symoro_elastic.analysis.simulation.simulated_measurements import Controller, Sensors, measure, simulate
from symoro_elastic.formats import read_machine
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import Friction, Kind, Machine
from symoro_elastic.measured.logs.identify import LogSettings, identify
from symoro_elastic.measured.logs.result import Identification
from symoro_elastic.measured.logs.views import table

HERE = Path(__file__).parent
DAMPING = 1e-4  # s, over stiffness
FRICTION = {"motor_x": (400.0, 80.0), "motor_y": (600.0, 120.0)}  # viscous N s/m, dry N
RESOLUTION = {"motor_x": 1e-7, "motor_y": 1e-7}  # m, others 1e-8 m or rad
# Weighed before mounting, or known by design: the sensor head, which no motor senses; centres of mass of parts
# whose yaw does not reveal them; springs without preload.
KNOWN = {"M13": 0.6, "MX13": 0, "MZ13": 0, "M10": 8, "MX10": 0, "MZ10": 0, "MX4": 0, "MZ4": 0, "MX5": 0, "MZ5": 0,
         "MZ3": 0, "MX11": 0, "MZ11": -14.25, "IA5": 0}  # fmt: skip
KNOWN |= {f"KQ{j}": 0.0 for j in (1, 2, 3, 4, 6, 7, 8, 10, 11, 13)}
HARMONICS = np.array([[1, 4, 11, 37], [1, 3, 13, 29]])  # Hz
STROKES = np.array([[0.04, 0.008, 0.0012, 0.0001], [0.06, 0.006, 0.0015, 0.00012]])  # m
PHASES = np.array([[0.0, 1.0, 2.0, 0.3], [0.5, 0.3, 1.7, 2.0]])


def machine_with_losses() -> Machine:
    machine, _ = read_machine(HERE / "two_axis.toml")
    joints = []
    for joint in machine.joints:
        if joint.kind is Kind.ELASTIC:
            damping = Formula.parse(DAMPING * joint.spring.stiffness.value())
            joint = replace(joint, spring=replace(joint.spring, damping=damping))  # noqa: PLW2901
        if joint.name in FRICTION:
            joint = replace(joint, friction=Friction(*map(Formula.parse, FRICTION[joint.name])))  # noqa: PLW2901
        joints.append(joint)
    return replace(machine, joints=tuple(joints))


def motion(t: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Sines up to the first natural frequencies of the structure (26 to 37 Hz), about x = 0.3, y = 0.1 m."""
    w = 2 * np.pi * HARMONICS
    sine, cosine = np.sin(w * t + PHASES), np.cos(w * t + PHASES)
    centre = np.array([0.3, 0.1])
    return (
        centre + (STROKES * sine).sum(axis=1),
        (STROKES * w * cosine).sum(axis=1),
        -(STROKES * w**2 * sine).sum(axis=1),
    )


def sensors(machine: Machine) -> Sensors:
    names = [machine.joints[j - 1].name for j in machine.independent]
    step = np.array([RESOLUTION.get(name, 1e-8) for name in names])
    return Sensors(step, step / 2, np.array([10.0, 10.0]))


def accuracy(found: Identification) -> None:
    """How far the estimates are from the truth that the simulation knows."""
    errors = [(e.value - e.unknown.nominal, e) for e in found.estimates if e.verdict == "identified"]
    worst = max(errors, key=lambda pair: abs(pair[0] / pair[1].unknown.nominal) if pair[1].unknown.nominal else 0.0)
    inside = sum(abs(error) < 2 * e.std for error, e in errors)
    off = 100 * abs(worst[0] / worst[1].unknown.nominal)
    print(f"{len(errors)} identified, the farthest {worst[1].unknown.label}, {off:.2g} % off; {inside} within two std")


def main(folder: Path) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    machine = machine_with_losses()
    controller = Controller.of_bandwidth([460.0, 490.0], frequency=12.0)
    true = simulate(machine, {}, motion, controller, duration=3.0, sampling=2500.0, substeps=4, settle=1.0)
    measured = measure(true, sensors(machine))
    np.savez(folder / "two_axis.npz", t=measured.t, q=measured.q, tau=measured.tau)
    found = identify(machine, measured, LogSettings(known=KNOWN))
    print(table(found, {e.unknown.label: e.unknown.nominal for e in found.estimates}))
    accuracy(found)
    for path in found.plots().save(folder):
        print(f"wrote {path}")


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "identified_two_axis"))
