"""Faults of files while a command writes: each of its file operations in turn fails, or the process ends there.

python -m tests.faults                    every operation and fault of all commands, and a table of what was left
python -m tests.faults --every 5 generate   each fifth operation of one command

A process of one thread has imported all that commands need; each case is a copy of it. Operations are counted by an
audit hook, those on paths in the folder that is written to. Results are those of an old run, of a new run, or a
mixture, which C and numpy have to reject, and which the next run has to replace.
"""

from __future__ import annotations

import argparse
import errno
import os
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from symoro_elastic import cli
from symoro_elastic.foundation.replacing import STAGING

EXAMPLES = Path(__file__).resolve().parents[1] / "examples"
OPERATIONS = {
    "open", "os.mkdir", "os.rename", "os.remove", "os.rmdir", "os.link", "os.chmod", "os.chown", "os.listdir",
    "os.scandir", "os.getxattr", "os.listxattr", "os.setxattr", "os.removexattr", "os.truncate", "shutil.copyfile",
}  # fmt: skip
"""Events of Python for calls of the operating system that name a file."""
ENDS = {"SIGINT": 130, "SIGTERM": 143, "SIGKILL": -signal.SIGKILL}
"""Exit codes of runs that a signal ends."""
FAULTS = ("ENOSPC", "EACCES", "EACCES from then on", *ENDS)
Contents = dict[str, bytes]


@dataclass(frozen=True)
class Command:
    """A command that writes to a folder: its words for the older and the newer run, the folder in place of OUT."""

    newer: str
    older: str = ""


COMMANDS = {
    "generate": Command("generate NEW --out OUT"),
    "generate over older": Command("generate NEW --out OUT", "generate OLD --out OUT --model geometric_model"),
    "view --force": Command("view NEW --out OUT/a.html --force", "view OLD --out OUT/a.html"),
    "convert --force": Command("convert NEW OUT/a.par --force", "convert OLD OUT/a.par"),
    "convert in place": Command("convert NEW OUT/a.par --force", "convert OLD OUT/a.par"),
    "report --force": Command("report NEW --out OUT/a.html --force", "report OLD --out OUT/a.html"),
}
IN_PLACE = "convert in place"
"""The command whose file has a second name, so that it is overwritten."""


@dataclass(frozen=True)
class Case:
    """What became of a run with a fault at one operation."""

    state: str
    wrong: str = ""


class Folder:
    """The folder of a command, how it is before and after, and copies of this process that run the command in it."""

    def __init__(self, work: Path, name: str) -> None:
        self.name, self.command = name, COMMANDS[name]
        self.machines = {"OLD": work / "older" / "arm.toml", "NEW": work / "newer" / "arm.toml"}
        for path, length in zip(self.machines.values(), ("0.4", "0.5"), strict=True):
            path.parent.mkdir(exist_ok=True)
            text = (EXAMPLES / "planar_2r.toml").read_text(encoding="utf-8").replace("value = 0.4", f"value = {length}")
            path.write_text(text.replace('name = "planar_2r"', 'name = "arm"'), encoding="utf-8")
        self.out = work / name.replace(" ", "_")
        self.log = work / "log.txt"
        self.count = 0
        self.out.mkdir()
        cli.cli.main(self.words(self.command.newer), standalone_mode=False)  # imports what copies of the process need
        self.prepare()
        self.older = contents(self.out)
        self.count = self.run(self.command.newer, None)[2]
        self.newer = contents(self.out)
        assert self.count > 5 and self.older != self.newer

    def prepare(self) -> None:
        """Make the folder as an older run leaves it."""
        shutil.rmtree(self.out, ignore_errors=True)
        self.out.mkdir()
        if self.command.older:
            assert self.run(self.command.older, None)[0] == 0
        if self.name == IN_PLACE:
            os.link(self.out / "a.par", self.out / "other name.par")

    def words(self, line: str) -> list[str]:
        """The words of a command line with the names of files."""
        names = {**self.machines, "OUT": self.out}
        return [str(names.get(word, word.replace("OUT/", f"{self.out}/"))) for word in shlex.split(line)]

    def run(self, line: str, fault: Callable[[int], None] | None) -> tuple[int, str, int]:
        """Run a command in a copy of this process; return exit code, what it prints, how many operations it had."""
        reading, writing = os.pipe()
        if not (child := os.fork()):
            with self.log.open("w") as log:
                os.dup2(log.fileno(), 2)
                os.dup2(log.fileno(), 1)
            os.close(reading)
            hook = Hook(self.out, fault, writing)
            sys.addaudithook(hook)
            sys.argv = ["symoro-elastic", *self.words(line)]
            code = 1
            try:
                cli.main()
            except SystemExit as ended:
                code = ended.code if isinstance(ended.code, int) else 1
            except BaseException as error:
                print(f"Traceback: {error!r}", file=sys.stderr)
            sys.stderr.flush()
            os._exit(code)
        os.close(writing)
        with os.fdopen(reading, "rb") as counts:
            count = len(counts.read())
        code = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
        return code, self.log.read_text(encoding="utf-8"), count

    def case(self, operation: int, fault: str) -> Case:
        """Run the command with a fault, look at what it leaves, and run it again."""
        self.prepare()
        code, said, _ = self.run(self.command.newer, Fault(operation, fault))
        left = contents(self.out)
        state = "old" if left == self.older else "new" if left == self.newer else "mixed"
        wrong = [] if "Traceback" not in said else [f"a traceback: {said}"]
        if code not in (0, ENDS.get(fault, 2)):
            wrong.append(f"exit code {code}")
        if code == 2 and said.count("\n") != 1:
            wrong.append(f"not one line: {said}")
        if fault not in ("SIGKILL", "EACCES from then on"):
            wrong += [f"{state}: {sorted(left)}"] if state == "mixed" else []
            wrong += ["a folder is left"] if [*self.out.rglob(f"{STAGING}*")] else []
            wrong += ["new, but failed"] if state == "new" and code == 2 else []
        if state == "mixed" and self.name.startswith("generate"):
            wrong += undetected(self.out / "arm", *(at(own, "arm/") for own in (self.older, self.newer)))
        code, said, _ = self.run(self.command.newer, None)
        if "exists" in said or code or contents(self.out) != self.newer or [*self.out.rglob(f"{STAGING}*")]:
            wrong.append(f"the next run: exit code {code}, {said}{sorted(contents(self.out))}")
        return Case(state, "; ".join(wrong))


