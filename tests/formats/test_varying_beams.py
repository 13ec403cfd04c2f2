"""Beams whose sections change, and that yield in shear, against finite elements of the test itself and closed forms."""

from __future__ import annotations

import numpy as np
import pytest

import symoro_elastic as se
from symoro_elastic.formats.toml import reading as toml
from symoro_elastic.formats.toml.flexible.auto_joints import bodies_beside
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.beams.errors import bending_of
from symoro_elastic.machine.checks import check
from symoro_elastic.machine.described import DescribedMachine
from symoro_elastic.machine.views import beams_table, by_first_cell
from tests.references.fe_beams import Clamped, Properties

E, DENSITY, RATIO = 2.1e11, 7850.0, 2.6
"""Modulus of elasticity, Pa, density, kg/m3, and E/G."""


def section(kind: str, sizes: np.ndarray, shear: bool) -> Properties:
    """Bending along y, the first size of a bar or box; factors of shear with Poisson's ratio 0.3 (Cowper, table 1)."""
    nu = 0.3
    a, b, t = (*sizes, 0.0, 0.0)[:3]
    if kind in ("rod", "tube"):
        area, square, m = np.pi / 4 * (a**2 - b**2), np.pi / 64 * (a**4 - b**4), b / a
        n = (1 + m**2) ** 2
        factor = 6 * (1 + nu) * n / ((7 + 6 * nu) * n + (20 + 12 * nu) * m**2)
    elif kind == "bar":
        area, square, factor = a * b, a**3 * b / 12, 10 * (1 + nu) / (12 + 11 * nu)
    else:
        c, d = a - 2 * t, b - 2 * t
        area, square = a * b - c * d, (a**3 * b - c**3 * d) / 12
        m = n = (b - t) / (a - t)
        below = 12 + 72 * m + 150 * m**2 + 90 * m**3 + nu * (11 + 66 * m + 135 * m**2 + 90 * m**3)
        factor = 10 * (1 + nu) * (1 + 3 * m) ** 2 / (below + 10 * n**2 * ((3 + nu) * m + 3 * m**2))
    GA = factor * E / RATIO * area if shear else np.inf
    return Properties(E * square, GA, DENSITY * area, DENSITY * square)


