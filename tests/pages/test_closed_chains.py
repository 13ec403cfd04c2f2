"""What `show` says about couplings, loops, rotors and motors."""

from __future__ import annotations

import json
import math
from typing import Any

import numpy as np
import pytest

from symoro_elastic.formats.toml import reading as toml
from symoro_elastic.machine.machine import Machine
from symoro_elastic.models.bound.joint_axes import placed_machine
from symoro_elastic.models.checks.loop_descriptions import described_loops
from symoro_elastic.models.checks.rotors import rotors
from symoro_elastic.numerics.verification.implementations import numpy_model
from symoro_elastic.pages.closed_chains import closed_chain
from tests.closed_chains.machines import FILES, machine
from tests.command_line import EXAMPLES, ended, run

pytestmark = pytest.mark.sampled(5)

FORMS = {
    "delta": {"leg_1": "inverse geometry", "leg_2": "inverse geometry", "leg_3": "inverse geometry"},
    "five_bar": {"diamond": "triangle"},
    "gantry": {"portal": "two slides"},
    "gantry_rigid": {"portal": "one joint"},
    "palletizer": {"drive": "constant map", "shoulder": "constant map", "elbow": "constant map"},
    "press": {"press": "triangle with a slide"},
    "ring": {"ring": "assembled"},
    "spatial_four_bar": {"linkage": "inverse geometry"},
    "sr400": {"parallelogram": "constant map"},
    "wedge": {"wedge": "two slides"},
}
SINGULAR = {
    "five_bar": "where the links between rod_2, tip and rod_1 meet stretched or folded: area of the triangle zero",
    "gantry": "where the slides carriage_2 and guide are parallel",
    "gantry_rigid": "nowhere: carriage_2 compensates the motion of the other joints",
    "press": "at the dead centre: the link between wrist_pin and rod stands at right angles to the slide slider",
    "ring": "where the rates of link_2, link_3, link_4, link_5 and link_6 do not follow from the others: det W_d = 0",
    "spatial_four_bar": "where the rates of cross, coupler and rocker do not follow from the others: det W_d = 0",
    "sr400": "nowhere: angles are sums of angles, in the flat position too",
    "wedge": "where the slides lift and face are parallel",
}
FOUR_BAR = """
name = "four_bar"
joints = [
  { name = "crank",  antecedent = 0,       kind = "motor",   sigma = 0, theta = "q1" },
  { name = "rod",    antecedent = "crank", kind = "passive", sigma = 0, d = 1, theta = "q2" },
  { name = "rocker", antecedent = 0,       kind = "passive", sigma = 0, d = "L0", theta = "q3" },
  { name = "pin",    antecedent = "rod",   kind = "cut",     sigma = 0, d = 2, theta = "q4" },
  { name = "end",    antecedent = "rocker", kind = "fixed",  sigma = 2, d = 2 },
]
[loops]
bars = { cut = "pin", meets = "end", start = { q1 = 3.141592653589793, q2 = 3.14, q3 = 3.14 } }
[parameters]
L0 = 3
[bodies]
crank = { mass = 1, center_of_mass = [0.5, 0, 0], inertia = [0.1, 0.1, 0.1] }
rod = { mass = 1, center_of_mass = [0.5, 0, 0], inertia = [0.1, 0.1, 0.1] }
rocker = { mass = 1, center_of_mass = [0.5, 0, 0], inertia = [0.1, 0.1, 0.1] }
"""
WRIST = """
name = "wrist"
joints = [
  { name = "turn",  antecedent = 0,      kind = "motor",   sigma = 0, theta = "q1" },
  { name = "tilt",  antecedent = "turn", kind = "motor",   sigma = 0, alpha = "pi/2", theta = "q2" },
  { name = "roll",  antecedent = "tilt", kind = "motor",   sigma = 0, alpha = "pi/2", theta = "q3" },
  { name = "rotor", antecedent = "tilt", kind = "coupled", sigma = 0, alpha = "pi/2", theta = "N*q3" },
]
[parameters]
N = 50
[bodies]
turn = { mass = 1, inertia_at_origin = [0, 0, 90] }
tilt = { mass = 1, inertia_at_origin = [1.5, 1.5, 1.5] }
roll = { mass = 1, inertia_at_origin = [0.4, 0.4, 0.4] }
rotor = { mass = 1, inertia_at_origin = [0.1, 0.1, 0.003] }
"""


def shown(found: Machine) -> Any:
    return closed_chain(found, placed_machine(found, {}))


@pytest.mark.parametrize("name", FORMS)
def test_how_each_loop_closes(name: str) -> None:
    assert {loop.plan.loop.name: loop.plan.form.value for loop in described_loops(machine(name))} == FORMS[name]


@pytest.mark.parametrize("name", SINGULAR)
def test_where_a_loop_is_singular(name: str) -> None:
    assert [loop.singular for loop in described_loops(machine(name))] == [SINGULAR[name]]


