"""The C++ header: the bits of the C in double and single precision, other scalar types, warnings, clashing names."""

from __future__ import annotations

import ctypes
import re
import shutil
import site
import subprocess
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from symoro_elastic.codegen.compile import load_library
from symoro_elastic.codegen.package import Package
from symoro_elastic.codegen.precision import DOUBLE, SINGLE, Precision
from symoro_elastic.codegen.targets.c import KEYWORDS, LIBRARY, render_c
from symoro_elastic.codegen.targets.cpp import namespace_of, render_cpp
from symoro_elastic.codegen.targets.numpy import render_numpy
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.machine.machine import Joint, Kind, Machine
from symoro_elastic.machine.scene import Scene
from symoro_elastic.models.packaging import trace_models
from symoro_elastic.numerics.verification.implementations import import_package
from tests.benchmarks.machines import humanoid, quadruped
from tests.closed_chains.machines import machine as of_loops
from tests.codegen.test_local_names import PARAMETERS, VARIABLES, arm
from tests.codegen.test_time_steps import machine as of_steps
from tests.models.test_floating_base import on
from tests.references.limbs import with_limbs
from tests.references.random_machines import chain, planar_2r, random_machine

COMPILERS = tuple(name for name in ("g++", "clang++") if shutil.which(name))
STRICT = ("-Wall", "-Wextra", "-pedantic", "-Wconversion", "-Wshadow", "-Wdouble-promotion", "-Werror")
STANDARDS = ("c++11", "c++20")
SAME = ("-O0", "-ffp-contract=off", "-fPIC", "-shared")
FIVE = ("direct_dynamics", "inverse_dynamics", "inertia_matrix", "bias_forces", "geometric_model")
CASES = {
    "random": ((*FIVE, "jacobian", "energy"), ()),
    "planar": (("direct_dynamics",), ("w2", "rodas4")),
    "numbers": (("direct_dynamics", "geometric_model"), ()),
    "ring": (("assemble",), ()),
    "on_base": (("direct_dynamics",), ("w2",)),
    "body": (("direct_dynamics",), ("w2",)),
    "long": (("inverse_dynamics",), ()),
    "hostile": (("direct_dynamics", "geometric_model"), ()),
    "drives": (("direct_dynamics",), ("w3",)),
    "quadruped": (("direct_dynamics", "inverse_dynamics", "inertia_matrix"), ("w2",)),
    "six limbs": (("direct_dynamics", "inverse_dynamics"), ()),
    "humanoid": (("direct_dynamics",), ()),
}
"""Models and methods of time steps."""
LIMBS = ("quadruped", "six limbs")
PROTOTYPE = re.compile(r"^void (\w+)\(([^)]*)\);", re.MULTILINE)
ROOM = 2000
"""Entries of each array that is handed to a function: more than any has."""

pytestmark = [pytest.mark.skipif(not COMPILERS, reason="no C++ compiler"), pytest.mark.sampled(5)]


def machine(name: str) -> Machine:
    if name == "random":
        return random_machine(0, joints=5, symbolic=True, moving_base=True)
    if name == "numbers":
        return replace(random_machine(1, joints=4), name="gamma")
    if name == "planar":
        return planar_2r(elastic=[2])
    if name == "body":
        return on(Machine("body", (Joint("tip", 0, Kind.FIXED, 2),)))
    if name == "on_base":
        return on(random_machine(3, joints=2, massless=0, friction=False))
    if name == "drives":
        return of_steps(name)
    if name == "quadruped":
        return quadruped()
    if name == "humanoid":
        return humanoid()
    if name == "six limbs":
        return with_limbs(3, 6, symbolic=True)
    if name == "hostile":
        return arm(VARIABLES, (*PARAMETERS, "joints", "motors", "std", "detail", "Scalar", "INT8_MAX", "p_x"))
    return chain(22) if name == "long" else of_loops(name)


@cache
def package(name: str) -> Package:
    models, steps = CASES[name]
    return trace_models(machine(name), Scene(models=models, steps=steps)).package


@dataclass(frozen=True)
class Argument:
    """A parameter of a function of C: an array, or a number."""

    name: str
    is_array: bool
    is_result: bool


