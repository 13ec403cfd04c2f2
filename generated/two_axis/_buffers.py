"""Programs on many states: the steps noted of a program, carried out on buffers.

A step is one numpy operation on a block of states. Its result goes to a buffer that no later
step reads any more, so that a block stays in the processor's cache. Calls of one shape use the
same buffers, one after the other; calls at the same time have buffers of their own.
"""

import math

import numpy as np

from . import _notes

ALIGNMENT = 64  # bytes
SHORTEST, LONGEST, CACHE = 2**11, 2**14, 2**21  # bytes: a buffer at least, at most; all buffers, where they can
KEPT = 2**23  # bytes: as many buffers at most are kept for the next call
KINDS = 4  # kinds of block at most that are kept


class Steps:
    """The steps of a program on registers: the entries of its arguments, its literals, then buffers."""

    def __init__(self, program, sizes):
        notes = _notes.Notes()
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
