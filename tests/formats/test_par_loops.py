"""Closed loops and couplings in .par files: how they are read, written back, and refused in one line."""

from __future__ import annotations

import re
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from symoro_elastic.formats.par import reading as par
from symoro_elastic.formats.par.columns import owned_names
from symoro_elastic.formats.toml import reading as toml
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.checks import check
from symoro_elastic.machine.described import DescribedMachine
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.loops import Closing, Loop
from symoro_elastic.machine.machine import Joint, Kind, Machine, Parameter
from tests.closed_chains.machines import FILES, reordered
from tests.formats.test_bad_par import message
from tests.machine.samples import PAR, PAR_LOOP, numbers

pytestmark = pytest.mark.sampled(5)

TOML_LOOP = """
name = "four_bar"
gravity = [0, -9.81, 0]
joints = [
  { name = "j1", antecedent = 0, kind = "motor", sigma = 0, theta = "qm" },
  { name = "j2", antecedent = 1, kind = "elastic", sigma = 0, theta = "d1" },
  { name = "j3", antecedent = 2, kind = "passive", sigma = 0, d = "L1", theta = "q3" },
  { name = "j4", antecedent = 0, kind = "passive", sigma = 0, d = "L0", theta = "q4" },
  { name = "j5", antecedent = 0, kind = "coupled", sigma = 0, d = 0.1, theta = "N5*qm" },
  { name = "j6", antecedent = 4, kind = "cut", sigma = 0, d = "L3", theta = "q6" },
  { name = "j7", antecedent = 3, kind = "fixed", sigma = 2, gamma = "pi/2", d = "L2" },
]
[loops]
loop_1 = { cut = "j6", meets = "j7", start = { qm = 1.0, d1 = 0, q3 = -0.6, q4 = 1.4, q6 = "pi/4" } }
[parameters]
K1 = nan
L1 = 0.1
L0 = 0.3
N5 = nan
ZZ5 = nan
L3 = 0.2
L2 = 0.35
[bodies]
j1 = { mass = 1, first_moments = [0, 0, 0], inertia_at_origin = [0, 0.1, 0.1] }
j2 = { mass = 2, first_moments = [0, 0, 0], inertia_at_origin = [0, 0.2, 0.2] }
j3 = { mass = 3, first_moments = [0, 0, 0], inertia_at_origin = [0, 0.3, 0.3] }
j4 = { mass = 4, first_moments = [0, 0, 0], inertia_at_origin = [0, 0.4, 0.4] }
j5 = { mass = 5, first_moments = [0, 0, 0], inertia_at_origin = [0, 0, "ZZ5"] }
[springs]
j2 = { stiffness = "K1*(2 + qm)" }
[motors]
j1 = { rotor_inertia = 0.5 }
"""


def loop_of(line: str) -> Loop:
    return par.read(f"{PAR_LOOP}{line}\n", "arm.par").loops[0]


def the_same_after_writing(machine: Machine) -> str:
    """The .par text of a machine, which gives it back, directly and through TOML."""
    machine = DescribedMachine.of(machine)
    text = par.write(machine)
    assert par.read(text, machine.source) == machine
    assert par.write(par.read(text, machine.source)) == text
    assert toml.read(toml.write(machine), machine.source) == machine
    return text


def rows(text: str, key: str) -> list[str]:
    """The entries of a list in a .par text."""
    found = re.search(rf"^{key} *= {{(.*)}}$", text, re.MULTILINE)
    assert found
    return [entry.strip() for entry in found[1].split(",")]


def test_the_rows_tell_bodies_cut_joints_and_the_frames_they_meet() -> None:
    """NL bodies, then NJ - NL cut joints, then their other ends: the same machine as in TOML."""
    machine = par.read(PAR_LOOP, "four_bar.par")
    same = replace(toml.read(TOML_LOOP, "four_bar.par"), origin=machine.origin)
    assert machine == same
    assert machine.origin.extras == {"QP": "{QP1, QP2, QP3, QP4, QP5, QP6}"}
    assert check(machine) == []
    assert machine.dependent == (3, 4) and machine.independent == (1, 2)
    the_same_after_writing(machine)


