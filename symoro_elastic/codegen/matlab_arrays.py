"""Arrays of functions as MATLAB holds them: vectors as columns, matrices as matrices, frames last."""

from __future__ import annotations

import math
from dataclasses import dataclass

from symoro_elastic.codegen.package import Argument, Result

LISTS = ("frames", "solutions", "loops")
"""What results have a page or a column for each of: the first axis in the shape of the quantity, the last here."""


@dataclass(frozen=True)
class MatlabArray:
    """An array of one state; `columns` and `pages` are None where it has no such axis.

    Other languages store it row by row, or `by_columns` as MATLAB does.
    """

    name: str
    meaning: str
    rows: int
    columns: int | None = None
    pages: int | None = None
    by_columns: bool = False

    @property
    def dims(self) -> tuple[int, ...]:
        """The lengths of its axes."""
        return self.rows, *(length for length in (self.columns, self.pages) if length is not None)

    @property
    def entries(self) -> int:
        """Their product."""
        return math.prod(self.dims)

    @property
    def size(self) -> str:
        """The axes of one state in words: `4 x 4 x 3`, `12 x 1`."""
        dims = self.dims if len(self.dims) > 1 else (*self.dims, 1)
        return " x ".join(map(str, dims))

    @property
    def sizes(self) -> str:
        """The axes of N states in words: `4 x 4 x 3 x N`."""
        return " x ".join(map(str, (*self.dims, "N")))

    @property
    def shape(self) -> str:
        """Source of the row of the axes: `12`, `[4 4]`."""
        return row_of_numbers(self.dims)

    @property
    def transposition(self) -> tuple[int, int, int]:
        """Pages, rows and columns, to be turned from row by row to column by column."""
        pages, columns = (1 if length is None else length for length in (self.pages, self.columns))
        return (pages, self.rows, columns) if not self.by_columns else (1, self.rows * columns, 1)

    def subscripts(self, k: int) -> str:
        """Subscripts of the entry k of the array stored row by row."""
        _, rows, columns = self.transposition
        page, row, column = k // (rows * columns), k // columns % rows, k % columns
        axes = ((row, self.rows), (column, self.columns), (page, self.pages))
        return ", ".join(str(index + 1) for index, length in axes if length is not None)


def of_argument(argument: Argument) -> MatlabArray:
    """Return an argument: a column, or the matrix that may be given in its place."""
    rows = argument.quantity.rows
    if rows and rows * rows == argument.size:
        return MatlabArray(argument.name, _meaning(argument), rows, rows)
    return MatlabArray(argument.name, _meaning(argument), argument.size)


def of_result(result: Result) -> MatlabArray:
    """Return a result; rows that belong to frames become its last axis."""
    shape, name, meaning = result.shape, result.name, _meaning(result)
    if len(shape) == 1:
        return MatlabArray(name, meaning, shape[0])
    if result.quantity.axes[0] not in LISTS:
        rows, columns = shape
        return MatlabArray(name, meaning, rows, columns)
    pages, rows = shape[:2]
    return MatlabArray(name, meaning, rows, shape[2] if len(shape) > 2 else None, pages)


def _meaning(array: Argument | Result) -> str:
    """What an array is, in words that hold where it is a matrix and no row of numbers."""
    return array.meaning.replace(", row by row", "")


def row_of_numbers(numbers: tuple[int, ...]) -> str:
    """Source of a row of numbers."""
    return str(numbers[0]) if len(numbers) == 1 else f"[{' '.join(map(str, numbers))}]"