def prototypes(header: str) -> dict[str, list[Argument]]:
    """The functions of a header and their parameters."""
    plain = re.sub(r"/\*.*?\*/", " ", header, flags=re.DOTALL)
    found = {}
    for name, arguments in PROTOTYPE.findall(plain):
        words = [text.strip() for text in arguments.split(",")]
        found[name] = [
            Argument(re.findall(r"\w+", word.partition("[")[0])[-1], "[" in word or "*" in word, "const" not in word)
            for word in words
        ]
    return found


def in_cpp(name: str, package: Package) -> str:
    """The name of a function of C in the namespace."""
    return name.removeprefix(f"{package.name}_").removesuffix("_f32").replace("_f32_", "_")


def wrapped(functions: dict[str, list[Argument]], package: Package, real: str) -> str:
    """Functions that are called as those of C are, and call those of the header."""
    lines = [f'#include "{package.name}.hpp"', 'extern "C" {']
    for name, arguments in functions.items():
        declared = [f"{'' if a.is_result else 'const '}{real} {'*' if a.is_array else ''}{a.name}" for a in arguments]
        call = f"{namespace_of(package.name)}::{in_cpp(name, package)}({', '.join(a.name for a in arguments)});"
        lines.append(f"void {name}({', '.join(declared)});\nvoid {name}({', '.join(declared)}) {{ {call} }}")
    return "\n".join([*lines, "}"])


def run(*command: str, folder: Path) -> None:
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0 and not done.stderr, done.stderr[:2000]


def outcome(library: ctypes.CDLL, function: str, arguments: list[Argument], p: Array) -> list[bytes]:
    """All arrays after a call, of numbers that are drawn but for p."""
    rng = np.random.default_rng(1)
    arrays, given = [], []
    real = p.dtype
    for a in arguments:
        array = rng.uniform(0.1, 0.9, ROOM).astype(real)
        if a.name == "p":
            array[: len(p)] = p
        arrays.append(array)
        number = ctypes.c_float if real == np.float32 else ctypes.c_double
        given.append(ctypes.c_void_p(array.ctypes.data) if a.is_array else number(1e-3))
    getattr(library, function)(*given)
    return [np.where(np.isnan(array), 0, array).tobytes() for array in arrays]


def differing(name: str, precision: Precision, folder: Path, *flags: str) -> list[str]:
    """Functions of the header whose results are not the bits of those of C."""
    made, files = package(name), {**render_c(package(name), precision), **render_cpp(package(name))}
    for file, text in files.items():
        (folder / file).write_text(text, encoding="utf-8")
    stem = made.name + precision.suffix
    functions = prototypes(files[f"{stem}.h"])
    if precision is SINGLE:
        functions = {f: a for f, a in functions.items() if "_f32" in f}
    (folder / "wrapped.cpp").write_text(wrapped(functions, made, precision.state), encoding="utf-8")
    run(*("gcc", "-std=c99", *SAME, "-o", "c.so", f"{stem}.c", "-lm"), folder=folder)
    run(*(COMPILERS[0], "-std=c++11", *SAME, *STRICT, *flags, "-o", "cpp.so", "wrapped.cpp", "-lm"), folder=folder)
    libraries = [load_library(folder / file) for file in ("c.so", "cpp.so")]
    p = np.array([*(one.value for one in made.parameters), 0.0], precision.state)
    assert len(functions) >= len(made.functions)
    return [f for f, a in functions.items() if len({tuple(outcome(one, f, a, p)) for one in libraries}) > 1]


NEEDS_C = pytest.mark.skipif(shutil.which("gcc") is None, reason="needs gcc")


@pytest.mark.sampled(12)
@NEEDS_C
@pytest.mark.parametrize("name", CASES)
def test_in_double_precision_it_has_the_bits_of_c(name: str, tmp_path: Path) -> None:
    assert differing(name, DOUBLE, tmp_path) == []


@pytest.mark.thorough
@NEEDS_C
@pytest.mark.parametrize("name", ["random", *LIMBS])
def test_in_single_precision_it_has_the_bits_of_c(name: str, tmp_path: Path) -> None:
    assert differing(name, SINGLE, tmp_path) == []


@NEEDS_C
@pytest.mark.parametrize("name", LIMBS)
def test_congruent_limbs_of_any_scalar_are_side_by_side(name: str, tmp_path: Path) -> None:
    (header,) = render_cpp(package(name)).values()
    widths = {"quadruped": {"4"}, "six limbs": {"2", "4"}}
    assert set(re.findall(r"const lanes(\d) qd\d+ = \{qd\[", header)) == widths[name]
    assert differing(name, DOUBLE, tmp_path, "-DNO_VECTORS") == []