class Hook:
    """An audit hook that counts operations in a folder, a byte to `writing` for each, and calls a fault with them."""

    def __init__(self, folder: Path, fault: Callable[[int], None] | None, writing: int) -> None:
        self.folder, self.fault, self.writing = str(folder), fault, writing
        self.number = 0

    def __call__(self, event: str, arguments: tuple[Any, ...]) -> None:
        """Count an operation."""
        if event not in OPERATIONS or not any(str(x).startswith(self.folder) for x in arguments[:2]):
            return
        self.number += 1
        os.write(self.writing, b".")
        if self.fault:
            self.fault(self.number)


@dataclass(frozen=True)
class Fault:
    """What happens at one operation, or from it on."""

    operation: int
    name: str

    def __call__(self, number: int) -> None:
        """Fail, or end the process."""
        if number < self.operation or (number > self.operation and "then on" not in self.name):
            return
        first = self.name.split()[0]
        if first in ENDS:
            signal.raise_signal(getattr(signal, first))
        else:
            raise OSError(getattr(errno, first), os.strerror(getattr(errno, first)))


def contents(folder: Path) -> Contents:
    """The files of a folder by name, without those that a killed run left beside them."""
    paths = (path for path in sorted(folder.rglob("*")) if path.is_file() and STAGING not in str(path))
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in paths}


def at(files: Mapping[str, bytes], folder: str) -> Contents:
    """Those of some files that are in a folder."""
    return {name.removeprefix(folder): text for name, text in files.items() if name.startswith(folder)}


def undetected(folder: Path, *runs: Contents) -> Iterator[str]:
    """Groups of files that are a mixture, and that C or numpy accepts all the same."""
    for suffixes, accepts in (((".py",), _import), ((".c", ".h"), _compile)):
        left, *own = (of_kind(files, suffixes) for files in (contents(folder), *runs))
        if left and left not in own and accepts(folder):
            yield f"a mixture is accepted: {sorted(left)}"


def of_kind(files: Contents, suffixes: tuple[str, ...]) -> Contents:
    """Those of some files that have one of the suffixes."""
    return {name: text for name, text in files.items() if name.endswith(suffixes)}


def _import(folder: Path) -> bool:
    """Whether Python imports the package."""
    program = f"import sys; sys.path.insert(0, {str(folder.parent)!r}); import {folder.name}"
    command = [sys.executable, "-B", "-c", program]
    return subprocess.run(command, capture_output=True, check=False).returncode == 0


def _compile(folder: Path) -> bool:
    """Whether C compiles its source, which is there with the header."""
    command = ["cc", "-fsyntax-only", str(folder / f"{folder.name}.c")]
    return subprocess.run(command, capture_output=True, check=False).returncode == 0


def cases(work: Path, name: str, every: int, faults: tuple[str, ...]) -> Iterator[tuple[str, int, Case]]:
    """Yield fault, operation and case of each n-th operation of a command."""
    folder = Folder(work, name)
    for operation in range(1, folder.count + 1, every):
        for fault in faults:
            yield fault, operation, folder.case(operation, fault)


def main() -> int:
    """Print what is left after each fault; 1 where something is wrong."""
    parser = argparse.ArgumentParser(prog="python -m tests.faults")
    parser.add_argument("names", nargs="*", default=[*COMMANDS], metavar="COMMAND", help="; ".join(COMMANDS))
    parser.add_argument("--every", type=int, default=1, help="each n-th operation only")
    parser.add_argument("--fault", choices=FAULTS, action="append", help="these faults only")
    asked = parser.parse_args()
    failed = 0
    with tempfile.TemporaryDirectory() as work:
        for name in asked.names:
            states, count = Counter[str](), 0
            for fault, operation, case in cases(Path(work), name, asked.every, tuple(asked.fault or FAULTS)):
                states[case.state] += 1
                count = max(count, operation)
                if case.wrong:
                    failed += 1
                    print(f"{name}, operation {operation}, {fault}: {case.wrong}", flush=True)
            print(f"{name}: {count} operations, {', '.join(f'{n} {state}' for state, n in sorted(states.items()))}")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
