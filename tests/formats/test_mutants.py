"""Mutants of machine files; `python -m tests.fuzz --count 20000` tries more of them."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import pytest

from tests.fuzz import mutant, outcome


@pytest.mark.thorough
def test_mutants_raise_the_readers_own_error_only(tmp_path: Path) -> None:
    found = Counter((outcome(mutant(seed), tmp_path), mutant(seed).suffix) for seed in range(600))
    assert min(found.values()) > 10 and len(found) == 4
