"""What loops and couplings do not allow is said in one line by `generate`, which then writes nothing."""

from __future__ import annotations

import math
import re
from pathlib import Path

import pytest

from tests.closed_chains.machines import FILES
from tests.command_line import EXAMPLES, Ended, ended

START = re.compile(r", start = \{[^}]*\}")
FLOATS = """
[base]
floating = "quaternion"
body = { mass = 5, center_of_mass = [0, 0, 0], inertia = [1, 2, 3] }
"""
TWO_ON_ONE_AXIS = """
joints = [
  { name = "crank", antecedent = 0, kind = "motor", sigma = 0, theta = "q1" },
  { name = "hub", antecedent = "crank", kind = "passive", sigma = 0, theta = "q2" },
  { name = "coupler", antecedent = "hub", kind = "passive", sigma = 0, d = 0.2, theta = "q3" },
  { name = "rocker", antecedent = 0, kind = "passive", sigma = 0, d = 0.55, theta = "q4" },
  { name = "pin", antecedent = "coupler", kind = "cut", sigma = 0, d = 0.6, theta = "q5" },
  { name = "pin_end", antecedent = "rocker", kind = "fixed", sigma = 2, d = 0.35 },
]
[loops.linkage]
cut = "pin"
meets = "pin_end"
dependent = ["q1", "q2"]
start = { q1 = 0.8, q2 = 0, q3 = -0.52, q4 = 1.08 }
[bodies]
coupler = { mass = 1, center_of_mass = [0.1, 0, 0], inertia = [0.1, 0.2, 0.2] }
rocker = { mass = 1, center_of_mass = [0.1, 0, 0], inertia = [0.1, 0.2, 0.2] }
hub = { mass = 1, center_of_mass = [0.1, 0, 0], inertia = [0.1, 0.2, 0.2] }
crank = { mass = 1, center_of_mass = [0.1, 0, 0], inertia = [0.1, 0.2, 0.2] }
"""

Change = tuple[str | re.Pattern[str], str]


def changed(name: str, *changes: Change) -> str:
    text = FILES[name].read_text(encoding="utf-8")
    for old, new in changes:
        found = old.sub(new, text) if isinstance(old, re.Pattern) else text.replace(old, new)
        assert found != text
        text = found
    return text


def generated(folder: Path, text: str, *models: str) -> Ended:
    """How `generate` of a machine file ends, with the models that are named, else the default ones."""
    file = folder / "machine.toml"
    file.write_text(text, encoding="utf-8")
    asked = [x for model in models for x in ("--model", model)]
    return ended("generate", file, "--out", folder / "out", *asked)


def assert_refused(folder: Path, done: Ended, message: str) -> None:
    """Warnings about the machine may come before."""
    assert done.code == 2, done
    assert done.out == ""
    *warnings, error = done.err.splitlines()
    assert all(line.startswith("warning: ") for line in warnings)
    said = error.removeprefix(f"error: {folder / 'machine.toml'}: ")
    assert said != error and re.fullmatch(message, said), error
    assert [path.name for path in folder.iterdir()] == ["machine.toml"]