class Drawn:
    """A tapered or stepped beam with a body at its end, and its finite elements."""

    def __init__(self, seed: int) -> None:
        rng = self.rng = np.random.default_rng(seed)
        kind, self.shear = ("rod", "tube", "bar", "box")[seed % 4], bool(seed // 2 % 2)
        count = 1 if seed % 2 else int(rng.integers(2, 4))
        size = 0.1 * rng.uniform(0.8, 1.2)
        self.length = size * (rng.uniform(5, 8) if self.shear else rng.uniform(12, 25))
        ends = [*np.sort(rng.uniform(0.2, 0.8, count - 1)), 1.0]
        widths = np.diff([0.0, *ends])

        def sizes() -> list[float]:
            a = size * rng.uniform(0.5, 1)
            return {"rod": [a], "tube": [a, 0.8 * a], "bar": [a, size * rng.uniform(0.4, 1)], "box": [a, a, 0.1 * a]}[
                kind
            ]

        first = [sizes() for _ in range(count)]
        last = [sizes() if seed % 2 else x for x in first]
        self.text = ", ".join(
            f"{{ length = {float(w * self.length)!r}, section = {written(kind, a)}, end_section = {written(kind, b)} }}"
            for w, a, b in zip(widths, first, last, strict=True)
        )

        def at(x: float) -> Properties:
            k = int(np.searchsorted(ends, x / self.length))
            start = 0.0 if k == 0 else ends[k - 1]
            part = (x / self.length - start) / (ends[k] - start)
            return section(kind, np.array(first[k]) * (1 - part) + np.array(last[k]) * part, self.shear)

        self.beam = Clamped(self.length, at, tuple(self.length * np.array(ends[:-1])))
        whole = float(self.beam.M[::2, ::2].sum())
        self.tip = (
            float(whole * 10 ** rng.uniform(-1.5, 0.7)),
            float(whole * self.length**2 * 10 ** rng.uniform(-4, -1.5)),
        )
        self.exact = self.beam.frequencies(*self.tip, 4)

    def read(self, keys: str) -> DescribedMachine:
        mass, inertia = self.tip
        return read(f"pieces = [{self.text}], shear = {str(self.shear).lower()}, {keys}", mass, inertia)

    def errors(self, machine: DescribedMachine, count: int) -> np.ndarray:
        frequencies = np.abs(se.modes(machine).frequencies[:count] / self.exact[:count] - 1)
        compliance = se.stiffness(machine, frame="tip").compliance[1, 1] / self.beam.compliance[0, 0] - 1
        return np.append(frequencies, abs(compliance))


def written(kind: str, sizes: list[float]) -> str:
    values = ", ".join(map(repr, map(float, sizes)))
    return f"{{ {kind} = {values if len(sizes) == 1 else f'[{values}]'} }}"


def read(keys: str, mass: float = 0.0, inertia: float = 0.0, more: str = "") -> DescribedMachine:
    body = f"[bodies]\ntip = {{ mass = {mass!r}, center_of_mass = [0, 0, 0], inertia = [0, 0, {inertia!r}] }}"
    machine = toml.read(
        f"""
name = "walled"
gravity = [0, 0, 0]
joints = [ {{ name = "wall", kind = "fixed", antecedent = 0 }}, {{ name = "tip", kind = "fixed" }} ]
[beams]
wall = {{ along = "x", E = {E}, density = {DENSITY}, bends = ["y"], {keys} }}
{body if mass else ""}
{more}
""",
        "beam.toml",
    )
    check(machine)
    return machine


@pytest.mark.sampled(4)
@pytest.mark.parametrize("seed", range(12))
def test_predicted_errors_are_those_of_finite_elements(seed: int) -> None:
    drawn = Drawn(seed)
    rule, joints = ("fitted", "gauss", "equal")[seed % 3], 2 + seed % 2
    count = int(drawn.rng.integers(1, joints + 1))
    machine = drawn.read(f'rule = "{rule}", joints = {joints}')
    (beam,) = machine.origin.beams
    (kind,) = bending_of(beam, {}, *bodies_beside(machine, beam, {}))
    predicted = kind.error(beam.joints_of("y"), drawn.exact[count - 1] * 1.01)
    assert 0.7 < predicted / drawn.errors(machine, count).max() < 1.4


@pytest.mark.thorough
@pytest.mark.parametrize("seed", range(12, 24))
def test_chosen_joints_are_within_the_tolerance(seed: int) -> None:
    drawn = Drawn(seed)
    count, tolerance = 1 + seed % 3, float(10 ** drawn.rng.uniform(-2.5, -1.5))
    highest = float(drawn.exact[count - 1] * 1.01)
    machine = drawn.read(f'joints = "auto", up_to = {highest!r}, tolerance = {tolerance!r}')
    assert drawn.errors(machine, count).max() < tolerance + 1e-4
    assert f" % up to {highest:g} Hz" in by_first_cell(beams_table(machine))["wall"]["predicted errors"]


@pytest.mark.sampled(3)
@pytest.mark.parametrize("seed", [0, 1, 4, 5, 9, 17])
def test_four_fitted_joints_give_three_frequencies(seed: int) -> None:
    """The bounds that docs/flexible.md states, without shear; elements are within 0.01 %."""
    drawn = Drawn(seed)
    assert not drawn.shear
    assert np.all(drawn.errors(drawn.read("joints = 4"), 3) < [6e-4, 8e-4, 2e-3, 2e-4])


@pytest.mark.thorough
@pytest.mark.parametrize("seed", [2, 3, 6, 7, 10, 11])
def test_shear_in_slides(seed: int) -> None:
    """Of beams of 5 to 8 times their section; without slides both frequencies are at least four times as wrong."""
    drawn = Drawn(seed)
    assert drawn.shear
    ours = drawn.errors(drawn.read("joints = 4"), 2)
    assert np.all(ours < [7e-4, 2e-3, 2e-4])
    drawn.shear = False
    assert np.all(drawn.errors(drawn.read("joints = 4"), 2) > [2e-3, 8e-3, 2e-3])


TUBE, ROD, L = np.array([0.1, 0.08]), np.array([0.07]), (0.6, 0.4)
STEPPED = "pieces = [{ length = 0.6, section = { tube = [0.1, 0.08] } }, { length = 0.4, section = { rod = 0.07 } }]"


@pytest.mark.sampled(4)
@pytest.mark.parametrize("rule", ["fitted", "gauss"])
@pytest.mark.parametrize("shear", [False, True])
@pytest.mark.parametrize("joints", [3, 5])
def test_tip_compliance_is_exact(rule: str, shear: bool, joints: int) -> None:
    """Deflection and slope under force and moment, by integrals over both uniform pieces."""
    keys = f'{STEPPED}, G = {E / RATIO}, rule = "{rule}", joints = {joints}, shear = {str(shear).lower()}'
    C = se.stiffness(read(keys, 1.0), frame="tip").compliance
    tube, rod = section("tube", TUBE, shear), section("rod", ROD, shear)
    (a, b), c, d = L, 1 / tube.EI, 1 / rod.EI
    force = c * (1 - b**3) / 3 + d * b**3 / 3 + a / tube.GA + b / rod.GA
    both, turn = c * (1 - b**2) / 2 + d * b**2 / 2, c * a + d * b
    np.testing.assert_allclose(C[np.ix_([1, 5], [1, 5])], [[force, both], [both, turn]], rtol=1e-9)


def test_mass_centre_and_inertia_of_cones_are_exact() -> None:
    """Of a truncated cone, and of any two parts of it."""
    (beam,) = read("length = 2, section = { rod = 0.3 }, end_section = { rod = 0.1 }").origin.beams
    number = lambda text: float(toml.Formula.parse(text).value())  # noqa: E731
    x, w = np.polynomial.legendre.leggauss(8)
    for start, end in ((0.0, 1.0), (0.0, 0.3), (0.3, 1.0)):
        at, weights = 2 * (start + (end - start) * (1 + x) / 2), (end - start) * w
        r = 0.15 - 0.05 * at
        line = DENSITY * np.pi * r**2 * weights
        mass, centre = line.sum(), line @ at / line.sum()
        polar, across = line @ r**2 / 2, line @ (r**2 / 4 + (at - centre) ** 2)
        ours, from_start, (about_axis, about_y, about_z) = beam.piece(start, end)
        np.testing.assert_allclose([number(ours), number(from_start)], [mass, centre - 2 * start], rtol=1e-12)
        np.testing.assert_allclose(
            list(map(number, (about_axis, about_y, about_z))), [polar, across, across], rtol=1e-12
        )


@pytest.mark.parametrize("rule", ["fitted", "gauss", "equal"])
def test_equal_pieces_are_a_uniform_beam(rule: str) -> None:
    piece = "{ length = 0.5, section = { box = [0.1, 0.08, 0.005] } }"
    one, both = (
        se.modes(read(f'{keys}, rule = "{rule}"', 2.0, 0.01)).frequencies[:3]
        for keys in (f"pieces = [{piece}, {piece}]", f"length = 1, {piece[piece.index('section') : -2]}")
    )
    np.testing.assert_allclose(one, both, rtol=1e-4 if rule == "fitted" else 1e-11)


@pytest.mark.parametrize("modes", [3, 4, 5])
def test_modes_of_a_short_beam(modes: int) -> None:
    keys = f"length = 0.5, section = {{ bar = [0.1, 0.06] }}, G = {E / RATIO}, shear = true, modes = {modes}"
    machine, beam = read(keys, 5.0, 0.02), Clamped(0.5, lambda _: section("bar", np.array([0.1, 0.06]), shear=True))
    found, exact = se.modes(machine).frequencies[:2], beam.frequencies(5.0, 0.02, 2)
    assert np.all(np.abs(found / exact - 1) < {3: [4e-4, 8e-3], 4: [1e-4, 8e-3], 5: [1e-4, 1e-3]}[modes])
    compliance = se.stiffness(machine, frame="tip").compliance[np.ix_([1, 5], [1, 5])]
    np.testing.assert_allclose(compliance, beam.compliance, rtol=1e-6)


@pytest.mark.parametrize("tip", [(0.5, 1e-4), (20.0, 0.05)])
def test_four_joints_of_a_beam_of_three_times_its_section(tip: tuple[float, float]) -> None:
    beam = Clamped(0.3, lambda _: section("bar", np.array([0.1, 0.06]), shear=True))
    machine = read(f"length = 0.3, section = {{ bar = [0.1, 0.06] }}, G = {E / RATIO}, shear = true", *tip)
    assert np.all(np.abs(se.modes(machine).frequencies[:2] / beam.frequencies(*tip, 2) - 1) < 2e-3)


def test_shear_by_its_stiffness() -> None:
    """kGA, EI and mass_per_length as those of the section give its compliance."""
    s = section("rod", ROD, shear=True)
    text = TABLE.replace(
        "section = { rod = 0.1 }, E = 1e9, density = 1000", f"EI = {s.EI}, mass_per_length = {s.mass}, kGA = {s.GA}"
    )
    C = se.stiffness(toml.read(text, "beam.toml"), frame="wall_end").compliance
    assert C[1, 1] == pytest.approx(1 / (3 * s.EI) + 1 / s.GA, rel=1e-9)


@pytest.mark.parametrize("keys", ["joints = 5", "joints = 4, shear = true"])
def test_damping_is_the_ratio_of_the_first_frequency(keys: str) -> None:
    modes = se.modes(read(f"{STEPPED}, damping = 0.02, {keys}"))
    assert modes.damping_ratios[0] == pytest.approx(0.02, rel=5e-3)


def test_joints_that_cannot_be_fitted_are_doubted() -> None:
    """One joint of torsion for two soft pieces with a stiff one between; none with more joints."""
    sizes = ((0.3, 0.06), (0.1, 0.2), (0.6, 0.06))
    pieces = ", ".join(f"{{ length = {length}, section = {{ rod = {size} }} }}" for length, size in sizes)
    text = TABLE.replace('"y"', '"torsion"').replace("length = 1, section = { rod = 0.1 }", f"pieces = [{pieces}]")
    (doubt,) = (x for x in check(toml.read(text.replace("E =", "joints = 2, E ="), "beam.toml")) if "an error of" in x)
    assert "beam wall: joints of torsion have an error of " in doubt
    assert not any("an error of" in x for x in check(toml.read(text, "beam.toml")))


def test_material_and_length_of_a_taper_stay_symbols() -> None:
    text = """
name = "cone"
gravity = [0, 0, 0]
joints = [ { name = "wall", kind = "fixed", antecedent = 0 } ]
[parameters]
L = { value = 20, unit = "m" }
modulus = { value = 2.1e11, unit = "Pa" }
[beams]
wall = { along = "z", length = "L", section = { rod = 0.1 }, end_section = { rod = 0.05 }, E = "modulus", \
density = 7850, bends = ["x"] }
"""
    modes = se.modes(toml.read(text, "cone.toml"))
    slopes = dict(zip(modes.sensitivity.parameters, modes.sensitivity.relative[:, 0], strict=True))
    assert slopes["modulus"] == pytest.approx(0.5, abs=1e-6)
    assert slopes["L"] == pytest.approx(-2, abs=1e-3)


@pytest.mark.thorough
def test_a_beam_that_tapers_and_yields_in_shear_passes_check() -> None:
    text = """
name = "arm"
gravity = [0, 0, -9.81]
joints = [ { name = "turn", kind = "motor", sigma = 0, antecedent = 0, axis = "z" }, { name = "tip", kind = "fixed" } ]
[bodies]
tip = { mass = 2, center_of_mass = [0, 0.1, 0], inertia = [0.1, 0.2, 0.15] }
[beams]
turn = { along = "x", length = 0.6, section = { box = [0.1, 0.08, 0.01] }, end_section = { box = [0.05, 0.06, 0.01] }, \
E = "210 GPa", density = 7850, shear = true, joints = 2 }
"""
    machine = toml.read(text, "arm.toml")
    assert [x.name for x in machine.joints if "_shear_" in x.name] == ["turn_shear_z1", "turn_shear_y1"]
    assert se.check(machine).ok


TABLE = """
name = "walled"
gravity = [0, 0, 0]
joints = [ { name = "wall", kind = "fixed", antecedent = 0 } ]
[parameters]
D = { value = 0.1, unit = "m" }
[beams]
wall = { along = "x", length = 1, section = { rod = 0.1 }, E = 1e9, density = 1000, bends = ["y"] }
"""


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("E =", "end_section = { bar = [0.1, 0.1] }, E =", "end_section: is a bar, and the section is a rod"),
        ("E =", 'end_section = { rod = "D" }, E =', "end_section: 'D' is a name, and sections that change are numbers"),
        ("E =", "end_section = { rod = 0 }, E =", "beam wall, end_section: sizes of a rod must be above 0"),
        ("E =", "end_section = { rod = 0.004 }, E =", "end_section: sizes change more than 20 times"),
        ("E =", "end_section = { rod = 0.05 }, modes = 3, E =", "modes are those of uniform beams"),
        ("section = { rod = 0.1 }, E =", "end_section = { rod = 0.1 }, EI = 3, E =", "end_section: needs a section"),
        ("E =", "pieces = [], E =", "beam wall, length: follows from the pieces"),
        ("length = 1, section = { rod = 0.1 }", "pieces = []", "beam wall, pieces: is empty"),
        ("length = 1, section = { rod = 0.1 }", "pieces = [{ length = 1 }]", "beam wall, piece 1, section: is missing"),
        (
            "length = 1, section = { rod = 0.1 }",
            "pieces = [{ length = 0, section = { rod = 1 } }, { length = 1, section = { rod = 1 } }]",
            "beam wall, piece 1, length: '0' must be above 0",
        ),
        (
            "length = 1, section = { rod = 0.1 }",
            "pieces = [{ length = 1, section = { rod = 1 }, E = 3 }]",
            "beam wall, piece 1, E: no such key here",
        ),
        (
            "length = 1, section = { rod = 0.1 }",
            'pieces = [{ length = "D", section = { rod = 1 } }, { length = 1, section = { rod = 1 } }]',
            "beam wall, piece 1, length: 'D' is a name",
        ),
        (
            "rod = 0.1 }",
            'rod = "D" }, shear = true',
            "shear: with shear, places of joints follow from numbers, and 'D'",
        ),
        ("section = { rod = 0.1 }, E = 1e9, density = 1000", "EI = 1, mass_per_length = 1, shear = true", "or kGA"),
        ("E =", "kGA = 3, E =", "kGA: follows from the section"),
        ("section = { rod = 0.1 }, E = 1e9, density = 1000", "EI = 1, mass_per_length = 1, kGA = 0", "must be above 0"),
    ],
)
def test_refusals(old: str, new: str, message: str) -> None:
    assert old in TABLE
    with pytest.raises(InputError) as refusal:
        toml.read(TABLE.replace(old, new, 1), "beam.toml")
    assert message in str(refusal.value)
    assert "\n" not in str(refusal.value)
