"""Reading what was written gives the same machine, in each format and from one to the other."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given, settings

from symoro_elastic.formats import read_machine, write_machine
from symoro_elastic.formats.par import reading as par
from symoro_elastic.formats.par import syntax as par_syntax
from symoro_elastic.formats.toml import reading as toml
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.checks import check
from symoro_elastic.machine.described import Origin
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import Kind, Machine, Parameter
from symoro_elastic.machine.scene import Scene
from tests.machine.samples import PAR, TOML, machines

pytestmark = pytest.mark.sampled(6)

EXAMPLES = sorted((Path(__file__).parents[2] / "examples").glob("*.*"))
MACHINES = [
    path for path in EXAMPLES if path.suffix == ".par" or (path.suffix == ".toml" and "joints" in path.read_text())
]


@pytest.mark.sampled(8)
@pytest.mark.parametrize("path", MACHINES, ids=lambda path: path.name)
@pytest.mark.parametrize("format_", [toml, par], ids=["toml", "par"])
def test_example_survives_writing(path: Path, format_, tmp_path: Path) -> None:
    machine, warnings = read_machine(path)
    assert warnings == []
    there = format_.read(format_.write(machine), machine.source)
    assert there == machine
    assert par.read(par.write(there), machine.source) == machine
    file = tmp_path / f"again.{'toml' if format_ is toml else 'par'}"
    if machine.flexible and format_ is par:
        with pytest.raises(InputError, match="does not know the integrals of its modes"):
            write_machine(machine, file)
        return
    write_machine(machine, file)
    assert replace(read_machine(file)[0], source=machine.source) == machine


@given(machines())
@settings(max_examples=100, deadline=None)
@pytest.mark.thorough
def test_random_machine_through_toml(machine: Machine) -> None:
    assert toml.read(toml.write(machine), "") == machine


@pytest.mark.thorough
@given(machines())
@settings(max_examples=60, deadline=None)
def test_random_machine_through_par(machine: Machine) -> None:
    assert par.read(par.write(machine), "") == machine


@pytest.mark.parametrize(
    "note", ["Robotname = 'other'", "red \x1b[31m", "next \x9b line", "a\u2028b", "two\nlines", "é"]
)
def test_notes_survive_and_no_control_character_is_written(note: str) -> None:
    machine = toml.read(TOML, "").with_notes(note, "last")
    text = par.write(machine)
    assert par.read(text, "") == machine
    assert text.replace("\n", "").isprintable()


@pytest.mark.parametrize("path", MACHINES, ids=lambda path: path.name)
def test_lines_of_toml_are_comments_to_readers_that_skip_lines_and_to_those_that_nest_them(path: Path) -> None:
    """SYMORO skips each line in which a comment begins, and no others."""
    machine = read_machine(path)[0].with_notes("!(* a *) M = {1}", "(*)\nNL = 7")
    lines = par.write(machine).split("\n")
    beside = [line for line in lines if "(*toml" in line]
    assert len(beside) > 3 and all(line.startswith("(*toml ") and line.endswith(" *)") for line in beside)
    assert {(line.count("(*"), line.count("*)")) for line in beside} == {(1, 1)}
    seen, all_of_it = (par_syntax.take_apart(text, "") for text in (without(lines), "\n".join(lines)))
    assert (seen.lists, seen.numbers) == (all_of_it.lists, all_of_it.numbers)


def without(lines: list[str]) -> str:
    """What SYMORO reads."""
    return "\n".join(line for line in lines if "(*" not in line)


def test_examples_are_what_their_names_say() -> None:
    names = {path.name for path in MACHINES}
    assert names >= {"two_axis.toml", "two_axis_printed.par", "rx90.par", "puma560.par", "flex4.par", "planar_2r.toml"}
    machine = read_machine(next(path for path in MACHINES if path.name == "two_axis.toml"))[0]
    kinds = [joint.kind for joint in machine.joints]
    assert [j for j, kind in enumerate(kinds, start=1) if kind == Kind.MOTOR] == [5, 9]
    assert [joint.antecedent for joint in machine.joints] == [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 5]
    assert [joint.variable for joint in machine.joints] == [f"q{j}" if j != 12 else None for j in range(1, 14)]
    assert " ".join(joint.alpha.text for joint in machine.joints[:8]) == "0 -pi/2 -pi/2 0 0 -pi/2 pi/2 pi/2"
    assert sum(joint.body.mass.value() for joint in machine.joints) == pytest.approx(2948.6)


@pytest.mark.thorough
def test_printed_table_differs_from_the_repaired_one_in_three_cells() -> None:
    by_name = {path.name: read_machine(path)[0] for path in MACHINES}
    repaired, printed = by_name["two_axis.toml"].joints, by_name["two_axis_printed.par"].joints
    geometry = ("name", "antecedent", "kind", "sigma", "gamma", "b", "alpha", "d", "theta", "r")
    different = [
        (j, cell)
        for j, (one, other) in enumerate(zip(repaired, printed, strict=True), start=1)
        for cell in geometry
        if getattr(one, cell) != getattr(other, cell)
    ]
    assert different == [(3, "alpha"), (3, "theta"), (8, "alpha")]


def test_numbers_stay_exact() -> None:
    joint = toml.read(TOML.replace("d = 0.1", "d = 0.1000000000000000055511151231257827"), "").joints[2]
    assert joint.d.tree == Formula.parse("0.1000000000000000055511151231257827").tree
    assert joint.d != Formula.parse("0.1")
    assert toml.read(TOML.replace("d = 0.1", "d = 1_000.5"), "").joints[2].d.text == "1000.5"


def test_central_inertia_is_written_about_the_origin_exactly() -> None:
    machine = toml.read(TOML, "")
    text = par.write(machine)
    lines = {
        line.split("=")[0].strip(): line.split("=", 1)[1].replace(" ", "") for line in text.split("\n") if "=" in line
    }
    assert (lines["MX"], lines["YY"], lines["ZZ"]) == ("{0,0.25,0}", "{0,0.225,0}", "{0,0.275,0}")
    assert par.read(text, "") == machine


def test_symbolic_central_inertia_about_the_origin_has_the_right_value() -> None:
    source = TOML.replace("mass = 2.5, center_of_mass = [0.1, 0, 0]", 'mass = "K2", center_of_mass = ["L2", -2, "-L2"]')
    source = source.replace("inertia = [0.1, 0.2, 0.25]", "inertia = [7, 0.5, -1, 8, 0.25, 9]")
    text = "\n".join(line for line in par.write(toml.read(source, "")).split("\n") if "center_of_mass" not in line)
    body = par.read(text, "").joints[1].body
    m, x, y, z = 3.0, 0.5, -2.0, -0.5
    expected = [
        *(7 + m * (y * y + z * z), 0.5 - m * x * y, -1 - m * x * z),
        *(8 + m * (x * x + z * z), 0.25 - m * y * z, 9 + m * (x * x + y * y)),
    ]
    assert [formula.value({"K2": m, "L2": x}) for formula in body.inertia] == expected
    assert [formula.value({"K2": m, "L2": x}) for formula in body.moments] == [m * x, m * y, m * z]


def test_par_lists_its_parameters_only_when_it_must() -> None:
    machine = par.read(PAR, "arm.par")
    assert [parameter.name for parameter in machine.parameters] == ["M2", "K2"]
    assert "(*toml [parameters]" not in par.write(machine)
    reversed_ = replace(machine, parameters=machine.parameters[::-1])
    assert "(*toml [parameters] *)\n(*toml K2 = nan *)\n(*toml M2 = nan *)\n" in par.write(reversed_)
    unused = replace(machine, parameters=(*machine.parameters, Parameter("spare")))
    assert par.read(par.write(unused), "arm.par") == unused


def test_type_tells_a_chain_from_a_tree() -> None:
    assert "Type = 0\n" in par.write(par.read(PAR, ""))
    assert "Type = 1\n" in par.write(par.read(PAR.replace("Type = 0", "").replace("{0, 1, 2}", "{0, 1, 1}", 1), ""))


def test_unused_columns_of_par_are_kept() -> None:
    extra = "QP = {QP1, QP2, 0}\nk = {K1, K2, 0}\nmu = {1, 0, 0}\nType = 1\nZ = {" + ", ".join("1" * 16) + "}\n"
    text = PAR.replace("k = {0, K2, 0}\n", "").replace("Type = 0\n", "") + extra
    machine = par.read(text, "")
    assert machine.origin.extras["QP"] == "{QP1, QP2, 0}"
    assert machine.origin.extras["k"] == "{K1, 0, 0}"
    assert machine.origin.extras["mu"] == "{1, 0, 0}"
    assert [parameter.name for parameter in machine.parameters] == ["M2", "K2"]
    again = par.write(machine)
    assert par.read(again, "") == machine
    for line in ("QP = {QP1, QP2, 0}", "k = {K1, K2, 0}", "Type = 1", "mu = {1, 0, 0}"):
        assert line.replace(" ", "") in again.replace(" ", "")


@pytest.mark.parametrize(
    ("extra", "where"),
    [
        ({"k": "{K9, 0, 0}"}, "k     = {K9,   K2,   0}"),
        ({"k": "{0, K9, 0}"}, "extras"),  # joint 2 is elastic: its k is another
        ({"k": "{0, 0, 0}"}, "extras"),
        ({"mu": "{1, 0, 1}"}, "mu    = { 1,    0,   1}"),
        ({"mu": "{0, 1, 0}"}, "extras"),  # joint 1 is a motor
        ({"mu": "{1, 2, 0}"}, "extras"),
        ({"mu": "{1, 1, 0}"}, "extras"),  # as the kinds imply
        ({"QP": "{1, 2}"}, "extras"),
        ({"QP": "{1,2,3}"}, "extras"),
        ({"QP": "{a, b, c}"}, "QP    = {a, b, c}"),
        ({"Type": "2"}, "Type = 2"),
        ({"Type": "tree"}, "extras"),
        ({"Type": "0"}, "extras"),  # as the table implies
        ({"any thing": "*) }"}, "extras"),
    ],
)
def test_extras_stand_where_par_readers_look_for_them(extra: dict[str, str], where: str) -> None:
    machine = replace(par.read(PAR, ""), origin=Origin(extras=extra))
    text = par.write(machine)
    assert par.read(text, "") == machine
    assert toml.read(toml.write(machine), "") == machine
    assert ("(*toml [extras]" in text) == (where == "extras")
    assert where.replace(" ", "") in text.replace(" ", "")


def test_empty_scene_is_not_no_scene() -> None:
    machine = toml.read(TOML, "").asking(scene=Scene())
    assert toml.read(toml.write(machine), "").asked.scene == Scene()
    assert par.read(par.write(machine), "").asked.scene == Scene()


@given(machines())
@settings(max_examples=50, deadline=None)
@pytest.mark.thorough
def test_writing_is_stable(machine: Machine) -> None:
    for format_ in (toml, par):
        text = format_.write(machine)
        assert format_.write(format_.read(text, "")) == text


def test_read_machine_runs_the_checks(tmp_path: Path) -> None:
    file = tmp_path / "arm.toml"
    file.write_text(TOML.replace("[0.1, 0.2, 0.25]", "[0.1, 0.2, 0.9]"))
    machine, warnings = read_machine(file)
    assert len(warnings) == 1 and "joint 2 (lift)" in warnings[0] and "triangle" in warnings[0]
    assert check(machine) == warnings
