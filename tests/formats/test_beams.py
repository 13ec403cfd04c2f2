"""Beams become rows: against beams and bars by their differential equations, rigid bodies, and scaling laws."""

from __future__ import annotations

from dataclasses import replace
from itertools import product
from pathlib import Path

import numpy as np
import pytest

import symoro_elastic as se
from symoro_elastic.formats.toml import reading as toml
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.beams.places import places_of
from symoro_elastic.machine.beams.sections import AXIAL, TORSION
from symoro_elastic.machine.checks import check
from symoro_elastic.machine.described import DescribedMachine
from symoro_elastic.machine.joints import Kind, Spring
from symoro_elastic.machine.views import beams_table, by_first_cell
from symoro_elastic.numerics.verification.implementations import numpy_model
from tests.references.beams import clamped_bar, clamped_beam, free_beam

LENGTH, STIFFNESS, LINE_MASS, LINE_INERTIA = 2.0, 3.0, 0.7, 0.2
MASS = LINE_MASS * LENGTH
BENDING = np.sqrt(STIFFNESS / LINE_MASS) / LENGTH**2 / (2 * np.pi)
"""Unit of bending frequencies, Hz."""
TIPS = ((0.0, 0.0), (0.25, 0.0), (1.0, 0.0), (5.0, 0.0), (1.0, 0.01), (5.0, 0.1))
"""Tip masses in beam masses, inertias in beam masses times the square of its length."""


def read(text: str) -> DescribedMachine:
    machine = toml.read(text, "beam.toml")
    check(machine)
    return machine


def beam(
    bends: str, keys: str, mass: float = 0.0, inertia: tuple[float, ...] = (0, 0, 0), of: str = ""
) -> DescribedMachine:
    """A beam on a wall, with a tip."""
    body = f"[bodies]\ntip = {{ mass = {mass}, center_of_mass = [0, 0, 0], inertia = {[*inertia]} }}" if mass else ""
    cells = of or f"EI = {STIFFNESS}, GJ = {STIFFNESS}, EA = {STIFFNESS}"
    return read(f"""
name = "walled"
gravity = [0, 0, 0]
joints = [ {{ name = "wall", kind = "fixed", antecedent = 0 }}, {{ name = "tip", kind = "fixed" }} ]
[beams]
wall = {{ along = "x", length = {LENGTH}, {cells}, mass_per_length = {LINE_MASS}, inertia_per_length = {LINE_INERTIA}, \
bends = [{bends}]{keys} }}
{body}
""")


def errors(bends: str, keys: str, tip: tuple[float, float], count: int) -> np.ndarray:
    """Errors of the first bending frequencies, %."""
    mass, inertia = tip[0] * MASS, tip[1] * MASS * LENGTH**2
    machine = beam(bends, keys, mass, (0, 0, inertia))
    return 100 * (se.modes(machine).frequencies[:count] / (BENDING * clamped_beam(*tip, count)) - 1)


@pytest.mark.parametrize("tip", TIPS)
def test_four_joints_give_three_frequencies(tip: tuple[float, float]) -> None:
    """The bounds that docs/flexible.md states."""
    assert np.all(np.abs(errors('"y"', "", tip, 3)) < [0.02, 0.02, 0.13])


@pytest.mark.sampled(3)
@pytest.mark.parametrize(
    ("keys", "bounds"),
    [
        ("joints = 2", [1.02]),
        ("joints = 3", [0.6, 1.1]),
        ("joints = 5", [0.005, 0.012, 0.07]),
        ('joints = 4, rule = "gauss"', [0.007, 0.48, 18]),
        ('joints = 4, rule = "equal"', [1.6, 5.3, 11]),
        ('joints = 10, rule = "equal"', [0.24, 0.82, 1.6]),
    ],
)
def test_errors_by_rule_are_those_of_the_page(keys: str, bounds: list[float]) -> None:
    """Worst of the tips; at least half of the bound is reached."""
    worst = np.max([np.abs(errors('"y"', f", {keys}", tip, len(bounds))) for tip in TIPS], axis=0)
    assert np.all(worst < bounds)
    assert np.all(worst > 0.5 * np.array(bounds))


