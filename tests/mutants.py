"""Mutants of the package: which small changes of its code no test notices.

python -m tests.mutants                      draws 200 mutants of the core and runs the test command's tests on them
python -m tests.mutants symoro_elastic/machine --count 60 --seed 1 --thorough --table survivors.md

A mutant changes an operator, a sign, a constant, a comparison or a condition, swaps two arguments, or removes a
statement. Tests run in a copy of the repository: at first all of them once, which records those that reach the
statement of a mutant and what they cost; then for each mutant these, the cheapest first, and then the other tests of
their files, until one fails. Tests in `architecture` read the code as text and do not count.
"""

from __future__ import annotations

import argparse
import ast
import bisect
import copy
import itertools
import json
import math
import os
import random
import resource
import subprocess
import sys
import tempfile
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import pytest

from tests.processor_times import read_times

ROOT = Path(__file__).parents[1]
CORE = ("symoro_elastic/mechanics", "symoro_elastic/symbolic", "symoro_elastic/codegen/c")
MOST = 60
"""Processor seconds of the tests of a mutant, as they were without it."""
FACTOR, MORE = 3, 60
"""A mutant has no end if its tests take this factor of their processor time, and more seconds."""
CHEAPEST = 40
"""Tests in the first run of a mutant: most mutants fail in one of a few tests."""
RECORDER = "reached_statements"
"""The module of the copy that instrumented code imports."""
BINARY = {
    ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult, ast.FloorDiv: ast.Mult,
    ast.Mod: ast.Mult, ast.Pow: ast.Mult, ast.BitOr: ast.BitAnd, ast.BitAnd: ast.BitOr, ast.MatMult: ast.Mult,
}  # fmt: skip
COMPARISONS = {
    ast.Lt: ast.LtE, ast.LtE: ast.Lt, ast.Gt: ast.GtE, ast.GtE: ast.Gt, ast.Eq: ast.NotEq, ast.NotEq: ast.Eq,
    ast.Is: ast.IsNot, ast.IsNot: ast.Is, ast.In: ast.NotIn, ast.NotIn: ast.In,
}  # fmt: skip


@dataclass(frozen=True)
class Mutant:
    """A change of a file: its place, what stands there and what replaces it, by positions in the UTF-8 text."""

    file: str
    line: int
    start: int
    end: int
    before: str
    after: str

    def apply(self, text: bytes) -> bytes:
        """The text of the file with the change."""
        return text[: self.start] + self.after.encode() + text[self.end :]

    def __str__(self) -> str:
        return f"{self.file}:{self.line}: {_short(self.before)} -> {_short(self.after)}"


# Changes


def mutants_of(file: str, text: str) -> list[Mutant]:
    """All mutants of a file, in the order of its text."""
    data = text.encode()
    starts = [0]
    for line in data.splitlines(keepends=True):
        starts.append(starts[-1] + len(line))
    found = []
    for node in _executed(ast.parse(text)):
        for changed in _changes(node):
            if ast.dump(changed) == ast.dump(node):  # two arguments that are equal
                continue
            start = starts[node.lineno - 1] + node.col_offset
            end = starts[node.end_lineno - 1] + node.end_col_offset
            after = ast.unparse(changed)
            after = after if isinstance(node, ast.stmt) else f"({after})"
            found.append(Mutant(file, node.lineno, start, end, data[start:end].decode(), after))
    return sorted(found, key=lambda mutant: (mutant.start, mutant.end, mutant.after))


def _executed(node: ast.AST) -> Iterator[ast.AST]:
    """The nodes that compute something: no annotations, docstrings, imports, texts of errors, formatted texts."""
    for name, value in ast.iter_fields(node):
        if name in ("annotation", "returns", "type_comment", "type_params", "decorator_list"):
            continue
        for child in value if isinstance(value, list) else [value]:
            if isinstance(child, (ast.Import, ast.ImportFrom, ast.JoinedStr)) or not isinstance(child, ast.AST):
                continue
            if isinstance(child, ast.Raise):
                continue
            if isinstance(child, ast.Assign) and ast.unparse(child.targets[0]).startswith("__"):
                continue
            yield child
            yield from _executed(child)


def _changes(node: ast.AST) -> Iterator[ast.AST]:
    changed = copy.copy(node)
    match node:
        case ast.BinOp(op=op) if type(op) in BINARY and not _is_text(node):
            changed.op = BINARY[type(op)]()
            yield changed
        case ast.UnaryOp(op=ast.USub() | ast.Not(), operand=operand):
            yield operand
        case ast.Compare(ops=[op]):
            changed.ops = [COMPARISONS[type(op)]()]
            yield changed
        case ast.BoolOp(op=op):
            changed.op = ast.And() if isinstance(op, ast.Or) else ast.Or()
            yield changed
        case ast.Constant(value=bool() as value):
            yield ast.Constant(not value)
        case ast.Constant(value=int() | float() as value):
            yield ast.Constant(value + 1)
        case ast.IfExp(test=test):
            changed.test = ast.UnaryOp(ast.Not(), test)
            yield changed
        case ast.Call(args=[first, second, *others]) if not any(isinstance(x, ast.Starred) for x in node.args):
            changed.args = [second, first, *others]
            yield changed
        case ast.Expr(value=ast.Call() | ast.Yield() | ast.YieldFrom()):
            yield ast.Pass()
        case ast.AugAssign():
            yield ast.Pass()
        case ast.Assign(targets=[ast.Subscript() | ast.Attribute()]):
            yield ast.Pass()
        case ast.Continue() | ast.Break():
            yield ast.Pass()


