"""Small motions of a tree of joints about rest, from its TOML file: numpy and complex steps, nothing of the product.

    G = (Cq + s Cv + s^2 Ca) (s^2 M + s D + K)^-1 F,  M = sum J^T m J,  K = diag(k) + dg/dq,  D = diag(d)

Gravity's torques g are analytic in q, so a step of 1e-30 i gives their slopes to rounding.
"""

from __future__ import annotations

import math
import tomllib
from collections.abc import Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

Array = np.ndarray[Any, Any]
STEP = 1e-30
COMPONENTS = {"fx": 0, "fy": 1, "fz": 2, "mx": 3, "my": 4, "mz": 5}
ORDERS = {"": 0, "v": 1, "a": 2}
FUNCTIONS = {name: getattr(math, name) for name in ("sin", "cos", "sqrt", "pi")}


def table_of(path: Path, springs: Mapping[str, tuple[float, float]] | None = None) -> dict[str, Any]:
    """The tables of a machine file, with stiffness and damping of springs in place of its own."""
    top = tomllib.loads(path.read_text(encoding="utf-8"))
    for name, (k, d) in (springs or {}).items():
        top["springs"][name] = {"stiffness": k, "damping": d}
    return top


def with_part(top: dict[str, Any], on: str, row: Mapping[str, Any], mass: float, f: float, zeta: float) -> Any:
    """The tables with a point mass on a spring, of a frequency (Hz) and damping of its own, taken from a body's mass.

    `row` is the row of the joint in the table; the body keeps its mass where the spring is stiff if the row leads to
    its centre of mass.
    """
    more, w = deepcopy(top), 2 * np.pi * f
    more["bodies"][on]["mass"] -= mass
    more["joints"].append({"antecedent": on, "kind": "elastic", "sigma": 1, **row})
    more["bodies"][row["name"]] = {"mass": mass, "center_of_mass": [0, 0, 0], "inertia": [0, 0, 0]}
    more["springs"][row["name"]] = {"stiffness": mass * w * w, "damping": 2 * zeta * mass * w}
    return more


