"""Rows of a beam by modes: its body, a row for each mode, and coupled rows that follow them to its tip."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

import numpy as np

from symoro_elastic.formats.toml.beams import END, displacement, own_axes
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.machine.beam_modes import ModalBeam, modal_beam
from symoro_elastic.machine.beams import TORSION, Beam
from symoro_elastic.machine.flexible import FlexibleBody
from symoro_elastic.machine.joints import SELECTED

Entries = dict[str, Any]
ROOT = "_root"
"""End of the name of the row that has the body of a beam by modes."""
TO_AXIS = (np.eye(3)[:, [1, 2, 0]], np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]]), np.eye(3))
"""Frames with z along x, y, z of the beam."""


def modal_rows(beam: Beam, values: Mapping[str, float]) -> tuple[list[Entries], dict[str, dict[str, Entries]]]:
    """The rows of a beam by modes below that of its root, and their bodies and springs by name."""
    root, made = own_axes(beam), of_beam(beam, values)
    labels = names_of(beam, made)
    rows = [{"name": beam.name + ROOT, "kind": "fixed", **displacement(root, np.eye(3))}]
    springs = {}
    for label, mode in zip(labels, made.modes, strict=True):
        sigma = int(mode.kind != TORSION)
        row = {"name": label, "kind": "elastic", "sigma": sigma, SELECTED[sigma]: label}
        rows.append({**row, "antecedent": beam.name + ROOT})
        springs[label] = {"stiffness": repr(mode.stiffness), "damping": repr(mode.damping)}
    rows += [*_to_tip(beam, made, labels)]
    mass, moments, J = made.rigid
    inertia = [J[at] for at in ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))]
    body = {"mass": repr(mass), "first_moments": _texts(moments), "inertia_at_origin": _texts(inertia)}
    return rows, {"springs": springs, "bodies": {beam.name + ROOT: body}}


def _texts(numbers: Iterable[float]) -> list[str]:
    return [repr(float(x)) for x in numbers]


def of_beam(beam: Beam, values: Mapping[str, float]) -> ModalBeam:
    """The modes of a beam in its own frame."""
    directions = {kind: own_axes(beam) @ np.eye(3)["xyz".index(kind)] for kind in beam.transverse}
    return modal_beam(beam, values, directions)


def names_of(beam: Beam, modal: ModalBeam) -> list[str]:
    """Names of the rows of modes: NAME_y1, NAME_y2, NAME_torsion1."""
    kinds = [mode.kind for mode in modal.modes]
    return [f"{beam.name}_{kind}{kinds[: k + 1].count(kind)}" for k, kind in enumerate(kinds)]


def flexible_body(beam: Beam, values: Mapping[str, float]) -> FlexibleBody:
    """The flexible body of the rows of a beam by modes."""
    modal = of_beam(beam, values)
    return modal.body(beam.name + ROOT, names_of(beam, modal))


def _to_tip(beam: Beam, modal: ModalBeam, labels: list[str]) -> Iterator[Entries]:
    """Coupled rows from the root to the tip, and the fixed one at their end."""
    axes, first = np.eye(3), {"antecedent": beam.name + ROOT}
    for what, axis, formula in _moves_of_tip(beam, modal, labels):
        sigma = int(what != "turn")
        cells = displacement(axes, TO_AXIS[axis])
        own = SELECTED[sigma]
        cells[own] = " + ".join([formula, *([cells[own]] if own in cells else [])])
        kind = {"kind": "coupled", "sigma": sigma} if any(label in formula for label in labels) else {"kind": "fixed"}
        yield {"name": f"{beam.name}_{what}_{'xyz'[axis]}", **first, **kind, **cells}
        axes, first = TO_AXIS[axis], {}
    yield {"name": beam.name + END, "kind": "fixed", **displacement(axes, own_axes(beam))}


def _moves_of_tip(beam: Beam, modal: ModalBeam, labels: list[str]) -> Iterator[tuple[str, int, str]]:
    """Slides along x, y, z and turns about z, y, x of the tip: what, axis and formula."""
    along = _formula(modal.tip[:, 0], labels)
    yield "shift", 0, " + ".join(filter(None, (repr(modal.length), along)))
    for kind in beam.bends:
        own = [k for k, mode in enumerate(modal.modes) if mode.kind == kind]
        shorter = _quadratic(modal.shortening[np.ix_(own, own)], [labels[k] for k in own])
        if shorter:
            yield f"shorter_{kind}", 0, f"-({shorter})"
    moved = {"shift": modal.tip, "turn": modal.turn}
    for what, axis in (("shift", 1), ("shift", 2), ("turn", 2), ("turn", 1), ("turn", 0)):
        if formula := _formula(moved[what][:, axis], labels):
            yield what, axis, formula


def _formula(factors: Array, labels: list[str]) -> str:
    """A sum of factors times variables."""
    pairs = zip(factors.tolist(), labels, strict=True)
    return " + ".join(label if x == 1.0 else f"({x!r})*{label}" for x, label in pairs if x)


def _quadratic(w: Array, labels: list[str]) -> str:
    """e^T w e/2 of a symmetric w, in variables."""
    pairs = ((k, m) for k in range(len(labels)) for m in range(k + 1))
    factors = ((k, m, float(w[k, m]) / (2 if m == k else 1)) for k, m in pairs)
    return " + ".join(f"({x!r})*{labels[k]}*{labels[m]}" for k, m, x in factors if x)