def test_what_is_written_is_what_symoro_reads() -> None:
    """Lists of bodies have NL entries, of joints NJ, of frames NF."""
    text = the_same_after_writing(par.read(PAR_LOOP, "four_bar.par"))
    assert "NL = 5\nNJ = 6\nNF = 7\nType = 2\n" in text
    assert {len(rows(text, key)) for key in ("ant", "sigma", "b", "d", "theta", "mu")} == {7}
    assert {len(rows(text, key)) for key in ("XX", "M", "IA", "FV", "CZ")} == {5}
    assert {len(rows(text, key)) for key in ("eta", "k", "QP")} == {6}
    assert rows(text, "mu") == ["1", "1", "0", "0", "0", "0", "0"]
    assert "(*toml joints" not in text and "variable" not in text


@pytest.mark.parametrize("key", ["M", "IA", "FV", "mu", "eta", "k"])
@pytest.mark.parametrize("count", [5, 6, 7])
def test_entries_of_rows_without_body_may_be_left_out(key: str, count: int) -> None:
    given = {"M": "1", "IA": "0.5", "FV": "FV1", "mu": "1", "eta": "0", "k": "0"}[key]
    others = {"eta": "1", "k": "K1*(2 + qm)", "mu": "1"}.get(key, "0")
    cells = [given, others, *["0"] * (count - 2)]
    without = re.sub(rf"^{key} = .*\n", "", PAR_LOOP, flags=re.MULTILINE)
    machine = par.read(f"{without}{key} = {{{', '.join(cells)}}}\n", "")
    full = par.read(f"{without}{key} = {{{', '.join([given, others, *['0'] * 5])}}}\n", "")
    assert machine == full
    the_same_after_writing(machine)


@pytest.mark.parametrize(
    ("old", "new", "place", "reason"),
    [
        (
            "d = {0, 0, L1, L0, 0.1, L3, L2}",
            "d = {0, 0, L1, L0, 0.1}",
            "d",
            "has 5 entries, expected 7 (NF = 2 NJ - NL)",
        ),
        (
            "M = {1, 2, 3, 4, 5}",
            "M = {1, 2, 3, 4}",
            "M",
            "has 4 entries, expected 5 (NL), 6 (NJ) or 7 (NF = 2 NJ - NL)",
        ),
        ("mu = {1, 1, 0, 0, 0, 0, 0}", "mu = {1}", "mu", "has 1 entries, expected 5 (NL), 6 (NJ) or 7 (NF"),
        ("eta = {0, 1, 0, 0, 0, 0}", "eta = {0, 1}", "eta", "has 2 entries, expected 5 (NL), 6 (NJ) or 7 (NF"),
        ("NF = 7", "NF = 6", "NF", "6 must be 2 NJ - NL = 7, or left out"),
        ("NJ = 6", "NJ = 4", "NJ", "4 joints are too few for NL = 5 bodies"),
        ("NJ = 6\nNF = 7", "NJ = 7", "ant", "has 7 entries, expected 9 (NF = 2 NJ - NL)"),
        ("NL = 5", "NL = -5", "NL", "must be the number of bodies"),
        ("sigma = {0, 0, 0, 0, 0, 0, 2}", "sigma = {0, 0, 0, 0, 0, 0, 0}", "joint 7 (j7), sigma", "row 7 is the frame"),
        (
            "mu = {1, 1, 0, 0, 0, 0, 0}",
            "mu = {1, 1, 0, 0, 0, 1, 0}",
            "joint 6 (j6), mu",
            "(passive joints: j3, j4, j5)",
        ),
        ("eta = {0, 1, 0, 0, 0, 0}", "eta = {0, 1, 0, 0, 0, 1}", "joint 6 (j6), eta", "no motor, spring or body"),
        ("M = {1, 2, 3, 4, 5}", "M = {1, 2, 3, 4, 5, 6}", "joint 6 (j6), mass", "no motor, spring or body"),
        ("ant = {0, 1, 2, 0, 0, 4, 3}", "ant = {0, 1, 2, 0, 6, 4, 3}", "joint 5 (j5), antecedent", "must be 0"),
        ("d1 = 0,", "d9 = 0,", "loop loop_1, start", "no joint variable 'd9'; did you mean 'd1'?"),
        ("d1 = 0,", "d1,", "(*! start *)", "mixes"),
        ("q6 = pi/4", "q6 = 1/", "loop loop_1, start, q6", "ends too early"),
        ("k = {0, K1*(2 + qm), 0, 0, 0, 0}", "k = {0, K1*(2 + q6), 0, 0, 0, 0}", "joint 2 (j2), stiffness", "'q6'"),
    ],
)
def test_one_line_names_what_is_wrong_with_a_loop(old: str, new: str, place: str, reason: str) -> None:
    assert old in PAR_LOOP
    said = message(PAR_LOOP.replace(old, new, 1))
    assert said.startswith(f"{place}: ") and reason in said


