"""The committed code in generated/: what the examples generate now, and right: imported, compiled, run."""

from __future__ import annotations

import random
import re
import shutil
import subprocess
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from symoro_elastic.codegen.integration.tableaus import W3, nodes_of
from symoro_elastic.formats import read_machine
from symoro_elastic.generation.pipeline import generate
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import Kind, Machine, Parameter
from symoro_elastic.machine.scene import Scene
from tests.generated_code import COMPILERS, RESULTS, STRICT, Array, call, compiled, imported
from tests.golden import FIVE, GENERATED, GOLDEN, ROOT, Golden, differences, left_over, make
from tests.references import multiprecision as reference
from tests.references.closed_chains import State
from tests.references.constraint_multipliers import Multipliers
from tests.references.random_machines import chain, random_machine, random_state

pytestmark = pytest.mark.sampled(6)

CONTRACT = 1e-12
NOT_COMMITTED = Golden("two_axis.toml", "all_models", FIVE)
FOLDERS = [pytest.param(golden, id=f"{golden.folder}/{golden.example}") for golden in GOLDEN]
BY_NUMPY = [folder for folder in FOLDERS if folder.id != "python/planar_2r.toml"]
"""Those that hold a package for numpy, too; that of compiled functions has tests of its own (`codegen/test_python`)."""
ALL_FOLDERS = [*BY_NUMPY, pytest.param(NOT_COMMITTED, id="not committed/two_axis.toml")]
SANITIZED = [
    folder
    for folder in ALL_FOLDERS
    if folder.id
    not in ("./two_axis.toml", "./planar_2r.toml", "./puma560.par", "./ball_screw.toml", "steps/planar_2r.toml")
]
"""Without folders whose functions stand in another one too, others like the RX90 and the SR400, and time steps."""
SANITIZE = ("-fsanitize=address,undefined", "-fno-sanitize-recover=all", "-g", "-O0")


# The same bytes


@pytest.mark.sampled(12)
@pytest.mark.parametrize("golden", FOLDERS)
def test_committed_files_are_what_the_examples_generate(
    golden: Golden, tmp_path: Path, request: pytest.FixtureRequest
) -> None:
    if request.config.getoption("--regenerate"):
        make(golden, GENERATED)
    assert differences(golden, tmp_path) == [], "accept with: python -m tests.golden --regenerate"


@pytest.mark.thorough
def test_every_committed_file_is_made_by_an_example(tmp_path: Path) -> None:
    made = {path for golden in GOLDEN for path in make(golden, tmp_path)}
    assert left_over(made) == []


def test_generated_text_holds_nothing_of_this_machine(tmp_path: Path) -> None:
    """No path, no date, no version; short lines end in \\n."""
    for golden in GOLDEN:
        for path in make(golden, tmp_path):
            text = (tmp_path / path).read_bytes().decode("ascii")
            assert str(ROOT) not in text and str(tmp_path) not in text and "\r" not in text
            assert not re.search(r"\b(19|20)\d\d-\d\d-\d\d\b|\b\d+\.\d+\.\d+\b|0x[0-9a-f]{6}", text), path
            assert text.endswith("\n") and not text.endswith("\n\n") and not re.search(r"[ \t]\n", text), path


# The right numbers


@cache
def valued(example: str) -> Machine:
    """The machine of an example; parameters without value get that of a physical machine."""
    machine, _ = read_machine(ROOT / "examples" / example)
    others = {"G3": "-9.81", "RL4": "0.45", "k2": "800", "k4": "350", "L2": "0.5"}
    values = {p.name: p.value for p in chain(len(machine.joints), seed=3).parameters}
    values |= {name: Formula.parse(text) for name, text in others.items()}
    parameters = [p if p.value else Parameter(p.name, values[p.name], p.unit) for p in machine.parameters]
    return replace(machine, parameters=tuple(parameters))


def folder_of(golden: Golden, tmp_path: Path) -> Path:
    """The committed folder of an example, or the one made of an example that is not committed."""
    if golden not in GOLDEN:
        return tmp_path / make(golden, tmp_path)[0].parent
    return GENERATED / golden.folder / read_machine(ROOT / "examples" / golden.example)[0].name


