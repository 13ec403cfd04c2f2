"""Generated models loaded into Python: functions of a machine, compiled or on numpy."""

from __future__ import annotations

import inspect
import shutil
import tempfile
from collections.abc import Callable, Mapping, Sequence
from functools import wraps
from pathlib import Path
from types import ModuleType
from typing import Any

from symoro_elastic.api.machines import MachineLike, the_machine
from symoro_elastic.api.scenes import Asked, SceneLike
from symoro_elastic.codegen.compile import CompiledPackage, compile_package
from symoro_elastic.codegen.package import Function, Package
from symoro_elastic.codegen.targets.c_batch import render_c_batch
from symoro_elastic.codegen.targets.numpy import render_numpy
from symoro_elastic.errors import InputError, among
from symoro_elastic.numerics.implementations import import_package
from symoro_elastic.pipeline import programs
from symoro_elastic.results import Part, Shown

BACKENDS = ("numpy", "c")
OPTIMISED = ("-O2", "-ffp-contract=off")


class LoadedModel(Shown):
    """Functions of a machine, such as `direct_dynamics(q, qd, tau)`, with what its generated package tells.

    `JOINTS`, `MOTORS`, `ELASTIC`, `PARAMETERS`, `DEFAULTS`, `FRAMES` ... are those of the generated numpy package,
    whose docstrings give arguments, results, shapes and units. Leading axes broadcast; p defaults to the machine's
    values, others are `parameters(name=value)`.
    """

    def __init__(self, package: Package, module: ModuleType, functions: Mapping[str, Callable[..., Any]]) -> None:
        self._package, self._module, self._functions = package, module, dict(functions)

    @property
    def name(self) -> str:
        """Name of the machine."""
        return self._package.name

    @property
    def headline(self) -> str:
        """Machine, coordinates and functions."""
        return f"Model of {self.name}: {', '.join(self._functions)}; {len(self._package.axes)} coordinates"

    def parts(self) -> list[Part]:
        """Return what it is, and the arguments and results of each function."""
        return [self.headline, *(f"{name}{_summary(function)}" for name, function in self._functions.items())]

    @property
    def functions(self) -> tuple[str, ...]:
        """Names of the functions."""
        return tuple(self._functions)

    def __getattr__(self, name: str) -> Any:
        """Return a function or a constant of the generated package."""
        if name.startswith("_"):
            raise AttributeError(name)
        if name in self._functions:
            return self._functions[name]
        try:
            return getattr(self._module, name)
        except AttributeError:
            what = f"{self.name} has no {name!r}: it was loaded with {', '.join(self._functions)}"
            raise AttributeError(what) from None

    def __dir__(self) -> list[str]:
        """Return the names of functions and constants."""
        constants = [name for name in getattr(self._module, "__all__", vars(self._module)) if name.isupper()]
        return [*super().__dir__(), *self._functions, *constants, "parameters"]


def _summary(function: Callable[..., Any]) -> str:
    """Return arguments and first line of the docstring of a function."""
    first = (function.__doc__ or "").strip().partition("\n")[0]
    return f"({', '.join(inspect.signature(function).parameters)}): {first}"


def load(
    machine: MachineLike,
    *models: str,
    scene: SceneLike = None,
    outputs: Mapping[str, Sequence[str]] | None = None,
    fold: Sequence[str] = (),
    steps: Sequence[str] = (),
    backend: str = "numpy",
) -> LoadedModel:
    """Return models of a machine as functions: `load("arm.toml", "inertia_matrix").inertia_matrix(q)`.

    Parameters
    ----------
    machine
        A machine, its file or its tables.
    models
        Names of models (`symoro-elastic models` lists them); by default those of the scene, else direct_dynamics and
        inverse_dynamics.
    scene
        A scene: outputs, locked joints, constants.
    outputs
        Joints or frames that are wanted of a model, or columns of derivatives.
    fold
        Parameters that become constants, or ["all"].
    steps
        Time steps beside the models: "w3", "w2", "rk4", "rodas4", "midpoint" (numpy only).
    backend
        "numpy": generated numpy functions; "c": the generated C, compiled by $CC, gcc or clang.

    Raises
    ------
    InputError
        For a name that is none, for a machine whose model would divide by zero, without a C compiler.
    """
    among((backend,), BACKENDS, "--backend")
    if backend == "c" and steps:
        raise InputError("symoro-elastic", "--steps", 'time steps are loaded with backend="numpy", or generated as C')
    found = the_machine(machine)
    package = programs(found, Asked(models, fold, outputs, steps).of(found, scene)).package
    folder = Path(tempfile.mkdtemp(prefix="symoro_elastic_"))
    try:
        module = import_package(render_numpy(package), folder / "numpy")
        functions = _of_module(package, module) if backend == "numpy" else _compiled(package, module, folder / "c")
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    return LoadedModel(package, module, functions)


def _of_module(package: Package, module: ModuleType) -> dict[str, Callable[..., Any]]:
    """Return the public functions of a generated numpy package: models and time steps."""
    own = [name for name, x in vars(module).items() if callable(x) and not name.startswith("_")]
    models = {function.name for function in package.functions}
    return {name: getattr(module, name) for name in own if name in models or name.startswith("step_")}


def _compiled(package: Package, module: ModuleType, folder: Path) -> dict[str, Callable[..., Any]]:
    """Return the functions in C, with the docstrings of those in numpy; raises `InputError` without a compiler."""
    from symoro_elastic.codegen.compile import CompilationFailed, CompilerMissing

    try:
        code = compile_package(package, folder, render_c_batch(package), flags=OPTIMISED)
    except (CompilerMissing, CompilationFailed) as error:
        raise InputError("symoro-elastic", "--backend", str(error)) from None
    return {f.name: _in_c(code, package, f, getattr(module, f.name)) for f in package.functions}


def _in_c(
    code: CompiledPackage, package: Package, function: Function, described: Callable[..., Any]
) -> Callable[..., Any]:
    """Return one compiled function with the arguments of the one in numpy."""
    names = tuple(package.inputs(function))

    @wraps(described)
    def call(*given: Any, **named: Any) -> Any:
        found = code.call(function.name, **dict(zip(names, given, strict=False)), **named)
        results = tuple(found.values())
        return results if len(results) > 1 else results[0]

    return call
