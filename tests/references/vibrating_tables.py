"""Frequency responses of machines from their tables, by a program of its own: numpy and complex steps.

Frames are those of Khalil and Kleinfinger; Jacobians are imaginary parts of frames at q + i h e_k, which lose no
digits; the curvature of gravity's energy is that of its gradient by central differences. Nothing of the package is
used, so that it is a shop floor whose truth is another program.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

Tables = Mapping[str, Any]
STEP = 1e-30
NAMES = {"pi": math.pi}
AXES = {"x": 0, "y": 1, "z": 2}
ORDERS = {"q": 0, "qd": 1, "qdd": 2, "": 0, "v": 1, "a": 2, "wd": 2}
"""How often a signal is derived: those of motors by their names, those of frames by what stands before the axis."""


def with_labels(tables: Tables, values: Mapping[str, float]) -> dict[str, Any]:
    """Tables with other numbers: `ram.stiffness`, `ram.damping`, `table.mass`, `motor.viscous`, or a parameter."""
    found: dict[str, Any] = copy.deepcopy(dict(tables))
    section = {"stiffness": "springs", "damping": "springs", "mass": "bodies", "viscous": "friction"}
    section["rotor_inertia"] = "motors"
    for label, x in values.items():
        joint, dot, key = label.rpartition(".")
        if dot:
            found.setdefault(section[key], {}).setdefault(joint, {})[key] = x
        else:
            found["parameters"][label]["value"] = x
    return found


class VibratingTables:
    """A machine with tables as in its file; `dependent` gives the variables of a loop from the independent ones."""

    def __init__(self, tables: Tables, dependent: Callable[[dict[str, Any]], dict[str, Any]] | None = None) -> None:
        self.tables, self.dependent = tables, dependent
        self.joints = [joint for joint in tables["joints"] if joint["kind"] != "cut"]
        self.constants = NAMES | {name: one["value"] for name, one in tables.get("parameters", {}).items()}
        own = [(joint, _variable(joint)) for joint in self.joints]
        following = {x for loop in tables.get("loops", {}).values() for x in loop["dependent"]}
        self.moving = [(joint, x) for joint, x in own if x]
        self.variables = [x for _, x in self.moving if x not in following]
        self.names = {joint["name"]: x for joint, x in self.moving}

    def number(self, x: Any) -> float:
        """A cell without variables."""
        return float(_value(x, self.constants)) if isinstance(x, str) else float(x)

    def coordinates(self, q: Any) -> dict[str, Any]:
        """All variables by name, dependent ones too."""
        found = dict(zip(self.variables, np.moveaxis(np.asarray(q), -1, 0), strict=True))
        return found | (self.dependent(found) if self.dependent else {})

    def frames(self, q: Any) -> dict[str, Any]:
        """Frame of each joint (..., 4, 4), complex, at q (..., n)."""
        symbols = {**self.constants, **self.coordinates(q)}
        frames: dict[Any, Any] = {0: np.eye(4, dtype=complex)}
        last: Any = 0
        for joint in self.joints:
            cell = {k: _value(joint.get(k, 0), symbols) for k in ("gamma", "b", "alpha", "d", "theta", "r")}
            antecedent = joint.get("antecedent", last)
            T = _turn(2, cell["gamma"]) @ _shift(2, cell["b"]) @ _turn(0, cell["alpha"]) @ _shift(0, cell["d"])
            frames[joint["name"]] = frames[antecedent] @ T @ _turn(2, cell["theta"]) @ _shift(2, cell["r"])
            last = joint["name"]
        return frames

    def jacobian(self, q: Any, of: Callable[[Any], Any]) -> Any:
        """Derivatives (..., numbers, n) of numbers (..., numbers) by q (..., n)."""
        q = np.asarray(q)
        return np.moveaxis(np.imag(of(q[..., None, :] + 1j * STEP * np.eye(q.shape[-1]))) / STEP, -2, -1)

    def place(self, q: Any, frame: str, point: Any) -> Any:
        """A point of a frame (..., 3)."""
        return (self.frames(q)[frame] @ np.append(point, 1.0))[..., :3]

    def turns(self, q: Any, frame: str) -> Any:
        """The nine entries of the rotation of a frame (..., 9)."""
        R = self.frames(q)[frame][..., :3, :3]
        return R.reshape(*R.shape[:-2], 9)

    def bodies(self) -> list[tuple[str, float, Any, Any]]:
        """Name, mass, centre of mass and inertia about it, of each body."""
        found = []
        for name, body in self.tables["bodies"].items():
            mass = self.number(body.get("mass", 0))
            c = np.array([self.number(x) for x in body.get("center_of_mass", (0, 0, 0))])
            tensor = _tensor([self.number(x) for x in body.get("inertia", body.get("inertia_at_origin", (0, 0, 0)))])
            found.append((name, mass, c, tensor))
        return found

    def inertia(self, q: Any) -> Any:
        """M (n, n): sum of m J^T J and Jw^T I Jw, and rotors."""
        n = len(q)
        M, here = np.zeros((n, n)), self.frames(q)
        for name, mass, c, tensor in self.bodies():
            J = self.jacobian(q, lambda x, name=name, c=c: self.place(x, name, c))
            R = np.real(here[name][:3, :3])
            dR = self.jacobian(q, lambda x, name=name: self.turns(x, name)).reshape(3, 3, n)
            spin = np.einsum("ji,jkn->ikn", R, dR)
            w = np.stack([spin[2, 1], spin[0, 2], spin[1, 0]])
            M += mass * J.T @ J + w.T @ tensor @ w
        for name, motor in self.tables.get("motors", {}).items():
            S = self.rates(q, name)
            M += self.number(motor.get("rotor_inertia", 0)) * self.number(motor.get("ratio", 1)) ** 2 * np.outer(S, S)
        return M

    def rates(self, q: Any, joint: str) -> Any:
        """Derivative (..., n) of a joint's own variable by q."""
        return self.jacobian(q, lambda x: self.coordinates(x)[self.names[joint]][..., None])[..., 0, :]

    def gravity_forces(self, q: Any) -> Any:
        """Gradient of the energy of gravity."""
        g = np.array([self.number(x) for x in self.tables.get("gravity", (0, 0, 0))])

        def energy(x: Any) -> Any:
            frames = self.frames(x)
            each = (-m * ((frames[name] @ np.append(c, 1.0))[..., :3] @ g) for name, m, c, _ in bodies)
            return sum(each)[..., None]  # type: ignore[index]

        bodies = self.bodies()
        return self.jacobian(q, energy)[..., 0, :]

    def springs(self, q: Any) -> tuple[Any, Any]:
        """K and D of springs, dampers and viscous friction, by the rates of their own variables."""
        n = len(q)
        K, D = np.zeros((n, n)), np.zeros((n, n))
        for name, spring in self.tables.get("springs", {}).items():
            S = self.rates(q, name)
            K += self.number(spring["stiffness"]) * np.outer(S, S)
            D += self.number(spring.get("damping", 0)) * np.outer(S, S)
        for name, friction in self.tables.get("friction", {}).items():
            S = self.rates(q, name)
            D += self.number(friction.get("viscous", 0)) * np.outer(S, S)
        return K, D

    def deflections(self, q: Any) -> Any:
        """Generalised forces (..., n) of the springs; their own variables are zero without load."""
        values = self.coordinates(q)
        return sum(
            self.number(spring["stiffness"]) * np.real(values[self.names[name]])[..., None] * self.rates(q, name)
            for name, spring in self.tables.get("springs", {}).items()
        )

    def small_motions(self, at: Mapping[str, float]) -> tuple[Any, Any, Any, Any]:
        """q at equilibrium with motors held, M, D, K."""
        motors = {self.names[joint["name"]] for joint in self.joints if joint["kind"] == "motor"}
        q = np.zeros(len(self.variables))
        for name, x in at.items():
            q[self.variables.index(self.names[name])] = x
        free = [k for k, x in enumerate(self.variables) if x not in motors]
        for _ in range(8):
            K = self.stiffness(q)
            r = self.gravity_forces(q) + self.deflections(q)
            step = np.zeros_like(q)
            if free:
                step[free] = -np.linalg.solve(K[np.ix_(free, free)], r[free])
            q = q + step
        return q, self.inertia(q), self.springs(q)[1], self.stiffness(q)

    def stiffness(self, q: Any) -> Any:
        """K: slopes of the forces of springs and gravity."""
        h = 1e-5
        ahead, behind = (q + way * h * np.eye(len(q)) for way in (1, -1))
        ahead, behind = (self.gravity_forces(x) + self.deflections(x) for x in (ahead, behind))
        curved = (ahead - behind).T / (2 * h)
        springs = self.springs(q)[0]
        loaded = curved - springs  # of gravity alone: the small part, where differences lose nothing that counts
        return springs + (loaded + loaded.T) / 2

    def response(
        self, at: Mapping[str, float], hold: Sequence[str], pairs: Sequence[tuple[str, str]], f: Any,
        pd: Mapping[str, tuple[float, float]] | None = None,
    ) -> Any:  # fmt: skip
        """G (f, pairs) of `frame.x`, `frame.ax`, `motor.q` ... to `frame.fx` or `motor.tau`."""
        q, M, D, K = self.small_motions(at)
        for name, (kp, kd) in (pd or {}).items():
            S = self.rates(q, name)
            K, D = K + kp * np.outer(S, S), D + kd * np.outer(S, S)
        fixed = {self.variables.index(self.names[name]) for name in hold}
        kept = [k for k in range(len(q)) if k not in fixed]
        chosen, s = np.ix_(kept, kept), (2j * np.pi * np.asarray(f))[:, None, None]
        Z = s * s * M[chosen] + s * D[chosen] + K[chosen]
        names = list(dict.fromkeys(x for _, x in pairs))
        forces = np.stack([self._row(q, x)[kept] for x in names], axis=1).astype(complex)
        moved = np.linalg.solve(Z, np.broadcast_to(forces, (len(Z), *forces.shape)))
        outs = np.stack([self._row(q, out)[kept] for out, _ in pairs])
        each = [moved[:, :, names.index(x)] @ row for row, (_, x) in zip(outs, pairs, strict=True)]
        return s[:, :, 0] ** [_order(out) for out, _ in pairs] * np.stack(each, axis=1)

    def modes(self, at: Mapping[str, float], hold: Sequence[str]) -> tuple[Any, Any]:
        """Natural frequencies in Hz and damping ratios of the oscillating poles, by frequency."""
        return self.mode_shapes(at, hold, [])[:2]

    def mode_shapes(self, at: Mapping[str, float], hold: Sequence[str], outputs: Sequence[str]) -> tuple[Any, Any, Any]:
        """The same, and amplitudes (modes, outputs), complex, the largest of each mode 1."""
        q, *matrices = self.small_motions(at)
        fixed = {self.variables.index(self.names[name]) for name in hold}
        kept = [k for k in range(len(q)) if k not in fixed]
        M, D, K = (x[np.ix_(kept, kept)] for x in matrices)
        none, one = np.zeros_like(M), np.eye(len(kept))
        poles, vectors = np.linalg.eig(np.block([[none, one], [-np.linalg.solve(M, np.hstack([K, D]))]]))
        order = [k for k in np.argsort(abs(poles)) if poles[k].imag > 0]
        poles, vectors = poles[order], vectors[: len(kept), order]
        rows = np.stack([self._row(q, name)[kept] for name in outputs]) if outputs else np.zeros((0, len(kept)))
        shapes = (rows @ vectors).T * poles[:, None] ** [_order(name) for name in outputs]
        size = abs(shapes).max(axis=1, keepdims=True) if outputs else 1.0
        return abs(poles) / (2 * np.pi), -poles.real / abs(poles), shapes / size

    def _row(self, q: Any, signal: str) -> Any:
        """Jacobian (n,) behind a signal."""
        owner, _, what = signal.rpartition(".")
        if what in ("tau", "q", "qd", "qdd"):
            return self.rates(q, owner)
        axis = AXES[what[-1]]
        if what.startswith("wd"):
            R = np.real(self.frames(q)[owner][:3, :3])
            dR = self.jacobian(q, lambda x: self.turns(x, owner)).reshape(3, 3, len(q))
            spin = np.einsum("ikn,jk->ijn", dR, R)
            return np.stack([spin[2, 1], spin[0, 2], spin[1, 0]])[axis]
        return self.jacobian(q, lambda x: self.place(x, owner, np.zeros(3)))[axis]