@pytest.mark.parametrize(
    ("line", "place", "reason"),
    [
        ("(*! loops = {a, b} *)", "(*! loops *)", "names 2 loops, expected 1"),
        ("(*! loops = {} *)", "(*! loops *)", "names 0 loops, expected 1"),
        ("(*! loops = a *)", "(*! loops *)", "must be names, or a table"),
        ("(*! loops = {{a}} *)", "(*! loops *)", "must be names, or a table"),
        ("(*! loops = {a = x} *)", "(*! loops *)", "a must be a table"),
        ("(*! loops = {a = {cut = j6}} *)", "(*! loops *)", "any of closes, dependent, start"),
        ("(*! loops = {a = {closes = ball}} *)", "loop a, closes", "no closes 'ball'; there are: frame, point"),
        ("(*! loops = {a = {closes = {x}}} *)", "loop a, closes", "must be a text"),
        ("(*! loops = {a = {dependent = q3}} *)", "loop a, dependent", "must be a list of texts"),
        ("(*! loops = {a = {dependent = {q33}}} *)", "loop a, dependent", "did you mean 'q3'"),
        ("(*! loops = {a = {start = {x1 = 1}}} *)", "loop a, start", "no joint variable 'x1'"),
        ("(*! loops = {a = {start = 1}} *)", "loop a, start", "must be a table"),
        ("(*! order = {j1} *)", "(*! order *)", "each of the 7 joints once"),
        ("(*! order = {j1, j2, j3, j4, j5, j6, j6} *)", "(*! order *)", "each of the 7 joints once"),
        ("(*! variable = {j9 = q3} *)", "(*! variable *)", "no joint 'j9'"),
        ("(*! variable = {j7 = q3} *)", "joint 7 (j7), variable", "a fixed frame has no variable"),
        ("(*! variable = {j3 = q4} *)", "joint 3 (j3), variable", "'q4' does not occur in theta = 'q3'"),
        ("(*! ratio = {1, 2} *)", "(*! ratio *)", "list of 7 entries"),
    ],
)
def test_one_line_names_what_is_wrong_with_an_extension_line(line: str, place: str, reason: str) -> None:
    said = message(f"{PAR_LOOP}{line}\n")
    assert said.startswith(f"{place}: ") and reason in said


def test_a_tree_that_says_it_has_loops_is_warned_about() -> None:
    machine = par.read(PAR.replace("Type = 0", "Type = 2"), "")
    (warning,) = check(machine)
    assert warning.startswith("Type = 2: the machine has no closed loop") and "NJ > NL" in warning
    assert check(par.read(PAR, "")) == []
    the_same_after_writing(machine)


@pytest.mark.parametrize(("said", "kind"), [("0", "a chain"), ("1", "a tree")])
def test_a_type_without_loops_is_questioned_where_rows_close_one(said: str, kind: str) -> None:
    machine = par.read(PAR_LOOP.replace("Type = 2", f"Type = {said}"), "arm.par")
    assert check(machine) == [
        f"Type = {said}: that is {kind}, but NJ > NL: the machine is read with a closed loop; write Type = 2, or "
        "leave those rows out"
    ]
    assert check(par.read(PAR_LOOP, "arm.par")) == check(par.read(PAR_LOOP.replace("Type = 2\n", ""), "arm.par")) == []


def test_start_without_a_loop_is_refused() -> None:
    said = message(f"{PAR}(*! start = {{q1 = 0}} *)")
    assert said == "(*! start *): the machine has no closed loop (NJ = NL = 3): leave it out"


