"""The cells of a machine's table as expressions of one graph."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from typing import Any

from symoro_elastic.foundation.scalar import Scalar
from symoro_elastic.machine.checks import formulas
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import Body, Machine
from symoro_elastic.machine.scene import Point
from symoro_elastic.mechanics.spatial import RigidInertia, Symmetric, Twist, Vector
from symoro_elastic.symbolic.expression import Expression, Graph, Level, operand
from symoro_elastic.symbolic.functions import arc_tangent, cosine_sine, square_root
from symoro_elastic.symbolic.program import Names

Points = tuple[tuple[int, Point], ...]


def _exact(x: Scalar) -> Scalar:
    """Constants as fractions, so that their quotients are exact."""
    found = operand(x)
    return found if isinstance(found, Expression) else Fraction(found)


class Cells:
    """The cells of a machine as expressions; `folded` names parameters that become constants.

    They are expressions of the graph of the cells `beside`, with their names and constants, where these are given.
    """

    def __init__(
        self, machine: Machine, folded: Sequence[str] = (), points: Points = (), *, beside: Cells | None = None
    ) -> None:
        self.machine, self.points = machine, points
        self.graph: Graph = beside.graph if beside else Graph()
        self.names: Names = beside.names if beside else Names()
        self._functions: dict[str, Callable[..., Any]] = {
            "sin": lambda x: _exact(cosine_sine(self.graph, x)[1]),
            "cos": lambda x: _exact(cosine_sine(self.graph, x)[0]),
            "tan": self._tangent,
            "sqrt": lambda x: square_root(self.graph, x),
            "atan2": lambda y, x: arc_tangent(self.graph, y, x),
        }
        self._cells: dict[str, Scalar] = beside._cells if beside else self._parameter_cells(folded)

    def values_by_name(self, variables: Mapping[str, Scalar]) -> dict[str, Scalar]:
        """Values of the names in cells: parameters, and these variables."""
        return {**self._cells, **variables}

    def _parameter_cells(self, folded: Sequence[str]) -> dict[str, Scalar]:
        cells: dict[str, Scalar] = {"pi": self.graph.pi}
        for parameter in self.machine.parameters:
            if parameter.name in folded and parameter.value is not None:
                cells[parameter.name] = self.cell(parameter.value, {"pi": self.graph.pi})
            else:
                cells[parameter.name] = self.graph.symbol(parameter.name, Level.PARAMETER)
        return cells

    def _tangent(self, x: Scalar) -> Scalar:
        cosine, sine = cosine_sine(self.graph, x)
        return _exact(sine) / cosine

    def cell(self, formula: Formula, names: dict[str, Scalar] | None = None) -> Scalar:
        """The expression of a cell; exact zero is the integer 0 of structure. Raises `InputError`."""
        try:
            value = formula.evaluate(names or self._cells, self._functions, Fraction)
        except (ArithmeticError, ValueError) as error:
            reason = "it divides by zero" if isinstance(error, ZeroDivisionError) else str(error)
            raise self.machine.error(self._place(formula), f"{formula.text!r} has no value: {reason}") from None
        return 0 if not isinstance(value, Expression) and value == 0 else value

    def cells(self, written: Sequence[Formula]) -> Any:
        """The expressions of several cells."""
        return tuple(map(self.cell, written))

    def vector(self, written: Sequence[Formula]) -> Vector:
        """The expressions of three cells."""
        return Vector(*self.cells(written))

    def _place(self, formula: Formula) -> str:
        of_point = any(formula in at for _, at in self.points)
        elsewhere = "scene, outputs" if of_point else "parameters"
        return next((place for place, written in formulas(self.machine) if written == formula), elsewhere)

    def twist(self, linear: Sequence[Formula], angular: Sequence[Formula]) -> Twist:
        """The expressions of a twist."""
        return Twist(self.vector(linear), self.vector(angular))

    def body(self, body: Body) -> RigidInertia:
        """The expressions of a body, about the origin of its frame."""
        mass, moments, inertia = self.cell(body.mass), self.vector(body.moments), Symmetric(*self.cells(body.inertia))
        if not body.central:
            return RigidInertia(mass, moments, inertia)
        return RigidInertia.about_center(mass, moments, inertia)
