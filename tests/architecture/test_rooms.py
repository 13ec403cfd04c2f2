"""The rooms of the package: on which floor each stands, and that imports run downwards only.

Every import counts, those inside functions and those for type checkers too.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from functools import cache
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

ROOT = Path(__file__).parents[2]
PACKAGE = ROOT / "symoro_elastic"

FLOORS = (
    ("foundation", "quantities"),
    ("symbolic", "mechanics", "machine"),
    ("codegen", "formats"),
    ("models",),
    ("numerics",),
    ("generation",),
    ("analysis",),
    ("measured",),
    ("pages",),
    ("api",),
    ("__init__",),
    ("cli",),
    ("__main__",),
)
"""The rooms from the ground up: a room imports rooms of the floors below."""
APART = {("codegen", "machine"), ("codegen", "mechanics"), ("formats", "symbolic"), ("formats", "mechanics")}
"""Pairs that never meet, although one stands below: programs know no machine, files know no equations."""
MOST_ARROWS = 75
"""Between rooms; the names of the package itself, for users and type checkers, are of several."""

FLOOR = {room: floor for floor, rooms in enumerate(FLOORS) for room in rooms}


def module_of(path: Path) -> str:
    return ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")


FILES = {module_of(path): path for path in sorted(PACKAGE.rglob("*.py"))}


def imports(path: Path) -> Iterator[str]:
    """Modules of the package that a file imports, anywhere in it."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names if alias.name in FILES)
        elif isinstance(node, ast.ImportFrom):
            for alias in node.names:
                submodule = f"{node.module}.{alias.name}"
                yield from (m for m in (submodule if submodule in FILES else str(node.module),) if m in FILES)


@cache
def imported() -> dict[str, set[str]]:
    """Modules that each module imports."""
    return {module: {*imports(path)} - {module} for module, path in FILES.items()}


def room_of(module: str) -> str:
    return module.split(".")[1] if "." in module else "__init__"


@cache
def arrows() -> dict[tuple[str, str], str]:
    """An import for each pair of rooms of which one imports the other."""
    return {
        (room_of(module), room_of(other)): f"{module} imports {other}"
        for module, others in imported().items()
        for other in others
        if room_of(module) != room_of(other)
    }


def test_every_room_stands_on_a_floor() -> None:
    assert {room_of(module) for module in FILES} == set(FLOOR)


def test_imports_run_downwards() -> None:
    wrong = [why for (room, other), why in arrows().items() if FLOOR[other] >= FLOOR[room] or (room, other) in APART]
    assert wrong == []


def test_there_are_few_arrows() -> None:
    assert len([room for room, _ in arrows() if room != "__init__"]) <= MOST_ARROWS


def test_no_files_import_each_other_in_a_circle() -> None:
    try:
        TopologicalSorter(imported()).prepare()
    except CycleError as error:
        raise AssertionError(" -> ".join(error.args[1])) from None


def test_the_map_names_every_folder_and_no_other() -> None:
    """The map of CONTRIBUTING.md: a line for each room, and after it the folders in that room."""
    drawn = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8").split("```")[1]
    named: dict[str, set[str]] = {}
    for line in drawn.strip().splitlines():
        room = re.match(r"(?:  \| )?(\w+) ", line)
        of_room = named.setdefault(room[1], set()) if room else named[next(reversed(named))]
        of_room |= set(re.findall(r"(\w+)/", line))
    rooms = {path.parent.name: set[str]() for path in PACKAGE.glob("*/__init__.py")}
    for path in PACKAGE.glob("*/*/__init__.py"):
        rooms[path.parts[-3]].add(path.parts[-2])
    assert named == rooms