def values_of(machine: Machine) -> dict[str, float]:
    return {p.name: p.value.value() for p in machine.parameters if p.value}


def expected(machine: Machine, model: str, state: tuple[Any, ...]) -> list[Any]:
    """The reference in 50 digits or more, a list of results."""
    q, qd, drive = state
    if machine.is_coupled:
        return of_coupled(Multipliers(machine, State(q, qd, start(machine))), model, drive)
    arguments = {"direct_dynamics": (q, qd, drive), "inverse_dynamics": (q, qd, drive), "bias_forces": (q, qd)}
    found = getattr(reference, model)(machine, *arguments.get(model, (q,)))
    return list(found) if model == "inverse_dynamics" else [found]


def of_coupled(found: Multipliers, model: str, drive: Any) -> list[Any]:
    """Results of the direct or inverse model: accelerations of the independent joints only."""
    entries = [found.chain.own.index(name) for name in found.chain.independent]
    if model == "direct_dynamics":
        return [found.direct(drive)[entries]]
    torques, accelerations = found.inverse(drive)
    return [torques, accelerations[entries]]


def start(machine: Machine) -> dict[str, float]:
    """Positions by variable at which the loops close."""
    return {name: value.value() for loop in machine.loops for name, value in loop.start.items()}


def inputs_of(model: str, state: tuple[Any, ...]) -> tuple[Any, ...]:
    return state[: {"inertia_matrix": 1, "geometric_model": 1, "bias_forces": 2}.get(model, 3)]


def worst(found: Any, wanted: Any) -> float:
    found, wanted = np.asarray(found, dtype=float), np.array(wanted, dtype=object).astype(float)
    assert found.shape == wanted.shape
    return float(np.max(np.abs(found - wanted), initial=0) / max(1.0, np.max(np.abs(wanted), initial=0)))


def states(machine: Machine) -> list[tuple[Any, ...]]:
    return [coupled_state(machine, seed) if machine.is_coupled else random_state(machine, seed) for seed in range(3)]


def coupled_state(machine: Machine, seed: int) -> tuple[list[float], list[float], list[float]]:
    """Near the start of the loops, so that they close on its branch; springs are deflected by a tenth of that."""
    chooser = random.Random(seed)
    joints, near = [machine.joint(j) for j in machine.independent], start(machine)
    reach = [0.03 if joint.kind is Kind.ELASTIC else 0.3 for joint in joints]
    q = [
        near.get(str(joint.variable), 0.0) + x * chooser.uniform(-1, 1) for joint, x in zip(joints, reach, strict=True)
    ]
    return q, [chooser.uniform(-1, 1) for _ in joints], [chooser.uniform(-20, 20) for _ in machine.motors]


def tuple_of(result: Any) -> tuple[Any, ...]:
    return result if isinstance(result, tuple) else (result,)


@pytest.mark.sampled(12)
@pytest.mark.parametrize("golden", ALL_FOLDERS)
def test_committed_numpy_and_c_are_right(golden: Golden, tmp_path: Path) -> None:
    """numpy within 1e-12 of 50 digits, stacked states within 8 u of single ones, and C the same bits as numpy."""
    assert COMPILERS, "neither gcc nor clang"
    machine, folder = valued(golden.example), folder_of(golden, tmp_path)
    module = imported(folder)
    p = module.parameters(**values_of(machine))
    libraries = [compiled(folder, tmp_path, compiler) for compiler in COMPILERS]
    all_states = states(machine)
    for model in golden.models or FIVE[:2]:
        function = getattr(module, model)
        singles = []
        for state in all_states:
            inputs = inputs_of(model, state)
            found = tuple_of(function(*inputs, p))
            singles.append(found)
            for output, wanted in zip(found, expected(machine, model, state), strict=True):
                assert worst(output, wanted) < CONTRACT, model
            for library in libraries:
                shapes = [output.shape for output in found]
                for output, in_c in zip(found, call(library, machine.name, model, inputs, p, shapes), strict=True):
                    assert (output == in_c).all(), (model, library)
        stacks = [np.stack(columns) for columns in zip(*(inputs_of(model, s) for s in all_states), strict=True)]
        for k, output in enumerate(tuple_of(function(*stacks, p))):
            assert worst(output, np.stack([single[k] for single in singles])) < CONTRACT, model


