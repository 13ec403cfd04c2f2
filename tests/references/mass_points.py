"""A flexible body twice: by integrals over its modes, and as mass points on rows that follow the modes.

Both are bodies of the same points, so that every model of the one is that of the other. Bodies of the second file need
no equations of modes: coupled slides carry each point.
"""

from __future__ import annotations

from dataclasses import replace

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


def two_machines(seed: int, modes: int, last_slides: bool) -> tuple[DescribedMachine, DescribedMachine]:
    """Return a motor, a flexible body behind a spring, and a motor on its interface: with points, and with modes."""
    rng = np.random.default_rng(seed)
    x, mass = _drawn(rng, POINTS, 3), 1 + 0.3 * np.abs(_drawn(rng, POINTS))
    phi, tip, psi, turn = _drawn(rng, modes, POINTS, 3), _drawn(rng, 3), _drawn(rng, modes, 3), _drawn(rng, modes)
    rows = [
        '{ name = "base", antecedent = 0, kind = "motor", sigma = 0, axis = "z", at = [0, 0, 0] }',
        f'{{ name = "body", antecedent = "base", kind = "elastic", sigma = 0, axis = "y", at = {_list(CARRIER_AT)} }}',
    ]
    common = f'antecedent = "body", kind = "elastic", sigma = 1, axis = "x", at = {_list(CARRIER_AT)}'
    rows += [f'{{ name = "e{k + 1}", variable = "v{k + 1}", {common} }}' for k in range(modes)]
    interface, end = _slides("tip", tip, psi)
    at = f"at = {_list(CARRIER_AT + tip)}"
    turned = f'antecedent = "{end}", kind = "coupled", sigma = 0, axis = "y", {at}, theta = "{_formula(turn)}"'
    moved = f'antecedent = "turned", kind = "motor", sigma = {int(last_slides)}, axis = "x"'
    interface += [f'{{ name = "turned", {turned} }}']
    interface += [f'{{ name = "last", {moved}, at = {_list(CARRIER_AT + tip + [0.2, 0, 0.1])} }}']
    bodies = ["base = { mass = 3, center_of_mass = [0.1, 0.2, 0], inertia = [0.2, 0.3, 0.4] }"]
    bodies += ["last = { mass = 1.5, center_of_mass = [0.05, 0.1, 0.2], inertia = [0.02, 0.03, 0.04] }"]
    springs = ["body = { stiffness = 200, damping = 1 }"]
    springs += [f"e{k + 1} = {{ stiffness = {int(rng.integers(50, 100))}, damping = 0.3 }}" for k in range(modes)]
    of_points: list[str] = []
    masses: list[str] = []
    for i in range(POINTS):
        slides, name = _slides(f"point{i}", x[i], phi[:, i])
        of_points += slides
        masses.append(f"{name} = {{ mass = {float(mass[i])!r} }}")
    P = np.einsum("i,ia,ib->ab", mass, x, x)
    J = (np.trace(P) * np.eye(3) - P)[np.triu_indices(3)]
    own = f"mass = {float(mass.sum())!r}, first_moments = {_list(mass @ x)}, inertia_at_origin = {_list(J)}"
    points = read(_text([*rows, *of_points, *interface], [*bodies, *masses], springs), "points.toml")
    modal = read(_text([*rows, *interface], [*bodies, f"body = {{ {own} }}"], springs), "modal.toml")
    return points, _with_modes(modal, modes, integrals_of(mass, x, phi, np.zeros((modes, modes, POINTS, 3))))


def _with_modes(machine: DescribedMachine, modes: int, integrals: dict[str, Array]) -> DescribedMachine:
    """The machine whose second row bends, from integrals in axes of frame 0 at position zero."""
    bound = Bound(machine)
    entries = [x for row in frames(bound.mechanism)[2].rotation for x in row]
    value = evaluate(entries, {str(x.operands[0]): 0.0 for x in bound.variables.values()}, FLOATS)
    R = np.array([float(value(x)) for x in entries]).reshape(3, 3)
    turned = {key: x @ R for key, x in integrals.items() if key.startswith("C")}
    turned |= {key: R.T @ x @ R for key, x in integrals.items() if key.startswith("T")}
    body = FlexibleBody.of("body", [f"e{k + 1}" for k in range(modes)], {**turned, "Mee": integrals["Mee"]})
    return replace(machine, flexible=(body,))


def _drawn(rng: np.random.Generator, *shape: int) -> Array:
    """Numbers of few digits, with which exact arithmetic is fast."""
    return np.round(rng.uniform(-1, 1, shape), 2)


def _slides(name: str, point: Array, psi: Array) -> tuple[list[str], str]:
    """Coupled slides along x, y, z that carry a point of the body, and the name of the last."""
    rows, antecedent, at = [], "body", f"at = {_list(CARRIER_AT + point)}"
    for k, axis in enumerate("xyz"):
        cells = f'kind = "coupled", sigma = 1, axis = "{axis}", {at}, r = "{_formula(psi[:, k])}"'
        rows.append(f'{{ name = "{name}{axis}", antecedent = "{antecedent}", {cells} }}')
        antecedent = f"{name}{axis}"
    return rows, antecedent


def _formula(factors: Array) -> str:
    return " + ".join(f"({float(x)!r})*v{k + 1}" for k, x in enumerate(factors))


def _list(numbers: Array) -> str:
    return str([float(x) for x in numbers])


def _text(rows: list[str], bodies: list[str], springs: list[str]) -> str:
    parts = ['name = "flexible"', "gravity = [0.3, -0.2, -9.81]", f"joints = [{', '.join(rows)}]"]
    return "\n".join([*parts, "[bodies]", *bodies, "[springs]", *springs, ""])
