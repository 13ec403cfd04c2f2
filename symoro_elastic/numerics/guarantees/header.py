"""What the text of a generated function says of its certificates."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from types import MappingProxyType

from symoro_elastic.codegen.guaranteed import EntryRange, Guaranteed
from symoro_elastic.codegen.package import Function, Package
from symoro_elastic.numerics.guarantees.certificate import Certificate, EntryBound, Guarantee
from symoro_elastic.numerics.guarantees.certificates import Certificates
from symoro_elastic.numerics.guarantees.wording import at_most, divisors, overflow, range_text

NOTHING: Mapping[str, str] = MappingProxyType({})
RESTS_ON = (
    "Proven for IEEE arithmetic rounded to nearest, contracted or not, and for sines and cosines within 1.5 units in "
    "the last place; not with -ffast-math. Outside of the box nothing is claimed."
)


def with_guarantees(package: Package, certificates: Certificates, first: Mapping[str, str] = NOTHING) -> Package:
    """The package whose functions say what is guaranteed of them, after the `first` sentence of a function, if any."""
    functions = [
        replace(
            function,
            guaranteed={
                one.precision: guaranteed(package, function, one, first.get(function.name, ""))
                for one in certificates.of(function.name)
            },
        )
        for function in package.functions
    ]
    return replace(package, functions=tuple(functions))


def guaranteed(
    package: Package, function: Function, one: Certificate, first: str = "", rests_on: str = RESTS_ON
) -> Guaranteed:
    """The box of a function, and what a certificate says of it in sentences, after `first` and before `rests_on`."""
    ranges = one.box.ranges
    entries = [(a.name, k, name) for a in function.program.inputs for k, name in enumerate(a.symbols)]
    entries += [("p", k, parameter.name) for k, parameter in enumerate(package.parameters)]
    limited = [(argument, k, ranges[name]) for argument, k, name in entries if name in ranges]
    return Guaranteed(
        tuple(EntryRange(argument, k, found.low, found.high) for argument, k, found in limited),
        (*filter(None, (first,)), *_sentences(one), rests_on),
    )


def _sentences(one: Certificate) -> Iterator[str]:
    """Box, bounds of each entry, divisors, range of numbers."""
    yield f"Guarantees in box {one.box.digest}, {one.precision} precision, SI units; *_in_box tells what is in it:"
    for name in one.box.open:
        yield f"  {name}: {one.box.ranges[name].low!r} to {one.box.ranges[name].high!r}"
    for entry in one.entries:
        yield f"{entry.name}[{entry.entry}]: {_bounds(entry)}"
    said = f"{divisors(one)}; {overflow(one)}."
    yield said[0].upper() + said[1:]


def _bounds(entry: EntryBound) -> str:
    """Range and error of an entry, with what stands behind each."""
    if entry.guarantee is Guarantee.PROVEN:
        error = f"error at most {at_most(entry.error)}" if entry.error else "exact"
        return f"{range_text(entry)}, {error}, {Guarantee.PROVEN}"
    within = f"{range_text(entry)}, {Guarantee.PROVEN}" if math.isfinite(entry.magnitude) else Guarantee.NONE
    if entry.guarantee is Guarantee.CONFIDENT:
        return f"{within}; error at most {at_most(entry.likely)} {Guarantee.CONFIDENT}"
    return f"{within}; error {Guarantee.NONE}"
