"""What is wrong with a TOML machine is said in one line that names file, joint and key."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from symoro_elastic.formats import read_machine, write_machine
from symoro_elastic.formats.toml import reading as toml
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.checks import check
from symoro_elastic.machine.machine import Machine
from symoro_elastic.models.packaging import reserved_words
from symoro_elastic.models.programs.catalogue import MODELS
from tests.machine.samples import TOML


def message(text: str) -> str:
    with pytest.raises(InputError) as caught:
        check(toml.read(text, "arm.toml"), reserved_words(), MODELS)
    said = str(caught.value)
    assert said.startswith("arm.toml: ") and "\n" not in said and len(said) < 500
    return said.removeprefix("arm.toml: ")


# What is replaced in the sample, by what, the place that must be named, and a word of the reason.
BAD = [
    # expressions are data
    ("d = 0.1", "d = \"__import__('os')\"", "joint 3 (tip), d", "not arithmetic"),
    ("d = 0.1", 'd = "a.b"', "joint 3 (tip), d", "not arithmetic"),
    ("d = 0.1", 'd = "10^10^10"', "joint 3 (tip), d", "whole number"),
    ("d = 0.1", 'd = "9^9999999999"', "joint 3 (tip), d", "exponent"),
    ("d = 0.1", 'd = "lambda: 0"', "joint 3 (tip), d", "not arithmetic"),
    ("d = 0.1", 'd = "L2[0]"', "joint 3 (tip), d", "not arithmetic"),
    ("d = 0.1", 'd = "exp(1)"', "joint 3 (tip), d", "there are sin"),
    ("d = 0.1", 'd = ""', "joint 3 (tip), d", "empty"),
    ("d = 0.1", 'd = "1 +"', "joint 3 (tip), d", "ends too early"),
    ("d = 0.1", 'd = "1e999"', "joint 3 (tip), d", "out of the range"),
    ("d = 0.1", "d = 1e999", "joint 3 (tip), d", "out of the range"),
    ("d = 0.1", 'd = "1/0"', "joint 3 (tip), d", "no value"),
    ("d = 0.1", 'd = "K2/(1 - 1)"', "joint 3 (tip), d", "division by zero"),
    ("d = 0.1", 'd = "K2*sqrt(-1)"', "joint 3 (tip), d", "no value"),
    ("d = 0.1", 'd = "sqrt(L2 - 1)"', "joint 3 (tip), d", "no value"),
    ("d = 0.1", 'd = "ÿ"', "joint 3 (tip), d", "not arithmetic"),
    ("d = 0.1", f'd = "{"(" * 200}1{")" * 200}"', "joint 3 (tip), d", "terms and signs"),
    ("d = 0.1", f'd = "{"(" * 60}1{")" * 60}"', "joint 3 (tip), d", "deeper"),
    ("d = 0.1", f'd = "{"1+" * 600}1"', "joint 3 (tip), d", "characters"),
    ("d = 0.1", f"d = 0x{'f' * 5000}", "file", "5002 characters"),
    ("d = 0.1", f"d = {'9' * 900}", "joint 3 (tip), d", "out of the range"),
    ("d = 0.1", f"d = {'9' * 5000}", "file", "5000 characters"),
    # types and lengths
    ("d = 0.1", "d = true", "joint 3 (tip), d", "must be a number"),
    ("d = 0.1", "d = [1]", "joint 3 (tip), d", "must be a number"),
    ("d = 0.1", "d = 1979-05-27", "joint 3 (tip), d", "must be a number"),
    ("d = 0.1", "d = nan", "joint 3 (tip), d", "not finite"),
    ("K2 = nan", "K2 = { value = nan }", "parameters, K2, value", "nan is not finite: leave out what is not known"),
    ("K2 = nan", 'K2 = { value = inf, unit = "N/m" }', "parameters, K2, value", "inf is not finite"),
    ("K2 = nan", "K2 = -inf", "parameters, K2", "-inf is not finite"),
    ("d = 0.1", "d = -inf", "joint 3 (tip), d", "not finite"),
    ("-9.81]", "nan]", "gravity", "not finite"),
    ("L2 = 0.35", "L2 = inf", "parameters, L2", "not finite"),
    ("L2 = 0.35", "L2 = true", "parameters, L2", "must be a number"),
    ("L2 = 0.35", 'L2 = "K2"', "parameters, L2", "holds names"),
    ("L2 = 0.35", 'L2 = "1/0"', "parameters, L2", "no value"),
    ("L2 = 0.35", "L2 = { val = 1 }", "parameters, L2, val", "did you mean 'value'"),
    ("L2 = 0.35", "L2 = { value = 1, unit = 2 }", "parameters, L2, unit", "text"),
    ("[0, 0, -9.81]", "[0, -9.81]", "gravity", "2 entries, expected 3"),
    ("[0, 0, -9.81]", '"down"', "gravity", "list"),
    ("inertia = [0.1, 0.2, 0.25]", "inertia = [1, 2]", "joint 2 (lift), inertia", "2 entries, expected 3 or 6"),
    (
        "inertia = [0.1, 0.2, 0.25]",
        "inertia_at_origin = [1, 2, 3]",
        "joint 2 (lift), center_of_mass",
        "are two alternatives",
    ),
    ("mass = 2.5", "mas = 2.5", "joint 2 (lift), mas", "did you mean 'mass'"),
    ("sigma = 1", "sigma = 1.0", "joint 2 (lift), sigma", "whole number"),
    ("sigma = 1", 'sigma = "1"', "joint 2 (lift), sigma", "whole number"),
    ("sigma = 1", "sigma = true", "joint 2 (lift), sigma", "whole number"),
    ("sigma = 1", f"sigma = {'1' * 100}", "joint 2 (lift), sigma", "too large"),
    ("joints = [", "joints = [ 1,", "joints", "list of tables"),
    ('name = "lift"', "name = 3", "joint 2, name", "text"),
    ('name = "arm"', 'name = ["arm"]', "name", "text"),
    ('name = "arm"', 'name = "arm"\nnotes = "x"', "notes", "list of texts"),
    ("[springs]\nlift = {", "[springs]\nlift = 3 #", "springs, lift", "table"),
    # keys and names
    ("[springs]", "[spring]", "spring", "did you mean 'springs'"),
    ("alpha =", "alfa =", "joint 2 (lift), alfa", "did you mean 'alpha'"),
    ('kind = "elastic"', 'kind = "elastc"', "joint 2 (lift), kind", "did you mean 'elastic'"),
    ('kind = "elastic", ', "", "joint 2 (lift), kind", "missing"),
    ("sigma = 1, ", "", "joint 2 (lift), sigma", "missing"),
    ('name = "lift", ', "", "joint 2, name", "missing"),
    ("[springs]\nlift", "[springs]\nlfit", "springs", "did you mean 'lift'"),
    ('name = "tip"', 'name = "tip", antecedent = "lifft"', "joint 3 (tip), antecedent", "did you mean 'lift'"),
    ('name = "tip"', 'name = "tip", antecedent = "tip"', "joint 3 (tip), antecedent", "closed loops"),
    ('name = "lift"', 'name = "lift", antecedent = 3', "joint 2 (lift), antecedent", "closed loops"),
    ('name = "tip"', 'name = "tip", antecedent = -1', "joint 3 (tip), antecedent", "must be 0"),
    ('name = "tip"', 'name = "lift"', "joint 3 (lift), name", "taken by joint 2"),
    ("L2 = 0.35", "L2 = 0.35\nq1 = 1", "joint 1 (base_yaw), theta", "no joint variable"),
    ('theta = "q1"', 'theta = "q2"', "joint 2 (lift), joint variable", "taken by joint 1"),
    ("K2 = nan", "K2 = nan\nint = 1", "parameters", "keyword"),
    ("K2 = nan", "K2 = nan\ntau = 1", "parameters", "generated code"),
    ("K2 = nan", 'K2 = nan\n"a b" = 1', "parameters", "letters"),
    ("K2 = nan", "K2 = nan\n_k = 1", "parameters", "letters"),
    ('name = "tip"', 'name = "a.b\\n"', "joint 3", "letters"),
    ('theta = "q1"', 'theta = "qd1"', "joint 1 (base_yaw), joint variable", "intermediate"),
    ('name = "arm"', 'name = "numpy"', "name", "which the generated package would hide; 'numpy_' is free"),
    ('name = "arm"', 'name = "platform"', "name", "which the generated package would hide; 'platform_' is free"),
    ('name = "arm"', 'name = "setup"', "name", "which the generated package would hide; 'setup_' is free"),
    ('name = "arm"', 'name = "symoro_elastic"', "name", "which the generated package would hide"),
    ('name = "arm"', 'name = "Aux"', "name", "Windows has a device of this name, and no file; 'Aux_' is free"),
    ('name = "arm"', 'name = "com1"', "name", "Windows has a device of this name, and no file; 'com1_' is free"),
    # the joint variable
    ('theta = "q1"', "theta = 0", "joint 1 (base_yaw), theta", "no joint variable"),
    ('theta = "q1"', 'r = "q1"', "joint 1 (base_yaw), theta", "'q1' is in r, which is for sigma = 1"),
    (
        'theta = "q1"',
        'theta = "q1 + L1"',
        "joint 1 (base_yaw), theta",
        'the cell holds q1 and L1, both new: write variable = "L1"; parameters are declared',
    ),
    ('theta = "q1"', 'theta = "2*q1"', "joint 1 (base_yaw), theta", "plus a constant"),
    ('theta = "q1"', 'theta = "-q1"', "joint 1 (base_yaw), theta", "plus a constant"),
    ('theta = "q1"', 'theta = "pi/2 - q1"', "joint 1 (base_yaw), theta", "plus a constant"),
    ('theta = "q1"', 'theta = "q1 + q1"', "joint 1 (base_yaw), theta", "plus a constant"),
    ('theta = "q1"', 'theta = "sin(q1)"', "joint 1 (base_yaw), theta", "plus a constant"),
    # meaning
    ("d = 0.1", 'd = "L3"', "joint 3 (tip), d", "'L3' is not declared in [parameters]; did you mean 'L2'?"),
    ("d = 0.1", 'd = "q1"', "joint 3 (tip), d", "variable of joint 1 (base_yaw)"),
    ("-9.81]", '"G3"]', "gravity z", "not declared"),
    ("sigma = 1", "sigma = 3", "joint 2 (lift), sigma", "must be 0"),
    ('kind = "fixed"', 'kind = "fixed", sigma = 0, theta = "q3"', "joint 3 (tip), kind", "fixed"),
    ('kind = "fixed"', 'kind = "motor", sigma = 2', "joint 3 (tip), kind", "sigma = 2"),
    ('stiffness = "K2", ', "", "joint 2 (lift), stiffness", "needs a stiffness"),
    ('stiffness = "K2"', "stiffness = 0.0", "joint 2 (lift), stiffness", "needs a stiffness"),
    ("[springs]", "[springs]\nbase_yaw = { neutral = 1 }", "joint 1 (base_yaw), neutral", "the motor has no spring"),
    ("mass = 2.5", "mass = -2.5", "joint 2 (lift), mass", "negative"),
    ("mass = 2.5", 'mass = "L2 - 1"', "joint 2 (lift), mass", "negative"),
    ('stiffness = "K2"', "stiffness = -1", "joint 2 (lift), stiffness", "negative"),
    ("damping = 3", "damping = -3", "joint 2 (lift), damping", "negative"),
    ("viscous = 1", "viscous = -1", "joint 1 (base_yaw), viscous friction", "negative"),
    ("coulomb = 2", "coulomb = 2, load = 0.9", "joint 1 (base_yaw), load friction", "must be below 0.9"),
    ("coulomb = 2", "coulomb = 2, static = 3", "joint 1 (base_yaw), static, stribeck", "give both, or none"),
    ("coulomb = 2", "coulomb = 2, bristle = 9", "joint 1 (base_yaw), bristle_damping", "give it with bristle"),
    ("coulomb = 2", "bristle = 9, bristle_damping = 1", "joint 1 (base_yaw), bristle", "no coulomb friction"),
    (
        "coulomb = 2",
        "coulomb = 2, creep = 1e-3, bristle = 9, bristle_damping = 1",
        "joint 1 (base_yaw), bristle, creep",
        "keep one",
    ),
    ("coulomb = 2", "coulomb = -2", "joint 1 (base_yaw), coulomb friction", "negative"),
    ("rotor_inertia = 0.5", "rotor_inertia = -0.5", "joint 1 (base_yaw), rotor_inertia", "negative"),
]


@pytest.mark.sampled(2)
@pytest.mark.parametrize(("old", "new", "place", "reason"), BAD, ids=[f"{new[:30]}" for _, new, _, _ in BAD])
def test_one_line_names_joint_and_key(old: str, new: str, place: str, reason: str) -> None:
    assert old in TOML
    said = message(TOML.replace(old, new, 1))
    assert said.startswith(f"{place}") and reason in said


def test_the_sample_itself_is_good() -> None:
    assert check(toml.read(TOML, "arm.toml")) == []
    assert check(toml.read(TOML.replace("\n", "\r\n"), "arm.toml")) == []


def test_every_line_break_and_bracket_of_toml_is_reported_with_its_line() -> None:
    assert message(TOML.replace("K2 = nan", "K2 = nan nan")).startswith("line 11, column ")
    assert "not TOML" in message("joints = [")
    assert "not TOML" in message("\x00\x01")
    assert "nested too deeply" in message(f"notes = {'[' * 5000}")
    assert "no joint" in message("name = 'arm'")


@pytest.mark.parametrize("part", ["a", '"a,b"', "1", "'.'"])
def test_keys_of_many_parts_take_no_time(part: str) -> None:
    dotted = ".".join([part] * 100_000)
    assert "more than 8 dots" in message(f"{dotted} = 1")
    assert "more than 8 dots" in message(f"[{dotted}]")


def test_dots_in_texts_and_comments_are_free() -> None:
    text = 'notes = ["a.b.c.d.e.f.g.h.i.j.k.l", '
    text += '\'1.2.3.4.5.6.7.8.9.10.11\', """a.\nb\\"""c.d.e.f.g.h.i.j.k"""]  # .........\n'
    assert len(toml.read(text + TOML, "").origin.notes) == 3


