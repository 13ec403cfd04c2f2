"""How programs are called: shapes are checked, single states run on floats, stacks on arrays."""

import functools
import math

import numpy as np


class Floats:
    sin, cos, sqrt, atan2 = math.sin, math.cos, math.sqrt, math.atan2

    @staticmethod
    def sign(x):
        return 1.0 if x > 0 else -1.0 if x < 0 else x


class Arrays:
    sin, cos, sqrt, sign, atan2 = np.sin, np.cos, np.sqrt, np.sign, np.arctan2


def run(module, arguments, p, parameters, shapes):
    """Results of a generated program for states stacked along leading axes."""
    arrays = [checked(name, value, size) for name, value, size in arguments]
    p = checked("p", p, parameters)
    lead = np.broadcast_shapes(p.shape[:-1], *(a.shape[:-1] for a in arrays))
    if lead:
        results = on_arrays(module, arrays, p)
    else:
        try:
            constants = prepared(module.constants, p.tobytes())
            results = module.program(Floats, *[a.tolist() for a in arrays], p.tolist(), constants)
        except (ArithmeticError, ValueError):
            results = on_arrays(module, arrays, p)
    return tuple(stacked(entries, lead, shape) for entries, shape in zip(results, shapes))


def on_arrays(module, arrays, p):
    with np.errstate(all="ignore"):
        p = np.moveaxis(p, -1, 0)
        columns = [np.moveaxis(a, -1, 0) for a in arrays]
        return module.program(Arrays, *columns, p, module.constants(Arrays, p))


@functools.lru_cache(maxsize=64)
def prepared(constants, p):
    """Work that depends on the parameters only, done once for each parameter set."""
    return constants(Floats, np.frombuffer(p).tolist())


def checked(name, value, size):
    array = np.asarray(value, dtype=float)
    if array.ndim == 0 or array.shape[-1] != size:
        raise ValueError(f"{name} has shape {array.shape}: (..., {size}) is expected")
    return array


def stacked(entries, lead, shape):
    result = np.empty((*lead, math.prod(shape)))
    for k, entry in enumerate(entries):
        result[..., k] = entry
    return result.reshape((*lead, *shape))
