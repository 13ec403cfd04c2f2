"""Generated models loaded into Python: functions of a machine, compiled, on numpy, or on numbers of other libraries."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial, wraps
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any, TypeAlias

from symoro_elastic.api.declaration import operation_on_models
from symoro_elastic.api.machines import the_machine, warn
from symoro_elastic.api.options import Loading
from symoro_elastic.api.rows import MachineLike
from symoro_elastic.api.scenes import scene_for
from symoro_elastic.codegen.compile import CompilationFailed, CompiledPackage, compile_package
from symoro_elastic.codegen.extension import FLAGS, extension_functions
from symoro_elastic.codegen.package import Function, Package
from symoro_elastic.codegen.real_numbers import real_numbers
from symoro_elastic.codegen.targets.numpy import render_numpy
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.output_files import temporary_folder
from symoro_elastic.foundation.packages import import_optional
from symoro_elastic.foundation.results import Part, Shown
from symoro_elastic.generation.pipeline import programs
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.scene import Scene
from symoro_elastic.numerics.verification.implementations import import_package

Functions: TypeAlias = Mapping[str, Callable[..., Any]]
Loader: TypeAlias = Callable[[Package, ModuleType, Path], Functions]


class LoadedModel(Shown):
    """Functions of a machine, such as `direct_dynamics(q, qd, tau)`, with the data of its generated package.

    `JOINTS`, `ELASTIC`, `PARAMETERS`, `DEFAULTS`, `FRAMES` ... are those of the generated numpy package, whose
    docstrings give arguments, results, shapes and units. `MOTORS` are the entries of q that tau acts on; where motors
    are on joints that follow from loops there are `MOTOR_NAMES` instead. Leading axes broadcast; p defaults to the
    machine's values, others are `parameters(name=value)`. `trace(model, functions, q, ...)` runs the lines of a model
    on numbers of any library. Arguments are real numbers: complex ones, text, dates and masked ones are a `TypeError`
    on every backend. Functions of backend "c" write results to `out`, an array or a tuple of arrays. A model pickles as
    machine, scene and backend, and is compiled anew where the pickle is read.
    `close()`, or the end of a `with` block, closes its library.
    """

    def __init__(self, machine: Machine, scene: Scene, backend: str | ModuleType) -> None:
        """Trace, render and load the models that a scene requests; raises `InputError`."""
        load_functions = _loader(backend)
        self._request = machine, scene, backend
        self._package = package = programs(machine, scene).package
        with temporary_folder() as folder:
            self._module = import_package(render_numpy(package), Path(folder, "numpy"))
            self._module._runtime.real = real_numbers  # refuses text, dates and masks as other backends do
            self._functions = dict(load_functions(package, self._module, Path(folder, "c")))
        vars(self).update(self._functions)  # at hand without a call of __getattr__

    def close(self) -> None:
        """Close the functions, and the library of compiled ones; calls raise `ValueError` from now on.

        A library is unloaded when none of its functions is referred to any more; until then it keeps memory maps of
        the process.
        """
        for name, function in self._functions.items():
            if hasattr(function, "closed"):
                function.closed = self._refusal
            self._functions[name] = getattr(self._module, name, function)
            vars(self).pop(name, None)

    @property
    def _refusal(self) -> str:
        return f"the model of {self.name} is closed: load it again"

    def __enter__(self) -> LoadedModel:
        """Return the model, which is closed at the end of the block."""
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __reduce__(self) -> tuple[Any, ...]:
        """Return machine, scene and backend: another process traces and compiles the models anew."""
        machine, scene, backend = self._request
        if not isinstance(backend, str | ModuleType):
            raise TypeError(f"{backend!r} is not a module: models on it cannot be pickled")
        return _load_again, (machine, scene, backend if isinstance(backend, str) else _Library(backend.__name__))

    @property
    def name(self) -> str:
        """Name of the machine."""
        return self._package.name

    @property
    def package(self) -> Package:
        """The generated package: functions with the joints, frames and components of their results."""
        return self._package

    @property
    def headline(self) -> str:
        """Machine, coordinates and functions."""
        return f"Model of {self.name}: {', '.join(self._functions)}; {len(self._package.axes)} coordinates"

    def parts(self) -> list[Part]:
        """Return a description, and the arguments and results of the functions."""
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
            raise ValueError(self._refusal)
        try:
            return getattr(self._module, name)
        except AttributeError:
            raise AttributeError(self._missing(name)) from None

    def _missing(self, name: str) -> str:
        """Return why a function or constant is missing."""
        if name == "MOTORS":
            named = ", ".join(self._package.motor_names)
            return f"{self.name} has no 'MOTORS': tau follows MOTOR_NAMES ({named}), and some have no entry of q"
        return f"{self.name} has no {name!r}: it was loaded with {', '.join(self._functions)}"

    def __dir__(self) -> list[str]:
        """Return the names of functions and constants."""
        constants = [name for name in getattr(self._module, "__all__", vars(self._module)) if name.isupper()]
        return [*super().__dir__(), *self._functions, *constants, "parameters"]


def _summary(function: Callable[..., Any]) -> str:
    """Return arguments and first line of the docstring of a function."""
    first = (function.__doc__ or "").strip().partition("\n")[0]
    return f"({', '.join(inspect.signature(function).parameters)}): {first}"


@operation_on_models(Loading)
def load(machine: MachineLike, options: Loading) -> LoadedModel:
    """Return models of a machine as functions: `load("arm.toml", "inertia_matrix").inertia_matrix(q)`.

    Raises
    ------
    InputError
        For an unknown name, for a machine whose model would divide by zero, without a C compiler or a package.
    """
    _loader(options.backend)
    if options.steps and options.backend not in ("numpy", "c"):
        raise InputError("symoro-elastic", "--steps", 'time steps are loaded with backend="numpy" or backend="c"')
    full = the_machine(machine)
    return LoadedModel(full, scene_for(full, options, options.steps), options.backend)


@dataclass(frozen=True)
class _Library:
    """An array library by the name of its module, which pickles as modules do not."""

    name: str


def _load_again(machine: Machine, scene: Scene, backend: str | _Library) -> LoadedModel:
    """Return the models of a pickle, loaded anew."""
    return LoadedModel(machine, scene, backend if isinstance(backend, str) else import_module(backend.name))


def _loader(backend: str | ModuleType) -> Loader:
    """Return the function that loads a backend; raises `InputError` for an unknown name."""
    if not isinstance(backend, str):
        name = getattr(backend, "__name__", "")
        return BACKENDS[name] if name in BACKENDS else partial(_on_library, backend)
    if backend not in BACKENDS:
        names = ", ".join(BACKENDS)
        what = (
            f"unknown backend {backend!r}: choose from {names}, or give the module of an array library, backend=torch"
        )
        raise InputError("symoro-elastic", "--backend", what)
    return BACKENDS[backend]


def _of_module(package: Package, module: ModuleType, _: Path) -> Functions:
    """Return the public functions of a generated numpy package: models and time steps."""
    own = [name for name, x in vars(module).items() if callable(x) and not name.startswith("_")]
    models = {function.name for function in package.functions}
    return {name: getattr(module, name) for name in own if name in models or name.startswith("step_")}


def _compile(package: Package, module: ModuleType, folder: Path) -> Functions:
    """Return the functions in C, with the docstrings of the numpy functions; raises `InputError` without a compiler."""
    described = _of_module(package, module, folder)
    try:
        return extension_functions(package, folder, described)
    except CompilationFailed as error:
        warn(f'backend="c" calls C by ctypes, which takes longer, and time steps on numpy: {error.what}')
        code = compile_package(package, folder, flags=FLAGS)
        return {**described, **{f.name: _by_ctypes(code, package, f, described[f.name]) for f in package.functions}}


def _by_ctypes(
    code: CompiledPackage, package: Package, function: Function, described: Callable[..., Any]
) -> Callable[..., Any]:
    """Return a compiled function with the arguments of that in numpy, called by ctypes."""
    signature = inspect.signature(described)

    @wraps(described)
    def call(*args: Any, **named: Any) -> Any:
        if call.closed:  # type: ignore[attr-defined]
            raise ValueError(call.closed)  # type: ignore[attr-defined]
        by_name = code.call(function.name, **signature.bind(*args, **named).arguments)
        results = tuple(by_name.values())
        return results if len(results) > 1 else results[0]

    call.closed = ""  # type: ignore[attr-defined]
    return call


def _on_casadi(package: Package, module: ModuleType, _: Path) -> Functions:
    from symoro_elastic.codegen.backends.casadi_functions import casadi_functions

    return casadi_functions(package, module)


def _on_jax(package: Package, module: ModuleType, _: Path) -> Functions:
    """Return functions of JAX's arrays; warns where JAX computes in single precision."""
    jax = import_optional("jax", 'backend="jax"', "jax")
    if not jax.config.jax_enable_x64:
        double = 'jax.config.update("jax_enable_x64", True) before the first array gives double precision'
        warn(f"JAX computes in single precision, to about 7 digits: {double}")
    return _on_library(import_optional("jax.numpy", 'backend="jax"', "jax"), package, module, Path())


def _on_sympy(package: Package, module: ModuleType, _: Path) -> Functions:
    from symoro_elastic.codegen.backends.sympy_expressions import expressions

    return expressions(package, module)


def _on_library(library: Any, package: Package, module: ModuleType, _: Path) -> Functions:
    from symoro_elastic.codegen.backends.array_libraries import on_arrays

    return on_arrays(package, module, library)


BACKENDS: Mapping[str, Loader] = {
    "numpy": _of_module,
    "c": _compile,
    "casadi": _on_casadi,
    "jax": _on_jax,
    "sympy": _on_sympy,
}
"""What makes the functions of a package, by the name of the backend."""
