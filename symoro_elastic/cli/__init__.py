"""The command line. Heavy imports wait inside the commands that need them."""

from __future__ import annotations

import sys

import click

from symoro_elastic import __version__
from symoro_elastic.cli.code import check, equations, generate
from symoro_elastic.cli.comparison import compare
from symoro_elastic.cli.feed_forward import feed_forward
from symoro_elastic.cli.identification import excite, identify
from symoro_elastic.cli.machine import convert, models, show
from symoro_elastic.cli.sections import SectionedGroup
from symoro_elastic.cli.trade import trade
from symoro_elastic.cli.vibration import linearize, modes, response
from symoro_elastic.errors import InputError


@click.group(cls=SectionedGroup, context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100})
@click.version_option(__version__, prog_name="symoro-elastic")
def cli() -> None:
    """Symbolic models of robots and machine tools with elastic joints, as standalone numpy and C code.

    MACHINE is a .toml file or a SYMORO .par file.
    """


SECTIONS = {
    "Models and code": (show, convert, models, equations, generate),
    "Verification": (check, trade),
    "Vibration": (linearize, modes, response, compare),
    "Control": (feed_forward,),
    "Identification": (excite, identify),
}

for title, commands in SECTIONS.items():
    cli.add_section(title, *commands)


def main() -> None:
    """Run the command line; an error that the user can fix ends in one line on stderr and exit code 2."""
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