@pytest.mark.parametrize("golden", ALL_FOLDERS)
def test_committed_packages_keep_the_contract(golden: Golden, tmp_path: Path) -> None:
    machine, module = valued(golden.example), imported(folder_of(golden, tmp_path))
    rows = [machine.joints[j - 1] for j in machine.independent]
    assert tuple(row.name for row in rows) == module.JOINTS
    assert tuple(machine.joint(j).name for j in machine.dependent) == getattr(module, "DEPENDENT", ())
    assert tuple(k for k, row in enumerate(rows) if row.kind == "motor") == module.MOTORS
    assert tuple(k for k, row in enumerate(rows) if row.kind == "elastic") == module.ELASTIC
    assert tuple(p.name for p in machine.parameters) == module.PARAMETERS
    assert len(module.DEFAULTS) == len(module.PARAMETERS)
    n, m = len(rows), len(module.MOTORS)
    p = module.parameters(**values_of(machine))
    q, qd, drive = states(machine)[0]
    function = module.direct_dynamics
    with pytest.raises(ValueError, match=rf"q has shape \({n + 1},\): \(\.\.\., {n}\) is expected"):
        function(np.zeros(n + 1), qd, drive, p)
    with pytest.raises(ValueError, match=rf"tau has shape \(\): \(\.\.\., {m}\) is expected"):
        function(q, qd, 0.0, p)
    with pytest.raises(TypeError, match="has no parameter nothing"):
        module.parameters(nothing=1)
    assert function(np.zeros((4, 1, n)), np.zeros((3, n)), np.zeros(m), p).shape == (4, 3, n)
    assert np.isnan(function(np.full(n, np.nan), qd, drive, p)).any()
    assert not np.isnan(function(q, qd, drive, p)).any()


SERVO = (np.array([300.0, 120.0]), np.array([20.0, 6.0]))
"""Gains of two motors."""
STEPS_IN_C = """
#include <stdio.h>
#include <stdlib.h>
#include "planar_2r.h"

enum { ROWS = PLANAR_2R_W3_NODES*PLANAR_2R_MOTORS };

int main(void)
{
    double *rows[3], *q = calloc(PLANAR_2R_JOINTS, sizeof *q), *qd = calloc(PLANAR_2R_JOINTS, sizeof *qd);
    const double kp[] = {300.0, 120.0}, kd[] = {20.0, 6.0};
    for (int k = 0; k < 3; ++k) rows[k] = malloc(ROWS*sizeof(double));
    for (int step = 0; step < 40; ++step) {
        for (int k = 0; k < 3*ROWS; ++k) {
            if (scanf("%lf", &rows[k/ROWS][k%ROWS]) != 1) return 1;
        }
        planar_2r_step_w3_servo(rows[0], rows[1], rows[2], kp, kd, 0.005, planar_2r_defaults, q, qd);
    }
    printf("%.17g %.17g %.17g %.17g\\n", q[0], q[1], qd[0], qd[1]);
    for (int k = 0; k < 3; ++k) free(rows[k]);
    free(q);
    free(qd);
    return 0;
}
"""


def wanted_motion(t: Array) -> tuple[Array, Array, Array]:
    """tau, r and rd (..., 2) of motors at times (...,)."""
    phase = np.stack([5 * t, 7 * t], axis=-1)
    return (
        np.stack([9 + 0 * t, 2 * np.cos(3 * t)], axis=-1),
        0.3 * np.sin(phase),
        0.3 * np.array([5, 7]) * np.cos(phase),
    )


