"""A program as the text of a MATLAB function: elementwise operators, so that a column of its arrays is a state."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import ClassVar

from symoro_elastic.codegen.body import Dialect, Writer
from symoro_elastic.codegen.c.calls import CalledArray
from symoro_elastic.codegen.local_names import with_local_names, with_own_results
from symoro_elastic.codegen.package import Argument, Function, Package, Result
from symoro_elastic.codegen.package_context import SINGULAR, count_text
from symoro_elastic.codegen.printers import ATOM, OPERATORS, Printer, Rule, Text, product, quotient
from symoro_elastic.codegen.target import words
from symoro_elastic.symbolic.operations import DIVIDE, MAXIMUM, MINIMUM, MULTIPLY, SQRT
from symoro_elastic.symbolic.program import Program, Statement, rename_variables

LONGEST_NAME = 63
KEYWORDS = words(
    """
    arguments break case catch classdef continue do else elseif end end_try_catch end_unwind_protect endarguments
    endclassdef endenumeration endevents endfor endfunction endif endmethods endparfor endproperties endspmd endswitch
    endwhile enumeration events for function global if methods otherwise parfor persistent properties return spmd switch
    try until unwind_protect unwind_protect_cleanup while
    """
)
"""Keywords of MATLAB and GNU Octave."""
CONSTANTS = words("ans e eps i I inf Inf j J NA nan NaN pi Inf true false")
"""Names of constants in both."""
OWN = words(
    """
    atan2 checked cos error isnan max maximum min minimum nargin p permute real_sqrt reshape sign sin sqrt states zeros
    """
)
"""Functions that are called, and identifiers of the templates."""
LISTS = ("frames", "solutions", "loops")
"""Axes along which results have a page or a column: the first axis of the quantity's shape, here the last."""


def _join_lines(head: str, parts: list[str]) -> str:
    return " ...\n        ".join([head + parts[0], *parts[1:]])


EXTREMA = (MINIMUM, MAXIMUM)
"""Functions of extrema, which ignore NaN in MATLAB."""
MATLAB = Dialect("", ";", lambda text: f"% {text}", _join_lines, {SQRT: "real_sqrt"})


def _product(flipped: bool, first: Text, second: Text) -> Text:
    return product(flipped, first, second, "*" if _is_literal(first) or _is_literal(second) else ".*")


def _quotient(flipped: bool, first: Text, second: Text) -> Text:
    return quotient(flipped, first, second, "/" if _is_literal(second) else "./")


def _is_literal(text: Text) -> bool:
    return text.binding == ATOM and text.text[0].isdigit()


class MatlabPrinter(Printer):
    """Prints expressions with elementwise MATLAB operators; operators with a literal need no dot."""

    operators: ClassVar[Mapping[str, Rule]] = {**OPERATORS, MULTIPLY: _product, DIVIDE: _quotient}


@dataclass(frozen=True)
class MatlabFunction:
    """Template data of a MATLAB function."""

    name: str
    title: str
    equations: str
    arguments: tuple[MatlabArray, ...]
    results: tuple[MatlabArray, ...]
    described: tuple[str, ...]
    body: str
    called: set[str]

    @property
    def left(self) -> str:
        """The results as the left-hand side of a call."""
        names = [result.name for result in self.results]
        return names[0] if len(names) == 1 else f"[{', '.join(names)}]"

    @property
    def given(self) -> str:
        """The arguments before p, as the argument list of a call."""
        return ", ".join(argument.name for argument in self.arguments)


def matlab_name(name: str) -> str:
    """Return the name of the package: that of the machine, unless MATLAB reserves it."""
    return f"{name}_" if name in KEYWORDS | CONSTANTS else name


def with_matlab_names(package: Package) -> Package:
    """Return the package with valid local names of MATLAB: no keywords, at most 63 characters."""
    package = with_local_names(with_own_results(package), OWN | KEYWORDS | CONSTANTS | {matlab_name(package.name)})
    used = {p.symbol for p in package.parameters}
    long = {name: _shorten(name, used) for name in sorted(used) if len(name) > LONGEST_NAME}
    return replace(
        package,
        parameters=tuple(replace(p, local=long.get(p.symbol, p.symbol)) for p in package.parameters),
        functions=tuple(replace(f, program=_with_short_names(f.program, long)) for f in package.functions),
    )


def _with_short_names(program: Program, names: Mapping[str, str]) -> Program:
    """The program with names within MATLAB's length; `names` are those of parameters."""
    symbols = {symbol for argument in program.inputs for symbol in argument.symbols}
    used = {*symbols, *names.values(), *program.used, *(s.name for s in (*program.once, *program.statements))}
    short = partial(_shorten, used=used)
    long = {**names, **{name: short(name) for name in sorted(symbols) if len(name) > LONGEST_NAME}}

    def of(statements: tuple[Statement, ...]) -> tuple[Statement, ...]:
        return tuple(s._replace(name=short(s.name)) if len(s.name) > LONGEST_NAME else s for s in statements)

    program = rename_variables(program, long) if long else program
    return replace(program, once=of(program.once), statements=of(program.statements))


def _shorten(name: str, used: set[str]) -> str:
    """A shortened name, ending with a number; it is added to the `used` names."""
    number = 1
    while (short := f"{name[: LONGEST_NAME - 8].rstrip('_')}_{number}") in used:
        number += 1
    used.add(short)
    return short


