"""What a call costs must not grow: counted operations, and instructions of compiled C as callgrind counts them."""

from __future__ import annotations

import re
import shutil
import subprocess
from collections.abc import Callable
from functools import cache
from pathlib import Path

import pytest

from symoro_elastic.machine.machine import Machine
from symoro_elastic.symbolic.program import OperationCount
from tests.benchmarks import contest
from tests.benchmarks.instructions import available, per_call
from tests.benchmarks.machines import arm_6, humanoid, two_axis, with_base_parameters
from tests.benchmarks.ours import Code, code

pytestmark = pytest.mark.sampled(5)

MACHINES: dict[str, Callable[[], Machine]] = {"arm": arm_6, "tree": humanoid, "two_axis": two_axis}
INVERSE, DIRECT, INERTIA = "inverse_dynamics", "direct_dynamics", "inertia_matrix"

OPERATIONS = {
    ("arm", INVERSE): 462,
    ("arm", DIRECT): 1015,
    ("arm", INERTIA): 222,
    ("tree", INVERSE): 2563,
    ("tree", DIRECT): 6229,
    ("two_axis", DIRECT): 239,
}
"""Products, divisions and sums of a call; base inertial parameters, parameters not folded."""

INSTRUCTIONS = {
    ("gcc", 12): {("arm", INVERSE): 1019, ("arm", DIRECT): 1543, ("arm", INERTIA): 558, ("two_axis", DIRECT): 392},
    ("clang", 14): {("arm", INVERSE): 761, ("arm", DIRECT): 1391, ("arm", INERTIA): 471, ("two_axis", DIRECT): 364},
}
"""Of a call, as counted with one version of a compiler; other versions differ by a few per cent."""
MARGIN = 1.05
PER_OPERATION, PER_ANGLE, PER_ENTRY = 1.4, 70, 2
"""For compilers that are not in the table: what a counted operation (its loads, its stores), a sine with its cosine,
and an entry of an argument or result may cost. Counted figures are at most 0.87 of that."""


@cache
def traced(machine: str, model: str) -> Code:
    return code(with_base_parameters(MACHINES[machine]()), model, fold=False)


def bound(made: Code) -> float:
    """Instructions of a call that no compiler should exceed."""
    count = made.operations
    operations, angles = count.products + count.add, count.sincos / 2
    entries = sum(made.inputs) + sum(made.results)
    return PER_OPERATION * operations + PER_ANGLE * angles + PER_ENTRY * entries


@pytest.mark.parametrize(("machine", "model"), OPERATIONS)
def test_operations_do_not_grow(machine: str, model: str) -> None:
    count: OperationCount = traced(machine, model).operations
    assert count.products + count.add <= OPERATIONS[machine, model], count


@pytest.mark.sampled(12)
@pytest.mark.skipif(not available(), reason="callgrind counts instructions: install valgrind")
@pytest.mark.parametrize("compiler", ["gcc", "clang"])
@pytest.mark.parametrize(("machine", "model"), INSTRUCTIONS["gcc", 12])
def test_instructions_do_not_grow(
    machine: str, model: str, compiler: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    if not shutil.which(compiler):
        pytest.skip(f"{compiler} is not installed")
    if not runs_avx2():
        pytest.skip("the processor has no AVX2 and FMA, for which the code is compiled")
    monkeypatch.setattr(contest, "BUILD", tmp_path)
    made = traced(machine, model)
    counted = per_call(made, compiler)
    stored = INSTRUCTIONS.get((compiler, version(compiler)), {}).get((machine, model))
    assert counted > made.operations.products + made.operations.add - made.operations.mul
    assert counted <= (MARGIN * stored if stored else bound(made))


def test_bound_is_near_what_is_stored() -> None:
    """The bound for unknown compilers catches code that is half as long again."""
    for figures in INSTRUCTIONS.values():
        for (machine, model), stored in figures.items():
            assert stored < bound(traced(machine, model)) < 1.6 * stored


def version(compiler: str) -> int:
    """Major version of a compiler."""
    told = subprocess.run([compiler, "-dumpversion"], capture_output=True, text=True, check=True)
    return int(re.match(r"\d+", told.stdout)[0])


def runs_avx2() -> bool:
    flags = Path("/proc/cpuinfo")
    words = flags.read_text(encoding="ascii").split() if flags.exists() else []
    return {"avx2", "fma"} <= set(words)
