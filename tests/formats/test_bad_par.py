"""What is wrong with a .par file is said in one line that names file, joint and key; old habits are read."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from symoro_elastic.formats import read_machine
from symoro_elastic.formats.par import reading as par
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.checks import check
from symoro_elastic.machine.machine import Kind, Machine
from symoro_elastic.models.packaging import reserved_words
from symoro_elastic.models.programs.catalogue import MODELS
from tests.formats.test_bad_toml import damaged
from tests.machine.samples import PAR


def message(text: str) -> str:
    with pytest.raises(InputError) as caught:
        check(par.read(text, "arm.par"), reserved_words(), MODELS)
    said = str(caught.value)
    assert said.startswith("arm.par: ") and "\n" not in said and len(said) < 500
    return said.removeprefix("arm.par: ")


BAD = [
    ("d = {0, 0, 0.1}", "d = {0, 0, __import__('os')}", "joint 3 (j3), d", "not arithmetic"),
    ("d = {0, 0, 0.1}", "d = {0, 0, exec(1)}", "joint 3 (j3), d", "not a function"),
    ("d = {0, 0, 0.1}", "d = {0, 0, a.b}", "joint 3 (j3), d", "not arithmetic"),
    ("d = {0, 0, 0.1}", "d = {0, 0, 10^10^10}", "joint 3 (j3), d", "whole number"),
    ("d = {0, 0, 0.1}", "d = {0, 0, os.system(1)}", "joint 3 (j3), d", "not arithmetic"),
    ("d = {0, 0, 0.1}", f"d = {{0, 0, {'1+' * 600}1}}", "joint 3 (j3), d", "characters"),
    ("d = {0, 0, 0.1}", "d = {0, 0, q2}", "joint 3 (j3), d", "variable of joint 2 (j2)"),
    ("d = {0, 0, 0.1}", "d = {0, 0, 1/0}", "joint 3 (j3), d", "no value"),
    ("d = {0, 0, 0.1}", "d = {0, 0, int}", "parameters", "keyword"),
    ("d = {0, 0, 0.1}", "d = {0, 0}", "d", "has 2 entries, expected 3"),
    ("d = {0, 0, 0.1}", "d = {0, , 0.1}", "d", "entry 2 is empty"),
    ("d = {0, 0, 0.1}", "d = {}", "d", "has 0 entries"),
    ("d = {0, 0, 0.1}", "d = 0", "d", "list in braces"),
    ("d = {0, 0, 0.1}", "d = {0, 0, 0.1", "d", "not closed"),
    ("d = {0, 0, 0.1}", "d = {0, 0, 0.1} 5", "line 8", "is not an entry"),
    ("d = {0, 0, 0.1}", "D = {0, 0, 0.1}\nd = {0, 0, 0.1}", "d", "given twice"),
    ("d = {0, 0, 0.1}", "dd = {0, 0, 0.1}", "dd", "did you mean 'd'"),
    ("alpha", "alhpa", "alhpa", "did you mean 'alpha'"),
    ("alpha", "a" * 1000, "a" * 60, "no such key"),
    ("M = {0, M2, 0}", "M = {0, M2}", "M", "has 2 entries, expected 3 (NL)"),
    ("eta = {0, 1, 0}", "eta = {0, 1}", "eta", "has 2 entries, expected 3 (NJ)"),
    ("eta = {0, 1, 0}", "eta = {0, 2, 0}", "joint 2 (j2), eta", "0 or 1"),
    ("eta = {0, 1, 0}", "eta = {0, 1, 1}", "joint 3 (j3), eta", "fixed frame"),
    ("eta = {0, 1, 0}", "eta = {0, 1, 0}\nmu = {2, 1, 0}", "joint 1 (j1), mu", "0 or 1"),
    ("G = {0, 0, -9.81}", "G = {0, -9.81}", "G", "expected 3"),
    ("G = {0, 0, -9.81}", "Z = {0, -9.81}", "Z", "expected 16"),
    ("NL = 3\n", "", "NL", "missing"),
    ("NL = 3", "NL = three", "NL", "whole number"),
    ("NL = 3", "NL = 99999999999999999999", "NL", "whole number"),
    ("NL = 3", "NL =", "NL", "one number"),
    ("NL = 3", "NL = {3}", "NL", "one number"),
    ("NJ = 3", "NJ = 2", "NJ", "too few"),
    ("NJ = 3", "NJ = 3\nNF = 4", "NF", "2 NJ - NL = 3"),
    ("NJ = 3", "NJ = 3\nis_mobile = maybe", "is_mobile", "0 or 1"),
    ("Type = 0", "Type = 7", "Type", "must be 0"),
    ("ant = {0, 1, 2}\n", "", "ant", "missing"),
    ("sigma = {0, 1, 2}\n", "", "sigma", "missing"),
    ("ant = {0, 1, 2}", "ant = {0, 1, 3}", "joint 3 (j3), antecedent", "closed loops"),
    ("ant = {0, 1, 2}", "ant = {0, x, 2}", "joint 2 (j2), ant", "whole number"),
    ("sigma = {0, 1, 2}", "sigma = {0, 5, 2}", "joint 2 (j2), sigma", "must be 0"),
    ("sigma = {0, 1, 2}", "sigma = {1, 1, 2}", "joint 1 (j1), r", "'q1' is in theta, which is for sigma = 0"),
    ("theta = {q1, 0, 0}", "theta = {0, 0, 0}", "joint 1 (j1), theta", "no joint variable in '0', where sigma = 0"),
    ("theta = {q1, 0, 0}", "theta = {q1 + L1, 0, 0}", "joint 1 (j1), theta", "any of L1, q1"),
    ("theta = {q1, 0, 0}", "theta = {2*q1, 0, 0}", "joint 1 (j1), theta", "plus a constant"),
    ("theta = {q1, 0, 0}", "theta = {q2, 0, 0}", "joint 2 (j2), joint variable", "taken by joint 1"),
    ("k = {0, K2, 0}", "", "joint 2 (j2), stiffness", "needs a stiffness"),
    ("k = {0, K2, 0}", "k = {0, -5, 0}", "joint 2 (j2), stiffness", "negative"),
    ("Type = 0", "Type = 0 (* never closed", "line 4", "never closed"),
    ("Type = 0", "(*! nmae = x *)", "(*! nmae *)", "did you mean 'name'"),
    ("Type = 0", "(*! name *)", "(*! ... *)", "is not an entry"),
    ("Type = 0", "(*! name = int *)", "name", "keyword"),
    ("Type = 0", "(*! name = {a} *)", "name", "must be a text"),
    ("Type = 0", "(*! names = {a, b} *)", "(*! names *)", "list of 3 names"),
    ("Type = 0", "(*! names = {a, b, b} *)", "joint 3 (b), name", "taken by joint 2"),
    ("Type = 0", "(*! values = {M3 = 1} *)", "parameters", "did you mean 'M2'"),
    ("Type = 0", "(*! values = {M2 = 1/} *)", "parameters, M2", "ends too early"),
    ("Type = 0", "(*! values = {M2 = K2} *)", "parameters, M2", "holds names"),
    ("Type = 0", "(*! values = {M2} *)", "(*! values *)", "must be a table"),
    ("Type = 0", "(*! values = {M2 = 1 *)", "(*! values *)", "comma or } is missing"),
    ("Type = 0", "(*! values = {M2 = } *)", "(*! values *)", "value is missing"),
    ("Type = 0", "(*! values = {M2 = 1, M2 = 2} *)", "(*! values *)", "given twice"),
    ("Type = 0", "(*! values = {M2 = 1, K2} *)", "(*! values *)", "mixes"),
    ("Type = 0", "(*! values = {M2 = -1} *)", "joint 2 (j2), mass", "negative"),
    ("Type = 0", f"(*! values = {'{' * 99} *)", "(*! values *)", "nested"),
    ("Type = 0", "(*! units = {M2 = m} x *)", "(*! units *)", "not expected"),
    ("Type = 0", "(*! units = {} *)\n(*! units = {} *)", "(*! units *)", "given twice"),
    ("Type = 0", '(*! units = {M2 = "\\q"} *)', "(*! units *)", "escape"),
    ("Type = 0", "(*! damping = {0, 1} *)", "(*! damping *)", "list of 3"),
    ("Type = 0", "(*! damping = {1, 0, 0} *)", "joint 1 (j1), damping", "only an elastic one"),
    ("Type = 0", "(*! neutral = {0, a.b, 0} *)", "joint 2 (j2), neutral", "not arithmetic"),
    ("Type = 0", "(*! central = {j9 = {0, 0, 0, 0, 0, 0, 0, 0, 0}} *)", "bodies", "no joint 'j9'"),
    ("Type = 0", "(*! central = {j2 = {0}} *)", "(*! central *)", "j2 must be a list of 9"),
    ("Type = 0", "(*! central = {j2 = {1, 0, 0, 0, 0, 0, 0, 0, 0}} *)", "joint 2 (j2), bodies", "does not agree"),
    ("Type = 0", "(*! scene = {models = {direct_dynamic}} *)", "scene, models", "did you mean 'direct_dynamics'"),
    ("Type = 0", "(*! scene = {modles = {}} *)", "scene, modles", "did you mean 'models'"),
    ("Type = 0", "(*! scene = {locked = {j3 = 0}} *)", "scene, locked, j3", "no variable to lock"),
    ("Type = 0", "(*toml nmae = 3 *)", "nmae", "did you mean 'name'"),
    ("Type = 0", "(*toml name = arm *)", "line 4, column 15", "not TOML"),
    ("Type = 0", "(*toml [parameters] *)\n\n(*toml M3 = , *)", "line 6, column 13", "not TOML"),
    ("Type = 0", "(*toml [parameters] *)\n(*toml M3 = 1 *)", "parameters", "did you mean 'M2'"),
    ("Type = 0", "(*toml joints = [{}] *)", "joints", "has 1 rows, expected 3"),
    ("Type = 0", "(*toml joints = [{sigma = 1}, {}, {}] *)", "joint 1 (j1), sigma", "remove one of the two"),
    ("Type = 0", "(*toml gravity = [0, 0, 1] *)", "gravity", "given by the list G too"),
    ("Type = 0", "(*toml [base] *)\n(*toml floating = 'rotation' *)", "base, floating", "add is_floating = 1"),
    ("Type = 0", "(*toml [loops] *)\n(*toml a = {} *)", "loops", "names 1 loops, expected 0"),
    ("Type = 0", "(*toml [motors] *)\n(*toml j9 = { ratio = 3 } *)", "motors", "did you mean"),
    (
        "Type = 0",
        "(*toml [springs] *)\n(*toml j2 = { stiffness = 3 } *)",
        "joint 2 (j2), springs, stiffness",
        "a list, too",
    ),
    ("Type = 0", "(*! notes = {a} *)\n(*toml notes = ['b'] *)", "notes", "move all to the first"),
]


@pytest.mark.parametrize(("old", "new", "place", "reason"), BAD, ids=[f"{new[:30]}" for _, new, _, _ in BAD])
def test_one_line_names_joint_and_key(old: str, new: str, place: str, reason: str) -> None:
    assert old in PAR
    said = message(PAR.replace(old, new, 1))
    assert said.startswith(f"{place}: ") and reason in said


OLD = """(* Robotname = 'arm' *)
NL = 3  (* bodies *)
NJ = 3 (* joints
on two lines *)
NF = 3
G = {0, 0, 0}
Type = 0 (* Simple *)
is_floating = 0
is_mobile = False