REFUSED = {
    "no position near start": (
        changed("five_bar", ("L2 = { value = 0.5 }", "L2 = { value = 0.1 }")),
        (),
        r"loop diamond: no position near start: 0\.\d+ m stay open after 50 steps of Newton's method: "
        r"the links rod_2 to tip and tip to rod_1 would need 0\.\d+ m more, or give another start",
    ),
    "no position, no start": (
        changed("five_bar", ("L2 = { value = 0.5 }", "L2 = { value = 0.1 }"), (START, "")),
        (),
        r"loop diamond: no position near start: 0\.\d+ m stay open after 50 steps of Newton's method: "
        r"write start = \{ \.\.\. \}",
    ),
    "two positions": (
        changed("four_bar", (START, "")),
        (),
        r"loop linkage: two positions \(q2 = -?\d\.\d\d or -?\d\.\d\d\): write start = \{ \.\.\. \}",
    ),
    "too many dependent joints": (
        changed("sr400", ('dependent = ["th3", "th8"]', 'dependent = ["th3", "th7", "th8"]')),
        (),
        r"loop parallelogram: 2 equations for 3 dependent variables \(3 of 5 are fulfilled by the plane\): "
        r"keep one of th3, th7, th8 independent",
    ),
    "offsets that cannot meet": (
        changed("four_bar", ("d = 0.6,", "d = 0.6, r = 0.1,")),
        (),
        r"loop linkage: no position near start: 0\.1 m stay open that no joint of the loop changes: "
        r"check the lengths b, d and r around it",
    ),
    "axes that cannot meet": (
        changed("four_bar", ("d = 0.6,", "alpha = 0.3, d = 0.6,")),
        (),
        r"loop linkage: no position near start: 0\.21 rad stay open that no joint of the loop changes: "
        r"check the angles gamma and alpha around it",
    ),
    "two motors on one freedom": (
        changed(
            "four_bar",
            ('kind = "passive", sigma = 0, d = 0.55', 'kind = "motor", sigma = 0, d = 0.55'),
            ('meets = "pin_end",', 'meets = "pin_end", dependent = ["q2", "q3"],'),
        ),
        (),
        r"inverse_dynamics: 2 motors drive 1 freedom: only 1 combination of torques is determined; "
        r"give sharing, or make the beam elastic",
    ),
    "too few dependent joints": (
        changed("four_bar", ('meets = "pin_end",', 'meets = "pin_end", dependent = ["q2"],')),
        (),
        r"loop linkage: 2 equations for 1 dependent variable \(3 of 5 are fulfilled by the plane\): "
        r"name more joints in dependent",
    ),
    "dependent joints on one axis": (
        TWO_ON_ONE_AXIS,
        (),
        r"loop linkage: q1 and q2 cannot both depend: their columns are parallel in every position; "
        r'try \["q1", "q3"\]',
    ),
    "dependent joints on one axis, no start": (
        changed("five_bar", ('["q2", "q4"]', '["qm1", "d1"]'), (START, "")),
        (),
        r"loop diamond: qm1 and d1 cannot both depend: their columns are parallel in every position; "
        r'try \["qm1", "q2"\]',
    ),
    "more motors than freedoms": (
        changed("gantry_rigid", (re.compile(", sharing = [12]"), "")),
        ("inverse_dynamics",),
        r"inverse_dynamics: 4 motors drive 3 freedoms: only 3 combinations of torques are determined; "
        r"give sharing, or make the beam elastic",
    ),
    "loops on a floating base": (
        changed("four_bar", ("gravity =", "# gravity ="), (re.compile(r"\n\[wrenches\]"), FLOATS + "[wrenches]")),
        (),
        r"direct_dynamics: not offered on a floating base with loops: linkage; couplings are",
    ),
    "inverse geometry of a loop": (
        changed("five_bar"),
        ("inverse_geometric_model",),
        r"joint 3 \(rod_1\): it follows from loop diamond, and not by sums of angles: .* \(dependent = \[\.\.\.\]\).*",
    ),
    "inverse geometry of coupled joints": (
        changed("cam"),
        ("inverse_geometric_model",),
        r"joint \d \(\w+\): '.*' is not a linear formula of .*",
    ),
    "assemble where loops have closed forms": (
        changed("sr400"),
        ("assemble",),
        r"assemble: no loop needs it, for the dependent variables have closed forms: ask for dependent_coordinates",
    ),
    "constraint forces without constraints": (
        changed("ball_screw"),
        ("constraint_forces",),
        r"constraint_forces: there is no loop, and every joint has a variable of its own, .*: leave it out",
    ),
}


@pytest.mark.sampled(2)
@pytest.mark.parametrize("case", REFUSED)
def test_one_line_says_why_and_nothing_is_written(case: str, tmp_path: Path) -> None:
    text, models, message = REFUSED[case]
    assert_refused(tmp_path, generated(tmp_path, text, *models), message)


@pytest.mark.parametrize("model", ["assemble", "constraint_forces", "coupling_matrix", "dependent_coordinates"])
def test_models_of_closed_chains_are_refused_on_trees(model: str, tmp_path: Path) -> None:
    text = (EXAMPLES / "planar_2r.toml").read_text(encoding="utf-8")
    assert_refused(tmp_path, generated(tmp_path, text, model), rf"{model}: no .*")


@pytest.mark.thorough
def test_the_joints_that_a_refusal_proposes_can_depend(tmp_path: Path) -> None:
    text = TWO_ON_ONE_AXIS.replace('["q1", "q2"]', '["q1", "q3"]')
    assert text != TWO_ON_ONE_AXIS
    assert generated(tmp_path, text, "direct_dynamics").code == 0


def test_motors_that_share_are_determined(tmp_path: Path) -> None:
    """One share is enough; the direct model asks for none."""
    alone = changed("gantry_rigid", (", sharing = 1", ""))
    assert generated(tmp_path, alone, "inverse_dynamics").code == 0
    without = changed("gantry_rigid", (re.compile(", sharing = [12]"), ""))
    assert generated(tmp_path, without, "direct_dynamics", "direct_dynamics_by_inertia_matrix").code == 0


FOUR_BAR = """
joints = [
  {{ name = "crank", antecedent = 0, kind = "motor", sigma = 0, theta = "q1" }},
  {{ name = "rod", antecedent = "crank", kind = "passive", sigma = 0, d = 0.15, theta = "q2" }},
  {{ name = "rocker", antecedent = 0, kind = "passive", sigma = 0, d = 0.5, theta = "q3" }},
  {{ name = "pin", antecedent = "rod", kind = "cut", sigma = 0, d = {rod}, theta = "q4" }},
  {{ name = "end", antecedent = "rocker", kind = "fixed", sigma = 2, d = 0.3 }},
  {{ name = "pin_2", antecedent = "rod", kind = "cut", sigma = 0, d = {rod}, theta = "q5" }},
  {{ name = "end_2", antecedent = "rocker", kind = "fixed", sigma = 2, d = 0.3 }},
]
[loops]
bars = {{ cut = "pin", meets = "end", start = {{ {start} }} }}
{second}
[bodies]
crank = {{ mass = 1, center_of_mass = [0.07, 0.01, 0], inertia = [0.001, 0.003, 0.003] }}
rod = {{ mass = 1, center_of_mass = [0.2, 0.01, 0], inertia = [0.001, 0.02, 0.02] }}
rocker = {{ mass = 1, center_of_mass = [0.15, 0.01, 0], inertia = [0.001, 0.01, 0.01] }}
"""