@dataclass
class SmallMotions:
    """M, D, K of the moving joints of a machine at rest: motors `at` their positions, springs in equilibrium."""

    top: dict[str, Any]
    at: Mapping[str, float]

    def __post_init__(self) -> None:
        self.rows = self.top["joints"]
        self.number = {row["name"]: k for k, row in enumerate(self.rows)}
        self.names = [row["name"] for row in self.rows if row["sigma"] != 2]
        self.cells = {name: x["value"] for name, x in self.top["parameters"].items()} | FUNCTIONS
        self.q = np.array([self.at.get(name, 0.0) for name in self.names])
        springs = self.top["springs"]
        self.k = np.array([float(springs.get(name, {}).get("stiffness", 0)) for name in self.names])
        friction = self.top.get("friction", {})
        d = [springs.get(n, {}).get("damping", 0) + friction.get(n, {}).get("viscous", 0) for n in self.names]
        elastic = self.k > 0
        for _ in range(5):
            g, slope = self._gravity()
            K = np.diag(self.k) + slope
            self.q[elastic] -= np.linalg.solve(K[np.ix_(elastic, elastic)], (self.k * self.q + g)[elastic])
        self.K, self.D, self.M = np.diag(self.k) + self._gravity()[1], np.diag(d).astype(float), self._inertia()

    def poses(self, q: Array) -> list[Array]:
        """Transforms of all frames: Rot(z, gamma) Trans(z, b) Rot(x, alpha) Trans(x, d) Rot(z, theta) Trans(z, r)."""
        values = {self._variable(row): x for row, x in zip(self._moving, q, strict=True)}
        found: list[Array] = []
        for row in self.rows:
            cells = (row.get(key, 0) for key in ("gamma", "b", "alpha", "d", "theta", "r"))
            gamma, b, alpha, d, theta, r = (self._number(cell, values) for cell in cells)
            own = _turn(2, gamma) @ _shift(2, b) @ _turn(0, alpha) @ _shift(0, d) @ _turn(2, theta) @ _shift(2, r)
            before = row["antecedent"]
            found.append(own if before == 0 else found[self.number[before]] @ own)
        return found

    @property
    def _moving(self) -> list[dict[str, Any]]:
        return [row for row in self.rows if row["sigma"] != 2]

    def _number(self, cell: Any, values: Mapping[str, Any] | None = None) -> Any:
        """A cell of one of our own examples: a number, or a formula of parameters and variables."""
        return eval(str(cell), {"__builtins__": {}}, {**self.cells, **(values or {})})

    def _variable(self, row: Mapping[str, Any]) -> str:
        text = str(row["theta" if row["sigma"] == 0 else "r"])
        (name,) = {word for word in text.replace("/", " ").split() if word not in self.cells and word.isidentifier()}
        return name

    def jacobian(self, poses: list[Array], frame: str, point: Array) -> Array:
        """Velocity of a point of a frame, given in frame 0, and angular velocity, by rates (6, n)."""
        carriers, j = set(), frame
        while j != 0:
            carriers.add(j)
            j = self.rows[self.number[j]]["antecedent"]
        J = np.zeros((6, len(self.names)), dtype=complex)
        for k, name in enumerate(self.names):
            if name in carriers:
                T = poses[self.number[name]]
                z, turns = T[:3, 2], self.rows[self.number[name]]["sigma"] == 0
                J[:3, k] = np.cross(z, point - T[:3, 3]) if turns else z
                J[3:, k] = z if turns else 0
        return J

    def _bodies(self, poses: list[Array]) -> Any:
        for name, body in self.top["bodies"].items():
            T = poses[self.number[name]]
            yield name, body, T[:3, :3], T[:3, 3] + T[:3, :3] @ np.array(body["center_of_mass"], dtype=float)

    def _gravity(self) -> tuple[Array, Array]:
        """Torques -sum m J^T g, and their slopes by q."""
        gravity, n = np.array(self.top["gravity"], dtype=float), len(self.names)
        columns = []
        for step in (np.zeros(n), *np.eye(n)):
            poses = self.poses(self.q + 1j * STEP * step)
            J = ((body["mass"], self.jacobian(poses, name, c)[:3]) for name, body, _, c in self._bodies(poses))
            columns.append(-sum(m * (each.T @ gravity) for m, each in J))
        return columns[0].real, np.array(columns[1:]).imag.T / STEP

    def _inertia(self) -> Array:
        poses = self.poses(self.q.astype(complex))
        M = np.zeros((len(self.names),) * 2)
        for name, body, R, c in self._bodies(poses):
            J = self.jacobian(poses, name, c).real
            about = (R @ np.diag(body["inertia"]) @ R.T).real
            M += body["mass"] * J[:3].T @ J[:3] + J[3:].T @ about @ J[3:]
        for name, motor in self.top.get("motors", {}).items():
            k = self.names.index(name)
            M[k, k] += motor["rotor_inertia"] * self._number(motor.get("ratio", 1)) ** 2
        return M

    def _row(self, name: str) -> tuple[Array, int]:
        """Row of the velocity behind a signal, and how often an output is derived."""
        owner, _, quantity = name.rpartition(".")
        if quantity in ("q", "qd", "qdd", "tau"):
            return np.eye(len(self.names))[self.names.index(owner)], max(quantity.count("d"), 0)
        poses = self.poses(self.q.astype(complex))
        J = self.jacobian(poses, owner, poses[self.number[owner]][:3, 3]).real
        if quantity in COMPONENTS:
            return J[COMPONENTS[quantity]], 0
        return J["xyz".index(quantity[-1])], ORDERS[quantity[:-1]]

    def responses(
        self, f: Array, pairs: Sequence[tuple[str, str]], held: Sequence[str] = (), pd: Mapping[str, Any] | None = None
    ) -> Array:
        """Responses of outputs to inputs, pairs of names, at f in Hz (pairs, frequencies)."""
        kept = [k for k, name in enumerate(self.names) if name not in held]
        K, D = self.K.copy(), self.D.copy()
        for name, (kp, kd) in (pd or {}).items():
            k = self.names.index(name)
            K[k, k] += kp
            D[k, k] += kd
        M, D, K = (x[np.ix_(kept, kept)] for x in (self.M, D, K))
        s = 2j * np.pi * f[:, None, None]
        Z = s * s * M + s * D + K
        rows = {name: self._row(name) for pair in pairs for name in pair}
        moved = {into: np.linalg.solve(Z, rows[into][0][kept][None, :, None].astype(complex)) for _, into in pairs}
        each = (((2j * np.pi * f) ** rows[o][1] * (moved[i][:, :, 0] @ rows[o][0][kept])) for o, i in pairs)
        return np.array([*each])

    def modes(self, held: Sequence[str] = ()) -> tuple[Array, Array]:
        """Natural frequencies in Hz and damping ratios of the oscillating poles, by frequency."""
        kept = [k for k, name in enumerate(self.names) if name not in held]
        M, D, K = (x[np.ix_(kept, kept)] for x in (self.M, self.D, self.K))
        n = len(kept)
        upper = np.hstack([np.zeros((n, n)), np.eye(n)])
        poles = np.linalg.eigvals(np.vstack([upper, -np.linalg.solve(M, np.hstack([K, D]))]))
        poles = poles[poles.imag > 0]
        poles = poles[np.argsort(abs(poles))]
        return abs(poles) / (2 * np.pi), -poles.real / abs(poles)


def _turn(axis: int, angle: complex) -> Array:
    c, s = np.cos(angle), np.sin(angle)
    T = np.eye(4, dtype=complex)
    a, b = (axis + 1) % 3, (axis + 2) % 3
    T[a, a], T[a, b], T[b, a], T[b, b] = c, -s, s, c
    return T


def _shift(axis: int, length: complex) -> Array:
    T = np.eye(4, dtype=complex)
    T[axis, 3] = length
    return T