(* Geometric parameters *)
Ant = {0, (* base *) 1,
   2}
Sigma={0,1,2}
B={0,0,0}
D={0,0,0.1,}
Alpha = {
        0,Pi/2,atan2(0, 1)}
Gamma = {0,0,0} (* trees only *)
Mu = {1,1,0}
Theta = {q1, 0, 0}
R = {0, q2 - L2, 0}
Ia = {2.5e-3, 0, 0}
M = {0, M2, 0};
(*! values = {L2 = 0.35, M2 = 5} *)
"""


@pytest.mark.parametrize("mark", ["", "\ufeff"])
@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_old_files_are_read(end: str, mark: str, tmp_path) -> None:
    file = tmp_path / "old arm-2.par"
    file.write_bytes((mark + OLD.replace("\n", end)).encode())
    machine, warnings = read_machine(file)
    assert (machine.name, warnings) == ("arm", [])
    assert [joint.antecedent for joint in machine.joints] == [0, 1, 2]
    assert [joint.kind for joint in machine.joints] == [Kind.MOTOR, Kind.MOTOR, Kind.FIXED]
    assert [joint.alpha.text for joint in machine.joints] == ["0", "Pi/2", "atan2(0, 1)"]
    assert machine.joints[1].r.text == "-L2"
    assert machine.joints[0].rotor_inertia.value() == 2.5e-3
    assert {parameter.name: parameter.value.value() for parameter in machine.parameters} == {"L2": 0.35, "M2": 5}
    expected = ["bodies", "joints\non two lines", "Simple", "base", "trees only"]
    assert list(machine.origin.notes) == expected


def test_files_of_symoro_plus_are_read_whatever_their_encoding(tmp_path: Path) -> None:
    """The address in their header has an accented letter, in Latin-1 or the code page of Windows."""
    header = "(* rue de la Noë, 44072 Nantes \u2013 France *)\n"
    texts = []
    for encoding in ("utf-8", "cp1252"):
        file = tmp_path / f"{encoding}.par"
        file.write_bytes((header + PAR).encode(encoding))
        texts.append(read_machine(file)[0].origin.notes[0])
    assert texts == [header.strip("(* )\n")] * 2
    letter = tmp_path / "letter.par"
    letter.write_bytes(PAR.replace("q1", "q\xeb").encode("cp1252"))
    with pytest.raises(InputError, match=r"not arithmetic|is not expected|letters"):
        read_machine(letter)


@pytest.mark.parametrize(
    ("text", "file", "name"),
    [
        ("(* Robotname = 'RX90' *)\n", "a.par", "RX90"),
        ('(*Robotname="SR400 v2"*)\n', "a.par", "SR400_v2"),
        ("(* Robotname = '' *)\n", "a.par", "a"),
        ("(* Robotname = 'RX90' *)\n(*! name = mine *)\n", "a.par", "mine"),
        ("", "my__robot (1).par", "my_robot_1"),
    ],
)
def test_the_name_is_that_of_the_robot_else_of_the_file(text: str, file: str, name: str) -> None:
    machine = par.read(text + PAR, file)
    assert machine.name == name and check(machine) is not None
    again = par.read(par.write(machine), "other.par")
    assert again == replace(machine, source="other.par")
    assert par.write(machine).startswith(f"(* Robotname = '{name}' *)")


@pytest.mark.parametrize(
    ("text", "file", "origin"),
    [
        ("", "int.par", '(it is made of the name of the file, give another by (*toml name = "..." *))'),
        (
            "(* Robotname = 'int' *)\n",
            "a.par",
            "(it is made of Robotname = 'int', give another by (*toml name = \"...\" *))",
        ),
        ("(*! name = int *)\n", "a.par", "keyword of C, C++ or Python; 'int_' is free"),
    ],
)
def test_a_message_about_a_name_says_where_it_comes_from(text: str, file: str, origin: str) -> None:
    with pytest.raises(InputError) as caught:
        check(par.read(text + PAR, file), reserved_words())
    assert str(caught.value).startswith(f"{file}: name: the name 'int' cannot be used: ")
    assert str(caught.value).endswith(origin)


def test_lists_left_out_are_zero_and_joints_are_motors() -> None:
    machine = par.read("NL = 1\nant = {0}\nsigma = {0}\ntheta = {t1}", "2 arms.par")
    joint = machine.joints[0]
    assert machine.name == "m2_arms"
    assert (joint.name, joint.kind, joint.variable) == ("j1", Kind.MOTOR, "t1")
    assert joint.body.mass.is_zero and joint.d.is_zero
    assert check(machine) == []


def test_mu_zero_is_passive() -> None:
    assert par.read(PAR + "mu = {0, 1, 0}", "").joints[0].kind == Kind.PASSIVE


@pytest.mark.parametrize(
    ("theta", "d", "variable", "parameters"),
    [
        ("q1 + L1", "L1", "q1", ["L1"]),  # L1 stands elsewhere too
        ("L1*L3 + q1", "0", "q1", ["L1", "L3"]),  # q1 is the one that is added
        ("q1", "q1", "q1", []),
    ],
)
def test_the_variable_among_several_names(theta: str, d: str, variable: str, parameters: list[str]) -> None:
    text = f"NL = 1\nant = {{0}}\nsigma = {{0}}\ntheta = {{{theta}}}\nd = {{{d}}}"
    machine = par.read(text, "")
    assert machine.joints[0].variable == variable
    assert [parameter.name for parameter in machine.parameters] == parameters


def test_names_declared_are_no_variables() -> None:
    text = "NL = 1\nant = {0}\nsigma = {0}\ntheta = {q1 + L1}\n"
    for line in ("(*! parameters = {L1} *)", "(*! values = {L1 = 1} *)", "(*! units = {L1 = rad} *)"):
        assert par.read(text + line, "").joints[0].variable == "q1"


@pytest.mark.thorough
def test_long_lines_take_no_time() -> None:
    assert "is not an entry" in message("a" * 5_000_000)
    assert "never closed" in message("(*" * 2_000_000)
    assert "not closed" in message("ant = {" + "0," * 2_000_000)
    assert "no such key" in message("x" * 1_000_000 + " = 1")
    assert "whole number" in message("NL = " + " " * 1_000_000 + "x\nant={0}\nsigma={0}")
    assert "is not an entry" in message("NL = 1" + " " * 1_000_000 + "{")


@given(st.data())
@settings(max_examples=300, deadline=None)
def test_no_damage_raises_anything_else(data: st.DataObject) -> None:
    text = damaged(PAR + OLD.split("\n")[-2] if data.draw(st.booleans()) else OLD, data)
    try:
        check(par.read(text, "arm.par"), reserved_words(), MODELS)
    except InputError as error:
        assert str(error).startswith("arm.par: ") and "\n" not in str(error)
    else:
        assert isinstance(par.read(text, "arm.par"), Machine)


@given(st.text(max_size=200))
@settings(max_examples=200, deadline=None)
def test_garbage_raises_nothing_else(text: str) -> None:
    with pytest.raises(InputError):
        par.read(text, "arm.par")