@pytest.mark.parametrize("standard", STANDARDS)
@pytest.mark.parametrize("compiler", COMPILERS)
def test_it_compiles_without_a_warning(compiler: str, standard: str, tmp_path: Path) -> None:
    made = package("random")
    header = render_c(made)[f"{made.name}.h"]
    (tmp_path / f"{made.name}.hpp").write_text(render_cpp(made)[f"{made.name}.hpp"], encoding="utf-8")
    (tmp_path / "wrapped.cpp").write_text(wrapped(prototypes(header), made, "double"), encoding="utf-8")
    run(compiler, f"-std={standard}", *STRICT, "-Wold-style-cast", "-fsyntax-only", "wrapped.cpp", folder=tmp_path)


def printed(machine: Machine, model: str, main: str, folder: Path, *flags: str) -> Array:
    """The numbers that a program around the header of a model prints."""
    made = trace_models(machine, Scene(models=(model,))).package
    (folder / f"{made.name}.hpp").write_text(render_cpp(made)[f"{made.name}.hpp"], encoding="utf-8")
    scalars = (Path(__file__).parent / "scalars.hpp").read_text(encoding="utf-8")
    (folder / "scalars.hpp").write_text(scalars, encoding="utf-8")
    includes = f'#include <cstdio>\n#include "scalars.hpp"\n#include "{made.name}.hpp"\n'
    (folder / "main.cpp").write_text(f"{includes}namespace m = {made.name};\n{main}", encoding="utf-8")
    run(COMPILERS[0], "-std=c++11", "-O0", *STRICT, *flags, "-o", "main", "main.cpp", folder=folder)
    done = subprocess.run([str(folder / "main")], capture_output=True, text=True, check=True)
    return np.array(done.stdout.split(), dtype=float)


Q, QD, TAU = (np.array([0.3, -0.7, 1.1, 0.2]), np.array([0.5, -0.4, 0.9, 0.6]), np.array([1.0, 2.0, -1.5, 0.5]))
DUALS = """
using duals::Dual;
template <class P> void print(std::size_t by_q, std::size_t by_qd, const P *p)
{
    Dual q[m::joints], qd[m::joints], tau[m::motors], qdd[m::joints];
    const double at[][4] = {@STATE@};
    for (std::size_t j = 0; j < m::joints; j++) {
        q[j] = Dual(at[0][j], j == by_q);
        qd[j] = Dual(at[1][j], j == by_qd);
    }
    for (std::size_t j = 0; j < m::motors; j++) tau[j] = Dual(at[2][j]);
    m::direct_dynamics(q, qd, tau, p, qdd);
    for (const Dual &x : qdd) std::printf("%.17g\\n", x.d);
}
int main()
{
    for (std::size_t k = 0; k < m::joints; k++) print(k, 9, m::defaults);
    for (std::size_t k = 0; k < m::joints; k++) print(9, k, m::defaults);
    for (std::size_t k = 0; k < m::parameters; k++) {
        Dual p[m::parameters];
        for (std::size_t i = 0; i < m::parameters; i++) p[i] = Dual(m::defaults[i], i == k);
        print(9, 9, p);
    }
}
"""


def test_dual_numbers_give_the_derivatives_of_the_models_of_derivatives(tmp_path: Path) -> None:
    machine = planar_2r(elastic=[2])
    names = ("direct_dynamics_derivatives", "direct_dynamics_parameter_derivatives")
    made = trace_models(machine, Scene(models=names)).package
    module = import_package(render_numpy(made), tmp_path / "numpy")
    q, qd, tau = Q[: len(made.axes)], QD[: len(made.axes)], TAU[: len(made.motors)]
    by_state = getattr(module, names[0])(q, qd, tau)
    by_named = dict(zip(made.functions[1].columns, np.asarray(getattr(module, names[1])(q, qd, tau)).T, strict=True))
    by_parameters = [by_named.get(parameter.name, np.zeros(len(q))) for parameter in made.parameters]
    wanted = np.concatenate([by_state[0].T.ravel(), by_state[1].T.ravel(), np.ravel(by_parameters)])
    state = ", ".join(f"{{{', '.join(map(repr, x.tolist()))}}}" for x in (Q, QD, TAU))
    found = printed(machine, "direct_dynamics", DUALS.replace("@STATE@", state), tmp_path)
    assert found.shape == wanted.shape
    assert np.abs(found - wanted).max() < 1e-12 * np.abs(wanted).max()