def test_extension_lines_say_what_rows_cannot() -> None:
    assert loop_of("").name == "loop_1"
    assert loop_of("(*! loops = {linkage} *)").name == "linkage"
    named = loop_of("(*! loops = {linkage = {}} *)")
    assert (named.name, named.closes, named.dependent, named.start["q6"].text) == ("linkage", Closing.FRAME, (), "pi/4")
    said = loop_of("(*! loops = {linkage = {closes = point, dependent = {q4, j1}, start = {q3 = 2}}} *)")
    assert (said.closes, said.dependent, said.start) == (Closing.POINT, ("j4", "j1"), {"q3": Formula.parse("2")})


@pytest.mark.parametrize(
    "loop",
    [
        {"name": "linkage"},
        {"closes": Closing.POINT},
        {"dependent": ("j4", "j1")},
        {"start": {}},
        {"name": "a", "closes": Closing.POINT, "dependent": ("j1",), "start": {"q3": Formula.parse("-pi/3")}},
    ],
)
def test_loops_survive_writing(loop: dict[str, object]) -> None:
    machine = par.read(PAR_LOOP, "four_bar.par")
    the_same_after_writing(replace(machine, loops=(replace(machine.loops[0], **loop),)))


TWO_LOOPS = """
NL = 4
NJ = 6
Type = 2
ant = {0, 1, 0, 3, 2, 4, 4, 7}
sigma = {0, 0, 0, 0, 2, 2, 2, 2}
b = {1, 0, 0, 0, 0, 0, 0, 0}
theta = {q1, q2, q3, q4, 0, 0, 0, 0}
mu = {1, 0, 1, 0, 0, 0, 0, 0}
Z = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}
GAM = {G1, G2, G3, G4, 0, 0}
"""


def test_two_loops_are_numbered_in_the_order_of_the_rows() -> None:
    """The frame that the second cut joint meets hangs on that of the first; entries that no model uses are kept."""
    machine = par.read(TWO_LOOPS, "two.par")
    assert [(loop.name, loop.cut, loop.meets) for loop in machine.loops] == [("loop_1", 5, 7), ("loop_2", 6, 8)]
    assert machine.joint(8).antecedent == 7 and machine.joint(1).b.text == "1"
    text = the_same_after_writing(machine)
    assert rows(text, "b")[0] == "1" and rows(text, "GAM") == ["G1", "G2", "G3", "G4", "0", "0"]
    assert rows(text, "Z")[5] == "1"


def test_loops_start_from_one_position_or_from_their_own() -> None:
    machine = par.read(TWO_LOOPS + "(*! start = {q1 = 0.1, q2 = 1, q3 = 0, q4 = 2} *)", "two.par")
    first, second = machine.loops
    assert first.start == second.start and first.start["q4"].text == "2"
    the_same_after_writing(machine)
    differing = replace(machine, loops=(first, replace(second, start={"q2": Formula.parse("1")})))
    the_same_after_writing(differing)


def test_rows_that_par_lists_last_come_back_where_they_were() -> None:
    """A tool that follows the cut joint in the table is row 6 of the file, and its own row again after reading."""
    tool = '  { name = "tool", antecedent = "j3", kind = "elastic", sigma = 0, d = "L2", theta = "q8" },\n]\n[loops]'
    text = TOML_LOOP.replace("]\n[loops]", tool) + "[wrenches]\ntool = { force = [1, 2, 3] }\n"
    text = text.replace("[springs]", "[springs]\ntool = { stiffness = 5 }")
    machine = toml.read(text, "")
    written = the_same_after_writing(machine)
    names = re.findall(r'^\(\*toml   { name = "(\w+)"', written, re.MULTILINE)
    assert names == ["j1", "j2", "j3", "j4", "j5", "j6", "j7", "tool"]
    assert rows(written, "theta") == ["qm", "d1", "q3", "q4", "N5*qm", "q8", "q6", "0"]
    assert rows(written, "ant") == ["0", "1", "2", "0", "0", "3", "4", "3"]
    assert rows(written, "FX") == ["0", "0", "0", "0", "0", "1"]
    block = r"\(\*toml joints = \[ \*\)\n(?:\(\*toml   .*\n)+\(\*toml \] \*\)\n\(\*toml \[loops\] \*\)\n.*\n"
    unordered = par.read(re.sub(block, "", written), "")
    assert [joint.variable for joint in unordered.joints][5] == "q8"
    assert (unordered.loops[0].cut, unordered.loops[0].meets) == (7, 8)
    assert check(unordered) == check(machine)


