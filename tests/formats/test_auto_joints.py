"""`joints = "auto"`: errors predicted by small matrices against those of the machine, by the beam's equation."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import symoro_elastic as se
from symoro_elastic.formats.toml import reading as toml
from symoro_elastic.formats.toml.flexible.auto_joints import bodies_beside
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.beams.deflections import Bending, Joints
from symoro_elastic.machine.beams.errors import bending_of
from symoro_elastic.machine.beams.places import places_of
from symoro_elastic.machine.checks import check
from symoro_elastic.machine.described import DescribedMachine
from symoro_elastic.machine.views import beams_table, by_first_cell
from tests.command_line import EXAMPLES
from tests.formats.test_beams import TIPS
from tests.references.beams import clamped_bar, clamped_beam, free_beam

RULES = ("fitted", "gauss", "equal")


class Drawn:
    """A beam along any axis with a tip mass that has an inertia, and its exact frequencies."""

    def __init__(self, seed: int) -> None:
        rng = np.random.default_rng(seed)
        self.rng = rng
        self.length, self.EI, self.line = rng.uniform(0.3, 3), float(10 ** rng.uniform(1, 5)), rng.uniform(0.5, 20)
        self.tip = (float(10 ** rng.uniform(-1.5, 0.7)), float(10 ** rng.uniform(-4, -1)))
        self.along = "xyz"[seed % 3]
        self.bends = "yzx"[seed % 3]
        self.unit = np.sqrt(self.EI / self.line) / self.length**2 / (2 * np.pi)
        self.exact = self.unit * clamped_beam(*self.tip, 4)

    def read(self, keys: str) -> DescribedMachine:
        mass, inertia = self.tip[0] * self.line * self.length, self.tip[1] * self.line * self.length**3
        machine = toml.read(
            f"""
name = "walled"
gravity = [0, 0, 0]
joints = [ {{ name = "wall", kind = "fixed", antecedent = 0 }}, {{ name = "tip", kind = "fixed" }} ]
[beams]
wall = {{ along = "{self.along}", length = {self.length!r}, EI = {self.EI!r}, mass_per_length = {self.line!r}, \
bends = ["{self.bends}"], {keys} }}
[bodies]
tip = {{ mass = {mass!r}, center_of_mass = [0, 0, 0], inertia = [{inertia!r}, {inertia!r}, {inertia!r}] }}
""",
            "beam.toml",
        )
        check(machine)
        return machine

    def errors(self, keys: str, highest: float) -> np.ndarray:
        """Errors of the machine's frequencies, as far as the exact ones are below a highest one."""
        count = int(np.sum(self.exact <= highest))
        return np.abs(se.modes(self.read(keys)).frequencies[:count] / self.exact[:count] - 1)


@pytest.mark.parametrize("tip", TIPS)
def test_frequencies_without_joints_are_those_of_the_equation(tip: tuple[float, float]) -> None:
    beam, bar = Bending("y", 1.0, (tip[0], 0.0, tip[1])), Bending("axial", 1.0, (tip[0], 0.0, 0.0))
    np.testing.assert_allclose(beam.exact[:4], clamped_beam(*tip, 4), rtol=1e-11)
    np.testing.assert_allclose(bar.exact[:4], clamped_bar(tip[0], 4), rtol=1e-11)


@pytest.mark.sampled(4)
@pytest.mark.parametrize("seed", range(12))
def test_predicted_errors_are_those_of_the_machine(seed: int) -> None:
    """Of drawn rules and numbers of joints; joints of the last frequency of a rule too."""
    drawn = Drawn(seed)
    rule, joints = RULES[seed % 3], int(drawn.rng.integers(2, 5))
    count = int(drawn.rng.integers(1, joints + 1))
    highest = drawn.exact[count - 1] * 1.01
    machine = drawn.read(f'rule = "{rule}", joints = {joints}')
    (beam,) = machine.origin.beams
    (kind,) = bending_of(beam, {}, *bodies_beside(machine, beam, {}))
    predicted = kind.error(Joints(places_of(rule, joints, is_bar=False)), highest)
    measured = drawn.errors(f'rule = "{rule}", joints = {joints}', highest).max()
    compliance = se.stiffness(machine, frame="tip").compliance.diagonal()[:3].max() * 3 * drawn.EI / drawn.length**3
    assert predicted == pytest.approx(max(measured, abs(compliance - 1)), rel=1e-4)


