"""Where each equation is: number -> function -> names in generated code.

Those of the paper: the source says it at the line, `# (29)`; docs/equations.md is made of these lines. Those of closed
chains are written out in docs/loop_equations.md; functions cite them, `(L10)`, in docstrings or at lines, and the table
that ends the page is made of these citations. `python -m tests.architecture.equation_index --write` writes both, and
says which numbers have no row.
"""

from __future__ import annotations

import ast
import re
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from types import MappingProxyType

from symoro_elastic.quantities import INTERMEDIATES
from symoro_elastic.quantities.quantity import COMPONENTS, Intermediate

ROOT = Path(__file__).parents[2]
HERE = Path(__file__).relative_to(ROOT)
PAGE = ROOT / "docs" / "equations.md"
LOOPS_PAGE = ROOT / "docs" / "loop_equations.md"
PACKAGE = ROOT / "symoro_elastic"
SOURCES = sorted((PACKAGE / "mechanics").rglob("*.py"))
LOOP_SOURCES = [*SOURCES, *sorted((PACKAGE / "models").rglob("*.py"))]
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

OF_LOOPS = {
    1: "positions of the joints, S and S_x",
    2: "rates and accelerations of the joints",
    3: "forces on the independent variables",
    4: "gam of joints whose cells hold formulas",
    5: "joint forces of an elastic transmission",
    6: "accelerations of its variables",
    7: "balanced rotors without their angle",
    8: "K of a joint behind a gear",
    9: "a loop is closed",
    10: "rates of dependent variables",
    11: "accelerations of dependent variables",
    12: "triangle of two turns",
    13: "rates of its angles",
    14: "accelerations of its angles",
    15: "triangle with an independent slide",
    16: "triangle of a turn and a slide",
    17: "slide between two turns",
    18: "error of a loop, step of Newton's method",
    20: "inverse model",
    21: "inertia matrix and bias forces over u",
    22: "B, the acceleration of a body of a cluster",
    23: "p and J^c of a body with all that it carries in the cluster",
    24: "A and Phi of the joints of a cluster",
    25: "H, U, eta and rho of its variables",
    26: "K and alpha of a cluster",
    27: "J* and beta* of its antecedent",
    28: "accelerations in a cluster",
    29: "forces on variables of known acceleration",
    30: "motors on dependent joints",
    31: "more motors than freedoms",
    32: "forces of constraints",
    33: "wrenches across cut joints",
    38: "M and D of small motions",
    40: "K of small motions",
    41: "second derivatives through a loop",
    42: "total derivatives where q_dep is an argument",
    43: "force of an elastic cell",
    44: "moment of an elastic cell",
    45: "wrenches on the bodies that it connects",
    46: "acceleration of the carried body",
    47: "acceleration of a carried body of constant inertia",
    48: "accelerations of the turns of a cell",
    49: "accelerations of the slides of a cell",
    50: "moments of the modes of a body at its deflections",
    51: "the deformed body as a rigid one",
    52: "force by the rates of modes",
    53: "moment by the rates of modes",
    54: "force on a mode by velocities",
    55: "equation of a mode",
}
BY_RATES = "what (L10) and (L11) come to for a triangle: these are solved"
NOT_CITED = {
    8: "what (L25) and (L26) come to for one joint and its rotor: these are carried out",
    **dict.fromkeys((13, 14, 15), BY_RATES),
    41: "what differentiating (L10) gives: expressions are differentiated",
}
"""Equations of loops that no function cites, with the reason."""
CITED = re.compile(r"\(L(\d+)\)(?:(?:-| to )\(L(\d+)\))?")
AT_END = re.compile(r"\(L(\d+)\)$", re.MULTILINE)
INDEX = "## Where each equation is\n"
CITING = ("symoro_elastic", "templates", "docs", "examples", "tests")
TEXTS = {".py", ".j2", ".md", ".toml"}


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
    """The places of each equation of the paper, each once, in the order of the files."""
    return _by_equation(marked for path in SOURCES for marked in markers(path))


def _by_equation(pairs: Iterable[tuple[int, Place]]) -> dict[int, list[Place]]:
    places: dict[int, list[Place]] = {}
    for equation, place in pairs:
        if place not in places.setdefault(equation, []):
            places[equation].append(place)
    return places


def without_row() -> list[str]:
    """A sentence for each number of the paper that a line has and this file has not, or the other way round."""
    sentences = [
        f"{place.file}, {place.function}: ({equation}) has no row: add it to WHAT in {HERE}"
        for equation, places in sorted(index().items())
        for place in places
        if equation not in WHAT
    ]
    return sentences + [
        f"[{equation}] {what}: no line of mechanics/ ends with `# ({equation})`, and NOT_WRITTEN gives no reason"
        for equation, what in WHAT.items()
        if equation not in index()
    ]


@cache
def loop_index() -> dict[int, list[Place]]:
    """The functions of `mechanics` and `models` that cite each equation of loops."""
    return _by_equation(
        (equation, place) for path in LOOP_SOURCES for equation, place in loop_citations(path) if place.function
    )


def loop_citations(path: Path) -> Iterator[tuple[int, Place]]:
    """(equation, place) of each citation of an equation of loops in a file; a range cites all that the page has."""
    text = path.read_text(encoding="utf-8")
    if not CITED.search(text):
        return
    functions = dict(_functions(ast.parse(text))) if path.suffix == ".py" else {}
    for number, line in enumerate(text.splitlines(), start=1):
        place = Place(str(path.relative_to(ROOT)), functions.get(number, ""))
        yield from ((equation, place) for cited in CITED.finditer(line) for equation in _numbers(cited))


