"""Sentences on certificates in the text of generated functions."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from decimal import ROUND_CEILING, ROUND_FLOOR, Context, Decimal
from types import MappingProxyType

from symoro_elastic.codegen.guaranteed import EntryRange, Guaranteed
from symoro_elastic.codegen.package import Function, Package
from symoro_elastic.machine.within import Evidence
from symoro_elastic.numerics.guarantees.box import DRAWN_AS
from symoro_elastic.numerics.guarantees.certificate import WITH_CONFIDENCE, Certificate, EntryBound
from symoro_elastic.numerics.guarantees.certificates import Certificates

NOTHING: Mapping[str, str] = MappingProxyType({})
RESTS_ON = (
    "Proven for IEEE arithmetic rounded to nearest, contracted or not, and for sines and cosines within 1.5 units in "
    "the last place; not with -ffast-math. Outside of the box nothing is claimed."
)


def with_guarantees(package: Package, certificates: Certificates, first: Mapping[str, str] = NOTHING) -> Package:
    """The package with guarantees in its functions, after the `first` sentence by function, if any."""
    functions = [
        replace(
            function,
            guaranteed={
                certificate.precision: guarantees_of(package, function, certificate, first.get(function.name, ""))
                for certificate in certificates.of(function.name)
            },
        )
        for function in package.functions
    ]
    return replace(package, functions=tuple(functions))


def guarantees_of(
    package: Package, function: Function, certificate: Certificate, first: str = "", rests_on: str = RESTS_ON
) -> Guaranteed:
    """The box of a function and the sentences of its certificate, between `first` and `rests_on`."""
    ranges = certificate.box.ranges
    entries = [(a.name, k, name) for a in function.program.inputs for k, name in enumerate(a.symbols)]
    entries += [("p", k, parameter.name) for k, parameter in enumerate(package.parameters)]
    limited = [(argument, k, ranges[name]) for argument, k, name in entries if name in ranges]
    return Guaranteed(
        tuple(EntryRange(argument, k, span.low, span.high) for argument, k, span in limited),
        (*filter(None, (first,)), *_sentences(certificate), rests_on),
    )


def _sentences(certificate: Certificate) -> Iterator[str]:
    """Lines on the box, bounds of entries, divisors and range of numbers."""
    box, precision = certificate.box, certificate.precision
    yield f"Guarantees in box {box.digest}, {precision} precision, SI units; *_in_box tells what is in it:"
    for name in box.open:
        yield f"  {name}: {box.ranges[name].low!r} to {box.ranges[name].high!r}"
    for entry in certificate.entries:
        yield f"{entry.name}[{entry.entry}]: {_bounds(entry)}"
    sentence = f"{divisors(certificate)}; {overflow(certificate)}."
    yield sentence[0].upper() + sentence[1:]


def _bounds(entry: EntryBound) -> str:
    """Range and error of an entry, with the evidence for both."""
    if entry.guarantee is Evidence.PROVEN:
        error = f"error at most {at_most(entry.error)}" if entry.error else "exact"
        return f"{range_text(entry)}, {error}, {Evidence.PROVEN}"
    within = f"{range_text(entry)}, {Evidence.PROVEN}" if math.isfinite(entry.magnitude) else Evidence.NONE
    if entry.guarantee is Evidence.CONFIDENT:
        return f"{within}; error at most {at_most(entry.likely)} {WITH_CONFIDENCE}"
    return f"{within}; error {Evidence.NONE}"


def at_most(x: float, digits: int = 2) -> str:
    """An upper bound as text, rounded upwards."""
    return _round(x, digits, ROUND_CEILING)


def at_least(x: float, digits: int = 2) -> str:
    """A lower bound as text, rounded downwards."""
    return _round(x, digits, ROUND_FLOOR)


def _round(x: float, digits: int, way: str) -> str:
    if not math.isfinite(x):
        return Evidence.NONE
    return format(float(Context(prec=digits, rounding=way).create_decimal(Decimal(x))), f".{digits}g")


def range_text(entry: EntryBound) -> str:
    """The range of an entry as text, its ends rounded outwards."""
    if not math.isfinite(entry.magnitude):
        return Evidence.NONE
    return f"{at_least(entry.low, 4)} to {at_most(entry.high, 4)}"


def error_text(error: float) -> str:
    """The bound of an error as text."""
    return at_most(error) if error else "exact"


def confidence(word: str) -> str:
    """Return a sentence that defines a word for confident bounds."""
    return f"{word}: {WITH_CONFIDENCE}, {DRAWN_AS}"


def divisors(certificate: Certificate) -> str:
    """Return a sentence on the least divisor of a model, and on whether it may be zero."""
    least = min(certificate.pivots, key=lambda pivot: pivot.least, default=None)
    if least is None:
        return "it divides by nothing that moves"
    if not least.least > 0:
        return f"not bounded: {least.name} may be zero in the box"
    return f"no divisor is zero: the least is {least.name}, at least {at_least(least.least, 3)}"


def overflow(certificate: Certificate) -> str:
    """Return a sentence on whether values stay within the range of the precision."""
    overflows = certificate.overflows
    return "a value may be out of the range of numbers" if overflows else "nothing overflows and nothing is NaN"
