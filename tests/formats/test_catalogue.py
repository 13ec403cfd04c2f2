"""Guides, bearings, screws, belts and couplings: against numbers by hand, with names kept, shown, and refused."""

from __future__ import annotations

import json
from math import pi, radians, tan

import numpy as np
import pytest

import symoro_elastic as se
from symoro_elastic.formats.toml import reading as toml
from symoro_elastic.formats.toml.catalogue import TABLES
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.described import DescribedMachine
from symoro_elastic.machine.views import catalogue_table
from symoro_elastic.mechanics.elastic_cells import elastic_cells
from symoro_elastic.models.bound.bind import Bound
from tests.command_line import EXAMPLES, ended

HEAD = """
gravity = [0, 0, 0]
joints = [
  { name = "drive", kind = "motor", sigma = 1, axis = "x", variable = "x" },
  { name = "part", kind = "elastic", sigma = SIGMA },
]
[parameters]
k = { value = "900 N/um" }
[bodies]
drive = { mass = 3 }
part = { mass = 2, center_of_mass = [0.1, 0, 0], inertia = [0.1, 0.2, 0.3] }
"""
GUIDE = 'blocks = 4, distance = ["400 mm", 0.3], radial = "k", lateral = "700 N/um"'
BEARINGS = 'radial = "300 N/um", axial = "k", distance = 0.12, contact_angle = "25 deg", pitch_diameter = "60 mm"'
SCREW = 'nut = "800 N/um", diameter = "28 mm", position = "0.2"'
ROD = 2.06e11 * pi * 0.028**2 / 4


def read(tables: str, sigma: str = "6") -> DescribedMachine:
    place = "" if sigma == "6" else ', theta = "q"' if sigma == "0" else ', r = "q"'
    return toml.read(HEAD.replace("SIGMA", sigma + place) + tables, "machine.toml")


def stiffnesses(machine: DescribedMachine, **values: float) -> dict[str, float]:
    springs = {joint.name: joint.spring.stiffness for joint in machine.joints if joint.kind == "elastic"}
    return {name.removeprefix("part_"): cell.value({"k": 9e8} | values) for name, cell in springs.items()}


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        ("", {"y": 2.8e9, "z": 3.6e9, "rx": 3.6e9 * 0.15**2, "ry": 3.6e9 * 0.2**2, "rz": 2.8e9 * 0.2**2}),
        (", moments = [1e4, 2e4, 3e4]", {"rx": 8.1e7 + 4e4, "ry": 1.44e8 + 8e4, "rz": 1.12e8 + 12e4}),
        (', rails = "y", normal = "x"', {"z": 2.8e9, "x": 3.6e9, "ry": 8.1e7, "rz": 1.44e8, "rx": 1.12e8}),
    ],
)
def test_four_runner_blocks(change: str, expected: dict[str, float]) -> None:
    found = stiffnesses(read(f"[guides]\npart = {{ {GUIDE}{change} }}"))
    assert len(found) == 5 and expected.items() <= {x: pytest.approx(k) for x, k in found.items()}.items()


