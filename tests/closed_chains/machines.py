"""The machines of `machines/`, and their states and known results of `data/`."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

from symoro_elastic.formats import read_machine
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import Machine
from tests.references.closed_chains import State

FOLDER = Path(__file__).parent
FILES = {path.stem: path for path in sorted((FOLDER / "machines").glob("*.toml"))}
WITH_RESULTS = ("ball_screw", "five_bar", "parallelogram", "sr400")
"""Machines whose results another program computed, by multipliers and by d'Alembert, to 50 digits."""


@dataclass(frozen=True)
class Situation:
    """A state, torques and accelerations of the motors, in double precision."""

    state: State
    tau: list[float]
    qdd_motor: list[float]


@cache
def machine(name: str) -> Machine:
    return read_machine(FILES[name])[0]


def in_order(entries: Sequence[Any], names: Sequence[str], order: Sequence[str]) -> list[Any]:
    """Entries by name, in another order."""
    return [dict(zip(names, entries, strict=True))[name] for name in order]


@cache
def without_closed_form() -> Machine:
    """The spatial four-bar with an axis of its coupler beside that of the cross, which has no closed form."""
    described = machine("spatial_four_bar")
    joints = (replace(row, d=Formula.parse(0.02)) if row.name == "coupler" else row for row in described.joints)
    return replace(described, joints=tuple(joints))


@cache
def situations(name: str) -> list[Situation]:
    return [_situation(entry) for entry in data(name)["states"]]


@cache
def data(name: str) -> dict[str, Any]:
    """What `data/` holds of a machine: lists in table order, results as decimal text."""
    found: dict[str, Any] = json.loads((FOLDER / "data" / f"{name}.json").read_text(encoding="utf-8"))
    return found


def _situation(entry: dict[str, Any]) -> Situation:
    return Situation(State(entry["u"], entry["ud"], entry["guess"]), entry["tau"], entry["qdd_motor"])


def reordered(described: Machine) -> Machine:
    """The machine with its rows in another order: of the rows whose antecedent stands already, the last one."""
    order: list[int] = []
    while len(order) < len(described.joints):
        numbered = enumerate(described.joints, start=1)
        order.append([j for j, row in numbered if j not in order and row.antecedent in (0, *order)][-1])
    number = {0: 0, **{j: k for k, j in enumerate(order, start=1)}}
    rows = [described.joint(j) for j in order]
    loops = [replace(loop, cut=number[loop.cut], meets=number[loop.meets]) for loop in described.loops]
    moved = tuple(replace(row, antecedent=number[row.antecedent]) for row in rows)
    return replace(described, joints=moved, loops=tuple(loops))