@pytest.mark.parametrize("name", [name for name in FILES if machine(name).loops])
def test_sums_of_angles_are_those_of_the_closed_position(name: str) -> None:
    at = placed_machine(machine(name), {}).q
    values = {str(joint.variable): at[joint.name] for joint in map(machine(name).joint, machine(name).with_variable)}
    for loop in described_loops(machine(name)):
        assert (loop.maps.keys() == loop.start.keys()) == (loop.plan.form.value == "constant map")
        for variable, text in loop.maps.items():
            terms = text.replace(" - ", " + -").split(" + ")
            total = sum(term(one, values) for one in terms)
            assert math.remainder(total - values[variable], 2 * math.pi) == pytest.approx(0, abs=1e-5)


def term(text: str, values: dict[str, float]) -> float:
    """A term such as `-0.5 q1`, `pi/2` or `-0.6`."""
    sign, names = (-1 if text.startswith("-") else 1), {**values, "pi/2": math.pi / 2, "pi": math.pi}
    factors = [names[x] if x in names else float(x) for x in text.removeprefix("-").split(" ")]
    return sign * math.prod(factors)


def test_equations_of_the_plane_and_reactions_that_are_not_determined() -> None:
    (loop,) = described_loops(machine("five_bar"))
    assert loop.dropped == "3 of 5 equations are fulfilled by the plane"
    assert loop.undetermined == ("force z", "moment x", "moment y")
    (ring,) = described_loops(machine("ring"))
    assert ring.dropped == "all 5 equations are needed" and ring.undetermined == ()


@pytest.mark.parametrize(("length", "bent", "near"), [("3", "3.14", True), ("2.9", "2.9", False)])
def test_a_start_next_to_a_singular_position_is_warned_of(length: str, bent: str, near: bool) -> None:
    """Crank 1 turned back from a base of 3: bars of 2 and 2 span 4, stretched; of 2.9 they span 3.9."""
    text = FOUR_BAR.replace("L0 = 3", f"L0 = {length}").replace("q2 = 3.14", f"q2 = {bent}")
    found = shown(toml.read(text, "bars.toml"))
    assert bool(found.warnings) is near
    assert all("loop bars: start is within 1e-6 of a singular position" in line for line in found.warnings)


def test_the_speed_from_which_a_rotor_matters() -> None:
    """Turn and roll at w: 0.4 w^2 of the roll and Z N w^2 of the rotor act on tilt, 2 kg m2.

    The moment of the rotor is 1 % of the result: of 1 rad/s2 and what both moments cause.
    """
    wrist = toml.read(WRIST, "wrist.toml")
    (rotor,) = rotors(wrist, placed_machine(wrist, {"tilt": math.pi / 2}).q)
    assert rotor.turning == ("turn", "roll") and rotor.has_body
    ZN = 50 * 0.003
    assert rotor.speed == pytest.approx(math.sqrt(0.01 * 2.0 / (ZN - 0.01 * (0.4 + ZN))), rel=1e-12)


BY_INERTIA = WRIST.replace("[0.1, 0.1, 0.003]", "[0.1, 0.1, 0]") + "[motors]\nrotor = { rotor_inertia = 0.003 }\n"


def test_there_the_rotor_body_differs_by_one_percent_from_its_inertia() -> None:
    """By the generated direct models of both, where a torque would give 1 rad/s2 at rest."""
    body, inertia = (toml.read(text, "wrist.toml") for text in (WRIST, BY_INERTIA))
    (rotor,) = rotors(body, placed_machine(body, {"tilt": math.pi / 2}).q)
    q, qd = np.array([0, math.pi / 2, 0]), rotor.speed * np.array([1.0, 0.0, 1.0])
    codes = (numpy_model(one, ("direct_dynamics",)) for one in (body, inertia))
    full, less = (code.direct_dynamics(q, qd, np.zeros(3))[1] for code in codes)
    assert abs(full - less) / (1 + abs(full)) == pytest.approx(0.01, rel=1e-9)


def test_a_ratio_has_the_speed_of_a_rotor_about_the_axis_of_the_joint() -> None:
    text = WRIST.replace("[bodies]", "[motors]\nroll = { rotor_inertia = 0.003, ratio = 50 }\n[bodies]")
    short = toml.read("\n".join(x for x in text.splitlines() if "rotor" not in x or "ratio" in x), "short.toml")
    (rotor,) = rotors(short, placed_machine(short, {"tilt": math.pi / 2}).q)
    assert not rotor.has_body
    assert rotor.speed == pytest.approx(math.sqrt(0.01 * 1.9 / (50 * 0.003 - 0.01 * 0.4)), rel=1e-12)


def test_an_inertia_on_a_coupled_joint_has_the_speed_of_a_rotor_that_turns_with_it() -> None:
    inertia = toml.read(BY_INERTIA, "wrist.toml")
    (rotor,) = rotors(inertia, placed_machine(inertia, {"tilt": math.pi / 2}).q)
    assert (rotor.has_body, rotor.turning) == (False, ("turn", "roll"))
    assert rotor.speed == pytest.approx(math.sqrt(0.01 * 2.0 / (50 * 0.003 - 0.01 * 0.4)), rel=1e-12)


