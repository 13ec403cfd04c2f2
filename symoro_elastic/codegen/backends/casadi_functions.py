"""Models as functions of CasADi, on its SX numbers."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from inspect import Signature
from types import ModuleType
from typing import Any

from symoro_elastic.codegen.backends.numpy_programs import Model, models_of
from symoro_elastic.codegen.local_names import with_own_results
from symoro_elastic.codegen.package import Function, Package
from symoro_elastic.codegen.real_numbers import refuse_no_numbers
from symoro_elastic.foundation.packages import import_optional

casadi = import_optional("casadi", 'backend="casadi"', "casadi")
CasadiFunction: Any = casadi.Function


class ModelFunction(CasadiFunction):  # type: ignore[misc]
    """A `casadi.Function` whose last input p is optional: its default is the values of the machine.

    Called by position it returns results; called by names only, a dictionary of them, as functions of CasADi do.
    Vectors are columns; k states as columns of all arguments give k columns of results.
    """

    def __init__(self, function: Any, defaults: Any, signature: Signature, doc: str | None) -> None:
        super().__init__(function)
        self.defaults, self.__signature__, self.__doc__ = defaults, signature, doc

    def __call__(self, *given: Any, **named: Any) -> Any:
        """Return results; raises `TypeError` where an argument other than p is missing."""
        arguments = self.__signature__.bind(*given, **named).arguments
        for value in arguments.values():
            refuse_no_numbers(value)
        arguments.setdefault("p", self.defaults)
        return super().__call__(*arguments.values()) if given else super().__call__(**arguments)

    def __reduce__(self) -> tuple[Any, ...]:
        return ModelFunction, (casadi.Function(self), self.defaults, self.__signature__, self.__doc__)


def casadi_functions(package: Package, module: ModuleType) -> dict[str, Any]:
    """Return the models as functions of CasADi: inputs and outputs have the names that they have on numpy."""
    named = {function.name: function for function in with_own_results(package).functions}
    defaults = casadi.DM([parameter.value for parameter in package.parameters])
    parameters = [parameter.name for parameter in package.parameters]
    return {
        model.name: ModelFunction(
            _function(package.name, model, named[model.name], parameters),
            defaults,
            model.signature,
            model.on_numpy.__doc__,
        )
        for model in models_of(package, module)
    }


def _function(machine: str, model: Model, named: Function, parameters: Sequence[str]) -> Any:
    """Return a model of a machine as a function of CasADi whose inputs are all required."""
    symbols = {a.name: _symbols(a.symbols) for a in model.function.program.inputs} | {"p": _symbols(parameters)}
    *states, p = (casadi.vertsplit(x) for x in symbols.values())
    with _as_written():
        results = model.program(_Functions, *states, model.constants(_Functions, p))
    return casadi.Function(
        f"{machine}_{model.name}",
        [_matrix(x, (rows, rows)) if (rows := model.rows.get(name)) else x for name, x in symbols.items()],
        [_matrix(_column(x), shape) for x, shape in zip(results, model.shapes, strict=True)],
        [*symbols],
        [result.name for result in named.results],
    )


class _Functions:
    """The elementary functions that programs call, in CasADi."""

    sin, cos, sqrt, sign, atan2 = casadi.sin, casadi.cos, casadi.sqrt, casadi.sign, casadi.atan2

    @staticmethod
    def minimum(x: Any, y: Any) -> Any:
        """Return the lesser number; `fmin` would leave NaN out."""
        return casadi.if_else(x < y, x, casadi.if_else(x >= y, y, x + y))

    @staticmethod
    def maximum(x: Any, y: Any) -> Any:
        """Return the larger number; `fmax` would leave NaN out."""
        return casadi.if_else(x > y, x, casadi.if_else(x <= y, y, x + y))


@contextmanager
def _as_written() -> Iterator[None]:
    """Build expressions exactly as the program: CasADi else turns x*(1/y) into x/y, with another rounding."""
    options = casadi.GlobalOptions
    before = options.getSimplificationOnTheFly()
    options.setSimplificationOnTheFly(False)
    try:
        yield
    finally:
        options.setSimplificationOnTheFly(before)


def _symbols(names: Sequence[str]) -> Any:
    return _column([casadi.SX.sym(name) for name in names])


def _column(numbers: Sequence[Any]) -> Any:
    return casadi.SX(casadi.vertcat(*numbers)) if numbers else casadi.SX(0, 1)


def _matrix(entries: Any, shape: tuple[int, ...]) -> Any:
    """Return entries row by row as a column, or as a matrix; matrices of a stack lie one below the other."""
    if len(shape) == 1:
        return entries
    columns = shape[-1]
    return casadi.reshape(entries, columns, entries.numel() // columns if columns else 0).T