def _numbers(cited: re.Match[str]) -> list[int]:
    first, last = int(cited[1]), int(cited[2] or cited[1])
    return [k for k in range(first, last + 1) if k in (first, last) or k in OF_LOOPS]


@cache
def written_out() -> frozenset[int]:
    """Numbers of the equations that stand in docs/loop_equations.md, above its table."""
    above = LOOPS_PAGE.read_text(encoding="utf-8").split(INDEX)[0]
    return frozenset(map(int, AT_END.findall("".join(above.split("```")[1::2]))))


def loops_without_row() -> list[str]:
    """A sentence for each equation of loops that is cited and not written out, or written out without a row."""
    paths = (path for name in CITING for path in sorted((ROOT / name).rglob("*")) if path.suffix in TEXTS)
    sentences = [
        f"{place.file}: cites (L{equation}), which docs/loop_equations.md does not have: write it out there"
        for path in paths
        for equation, place in loop_citations(path)
        if equation not in written_out()
    ]
    sentences += [
        f"docs/loop_equations.md: (L{equation}) has no row: say what it is in OF_LOOPS in {HERE}"
        for equation in sorted(written_out() - OF_LOOPS.keys())
    ]
    return sentences + [
        f"(L{equation}) {what}: no function cites it, and NOT_CITED gives no reason"
        for equation, what in OF_LOOPS.items()
        if equation not in loop_index() and equation not in NOT_CITED
    ]


def generated_names(equation: int) -> list[str]:
    """Names that the quantities of an equation of the paper have in generated code, for joint 5."""
    rows = (row for row in INTERMEDIATES if equation in row.equations)
    return list(dict.fromkeys(map(_example, rows)))


def generated_names_of_loops(equation: int) -> list[str]:
    """Names that the quantities of an equation of loops have in generated code, for joint 5."""
    rows = (row for row in INTERMEDIATES if any(equation in _numbers(cited) for cited in CITED.finditer(row.meaning)))
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
        "page is made from them (`python -m tests.architecture.equation_index --write`). Names in generated code are",
        "given for joint 5.",
        "",
        *_table(WHAT, index(), generated_names, "[{}]"),
        "",
        "Without a line of their own:",
        "",
        *_reasons(NOT_WRITTEN, "[{}]"),
    ]
    return "\n".join(lines) + "\n"


def loops_page() -> str:
    """docs/loop_equations.md: what stands there, and the table of functions made anew."""
    above = LOOPS_PAGE.read_text(encoding="utf-8").split(INDEX)[0]
    lines = [
        INDEX,
        "Functions of `symoro_elastic/mechanics/` and `models/` that cite an equation; the table is made from them",
        "(`python -m tests.architecture.equation_index --write`). Names in generated code are given for joint 5.",
        "",
        *_table(OF_LOOPS, loop_index(), generated_names_of_loops, "(L{})", NOT_CITED),
        "",
        "Not computed as they stand:",
        "",
        *_reasons(NOT_CITED, "(L{})"),
    ]
    return above + "\n".join(lines) + "\n"


def _table(
    what: Mapping[int, str],
    places: Mapping[int, list[Place]],
    names_of: Callable[[int], list[str]],
    form: str,
    left_out: Mapping[int, str] = MappingProxyType({}),
) -> Iterator[str]:
    yield "| equation | what | function | generated names |"
    yield "|---|---|---|---|"
    for equation in sorted(what.keys() - left_out.keys()):
        where = "<br>".join(f"`{place.function}` ({_link(place)})" for place in places.get(equation, []))
        names = ", ".join(f"`{name}`" for name in names_of(equation))
        yield f"| {form.format(equation)} | {what[equation]} | {where} | {names} |"


def _reasons(reasons: Mapping[int, str], form: str) -> Iterator[str]:
    for reason in dict.fromkeys(reasons.values()):
        yield f"- {_ranges([k for k, other in reasons.items() if other == reason], form)}: {reason}"


def _ranges(numbers: list[int], form: str) -> str:
    """`[16], [19]-[27]`."""
    runs: list[list[int]] = []
    for k in numbers:
        if runs and runs[-1][-1] == k - 1:
            runs[-1].append(k)
        else:
            runs.append([k])
    return ", ".join("-".join(map(form.format, dict.fromkeys((run[0], run[-1])))) for run in runs)


def _link(place: Place) -> str:
    return f"[{place.file.removeprefix('symoro_elastic/').removeprefix('mechanics/')}](../{place.file})"


PAGES = {PAGE: page, LOOPS_PAGE: loops_page}


def main() -> int:
    """Write the pages, or say which are out of date, and which numbers have no row."""
    sentences = [*without_row(), *loops_without_row()]
    for path, made in PAGES.items():
        if "--write" in sys.argv[1:]:
            path.write_text(made(), encoding="utf-8")
        elif path.read_text(encoding="utf-8") != made():
            sentences.append(
                f"{path.relative_to(ROOT)} is out of date: python -m tests.architecture.equation_index --write"
            )
    print(*sentences, sep="\n", end="\n" if sentences else "")
    return int(bool(sentences))


if __name__ == "__main__":
    sys.exit(main())
