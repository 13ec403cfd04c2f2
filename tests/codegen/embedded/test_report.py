"""The report of generated C against what runs and what the compiler knows; compilers that are missing."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from functools import cache
from pathlib import Path

import pytest

from symoro_elastic import generate
from symoro_elastic.codegen.embedded.report import CodeReport, code_report
from symoro_elastic.codegen.embedded.tool_chain import compile_file, tool_chain
from symoro_elastic.codegen.package import Package
from symoro_elastic.codegen.precision import PRECISIONS
from symoro_elastic.codegen.targets.c import render_c
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.results import Table
from symoro_elastic.generation import pipeline
from symoro_elastic.machine.scene import Scene
from symoro_elastic.models.packaging import trace_models
from tests.benchmarks.steps import largest_stack
from tests.command_line import ended, run
from tests.references.random_machines import planar_2r

CORTEX_M7 = "-mcpu=cortex-m7 -mfpu=fpv5-sp-d16 -mfloat-abi=hard"
EXAMPLE = Path(__file__).parents[3] / "examples" / "planar_2r.toml"
needs_gcc = pytest.mark.skipif(shutil.which("gcc") is None, reason="needs gcc")
needs_arm = pytest.mark.skipif(shutil.which("arm-none-eabi-gcc") is None, reason="needs arm-none-eabi-gcc")
needs_valgrind = pytest.mark.skipif(shutil.which("valgrind") is None, reason="needs valgrind")


@cache
def package() -> Package:
    return trace_models(planar_2r(elastic=[2]), Scene(models=("direct_dynamics",), steps=("w2",))).package


@cache
def report(compiler: str, flags: str = "", precision: str = "double") -> CodeReport:
    in_precision = PRECISIONS[precision]
    return code_report(package(), render_c(package(), in_precision), in_precision, tool_chain(compiler, flags))


WITHOUT_EFFECT = {"-Wall", "-Wextra", "-Wpedantic", "-Werror", "-g1", "-fstack-usage", "-c", "-o"}
"""On the code: warnings, data for debuggers, names of files."""


@needs_gcc
def test_the_command_shown_is_all_that_the_code_depends_on(monkeypatch: pytest.MonkeyPatch) -> None:
    commands, run = [], subprocess.run
    monkeypatch.setattr(subprocess, "run", lambda command, **how: (commands.append(command), run(command, **how))[1])
    tools = tool_chain("gcc", "-ffast-math -std=gnu11")
    compile_file({"some.c": "int f(void) { return 0; }\n"}, "some.c", tools)
    assert tools.command == "gcc -std=c99 -O2 -ffast-math -std=gnu11"
    others = [word for word in commands[0] if word not in WITHOUT_EFFECT and not word.startswith("some.")]
    assert " ".join(others) == tools.command
    assert [word for word in commands[0] if word.startswith("-g")] == ["-g1"], "all of -g takes gcc a third longer"


@needs_gcc
def test_the_wait_for_the_compiler_of_a_report_is_announced(tmp_path: Path) -> None:
    """A cross compiler takes a minute for 30 joints: a line says what runs, before it runs."""
    announced: list[str] = []
    tools = tool_chain("gcc", "")
    options = pipeline.CodeOptions(tools=tools, announce=announced.append)
    pipeline.generate(planar_2r(), Scene(), ("c",), tmp_path, options)
    assert announced[-2:] == [f"compile: {tools.command}", "write"]


def costs(found: CodeReport) -> dict[str, tuple[int | None, int | None]]:
    """Instructions and stack by function."""
    return {one.name: (one.cost.instructions, one.cost.stack) for one in found.functions}


PROGRAM = """
#include "planar_2r.h"
int main(void)
{
    static double a[100], found[100];
    double q[2] = {0.3, 0.01}, qd[2] = {0.5, -0.2};
    for (int k = 0; k < 100; k++) a[k] = 0.3 + 0.01*k;
    planar_2r_direct_dynamics_prepare(planar_2r_defaults, found);
    planar_2r_direct_dynamics(q, qd, a, planar_2r_defaults, found);
    planar_2r_step_w2(a, 1e-6, planar_2r_defaults, q, qd);
    planar_2r_step_w2_servo(a, a, a, a, a, 1e-6, planar_2r_defaults, q, qd);
    return 0;
}
"""


@pytest.fixture(scope="module")
def program(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A program that calls functions once, compiled as the report is."""
    folder = tmp_path_factory.mktemp("program")
    for name, text in {**render_c(package()), "main.c": PROGRAM}.items():
        (folder / name).write_text(text, encoding="utf-8")
    command = ["gcc", "-std=c99", "-O2", "main.c", "planar_2r.c", "-o", "main", "-lm"]
    subprocess.run(command, cwd=folder, check=True)
    return folder / "main"


