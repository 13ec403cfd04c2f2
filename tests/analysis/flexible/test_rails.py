"""Rails on bodies of finite elements: polynomials against nodes, and slides against bodies with an interface there."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import symoro_elastic as se
from symoro_elastic.analysis.flexible.rails import rail_of
from symoro_elastic.analysis.flexible.sources import nodes_of, of_mesh
from symoro_elastic.formats.modes_file import ModalBody, Rail, load, save
from symoro_elastic.formats.toml.flexible.modal_rows import _of_beam, along_beam
from symoro_elastic.formats.toml.reading import read
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import InputError
from tests.command_line import refused
from tests.mechanics.test_flexible_bodies import model

skfem = pytest.importorskip("skfem")
pytest.importorskip("scipy.sparse")

LENGTH, WIDTH, HEIGHT = 1.2, 0.2, 0.12
STRIP = (0.1, 1.1)
"""Of x: from where to where the rail is, m."""
CARRIAGE = 40.0


@pytest.fixture(scope="module")
def bed(tmp_path_factory: pytest.TempPathFactory) -> str:
    """A cast bed, held at one end; its rail is a strip of the top, beside the middle."""
    mesh = skfem.MeshHex.init_tensor(*(np.linspace(0, *end) for end in ((LENGTH, 13), (WIDTH, 5), (HEIGHT, 2))))

    def on_top(x: Array, low: float, high: float) -> Array:
        return (np.abs(x[2] - HEIGHT) < 1e-9) & (low < x[0]) & (x[0] < high) & (x[1] > WIDTH / 2)

    sets = {"foot": lambda x: x[0] == 0, "rail": lambda x: on_top(x, *STRIP)}
    sets |= {f"at_{k}": lambda x, k=k: on_top(x, k / 10 - 0.06, k / 10 + 0.06) for k in (3, 7)}
    file = tmp_path_factory.mktemp("meshes") / "bed.msh"
    mesh.with_boundaries(sets).save(str(file))
    return str(file)


def test_a_rigid_motion_and_a_bent_line_are_exact() -> None:
    x = np.array([[0.1 * k, y, 0.3] for k in range(21) for y in (0.2, 0.3)])
    turn, s = np.array([0.2, -0.3, 0.4]), x[:, 0] / 2
    rigid = np.array([1.0, 2, 3]) + np.cross(turn, x)
    bent = np.column_stack([-(x[:, 2] - 0.3) * s, 0 * s, s**3])
    rail, error = rail_of(x, np.arange(len(x)), np.array([rigid, bent]), np.ones(2), "guide", "bed")
    assert error < 1e-12 and rail.length == pytest.approx(2) and rail.point == pytest.approx([0, 0.25, 0.3])
    here = rail.at(0.6)
    assert here.turn[0] == pytest.approx(turn, abs=1e-9)
    assert here.shift[0] == pytest.approx(np.array([1, 2, 3]) + np.cross(turn, [0.6, 0.25, 0.3]), abs=1e-9)
    assert here.shift[1] == pytest.approx([0, 0, 0.3**3], abs=1e-9)
    assert here.turn[1] == pytest.approx([0, -3 * 0.3**2 / 2, 0], abs=1e-9)


def machine(file: Path, row: str) -> str:
    return f"""
