"""The command line. Heavy imports wait inside the commands that need them."""

from __future__ import annotations

import errno
import gc
import os
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager

import click

from symoro_elastic.cli.sectioned_group import Failure, SectionedGroup
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.version import __version__
from symoro_elastic.machine.format_names import suffixes

HELP = f"""Symbolic models of robots and machine tools with elastic joints, as standalone code: numpy, C and others.

MACHINE is a file of a machine ({", ".join(suffixes())}); `symoro-elastic formats` describes them.
"""
CONTEXT = {"help_option_names": ["-h", "--help"], "max_content_width": 100}


@click.group(cls=SectionedGroup, context_settings=CONTEXT, help=HELP)
@click.version_option(__version__, prog_name="symoro-elastic")
def cli() -> None:
    """Symbolic models of robots and machine tools."""


OF_OUTPUT = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EROFS, errno.EIO, errno.EBADF)
"""Errors of writing; others are of programs, processes and files that are read."""
COLLECTED_AFTER = 2_000_000, 50
"""New objects after which Python looks for cyclic garbage, and times until it looks among older ones, too.

What a command makes lives on until its end, mostly: by default a fifth of the time of a large machine goes into this.
"""

SINGLE_THREADED = ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
"""Libraries of linear algebra that use one thread unless the user says otherwise: matrices here have some ten rows, for
which threads wait for each other. `control` at many positions takes a quarter of the time."""


def main() -> None:
    """Run the command line; an error that the user can fix ends in one line on stderr and exit code 2.

    Where a signal ends the process, temporary files are removed first.
    """
    gc.set_threshold(*COLLECTED_AFTER)
    for name in SINGLE_THREADED:
        os.environ.setdefault(name, "1")  # numpy reads them at its import
    with _ended_by_signals():
        code = _run(sys.argv[1:] or ["--help"])
    gc.freeze()  # the process ends: no garbage is looked for any more
    sys.exit(_flush(code))


def _run(arguments: list[str]) -> int:
    """Run one command; return its exit code."""
    if sys.stdout is None:
        return _fail("standard output: is closed: nothing can be printed")
    try:
        code = cli.main(args=arguments, standalone_mode=False)
    except InputError as error:
        return _fail(str(error))
    except click.ClickException as error:
        return _fail(_usage(error))
    except click.Abort:
        return 130
    except MemoryError:
        return _fail("not enough memory for so large a model: ask for one --model, for fewer outputs, or lock joints")
    except Failure as failure:
        if isinstance(failure.cause, OSError):
            return _no_output(failure.cause)
        raise
    return code if isinstance(code, int) else 0


def _flush(code: int) -> int:
    """Write out buffered standard output; return the exit code."""
    try:
        if sys.stdout is not None:
            sys.stdout.flush()
    except OSError as error:
        return _no_output(error)
    return code


def _no_output(error: OSError) -> int:
    """Report an error of the operating system, unless a reader such as `head` closed the pipe; return the exit code."""
    reason = error.strerror or error
    if error.errno in OF_OUTPUT:
        _fail(f"{error.filename or 'standard output or a temporary file'}: cannot be written ({reason})")
    elif error.errno != errno.EPIPE:
        _fail(f"{error.filename or 'operating system'}: cannot be used ({reason}): correct that, and run it again")
    sys.stdout = open(os.devnull, "w")  # noqa: SIM115  (the interpreter flushes it when it ends)
    return 0 if error.errno == errno.EPIPE else 2


@contextmanager
def _ended_by_signals() -> Iterator[None]:
    """Let SIGTERM and SIGHUP, unless ignored, end the block as an exception."""
    numbers = [getattr(signal, name) for name in ("SIGTERM", "SIGHUP") if hasattr(signal, name)]
    before = {number: signal.getsignal(number) for number in numbers}

    def end(number: int, _frame: object) -> None:
        raise SystemExit(128 + number)

    for number, handler in before.items():
        if handler == signal.SIG_DFL:
            signal.signal(number, end)
    try:
        yield
    finally:
        for number, handler in before.items():
            if handler == signal.SIG_DFL:
                signal.signal(number, handler)


def _fail(line: str) -> int:
    from symoro_elastic.cli.output import say

    say(f"error: {line}")
    return 2


def _usage(error: click.ClickException) -> str:
    command = getattr(getattr(error, "ctx", None), "command_path", "symoro-elastic")
    return f"{command}: {error.format_message()} See {command} --help"
