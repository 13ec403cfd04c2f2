"""Models within tolerances as sentences and tables, and as data for JSON."""

from __future__ import annotations

from dataclasses import asdict

from symoro_elastic.foundation.results import Field, Part, declare, parts_of
from symoro_elastic.generation.reduced_models.model import ReducedModel
from symoro_elastic.generation.reduced_models.sentences import sentences_on
from symoro_elastic.numerics.guarantees.certificates import Certificates

declare(
    ReducedModel,
    Field("within", lambda model: {name or "all": str(x) for name, x in model.within.tolerances.items()}),
    Field("operations", lambda model: dict(zip(("whole", "left"), model.operations, strict=True))),
    Field("lost", lambda model: model.lost and asdict(model.lost)),
    Field("solved_exactly", "solved"),
    Field("shift_of_frequencies", "reduction.shift"),
    Field("unproven", "reduction.unproven"),
    Field("ended", "reduction.ended"),
    Field("left_out", lambda model: [change.term for change in model.reduction.left_out]),
    Field("certificates", lambda model: [certificate.as_json() for certificate in model.certificates]),
)


@parts_of.register
def _(model: ReducedModel) -> list[Part]:
    """Return the omitted terms of a model in sentences, and the table of its errors."""
    certificates = Certificates(model.certificates[0].machine, model.certificates) if model.certificates else None
    return [sentences_on(model), *(certificates.parts() if certificates else ())]
