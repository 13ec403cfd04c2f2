"""Matrices in files of finite-element programs: the same body from each, and a clear line for damaged ones."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import symoro_elastic as se
from symoro_elastic.analysis.flexible.matrix_files import matrix_of_nodes
from symoro_elastic.analysis.flexible.reduction import FiniteElements, modal_body
from symoro_elastic.analysis.flexible.solid_elements import SolidElements
from symoro_elastic.formats.modes_file import ModalBody
from symoro_elastic.foundation.errors import InputError

skfem = pytest.importorskip("skfem")
sparse = pytest.importorskip("scipy.sparse")
Terms = list[tuple[tuple[int, int], tuple[int, int], float]]
"""Node and direction of a row, of a column, and the value."""
MM, TONNE = 1e-3, 1e3


@pytest.fixture(scope="module")
def model() -> FiniteElements:
    """A block of tetrahedra whose nodes have numbers without order, and whose terms have few digits."""
    basis = skfem.Basis(
        skfem.MeshTet.init_tensor(*(np.linspace(0, 0.1 * k, k + 1) for k in (3, 1, 1))), skfem.ElementTetP1()
    )
    solid = SolidElements.of(basis, (6e9, 6e9))
    numbers = 3 + 7 * np.random.default_rng(0).permutation(basis.N)
    return FiniteElements(basis.doflocs.T, solid.stiffness(), solid.mass(2400.0), numbers, "block", "")


@pytest.fixture(scope="module")
def body(model: FiniteElements) -> ModalBody:
    x = model.x[:, 0]
    return modal_body(model, np.flatnonzero(x == 0), {"tip": np.flatnonzero(x > 0.299)}, 3)


def terms_of(model: FiniteElements, matrix: Any, lower: bool) -> Terms:
    """Terms of a matrix in drawn order, of one triangle by the index or of both."""
    matrix = sparse.coo_matrix(sparse.tril(matrix) if lower else matrix)
    order = np.random.default_rng(1).permutation(matrix.nnz)
    ends = [[(int(model.numbers[k // 3]), int(k % 3) + 1) for k in x[order]] for x in (matrix.row, matrix.col)]
    return [(*pair, float(x)) for pair, x in zip(zip(*ends, strict=True), matrix.data[order], strict=True)]


def labelled(terms: Terms) -> str:
    return "".join(f"{a[0]},{a[1]}, {b[0]},{b[1]}, {x:.16e}\n" for a, b, x in terms)


def calculix(terms: Terms) -> tuple[str, str]:
    """Rows and columns by equations in drawn order, and the nodes of these."""
    ends = sorted({end for a, b, _ in terms for end in (a, b)}, key=lambda end: (7 * end[0] + 3 * end[1]) % 23)
    at = {end: k + 1 for k, end in enumerate(ends)}
    lines = (f"{min(at[a], at[b])} {max(at[a], at[b])} {x:20.13e}\n" for a, b, x in terms)
    return "".join(lines), "".join(f"{node}.{axis}\n" for node, axis in ends)


def columns(terms: Terms) -> Iterator[tuple[tuple[int, int], list[tuple[int, int, float]]]]:
    for end in sorted({b for _, b, _ in terms}):
        yield end, [(*a, x) for a, b, x in terms if b == end]


def small(name: str, terms: Terms) -> str:
    """Fields of 8 characters, with numbers as 1.234+5."""
    text = f"DMIG    {name:8}       0       6       1       0\n"
    for (node, axis), rows in columns(terms):
        groups = [f"{a:8d}{b:8d}{short(x):>8}{'':8}" for a, b, x in rows]
        text += f"DMIG    {name:8}{node:8d}{axis:8d}{'':8}{groups[0].rstrip()}\n"
        for k in range(1, len(groups), 2):
            text += f"{'':8}{''.join(groups[k : k + 2]).rstrip()}\n"
    return text


def short(x: float) -> str:
    mantissa, exponent = f"{x:.3e}".split("e")
    return f"{mantissa}{int(exponent):+d}"


def large(name: str, terms: Terms) -> str:
    """Fields of 16 characters with D, as punched."""
    text = f"DMIG    {name:8}       0       6       2       0               {len(terms):8d}\n"
    for (node, axis), rows in columns(terms):
        text += f"DMIG*   {name:16}{node:16d}{axis:16d}\n"
        text += "".join(f"*       {a:16d}{b:16d}{x:16.9E}\n".replace("E", "D") for a, b, x in rows)
    return text


def free(name: str, terms: Terms) -> str:
    text = f"$ a comment\nGRID,7,,1.,2.,3.\nDMIG,{name},0,1,2\n"
    for (node, axis), rows in columns(terms):
        first, *more = [f"{a},{b},{x!r}," for a, b, x in rows]
        text += f"DMIG,{name},{node},{axis},,{first}\n" + "".join(f",{line}\n" for line in more)
    return text


def written(form: str, model: FiniteElements, folder: Path) -> dict[str, Any]:
    """Files of a form in `folder`, in mm, N and t, as arguments of `flexible`."""
    matrices = {"K": model.K / TONNE, "M": sparse.kron(model.m, np.eye(3)) / TONNE}
    terms = {name: terms_of(model, x, form != "both triangles") for name, x in matrices.items()}
    nodes = [
        f"{k}, {', '.join(repr(x / MM) for x in place)}"
        for k, place in zip(model.numbers, model.x.tolist(), strict=True)
    ]
    (folder / "nodes.inp").write_text("\n".join(["*NODE, NSET=NALL", *nodes, "9999, 1., 2., 3."]))
    files = {"K": folder / "K.mtx", "M": folder / "M.mtx"}
    if form == "calculix":
        files = {"K": folder / "job.sti", "M": folder / "job.mas"}
        for name, file in files.items():
            text, rows = calculix(terms[name])
            file.write_text(text)
            (folder / "job.dof").write_text(rows)
    elif form in DMIG:
        text = "".join(DMIG[form](f"{name}AAX", terms[name]) for name in terms)
        (folder / "job.pch").write_text(text + "ENDDATA\n")
        files = dict.fromkeys(files, folder / "job.pch")
    else:
        for name, file in files.items():
            file.write_text(f"** {name}\n{labelled(terms[name])}")
    return {"source": files["K"], "mass": files["M"], "nodes": folder / "nodes.inp", "scale": MM, "mass_unit": "t"}


DMIG: dict[str, Callable[[str, Terms], str]] = {"small": small, "large": large, "free": free}
FORMS = ("one triangle", "both triangles", "calculix", *DMIG)


def read(arguments: dict[str, Any]) -> ModalBody:
    return se.flexible(fixed="x=0", interfaces={"tip": "x=0.3"}, modes=3, **arguments).body


@pytest.mark.parametrize("form", FORMS)
def test_each_form_gives_the_body(form: str, model: FiniteElements, body: ModalBody, tmp_path: Path) -> None:
    """Ten digits of numbers in large fields are the fewest."""
    same = read(written(form, model, tmp_path))
    assert same.frequencies == pytest.approx(body.frequencies, rel=1e-7)
    along, exact = same.compliance("tip"), body.compliance("tip")
    assert along == pytest.approx(exact, rel=1e-6, abs=1e-9 * np.abs(exact).max())
    assert same.G[:4, :4] == pytest.approx(body.G[:4, :4], rel=1e-8, abs=1e-12)


def change(name: str, old: str, new: str) -> Callable[[Path], None]:
    """A change of a file: the first `old` becomes `new`."""

    def applied(folder: Path) -> None:
        text = (folder / name).read_text()
        assert old in text
        (folder / name).write_text(text.replace(old, new, 1))

    return applied


def cut(name: str) -> Callable[[Path], None]:
    """A file of half its lines."""

    def applied(folder: Path) -> None:
        lines = (folder / name).read_text().splitlines()
        (folder / name).write_text("\n".join(lines[: len(lines) // 2]))

    return applied


WRONG = {
    "no coordinates": ("one triangle", change("nodes.inp", "\n3,", "\n9998,"), "has node 3, which the nodes have not"),
    "a node twice": ("one triangle", change("nodes.inp", "9999,", "3,"), "nodes.inp: file: has node 3 2 times"),
    "rotations": ("one triangle", change("K.mtx", ",3,", ",4,"), "has directions beyond x, y, z: export solid"),
    "other lines": ("one triangle", change("K.mtx", "3,", "3,3,"), "must be Matrix Market, DMIG, or lines of"),
    "words": ("one triangle", change("M.mtx", "\n", "\nsee K\n"), "M.mtx: file: must be Matrix Market, DMIG"),
    "no number": ("one triangle", change("M.mtx", "e-0", "e+999"), "or a value that is not a number"),
    "half": ("both triangles", cut("K.mtx"), "K.mtx: K: "),
    "half of the mass": ("one triangle", cut("M.mtx"), "M.mtx: M: is not the same in x, y, z"),
    "few rows": ("calculix", cut("job.dof"), "its file .dof has"),
    "other rows": ("calculix", change("job.dof", ".", ","), "job.dof: file: must have a line node.direction"),
    "complex": ("large", change("job.pch", "       6       2", "       6       4"), "KAAX has the type 4: real ones"),
    "two": ("large", lambda folder: twice(folder / "job.pch"), "must have one matrix of a name K..., has KAAX, KBBX"),
    "no term": ("small", change("job.pch", "+", "x"), "KAAX has a term that is not a node, direction and value"),
}


def twice(file: Path) -> None:
    text = file.read_text()
    file.write_text(text + text.replace("KAAX", "KBBX"))


@pytest.mark.parametrize("case", WRONG)
def test_damaged_files_are_refused(case: str, model: FiniteElements, tmp_path: Path) -> None:
    form, damage, what = WRONG[case]
    arguments = written(form, model, tmp_path)
    damage(tmp_path)
    with pytest.raises(InputError) as error:
        read(arguments)
    assert what in str(error.value)


@pytest.mark.parametrize(
    ("change", "what"),
    [
        ({"mass": None}, "mass: a stiffness without mass has no frequencies"),
        ({"nodes": None}, "nodes: integrals over the mass need coordinates"),
        ({"mass_unit": ""}, "mass_unit: says the unit of mass in matrices whose lengths are not m"),
        ({"mass_unit": "lb"}, "mass_unit: says the unit of mass"),
    ],
)
def test_missing_parts_are_named(change: dict[str, Any], what: str, model: FiniteElements, tmp_path: Path) -> None:
    with pytest.raises(InputError) as error:
        read(written("one triangle", model, tmp_path) | change)
    assert what in str(error.value)


def test_bodies_without_mass_are_refused(model: FiniteElements, tmp_path: Path) -> None:
    arguments = written("one triangle", model, tmp_path)
    (tmp_path / "M.mtx").write_text("".join(f"{k},{axis},{k},{axis},0.\n" for k in model.numbers for axis in (1, 2, 3)))
    with pytest.raises(InputError, match="adds up to no mass: give the material a density"):
        read(arguments)


def test_texts_that_crash_a_library_are_read_or_refused(tmp_path: Path) -> None:
    """SciPy 1.17 ends the process for a blank at the end, and for an array without rows."""
    head, numbers = "%%MatrixMarket matrix", np.array([1, 2, 3])
    for text in (f"{head} array real general\n0 9\n1.5\n", f"{head} array real general\n99999999 9\n1.5\n"):
        (tmp_path / "K.mtx").write_text(text)
        with pytest.raises(InputError, match=r"rows: x, y, z of 3 nodes are 9"):
            matrix_of_nodes(str(tmp_path / "K.mtx"), numbers, "K")
    (tmp_path / "K.mtx").write_text(f"{head} coordinate real symmetric\n9 9 1\n1 1 2.0 ")
    assert matrix_of_nodes(str(tmp_path / "K.mtx"), numbers, "K")[0, 0] == 2.0