@pytest.mark.parametrize(("blocks", "b"), [(6, 0.3), (8, 0.3), (3, 0.0)])
def test_more_blocks_are_springs_at_their_places(blocks: int, b: float) -> None:
    """Sums over the blocks, wherever they are."""
    text = GUIDE.replace("blocks = 4", f"blocks = {blocks}").replace("0.3]", f"{b}], moments = [1e4, 0, 0]")
    found = stiffnesses(read(f"[guides]\npart = {{ {text} }}"))
    sides = [-b / 2, b / 2] if b else [0.0]
    along, across = np.meshgrid(np.linspace(-0.2, 0.2, blocks // len(sides)), sides)
    assert found["rx"] == pytest.approx(9e8 * np.sum(across**2) + blocks * 1e4)
    assert found["ry"] == pytest.approx(9e8 * np.sum(along**2))
    assert found["rz"] == pytest.approx(7e8 * np.sum(along**2))


@pytest.mark.parametrize(("arrangement", "sign"), [("O", 1), ("X", -1)])
def test_bearing_pairs(arrangement: str, sign: int) -> None:
    found = stiffnesses(read(f'[bearings]\npart = {{ {BEARINGS}, arrangement = "{arrangement}", axis = "x" }}'))
    spread = 0.12 + sign * 0.06 * tan(radians(25))
    tilt = pytest.approx(2 * 3e8 * (spread / 2) ** 2)
    assert found == {"x": 1.8e9, "y": 6e8, "z": 6e8, "ry": tilt, "rz": tilt}


@pytest.mark.parametrize(
    ("change", "compliance"),
    [
        ("", 1 / 8e8 + 0.2 / ROD),
        (", bearing = 5e8", 1 / 8e8 + 0.2 / ROD + 1 / 5e8),
        (", length = 1", 1 / 8e8 + 0.2 * 0.8 / ROD),
        (", length = 1, bearing = 5e8", 1 / 8e8 + 1 / (1 / (2e-9 + 0.2 / ROD) + 1 / (2e-9 + 0.8 / ROD))),
        (", torsional = 2e4, lead = 0.01", 1 / 8e8 + 0.2 / ROD + (0.01 / (2 * pi)) ** 2 / 2e4),
        (", modulus = '1e11 Pa'", 1 / 8e8 + 0.2 / ROD * 2.06),
    ],
)
def test_screws(change: str, compliance: float) -> None:
    assert stiffnesses(read(f"[screws]\npart = {{ {SCREW}{change} }}", "1"))["part"] == pytest.approx(1 / compliance)


def test_turning_rows() -> None:
    """A screw by its lead, a belt by the radius of the pulley, couplings in series."""
    screw = stiffnesses(read(f"[screws]\npart = {{ {SCREW}, lead = 0.02 }}", "0"))["part"]
    assert screw == pytest.approx((0.02 / (2 * pi)) ** 2 / (1 / 8e8 + 0.2 / ROD))
    belt = stiffnesses(read("[belts]\npart = { specific = 1e6, strands = [0.5, 2], radius = 0.1 }", "0"))["part"]
    assert belt == pytest.approx(1e6 * 2.5 * 0.01)
    assert stiffnesses(read("[couplings]\npart = { torsional = [3e4, 6e4] }", "0"))["part"] == pytest.approx(2e4)
    assert stiffnesses(read("[couplings]\npart = { torsional = [3e4] }", "0"))["part"] == 3e4


def test_names_stay_and_positions_count() -> None:
    """A belt whose strands follow the motor, along the rails of a guide; six directions are one cell."""
    text = f'[guides]\npart = {{ {GUIDE} }}\n[belts]\npart = {{ specific = 1e6, strands = ["0.5 + x", "1.5 - x"] }}'
    machine = read(f"{text}\n[springs]\npart = {{ damping = [1, 2, 3, 4, 5, 6] }}")
    assert stiffnesses(machine, k=1e9, x=0.25)["x"] == pytest.approx(1e6 * (1 / 0.75 + 1 / 1.25))
    assert stiffnesses(machine, k=1e9, x=0)["z"] == 4e9
    assert [j.spring.damping.value() for j in machine.joints if j.kind == "elastic"] == [1, 2, 3, 6, 5, 4]
    assert len(elastic_cells(Bound(machine).mechanism, machine.elastic)) == 1


@pytest.mark.parametrize(
    ("table", "sigma"), [("guides", "6"), ("bearings", "6"), ("screws", "0"), ("belts", "0"), ("couplings", "0")]
)
def test_examples_of_keys_are_read(table: str, sigma: str) -> None:
    """Those of the reference and of commented tables of new files."""
    entries = ", ".join(f"{key.name} = {key.example}" for key in TABLES[table].keys)
    machine = read(f"[{table}]\npart = {{ {entries} }}".replace(' y"', ' x"'), sigma)
    assert all(k > 0 for k in stiffnesses(machine, x=0.1).values())


def test_what_show_prints_and_sweeps_change() -> None:
    rows = {row[0]: row[1:] for row in catalogue_table(se.read(EXAMPLES / "carriage.toml")).rows}
    assert rows["carriage_rx"][:2] == ("6.664e+07 N m/rad", "4*k_block*(b/2)^2 + 4*2e4")
    assert rows["carriage_x"][0] == "by x" and rows["carriage_x"][2].startswith("ISO 3408-4")
    assert "springs from catalogues" in ended("show", str(EXAMPLES / "carriage.toml")).out
    as_json = json.loads(ended("show", str(EXAMPLES / "carriage.toml"), "--json").out)
    assert as_json["catalogue_springs"]["carriage_rx"]["tolerance"].startswith("20 %")
    modes = [se.modes(EXAMPLES / "carriage.toml", values={"k_block": k}).frequencies[1] for k in (4e8, 8e8)]
    assert modes[0] < modes[1]


@pytest.mark.parametrize(
    ("tables", "sigma", "message"),
    [
        (f"[guides]\nparts = {{ {GUIDE} }}", "6", "guides: no joint 'parts'; did you mean 'part'?"),
        (f"[guides]\ndrive = {{ {GUIDE} }}", "6", 'guides, drive, kind: the row has no spring: write kind = "elastic"'),
        (f"[guides]\npart = {{ {GUIDE} }}", "1", "guides, part, sigma: the row has one direction"),
        (f"[screws]\npart = {{ {SCREW} }}", "6", "screws, part, sigma: a single stiffness for six"),
        (f"[guides]\npart = {{ {GUIDE} }}\n[springs]\npart = {{ stiffness = 1 }}", "6", "given in [springs], too"),
        (f"[guides]\npart = {{ {GUIDE} }}\n[bearings]\npart = {{ {BEARINGS} }}", "6", "[guides] and [bearings] give"),
        (f"[guides]\npart = {{ {GUIDE} }}".replace("= 4", "= 5"), "6", "blocks: 5 cannot be divided among the rails"),
        (f"[guides]\npart = {{ {GUIDE} }}".replace("0.3", "-0.3"), "6", "guides, part, distance: -0.3 is not positive"),
        (f"[guides]\npart = {{ {GUIDE} }}".replace("0.3", "0"), "6", "moments: nothing else holds the roll"),
        (f"[guides]\npart = {{ {GUIDE} }}".replace("= 4", "= 2"), "6", "moments: nothing else holds the pitch"),
        (f'[guides]\npart = {{ {GUIDE}, normal = "x" }}', "6", "guides, part, normal: is along the rails, too"),
        (f"[guides]\npart = {{ {GUIDE} }}".replace('"k"', "0"), "6", "guides, part, radial: 0 is not positive"),
        (f"[bearings]\npart = {{ {BEARINGS} }}".replace("0.12", '"12 N"'), "6", "bearings, part, distance"),
        (f'[bearings]\npart = {{ {BEARINGS}, arrangement = "T" }}', "6", "no arrangement 'T'"),
        (f"[screws]\npart = {{ {SCREW} }}", "0", "screws, part, lead: is missing: the row turns"),
        (f"[screws]\npart = {{ {SCREW}, torsional = 1e4 }}", "1", "lead: is missing: torsion moves the nut by it"),
        (f"[screws]\npart = {{ {SCREW}, length = 0.1 }}", "1", "position: 0.2 m is beyond the other bearing, at 0.1"),
        ("[belts]\npart = { specific = 1e6, strands = [1] }", "1", "belts, part, strands: has 1 entries, expected 2"),
        ("[belts]\npart = { specific = 1e6, strands = [1, 1] }", "0", "radius: is missing: the row turns"),
        ("[couplings]\npart = { torsional = [1e4] }", "1", "torsional: the row slides: give it to the screw"),
        ("[couplings]\npart = { torsion = 1e4 }", "0", "no such key here; did you mean 'torsional'?"),
    ],
)
def test_refusals(tables: str, sigma: str, message: str) -> None:
    with pytest.raises(InputError) as refusal:
        read(tables, sigma)
    assert message in str(refusal.value) and "\n" not in str(refusal.value)


@pytest.mark.thorough
def test_motions_with_a_stiffness_by_position() -> None:
    """Explicit and implicit steps agree along a belt whose strands change."""
    machine = read('[belts]\npart = { specific = 1e5, strands = ["0.5 + x", "1.5 - x"] }', "1")
    motion = {"duration": 0.02, "moves": [{"motor": "drive", "by": 0.1, "in": 0.02}]}
    scene = {"motion": motion | {"servo": {"drive": {"bandwidth": 20, "damping": 0.8}}}}
    found = [se.simulate(machine, scene, method=method, step=1e-5)[0].motion.q[-1] for method in ("rk4", "w3")]
    np.testing.assert_allclose(*found, rtol=1e-8)
