"""How programs are called: shapes are checked, few states run one by one on floats, many on buffers."""

import functools
import math

import numpy as np

from . import _buffers

FEW = 20  # states that take less time one by one
MATRICES = {"T": 4, "R0": 3}
DOUBLE, SINGLE = np.dtype(np.float64), np.dtype(np.float32)


class Floats:
    sin, cos, sqrt, atan2 = math.sin, math.cos, math.sqrt, math.atan2

    @staticmethod
    def sign(x):
        return 1.0 if x > 0 else -1.0 if x < 0 else x


def by_row(name, x):
    """A placement T or a rotation R0, which may be given as a matrix, row by row."""
    n = MATRICES.get(name)
    return x.reshape((*x.shape[:-2], n * n)) if n and x.shape[-2:] == (n, n) else x


class Model:
    """A program, the sizes of its arguments by name, the number of parameters, the shapes of its results."""

    def __init__(self, constants, program, arguments, parameters, results):
        self.constants, self.program = constants, program
        self.sizes = arguments | {"p": parameters}
        self.single_state = [(size,) for size in self.sizes.values()]
        self.shapes = results

    def __call__(self, *states, p):
        """Results for states and parameter sets, which may be stacked along leading axes and broadcast."""
        arrays = [x if type(x) is np.ndarray and x.dtype is DOUBLE else as_numbers(x) for x in states]
        p = np.asarray(p, dtype=DOUBLE)
        if [*[x.shape for x in arrays], p.shape] != self.single_state:
            return self.stack(arrays, p)
        try:
            entries = self.on_floats([x.tolist() for x in arrays], p.tobytes())
        except (ArithmeticError, ValueError):
            return self.stack(arrays, p)
        dtype = precision(arrays)
        return unpacked([np.array(x, dtype).reshape(shape) for x, shape in zip(entries, self.shapes)])

    def on_floats(self, state, p):
        return self.program(Floats, *state, prepared(self.constants, p))

    def stack(self, arrays, p):
        arrays = [by_row(name, x) for name, x in zip(self.sizes, arrays)]
        for (name, size), x in zip(self.sizes.items(), [*arrays, p]):
            if x.shape[-1:] != (size,):
                raise ValueError(f"{name} has shape {x.shape}: (..., {size}) is expected")
        lead = np.broadcast_shapes(*(x.shape[:-1] for x in [*arrays, p]))
        few = 0 < math.prod(lead) <= FEW
        results = self.one_by_one(arrays, p, lead) if few else None
        if results is None:
            results = self.on_buffers(arrays, p, lead)
        dtype = precision(arrays)
        return unpacked([np.asarray(x, dtype).reshape((*lead, *shape)) for x, shape in zip(results, self.shapes)])

    def one_by_one(self, arrays, p, lead):
        """Results by state; None where plain floats have none: the square root of -1, a division by 0."""
        *states, sets = (spread(x, lead) for x in [*arrays, p])
        rows = zip(*(x.tolist() for x in states), (x.tobytes() for x in sets))
        try:
            return [*zip(*(self.on_floats(state, p) for *state, p in rows))]
        except (ArithmeticError, ValueError):
            return None

    def on_buffers(self, arrays, p, lead):
        with np.errstate(all="ignore"):
            return self.steps.carry_out([*arrays, self.constants_of(p)], lead, precision(arrays))

    def constants_of(self, p):
        """What the program needs of parameter sets; on buffers where there are many, or floats have no result."""
        if p.ndim == 1:
            try:
                return np.array(prepared(self.constants, p.tobytes()), DOUBLE)
            except (ArithmeticError, ValueError):
                pass
        (constants,) = self.steps_once.carry_out([p], p.shape[:-1], DOUBLE)
        return constants.reshape((*p.shape[:-1], constants.shape[-1]))

    @functools.cached_property
    def steps_once(self):
        return _buffers.Steps(lambda functions, p: [self.constants(functions, p)], [self.sizes["p"]])

    @functools.cached_property
    def steps(self):
        sizes = [*self.sizes.values()][:-1]
        return _buffers.Steps(self.program, [*sizes, len(self.steps_once.results[0])])


@functools.lru_cache(maxsize=64)
def prepared(constants, p):
    """Work that depends on the parameters only, done once for each parameter set."""
    return constants(Floats, np.frombuffer(p).tolist())


def as_numbers(value):
    array = np.asarray(value)
    return np.asarray(array, dtype=SINGLE if array.dtype == SINGLE else DOUBLE)


def precision(arrays):
    for x in arrays:
        if x.dtype != SINGLE:
            return DOUBLE
    return SINGLE if arrays else DOUBLE


def spread(array, lead):
    return np.broadcast_to(array, (*lead, array.shape[-1])).reshape(math.prod(lead), array.shape[-1])


def unpacked(results):
    return results[0] if len(results) == 1 else tuple(results)