@pytest.mark.sampled(16)
@pytest.mark.parametrize("name", FILES)
def test_machines_of_closed_chains_come_back_from_par(name: str) -> None:
    """From TOML to .par to TOML, in two orders of the rows."""
    text = FILES[name].read_text()
    machine = toml.read(text, name)
    for same in (machine, reordered(machine)):
        written = the_same_after_writing(same)
        assert toml.write(par.read(written, name)) == toml.write(same)
        counts = [int(re.search(rf"^{key} = (\d+)$", written, re.MULTILINE)[1]) for key in ("NL", "NJ", "NF")]
        assert counts == [len(same.joints) - (2 - k) * len(same.loops) for k in range(3)]


def test_a_body_on_the_frame_of_a_loop_survives() -> None:
    machine = toml.read(TOML_LOOP.replace("[springs]", "j7 = { mass = 7 }\n[springs]"), "")
    assert rows(the_same_after_writing(machine), "M") == ["1", "2", "3", "4", "5", "0", "7"]


def test_what_par_cannot_hold_is_refused() -> None:
    tool = '  { name = "tool", antecedent = "j7", kind = "fixed" },\n]\n[loops]'
    machine = toml.read(TOML_LOOP.replace("]\n[loops]", tool), "four.toml")
    with pytest.raises(
        InputError, match=r"four.toml: joint 8 \(tool\), antecedent: it is carried by the frame where a "
    ):
        par.write(machine)
    twice = replace(machine, loops=(*machine.loops, replace(machine.loops[0], name="again")))
    with pytest.raises(InputError, match=r"four.toml: joint 6 \(j6\): two loops close at this row"):
        par.write(twice)


def test_a_base_that_floats_comes_before_the_bodies() -> None:
    text = (
        PAR_LOOP.replace("Type = 2", "is_floating = 1").replace("M = {1,", "M = {9, 1,").replace("ZZ = {", "ZZ = {3, ")
    )
    machine = par.read(text, "")
    assert machine.floating is not None
    assert machine.floating.body.mass.text == "9" and machine.joint(1).body.mass.text == "1"
    assert len(rows(the_same_after_writing(machine), "M")) == 6


def test_the_body_of_a_base_about_its_centre_of_mass_survives() -> None:
    text = (
        'joints = [{ name = "arm", kind = "motor", sigma = 0, theta = "q" }]\n[base]\nfloating = "quaternion"\n'
        "body = { mass = 3, center_of_mass = [0.2, 0, 0], inertia = [1, 2, 3] }\n"
    )
    written = the_same_after_writing(toml.read(text, ""))
    assert rows(written, "M") == ["3", "0"]
    with pytest.raises(InputError, match=r"base, body: does not agree with the lists XX to M"):
        par.read(written.replace("center_of_mass = [0.2", "center_of_mass = [0.3"), "")


# Couplings: cells with the variables of other joints.


def cells(thetas: list[str], mu: str, line: str = "", d: str = "") -> Machine:
    """A machine of revolute joints with these cells."""
    count = len(thetas)
    text = f"NL = {count}\nant = {{{', '.join('0' * count)}}}\nsigma = {{{', '.join('0' * count)}}}\n"
    text += f"theta = {{{', '.join(thetas)}}}\nmu = {{{', '.join(mu)}}}\n"
    return par.read(text + (f"d = {{{d}}}\n" if d else "") + line, "arm.par")


@pytest.mark.parametrize(
    ("thetas", "mu", "variables", "parameters"),
    [
        (["q1", "N2*q1"], "10", ["q1", None], ["N2"]),
        (["N2*q1", "q1"], "01", [None, "q1"], ["N2"]),  # either order of rows
        (["q1", "q2", "q2 - q1"], "110", ["q1", "q2", None], []),
        (["(qa + qb)/2", "qa", "qb"], "011", [None, "qa", "qb"], []),
        (["q5", "c65*q5 + q6"], "11", ["q5", "q6"], ["c65"]),
        (["q1", "q1"], "10", ["q1", None], []),  # the same angle
        (["q1", "q1"], "00", ["q1", None], []),
        (["q1 + L1", "q3 + L1"], "11", ["q1", "q3"], ["L1"]),
        (["q1 + L1", "q3 + L1"], "01", ["q1", "q3"], ["L1"]),
        (["q1", "q1 + q2"], "10", ["q1", "q2"], []),  # passive: q2 is new
        (["q1 + L1", "N2*q1"], "10", ["q1", None], ["L1", "N2"]),  # what joint 2 follows is a variable
        (["N2*q1", "q1 + L1"], "00", [None, "q1"], ["L1", "N2"]),
        (["q1", "q1 + q2", "q2 + q3", "q3 + q4 + q1"], "1111", ["q1", "q2", "q3", "q4"], []),
        (["q3 + q4 + q1", "q2 + q3", "q1 + q2", "q1"], "1111", ["q4", "q3", "q2", "q1"], []),
    ],
)
def test_own_variables_of_cells(thetas: list[str], mu: str, variables: list[str | None], parameters: list[str]) -> None:
    machine = cells(thetas, mu)
    assert [joint.variable for joint in machine.joints] == variables
    assert sorted(parameter.name for parameter in machine.parameters) == parameters
    assert all((joint.kind is Kind.COUPLED) == (joint.variable is None) for joint in machine.joints)
    check(machine)
    the_same_after_writing(machine)


