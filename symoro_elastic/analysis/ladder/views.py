"""The ladder as a table, as data for JSON, as one sentence of advice, and as the scene of the rung that is chosen."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.scene import Scene
from symoro_elastic.machine.static_springs import held_positions
from symoro_elastic.machine.wanted import Wanted
from symoro_elastic.model_ladder.rung import Rung
from symoro_elastic.model_ladder.rungs import MODEL_SHARE, Ladder
from symoro_elastic.model_ladder.spring_errors import relative
from symoro_elastic.simulation.periods import period_line, quantity
from symoro_elastic.simulation.tolerances import unit_of

ARITHMETIC_SHARE = 0.05
"""Of a tolerance that arithmetic may take."""

LEAST_SAVING = 1.05
"""Operations of the whole machine with RK4 over those of a rung, from which they are told."""


def ladder_table(found: Ladder) -> Any:
    """Return a row for each rung: what is left out more, errors, steps, cost against the whole machine with RK4."""
    from rich.table import Table

    worst = worst_output(found)
    unit = unit_of(found.machine, worst)
    table = Table("springs left out", f"predicted ({worst})", "measured", "method", "step", "time", "against full", "")
    before: set[str] = set()
    for k, rung in enumerate(found.rungs):
        measured = rung.measured.model[worst] if rung.measured else None
        table.add_row(
            _name(rung, before),
            quantity(rung.predicted[worst], unit),
            "-" if measured is None else quantity(measured, unit),
            rung.chosen.method if rung.chosen else "-",
            quantity(_step(found, rung), "s") if rung.chosen else "-",
            quantity(rung.measured.seconds * rung.chosen.steps, "s") if rung.measured and rung.chosen else "-",
            f"{found.full.cost / rung.chosen.cost:.3g}" if rung.chosen else "-",
            _verdict(found, k),
        )
        before = set(rung.left_out)
    return table


def springs_table(found: Ladder) -> Any:
    """Return a row for each spring: what it costs alone, its activity and its frequency."""
    from rich.table import Table

    table = Table("spring", "static alone, of the tolerance", "activity", "alone it vibrates at")
    for one in found.springs:
        table.add_row(one.name, f"{one.alone:.2g}", quantity(one.activity, "J"), quantity(one.frequency, "Hz"))
    return table


def advice(found: Ladder) -> str:
    """Return one sentence: what to keep, what may follow statically, and with which steps."""
    within = ", ".join(
        f"{name} within {quantity(x, unit_of(found.machine, name))}" for name, x in found.tolerance.items()
    )
    if found.chosen is None:
        nearest = min(found.rungs, key=lambda rung: relative(rung.predicted, found.tolerance))
        what = f"{within}: no rung is good enough; the nearest one, {_described(found, nearest)}"
        return f"{what}, {_shortfall(found, nearest)}"
    rung = found.rungs[found.chosen]
    assert rung.chosen is not None
    many = "this motion" if len(found.references) == 1 else f"these {len(found.references)} motions"
    what = f"{within} over {many}: {_described(found, rung)}"
    if not rung.chosen.method:
        return f"{what}; nothing is left to integrate, for motors follow exactly"
    steps = f"{rung.chosen.method}, {rung.chosen.steps} steps of {quantity(_step(found, rung), 's')}"
    if found.saving < LEAST_SAVING:
        return f"{what}; {steps}"
    return f"{what}; {steps}, {found.saving:.3g} times fewer operations than the whole machine with RK4"


def _shortfall(found: Ladder, rung: Rung) -> str:
    """Return why a rung is not good enough: its model, its steps as measured, or springs that do not hold."""
    lost = relative(rung.predicted, found.tolerance)
    if rung.chosen is None and lost <= MODEL_SHARE:
        return f"takes {lost:.0%} of that, but its springs do not hold their loads"
    if rung.measured is None or rung.chosen is None:
        return f"takes {lost:.0%} of that"
    model, steps = (relative(x, found.tolerance) for x in (rung.measured.model, rung.measured.steps))
    taken = f"{rung.chosen.steps} steps of {rung.chosen.method}"
    predicted = relative(rung.chosen.predicted, found.tolerance)
    return f"takes {model:.0%} of that; its {taken} take {steps:.0%} where {predicted:.0%} were predicted"


def predicted_line(found: Ladder) -> str:
    """Return the advice on one line with the error that is predicted of the output that is worst."""
    if found.chosen is None:
        return advice(found)
    predicted = found.rungs[found.chosen].predicted
    worst = max(found.tolerance, key=lambda name: predicted[name] / found.tolerance[name])
    error = quantity(predicted[worst], unit_of(found.machine, worst))
    return f"{advice(found)}; error of {worst} by prediction {error}"


def arithmetic_line(found: Ladder) -> str:
    """Return a line on accelerations in single precision, states in double; empty where no rung is chosen."""
    if found.chosen is None:
        return ""
    worst = max(found.tolerance, key=lambda name: found.arithmetic[name] / found.tolerance[name])
    added = quantity(found.arithmetic[worst], unit_of(found.machine, worst))
    enough = found.arithmetic[worst] <= ARITHMETIC_SHARE * found.tolerance[worst]
    verdict = "mixed precision is enough" if enough else "use double precision"
    return f"accelerations in single precision add about {added} to {worst}: {verdict}"


def _described(found: Ladder, rung: Rung) -> str:
    kept = [
        joint.name
        for joint in found.machine.moving_joints
        if joint.kind == "elastic" and joint.name not in rung.left_out
    ]
    if not rung.left_out:
        return "keep every spring"
    how = "are locked" if rung.locked else "follow statically"
    left = f"{len(rung.left_out)} {how} ({', '.join(rung.left_out)})"
    return f"keep {', '.join(kept)} as springs, {left}" if kept else f"all springs, {left}"


def period_of(found: Ladder, wanted: Wanted) -> str:
    """Return how long the steps of a period take on the chosen rung; empty where there is none of both."""
    rung = found.rungs[found.chosen] if found.chosen is not None else None
    return period_line(wanted, _step(found, rung), rung.measured.seconds) if rung and rung.measured else ""


def reduced_scene(found: Ladder, whole: Machine, scene: Scene) -> Scene:
    """Return the scene of a whole machine with the method of the chosen rung, and its springs held where they start."""
    if found.chosen is None:
        return scene
    rung, reference = found.rungs[found.chosen], found.references[0]
    assert rung.chosen is not None
    rows = {joint.name: k for k, joint in enumerate(found.machine.moving_joints)}
    held = {name: Formula.parse(float(reference.start.q[rows[name]])) for name in rung.left_out}
    steps = tuple(dict.fromkeys((*scene.steps, *filter(None, (rung.chosen.method,)))))
    forces = dict.fromkeys((*scene.forces, *(str(x) for one in found.references for x in one.loaded.forces)))
    scene = replace(scene, forces=tuple(forces), steps=steps, condense=scene.condense or bool(found.condensed))
    if rung.locked:
        return replace(scene, locked={**scene.locked, **held})
    return replace(scene, static={**held_positions(whole, scene.static), **held})


def ladder_json(found: Ladder) -> dict[str, Any]:
    """Return all rungs as plain data."""
    return {
        "tolerance": dict(found.tolerance),
        "rungs": [_rung_json(found, k, rung) for k, rung in enumerate(found.rungs)],
        "chosen": found.chosen,
        "distrusted": list(found.distrusted),
        "full": {"method": found.full.method, "steps": found.full.steps, "operations": found.full.operations},
        "arithmetic": dict(found.arithmetic),
        "springs": [
            {"name": x.name, "alone": x.alone, "activity": x.activity, "frequency": x.frequency} for x in found.springs
        ],
        "condensed": list(found.condensed),
        "advice": advice(found),
    }


def _rung_json(found: Ladder, k: int, rung: Rung) -> dict[str, Any]:
    measured = rung.measured
    return {
        "left_out": list(rung.left_out),
        "locked": rung.locked,
        "predicted": dict(rung.predicted),
        "measured": dict(measured.model) if measured else None,
        "method": rung.chosen.method if rung.chosen else None,
        "steps": rung.chosen.steps if rung.chosen else None,
        "step": _step(found, rung) if rung.chosen else None,
        "operations": rung.chosen.operations if rung.chosen else None,
        "step_errors_predicted": dict(rung.chosen.predicted) if rung.chosen else None,
        "step_errors_measured": dict(measured.steps) if measured and rung.chosen else None,
        "seconds_per_step": measured.seconds if measured and rung.chosen else None,
        "verdict": _verdict(found, k),
    }


def worst_output(found: Ladder) -> str:
    """Return the output whose error is the largest part of its tolerance, over all rungs."""
    shares = {
        name: max(rung.predicted[name] for rung in found.rungs) / limit for name, limit in found.tolerance.items()
    }
    return max(shares, key=lambda name: shares[name])


def _name(rung: Rung, before: set[str]) -> str:
    if rung.locked:
        return "all, locked"
    new = [name for name in rung.left_out if name not in before]
    return f"+ {', '.join(new)}" if new else "none"


def _step(found: Ladder, rung: Rung) -> float:
    """Return the shortest step of a rung over all motions, s."""
    assert rung.chosen is not None
    return min(reference.duration for reference in found.references) / rung.chosen.steps


def _verdict(found: Ladder, k: int) -> str:
    if k == found.chosen:
        return "<- chosen"
    return "prediction failed" if k in found.distrusted else ""
