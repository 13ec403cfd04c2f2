"""The command line. Heavy imports wait inside the commands that need them."""

from __future__ import annotations

import sys

import click

from symoro_elastic import __version__
from symoro_elastic.cli.code import check, equations, generate
from symoro_elastic.cli.feed_forward import feed_forward
from symoro_elastic.cli.identification import excite, identify
from symoro_elastic.cli.machine import convert, models, show
from symoro_elastic.cli.trade import trade
from symoro_elastic.cli.vibration import compare, linearize, modes, response
from symoro_elastic.errors import InputError


@click.group(context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100})
@click.version_option(__version__, prog_name="symoro-elastic")
def cli() -> None:
    """Symbolic models of robots and machine tools with elastic joints, as standalone numpy and C code.

    MACHINE is a .toml file or a SYMORO .par file.
    """


for command in (
    generate, check, show, equations, convert, models, excite, identify, linearize, modes, response, compare,
    feed_forward, trade,
):  # fmt: skip
    cli.add_command(command)


def main() -> None:
    """Run the command line; whatever a user can mend ends in one line on stderr and exit code 2."""
    try:
        code = cli.main(args=sys.argv[1:] or ["--help"], standalone_mode=False)
    except InputError as error:
        code = _fail(str(error))
    except click.ClickException as error:
        code = _fail(_usage(error))
    except click.Abort:
        code = 130
    except MemoryError:
        code = _fail("not enough memory for so large a model: ask for one --model, for fewer outputs, or lock joints")
    except BrokenPipeError:
        code = 0
    sys.exit(code if isinstance(code, int) else 0)


def _fail(line: str) -> int:
    click.echo("error: " + " ".join(line.split()), err=True)
    return 2


def _usage(error: click.ClickException) -> str:
    command = getattr(getattr(error, "ctx", None), "command_path", "symoro-elastic")
    return f"{command}: {error.format_message()} See {command} --help"
