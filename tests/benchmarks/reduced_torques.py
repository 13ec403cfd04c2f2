"""Reduced inverse models fed forward: errors at the tool, predicted over measured, on drawn machines and motions.

python -m tests.benchmarks.reduced_torques [--draws 40]
python -m tests.benchmarks.reduced_torques --scenes      all that `reduce` advises, on machine tools, arms, portals
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from symoro_elastic.analysis.ladder.feed_forward import FedMeasurement, FeedForwardSearch, ReducedTorques
from symoro_elastic.analysis.ladder.predicted_rungs import Prediction
from symoro_elastic.analysis.ladder.reduced import Goal, Purpose, reduced_for
from symoro_elastic.analysis.ladder.rungs import Asked, prediction_of
from symoro_elastic.analysis.simulation.prediction.step_error import poles
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.described import DescribedMachine
from symoro_elastic.machine.prescribed_motion import Bandwidth
from symoro_elastic.machine.scene import Scene
from tests.analysis.ladder.scenes import Scene as Motion
from tests.analysis.ladder.scenes import arm, many, moving, random_springs
from tests.analysis.ladder.test_drives import GROWING, drawn, equipped

TOLERANCES = 1e-6, 3e-4
"""Drawn between these, m: from a servo's resolution to what an assembly robot repeats."""
TIP = "tip.x", "tip.y"
KINDS = "drives", "drives with set-point filters", "servos", "arms under servos"


@dataclass(frozen=True)
class Drawn:
    """A draw: what its largest used fraction of the tolerances was predicted to be, and measured, for each model."""

    kind: str
    seed: int
    operations: tuple[int, int]
    pairs: tuple[tuple[float, float], ...]
    advised: float | None

    @property
    def ratios(self) -> tuple[float, ...]:
        """Predicted over measured."""
        return tuple(predicted / measured for predicted, measured in self.pairs)


def draw(seed: int) -> Drawn | None:
    """Return the result of a draw; None where its loops are not stable or nothing can be left out."""
    kind, source = KINDS[seed % len(KINDS)], np.random.default_rng([seed, 45])
    tolerance = float(np.exp(source.uniform(*np.log(TOLERANCES))))
    machine, prediction = _prediction(kind, seed, source, tolerance)
    if poles(prediction.paths[0]).real.max() > GROWING:
        return None
    search = FeedForwardSearch(prediction, machine)
    result = search.run()
    measurement = FedMeasurement(prediction, search.full)
    pairs = list(_pairs(search, measurement, result.tried, result.full))
    chosen = result.chosen
    advised = search.budget.used_fraction(chosen.measured) if chosen and chosen.measured else None
    return Drawn(kind, seed, (result.operations, result.full), tuple(pairs), advised)


def _prediction(
    kind: str, seed: int, source: np.random.Generator, tolerance: float
) -> tuple[DescribedMachine, Prediction]:
    if kind in KINDS[:2]:
        machine = (drawn if kind == KINDS[0] else equipped)(seed)
        return machine, prediction_of(machine, machine.asked.motions, dict.fromkeys(TIP, tolerance))
    scene = _scene(kind, seed, source, tolerance)
    described = DescribedMachine.of(scene.reference.machine)
    return described, prediction_of(described, [scene.reference.prescribed], scene.tolerances)


def _scene(kind: str, seed: int, source: np.random.Generator, tolerance: float) -> Motion:
    frequencies = tuple(source.uniform(20, 90, 3))
    servo, lasts = Bandwidth(source.uniform(4, 10), source.uniform(0.6, 0.9)), source.uniform(0.15, 0.5)
    if kind == KINDS[2]:
        machine = random_springs(seed, 5 + seed % 3, frequencies, 0.02)
    else:
        machine = arm(("rx90.par", "puma560.par")[seed // 4 % 2], frequencies, 0.02)
    return moving("", machine, source.uniform(0.1, 0.6), lasts, tolerance, servo)


def _pairs(
    search: FeedForwardSearch, measurement: FedMeasurement, tried: tuple[ReducedTorques, ...], full: int
) -> Iterator[tuple[float, float]]:
    distinct = {x.operations: x for x in tried if x.operations < full}
    for model in distinct.values():
        predicted = search.budget.used_fraction(model.predicted)
        if 1e-3 < predicted < 3:
            measured = model.measured or measurement.errors(search.feed(model.model))
            yield predicted, search.budget.used_fraction(measured)


def scenes() -> Iterator[tuple[str, DescribedMachine, Prediction]]:
    """Yield machines and motions: the two-axis machine, arms and random trees, draws under drives."""
    for title, make in many().items():
        scene = make()
        described = DescribedMachine.of(scene.reference.machine)
        yield title, described, prediction_of(described, [scene.reference.prescribed], scene.tolerances)
    for seed in (201, 202, 203, 204):
        machine = equipped(seed) if seed % 2 else drawn(seed)
        yield f"drives {seed}", machine, prediction_of(machine, machine.asked.motions, dict.fromkeys(TIP, 1e-5))


def reduce_scenes() -> None:
    """Print what is advised for each scene: operations, and measured errors as fractions of the tolerance."""
    inside = []
    for title, machine, prediction in scenes():
        controlled = prediction.references[0].servo is not None
        purpose = Purpose.BOTH if controlled else Purpose.SIMULATION
        began = time.process_time()
        try:
            result = reduced_for(Goal(purpose), prediction, Asked(machine, Scene(), None))
        except InputError as error:
            print(f"{title}: {error}", flush=True)
            continue
        seconds = time.process_time() - began
        inside.append(result.is_within)
        print(f"{title}: {result.headline}; within: {result.is_within}; {seconds:.0f} s of processor", flush=True)
    print(f"{sum(inside)} of {len(inside)} within the tolerances")


def main() -> None:
    """Print a line for each draw, and the distribution of ratios."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--draws", type=int, default=40)
    parser.add_argument("--scenes", action="store_true")
    if parser.parse_args().scenes:
        reduce_scenes()
        return
    wanted, results, seed = parser.parse_args().draws, list[Drawn](), 100
    while len(results) < wanted and seed < 100 + 4 * wanted:
        seed += 1
        try:
            result = draw(seed)
        except InputError as error:
            print(f"{seed}: {error}", flush=True)
            continue
        if result is None or not result.pairs:
            continue
        results.append(result)
        listed = ", ".join(f"{x:.3f}" for x in result.ratios)
        left, full = result.operations
        advised = "nothing left out" if result.advised is None else f"advised: {result.advised:.1%} of the tolerance"
        print(f"{seed} {result.kind}: {left} of {full} operations; {advised}; predicted/measured {listed}", flush=True)
    every = np.array([x for result in results for x in result.ratios])
    near, wide = ((low <= every) & (every <= high) for low, high in ((0.7, 1.4), (0.5, 2.0)))
    used = [x.advised for x in results if x.advised is not None]
    print(f"{len(results)} draws, {len(every)} models: ratios {every.min():.3f} to {every.max():.3f}, ", end="")
    print(f"{near.mean():.1%} within 0.7 to 1.4, {wide.mean():.1%} within 0.5 to 2; ", end="")
    print(f"advised {len(used)}, largest measured error {max(used):.1%} of the tolerance")


if __name__ == "__main__":
    main()