def test_committed_steps_are_right(tmp_path: Path) -> None:
    """Under servos: order 3 against DOP853 on the committed direct model; C the same, within its arrays."""
    module, model = imported(GENERATED / "steps" / "planar_2r"), imported(GENERATED / "planar_2r")

    def rate(t: float, y: Array) -> Array:
        tau, r, rd = wanted_motion(np.array(t))
        torque = tau + SERVO[0] * (r - y[:2]) + SERVO[1] * (rd - y[2:])
        return np.concatenate([y[2:], model.direct_dynamics(y[:2], y[2:], torque)])

    exact = solve_ivp(rate, (0, 0.2), np.zeros(4), method="DOP853", rtol=1e-12, atol=1e-12).y[:, -1]
    nodes, ends = np.array(nodes_of(W3), dtype=float), []
    for count in (40, 80):
        h, q, qd = 0.2 / count, np.zeros(2), np.zeros(2)
        rows = [wanted_motion(h * (k + nodes)) for k in range(count)]
        for row in rows:
            q, qd = module.step_w3_servo(*row, *SERVO, h, q, qd)
        ends.append(np.array([*q, *qd]))
        if count == 40:
            given = " ".join(repr(float(x)) for row in rows for part in row for x in part.ravel())
    coarse, fine = (np.abs(end - exact).max() for end in ends)
    assert coarse < 1e-2 and 2.5 < np.log2(coarse / fine) < 3.5
    (tmp_path / "main.c").write_text(STEPS_IN_C)
    folder = GENERATED / "steps" / "planar_2r"
    for compiler in COMPILERS:
        sources = [str(tmp_path / "main.c"), str(folder / "planar_2r.c")]
        command = [compiler, "-std=c99", *SANITIZE, f"-I{folder}", *sources, "-lm", "-o", str(tmp_path / compiler)]
        subprocess.run(command, check=True)
        ran = subprocess.run([str(tmp_path / compiler)], input=given, capture_output=True, text=True, check=True)
        np.testing.assert_allclose(np.array(ran.stdout.split(), dtype=float), ends[0], rtol=0, atol=1e-13)


def test_missing_values_are_named() -> None:
    module = imported(GENERATED / "flex4")
    given = {name: 1.0 for name in module.PARAMETERS if name not in ("k4", "XX1")}
    with pytest.raises(ValueError, match="flex4 needs a value for XX1, k4"):
        module.parameters(**given)
    assert np.isnan(module.DEFAULTS).all()
    assert imported(GENERATED / "planar_2r").parameters(l1=7)[3] == 7
    with pytest.raises(ValueError, match="read-only"):
        module.DEFAULTS[0] = 1


def test_parameter_sets_may_be_stacked_too() -> None:
    """One set for each state, as states stack; each row the same as alone."""
    machine, module = valued("planar_2r.toml"), imported(GENERATED / "planar_2r")
    sets = np.stack([module.parameters(l1=length, m2=mass) for length, mass in ((0.4, 1.5), (0.7, 0.3), (0.1, 9.0))])
    q, qd, tau = (np.array(x) for x in states(machine)[1])
    stacked = module.direct_dynamics(q, qd, tau, sets)
    assert worst(stacked, [module.direct_dynamics(q, qd, tau, p) for p in sets]) < CONTRACT
    torques, accelerations = module.inverse_dynamics(q, qd, stacked, sets)
    assert worst(torques, np.broadcast_to(tau, (3, 2))) < CONTRACT and worst(accelerations, stacked) < CONTRACT


# The C itself


@pytest.mark.thorough
def test_units_cannot_leave_their_comment(tmp_path: Path) -> None:
    """A file is data: whatever a unit says, the code is the same but for its comments."""
    units = ("*/ int x; /*", "a\nb", "\u202e/*", "*\x00/", "**//", "/*/ x", "??/", "\\", "µm")
    machine, _ = read_machine(ROOT / "examples" / "planar_2r.toml")
    odd = [replace(p, unit=unit) for p, unit in zip(machine.parameters, units, strict=True)]
    generate(machine, Scene(), ("c",), tmp_path / "plain")
    generate(replace(machine, parameters=tuple(odd)), Scene(), ("c",), tmp_path / "odd")
    codes = []
    for kind in ("plain", "odd"):
        folder = tmp_path / kind / "planar_2r"
        for compiler in COMPILERS:
            compiled(folder, tmp_path, compiler)
        preprocess = [COMPILERS[0], "-std=c99", "-E", "-P", str(folder / "planar_2r.c")]
        codes.append(subprocess.run(preprocess, capture_output=True, text=True, check=True).stdout)
    assert codes[0] == codes[1]


