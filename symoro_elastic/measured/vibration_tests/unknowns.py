"""Unknowns of vibration tests: parameters that are estimated or uncertain, their values in the file and their priors.

The unknowns are x = ln p: positive, of one size, with relative standard deviations. A prior,
x ~ N(ln p_file, ln(factor)^2), keeps at the value of the file what no test tells.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from symoro_elastic.analysis.vibration.linearization import linearize, with_motors
from symoro_elastic.analysis.vibration.modes import modes, strain_shares
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.columns import Dimension, cells
from symoro_elastic.machine.described import AnyMachine
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import Kind, Machine
from symoro_elastic.machine.names import no_such
from symoro_elastic.measured.fitting.estimates import Unknown
from symoro_elastic.measured.fitting.evidence import OtherData
from symoro_elastic.measured.vibration_tests.measured import VibrationTest
from symoro_elastic.numerics.motion.equations_of_motion import EquationsOfMotion, motion_of
from symoro_elastic.numerics.motion.equilibrium import equilibrium

SOUGHT = frozenset({Dimension.STIFFNESS, Dimension.DAMPING, Dimension.VISCOUS_FRICTION})
DOUBTED = frozenset({Dimension.MASS, Dimension.INERTIA, Dimension.ROTOR_INERTIA})
FIRST_DAMPING = 0.02  # damping ratio that springs without damping in the file start at
FIRST_SERVO = 20.0  # frequency, Hz, that unknown gains of a motor give its own inertia at the start
STARTED_FACTOR = 10.0  # factor within which values are that no file gives
FRICTION = "viscous"
KP, KD = "kp", "kd"


@dataclass(frozen=True)
class Sought:
    """Unknowns of tests, the machine with initial damping, and notes on assumptions."""

    machine: AnyMachine  # type: ignore[valid-type]
    unknowns: tuple[Unknown, ...]
    notes: tuple[str, ...]

    @property
    def start(self) -> Array:
        """Logarithms (p,) of the initial values."""
        return np.log([unknown.nominal for unknown in self.unknowns])

    @property
    def prior(self) -> Array:
        """Inverse prior variances (p,) of the logarithms."""
        return np.array([unknown.prior_std for unknown in self.unknowns]) ** -2.0

    @property
    def labels(self) -> tuple[str, ...]:
        """Names of the unknowns."""
        return tuple(unknown.label for unknown in self.unknowns)


def gain_label(motor: str, gain: str) -> str:
    """Return the label of an unknown gain of a motor's controller."""
    return f"{motor}.{gain}"


def sought_of(
    machine: Machine,
    seek: Sequence[str],
    factor: float,
    mass_doubt: float,
    other: OtherData | None,
    tests: Sequence[VibrationTest],
) -> Sought:
    """Return the unknowns of tests: every stiffness, damping and viscous friction, or those that `seek` names.

    The friction of motors that all tests hold is not. With `other` data, masses and inertias that these
    determine are unknown, too.
    Springs without damping start at 2 % of critical in the mode with most of their strain energy. With a `mass_doubt`,
    a relative standard deviation, masses and inertias are unknown to that. Raises `InputError` for unknown names.
    """
    notes: list[str] = []
    if not seek or any(label.endswith(".damping") for label in seek):
        machine, notes = _with_damping(machine, tests[0], seek)
    started = {line.partition(" = ")[0] for line in notes}
    motion = motion_of(machine)
    parameters = dict(_parameters(motion))
    still = set.intersection(*(set(held_in(test, motion.motor_names)) for test in tests))
    idle = {f"{motor}.{FRICTION}" for motor in still}
    usual = [name for name, (dimensions, _) in parameters.items() if dimensions <= SOUGHT and name not in idle]
    chosen = [*(seek or usual), *(other.informed if other else ())]
    _refuse_unknown(machine, motion, chosen, parameters)
    unknowns = [
        _unknown(name, motion, parameters[name][1], STARTED_FACTOR if name in started else factor, name in started)
        for name in chosen
    ]
    doubted = [name for name, (dimensions, _) in parameters.items() if dimensions <= DOUBTED] if mass_doubt else []
    unknowns += [
        replace(_unknown(name, motion, parameters[name][1], 2.0, False), prior_std=mass_doubt, is_nuisance=True)
        for name in doubted
        if name not in chosen and motion.parameters[name] > 0
    ]
    if started:
        notes = [f"springs without damping start at {FIRST_DAMPING:.0%} of critical: {', '.join(sorted(started))}"]
    return Sought(machine, (*unknowns, *_unknown_gains(motion, tests)), tuple(notes))


def _refuse_unknown(
    machine: Machine, motion: EquationsOfMotion, chosen: Sequence[str], parameters: Collection[str]
) -> None:
    """Raise `InputError` for names without a parameter, values that are not positive, and where none is left."""
    for name in chosen:
        if name not in parameters:
            raise InputError(machine.label, "--seek", no_such("parameter", name, parameters))
        if not motion.parameters[name] > 0:
            what = f"{name} is {motion.parameters[name]:g}: only positive numbers are sought, by their logarithm"
            raise InputError(machine.label, "--seek", what)
    if not chosen:
        raise InputError(machine.label, "--seek", "no stiffness, damping or viscous friction: name what is sought")


