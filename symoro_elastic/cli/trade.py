"""The command trade: speed against accuracy of every build."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

import click

from symoro_elastic.cli.options import (
    BASE,
    FOLD,
    JSON,
    MACHINE,
    MERGE_ANGLES,
    MODEL,
    ONLY,
    SCENE,
    Plots,
    draws,
    gather,
    writes,
)
from symoro_elastic.cli.output import counted, print_json, print_parts
from symoro_elastic.cli.parsing import NumberRange, WholeRange, parsed_by
from symoro_elastic.cli.reading import Selection
from symoro_elastic.errors import InputError

if TYPE_CHECKING:
    from symoro_elastic.machine.machine import Machine
    from symoro_elastic.machine.scene import Scene
    from symoro_elastic.trade_off.advice import Advice
    from symoro_elastic.trade_off.trade import Trade


@dataclass(frozen=True)
class Effort:
    """How many builds are tried, at how many states, in how many rounds."""

    level: str | None
    states: int
    extreme: bool
    rounds: int
    seed: int


@dataclass(frozen=True)
class Verdict:
    """The error that is accepted, and what may be recommended and printed."""

    tolerance: float
    fast_math: bool
    points: bool


def finite_tolerance(tolerance: float, option: str) -> float:
    """A tolerance that is a number."""
    if not tolerance < float("inf"):
        raise InputError("symoro-elastic", option, f"{tolerance} is no relative error: give a number such as 1e-6")
    return tolerance


@click.command()
@MACHINE
@gather("selection", Selection)
@gather("effort", Effort)
@gather("verdict", Verdict)
@MODEL
@FOLD
@BASE
@ONLY
@SCENE
@MERGE_ANGLES
@click.option(
    "--tolerance",
    default=1e-12,
    show_default=True,
    metavar="X",
    type=NumberRange(0, min_open=True),
    callback=parsed_by(finite_tolerance),
    help="Relative error that is accepted.",
)
@click.option("--quick", "level", flag_value="quick", help="Try one compiler with its best flags.")
@click.option("--all", "level", flag_value="all", help="Try every combination, however long it takes.")
@click.option("--extreme", is_flag=True, help="Measure at extreme states instead of moderate ones.")
@click.option(
    "--states",
    default=20_000,
    show_default=True,
    type=WholeRange(1, 1_000_000),
    help="States to measure errors at; more make the bound at other states tighter.",
)
@click.option("--rounds", default=15, show_default=True, type=WholeRange(1, 10_000), help="Rounds of timing.")
@click.option("--seed", default=0, show_default=True, type=WholeRange(0), help="Seed of the random states.")
@click.option("--fast-math", is_flag=True, help="Allow -ffast-math in the advice: NaN and order of sums are not kept.")
@click.option("--points", is_flag=True, help="Print every build, not the Pareto front only.")
@draws
@writes
@JSON
def trade(
    machine: str,
    selection: Selection,
    effort: Effort,
    verdict: Verdict,
    plots: Plots,
    as_json: bool,
) -> None:
    """Measure speed and accuracy, recommend the fastest build.

    Precisions, compilers and flags, batches, base parameters, constants: each point on this computer. An error is
    relative to the largest entry of a result, in units u of half an ulp of 1 in the precision at hand; inputs are in
    double, rounding them counts. What is recommended keeps the tolerance at 100 000 states that were not tried, with
    95 % confidence: a bound from the tail of the errors measured.
    """
    from symoro_elastic.trade_off.plots import plot
    from symoro_elastic.trade_off.tables import trade_json

    given, scene = selection.read(machine)
    found = _found(given, scene, effort)
    words = [machine, *selection.as_words()]
    plots.write(partial(plot, found, with_fast_math=verdict.fast_math))
    failed, advised = None, None
    try:
        advised = found.advice(verdict.tolerance, fast_math=verdict.fast_math)
    except InputError as error:
        failed = error
    if as_json:
        print_json(trade_json(found, advised, words, verdict.fast_math))
    else:
        _print(found, advised, words, verdict)
    if failed:
        raise failed


def _found(machine: Machine, scene: Scene, effort: Effort) -> Trade:
    from symoro_elastic.api import models as api

    with ExitStack() as shown:

        def progress(step: str) -> Callable[[int, int], None]:
            shown.close()
            return shown.enter_context(counted(step))

        return api.trade(
            machine, scene=scene, effort=effort.level or "usual", states=effort.states, extreme=effort.extreme,
            rounds=effort.rounds, seed=effort.seed, watched=progress,
        )  # fmt: skip


def _print(found: Trade, advised: Advice | None, words: Sequence[str], verdict: Verdict) -> None:
    from symoro_elastic.trade_off.advice import commands, sentence
    from symoro_elastic.trade_off.tables import trade_parts

    print_parts(trade_parts(found, verdict.fast_math, verdict.points))
    for note in found.notes:
        click.echo(f"note: {note}", err=True)
    if advised:
        click.echo(sentence(advised))
        click.echo("\n".join(f"  {line}" for line in commands(advised.fastest, words)))
