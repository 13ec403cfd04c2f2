"""Sentences on the omitted terms of reduced models: for readers, and for the comments of generated code."""

from __future__ import annotations

import math
from collections.abc import Sequence

from symoro_elastic.generation.reduced_models.model import ReducedModel
from symoro_elastic.machine.within import Evidence, Keep
from symoro_elastic.numerics.evaluation.quantile_bound import CONFIDENCE, share_beyond
from symoro_elastic.numerics.guarantees.fixed_point import Total
from symoro_elastic.numerics.within.frequencies import POSITIONS
from symoro_elastic.numerics.within.reduction import MOST_SEARCHES
from symoro_elastic.numerics.within.structure import STATES
from symoro_elastic.symbolic.expression import is_constant

PASSIVE = "The inertia matrix stays symmetric and positive definite, and power stays balanced"
KEPT = {
    Keep.PARAMETERS: f"{PASSIVE}: this is the full model of another machine.",
    Keep.INERTIA: f"{PASSIVE}: all forces of inertia and gravity are derivatives of the reduced energies.",
}
"""Structure that a reduced model has, by what is omitted."""


def sentences_on(model: ReducedModel) -> str:
    """Return sentences on the omitted terms of a model, and on the evidence for its errors."""
    reduction, changes = model.reduction, len(model.reduction.left_out)
    unit = "whole parameters" if model.within.keep is Keep.PARAMETERS else "terms"
    of = " of its inverse model, which is solved exactly" if model.solved else ""
    of = " of the inertia matrix and the potential" if model.within.keep is Keep.INERTIA else of
    sentences = [
        f"{model.headline}; {changes} {unit if changes != 1 else unit.removesuffix('s')} left out{of}.",
        "Errors are relative to the full model, rounding included.",
    ]
    if rounding := _of_rounding(model):
        sentences.append(f"Zero but for rounding, so without a relative tolerance: {rounding}.")
    if constant := _constant(model):
        sentences.append(f"Reduced to a constant: {constant}.")
    if changes and model.within.guaranteed is Evidence.CONFIDENT:
        beyond = math.ceil(1e6 * share_beyond(reduction.states, MOST_SEARCHES))
        sentences.append(
            f"With {CONFIDENCE:.0%} confidence at most {beyond} of a million drawn states have larger errors, for any "
            "distribution of errors."
        )
    if not changes and reduction.unproven:
        sentences.append(f"Nothing is omitted: {reduction.unproven}.")
    if reduction.shift is not None and model.within.frequencies:
        allowed = model.within.frequencies
        most = allowed.value * reduction.shift
        shift = f"{100 * most:.2g} %" if allowed.relative else f"{most:.2g} Hz"
        share = 1 - share_beyond(POSITIONS, MOST_SEARCHES)
        sentences.append(
            f"Natural frequencies shift by at most {shift} at {POSITIONS} drawn positions; with {CONFIDENCE:.0%} "
            f"confidence at {share:.1%} of all, and by the tail of the shifts at as many more."
        )
    if reduction.ended:
        sentences.append("The search was ended by hand.")
    if changes and (structure := KEPT.get(model.within.keep)):
        sentences.append(structure)
    if model.lost is not None:
        lost = model.lost
        sentences.append(
            f"At {STATES} drawn states: inertia matrix asymmetric by {lost.asymmetry:.1g} of its largest entry, "
            f"power balance violated by up to {lost.power:.2g} of {lost.largest_power:.2g} W."
        )
    return " ".join(sentences)


def _constant(model: ReducedModel) -> str:
    """Return the names of the entries of results that no longer depend on the state."""
    pairs = zip(model.reduction.program.outputs, model.reduction.reduced.outputs, strict=True)
    entries = [(x, y) for whole, left in pairs for x, y in zip(whole.entries, left.entries, strict=True)]
    named = zip(model.certificates[0].entries, entries, strict=True)
    lost = [f"{bound.name}[{bound.entry}]" for bound, (x, y) in named if is_constant(y) and not is_constant(x)]
    return ", ".join(lost)


def _of_rounding(model: ReducedModel) -> str:
    """Return the names of the entries of results that are zero but for rounding."""
    names = [(output.name, k) for output in model.reduction.program.outputs for k in range(len(output.entries))]
    labelled = dict(zip(names, model.certificates[0].entries, strict=True))
    entries = [labelled[error.output, error.index] for error in model.reduction.errors if error.is_rounding]
    return ", ".join(f"{entry.name}[{entry.entry}]" for entry in entries)


def fixed_totals(models: Sequence[ReducedModel]) -> dict[str, Total]:
    """Remarks on functions in fixed point of which terms are omitted, by name."""
    return {model.model: Total(model.certificates[0], sentences_on(model), model.reduction.program) for model in models}
