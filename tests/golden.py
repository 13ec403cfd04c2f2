"""What generated/ holds: made from the examples, committed, compared byte by byte.

python -m tests.golden                what differs from what the examples generate now
python -m tests.golden --regenerate   accept it
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

from symoro_elastic.codegen.targets import DEFAULT_TARGETS
from symoro_elastic.formats import read_machine
from symoro_elastic.foundation.output_files import permission
from symoro_elastic.generation.pipeline import generate
from symoro_elastic.machine.scene import AUTO, Scene

ROOT = Path(__file__).resolve().parents[1]
GENERATED = ROOT / "generated"
FIVE = ("direct_dynamics", "inverse_dynamics", "inertia_matrix", "bias_forces", "geometric_model")


class Golden(NamedTuple):
    """An example, the folder under generated/ that its machine goes to, models (none: as it says), time steps."""

    example: str
    folder: str
    models: tuple[str, ...] = ()
    targets: tuple[str, ...] = DEFAULT_TARGETS
    steps: tuple[str, ...] = ()


# Directly under generated/ stands what `symoro-elastic generate examples/...` writes without an option.
GOLDEN = (
    Golden("two_axis.toml", "."),
    Golden("rx90.par", "."),
    Golden("puma560.par", "."),
    Golden("flex4.par", "."),
    Golden("planar_2r.toml", "."),
    Golden("ball_screw.toml", "."),
    Golden("sr400.par", "."),
    Golden("planar_2r.toml", "all_models", FIVE, ("numpy", "c-batch")),
    Golden("planar_2r.toml", "steps", FIVE[:2], steps=("w3",)),
    Golden("planar_2r.toml", "python", ("inertia_matrix",), ("python",)),
)


def make(golden: Golden, out: Path) -> list[Path]:
    """Write what an example generates to `out` in place of generated/; the files, relative to it."""
    machine, _ = read_machine(ROOT / "examples" / golden.example)
    scene = Scene(golden.models, steps=golden.steps) if golden.models else machine.asked.scene or Scene()
    scene = replace(scene, form=AUTO)
    with permission(force=True):
        written = generate(machine, scene, golden.targets, out / golden.folder).written
    return sorted(path.relative_to(out) for path in written)


def differences(golden: Golden, out: Path) -> list[str]:
    """A line for each committed file of an example that is missing or differs from the one made in `out`."""
    found = []
    for path in make(golden, out):
        committed = GENERATED / path
        if not committed.is_file():
            found.append(f"generated/{path} is missing")
        elif committed.read_bytes() != (out / path).read_bytes():
            found.append(f"generated/{path} differs")
    return found


def left_over(made: set[Path]) -> list[str]:
    """Files in generated/ that no example makes."""
    there = {path.relative_to(GENERATED) for path in GENERATED.rglob("*") if path.is_file()}
    return [
        f"generated/{path} is made by no example" for path in sorted(there - made) if "__pycache__" not in path.parts
    ]


def main() -> int:
    """Compare, or regenerate."""
    parser = argparse.ArgumentParser(prog="python -m tests.golden")
    parser.add_argument("--regenerate", action="store_true", help="write generated/ anew")
    if parser.parse_args().regenerate:
        print(f"{sum(len(make(golden, GENERATED)) for golden in GOLDEN)} files written to {GENERATED}")
        return 0
    with tempfile.TemporaryDirectory() as folder:
        lines = [line for golden in GOLDEN for line in differences(golden, Path(folder))]
    print("\n".join(lines) or "nothing differs")
    return bool(lines)


if __name__ == "__main__":
    sys.exit(main())
