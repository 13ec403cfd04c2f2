"""Factors of a determinant that is a polynomial in sines and cosines of joint angles.

Modulo S^2 + C^2 = 1 factors are not unique. In t = tan(q/2) they are: with S = 2t/(1 + t^2), C = (1 - t^2)/(1 + t^2)
the numerator is a polynomial, which SymPy factors. What its degree in t lacks are zeros at t = infinity, q = pi. A
factor of even degree is a polynomial in S and C again, as s^2 = (1 - C)/2, s c = S/2, c^2 = (1 + C)/2 for the sine and
the cosine of q/2; factors of odd degree, such as t with the zero at infinity (S) and 1 - t with 1 + t (C), are
multiplied in pairs.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import sympy
from sympy.simplify.fu import TR10i

MOST_OPERATIONS = 3000
"""Expressions that are longer are not factored: they would not be read either."""


class TooLong(ArithmeticError):
    """An expression has too many operations to be factored."""


def factors(determinant: Any, angles: Sequence[sympy.Symbol]) -> tuple[Any, list[Any]]:
    """Return the factor of a determinant without joint variables, and the others; raises `TooLong`."""
    expanded = sympy.expand_trig(determinant)
    halves = {q: sympy.Dummy(f"t_{q}") for q in angles if expanded.has(q)}
    if not halves:
        return expanded, []
    rational = expanded.subs({f(q): x for q, t in halves.items() for f, x in _of_half_angle(t)})
    numerator, denominator = sympy.fraction(sympy.together(rational))
    if sympy.count_ops(numerator) > MOST_OPERATIONS:
        raise TooLong
    constant, found = sympy.factor_list(numerator)
    constant, denominator = (
        constant / sympy.LC(denominator, *halves.values()),
        sympy.Poly(denominator, *halves.values()),
    )
    parts = [factor for factor, power in found for _ in range(power)]
    for q, t in halves.items():
        missing = denominator.degree(t) - sum(sympy.degree(part, t) for part in parts)
        parts = _in_angle(parts, t, q, missing)
    return _normal(constant, parts, angles)


def _of_half_angle(t: sympy.Symbol) -> Iterable[tuple[Any, Any]]:
    return (sympy.sin, 2 * t / (1 + t**2)), (sympy.cos, (1 - t**2) / (1 + t**2))


def _in_angle(parts: Sequence[Any], t: sympy.Symbol, q: sympy.Symbol, missing: int) -> list[Any]:
    """Factors in the sine and cosine of q in place of tan(q/2); `missing` counts zeros at infinity."""
    degrees = [(part, sympy.degree(part, t)) for part in parts]
    odd = sorted((x for x in degrees if x[1] % 2), key=lambda x: sympy.count_ops(x[0]))
    pairs = [x for x in degrees if not x[1] % 2]
    alone = [part for part, _ in odd if part == t][:missing]
    pairs += [(part, 2) for part in alone]
    rest = [x for x in odd if x[0] != t] + [x for x in odd if x[0] == t][len(alone) :]
    while len(rest) > 1:
        (one, m), (other, n) = rest.pop(0), rest.pop(0)
        pairs.append((sympy.expand(one * other), m + n))
    pairs += [(part, degree + 1) for part, degree in rest]
    pairs += [(sympy.Integer(1), 2)] * ((missing - len(alone) - len(rest)) // 2)
    return [_in_sine_and_cosine(part, degree, t, q) for part, degree in pairs]


def _in_sine_and_cosine(part: Any, degree: int, t: sympy.Symbol, q: sympy.Symbol) -> Any:
    """A polynomial of an even degree in tan(q/2), times cos(q/2)^degree."""
    if not degree:
        return part
    S, C = sympy.sin(q), sympy.cos(q)
    total = 0
    for (power,), x in sympy.Poly(part, t).terms():
        sines, cosines = power, degree - power
        both = sines % 2
        total += x * (S / 2) ** both * ((1 - C) / 2) ** (sines // 2) * ((1 + C) / 2) ** (cosines // 2)
    return sympy.expand(total)


def _normal(constant: Any, parts: Sequence[Any], angles: Sequence[Any]) -> tuple[Any, list[Any]]:
    """Numbers and signs, and what has no joint variable, go to the constant; sums of products become sines of sums."""
    found: list[Any] = []
    for part in parts:
        number, factor = part.as_content_primitive()
        factor = TR10i(factor)
        if factor.could_extract_minus_sign():
            number, factor = -number, -factor
        constant = constant * number
        if factor.has(*angles):
            found.append(factor)
        else:
            constant = constant * factor
    return constant, found


def condition(factor: Any) -> str:
    """Return in words where a factor vanishes: `q5 = 0 or pi`, `L4*sin(q2 + q3) = D3*cos(q2)`."""
    for function, values in ((sympy.sin, "0 or pi"), (sympy.cos, "pi/2 or -pi/2")):
        if factor.func is function:
            return f"{factor.args[0]} = {values}"
    terms = sympy.Add.make_args(factor)
    negative = [term for term in terms if term.could_extract_minus_sign()]
    left = sympy.Add(*(term for term in terms if term not in negative))
    return f"{left} = {sympy.Add(*(-term for term in negative))}"
