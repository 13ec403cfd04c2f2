"""Models as functions of SymPy expressions."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from numbers import Rational
from types import ModuleType
from typing import Any

import sympy

from symoro_elastic.codegen.backends.numpy_programs import Model, models_of, one_or_all
from symoro_elastic.codegen.closed_form import Conversion, affordable, written_forms
from symoro_elastic.codegen.package import Package
from symoro_elastic.codegen.real_numbers import refuse_no_numbers
from symoro_elastic.symbolic.expression import Expression, Operand
from symoro_elastic.symbolic.operations import SYMBOL
from symoro_elastic.symbolic.program import Output, Program


def expressions(package: Package, module: ModuleType) -> dict[str, ExpressionFunction]:
    """Return the models as functions of SymPy expressions."""
    parameters = tuple(parameter.symbol for parameter in package.parameters)
    return {model.name: ExpressionFunction(model, parameters) for model in models_of(package, module)}


class ExpressionFunction:
    """A model as a function of SymPy expressions; omitted arguments are symbols.

    Symbols have the names of the machine's variables and parameters, rates and the like those of generated code:
    `symbols` gives them by argument. Numbers of the machine's file are exact. Results are matrices, vectors as columns;
    matrices of a stack are arrays. Short results are written out; others are nested as the recursions leave them, and
    grow without measure where they are expanded: `cse()` gives the lines that they are computed by.
    """

    def __init__(self, model: Model, parameters: tuple[str, ...]) -> None:
        self.model = model
        names = {argument.name: argument.symbols for argument in model.function.program.inputs} | {"p": parameters}
        self.symbols = {name: tuple(map(sympy.Symbol, entries)) for name, entries in names.items()}
        self.__name__, self.__doc__ = model.name, model.on_numpy.__doc__
        arguments = model.signature.parameters.values()
        self.__signature__ = model.signature.replace(parameters=[x.replace(default=None) for x in arguments])

    @property
    def program(self) -> Program:
        """The program of the model."""
        return self.model.function.program

    def __call__(self, *given: Any, **named: Any) -> Any:
        """Return results for expressions; omitted arguments are symbols."""
        bound = self.__signature__.bind(*given, **named)
        values = {
            symbol: x
            for name, value in bound.arguments.items()
            if value is not None
            for symbol, x in zip(self.symbols[name], self._entries(name, value), strict=True)
        }
        convert = self._conversion(values)
        outputs = self.program.outputs
        return one_or_all(
            [_array(output, [self._entry(convert, values, x) for x in output.entries]) for output in outputs]
        )

    def cse(self) -> tuple[list[tuple[Any, Any]], list[Any]]:
        """Return the generated code in the form of `sympy.cse`: assignments (symbol, expression), and results."""
        statements = (*self.program.once, *self.program.statements)
        assigned = {statement.node.id: statement for statement in statements}
        convert, lines = Conversion(sympy), {}
        for node in self.program.nodes:
            x = convert.node(node)
            if statement := assigned.get(node.id):
                symbol, sign = sympy.Symbol(statement.name), -1 if statement.negative else 1
                lines[statement.name] = (symbol, sign * x)
                x = sign * symbol
            convert.found[node.id] = x
        results = [_array(x, [_expression_of(convert, entry) for entry in x.entries]) for x in self.program.outputs]
        return [lines[statement.name] for statement in statements], results

    def _entries(self, name: str, value: Any) -> list[Any]:
        """Return the entries of an argument, a matrix row by row; raises `ValueError` for another size."""
        refuse_no_numbers(value)
        entries = sympy.flatten(value.tolist() if hasattr(value, "tolist") else value)
        if len(entries) != len(self.symbols[name]):
            raise ValueError(f"{name} has {len(entries)} entries: {len(self.symbols[name])} are expected")
        return [_expression(name, x) for x in entries]

    def _conversion(self, values: dict[Any, Any]) -> Conversion:
        """Return the conversion of all nodes to SymPy expressions, with `values` for symbols."""
        convert = Conversion(sympy)
        for node in self.program.nodes:
            x = convert.node(node)
            convert.found[node.id] = values.get(x, x) if node.operation == SYMBOL else x
        return convert

    def _entry(self, convert: Conversion, values: dict[Any, Any], x: Operand) -> Any:
        """Return an entry of a result as a SymPy expression, expanded to symbols if that is short."""
        if isinstance(x, Expression) and x.id in self._written_out:
            return self._written_out[x.id].xreplace(values)
        return _expression_of(convert, x)

    @cached_property
    def _written_out(self) -> dict[int, Any]:
        """The short entries of results as expressions of symbols, by expression number."""
        entries = [x for output in self.program.outputs for x in output.entries if isinstance(x, Expression)]
        wanted, convert = affordable(dict.fromkeys(entries)), Conversion(sympy)
        return {x.id: min(written_forms(sympy, convert(x)), key=sympy.count_ops) for x in wanted}


def _expression(name: str, x: Any) -> Any:
    """Return an entry of an argument as an expression; raises `TypeError` for text and the like."""
    if isinstance(x, sympy.Expr):
        return x
    if isinstance(x, Rational):
        return sympy.Rational(int(x.numerator), int(x.denominator))
    if isinstance(x, float):
        return sympy.Float(x)
    raise TypeError(f"{name}: {x!r} is neither an expression nor a number")


def _expression_of(convert: Conversion, x: Operand) -> Any:
    return convert.found[x.id] if isinstance(x, Expression) else convert(x)


def _array(output: Output, entries: Sequence[Any]) -> Any:
    """Return a result as a column, a matrix, or an array of matrices."""
    if len(output.shape) > 2:
        return sympy.ImmutableDenseNDimArray(entries, output.shape)
    return sympy.Matrix(*(*output.shape, 1)[:2], entries)
