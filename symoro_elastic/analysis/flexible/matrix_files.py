"""Stiffness and mass matrices of nodes in text files: Matrix Market, CalculiX, Nastran and Abaqus.

* Matrix Market: rows are x, y, z of each node, in the order of the table of nodes.
* CalculiX (SOLVER=MATRIXSTORAGE): lines "row column value" of one triangle; the file .dof next to it has a line
  "node.direction" for each row.
* Lines "node, direction, node, direction, value" (Abaqus *MATRIX OUTPUT, CalculiX *MATRIX ASSEMBLE): both triangles
  or one.
* Nastran DMIG (.pch), in fields of 8 or 16 characters or free: the only matrix of the file, or that of the name K...
  or M..., both triangles or one.
"""

from __future__ import annotations

import io
import re
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from symoro_elastic.foundation.array_types import AnyArray, Array
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.input_files import read_file
from symoro_elastic.foundation.packages import for_vibrations

SUFFIXES = (".mtx", ".sti", ".pch")
"""Of files of a stiffness matrix."""
LARGEST = 2**53
"""Integers that floating-point numbers hold exactly."""
REAL = ("1", "2")
"""Types of DMIG: of single and double precision."""
EXPONENT = re.compile(r"(?<=[\d.])(?=[-+]\d+$)")
"""Where Nastran leaves out the E."""
Entries: TypeAlias = tuple[AnyArray, AnyArray, Array]
"""Nodes (N, 2) and directions (N, 2), 1 to 3, of rows and columns, and values (N,)."""


def matrix_of_nodes(file: str, numbers: AnyArray, letter: str) -> Any:
    """Return the sparse matrix (3 n, 3 n) of n nodes in a file, zero for nodes that it does not have.

    `letter`, K or M, chooses one of several. Raises `InputError`.
    """
    text = read_file(file).decode("utf-8-sig", "replace")
    if text.startswith("%%MatrixMarket"):
        return _of_matrix_market(file, text, len(numbers))
    has_dmig = re.search(r"^DMIG", text, re.MULTILINE)
    nodes, axes, values = _of_dmig(file, text, letter) if has_dmig else _of_lines(file, text)
    if not len(values) or not np.isfinite(values).all():
        raise InputError(file, "file", "has no matrix, or a value that is not a number")
    if ((axes < 1) | (axes > 3)).any():
        raise InputError(file, "file", "has directions beyond x, y, z: export solid elements, not beams or shells")
    order = np.argsort(numbers)
    index = order[np.minimum(np.searchsorted(numbers, nodes, sorter=order), len(order) - 1)]
    if (missing := np.unique(nodes[numbers[index] != nodes])).size:
        raise InputError(file, "file", f"has node {missing[0]:.0f}, which the nodes have not: add its coordinates")
    rows, sparse = 3 * index + axes - 1, for_vibrations("scipy.sparse")
    matrix = sparse.coo_matrix((values, rows.T), shape=(3 * len(numbers),) * 2).tocsc()
    diagonal = sparse.diags(matrix.diagonal())
    pattern = abs(matrix - diagonal) > 0
    is_triangle = not pattern.multiply(pattern.T).nnz
    return matrix + matrix.T - diagonal if is_triangle else matrix


def _of_matrix_market(file: str, text: str, count: int) -> Any:
    scipy, content = for_vibrations("scipy.io"), text.strip() + "\n"  # it crashes on blanks at the end, or no rows
    try:
        rows, columns, *_ = scipy.mminfo(io.StringIO(content))
        if rows != 3 * count or columns != rows:
            raise InputError(file, "file", f"has {rows} rows: x, y, z of {count} nodes are {3 * count}")
        return for_vibrations("scipy.sparse").csc_matrix(scipy.mmread(io.StringIO(content)))
    except (ValueError, TypeError) as error:
        raise InputError(file, "file", f"not a Matrix Market file: {str(error)[:120]}") from None


