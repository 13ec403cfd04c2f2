"""Springs are left out in an order that no other spring at the same rung beats."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from symoro_elastic.analysis.ladder import greedy
from symoro_elastic.analysis.ladder.greedy import backward_greedy, spring_figures
from symoro_elastic.analysis.simulation.prediction.path import linear_path
from symoro_elastic.analysis.simulation.prediction.spring_errors import Deviations, relative, spring_errors
from tests.analysis.ladder.motions import moved
from tests.analysis.ladder.scenes import moving, random_springs
from tests.analysis.vibration.machines import drive

SAMPLES = 200


def test_each_rung_leaves_out_the_spring_that_costs_least() -> None:
    scene = moving("random", random_springs(3, 7, (20, 80, 50), 0.02), 0.3, 0.3, 1e-5)
    path = linear_path(scene.reference, scene.outputs, SAMPLES)
    rungs, tolerance = backward_greedy([path], scene.tolerances), scene.tolerances
    assert [len(rung.left_out) for rung in rungs] == list(range(len(path.springs) + 1))
    assert set(rungs[-1].left_out) == set(path.names(path.springs))
    for rung, after in pairwise(rungs):
        before = {path.joints.index(name) for name in rung.left_out}
        others = [{*before, k} for k in path.springs if k not in before]
        least = min(relative(x.static, tolerance) for x in spring_errors([Deviations(path)], others))
        assert relative(after.static, tolerance) == pytest.approx(least)


@pytest.mark.thorough
def test_of_many_springs_the_best_are_tried(monkeypatch: pytest.MonkeyPatch) -> None:
    """All at first, then six at most: the same order here as if all were."""
    scene = moving("random", random_springs(5, 10, (20, 80, 50, 35), 0.02), 0.3, 0.3, 1e-5)
    path = linear_path(scene.reference, scene.outputs, SAMPLES)
    counts: list[int] = []

    def counted(paths: list[Deviations], sets: list[tuple[int, ...]]) -> list[greedy.Errors]:
        counts.append(len(sets))
        return spring_errors(paths, sets)

    every = backward_greedy([path], scene.tolerances)
    monkeypatch.setattr(greedy, "spring_errors", counted)
    monkeypatch.setattr(greedy, "ALL_TRIED", 4)
    monkeypatch.setattr(greedy, "BEST_TRIED", 3)
    assert backward_greedy([path], scene.tolerances) == every
    n = len(path.springs)
    assert n > 4 and counts == [1, n, *(min(3, left) for left in range(n - 1, 0, -1))]


def test_figures_of_a_spring_in_closed_form() -> None:
    """One spring: sqrt(k/m); alone it costs what the only rung costs; activity is the work that goes in and out."""
    reference = moved(drive(m2=5.0, k=2e4, d=40.0), 0.5, {"motor": (0.1, 0.5)})
    path = linear_path(reference, ("load.z",), SAMPLES)
    tolerance = {"load.z": 1e-6}
    (figures,) = spring_figures([path], tolerance)
    assert figures.name == "load"
    assert figures.frequency == pytest.approx(np.sqrt(2e4 / 5.0) / (2 * np.pi))
    assert figures.alone == pytest.approx(relative(backward_greedy([path], tolerance)[1].static, tolerance))
    energy = 0.5 * 2e4 * Deviations(path).whole.d[:, 0, 1] ** 2
    assert figures.activity == pytest.approx(np.abs(np.diff(energy)).sum(), rel=1e-2)
