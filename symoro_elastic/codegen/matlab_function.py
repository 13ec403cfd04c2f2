"""A program as the text of a MATLAB function: elementwise operators, so that a column of its arrays is a state."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import ClassVar

from symoro_elastic.codegen.body import Dialect, Writer
from symoro_elastic.codegen.local_names import with_local_names, with_own_results
from symoro_elastic.codegen.matlab_arrays import MatlabArray, of_argument, of_result
from symoro_elastic.codegen.package import Function, Package
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
"""Of MATLAB and GNU Octave."""
CONSTANTS = words("ans e eps i I inf Inf j J NA nan NaN pi Inf true false")
"""Names that both give a value."""
OWN = words(
    """
    atan2 checked cos error isnan max maximum min minimum nargin p permute real_sqrt reshape sign sin sqrt states zeros
    """
)
"""Functions that are called, and identifiers of the templates."""


def _continued(head: str, parts: list[str]) -> str:
    return " ...\n        ".join([head + parts[0], *parts[1:]])


EXTREMA = (MINIMUM, MAXIMUM)
"""Those of MATLAB leave out NaN."""
MATLAB = Dialect("", ";", lambda text: f"% {text}", _continued, {SQRT: "real_sqrt"})


def _product(flipped: bool, first: Text, second: Text) -> Text:
    return product(flipped, first, second, "*" if _is_literal(first) or _is_literal(second) else ".*")


def _quotient(flipped: bool, first: Text, second: Text) -> Text:
    return quotient(flipped, first, second, "/" if _is_literal(second) else "./")


def _is_literal(text: Text) -> bool:
    return text.binding == ATOM and text.text[0].isdigit()


class MatlabPrinter(Printer):
    """Operators that are elementwise; those with a literal need no dot."""

    operators: ClassVar[Mapping[str, Rule]] = {**OPERATORS, MULTIPLY: _product, DIVIDE: _quotient}


@dataclass(frozen=True)
class MatlabFunction:
    """What the template of a function is given."""

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
        """The results, as they stand on the left of a call."""
        names = [result.name for result in self.results]
        return names[0] if len(names) == 1 else f"[{', '.join(names)}]"

    @property
    def given(self) -> str:
        """The arguments before p, in the brackets of a call."""
        return ", ".join(argument.name for argument in self.arguments)


def matlab_name(name: str) -> str:
    """Return the name of the package of functions: that of the machine, unless MATLAB uses it."""
    return f"{name}_" if name in KEYWORDS | CONSTANTS else name


def with_matlab_names(package: Package) -> Package:
    """Return the package with local names that MATLAB takes: no keywords, at most 63 characters."""
    package = with_local_names(with_own_results(package), OWN | KEYWORDS | CONSTANTS | {matlab_name(package.name)})
    taken = {p.symbol for p in package.parameters}
    long = {name: _shortened(name, taken) for name in sorted(taken) if len(name) > LONGEST_NAME}
    return replace(
        package,
        parameters=tuple(replace(p, local=long.get(p.symbol, p.symbol)) for p in package.parameters),
        functions=tuple(replace(f, program=_with_short_names(f.program, long)) for f in package.functions),
    )


def _with_short_names(program: Program, names: Mapping[str, str]) -> Program:
    """The program with other names for what is longer than MATLAB tells apart; `names` are those of parameters."""
    symbols = {symbol for one in program.inputs for symbol in one.symbols}
    taken = {*symbols, *names.values(), *program.used, *(s.name for s in (*program.once, *program.statements))}
    short = partial(_shortened, taken=taken)
    long = {**names, **{name: short(name) for name in sorted(symbols) if len(name) > LONGEST_NAME}}

    def of(statements: tuple[Statement, ...]) -> tuple[Statement, ...]:
        return tuple(s._replace(name=short(s.name)) if len(s.name) > LONGEST_NAME else s for s in statements)

    program = rename_variables(program, long) if long else program
    return replace(program, once=of(program.once), statements=of(program.statements))


def _shortened(name: str, taken: set[str]) -> str:
    """The beginning of a name and a number, added to those that are taken."""
    number = 1
    while (found := f"{name[: LONGEST_NAME - 8].rstrip('_')}_{number}") in taken:
        number += 1
    taken.add(found)
    return found


def matlab_function(package: Package, function: Function) -> MatlabFunction:
    """Return a function of a package whose names MATLAB takes."""
    program = function.program
    printer = MatlabPrinter(program, functions=MATLAB.functions)
    arguments, results = tuple(map(of_argument, function.arguments)), tuple(map(of_result, function.results))
    writer = Writer(printer, MATLAB, package.joint_names)
    lines = [*writer.statements(program.once), *writer.statements(program.statements)]
    lines += ["", "    % Results."]
    for result, output in zip(results, program.outputs, strict=True):
        lines += _result(result, [printer.value(x) for x in output.entries])
    entries = {one.name: one.symbols for one in program.inputs} | {"p": tuple(p.symbol for p in package.parameters)}
    read = [line for name, symbols in entries.items() for line in _read(name, symbols, printer.referenced)]
    return MatlabFunction(
        name=function.name,
        title=function.title[:1].upper() + function.title[1:],
        equations=function.equations,
        arguments=arguments,
        results=results,
        described=tuple(_described(function)),
        body="\n".join([*(_by_rows(one) for one in arguments if one.columns is not None), *read, *lines]),
        called={name for name in (*MATLAB.functions.values(), *EXTREMA) if any(f"{name}(" in line for line in lines)},
    )


def _by_rows(argument: MatlabArray) -> str:
    """The line that makes a column of a matrix, row by row."""
    return f"    {argument.name} = reshape(permute({argument.name}, [2 1 3]), {argument.entries}, []);"


def _read(array: str, symbols: Sequence[str], used: set[str]) -> Iterator[str]:
    """Lines that give the entries of an array their names."""
    for k, symbol in enumerate(symbols):
        if symbol in used:
            yield f"    {symbol} = {array}({k + 1}, :);"


def _result(result: MatlabArray, values: Sequence[str]) -> Iterator[str]:
    """Lines that put the entries of a result into their places."""
    yield f"    {result.name} = zeros({', '.join(map(str, result.dims))}, states);"
    for k, value in enumerate(values):
        if value != "0.0":
            yield f"    {result.name}({result.subscripts(k)}, :) = {value};"


def _described(function: Function) -> Iterator[str]:
    """What else there is to know of a function, in lines."""
    if function.divides:
        yield f"{SINGULAR[:1].upper()}{SINGULAR[1:]}."
    for result in function.results:
        if result.rows and not result.whole:
            yield f"Entries of {result.name}: {', '.join(result.rows)}."
        if result.columns:
            held = of_result(result)
            axis = "Columns" if held.columns is not None else "Rows" if held.pages is not None else "Entries"
            yield f"{axis} of {result.name}: {', '.join(result.columns)}."
    counts = f"{count_text(function.program.count)} a state"
    if function.program.once:
        counts += f"; {count_text(function.program.count_once)} for each parameter set"
    yield f"{counts}."
