"""Commands run inside the test's own process."""

from __future__ import annotations

import io
import sys
from contextlib import redirect_stderr, redirect_stdout
from inspect import signature
from pathlib import Path
from typing import Any, NamedTuple

import pytest
from click.testing import CliRunner, Result

from symoro_elastic.cli import cli, main
from symoro_elastic.foundation.errors import InputError

APART: dict[str, Any] = {"mix_stderr": False} if "mix_stderr" in signature(CliRunner).parameters else {}
"""Before click 8.2 a runner mixes what is printed and what is said, unless told."""
EXAMPLES = Path(__file__).parents[1] / "examples"


def run(*arguments: object) -> Result:
    """`symoro-elastic ARGUMENTS`; errors are raised."""
    return CliRunner(**APART).invoke(cli, [str(argument) for argument in arguments], catch_exceptions=False)


def refused(*arguments: object) -> str:
    """The message with which a command refuses its arguments."""
    with pytest.raises(InputError) as error:
        run(*arguments)
    return str(error.value)


class Ended(NamedTuple):
    """How a command ended: exit code, standard output and standard error."""

    code: int
    out: str
    err: str


def ended(*arguments: object) -> Ended:
    """`symoro-elastic ARGUMENTS` by its entry point; exceptions that it lets through are raised."""
    out, err = io.StringIO(), io.StringIO()
    argv, sys.argv = sys.argv, ["symoro-elastic", *map(str, arguments)]
    try:
        with redirect_stdout(out), redirect_stderr(err), pytest.raises(SystemExit) as caught:
            main()
    finally:
        sys.argv = argv
    code = caught.value.code
    assert isinstance(code, int)
    return Ended(code, out.getvalue(), err.getvalue())