def test_the_last_frequency_of_a_rule_is_no_prediction() -> None:
    assert errors('"y"', ', joints = 2, rule = "gauss"', (0.0, 0.0), 2)[1] == pytest.approx(63, abs=1)
    assert errors('"y"', "", (0.0, 0.0), 4)[3] == pytest.approx(174, abs=2)


@pytest.mark.parametrize(("kind", "position"), [(TORSION, 3), (AXIAL, 0)])
@pytest.mark.parametrize(("joints", "bounds"), [(2, [1.6]), (4, [0.6, 2.1]), (5, [0.001, 0.002])])
def test_bars(kind: str, position: int, joints: int, bounds: list[float]) -> None:
    line = LINE_INERTIA if kind == TORSION else LINE_MASS
    unit = np.sqrt(STIFFNESS / line) / LENGTH / (2 * np.pi)
    for tip in (0.0, 0.25, 1.0, 5.0):
        mass, inertia = (1e-9, (tip * line * LENGTH, 0, 0)) if kind == TORSION else (tip * line * LENGTH, (0, 0, 0))
        machine = beam(f'"{kind}"', f", joints = {joints}", mass, inertia)
        found = se.modes(machine).frequencies[: len(bounds)]
        assert np.all(np.abs(100 * (found / (unit * clamped_bar(tip, len(bounds))) - 1)) < bounds)


def test_gauss_is_no_better_than_equal_pieces_for_bars() -> None:
    unit = np.sqrt(STIFFNESS / LINE_MASS) / LENGTH / (2 * np.pi) * clamped_bar(0.0, 1)[0]
    gauss, equal, fitted = (
        abs(se.modes(beam('"axial"', f', joints = 4, rule = "{rule}"')).frequencies[0] / unit - 1)
        for rule in ("gauss", "equal", "fitted")
    )
    assert gauss > 0.9 * equal > 5 * fitted


def test_equal_pieces_win_for_a_free_beam() -> None:
    """A beam on slides and a pivot without mass: its root is held by nothing, for which no place is fitted."""
    rows = [f'{{ name = "{a}", kind = "passive", sigma = 1, axis = "{a}" }}' for a in ("x", "y")]
    worst = {}
    for rule in ("fitted", "equal"):
        machine = read(f"""
name = "free"
gravity = [0, 0, 0]
joints = [ {", ".join(rows)}, {{ name = "pivot", kind = "passive", sigma = 0, axis = "z" }} ]
[beams]
pivot = {{ along = "x", length = {LENGTH}, EI = 3, mass_per_length = {LINE_MASS}, bends = ["y"], rule = "{rule}" }}
""")
        elastic = [f for f in se.modes(machine).frequencies if f > 0.1 * BENDING]
        worst[rule] = abs(elastic[0] / (BENDING * free_beam(1)[0]) - 1)
    assert worst["equal"] < 1e-3
    assert 5e-3 < worst["fitted"] < 0.02


@pytest.mark.sampled(3)
@pytest.mark.parametrize("keys", ["", ", joints = 2", ", joints = 3", ", joints = 5", ', rule = "gauss"'])
def test_tip_compliance_is_exact(keys: str) -> None:
    C = se.stiffness(beam('"y", "z", "torsion", "axial"', keys, 1.0), frame="tip").compliance
    L, k = LENGTH, STIFFNESS
    a, b, c = L**3 / (3 * k), L**2 / (2 * k), L / k
    expected = np.diag([c, a, a, c, c, c])
    expected[1, 5] = expected[5, 1] = b
    expected[2, 4] = expected[4, 2] = -b
    np.testing.assert_allclose(C, expected, rtol=1e-9, atol=1e-9 * b)


@pytest.mark.parametrize(("load", "error"), [(0.5, 0.01), (-0.5, 0.0035), (-5.0, 0.012)])
def test_axial_loads_soften_and_stiffen(load: float, error: float) -> None:
    """A mass whose weight is `load` times the buckling load, on a beam without mass: by the beam-column's equation."""
    weight = load * np.pi**2 / 4 * STIFFNESS / LENGTH**2
    a = np.sqrt(abs(weight) / STIFFNESS) * LENGTH
    stiffness = weight / LENGTH / (np.tan(a) / a - 1 if load > 0 else np.tanh(a) / a - 1)
    machine = read(f"""
name = "loaded"
gravity = [{-weight}, 0, 0]
joints = [ {{ name = "wall", kind = "fixed", antecedent = 0 }}, {{ name = "tip", kind = "fixed" }} ]
[beams]
wall = {{ along = "x", length = {LENGTH}, EI = {STIFFNESS}, mass_per_length = 1e-7, bends = ["y"] }}
[bodies]
tip = {{ mass = 1, center_of_mass = [0, 0, 0], inertia = [0, 0, 0] }}
""")
    assert se.modes(machine).frequencies[0] == pytest.approx(np.sqrt(stiffness) / (2 * np.pi), rel=error)


