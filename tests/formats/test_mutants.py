"""Damaged files for every reader; `python -m tests.fuzz --count 20000` tries more of them."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from shutil import copy

import pytest

from symoro_elastic.foundation.errors import InputError
from tests.command_line import EXAMPLES
from tests.fuzz import READERS, REPEATED, available, mutant, outcome, sources


@pytest.mark.thorough
@pytest.mark.parametrize("reader", available())
def test_readers_take_the_files_that_are_damaged(reader: str, tmp_path: Path) -> None:
    copy(EXAMPLES / "bracket.npz", tmp_path)
    for content in READERS[reader].sources():
        path = tmp_path / f"arm{READERS[reader].suffix}"
        path.write_bytes(content)
        READERS[reader].read(path)


@pytest.mark.parametrize("count", [3, pytest.param(150, marks=pytest.mark.thorough)])
@pytest.mark.parametrize("reader", available())
def test_mutants_raise_the_readers_own_error_only(reader: str, count: int, tmp_path: Path) -> None:
    """Within a second of the processor."""
    found = {outcome(mutant(seed, reader), tmp_path) for seed in range(count)}
    assert found <= {"accepted", "refused"} and "refused" in found


PLACES = {
    "toml": ("0.35", '"K2"', "tip", "gravity"), "par": ("{", "NL", "sigma"), "dh": ("deg", "0.1", "revolute"),
    "log": ("deg", "q_elbow", "1.5"), "scene": ("duration", "models"), "tests": ("x_left.csv", "um/N", "10"),
    "sweep": ("lognormal:1e7:0.2", "100"), "urdf": ("8.5", "column"), "journal": ("1.5", "none"),
    "manifest": ("a.c", "00"), "responses": ("tool.ax", "12"),
}  # fmt: skip
"""What is replaced by a value that is long, in the first of the sources."""
MOST = 5.0
"""Time of the processor for one file, s: they take 0.1 s, and took minutes where their length mattered twice."""
VALUES = [
    *(unit * (90_000 // len(unit)) + (" mm" if k % 2 else "") for k, unit in enumerate(REPEATED)),
    *("1e999999999", "1e999999999 mm", "-1e-999999999 kg", "9" * 5000 + " mm", "9" * 90_000),
]


@contextmanager
def ended_after(seconds: float) -> Iterator[None]:
    """End the block after some time of the processor, which does not depend on what else the computer does."""

    def end(*_: object) -> None:
        raise TimeoutError(f"{seconds} s")

    before = signal.signal(signal.SIGVTALRM, end)
    signal.setitimer(signal.ITIMER_VIRTUAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0)
        signal.signal(signal.SIGVTALRM, before)


@pytest.mark.sampled(30)
@pytest.mark.parametrize(
    ("reader", "place"), [(reader, place) for reader, places in PLACES.items() for place in places], ids=str
)
def test_long_values_are_refused_within_a_second(reader: str, place: str, tmp_path: Path) -> None:
    """Digits, dots, brackets, quotes, blanks ..., of each of which some reader looked at all again and again."""
    text = next(text for text in sources(reader) if place in text)
    path = tmp_path / f"arm{READERS[reader].suffix}"
    for value in VALUES:
        path.write_bytes(text.replace(place, value, 1).encode())
        with ended_after(MOST), suppress(InputError):
            READERS[reader].read(path)
