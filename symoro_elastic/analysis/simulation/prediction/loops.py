"""Drives in the linear model along a motion: their states z are rates of coordinates w, one each.

    w'' - A w' - B_x d_m - B_v d_m' = A z_0 + B u,    w' = z - z_0,    w(0) = w'(0) = 0
    M d'' + D d' + K d - S_m^T (C w' + D_x d_m + D_v d_m') = R + S_m^T (C z_0 + D u - tau_0)

z' = A z + B u, tau = C z + D u are the laws of drives, u their inputs where motors are on their set points, z_0
their states at the start, d_m the deviations of motors. Nothing depends on w itself. Loops are rows more of M, D and K:
whatever treats the small motion of a machine treats that of its drives.

A part of a drive that follows at once (a lag, a dead time, a filter: all pass what is constant as it is) is left out of
the law; the integral part stays.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import replace
from itertools import groupby

import numpy as np

from symoro_elastic.analysis.control.cascade import CURRENT, Biquad, Cascade, DeadTime, FirstOrder
from symoro_elastic.analysis.control.drive_laws import LIMITS, XD, DriveLaw, X, law_of, parts_of_path
from symoro_elastic.analysis.simulation.compiled_steps import refuse_sampled
from symoro_elastic.analysis.simulation.driven import inputs_of
from symoro_elastic.analysis.simulation.prediction.output_matrices import Outputs, is_torque
from symoro_elastic.analysis.simulation.reference_motion import Reference
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.machine.described import drives_of
from symoro_elastic.machine.drives import MOTOR

CONTROLLER = "controller"


def refuse_drives(reference: Reference) -> None:
    """Raise `InputError` for drives that linear models of motions do not support: sampled, or with measured loads."""
    refuse_sampled(reference)
    drives = drives_of(reference.machine).by_motor
    for cascade in reference.drives:
        drive = drives[cascade.motor]
        for key in (key for key, there in (("measured", drive.measured != MOTOR), ("period", drive.period)) if there):
            what = "has no part in a linear model of a motion: leave it out, or simulate"
            raise reference.machine.error(f"drives, {cascade.motor}, {key}", what)


def part_names(cascade: Cascade) -> list[str]:
    """Return the scene names of the elements of a drive's path, as `motor_x.lag`; empty if one cannot be omitted."""
    filters, found = 0, []
    for element in cascade.path:
        part = "dead_time" if isinstance(element, DeadTime) else ""
        if isinstance(element, FirstOrder | Biquad):
            is_lag = element.name == CURRENT
            filters += not is_lag
            part = "lag" if is_lag else f"filter_{filters}"
        found.append(f"{cascade.motor}.{part}" if part else "")
    return found


def without_parts(drives: Sequence[Cascade], left_out: Collection[str]) -> tuple[Cascade, ...]:
    """Return the drives without some lags, filters and dead times, which then act without delay."""
    pairs = [zip(drive.path, part_names(drive), strict=True) for drive in drives]
    paths = [tuple(x for x, name in pair if name not in left_out) for pair in pairs]
    return tuple(replace(drive, path=path) for drive, path in zip(drives, paths, strict=True))


def _names(drive: Cascade) -> Iterator[str]:
    """Yield the names of the states w of a drive; the first state of an omissible part has the name of the part."""
    controller = len(law_of(replace(drive, path=())).A)
    yield from (f"{drive.motor}.{CONTROLLER}_{k + 1}" for k in range(controller))
    ahead, _ = parts_of_path(drive)
    named = zip(drive.path, part_names(drive), strict=True)
    for element, name in sorted(named, key=lambda pair: pair[0] not in ahead):
        states = len(law_of(replace(drive, path=(element,))).A) - controller
        yield from ((name if name and k == 0 else f"{drive.motor}.{element.name} {k + 1}") for k in range(states))


def parts_of(drives: Sequence[Cascade]) -> tuple[str, ...]:
    """Return the names of the parts of drives that may be omitted."""
    return tuple(name for drive in drives for name in part_names(drive) if name)