def test_two_planes_have_their_own_stiffness() -> None:
    both = se.modes(beam('"y", "z"', "", of=f"EI = [{STIFFNESS}, {4 * STIFFNESS}]")).frequencies
    alone = se.modes(beam('"y"', "")).frequencies
    np.testing.assert_allclose(np.sort(both), np.sort([*alone, *(2 * alone)]), rtol=1e-12)


ARM = """
name = "arm"
gravity = [0, 0, -9.81]
joints = [
  { name = "turn", kind = "motor", sigma = 0, antecedent = 0, axis = "z", at = [0, 0, 0.5] },
  { name = "slide", kind = "motor", sigma = 1, axis = "x", at = [0.3, 0, 0.5] },
  { name = "wrist", kind = "motor", sigma = 0, axis = "y", in = "slide", at = [0.05, 0, 0.02] },
  { name = "tool", kind = "fixed", d = 0.1 },
]
[parameters]
L = { value = 1.2, unit = "m" }
D = { value = 0.12, unit = "m" }
Di = { value = 0.1, unit = "m" }
modulus = { value = 2.1e11, unit = "N/m2" }
[bodies]
turn = { mass = 20, center_of_mass = [0, 0, 0], inertia = [1, 1, 1] }
slide = { mass = 9, center_of_mass = [0.1, 0, 0], inertia = [1, 1, 1] }
wrist = { mass = 4, center_of_mass = [0, 0.05, 0], inertia = [0.1, 0.2, 0.15] }
[beams]
slide = { along = "x", length = "L", section = { tube = ["D", "Di"] }, E = "modulus", density = 7850, joints = 2 }
"""


def test_symbols_are_numbers() -> None:
    numbers = (
        ARM.replace('"L"', '"1200 mm"').replace('["D", "Di"]', '["120 mm", 0.1]').replace('"modulus"', '"210 GPa"')
    )
    (by_name, sensitivity), (by_number, _) = (
        (x.frequencies, x.sensitivity) for x in map(se.modes, map(read, (ARM, numbers)))
    )
    np.testing.assert_allclose(by_name, by_number, rtol=1e-9, atol=1e-4)
    assert {"L", "D", "Di", "modulus"} <= {*sensitivity.parameters}


def test_slopes_by_names_obey_the_scaling_laws() -> None:
    """Frequencies of a tube grow as sqrt(E), as its diameters, and as 1/L^2 of a slender one."""
    machine = read("""
name = "tube"
gravity = [0, 0, 0]
joints = [ { name = "wall", kind = "fixed", antecedent = 0 } ]
[parameters]
L = { value = 100, unit = "m" }
D = { value = 0.12, unit = "m" }
Di = { value = 0.1, unit = "m" }
modulus = { value = 2.1e11, unit = "Pa" }
[beams]
wall = { along = "z", length = "L", section = { tube = ["D", "Di"] }, E = "modulus", density = 7850, bends = ["x"] }
""")
    modes = se.modes(machine)
    slopes = dict(zip(modes.sensitivity.parameters, modes.sensitivity.relative[:, 0], strict=True))
    assert slopes["modulus"] == pytest.approx(0.5, abs=1e-9)
    assert slopes["L"] == pytest.approx(-2, abs=1e-5)
    assert slopes["D"] + slopes["Di"] == pytest.approx(1, abs=1e-5)


