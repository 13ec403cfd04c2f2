"""One sentence: the fastest way within a tolerance, and the commands that make it."""

from __future__ import annotations

import shlex
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from symoro_elastic.errors import InputError
from symoro_elastic.trade.front import fastest_within, most_accurate
from symoro_elastic.trade.points import BATCH, SINGLE_CALL, Figures, Point
from symoro_elastic.trade.trade import Trade

STANDARD = "-std=c99"


@dataclass(frozen=True)
class Advice:
    """The fastest points within a tolerance, one for each model, all of one build; those of one state a call.

    `one_state` is empty where the fastest are such calls, or where none of these is within the tolerance.
    """

    tolerance: float
    fastest: tuple[Figures, ...]
    one_state: tuple[Figures, ...]


def advice(found: Trade, tolerance: float, with_fast_math: bool = False) -> Advice:
    """The build that is fastest for all models together. Raises `InputError` that names the nearest where none is."""
    source = found.machine.label
    for model, figures in found.figures.items():
        if fastest_within(figures, tolerance, with_fast_math) is None:
            nearest = most_accurate(figures, with_fast_math)
            what = f"none of the ways tried to compute {model} has errors within {tolerance:.1e}: "
            what += f"nearest is {nearest.error:.1e}, with "
            raise InputError(source, "--tolerance", what + nearest.point.words)
    every = [one for figures in found.figures.values() for one in figures]
    models = list(found.figures)
    fastest = _of_one_build(every, models, tolerance, with_fast_math)
    if not fastest:
        what = f"no build is within {tolerance:.1e} for all of {', '.join(models)}: ask for one --model at a time"
        raise InputError(source, "--tolerance", what)
    single = [one for one in every if one.point.call == SINGLE_CALL]
    batch = fastest[0].point.call == BATCH
    return Advice(tolerance, fastest, _of_one_build(single, models, tolerance, with_fast_math) if batch else ())


def _of_one_build(
    figures: Iterable[Figures], models: Sequence[str], tolerance: float, with_fast_math: bool
) -> tuple[Figures, ...]:
    """The fastest points, one a model, that one package and one library can hold; none where no build has all."""
    groups: dict[Any, list[Figures]] = {}
    for one in figures:
        point = one.point
        key = (point.form.base, point.form.folded, point.form.merged, point.build, point.precision.name, point.call)
        groups.setdefault(key, []).append(one)
    complete = []
    for group in groups.values():
        best = [
            fastest_within([one for one in group if one.point.model == model], tolerance, with_fast_math)
            for model in models
        ]
        if all(best):
            complete.append(tuple(one for one in best if one))
    return min(complete, key=lambda some: sum(one.ns for one in some), default=())


def sentence(advised: Advice) -> str:
    """The advice as one sentence."""
    said = f"Within a relative error of {advised.tolerance:.1e} the fastest is {_said(advised.fastest)}"
    return said + (f"; for one state a call, {_said(advised.one_state)}." if advised.one_state else ".")


def _said(figures: Sequence[Figures]) -> str:
    point = figures[0].point
    options = ["base parameters"] * point.form.base + ["folded constants"] * point.form.folded
    options += ["angles summed"] * point.form.merged
    models = " and ".join(
        f"{one.point.model} by {one.point.form.way} in {one.ns:.3g} ns a state (worst error {one.error:.1e})"
        for one in figures
    )
    how = ", ".join([point.precision.name, point.made_by, point.call, *options])
    return f"{how}: {models}"


def commands(figures: Sequence[Figures], words: Sequence[str]) -> list[str]:
    """The command lines that generate and compile points of one build; `words` say machine and what is asked of it."""
    point = figures[0].point
    form, name = point.form, point.form.package.name
    asked = [*words, *(word for one in figures for word in ("--model", _written(one.point)))]
    asked += ["--base"] if form.base and "--base" not in words else []
    asked += ["--fold", "all"] if form.folded and "all" not in words else []
    asked += ["--merge-angles", f"{form.bound:g}"] if form.merged else []
    asked += ["--target", "c" if point.build else "numpy"]
    asked += ["--precision", point.precision.name] if point.build and point.precision.suffix else []
    generate = shlex.join(["symoro-elastic", "generate", *asked])
    if point.build is None:
        return [generate]
    stem = f"{name}{point.precision.suffix}"
    flags = [*point.build.compiler, STANDARD, *point.build.flags]
    return [generate, shlex.join([*flags, "-c", f"generated/{name}/{stem}.c", "-o", f"{stem}.o"])]


def _written(point: Point) -> str:
    return point.form.traced[point.model].model.name
