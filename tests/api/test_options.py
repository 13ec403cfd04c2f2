"""Options are declared once: help, signature, docstring, files and completion follow from one field."""

from __future__ import annotations

import ast
import inspect
import math
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import click
import pytest
from click.testing import CliRunner

import symoro_elastic as se
from symoro_elastic.api import kinds, sweeps
from symoro_elastic.api.declaration import Option, operation, option, options, read_options
from symoro_elastic.api.measuring_options import Exciting, Identifying
from symoro_elastic.api.options import (
    Checking,
    Comparing,
    Generating,
    Linearizing,
    Oscillating,
    Reading,
    Responding,
    Sweeping,
    Trading,
)
from symoro_elastic.api.rows import READABLE, WRITABLE
from symoro_elastic.cli import cli
from symoro_elastic.cli.options import DeclaredOption, takes
from symoro_elastic.codegen.targets import TARGET_NAMES
from symoro_elastic.formats import FORMATS
from symoro_elastic.foundation.errors import InputError
from tests.command_line import EXAMPLES, ended, run

TWO_R = EXAMPLES / "planar_2r.toml"


class Widened(Sweeping):
    """The options of `sweep`, and one more."""

    margins: Sequence[float] = option(
        (), "MM", "Margin, mm, of {names} at --at.", kinds.LIST, names=lambda: ("tool", "table")
    )


def test_an_option_is_one_line() -> None:
    """In a copy of the record of `sweep`: seen in help, signature and docstring."""
    seen: list[Widened] = []

    def show(options: Widened) -> None:
        seen.append(options)

    command = click.command()(takes(Widened)(show))
    text = CliRunner().invoke(command, ["--help"], terminal_width=200).output
    assert "--margin MM" in text and "Margin, mm, of tool, table at --at; may be repeated." in text
    CliRunner().invoke(command, ["--margin", "2", "--margin", "1/2"], catch_exceptions=False)
    assert seen[0].margins == (2.0, 0.5)

    @operation(Widened)
    def sweep(machine: str, options: Widened) -> Sequence[float]:
        """Return the margins."""
        return options.margins

    added = inspect.signature(sweep).parameters["margins"]
    assert (added.kind, added.default, added.annotation) == (added.KEYWORD_ONLY, (), "Sequence[float]")
    assert "\nmargins : list of numbers\n    Margin, mm, of tool, table at at.\n" in (inspect.getdoc(sweep) or "")
    assert sweep("", margins=[3.0]) == [3.0]
    with pytest.raises(TypeError, match="unexpected keyword argument 'margin'"):
        sweep("", margin=[3.0])  # type: ignore[call-arg]


def test_an_option_is_a_key_of_files(tmp_path: Path) -> None:
    path = tmp_path / "sweep.toml"
    path.write_text('margins = [1, 2.5]\nresults = ["a"]\nas_given = true\npd = { m = [1, 2] }\n')
    given = read_options(path, Widened)
    assert given == {"margins": (1.0, 2.5), "results": ("a",), "as_given": True, "pd": {"m": (1.0, 2.0)}}
    path.write_text("scene = 'a.toml'")
    with pytest.raises(InputError, match="scene: no such key here"):
        read_options(path, Widened)


def rows() -> list[tuple[str, Option]]:
    """Options of all commands."""
    return [
        (str(command.name), parameter.row)
        for command in cli.commands.values()
        for parameter in command.params
        if isinstance(parameter, DeclaredOption)
    ]


def test_a_name_has_one_meaning() -> None:
    """The same name in Python, the same kind of value, written alike.

    `--model` may be repeated or not; `reduce` leaves out parts, its rate is that of a controller; errors of
    `flexible` are within one fraction.
    """
    kinds_of: dict[str, set[tuple[str, str, str]]] = {}
    for _, row in rows():
        kinds_of.setdefault(row.flag, set()).add((row.name, row.metavar, row.kind.shape))
    several = {flag: found for flag, found in kinds_of.items() if len(found) > 1}
    assert several.keys() <= {"--model", "--stroke", "--out", "--only", "--rate", "--position", "--within"}
    assert {name for name, _, _ in several.get("--stroke", set())} == {"stroke", "strokes"}


def test_no_former_name_is_in_use() -> None:
    for command, row in rows():
        own = {other.flag for name, other in rows() if name == command}
        assert not own & {old.partition("=")[0] for old in (*row.formerly, *row.gone)}, (command, row.name)


def test_python_and_the_command_line_have_the_same_words() -> None:
    """What is not an argument of the function is how its machine is read, or what becomes of the result."""
    outside = {row.name for row in options(Reading)} | {"plots", "plot_format", "out", "save", "format"}
    outside |= {"proven", "along", "tolerance", "fast_math", "points"}
    others = {"check": [se.certify], "flexible": [se.flexible_parts]}
    for command, row in rows():
        function = getattr(se, command.replace("-", "_"), None)
        if function and row.name not in outside:
            several = [function, *others.get(command, ())]
            assert any(row.name in inspect.signature(x).parameters for x in several), (command, row.name)


