"""Programs on many states: the steps noted of a program, carried out on buffers.

A step is one numpy operation on a block of states. Its result goes to a buffer that no later
step reads any more, so that a block stays in the processor's cache.
"""

import math

import numpy as np

from . import _notes

ALIGNMENT = 64  # bytes
SHORTEST, LONGEST, CACHE = 2**11, 2**14, 2**21  # bytes: a buffer at least, at most; all buffers, where they can


class Steps:
    """The steps of a program on registers: the entries of its arguments, its literals, then buffers."""

    def __init__(self, program, sizes):
        notes = _notes.Notes()
        arguments = [[notes.new() for _ in range(size)] for size in sizes]
        results = [[notes.number(x) for x in entries] for entries in program(notes, *arguments)]
        self.literals = [*notes.literals.values()]
        fixed = [*range(sum(sizes)), *notes.literals]
        register = {number: k for k, number in enumerate(fixed)}
        self.buffers = add_buffers(register, notes.steps, {x for entries in results for x in entries})
        self.steps = [(f, *(register[x] for x in numbers)) for f, *numbers in notes.steps]
        self.results = [[register[x] for x in entries] for entries in results]

    def carry_out(self, arguments, lead, dtype):
        """Each result as an array of a row for each state of a stack with the leading axes `lead`."""
        count = math.prod(lead)
        length = self.block(count, dtype)
        fixed = [np.array(x, dtype) for x in self.literals]
        stacks = [Stack(x, lead, length, dtype) for x in arguments]
        registers = [r for s in stacks for r in s.registers] + fixed + [*aligned(self.buffers, length, dtype)]
        results = [np.empty((count, len(entries)), dtype) for entries in self.results]
        for start in range(0, count, length):
            block = slice(start, min(start + length, count))
            if block.stop - start < length:
                registers = [r[: block.stop - start] if r.ndim else r for r in registers]
            for stack in stacks:
                stack.load(block)
            for operation, first, second, result in self.steps:
                operation(registers[first], registers[second], registers[result])
            for result, entries in zip(results, self.results):
                for k, register in enumerate(entries):
                    result[block, k] = registers[register]
        return results

    def block(self, count, dtype):
        """States in a block: blocks of almost equal length."""
        size = max(SHORTEST, min(LONGEST, CACHE // max(1, self.buffers)))
        blocks = math.ceil(count * dtype.itemsize / size)
        return math.ceil(count / blocks) if blocks else 1


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


def aligned(rows, length, dtype):
    """Buffers that begin where lines of the processor's cache do."""
    line = ALIGNMENT // dtype.itemsize
    stride = -(-length // line) * line
    memory = np.empty(rows * stride + line, dtype)
    start = -memory.ctypes.data % ALIGNMENT // dtype.itemsize
    return memory[start : start + rows * stride].reshape(rows, stride)[:, :length]


class Stack:
    """An argument of a stack of states: numbers where all states share it, else a row of a buffer for each entry."""

    def __init__(self, array, lead, length, dtype):
        *own, size = array.shape
        self.rows = array.reshape(math.prod(own), size)
        self.shared = len(self.rows) == 1
        self.numbers = None
        if self.shared:
            self.registers = [np.array(x, dtype) for x in self.rows[0]]
            return
        if own != [*lead]:
            self.numbers = np.broadcast_to(np.arange(len(self.rows)).reshape(own), lead).reshape(-1)
        self.buffer = aligned(size, length, dtype)
        self.registers = [*self.buffer]

    def load(self, block):
        """Fill the buffers with a block of states."""
        if not self.shared:
            rows = self.rows[block if self.numbers is None else self.numbers[block]]
            self.buffer[:, : len(rows)] = rows.T
