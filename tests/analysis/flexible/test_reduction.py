"""Bodies by modes of finite elements: against beam theory, the full matrices, and each other."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

import symoro_elastic as se
from symoro_elastic.analysis.flexible.reduction import FiniteElements, modal_body
from symoro_elastic.analysis.flexible.sources import of_mesh
from symoro_elastic.formats.modes_file import load
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import InputError
from tests.command_line import EXAMPLES, ended

skfem = pytest.importorskip("skfem")
sparse = pytest.importorskip("scipy.sparse")

LENGTH, WIDTH, HEIGHT = 0.5, 0.05, 0.03
E, DENSITY = 210e9, 7850.0
SLENDER = f"{E},0,{DENSITY}"
"""Steel without lateral contraction, for which a clamped bar is a beam."""


@pytest.fixture(scope="module")
def bar(tmp_path_factory: pytest.TempPathFactory) -> str:
    mesh = skfem.MeshHex.init_tensor(*(np.linspace(0, *end) for end in ((LENGTH, 11), (WIDTH, 2), (HEIGHT, 2))))
    mesh = mesh.with_boundaries({"root": lambda x: x[0] == 0, "tip": lambda x: np.abs(x[0] - LENGTH) < 1e-9})
    file = tmp_path_factory.mktemp("meshes") / "bar.msh"
    mesh.save(str(file))
    return str(file)


@pytest.fixture(scope="module")
def model(bar: str) -> FiniteElements:
    return of_mesh(bar, SLENDER, 1.0)


def test_a_bar_is_a_beam(bar: str) -> None:
    """Timoshenko's shear lowers f1 by 0.2 and 0.6 %, f2 by 1.4 and 3.7 %: 1.5 (h/L)^2 E/G times 1.2 and more."""
    body = se.flexible(bar, "root", {"tip": "x=0.5"}, material=SLENDER, modes=6).body
    mass, moments, _ = body.rigid
    assert mass == pytest.approx(DENSITY * LENGTH * WIDTH * HEIGHT, rel=1e-12)
    assert moments / mass == pytest.approx([LENGTH / 2, WIDTH / 2, HEIGHT / 2], rel=1e-12)
    for k, size, shear in ((0, HEIGHT, 3e-3), (1, WIDTH, 8e-3)):
        exact = 3.5160152685 / (2 * np.pi * LENGTH**2) * np.sqrt(E * size**2 / (12 * DENSITY))
        assert -shear < body.frequencies[k] / exact - 1 < 1e-3
    along = np.diag(body.compliance("tip"))
    stretched = LENGTH / (E * WIDTH * HEIGHT)
    assert stretched < along[0] < 1.06 * stretched, "forces that are equal at all nodes press into the face"
    for k, (width, size) in ((1, (HEIGHT, WIDTH)), (2, (WIDTH, HEIGHT))):
        bending, shear = LENGTH**3 / (3 * E * width * size**3 / 12), LENGTH / (E / 2 * width * size)
        assert bending < along[k] < bending + 1.3 * shear


def test_compliance_is_that_of_all_elements(model: FiniteElements) -> None:
    held, tip = model.groups["root"], model.groups["tip"]
    body = modal_body(model, held, {"tip": tip}, 2)
    free = np.setdiff1d(np.arange(len(model.x)), held)
    rows = (3 * free[:, None] + np.arange(3)).ravel()
    K = model.K.toarray()[np.ix_(rows, rows)]
    forces = np.zeros((len(model.x), 3, 3))
    forces[tip] = np.eye(3) / len(tip)
    exact = np.linalg.solve(K, forces.reshape(-1, 3)[rows])
    whole = forces.reshape(-1, 3)[rows].T @ exact
    assert body.compliance("tip")[:3, :3] == pytest.approx(whole, rel=1e-8, abs=1e-10 * whole.max())