def _is_text(node: ast.BinOp) -> bool:
    return any(isinstance(x, ast.JoinedStr) or isinstance(getattr(x, "value", 0), str) for x in (node.left, node.right))


def draw(folders: Sequence[str], count: int, seed: int) -> list[Mutant]:
    """Mutants drawn at random from the files of folders, with at most one of a place."""
    files = [path for folder in folders for path in sorted((ROOT / folder).rglob("*.py"))]
    every = [
        mutant
        for path in files or [ROOT / folder for folder in folders]
        for mutant in mutants_of(path.relative_to(ROOT).as_posix(), path.read_text(encoding="utf-8"))
    ]
    drawn = random.Random(seed).sample(every, min(count, len(every)))
    return sorted(drawn, key=lambda mutant: (mutant.file, mutant.start))


# The tests that reach a mutant


def instrumented(text: str, lines: dict[int, list[int]]) -> str:
    """Code that records the numbers of mutants where it reaches the innermost statements of their lines."""
    tree = ast.parse(text)
    for node in [*ast.walk(tree)]:
        for name in ("body", "orelse", "finalbody"):
            block = getattr(node, name, None)
            if isinstance(block, list):
                setattr(node, name, [new for statement in block for new in (*_records(statement, lines), statement)])
    head = next(
        (
            k + 1
            for k, x in reversed([*enumerate(tree.body)])
            if isinstance(x, ast.ImportFrom) and x.module == "__future__"
        ),
        0,
    )
    tree.body.insert(head, ast.ImportFrom(RECORDER, [ast.alias("reached")], 0))
    return ast.unparse(ast.fix_missing_locations(tree))


def _records(statement: ast.stmt, lines: dict[int, list[int]]) -> Iterator[ast.stmt]:
    """Statements that record the mutants of a statement's own lines, without those of the blocks in it."""
    if isinstance(statement, (ast.Import, ast.ImportFrom, ast.FunctionDef, ast.ClassDef)) or _is_docstring(statement):
        return
    blocks = [x for name in ("body", "orelse", "finalbody", "handlers") for x in getattr(statement, name, [])]
    last = min((x.lineno for x in blocks), default=statement.end_lineno + 1)
    numbers = [k for line in range(statement.lineno, max(last, statement.lineno + 1)) for k in lines.get(line, ())]
    if numbers:
        yield ast.parse(f"reached.update({numbers})").body[0]


def _is_docstring(statement: ast.stmt) -> bool:
    return isinstance(statement, ast.Expr) and isinstance(statement.value, ast.Constant)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item: pytest.Item) -> Iterator[None]:
    """As a plugin (`-p tests.mutants`): append the mutants that a test reaches to a file."""
    reached = sys.modules.get(RECORDER)
    if reached is None:
        return (yield)
    reached.reached.clear()
    try:
        return (yield)
    finally:
        if reached.reached:
            with Path(os.environ["REACHED_MUTANTS"]).open("ab", buffering=0) as file:
                file.write((json.dumps([item.nodeid, sorted(reached.reached)]) + "\n").encode())


