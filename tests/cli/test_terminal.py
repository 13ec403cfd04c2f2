"""What files hold never steers the terminal: errors, warnings, notes, tables, progress; and lines have an end."""

from __future__ import annotations

import ast
import io
import unicodedata
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

import symoro_elastic as se
from symoro_elastic.cli import output
from symoro_elastic.foundation.errors import InputError, printable
from symoro_elastic.foundation.results import Table
from tests.command_line import EXAMPLES, ended

ROOT = Path(__file__).parents[2]
ESCAPE = "\x1b]0;HIJACK\x07\x9b2J\u202e"
ESCAPED = r"\x1b]0;HIJACK\x07\x9b2J\u202e"
TWO_AXIS = EXAMPLES / "two_axis.toml"


def steers(character: str) -> bool:
    """Whether a character is a control character, half of one, a separator of lines, or turns the direction."""
    is_turning = unicodedata.bidirectional(character) in {"LRE", "RLE", "LRO", "RLO", "PDF", "LRI", "RLI", "FSI", "PDI"}
    return character not in "\n\t" and (unicodedata.category(character) in ("Cc", "Cs", "Zl", "Zp") or is_turning)


@pytest.mark.thorough
@given(st.text(st.characters()))
def test_printable_texts_steer_no_terminal_and_others_stay(text: str) -> None:
    shown = printable(text)
    assert not any(map(steers, shown)) and (shown == text) != any(map(steers, text))


def test_names_of_files_in_errors(tmp_path: Path) -> None:
    listed = tmp_path / "tests.toml"
    listed.write_text(f'[[tests]]\nfile = "{ESCAPE}.csv"\n'.replace("\x1b", "\\u001b").replace("\x07", "\\u0007")
                      .replace("\x9b", "\\u009b"), encoding="utf-8")  # fmt: skip
    found = ended("update", TWO_AXIS, listed)
    assert found.code == 2 and found.err.startswith("error: ") and f"{ESCAPED}.csv: " in found.err
    assert found.err.count("\n") == 1 and found.err == printable(found.err)
    with pytest.raises(InputError) as error:
        se.update(TWO_AXIS, listed)
    assert f"{ESCAPED}.csv: " in str(error.value) and ESCAPE not in str(error.value)


def test_the_name_of_a_file_that_is_no_text(tmp_path: Path) -> None:
    found = ended("show", tmp_path / "no\udcff text.toml")
    assert found.code == 2 and r"no\udcff text.toml: file: no such file" in found.err


def test_tables_notes_warnings_and_stages(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    output.print_table(Table((ESCAPE,), [(ESCAPE,)], ESCAPE))
    output.print_parts([ESCAPE])
    output.say(f"warning: {ESCAPE}")
    printed = capsys.readouterr()
    assert (printed.out + printed.err).count(ESCAPED) == 5
    assert printable(printed.out + printed.err) == printed.out + printed.err
    shown = io.StringIO()
    monkeypatch.setattr("sys.stderr", shown)
    monkeypatch.setattr(output, "_is_terminal", lambda _: True)
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setenv("FORCE_COLOR", "1")
    with output.staged_progress(f"[red]{ESCAPE}") as (announce, _):
        announce(f"[bold]{ESCAPE}")
    assert "[bold]" in shown.getvalue() and "\x1b]0" not in shown.getvalue() and "\x07" not in shown.getvalue()


def test_only_one_module_prints() -> None:
    """The one that lets nothing steer the terminal."""
    for path in sorted((ROOT / "symoro_elastic" / "cli").glob("*.py")):
        calls = [ast.unparse(node.func) for node in ast.walk(ast.parse(path.read_text())) if isinstance(node, ast.Call)]
        assert path.name == "output.py" or not {"print", "click.echo", "click.secho"} & {*calls}, path


def test_a_warning_is_said_once_and_not_as_often_as_its_formula_is_long(tmp_path: Path) -> None:
    machine = tmp_path / "arm.toml"
    text = (EXAMPLES / "planar_2r.toml").read_text(encoding="utf-8")
    machine.write_text(text.replace('mass = "m1"', f'mass = "{"+".join(["l1"] * 140)}"'), encoding="utf-8")
    said = ended("show", machine).err.splitlines()
    (line,) = (line for line in said if "l1 is in m" in line)
    assert len(line) < 250 and not any("more like these" in line for line in said)


def test_long_words_are_cut_in_warnings_as_in_errors(capsys: pytest.CaptureFixture[str]) -> None:
    output.say(f"warning: {'x' * 5000} is long")
    assert capsys.readouterr().err == f"warning: {'x' * 60}...{'x' * 60} is long\n"


@pytest.mark.thorough
def test_errors_have_an_end_whatever_they_quote() -> None:
    for text in ("x" * 90_000, "x " * 90_000, "\x1b" * 90_000):
        said = str(InputError(text, text, text))
        assert len(said) < 1500 and said.endswith(text[-1:].replace("\x1b", "x1b")) and "..." in said
    assert InputError("a", "b", "x" * 9000).what == "x" * 9000
