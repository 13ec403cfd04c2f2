"""What polynomials prove of the machines of certificates: attacked like these, and on its own."""

from __future__ import annotations

import math

import pytest

import symoro_elastic as se
from symoro_elastic.codegen.precision import PRECISIONS
from symoro_elastic.generation.pipeline import certificates, programs
from symoro_elastic.machine.scene import Scene
from symoro_elastic.numerics.guarantees.box import box_of
from symoro_elastic.numerics.guarantees.certificates import Effort
from symoro_elastic.numerics.guarantees.largest_value import largest
from symoro_elastic.numerics.guarantees.polynomial_rounding import rounding_bound
from symoro_elastic.numerics.guarantees.running_error import ROUNDINGS
from tests.numerics.guarantees.attack import SLACK, Attack
from tests.numerics.guarantees.test_certificates import HINGE, MACHINES, QUICK, certified, limited, results_of

WORK = 1e9
"""Bounds are attacked that are proven when this is done, too."""


MORE = ("puma", "gantry")
"""More machines: `python -m tests.benchmarks.certificates --polynomials`."""


@pytest.mark.parametrize("name", [*QUICK, *(pytest.param(name, marks=pytest.mark.thorough) for name in MORE)])
@pytest.mark.parametrize("model", ["inverse_dynamics", "inertia_matrix"])
def test_bounds_are_never_exceeded(name: str, model: str) -> None:
    """Rounding in double and single, and largest values, in the whole and a moderate box."""
    whole, proven = MACHINES[name](), 0
    for scale in (1.0, 0.2):
        machine = limited(whole, scale)
        program = programs(machine, Scene(models=(model,))).package.functions[0].program
        roots = [x for output in program.outputs for x in output.entries]
        box = box_of(machine, machine.limits, program.inputs, program.used)
        chosen = roots[1 :: 1 + len(roots) // 2]
        largests = [largest(x, box, work=WORK) for x in chosen]
        for precision in ("double", "single"):
            worst = Attack(chosen, box, precision).run(2000, rounds=5)
            for k, (x, most) in enumerate(zip(chosen, largests, strict=True)):
                bound = rounding_bound(x, box, ROUNDINGS[precision]).bound
                assert worst.error[k] <= bound * (1 + SLACK[precision])
                found = max(abs(worst.low[k]), abs(worst.high[k]), most.found)
                assert found <= most.bound * (1 + 1e-5 if precision == "single" else 1 + 1e-12)
                proven += math.isfinite(bound) and math.isfinite(most.bound)
    assert proven


def test_certificates_take_the_smaller_error() -> None:
    machine = limited(MACHINES["two joints"]())
    scene, double = Scene(models=("inertia_matrix",)), [PRECISIONS["double"]]
    told: list[tuple[int, int]] = []
    effort = Effort(1, polynomials=True, progress=lambda *x: told.append(x))
    refined = certificates(machine, scene, double, effort).certificates[0]
    plain = certified(machine, "inertia_matrix", sub_boxes=1)
    errors = [(one.error, two.error) for one, two in zip(refined.entries, plain.entries, strict=True)]
    assert all(one <= two for one, two in errors)
    assert all(entry.likely <= entry.error for entry in refined.entries)
    assert all(
        one.low >= two.low and one.high <= two.high for one, two in zip(refined.entries, plain.entries, strict=True)
    )
    worst = Attack(results_of(machine, "inertia_matrix"), refined.box, "double").run(2000, rounds=6)
    for entry, low, high in zip(refined.entries, worst.low, worst.high, strict=True):
        assert entry.low <= low and high <= entry.high
        assert entry.high - entry.low <= 1.2 * (high - low) + 1e-9 * entry.magnitude
    assert told[-1] == (len(refined.entries), len(refined.entries))


@pytest.mark.thorough
def test_what_is_no_polynomial_keeps_its_error() -> None:
    machine = limited(MACHINES["two joints"]())
    scene, double = Scene(models=("direct_dynamics",)), [PRECISIONS["double"]]
    refined = certificates(machine, scene, double, Effort(1, polynomials=True)).certificates[0]
    assert refined.entries == certified(machine, "direct_dynamics", sub_boxes=1).entries


def test_the_option() -> None:
    """A pendulum whose mass is known to 10 %: parameters with a range are variables."""
    plain, refined = (
        se.certify(HINGE, "inverse_dynamics", polynomials=x).certificates[0].entries[0] for x in (False, True)
    )
    assert refined.error <= plain.error