def _order(signal: str) -> int:
    what = signal.rpartition(".")[2]
    return ORDERS[what if what in ORDERS else what[:-1]]


def _variable(joint: Mapping[str, Any]) -> str:
    """The variable of a joint, empty where it has none."""
    if joint["kind"] == "fixed":
        return ""
    cell = joint["theta" if joint["sigma"] == 0 else "r"]
    return str(joint.get("variable", str(cell).split("+")[0].strip()))


def _value(cell: Any, symbols: Mapping[str, Any]) -> Any:
    return eval(cell.replace("^", "**"), {}, dict(symbols)) if isinstance(cell, str) else cell


def _turn(axis: int, angle: Any) -> Any:
    T = np.broadcast_to(np.eye(4, dtype=complex), (*np.shape(angle), 4, 4)).copy()
    i, j = (axis + 1) % 3, (axis + 2) % 3
    T[..., i, i] = T[..., j, j] = np.cos(angle)
    T[..., i, j], T[..., j, i] = -np.sin(angle), np.sin(angle)
    return T


def _shift(axis: int, length: Any) -> Any:
    T = np.broadcast_to(np.eye(4, dtype=complex), (*np.shape(length), 4, 4)).copy()
    T[..., axis, 3] = length
    return T


def _tensor(entries: Sequence[float]) -> Any:
    if len(entries) == 3:
        return np.diag(entries)
    xx, xy, xz, yy, yz, zz = entries
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
