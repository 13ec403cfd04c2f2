"""Singular positions of a frame, with the joints that are dependent there and the lost motion.

Factors of a determinant that is a polynomial in sines and cosines of joint angles.

Modulo S^2 + C^2 = 1 factors are not unique. In t = tan(q/2) they are: with S = 2t/(1 + t^2), C = (1 - t^2)/(1 + t^2)
the numerator is a polynomial, which SymPy factors. What its degree in t lacks are zeros at t = infinity, q = pi. A
factor of even degree is a polynomial in S and C again, as s^2 = (1 - C)/2, s c = S/2, c^2 = (1 + C)/2 for the sine and
the cosine of q/2; factors of odd degree, such as t with the zero at infinity (S) and 1 - t with 1 + t (C), are
multiplied in pairs.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import mpmath
import numpy as np
import sympy
from sympy.simplify.fu import TR10i

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import InputError, enumeration
from symoro_elastic.foundation.results import Result

NEGLIGIBLE = 1e-6
"""Entries of unit vectors below this are rounding at a position found to 1e-12."""
TRIALS = 40
MOST_OPERATIONS = 3000
"""Expressions that are longer are not factored: they would not be read either."""


@dataclass(frozen=True)
class SingularPosition:
    """A position at which a factor of the determinant is zero, with its consequences.

    `alike` names the joints whose velocities, in one ratio, leave the components still; `lost` the components that a
    wanted velocity must leave out there, each or one combination of them; both empty where no position was found.
    """

    factor: str
    latex: str
    condition: str
    alike: tuple[str, ...] = ()
    lost: tuple[str, ...] = ()

    @property
    def sentence(self) -> str:
        """Consequence of the singularity at this position, in one sentence."""
        if not self.alike:
            return f"{self.condition}: no such position was found"
        alike, lost = enumeration(self.alike), enumeration(self.lost)
        whose = f"{alike} does not move them" if len(self.alike) == 1 else f"{alike} move them alike"
        what = f"{lost} is lost" if len(self.lost) == 1 else f"a combination of {lost} is lost"
        return f"{self.condition}: {whose}, {what}"


@dataclass(frozen=True)
class Singularities(Result):
    """The determinant of the Jacobian of some components of a frame, its factors, and their zeros."""

    machine: str
    components: tuple[str, ...]
    joints: tuple[str, ...]
    determinant: str
    latex: str
    positions: tuple[SingularPosition, ...]

    @property
    def headline(self) -> str:
        """Machine, components and number of factors."""
        return f"Singularities of {self.machine}: {', '.join(self.components)}, {len(self.positions)} kinds"


@dataclass(frozen=True)
class Task:
    """Input of the analysis: joint variables with units, joints that move frame components, parameters."""

    source: str
    variables: Mapping[str, str]
    joints: tuple[str, ...]
    components: tuple[str, ...]
    values: Mapping[str, float]

    @property
    def angles(self) -> list[Any]:
        """The variables that are angles, as symbols."""
        return [sympy.Symbol(name) for name, unit in self.variables.items() if unit == "rad"]


@dataclass(frozen=True)
class Samples:
    """Evaluation of some rows and columns of the Jacobian of a frame at single positions."""

    jacobian: Any
    rows: tuple[int, ...]
    columns: tuple[int, ...]
    task: Task

    def at(self, position: Mapping[str, float]) -> Array:
        """Return the Jacobian (components, joints) at a position by variable."""
        values = [*self.task.values.values()]
        J = self.jacobian([position[name] for name in self.task.variables], *([values] if values else []))
        return np.asarray(J[0][np.ix_(self.rows, self.columns)])


def singular_positions(determinant: Any, task: Task, samples: Samples) -> tuple[Any, tuple[SingularPosition, ...]]:
    """Return the factored determinant, and the zeros of each factor; raises `InputError` for a long one."""
    try:
        constant, nontrivial = factors(determinant, task.angles)
    except TooLong:
        what = "its determinant is too long to be factored: generate jacobian_determinant, or ask for fewer components"
        raise InputError(task.source, "singularities", what) from None
    positions = []
    for factor in dict.fromkeys(nontrivial):
        position = _zero_of(factor, [*task.variables], task.values)
        alike, lost = _meaning(samples.at(position), task) if position else ((), ())
        positions.append(SingularPosition(str(factor), latex(factor), condition(factor), alike, lost))
    return sympy.Mul(constant, *nontrivial), tuple(positions)


def latex(expression: Any) -> str:
    """Return LaTeX of an expression."""
    return str(sympy.latex(expression))


def _zero_of(factor: Any, variables: Sequence[str], values: Mapping[str, float]) -> dict[str, float] | None:
    """A zero of a factor, the other variables at random; None without one."""
    rng = np.random.default_rng(0)
    numbers = factor.subs({sympy.Symbol(name): x for name, x in values.items()})
    free = [name for name in variables if numbers.has(sympy.Symbol(name))]
    for _ in range(TRIALS if free else 0):
        position = dict(zip(variables, rng.uniform(-2, 2, len(variables)).tolist(), strict=True))
        unknown = free[-1]
        fixed = {sympy.Symbol(name): x for name, x in position.items() if name != unknown}
        f = sympy.lambdify(sympy.Symbol(unknown), numbers.subs(fixed), "mpmath")
        grid = np.linspace(-np.pi, np.pi, 50)
        signs = np.sign([float(f(x)) for x in grid])
        for k in np.flatnonzero(signs[1:] * signs[:-1] < 0):
            root = float(mpmath.findroot(f, (grid[k], grid[k + 1]), solver="anderson", tol=1e-24, verify=False))
            return position | {unknown: root}
    return None


def _meaning(J: Array, task: Task) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Joints of the null-space velocity, and components of the lost velocity, of a singular Jacobian."""
    U, _, right = np.linalg.svd(J)
    alike = tuple(name for name, x in zip(task.joints, right[-1], strict=True) if abs(x) > NEGLIGIBLE)
    lost = tuple(name for name, x in zip(task.components, U[:, -1], strict=True) if abs(x) > NEGLIGIBLE)
    return alike, lost


