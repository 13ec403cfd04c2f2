"""Singularities as a table and sentences."""

from __future__ import annotations

from symoro_elastic.analysis.singularities.singularities import Singularities, SingularPosition
from symoro_elastic.foundation.results import Field, Part, declare, parts_of

declare(
    SingularPosition,
    Field("factor", head="factor"),
    Field("latex"),
    Field("condition", head="vanishes where"),
    *map(Field, ("alike", "lost", "sentence")),
)
declare(Singularities, *map(Field, ("machine", "components", "joints", "determinant", "latex", "positions")))


@parts_of.register
def _(result: Singularities) -> list[Part]:
    return [result.headline, f"det J = {result.determinant}", *(position.sentence for position in result.positions)]
