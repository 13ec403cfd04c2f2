"""Entries of results that repeat others are written in rows: the batch still gives what single calls give."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from symoro_elastic.codegen.compile import compile_package
from symoro_elastic.codegen.package import Package
from symoro_elastic.codegen.precision import DOUBLE, MIXED, SINGLE, Precision
from symoro_elastic.codegen.targets.c_batch import render_c_batch
from symoro_elastic.codegen.targets.cuda import render_cuda
from symoro_elastic.formats import read_machine
from symoro_elastic.formats.toml import reading as toml
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.scene import ALL, Scene
from symoro_elastic.models.packaging import trace_models

pytestmark = pytest.mark.sampled(5)

EXAMPLES = Path(__file__).parents[2] / "examples"
STRICT = ("-O0", "-Wconversion", "-Wshadow")
COUNTS = (1, 3, 7, 16, 17, 511, 512, 513, 1041)
"""Numbers of states: below and above what is computed side by side, and what is written in rows at a time."""


@cache
def slides() -> Machine:
    """Nine slides on one another: their inertia matrix is constant."""
    row = '{{ name = "x{j}", antecedent = {i}, kind = "motor", sigma = 1, r = "q{j}" }}'
    rows = ", ".join(row.format(i=j - 1, j=j) for j in range(1, 10))
    bodies = "\n".join(f"x{j} = {{ mass = {j}.5 }}" for j in range(1, 10))
    return toml.read(f'name = "slides"\njoints = [{rows}]\n[bodies]\n{bodies}', "slides.toml")


@cache
def package(name: str) -> Package:
    """The inertia matrix of one of the examples, or of the slides; "folded" without parameters."""
    stem, _, folded = name.partition(" ")
    machine = slides() if stem == "slides" else read_machine(EXAMPLES / f"{stem}.toml")[0]
    return trace_models(machine, Scene(("inertia_matrix", "jacobian"), fold=ALL if folded else ())).package


@pytest.mark.parametrize(
    ("name", "precision"),
    [("two_axis", DOUBLE), ("two_axis folded", SINGLE), ("slides", MIXED)],
    ids=["double", "single", "mixed"],
)
def test_the_batch_is_the_single_calls(name: str, precision: Precision, tmp_path: Path) -> None:
    of = package(name)
    code = compile_package(of, tmp_path, precision=precision, flags=STRICT)
    q = np.random.default_rng(0).uniform(-1, 1, (max(COUNTS), len(of.axes)))
    for model in ("inertia_matrix", "jacobian"):
        (wanted,) = code.call(model, q=q).values()
        for count in COUNTS:
            (found,) = code.call_batch(model, q=q[:count]).values()
            assert np.array_equal(found, wanted[:count]), (model, count)


@pytest.mark.parametrize(("name", "stored"), [("two_axis", 25), ("slides", 0)])
def test_vectors_store_no_entry_twice_and_no_number(name: str, stored: int) -> None:
    text = render_c_batch(package(name))[f"{name}_batch.c"]
    body = text[text.index("inertia_matrix_lanes(") : text.index("inertia_matrix_rows_of_A(")]
    values = re.findall(r"STORE\(A \+ \d+\*states, (.*)\);", body)
    assert len(values) == len(set(values)) == stored


def test_kernels_store_every_entry() -> None:
    """Only what writes rows leaves them."""
    text = "".join(render_cuda(package("two_axis")).values())
    assert len(set(re.findall(r" A\[(\d+)\*states\] = ", text))) == 144


def test_small_results_are_stored_as_they_are_computed() -> None:
    machine, _ = read_machine(EXAMPLES / "planar_2r.toml")
    text = render_c_batch(trace_models(machine, Scene(("inertia_matrix",))).package)["planar_2r_batch.c"]
    assert "rows_of" not in text and "ROW" not in text
