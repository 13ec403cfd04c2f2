"""Singular positions of a frame, with the joints that then move it alike and the motion that is lost."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import mpmath
import numpy as np
import sympy

from symoro_elastic.analysis.singularities.factors import TooLong, condition, factors
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.results import Result

NEGLIGIBLE = 1e-6
"""Entries of unit vectors below this are rounding at a position found to 1e-12."""
TRIALS = 40


@dataclass(frozen=True)
class SingularPosition:
    """Where a factor of the determinant vanishes.

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
        """What happens there, in one sentence."""
        if not self.alike:
            return f"{self.condition}: no such position was found"
        whose = f"{self.alike[0]} does not move them" if len(self.alike) == 1 else f"{_and(self.alike)} move them alike"
        what = f"{self.lost[0]} is lost" if len(self.lost) == 1 else f"a combination of {_and(self.lost)} is lost"
        return f"{self.condition}: {whose}, {what}"


def _and(names: Sequence[str]) -> str:
    return " and ".join(filter(None, (", ".join(names[:-1]), names[-1])))


@dataclass(frozen=True)
class Singularities(Result):
    """The determinant of the Jacobian of some components of a frame, its factors, and where they vanish."""

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
    """Joint variables of a machine with their units, joints that move some components of a frame, parameters."""

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
    """The Jacobian of a frame at single positions; of it, some rows and columns."""

    jacobian: Any
    rows: tuple[int, ...]
    columns: tuple[int, ...]
    task: Task

    def at(self, position: Mapping[str, float]) -> Array:
        """Return the Jacobian (components, joints) at a position by variable."""
        values = [*self.task.values.values()]
        found = self.jacobian([position[name] for name in self.task.variables], *([values] if values else []))
        chosen: Array = found[0][np.ix_(self.rows, self.columns)]
        return chosen


def singular_positions(determinant: Any, task: Task, samples: Samples) -> tuple[Any, tuple[SingularPosition, ...]]:
    """Return the factored determinant, and where each factor vanishes; raises `InputError` where it is too long."""
    try:
        constant, found = factors(determinant, task.angles)
    except TooLong:
        what = "its determinant is too long to be factored: generate jacobian_determinant, or ask for fewer components"
        raise InputError(task.source, "singularities", what) from None
    positions = []
    for factor in dict.fromkeys(found):
        position = _zero_of(factor, [*task.variables], task.values)
        alike, lost = _meaning(samples.at(position), task) if position else ((), ())
        positions.append(SingularPosition(str(factor), latex(factor), condition(factor), alike, lost))
    return sympy.Mul(constant, *found), tuple(positions)


def latex(expression: Any) -> str:
    """Return LaTeX of an expression."""
    return str(sympy.latex(expression))


def _zero_of(factor: Any, variables: Sequence[str], values: Mapping[str, float]) -> dict[str, float] | None:
    """A position where a factor vanishes, the other variables at random; none where none was found."""
    rng = np.random.default_rng(0)
    numbers = factor.subs({sympy.Symbol(name): x for name, x in values.items()})
    free = [name for name in variables if numbers.has(sympy.Symbol(name))]
    for _ in range(TRIALS if free else 0):
        position = dict(zip(variables, rng.uniform(-2, 2, len(variables)).tolist(), strict=True))
        sought = free[-1]
        fixed = {sympy.Symbol(name): x for name, x in position.items() if name != sought}
        f = sympy.lambdify(sympy.Symbol(sought), numbers.subs(fixed), "mpmath")
        grid = np.linspace(-np.pi, np.pi, 50)
        signs = np.sign([float(f(x)) for x in grid])
        for k in np.flatnonzero(signs[1:] * signs[:-1] < 0):
            root = float(mpmath.findroot(f, (grid[k], grid[k + 1]), solver="anderson", tol=1e-24, verify=False))
            return position | {sought: root}
    return None


def _meaning(J: Array, task: Task) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Joints of the velocities that leave the components still, and components of the velocity that is lost."""
    left, _, right = np.linalg.svd(J)
    alike = tuple(name for name, x in zip(task.joints, right[-1], strict=True) if abs(x) > NEGLIGIBLE)
    lost = tuple(name for name, x in zip(task.components, left[:, -1], strict=True) if abs(x) > NEGLIGIBLE)
    return alike, lost
