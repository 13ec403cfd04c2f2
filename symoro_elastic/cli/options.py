"""Options that several commands share, and records that commands take them as."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, fields
from functools import wraps
from pathlib import Path
from typing import Any

import click

from symoro_elastic.cli import completion
from symoro_elastic.cli.output import print_written
from symoro_elastic.cli.parsing import NumberRange, bound, numbers, parsed_by
from symoro_elastic.errors import InputError

Command = Callable[..., Any]


class InputFile(click.Path):
    """A file that the command reads, so that it does not write it."""


class OutputFile(click.Path):
    """A file that the command writes."""


class OutputFolder(click.Path):
    """A folder that the command writes files to."""


MACHINE = click.argument("machine", metavar="MACHINE", type=InputFile())
MODEL = click.option(
    *("--model", "models"),
    metavar="NAME",
    multiple=True,
    shell_complete=completion.MODELS,
    help="Model to generate; may be repeated.",
)
FOLD = click.option(
    "--fold",
    metavar="NAME|all",
    multiple=True,
    shell_complete=completion.PARAMETERS,
    help="Parameter to replace by its value; may be repeated.",
)
FREE = click.option(
    "--free",
    metavar="TABLES",
    multiple=True,
    shell_complete=completion.FREED,
    help="Tables whose numbers stay parameters of the code: bodies,springs,motors,friction,wrenches; may be repeated.",
)
ONLY = click.option(
    "--only",
    metavar="MODEL=NAME",
    multiple=True,
    help="Only this joint or frame of a model, as in 'jacobian=tool at (0.1, 0, L2) in base', or these columns of "
    "derivatives, as in 'direct_dynamics_parameter_derivatives by M1, K2'; may be repeated.",
)
BASE = click.option("--base", is_flag=True, help="Group the inertial parameters first.")
SCENE = click.option(
    "--scene", metavar="FILE", type=InputFile(), help="TOML file of models, outputs, constants and locked joints."
)
MERGE_ANGLES = click.option(
    "--merge-angles",
    metavar="BOUND",
    type=NumberRange(0, 1e6, min_open=True),
    callback=parsed_by(bound),
    help="Add angles of parallel axes where that saves operations; valid for |q| up to BOUND, rad.",
)
FORM = click.option(
    "--form",
    default="recursion",
    show_default=True,
    metavar="NAME",
    shell_complete=completion.FORMS,
    help="How direct_dynamics is computed: recursion, inertia (matrix), or auto: the faster one that is as accurate.",
)
AT = click.option(
    "--at",
    "positions",
    metavar="JOINT=X",
    multiple=True,
    callback=parsed_by(numbers),
    help="Position of a motor, rad or m (default 0), or initial guess for another joint; may be repeated.",
)
VALUE = click.option(
    "--value",
    "values",
    metavar="NAME=X",
    multiple=True,
    callback=parsed_by(numbers),
    help="Value of a parameter; may be repeated.",
)
JSON = click.option("--json", "as_json", is_flag=True, help="Print the results as one JSON object.")


FORCE = click.option("--force", is_flag=True, help="Replace existing files.")


def writes(command: Command) -> Command:
    """Add --force to a command, and refuse before its work what may not be written."""

    @FORCE
    @wraps(command)
    def called(force: bool, **options: Any) -> Any:
        from symoro_elastic.output_files import permission, refuse_file, refuse_folder

        with permission([path for _, path in _paths(InputFile)], force):
            for place, path in _paths(OutputFile):
                refuse_file(path, place)
            for place, path in _paths(OutputFolder):
                refuse_folder(path, place)
            return command(**options)

    return called


def _paths(kind: type[click.Path]) -> Iterator[tuple[str, str]]:
    """Name of the option or argument, and path, of all paths of a kind that the command line gives."""
    context = click.get_current_context()
    for parameter in context.command.params:
        given = context.params.get(str(parameter.name))
        if isinstance(parameter.type, kind) and given is not None:
            place = parameter.opts[0] if isinstance(parameter, click.Option) else parameter.make_metavar(context)
            yield from ((place, path) for path in ([given] if isinstance(given, str) else given))


@dataclass(frozen=True)
class Plots:
    """The folder that plots are drawn into, None where none are asked for, and the format of their files."""

    plots: str | None
    picture: str | None

    def __post_init__(self) -> None:
        if self.picture and not self.plots:
            raise InputError("symoro-elastic", "--picture", "there are no plots: name their folder with --plots")

    def write(self, plot: Callable[[str, str], list[Path]]) -> None:
        """Draw by `plot(folder, form)` and name the files, where plots are asked for."""
        if self.plots:
            print_written(self.plots, plot(self.plots, self.picture or "png"))


def _picture(form: str | None, _option: str) -> str | None:
    """A format of pictures, or None."""
    if form is not None:
        from symoro_elastic.pictures import refuse_format

        refuse_format(form)
    return form


PLOTS = click.option("--plots", metavar="FOLDER", type=OutputFolder(), help="Draw plots into this folder.")
PICTURE = click.option(
    "--picture",
    metavar="NAME",
    shell_complete=completion.PICTURES,
    callback=parsed_by(_picture),
    help="Format of the plots: png (default), svg or pdf.",
)


def draws(command: Command) -> Command:
    """Add --plots and --picture to a command, which takes both as `plots`, a `Plots`."""
    return PLOTS(PICTURE(gather("plots", Plots)(command)))


def gather(name: str, record: type[Any]) -> Callable[[Command], Command]:
    """Return a decorator that passes the options named as the fields of a dataclass as one argument."""

    def decorate(command: Command) -> Command:
        @wraps(command)
        def called(**options: Any) -> Any:
            own = {field.name: options.pop(field.name) for field in fields(record) if field.name in options}
            return command(**options, **{name: record(**own)})

        return called

    return decorate
