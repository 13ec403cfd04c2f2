"""How generated programs are called: shapes are checked, few states run one by one on floats, many on buffers.

For many states the steps of a program are noted once, while its lines run on quantities instead
of floats. A step is one numpy operation on a block of states. Its result goes to a buffer that no
later step reads any more, so that a block stays in the processor's cache. Calls of one shape use
the same buffers, one after the other; calls at the same time have buffers of their own.
"""

import functools
import math

import numpy as np

_DIGEST = 354700140  # of the files of this package: those of another run are not imported

FEW = 20  # states that take less time one by one
MATRICES = {"T": 4, "R0": 3}
DOUBLE, SINGLE = np.dtype(np.float64), np.dtype(np.float32)
ALIGNMENT = 64  # bytes
SHORTEST, LONGEST, CACHE = 2**11, 2**14, 2**21  # bytes: a buffer at least, at most; all buffers, where they can
KEPT = 2**23  # bytes: as many buffers at most are kept for the next call
KINDS = 4  # kinds of block at most that are kept


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
        p = p if type(p) is np.ndarray and p.dtype is DOUBLE else np.asarray(real(p), dtype=DOUBLE)
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

    def trace(self, functions, *arguments, p):
        """Entries of each result from those of the arguments, on any numbers of which `functions` has sin, cos ..."""
        return self.program(functions, *arguments, self.constants(functions, p))

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
        return Steps(lambda functions, p: [self.constants(functions, p)], [self.sizes["p"]])

    @functools.cached_property
    def steps(self):
        sizes = [*self.sizes.values()][:-1]
        return Steps(self.program, [*sizes, len(self.steps_once.results[0])])


@functools.lru_cache(maxsize=64)
def prepared(constants, p):
    """Work that depends on the parameters only, done once for each parameter set."""
    return constants(Floats, np.frombuffer(p).tolist())


def real(value):
    array = np.asarray(value)
    if array.dtype.kind == "c":
        raise TypeError("arguments are real numbers, not complex ones")
    return array


def as_numbers(value):
    array = real(value)
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


def operator(operation):
    """An operator of two quantities, and its reflection."""
    return lambda a, b: a.notes.step(operation, a, b), lambda a, b: a.notes.step(operation, b, a)


def function(operation):
    """A function of one quantity; its step is called as those of two are."""

    def step(x, _, result):
        operation(x, result)

    return lambda notes, x: notes.step(step, x, x)


class Quantity:
    """A number of a program while its steps are noted."""

    def __init__(self, notes, number):
        self.notes, self.number = notes, number

    def __neg__(self):
        return self * -1.0

    __add__, __radd__ = operator(np.add)
    __sub__, __rsub__ = operator(np.subtract)
    __mul__, __rmul__ = operator(np.multiply)
    __truediv__, __rtruediv__ = operator(np.divide)


class Notes:
    """Steps (operation, numbers of two operands, number of the result); quantities are numbered as they come."""

    def __init__(self):
        self.count, self.literals, self.steps = 0, {}, []

    def new(self):
        self.count += 1
        return Quantity(self, self.count - 1)

    def number(self, x):
        if isinstance(x, Quantity):
            return x.number
        quantity = self.new()
        self.literals[quantity.number] = x
        return quantity.number

    def step(self, operation, first, second):
        operands = self.number(first), self.number(second)
        result = self.new()
        self.steps.append((operation, *operands, result.number))
        return result

    sin, cos, sqrt, sign = map(function, (np.sin, np.cos, np.sqrt, np.sign))

    def atan2(self, y, x):
        return self.step(np.arctan2, y, x)


