"""Options of commands, from the declarations of operations, and the records that commands receive."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from symoro_elastic.api import kinds
from symoro_elastic.api.declaration import Option, Options, option, options
from symoro_elastic.api.quantities import UnitOf
from symoro_elastic.api.rows import WRITABLE
from symoro_elastic.cli.output import print_written, say
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.file_forms import OF_FILES, PAGES, PICTURE_FORMATS, form_of

if TYPE_CHECKING:
    from symoro_elastic.foundation.pictures import Figures
    from symoro_elastic.machine.machine import Machine

Command = Callable[..., Any]
Completion = Callable[[click.Context, click.Parameter, str], list[str]]
R = TypeVar("R")
K = TypeVar("K", bound=click.Path)


class InputFile(click.Path):
    """A file that the command reads and must not write."""


class Output(click.Path):
    """A path that the command writes to."""

    def refuse(self, path: str, place: str) -> None:
        """Raise `InputError` for a path that must not be written, before the command's work."""
        raise NotImplementedError


class OutputFile(Output):
    """A file that the command writes, in the format that its suffix says, one of `forms`."""

    def __init__(self, forms: Sequence[str]) -> None:
        super().__init__()
        self.forms = forms

    def refuse(self, path: str, place: str) -> None:
        """Raise `InputError` for a file that must not be written, or whose format is not supported."""
        from symoro_elastic.foundation.output_files import refuse_file

        refuse_file(path, place)
        form_of(path, self.forms, place)


class OutputMachine(OutputFile):
    """A machine file that the command writes."""

    def __init__(self) -> None:
        super().__init__(WRITABLE)

    def refuse(self, path: str, place: str) -> None:
        """Raise `InputError` for a path that no machine can be written to, such as a read-only format."""
        from symoro_elastic.formats.reading import refuse_unwritable
        from symoro_elastic.foundation.output_files import refuse_file

        refuse_file(path, place)
        refuse_unwritable(path, place)


class OutputFolder(Output):
    """A folder that the command writes files to."""

    def refuse(self, path: str, place: str) -> None:
        """Raise `InputError` for a folder that must not be written."""
        from symoro_elastic.foundation.output_files import refuse_folder

        refuse_folder(path, place)


class OutputPage(OutputFile):
    """A page that the command writes, or the folder in which it has the name of the machine."""

    def __init__(self) -> None:
        super().__init__(PAGES)

    def refuse(self, path: str, place: str) -> None:
        """Raise `InputError` for a page, or for a folder, that must not be written."""
        suffix = Path(path).suffix.lower()
        if suffix in PAGES or (suffix in OF_FILES and not Path(path).is_dir()):
            super().refuse(path, place)
        else:
            OutputFolder().refuse(path, place)


class _AsInFiles(click.ParamType):  # type: ignore[type-arg]
    """A number by the rules of machine files, in its unit or in that of the option."""

    unit: str | UnitOf | None = ""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        if not isinstance(value, str):
            return super().convert(value, param, ctx)
        try:
            if isinstance(self, click.types.IntParamType):
                number = kinds.whole_number(value)
            else:
                number = kinds.number(value, self.unit if isinstance(self.unit, str) else None)
        except ValueError as error:
            place = param.opts[0] if param else self.name
            raise InputError("symoro-elastic", place, f"{value!r} {error}") from None
        return number if isinstance(number, str) else super().convert(number, param, ctx)


class Number(_AsInFiles, click.types.FloatParamType):
    """A number."""


class NumberRange(_AsInFiles, click.FloatRange):
    """A number within a range."""


class Whole(_AsInFiles, click.types.IntParamType):
    """A whole number."""


class WholeRange(_AsInFiles, click.IntRange):
    """A whole number within a range."""


FILES = {kinds.SCENE: InputFile, kinds.INPUT_FILE: InputFile, kinds.OUTPUT_FOLDER: OutputFolder}


def _type(row: Option) -> click.ParamType | None:  # type: ignore[type-arg]
    """Return the type of an option, None for texts."""
    if row.kind in FILES:
        return FILES[row.kind]()
    if row.kind.forms:
        return OutputFile(row.kind.forms)
    low, is_open = (row.least, False) if row.above is None else (row.above, True)
    is_bounded = low is not None or row.most is not None
    if row.kind is kinds.WHOLE:
        return WholeRange(low, row.most, is_open) if is_bounded else Whole()  # type: ignore[arg-type]
    if row.kind in (kinds.NUMBER, kinds.BOUND, kinds.LIST):
        type_ = NumberRange(low, row.most, is_open) if is_bounded else Number()
        type_.unit = row.unit
        return type_
    return None