@pytest.mark.parametrize(
    ("thetas", "mu", "place", "reason"),
    [
        (["q4 + d", "q5"], "11", "joint 1 (j1), theta", "may hold any of d, q4 as joint variable"),
        (["q1", "q1 + a + b"], "10", "joint 2 (j2), theta", "may hold any of a, b"),
        (["q1", "q2", "q1 + q2"], "111", "joint 3 (j3), theta", "variables of other joints only (q1, q2): add one"),
        (["qa + L1", "qb + L2", "(qa + qb)/2"], "110", "joint 1 (j1), theta", "may hold any of L1, qa"),
        (["2*q1", "3*q1"], "00", "joint 1 (j1), theta", "no joint variable in '2*q1'"),
        (["2*q1"], "0", "joint 1 (j1), theta", "must be the joint variable 'q1'"),
        # Either the motor's own angle is q1 and joint 2 follows it, or joint 2 is passive and the motor's own is off.
        (["q1 + off", "q1"], "10", "joint 1 (j1), theta", "any of off, q1"),
        # Either off is a constant of both, or the passive joint's own.
        (["q1", "q1 + off", "q3", "q3 + off"], "1010", "joint 2 (j2), theta", "'off' in 'q1 + off' may be a variable"),
    ],
)
def test_doubts_about_variables_are_refused(thetas: list[str], mu: str, place: str, reason: str) -> None:
    with pytest.raises(InputError) as caught:
        cells(thetas, mu)
    said = str(caught.value).removeprefix("arm.par: ")
    assert said.startswith(f"{place}: ") and reason in said and "\n" not in said


@pytest.mark.parametrize(
    ("thetas", "mu", "line", "variables"),
    [
        (["q1 + off", "q1"], "10", "(*! variable = {j1 = off} *)", ["off", "q1"]),
        (["q1 + off", "q1"], "10", "(*! variable = {j1 = q1} *)", ["q1", None]),
        (["q1 + off", "q1"], "10", "(*! parameters = {off} *)", ["q1", None]),
        (["q1", "q1 + off", "q3", "q3 + off"], "1010", "(*! variable = {j2 = off} *)", ["q1", "off", "q3", None]),
        (["q1", "q1 + off", "q3", "q3 + off"], "1010", "(*! values = {off = 1} *)", ["q1", None, "q3", None]),
        (["q4 + d", "q5"], "11", "(*! variable = {j1 = d} *)", ["d", "q5"]),
    ],
)
def test_the_way_out_of_a_doubt(thetas: list[str], mu: str, line: str, variables: list[str | None]) -> None:
    machine = cells(thetas, mu, line)
    assert [joint.variable for joint in machine.joints] == variables
    the_same_after_writing(machine)


def test_a_name_that_stands_where_no_variable_does_is_a_parameter() -> None:
    assert [joint.variable for joint in cells(["q4 + d", "q5"], "11", d="d, 0").joints] == ["q4", "q5"]


def test_variables_are_named_where_the_cells_leave_a_doubt() -> None:
    machine = cells(["q1 + off", "q1"], "10", "(*! variable = {j1 = off} *)")
    written = par.write(machine)
    assert '(*toml   { name = "j1", variable = "off" }, *)' in written
    assert '(*toml   { name = "j2", variable = "q1"  }, *)' in written
    assert "variable" not in par.write(cells(["q1", "N2*q1"], "10"))


