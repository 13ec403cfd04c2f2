"""Operations against guaranteed error as a table, as data for JSON, and as sentences."""

from __future__ import annotations

from symoro_elastic.analysis.trade_off.guaranteed import Contribution, GuaranteedCurve, GuaranteedPoint
from symoro_elastic.codegen.package_context import count_json, operations
from symoro_elastic.foundation.results import Field, Part, Table, declare, parts_of
from symoro_elastic.numerics.guarantees.certificate import Guarantee
from symoro_elastic.numerics.guarantees.wording import at_most, confidence

declare(Contribution, Field("error"), Field("word", lambda x: str(x.word)))
declare(
    GuaranteedPoint,
    Field("form"),
    Field("precision"),
    Field("share"),
    Field("left_out"),
    Field("operations", lambda x: count_json(x.operations)),
    Field("rounding"),
    Field("terms"),
    Field("total"),
    Field("unseen"),
    Field("time"),
)
declare(GuaranteedCurve, Field("model"), Field("within"), Field("points"), Field("path"), Field("saved"))


@parts_of.register
def guaranteed_parts(curve: GuaranteedCurve) -> list[Part]:
    """Return a row for each step of the path, and what its end keeps."""
    title = f"{curve.model} within {curve.within}: operations against guaranteed error, of the tolerance"
    heads = ("form", "precision", "terms left out", "operations", "time", "rounding", "", "terms", "", "sum")
    table = Table(heads, title=title)
    first, total = curve.points[0], 0.0
    for one in (curve.points[k] for k in curve.path):
        total = max(total, one.total)
        table.add_row(
            one.form,
            one.precision,
            str(one.left_out),
            operations(one.operations),
            f"{one.time / first.time:.0%}",
            *_contribution(one.rounding),
            *_contribution(one.terms),
            _share(total),
        )
    return [table, advice(curve), *_explained(curve)]


def advice(curve: GuaranteedCurve) -> str:
    """Return one sentence: the end of the path, and its largest error at states that no search has seen."""
    one, less = curve.advised, f"{curve.saved:.0%} less time than the whole model in double precision"
    what = f"{curve.model} within {curve.within}: {one.form}, {one.precision} precision"
    if not one.left_out:
        return f"{what}, nothing left out: {less}"
    terms = f"{one.left_out} terms left out for {one.share:.0%} of the tolerance"
    return f"{what}, {terms}: {less}; at a million unseen states they take {one.unseen:.0%} of it at most"


def _explained(curve: GuaranteedCurve) -> list[str]:
    words = {part.word for k in curve.path for part in (curve.points[k].rounding, curve.points[k].terms)}
    return [confidence("95 %")] if Guarantee.CONFIDENT in words else []


def _contribution(part: Contribution) -> tuple[str, str]:
    short = {Guarantee.PROVEN: "proven", Guarantee.CONFIDENT: "95 %", Guarantee.NONE: ""}
    return _share(part.error), short[part.word] if part.error else ""


def _share(x: float) -> str:
    return at_most(x) if x else "0"
