"""The command sweep: figures of a machine over grids and samples of its parameters and positions."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from symoro_elastic.cli import completion
from symoro_elastic.cli.options import JSON, MACHINE, Command, InputFile, OutputFile, Plots, draws, gather, writes
from symoro_elastic.cli.output import counted_ahead, print_result
from symoro_elastic.cli.parsing import Number, Whole, parsed_by, texts
from symoro_elastic.cli.reading import note, read, scene_of
from symoro_elastic.cli.situation import Situation, takes_situation
from symoro_elastic.cli.vibration import INPUT, OUTPUT

if TYPE_CHECKING:
    from symoro_elastic.api.sweeps import Plan, Subject
    from symoro_elastic.machine.machine import Machine
    from symoro_elastic.sweeps.axes import AxisLike
    from symoro_elastic.sweeps.description import Description
    from symoro_elastic.sweeps.running import Workplace
    from symoro_elastic.sweeps.sweep import Sweep

JOURNAL = ".journal"


@dataclass(frozen=True)
class Points:
    """What is swept, and how points are drawn; what a file says of it stands behind the options."""

    over: Mapping[str, AxisLike]
    samples: int | None
    sampling: str | None
    seed: int | None

    def behind(self, file: Description) -> Points:
        """Return them with what the file says and no option does."""
        return Points(
            {**file.over, **self.over},
            file.samples if self.samples is None else self.samples,
            self.sampling or file.sampling,
            file.seed if self.seed is None else self.seed,
        )


@dataclass(frozen=True)
class Analysis:
    """What is computed at each point."""

    of: str | None
    inputs: Sequence[str]
    outputs: Sequence[str]
    frequencies: Sequence[float]
    damping: float | None
    method: str | None
    step: float | None
    scene: str | None
    figures: Sequence[str]

    def subject(self, file: Description, situation: Situation) -> Subject:
        """Return what is computed, with what the file says and no option does."""
        from symoro_elastic.api.motions import Integration
        from symoro_elastic.api.sweeps import Subject

        point = replace(situation.point, at={**file.at, **situation.positions}, hold=situation.hold or file.hold)
        damping, step = (
            given if given is not None else told
            for given, told in ((self.damping, file.damping), (self.step, file.step))
        )
        return Subject(
            self.of or file.of or "modes",
            point,
            self.inputs or file.inputs,
            self.outputs or file.outputs,
            self.frequencies or file.frequencies,
            damping or 0.0,
            Integration(self.method or file.method, step),
            situation.values,
            self.scene,
        )


@dataclass(frozen=True)
class Workers:
    """Where points are computed."""

    workers: int
    scheduler: str | None

    @property
    def workplace(self) -> Workplace:
        """The workplace."""
        from symoro_elastic.sweeps.running import Workplace

        return Workplace(self.workers, self.scheduler)


POINTS = (
    click.option(
        "--over",
        metavar="NAME=VALUES",
        multiple=True,
        callback=parsed_by(texts),
        help="Parameter, number of the table (ram.stiffness, ram.k) or position (q.motor_x) that is swept over "
        "LOW:HIGH:COUNT[,log] or X1,X2,...; with --samples over LOW:HIGH[,log], normal:MEAN:DEVIATION or "
        "lognormal:MEDIAN:DEVIATION; may be repeated.",
    ),
    click.option("--samples", metavar="N", type=Whole(), help="Draw so many points instead of a grid."),
    click.option(
        "--sampling",
        metavar="NAME",
        help="How points are drawn: latin (a Latin hypercube, default), random or sobol.",
    ),
    click.option("--seed", metavar="N", type=Whole(), help="Number that other points are drawn by (default: 0)."),
)
ANALYSIS = (
    click.option(
        "--of",
        metavar="NAME",
        help="What is computed at each point: modes (default), response, ladder or simulation.",
    ),
    INPUT,
    OUTPUT,
    click.option(
        "--frequency",
        "frequencies",
        metavar="HZ",
        multiple=True,
        type=Number(),
        help="Frequency at which the magnitude of a response is a figure; may be repeated.",
    ),
    click.option("--damping", metavar="RATIO", type=Number(), help="Damping ratio added to every mode of a response."),
    click.option(
        "--method", metavar="NAME", shell_complete=completion.METHODS, help="Method of simulations, as in simulate."
    ),
    click.option("--step", metavar="S", type=Number(), help="Step of simulations, s."),
    click.option(
        "--scene", metavar="FILE", type=InputFile(), help="TOML file with [motion] and [wanted], or of locked joints."
    ),
    click.option(
        "--figure",
        "figures",
        metavar="NAME",
        multiple=True,
        help="Figure that is kept, or a pattern such as 'frequency_*' (default: all); may be repeated.",
    ),
)
WORKERS = (
    click.option(
        "--workers",
        metavar="N",
        type=Whole(),
        default=1,
        show_default=True,
        help="Processes that compute points; 0 is one on each core.",
    ),
    click.option(
        "--scheduler", metavar="ADDRESS", help="Dask scheduler whose workers compute points: tcp://host:8786."
    ),
)


def _takes(
    name: str, record: type[Any], options: Sequence[Callable[[Command], Command]]
) -> Callable[[Command], Command]:
    """Return a decorator that adds options to a command, which takes them as one argument."""

    def decorate(command: Command) -> Command:
        command = gather(name, record)(command)
        for option in reversed(options):
            command = option(command)
        return command

    return decorate


@click.command()
@MACHINE
@click.option("--sweep", "file", metavar="FILE", type=InputFile(), help="TOML file that describes the sweep.")
@_takes("points", Points, POINTS)
@_takes("analysis", Analysis, ANALYSIS)
@takes_situation
@_takes("workers", Workers, WORKERS)
@click.option(
    "--out",
    metavar="FILE",
    type=OutputFile(),
    help="Save all points: .csv, .nc (NetCDF) or .npz. Until the end FILE.journal keeps them: an interrupted sweep "
    "goes on from there.",
)
@draws
@writes
@JSON
def sweep(
    machine: str,
    file: str | None,
    points: Points,
    analysis: Analysis,
    workers: Workers,
    situation: Situation,
    out: str | None,
    plots: Plots,
    as_json: bool,
) -> None:
    """Sweep parameters and positions over grids or samples.

    Gives figures of the modes, frequency responses, ladder or simulation of MACHINE at each point, and what each
    quantity does to them.
    """
    from symoro_elastic.output_files import remove_file
    from symoro_elastic.sweeps.description import Description, read_description
    from symoro_elastic.sweeps.files import refuse_form, save
    from symoro_elastic.sweeps.plots import plot_sweep

    if out:
        refuse_form(out)
    told = read_description(file) if file else Description()
    workplace, subject = workers.workplace, analysis.subject(told, situation)
    planned = _planned(machine, points.behind(told), subject, analysis.scene)
    found = _computed(planned, workplace, analysis.figures or told.figures, out)
    if out:
        save(found, out)
        remove_file(f"{out}{JOURNAL}")
    print_result(found, as_json, **({"written": out} if out else {}))
    if out and not as_json:
        click.echo(f"wrote {out}")
    plots.write(partial(plot_sweep, found))


def _planned(path: str, points: Points, subject: Subject, scene: str | None) -> Plan:
    """Return the sweep of the machine of a file."""
    from symoro_elastic.api.sweeps import plan

    machine: Machine = read(path)
    scene_of(machine, scene)
    return plan(machine, points.over, subject, points.samples, points.sampling, points.seed)


def _computed(planned: Plan, workplace: Workplace, figures: Sequence[str], out: str | None) -> Sweep:
    """Return the figures at all points; where Ctrl-C ends them, say where those are that were computed."""
    try:
        with counted_ahead("sweep") as progress:
            journal = Path(f"{out}{JOURNAL}") if out else None
            return planned.run(workplace, journal, figures, note, progress)
    except KeyboardInterrupt:
        kept = f"{out}{JOURNAL} keeps what was computed: give the command again to go on"
        click.echo(f"note: interrupted, {kept if out else 'nothing was written'}", err=True)
        raise
