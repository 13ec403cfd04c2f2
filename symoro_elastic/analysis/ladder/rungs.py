"""The ladder of models of a machine for a motion: what each leaves out, what that costs and saves, measured.

A rung leaves springs out, static or locked; the cheapest method and step that suffice are predicted for it. The rung
that is chosen, its neighbour and the whole machine are simulated, and the prediction is compared with what is measured.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

from symoro_elastic.analysis.ladder.climbed import Ladder
from symoro_elastic.analysis.ladder.greedy import spring_figures
from symoro_elastic.analysis.ladder.measured_budget import budget_of
from symoro_elastic.analysis.ladder.measured_rungs import Measurement
from symoro_elastic.analysis.ladder.predicted_rungs import Prediction
from symoro_elastic.analysis.ladder.rung import Rung
from symoro_elastic.analysis.simulation.compiled_steps import refuse_still
from symoro_elastic.analysis.simulation.prediction.output_matrices import is_torque
from symoro_elastic.analysis.simulation.reference_motion import reference_of
from symoro_elastic.analysis.simulation.simulate import Simulating, refuse_period
from symoro_elastic.analysis.simulation.tolerances import refuse_rounding
from symoro_elastic.codegen.integration.tableaus import RK4
from symoro_elastic.foundation.packages import for_vibrations
from symoro_elastic.foundation.progress import Announce, Progress, announce_nothing, no_progress
from symoro_elastic.machine.checks import require_fixed_base
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.prescribed_motion import PrescribedMotion
from symoro_elastic.machine.series_springs import Condensed, condense
from symoro_elastic.numerics.motion.signals import FrameSignal, outputs

COUNT, SEED = 20, 0
WAY_OUT = "leave it out, or name a frame beyond them"


def ladder(
    machine: Machine,
    motions: Sequence[PrescribedMotion],
    tolerance: Mapping[str, float],
    period: float | None = None,
    announce: Announce = announce_nothing,
    progress: Progress = no_progress,
    with_budget: bool = False,
) -> Ladder:
    """Return the ladder of a machine for some motions and tolerances by output; raises `InputError`."""
    announce("predict")
    prediction = prediction_of(machine, motions, tolerance, period)
    rungs = prediction.rungs(progress)
    announce("measure")
    measurement = Measurement(prediction)
    found = measured_ladder(measurement, rungs)
    if not with_budget:
        return found
    announce("spend")
    alone = None if found.chosen is None else found.rungs[found.chosen].chosen
    return replace(found, budget=budget_of(measurement, rungs, found.full, alone, progress))


def predicted_ladder(
    machine: Machine, motions: Sequence[PrescribedMotion], tolerance: Mapping[str, float], period: float | None = None
) -> Ladder:
    """Return the ladder with the rung chosen that is cheapest by prediction, nothing measured; raises `InputError`."""
    prediction = prediction_of(machine, motions, tolerance, period)
    rungs = prediction.rungs()
    return _ladder(prediction, rungs, next(iter(_by_cost(rungs)), None))


def prediction_of(
    machine: Machine, motions: Sequence[PrescribedMotion], tolerance: Mapping[str, float], period: float | None = None
) -> Prediction:
    """Return the prediction of rungs of a machine, springs in series condensed; raises `InputError`."""
    require_fixed_base(machine, "ladder")
    series = with_springs_joined(machine, motions, tolerance)
    references = tuple(reference_of(series.machine, motion) for motion in motions)
    prediction = Prediction(series.machine, references, tolerance, period, series.notes)
    for reference in references:
        refuse_still(reference)
        refuse_rounding(prediction.tolerance, reference)
        refuse_period(Simulating(reference, prediction.request))
    return prediction


def measured_ladder(measurement: Measurement, rungs: Sequence[Rung]) -> Ladder:
    """Return the ladder with the chosen rung and its neighbour measured; down to one whose prediction holds."""
    found, distrusted, chosen = list(rungs), list[int](), None
    for k in _by_cost(rungs):
        found[k] = replace(found[k], measured=measurement.errors(found[k]))
        if found[k].is_trusted(measurement.prediction.tolerance):
            chosen = k
            break
        distrusted.append(k)
    if chosen is not None and chosen + 1 < len(found) and not found[chosen + 1].locked:
        found[chosen + 1] = replace(found[chosen + 1], measured=measurement.errors(found[chosen + 1]))
    return _ladder(measurement.prediction, found, chosen, distrusted)


def _ladder(
    prediction: Prediction, rungs: Sequence[Rung], chosen: int | None, distrusted: Sequence[int] = ()
) -> Ladder:
    return Ladder(
        prediction.machine,
        prediction.references,
        prediction.tolerance,
        tuple(rungs),
        chosen,
        prediction.steps_of(rungs[0], (RK4.name,)),
        tuple(distrusted),
        {} if chosen is None else prediction.arithmetic(rungs[chosen]),
        spring_figures(prediction.paths, prediction.tolerance),
        prediction.condensed,
    )


def _by_cost(rungs: Sequence[Rung]) -> list[int]:
    """Return the numbers of the rungs that fit, the cheapest first."""
    costs = {k: rung.chosen.cost for k, rung in enumerate(rungs) if rung.chosen}
    return sorted(costs, key=lambda k: costs[k])


def with_springs_joined(
    machine: Machine, motions: Sequence[PrescribedMotion], signals: Iterable[str]
) -> Condensed[Machine]:
    """Return the machine with one spring in place of those in series, which is exact, and a line on each.

    Raises `InputError` for motions and signals that name what then is another thing: the variables of the joints, and
    frames between them.
    """
    found = condense(machine)
    for motion in motions:
        for name in found.variables.intersection(motion.start):
            what = f"{name} is one of two springs in series, which are merged: {WAY_OUT}"
            raise motion.error(f"start, {name}", what)
        for k, force in enumerate(motion.forces, 1):
            if force.at in found.between:
                what = f"{force.at} is between two springs in series, which are merged: {WAY_OUT}"
                raise motion.error(f"forces {k}, at", what)
    for name in signals:
        if _changes(machine, found, name):
            what = f"{name} belongs to two springs in series, which are merged: {WAY_OUT}"
            raise machine.error("wanted, tolerance", what)
    return found


def _changes(machine: Machine, found: Condensed[Machine], name: str) -> bool:
    """Whether a signal is of a variable, or of a frame, that condensing changes."""
    if not found.variables or is_torque(name):
        return False
    (signal,) = outputs(machine, [name])
    joint = machine.joint(signal.number).name
    return joint in (found.between if isinstance(signal, FrameSignal) else found.variables)


def starts(box: Mapping[str, tuple[float, float]], count: int = COUNT, seed: int = SEED) -> list[dict[str, float]]:
    """Return positions by joint in a box of ranges by joint, rad or m: a Latin hypercube, the same for a seed.

    Each range is divided into `count` parts, and each part holds one position.
    """
    qmc = for_vibrations("scipy.stats.qmc")
    shares = qmc.LatinHypercube(len(box), seed=seed).random(count)
    return [
        {name: low + share * (high - low) for (name, (low, high)), share in zip(box.items(), row, strict=True)}
        for row in shares.tolist()
    ]
