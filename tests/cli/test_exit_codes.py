"""How commands end: the exit codes of docs/exit_codes.md, whatever becomes of standard output."""

from __future__ import annotations

import re
import shlex
import signal
import subprocess
import sys
from pathlib import Path

import click
import pytest

from symoro_elastic.api.kinds import numbers
from symoro_elastic.cli import cli
from symoro_elastic.cli.options import WholeRange
from symoro_elastic.cli.sectioned_group import Failure
from symoro_elastic.generation import pipeline
from tests.command_line import EXAMPLES, Ended, ended, refused

ROOT = Path(__file__).parents[2]
TWO_R, TWO_AXIS = EXAMPLES / "planar_2r.toml", EXAMPLES / "two_axis.toml"
FULL = "error: standard output or a temporary file: cannot be written (No space left on device)"
PROGRAM = shlex.join([sys.executable, "-m", "symoro_elastic"])


def shell(line: str) -> Ended:
    """A line of bash, with {program} and {machine}; the exit code is that of the program."""
    text = line.format(program=PROGRAM, machine=shlex.quote(str(TWO_R))) + "; exit ${PIPESTATUS[0]}"
    done = subprocess.run(["bash", "-c", text], capture_output=True, text=True, check=False, cwd=ROOT)
    return Ended(done.returncode, done.stdout, done.stderr)


def test_the_page_lists_the_codes() -> None:
    page = (ROOT / "docs" / "exit_codes.md").read_text(encoding="utf-8")
    assert re.findall(r"^\| ([\d, ]+) \|", page, re.MULTILINE) == ["0", "1", "2", "130", "129, 143"]
    assert (128 + signal.SIGHUP, 128 + signal.SIGTERM) == (129, 143)


@pytest.mark.sampled(12)
@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ("{program} models >&-", (2, "error: standard output: is closed: nothing can be printed\n")),
        ("{program} models > /dev/full", (2, FULL)),
        ("{program} --help > /dev/full", (2, FULL)),
        ("{program} models | true", (0, "")),
        ("{program} equations {machine} | head -1", (0, "")),
        ("{program} models 2>&- | tail -1", (0, "")),
        ("CC=/bin/true {program} check {machine}", (2, "error: symoro-elastic: C compiler: /bin/true: wrote")),
    ],
)
def test_whatever_becomes_of_the_output(line: str, expected: tuple[int, str]) -> None:
    found = shell(line)
    code, said = expected
    assert (found.code, found.err[: len(said)]) == (code, said)
    assert found.err.count("\n") == (code == 2)


def test_ctrl_c_is_130_and_an_end_of_file_is_not(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object, **__: object) -> None:
        raise error

    monkeypatch.setattr(pipeline, "prepare", fail)
    error: BaseException = KeyboardInterrupt()
    assert ended("show", TWO_R).code == 130
    error = OSError(28, "No space left on device", "/tmp/x")
    assert ended("show", TWO_R) == Ended(2, "", "error: /tmp/x: cannot be written (No space left on device)\n")
    error = EOFError()
    with pytest.raises(Failure) as caught:
        ended("show", TWO_R)
    assert isinstance(caught.value.cause, EOFError)


# Numbers in options: by the rules of machine files


@pytest.mark.parametrize("written", ["1_000", "\u0661", "1e400", "nan", "inf", "0x10", "", "1,5", "M1", "1/0"])
def test_numbers_that_a_file_refuses_are_refused_in_options(written: str) -> None:
    said = refused("modes", TWO_AXIS, "--value", f"D4={written}")
    assert said.startswith(f"symoro-elastic: --value: 'D4={written}' is not NAME=NUMBER")
    assert "is not a number" in refused("compare", TWO_AXIS, "--duration", written)
    assert "is not a number" in refused("check", TWO_AXIS, "--seed", written)


def test_formulas_of_numbers_are_numbers() -> None:
    assert numbers(["q=-pi/2", "x = 1e-3"], "--at") == {"q": -1.5707963267948966, "x": 1e-3}
    assert WholeRange(0).convert("12345678901234567890", None, None) == 12345678901234567890
    assert "is not a whole number" in refused("check", TWO_AXIS, "--seed", "1.5")


@pytest.mark.parametrize(
    "options", ["--value D4=1 --value D4=2", "--at motor_x=0 --at motor_x=1", "--pd motor_x=1:1 --pd motor_x=1:2"]
)
def test_one_name_has_one_value(options: str) -> None:
    assert "is given twice: keep one" in refused("modes", TWO_AXIS, *options.split())
    assert numbers(["D4=1", "D4=1"], "--value") == {"D4": 1.0}


def test_no_option_of_one_value_is_given_twice() -> None:
    """Of any command: a flag may be, and an option that takes several values."""
    assert not refused_twice("show", "--json")
    for command in cli.commands.values():
        for option in command.params:
            if isinstance(option, click.Option) and not option.multiple and not option.is_flag:
                assert refused_twice(str(command.name), f"{option.opts[0]}=1") == f"symoro-elastic: {option.opts[0]}"


def refused_twice(command: str, option: str) -> str:
    """The place in the error that an option is given twice, if it is."""
    line = ended(command, TWO_R, option, option).err.removeprefix("error: ")
    return line.partition(": is given twice: keep one")[0] if "is given twice" in line else ""


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ("modes --along motor_x=0:1:1000000000", "--along: 1000000000 positions: name joints, and at most 10000"),
        ("modes --along motor_x=0:1:101 --along motor_y=0:1:100", "--along: 10100 positions"),
        ("modes --along motor_x=0:1:2.5", "give LOW:HIGH:COUNT"),
        ("response --band 1:2:300000", "--band: from 1 to 2 Hz in 300000 points"),
        ("response --band 1e-320:1e300:5", "--band: from 9.99989e-321 to 1e+300 Hz"),
        ("response --band 1e-300:1e300:5", "--band: from 1e-300 to 1e+300 Hz"),
        ("response --band 5:1:5", "--band: from 5 to 1 Hz"),
    ],
)
def test_grids_are_bounded_before_any_work(options: str, said: str) -> None:
    """Before the machine is read, which does not exist."""
    command, *more = options.split()
    assert said in refused(command, "none.toml", *more)


def test_latex_is_looked_for_before_any_work(monkeypatch: pytest.MonkeyPatch) -> None:
    """Before the machine is read, which does not exist."""
    monkeypatch.setenv("PATH", "")
    assert "no LaTeX is installed" in refused("equations", "none.toml", "--format", "pdf")


def test_long_words_of_the_user_are_cut_in_errors() -> None:
    found = ended("equations", TWO_AXIS, "--format", "x" * 3000)
    assert found.code == 2 and found.out == "" and found.err.count("\n") == 1
    assert "unknown 'xxx" in found.err and "...xxx" in found.err and len(found.err) < 300
