"""Calls of compiled functions with arguments of any kind; needs numpy only, as it is a file of generated packages."""

import functools
import inspect
from typing import Any

import numpy as np


def describe(function: Any, described: Any, inputs: dict[str, Any], real: Any) -> Any:
    """Give a compiled function the name, signature and docstring of its description, and what `call_anyhow` needs.

    `inputs` maps each input to its accepted shapes at a state, the shape in C first; `real` converts an argument to an
    array, or raises.
    """
    signature = inspect.signature(described)
    out = inspect.Parameter("out", inspect.Parameter.KEYWORD_ONLY, default=None)
    functools.update_wrapper(function, described)
    function.__signature__ = signature.replace(parameters=[*signature.parameters.values(), out])
    function.inputs, function.real = inputs, real
    return function


def call_anyhow(function: Any, /, *given: Any, **named: Any) -> Any:
    """Return what a compiled function gives for arguments that it does not read itself: lists, matrices, other axes.

    Raises `TypeError` for unexpected arguments and for values that are not real numbers, `ValueError` for shapes.
    """
    bound = function.__signature__.bind(*given, **named)
    bound.apply_defaults()
    *values, out = bound.arguments.values()
    named_inputs = zip(function.inputs.items(), values, strict=True)
    arrays = [as_numbers(name, function.real(x), shapes) for (name, shapes), x in named_inputs]
    leads = [x.shape[: x.ndim - len(shape)] for x, (shape, *_) in zip(arrays, function.inputs.values(), strict=True)]
    lead = np.broadcast_shapes(*leads)
    spread = [
        np.broadcast_to(x, lead + x.shape[len(own) :]) if own else x for x, own in zip(arrays, leads, strict=True)
    ]
    results = function(*spread)
    return results if out is None else fill(out, results)


def as_numbers(name: str, x: Any, shapes: Any) -> Any:
    """Return an array as float64, each state in the first of the shapes that it may have."""
    for shape in shapes:
        lead = x.shape[: max(x.ndim - len(shape), 0)]
        if x.shape == lead + shape:
            return np.asarray(x, dtype=float).reshape(lead + shapes[0])
    expected = ", ".join(map(str, ("...", *shapes[0])))
    raise ValueError(f"{name} has shape {x.shape}: ({expected}) is expected")


def fill(out: Any, results: Any) -> Any:
    """Copy results to the array, or the arrays of the tuple, that are given for them, and return these."""
    pairs = [(out, results)]
    if isinstance(results, tuple):
        if not isinstance(out, tuple) or len(out) != len(results):
            raise TypeError(f"out is a tuple of {len(results)} arrays")
        pairs = [*zip(out, results, strict=True)]
    for array, result in pairs:
        if not isinstance(array, np.ndarray) or array.dtype != result.dtype:
            raise TypeError(f"out is an array of {result.dtype} for each result")
        if array.shape != result.shape or not array.flags.writeable:
            kind = "" if array.flags.writeable else " and is read-only"
            raise ValueError(
                f"out has shape {array.shape}{kind}: a writeable array of shape {result.shape} is expected"
            )
    for array, result in pairs:
        array[...] = result
    return out
