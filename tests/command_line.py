"""Commands run inside the test's own process."""

from __future__ import annotations

from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from symoro_elastic.cli import cli
from symoro_elastic.errors import InputError

EXAMPLES = Path(__file__).parents[1] / "examples"


def run(*arguments: object) -> Result:
    """`symoro-elastic ARGUMENTS`; errors are raised."""
    return CliRunner().invoke(cli, [str(argument) for argument in arguments], catch_exceptions=False)


def refused(*arguments: object) -> str:
    """The message with which a command refuses its arguments."""
    with pytest.raises(InputError) as error:
        run(*arguments)
    return str(error.value)
