"""Processor seconds of tests and of the processes that they start, by folder and file.

python -m pytest --processor-times=FILE          appends a line for each test: seconds, tab, its name
python -m tests.processor_times FILE [--depth 2]  prints the sums, most first; --tests prints the slowest tests
"""

from __future__ import annotations

import argparse
import os
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path

import pytest

OPTION = "--processor-times"
IMPORTS = "imports and collection"
"""The name of what a process of tests computes before its first test."""


class ProcessorTimes:
    """A plugin that appends to a file what each test of this process costs."""

    def __init__(self, file: Path) -> None:
        self.file, self.is_first = file, True

    @pytest.hookimpl(wrapper=True, tryfirst=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Iterator[None]:
        """Measure set-up, call and tear-down of a test."""
        before = processor_seconds()
        if self.is_first:
            self._append(before, IMPORTS)
            self.is_first = False
        try:
            return (yield)
        finally:
            self._append(processor_seconds() - before, item.nodeid)

    def _append(self, seconds: float, name: str) -> None:
        """Append a line by a single write, since other processes append theirs."""
        with self.file.open("ab", buffering=0) as file:
            file.write(f"{seconds:.3f}\t{name}\n".encode())


def processor_seconds() -> float:
    """Processor seconds of this process and of the processes that it has started and waited for."""
    times = os.times()
    return times.user + times.system + times.children_user + times.children_system


def read_times(file: Path) -> Counter[str]:
    """Processor seconds by test; those of imports are summed over the processes."""
    seconds: Counter[str] = Counter()
    for line in file.read_text(encoding="utf-8").splitlines():
        number, name = line.split("\t", 1)
        seconds[name] += float(number)
    return seconds


def by_folder(seconds: Mapping[str, float], depth: int) -> dict[str, tuple[float, int]]:
    """Processor seconds and number of tests by the first `depth` parts of their files' paths below tests/."""
    sums: Counter[str] = Counter()
    tests: Counter[str] = Counter()
    for name, number in seconds.items():
        parts = name.split("::")[0].removeprefix("tests/").split("/")
        group = "/".join(parts[:depth]) if "::" in name else name
        sums[group] += number
        tests[group] += "::" in name
    return {group: (number, tests[group]) for group, number in sums.most_common()}


def table(rows: Iterable[tuple[str, float, int]]) -> str:
    """Lines of name, processor seconds, fraction of the sum, and number of tests."""
    rows = list(rows)
    total = sum(row[1] for row in rows)
    lines = [f"{seconds:9.2f} s {seconds / max(total, 1e-9):7.1%} {tests:6d}  {name}" for name, seconds, tests in rows]
    return "\n".join([*lines, f"{total:9.2f} s  {'':6s} {sum(row[2] for row in rows):6d}  all"])


def main() -> None:
    """Print the table of a file that the option has written."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("file", type=Path)
    parser.add_argument(
        "--depth", type=int, default=0, help="1: rooms, 2 and more: folders and files (0: rooms, then files)"
    )
    parser.add_argument("--tests", type=int, default=0, metavar="N", help="print the N slowest tests")
    options = parser.parse_args()
    seconds = read_times(options.file)
    for depth in [options.depth] if options.depth else [1, 9]:
        print(table((name, *sums) for name, sums in by_folder(seconds, depth).items()), end="\n\n")
    for name, number in seconds.most_common(options.tests):
        print(f"{number:9.2f} s  {name}")


if __name__ == "__main__":
    main()