def matlab_function(package: Package, function: Function) -> MatlabFunction:
    """Return the template data of a function with MATLAB names."""
    program = function.program
    printer = MatlabPrinter(program, functions=MATLAB.functions)
    arguments, results = tuple(map(of_argument, function.arguments)), tuple(map(of_result, function.results))
    writer = Writer(printer, MATLAB, package.joint_names)
    lines = [*writer.statements(program.once), *writer.statements(program.statements)]
    lines += ["", "    % Results."]
    for result, output in zip(results, program.outputs, strict=True):
        lines += _result(result, [printer.value(x) for x in output.entries])
    entries = {x.name: x.symbols for x in program.inputs} | {"p": tuple(p.symbol for p in package.parameters)}
    matrices = [a for a in arguments if a.columns is not None]
    columns = [f"    {a.name} = reshape(permute({a.name}, [2 1 3]), {a.entries}, []);" for a in matrices]  # row by row
    read = [line for name, symbols in entries.items() for line in _read(name, symbols, printer.referenced)]
    return MatlabFunction(
        name=function.name,
        title=function.title[:1].upper() + function.title[1:],
        equations=function.equations,
        arguments=arguments,
        results=results,
        described=tuple(_remarks(function)),
        body="\n".join([*columns, *read, *lines]),
        called={name for name in (*MATLAB.functions.values(), *EXTREMA) if any(f"{name}(" in line for line in lines)},
    )


def _read(array: str, symbols: Sequence[str], used: set[str]) -> Iterator[str]:
    """Lines that assign the entries of an array to their names."""
    for k, symbol in enumerate(symbols):
        if symbol in used:
            yield f"    {symbol} = {array}({k + 1}, :);"


def _result(result: MatlabArray, values: Sequence[str]) -> Iterator[str]:
    """Lines that store the entries of a result."""
    yield f"    {result.name} = zeros({', '.join(map(str, result.dims))}, states);"
    for k, value in enumerate(values):
        if value != "0.0":
            yield f"    {result.name}({result.subscripts(k)}, :) = {value};"


def _remarks(function: Function) -> Iterator[str]:
    """Lines of further remarks on a function."""
    if function.divides:
        yield f"{SINGULAR[:1].upper()}{SINGULAR[1:]}."
    for result in function.results:
        if result.rows and not result.whole:
            yield f"Entries of {result.name}: {', '.join(result.rows)}."
        if result.columns:
            array = of_result(result)
            axis = "Columns" if array.columns is not None else "Rows" if array.pages is not None else "Entries"
            yield f"{axis} of {result.name}: {', '.join(result.columns)}."
    counts = f"{count_text(function.program.count)} a state"
    if function.program.once:
        counts += f"; {count_text(function.program.count_once)} for each parameter set"
    yield f"{counts}."


@dataclass(frozen=True)
class MatlabArray:
    """A MATLAB array for one state; `columns` and `pages` are None if it has no such dimension.

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
        """Lengths of the dimensions."""
        return self.rows, *(length for length in (self.columns, self.pages) if length is not None)

    @property
    def entries(self) -> int:
        """Number of entries."""
        return math.prod(self.dims)

    @property
    def size(self) -> str:
        """Size for one state as text: `4 x 4 x 3`, `12 x 1`."""
        dims = self.dims if len(self.dims) > 1 else (*self.dims, 1)
        return " x ".join(map(str, dims))

    @property
    def sizes(self) -> str:
        """Size for N states as text: `4 x 4 x 3 x N`."""
        return " x ".join(map(str, (*self.dims, "N")))

    @property
    def shape(self) -> str:
        """MATLAB source of the size vector: `12`, `[4 4]`."""
        return str(self.dims[0]) if len(self.dims) == 1 else f"[{' '.join(map(str, self.dims))}]"

    @property
    def transposition(self) -> tuple[int, int, int]:
        """Pages, rows and columns for the conversion from row-major to column-major order."""
        pages, columns = (1 if length is None else length for length in (self.pages, self.columns))
        return (pages, self.rows, columns) if not self.by_columns else (1, self.rows * columns, 1)

    def subscripts(self, k: int) -> str:
        """Subscripts of the entry k of the array stored row by row."""
        _, rows, columns = self.transposition
        page, row, column = k // (rows * columns), k // columns % rows, k % columns
        axes = ((row, self.rows), (column, self.columns), (page, self.pages))
        return ", ".join(str(index + 1) for index, length in axes if length is not None)


def of_argument(argument: Argument) -> MatlabArray:
    """Return the MATLAB array of an argument: a column, or an equivalent square matrix."""
    rows = argument.quantity.rows
    if rows and rows * rows == argument.size:
        return MatlabArray(argument.name, _meaning(argument), rows, rows)
    return MatlabArray(argument.name, _meaning(argument), argument.size)


def of_result(result: Result) -> MatlabArray:
    """Return the MATLAB array of a result; the frames of a result become its last dimension."""
    shape, name, meaning = result.shape, result.name, _meaning(result)
    if len(shape) == 1:
        return MatlabArray(name, meaning, shape[0])
    if result.quantity.axes[0] not in LISTS:
        rows, columns = shape
        return MatlabArray(name, meaning, rows, columns)
    pages, rows = shape[:2]
    return MatlabArray(name, meaning, rows, shape[2] if len(shape) > 2 else None, pages)


def of_step(array: CalledArray) -> MatlabArray:
    """Return the MATLAB array of a step's argument or result: one column per node, or a matrix."""
    if array.matrix:
        return MatlabArray(array.name, "", array.matrix[0], array.matrix[1])
    if len(array.shape) < 2:
        return MatlabArray(array.name, "", array.entries)
    nodes, motors = array.shape
    return MatlabArray(array.name, "", motors, nodes, by_columns=True)


def _meaning(array: Argument | Result) -> str:
    """Meaning of an array as text, without the remark on its storage row by row."""
    return array.meaning.replace(", row by row", "")
