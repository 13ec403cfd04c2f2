"""Modes at the amplitude of a picture: displacements of points of the machine, and where it moves most."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from symoro_elastic.analysis.vibration.modes import Modes, frame_shapes
from symoro_elastic.foundation.array_types import AnyArray, Array
from symoro_elastic.foundation.pictures import Plot
from symoro_elastic.foundation.plot_style import curve, shades
from symoro_elastic.machine.checks import parameter_values
from symoro_elastic.machine.flexible import Surface
from symoro_elastic.models.bound.joint_axes import placed_machine
from symoro_elastic.models.bound.viewing import upward, view_axes

AMPLITUDE = 0.08
"""Largest displacement of a drawn point by a mode at full amplitude, of the diagonal of the drawing."""
MOST_TURN = 0.35
"""Largest rotation of a frame at full amplitude, rad: small parts would turn over."""
MOST_ARROWS = 3
LEAST_ARROW = 0.5
"""Of the largest displacement: smaller ones have no arrow."""
EQUAL = 3
"""Decimals of displacements over the largest: of equal ones the first has the arrow, joints before their bodies."""
MOST_TRIANGLES, THIN = 300, 0.4
"""Of the surface of a body by modes, and the width of its lines, points."""
MOST_PICTURES, COLUMNS = 6, 3
ARM = 0.08
"""Of the diagonal around all origins: the lines along the axes of a frame, which show that it turns."""


@dataclass(frozen=True)
class DrawnPoints:
    """Points (P, 3) m of a machine, in frame 0, each fixed to a frame (P,) with its origin (P, 3); 0 is the base."""

    points: Array
    frames: Array
    origins: Array
    extent: float
    bent: tuple[BentPoints, ...] = ()


@dataclass(frozen=True)
class BentPoints:
    """Drawn points, by index, on the surface of a modal body with axes (3, 3) in frame 0.

    `rows` are its modes, whose frames slide along z of the body by their deflections.
    """

    indices: range
    root: int
    rows: tuple[int, ...]
    axes: Array
    surface: Surface

    @property
    def edges(self) -> AnyArray:
        """Edges of the surface's triangles, pairs of indices (E, 2)."""
        pairs = self.surface.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
        return np.asarray(self.indices.start + np.unique(np.sort(pairs, axis=1), axis=0))

    def displacements(self, motion: Array) -> Array:
        """Return elastic displacements (N, 3) of the points by the modes, in a motion (frames, 6)."""
        e = (motion[list(self.rows), :3] - motion[self.root, :3]) @ self.axes[:, 2]
        return np.asarray(np.tensordot(e, self.surface.modes, axes=1) @ self.axes.T)


@dataclass(frozen=True)
class DrawnMode:
    """Mode k at full amplitude: `factor` of its shape, displacements (P, 3) m of points, and which have arrows."""

    k: int
    factor: float
    displacements: Array
    arrows: list[int]


def drawn_modes(modal: Modes, some: Sequence[int], drawn: DrawnPoints) -> Iterator[DrawnMode]:
    """Yield some modes at the amplitude that suits the extent of drawn points, m."""
    shapes = np.concatenate([np.zeros((1, 6, len(modal.eigenvalues))), frame_shapes(modal)])
    for k in some:
        motion = shapes[drawn.frames, :, k]
        displaced = motion[:, :3] + np.cross(motion[:, 3:], drawn.points - drawn.origins)
        for body in drawn.bent:
            displaced[body.indices] += body.displacements(shapes[:, :, k])
        far = np.linalg.norm(displaced, axis=1)
        turn = float(np.linalg.norm(shapes[:, 3:, k], axis=1).max())
        largest = max(float(far.max(initial=0.0)) / (AMPLITUDE * drawn.extent), turn / MOST_TURN)
        factor = 1 / largest if largest > 0 else 0.0
        yield DrawnMode(k, factor, factor * displaced, _farthest(drawn.points, far, AMPLITUDE * drawn.extent))


