"""The page on other libraries: its programs print what it shows."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.documented_pages import beside_examples, wrong_blocks
from tests.golden import ROOT


@pytest.mark.thorough
def test_programs_print_what_the_page_shows(tmp_path: Path) -> None:
    pytest.importorskip("casadi")
    jax = pytest.importorskip("jax")
    precise = jax.config.jax_enable_x64
    try:
        with beside_examples(tmp_path):
            assert wrong_blocks((ROOT / "docs" / "backends.md").read_text(encoding="utf-8")) == {}
    finally:
        jax.config.update("jax_enable_x64", precise)
