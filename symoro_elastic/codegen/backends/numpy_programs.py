"""Programs of a generated numpy package: their lines run on the numbers of any library."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from types import ModuleType
from typing import Any

from symoro_elastic.codegen.package import Function, Package


@dataclass(frozen=True)
class Model:
    """A function of a package with the code of the numpy module that was generated for it.

    `constants(functions, p)` is its work for a parameter set, `program(functions, *arguments, constants)` that for a
    state: arguments and results by entries, on all numbers with `+ - * /` for which `functions` gives sin, cos, sqrt,
    sign and atan2. `inputs` are the entries of arguments and of p. `on_numpy` is the function of arrays, `floats`
    are the functions of floats.
    """

    function: Function
    inputs: dict[str, int]
    constants: Callable[..., Sequence[Any]]
    program: Callable[..., Sequence[Sequence[Any]]]
    on_numpy: Callable[..., Any]
    floats: type

    @property
    def name(self) -> str:
        """Name of the model."""
        return self.function.name

    @property
    def signature(self) -> inspect.Signature:
        """Names of the arguments; p is the last, and has the values of the machine as its default."""
        return inspect.signature(self.on_numpy)

    @property
    def rows(self) -> dict[str, int]:
        """Rows of the arguments that may be matrices, which are flattened row by row."""
        return {argument.name: argument.quantity.rows for argument in self.function.arguments if argument.quantity.rows}

    @property
    def shapes(self) -> tuple[tuple[int, ...], ...]:
        """Shapes of the results at one state."""
        return tuple(result.shape for result in self.function.results)

    def constants_on_floats(self, p: Sequence[float]) -> Sequence[float] | None:
        """Return the parameter-only values of a parameter set in double precision; None where floats raise an error."""
        try:
            return self.constants(self.floats, p)
        except (ArithmeticError, ValueError):
            return None


def models_of(package: Package, module: ModuleType) -> Iterator[Model]:
    """Return the functions of a package that was rendered for numpy and imported."""
    for function in package.functions:
        lines = getattr(module, f"_{function.name}")
        on_numpy = getattr(module, function.name)
        yield Model(function, package.inputs(function), lines.constants, lines.program, on_numpy, lines._runtime.Floats)


def one_or_all(results: Sequence[Any]) -> Any:
    """Return the only result, or the tuple of all results."""
    return results[0] if len(results) == 1 else tuple(results)