def test_frequencies_come_from_above_and_are_exact_with_modes(model: FiniteElements) -> None:
    held, tip = model.groups["root"], {"tip": model.groups["tip"]}
    few, many = (modal_body(model, held, tip, count).frequencies for count in (0, 12))
    free = np.setdiff1d(np.arange(len(model.x)), held)
    rows = (3 * free[:, None] + np.arange(3)).ravel()
    M = np.kron(model.m.toarray(), np.eye(3))[np.ix_(rows, rows)]
    lower = np.linalg.inv(np.linalg.cholesky(M))
    squares = np.linalg.eigvalsh(lower @ model.K.toarray()[np.ix_(rows, rows)] @ lower.T)
    exact = np.sqrt(squares[:6]) / (2 * np.pi)
    assert many[:6] == pytest.approx(exact, rel=1e-7)
    assert (few[:4] >= exact[:4] * (1 - 1e-9)).all() and few[:2] == pytest.approx(exact[:2], rel=0.01)


def test_matrices_give_the_body_of_the_mesh(model: FiniteElements, bar: str, tmp_path: Path) -> None:
    from scipy.io import mmwrite

    files = {"K.mtx": model.K, "M.mtx": sparse.kron(model.m, np.eye(3))}
    for name, matrix in files.items():
        stream = io.BytesIO()
        mmwrite(stream, matrix, precision=17)
        (tmp_path / name).write_bytes(stream.getvalue())
    lines = [f"{k},{','.join(map(repr, (1e3 * x).tolist()))}" for k, x in enumerate(model.x, start=1)]
    (tmp_path / "nodes.csv").write_text("\n".join(["node,x,y,z", *lines]))
    where = {"mass": tmp_path / "M.mtx", "nodes": tmp_path / "nodes.csv", "scale": 1e-3, "mass_unit": "kg"}
    body = se.flexible(tmp_path / "K.mtx", "x=0", {"tip": "x=0.5"}, **where).body
    of_mesh_ = se.flexible(bar, "root", {"tip": "tip"}, material=SLENDER).body
    assert body.frequencies == pytest.approx(of_mesh_.frequencies, rel=1e-6)
    assert body.G[:4, :4] == pytest.approx(of_mesh_.G[:4, :4], rel=1e-9, abs=1e-12)


def test_a_file_of_modes_is_read_back(bar: str, tmp_path: Path) -> None:
    result = se.flexible(bar, "root", {"tip": "tip"})
    body = load(result.write(tmp_path / "bar.npz"))
    for key in ("G", "stiffness", "damping"):
        assert np.array_equal(getattr(body, key), getattr(result.body, key)), key
    assert body.compliance("tip") == pytest.approx(result.body.compliance("tip"), rel=1e-15)
    assert se.flexible(tmp_path / "bar.npz").as_json()["mass"] == pytest.approx(5.8875)


def test_the_command_says_what_it_made(bar: str, tmp_path: Path) -> None:
    made = ended("flexible", bar, "--fixed", "root", "--interface", "tip=tip", "--save", tmp_path / "bar.npz")
    assert made.code == 0 and "5.8875 kg, 12 modes, the first at 1" in made.out, made
    assert "[flexible]" not in made.err and (tmp_path / "bar.npz").exists()


def _refused(call: Callable[[], object]) -> str:
    with pytest.raises(InputError) as error:
        call()
    return str(error.value)


def test_refused(bar: str, model: FiniteElements, tmp_path: Path) -> None:
    assert "no group 'rot'; did you mean 'root'" in _refused(lambda: se.flexible(bar, "rot"))
    assert "no node at 'x=7'" in _refused(lambda: se.flexible(bar, "x=7"))
    assert "says which nodes the joint holds" in _refused(lambda: se.flexible(bar))
    assert "nodes on a line or point" in _refused(lambda: se.flexible(bar, "1-1"))
    assert "no material 'stel'; did you mean 'steel'" in _refused(lambda: se.flexible(bar, "root", material="stel"))
    assert "no mesh can be read" in _refused(lambda: se.flexible(EXAMPLES / "two_axis.toml", "root"))
    fixed = FiniteElements(model.x, model.K + sparse.identity(3 * len(model.x)) * 1e9, model.m, model.numbers, "K", "")
    tied = _refused(lambda: modal_body(fixed, model.groups["root"], {}, 2))
    assert "a motion of the whole body meets forces: export the free model" in tied


