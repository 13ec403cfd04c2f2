"""The box of a machine: a range for every variable of its models, from the limits that its file gives."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TypeAlias

import numpy as np

from symoro_elastic.foundation.array_types import Array, BoolArray
from symoro_elastic.foundation.errors import InputError, without_value
from symoro_elastic.foundation.progress import Progress, no_progress
from symoro_elastic.machine.format_names import in_words, is_robot
from symoro_elastic.machine.limits import Limits, Range
from symoro_elastic.machine.machine import Joint, Kind, Machine
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
"""The limit of a joint that is the range of its entries, by argument."""
EXAMPLES = {
    POSITION: ("[-0.4, 0.4]", "[-1e-4, 1e-4]"),
    "velocity": ("2", "0.01"),
    "acceleration": ("20", "1"),
    "torque": ("300", "300"),
}
"""Limits of a joint, and of a spring, for messages."""
FULL_TURN = Range(-np.pi, np.pi)
Parts: TypeAlias = Mapping[str, Interval]
"""The sub-boxes of a box: intervals by variable, with an entry per sub-box."""
LEAST_GAIN = 0.02
"""Least decrease of the mean logarithm of bounds for which a box is cut."""
UNBOUNDED = 1e30
"""Placeholder of infinite bounds where partitions are compared."""


@dataclass(frozen=True)
class Box:
    """Ranges of the variables of programs, by name, in SI units; fixed parameters are points."""

    ranges: Mapping[str, Range]
    positions: frozenset[str] = frozenset()
    """Names of the variables that are positions."""

    def of(self, names: Iterable[str]) -> Box:
        """The box of some of its variables."""
        return Box({name: self.ranges[name] for name in names}, self.positions & {*names})

    def interval(self, name: str) -> Interval:
        """The range of a variable as an interval."""
        span = self.ranges[name]
        return Interval(np.array([span.low]), np.array([span.high]))

    @property
    def whole(self) -> dict[str, Interval]:
        """The box as one sub-box."""
        return {name: self.interval(name) for name in self.ranges}

    @cached_property
    def open(self) -> tuple[str, ...]:
        """Names of the variables whose range is more than a single value."""
        return tuple(name for name, span in self.ranges.items() if span.low < span.high)

    @property
    def numbers(self) -> dict[str, float]:
        """Values of the variables whose range is a single value."""
        return {name: x.low for name, x in self.ranges.items() if x.low == x.high}

    def rounded(self, dtype: type) -> Box:
        """The box in which ranges without a number of `dtype`, as of parameters, are the nearest number."""
        return Box({name: _holding_a_number(x, dtype) for name, x in self.ranges.items()}, self.positions)

    @property
    def digest(self) -> str:
        """Hash of the ranges, twelve characters."""
        text = ";".join(f"{name}={span.low!r},{span.high!r}" for name, span in sorted(self.ranges.items()))
        return hashlib.sha256(text.encode()).hexdigest()[:12]

    def states(self, count: int, rng: np.random.Generator) -> dict[str, Array]:
        """Values of all variables at random states, distributed as `drawn` says."""
        low, high = np.array([(x.low, x.high) for x in self.ranges.values()]).reshape(-1, 2, 1).swapaxes(0, 1)
        positions = np.array([name in self.positions for name in self.ranges], dtype=bool).reshape(-1, 1)
        return dict(zip(self.ranges, drawn(low, high, positions, count, rng), strict=True))


def _holding_a_number(span: Range, dtype: type) -> Range:
    least = dtype(span.low)
    least = least if float(least) >= span.low else np.nextafter(least, dtype(np.inf))
    nearest = float(dtype(span.low / 2 + span.high / 2))
    return span if float(least) <= span.high else Range(nearest, nearest)


DRAWN_AS = "half of the states drawn evenly from the box, half with all but positions at its corners"


def drawn(low: Array, high: Array, positions: BoolArray, count: int, rng: np.random.Generator) -> Array:
    """Return random states (variables, count) between ends (variables, 1): half uniform, half at corners.

    Positions are always uniform. Errors linear in velocities, accelerations and torques are largest at corners.
    """
    part = rng.random((len(low), count))
    corners = slice(count - count // 2, None)
    part[:, corners] = np.where(positions, part[:, corners], np.round(part[:, corners]))
    return np.asarray(np.minimum(low + (high - low) * part, high))


def box_of(machine: Machine, limits: Limits, inputs: Iterable[Input], used: Iterable[str] = ()) -> Box:
    """The box of the variables of arguments and of the parameters; raises `InputError` for missing limits.

    Revolute joints without limits have full turns. If `used` is given, only its variables of `inputs` count.
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
    parameters = [parameter.name for parameter in machine.parameters if not needed or parameter.name in needed]
    with_limits = {name: x for name, x in ranges.items() if x is not None}
    return Box({**with_limits, **parameter_box(machine, limits, parameters).ranges}, frozenset(positions))