FIXED = """
template <class Number> void print()
{
    const double state[] = {0.3, -0.7}, rate[] = {0.5, -0.4}, torque[] = {0.01, -0.02};
    Number q[2], qd[2], tau[2], qdd[2], p[m::parameters];
    for (std::size_t j = 0; j < 2; j++) {
        q[j] = Number(state[j]);
        qd[j] = Number(rate[j]);
        tau[j] = Number(torque[j]);
    }
    for (std::size_t k = 0; k < m::parameters; k++) p[k] = Number(m::defaults[k]);
    m::direct_dynamics(q, qd, tau, p, qdd);
    for (const Number &x : qdd) std::printf("%.17g\\n", double(x));
}
int main() { print<double>(); print<fixed_point::Fixed>(); }
"""


def test_numbers_in_fixed_point_give_the_results_to_their_resolution(tmp_path: Path) -> None:
    exact, found = printed(planar_2r(), "direct_dynamics", FIXED, tmp_path).reshape(2, -1)
    assert np.abs(found - exact).max() < 1e-6 * np.abs(exact).max()
    assert (found != exact).any()


EIGEN = next(iter(Path(site.getsitepackages()[0]).glob("cmeel.prefix/include/eigen3")), None)
WITH_EIGEN = """
#include <unsupported/Eigen/AutoDiff>
const int n = m::joints;
typedef Eigen::AutoDiffScalar<Eigen::Matrix<double, n, 1>> Number;
int main()
{
    Number q[n], rest[n], qdd[n];
    duals::Dual q_dual[n], rest_dual[n], qdd_dual[n];
    for (int j = 0; j < n; j++) {
        q[j] = Number(0.3 - j, n, j);
        rest[j] = Number(0.5);
        rest_dual[j] = duals::Dual(0.5);
    }
    m::direct_dynamics(q, rest, rest, m::defaults, qdd);
    for (int k = 0; k < n; k++) for (int j = 0; j < n; j++) std::printf("%.17g ", qdd[j].derivatives()[k]);
    for (int k = 0; k < n; k++) {
        for (int j = 0; j < n; j++) q_dual[j] = duals::Dual(0.3 - j, j == k);
        m::direct_dynamics(q_dual, rest_dual, rest_dual, m::defaults, qdd_dual);
        for (int j = 0; j < n; j++) std::printf("%.17g ", qdd_dual[j].d);
    }
}
"""


@pytest.mark.skipif(EIGEN is None, reason="needs Eigen (cmeel-eigen)")
@pytest.mark.parametrize("name", ["planar", "six limbs"])
def test_expression_templates_of_eigen_differentiate_it(name: str, tmp_path: Path) -> None:
    flags = ("-isystem", str(EIGEN), "-w")
    found, wanted = printed(machine(name), "direct_dynamics", WITH_EIGEN, tmp_path, *flags).reshape(2, -1)
    assert np.abs(found - wanted).max() < 1e-13 * np.abs(wanted).max()


def test_no_namespace_clashes_with_the_headers_that_are_included(tmp_path: Path) -> None:
    includes = "\n".join(re.findall(r"#include <\w+>", next(iter(render_cpp(package("random")).values()))))
    (tmp_path / "headers.cpp").write_text(includes, encoding="utf-8")
    done = subprocess.run(
        [COMPILERS[0], "-std=c++11", "-E", "-P", "headers.cpp"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=True,
    )
    plain = [
        name
        for name in sorted(set(re.findall(r"\b[a-z][a-z0-9_]*\b", done.stdout)))
        if name not in KEYWORDS | LIBRARY and not re.match(r"f(32|64)", name)
    ]
    namespaces = [f"namespace {namespace_of(name)} {{}}" for name in plain]
    (tmp_path / "names.cpp").write_text("\n".join([includes, *namespaces]), encoding="utf-8")
    run(COMPILERS[0], "-std=c++11", "-fsyntax-only", "names.cpp", folder=tmp_path)
    assert namespace_of("gamma") == "gamma_"
    assert namespace_of("two_axis") == "two_axis"