class TooLong(ArithmeticError):
    """An expression with too many operations for factoring."""


def factors(determinant: Any, angles: Sequence[sympy.Symbol]) -> tuple[Any, list[Any]]:
    """Return the factor of a determinant without joint variables, and the other factors; raises `TooLong`."""
    expanded = sympy.expand_trig(determinant)
    halves = {q: sympy.Dummy(f"t_{q}") for q in angles if expanded.has(q)}
    if not halves:
        return expanded, []
    sines = {sympy.sin(q): 2 * t / (1 + t**2) for q, t in halves.items()}
    rational = expanded.subs({**sines, **{sympy.cos(q): (1 - t**2) / (1 + t**2) for q, t in halves.items()}})
    numerator, denominator = sympy.fraction(sympy.together(rational))
    if sympy.count_ops(numerator) > MOST_OPERATIONS:
        raise TooLong
    constant, powers = sympy.factor_list(numerator)
    constant /= sympy.LC(denominator, *halves.values())
    denominator = sympy.Poly(denominator, *halves.values())
    parts = [factor for factor, power in powers for _ in range(power)]
    for q, t in halves.items():
        missing = denominator.degree(t) - sum(sympy.degree(part, t) for part in parts)
        parts = _in_angle(parts, t, q, missing)
    return _normal(constant, parts, angles)


def _in_angle(parts: Sequence[Any], t: sympy.Symbol, q: sympy.Symbol, missing: int) -> list[Any]:
    """Factors with tan(q/2) replaced by the sine and cosine of q; `missing` counts zeros at infinity."""
    degrees = [(part, sympy.degree(part, t)) for part in parts]
    odd = sorted((x for x in degrees if x[1] % 2), key=lambda x: sympy.count_ops(x[0]))
    pairs = [x for x in degrees if not x[1] % 2]
    alone = [part for part, _ in odd if part == t][:missing]
    pairs += [(part, 2) for part in alone]
    unpaired = [x for x in odd if x[0] != t] + [x for x in odd if x[0] == t][len(alone) :]
    while len(unpaired) > 1:
        (first, m), (second, n) = unpaired.pop(0), unpaired.pop(0)
        pairs.append((sympy.expand(first * second), m + n))
    pairs += [(part, degree + 1) for part, degree in unpaired]
    pairs += [(sympy.Integer(1), 2)] * ((missing - len(alone) - len(unpaired)) // 2)
    return [_in_sine_and_cosine(part, degree, t, q) for part, degree in pairs]


def _in_sine_and_cosine(part: Any, degree: int, t: sympy.Symbol, q: sympy.Symbol) -> Any:
    """A polynomial of even degree in tan(q/2) times cos(q/2)^degree, in the sine and cosine of q."""
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
    """Move numbers, signs and constant factors to the constant; combine sums of products into sines of sums."""
    normal: list[Any] = []
    for part in parts:
        number, factor = part.as_content_primitive()
        factor = TR10i(factor)
        if factor.could_extract_minus_sign():
            number, factor = -number, -factor
        constant = constant * number
        if factor.has(*angles):
            normal.append(factor)
        else:
            constant = constant * factor
    return constant, normal


def condition(factor: Any) -> str:
    """Return the condition for a zero of a factor as text: `q5 = 0 or pi`, `L4*sin(q2 + q3) = D3*cos(q2)`."""
    for function, values in ((sympy.sin, "0 or pi"), (sympy.cos, "pi/2 or -pi/2")):
        if factor.func is function:
            return f"{factor.args[0]} = {values}"
    terms = sympy.Add.make_args(factor)
    negative = [term for term in terms if term.could_extract_minus_sign()]
    positive = sympy.Add(*(term for term in terms if term not in negative))
    return f"{positive} = {sympy.Add(*(-term for term in negative))}"
