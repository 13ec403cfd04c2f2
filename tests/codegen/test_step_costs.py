"""What real time asks of a step: the same work at every state, and stack that is known before."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import pytest

from tests.benchmarks import contest
from tests.benchmarks.instructions import available, per_call
from tests.benchmarks.machines import two_axis
from tests.benchmarks.steps import STATES, StepCode, can_measure_stack, largest_stack, step_code

STACK = {"w3": 4000, "rk4": 2500}
"""Bytes that a step of twelve joints may take: its stages, its factors, and the deepest model."""


@cache
def code_of(method: str) -> StepCode:
    return step_code(two_axis(), method)


@pytest.mark.skipif(not (available() and can_measure_stack()), reason="callgrind counts instructions: install valgrind")
def test_instructions_of_a_step_are_the_same_at_every_state(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(contest, "BUILD", tmp_path)
    first, second = (per_call(code_of("w3"), "gcc", x) for x in STATES)
    assert first == second > 1000


@pytest.mark.skipif(not can_measure_stack(), reason="gcc says what each function takes of the stack: install it")
@pytest.mark.parametrize("method", STACK)
def test_stack_of_a_step_is_bounded_and_small(method: str) -> None:
    """Its arrays are 14 vectors of the joints, or 11, at least."""
    code = code_of(method)
    vectors = {"w3": 14, "rk4": 11}[method]
    assert 8 * 12 * vectors <= largest_stack(code.files, code.run.name) <= STACK[method]