def _farthest(points: Array, far: Array, apart: float) -> list[int]:
    """Indices of points (P, 3) at least `apart`, m, that move most; `far` (P,) are their displacements."""
    chosen: list[int] = []
    largest = far.max(initial=0.0) or np.inf
    for i in np.argsort(-np.round(far / largest, EQUAL), kind="stable").tolist():
        if len(chosen) == MOST_ARROWS or not far[i] > LEAST_ARROW * largest:
            break
        if all(np.linalg.norm(points[i] - points[j]) > apart for j in chosen):
            chosen.append(i)
    return chosen


def mode_pictures(modal: Modes) -> Plot | str:
    """Return links and axes of a machine at full amplitude of its lowest modes, and at rest; or why there are none."""
    vibrating = [int(k) for k in np.flatnonzero(modal.frequencies > 0)][:MOST_PICTURES]
    if not vibrating:
        return "no mode vibrates"
    columns = min(COLUMNS, len(vibrating))
    rows = -(-len(vibrating) // columns)
    title = f"{modal.linear.motion.machine.name}: modes at full amplitude, grey: at rest"
    size = (3.0 * columns, 0.4 + 2.8 * rows)
    return Plot(title, partial(_draw, modal, vibrating), rows, columns, size, share_x=False)


def _draw(modal: Modes, some: Sequence[int], *axes: Any) -> None:
    drawn, lines = _skeleton(modal)
    machine = modal.linear.motion.machine
    view = view_axes(upward(machine, parameter_values(machine)))[:2].T
    rest = drawn.points @ view
    for mode, axis in zip(drawn_modes(modal, some, drawn), axes, strict=False):
        moved = rest + mode.displacements @ view
        for points, look in ((rest, {"color": shades().grey, "linewidth": 0.7}), (moved, curve(0))):
            for pairs, width in ((lines, {}), *((body.edges, {"linewidth": THIN}) for body in drawn.bent)):
                axis.plot(*np.insert(points[np.array(pairs)], 2, np.nan, axis=1).reshape(-1, 2).T, **(look | width))
        for i in mode.arrows:
            arrow = {"arrowstyle": "-|>", "color": curve(1)["color"], "shrinkA": 0, "shrinkB": 0}
            axis.annotate("", moved[i], rest[i], arrowprops=arrow)
        axis.set(aspect="equal", xticks=[], yticks=[], xlabel=f"mode {mode.k + 1}: {modal.frequencies[mode.k]:.4g} Hz")
        axis.spines[:].set_visible(False)
    for axis in axes[len(some) :]:
        axis.set_axis_off()


def _skeleton(modal: Modes) -> tuple[DrawnPoints, list[list[int]]]:
    """Points of links, axes and surfaces of a machine; lines between the former as pairs of indices."""
    linear = modal.linear
    machine = linear.motion.machine
    names = (joint.name for joint in machine.independent_joints)
    placed = placed_machine(machine, dict(zip(names, linear.state.q.tolist(), strict=True)))
    origins = np.array([(0.0, 0.0, 0.0), *(joint.origin for joint in placed.joints)])
    rows = [j for j in range(len(origins)) if j not in machine.modal_rows]
    extent = float(np.linalg.norm(np.ptp(origins[rows], axis=0))) or 1.0
    points, frames, lines = [*origins[rows]], [*rows], []
    for own, j in enumerate(rows[1:], start=1):
        antecedent = machine.joint(j).antecedent
        lines.append([len(points), own])
        points, frames = [*points, origins[antecedent]], [*frames, antecedent]
        for arm in ARM * extent * np.eye(3):
            lines.append([len(points), len(points) + 1])
            points, frames = [*points, origins[j] - arm, origins[j] + arm], [*frames, j, j]
    bent = []
    for root, (body, modes) in machine.flexible_bodies.items():
        if body.surface is not None:
            surface, x, z = body.surface.coarse(MOST_TRIANGLES), placed.joints[root - 1].x, placed.joints[root - 1].axis
            first, axes = len(points), np.stack([x, np.cross(z, x), z], axis=1)
            e = (origins[list(modes)] - origins[root]) @ axes[:, 2]
            points = [*points, *(origins[root] + surface.at(e) @ axes.T)]
            frames += [root] * len(surface.points)
            bent.append(BentPoints(range(first, len(points)), root, modes, axes, surface))
    stacked = np.array(frames)
    return DrawnPoints(np.array(points), stacked, origins[stacked], extent, tuple(bent)), lines
