"""Batches load numbers where they are needed first and store them where they are found; angles of any size."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from symoro_elastic.codegen.c import function as c_function
from symoro_elastic.codegen.c.function import near_use
from symoro_elastic.codegen.compile import compile_package
from symoro_elastic.codegen.partition import Part, Step, partition
from symoro_elastic.codegen.precision import DOUBLE, MIXED, SINGLE, Precision
from symoro_elastic.codegen.targets.c_batch import render_c_batch
from symoro_elastic.generation.pipeline import programs
from symoro_elastic.machine.scene import Scene
from symoro_elastic.symbolic.expression import Graph
from symoro_elastic.symbolic.program import Section, Statement
from tests.benchmarks.machines import chain

MODEL = "direct_dynamics"
PLAIN = ("-O0", "-ffp-contract=off")
READ = re.compile(r" *const \w+ (\w+) = (?:LOAD\(.*\)|(?:spill|p|c)\[\w+\]);")
WRITTEN = re.compile(r" *(?:STORE\(.*, (\w+)\)|spill\[\d+\] = (\w+));")
DEFINED = re.compile(r" *const \w+ (\w+) =")


@pytest.fixture
def in_parts(monkeypatch: pytest.MonkeyPatch) -> None:
    """Parts of 40 statements."""

    def short(steps: list[Step], needed: list[str], *_: int, apart: bool = False) -> tuple[list[Part], int]:
        return partition(steps, needed, 40, 40, apart=apart)

    monkeypatch.setattr(c_function, "partition", short)


def routines(text: str) -> list[list[str]]:
    """The statements of every part of the work on vectors, without comments."""
    bodies = re.findall(r"_lanes_part\d+\([^{]*\)\n\{\n(.*?)\n\}\n", text, re.S)
    plain = [re.sub(r"/\*.*?\*/", "", body, flags=re.S) for body in bodies]
    return [[re.sub(r"\s+", " ", one) + ";" for one in body.split(";") if one.strip()] for body in plain]


def test_loads_stand_before_the_first_use_and_stores_after_the_definition(in_parts: None) -> None:
    package = programs(chain(4), Scene(models=(MODEL,))).package
    parts = routines(render_c_batch(package)["chain4_batch.c"])
    assert len(parts) > 4
    loads = stores = 0
    for lines in parts:
        for k, line in enumerate(lines):
            if found := READ.match(line):
                later = [one for one in lines[k:] if not READ.match(one) and not re.search(r"= -?[\d.e+-]+;", one)]
                assert re.search(rf"\b{found[1]}\b", later[0]), (line, later[0])
                loads += 1
            if found := WRITTEN.match(line):
                name = found[1] or found[2]
                before = [one for one in lines[:k] if not WRITTEN.match(one)]
                last = DEFINED.match(before[-1])
                assert last and last[1] == name, line
                stores += 1
        slots = [set(re.findall(pattern, "\n".join(lines))) for pattern in (r"= spill\[(\d+)\]", r"spill\[(\d+)\] =")]
        assert not slots[0] & slots[1]
    assert loads > 20 and stores > 20


@pytest.mark.sampled(5)
@pytest.mark.parametrize("precision", (DOUBLE, SINGLE, MIXED), ids=lambda one: one.name)
def test_batches_in_parts_have_the_bits_of_calls(precision: Precision, in_parts: None, tmp_path: Path) -> None:
    package = programs(chain(3), Scene(models=(MODEL,))).package
    code = compile_package(package, tmp_path, precision=precision, flags=PLAIN)
    rng = np.random.default_rng(3)
    state = {argument.name: rng.uniform(-2, 2, (21, argument.size)) for argument in package.functions[0].arguments}
    assert np.array_equal(code.call_batch(MODEL, **state)["qdd"], code.call(MODEL, **state)["qdd"])


@pytest.mark.sampled(5)
@pytest.mark.parametrize("precision", (DOUBLE, SINGLE, MIXED), ids=lambda one: one.name)
def test_angles_of_any_size_have_the_bits_of_calls(precision: Precision, tmp_path: Path) -> None:
    """The sum of squares is large where no angle is, too: the bits do not depend on what lies beside a state."""
    package = programs(chain(3), Scene(models=("inertia_matrix",))).package
    code = compile_package(package, tmp_path, precision=precision, flags=PLAIN)
    largest = 1024.0 if precision is SINGLE else 65536.0
    sizes = [0, 1, largest, np.nextafter(largest, 1e9), 0.9 * largest, 1.1 * largest, 1e8, 1e30, np.inf, np.nan]
    rng = np.random.default_rng(4)
    q = np.vstack([rng.uniform(-np.pi, np.pi, (64, 3)), rng.choice(sizes, (64, 3)) * rng.choice([-1, 1], (64, 3))])
    q = rng.permutation(q)
    found, wanted = (call("inertia_matrix", q=q)["A"] for call in (code.call_batch, code.call))
    assert np.isfinite(wanted).all(axis=(1, 2)).sum() > 64
    assert np.array_equal(found, wanted, equal_nan=True)


def test_what_no_statement_needs_or_finds_is_at_the_end() -> None:
    x = Graph().symbol("x")
    steps = [Step(Statement(name, x, False, Section("")), frozenset(uses)) for name, uses in (("a", "x"), ("b", "ay"))]
    around, at_end = near_use(steps, dict(zip("xyz", "XYZ", strict=True)), [("y", "1"), ("z", "2"), ("a*b", "3")])
    assert around.before == {"a": ["X"], "b": ["Y"]}
    assert around.after == {"a": [], "b": ["3"]}
    assert at_end == ["1", "Z", "2"]
