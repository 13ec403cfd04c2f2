"""The budget as a table, as data for JSON, and as sentences."""

from __future__ import annotations

from itertools import groupby
from typing import Any

from symoro_elastic.analysis.ladder.budget import Budget, MeasuredEnd, PathStep, Spent
from symoro_elastic.analysis.simulation.periods import quantity
from symoro_elastic.analysis.simulation.tolerances import unit_of
from symoro_elastic.foundation.errors import some_of
from symoro_elastic.foundation.results import Field, Part, Table, declare, parts_of

MOST_NAMED = 4
SMALL = 1e-6
"""Of the tolerance: errors that are not distinguished."""
STANDS_ON = "errors are predicted by the linear model along the motion, none is proven; the last model is simulated"


@parts_of.register
def budget_parts(found: Budget) -> list[Part]:
    """Return the table of the path, what the end leaves out, what was measured, and times."""
    lines = [advice(found), measured_line(found), times_line(found), *_dropped(found), STANDS_ON]
    return [budget_table(found), *lines]


def budget_table(found: Budget) -> Table:
    """Return a row for each step of the path; equal ones that follow each other are one row."""
    worst = found.worst_output
    unit, tolerance = unit_of(found.machine, worst), found.tolerance[worst]
    heads = "spent on", "", f"adds to {worst}", "", "sum", "operations", "steps", "against full"
    table = Table(
        heads, title=f"{found.machine.name}: one budget for everything, {quantity(tolerance, unit)} of {worst}"
    )
    for spent, group in groupby(found.path, key=lambda step: step.spent):
        steps = list(group)
        last = steps[-1]
        table.add_row(
            str(spent),
            some_of([name for step in steps for name in step.names], MOST_NAMED),
            _small(sum(step.added[worst] for step in steps), tolerance, unit),
            str(last.word),
            f"{last.total[worst] / tolerance:.1%}",
            str(last.steps.operations),
            f"{last.steps.steps} {last.steps.method}".strip(),
            f"{found.full.cost / last.steps.cost:.3g}",
        )
    return table


def advice(found: Budget) -> str:
    """Return one sentence: what the advised model leaves out, and what that saves."""
    rung, steps = found.advised.rung, found.advised.steps
    parts = [f"{len(rung.left_out)} springs static ({', '.join(rung.left_out)})"] if rung.left_out else []
    parts += [f"held where they are neutral: {', '.join(rung.neutral)}"] if rung.neutral else []
    parts += [f"without {', '.join(rung.zero)}"] if rung.zero else []
    parts += [f"{steps.steps} steps of {steps.method}"] if steps.method else []
    parts += ["mixed precision"] if found.advised.spent is Spent.PRECISION else []
    than = "the whole machine" if found.alone is None else "with springs alone left out"
    saved = f"{found.saved:.0%} fewer operations than {than}" if found.saved > 0 else f"no fewer operations than {than}"
    return f"{'; '.join(parts) or 'nothing is left out'}: {saved}"


def measured_line(found: Budget) -> str:
    """Return the errors of the end, simulated beside the whole machine, and the sums that were predicted."""
    errors = [
        f"{name} {quantity(x, unit_of(found.machine, name))} off, at most "
        f"{quantity(found.advised.total[name], unit_of(found.machine, name))} by prediction"
        for name, x in found.measured.errors.items()
    ]
    verdict = "within the tolerance" if found.is_within else "beyond the tolerance"
    return f"simulated beside the whole machine: {', '.join(errors)}: {verdict}"


def times_line(found: Budget) -> str:
    """Return the times of a step in both precisions, and which is taken."""
    times = found.measured
    if not times.seconds:
        return "nothing is left to integrate"
    taken = "mixed" if found.advised.spent is Spent.PRECISION else "double"
    worst = found.worst_output
    off = quantity(times.errors_mixed[worst], unit_of(found.machine, worst))
    both = f"{quantity(times.seconds, 's')} in double, {quantity(times.mixed, 's')} in mixed precision"
    return f"a step takes {both} ({worst} then {off} off) on this computer: {taken} precision"


def _dropped(found: Budget) -> list[str]:
    """Return a line on steps of the path that were taken back."""
    names = [name for step in found.dropped for name in (step.names or (str(step.spent),))]
    return (
        [f"taken back, because the simulation was beyond the tolerance: {some_of(names, MOST_NAMED)}"] if names else []
    )


def _small(error: float, tolerance: float, unit: str) -> str:
    """Return an error, or what it is below where it is a rounding."""
    least = SMALL * tolerance
    return quantity(error, unit) if error >= least else f"< {quantity(least, unit)}"


def _step_json(step: PathStep) -> dict[str, Any]:
    return {
        "spent": str(step.spent),
        "names": list(step.names),
        "added": dict(step.added),
        "word": str(step.word),
        "total": dict(step.total),
        "method": step.steps.method,
        "steps": step.steps.steps,
        "operations": step.steps.operations,
        "cost": step.steps.cost,
    }


declare(
    MeasuredEnd,
    Field("errors"),
    Field("errors_mixed"),
    Field("seconds_double", "seconds"),
    Field("seconds_mixed", "mixed"),
)
declare(
    Budget,
    Field("tolerance"),
    Field("path", lambda x: [_step_json(step) for step in x.path]),
    Field("static", "advised.rung.left_out"),
    Field("neutral", "advised.rung.neutral"),
    Field("zero", "advised.rung.zero"),
    Field("measured"),
    Field("within", "is_within"),
    Field("saved"),
    Field("dropped", lambda x: [_step_json(step) for step in x.dropped]),
    Field("advice", advice),
)
