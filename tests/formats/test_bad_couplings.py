"""What is wrong with couplings and loops is said in one line that names file, joint or loop, and the way out."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import symoro_elastic as se
from symoro_elastic.formats.toml import reading as toml
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.checks import check
from symoro_elastic.machine.formula import ZERO, Formula
from symoro_elastic.machine.machine import Joint, Kind, Machine, Wrench
from symoro_elastic.models.packaging import reserved_words
from symoro_elastic.models.programs.catalogue import MODELS
from tests.machine.samples import COUPLED

RING = COUPLED.index("[loops.ring]"), COUPLED.index("[parameters]")
SIDE = '\n  { name = "side", antecedent = 0, kind = "KIND", sigma = SIGMA, CELL },\n]\n[loops.ring]'


def side(cell: str, kind: str = "motor", sigma: int = 0) -> str:
    """One more row."""
    return SIDE.replace("KIND", kind).replace("SIGMA", str(sigma)).replace("CELL", cell)


def two(entry: str) -> str:
    """A second loop, with these entries."""
    return f"{entry}\n[parameters]"


def message(machine: Machine) -> str:
    with pytest.raises(InputError) as caught:
        check(machine, reserved_words(), MODELS)
    return said(caught.value)


def said(error: InputError) -> str:
    text = str(error)
    assert text.startswith("arm.toml: ") and "\n" not in text and len(text) < 500
    return text.removeprefix("arm.toml: ")


def read_message(*changes: tuple[str, str]) -> str:
    text = COUPLED
    for old, new in changes:
        assert old in text
        text = text.replace(old, new, 1)
    try:
        machine = toml.read(text, "arm.toml")
    except InputError as error:
        return said(error)
    return message(machine)


END, LOOP = "]\n[loops.ring]", "[parameters]"

# What is replaced in the sample, by what, the place that must be named, and what is said there.
BAD = [
    # cells and own variables
    (
        *('"qm/N1 + q4"', '"q4 + d_belt"', "joint 5 (crank), theta"),
        'the cell holds q4 and d_belt, both new: write variable = "d_belt"; parameters are declared in [parameters]',
    ),
    (
        *('"qm/N1 + q4"', '"qm/N2 + q4*2 + d"', "joint 5 (crank), theta"),
        'the cell holds N2, q4 and d, all new: write variable = "d"; parameters are declared in [parameters]',
    ),
    (
        *('theta = "qm/N1 + q4"', 'theta = "qm/N1 + q4", variable = "q9"', "joint 5 (crank), variable"),
        "'q9' does not occur in theta = 'qm/N1 + q4'",
    ),
    (
        *('theta = "N1*q1"', 'theta = "N1*q1", variable = "q1"', "joint 2 (rotor), variable"),
        "a coupled joint has no variable of its own: leave it out",
    ),
    (
        *('kind = "fixed", d', 'kind = "fixed", variable = "q1", d', "joint 9 (pin_end), variable"),
        "a fixed frame has no variable of its own: leave it out",
    ),
    (
        *('"qm/N1 + q4"', '"qm/N1"', "joint 5 (crank), theta"),
        'the cell holds variables of other joints only (qm): add one of its own, or write kind = "coupled"',
    ),
    (
        *('"qm/N1 + q4"', '"qm/N1 + 2*q4"', "joint 5 (crank), theta"),
        "'qm/N1 + 2*q4' must be the joint variable 'q4', alone or plus a constant or a formula of the variables of "
        "other joints",
    ),
    (
        *('"qm/N1 + q4"', '"q4 + qm/N1*q4"', "joint 5 (crank), theta"),
        "'q4 + qm/N1*q4' must be the joint variable 'q4', alone or plus a constant or a formula of the variables of "
        "other joints",
    ),
    (
        *('theta = "N1*q1"', 'theta = "N1*pi"', "joint 2 (rotor), theta"),
        "'N1*pi' holds no variable of another joint: a joint that does not move is fixed, with sigma = 2",
    ),
    (
        *('theta = "N1*q1"', 'theta = "N1*q11"', "joint 2 (rotor), theta"),
        "'q11' is not declared in [parameters]; did you mean 'q1'? (declare it: q11 = 1.5, or nan for a name without "
        "value)",
    ),
    (
        *('theta = "N1*q1"', 'theta = "N1*q6"', "joint 2 (rotor), theta"),
        "'q6' is the variable of the cut joint pin, which follows from its loop: leave it out",
    ),
    (
        *('theta = "q6"', 'theta = "q6 + q1"', "joint 8 (pin), theta"),
        "'q1' is the variable of joint 1 (waist): only numbers and parameters are allowed here; a joint that follows "
        "it is coupled, with the formula in theta (sigma = 0) or r (sigma = 1)",
    ),
    (
        *('kind = "fixed", d = "L3"', 'kind = "fixed", d = "L3*q1"', "joint 9 (pin_end), d"),
        "'q1' is the variable of joint 1 (waist): only numbers and parameters are allowed here; a joint that follows "
        "it is coupled, with the formula in theta (sigma = 0) or r (sigma = 1)",
    ),
    (
        *("{ mass = 9 }", '{ mass = "9 + q1" }', "joint 4 (forearm), mass"),
        "'q1' is the variable of joint 1 (waist): only numbers and parameters are allowed here; a joint that follows "
        "it is coupled, with the formula in theta (sigma = 0) or r (sigma = 1)",
    ),
    (
        *("(1 + q2^2)", "(1 + q22^2)", "joint 5 (crank), stiffness"),
        "'q22' is not declared in [parameters]; did you mean 'q2'? (declare it: q22 = 1.5, or nan for a name without "
        "value)",
    ),
    (
        *("(1 + q2^2)", "(1 + q6^2)", "joint 5 (crank), stiffness"),
        "'q6' is the variable of the cut joint pin, which follows from its loop: leave it out",
    ),
    ('"3e4/(1 + q2^2)"', '"3e4*q2/0"', "joint 5 (crank), stiffness", "division by zero"),
    # units
    (
        *(END, side('r = "q1 + s"', sigma=1), "joint 11 (side), r"),
        "q1 is an angle, added to a length in 'q1': a radius or a pitch is missing, as in R*q1",
    ),
    (
        *('r = "L3*sin(q3)"', 'r = "-q3"', "joint 10 (jaw), r"),
        "q3 is an angle, added to a length in '-q3': a radius or a pitch is missing, as in R*q1",
    ),
    (
        *(
            END,
            '\n  { name = "s", kind = "motor", sigma = 1, r = "z" },' + side('theta = "z - L2*q1"', "coupled"),
            "joint 12 (side), theta",
        ),
        "z is a length, added to an angle in 'z - L2*q1': a radius or a pitch is missing, as in R*q1",
    ),
    (
        *(
            END,
            '\n  { name = "s", kind = "motor", sigma = 1, r = "z" },' + side('theta = "2*(z + q1)"', "coupled"),
            "joint 12 (side), theta",
        ),
        "q1 is an angle, added to a length in '2*(z + q1)': a radius or a pitch is missing, as in R*q1",
    ),
    # what acts on coupled joints, ratios, shares
    (
        *("crank = { stiffness", "rotor = { damping = 1 }\ncrank = { stiffness", "joint 2 (rotor), damping"),
        "a coupled joint has no variable of its own: add one to the cell, or move the spring to a joint that has",
    ),
    (
        *("arm = { rotor", "rotor = { sharing = 1 }\narm = { rotor", "joint 2 (rotor), sharing"),
        "a coupled joint has no variable of its own: add one to the cell, or move the motor to a joint that has",
    ),
    (
        *("arm = { rotor", "crank = { sharing = 1 }\narm = { rotor", "joint 5 (crank), sharing"),
        "the joint is elastic: only motors share a torque",
    ),
    (
        *("arm = { rotor", 'waist = { sharing = "1 - N1" }\narm = { rotor', "joint 1 (waist), sharing"),
        "'1 - N1' is negative: -99",
    ),
    (
        *("arm = { rotor_inertia = 5e-4, ", "arm = { ", "joint 3 (arm), ratio"),
        "a ratio needs a rotor_inertia, that of the rotor about its own axis",
    ),
    # cut joints
    *(
        (
            old,
            new,
            f"joint 8 (pin), {key}",
            f"the cut joint carries no {what}: cut the loop elsewhere (passive joints of it: q3, q5)",
        )
        for old, new, key, what in (
            ("[bodies]", "[bodies]\npin = { mass = 1 }", "mass", "motor, spring or body"),
            ("[springs]", "[springs]\npin = { stiffness = 1 }", "stiffness", "motor, spring or body"),
            ("[motors]", "[motors]\npin = { rotor_inertia = 1 }", "rotor_inertia", "motor, spring or body"),
            ("[motors]", "[motors]\npin = { sharing = 1 }", "sharing", "motor, spring or body"),
            ("[friction]", "[friction]\npin = { viscous = 1 }", "viscous friction", "friction"),
        )
    ),
    (
        *('{ name = "jaw", antecedent = "forearm"', '{ name = "jaw", antecedent = "pin"', "joint 10 (jaw), antecedent"),
        "pin is a cut joint, which carries no other: hang it on rod",
    ),
    (
        *(COUPLED[slice(*RING)], "", "joint 8 (pin), kind"),
        'no loop is closed by this cut joint: write [loops] name = { cut = "pin", meets = "..." }, or give it another '
        "kind",
    ),
    (
        'kind = "cut", sigma = 0',
        'kind = "cut"',
        "joint 8 (pin), sigma",
        "is missing: 0 revolute, 1 prismatic, 2 fixed frame",
    ),
    # ends of loops
    ('cut = "pin"', 'cut = "pen"', "loop ring, cut", "no joint 'pen'; did you mean 'pin'?"),
    ('meets = "pin_end"', "meets = 9", "loop ring, meets", "must be a text in quotes"),
    ('meets = "pin_end"\n', "", "loop ring, meets", "is missing"),
    (
        'meets = "pin_end"',
        'closes = "line"\nmeets = "pin_end"',
        "loop ring, closes",
        "no closes 'line'; there are: frame, point",
    ),
    ("start = {", "starts = {", "loop ring, starts", "no such key here; did you mean 'start'?"),
    (
        *('meets = "pin_end"', 'meets = "pin"', "loop ring, meets"),
        "pin is the cut joint itself: name the fixed frame that it meets",
    ),
    (
        *('meets = "pin_end"', 'meets = "forearm"', "loop ring, meets"),
        "forearm is not a fixed frame: the cut joint meets a row of its own, of kind fixed",
    ),
    (
        *('meets = "pin_end"', 'meets = "pin_end"\ncloses = "point"', "loop ring, closes"),
        "a ball joint has no variable in the table: give pin sigma = 2",
    ),
    (
        *(LOOP, two('[loops.other]\ncut = "rod"\nmeets = "pin_end"'), "loop other, cut"),
        'rod is not a cut joint: its row needs kind = "cut"; there are: pin',
    ),
    (
        *(LOOP, two('[loops.other]\ncut = "pin"\nmeets = "pin_end"'), "loop other, cut"),
        "pin belongs to loop ring: each loop has a cut joint and a fixed frame of its own",
    ),
    (
        *("[loops.ring]", '[loops."a b"]', "loop 'a b'"),
        "this name cannot be used: a name is made of ASCII letters, digits and underscores, and starts with a letter",
    ),
    # dependent joints
    ('"q3", "rod"', '"q3", "rodd"', "loop ring, dependent", "no joint 'rodd'; did you mean 'rod'?"),
    (
        *('"q3", "rod"', '"q3", "waist"', "loop ring, dependent"),
        "waist is not a joint of the loop: those are arm, forearm, crank, drive, rod",
    ),
    (
        *('"q3", "rod"', '"q3", "pin"', "loop ring, dependent"),
        "pin is the cut joint, whose variable follows anyway: leave it out",
    ),
    (
        *('"q3", "rod"', '"q3", "jaw"', "loop ring, dependent"),
        "jaw is coupled and has no variable of its own: name the joint that it follows",
    ),
    ('"q3", "rod"', '"rod", "rod"', "loop ring, dependent", "a joint is given twice: keep one"),
    # start
    ("q3 = 1.5", "q33 = 1.5", "loop ring, start", "no joint variable 'q33'; did you mean 'q3'?"),
    ("q3 = 1.5", 'q3 = "N3"', "loop ring, start, q3", "'N3' is not declared in [parameters]; did you mean 'N1'?"),
    ("q3 = 1.5", 'q3 = "1/0"', "loop ring, start, q3", "'1/0' has no value: it divides by zero"),
    (
        *("N1 = 100", "N1 = nan", "loop ring, start, qm"),
        "N1 has no value, but numbers select the branch: give it one, or write a number",
    ),
    # antecedents
    (
        *('antecedent = "arm", kind', 'antecedent = "rod", kind', "joint 4 (forearm), antecedent"),
        "7 must be 0 (the base) or a row above 4: joints are numbered from the base outwards; closed loops are written "
        "with a row of kind cut, in [loops]",
    ),
]


@pytest.mark.parametrize(("old", "new", "place", "what"), BAD, ids=[f"{place}: {new[:30]}" for _, new, place, _ in BAD])
def test_one_line_names_joint_or_loop(old: str, new: str, place: str, what: str) -> None:
    assert read_message((old, new)) == f"{place}: {what}"


def test_the_sample_itself_is_good() -> None:
    assert check(toml.read(COUPLED, "arm.toml"), reserved_words(), MODELS) == []


TWO_RINGS = COUPLED.replace(
    END,
    """
  { name = "pin_2", antecedent = "rod", kind = "cut", sigma = 0, d = "L2", theta = "q7" },
  { name = "pin_2_end", antecedent = "forearm", kind = "fixed", d = "L3" },
]
[loops.other]
cut = "pin_2"
meets = "pin_2_end"
[loops.ring]""",
)


def with_entry(entry: str) -> Machine:
    """Two loops, the first with one more entry."""
    return toml.read(TWO_RINGS.replace('meets = "pin_2_end"', f'meets = "pin_2_end"\n{entry}'), "arm.toml")


def test_a_loop_closed_twice_is_warned_about() -> None:
    assert check(with_entry("")) == ["loop ring: it closes around the same joints as loop other: closed twice?"]


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("q3 = 1.5", "q3 = 90", ["q3 = 90 is 14.3 turns, as angles are in rad: degrees? write pi/2"]),
        ("q3 = 1.5", "q3 = 1.5, q6 = -45", ["q6 = -45 is -7.16 turns, as angles are in rad: degrees? write -pi/4"]),
        ("q2 = 1,", "q2 = 6.2,", []),
        ('qm = "2.5*N1"', "qm = -700", []),
        ("q4 = 0", "q4 = 8", []),
    ],
)
def test_a_start_in_degrees_is_questioned(old: str, new: str, said: list[str]) -> None:
    """Of a cut joint too; not of a drive, nor of the joint behind it."""
    text = COUPLED.replace(old, new)
    assert text != COUPLED
    assert check(toml.read(text, "arm.toml")) == [f"loop ring, start: {line}" for line in said]


def test_loops_that_contradict_are_refused() -> None:
    assert message(with_entry('dependent = ["q3"]')) == (
        "loop ring, dependent: forearm follows from loop other already: name another joint of the loop"
    )
    start = "start = { q2 = 1, q3 = 1.4, q4 = 0, qm = 250, q5 = -1.5 }"
    assert message(with_entry(start)) == (
        "loop ring, start, q3: 1.5 contradicts 1.4 of loop other: a joint has one position"
    )
    assert check(with_entry(start.replace("1.4", "1.50")))


def test_loops_end_in_frames_of_their_own() -> None:
    machine = with_entry("")
    first, second = machine.loops
    assert message(replace(machine, loops=(first, replace(second, meets=first.meets)))) == (
        "loop ring, meets: pin_2_end belongs to loop other: each loop has a cut joint and a fixed frame of its own"
    )
    assert message(replace(machine, loops=(first, replace(second, cut=13)))) == (
        "loop ring, cut: row 13 is missing: the table has 12"
    )
    assert message(replace(machine, loops=(first, replace(second, name="other")))) == (
        "loop 'other': this name cannot be used: two loops have it"
    )


def test_a_loop_through_fixed_frames_only_is_refused() -> None:
    text = """joints = [
  { name = "base", kind = "fixed" },
  { name = "a", antecedent = "base", kind = "fixed", d = 1 },
  { name = "b", antecedent = "base", kind = "fixed", d = 2 },
  { name = "pin", antecedent = "a", kind = "cut", sigma = 0, d = 1, theta = "q1" },
]
[loops]
ring = { cut = "pin", meets = "b" }
"""
    assert message(toml.read(text, "arm.toml")) == (
        "loop ring, cut: no joint between pin and b moves: all of the loop is fixed"
    )


def test_a_loop_without_passive_joints_names_those_that_depend() -> None:
    text = COUPLED.replace("passive", "motor").replace('dependent = ["q3", "rod"]\n', "")
    assert message(toml.read(text, "arm.toml")) == (
        "loop ring, dependent: the loop has no passive joint: name those that follow from the others"
    )


def chain(*cells: str) -> Machine:
    """Revolute motors; a cell that begins with the name of its own variable."""
    rows = [
        Joint(f"j{j}", j - 1, Kind.MOTOR, 0, cell.split()[0], theta=Formula.parse(cell.partition("+ ")[2] or 0))
        for j, cell in enumerate(cells, start=1)
    ]
    return Machine("arm", tuple(rows), source="arm.toml")


@pytest.mark.parametrize(
    ("cells", "said"),
    [
        (("q1 + q5", "q3 + q1", "q5 + 2*q3"), "joint 1 (j1), theta: theta needs q5, which needs q3, which needs theta"),
        (("q1", "q2 + q4 + q1", "q3", "q4 + q2"), "joint 2 (j2), theta: theta needs q4, which needs theta"),
    ],
)
def test_cycles_are_named(cells: tuple[str, ...], said: str) -> None:
    assert message(chain(*cells)) == f"{said}: break the cycle"


def test_chains_of_cells_are_no_cycle() -> None:
    check(chain("q1 + q2 + q3", "q2 + q3", "q3"))
    check(chain(*(f"q{j} + {'q' + str(j + 1) if j < 300 else '1'}" for j in range(1, 301))))


def test_machines_built_in_python_are_checked_too() -> None:
    machine = toml.read(COUPLED, "arm.toml")

    def changed(j: int, joint: Joint) -> Machine:
        return replace(machine, joints=(*machine.joints[: j - 1], joint, *machine.joints[j:]))

    assert message(changed(1, replace(machine.joint(1), theta=Formula.parse("2*q1")))) == (
        "joint 1 (waist), theta: 'q1' is in the cell twice: a joint is its variable plus other variables"
    )
    assert message(changed(2, replace(machine.joint(2), variable="q7"))) == (
        "joint 2 (rotor), joint variable: a coupled joint has no variable of its own: remove 'q7'"
    )
    weight = Wrench(force=(ZERO, ZERO, Formula.parse(1)))
    assert message(changed(8, replace(machine.joint(8), wrench=weight))) == (
        "joint 8 (pin), force z: the cut joint carries no wrench: cut the loop elsewhere (passive joints of it: q3, q5)"
    )


@pytest.mark.parametrize(
    "cell", ["1*q1 + s", "q1/(2*pi) + s", "L2*(q1 - q2) + s", "sin(q1) + s", "s - L3*q1^2", "s + sqrt(q1^2 + q2^2)"]
)
def test_couplings_with_a_pitch_are_legal(cell: str) -> None:
    check(toml.read(COUPLED.replace(END, side(f'r = "{cell}", variable = "s"', sigma=1)), "arm.toml"))


def test_a_ratio_that_no_gear_has_is_warned_about() -> None:
    """In the motor's ratio, in the cell of the rotor, and in that of the joint behind the gear."""
    found = check(toml.read(COUPLED.replace("N1 = 100", "N1 = 2e4"), "arm.toml"))
    assert found == [
        "joint 2 (rotor): theta = N1*q1: the joint turns 20000 times as fast as q1; is this meant?",
        "joint 3 (arm): ratio = N1: the rotor turns 20000 times as fast as the joint; is this meant?",
        "joint 5 (crank): theta = qm/N1: qm turns 20000 times as fast as the joint; is this meant?",
    ]