class Loops:
    """The laws of drives along a motion, linear about the motors' set points at times t (N,)."""

    def __init__(self, reference: Reference, drives: Sequence[Cascade], t: Array) -> None:
        self.drives, self.names = tuple(drives), tuple(name for drive in drives for name in _names(drive))
        self.laws = [law_of(drive) for drive in drives]
        on = replace(reference, drives=self.drives).motion(t)
        x, xd = reference.of_motors(on)
        self._u = inputs_of(reference, on, x, xd)
        (at,) = inputs_of(reference, on[:1], x[:1], xd[:1])
        at[:, [2, X, XD]] = 0.0
        self._rest = [law.steady @ u for law, u in zip(self.laws, at, strict=True)]
        self._motors = list(reference.machine.motor_entries)
        self._held = reference.start.torques

    def _each(self) -> Iterator[tuple[int, slice, DriveLaw]]:
        first = 0
        for k, law in enumerate(self.laws):
            yield k, slice(first, first + len(law.A)), law
            first += len(law.A)

    def matrices(self, n: int) -> tuple[Array, Array]:
        """Return the damping and stiffness matrices of loops, (n + states, n + states) for a machine of n joints."""
        D, K = np.zeros((2, n + len(self.names), n + len(self.names)))
        for k, part, law in self._each():
            m, own = self._motors[k], slice(n + part.start, n + part.stop)
            D[own, own], D[own, m], K[own, m] = -law.A, -law.B[:, XD], -law.B[:, X]
            D[m, own] = -law.C
            D[m, m], K[m, m] = -law.D[XD], -law.D[X]
        return D, K

    def forces(self, n: int) -> Array:
        """Return the forces that drive the loops, (N, n + states)."""
        R = np.zeros((len(self._u), n + len(self.names)))
        for k, part, law in self._each():
            R[:, n + part.start : n + part.stop] = law.A @ self._rest[k] + self._u[:, k] @ law.B.T
            R[:, self._motors[k]] = self.torque_offset(k)
        return R

    def refuse_beyond(self, reference: Reference, d: Array, dd: Array) -> None:
        """Raise `InputError` where a limit of a drive acts along the linear motion d, d' (N, n + states)."""
        n = d.shape[1] - len(self.names)
        for k, part, law in self._each():
            u, m = self._u[:, k].copy(), self._motors[k]
            u[:, X] += d[:, m]
            u[:, XD] += dd[:, m]
            z = self._rest[k] + dd[:, n + part.start : n + part.stop]
            used = np.abs(z @ law.F.T + u @ law.G.T).max(axis=0) / law.limits
            for j, what in zip(LIMITS, ("torque or current", "voltage"), strict=True):
                if used[j] > 1:
                    excess = f"the motion needs {used[j]:.3g} times that of the {what}, where loops are not linear: "
                    place = f"drives, {self.drives[k].motor}, limits"
                    raise reference.machine.error(place, excess + "raise it, move slower, or simulate")

    def torque_offset(self, motor: int) -> Array:
        """Return the torque (N,) of a drive on its set point with constant states, minus the torque at the start."""
        law = self.laws[motor]
        return np.asarray(law.C @ self._rest[motor] + self._u[:, motor] @ law.D - self._held[motor])

    def outputs(self, of: Outputs, n: int) -> tuple[Outputs, Array]:
        """Return the output rows with drive torques filled in, and the outputs (N, outputs) at zero deviation."""
        Cq, Cv, Ca = (np.pad(C, ((0, 0), (0, 0), (0, len(self.names)))) for C in (of.Cq, of.Cv, of.Ca))
        offsets = np.zeros(Cq.shape[:2])
        motors = [drive.motor for drive in self.drives]
        for row, name in enumerate(of.names):
            if not is_torque(name):
                continue
            for k, part, law in self._each():
                if motors[k] == name.rpartition(".")[0]:
                    Cq[:, row, self._motors[k]], Cv[:, row, self._motors[k]] = law.D[X], law.D[XD]
                    Cv[:, row, n + part.start : n + part.stop] = law.C
                    offsets[:, row] = self.torque_offset(k)
        return replace(of, Cq=Cq, Cv=Cv, Ca=Ca), offsets


def by_parts(sets: Sequence[Collection[int]], parts: Collection[int]) -> Iterator[tuple[tuple[int, ...], list[int]]]:
    """Yield each combination of omitted parts, and the indices of the sets that omit it."""
    keys = [tuple(sorted(k for k in left_out if k in parts)) for left_out in sets]
    order = sorted(range(len(sets)), key=lambda k: keys[k])
    for key, rows in groupby(order, key=lambda k: keys[k]):
        yield key, list(rows)