class Steps:
    """The steps of a program on registers: the entries of its arguments, its literals, then buffers."""

    def __init__(self, program, sizes):
        notes = Notes()
        arguments = [[notes.new() for _ in range(size)] for size in sizes]
        results = [[notes.number(x) for x in entries] for entries in program(notes, *arguments)]
        self.sizes, self.literals = sizes, [*notes.literals.values()]
        fixed = [*range(sum(sizes)), *notes.literals]
        register = {number: k for k, number in enumerate(fixed)}
        self.buffers = add_buffers(register, notes.steps, {x for entries in results for x in entries})
        self.steps = [(f, *(register[x] for x in operands)) for f, *operands in notes.steps]
        self.results = [[register[x] for x in entries] for entries in results]
        self.kept = {}

    def carry_out(self, arguments, lead, dtype):
        """Each result as an array of a row for each state of a stack with the leading axes `lead`."""
        count = math.prod(lead)
        results = [np.empty((count, len(entries)), dtype) for entries in self.results]
        if not count:
            return results
        length = self.block_length(count, dtype)
        stacks = [Stack(x, lead) for x in arguments]
        idle = self.idle(length, dtype, *(stack.shared for stack in stacks))
        try:
            block = idle.pop()
        except IndexError:
            block = Block(self, length, dtype, [stack.shared for stack in stacks])
        for start in range(0, count, length):
            states = slice(min(start, count - length), min(start + length, count))  # the last block may overlap
            block.carry_out(stacks, states, results)
        if block.size <= KEPT:
            idle.append(block)
        return results

    def idle(self, *kind):
        """The blocks of a kind that no call uses now."""
        if len(self.kept) >= KINDS and kind not in self.kept:
            self.kept.clear()
        return self.kept.setdefault(kind, [])

    def block_length(self, count, dtype):
        """States in a block, where there are any: blocks of almost equal length."""
        size = max(SHORTEST, min(LONGEST, CACHE // max(1, self.buffers)))
        return math.ceil(count / math.ceil(count * dtype.itemsize / size))


def add_buffers(register, steps, results):
    """Give each step a buffer for its result, that of an operand if it is read for the last time; how many there are."""
    last = {number: k for k, (_, *operands, _) in enumerate(steps) for number in operands}
    fixed, buffers, free = len(register), 0, []
    for k, (_, *operands, result) in enumerate(steps):
        done = [x for x in dict.fromkeys(operands) if last[x] == k and x not in results]
        free += [register[x] for x in done if register[x] >= fixed]
        if not free:
            free.append(fixed + buffers)
            buffers += 1
        register[result] = free.pop()
    return buffers


class Block:
    """Steps on buffers of one length; arguments that all states share are numbers."""

    def __init__(self, steps, length, dtype, shared):
        self.arguments, registers = [], []
        for size, one in zip(steps.sizes, shared):
            self.arguments.append(np.empty(size, dtype) if one else aligned(size, length, dtype))
            registers += numbers(self.arguments[-1])
        buffers = aligned(steps.buffers, length, dtype)
        registers += [*numbers(np.array(steps.literals, dtype)), *buffers]
        self.steps = [(f, *(registers[x] for x in operands)) for f, *operands in steps.steps]
        self.results = [[registers[x] for x in entries] for entries in steps.results]
        self.size = buffers.nbytes

    def carry_out(self, stacks, states, results):
        for stack, argument in zip(stacks, self.arguments):
            argument[...] = stack.rows[0] if stack.shared else stack.of(states).T
        for operation, first, second, result in self.steps:
            operation(first, second, result)
        for result, entries in zip(results, self.results):
            for k, entry in enumerate(entries):
                result[states, k] = entry


def numbers(array):
    """The entries along the first axis, arrays without axes among them: operations take these faster than floats."""
    return [array[k, ...] for k in range(len(array))]


def aligned(rows, length, dtype):
    """Buffers that begin where lines of the processor's cache do."""
    line = ALIGNMENT // dtype.itemsize
    stride = -(-length // line) * line
    memory = np.empty(rows * stride + line, dtype)
    start = -memory.ctypes.data % ALIGNMENT // dtype.itemsize
    return memory[start : start + rows * stride].reshape(rows, stride)[:, :length]


class Stack:
    """An argument of a stack of states: a row for each state, or one that all share."""

    def __init__(self, array, lead):
        *own, size = array.shape
        self.rows = array.reshape(math.prod(own), size)
        self.shared = len(self.rows) == 1
        self.which = None
        if not self.shared and own != [*lead]:
            self.which = np.broadcast_to(np.arange(len(self.rows)).reshape(own), lead).reshape(-1)

    def of(self, states):
        """The rows of some states."""
        return self.rows[states if self.which is None else self.which[states]]