@pytest.mark.parametrize(
    "cell", ["1e4*q1", "q1/1e4", "q1 + 1e-5*q2", "2e4*sin(q1)", "q1*q2*1e5", "1/q1", "N*q1", "1e6"]
)
def test_other_cells_are_no_gears_beyond_measure(cell: str) -> None:
    """Gears up to 10000, small couplings beside a large one, cams, ratios without value."""
    text = COUPLED.replace('"N1*q1"', f'"{cell} + 0*q1"').replace("N1 = 100", "N1 = 100\nN = nan")
    assert check(toml.read(text, "arm.toml")) == []


def test_a_rotor_with_a_body_and_a_rotor_inertia_is_questioned() -> None:
    row = side('theta = "50*q1"', "coupled")
    text = COUPLED.replace(END, row).replace("[motors]", "[motors]\nside = { rotor_inertia = 1e-3 }")
    body = "[bodies]\nside = { mass = 1, center_of_mass = [X, 0, 0], inertia = [1e-3, 1e-3, 2e-3] }"
    questioned, eccentric = (
        check(toml.read(text.replace("[bodies]", body.replace("X", x)), "arm.toml")) for x in ("0", "0.1")
    )
    assert questioned == [
        "joint 11 (side): inertia ZZ of the body and rotor_inertia are both counted: one of them where they are of the "
        "same rotor"
    ]
    assert check(toml.read(text, "arm.toml")) == eccentric == []


