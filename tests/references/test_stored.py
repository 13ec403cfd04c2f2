"""Stored results are those of their machine, state and digits, and nothing else."""

from __future__ import annotations

from dataclasses import replace

import pytest
from mpmath import mpf

from tests.references import stored as module
from tests.references.lagrange import inertia_and_bias
from tests.references.random_machines import planar_2r, random_state
from tests.references.stored import stored

ARM = planar_2r()
Q, QD, _ = random_state(ARM, 0)


@pytest.mark.thorough
def test_a_stored_result_is_read_in_its_digits() -> None:
    inertia, bias = stored(inertia_and_bias, ARM, Q, QD)
    wanted_inertia, wanted_bias = inertia_and_bias(ARM, Q, QD)
    for found, wanted in zip([*inertia[0], *bias], [*wanted_inertia[0], *wanted_bias], strict=True):
        assert isinstance(found, mpf) and abs(found - wanted) < mpf(10) ** -45


@pytest.mark.parametrize("changed", ["machine", "state", "digits"])
def test_what_has_changed_is_an_error_that_says_what_to_run(changed: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "_mode", [])
    machine = replace(ARM, joints=ARM.joints[:1]) if changed == "machine" else ARM
    qd = [QD[0] + 1e-16 + abs(QD[0]) * 2**-50, QD[1]] if changed == "state" else QD
    with pytest.raises(LookupError, match=r"inertia_and_bias for planar_2r .*stored --regenerate"):
        stored(inertia_and_bias, machine, Q, qd, digits=60 if changed == "digits" else 50)


def test_a_result_that_is_not_what_is_stored_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where it is one of those that every run computes anew."""
    monkeypatch.setattr(module, "RECOMPUTED", 1)
    monkeypatch.setattr(module, "_mode", [])
    stored(inertia_and_bias, ARM, Q, QD)

    def inertia_and_bias_of_another(*state: object) -> object:
        inertia, bias = inertia_and_bias(*state)
        return inertia, [bias[0] + mpf(10) ** -30, bias[1]]

    inertia_and_bias_of_another.__name__ = "inertia_and_bias"
    with pytest.raises(AssertionError, match="is not what is stored"):
        stored(inertia_and_bias_of_another, ARM, Q, QD)