@pytest.mark.parametrize("offset", ["q1", "(q1)", "+q1", "q1+0"])
def test_a_variable_alone(offset: str) -> None:
    joint = toml.read(TOML.replace('"q1"', f'"{offset}"'), "").joints[0]
    assert joint.variable == "q1" and joint.theta.is_zero


@pytest.mark.parametrize(
    ("cell", "offset"),
    [
        ("q1 + pi/2", "pi/2"),
        ("pi/2 + q1", "pi/2"),
        ("q1 - L2", "-L2"),
        ("(q1 - L2)", "-L2"),
        ("L2*(3 - K2) + q1 - 2e3", "L2*(3 - K2) - 2e3"),
        ("-L2 + q1", "-L2"),
    ],
)
def test_a_variable_with_an_offset(cell: str, offset: str) -> None:
    joint = toml.read(TOML.replace('"q1"', f'"{cell}"'), "").joints[0]
    assert (joint.variable, joint.theta.text) == ("q1", offset)


def test_files_that_cannot_be_read(tmp_path: Path) -> None:
    cases = {
        "missing.toml": (None, "file: no such file"),
        "huge.toml": (b'name = "' + b"a" * 10_000_000 + b'"', "file: larger than 5 MB"),
        "latin.toml": ("# ü\r\nname = 'é'".encode("latin-1"), "line 1, column 3: the byte 0xfc is not UTF-8"),
        "half.toml": ("# ü\r\nname = 'é'".encode()[:-2], "line 2, column 9: the byte 0xc3 is not UTF-8"),
        "garbage.toml": (bytes(range(256)), "line 3, column 115: the byte 0x80 is not UTF-8"),
        "windows.toml": ("name = 'a'".encode("utf-16"), "line 1, column 1: the file is UTF-16 text"),
        "windows.par": ("NL = 1".encode("utf-16"), "line 1, column 1: the file is UTF-16 text"),
        "garbage.par": (b"(* \x81 *)", "line 1, column 4: the byte 0x81 is not UTF-8"),
        "arm.json": (b"{}", "file: the suffix '.json' is not a machine format: use .toml, .par, .urdf, .xml or .csv"),
        "arm": (b"", "file: the suffix '' is not a machine format"),
    }
    for name, (content, reason) in cases.items():
        path = tmp_path / name
        if content is not None:
            path.write_bytes(content)
        with pytest.raises(InputError) as caught:
            read_machine(path)
        assert str(caught.value).startswith(f"{path}: {reason}")
        assert "\n" not in str(caught.value)