@pytest.mark.parametrize("golden", ALL_FOLDERS)
def test_headers_serve_cpp(golden: Golden, tmp_path: Path) -> None:
    if not shutil.which("g++"):
        pytest.skip("needs g++")
    folder = folder_of(golden, tmp_path)
    source = tmp_path / "twice.cpp"
    header = f'#include "{folder.name}.h"\n'
    source.write_text(
        header * 2 + f"void (*const f)() = reinterpret_cast<void (*)()>({folder.name}_direct_dynamics);\n"
    )
    command = ["g++", "-Wall", "-Wextra", "-Wpedantic", "-Werror", f"-I{folder}", "-c", str(source)]
    subprocess.run([*command, "-o", str(tmp_path / "twice.o")], check=True)
    symbols = subprocess.run(["nm", str(tmp_path / "twice.o")], capture_output=True, text=True, check=True).stdout
    assert re.search(rf"U {folder.name}_direct_dynamics$", symbols, re.MULTILINE)  # C linkage


@pytest.mark.sampled(12)
@pytest.mark.parametrize("golden", ALL_FOLDERS)
def test_c_has_no_state_and_needs_only_mathematics(golden: Golden, tmp_path: Path) -> None:
    """No variable that can be written, nothing undefined but functions of math.h (memset is how GCC clears arrays)."""
    folder = folder_of(golden, tmp_path)
    for compiler in COMPILERS:
        command = [compiler, *STRICT, "-O2", "-fno-pic", "-c", str(folder / f"{folder.name}.c"), "-o"]
        subprocess.run([*command, str(tmp_path / "model.o")], check=True)
        lines = subprocess.run(["nm", str(tmp_path / "model.o")], capture_output=True, text=True, check=True).stdout
        symbols = [line.split()[-2:] for line in lines.splitlines()]
        assert {kind for kind, _ in symbols} <= {"T", "t", "R", "r", "U"}
        undefined = {name for kind, name in symbols if kind == "U"}
        assert undefined <= {"sin", "cos", "sincos", "sqrt", "atan2", "memset"}, undefined


STATES = 11
"""Of a batch: not a multiple of what is computed side by side."""


def driver(header: str, name: str, shorter: str = "") -> str:
    """A program that calls every function of two headers once, on heap arrays of exactly the declared sizes.

    The array named `shorter` is made one entry too short, to see that this is noticed.
    """
    macro = name.upper()
    sizes = {
        **dict.fromkeys(("q", "qd", "qdd", "H"), f"{macro}_JOINTS"),
        **dict.fromkeys(("tau", "qdd_motor"), f"{macro}_MOTORS"),
        "A": f"{macro}_JOINTS*{macro}_JOINTS",
        "T": f"{macro}_FRAMES*16",
        "p": f"{macro}_PARAMETERS",
    }
    includes = ["#include <stdlib.h>", f'#include "{name}.h"', f'#include "{name}_batch.h"']
    lines = [*includes, "", "int main(void)", "{", "    double sum = 0.0;"]
    constants = ""
    for function, arguments in re.findall(r"^void (\w+)\(([^)]*)\);", header, re.MULTILINE):
        names = re.findall(r"(const )?double \*?(\w+)", arguments)
        is_batch = function.endswith(("_batch", "_batch_threads"))
        constants = f"{function.removesuffix('_prepared').removesuffix('_prepare').upper()}_CONSTANTS"
        lines.append("    {")
        for _, array in names:
            size = f"({constants})" if array == "c" else f"({sizes[array]})"
            size += f"*{STATES}" if is_batch and array != "p" else ""
            less = " - 1" if array == shorter else ""
            lines.append(f"        double *{array} = malloc(({size}{less})*sizeof(double));")
            lines.append(f"        for (int k = 0; k < {size}{less}; ++k) {array}[k] = 0.1 + 0.01*k;")
        states = [str(STATES)] if is_batch else []
        lines.append(f"        {function}({', '.join([*states, *(array for _, array in names)])});")
        for constant, array in names:
            size = f"({constants})" if array == "c" else f"({sizes[array]})"
            size += f"*{STATES}" if is_batch and array != "p" else ""
            if not constant:
                lines.append(f"        for (int k = 0; k < {size}; ++k) sum += {array}[k] != {array}[k];")
            lines.append(f"        free({array});")
        lines.append("    }")
    return "\n".join([*lines, "    return sum > 0.0;", "}", ""])


