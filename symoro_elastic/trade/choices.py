"""What one choice does by itself: points that differ in nothing else, compared."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from statistics import median
from typing import Any

from symoro_elastic.trade.builds import FAST, LIBM, PLAIN, SEPARATE, Flags
from symoro_elastic.trade.forms import BY_MATRIX
from symoro_elastic.trade.points import BATCH, Figures, Point

Told = Callable[[Point], Any]


@dataclass(frozen=True)
class Choice:
    """A choice and its effect: medians of the ratios of time and of worst error over `pairs` of points."""

    words: str
    time: float
    error: float
    pairs: int


@dataclass(frozen=True)
class _Choice:
    """`chosen` tells whether a point has made the choice (True), its counterpart (False), or has no part in it."""

    words: str
    chosen: Callable[[Point], bool | None]
    rest: Told


def choices(figures: Sequence[Figures]) -> list[Choice]:
    """The effect of every choice for which there are points to compare."""
    found = []
    for choice in _choices(figures):
        ratios = list(_ratios(figures, choice))
        if ratios:
            times, errors = zip(*ratios, strict=True)
            found.append(Choice(choice.words, median(times), median(errors), len(ratios)))
    return found


def _ratios(figures: Sequence[Figures], choice: _Choice) -> Iterator[tuple[float, float]]:
    without = {choice.rest(one.point): one for one in figures if choice.chosen(one.point) is False}
    for one in figures:
        other = without.get(choice.rest(one.point)) if choice.chosen(one.point) else None
        if other and math.isfinite(one.error) and other.error > 0:
            yield one.ns / other.ns, one.error / other.error


def _choices(figures: Sequence[Figures]) -> Iterator[_Choice]:
    yield _Choice("a batch instead of single calls", lambda p: p.call == BATCH, lambda p: p.but(call=""))
    for name in ("single", "mixed", "double-double"):
        yield _Choice(f"{name} instead of double", _one_of(lambda p: p.precision.name, name, "double"), _but_precision)
    yield from _by_form("base parameters", lambda p: p.form.base, lambda p: (p.form.way, p.form.folded, p.form.merged))
    yield from _by_form("constants folded", lambda p: p.form.folded, lambda p: (p.form.way, p.form.base, p.form.merged))
    yield from _by_form(
        "A^-1 instead of the recursion", lambda p: p.form.way == BY_MATRIX, lambda p: (p.form.base, p.form.folded)
    )
    yield from _by_form("angles summed", lambda p: p.form.merged, lambda p: (p.form.way, p.form.base, p.form.folded))
    for words, flag in (("libm's sine and cosine", LIBM), ("products and sums apart (no FMA)", SEPARATE)):
        yield _Choice(words, _has(flag, lambda flags: FAST not in flags), _but_flag(flag))
    yield _Choice("-ffast-math, libm's sine and cosine", _has(FAST, lambda flags: LIBM in flags), _but_flag(FAST))
    yield _Choice("-ffast-math, inline sine and cosine", _has(FAST, lambda flags: LIBM not in flags), _but_flag(FAST))
    yield _Choice("-O2 instead of what the source recommends", _plain(figures), _but_flags)
    names = list(dict.fromkeys(p.build.compiler[0] for p in (f.point for f in figures) if p.build))
    for name in names[1:]:
        compiler = _one_of(lambda p: p.build.compiler[0] if p.build else "", name, names[0])
        yield _Choice(f"{name} instead of {names[0]}", compiler, _but_compiler)


def _by_form(words: str, chosen: Callable[[Point], bool], rest: Told) -> Iterator[_Choice]:
    yield _Choice(words, chosen, lambda p: (p.model, rest(p), p.build, p.precision.name, p.call))


def _one_of(told: Told, yes: str, no: str) -> Callable[[Point], bool | None]:
    return lambda p: {yes: True, no: False}.get(told(p))


def _has(flag: str, where: Callable[[Flags], bool]) -> Callable[[Point], bool | None]:
    return lambda p: flag in p.build.flags if p.build and where(p.build.flags) else None


def _but_flag(flag: str) -> Told:
    """All but a flag; contraction is one choice, whichever flag says it."""
    contraction = ("-ffp-contract=fast", "-ffp-contract=on", SEPARATE)
    dropped = contraction if flag == SEPARATE else (flag,)

    def rest(p: Point) -> Any:
        kept = tuple(f for f in p.build.flags if f not in dropped) if p.build else ()
        return _but_flags(p), kept

    return rest


def _plain(figures: Sequence[Figures]) -> Callable[[Point], bool | None]:
    """Plain optimisation against the flags of the first point, which are those recommended."""
    best = {one.point.build.compiler: one.point.build.flags for one in reversed(figures) if one.point.build}

    def chosen(p: Point) -> bool | None:
        if p.build is None or p.build.flags not in (PLAIN, best[p.build.compiler]):
            return None
        return p.build.flags == PLAIN

    return chosen


def _but_flags(p: Point) -> Any:
    return p.model, p.form, p.build.compiler if p.build else None, p.precision.name, p.call


def _but_precision(p: Point) -> Any:
    return p.model, p.form, p.build and (p.build.compiler, p.build.flags), p.call


def _but_compiler(p: Point) -> Any:
    flags = tuple(f for f in p.build.flags if not f.startswith("-ffp-contract=") or f == SEPARATE) if p.build else ()
    return p.model, p.form, flags, p.precision.name, p.call