@pytest.mark.sampled(4)
@pytest.mark.parametrize("along", [sign + axis for sign in ("", "-") for axis in "xyz"])
@pytest.mark.parametrize("bends", ["torsion", "axial", "first second", "second torsion axial first"])
def test_a_beam_at_rest_is_a_rigid_body(along: str, bends: str) -> None:
    """Its end is where a fixed frame is, and the inertia about all axes that of a bar of its size."""
    first, second = sorted({*"xyz"} - {along[-1]})
    axis = "xyz".index(along[-1])
    point = np.zeros(3)
    point[axis] = -0.7 if along[0] == "-" else 0.7
    sides = np.insert([0.1, 0.3], axis, 0.7)
    mass = 1000 * sides.prod()
    inertia = (mass * (sides @ sides - sides**2) / 12).tolist()
    body = f"{{ mass = {mass}, center_of_mass = {(point / 2).tolist()}, inertia = {inertia} }}"
    rows = [
        f'{{ name = "{a}", kind = "motor", sigma = {sigma}, axis = "{a[0]}" }}'
        for sigma, a in ((1, "x1"), (0, "z"), (0, "y"), (0, "x"))
    ]
    listed = ", ".join(f'"{ {"first": first, "second": second}.get(kind, kind) }"' for kind in bends.split())
    seat = '{ name = "seat", kind = "fixed", gamma = 0.3, alpha = 0.2, d = 0.1 }'
    head = f'name = "turning"\ngravity = [0, 0, -9.81]\njoints = [ {", ".join(rows)}, {seat}, '
    flexible = read(
        f'{head}{{ name = "tip", kind = "fixed" }} ]\n[beams]\nseat = {{ along = "{along}", length = 0.7, '
        f"section = {{ bar = [0.1, 0.3] }}, E = 1e9, density = 1000, joints = 3, bends = [{listed}] }}\n"
    )
    tip = f'{{ name = "tip", kind = "fixed", at = {point.tolist()}, in = "seat" }}'
    rigid = read(f"{head}{tip} ]\n[bodies]\nseat = {body}\n")
    joints = tuple(
        replace(x, kind=Kind.FIXED, sigma=2, variable=None, spring=Spring()) if x.kind is Kind.ELASTIC else x
        for x in flexible.joints
    )
    q, qd, qdd = np.array([[0.1, 0.2, -0.4, 0.5], [1, 2, -1, 0.5], [3, 1, -2, 0.4]])
    held, expected = (
        numpy_model(machine, ("inverse_dynamics", "geometric_model"), {"geometric_model": ("tip",)})
        for machine in (replace(flexible, joints=joints), rigid)
    )
    np.testing.assert_allclose(held.geometric_model(q), expected.geometric_model(q), atol=1e-14)
    np.testing.assert_allclose(
        held.inverse_dynamics(q, qd, qdd), expected.inverse_dynamics(q, qd, qdd), rtol=1e-12, atol=1e-11
    )


def test_a_stiff_beam_is_a_rigid_body() -> None:
    """On a soft spring, with a body at its end: its frequency with E times 1e9 is that of the rigid machine."""
    head = """name = "soft"
gravity = [0, 0, 0]
joints = [
  { name = "bed", kind = "elastic", sigma = 0, antecedent = 0, axis = "z" },
  { name = "ram", kind = "fixed" },
  { name = "tool", kind = "fixed" PLACE },
]
[springs]
bed = { stiffness = 2e5 }
[bodies]
tool = { mass = 3, center_of_mass = [0.1, 0.05, 0], inertia = [0.1, 0.2, 0.3] }
"""
    mass = 7850 * 0.1**2 * 0.7
    body = (
        f"ram = {{ mass = {mass}, center_of_mass = [0.35, 0, 0], inertia = [0, 0, {mass * (0.7**2 + 0.1**2) / 12}] }}"
    )
    rigid = se.modes(read(head.replace("PLACE", ", d = 0.7") + body)).frequencies[0]
    text = '[beams]\nram = { along = "x", length = 0.7, section = { bar = [0.1, 0.1] }, E = 2.1eNN, density = 7850 }\n'
    stiff, soft = (
        se.modes(read(head.replace("PLACE", "") + text.replace("NN", power))).frequencies[0] for power in ("18", "9")
    )
    assert stiff == pytest.approx(rigid, rel=1e-6)
    assert soft < 0.9999 * rigid


