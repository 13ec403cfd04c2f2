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
from symoro_elastic.cli.output import counted, print_json, print_table
from symoro_elastic.cli.parsing import NumberRange, WholeRange, parsed_by
from symoro_elastic.cli.reading import Selection
from symoro_elastic.errors import InputError

if TYPE_CHECKING:
    from symoro_elastic.machine.machine import Machine
    from symoro_elastic.machine.scene import Scene
    from symoro_elastic.trade_off.advice import Advice
    from symoro_elastic.trade_off.trade import Request, Trade


@dataclass(frozen=True)
class Effort:
    """How many builds are tried, at how many states, in how many rounds."""

    level: str | None
    states: int
    extreme: bool
    rounds: int
    seed: int

    def request(self) -> Request:
        """Return the request to `trade`."""
        from symoro_elastic.trade_off.trade import Request

        return Request(self.level or "usual", self.states, self.extreme, self.rounds, self.seed)


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
    95 % confidence: a bound from the tail of the errors measured. Where the scene has a motion and tolerances, a
    line says what the ladder predicts for it.
    """
    from symoro_elastic.trade_off.advice import advice
    from symoro_elastic.trade_off.plots import plot
    from symoro_elastic.trade_off.tables import trade_json

    given, scene = selection.read(machine)
    found = _found(given, scene, effort.request(), machine)
    words = [machine, *selection.as_words()]
    plots.write(partial(plot, found, with_fast_math=verdict.fast_math))
    failed, advised = None, None
    try:
        advised = advice(found, verdict.tolerance, verdict.fast_math)
    except InputError as error:
        failed = error
    quoted = _quoted_ladder(given, selection.scene)
    if as_json:
        print_json(trade_json(found, advised, words, verdict.fast_math) | {"ladder": quoted or None})
    else:
        _print(found, advised, words, verdict)
        if quoted:
            click.echo(f"ladder of {selection.scene}: {quoted}")
    if failed:
        raise failed


def _quoted_ladder(machine: Machine, scene: str | None) -> str:
    """Return a line of the ladder of the motion in a scene file; empty where it has none, or none that can be made."""
    from symoro_elastic.cli.ladder import quoted_ladder

    try:
        return quoted_ladder(machine, scene) if scene else ""
    except InputError as error:
        click.echo(f"note: no ladder: {error}", err=True)
        return ""


def _found(machine: Machine, scene: Scene, request: Request, source: str) -> Trade:
    from symoro_elastic.codegen.compile import CompilationFailed
    from symoro_elastic.numerics.values import NoValues
    from symoro_elastic.trade_off.trade import trade

    with ExitStack() as shown:

        def progress(step: str) -> Callable[[int, int], None]:
            shown.close()
            return shown.enter_context(counted(step))

        try:
            return trade(machine, scene, request, progress)
        except (CompilationFailed, NoValues) as error:
            raise InputError(source, "trade", str(error)) from None


def _print(found: Trade, advised: Advice | None, words: Sequence[str], verdict: Verdict) -> None:
    from symoro_elastic.trade_off.advice import commands, sentence
    from symoro_elastic.trade_off.tables import drifts_table

    _print_points(found, verdict)
    if found.drifts:
        steps = f"{found.drifts[0].steps} steps of {found.drifts[0].step:.1e} s"
        print_table(drifts_table(found.drifts), f"free motion without losses, {steps}")
    for note in found.notes:
        click.echo(f"note: {note}", err=True)
    if advised:
        click.echo(sentence(advised))
        click.echo("\n".join(f"  {line}" for line in commands(advised.fastest, words)))


def _print_points(found: Trade, verdict: Verdict) -> None:
    from symoro_elastic.trade_off.factors import effects
    from symoro_elastic.trade_off.front import front
    from symoro_elastic.trade_off.tables import effects_table, measurements_table

    kind = "extreme" if found.request.extreme else "moderate"
    of = "every point" if verdict.points else "none is faster and as accurate"
    for model, figures in found.measurements.items():
        best = front(figures, verdict.fast_math)
        title = f"{found.machine.name}, {model}: {of}, {found.request.states} {kind} states"
        print_table(measurements_table(figures if verdict.points else best, best), title)
        print_table(effects_table(effects(figures)), f"{model}: what a choice does by itself")