def sanitized(folder: Path, build: Path, compiler: str, shorter: str = "") -> subprocess.CompletedProcess[str]:
    headers = "".join((folder / f"{folder.name}{kind}.h").read_text() for kind in ("", "_batch"))
    (build / "main.c").write_text(driver(headers, folder.name, shorter))
    program = build / f"main_{compiler}"
    strict = () if shorter else ("-Wall", "-Wextra", "-Werror")  # GCC warns by itself: prototypes state the sizes
    command = [compiler, "-std=c99", *strict, *SANITIZE, f"-I{folder}", str(build / "main.c")]
    objects = [str(sanitized_object(folder / f"{folder.name}{kind}.c", build, compiler)) for kind in ("", "_batch")]
    subprocess.run([*command, *objects, "-lm", "-o", str(program)], check=True)
    return subprocess.run([str(program)], capture_output=True, text=True, check=False)


def sanitized_object(source: Path, build: Path, compiler: str) -> Path:
    """A compiled source; what is compiled there already is used again."""
    made = build / f"{source.stem}_{compiler}.o"
    if not made.exists():
        command = [compiler, "-std=c99", "-Wall", "-Wextra", "-Werror", *SANITIZE, "-c", str(source), "-o", str(made)]
        subprocess.run(command, check=True)
    return made


def with_batch(golden: Golden, out: Path) -> Path:
    """The folder of an example that is generated with its batch."""
    return out / make(golden._replace(targets=("c-batch",)), out)[0].parent


@cache
def sanitizer() -> str:
    """A compiler whose sanitizers work here; empty without."""
    for compiler in COMPILERS:
        run = subprocess.run(
            [compiler, *SANITIZE, "-x", "c", "-", "-o", "/dev/null"],
            input="int main(void) { return 0; }",
            text=True,
            capture_output=True,
            check=False,
        )
        if run.returncode == 0:
            return compiler
    return ""


@pytest.mark.parametrize("golden", SANITIZED)
def test_no_function_leaves_its_arrays(golden: Golden, tmp_path: Path) -> None:
    """Every function, on arrays of exactly the declared sizes, under the address and undefined-behaviour sanitizers."""
    if not sanitizer():
        pytest.skip("needs sanitizers")
    run = sanitized(with_batch(golden, tmp_path), tmp_path, sanitizer())
    assert run.returncode == 0, run.stderr


@pytest.mark.thorough
def test_an_array_too_short_is_noticed(tmp_path: Path) -> None:
    if not sanitizer():
        pytest.skip("needs sanitizers")
    for shorter in ("q", "tau", "p", "c", "A", "T"):
        run = sanitized(GENERATED / "all_models" / "planar_2r", tmp_path, sanitizer(), shorter)
        assert run.returncode != 0 and "heap-buffer-overflow" in run.stderr, shorter


@pytest.mark.thorough
@pytest.mark.parametrize("seed", [0, 1])
def test_random_trees_compile_without_a_warning_and_agree(seed: int, tmp_path: Path) -> None:
    """Friction, wrenches, a moving base, parameters for everything; all five models."""
    machine = random_machine(seed, joints=4, symbolic=True, moving_base=True)
    generate(machine, Scene(FIVE), ("numpy", "c-batch"), tmp_path)
    folder = tmp_path / machine.name
    module = imported(folder)
    libraries = [compiled(folder, tmp_path, compiler) for compiler in COMPILERS]
    state = random_state(machine, seed)
    for model in RESULTS:
        inputs = inputs_of(model, state)
        found = tuple_of(getattr(module, model)(*inputs))
        for output, wanted in zip(found, expected(machine, model, state), strict=True):
            assert worst(output, wanted) < CONTRACT, model
        for library in libraries:
            shapes = [output.shape for output in found]
            results: list[Array] = call(library, machine.name, model, inputs, module.DEFAULTS, shapes)
            assert all((a == b).all() for a, b in zip(found, results, strict=True)), model
    if sanitizer():
        run = sanitized(folder, tmp_path, sanitizer())
        assert run.returncode == 0, run.stderr
