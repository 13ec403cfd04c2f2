"""What every file keeps to: light start-up, no text of a user run, files written in one place, sizes."""

from __future__ import annotations

import ast
import statistics
import sys
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PACKAGE = ROOT / "symoro_elastic"
FILES = sorted(PACKAGE.rglob("*.py"))
LONGEST_FUNCTION, LONGEST_FILE, LONGEST_PAGE, MEDIAN_FUNCTION = 45, 600, 250, 6


@pytest.fixture(scope="module", autouse=True)
def _trees_are_forgotten() -> Iterator[None]:
    """They are a million objects, which every later collection of garbage would pass through."""
    yield
    for kept in (tree, nodes, calls):
        kept.cache_clear()


@cache
def tree(path: Path) -> ast.Module:
    return ast.parse(path.read_text(encoding="utf-8"), filename=str(path))


@cache
def nodes(path: Path) -> list[ast.AST]:
    return [*ast.walk(tree(path))]


@cache
def calls(path: Path) -> list[ast.Call]:
    return [node for node in nodes(path) if isinstance(node, ast.Call)]


def imports(path: Path) -> Iterator[tuple[str, int]]:
    """(module, line) of every import, inside functions too; names imported from a package count as modules of it."""
    for node in nodes(path):
        if isinstance(node, ast.Import):
            yield from ((alias.name, node.lineno) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}:{node.lineno}: a relative import"
            yield str(node.module), node.lineno
            yield from ((f"{node.module}.{alias.name}", node.lineno) for alias in node.names)


HEAVY = {"numpy", "sympy", "mpmath", "jinja2", "rich", "latex2mathml"}


def test_what_help_needs_is_light() -> None:
    """The command line imports heavy libraries inside its commands only."""
    names = ("declaration", "kinds", "options", "quantities", "rows", "measuring_options")
    options = tuple(f"api/{name}.py" for name in names)
    ground = tuple(f"foundation/{name}.py" for name in ("errors", "file_forms", "progress", "input_files", "version"))
    light = ("__main__.py", "__init__.py", *ground, "machine/format_names.py", *options)
    for path in (*(PACKAGE / name for name in light), *sorted((PACKAGE / "cli").glob("*.py"))):
        outermost = {
            alias.name.split(".")[0] for node in tree(path).body if isinstance(node, ast.Import) for alias in node.names
        } | {str(node.module) for node in tree(path).body if isinstance(node, ast.ImportFrom)}
        assert not {module.split(".")[0] for module in outermost} & HEAVY
        ours = {m for m in outermost if m.startswith("symoro_elastic") and not m.startswith("symoro_elastic.cli")}
        assert {m.removeprefix("symoro_elastic").replace(".", "/") + ".py" for m in ours} <= {
            ".py",
            *(f"/{name}" for name in light),
            "/api.py",
        }, path


def test_generated_code_needs_numpy_only() -> None:
    for path in sorted((ROOT / "generated").rglob("*.py")):
        found = {module.split(".")[0] for module, _ in imports_of_generated(path)}
        assert found <= {"numpy", "", *sys.stdlib_module_names}, path


