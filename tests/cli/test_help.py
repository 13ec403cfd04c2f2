"""`--help`: every command in one section, with a first line that is whole and short; options in standard terms."""

from __future__ import annotations

import inspect
import os
import pkgutil
import re
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import click
import pytest
from click.testing import CliRunner

import symoro_elastic.cli
from symoro_elastic.cli import cli
from symoro_elastic.cli.help import COMMON, HEADS, MOST
from symoro_elastic.cli.listed import LISTED, SECTIONS

COMMANDS = sorted(cli.commands)
WIDTH = 80
LONGEST = 60


def printed(*arguments: str) -> str:
    """The help as printed on a terminal of 80 columns."""
    return CliRunner().invoke(cli, [*arguments, "--help"], terminal_width=WIDTH).output


def first_line(command: click.Command) -> str:
    return (command.help or "").split("\n")[0]


def test_every_command_is_in_exactly_one_section() -> None:
    """And found in the module that the list names."""
    listed = [name for section in SECTIONS.values() for name in section]
    modules = [module.name for module in pkgutil.iter_modules(symoro_elastic.cli.__path__) if module.name != "__main__"]
    made = [
        (name, str(one.name))
        for name in modules
        for one in vars(import_module(f"symoro_elastic.cli.{name}")).values()
        if isinstance(one, click.Command)
    ]
    assert sorted(made) == sorted((LISTED[name].module, name) for name in listed)
    assert {name: str(command.name) for name, command in cli.commands.items()} == {name: name for name in listed}


def test_sections_are_printed_in_order_with_their_commands() -> None:
    text = printed()
    titles = re.findall(r"^(\w[\w ]*):$", text, re.MULTILINE)
    assert titles == ["Options", *SECTIONS]
    for title, names in SECTIONS.items():
        section = text.split(f"\n{title}:\n")[1].split("\n\n")[0]
        assert [line.split()[0] for line in section.splitlines()] == list(names)


@pytest.mark.parametrize("name", COMMANDS)
def test_first_lines_are_short_whole_sentences(name: str) -> None:
    line = first_line(cli.commands[name])
    assert len(line) <= LONGEST
    assert line.endswith(".") and line[0].isupper()
    assert re.search(rf"^  {name} +{re.escape(line.removesuffix('.'))}\.?$", printed(), re.MULTILINE), "cut or wrapped"


@pytest.mark.parametrize("name", COMMANDS)
def test_every_option_is_described(name: str) -> None:
    options = [p for p in cli.commands[name].params if isinstance(p, click.Option)]
    assert options
    for option in options:
        assert option.help and option.help[0].isupper() | (option.help.split()[0] in ("numpy", "latex,")), option.name
        assert option.help.endswith("."), option.name


@pytest.mark.parametrize("name", COMMANDS)
def test_the_first_screen_has_few_options_and_help_all_has_every_one(name: str) -> None:
    """Under heads; the common ones are named at the foot."""
    options = {p.opts[-1] for p in cli.commands[name].params if isinstance(p, click.Option)}
    first = re.findall(r"^  (?:-\w, )?(--[\w-]+)", after_heads(printed(name)), re.MULTILINE)
    assert len(first) <= MOST and not {*first} & COMMON
    foot = " ".join(printed(name).split("Common options: ")[1].split())
    assert {*first} | COMMON >= options or "more options: --help all" in foot
    assert all(option in foot for option in options & COMMON)
    every = re.findall(r"^  (?:-\w, )?(--[\w-]+)", after_heads(printed_all(name)), re.MULTILINE)
    assert sorted(every) == sorted({*options, "--help"})


def after_heads(text: str) -> str:
    """The sections of options."""
    return re.split(r"^[A-Z][a-z ]+:$", text, maxsplit=1, flags=re.MULTILINE)[-1]


def printed_all(name: str) -> str:
    return CliRunner().invoke(cli, [name, "--help", "all"], terminal_width=WIDTH).output


def test_options_have_one_head() -> None:
    named = [option for options in HEADS.values() for option in options]
    assert len(named) == len({*named}) and not {*named} & COMMON


@pytest.mark.parametrize("name", COMMANDS)
def test_limits_are_numbers(name: str) -> None:
    """A range without ends is printed as one up to None."""
    assert "None" not in printed(name)


@pytest.mark.parametrize("name", COMMANDS)
def test_commands_take_few_arguments(name: str) -> None:
    """Options that belong together are one record."""
    command = cli.commands[name].callback
    assert command
    assert len(inspect.signature(command).parameters) <= 9


def test_help_loads_click_and_the_command_line_only(tmp_path: Path) -> None:
    """No module of a command. Modules are counted, not seconds: a busy machine changes nothing."""
    code = (
        "import sys; before = set(sys.modules)\n"
        "from symoro_elastic.cli import cli; cli.main(['--help'], standalone_mode=False)\n"
        "print('loaded', *sorted(set(sys.modules) - before))"
    )
    ran = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=tmp_path)
    loaded = ran.stdout.splitlines()[-1].split()[1:]
    assert {name.split(".")[0] for name in loaded} - sys.stdlib_module_names <= {"click", "symoro_elastic"}
    ours = [name.split(".")[1] for name in loaded if name.startswith("symoro_elastic.")]
    assert set(ours) == {"cli", "foundation", "machine"}
    of_machines = {name for name in loaded if name.startswith("symoro_elastic.machine.")}
    assert of_machines == {"symoro_elastic.machine.format_names"}
    ground = {name for name in loaded if name.startswith("symoro_elastic.foundation.")}
    assert ground == {f"symoro_elastic.foundation.{name}" for name in ("errors", "version")}
    commands = {name for name in loaded if name.startswith("symoro_elastic.cli.")}
    assert commands == {f"symoro_elastic.cli.{name}" for name in ("listed", "sectioned_group")}


CALLED = """
import os, sys
from symoro_elastic import cli
sys.argv[1:] = ["--version"]
try:
    cli.main()
except SystemExit:
    print(os.environ["OPENBLAS_NUM_THREADS"])
"""


def test_linear_algebra_has_one_thread_unless_the_user_says_otherwise() -> None:
    for chosen, used in (({}, "1"), ({"OPENBLAS_NUM_THREADS": "3"}, "3")):
        environment = {key: x for key, x in os.environ.items() if key != "OPENBLAS_NUM_THREADS"} | chosen
        done = subprocess.run(
            [sys.executable, "-c", CALLED], env=environment, capture_output=True, text=True, check=True
        )
        assert done.stdout.splitlines()[-1] == used
