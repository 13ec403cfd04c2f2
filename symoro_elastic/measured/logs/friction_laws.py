"""Laws beyond FV qd + FS sign(qd): friction by load, by velocity and by record, and cogging.

Laws add columns to that of FS. Load: |tau| sign(qd), tau the torque through the transmission by the *model*, for the
measured torque is on the left side, too, and its noise would be in both. It depends on the unknowns, and so on their
errors: FL |p + P X| = FL0 s (p + P X) + (FL - FL0) |p + P X0| to first order, s = sign(p + P X0), about a
fit X0, FL0, then about the next one (Gauss-Newton). Stribeck: sign(qd) / (1 + (qd / vb)^2) at a given vb, the law of
Hess and Soom (1990).
Records at other temperatures: columns of FV and FS that are zero in the first record.
Cogging a sin(k q + phi) helps the motor: columns -cos(k q) and -sin(k q), of a sin(phi) and a cos(phi), at a known k.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import without_value
from symoro_elastic.machine.checks import parameter_values
from symoro_elastic.machine.described import AnyMachine
from symoro_elastic.machine.joints import INERTIAL, Cogging
from symoro_elastic.machine.labels import ParameterLabels
from symoro_elastic.machine.machine import Machine
from symoro_elastic.measured.fitting.estimates import Unknown
from symoro_elastic.measured.logs.estimation import independent_solution
from symoro_elastic.measured.logs.possible import Linear
from symoro_elastic.numerics.linear.regressor import Regressor

LOAD, STATIC, VISCOUS_CHANGE, DRY_CHANGE = "FL", "FB", "FV of record", "FS of record"
COSINE, SINE = "CC", "CS"
"""Cogging: a sin(phi) and a cos(phi)."""
LAWS = {
    "load friction": (LOAD,),
    "friction by Stribeck's law": (STATIC,),
    "friction of each record": (VISCOUS_CHANGE, DRY_CHANGE),
    "cogging": (COSINE, SINE),
}
"""What its quantities are."""
ROUNDS = 20  # Gauss-Newton steps
CONVERGED = 0.02  # standard deviations: last step
Motion = tuple[Array, Array, Array]


@dataclass(frozen=True)
class FrictionLaws:
    """Friction laws to identify: rows of the table with load friction, Stribeck velocities by row, whether friction
    changes by record, number of records, orders k of cogging by row, 1/rad or 1/m of the joint. X, by column of the
    regressor, and gains, by row, are those about which load friction is linear."""

    load: tuple[int, ...] = ()
    stribeck: Mapping[int, float] = field(default_factory=dict)
    changing: bool = False
    records: int = 1
    cogging: Mapping[int, float] = field(default_factory=dict)
    X: Mapping[int, float] = field(default_factory=dict)
    gains: Mapping[int, float] = field(default_factory=dict)

    def unknowns(self, machine: Machine, linear: Linear) -> list[Unknown]:
        """Return gains of load, static less coulomb friction, changes of friction by record, and cogging."""
        labels = ParameterLabels(machine)

        def unknown(label: str, unit: str, j: int, quantity: str, text: str = "", about: float = 0.0) -> Unknown:
            return Unknown(
                label, unit, formula=text or label, joint=machine.joint(j).name, quantity=quantity, about=about
            )

        unknowns = [unknown(labels(j, LOAD), "1", j, LOAD, about=self.gains.get(j, 0.0)) for j in self.load]
        for j in self.stribeck:
            label = labels(j, STATIC)
            unknowns.append(unknown(label, machine.joint(j).force_unit, j, STATIC, f"{label} - {labels(j, 'FS')}"))
        for record in range(2, (self.records if self.changing else 1) + 1):
            for c, quantity in self._changing(linear):
                column = linear.columns[c]
                text = f"{column.label} of record {record} - {column.label}"
                unknowns.append(unknown(f"{column.label}_{record}", column.unit, column.row, quantity, text))
        for j in self.cogging:
            unknowns += [unknown(labels(j, x), machine.joint(j).force_unit, j, x) for x in (COSINE, SINE)]
        return unknowns

    def _changing(self, linear: Linear) -> list[tuple[int, str]]:
        kinds = {"FV": VISCOUS_CHANGE, "FS": DRY_CHANGE}
        return [(c, kinds[linear.columns[c].quantity]) for c in linear.sought if linear.columns[c].quantity in kinds]

    def columns(self, Y: Regressor, linear: Linear, motion: Motion, record: int = 0) -> Array:
        """Return friction columns of a record (samples, n, k); records that are not fitted take those of the first."""
        dry = {column.row: c for c, column in enumerate(linear.columns) if column.quantity == "FS"}
        rows = [*self.load, *self.stribeck]
        unit = Y.evaluate(*motion, [dry[j] for j in rows])
        blocks = [unit[:, :, : len(self.load)] * np.abs(self._passing(Y, linear, motion))[:, None]]
        rates = Y.rates(list(self.stribeck), motion[0], motion[1])
        falling = 1 / (1 + (rates / np.array(list(self.stribeck.values()))) ** 2)
        blocks.append(unit[:, :, len(self.load) :] * falling[:, None])
        if self.changing:
            own = Y.evaluate(*motion, [c for c, _ in self._changing(linear)])
            blocks += [own * (k == record) for k in range(1, self.records)]
        return np.concatenate([*blocks, *(_cogging(Y, j, k, motion[0]) for j, k in self.cogging.items())], axis=2)

    def slopes(self, Y: Regressor, linear: Linear, motion: Motion) -> Array:
        """Return terms of linearized load friction: FL0 s P sign(qd) to add to columns of groups, then FL0 s p sign(qd)
        to add to right-hand sides, (samples, n, groups + 1)."""
        groups = [linear.sought[c] for c in linear.structure.kept]
        more = np.zeros((*motion[0].shape, len(groups) + 1))
        rising = [(k, j, self.gains[j]) for k, j in enumerate(self.load) if self.gains.get(j)]
        if not rising:
            return more
        dry = {column.row: c for c, column in enumerate(linear.columns) if column.quantity == "FS"}
        inertial = [k for k, c in enumerate(groups) if linear.columns[c].quantity in INERTIAL]
        bodies = Y.evaluate(*motion, [groups[k] for k in inertial])
        unit, passing = Y.evaluate(*motion, [dry[j] for _, j, _ in rising]), self._passing(Y, linear, motion)
        X = np.array([self.X[groups[k]] for k in inertial])
        for place, (k, j, gain) in enumerate(rising):
            P, side = bodies[:, Y.felt_by(j)[0]], gain * np.sign(passing[:, k])
            both = np.column_stack([P, passing[:, k] - P @ X]) * side[:, None]
            more[:, :, [*inertial, len(groups)]] += unit[:, :, place, None] * both[:, None]
        return more

    def _passing(self, Y: Regressor, linear: Linear, motion: Motion) -> Array:
        """Return the torques (samples, joints) transmitted by joints whose friction rises with load."""
        if not self.load:
            return np.zeros((len(motion[0]), 0))
        places = [Y.felt_by(j)[0] for j in self.load]
        X = {c: x for c, x in {**self.X, **linear.known}.items() if linear.columns[c].quantity in INERTIAL}
        torques = Y.torques(*motion, list(X), np.array(list(X.values()))) + Y.loads(motion[0])
        rotors = self._within_bodies(linear)
        passing: Array = (torques - Y.evaluate(*motion, list(rotors)) @ np.array(list(rotors.values())))[:, places]
        return passing

    def _within_bodies(self, linear: Linear) -> dict[int, float]:
        """Return inertias of rotors in the file, by column, that data do not separate from inertias of bodies."""
        rotors = {c: linear.columns[c] for c in linear.sought if c not in self.X}
        inertias = {
            c: column.value for c, column in rotors.items() if column.quantity == "IA" and column.row in self.load
        }
        return {c: x for c, x in inertias.items() if np.isfinite(x)}

    def about(self, linear: Linear, X: Sequence[float], gains: Sequence[float] = ()) -> FrictionLaws:
        """Return the friction laws linearized about the base parameters X and the load gains."""
        groups = [linear.sought[c] for c in linear.structure.kept]
        return replace(self, X=dict(zip(groups, X, strict=False)), gains=dict(zip(self.load, gains, strict=False)))


def _cogging(Y: Regressor, j: int, k: float, q: Array) -> Array:
    """Return -cos(k q) and -sin(k q) of a joint, (samples, n, 2)."""
    torques, at = np.zeros((*q.shape, 2)), Y.felt_by(j)[0]
    torques[:, at] = -np.stack([np.cos(k * q[:, at]), np.sin(k * q[:, at])], axis=1)
    return torques


def laws_of_file(machine: Machine, values: Mapping[str, float]) -> FrictionLaws:
    """Return the laws that motors have in the file of a machine, whose friction would otherwise be counted twice.

    Raises `InputError` for a velocity of Stribeck's law without value.
    """
    load, velocities, orders, known = [], {}, {}, {**parameter_values(machine), **values}
    for j in machine.motors:
        friction = machine.joint(j).friction
        load += [] if friction.load.is_zero else [j]
        if not machine.joint(j).cogging.amplitude.is_zero:
            orders[j] = machine.joint(j).reflected_cogging.order.value(known)
        if friction.static.is_zero:
            continue
        if missing := sorted(friction.stribeck.names - known.keys()):
            what = without_value(missing, "--value")
            raise machine.error(f"friction, {machine.joint(j).name}, stribeck", what)
        velocities[j] = friction.stribeck.value(known)
    return FrictionLaws(tuple(load), velocities, cogging=orders)


def groups_of(Y: Array, tau: Array, count: int) -> tuple[Array, Array]:
    """Return base parameters by weighted least squares of independent columns, zero for the others, and their
    standard deviations."""
    X, std = np.zeros(Y.shape[2]), np.zeros(Y.shape[2])
    independent, solution = independent_solution(Y, tau)
    X[independent], std[independent] = solution.X, solution.std
    return X[:count], std[:count]


def refuse_laws(machine: Machine, laws: FrictionLaws) -> None:
    """Raise `InputError` for load friction or cogging of joints that follow other joints."""
    for option, rows in (("--load-friction", laws.load), ("--cogging", laws.cogging)):
        for j in (j for j in rows if j not in machine.independent):
            what = f"joint {j} ({machine.joint(j).name}) follows others, so the torque through it cannot be determined"
            raise machine.error(option, what)


def without_cogging(machine: AnyMachine) -> AnyMachine:
    """Return the machine without cogging, which is not linear in its own numbers."""
    return replace(machine, joints=tuple(replace(joint, cogging=Cogging()) for joint in machine.joints))