class DeclaredOption(click.Option):
    """An option of click made from a declared one; names of registries are read when its help is printed."""

    def __init__(self, row: Option) -> None:
        self.row = row
        settings: dict[str, Any] = {"metavar": row.metavar, "multiple": row.kind.many, "required": row.required}
        if row.kind is kinds.FLAG:
            settings = {"is_flag": True}
        elif row.default and not row.kind.many:
            settings |= {"default": row.default, "show_default": True}
        elif row.default == 0:
            settings |= {"default": row.default, "show_default": row.least is not None}
        elif not row.kind.many and not row.required:
            settings |= {"default": row.default}
        if row.bare:
            settings |= {"is_flag": False, "flag_value": row.bare}
        if parse := row.kind.parse:
            settings["callback"] = lambda _context, option, value: parse(value, option.opts[0])
        complete = _completion(row)
        super().__init__((row.flag, row.name), type=_type(row), help=row.meaning, shell_complete=complete, **settings)

    def get_help_record(self, ctx: click.Context) -> tuple[str, str] | None:
        """Return how the option is written, and its help."""
        self.help = self.row.help
        return super().get_help_record(ctx)


def _completion(row: Option) -> Completion | None:
    if row.of_machine:
        return completed_from_machine(row.of_machine)
    return completed_from(row.names) if row.names else None


def completed_from(names: Callable[[], Iterable[str]]) -> Completion:
    """Return a completion with these names."""
    return lambda _context, _option, prefix: [name for name in names() if name.startswith(prefix)]


def completed_from_machine(names: Callable[[Machine], Iterable[str]]) -> Completion:
    """Return a completion with names of the machine on the command line; empty for an unreadable one."""

    def complete(context: click.Context, _option: click.Parameter, prefix: str) -> list[str]:
        from symoro_elastic.formats.reading import read

        for path in (context.params.get("machine"), *context.args):
            try:
                return [name for name in names(read(path or "")) if name.startswith(prefix)]
            except InputError:
                continue
        return []

    return complete


def takes(record: type[Any], name: str = "options", *only: str) -> Callable[[Command], Command]:
    """Return a decorator that adds the options of a record to a command, passed as one argument.

    All of them, or `only` some. What must be given and is not an option is an argument of the command.
    """
    rows = [row for row in options(record) if row.on_command_line and (row.name in only or not only)]
    names = [row.name for row in rows] + [row.name for row in options(record) if row.required]

    def decorate(command: Command) -> Command:
        @wraps(command)
        def wrapper(**arguments: Any) -> Any:
            own = {name: arguments.pop(name) for name in dict.fromkeys(names)}
            return command(**arguments, **{name: record(**own)})

        # As click's own decorators do: the last one that is added stands first.
        parameters = wrapper.__dict__.setdefault("__click_params__", [])
        parameters += [DeclaredOption(row) for row in reversed(rows)]
        return wrapper

    return decorate


def call(function: Callable[..., R], machine: Any, record: Any, **callbacks: Any) -> R:
    """Return the result of an operation for the options of a record, with callbacks for its progress."""
    return function(machine, **{**vars(record), **callbacks})


MACHINE = click.argument("machine", metavar="MACHINE", type=InputFile())
JSON = click.option("--json", "as_json", is_flag=True, help="Print the results as one JSON object.")
FORCE = click.option("--force", is_flag=True, help="Replace existing files.")


def writes(command: Command) -> Command:
    """Add --force to a command, and refuse paths that must not be written before its work."""

    @FORCE
    @wraps(command)
    def wrapper(force: bool, **arguments: Any) -> Any:
        from symoro_elastic.foundation.output_files import permission

        with permission([path for _, path, _ in _paths(InputFile)], force):
            for place, path, kind in _paths(Output):
                kind.refuse(path, place)
            return command(**arguments)

    return wrapper


def _paths(kind: type[K]) -> Iterator[tuple[str, str, K]]:
    """Name of the option or argument, path, and type, of all paths of a kind on the command line."""
    context = click.get_current_context()
    for parameter in context.command.params:
        value = context.params.get(str(parameter.name))
        if isinstance(parameter.type, kind) and value is not None:
            place = (
                parameter.opts[0] if isinstance(parameter, click.Option) else parameter.human_readable_name.strip("[]")
            )
            yield from ((place, path, parameter.type) for path in ([value] if isinstance(value, str) else value))


class Plots(Options):
    """The folder of plots, None without plots, and the format of their files."""

    plots: str | None = option(None, "FOLDER", "Draw plots into this folder.", kinds.OUTPUT_FOLDER)
    plot_format: str | None = option(
        None, "NAME", "Format of the plots: {names} (default: png).", names=lambda: PICTURE_FORMATS, gone=("--picture",)
    )

    def __post_init__(self) -> None:
        if self.plot_format:
            from symoro_elastic.foundation.pictures import refuse_format

            refuse_format(self.plot_format)
            if not self.plots:
                what = "plots need a folder: name it with --plots"
                raise InputError("symoro-elastic", "--plot-format", what)

    def write(self, draw: Callable[[], Figures]) -> None:
        """Draw the figures, save them and print the names of the files, if plots are requested."""
        if self.plots:
            figures = draw()
            print_written(self.plots, figures.save(self.plots, self.plot_format or "png"))
            for name, reason in figures.left_out.items():
                say(f"note: {name} is not drawn: {reason}")


draws = takes(Plots, "plots")
"""Add --plots and --plot-format to a command, which receives both as `plots`."""
