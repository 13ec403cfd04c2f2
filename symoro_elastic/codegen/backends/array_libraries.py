"""Models on arrays of any library that has the functions of numpy or of the Python array API: JAX, PyTorch, CuPy.

Arguments and results have the shapes that those of the functions on numpy have; leading axes broadcast. The arrays of a
library stay on their device and keep their precision, and their derivatives: no entry is ever taken out as a float.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import reduce, wraps
from operator import add
from types import ModuleType
from typing import Any

import numpy as np

from symoro_elastic.codegen.backends.numpy_programs import Model, models_of, one_or_all
from symoro_elastic.codegen.package import Package
from symoro_elastic.codegen.real_numbers import refuse_no_numbers
from symoro_elastic.foundation.errors import InputError

Functions = dict[str, Callable[..., Any]]
FUNCTIONS = ("sin", "cos", "sqrt", "sign")
OF_TWO = ("minimum", "maximum")
ON_ARRAYS = ("asarray", "zeros_like", "full_like", "sum", "stack", "reshape", "broadcast_to")


def on_arrays(package: Package, module: ModuleType, library: Any) -> Functions:
    """Return the models as functions of arrays of a library; raises `InputError` for an unsupported library."""
    missing = [name for name in (*FUNCTIONS, *OF_TWO, *ON_ARRAYS) if not hasattr(library, name)]
    if missing or not (hasattr(library, "atan2") or hasattr(library, "arctan2")):
        name = getattr(library, "__name__", repr(library))
        what = f"{name} has no {(*missing, 'atan2')[0]}: give the name of a backend, or an array library"
        raise InputError("symoro-elastic", "--backend", what)
    namespace = _Namespace(library)
    return {model.name: _function(model, namespace) for model in models_of(package, module)}


class _Namespace:
    """An array library: the functions that programs call, and its functions of arrays."""

    def __init__(self, library: Any) -> None:
        self.library = library
        self.sin, self.cos, self.sqrt, self.sign = (getattr(library, name) for name in FUNCTIONS)
        self.atan2 = library.atan2 if hasattr(library, "atan2") else library.arctan2

    def minimum(self, x: Any, y: Any) -> Any:
        """Return the lesser numbers; one of them may be a number of Python."""
        return self.library.minimum(*self._both(x, y))

    def maximum(self, x: Any, y: Any) -> Any:
        """Return the larger numbers; one of them may be a number of Python."""
        return self.library.maximum(*self._both(x, y))

    def _both(self, x: Any, y: Any) -> tuple[Any, Any]:
        if not hasattr(y, "shape"):
            return x, self.library.full_like(x, y)
        return (x, y) if hasattr(x, "shape") else (self.library.full_like(y, x), y)

    def array(self, value: Any) -> Any:
        """Return an array of the library; numbers of Python become double precision, those of numpy keep theirs."""
        if hasattr(value, "shape") and not isinstance(value, np.ndarray):
            return value
        try:
            array = np.asarray(value)
        except (TypeError, RuntimeError):  # numbers of the library that are not known yet
            return self.library.asarray(value)
        if array.dtype.kind not in "fiub":
            raise TypeError("arguments are real numbers, not objects")
        own = array.astype(array.dtype if array.dtype.kind == "f" else float)  # a copy: PyTorch shares memory
        return self.library.asarray(own)

    def entries(self, array: Any) -> list[Any]:
        """Return the entries along the last axis."""
        if hasattr(self.library, "unstack"):
            return list(self.library.unstack(array, axis=-1))
        return [array[..., k] for k in range(array.shape[-1])]

    def zero(self, arrays: Sequence[Any]) -> Any:
        """Return zeros of the leading shape, type and device of results for these arguments."""
        xp = self.library
        return reduce(add, [xp.sum(xp.zeros_like(array), axis=-1) for array in arrays]) * 1.0

    def stack(self, entries: Sequence[Any], shape: tuple[int, ...], zero: Any) -> Any:
        """Return the array of a result whose entries are arrays, or numbers if constant."""
        xp, lead = self.library, zero.shape
        if not entries:
            return xp.reshape(xp.broadcast_to(zero[..., None], (*lead, 1))[..., :0], (*lead, *shape))
        columns = [xp.broadcast_to(x, lead) if hasattr(x, "shape") else xp.full_like(zero, x) for x in entries]
        return xp.reshape(xp.stack(columns, axis=-1), (*lead, *shape))


def _function(model: Model, namespace: _Namespace) -> Callable[..., Any]:
    """Return a model as a function of arrays of a library."""
    signature = model.signature

    @wraps(model.on_numpy)
    def call(*given: Any, **named: Any) -> Any:
        bound = signature.bind(*given, **named)
        bound.apply_defaults()
        *states, p = (_as_array(model, namespace, name, x) for name, x in bound.arguments.items())
        constants = _constants(model, namespace, p)
        zero = namespace.zero([*states, *([] if states and _is_known(p) else [namespace.array(p)])])
        results = model.program(namespace, *map(namespace.entries, states), constants)
        stacked = [namespace.stack(x, shape, zero) for x, shape in zip(results, model.shapes, strict=True)]
        return one_or_all(stacked)

    return call


def _as_array(model: Model, namespace: _Namespace, name: str, value: Any) -> Any:
    """Return an argument as an array, a matrix flattened row by row; a single row p of numpy stays on numpy.

    Raises `ValueError` where its last axis has not as many entries as the model needs.
    """
    refuse_no_numbers(value)
    array = value if name == "p" and _is_known(value) else namespace.array(value)
    rows, size = model.rows.get(name, 0), model.inputs[name]
    if rows and tuple(array.shape[-2:]) == (rows, rows):
        return namespace.library.reshape(array, (*array.shape[:-2], size))
    if tuple(array.shape[-1:]) != (size,):
        raise ValueError(f"{name} has shape {tuple(array.shape)}: (..., {size}) is expected")
    return array


def _is_known(p: Any) -> bool:
    """Whether p is a single row of numpy, whose values are available before the library traces the call."""
    return isinstance(p, np.ndarray) and p.ndim == 1


def _constants(model: Model, namespace: _Namespace, p: Any) -> Sequence[Any]:
    """Return the parameter-only values of a program; for a single row p of numpy they are in double precision."""
    constants = model.constants_on_floats(p.tolist()) if _is_known(p) else None
    return model.constants(namespace, namespace.entries(namespace.array(p))) if constants is None else constants