def test_a_rotor_with_a_variable_of_its_own_has_the_speed_of_the_joint_that_it_drives() -> None:
    """Behind an elastic gear: at the speed of the roll, which the rotor drives, as that of a coupled rotor."""
    text = WRIST.replace('"motor",   sigma = 0, alpha = "pi/2", theta = "q3"', '"elastic", sigma = 0, ROLL')
    text = text.replace("ROLL", 'alpha = "pi/2", theta = "qm/N + q3", variable = "q3"')
    text = text.replace('kind = "coupled"', 'kind = "motor"').replace('"N*q3"', '"qm"')
    wrist = toml.read(text.replace("[bodies]", "[springs]\nroll = { stiffness = 1e4 }\n[bodies]"), "wrist.toml")
    (rotor,) = rotors(wrist, placed_machine(wrist, {"tilt": math.pi / 2}).q)
    assert (rotor.joint, rotor.has_body, rotor.turning) == ("rotor", True, ("turn", "roll"))
    ZN = 50 * 0.003
    assert rotor.speed == pytest.approx(math.sqrt(0.01 * 2.0 / (ZN - 0.01 * (0.4 + ZN))), rel=1e-12)
    (unknown,) = rotors(toml.read(text.replace("N = 50", "N = nan"), ""), placed_machine(wrist, {}).q)
    assert math.isnan(unknown.speed)


def test_a_joint_that_others_follow_faster_is_no_rotor() -> None:
    """The roll, whose body is one of revolution, too."""
    wrist = toml.read(WRIST.replace("N = 50", "N = 1"), "wrist.toml")
    assert [rotor.joint for rotor in rotors(wrist, placed_machine(wrist, {}).q)] == ["rotor"]


@pytest.mark.thorough
def test_rotors_on_the_base_matter_at_no_speed() -> None:
    linkage = json.loads(run("show", EXAMPLES / "linkage.toml", "--json").stdout)
    assert linkage["rotors"]["rotor"] == {"body": True, "speed": None, "turning": []}


@pytest.mark.thorough
def test_shared_torques_are_said() -> None:
    assert shown(machine("gantry_rigid")).driven == 3
    output = run("show", FILES["gantry_rigid"]).stdout
    assert "4 motors drive 3 freedoms: they share torques as carriage_1 2, carriage_2 1" in output


@pytest.mark.thorough
def test_show_names_variables_and_loops() -> None:
    output = run("show", EXAMPLES / "sr400.par").stdout
    assert "dependent variables (by closed forms): th3 of elbow, th8 of rod" in output
    assert "  th3 = th7 - th2 - pi/2\n" in output
    found = json.loads(run("show", EXAMPLES / "sr400.par", "--json").stdout)
    assert found["dependent"] == ["elbow", "rod"] and found["cut"] == ["pin"] and found["coupled"] == []
    assert found["motors"] == ["waist", "shoulder", "wrist_1", "wrist_2", "wrist_3", "crank"]
    loop = found["loops"]["parallelogram"]
    assert (loop["form"], loop["equations"], loop["dropped"]) == ("constant map", 5, 3)


def test_trees_have_no_lines_about_loops() -> None:
    output = run("show", EXAMPLES / "planar_2r.toml").stdout
    assert "independent variables" not in output and "loop" not in output


@pytest.mark.thorough
def test_positions_that_no_branch_reaches_are_refused() -> None:
    found = ended("show", FILES["delta"], "--at", "px=2")
    assert found.code == 2 and "leg_1, leg_2, leg_3 cannot close at this position" in found.err
    found = ended("show", EXAMPLES / "four_bar.par", "--at", "rod=1")
    assert "rod does not move by itself: independent joints are" in found.err


def of_length(pin: str) -> Machine:
    """The four-bar with bars of a length without value, the rod of `pin` of them."""
    text = FOUR_BAR.replace("L0 = 3", "L0 = nan").replace("d = 1,", 'd = "L0",').replace("d = 2,", f'd = "{pin}",')
    return toml.read(
        text.replace('kind = "fixed",  sigma = 2, d = 2', 'kind = "fixed", sigma = 2, d = "L0"'), "open.toml"
    )


def test_lengths_without_value_leave_dependent_joints_open() -> None:
    found = placed_machine(of_length("1.5*L0"), {})
    assert found.q["crank"] == math.pi and np.isnan([found.q["rod"], found.q["rocker"]]).all()


def test_a_parallelogram_needs_no_lengths() -> None:
    """It starts flat, as its crank points away from the rocker."""
    found = placed_machine(of_length("L0"), {"crank": 2.0})
    assert found.q["rod"] == pytest.approx(-2.0, abs=1e-15) and found.q["rocker"] == pytest.approx(2.0, abs=1e-15)