def test_ratio_and_sharing_are_lines_of_their_own() -> None:
    machine = par.read(PAR_LOOP + "(*! ratio = {100, 0, 0, 0, 0} *)\n(*! sharing = {N5, 0, 0, 0, 0, 0, 0} *)", "")
    assert (machine.joint(1).ratio.text, machine.joint(1).sharing.text) == ("100", "N5")
    assert '(*toml j1 = { ratio = 100, sharing = "N5" } *)' in the_same_after_writing(machine)


CELLS = ("{0}", "N*{0} + L1", "({0} - {1})/2", "sin({0})*R", "{0} - {1} - L2", "-{0}")
OFFSETS = ("0", "L1", "pi/2 - L1", "-L2")


@st.composite
def trees(draw: st.DrawFn) -> list[Joint]:
    """Rows in which some cells hold the variables of others."""
    owners = draw(st.integers(1, 3))
    joints = []
    for j in range(1, owners + draw(st.integers(0, 3)) + 1):
        kind = draw(st.sampled_from([Kind.MOTOR, Kind.PASSIVE])) if j <= owners else Kind.COUPLED
        others = st.sampled_from([f"x{k}" for k in range(1, owners + 1) if k != j] or ["pi"])
        cell = draw(st.sampled_from(CELLS)).format(draw(others), draw(others))
        if kind is not Kind.COUPLED and (owners == 1 or draw(st.booleans())):
            cell = draw(st.sampled_from(OFFSETS))
        variable = None if kind is Kind.COUPLED else f"x{j}"
        sigma = draw(st.sampled_from([0, 1]))
        joint = Joint(f"b{j}", 0, kind, sigma, variable, d=Formula.parse(draw(st.sampled_from(["0", "R"]))))
        joints.append(replace(joint, **{"r" if sigma == 1 else "theta": Formula.parse(cell)}))
    order = draw(st.permutations(joints))
    return [replace(joint, antecedent=draw(st.integers(0, k))) for k, joint in enumerate(order)]


@st.composite
def linkages(draw: st.DrawFn) -> Machine:
    """Machines with couplings and loops, in any order of rows and of parameters."""
    joints = draw(trees())
    count = draw(st.integers(0, 2))
    for k in range(1, count + 1):
        for name, kind in ((f"c{k}", Kind.CUT), (f"e{k}", Kind.FIXED)):
            sigma = draw(st.sampled_from([0, 1, 2])) if kind is Kind.CUT else 2
            place = draw(st.integers(0, len(joints)))
            carriers = [0, *(j for j, joint in enumerate(joints[:place], start=1) if joint.name[0] == "b")]
            row = Joint(name, draw(st.sampled_from(carriers)), kind, sigma, None if sigma == 2 else f"y{k}")
            joints = [replace(joint, antecedent=joint.antecedent + (joint.antecedent > place)) for joint in joints]
            joints.insert(place, row)
    names = [joint.name for joint in joints]
    starts = st.dictionaries(st.sampled_from([str(joint.variable) for joint in joints if joint.variable]), numbers)
    loops = [
        Loop(
            name=draw(st.sampled_from([f"loop_{k}", f"side_{k}"])),
            cut=names.index(f"c{k}") + 1,
            meets=names.index(f"e{k}") + 1,
            closes=draw(st.sampled_from(list(Closing))),
            dependent=tuple(draw(st.lists(st.sampled_from(names), max_size=2))),
            start=draw(starts),
        )
        for k in range(1, count + 1)
    ]
    order = draw(st.permutations(["L1", "L2", "N", "R"]))
    return Machine("arm", tuple(joints), tuple(Parameter(name) for name in order), loops=tuple(loops))


@given(linkages())
@settings(max_examples=60, deadline=None)
@pytest.mark.thorough
def test_random_linkage_through_both_formats(machine: Machine) -> None:
    the_same_after_writing(machine)


def test_many_coupled_rows_are_settled_in_linear_work() -> None:
    """A chain of 20 000 cells in which each holds the variable of the row below."""
    count = 20_000
    names = {j: {f"q{j}", f"q{j + 1}"} for j in range(1, count)} | {count: {f"q{count}"}}
    assert owned_names(names, optional=()) == {j: {f"q{j}"} for j in names}
