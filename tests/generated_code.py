"""Generated code in tests: rendered, taken apart as text, imported, compiled."""

from __future__ import annotations

import ctypes
import importlib.util
import itertools
import re
import shutil
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from symoro_elastic.codegen.targets import render_targets
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.restrict import names_to_fold, restrict
from symoro_elastic.machine.scene import Scene
from symoro_elastic.models.derivatives.derivatives import DERIVATIVES
from symoro_elastic.models.drives.control import CONTROLLERS
from symoro_elastic.models.dynamics.closed_chains import CLOSED_CHAINS
from symoro_elastic.models.dynamics.feed_forward import FEED_FORWARD
from symoro_elastic.models.kinematics.geometric import STATIC_SPRINGS
from symoro_elastic.models.kinematics.inverse_geometric import INVERSE_GEOMETRIC
from symoro_elastic.models.kinematics.inverse_kinematic import INVERSE_KINEMATIC
from symoro_elastic.models.packaging import package
from symoro_elastic.models.programs.catalogue import MODELS, trace_scene
from symoro_elastic.numerics.linear.grouping import grouping_by_rank
from symoro_elastic.symbolic.program import OperationCount

ALL_MODELS = tuple(
    name
    for name, model in MODELS.items()
    if model
    not in (
        *(*INVERSE_GEOMETRIC, *INVERSE_KINEMATIC, *DERIVATIVES, *FEED_FORWARD),
        *(*CLOSED_CHAINS, *STATIC_SPRINGS, *CONTROLLERS),
    )
)
"""The models that every machine has, but for derivatives, which are long."""
STRICT = ("-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Werror")
COMPILERS = tuple(name for name in ("gcc", "clang") if shutil.which(name))
RESULTS = {
    "direct_dynamics": ("qdd",),
    "inverse_dynamics": ("tau", "qdd"),
    "inertia_matrix": ("A",),
    "bias_forces": ("H",),
    "geometric_model": ("T",),
}
_unique = itertools.count()

Array = NDArray[np.float64]


def rendered(machine: Machine, scene: Scene | None = None, targets: Sequence[str] = ("numpy", "c")) -> dict[str, str]:
    """File names and texts; all models unless the scene names some."""
    scene = _with_models(scene)
    traced = trace_scene(machine, scene, grouping_by_rank)
    described = package(restrict(machine, scene), traced, names_to_fold(machine, scene))
    return render_targets(described, targets)


def _with_models(scene: Scene | None) -> Scene:
    scene = scene or Scene()
    return scene if scene.models else replace(scene, models=ALL_MODELS)


# Text


@dataclass(frozen=True)
class Assignment:
    """`target = right;`; local variables are declared where they are assigned."""

    target: str
    local: bool
    right: str


def c_functions(text: str) -> dict[str, list[Assignment]]:
    """Functions of a C text and their assignments, found without the printer's help; of one state, not of a batch."""
    plain = re.sub(r"/\*.*?\*/", " ", text, flags=re.DOTALL)
    plain = re.sub(r"\b\w+_sign\(", "sign(", plain)
    found = {}
    for name, body in re.findall(r"^(?:static )?void (\w+)\([^)]*\)\n\{\n(.*?)^\}", plain, re.DOTALL | re.MULTILINE):
        statements = [" ".join(s.split()).removeprefix("} ") for s in body.split(";")]
        parts = [re.fullmatch(r"(const double )?(\w+(?:\[\w+\])?) = (.*)", s) for s in statements]
        found[name] = [Assignment(p[2], bool(p[1]), p[3]) for p in parts if p]
    return found


def c_work(functions: dict[str, list[Assignment]], name: str) -> tuple[list[Assignment], list[Assignment]]:
    """Assignments of one model: on parameters only, then for each call; parts in a row, what they hand on left out."""
    kinds = (rf"{name}_prepare(_part\d+)?", rf"{name}(_prepared)?(_part\d+)?")
    once, each = ([a for n, found in functions.items() if re.fullmatch(kind, n) for a in found] for kind in kinds)
    return _own(once), _own(each)


def _own(assignments: list[Assignment]) -> list[Assignment]:
    """Without the spill array, the angles, and the size of these."""
    own = [a for a in assignments if "spill[" not in a.target + a.right and not a.target.startswith(("angle[", "size"))]
    return list(dict.fromkeys(own))  # each part unpacks the arguments it needs


TOKEN = re.compile(
    r"(?P<number>\d+\.?\d*(?:[eE][+-]?\d+)?)|(?P<name>[A-Za-z_]\w*)|(?P<sign>[-+*/])|(?P<other>[\[\](),])"
)


def tokens(expression: str) -> list[tuple[str, str]]:
    """(kind, text) of each token; fails on anything that is not an arithmetic."""
    assert not TOKEN.sub("", expression).strip(), expression
    return [(str(m.lastgroup), m[0]) for m in TOKEN.finditer(expression)]


def names_in(expression: str) -> list[str]:
    """Identifiers of an expression."""
    return [text for kind, text in tokens(expression) if kind == "name"]


def recount(assignments: Sequence[Assignment]) -> OperationCount:
    """Operations in printed statements, by reading the text: binary signs, sines and cosines."""
    totals = {"mul": 0, "add": 0, "div": 0, "sincos": 0}
    kinds = {"*": "mul", "/": "div", "+": "add", "-": "add"}
    for assignment in assignments:
        before = ("other", "(")
        for kind, text in tokens(assignment.right):
            if kind == "sign" and (before[0] in ("number", "name") or before[1] in (")", "]")):
                totals[kinds[text]] += 1
            totals["sincos"] += kind == "name" and text in ("sin", "cos", "sine", "cosine")
            before = (kind, text)
    return OperationCount(**totals)


# Numbers


def imported(folder: Path) -> ModuleType:
    """The numpy package in a folder, under a name of its own."""
    name = f"generated_{next(_unique)}_{folder.name}"
    spec = importlib.util.spec_from_file_location(
        name, folder / "__init__.py", submodule_search_locations=[str(folder)]
    )
    assert spec and spec.loader
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module


def compiled(folder: Path, build: Path, compiler: str, name: str = "") -> ctypes.CDLL:
    """The C of a folder as a library, without a warning; sines and cosines are the library's, as Python's are."""
    name = name or folder.name
    library = build / f"{name}_{compiler}_{next(_unique)}.so"
    command = [
        compiler,
        *STRICT,
        "-O1",
        "-ffp-contract=off",
        f"-D{name.upper()}_LIBM",
        "-shared",
        "-fPIC",
        "-o",
        str(library),
    ]
    run = subprocess.run([*command, str(folder / f"{name}.c"), "-lm"], capture_output=True, text=True, check=False)
    assert run.returncode == 0 and not run.stderr, run.stderr
    return ctypes.CDLL(str(library))


def call(
    library: ctypes.CDLL, machine: str, model: str, inputs: Sequence[Any], p: Any, shapes: Sequence[tuple[int, ...]]
) -> list[Array]:
    """Results of a C function."""
    arrays = [np.ascontiguousarray(x, dtype=float) for x in (*inputs, p)]
    results = [np.full(shape, np.nan) for shape in shapes]
    pointers = [a.ctypes.data_as(ctypes.POINTER(ctypes.c_double)) for a in (*arrays, *results)]
    function = getattr(library, f"{machine}_{model}")
    function.restype = None
    function(*pointers)
    return results
