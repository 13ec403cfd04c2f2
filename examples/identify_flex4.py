"""Identification of flex4 from simulated, noisy measurements: an exciting motion, a virtual experiment, estimates.

    python examples/identify_flex4.py [FOLDER]

The table has no numbers, so plausible values are chosen here. Encoders on all four joints have 20 bits and a noise of
one step, torques a noise of 0.3 and 0.1 N m. The model is perfect here: a real machine is a harder case. Writes
the data (CSV) and three pictures to FOLDER (default: identified_flex4).
"""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

from symoro_elastic.analysis.simulation.simulated_measurements import Controller, Sensors, measure, simulate
from symoro_elastic.analysis.time_series.measurements import read_measurements, write_measurements
from symoro_elastic.formats import read_machine
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import Friction, Machine, Spring
from symoro_elastic.measured.logs.excitation import excite
from symoro_elastic.measured.logs.fourier_motion import FourierMotion, Limits
from symoro_elastic.measured.logs.identify import LogSettings, identify
from symoro_elastic.measured.logs.result import Identification
from symoro_elastic.measured.logs.views import table

HERE = Path(__file__).parent
GEOMETRY = {"L2": 0.5, "G3": -9.81}
LINKS = {  # kg, m: bodies 1 and 3 are what turns with the motors, 2 and 4 the arms beyond the springs
    "ZZ1": 0.05, "M1": 2, "YY2": 0.5, "ZZ2": 0.5, "XX2": 0.02, "MX2": 1.5, "M2": 6,
    "XX3": 0.004, "YY3": 0.003, "ZZ3": 0.005, "M3": 1,
    "XX4": 0.012, "XY4": -0.01, "YY4": 0.16, "ZZ4": 0.165, "MX4": 0.6, "MY4": 0.05, "M4": 3,
}  # fmt: skip
MOTORS_AND_SPRINGS = {"IA1": 0.5, "IA3": 0.15, "k2": 1500.0, "k4": 400.0}
DAMPING, NEUTRAL = {"j2": 0.4, "j4": 0.15}, {"j2": 0.01, "j4": -0.02}  # N m s/rad, rad
FRICTION = {"j1": (3.0, 2.0), "j3": (1.0, 1.0)}  # viscous N m s/rad, dry N m
BALANCED = {f"{name}3": 0.0 for name in ("XY", "XZ", "YZ", "MX", "MY")}  # rotor 3: known by construction


def machine_with_losses() -> Machine:
    """flex4 with friction of the motors, damping and neutral positions of the springs, which its .par leaves out."""
    machine, _ = read_machine(HERE / "flex4.par")
    joints = []
    for joint in machine.joints:
        if joint.name in DAMPING:
            law = (joint.spring.stiffness, Formula.parse(DAMPING[joint.name]), Formula.parse(NEUTRAL[joint.name]))
            joint = replace(joint, spring=Spring(*law))  # noqa: PLW2901
        else:
            joint = replace(joint, friction=Friction(*map(Formula.parse, FRICTION[joint.name])))  # noqa: PLW2901
        joints.append(joint)
    return replace(machine, joints=tuple(joints))


def values(machine: Machine) -> dict[str, float]:
    """A number for every parameter; inertial parameters that are not listed are zero."""
    zero = {p.name: 0.0 for p in machine.parameters}
    return {**zero, **GEOMETRY, **LINKS, **MOTORS_AND_SPRINGS}


def exciting_motion(machine: Machine) -> FourierMotion:
    """Five harmonics of 0.5 Hz within limits of the two motors (rad, rad/s, rad/s2)."""
    limits = Limits.of([-1.2, -1.0], [1.2, 1.0], [2.5, 3.0], [15.0, 20.0])
    found = excite(machine, limits, 0.5, 5, values(machine), tuple(BALANCED), evaluations=400)
    print(f"condition number of the regressor: {found.before:.1f} at a random motion, {found.condition:.1f} excited")
    return found.motion


def accuracy(found: Identification) -> None:
    """How far the estimates are from the truth that the simulation knows."""
    errors = [(e.value - e.unknown.nominal, e) for e in found.estimates if e.verdict == "identified"]
    worst = max(abs(error / e.unknown.nominal) for error, e in errors if e.unknown.nominal)
    inside = sum(abs(error) < 2 * e.std for error, e in errors)
    print(f"{len(errors)} identified, the farthest {100 * worst:.2g} % off; {inside} within two standard deviations")


def main(folder: Path) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    machine = machine_with_losses()
    motion = exciting_motion(machine)
    controller = Controller.of_bandwidth([2.0, 0.4], frequency=4.0)
    true = simulate(machine, values(machine), motion.at, controller, duration=10.0, sampling=1000.0, settle=2.0)
    step = np.full(4, 2 * np.pi / 2**20)
    write_measurements(measure(true, Sensors(step, step, np.array([0.3, 0.1]))), machine, folder / "flex4.csv")

    measured = read_measurements(folder / "flex4.csv", machine)
    found = identify(machine, measured, LogSettings(values=values(machine), known=BALANCED))
    print(table(found, {e.unknown.label: e.unknown.nominal for e in found.estimates}))
    for name, (q0, std) in found.neutral.items():
        print(f"neutral position of {name}: {q0:.6f} rad, std {std:.1e}, true {NEUTRAL[name]}")
    accuracy(found)
    for path in found.plots().save(folder):
        print(f"wrote {path}")


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "identified_flex4"))
