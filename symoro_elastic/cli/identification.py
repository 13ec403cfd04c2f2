"""Commands for measured machines: excite, identify."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any

import click

from symoro_elastic.cli.options import JSON, MACHINE, VALUE, InputFile, OutputFile, Plots, draws, gather, writes
from symoro_elastic.cli.output import counted, print_json, print_table, steps
from symoro_elastic.cli.parsing import Number, NumberRange, WholeRange, numbers, parsed_by, ranges
from symoro_elastic.cli.reading import of_parameters, read

if TYPE_CHECKING:
    from symoro_elastic.identification.excitation import Excitation, Limits
    from symoro_elastic.identification.identify import Identification
    from symoro_elastic.identification.trajectory import Trajectory
    from symoro_elastic.identification.validation import Fit
    from symoro_elastic.machine.machine import Machine
    from symoro_elastic.progress import Announce
    from symoro_elastic.time_series.measurements import Measurements
    from symoro_elastic.time_series.preparation import Preparation

Ranges = dict[str, tuple[float, float]]


@dataclass(frozen=True)
class MotorLimits:
    """Limits of the motors by name; the name "" stands for all."""

    position: Ranges
    velocity: Ranges
    acceleration: Ranges

    def of(self, machine: Machine) -> Limits:
        """Return the limits of every motor of the machine."""
        from symoro_elastic.identification.trajectory import limits_of

        if not machine.motors:
            raise machine.error("motors", "the machine has none: there is nothing to excite")
        given = {"--position": self.position, "--velocity": self.velocity, "--acceleration": self.acceleration}
        return limits_of(machine, given)


@dataclass(frozen=True)
class FourierSeries:
    """The periodic motion that is optimized, and how it is sampled."""

    frequency: float
    harmonics: int
    periods: int
    rate: float
    evaluations: int
    seed: int

    def refuse_rate(self, motors: int) -> None:
        """Raise `InputError` where the sample rate is too low for the harmonics, or the file too long."""
        from symoro_elastic.identification.trajectory import refuse_rate

        refuse_rate(self.rate, self.frequency, self.harmonics, self.periods, motors)

    def optimized(
        self, machine: Machine, limits: Limits, values: Mapping[str, float], known: Sequence[str]
    ) -> Excitation:
        """Return the exciting motion."""
        from symoro_elastic.identification.excitation import excite

        with counted("search") as progress:
            return excite(
                machine, limits, self.frequency, self.harmonics, values, known, evaluations=self.evaluations,
                seed=self.seed, progress=lambda done, total, _: progress(done, total),
            )  # fmt: skip


@dataclass(frozen=True)
class Given:
    """What is known before: values of named parameters, of columns that are not sought, the bandwidth of the motion."""

    values: dict[str, float]
    known: dict[str, float]
    bandwidth: float | None

    def identified(self, machine: Machine, records: Sequence[Measurements], step: Announce) -> Identification:
        """Return the parameters of a machine from records."""
        from symoro_elastic.identification.identify import identify

        return identify(machine, records, of_parameters(self.values, machine), self.known, self.bandwidth, step=step)

    def saved(
        self, result: Identification, records: Sequence[Measurements], step: Announce
    ) -> tuple[Machine, list[str]]:
        """Return the machine with the estimates, and what of them no machine has."""
        from symoro_elastic.identification.identified import identified, possible
        from symoro_elastic.identification.identify import identify

        def again(fixed: Mapping[str, float]) -> Identification:
            known, Y = {**self.known, **fixed}, result.equations.Y
            return identify(result.machine, records, self.values, known, self.bandwidth, step=step, Y=Y)

        fitted, lines = possible(result, again)
        return identified(fitted, self.values), lines


@dataclass(frozen=True)
class Preparing:
    """How records are made ready."""

    gains: dict[str, float]
    resample: float | None
    first: float | None
    last: float | None

    def of(self, machine: Machine) -> Preparation:
        """Return it for a machine; raises `InputError` for unknown motors and times without room."""
        from symoro_elastic.time_series.preparation import Preparation

        preparation = Preparation(self.first, self.last, self.resample, self.gains)
        preparation.refuse(machine)
        return preparation


def limit(option: str, metavar: str, of: str) -> Callable[..., Any]:
    """Return an option for limits of all motors or of one."""
    text = f"{of} of all motors, or of one (NAME=...), SI units; may be repeated."
    return click.option(
        f"--{option}", metavar=metavar, multiple=True, required=True, callback=parsed_by(ranges), help=text
    )


@click.command()
@MACHINE
@gather("limits", MotorLimits)
@gather("series", FourierSeries)
@click.option("--out", required=True, metavar="FILE", type=OutputFile(), help="Save the trajectory: .csv or .npz.")
@limit("position", "[NAME=]LOW:HIGH", "Range of positions")
@limit("velocity", "[NAME=]MAX", "Largest velocity")
@limit("acceleration", "[NAME=]MAX", "Largest acceleration")
@click.option(
    "--frequency",
    default=0.1,
    show_default=True,
    metavar="HZ",
    type=NumberRange(0, min_open=True),
    help="Fundamental frequency of the motion.",
)
@click.option(
    "--harmonics", default=5, show_default=True, type=WholeRange(1, 50), help="Harmonics of the Fourier series."
)
@click.option(
    "--periods",
    default=3,
    show_default=True,
    type=WholeRange(1, 1000),
    help="Periods of the motion, without start and stop.",
)
@click.option(
    "--rate",
    default=1000.0,
    show_default=True,
    metavar="HZ",
    type=NumberRange(0, min_open=True),
    help="Sample rate.",
)
@click.option(
    "--evaluations",
    default=1500,
    show_default=True,
    type=WholeRange(1, 1_000_000),
    help="Motions that the search evaluates.",
)
@click.option("--seed", default=0, show_default=True, type=WholeRange(0), help="Seed of the first motions.")
@VALUE
@click.option("--known", metavar="LABEL", multiple=True, help="Parameter that is not to be identified.")
@draws
@writes
@JSON
def excite(
    machine: str,
    limits: MotorLimits,
    series: FourierSeries,
    out: str,
    values: dict[str, float],
    known: tuple[str, ...],
    plots: Plots,
    as_json: bool,
) -> None:
    """Design an exciting trajectory for identification.

    A Fourier series within limits whose regressor has a low condition number, started from rest and stopped,
    written as t, q_<motor>, qd_, qdd_. Elastic joints follow their springs; passive ones are assumed to stay at
    zero.
    """
    from symoro_elastic.identification import trajectory
    from symoro_elastic.identification.plots import plot_excitation
    from symoro_elastic.numerics.independent_joints import with_independent_motors
    from symoro_elastic.time_series.writing import refuse_file

    refuse_file(out)
    found = with_independent_motors(read(machine))
    trajectory.refuse_without_motors(found)
    allowed = limits.of(found)
    series.refuse_rate(len(found.motors))
    best = series.optimized(found, allowed, of_parameters(values, found), known)
    sampled = trajectory.trajectory(best.motion, allowed, series.periods, series.rate)
    trajectory.write(sampled, found, out)
    _print_excitation(best, sampled, allowed, found, out, as_json)
    plots.write(partial(plot_excitation, best, sampled, allowed, found))


def _print_excitation(
    best: Excitation, sampled: Trajectory, limits: Limits, machine: Machine, out: str, as_json: bool
) -> None:
    from symoro_elastic.identification import trajectory

    figures = trajectory.figures(best, sampled, limits, machine)
    if as_json:
        print_json({"written": out, **figures})
        return
    print_table(trajectory.table(figures), f"{machine.name}: reached of the limits")
    click.echo("\n".join(trajectory.lines(figures)))
    click.echo(f"wrote {out}")


@click.command()
@MACHINE
@click.argument("data", metavar="DATA...", nargs=-1, required=True, type=InputFile())
@gather("given", Given)
@VALUE
@click.option(
    "--known",
    metavar="LABEL=X",
    multiple=True,
    callback=parsed_by(numbers),
    help="Value of a parameter that is not to be estimated.",
)
@click.option("--bandwidth", type=Number(), metavar="HZ", help="Bandwidth of the motion (default: from its spectrum).")
@gather("preparing", Preparing)
@click.option(
    "--gain",
    "gains",
    metavar="MOTOR=K",
    multiple=True,
    callback=parsed_by(numbers),
    help="Torque of a motor over its column, as for measured currents; may be repeated.",
)
@click.option("--resample", type=Number(), metavar="HZ", help="Sample the records evenly at this frequency.")
@click.option("--from", "first", type=Number(), metavar="S", help="Leave out what is before this time.")
@click.option("--to", "last", type=Number(), metavar="S", help="Leave out what is after this time.")
@click.option("--validate", metavar="FILE", type=InputFile(), help="Predict the torques of this record, too.")
@click.option("--save", metavar="FILE", type=OutputFile(), help="Save the machine with the estimates: .toml or .par.")
@draws
@writes
@JSON
def identify(
    machine: str,
    data: tuple[str, ...],
    given: Given,
    preparing: Preparing,
    validate: str | None,
    save: str | None,
    plots: Plots,
    as_json: bool,
) -> None:
    """Estimate dynamic parameters from measurements.

    DATA are CSV or NPZ files with t, q_<joint>, tau_<motor>.
    """
    from symoro_elastic.identification import report
    from symoro_elastic.identification.plots import plot
    from symoro_elastic.identification.validation import validated
    from symoro_elastic.machine.formats import write_machine
    from symoro_elastic.machine.formats.reading import refuse_unwritable
    from symoro_elastic.numerics.independent_joints import with_independent_motors
    from symoro_elastic.time_series.measurements import read_measurements

    if save:
        refuse_unwritable(save)
    of_file = read(machine)
    found = with_independent_motors(of_file)
    prepare = preparing.of(found)
    with steps() as step:
        step("read")
        records = [read_measurements(path, found, prepare) for path in data]
        other = read_measurements(validate, found, prepare) if validate else None
        result = given.identified(found, records, step)
        checked = validated(result, other) if other else None
        saved, warnings = given.saved(result, records, step) if save else (None, [])
    if save and saved:
        write_machine(replace(saved, loops=of_file.loops), save)
        for warning in warnings:
            click.echo(f"warning: {warning}", err=True)
    if as_json:
        print_json(report.as_json(result, checked) | ({"written": save} if save else {}))
    else:
        _print_identification(result, checked, save)
    plots.write(partial(plot, result))


def _print_identification(result: Identification, checked: Fit | None, save: str | None) -> None:
    from symoro_elastic.identification import report
    from symoro_elastic.identification.validation import lines, own_fit

    click.echo(report.table(result, report.file_values(result) or None, "file"))
    fits = [own_fit(result), *([checked] if checked else [])]
    figures = [line for fit in fits for line in lines(fit, result.machine)]
    click.echo("\n".join([*neutral_positions(result), *figures, *result.notes]))
    if save:
        click.echo(f"wrote {save}")


def neutral_positions(result: Identification) -> list[str]:
    """Return a line for each spring with an identified neutral position."""
    units = {joint.name: joint.unit for joint in result.machine.joints}
    return [
        f"neutral position of {name}: {q0:.5g} {units[name]}, std {std:.2g}"
        for name, (q0, std) in result.neutral.items()
    ]