def test_a_loop_that_is_closed_twice_is_a_warning(tmp_path: Path) -> None:
    start = "q1 = 1.0, q2 = -0.6, q3 = 1.6"
    second = f'again = {{ cut = "pin_2", meets = "end_2", start = {{ {start} }} }}'
    done = generated(tmp_path, FOUR_BAR.format(rod=0.45, start=start, second=second))
    assert done.code == 0 and "it closes around the same joints as loop bars: closed twice?" in done.err
    shown = ended("show", tmp_path / "machine.toml")
    assert shown.code == 0 and "other loops close it already" in " ".join(shown.out.split())


@pytest.mark.thorough
def test_a_start_where_links_are_stretched_is_a_warning(tmp_path: Path) -> None:
    done = generated(tmp_path, four_bar(0.65, "q1 = 0, q2 = 0, q3 = 0"))
    warning = "warning: loop bars: start is within 1e-6 of a singular position: where"
    assert done.code == 0 and warning in done.err
    assert "; branches meet there: move start to the intended side" in done.err
    said = ended("show", tmp_path / "machine.toml").err
    assert warning in said and said.endswith("and are not singular: move start to the intended side\n")


def four_bar(rod: float, start: str, second: str = "") -> str:
    """A four-bar, its second cut joint left out unless a second loop is given."""
    lines = FOUR_BAR.format(rod=rod, start=start, second=second).split("\n")
    return "\n".join(line for line in lines if second or "_2" not in line)


@pytest.mark.parametrize(
    ("rod", "q1", "links"), [(0.05, 1.0, "rod to pin and pin to rocker"), (0.9, 1.0, "pin to rocker and rocker to rod")]
)
def test_a_loop_that_cannot_close_says_which_length_it_lacks(rod: float, q1: float, links: str, tmp_path: Path) -> None:
    base = math.hypot(0.5 - 0.15 * math.cos(q1), 0.15 * math.sin(q1))
    sides = sorted((base, rod, 0.3))
    length = f"{sides[2] - sides[1] - sides[0]:.2g}"
    done = generated(tmp_path, four_bar(rod, f"q1 = {q1}, q2 = -0.6, q3 = 1.6"))
    assert_refused(
        tmp_path,
        done,
        rf"loop bars: no position near start: .* m stay open after 50 steps of Newton's method: "
        rf"the links {links} would need {length} m more, or give another start",
    )


def test_a_slider_that_cannot_close_says_which_length_it_lacks(tmp_path: Path) -> None:
    """The crank of 0.12 m stands at 1/3 rad from the normal of the slide, whose line is 0.03 m off."""
    off = 0.12 * math.cos(3.0 / 9) + 0.03
    done = generated(tmp_path, changed("press", ("L = { value = 0.6 }", "L = { value = 0.02 }")))
    assert_refused(
        tmp_path,
        done,
        rf"loop press: .*: the link \w+ to \w+ would need {off - 0.02:.2g} m more, or give another start",
    )


def test_loops_that_contradict_are_both_named(tmp_path: Path) -> None:
    """The rod cannot end at two places of the rocker."""
    start = "q1 = 1.0, q2 = -0.6, q3 = 1.6"
    second = f'other = {{ cut = "pin_2", meets = "end_2", start = {{ {start} }} }}'
    text = four_bar(0.45, start, second)
    text = text.replace("sigma = 2, d = 0.3 },\n]", "sigma = 2, d = 0.35 },\n]")
    assert_refused(
        tmp_path,
        generated(tmp_path, text),
        r"loop other: it closes near start, but not together with loop bars, whose joints it shares: "
        r"0\.025 m stay open after 50 steps of Newton's method; check the lengths b, d and r around them",
    )


def test_a_flat_start_is_told_to_move(tmp_path: Path) -> None:
    """The bars are 1e-4 m from lying on the base: Newton's method cannot leave the line."""
    assert_refused(
        tmp_path,
        generated(tmp_path, four_bar(0.6499, "q1 = 0, q2 = 0, q3 = 0")),
        r"loop bars: no position near start: 0\.0001 m stay open after 50 steps of Newton's method: "
        r"start is at a singular position, where branches meet: move it to the intended side",
    )


def test_show_says_one_freedom(tmp_path: Path) -> None:
    text = four_bar(0.45, "q1 = 1.0, q2 = -0.6, q3 = 1.6").replace(
        'name = "rocker", antecedent = 0, kind = "passive"', 'name = "rocker", antecedent = 0, kind = "motor"'
    )
    (tmp_path / "machine.toml").write_text(text.replace("start = {", 'dependent = ["rod", "rocker"], start = {'))
    assert "2 motors drive 1 freedom:" in ended("show", tmp_path / "machine.toml").out
