"""Flexible bodies twice: by integrals over their modes, and as mass points on rows that follow the modes.

Both are bodies of the same points, so that every model of the one is that of the other. Bodies of the second file need
no equations of modes: coupled slides carry each point, along polynomials of the modes where they shorten the body.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from symoro_elastic.formats.toml.reading import read
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.machine.described import DescribedMachine
from symoro_elastic.machine.flexible import FlexibleBody, integrals_of
from symoro_elastic.mechanics.kinematics import frames
from symoro_elastic.models.bound.bind import Bound
from symoro_elastic.symbolic.arithmetic import FLOATS, evaluate

POINTS = 4
CARRIER_AT = np.array([0.3, 0.1, 0.2])
FLOATING = """
[base]
floating = "quaternion"
known = "wrench"
body = { mass = 4, first_moments = [0.1, 0.2, 0.3], inertia_at_origin = [0.9, 0.8, 0.7] }
"""


@dataclass(frozen=True, eq=False)
class Points:
    """A body of points that bends: its row, its place, its modes and their variables, masses, x, phi and s."""

    name: str
    at: Array
    modes: Sequence[str]
    variables: Sequence[str]
    mass: Array
    x: Array
    phi: Array
    s: Array

    @classmethod
    def drawn(cls, rng: np.random.Generator, name: str, at: Array, modes: Sequence[str], shortens: float) -> Points:
        """A body of drawn points, whose row is `name`."""
        x, mass, m = _drawn(rng, POINTS, 3), 1 + 0.3 * np.abs(_drawn(rng, POINTS)), len(modes)
        phi, s = _drawn(rng, m, POINTS, 3), np.zeros((m, m, POINTS, 3))
        if shortens:
            phi[..., 0], s[..., 0] = 0, shortens * _drawn(rng, m, m, POINTS)
        return cls(name, at, modes, [f"v{mode[1:]}{name}" for mode in modes], mass, x, phi, (s + s.swapaxes(0, 1)) / 2)

    @property
    def rows(self) -> list[str]:
        """The rows of the modes."""
        common = f'antecedent = "{self.name}", kind = "elastic", sigma = 1, axis = "x", at = {_list(self.at)}'
        pairs = zip(self.modes, self.variables, strict=True)
        return [f'{{ name = "{mode}", variable = "{variable}", {common} }}' for mode, variable in pairs]

    def slides(self, label: str, point: Array, psi: Array, s: Array | None = None) -> tuple[list[str], str]:
        """Coupled slides along x, y, z that carry a point of the body, and the name of the last."""
        rows, antecedent, at = [], self.name, f"at = {_list(self.at + point)}"
        for k, axis in enumerate("xyz"):
            formula = self.formula(psi[:, k], None if s is None else s[:, :, k])
            cells = f'kind = "coupled", sigma = 1, axis = "{axis}", {at}, r = "{formula}"'
            rows.append(f'{{ name = "{label}{axis}", antecedent = "{antecedent}", {cells} }}')
            antecedent = f"{label}{axis}"
        return rows, antecedent

    def formula(self, psi: Array, s: Array | None = None) -> str:
        """psi_k e_k + s_kl e_k e_l/2 in the variables."""
        terms = [f"({float(x)!r})*{v}" for x, v in zip(psi, self.variables, strict=True)]
        for v, row in zip(self.variables, s if s is not None and s.any() else [], strict=False):
            terms += [f"({float(x) / 2!r})*{v}*{w}" for x, w in zip(row, self.variables, strict=True)]
        return " + ".join(terms)

    def as_points(self) -> tuple[list[str], list[str]]:
        """Rows that carry the points, and their masses."""
        rows: list[str] = []
        masses: list[str] = []
        for i in range(POINTS):
            slides, name = self.slides(f"{self.name}point{i}", self.x[i], self.phi[:, i], self.s[:, :, i])
            rows += slides
            masses.append(f"{name} = {{ mass = {float(self.mass[i])!r} }}")
        return rows, masses

    @property
    def rigid(self) -> str:
        """The entry of its undeformed body."""
        P = np.einsum("i,ia,ib->ab", self.mass, self.x, self.x)
        J = (np.trace(P) * np.eye(3) - P)[np.triu_indices(3)]
        own = f"mass = {float(self.mass.sum())!r}, first_moments = {_list(self.mass @ self.x)}"
        return f"{self.name} = {{ {own}, inertia_at_origin = {_list(J)} }}"

    def flexible(self, machine: DescribedMachine) -> FlexibleBody:
        """The flexible body of its row of a machine, whose frame may be elsewhere on the axis of the joint."""
        R, origin = _frame(machine, self.name)
        integrals = integrals_of(self.mass, (self.x + self.at - origin) @ R, self.phi @ R, self.s @ R)
        return FlexibleBody.of(self.name, self.modes, integrals)


def two_machines(
    seed: int, modes: int, last_slides: bool, base_slides: bool = False, floats: bool = False, shortens: float = 0.0
) -> tuple[DescribedMachine, DescribedMachine]:
    """Return machines with two bodies that bend, with points, and with modes.

    A motor carries the first one behind a spring, a motor on its interface the second, which carries nothing. Where
    they shorten, they bend across x of frame 0 and shorten along it.
    """
    rng = np.random.default_rng(seed)
    tip, psi, turn = _drawn(rng, 3), _drawn(rng, modes, 3), _drawn(rng, modes)
    end_at = CARRIER_AT + tip + [0.2, 0, 0.1]
    first = Points.drawn(rng, "body", CARRIER_AT, [f"e{k + 1}" for k in range(modes)], shortens)
    second = Points.drawn(rng, "last", end_at, ["f1"], shortens)
    base = f'kind = "motor", sigma = {int(base_slides)}, axis = "z", at = [0, 0, 0]'
    rows = [
        f'{{ name = "base", antecedent = 0, {base} }}',
        f'{{ name = "body", antecedent = "base", kind = "elastic", sigma = 0, axis = "y", at = {_list(CARRIER_AT)} }}',
        *first.rows,
    ]
    interface, end = first.slides("tip", tip, psi)
    at = f"at = {_list(CARRIER_AT + tip)}"
    turned = f'antecedent = "{end}", kind = "coupled", sigma = 0, axis = "y", {at}, theta = "{first.formula(turn)}"'
    moved = f'antecedent = "turned", kind = "motor", sigma = {int(last_slides)}, axis = "x"'
    rows += [*interface, f'{{ name = "turned", {turned} }}', f'{{ name = "last", {moved}, at = {_list(end_at)} }}']
    rows += second.rows
    bodies = ["base = { mass = 3, center_of_mass = [0.1, 0.2, 0], inertia = [0.2, 0.3, 0.4] }"]
    springs = ["body = { stiffness = 200, damping = 1 }"]
    names = (*first.modes, *second.modes)
    springs += [f"{name} = {{ stiffness = {int(rng.integers(50, 100))}, damping = 0.3 }}" for name in names]
    more, (of_points, masses) = FLOATING if floats else "", _joined(first.as_points(), second.as_points())
    points = read(_text([*rows, *of_points], [*bodies, *masses], springs) + more, "points.toml")
    modal = read(_text(rows, [*bodies, first.rigid, second.rigid], springs) + more, "modal.toml")
    return points, replace(modal, flexible=(first.flexible(modal), second.flexible(modal)))


def _joined(*parts: tuple[list[str], list[str]]) -> tuple[list[str], list[str]]:
    return [x for rows, _ in parts for x in rows], [x for _, masses in parts for x in masses]


def _frame(machine: DescribedMachine, name: str) -> tuple[Array, Array]:
    """Axes (3, 3) and origin (3,) of a row in frame 0 at position zero."""
    bound = Bound(machine)
    frame = frames(bound.mechanism)[[joint.name for joint in machine.joints].index(name) + 1]
    entries = [*(x for row in frame.rotation for x in row), *frame.origin]
    value = evaluate(entries, {str(x.operands[0]): 0.0 for x in bound.variables.values()}, FLOATS)
    numbers = np.array([float(value(x)) for x in entries])
    return numbers[:9].reshape(3, 3), numbers[9:]


def _drawn(rng: np.random.Generator, *shape: int) -> Array:
    """Numbers of few digits, with which exact arithmetic is fast."""
    return np.round(rng.uniform(-1, 1, shape), 2)


def _list(numbers: Array) -> str:
    return str([float(x) for x in numbers])


def _text(rows: list[str], bodies: list[str], springs: list[str]) -> str:
    parts = ['name = "flexible"', "gravity = [0.3, -0.2, -9.81]", f"joints = [{', '.join(rows)}]"]
    return "\n".join([*parts, "[bodies]", *bodies, "[springs]", *springs, ""])