def test_a_folder_is_no_file(tmp_path: Path) -> None:
    (tmp_path / "folder.toml").mkdir()
    with pytest.raises(InputError, match="is not a file"):
        read_machine(tmp_path / "folder.toml")
    with pytest.raises(InputError, match="cannot be written"):
        write_machine(toml.read(TOML, ""), tmp_path / "folder.toml")
    with pytest.raises(InputError, match="no such file"):
        read_machine("a\0b.toml")


def test_a_byte_order_mark_is_no_harm(tmp_path: Path) -> None:
    (tmp_path / "arm.toml").write_bytes(b"\xef\xbb\xbf" + TOML.encode())
    assert read_machine(tmp_path / "arm.toml")[0].name == "arm"


@given(st.data())
@settings(max_examples=300, deadline=None)
def test_no_damage_raises_anything_else(data: st.DataObject) -> None:
    text = damaged(TOML, data)
    try:
        check(toml.read(text, "arm.toml"), reserved_words(), MODELS)
    except InputError as error:
        assert str(error).startswith("arm.toml: ") and "\n" not in str(error)
    else:
        assert isinstance(toml.read(text, "arm.toml"), Machine)


def damaged(text: str, data: st.DataObject) -> str:
    """The text with a part cut out, doubled, or replaced by something odd."""
    start = data.draw(st.integers(0, len(text)))
    end = data.draw(st.integers(start, min(len(text), start + 30)))
    odd = ["", "\n", "0", "-1", "nan", '"', "[", "]", "{", "}", "=", ",", "q1", "(*", "*)", "(*!", "\x00", "é", "1e999"]
    middle = data.draw(st.one_of(st.sampled_from(odd), st.text(max_size=6), st.just(text[start:end] * 2)))
    return text[:start] + middle + text[end:]
