"""Meshes of triangles with fewer triangles."""

from __future__ import annotations

import numpy as np

from symoro_elastic.foundation.array_types import AnyArray, Array

COARSEST = 8
"""Cells of a grid across a mesh, at least."""


def coarse_mesh(points: Array, triangles: AnyArray, most: int) -> tuple[Array, AnyArray]:
    """Return a simplified mesh: points in one cell of a grid are merged at their mean.

    Points (N, 3 or more) may have other numbers after x, y, z, whose means follow. The grid is the finest, by halving,
    on which at most `most` triangles (M, 3) keep three cells.
    """
    cells = 1024
    low, size = points[:, :3].min(axis=0), float(np.ptp(points[:, :3], axis=0).max())
    while len(triangles) > most and cells >= COARSEST and size > 0:
        _, number = np.unique(np.floor((points[:, :3] - low) / size * cells), axis=0, return_inverse=True)
        number = number.reshape(-1)
        counts = np.bincount(number)
        points = np.stack([np.bincount(number, x) / counts for x in points.T], axis=1)
        triangles = number[triangles]
        a, b, c = triangles.T
        triangles = triangles[(a != b) & (b != c) & (c != a)]
        cells //= 2
    return points, triangles