@pytest.mark.parametrize("kind", ["y", TORSION, AXIAL])
def test_damping_is_the_ratio_of_the_first_frequency(kind: str) -> None:
    modes = se.modes(beam(f'"{kind}"', ", damping = 0.02, joints = 5"))
    assert modes.damping_ratios[0] == pytest.approx(0.02, rel=1e-4)


@pytest.mark.thorough
def test_a_beam_on_a_moving_joint_passes_check() -> None:
    assert se.check(read(ARM)).ok


def test_children_frames_and_numbers_of_rows_are_at_the_end() -> None:
    machine = read(
        ARM.replace('name = "tool", kind', 'name = "tool", antecedent = 3, kind') + '[frames]\neye = { on = "slide" }\n'
    )
    names = [joint.name for joint in machine.joints]
    carriers = {joint.name: machine.joint(joint.antecedent).name for joint in machine.joints if joint.antecedent}
    assert carriers["wrist"] == "slide_end"
    assert carriers["tool"] == "wrist"
    assert machine.frames[0].on == "slide_end"
    assert names.index("slide_root") == names.index("slide") + 1


def test_beams_are_shown() -> None:
    """A clamped tube of 1.2 m: mass by its section, frequencies by the textbook's formulas."""
    shown = by_first_cell(beams_table(read(ARM)))["slide"]
    area, moment = np.pi / 4 * (0.12**2 - 0.1**2), np.pi / 64 * (0.12**4 - 0.1**4)
    bending = 1.8751040687**2 / (2 * np.pi * 1.2**2) * np.sqrt(2.1e11 * moment / (7850 * area))
    torsion = np.sqrt(2.1e11 / 2.6 / 7850) / (4 * 1.2)
    assert (shown["mass, kg"], shown["joints or modes"]) == (f"{7850 * area * 1.2:.6g}", "2+2+1")
    assert shown["first frequencies if clamped, Hz"] == f"y {bending:.5g}, z {bending:.5g}, torsion {torsion:.5g}"


def test_corrected_springs_are_written_beside_the_beam(tmp_path: Path) -> None:
    """As `update` does: the file keeps its beam, the entries by the names of its rows win."""
    like = tmp_path / "arm.toml"
    like.write_text(ARM, encoding="utf-8")
    machine = read(ARM)
    stiffness = toml.Formula.parse(4.5e6)
    joints = tuple(
        replace(joint, spring=replace(joint.spring, stiffness=stiffness)) if joint.name == "slide_y1" else joint
        for joint in machine.joints
    )
    se.write(replace(machine, joints=joints), tmp_path / "fitted.toml", like=like)
    text = (tmp_path / "fitted.toml").read_text(encoding="utf-8")
    assert ARM.strip() in text
    assert read(text).joints == joints


@pytest.mark.thorough
def test_a_cell_carries_a_beam() -> None:
    """The springs of both are there, and a beam on a cell is one on a fixed row that the cell carries."""
    cell = ARM.replace('"motor", sigma = 1, axis = "x"', '"elastic", sigma = 6')
    springs = "[springs]\nslide = { stiffness = [1e7, 2e7, 3e7, 4e5, 5e5, 6e5] }\n"
    row = "sigma = 6, at = [0.3, 0, 0.5] }"
    apart = cell.replace(row, f'{row}, {{ name = "root", kind = "fixed" }}')
    apart = apart.replace('in = "slide"', 'in = "root"').replace("slide = { along", "root = { along")
    ours, theirs = (read(text + springs) for text in (cell, apart))
    assert len(ours.joints) == len(theirs.joints) - 1
    np.testing.assert_allclose(se.modes(ours).frequencies, se.modes(theirs).frequencies, rtol=1e-9, atol=1e-4)


