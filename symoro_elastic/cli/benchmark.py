"""The command benchmark: speed against accuracy of every build."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import ExitStack
from functools import partial
from typing import TYPE_CHECKING

from symoro_elastic.api import kinds
from symoro_elastic.api.declaration import Options, option, switch
from symoro_elastic.api.options import Reading, Trading
from symoro_elastic.cli.listed import command
from symoro_elastic.cli.options import JSON, MACHINE, Plots, call, draws, takes, writes
from symoro_elastic.cli.output import echo, print_json, print_parts, progress_bar
from symoro_elastic.cli.reading import note, read_for
from symoro_elastic.foundation.errors import InputError

if TYPE_CHECKING:
    from symoro_elastic.analysis.trade_off.advice import Advice
    from symoro_elastic.analysis.trade_off.trade import Trade
    from symoro_elastic.foundation.pictures import Figures
    from symoro_elastic.machine.machine import Machine


class Advising(Options):
    """Options of the recommended build: accepted error, -ffast-math, and whether every build is printed."""

    tolerance: float = option(1e-12, "X", "Relative error that is accepted.", kinds.NUMBER, above=0)
    fast_math: bool = switch("Allow -ffast-math in the advice: NaN and order of sums are not kept.")
    points: bool = switch("Print every build, not the Pareto front only.")

    def __post_init__(self) -> None:
        if not self.tolerance < float("inf"):
            what = f"{self.tolerance} is not a relative error: give a number such as 1e-6"
            raise InputError("symoro-elastic", "--tolerance", what)


@command("benchmark")
@MACHINE
@takes(Trading)
@takes(Reading, "reading", "base")
@takes(Advising, "advising")
@draws
@writes
@JSON
def benchmark(
    machine: str, options: Trading, reading: Reading, advising: Advising, plots: Plots, as_json: bool
) -> None:
    """Compare precisions, compilers and flags, batches, base parameters, constants: each point on this computer.

    An error is relative to the largest entry of a result, in units u of half an ulp of 1 in the precision at hand;
    inputs are in double, their rounding is included. The recommended build is within the tolerance at 100 000 further
    states, with 95 % confidence: a bound from the tail of the errors measured. With --within form, precision and terms
    are steps on one path of operations against guaranteed error.
    """
    from symoro_elastic.analysis.trade_off.views import trade_json

    full_machine = read_for(options, machine, reading)
    measured = _measure(full_machine, options)
    words = [machine, *_as_words(options, reading.base)]
    plots.write(partial(_figures, measured, advising.fast_math))
    failed, advised = None, None
    try:
        advised = measured.advice(advising.tolerance, fast_math=advising.fast_math)
    except InputError as error:
        failed = error
    if as_json:
        print_json(trade_json(measured, advised, words, advising.fast_math))
    else:
        _print(measured, advised, words, advising)
    if failed:
        raise failed


def _figures(measured: Trade, with_fast_math: bool) -> Figures:
    from symoro_elastic.analysis.trade_off.plots import pictures
    from symoro_elastic.foundation.pictures import Figures

    return Figures(pictures(measured, with_fast_math))


def _as_words(options: Trading, base: bool) -> list[str]:
    """Return the options of a `generate` command line, without models and merged angles."""
    words = [word for name in options.fold for word in ("--fold", name)] + ["--base"] * base
    outputs = [(model, name) for model, names in (options.only or {}).items() for name in names]
    words += [word for model, name in outputs for word in ("--only", _request(model, name))]
    return [*words, *(["--scene", str(options.scene)] if options.scene else [])]


def _request(model: str, name: str) -> str:
    return f"{model} {name}" if name.startswith("by ") else f"{model}={name}"


def _measure(machine: Machine, options: Trading) -> Trade:
    from symoro_elastic.api import models as api

    with ExitStack() as bars:

        def progress(step: str) -> Callable[[int, int], None]:
            bars.close()
            return bars.enter_context(progress_bar(step))

        return call(api.benchmark, machine, options, watched=progress)


def _print(measured: Trade, advised: Advice | None, words: Sequence[str], advising: Advising) -> None:
    from symoro_elastic.analysis.trade_off.advice import commands, sentence
    from symoro_elastic.analysis.trade_off.views import trade_parts

    print_parts(trade_parts(measured, advising.fast_math, advising.points))
    for line in measured.notes:
        note(line)
    if advised:
        echo(sentence(advised))
        echo("\n".join(f"  {line}" for line in commands(advised.fastest, words)))