class Copy:
    """A copy of the repository in which mutants live."""

    def __init__(self, folder: Path, marks: str) -> None:
        self.folder, self.marks = folder, marks
        self.costs: Counter[str] = Counter()
        listed = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, text=True, check=True).stdout
        for name in listed.split("\0"):
            if name and (ROOT / name).is_file():
                (folder / name).parent.mkdir(parents=True, exist_ok=True)
                (folder / name).write_bytes((ROOT / name).read_bytes())
        self.environment = {**os.environ, "PYTHONPATH": str(folder), "CI": "1", "PYTHONDONTWRITEBYTECODE": "1"}

    def pytest(self, *arguments: str, limit: float = math.inf) -> int:
        """The exit status of the tests; negative if they are ended by the limit of processor seconds."""
        command = [sys.executable, "-m", "pytest", "-x", "--tb=no", "--no-header", *arguments]
        seconds = resource.RLIM_INFINITY if math.isinf(limit) else math.ceil(limit)

        def limited() -> None:
            resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds))

        streams = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL, "stdin": subprocess.DEVNULL}
        return subprocess.run(
            command, cwd=self.folder, env=self.environment, check=False, preexec_fn=limited, **streams
        ).returncode

    def tests_of(self, mutants: Sequence[Mutant], tests: Sequence[str], jobs: int) -> list[list[str]]:
        """The tests that reach each mutant, the cheapest first; the code is instrumented meanwhile."""
        (self.folder / f"{RECORDER}.py").write_text("reached: set[int] = set()\n", encoding="utf-8")
        lines: dict[str, dict[int, list[int]]] = defaultdict(lambda: defaultdict(list))
        for k, mutant in enumerate(mutants):
            lines[mutant.file][mutant.line].append(k)
        texts = {file: (self.folder / file).read_text(encoding="utf-8") for file in lines}
        for file, text in texts.items():
            (self.folder / file).write_text(instrumented(text, lines[file]), encoding="utf-8")
        reached, seconds = self.folder / "reached.jsonl", self.folder / "seconds"
        self.environment["REACHED_MUTANTS"] = str(reached)
        self.pytest(
            *(
                "-m",
                self.marks,
                "--maxfail=1000",
                "-n",
                str(jobs),
                "-p",
                "tests.mutants",
                "--ignore=tests/architecture",
            ),
            *(f"--processor-times={seconds}", *tests),
        )
        for file, text in texts.items():
            (self.folder / file).write_text(text, encoding="utf-8")
        return self.read(mutants, reached, seconds)

    def read(self, mutants: Sequence[Mutant], reached: Path, seconds: Path) -> list[list[str]]:
        """The tests that reach each mutant by the two files of a run."""
        self.costs = read_times(seconds)
        reaching: list[list[str]] = [[] for _ in mutants]
        for line in reached.read_text(encoding="utf-8").splitlines():
            test, numbers = json.loads(line)
            for k in numbers:
                reaching[k].append(test)
        return [self._cheapest(names) for names in reaching]

    def _cheapest(self, names: Iterable[str]) -> list[str]:
        return sorted(names, key=lambda name: (self.costs[name], name))

    def killed_by(self, mutant: Mutant, reaching: Sequence[str], most: float) -> str:
        """What notices a mutant: tests that reach it, others of their files, no end; empty if nothing does.

        Tests are run that take up to `most` processor seconds together.
        """
        file = self.folder / mutant.file
        text = file.read_bytes()
        file.write_bytes(mutant.apply(text))
        files = {name.split("::")[0] for name in reaching}
        room = f"tests/{Path(mutant.file).parts[1]}/"  # what runs at an import is reached by no test
        others = [x for x in self.costs if (x.split("::")[0] in files or (not files and x.startswith(room)))]
        names = [*reaching, *self._cheapest({*others} - {*reaching})]
        total = list(itertools.accumulate(self.costs[name] for name in names))
        names = names[: bisect.bisect_right(total, most)]
        try:
            for stage, part in (("few tests", names[:CHEAPEST]), ("more tests", names[CHEAPEST:])):
                limit = MORE + FACTOR * sum(self.costs[name] for name in part)
                status = self.pytest("-n", "0", "-m", "", *part, limit=limit) if part else 0
                if status not in (0, 5):
                    return "no end" if status < 0 else stage
        finally:
            file.write_bytes(text)
        return ""


def table(mutants: Sequence[Mutant], verdicts: Sequence[str], reaching: Sequence[Sequence[str]]) -> str:
    """Counts by what has killed them, and the survivors, in Markdown."""
    counts = Counter(verdict or "survivors" for verdict in verdicts)
    lines = [f"{len(mutants)} mutants: " + ", ".join(f"{number} {name}" for name, number in counts.most_common()), ""]
    lines += ["| place | from | to | tests that reach it |", "|---|---|---|---|"]
    for mutant, verdict, tests in zip(mutants, verdicts, reaching, strict=True):
        if not verdict:
            cells = (f"{mutant.file}:{mutant.line}", _short(mutant.before), _short(mutant.after), str(len(tests)))
            lines.append("| " + " | ".join(f"`{cell}`".replace("|", "\\|") for cell in cells) + " |")
    return "\n".join(lines) + "\n"


def _short(text: str) -> str:
    line = " ".join(text.split())
    return line if len(line) <= 70 else f"{line[:67]}..."


def main() -> None:
    """Draw mutants, run tests, print the survivors."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("paths", nargs="*", default=CORE, help="folders or files of the package")
    parser.add_argument("--count", type=int, default=200)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--most", type=float, default=MOST, help="processor seconds of the tests of a mutant")
    parser.add_argument("--jobs", type=int, default=1, help="processes of the run that records what tests reach")
    parser.add_argument("--tests", nargs="*", default=["tests"], help="files or folders of tests")
    parser.add_argument("--thorough", action="store_true", help="the thorough tests too")
    parser.add_argument("--table", type=Path, help="file of the table of survivors")
    options = parser.parse_args()
    mutants = draw(options.paths, options.count, options.seed)
    with tempfile.TemporaryDirectory() as folder:
        place = Copy(Path(folder), "" if options.thorough else "not thorough")
        reaching = place.tests_of(mutants, options.tests, options.jobs)
        verdicts = []
        for mutant, tests in zip(mutants, reaching, strict=True):
            verdicts.append(place.killed_by(mutant, tests, options.most))
            print(f"{verdicts[-1] or 'SURVIVES':18} {len(tests):5d} tests  {mutant}", flush=True)
    text = table(mutants, verdicts, reaching)
    print(text)
    if options.table:
        options.table.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