TABLE = """
name = "walled"
gravity = [0, 0, 0]
joints = [
  { name = "wall", kind = "fixed", antecedent = 0 },
  { name = "tip", kind = "motor", sigma = 0, axis = "z", in = "wall" },
]
[parameters]
D = { value = 0.1, unit = "m" }
[bodies]
tip = { mass = 1, center_of_mass = [0, 0, 0], inertia = [1, 1, 1] }
[beams]
wall = { along = "x", length = 1, section = { tube = ["D", 0.08] }, E = "210 GPa", density = 7850 }
"""
CELLS = "EI = 3, mass_per_length = 2 }"
SECTION = TABLE[TABLE.index("section") : -1]


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("0.08]", "0.1]", "beam wall, section: the inner diameter 0.1 m is not below the outer one, 0.1 m"),
        ("0.08]", "-0.1]", "beam wall, section: sizes of a tube must be above 0"),
        ('tube = ["D", 0.08]', "box = [0.1, 0.2, 0.05]", "two walls of 0.05 m fill the side of 0.1 m"),
        ('tube = ["D", 0.08]', "pipe = [0.1, 0.2]", "beam wall, section, pipe: no such key here"),
        ('tube = ["D", 0.08]', "rod = 0.1, bar = [1, 2]", "beam wall, section: must be one of rod, tube, bar, box"),
        ('tube = ["D", 0.08]', "tube = [0.1]", "beam wall, section, tube: has 1 entries, expected 2"),
        ("length = 1", "length = 0", "beam wall, length: '0' must be above 0"),
        ("length = 1", "length = 1e300", "beam wall: numbers or formulas that are too large"),
        ("density", "damping = -1, density", "beam wall, damping: '-1' must not be negative"),
        ("density", "joints = 0, density", "beam wall, joints: 0 is not from 2 to 5, which the rule fitted has"),
        ("density", "joints = 6, density", 'which the rule fitted has: rule = "gauss" or "equal" have others'),
        ("density", 'rule = "gaus", density', "beam wall, rule: no rule 'gaus'; did you mean 'gauss'?"),
        ("density", 'bends = ["x"], density', "beam wall, bends: no deflection 'x' along x"),
        ("density", "EI = 3, density", "beam wall, EI: follows from the section: remove one of the two"),
        (", density = 7850", "", "beam wall, density: is missing, which the section needs"),
        ('along = "x"', 'along = "u"', "beam wall, along: no along 'u'"),
        ('along = "x", ', "", "beam wall, along: is missing"),
        ("wall = { along", "wal = { along", "beams: no joint 'wal'; did you mean 'wall'?"),
        ('in = "wall"', 'in = "wall", at = [-0.4, 0, 0]', "it is 0.4 m before the end of the beam wall"),
        ('in = "wall"', 'antecedent = "wall", at = [0.25, 0, 0]', "it is 0.75 m before the end of the beam wall"),
        ("[beams]", '[frames]\neye = { on = "wall", at = [-0.5, 0, 0] }\n[beams]', "frame eye, on: it is 0.5 m before"),
        (
            '"wall", kind = "fixed"',
            '"wall", kind = "cut", sigma = 2',
            "beams: 'wall' is a cut joint, which carries nothing",
        ),
        (SECTION, "mass_per_length = 2 }", "EI: is missing"),
        (SECTION, f"G = 3, {CELLS}", "G: needs a section"),
        (SECTION, f'bends = ["axial"], {CELLS}', "bends: axial needs EA, or a section and E"),
        (SECTION, f"GJ = 2, {CELLS}", "inertia_per_length: is missing: torsion needs it"),
    ],
)
def test_refusals(old: str, new: str, message: str) -> None:
    assert old in TABLE
    with pytest.raises(InputError) as refusal:
        read(TABLE.replace(old, new, 1))
    assert message in str(refusal.value)
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('"210 GPa"', "210000", 'E = 210000 N/m2 is no solid\'s; write the unit, as "210000 MPa", if meant'),
        ("7850", "7.85e-9", 'density = 7.85e-09 kg/m3 is no solid\'s; write the unit, as "7.85e-09 t/mm3", if meant'),
        ('"D", 0.08', "100, 80", "length 1 m is below 5 times the size 100 m of the section"),
    ],
)
def test_numbers_in_millimetres_and_tonnes_are_doubted(old: str, new: str, message: str) -> None:
    assert any(message in line for line in check(toml.read(TABLE.replace(old, new), "beam.toml")))
    assert not check(toml.read(TABLE, "beam.toml"))


def test_every_rule_spreads_the_compliance() -> None:
    for rule, joints, is_bar in product(("fitted", "gauss", "equal"), (2, 3), (False, True)):
        places, shares = places_of(rule, joints, is_bar)
        assert sum(shares) == pytest.approx(1, abs=1e-12)
        assert 0 < places[0] < places[-1] < 1