def parameter_box(machine: Machine, limits: Limits, names: Iterable[str] | None = None) -> Box:
    """The box of parameters, by default of all; raises `InputError` for one without value."""
    chosen = [parameter.name for parameter in machine.parameters] if names is None else names
    return Box({name: _of_parameter(machine, limits, name) for name in chosen})


def _joints(machine: Machine, argument: str) -> Sequence[Joint]:
    numbers = {"n": machine.independent, "m": machine.motors, "d": machine.dependent}
    return [machine.joint(j) for j in numbers[QUANTITIES[argument].follows]]


def _range(limits: Limits, joint: Joint, quantity: str) -> Range | None:
    """The range of a quantity of a joint; None where it has none."""
    limit: Range | None = getattr(limits.of(joint.name), quantity)
    return FULL_TURN if limit is None and quantity == POSITION and joint.sigma == 0 else limit


def _without_limits(machine: Machine, missing: Mapping[str, Sequence[Joint]]) -> InputError:
    """The error for missing limits: of the first joint and quantity, with a list of the others."""
    (quantity, (joint, *others)), *more = missing.items()
    example = EXAMPLES[quantity][joint.kind is Kind.ELASTIC]
    way = "convert the file to .toml, and give it there" if is_robot(machine.label) else "give it"
    what = f"has no {quantity}: {way}, as in [limits] {joint.name} = {{ {quantity} = {example} }}"
    if any(other.kind is Kind.ELASTIC for joints in missing.values() for other in joints):
        what += ", or take the ranges of springs from a motion (--limits motion --scene FILE)"
    remaining = [(quantity, others), *more]
    lists = [f"{name} of {in_words([other.name for other in joints], 'and')}" for name, joints in remaining if joints]
    what += f"; missing, too: {'; '.join(lists)}" if lists else ""
    return machine.error(f"limits, {joint.name}", what)


def _of_parameter(machine: Machine, limits: Limits, name: str) -> Range:
    if name in limits.parameters:
        return limits.parameters[name]
    value = next(parameter.value for parameter in machine.parameters if parameter.name == name)
    if value is None:
        raise machine.error(f"parameters, {name}", without_value([name]))
    number = value.value()
    return Range(number, number)


def points(values: Mapping[str, Array]) -> dict[str, Interval]:
    """Return states as degenerate sub-boxes, in which every variable has a single value."""
    return {name: Interval(x, x) for name, x in values.items()}


def halves_along(parts: Parts, name: str) -> dict[str, Interval]:
    """The sub-boxes halved along a variable: twice as many."""
    cut = parts[name]
    middle = cut.low / 2 + cut.high / 2
    halves = {key: Interval(np.tile(x.low, 2), np.tile(x.high, 2)) for key, x in parts.items()}
    halves[name] = Interval(np.concatenate([cut.low, middle]), np.concatenate([middle, cut.high]))
    return halves


def side_by_side(boxes: Sequence[Parts]) -> dict[str, Interval]:
    """Concatenated sub-boxes of several partitions, for joint evaluation."""
    joined = {name: [box[name] for box in boxes] for name in boxes[0]}
    return {
        name: Interval(np.concatenate([x.low for x in parts]), np.concatenate([x.high for x in parts]))
        for name, parts in joined.items()
    }


def cut(
    parts: Parts,
    names: Sequence[str],
    bounds: Callable[[Parts], Array],
    most: int,
    progress: Progress = no_progress,
    least_gain: float = LEAST_GAIN,
) -> Parts:
    """Partition a box into at most `most` sub-boxes, halving along the variable that makes bounds smallest.

    `bounds` returns bounds (results, sub-boxes), of which the largest over sub-boxes counts. It ends
    where a cut gains less than `least_gain`.
    """
    if not names:
        return parts
    steps = int(math.log2(most))
    (before,) = _sizes([parts], bounds)
    for step in range(steps):
        candidates = [halves_along(parts, name) for name in names]
        sizes = _sizes(candidates, bounds)
        progress(step + 1, steps)
        best = min(range(len(candidates)), key=sizes.__getitem__)
        if not sizes[best] < before - least_gain:
            break
        parts, before = candidates[best], sizes[best]
    return parts


def _sizes(boxes: Sequence[Parts], bounds: Callable[[Parts], Array]) -> list[float]:
    """Mean logarithms of bounds by partition, for partitions with equal numbers of sub-boxes."""
    values = bounds(side_by_side(boxes))
    by_box = values.reshape(len(values), len(boxes), -1).max(axis=2)
    logs = np.log(np.where(np.isfinite(by_box), by_box, UNBOUNDED), where=by_box > 0, out=np.zeros_like(by_box))
    return [float(mean) for mean in logs.mean(axis=0)]