def _of_lines(file: str, text: str) -> Entries:
    """Entries of a matrix from lines "row, column, value" or "node, direction, node, direction, value"."""
    lines = [line.replace(",", " ").replace("D", "E") for line in text.splitlines() if line.strip()[:1] not in "*#"]
    try:
        table = np.loadtxt(lines or ["none"], ndmin=2)
        labels, values = _integers(table[:, :-1]), table[:, -1]
        if table.shape[1] not in (3, 5) or (labels != table[:, :-1]).any():
            raise ValueError
    except ValueError:
        what = "must be Matrix Market, DMIG, or lines of row, column, value or of node, direction (twice), value"
        raise InputError(file, "file", what) from None
    if table.shape[1] == 5:
        return labels[:, ::2], labels[:, 1::2], values
    rows = _rows_of_calculix(str(Path(file).with_suffix(".dof")))
    if labels.min() < 1 or labels.max() > len(rows):
        raise InputError(file, "file", f"has row {labels.max()}: its file .dof has {len(rows)}")
    return rows[labels - 1, 0], rows[labels - 1, 1], values


def _rows_of_calculix(file: str) -> AnyArray:
    """Nodes and directions (N, 2) of the rows of matrices, from a .dof file of CalculiX."""
    rows = [line.split(".") for line in read_file(file).decode("ascii", "replace").split()]
    if not rows or not all(len(row) == 2 and all(x.isdecimal() for x in row) for row in rows):
        raise InputError(file, "file", "must have a line node.direction for each row of the matrices, as 12.1")
    return np.array(rows).astype(np.int64)


def _of_dmig(file: str, text: str, letter: str) -> Entries:
    """Entries of the DMIG matrix whose name begins with a letter, or of the only matrix in the file."""
    matrices: dict[str, list[tuple[int, int, int, int, float]]] = defaultdict(list)
    for number, (name, column, axis, *more) in _cards(text):
        if column == "0":
            if more[0] not in REAL:
                raise InputError(file, f"line {number}", f"{name} has the type {more[0]}: real ones are 1 and 2")
            continue
        try:
            at = int(column), int(axis)
            groups = (more[k : k + 3] for k in range(1, len(more), 4) if more[k])
            terms = [(int(row), int(along), *at, _number(value)) for row, along, value in groups]
        except ValueError:
            what = f"{name} has a term that is not a node, direction and value"
            raise InputError(file, f"line {number}", what) from None
        matrices[name] += terms
    chosen = [name for name in matrices if name.startswith(letter) and not name.startswith("K4")] or [*matrices]
    if len(chosen) != 1:
        what = f"must have one matrix of a name {letter}..., has {', '.join(chosen) or 'none'}"
        raise InputError(file, "file", what)
    table = np.array(matrices[chosen[0]], dtype=float).reshape(-1, 5)
    labels = _integers(table[:, :4])
    return labels[:, ::2], labels[:, 1::2], table[:, 4]


def _cards(text: str) -> Iterator[tuple[int, list[str]]]:
    """Fields of each DMIG entry, from its name on, with its line number; other bulk data are omitted."""
    card: list[str] = []
    first = 0
    for number, line in enumerate([*text.splitlines(), "END"], start=1):
        if line.startswith("$") or not line.strip():
            continue
        if line[0] not in "+* ,":
            if card:
                yield first, card
            card, first = [], number
        if card or line.startswith("DMIG"):
            card = [*card, *_fields(line.expandtabs())]


def _fields(line: str) -> list[str]:
    """The data fields of a line, without the first: eight, or four of twice the width."""
    count, width = (4, 16) if "*" in line[:8] else (8, 8)
    if "," in line:
        fields = line.split(",")[1:]
        return [x.strip() for x in [*fields, *[""] * count][:count]]
    return [line[8 + k * width : 8 + (k + 1) * width].strip() for k in range(count)]


def _integers(x: Array) -> AnyArray:
    """Node labels as integers; 0 for labels that are too large."""
    return np.where(np.abs(x) < LARGEST, x, 0).astype(np.int64)


def _number(text: str) -> float:
    return float(EXPONENT.sub("E", text.upper().replace("D", "E")))