name = "table_on_a_bed"
gravity = [0, 0, -9.81]
joints = [
  {{ name = "bed", kind = "fixed", at = [0, 0, 0] }},
  {row}
  {{ name = "tool", kind = "fixed", r = 0.2 }},
]
[flexible]
bed = {{ file = "{file}" }}
[bodies]
table = {{ mass = {CARRIAGE}, center_of_mass = [0.02, 0.03, 0.1], inertia = [0.4, 0.4, 0.6] }}
"""


@pytest.mark.thorough
@pytest.mark.parametrize("place", [3, 7])
def test_a_table_on_a_rail_is_one_on_an_interface_there(bed: str, tmp_path: Path, place: int) -> None:
    """Interfaces are averaged over their nodes, a rail has sections that stay plane: they agree within 1 %."""
    fitted = se.flexible(bed, "foot", rails={"guide": "rail"}, modes=4, material="cast-iron")
    fitted.write(tmp_path / "rail.npz")
    se.flexible(bed, "foot", {"spot": f"at_{place}"}, modes=8, material="cast-iron").write(tmp_path / "spot.npz")
    slide = '{ name = "table", kind = "motor", sigma = 1, along = "bed_guide" },'
    (tmp_path / "slide.toml").write_text(machine(tmp_path / "rail.npz", slide))
    still = '{ name = "table", kind = "motor", sigma = 1, antecedent = "bed_spot", axis = "x", at = [%s, 0.15, 0.12] },'
    (tmp_path / "still.toml").write_text(machine(tmp_path / "spot.npz", still % (place / 10)))
    at = place / 10 - load(tmp_path / "rail.npz").rails["guide"].point[0]
    moving = se.modes(str(tmp_path / "slide.toml"), at={"table": at})
    held = se.modes(str(tmp_path / "still.toml"))
    assert np.asarray(moving.frequencies)[:4] == pytest.approx(np.asarray(held.frequencies)[:4], rel=0.01)


def on_a_beam(rows: str, tables: str) -> str:
    return f"""
