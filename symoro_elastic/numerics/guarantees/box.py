"""The box of a machine: a range for every variable of its models, from the limits that its file gives."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from symoro_elastic.foundation.array_types import Array, BoolArray
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.format_names import in_words, is_robot
from symoro_elastic.machine.limits import Limits, Range
from symoro_elastic.machine.machine import Joint, Machine
from symoro_elastic.numerics.guarantees.intervals import Interval
from symoro_elastic.quantities import QUANTITIES
from symoro_elastic.symbolic.program import Input

POSITION = "position"
LIMITED = {
    "q": POSITION,
    "q_dep": POSITION,
    "qd": "velocity",
    "qdd": "acceleration",
    "qdd_motor": "acceleration",
    "tau": "torque",
}
"""Which limit of a joint is the range of an entry of each argument."""
FULL_TURN = Range(-np.pi, np.pi)


@dataclass(frozen=True)
class Box:
    """The range of each variable of some programs, by name, in SI units; parameters with one value are points."""

    ranges: Mapping[str, Range]
    positions: frozenset[str] = frozenset()
    """Names of the variables that are positions."""

    def of(self, names: Iterable[str]) -> Box:
        """The box of some of its variables."""
        return Box({name: self.ranges[name] for name in names}, self.positions & {*names})

    def interval(self, name: str) -> Interval:
        """The range of one variable as an interval."""
        found = self.ranges[name]
        return Interval(np.array([found.low]), np.array([found.high]))

    @property
    def whole(self) -> dict[str, Interval]:
        """The box as one sub-box."""
        return {name: self.interval(name) for name in self.ranges}

    @cached_property
    def open(self) -> tuple[str, ...]:
        """Names of the variables that are not points."""
        return tuple(name for name, found in self.ranges.items() if found.low < found.high)

    def rounded(self, dtype: type) -> Box:
        """The box whose points are numbers of an array: a parameter has the value that the array holds."""
        points = {name: float(dtype(x.low)) for name, x in self.ranges.items() if x.low == x.high}
        return Box({**self.ranges, **{name: Range(x, x) for name, x in points.items()}}, self.positions)

    @property
    def digest(self) -> str:
        """Twelve characters that tell boxes apart."""
        text = ";".join(f"{name}={found.low!r},{found.high!r}" for name, found in sorted(self.ranges.items()))
        return hashlib.sha256(text.encode()).hexdigest()[:12]

    def states(self, count: int, rng: np.random.Generator) -> dict[str, Array]:
        """Values of all variables at random states, as `drawn` draws them."""
        low, high = (
            np.array([getattr(x, end) for x in self.ranges.values()]).reshape(-1, 1) for end in ("low", "high")
        )
        positions = np.array([name in self.positions for name in self.ranges], dtype=bool).reshape(-1, 1)
        return dict(zip(self.ranges, drawn(low, high, positions, count, rng), strict=True))


DRAWN_AS = "half of the states drawn evenly from the box, half with all but positions at its corners"


def drawn(low: Array, high: Array, positions: BoolArray, count: int, rng: np.random.Generator) -> Array:
    """Return states (variables, count) between ends (variables, 1): drawn evenly, half with all but positions at ends.

    Errors that are linear in velocities, accelerations and torques are largest there.
    """
    part = rng.random((len(low), count))
    corners = slice(count - count // 2, None)
    part[:, corners] = np.where(positions, part[:, corners], np.round(part[:, corners]))
    found: Array = np.minimum(low + (high - low) * part, high)
    return found


def box_of(machine: Machine, limits: Limits, inputs: Iterable[Input], used: Iterable[str] = ()) -> Box:
    """The box of the variables in some arguments, and of the parameters; raises `InputError` for what has no limit.

    Variables that turn, and have no limits, take whole turns. Of `inputs` only the variables in `used` count, if given.
    """
    needed = {*used}
    ranges: dict[str, Range | None] = {}
    missing: dict[str, list[Joint]] = {}
    positions = set()
    for argument in inputs:
        if argument.name not in LIMITED:
            what = f"{argument.name} has no limits: models that take it have no box"
            raise machine.error("limits", what)
        for name, joint in zip(argument.symbols, _joints(machine, argument.name), strict=True):
            if not needed or name in needed:
                ranges[name] = _range(limits, joint, LIMITED[argument.name])
                if ranges[name] is None:
                    missing.setdefault(LIMITED[argument.name], []).append(joint)
                positions |= {name} if LIMITED[argument.name] == POSITION else set()
    if missing:
        raise _without_limits(machine, missing)
    parameters = [each.name for each in machine.parameters if not needed or each.name in needed]
    given = {name: x for name, x in ranges.items() if x is not None}
    return Box({**given, **parameter_box(machine, limits, parameters).ranges}, frozenset(positions))


def parameter_box(machine: Machine, limits: Limits, names: Iterable[str] | None = None) -> Box:
    """The box of parameters, by default of all; raises `InputError` for one without value."""
    chosen = [each.name for each in machine.parameters] if names is None else names
    return Box({name: _of_parameter(machine, limits, name) for name in chosen})


def _joints(machine: Machine, argument: str) -> Sequence[Joint]:
    numbers = {"n": machine.independent, "m": machine.motors, "d": machine.dependent}
    return [machine.joint(j) for j in numbers[QUANTITIES[argument].follows]]


def _range(limits: Limits, joint: Joint, quantity: str) -> Range | None:
    """The range of a quantity of a joint; None where it has none."""
    found: Range | None = getattr(limits.of(joint.name), quantity)
    return FULL_TURN if found is None and quantity == POSITION and joint.sigma == 0 else found


def _without_limits(machine: Machine, missing: Mapping[str, Sequence[Joint]]) -> InputError:
    """The error of joints that have no range of a quantity: the first, and which others are missing."""
    (quantity, (joint, *others)), *more = missing.items()
    example = {POSITION: "[-0.4, 0.4]", "velocity": "2", "acceleration": "20", "torque": "300"}[quantity]
    way = "convert the file to .toml, and give it there" if is_robot(machine.label) else "give it"
    what = f"has no {quantity}: {way}, as in [limits] {joint.name} = {{ {quantity} = {example} }}"
    rest = [(quantity, others), *more]
    lists = [f"{name} of {in_words([each.name for each in found], 'and')}" for name, found in rest if found]
    return machine.error(
        f"limits, {joint.name}", "; missing, too: ".join([what, "; ".join(lists)] if lists else [what])
    )


def _of_parameter(machine: Machine, limits: Limits, name: str) -> Range:
    if name in limits.parameters:
        return limits.parameters[name]
    value = next(each.value for each in machine.parameters if each.name == name)
    if value is None:
        raise machine.error(f"parameters, {name}", "has no value: a box needs the values of all parameters")
    number = value.value()
    return Range(number, number)


def points(values: Mapping[str, Array]) -> dict[str, Interval]:
    """States as sub-boxes of one point each."""
    return {name: Interval(x, x) for name, x in values.items()}