def _files(arrays: dict[str, np.ndarray]) -> Iterator[tuple[str, dict[str, np.ndarray], str]]:
    yield "no K", {"G": arrays["G"]}, "K: is missing"
    yield "not symmetric", {**arrays, "G": arrays["G"] + np.eye(len(arrays["G"]), k=1)}, "G: is not symmetric"
    yield "negative", {**arrays, "G": -arrays["G"]}, "G: has a negative eigenvalue"
    yield "shape", {**arrays, "tool_phi": np.zeros((3, 99))}, "tool_phi: must be numbers of the shape"
    yield "complex", {**arrays, "tool_phi": arrays["tool_phi"] * 1j}, "tool_phi: must be numbers of the shape"
    yield "rigid", {**arrays, "K": 0 * arrays["K"]}, "K: a mode without stiffness"
    yield "coupled", {**arrays, "K": arrays["K"] + 1e3}, "K: is not diagonal"


def test_wrong_files_are_refused(tmp_path: Path) -> None:
    with np.load(EXAMPLES / "bracket.npz", allow_pickle=False) as stored:
        arrays = {key: stored[key] for key in stored.files}
    for name, wrong, what in _files(arrays):
        np.savez(tmp_path / "wrong.npz", **wrong)
        assert what in _refused(lambda: load(tmp_path / "wrong.npz")), name
    for content in (b"", b"text", (EXAMPLES / "bracket.npz").read_bytes()[:3000], _npy(np.eye(3))):
        (tmp_path / "damaged.npz").write_bytes(content)
        assert "not a .npz file of arrays" in _refused(lambda: load(tmp_path / "damaged.npz"))
    with zipfile.ZipFile(tmp_path / "zeros.npz", "w", zipfile.ZIP_DEFLATED) as large:
        large.writestr("G.npy", bytes(60_000_000))
    assert "arrays of more than 50 MB" in _refused(lambda: load(tmp_path / "zeros.npz"))
    np.savez(tmp_path / "pickle.npz", G=np.array([{}], dtype=object), K=np.eye(2))
    assert "not a .npz file of arrays" in _refused(lambda: load(tmp_path / "pickle.npz"))


def _npy(x: Array) -> bytes:
    stream = io.BytesIO()
    np.save(stream, x)
    return stream.getvalue()


def test_a_rigid_interface_moves_as_one_body(model: FiniteElements) -> None:
    """Its compliance is that of elements whose nodes at the tip are fixed to a frame there."""
    held, tip = model.groups["root"], model.groups["tip"]
    averaged, rigid = (modal_body(model, held, {"tip": tip}, 2, rigid=names) for names in ((), ("tip",)))
    assert rigid.frequencies[0] > averaged.frequencies[0]
    others = np.setdiff1d(np.arange(len(model.x)), [*held, *tip])
    rows = (3 * others[:, None] + np.arange(3)).ravel()
    at_tip = (3 * tip[:, None] + np.arange(3)).ravel()
    arms = model.x[tip] - model.x[tip].mean(axis=0)
    motions = np.vstack([np.hstack([np.eye(3), np.cross(np.eye(3), arm).T]) for arm in arms])
    K = model.K.toarray()
    coupled = K[np.ix_(rows, at_tip)] @ motions
    held_off = K[np.ix_(rows, rows)]
    stiffness = motions.T @ K[np.ix_(at_tip, at_tip)] @ motions - coupled.T @ np.linalg.solve(held_off, coupled)
    exact = np.linalg.inv(stiffness)
    assert rigid.compliance("tip") == pytest.approx(exact, rel=1e-6, abs=1e-8 * np.abs(exact).max())
    assert rigid.about.endswith("rigid interface tip")


def test_rigid_interfaces_are_apart(bar: str) -> None:
    what = "is rigid and has nodes of the joint, or of another rigid interface"
    assert what in _refused(lambda: se.flexible(bar, "root", {"tip": "root:rigid"}))
    assert what in _refused(lambda: se.flexible(bar, "tip", {"a": "x=0:rigid", "b": "x=0:rigid"}))
    assert se.flexible(bar, "root", {"tip": "tip:rigid"}).body.count == 12
