"""Every option of every command, with a value that it cannot have: the message names the option as it was typed."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

import click
import pytest

import symoro_elastic as se
from symoro_elastic import cli
from symoro_elastic.cli.options import DeclaredOption, InputFile, Output
from symoro_elastic.foundation.errors import InputError
from tests.command_line import EXAMPLES, ended, refused

MACHINE, SCENE = EXAMPLES / "planar_2r.toml", EXAMPLES / "scenes" / "planar_2r_move.toml"
LIMITS = ("--position", "1", "--velocity", "1", "--acceleration", "5")
NEEDED = {
    "excite": (*LIMITS, "--out", "e.csv"),
    "view": ("--out", "page.html"),
    "report": ("--out", "page.html"),
    "convert": ("other.toml",),
    "simulate": ("--scene", str(SCENE)),
    "reduce": ("--scene", str(SCENE)),
    "ladder": ("--scene", str(SCENE)),
    "sweep": ("--over", "m2=1,2"),
    "identify": ("data.csv",),
    "ik": ("--position", "0.5,0.5,0"),
    "update": ("tests.toml", "--seek", "m1"),
    "lobes": ("--direction", "tip.x", "--cutting", "1e9"),
}
"""What a command does not do without."""
PROGRAMS = {"--compiler", "--compiler-flags", "--scheduler"}
"""Texts that go elsewhere as they are."""


@pytest.fixture(autouse=True)
def _in_an_empty_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    rows = [f"{k / 100},{math.sin(k / 9)},{math.sin(k / 7)},{k % 3},{k % 2}" for k in range(200)]
    (tmp_path / "data.csv").write_text("\n".join(["t,q_shoulder,q_elbow,tau_shoulder,tau_elbow", *rows]))
    (tmp_path / "tests.toml").write_text('[[tests]]\nfile = "hammer.csv"\n')
    rows = [f"{k},{k % 7},{k % 5}" for k in range(1, 20)]
    (tmp_path / "hammer.csv").write_text("\n".join(["f [Hz],re tip.ax/tip.fx,im tip.ax/tip.fx", *rows]))
    monkeypatch.chdir(tmp_path)


def wrong_values() -> Iterator[tuple[str, str, str]]:
    """Command, option and a value: an unknown name, a text for a number, a number out of range."""
    for name, command in cli.cli.commands.items():
        for one in command.params if any(p.name == "machine" for p in command.params) else ():
            if isinstance(one, DeclaredOption) and not one.is_flag and one.opts[0] not in PROGRAMS:
                yield from ((name, one.opts[0], value) for value in _wrong(name, one))


def _wrong(command: str, one: DeclaredOption) -> tuple[str, ...]:
    if isinstance(one.type, (InputFile, Output)):
        return ()  # the message begins with the path
    if isinstance(one.type, click.types.FloatParamType | click.types.IntParamType):
        return ("nonsense",)
    if "MODEL" in one.row.metavar:
        return ("nonsense", "nonsense=tool", "jacobian=nonsense")
    if "=" in one.row.metavar:
        return ("nonsense=1", "nonsense", "nonsense=1:x")
    return ("nonsense",)


@pytest.mark.sampled(30)
@pytest.mark.parametrize(("command", "option", "value"), list(wrong_values()), ids=str)
def test_a_message_names_the_option_that_was_typed(command: str, option: str, value: str) -> None:
    needed = [*NEEDED.get(command, ()), *(("--radial", "6e8") if option == "--across" else ())]
    if option in needed:
        del needed[needed.index(option) : needed.index(option) + 2]
    found = ended(command, MACHINE, *needed, option, value)
    assert found.code == 2 and option in found.err and found.err.startswith("error: "), found


ODD = (
    *("", " ", ",", ",,", "1,,0", "nan", "nan,0,0", "1e999,0,0", "1/0", "=", "=1", "x=", "x=nan", "x=1:2:nan"),
    *("x=1:2:-1", "x=1:2:1e9,log", "x=,", ":", "1:", ":nan", "x==1", "[", "'", "x=(1", "1,2,3,4", "\u00e9=1"),
    *("x=1 kg m/", "a by", "a by b="),
)


def parsed_options() -> dict[str, DeclaredOption]:
    """Options whose texts are parsed, each once, by its flag and kind."""
    params = [one for command in cli.cli.commands.values() for one in command.params]
    declared = [one for one in params if isinstance(one, DeclaredOption) and one.row.kind.parse]
    return {f"{one.opts[0]} {one.row.metavar}": one for one in declared}


@pytest.mark.parametrize("name", parsed_options())
def test_no_text_of_an_option_ends_in_another_error(name: str) -> None:
    one = parsed_options()[name]
    assert one.row.kind.parse is not None
    for text in ODD:
        try:
            one.row.kind.parse((text,) if one.row.kind.many else text, one.opts[0])
        except InputError as error:
            assert one.opts[0] in str(error), (text, error)


@pytest.mark.sampled(2)
@pytest.mark.parametrize(
    ("given", "said"),
    [
        (("generate", MACHINE, "--model", "inertia_matrx"), "--model: no model 'inertia_matrx'; did you mean"),
        (("check", MACHINE, "--fold", "m3"), "--fold: no parameter 'm3'; did you mean 'm2'?"),
        (("equations", MACHINE, "--only", "jacobian=elbw"), "--only, jacobian: no frame 'elbw'; did you mean 'elbow'?"),
        (("response", MACHINE, "--input", "elbow.Fx"), "--input: 'elbow.Fx' is not NAME.QUANTITY"),
        (("response", MACHINE, "--input", "elbow.Fx"), "; did you mean 'elbow.fx'?"),
        (("modes", MACHINE, "--value", "m3=1"), "--value: no parameter 'm3'; did you mean 'm2'?"),
        (("feed-forward", MACHINE, "--start", "elbw=1"), "--start: no moving joint 'elbw'; did you mean 'elbow'?"),
        (("generate", MACHINE, "--target", "fmu", "--start", "elbw=1"), "--start: no moving joint 'elbw'"),
        (
            ("excite", MACHINE, *LIMITS, "--out", "e.csv", "--known", "MX22"),
            "--known, MX22: there is no such parameter",
        ),
    ],
)
def test_messages_name_the_option_and_what_may_be_meant(given: tuple[object, ...], said: str) -> None:
    assert said in refused(*given)


def test_in_python_the_argument_is_named() -> None:
    for wrong, said in (
        ({"scene": {"models": ["inertia_matrx"]}}, "scene, models: no model"),
        ({"fold": ["m3"]}, r"fold: no parameter 'm3'"),
        ({"only": {"jacobian": ["elbw"]}}, r"only, jacobian: no frame 'elbw'"),
    ):
        with pytest.raises(se.InputError, match=said):
            se.equations(MACHINE, "jacobian", **wrong)
    with pytest.raises(se.InputError, match=r"inputs: 'elbow\.Fx' is not NAME\.QUANTITY.*did you mean 'elbow\.fx'"):
        se.response(MACHINE, inputs=["elbow.Fx"])
    with pytest.raises(se.InputError, match=r"values: no parameter 'm3'"):
        se.modes(MACHINE, values={"m3": 1.0})