def imports_of_generated(path: Path) -> Iterator[tuple[str, int]]:
    for node in nodes(path):
        if isinstance(node, ast.Import):
            yield from ((alias.name, node.lineno) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            yield str(node.module or ""), node.lineno


FORBIDDEN = {"eval", "exec", "compile", "__import__", "sympify", "parse_expr", "S"}
HARMLESS = {"re.compile", "spec.compile"}
"""Calls of the same names that run no text: patterns, and MuJoCo's models."""
FORBIDDEN_MODULES = {"pickle", "marshal", "shelve", "code", "codeop"}


def called(node: ast.Call) -> str:
    if isinstance(node.func, ast.Name):
        return node.func.id
    return node.func.attr if isinstance(node.func, ast.Attribute) else ""


def test_text_of_a_user_is_never_run() -> None:
    """No eval and its kin."""
    wrong = []
    for path in FILES:
        found = [(called(node), node) for node in calls(path)]
        run = [(name, node) for name, node in found if name in FORBIDDEN and ast.unparse(node.func) not in HARMLESS]
        wrong += [f"{path.relative_to(ROOT)}:{node.lineno}: {name}" for name, node in run]
        used = [(name, line) for name, line in imports(path) if name in FORBIDDEN_MODULES]
        wrong += [f"{path.relative_to(ROOT)}:{line}: {name}" for name, line in used]
    assert wrong == []


def test_data_know_no_printer_and_no_plot() -> None:
    """rich is of the command line, matplotlib of plots and pages; results are imported by views, not views by results.

    Views of a room are used by other views, by pages and by commands.
    """
    for path in FILES:
        name = path.relative_to(PACKAGE)
        room, shows = name.parts[0], path.stem in ("views", "plots")
        used = {module for module, _ in imports(path)}
        assert room == "cli" or not {module for module in used if module.split(".")[0] == "rich"}, name
        texts = {node.value for node in nodes(path) if isinstance(node, ast.Constant) and isinstance(node.value, str)}
        plotted = {x for x in texts | used if x.split(".")[0] == "matplotlib"}
        assert name == Path("foundation/pictures.py") or not plotted, name
        if not shows and room not in ("pages", "cli"):
            assert "symoro_elastic.foundation.pictures.new_figure" not in used, name
            assert not {module for module in used if {*module.split(".")} & {"views", "plots"}}, name


def started(node: ast.Call) -> bool:
    """Whether a call starts another program."""
    return isinstance(node.func, ast.Attribute) and ast.unparse(node.func.value) == "subprocess"


def badly_started(node: ast.Call) -> bool:
    """Whether a program is waited for without limit, or what it prints has to be UTF-8."""
    given = {keyword.arg: ast.unparse(keyword.value) for keyword in node.keywords}
    is_text = given.keys() & {"text", "universal_newlines", "encoding"}
    return (
        ast.unparse(node.func) != "subprocess.run"
        or "timeout" not in given
        or bool(is_text and given.get("errors") != "'replace'")
    )


def test_programs_may_print_in_any_encoding_and_are_not_waited_for_without_limit() -> None:
    found = [(path, node) for path in FILES for node in calls(path) if started(node)]
    assert len(found) > 1
    assert [f"{path}:{node.lineno}" for path, node in found if badly_started(node)] == []


@pytest.mark.parametrize(
    "text", ["run(x)", "run(x, text=True, timeout=1)", "run(x, encoding='utf-8', timeout=1)", "Popen(x)"]
)
def test_programs_that_are_badly_started_are_found(text: str) -> None:
    (call,) = (node for node in ast.walk(ast.parse(f"subprocess.{text}")) if isinstance(node, ast.Call))
    assert started(call) and badly_started(call)


WRITES = {"write_text", "write_bytes", "savefig", "savez", "savez_compressed", "savemat", "savetxt", "copyfile", "dump"}
# Modules that write to temporary folders, or to a stream in memory, beside the two that write the files of users.
MAY_WRITE = {
    "foundation/output_files.py",
    "foundation/replacing.py",
    "pages/equations/pdf.py",
    "codegen/compile.py",
    "numerics/verification/implementations.py",
}
TO_MEMORY = {
    "foundation/pictures.py",
    "analysis/time_series/writing.py",
    "analysis/vibration/export.py",
    "formats/modes_file.py",
}


def test_files_of_users_are_written_in_two_modules() -> None:
    wrong = []
    for path in FILES:
        name = str(path.relative_to(PACKAGE))
        for node in calls(path) if name not in MAY_WRITE else ():
            if called(node) in WRITES and isinstance(node.func, ast.Attribute):
                ours = ast.unparse(node.func) == "output_files.write_text"
                if not ours and not (name in TO_MEMORY and "stream" in ast.unparse(node)):
                    wrong.append(f"{path.relative_to(ROOT)}:{node.lineno}: {ast.unparse(node.func)}")
    assert wrong == []


def functions(path: Path) -> dict[str, int]:
    """Lines of each function of a file, without those of docstrings that list parameters."""
    found = (node for node in nodes(path) if isinstance(node, ast.FunctionDef))
    return {
        f"{node.name}, line {node.lineno}": (node.end_lineno or 0) - node.lineno + 1 - parameters_described(node)
        for node in found
    }


def parameters_described(function: ast.FunctionDef) -> int:
    """Lines of the docstring of a function that describes its parameters in sections, else 0."""
    text = ast.get_docstring(function, clean=False) or ""
    return text.count("\n") + 1 if "Parameters\n" in text else 0


def test_nothing_is_long() -> None:
    for path in FILES:
        lines = path.read_text(encoding="utf-8").count("\n")
        assert lines <= LONGEST_FILE, f"{path}: {lines} lines"
        assert {name: length for name, length in functions(path).items() if length > LONGEST_FUNCTION} == {}, path


@pytest.mark.thorough
def test_half_of_the_functions_are_short() -> None:
    assert statistics.median(length for path in FILES for length in functions(path).values()) <= MEDIAN_FUNCTION


@pytest.mark.thorough
def test_the_dynamics_are_a_page() -> None:
    text = (PACKAGE / "mechanics" / "dynamics.py").read_text(encoding="utf-8")
    assert text.count("\n") <= LONGEST_PAGE


@pytest.mark.thorough
def test_templates_hold_no_mathematics() -> None:
    """They are short, and none does arithmetic on what it prints; scripts of pages are as short."""
    for path in sorted((ROOT / "templates").rglob("*.js")):
        assert "vendor" in path.parts or path.read_text(encoding="utf-8").count("\n") <= 150, path
    for path in sorted((ROOT / "templates").rglob("*.j2")):
        text = path.read_text(encoding="utf-8")
        assert text.count("\n") <= 150, path
        inside = [part.split("}}")[0] for part in text.split("{{")[1:]]
        assert not [part for part in inside if any(sign in part for sign in (" + ", " * ", " / ", "**"))], path
