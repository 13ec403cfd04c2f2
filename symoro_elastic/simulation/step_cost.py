"""Operations of a time step, counted in the programs that it calls."""

from __future__ import annotations

from functools import cached_property

from symoro_elastic.integration.methods import Method
from symoro_elastic.integration.midpoint import Midpoint
from symoro_elastic.integration.rosenbrock import Rosenbrock
from symoro_elastic.integration.tableaus import Tableau
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.restrict import folded
from symoro_elastic.machine.scene import ALL, Scene
from symoro_elastic.models.base_steps import base_models
from symoro_elastic.models.catalogue import trace
from symoro_elastic.models.implicit_steps import Motors, implicit_system
from symoro_elastic.models.motor_coordinates import dependent_motors, motor_coordinates
from symoro_elastic.symbolic.program import OperationCount

DEGREES = 6
"""Of freedom of a floating base."""
DIVISION, SINE = 5, 15
"""Products that take about as long as a division, and as a sine and a cosine."""


def weighted(count: OperationCount) -> int:
    """Return the operations of a program as so many products."""
    return count.mul + count.add + DIVISION * count.div + SINE * count.sincos


class StepCost:
    """Operations of steps of a machine whose motors are given in a way."""

    def __init__(self, machine: Machine, motors: Motors) -> None:
        self.machine, self.motors = machine, motors
        self._folded = folded(machine, Scene(fold=ALL))

    def of(self, method: Method) -> int:
        """Return the operations of a step, weighted: those of its right sides, systems and sums."""
        rows, n = _sums(method), len(self.machine.moving) + (DEGREES if self.machine.floating else 0)
        found = _stages(method) * (self._of_model(self._right_side) + self._of_motors) + 4 * n * rows
        if self.machine.floating:
            displacement, rates = (weighted(one.program.count) for one in base_models(self.machine, self._folded))
            found += (_stages(method) + 1) * displacement + _stages(method) * rates
        if isinstance(method, Rosenbrock):
            dense = 2 * n**3 // 3 + len(method.m) * 6 * n**2
            return found + self._of_model("linearization") + dense
        if isinstance(method, Tableau):
            return found
        factors, solve = self._system
        return found + factors + _stages(method) * solve

    @property
    def _right_side(self) -> str:
        return "inverse_dynamics" if self.motors is Motors.DRIVEN else "direct_dynamics"

    @cached_property
    def _of_motors(self) -> int:
        """Operations of positions and velocities of motors that follow from loops, under servos."""
        if self.motors is not Motors.SERVO or not dependent_motors(self.machine):
            return 0
        return weighted(motor_coordinates(self.machine, self._folded).program.count)

    def _of_model(self, name: str) -> int:
        if name not in self._counts:
            self._counts[name] = weighted(trace(self.machine, name, folded=self._folded).program.count)
        return self._counts[name]

    @cached_property
    def _counts(self) -> dict[str, int]:
        return {}

    @cached_property
    def _system(self) -> tuple[int, int]:
        factors, solve = implicit_system(self.machine, self.motors, self._folded)
        return weighted(factors.program.count), weighted(solve.program.count)


def _stages(method: Method) -> int:
    if isinstance(method, Midpoint):
        return method.iterations
    return len(method.m if isinstance(method, Rosenbrock) else method.b)


def _sums(method: Method) -> int:
    """Return the coefficients of a step that are not zero."""
    if isinstance(method, Midpoint):
        return 2 * method.iterations
    rows = [*(method.A if isinstance(method, Tableau) else method.a)]
    rows += [] if isinstance(method, Tableau) else [*(method.c if isinstance(method, Rosenbrock) else method.g)]
    return sum(1 for row in rows for x in row if x) + _stages(method)
