"""Pages of the documentation whose commands and programs run, and print what the pages show.

`python -m tests.documented_pages docs/PAGE.md` runs a page and writes what is printed into it.
"""

from __future__ import annotations

import contextlib
import io
import os
import re
import shlex
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from decimal import Decimal, InvalidOperation
from itertools import pairwise
from pathlib import Path
from types import ModuleType
from typing import Any, NamedTuple

from tests.command_line import EXAMPLES, ended
from tests.golden import ROOT

BLOCK = re.compile(r"^```(\w*)\n(.*?)^```$", re.DOTALL | re.MULTILINE)
TIME = re.compile(r"[\d.e+-]+ [num]?s\b")
VERDICT = re.compile(r"(within|more than) the TIME that|\d+ overruns|\d\.\de-1\d|-?─+")
BELOW = Decimal("1e-9")
"""Of a number that is rounding: positions that are zero but for that."""
EXECUTED = ("sh", "python")


class Run(NamedTuple):
    """Commands or a program, and what the page shows of its output."""

    language: str
    text: str
    shown: str


def runs(page: str) -> list[Run]:
    """Every block that runs, with the block without language that follows it."""
    found = [*BLOCK.findall(page), ("sh", "")]
    return [
        Run(language, text, "" if kind else shown)
        for (language, text), (kind, shown) in pairwise(found)
        if language in EXECUTED
    ]


def words(text: str) -> list[str]:
    """Without times, what depends on them, and the last digits of rounding errors."""
    return VERDICT.sub("", TIME.sub("TIME", text)).split()


def differ(shown: str, printed: str) -> bool:
    """Whether two words are other texts, or numbers by more than one of the last digit that is shown."""
    if shown == printed:
        return False
    try:
        x, y = Decimal(shown.strip(",[]")), Decimal(printed.strip(",[]"))
    except InvalidOperation:
        return True
    digit = Decimal(1).scaleb(int(x.as_tuple().exponent))
    return abs(x - y) > max(digit, BELOW)


def differences(shown: str, printed: str) -> list[tuple[str, str]]:
    before, after = words(shown), words(printed)
    if len(before) != len(after):
        return [(shown, printed)]
    return [pair for pair in zip(before, after, strict=True) if differ(*pair)]


def output(run: Run, names: dict[str, Any] | None = None) -> str:
    """Standard output, then the error stream; programs of a page share `names`."""
    if run.language == "python":
        with contextlib.redirect_stdout(io.StringIO()) as out:
            exec(run.text, {} if names is None else names)
        return out.getvalue()
    lines = run.text.replace("\\\n", " ").splitlines()
    return "".join(_printed(shlex.split(line, comments=True)) for line in lines if line.strip())


def _printed(command: list[str]) -> str:
    program, *arguments = command
    if program == "symoro-elastic":
        done = ended(*arguments)
        assert done.code == 0, done.err
        return done.out + done.err
    return subprocess.run([program, *arguments], capture_output=True, text=True, check=True).stdout


def wrong_blocks(page: str) -> dict[str, list[tuple[str, str]]]:
    """Run a page in the folder where it is; what differs, by the text of its block."""
    names: dict[str, Any] = {}
    found = {}
    for run in runs(page):
        printed = output(run, names)
        if run.shown and (wrong := differences(run.shown, printed)):
            found[run.text] = wrong
    return found


@contextlib.contextmanager
def beside_examples(folder: Path) -> Iterator[Path]:
    """Go to a folder beside the examples, as pages assume, whose `generated` is its own."""
    before, known = Path.cwd(), _without_generated()
    if not (folder / "examples").exists():
        (folder / "examples").symlink_to(EXAMPLES)
    os.chdir(folder)
    sys.path.insert(0, str(folder))
    try:
        yield folder
    finally:
        os.chdir(before)
        sys.path.remove(str(folder))
        _without_generated()
        sys.modules.update(known)


def _without_generated() -> dict[str, ModuleType]:
    """Forget the modules that were imported from a folder `generated`; they are returned."""
    return {name: sys.modules.pop(name) for name in [*sys.modules] if name.split(".")[0] == "generated"}


def rewritten(page: str) -> str:
    """The page with what its blocks print in the place of what it shows."""
    names: dict[str, Any] = {}
    for run in runs(page):
        printed = "\n".join(line.rstrip() for line in output(run, names).strip("\n").splitlines()) + "\n"
        if run.shown:
            head = f"```{run.language}\n{run.text}```"
            start = page.index(head) + len(head)
            page = page[:start] + page[start:].replace(run.shown, printed, 1)
    return page


def main() -> int:
    for path in map(Path, sys.argv[1:]):
        with tempfile.TemporaryDirectory() as folder, beside_examples(Path(folder)):
            text = rewritten((ROOT / path).read_text(encoding="utf-8"))
        (ROOT / path).write_text(text, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