@pytest.mark.sampled(4)
@pytest.mark.parametrize("seed", range(12, 24))
def test_chosen_joints_are_within_the_tolerance(seed: int) -> None:
    """And fewer joints of the same rule are not, unless there are none."""
    drawn = Drawn(seed)
    highest, tolerance = float(drawn.exact[seed % 3] * 1.01), float(10 ** drawn.rng.uniform(-3, -1.5))
    machine = drawn.read(f'joints = "auto", up_to = {highest!r}, tolerance = {tolerance!r}')
    (beam,) = machine.origin.beams
    assert drawn.errors(f'joints = {beam.joints}, rule = "{beam.rule}"', highest).max() < tolerance
    shown = by_first_cell(beams_table(machine))["wall"]
    assert (shown["rule"], shown["joints or modes"]) == (beam.rule, str(beam.joints))
    assert f" % up to {highest:g} Hz" in shown["predicted errors"] and ", root clamped, " in shown["predicted errors"]
    if beam.joints > 2:
        fewer = drawn.errors(f'joints = {beam.joints - 1}, rule = "{beam.rule}"', highest)
        assert len(fewer) < seed % 3 + 1 or fewer.max() > tolerance


ARM = """
name = "arm"
gravity = [0, 0, 0]
joints = [
  { name = "turn", kind = "motor", sigma = 0, antecedent = 0, axis = "z" },
  { name = "wrist", kind = "motor", sigma = 0, axis = "y", in = "turn", at = [0.2, 0, 0.1] },
]
[bodies]
wrist = { mass = 4, center_of_mass = [0.1, 0.05, 0.02], inertia = [0.1, 0, 0, 0.2, 0, 0.15] }
[parameters]
L = { value = 1.2, unit = "m" }
[beams]
turn = { along = "x", length = "L", EI = [2.1e4, 5e3], GJ = 3e3, mass_per_length = 12, inertia_per_length = 0.1, KEYS }
"""


def read(keys: str, text: str = ARM) -> DescribedMachine:
    return toml.read(text.replace("KEYS", keys), "arm.toml")


def test_what_is_carried_off_the_axis_counts() -> None:
    """The frequencies of each kind alone are those of the machine with the other kinds left out."""
    for bends in ("y", "z", "torsion"):
        machine = read(f'bends = ["{bends}"], rule = "equal", joints = 6')
        (beam,) = machine.origin.beams
        carried, hub = bodies_beside(machine, beam, {"L": 1.2})
        assert carried[3, 3] == 4
        assert hub is None, "a motor holds it"
        (kind,) = bending_of(beam, {"L": 1.2}, carried, hub)
        ours = kind.of_joints(beam.joints_of(bends))
        np.testing.assert_allclose(ours, se.modes(machine, hold=["all"]).frequencies, rtol=1e-9)


def test_a_free_root_moves_with_its_hub() -> None:
    """The frequencies above zero are those of the machine whose root slides and turns in a plane with a body."""
    machine = toml.read(
        """
name = "free"
gravity = [0, 0, 0]
joints = [
  { name = "x", kind = "passive", sigma = 1, axis = "x" },
  { name = "y", kind = "passive", sigma = 1, axis = "y" },
  { name = "pivot", kind = "passive", sigma = 0, axis = "z" },
  { name = "tip", kind = "fixed", d = 0.1 },
]
[beams]
pivot = { along = "x", length = 2, EI = 3, mass_per_length = 0.7, bends = ["y"], rule = "gauss", joints = 5 }
[bodies]
pivot = { mass = 2, center_of_mass = [-0.1, 0, 0], inertia = [0, 0, 0.05] }
tip = { mass = 0.5, center_of_mass = [0.1, 0, 0], inertia = [0, 0, 0.02] }
""",
        "free.toml",
    )
    (beam,) = machine.origin.beams
    clamped, free = bending_of(beam, {}, *bodies_beside(machine, beam, {}))
    assert clamped.hub is None
    found = se.modes(machine).frequencies
    ours = free.of_joints(beam.joints_of("y"))
    np.testing.assert_allclose(ours, found[found > 1e-3 * ours[0]], rtol=1e-9)
    assert ours[:2] == pytest.approx(free.exact[:2], rel=5e-3)
    bare = replace(free, hertz=1.0, tip=(0.0, 0.0, 0.0), hub=(0.0, 0.0, 0.0))
    np.testing.assert_allclose(bare.exact[:3], free_beam(3), rtol=1e-11)


