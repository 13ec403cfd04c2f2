"""The steps of a program, noted while its lines run on quantities instead of floats."""

import numpy as np


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
