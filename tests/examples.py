"""The examples of the repository, as machines."""

from __future__ import annotations

from pathlib import Path

from symoro_elastic.formats import read_machine
from symoro_elastic.machine.described import DescribedMachine

EXAMPLES = Path(__file__).parents[1] / "examples"


def example(name: str) -> DescribedMachine:
    """The machine in a file of `examples/`, without its warnings."""
    return read_machine(EXAMPLES / name)[0]