def test_a_rotor_that_moves_with_other_joints_than_its_torque_is_questioned() -> None:
    """On a row whose cell is a sum: the remedy, a row of its own, gives inertia to the variable of the motor alone."""
    joints = """gravity = [0, 0, 0]
    joints = [
      { name = "a", kind = "motor", sigma = 0, theta = "q1" },
      { name = "b", antecedent = "a", kind = "motor", sigma = 0, d = 0.5, theta = "q2 - q1/2", variable = "q2" },
      { name = "rotor", antecedent = 0, kind = "coupled", sigma = 0, theta = "q2" },
    ]
    [bodies]
    a = { mass = 1, center_of_mass = [0.1, 0, 0] }
    b = { mass = 1, center_of_mass = [0.1, 0, 0] }
    """
    summed = joints + "[motors]\nb = { rotor_inertia = 0.3 }"
    apart = joints + "[motors]\nrotor = { rotor_inertia = 0.3 }"
    (warning,) = check(toml.read(summed, "arm.toml"))
    assert warning == (
        "joint 2 (b): rotor_inertia moves with all of theta, -q1/2 too, the torque of the motor acts on q2: a rotor "
        'that moves with q2 alone is a row of its own, kind = "coupled", theta = "q2", with the rotor_inertia'
    )
    assert check(toml.read(apart, "arm.toml")) == []
    q = np.array([0.3, -0.4])
    bare, added, own = (
        se.load(toml.read(text, "arm.toml"), "inertia_matrix").inertia_matrix(q) for text in (joints, summed, apart)
    )
    np.testing.assert_allclose(added - bare, 0.3 * np.array([[0.25, -0.5], [-0.5, 1]]), atol=1e-15)
    np.testing.assert_allclose(own - bare, np.diag([0, 0.3]), atol=1e-15)


def test_frames_of_cut_joints_are_not_asked_for() -> None:
    for asked in ("pin", "tool in pin"):
        text = COUPLED.replace('"jaw"', '"tool"').replace("jaw =", "tool =")
        machine = toml.read(
            text + f'[scene]\nmodels = ["jacobian"]\noutputs = {{ jacobian = ["{asked}"] }}', "arm.toml"
        )
        assert message(machine) == (
            "scene, outputs, jacobian: pin is the cut joint of loop ring: name the frame that it meets, pin_end"
        )


def test_motors_of_different_types_that_share_are_warned_about() -> None:
    shares = "waist = { sharing = 1 }\nside = { sharing = 2 }\narm = { rotor"
    for cell, sigma, expected in (
        ('r = "s"', 1, ["sharing: waist turns and side slides: N m and N have equal weights"]),
        ('theta = "s"', 0, []),
    ):
        text = COUPLED.replace(END, side(cell, sigma=sigma)).replace("arm = { rotor", shares)
        found = check(toml.read(text.replace("[bodies]", "[bodies]\nside = { mass = 1 }"), "arm.toml"))
        assert found == expected
