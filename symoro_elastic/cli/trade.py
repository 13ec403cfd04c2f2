"""The command that weighs speed against accuracy: trade."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import ExitStack
from typing import TYPE_CHECKING

import click

from symoro_elastic.cli.options import BASE, FOLD, JSON, MACHINE, MERGE_ANGLES, MODEL, ONLY, SCENE
from symoro_elastic.cli.output import counted, print_json, print_table
from symoro_elastic.cli.reading import read, scene_of, with_merged_angles
from symoro_elastic.errors import InputError

if TYPE_CHECKING:
    from symoro_elastic.machine.machine import Machine
    from symoro_elastic.machine.scene import Scene
    from symoro_elastic.trade.advice import Advice
    from symoro_elastic.trade.trade import Request, Trade


@click.command()
@MACHINE
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
    type=click.FloatRange(0, min_open=True),
    help="Relative error that is good enough.",
)
@click.option("--quick", "effort", flag_value="quick", help="One compiler, its best flags.")
@click.option("--all", "effort", flag_value="all", help="Every combination, however long it takes.")
@click.option("--extreme", is_flag=True, help="At extreme states instead of moderate ones.")
@click.option("--states", default=400, show_default=True, type=click.IntRange(1, 1_000_000), help="To measure errors.")
@click.option("--rounds", default=15, show_default=True, type=click.IntRange(1, 10_000), help="Of timing.")
@click.option("--seed", default=0, show_default=True, type=click.IntRange(0), help="Chooses the random states.")
@click.option("--fast-math", is_flag=True, help="Let -ffast-math be advised: NaN and order of sums are not kept.")
@click.option("--points", is_flag=True, help="Print every point, not the front only.")
@click.option("--plots", metavar="FOLDER", type=click.Path(), help="Draw time against error there.")
@JSON
def trade(
    machine: str,
    models: tuple[str, ...],
    fold: tuple[str, ...],
    base: bool,
    only: tuple[str, ...],
    scene: str | None,
    merge_angles: float | None,
    tolerance: float,
    effort: str | None,
    extreme: bool,
    states: int,
    rounds: int,
    seed: int,
    fast_math: bool,
    points: bool,
    plots: str | None,
    as_json: bool,
) -> None:
    """Time every way to compute the models of MACHINE, measure its errors, and advise the fastest good enough.

    Precisions, compilers and flags, batches, base parameters, constants: each point on this computer. An error is
    relative to the largest entry of a result, in units u of half an ulp of 1 in the precision at hand.
    """
    from symoro_elastic.trade.advice import advice
    from symoro_elastic.trade.plots import plot
    from symoro_elastic.trade.tables import trade_json
    from symoro_elastic.trade.trade import Request

    if not tolerance < float("inf"):
        raise InputError(
            "symoro-elastic", "--tolerance", f"{tolerance} is no relative error: give a number such as 1e-6"
        )
    found_machine = read(machine, base)
    asked = with_merged_angles(scene_of(found_machine, scene, models, fold, only), merge_angles)
    found = _found(found_machine, asked, Request(effort or "usual", states, extreme, rounds, seed), machine)
    words = [machine, *_words(fold, base, only, scene)]
    if plots:
        written = plot(found, plots, with_fast_math=fast_math)
        click.echo(f"wrote {plots}: {', '.join(path.name for path in written)}", err=True)
    failed, advised = None, None
    try:
        advised = advice(found, tolerance, fast_math)
    except InputError as error:
        failed = error
    if as_json:
        print_json(trade_json(found, advised, words, fast_math))
    else:
        _print(found, advised, words, points, fast_math)
    if failed:
        raise failed


def _found(machine: Machine, asked: Scene, request: Request, source: str) -> Trade:
    from symoro_elastic.codegen.compile import CompilationFailed
    from symoro_elastic.numerics.values import NoValues
    from symoro_elastic.trade.trade import trade

    with ExitStack() as shown:

        def watched(step: str) -> Callable[[int, int], None]:
            shown.close()
            return shown.enter_context(counted(step))

        try:
            return trade(machine, asked, request, watched)
        except (CompilationFailed, NoValues) as error:
            raise InputError(source, "trade", str(error)) from None


def _words(fold: Sequence[str], base: bool, only: Sequence[str], scene: str | None) -> list[str]:
    """What was asked for, as `generate` takes it."""
    words = [word for name in fold for word in ("--fold", name)] + ["--base"] * base
    words += [word for name in only for word in ("--only", name)]
    return [*words, *(["--scene", scene] if scene else [])]


def _print(found: Trade, advised: Advice | None, words: Sequence[str], points: bool, fast_math: bool) -> None:
    from symoro_elastic.trade.advice import commands, sentence
    from symoro_elastic.trade.factors import effects
    from symoro_elastic.trade.front import front
    from symoro_elastic.trade.tables import drifts_table, effects_table, measurements_table

    kind = "extreme" if found.request.extreme else "moderate"
    for model, figures in found.measurements.items():
        best = front(figures, fast_math)
        title = f"{found.machine.name}, {model}: " + ("every point" if points else "none is faster and as accurate")
        print_table(
            measurements_table(figures if points else best, best), f"{title}, {found.request.states} {kind} states"
        )
        print_table(effects_table(effects(figures)), f"{model}: what a choice does by itself")
    if found.drifts:
        steps = f"{found.drifts[0].steps} steps of {found.drifts[0].step:.1e} s"
        print_table(drifts_table(found.drifts), f"free motion without losses, {steps}")
    for note in found.notes:
        click.echo(f"note: {note}", err=True)
    if advised:
        click.echo(sentence(advised))
        click.echo("\n".join(f"  {line}" for line in commands(advised.fastest, words)))
