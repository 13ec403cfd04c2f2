"""Documents name what exists: tests behind promises, files, commands and the version."""

from __future__ import annotations

import contextlib
import re
import shlex
from collections import Counter
from functools import cache
from pathlib import Path

import click
import pytest

import symoro_elastic
from symoro_elastic.cli import cli
from tests.conftest import IS_QUICK

ROOT = Path(__file__).parents[2]
TESTS = ROOT / "tests"
PROMISE = re.compile(r"^\| ([^|]+) \| (`[\w/]+\.py::\w+`(?:, `[\w/]+\.py::\w+`)*) \|$", re.MULTILINE)
PROMISES = [
    (promise, re.findall(r"([\w/]+\.py)::(\w+)", tests))
    for promise, tests in PROMISE.findall((TESTS / "README.md").read_text(encoding="utf-8"))
]
DOCUMENTS = (
    *("README.md", "CONTRIBUTING.md", "CHANGELOG.md", "tests/README.md"),
    *(str(path.relative_to(ROOT)) for path in sorted((ROOT / "docs").rglob("*.md"))),
)


def text(document: str) -> str:
    return (ROOT / document).read_text(encoding="utf-8")


@cache
def names_of_tests(path: str) -> set[str]:
    return {*re.findall(r"^def (test_\w+)", (TESTS / path).read_text(encoding="utf-8"), re.MULTILINE)}


# Promises


def test_every_promise_has_its_test() -> None:
    named = [test for _, tests in PROMISES for test in tests]
    assert [(p, name) for p, name in named if not (TESTS / p).is_file() or name not in names_of_tests(p)] == []


def test_every_promise_has_a_test_in_the_test_command(request: pytest.FixtureRequest) -> None:
    """Of those whose files are collected: in the test command, all."""
    is_quick = request.config.stash[IS_QUICK]
    files = {name.split("::")[0] for name in is_quick}
    slow = [
        (promise, tests)
        for promise, tests in PROMISES
        if files >= {f"tests/{path}" for path, _ in tests}
        and not any(is_quick.get(f"tests/{path}::{name}") for path, name in tests)
    ]
    assert slow == []


@pytest.mark.thorough
def test_promises_are_many_and_differ() -> None:
    table = text("tests/README.md").split("## Where each promise is tested")[1]
    rows = [line for line in table.splitlines() if line.startswith("| ") and "| |" not in line]
    assert len(rows) - 1 == len(PROMISES) >= 50, "every row but the heading is a promise with a test"
    assert len({str(tests) for _, tests in PROMISES}) == len(PROMISES)


@pytest.mark.thorough
def test_every_folder_of_tests_is_listed() -> None:
    table = text("tests/README.md").split("## Where each promise is tested")[0]
    named = set(re.findall(r"`([\w.]+)`", table))
    there = {path.name for path in TESTS.iterdir() if path.is_dir() and any(path.glob("*.py"))}
    files = {path.name for path in TESTS.glob("*.py")} - {"__init__.py", "conftest.py"}
    assert there | files <= named


# Files and commands that documents name


@pytest.mark.parametrize("document", DOCUMENTS)
def test_files_that_are_named_exist(document: str) -> None:
    links = re.findall(r"\]\((?!https?:)([^)#]+)\)", text(document))
    paths = re.findall(r"`((?:examples|docs|tests|symoro_elastic|templates)/[\w/.]*\w)`", text(document))
    paths += re.findall(r"`([a-z]\w*/[\w/]+\.(?:py|j2))`", text(document))
    folders = (ROOT, ROOT / "symoro_elastic", (ROOT / document).parent)
    missing = [name for name in (*links, *paths) if not any((folder / name).exists() for folder in folders)]
    assert missing == []


@pytest.mark.parametrize("document", DOCUMENTS)
def test_modules_that_are_run_exist(document: str) -> None:
    for module in re.findall(r"python -m (tests[\w.]*)", text(document)):
        path = ROOT.joinpath(*module.split("."))
        assert path.with_suffix(".py").is_file() or (path / "__main__.py").is_file(), module


def test_every_benchmark_is_named() -> None:
    """Of those that run alone; `scenes` runs others."""
    guide = text("CONTRIBUTING.md")
    for path in sorted((TESTS / "benchmarks").glob("*.py")):
        if '__name__ == "__main__"' in path.read_text(encoding="utf-8") and path.stem != "scene_energy":
            assert re.search(rf"(?:benchmarks\.|`){path.stem}\b", guide), path.stem


@pytest.mark.parametrize("document", DOCUMENTS)
def test_commands_that_are_named_exist(document: str) -> None:
    for name in re.findall(r"symoro-elastic ([a-z][\w-]*)", text(document)):
        assert name in cli.commands, name


@pytest.mark.parametrize("document", [name for name in DOCUMENTS if name != "CHANGELOG.md"])
def test_options_that_are_named_exist(document: str) -> None:
    """Commands within sentences and tables; an option may stand there without its value."""
    for code in re.findall(r"`(?:symoro-elastic )?([^`\n]+)`", text(document)):
        name, *rest = code.split(" ", 1)
        if rest and name in cli.commands:
            command = cli.commands[name]
            parser = command.make_parser(click.Context(command))
            with contextlib.suppress(click.BadOptionUsage):
                parser.parse_args(shlex.split(rest[0]))


# The version


def test_the_changelog_has_the_version() -> None:
    versions = re.findall(r"^## \[([^\]]+)\]", text("CHANGELOG.md"), re.MULTILINE)
    assert versions[0] == "Unreleased" and versions[1] == symoro_elastic.__version__


def test_the_citation_has_the_version() -> None:
    found = re.search(r"^version: (\S+)$", text("CITATION.cff"), re.MULTILINE)
    assert found and found[1] == symoro_elastic.__version__


def test_no_line_repeats_another() -> None:
    """A merge of two versions of a line keeps both, whole or torn."""
    rows = Counter(re.findall(r"^\| ([^|]+) \|", text("tests/README.md"), re.MULTILINE))
    assert [row for row, count in rows.items() if count > 1] == []
    lines = [line.split() for line in text("CHANGELOG.md").splitlines()]
    phrases = Counter(phrase for words in lines for phrase in {tuple(words[k : k + 8]) for k in range(len(words) - 7)})
    assert [phrase for phrase, count in phrases.items() if count > 1] == []
