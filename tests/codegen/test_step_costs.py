"""What a step takes of the stack is known before, as real time asks."""

from __future__ import annotations

import pytest

from tests.benchmarks.machines import two_axis
from tests.benchmarks.steps import can_measure_stack, largest_stack, step_code

pytestmark = pytest.mark.sampled(5)

STACK = {"w3": 4000, "rk4": 2500}
"""Bytes that a step of twelve joints may take: its stages, its factors, and the deepest model."""


@pytest.mark.sampled(1000)
@pytest.mark.skipif(not can_measure_stack(), reason="gcc says what each function takes of the stack: install it")
@pytest.mark.parametrize("method", STACK)
def test_stack_of_a_step_is_bounded_and_small(method: str) -> None:
    """Its arrays are 14 vectors of the joints, or 11, at least."""
    code = step_code(two_axis(), method)
    vectors = {"w3": 14, "rk4": 11}[method]
    assert 8 * 12 * vectors <= largest_stack(code.files, code.run.name) <= STACK[method]
