"""Robots of other formats against the library that reads them: `python -m tests.benchmarks.robots urdf`, or `mjcf`.

URDF needs `pip install example-robot-data pybullet pin`, MJCF `mujoco gymnasium-robotics pybullet`; files are found
where these packages keep them, or in a folder. Errors at random states are those of inverse dynamics, relative to the
largest torque, of the frames of all links and joints by their names, of their Jacobians, and of direct dynamics from
Pinocchio's torques, relative to the largest acceleration, which the condition of the inertia matrix magnifies.
"""

from __future__ import annotations

import argparse
import json
import math
import time
from collections.abc import Iterator
from importlib.metadata import files
from pathlib import Path
from typing import Any

from symoro_elastic.formats.format import Conversion
from symoro_elastic.formats.reading import read
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.generation.pipeline import zero_pivots
from symoro_elastic.machine.scene import Scene
from symoro_elastic.models.packaging import reserved_words
from tests.benchmarks import robots_mjcf
from tests.benchmarks.match import require_pinocchio
from tests.benchmarks.tables import print_table, progress, save_json

PACKAGES = ("example-robot-data", "pybullet")
SNAP = Conversion(1e-9)
BOUND = 1e-12
Figures = dict[str, Any]


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m tests.benchmarks.robots", description=__doc__)
    parser.add_argument("format", choices=("urdf", "mjcf"))
    parser.add_argument("--folder", type=Path, help="a folder with files, in place of the packages")
    parser.add_argument("--only", default="", help="files whose path holds this text")
    parser.add_argument("--json", type=Path, help="save the figures")
    arguments = parser.parse_args()
    if arguments.format == "mjcf":
        robots_mjcf.compare(arguments.only, arguments.json, arguments.folder)
        return
    require_pinocchio()
    paths = [path for path in robots(arguments.folder) if arguments.only in str(path)]
    rows: list[Figures] = []
    for path in progress(paths, "compare with Pinocchio"):
        rows.append(figures(path))
        if arguments.json:
            save_json(arguments.json, rows)
    measured = [row for row in rows if "joints" in row]
    print_table(
        "URDF: errors against Pinocchio, and products and sums of the inverse model",
        [
            *("robot", "joints", "follow", "torques", "frames", "Jacobians", "accelerations", "operations"),
            *("snapped: torques", "frames", "operations"),
        ],
        [[str(row["robot"]), *map(_text, row["shown"])] for row in measured],
    )
    for row in rows:
        if "joints" not in row:
            print(f"{row['robot']}: {row['why']}")
    above = [row["robot"] for row in measured if max(row["exact"]) > BOUND]
    sizes = [row["joints"] for row in measured]
    print(f"{len(measured)} robots, {min(sizes)} to {max(sizes)} joints; above {BOUND:g}: {', '.join(above) or 'none'}")


def robots(folder: Path | None = None) -> Iterator[Path]:
    """Every URDF of the packages, or of a folder, with at least two joints that move, each text once."""
    seen: set[str] = set()
    for path in sorted(folder.rglob("*.urdf")) if folder else _of_packages():
        text = path.read_text(encoding="utf-8", errors="replace")
        if text not in seen and _moving(text) >= 2:
            seen.add(text)
            yield path


def _of_packages() -> Iterator[Path]:
    for package in PACKAGES:
        for file in sorted(files(package) or (), key=str):
            if file.suffix == ".urdf" and "random_urdfs" not in file.parts:
                yield Path(str(file.locate()))


def _moving(text: str) -> int:
    return sum(text.count(f'type="{kind}"') for kind in ("revolute", "continuous", "prismatic"))


def figures(path: Path) -> Figures:
    """Joints, errors and operations of one robot, exact and snapped; or why there are none."""
    from tests.references.compared_robots import ComparedRobot

    text, words = path.read_text(encoding="utf-8", errors="replace"), reserved_words()
    try:
        exact, snapped = read(path, words), read(path, words, SNAP)
    except InputError as error:
        return {"robot": path.name, "why": error.what}
    begin = time.perf_counter()
    try:
        both = [ComparedRobot(text, machine) for machine in (exact, snapped)]
        if set(both[0].own) != set(both[0].robot.own):
            return {"robot": path.name, "why": "Pinocchio reads other joints"}
        errors = [one.errors() for one in both]
        is_regular = not zero_pivots(exact, Scene(models=("direct_dynamics",)))
        accelerations = both[0].acceleration_error() if is_regular else math.nan
    except (ValueError, InputError) as error:
        return {"robot": path.name, "why": str(error).splitlines()[0][:120]}
    operations = [(one.operations.products, one.operations.add) for one in both]
    follow = len(both[0].tree.moving) - len(both[0].own)
    exact_errors, snapped_errors = ((e.torques, e.frames, e.jacobians) for e in errors)
    figures = (*exact_errors, accelerations, operations[0], *snapped_errors[:2], operations[1])
    return {
        "robot": path.name,
        "joints": len(exact.articulated),
        "exact": exact_errors,
        "snapped": snapped_errors,
        "accelerations": accelerations,
        "operations": operations,
        "seats": sum(joint.name.endswith("_seat") for joint in exact.joints),
        "remarks": exact.origin.remarks,
        "shown": [len(exact.independent), follow, *figures],
        "seconds": time.perf_counter() - begin,
    }


def _text(figure: Any) -> str:
    if isinstance(figure, tuple):
        return f"{figure[0]}x {figure[1]}+"
    return f"{figure:.1e}" if isinstance(figure, float) else json.dumps(figure)


if __name__ == "__main__":
    main()
