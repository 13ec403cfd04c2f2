"""Attacks with a million states: generated C beside a reference in a wider type, which is C of the same operations.

The generated function, compiled as users compile it (fused products and its own sines among it), is called on batches
of states; a reference is computed from the exact numbers of the program, in long double for double precision (11 bits
more) and in double for single (29 more). Errors, least and largest values are kept by result.
"""

from __future__ import annotations

import ctypes
import math
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from symoro_elastic.codegen.compile import compile_library, compile_package
from symoro_elastic.codegen.package import Package
from symoro_elastic.codegen.precision import PRECISIONS
from symoro_elastic.numerics.guarantees.box import Box
from symoro_elastic.symbolic.arithmetic import evaluate, multiprecision
from symoro_elastic.symbolic.expression import Expression, Level, Operand, reachable
from symoro_elastic.symbolic.operations import (
    ADD,
    ATAN2,
    COS,
    DIVIDE,
    MAXIMUM,
    MINIMUM,
    MULTIPLY,
    NEGATE,
    SIGN,
    SIN,
    SQRT,
    SUBTRACT,
    SYMBOL,
)
from tests.numerics.guarantees.attack import Attack, Worst

Array = NDArray[np.float64]
AT_ONCE = 50_000
WIDER = {"double": ("long double", "l"), "single": ("double", "")}
"""Type of the reference, and what names of its functions end with."""
OPERATORS = {ADD: "+", SUBTRACT: "-", MULTIPLY: "*", DIVIDE: "/"}
FUNCTIONS = {SIN: "sin", COS: "cos", SQRT: "sqrt", ATAN2: "atan2", MINIMUM: "fmin", MAXIMUM: "fmax"}
SOURCE = """
#include <math.h>
typedef {type} real;
void compare(long n, const double *x, const double *computed, double *error, double *low, double *high)
{{
    for (long s = 0; s < n; s++) {{
{statements}
        const real result[] = {{{results}}};
        for (int k = 0; k < {count}; k++) {{
            real off = fabs{end}((real)computed[k * n + s] - result[k]);
            if (!(off <= error[k])) error[k] = (double)off;
            if (!(result[k] >= low[k])) low[k] = (double)result[k];
            if (!(result[k] <= high[k])) high[k] = (double)result[k];
        }}
    }}
}}
"""


def reference_source(roots: Sequence[Operand], symbols: Sequence[str], precision: str) -> str:
    """Return C that compares computed results with those of the reference, one statement for each operation."""
    kind, end = WIDER[precision]
    nodes = reachable(roots)
    constants = [node for node in nodes if node.level == Level.CONSTANT]
    value = evaluate(constants, {}, multiprecision(60))
    exact = {node.id: Fraction(str(value(node))) for node in constants}
    rows = {name: k for k, name in enumerate(symbols)}

    def of(x: Operand) -> str:
        if isinstance(x, Expression):
            return number(exact[x.id]) if x.id in exact else f"z{x.id}"
        return number(Fraction(x))

    lines = []
    for node in nodes:
        if node.id in exact:
            continue
        if node.operation == SYMBOL:
            text = f"x[{rows[node.operands[0]]} * n + s]"
        elif node.operation in OPERATORS:
            text = f" {OPERATORS[node.operation]} ".join(map(of, node.operands))
        elif node.operation == NEGATE:
            text = f"-{of(node.operands[0])}"
        elif node.operation == SIGN:
            text = "(real)(({0} > 0) - ({0} < 0))".format(of(node.operands[0]))
        else:
            text = f"{FUNCTIONS[node.operation]}{end}({', '.join(map(of, node.operands))})"
        lines.append(f"        const real z{node.id} = {text};")
    results = ", ".join(map(of, roots))
    return SOURCE.format(type=kind, end=end, statements="\n".join(lines), results=results, count=len(roots))


def number(x: Fraction) -> str:
    """A number as two doubles, whose sum has 106 bits."""
    high = float(x)
    low = float(x - Fraction(high))
    return f"((real){high.hex()} + (real){low.hex()})"


def attack_in_c(package: Package, model: str, box: Box, precision: str, states: int, seed: int = 1) -> Worst:
    """Return the worst errors, and the least and largest values, of a model at so many states of a box."""
    (function,) = (one for one in package.functions if one.name == model)
    roots = [x for output in function.program.outputs for x in output.entries]
    symbols = [*box.ranges]
    with tempfile.TemporaryDirectory() as folder:
        compiled = compile_package(package, Path(folder) / "code", precision=PRECISIONS[precision])
        text = {"reference.c": reference_source(roots, symbols, precision)}
        library = ctypes.CDLL(str(compile_library(text, Path(folder) / "reference", flags=("-O1", "-w"))))
        error, low, high = np.zeros(len(roots)), np.full(len(roots), np.inf), np.full(len(roots), -np.inf)
        for drawn in _held(box, precision, states, seed, roots):
            count = len(drawn[symbols[0]])
            arrays = {
                argument.name: np.stack([drawn.get(name, np.zeros(count)) for name in argument.symbols], axis=1)
                for argument in function.program.inputs
            }
            found = compiled.call_batch(model, **arrays).values()
            rows = [np.asarray(x, float).reshape(count, -1).T for x in found]
            computed = np.ascontiguousarray(np.concatenate(rows))
            x = np.ascontiguousarray([drawn[name] for name in symbols])
            pointers = (ctypes.c_void_p(array.ctypes.data) for array in (x, computed, error, low, high))
            library.compare(ctypes.c_long(count), *pointers)
    return Worst(error, low, high)


def _held(box: Box, precision: str, states: int, seed: int, roots: Sequence[Operand]) -> Iterator[Mapping[str, Array]]:
    """Yield states of a box as arrays of the precision hold them."""
    attack = Attack(roots, box, precision, seed)
    for _ in range(math.ceil(states / AT_ONCE)):
        yield attack.held(box.states(AT_ONCE, attack.rng))
