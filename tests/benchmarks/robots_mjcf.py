"""Robots in MJCF against MuJoCo: files of gymnasium-robotics, pybullet and MuJoCo, found where they keep them.

Errors are those of forces (`mj_inverse`), relative to the largest term of a state, of frames, relative to the size of
the robot, and of accelerations (`mj_forward`), which the condition of the inertia matrix magnifies.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from importlib.metadata import PackageNotFoundError, files
from pathlib import Path
from typing import Any

from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.described import DescribedMachine
from tests.benchmarks.tables import print_table, progress, save_json

PACKAGES = ("mujoco", "gymnasium-robotics", "pybullet")
BOUND = 1e-12
STATES = 10
COLUMNS = ("joints", "motors", "springs", "floats", "forces", "frames", "accelerations")
Figures = dict[str, Any]


def compare(only: str = "", json: Path | None = None, folder: Path | None = None) -> None:
    """Print the errors of all files whose path holds a text, and save them."""
    paths = [path for path in robots(folder) if only in str(path)]
    rows: list[Figures] = []
    for path in progress(paths, "compare with MuJoCo"):
        rows.append(figures(path))
        if json:
            save_json(json, rows)
    measured = [row for row in rows if "joints" in row]
    shown = [[row["robot"], *(_text(row[name]) for name in COLUMNS)] for row in measured]
    print_table("MJCF: errors against MuJoCo", ["robot", *COLUMNS], shown)
    for row in rows:
        if "joints" not in row:
            print(f"{row['robot']}: {row['why']}")
    above = [row["robot"] for row in measured if max(row["forces"], row["frames"]) > BOUND]
    print(f"{len(measured)} robots; forces or frames above {BOUND:g}: {', '.join(above) or 'none'}")


def robots(folder: Path | None = None) -> Iterator[Path]:
    """Every MJCF file of the packages, or of a folder, that stands by itself, each text once."""
    of_packages = (Path(str(file.locate())) for package in PACKAGES for file in sorted(_files(package), key=str))
    seen: set[str] = set()
    for path in sorted(folder.rglob("*.xml")) if folder else of_packages:
        text = path.read_text(encoding="utf-8", errors="replace") if path.suffix == ".xml" else ""
        if "<mujoco" in text and "<worldbody" in text and text not in seen:
            seen.add(text)
            yield path


def _files(package: str) -> list[Any]:
    try:
        return list(files(package) or ())
    except PackageNotFoundError:
        return []


def figures(path: Path) -> Figures:
    """Joints and errors of one robot; or why there are none."""
    from tests.references.mujoco_model import Compared

    name, begin = f"{path.parent.name}/{path.stem}", time.perf_counter()
    try:
        compared = Compared.of_file(path)
    except (InputError, ValueError) as error:
        why = error.what if isinstance(error, InputError) else f"MuJoCo refuses it: {error}"
        return {"robot": name, "why": " ".join(why.split())[:150]}
    if compared.has_balls:
        return {"robot": name, "why": "ball joints, which are three rows, are compared in the tests"}
    machine, errors = compared.machine, compared.errors(STATES)
    assert isinstance(machine, DescribedMachine)
    return {
        "robot": name,
        "joints": len(machine.independent),
        "motors": len(machine.motors),
        "springs": len(machine.elastic),
        "floats": machine.floating is not None,
        "forces": errors.forces,
        "frames": errors.frames,
        "accelerations": errors.accelerations,
        "remarks": machine.origin.remarks,
        "seconds": time.perf_counter() - begin,
    }


def _text(figure: Any) -> str:
    if isinstance(figure, bool):
        return "yes" if figure else ""
    return f"{figure:.1e}" if isinstance(figure, float) else str(figure)