name = "column"
gravity = [0.3, -9.0, 2.0]
joints = [
  {{ name = "swing", kind = "motor", sigma = 0, antecedent = 0, axis = "z", at = [0, 0, 0] }},
  {{ name = "column", kind = "fixed" }},
  {rows}
]
[bodies]
swing = {{ mass = 2, inertia = [0.1, 0.1, 0.2] }}
cart = {{ mass = 3, center_of_mass = [0.02, 0.03, 0.1], inertia = [0.04, 0.05, 0.06] }}
{tables}
"""


@pytest.mark.parametrize("along", ["x", pytest.param("-z", marks=pytest.mark.thorough)])
def test_the_axis_of_a_beam_is_a_rail(tmp_path: Path, along: str) -> None:
    """The same polynomials and integrals from a file: models are equal within rounding."""
    slide = '{ name = "cart", kind = "motor", sigma = 1, along = "%s", from = 0.25 },'
    section = 'section = { bar = [0.02, 0.01] }, E = "1 GPa", density = 7850, modes = 1'
    by_beam = read(
        on_a_beam(slide % "column", f'[beams]\ncolumn = {{ along = "{along}", length = 1.5, {section} }}'), "beam"
    )
    (beam,) = by_beam.origin.beams
    way, modal = along_beam(beam, {}), _of_beam(beam, {})
    turn = way.frame.T  # from the axes of the beam to those of its row
    phi, points = modal.phi @ turn.T, modal.points @ turn.T
    psi = np.column_stack([np.ones(len(points)), points, phi.transpose(1, 0, 2).reshape(len(points), -1)])
    count = max(len(x) for moves in way.moves.values() for x in moves)
    shift, turned = np.zeros((2, count, len(phi), 3))
    for (what, axis), moves in way.moves.items():
        for k, polynomial in enumerate(moves):
            (shift if what == "shift" else turned)[: len(polynomial), k, axis] = polynomial
    rail = Rail(np.zeros(3), turn @ [1.5, 0, 0], shift @ turn.T, turned @ turn.T)
    numbers = (np.array([getattr(mode, key) for mode in modal.modes]) for key in ("stiffness", "damping"))
    save(ModalBody(psi.T @ (modal.mass[:, None] * psi), *numbers, rails={"guide": rail}), tmp_path / "column.npz")
    file = tmp_path / "column.npz"
    assert load(file).rails["guide"].at(0.3).turn == pytest.approx(rail.at(0.3).turn, rel=1e-15)
    by_rail = read(on_a_beam(slide % "column_guide", f'[flexible]\ncolumn = {{ file = "{file}" }}'), "rail")
    rng, n = np.random.default_rng(1), len(by_beam.independent)
    q, qd = 0.05 * rng.normal(size=(2, n))
    for name, x in (("direct_dynamics", rng.normal(size=2)), ("inverse_dynamics", rng.normal(size=2))):
        for first, second in zip(model(by_beam, name, q, qd, x), model(by_rail, name, q, qd, x), strict=True):
            assert second == pytest.approx(first, rel=1e-9, abs=1e-9 * np.abs(first).max())


@pytest.mark.parametrize(
    ("change", "what"),
    [
        ({"guide_end": np.array([1.0, 1, 0])}, "guide_end: must lie on an axis of the frame through the beginning"),
        ({"guide_psi": np.zeros((3, 3, 1))}, "guide_psi: must be numbers of the shape"),
        ({"guide_phi": np.array(["a"])}, "guide_phi: must be numbers of the shape"),
        ({"guide_psi": None}, "guide: a rail has guide_r, guide_phi, guide_psi, guide_end"),
    ],
)
def test_rails_that_are_refused(tmp_path: Path, change: dict[str, Array | None], what: str) -> None:
    arrays = {"G": np.eye(7), "K": np.eye(1), "guide_r": np.zeros(3), "guide_end": np.array([1.0, 0, 0])}
    arrays |= {"guide_phi": np.zeros((2, 3, 1)), "guide_psi": np.zeros((2, 3, 1))}
    np.savez(tmp_path / "bed.npz", **{key: x for key, x in {**arrays, **change}.items() if x is not None})
    with pytest.raises(InputError) as error:
        load(tmp_path / "bed.npz")
    assert what in str(error.value)


def test_a_part_of_a_plane_is_a_strip(bed: str) -> None:
    model = of_mesh(bed, "steel", 1.0)
    part = nodes_of(model, f"z={HEIGHT} & x=0.1:1.1 & y=0.1:0.2", "--rail")
    x = model.x[part]
    assert x.min(axis=0) == pytest.approx([0.1, 0.1, HEIGHT]) and x.max(axis=0) == pytest.approx([1.1, 0.2, HEIGHT])
    assert {*model.groups["rail"]} == {*part}
    for text, what in (("z=0.12&x=e", "no group 'z=0.12&x=e'"), ("z=0.12&x=3:4", "no node at 'z=0.12&x=3:4'")):
        with pytest.raises(InputError) as error:
            nodes_of(model, text, "--rail")
        assert what in str(error.value)


def test_nodes_that_are_no_rail(bed: str) -> None:
    for nodes, what in (("at_3", "a rail is a strip along x, y or z"), ("1-3", "a rail is a strip")):
        assert what in refused("flexible", bed, "--fixed", "foot", "--rail", f"guide={nodes}")
    assert "is no NAME=NODES" in refused("flexible", bed, "--fixed", "foot", "--rail", "guide")


def test_many_modes_are_no_rail(tmp_path: Path) -> None:
    modes, rail = 17, Rail(np.zeros(3), np.array([1.0, 0, 0]), np.zeros((2, 17, 3)), np.zeros((2, 17, 3)))
    save(ModalBody(np.eye(4 + 3 * modes), np.ones(modes), np.ones(modes), rails={"guide": rail}), tmp_path / "bed.npz")
    slide = '{ name = "cart", kind = "motor", sigma = 1, along = "column_guide" },'
    with pytest.raises(InputError) as error:
        read(on_a_beam(slide, f'[flexible]\ncolumn = {{ file = "{tmp_path / "bed.npz"}" }}'), "bed.toml")
    assert "along: 'column_guide' has 17 modes, more than 16: leave out those" in str(error.value)


@pytest.mark.parametrize(
    ("limits", "what"),
    [
        ("", "cart slides along column, which is 1.5 m long: give its position in [limits]"),
        ("[limits]\ncart = { position = [-0.2, 1.3] }", "[limits] let it be at 0.05 to 1.55 m, where its deflections"),
        ("[limits]\ncart = { position = [-0.25, 1.25] }", ""),
    ],
)
def test_slides_that_leave_their_body(limits: str, what: str) -> None:
    slide = '{ name = "cart", kind = "motor", sigma = 1, along = "column", from = 0.25 },'
    beam = '[beams]\ncolumn = { along = "x", length = 1.5, EI = 1, mass_per_length = 1, modes = 1, bends = ["y"] }'
    remarks = " ".join(read(on_a_beam(slide, f"{beam}\n{limits}"), "column.toml").origin.remarks)
    assert (what in remarks) if what else ("cart" not in remarks)