def positive_inertias(machine: Machine) -> list[str]:
    """Return names of the masses, inertias and rotor inertias of a machine that are positive."""
    motion = motion_of(machine)
    named = [name for name, (dimensions, _) in _parameters(motion) if dimensions <= DOUBTED]
    return [name for name in named if motion.parameters[name] > 0]


def _unknown(name: str, motion: EquationsOfMotion, unit: str, factor: float, is_guess: bool) -> Unknown:
    return Unknown(name, unit, motion.parameters[name], math.log(factor), of_file=not is_guess)


def _parameters(motion: EquationsOfMotion) -> Iterator[tuple[str, tuple[frozenset[Dimension], str]]]:
    """Yield the parameters of cells, with the dimensions of all cells that they are in, and the unit of the first."""
    dimensions: dict[str, set[Dimension]] = {}
    units: dict[str, str] = {}
    for joint in motion.machine.joints:
        for cell, formula in cells(joint):
            for name in formula.names & motion.parameters.keys():
                dimensions.setdefault(name, set()).add(cell.column.dimension)
                units.setdefault(name, cell.column.dimension.units[joint.sigma == 1])
    units_of_file = {p.name: p.unit for p in motion.given.parameters}
    for name, found in dimensions.items():
        yield name, (frozenset(found), units_of_file.get(name) or units[name])


def _with_damping(machine: Machine, test: VibrationTest, seek: Sequence[str]) -> tuple[Machine, list[str]]:
    """Return the machine with damping in its springs, d = 2 ratio k / omega, and lines `label = value`."""
    bare = [
        joint.name
        for joint in machine.joints
        if joint.kind is Kind.ELASTIC and joint.spring.damping.is_zero and joint.friction.viscous.is_zero
        if not seek or f"{joint.name}.damping" in seek
    ]
    if not bare:
        return machine, []
    motion = motion_of(machine)
    linear = linearize(motion, equilibrium(motion, test.at))
    modal = modes(with_motors(linear, held_in(test, motion.motor_names)))
    shares, omega = strain_shares(modal), np.sqrt(np.maximum(modal.eigenvalues, 0.0))
    stiffness = dict(zip(motion.springs, motion.spring_stiffnesses(linear.state.q), strict=True))
    first = {}
    for name in bare:
        mode = int(np.argmax(np.where(omega > 0, shares.by_name[name], -1.0)))
        first[name] = float(f"{2 * FIRST_DAMPING * stiffness[name] / omega[mode]:.4g}")
    bare_springs = {joint.name: joint.spring for joint in machine.joints if joint.name in first}
    springs = {k: replace(spring, damping=Formula.parse(first[k])) for k, spring in bare_springs.items()}
    joints = tuple(replace(joint, spring=springs.get(joint.name, joint.spring)) for joint in machine.joints)
    return replace(machine, joints=joints), [f"{name}.damping = {x:g}" for name, x in first.items()]


def held_in(test: VibrationTest, motors: Sequence[str]) -> list[str]:
    """Return the names of the motors that a test locks."""
    return list(motors) if "all" in test.hold else list(test.hold)


def _unknown_gains(motion: EquationsOfMotion, tests: Sequence[VibrationTest]) -> list[Unknown]:
    """Return the controller gains that tests omit as unknowns, starting from a well-damped servo."""
    motors = list(dict.fromkeys(name for test in tests for name, gains in test.pd.items() if gains is None))
    if not motors:
        return []
    state = equilibrium(motion, tests[0].at)
    (M,), found = motion.matrices("M", state.q, state.qd, state.qdd), []
    rows, omega = motion.motor_slopes(state.q), 2 * math.pi * FIRST_SERVO
    for motor in motors:
        m = motion.motor(motor, "pd")
        inertia = float(rows[m] @ M @ rows[m] / (rows[m] @ rows[m]) ** 2)
        turns = motion.machine.motor_joints[m].sigma == 0
        units = ("N m/rad", "N m s/rad") if turns else ("N/m", "N s/m")
        starts = (inertia * omega**2, 1.4 * inertia * omega)
        found += [
            Unknown(gain_label(motor, gain), unit, x, math.log(STARTED_FACTOR), of_file=False, is_gain=True)
            for gain, unit, x in zip((KP, KD), units, starts, strict=True)
        ]
    return found


def gains_in(test: VibrationTest, values: Mapping[str, float]) -> dict[str, tuple[float, float]]:
    """Return the gains of the controllers in a test; unknown ones are among the values by label."""
    return {
        motor: given or (values[gain_label(motor, KP)], values[gain_label(motor, KD)])
        for motor, given in test.pd.items()
    }
