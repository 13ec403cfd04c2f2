"""Short results written out in the joint variables, their rates, the torques and the parameters.

Expressions go to SymPy node by node. What expanding one would cost is counted beforehand, so long
ones are never tried. Of two forms, products of sines and cosines or sums of angles, the shorter
is shown, and only where it is short.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import reduce
from typing import Any

from symoro_elastic.codegen.latex import NAMED, Array, Equation, arrays, matrix, number, product
from symoro_elastic.codegen.notation import Notation
from symoro_elastic.codegen.package import Function, Package
from symoro_elastic.codegen.printers import ATOM, PRODUCT, SUM, Text
from symoro_elastic.foundation.scalar import Scalar
from symoro_elastic.symbolic import operations as op
from symoro_elastic.symbolic.arithmetic import library
from symoro_elastic.symbolic.expression import Expression, Operand, reachable
from symoro_elastic.symbolic.program import Output

MAX_OPERATIONS = 400
MAX_TERMS = 256
MAX_TERMS_IN_ALL = 768
MAX_LENGTH = 200


@dataclass(frozen=True)
class ClosedForm:
    """A SymPy expression and its LaTeX."""

    expression: Any
    latex: str


@dataclass(frozen=True)
class Size:
    """Size of an expanded expression: operations, terms above and below the fraction bar."""

    operations: int = 0
    over: int = 1
    under: int = 1

    @property
    def terms(self) -> int:
        """Number of terms."""
        return self.over + self.under


def closed_forms(outputs: Sequence[Output], notation: Notation) -> dict[int, ClosedForm]:
    """Short closed forms by expression id, the smallest first, until about a second is spent."""
    wanted = affordable({x.id: x for output in outputs for x in output.entries if isinstance(x, Expression)}.values())
    if not wanted:
        return {}
    import sympy

    convert = Conversion(sympy)
    forms = {x.id: _shortest(sympy, convert(x), notation) for x in wanted}
    return {key: form for key, form in forms.items() if form}


def affordable(expressions: Iterable[Expression]) -> list[Expression]:
    """The expressions small enough to be expanded, the smallest first, until about a second is spent."""
    expressions = list(expressions)
    sizes = written_out(expressions)
    terms_left, chosen = MAX_TERMS_IN_ALL, []
    for x in sorted(expressions, key=lambda x: (sizes[x.id].terms, x.id)):
        terms_left -= sizes[x.id].terms
        if terms_left < 0 or sizes[x.id].terms > MAX_TERMS:
            break
        if sizes[x.id].operations <= MAX_OPERATIONS:
            chosen.append(x)
    return chosen


def closed_equations(package: Package, function: Function, notation: Notation) -> list[Equation]:
    """Equations of a function's results with short closed forms, equal entries in one line.

    A vector or matrix is written whole, too, where it is short. Matrices of a stack are whole or left out.
    """
    forms = closed_forms(function.program.outputs, notation)
    lines: list[Equation] = []
    for array in arrays(package, function):
        if len(array.output.shape) == 3:
            lines += _matrices(array, forms)
            continue
        lefts: dict[int, list[str]] = {}
        for symbol, x in zip(array.entries, array.output.entries, strict=True):
            if isinstance(x, Expression) and x.operation != op.SYMBOL and x.id in forms:
                lefts.setdefault(x.id, []).append(symbol)
        lines += [Equation(" = ".join(symbols), forms[key].latex) for key, symbols in lefts.items()]
        if len(array.entries) > 1 and lefts:
            lines += _matrices(array, forms)
    return lines


def _matrices(array: Array, forms: Mapping[int, ClosedForm]) -> Iterator[Equation]:
    texts = [_latex(x, forms) for x in array.output.entries]
    for whole, entries in array.matrices(texts) if array.fits else ():
        if all(entries) and sum(map(visible_length, entries)) <= MAX_LENGTH:
            yield Equation(whole, matrix(entries, array.columns))


def _latex(x: Operand, forms: Mapping[int, ClosedForm]) -> str:
    if not isinstance(x, Expression):
        return number(x).signed()
    return forms[x.id].latex if x.id in forms else ""


def written_out(roots: Iterable[Scalar]) -> dict[int, Size]:
    """Sizes of expressions expanded to trees; sines and cosines count double, as sums of angles double them."""
    sizes: dict[int, Size] = {}
    for node in reachable(roots):
        parts = [
            sizes[x.id] if isinstance(x, Expression) else Size() for x in node.operands if node.operation != op.SYMBOL
        ]
        sizes[node.id] = _size(node.operation, parts)
    return sizes


def _size(operation: str, parts: Sequence[Size]) -> Size:
    operations = min(sum(part.operations for part in parts) + (operation not in (op.SYMBOL, op.PI)), 10**9)
    if operation in (op.ADD, op.SUBTRACT):
        a, b = parts
        over, under = a.over * b.under + b.over * a.under, a.under * b.under
    elif operation == op.MULTIPLY:
        over, under = parts[0].over * parts[1].over, parts[0].under * parts[1].under
    elif operation == op.DIVIDE:
        over, under = parts[0].over * parts[1].under, parts[0].under * parts[1].over
    elif operation == op.NEGATE:
        over, under = parts[0].over, parts[0].under
    else:
        over, under = (2 if operation in (op.SIN, op.COS) else 1), 1
    return Size(operations, min(over, 10**9), min(under, 10**9))


class Conversion:
    """Conversion of nodes to SymPy expressions; `known` are given ones, by node number."""

    def __init__(self, sympy: Any, known: Mapping[int, Any] | None = None) -> None:
        self.sympy = sympy
        self.found = dict(known or {})
        own: op.Functions = {
            op.PI: lambda: sympy.pi,
            op.COSPI: lambda a: sympy.cos(sympy.pi * a),
            op.MINIMUM: sympy.Min,
            op.MAXIMUM: sympy.Max,
        }
        self.operations = library(sympy, own)

    def __call__(self, x: Operand) -> Any:
        """The SymPy expression of an operand."""
        if not isinstance(x, Expression):
            return self.sympy.Rational(Fraction(x).numerator, Fraction(x).denominator)
        for node in reachable([x]):
            if node.id not in self.found:
                self.found[node.id] = self.node(node)
        return self.found[x.id]

    def node(self, node: Expression) -> Any:
        """The SymPy expression of a node whose operands are converted."""
        if node.operation == op.SYMBOL:
            return self.sympy.Symbol(node.operands[0])
        operands = [self.found[x.id] if isinstance(x, Expression) else self(x) for x in node.operands]
        return self.operations[node.operation](*operands)


def written_forms(sympy: Any, x: Any) -> tuple[Any, Any]:
    """A SymPy expression expanded in two ways: to products of sines and cosines, and to sums of angles."""
    from sympy.simplify.fu import TR8

    over, under = (sympy.expand(part) for part in sympy.fraction(sympy.together(x)))
    if under.is_number:
        over, under = sympy.expand(over / under), sympy.Integer(1)
    return over / under, sympy.expand(TR8(over)) / sympy.expand(TR8(under))


def _shortest(sympy: Any, x: Any, notation: Notation) -> ClosedForm | None:
    """The shorter of the two expanded forms, or None if it is long."""
    try:
        printed = [ClosedForm(form, _Printer(sympy, notation).text(form).signed()) for form in written_forms(sympy, x)]
    except LookupError:
        return None
    shortest = min(printed, key=lambda form: visible_length(form.latex))
    return shortest if visible_length(shortest.latex) <= MAX_LENGTH else None


def visible_length(latex: str) -> int:
    """Approximate number of characters that a LaTeX text shows."""
    return len(re.sub(r"\\(mathit|mathrm|d?dot|overline|frac|,)|[{}_^\s]", "", re.sub(r"\\(sin|cos)\b", "sin", latex)))


class _Printer:
    """Printer of SymPy expressions as LaTeX in the notation of a program; `LookupError` for unsupported ones."""

    def __init__(self, sympy: Any, notation: Notation) -> None:
        self.sympy, self.notation = sympy, notation
        self.functions = {
            sympy.sin: NAMED[op.SIN],
            sympy.cos: NAMED[op.COS],
            sympy.sign: NAMED[op.SIGN],
            sympy.atan2: NAMED[op.ATAN2],
            sympy.Min: NAMED[op.MINIMUM],
            sympy.Max: NAMED[op.MAXIMUM],
        }

    def text(self, x: Any) -> Text:
        """LaTeX of an expression."""
        if x.is_Rational:
            return number(Fraction(int(x.p), int(x.q)))
        if x.is_Symbol:
            return Text(False, self.notation[x.name], ATOM)
        if x is self.sympy.pi:
            return Text(False, r"\pi", ATOM)
        if x.is_Add:
            return self._sum([self.text(term) for term in x.as_ordered_terms()])
        coefficient, rest = x.as_coeff_Mul()
        if coefficient != 1:
            text = self.text(rest)
            if coefficient == -1:
                return text._replace(negative=not text.negative)
            return product(self.text(coefficient), text)
        over, under = self.sympy.fraction(x)
        if under != 1:
            top, bottom = self.text(over), self.text(under)
            return Text(top.negative != bottom.negative, rf"\frac{{{top.text}}}{{{bottom.text}}}", ATOM)
        if x.is_Mul:
            return reduce(product, map(self.text, sorted(x.as_ordered_factors(), key=self._rank)))
        if x.is_Pow:
            return self._power(*x.args)
        return self._call(x, "")

    def _rank(self, factor: Any) -> int:
        """Sort key of a factor: constants, symbols, sums, then functions."""
        base = factor.base if factor.is_Pow else factor
        return 0 if base.is_number else 3 if base.is_Function else 2 if base.is_Add else 1

    def _sum(self, terms: list[Text]) -> Text:
        first = next((k for k, term in enumerate(terms) if not term.negative), None)
        if first is None:
            return self._sum([term._replace(negative=False) for term in terms])._replace(negative=True)
        terms.insert(0, terms.pop(first))
        tail = "".join(f" {'-' if term.negative else '+'} {term.factor(PRODUCT)}" for term in terms[1:])
        return Text(False, terms[0].signed() + tail, SUM)

    def _power(self, base: Any, exponent: Any) -> Text:
        if exponent == self.sympy.Rational(1, 2):
            return Text(False, rf"\sqrt{{{self.text(base).signed()}}}", ATOM)
        if base.is_Function:
            return self._call(base, f"^{{{exponent}}}")
        text = self.text(base).factor(ATOM)
        text = f"({text})" if "^" in text else text
        return Text(False, f"{text}^{{{self.text(exponent).signed()}}}", ATOM)

    def _call(self, x: Any, power: str) -> Text:
        name = self.functions[x.func] + power
        texts = [self.text(argument) for argument in x.args]
        if len(texts) == 1 and texts[0].binding == ATOM and not texts[0].negative:
            return Text(False, f"{name} {texts[0].text}", PRODUCT)
        return Text(False, f"{name}({', '.join(text.signed() for text in texts)})", ATOM)
