"""Rows of a body by modes: the body, a row for each mode, and coupled rows that follow them to its interfaces."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from symoro_elastic.formats.toml.flexible.beams import END, displacement, own_axes
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.machine.beams.beam import Beam
from symoro_elastic.machine.beams.modes import ALONG, ModalBeam, Mode, modal_beam
from symoro_elastic.machine.beams.sections import AXIAL, TORSION
from symoro_elastic.machine.flexible import FlexibleBody, without_rounding
from symoro_elastic.machine.joints import SELECTED

Entries = dict[str, Any]
Rows = tuple[list[Entries], dict[str, dict[str, Entries]]]
"""Rows, and entries of tables by joint."""
ROOT = "_root"
"""End of the name of the row that has a body by modes."""
CARRIAGE = "_body"
"""End of the name of the row that has the body of a slide along a beam."""
TO_AXIS = (np.eye(3)[:, [1, 2, 0]], np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]]), np.eye(3))
"""Frames with z along x, y, z."""
MOVES = (("shift", 0), ("shift", 1), ("shift", 2), ("turn", 2), ("turn", 1), ("turn", 0))
"""Moves of what slides along a body, in their order."""
LONGEST = 900
"""Characters of a formula; a cell may have 1000."""
UPPER = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))


@dataclass(frozen=True, eq=False)
class Follower:
    """A frame on a modal body: its row, its point at rest, displacement and rotation by modes (m, 3), its axes (3, 3).

    `shorter` are foreshortenings against an axis: label of the row, axis, and w of e^T w e/2.
    """

    name: str
    point: Array
    shift: Array
    turn: Array
    axes: Array
    shorter: Sequence[tuple[str, int, Array]] = ()


@dataclass(frozen=True, eq=False)
class ModalRows:
    """Data for the rows of a modal body: name, sigma, stiffness and damping of the modes, and following frames.

    `rigid` are mass, first moments and inertia at rest.
    """

    name: str
    labels: Sequence[str]
    sigmas: Sequence[int]
    stiffness: Sequence[float]
    damping: Sequence[float]
    rigid: tuple[float, Array, Array]
    followers: Sequence[Follower]

    def rows(self, placed: Entries) -> Rows:
        """Rows of the body, placed by cells `placed` in the row that carries it; bodies and springs by name."""
        root = self.name + ROOT
        rows = [{"name": root, "kind": "fixed", **placed}]
        for label, sigma in zip(self.labels, self.sigmas, strict=True):
            row = {"name": label, "antecedent": root, "kind": "elastic", "sigma": sigma}
            rows.append({**row, SELECTED[sigma]: label})
        numbers = zip(self.labels, self.stiffness, self.damping, strict=True)
        springs = {label: {"stiffness": repr(float(k)), "damping": repr(float(d))} for label, k, d in numbers}
        mass, moments, J = self.rigid
        body = {
            "mass": repr(mass),
            "first_moments": _texts(moments),
            "inertia_at_origin": _texts(J[at] for at in UPPER),
        }
        for follower in self.followers:
            rows += self._to(follower)
        return rows, {"springs": springs, "bodies": {root: body}}

    def _to(self, follower: Follower) -> Iterator[Entries]:
        """Coupled rows that move a following frame, and a fixed row at their end."""
        axes, first = np.eye(3), {"antecedent": self.name + ROOT}
        for what, axis, formula in self._moves(follower):
            sigma = int(what != "turn")
            cells = displacement(axes, TO_AXIS[axis])
            own = SELECTED[sigma]
            cells[own] = " + ".join([formula, *([cells[own]] if own in cells else [])])
            follows = any(label in formula for label in self.labels)
            kind = {"kind": "coupled", "sigma": sigma} if follows else {"kind": "fixed"}
            yield {"name": f"{follower.name}_{what}_{'xyz'[axis]}", **first, **kind, **cells}
            axes, first = TO_AXIS[axis], {}
        yield {"name": follower.name, **first, "kind": "fixed", **displacement(axes, follower.axes)}

    def _moves(self, follower: Follower) -> Iterator[tuple[str, int, str]]:
        """Translations along x, y, z and rotations about z, y, x of a frame: name, axis and formula."""
        point, shift, turn = map(without_rounding, (follower.point, follower.shift, follower.turn))
        for axis in range(3):
            at = [repr(float(point[axis]))] if point[axis] else []
            yield from _parts("shift", axis, [*at, *_linear(shift[:, axis], self.labels)])
            for what, along, w in follower.shorter:
                if along == axis:
                    for part, _, formula in _parts(what, axis, _quadratic(w, self.labels)):
                        yield part, axis, f"-({formula})"
        for axis in (2, 1, 0):
            yield from _parts("turn", axis, _linear(turn[:, axis], self.labels))


def _parts(what: str, axis: int, terms: Iterable[str]) -> Iterator[tuple[str, int, str]]:
    """Motions along or about one axis whose formulas add up to a sum, split if it is too long for one formula."""
    formulas: list[str] = []
    for term in terms:
        if formulas and len(formulas[-1]) + len(term) < LONGEST:
            formulas[-1] += f" + {term}"
        else:
            formulas.append(term)
    for k, formula in enumerate(formulas):
        yield f"{what}{k + 1}" if k else what, axis, formula


def rows_of_beam(beam: Beam, values: Mapping[str, float]) -> Rows:
    """Rows of a beam by modes below its root, and their bodies and springs by name."""
    root, modal = own_axes(beam), _of_beam(beam, values)
    kinds = {kind: np.array([mode.kind == kind for mode in modal.modes]) for kind in beam.bends}
    shorter = [
        (f"shorter_{kind}", 0, np.where(np.outer(own, own), modal.shortening, 0.0)) for kind, own in kinds.items()
    ]
    tip = Follower(beam.name + END, np.array([modal.length, 0, 0]), modal.tip, modal.turn, root, shorter)
    modes = modal.modes
    sigmas = [int(mode.kind != TORSION) for mode in modes]
    springs = [mode.stiffness for mode in modes], [mode.damping for mode in modes]
    rows = ModalRows(beam.name, _labels(beam, modal), sigmas, *springs, modal.rigid, [tip])
    return rows.rows(displacement(root, np.eye(3)))


@dataclass(frozen=True, eq=False)
class Guideway:
    """A straight line on a modal body that guides a slide: the root row of the body, and names of its modes.

    `moves` are the polynomials of each mode, by powers of the distance in m, for "shift" and "turn" along the axes of
    the line, x along it: columns of `axes` (3, 3) in the frame of the root. It begins at `point` and is `length` long;
    what slides has at rest the axes `frame`.
    """

    root: str
    labels: Sequence[str]
    moves: Mapping[tuple[str, int], Sequence[Sequence[float]]]
    length: float
    point: Array
    axes: Array
    frame: Array
    is_stiffened: bool = False

    def rows(self, name: str, own: Entries, place: str) -> list[Entries]:
        """Rows of a slide: its own, coupled rows for deflection and slope at its position, and a frame.

        `place` is the formula of its distance from the beginning, `own` are the other cells of its row.
        """
        axes, first = np.eye(3), {"antecedent": self.root}
        rows = []
        for axis in np.flatnonzero(self.point).tolist():
            cells = {**displacement(axes, TO_AXIS[axis]), "r": repr(float(self.point[axis]))}
            rows.append({"name": f"{name}_at_{'xyz'[axis]}", **first, "kind": "fixed", **cells})
            axes, first = TO_AXIS[axis], {}
        rows.append({"name": name, **first, **own, **displacement(axes, self.axes @ TO_AXIS[0]), "r": place})
        axes = self.axes @ TO_AXIS[0]
        for (what, axis), polynomials in self.moves.items():
            pairs = zip(self.labels, polynomials, strict=True)
            terms = [f"{label}*({_at_place(x, place)})" for label, x in pairs if any(x)]
            for part, _, formula in _parts(what, axis, terms):
                sigma, turned = int(what == "shift"), self.axes @ TO_AXIS[axis]
                cells = displacement(axes, turned)
                selected = SELECTED[sigma]
                cells[selected] = " + ".join([formula, *([cells[selected]] if selected in cells else [])])
                rows.append({"name": f"{name}_{part}_{'xyz'[axis]}", "kind": "coupled", "sigma": sigma, **cells})
                axes = turned
        return [*rows, {"name": name + CARRIAGE, "kind": "fixed", **displacement(axes, self.frame)}]


def along_beam(beam: Beam, values: Mapping[str, float]) -> Guideway:
    """Guideway along the axis of a beam by modes."""
    modal = _of_beam(beam, values)
    moves = {(what, k): [_motion(mode, what, k, modal.length) for mode in modal.modes] for what, k in MOVES}
    root = beam.name + ROOT
    return Guideway(
        root, _labels(beam, modal), moves, modal.length, np.zeros(3), np.eye(3), own_axes(beam), beam.stiffening
    )


def _motion(mode: Mode, what: str, axis: int, length: float) -> list[float]:
    """Polynomial coefficients in x, m, of a mode's displacement or rotation along an axis; empty if it is zero."""
    is_bar = mode.kind in (TORSION, AXIAL)
    direction = ALONG if is_bar else mode.direction if what == "shift" else np.cross(ALONG, mode.direction)
    moves = (what == "shift") == (mode.kind != TORSION) if is_bar else True
    if not moves or not direction[axis]:
        return []
    shape = mode.shape if is_bar or what == "shift" else mode.slope / length
    return [float(direction[axis] * c / length**k) for k, c in enumerate(shape.coef)]


