"""Plots of results at one position: stiffness by axis, over positions, results of models, solutions of a pose."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from symoro_elastic.analysis.poses.evaluation import EvaluatedResult, Evaluation
from symoro_elastic.analysis.poses.frame_stiffness import COMPONENTS, FrameStiffness, StiffnessMap
from symoro_elastic.analysis.poses.inverse_geometry import InverseGeometry
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.pictures import Plot
from symoro_elastic.foundation.plot_style import bars, by_unit, contours, curves, legend, map_of_numbers, y_label
from symoro_elastic.foundation.results import figures_of
from symoro_elastic.quantities.units import MICRO

MOST_SOLUTIONS = 6
"""As many as bars have distinct hatches."""
ROW = 0.3
"""Inches of a row of bars or numbers."""
N_PER_UM, N_M_PER_URAD = "N/um", "N m/urad"


@figures_of.register
def _(result: FrameStiffness) -> dict[str, Plot | str]:
    """Return stiffness: along and about the axes and in the worst direction, with the springs that yield."""
    title = f"{result.machine}: stiffness of {result.frame_name}, motors held"
    size = (8.0, 4.2 + ROW * len(_springs(result)))
    draw, ratios = partial(_by_axis, result), (4.0, 3.0, 1.0 + len(_springs(result)))
    return {"stiffness": Plot(title, draw, 3, size=size, ratios=ratios, share_x=False)}


def _springs(result: FrameStiffness) -> list[str]:
    return list(dict.fromkeys(name for shares in result.shares_by_axis.values() for name in shares))


def _stiffnesses(result: FrameStiffness) -> list[float]:
    """Along x, y, z, N/um, and about them, N m/urad; infinite for rigid axes."""
    return [1 / c / MICRO if c > 0 else np.inf for c in np.diagonal(result.compliance)]


def _by_axis(result: FrameStiffness, along: Any, about: Any, springs: Any) -> None:
    values = _stiffnesses(result)
    worst = result.least_stiffness / MICRO
    for axes, numbers, rows, unit in (
        (along, [*values[:3], worst], [*COMPONENTS[:3], "worst"], N_PER_UM),
        (about, values[3:], COMPONENTS[3:], N_M_PER_URAD),
    ):
        rigid = [f"{row}: rigid" if np.isinf(x) else row for row, x in zip(rows, numbers, strict=True)]
        bars(axes, {"stiffness": numbers}, rigid)
        axes.set_xlabel(f"stiffness, {unit}")
    names = _springs(result) or ["no spring yields"]
    shares = [[result.shares_by_axis[axis].get(name, 0.0) for axis in COMPONENTS] for name in names]
    map_of_numbers(springs, np.array(shares), names, COMPONENTS, "{:.0%}", "strain energy")
    springs.set_xlabel("force along, moment about")


@figures_of.register
def _(result: StiffnessMap) -> dict[str, Plot | str]:
    """Return stiffness: curves over the position of one joint, a map of the least over two, else over the points."""
    first = result.points[0]
    title = f"{first.machine}: stiffness of {first.frame_name}, motors held"
    if min(point.least_stiffness for point in result.points) == np.inf:
        return {"stiffness": "the frame is rigid at all positions"}
    positions = {name: np.array([point.at[name] for point in result.points]) for name in first.at}
    moved = {name: x for name, x in positions.items() if np.ptp(x) > 0}
    grid = [np.unique(x) for x in moved.values()]
    if len(moved) == 2 and np.prod([len(x) for x in grid]) == len(result.points):
        draw = partial(_over_two, result, moved, (len(grid[0]), len(grid[1])))
        return {"stiffness": Plot(f"{title}, in the worst direction", draw, size=(7.0, 5.0))}
    return {"stiffness": Plot(title, partial(_over_one, result, moved), size=(8.0, 4.5))}


def _over_two(result: StiffnessMap, moved: dict[str, Array], shape: tuple[int, int], axes: Any) -> None:
    order = np.lexsort([*moved.values()][::-1])
    x, y = (values[order].reshape(shape) for values in moved.values())
    least = np.array([point.least_stiffness / MICRO for point in result.points])[order].reshape(shape)
    contours(x, y, least, [f"{name}, rad or m" for name in moved], f"stiffness, {N_PER_UM}", axes)


def _over_one(result: StiffnessMap, moved: dict[str, Array], axes: Any) -> None:
    over, x = next(iter(moved.items())) if len(moved) == 1 else ("number of the point", np.arange(len(result.points)))
    columns = np.array([[*_stiffnesses(p)[:3], p.least_stiffness / MICRO] for p in result.points])
    columns = np.where(np.isfinite(columns), columns, np.nan)
    yields = np.flatnonzero(np.isfinite(columns).any(axis=0))
    order = np.argsort(x, kind="stable")
    names = [(*COMPONENTS[:3], "worst direction")[k] for k in yields]
    curves(axes, x[order], columns[np.ix_(order, yields)], names, marker=".")
    axes.set_ylim(bottom=0)
    y_label(axes, "stiffness", N_PER_UM)
    axes.set_xlabel(f"{over}, rad or m" if len(moved) == 1 else over)
    legend(axes)


@figures_of.register
def _(result: InverseGeometry) -> dict[str, Plot | str]:
    """Return solutions: the positions of the joints, a row for each unit."""
    title = f"{result.machine}: positions at which {result.frame_name} has the pose"
    shown = [x.joints for x in result.solutions[:MOST_SOLUTIONS]]
    if not shown:
        return {"solutions": f"no start reaches the pose: the nearest misses it by {result.miss:.3g} m"}
    title += f"; the nearest {len(shown)} of {len(result.solutions)}" if len(shown) < len(result.solutions) else ""
    names, units = list(result.units), by_unit(list(result.units.values()))
    size = (8.0, 1.0 + sum(0.6 + ROW * len(rows) * (1 + len(shown) / 3) for rows in units.values()))

    def draw(*axes: Any) -> None:
        for axis, (unit, rows) in zip(axes, units.items(), strict=True):
            series = {f"solution {k}": [joints[names[j]] for j in rows] for k, joints in enumerate(shown, 1)}
            bars(axis, series, [names[j] for j in rows])
            axis.set_xlabel(f"position, {unit}")
        legend(axes[0])

    return {"solutions": Plot(title, draw, len(units), size=size, share_x=False)}


@figures_of.register
def _(evaluation: Evaluation) -> dict[str, Plot | str]:
    """Return <model>_<result>: bars of numbers, or a map of the entries; <model>_<result>_<frame> of matrices."""
    plots: dict[str, Plot | str] = {}
    for model, results in evaluation.models.items():
        for result in results:
            entries = {row: np.asarray(x, dtype=float) for row, x in result.entries.items()}
            matrices = {f"_{row}": x for row, x in entries.items() if x.ndim == 2}
            numbers = {} if matrices else {"": np.array([x.ravel() for x in entries.values()])}
            for suffix, values in {**matrices, **numbers}.items():
                rows = (
                    [*entries]
                    if numbers
                    else COMPONENTS
                    if len(values) == len(COMPONENTS)
                    else range(1, len(values) + 1)
                )
                name = f"{model}_{result.name}{suffix}"
                plots[name] = _numbers(f"{evaluation.machine}: {name}", result, [*map(str, rows)], values)
    return plots


def _numbers(title: str, result: EvaluatedResult, rows: Any, values: Array) -> Plot:
    largest = float(np.abs(values[np.isfinite(values)]).max(initial=0.0)) or 1.0
    names = result.columns or tuple(str(k + 1) for k in range(values.shape[1]))

    def draw(axes: Any) -> None:
        if values.shape[1] == 1:
            bars(axes, {result.name: values[:, 0].tolist()}, rows)
        else:
            map_of_numbers(axes, values / largest, rows, names, "{:.2f}", f"entry, of {largest:.4g}")
        axes.set_xlabel(result.meaning)

    return Plot(title, draw, size=(max(5.5, 3.2 + 0.55 * len(names)), 1.9 + ROW * len(rows)))
