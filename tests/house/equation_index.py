"""Where each equation of the paper is written: number -> function -> names in generated code.

The source says it at the line, `# (29)`; `python -m tests.house.equation_index --write` makes docs/equations.md of it.
"""

from __future__ import annotations

import ast
import re
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from symoro_elastic.quantities import INTERMEDIATES
from symoro_elastic.quantities.quantity import COMPONENTS, Intermediate

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "equations.md"
SOURCES = sorted((ROOT / "symoro_elastic" / "mechanics").rglob("*.py"))
MARKER = re.compile(r"#\s((?:\(\d+\)(?:, )?)+)")
LAST = 61

WHAT = {
    1: "placement of frame j in the frame of its antecedent",
    2: "placement of frame j in frame 0",
    3: "velocity of frame j",
    4: "spatial axis a of joint j",
    5: "transform of twists; its transpose is that of wrenches",
    6: "acceleration of frame j",
    7: "gamma, the part of the acceleration that depends on velocities only",
    8: "Lagrange form: inertia matrix A and forces H",
    9: "torque of a spring (and damper)",
    10: "direct model through the inverse of A",
    11: "elastic accelerations found where those of motors are given",
    12: "Newton-Euler equation of a body",
    13: "spatial inertia JJ of a body",
    14: "beta, the wrench that depends on velocities only",
    15: "equilibrium of body j with the bodies that it carries",
    17: "torque of a motor with a rotor",
    18: "torque of an elastic joint",
    28: "H, the inertia that joint j moves",
    29: "K, the inertia that the antecedent feels",
    30: "alpha, the wrench that the antecedent feels when it does not accelerate",
    31: "beta* of the antecedent",
    32: "J* of the antecedent",
    33: "acceleration of the antecedent, in frame j",
    34: "acceleration of joint j",
    35: "wrench f of the antecedent on body j",
    36: "acceleration of frame j",
    50: "H of an elastic joint",
    51: "K of an elastic joint",
    52: "alpha of an elastic joint",
    53: "K of a joint of given acceleration",
    54: "alpha of a joint of given acceleration",
    55: "beta* of the antecedent",
    56: "J* of the antecedent",
    57: "acceleration of the antecedent, in frame j",
    58: "wrench f of the antecedent on body j",
    59: "acceleration of an elastic joint",
    60: "acceleration of frame j",
    61: "torque of a motor",
}
DIRECT = "steps of the derivation of [28]-[36] for the last two bodies"
INVERSE = "steps of the derivation of [50]-[61] for the last two bodies"
NOT_WRITTEN = dict.fromkeys((16, *range(19, 28)), DIRECT) | dict.fromkeys(range(37, 50), INVERSE)
"""Equations that no line carries out, with the reason."""


@dataclass(frozen=True)
class Place:
    """A line that carries out an equation: file and the function around it."""

    file: str
    function: str


def markers(path: Path) -> Iterator[tuple[int, Place]]:
    """(equation, place) of each marker in a file."""
    text = path.read_text(encoding="utf-8")
    functions = dict(_functions(ast.parse(text)))
    for number, line in enumerate(text.splitlines(), start=1):
        for found in MARKER.finditer(line):
            name = functions.get(number, "")
            place = Place(str(path.relative_to(ROOT)), name)
            yield from ((int(equation), place) for equation in re.findall(r"\d+", found[1]))


def _functions(tree: ast.Module) -> Iterator[tuple[int, str]]:
    """(line, qualified name of the innermost function or class around it)."""

    def walk(node: ast.AST, names: tuple[str, ...]) -> Iterator[tuple[int, str]]:
        for child in ast.iter_child_nodes(node):
            if isinstance(child, ast.FunctionDef | ast.ClassDef):
                inner = (*names, child.name)
                yield from ((line, ".".join(inner)) for line in range(child.lineno, (child.end_lineno or 0) + 1))
                yield from walk(child, inner)

    yield from walk(tree, ())


@cache
def index() -> dict[int, list[Place]]:
    """The places of each equation, each once, in the order of the files."""
    places: dict[int, list[Place]] = {}
    for path in SOURCES:
        for equation, place in markers(path):
            if place not in places.setdefault(equation, []):
                places[equation].append(place)
    return places


def generated_names(equation: int) -> list[str]:
    """Names that the quantities of an equation have in generated code, for joint 5."""
    rows = (row for row in INTERMEDIATES if equation in row.equations)
    return list(dict.fromkeys(map(_example, rows)))


def _example(row: Intermediate) -> str:
    pattern, shown = COMPONENTS[row.component]
    suffix = re.sub(r"\(\?P<c>.*\)", shown, pattern)
    return f"{row.name}5" + re.sub(r"^\(\?<!.*?\)", "", suffix)


def page() -> str:
    """docs/equations.md."""
    lines = [
        "# Where each equation is",
        "",
        "Numbers are those of W. Khalil and M. Gautier, *Modeling of high speed machines using robotics formulation*.",
        "Each line of `symoro_elastic/mechanics/` that carries out an equation ends with its number, `# (29)`: this",
        "page is made from them (`python -m tests.house.equation_index --write`). Names in generated code are given",
        "for joint 5.",
        "",
        "| equation | what | function | generated names |",
        "|---|---|---|---|",
    ]
    places = index()
    for equation in range(1, LAST + 1):
        if equation in NOT_WRITTEN:
            continue
        where = "<br>".join(f"`{place.function}` ({_link(place)})" for place in places[equation])
        names = ", ".join(f"`{name}`" for name in generated_names(equation))
        lines.append(f"| [{equation}] | {WHAT[equation]} | {where} | {names} |")
    lines += ["", "Without a line of their own:", ""]
    for reason in dict.fromkeys(NOT_WRITTEN.values()):
        numbers = [k for k, other in NOT_WRITTEN.items() if other == reason]
        lines.append(f"- {_ranges(numbers)}: {reason}")
    return "\n".join(lines) + "\n"


def _ranges(numbers: list[int]) -> str:
    """`[16], [19]-[27]`."""
    runs: list[list[int]] = []
    for k in numbers:
        if runs and runs[-1][-1] == k - 1:
            runs[-1].append(k)
        else:
            runs.append([k])
    return ", ".join(f"[{run[0]}]" + (f"-[{run[-1]}]" if len(run) > 1 else "") for run in runs)


def _link(place: Place) -> str:
    short = place.file.removeprefix("symoro_elastic/mechanics/")
    return f"[{short}](../{place.file})"


def main() -> int:
    """Write the page, or say whether it is up to date."""
    if "--write" in sys.argv[1:]:
        PAGE.parent.mkdir(exist_ok=True)
        PAGE.write_text(page(), encoding="utf-8")
        return 0
    return int(not PAGE.exists() or PAGE.read_text(encoding="utf-8") != page())


if __name__ == "__main__":
    sys.exit(main())