def executed(program: Path, function: str) -> int:
    """Instructions of the call of a function, by callgrind."""
    collected = ["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null", f"--toggle-collect={function}"]
    done = subprocess.run([*collected, str(program)], capture_output=True, text=True, check=True)
    return int(re.findall(r"Collected : (\d+)", done.stderr)[0])


@needs_gcc
@needs_valgrind
def test_a_straight_line_executes_as_many_instructions_as_are_reported(program: Path) -> None:
    name = "planar_2r_direct_dynamics_prepare"
    assert costs(report("gcc"))[name][0] == executed(program, name)


@pytest.mark.sampled(2)
@needs_gcc
@needs_valgrind
@pytest.mark.parametrize("function", ["direct_dynamics", "step_w2_servo"])
def test_no_call_executes_more_than_is_reported_nor_much_less(function: str, program: Path) -> None:
    name = f"planar_2r_{function}"
    most = costs(report("gcc"))[name][0]
    assert most is not None
    assert 0.7 * most < executed(program, name) <= most


@needs_gcc
def test_stack_is_what_the_compiler_says_along_its_own_graph_of_calls() -> None:
    name = "planar_2r_step_w2_servo"
    assert costs(report("gcc"))[name][1] == largest_stack(render_c(package()), name)


@needs_arm
def test_single_precision_on_a_processor_without_double_calls_no_function_for_doubles() -> None:
    found = report("arm-none-eabi-gcc", CORTEX_M7, "single")
    called = {name for one in found.functions for name in one.cost.calls or ()}
    assert called == {"sinf", "cosf"}
    assert found.format == "elf32-littlearm"


@needs_arm
def test_every_function_but_that_of_an_open_number_of_entries_is_bounded() -> None:
    found = costs(report("arm-none-eabi-gcc", CORTEX_M7, "single"))
    assert [name for name, (instructions, _) in found.items() if instructions is None] == ["planar_2r_single_advance"]
    assert None not in {stack for _, stack in found.values()}


@needs_arm
def test_without_a_floating_point_unit_its_operations_are_calls_of_the_library() -> None:
    one = report("arm-none-eabi-gcc", "-mcpu=cortex-m0plus", "single").functions[0]
    assert one.name == "planar_2r_direct_dynamics_f32_prepare"
    assert one.operations and one.cost.calls
    assert one.cost.calls["__aeabi_fmul"] == one.operations.mul


@needs_gcc
def test_the_command_line_prints_what_python_returns(tmp_path: Path) -> None:
    made = generate(EXAMPLE, out=tmp_path / "a", targets=["c"], report=True)
    printed = run("generate", EXAMPLE, "--target", "c", "--out", tmp_path / "b", "--report", "--json").output
    assert json.loads(printed)["reports"] == made.as_json()["reports"]
    assert [one.name for one in made.reports[0].functions] == made.reports[0].columns()["function"]
    table, size, *_ = made.parts()[-4:]
    assert isinstance(table, Table) and len(table.rows) == len(made.reports[0].functions)
    assert "bytes of code" in str(size)


BAD = {
    ("--report", "--compiler", "arm-none-gcc"): "--compiler: there is no program 'arm-none-gcc'",
    ("--compiler", "gcc"): "--compiler: belongs to the report: add --report",
    ("--compiler-flags", "-O3"): "--compiler-flags: belongs to the report",
    ("--report", "--compiler-flags", "'-O3"): '--compiler-flags: "\'-O3" has an unmatched quotation mark',
    ("--processor", "cortex-m7"): "--processor: belongs to the report",
    ("--report", "--processor", "cortex"): "--processor: unknown 'cortex'",
    ("--report", "--processor", "cortex-m7", "--compiler", "gcc"): "--processor: names a compiler and its options",
    ("--report", "--target", "numpy"): "--report: concerns the C code: add --target c",
    ("--report", "--compiler-flags", "-mcpu=nothing"): "symoro-elastic: C compiler: gcc: ",
}


@needs_gcc
@pytest.mark.parametrize(("options", "message"), BAD.items(), ids=[" ".join(options) for options in BAD])
def test_what_cannot_be_reported_is_refused_and_nothing_is_written(
    options: tuple[str, ...], message: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("CC", "gcc")
    found = ended("generate", EXAMPLE, "--out", tmp_path / "out", *options)
    assert found.code == 2
    assert message in found.err
    assert found.err.count("\n") == 1
    assert not (tmp_path / "out").exists()


def test_a_missing_compiler_is_named_with_its_package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(InputError, match="apt install gcc-arm-none-eabi"):
        generate(EXAMPLE, out=tmp_path / "out", report=True, compiler="arm-none-eabi-gcc")
    assert not (tmp_path / "out").exists()
