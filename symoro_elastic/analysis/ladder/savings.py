"""Operations that a step saves without some numbers, found in one trace where these numbers are symbols.

To leave out a number is to freeze its symbol at zero: what nothing needs any more is counted by uses (`liveness`). The
count of the programs that are traced without them decides at last.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping

from symoro_elastic.analysis.simulation.simulate import StepCost
from symoro_elastic.codegen.integration.methods import Method
from symoro_elastic.machine.machine import Machine
from symoro_elastic.models.implicit_steps import Motors
from symoro_elastic.numerics.within.liveness import Liveness
from symoro_elastic.numerics.within.tape import Change, Kind, Tape


class Savings:
    """What a step of some programs saves where symbols are zero."""

    def __init__(self, machine: Machine, motors: Motors, symbols: Mapping[str, str], method: Method) -> None:
        """`symbols` are parameters of the machine by the names of what is left out; all others are constants."""
        constants = [p.name for p in machine.parameters if p.value is not None and p.name not in symbols.values()]
        self._programs = [(times, Tape(x)) for times, x in StepCost(machine, motors, constants).programs(method)]
        self._symbols = symbols

    def of(self, names: Collection[str]) -> int:
        """Return the operations that a step saves without these."""
        return sum(times * (Liveness(tape).cost - self._without(tape, names)) for times, tape in self._programs)

    def _without(self, tape: Tape, names: Collection[str]) -> int:
        live = Liveness(tape)
        for name in names:
            place = tape.symbols.get(self._symbols.get(name, ""))
            if place is not None and live.is_possible(change := Change(Kind.FREEZE, place, constant=0.0)):
                live.apply(change)
        return live.cost