@pytest.mark.parametrize(
    ("record", "name", "beyond", "wanted"),
    [
        (Trading, "states", 0, "at least 1 and at most 1e+06"),
        (Trading, "rounds", 10_001, "at least 1 and at most 10000"),
        (Trading, "merge_angles", 0.0, "above 0 and at most 1e+06"),
        (Trading, "merge_angles", math.nan, "above 0 and at most 1e+06"),
        (Checking, "seed", -1, "at least 0"),
    ],
)
def test_numbers_beyond_their_bounds_are_refused(record: type[Any], name: str, beyond: float, wanted: str) -> None:
    """In Python, too, as the command line does before the function is called."""
    with pytest.raises(InputError, match=re.escape(f"{beyond!r} is out of range: give a number {wanted}")):
        record(**{name: beyond})
    assert getattr(record(**{name: 1}), name) == 1


def test_numbers_out_of_range_are_named_as_python_has_them() -> None:
    with pytest.raises(InputError, match="symoro_elastic: states: 0 is out of range"):
        se.benchmark(TWO_R, states=0)


def test_names_in_texts_are_those_of_registries() -> None:
    assert tuple(suffix for form in FORMATS for suffix in form.suffixes) == READABLE
    assert tuple(suffix for form in FORMATS for suffix in form.suffixes if form.write) == WRITABLE
    text = run("generate", "--help").stdout
    assert f"Target: {', '.join(TARGET_NAMES)}" in " ".join(text.split())
    assert f"Target: {', '.join(TARGET_NAMES)}" in " ".join((inspect.getdoc(se.generate) or "").split())
    for command, row in rows():
        for name in (row.names or tuple)() if row.name not in ("models", "model") else ():
            assert name in row.help, (command, row.name)


FORMER = {
    ("trade", TWO_R, "--rounds", "x"): "note: trade is now benchmark",
    ("certify", TWO_R, "--sub-boxes", "x"): "note: certify is now check --proven",
    ("check", TWO_R, "--box", "--sub-boxes", "x"): "note: --box is now --proven",
}
GONE = {
    ("benchmark", TWO_R, "--quick", "--rounds", "x"): "--quick: it is now --effort=quick",
    ("modes", TWO_R, "--over", "x"): "--over: it is now --along",
    ("modes", TWO_R, "--over=x"): "--over: it is now --along",
    ("modes", TWO_R, "--plots", "p", "--picture", "bmp"): "--picture: it is now --plot-format",
    ("identify", TWO_R, "x.csv", "--from", "x"): "--from: it is now --after",
    ("compare", TWO_R, "--free", "--stroke", "x"): "--free: it is now --free-motors",
}


@pytest.mark.parametrize("words", FORMER, ids=lambda words: " ".join(map(str, words[2:])))
def test_former_names_are_taken_with_a_notice(words: tuple[object, ...]) -> None:
    ending = ended(*words)
    notice, error = ending.err.splitlines()
    assert notice == FORMER[words] and error.startswith("error: ") and "No such option" not in error


@pytest.mark.parametrize("words", GONE, ids=lambda words: " ".join(map(str, words[2:])))
def test_names_of_the_version_before_are_refused_by_the_present_one(words: tuple[object, ...]) -> None:
    assert ended(*words) == (2, "", f"error: symoro-elastic: {GONE[words]}\n")


def test_former_names_of_python_are_taken_with_a_warning_and_older_ones_refused() -> None:
    with pytest.warns(DeprecationWarning, match="trade is now benchmark") as issued:
        assert se.trade is se.benchmark
    assert issued[0].filename == __file__
    with pytest.raises(TypeError, match="outputs is now only"):
        se.load(TWO_R, "jacobian", outputs={"jacobian": ["tip"]})  # type: ignore[call-overload]


def test_positions_are_given_as_before() -> None:
    for record, names in (
        (Exciting, ["position", "velocity", "acceleration"]),
        (Identifying, ["records"]),
        (Linearizing, ["point"]),
        (Oscillating, ["point"]),
        (Responding, ["point"]),
        (Comparing, ["motion"]),
        (Generating, []),
    ):
        assert [row.name for row in options(record) if not row.is_keyword] == names


def test_documentation_finds_the_options_of_functions() -> None:
    """Programs that write it follow functions to those that they wrap, which take a record."""
    for name in se.__all__:
        function = getattr(se, name)
        if inspect.isfunction(function):
            found = inspect.signature(inspect.unwrap(function))
            assert "options" not in found.parameters and "**" not in str(found), name
            if hasattr(function, "options"):
                assert all(f"\n{row}" in inspect.cleandoc(function.__doc__ or "") for row in found.parameters), name


def test_public_names_are_those_for_type_checkers() -> None:
    tree = ast.parse(Path(se.__file__).read_text(encoding="utf-8"))
    imported = next(node for node in tree.body if isinstance(node, ast.If)).body
    named = {alias.name: node.module for node in imported if isinstance(node, ast.ImportFrom) for alias in node.names}
    assert sorted(named) == sorted(se.__all__)
    for name, module in named.items():
        assert getattr(se, name).__module__ == module, name


def test_commands_of_sweep_reach_its_plan() -> None:
    """What the records share is one field: `modes`, `response` and `sweep` have the same operating point."""
    at = [next(row for row in options(record) if row.name == "at") for record in (Oscillating, Responding, Sweeping)]
    assert len({row.meaning for row in at}) == 1
    assert sweeps.sweep.options is Sweeping  # type: ignore[attr-defined]