def _at_place(coefficients: Sequence[float], place: str) -> str:
    """Text of a polynomial evaluated at a position, by Horner's rule."""
    *others, last = np.trim_zeros(coefficients, "b")
    text = repr(last)
    for c in reversed(others):
        text = f"({place})*({text})" if c == 0.0 else f"{c!r} + ({place})*({text})"
    return text


def body_of_beam(beam: Beam, values: Mapping[str, float]) -> FlexibleBody:
    """Flexible body for the rows of a beam by modes."""
    modal = _of_beam(beam, values)
    return modal.body(beam.name + ROOT, _labels(beam, modal))


def _of_beam(beam: Beam, values: Mapping[str, float]) -> ModalBeam:
    """Modes of a beam in its own frame."""
    directions = {kind: own_axes(beam) @ np.eye(3)["xyz".index(kind)] for kind in beam.transverse}
    return modal_beam(beam, values, directions)


def _labels(beam: Beam, modal: ModalBeam) -> list[str]:
    """Names of the rows of modes: NAME_y1, NAME_y2, NAME_torsion1."""
    kinds = [mode.kind for mode in modal.modes]
    return [f"{beam.name}_{kind}{kinds[: k + 1].count(kind)}" for k, kind in enumerate(kinds)]


def _texts(numbers: Iterable[float]) -> list[str]:
    return [repr(x) for x in without_rounding(np.array([*numbers], dtype=float)).tolist()]


def _linear(factors: Array, labels: Sequence[str]) -> Iterator[str]:
    """Terms of a sum of factors times variables."""
    pairs = zip(without_rounding(factors).tolist(), labels, strict=True)
    return (label if x == 1.0 else f"({x!r})*{label}" for x, label in pairs if x)


def _quadratic(w: Array, labels: Sequence[str]) -> Iterator[str]:
    """Terms of the quadratic form e^T w e/2 with symmetric w in the variables e."""
    pairs = ((k, m) for k in range(len(labels)) for m in range(k + 1))
    factors = ((k, m, float(w[k, m]) / (2 if m == k else 1)) for k, m in pairs)
    return (f"({x!r})*{labels[k]}*{labels[m]}" for k, m, x in factors if x)