@pytest.mark.thorough
def test_joints_of_a_gantry_are_enough_on_soft_and_stiff_guides() -> None:
    """Of 12 drawn gantries, at most 2 exceed the tolerance, by half of it, against 14 and 10 equal pieces extrapolated.

    Arm, load, guide and band vary; the quill has 5 joints. Torsion and bending are coupled, roots yield.
    """
    text = (EXAMPLES / "cantilever.toml").read_text(encoding="utf-8")
    text = text.replace('"auto", up_to = "400 Hz", tolerance = 0.01, rule = "fitted"', "5")
    worst = []
    for seed in range(12):
        rng = np.random.default_rng(seed)
        drawn = text.replace("A = { value = 0.9", f"A = {{ value = {rng.uniform(0.5, 2)}")
        drawn = drawn.replace("h = { value = 0.16", f"h = {{ value = {rng.uniform(0.08, 0.25)}")
        drawn = drawn.replace("z_axis = { mass = 9", f"z_axis = {{ mass = {10 ** rng.uniform(0, 1.7)}")
        springs = (1.2e8, 2.6e8, 3e8, 1.1e6, 0.9e6, 0.8e6)
        softer = ", ".join(str(k * 10 ** rng.uniform(-0.5, 1.2)) for k in springs)
        drawn = drawn.replace('"120 N/um", "260 N/um", "300 N/um", 1.1e6, 0.9e6, 0.8e6', softer)
        highest = 10 ** rng.uniform(2, 2.8)
        keys = ('joints = 14, rule = "equal"', 'joints = 10, rule = "equal"', f'joints = "auto", up_to = {highest}')
        texts = [drawn.replace("damping = 0.004", f"damping = 0.004, {key}") for key in keys]
        many, fewer, ours = (se.modes(toml.read(x, "gantry.toml"), hold=["all"]).frequencies[:14] for x in texts)
        exact = many + (many - fewer) / ((14 / 10) ** 2 - 1)
        worst.append(np.max(np.abs(ours / exact - 1), where=exact < highest, initial=0.0))
    assert np.sum(np.array(worst) > 0.01) <= 2
    assert max(worst) < 0.015


def test_without_a_band_or_without_values_there_are_four() -> None:
    plain = read('joints = "auto"')
    assert (plain.origin.beams[0].joints, plain.origin.beams[0].rule) == (4, "fitted")
    assert plain.joints == read("joints = 4").joints
    assert by_first_cell(beams_table(plain))["turn"]["predicted errors"] == "no up_to"
    unknown = read('joints = "auto", up_to = 100', ARM.replace("value = 1.2, ", ""))
    assert unknown.origin.beams[0].joints == 4
    assert by_first_cell(beams_table(unknown))["turn"]["predicted errors"] == "parameters without value"


def test_a_rule_of_the_file_is_kept() -> None:
    chosen = read('joints = "auto", up_to = "60 Hz", tolerance = 0.01, rule = "equal"').origin.beams[0]
    assert chosen.rule == "equal"
    assert chosen.joints > read('joints = "auto", up_to = "60 Hz", tolerance = 0.01').origin.beams[0].joints


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ("joints = 3, up_to = 100", 'beam turn, up_to: belongs to joints = "auto"'),
        ("tolerance = 0.1", 'beam turn, tolerance: belongs to joints = "auto"'),
        ('joints = "auto", up_to = 0', "beam turn, up_to: 0 must be above 0"),
        ('joints = "auto", up_to = 9, tolerance = -1', "beam turn, tolerance: -1 must be above 0"),
        ('joints = "auto", up_to = 1e6', "beam turn, joints: no rule has joints enough for 1 % up to 1e+06 Hz"),
    ],
)
def test_refusals(keys: str, message: str) -> None:
    with pytest.raises(InputError) as refusal:
        read(keys)
    assert message in str(refusal.value)
