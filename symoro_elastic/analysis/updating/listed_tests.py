"""Mistakes of a list of tests, undone: where the machine stood, which motors were held, what was hit and measured.

Each way in which the list may be wrong gives other tests with the same numbers. Those whose smoothed responses are
nearest to the model's are fitted from the start; one that leaves no more than noise is named, if the list as it is
does not explain the tests from there, too.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from itertools import combinations, product

from symoro_elastic.analysis.updating.measured import VibrationTest
from symoro_elastic.analysis.updating.unknowns import held_in
from symoro_elastic.machine.machine import Machine
from symoro_elastic.numerics.motion.signals import FRAME_OUTPUTS, JOINT_OUTPUTS, MOTOR_TORQUE, WRENCH_INPUTS

DEGREE, MILLIMETRE = math.pi / 180, 1e-3
MOST_TOGETHER = 3
"""Motors, of which all combinations are tried as held."""
AT = "at: "
ZEROS = (
    (0.1, 0.2, 0.3, 0.45, 0.6, 0.8, 1.0, 1.25, math.pi / 2, 1.8, 2.1, 2.4, 2.75, math.pi),
    (0.02, 0.05, 0.1, 0.2, 0.4, 0.8),
)
"""Of joints that turn, rad, and that slide, m: zeros that are tried."""
HELD, FREE, SERVO = "held", "free", "under a servo"


@dataclass(frozen=True)
class Corrected:
    """Tests without one mistake of their list; `tests` are those (by place) that differ, `what` names the mistake.

    `zero` is what was added to the positions of a joint, where its zero may be another. `is_sign` tells that a signal
    has only the opposite sign, which other lines name.
    """

    what: str
    tests: tuple[VibrationTest, ...]
    changed: tuple[int, ...]
    joint: str = ""
    zero: float = 0.0
    is_sign: bool = False

    @property
    def files(self) -> str:
        """Names of the tests that differ."""
        return ", ".join(dict.fromkeys(self.tests[k].name for k in self.changed))


class ListedTests:
    """Tests of a machine as they are listed, and as they may have been."""

    def __init__(self, machine: Machine, tests: Sequence[VibrationTest]) -> None:
        self.machine, self.tests = machine, tuple(tests)
        self.motors = [joint.name for joint in machine.motor_joints]

    @cached_property
    def scopes(self) -> list[tuple[int, ...]]:
        """All tests, then each of them where there are more."""
        every = tuple(range(len(self.tests)))
        return [every, *((k,) for k in every)] if len(every) > 1 else [every]

    def each(self, what: str, of: Callable[[VibrationTest], VibrationTest]) -> Iterator[Corrected]:
        """Yield tests of which all, or one, are changed."""
        for scope in self.scopes:
            found = [of(test) if k in scope else test for k, test in enumerate(self.tests)]
            changed = tuple(k for k in scope if found[k] is not self.tests[k])
            if changed and (len(scope) == 1 or len(changed) > 1):
                yield Corrected(what, tuple(found), changed)

    def with_test(self, what: str, k: int, test: VibrationTest) -> Corrected:
        """Return the tests with another one in the place of one."""
        return Corrected(what, (*self.tests[:k], test, *self.tests[k + 1 :]), (k,))

    def positions(self) -> Iterator[Corrected]:
        """Yield tests with other positions: mirrored, in degrees or mm, of exchanged joints or tests."""
        names = list(dict.fromkeys(name for test in self.tests for name in test.at))
        sigma = {joint.name: joint.sigma for joint in self.machine.joints}
        groups = [[name] for name in names] + ([names] if len(names) > 1 else [])
        for group in groups:
            what = f"{AT}{', '.join(group)} {'has' if len(group) == 1 else 'have'} the opposite sign"
            yield from self.each(what, partial(_scaled, names=group, factor=-1.0))
            for kind, factor, unit in ((0, DEGREE, "degrees, not rad"), (1, MILLIMETRE, "mm, not m")):
                own = [name for name in group if sigma.get(name) == kind]
                if own and (len(group) == 1 or len(own) > 1):
                    what = f"{AT}{', '.join(own)} {'is' if len(own) == 1 else 'are'} in {unit}"
                    yield from self.each(what, partial(_scaled, names=own, factor=factor))
        for a, b in combinations(names, 2):
            yield from self.each(f"{AT}{a} and {b} are exchanged", partial(_exchanged, a=a, b=b))
        for i, j in combinations(range(len(self.tests)), 2):
            a_test, b_test = self.tests[i], self.tests[j]
            if a_test.at != b_test.at:
                at = {i: b_test.at, j: a_test.at}
                found = tuple(replace(t, at=at.get(k, t.at)) for k, t in enumerate(self.tests))
                yield Corrected(f"{AT}the positions of these two are exchanged", found, (i, j))

    def zeros(self) -> Iterator[Corrected]:
        """Yield tests with other zeros of a joint that moves, some apart."""
        at = {
            joint.name: joint.sigma for joint in self.machine.motor_joints if joint in self.machine.independent_joints
        }
        for name, sigma in at.items():
            yield from (self.with_zero(name, sign * zero) for zero in ZEROS[sigma] for sign in (1, -1))

    def with_zero(self, name: str, zero: float) -> Corrected:
        """Return the tests with another zero of a joint."""
        found = [test.with_zero(name, zero) for test in self.tests]
        unit = next("m" if joint.sigma == 1 else "rad" for joint in self.machine.motor_joints if joint.name == name)
        what = f"{AT}the zero of {name} is off: add {zero:.4g} {unit} to its positions"
        return Corrected(what, tuple(found), tuple(range(len(found))), name, zero)

    def held(self) -> Iterator[Corrected]:
        """Yield tests with other motors held, free, or under a servo whose gains are unknown."""
        for names in self._groups_of_motors():
            for how in (HELD, FREE, SERVO):
                what = f"hold: {', '.join(names)} {'was' if len(names) == 1 else 'were'} {how}"
                yield from self.each(what, partial(_moved, names=names, how=how, motors=self.motors))

    def _groups_of_motors(self) -> list[tuple[str, ...]]:
        most = len(self.motors) if len(self.motors) <= MOST_TOGETHER else 1
        found = [group for n in range(1, most + 1) for group in combinations(self.motors, n)]
        return found if most == len(self.motors) else [*found, tuple(self.motors)]

    def signals(self) -> Iterator[Corrected]:
        """Yield tests with another axis, a moment for a force, another body, and either sign, of input or output."""
        pairs = [(one.output, one.input) for test in self.tests for one in test.responses]
        for side, others in ((0, self.other_outputs), (1, self._other_inputs)):
            for name in dict.fromkeys(pair[side] for pair in pairs):
                for other, sign in [(name, -1.0), *product(others(name), (1.0, -1.0))]:
                    what = f"{name} is {'-' if sign < 0 else ''}{other}"
                    for one in self.each(what, partial(_named, side=side, name=name, other=other, sign=sign)):
                        yield replace(one, is_sign=other == name)

    def other_outputs(self, name: str) -> Iterator[str]:
        """Yield the outputs that one may be in place of: other axes of its frame, other frames or joints."""
        owner, _, quantity = name.rpartition(".")
        if quantity in JOINT_OUTPUTS:
            yield from (f"{other}.{quantity}" for other in self._moving if other != owner)
            return
        order = FRAME_OUTPUTS[quantity][0]
        yield from (f"{owner}.{one}" for one, (of, _) in FRAME_OUTPUTS.items() if of == order and one != quantity)
        yield from (f"{other}.{quantity}" for other in self._frames if other != owner)

    def _other_inputs(self, name: str) -> Iterator[str]:
        owner, _, quantity = name.rpartition(".")
        if quantity == MOTOR_TORQUE:
            yield from (f"{other}.{quantity}" for other in self._moving if other != owner and other in self.motors)
            return
        yield from (f"{owner}.{one}" for one in WRENCH_INPUTS if one != quantity)
        yield from (f"{other}.{quantity}" for other in self._frames if other != owner)

    @cached_property
    def _frames(self) -> list[str]:
        return [joint.name for joint in self.machine.joints]

    @cached_property
    def _moving(self) -> list[str]:
        """Joints whose motion is free, and whose motors no test holds."""
        held = {name for test in self.tests for name in held_in(test, self.motors)}
        return [joint.name for joint in self.machine.independent_joints if joint.name not in held]


def _scaled(test: VibrationTest, names: Sequence[str], factor: float) -> VibrationTest:
    """Return a test at positions of some joints times a factor; a zero has no sign."""
    if not any(test.at.get(name) for name in names):
        return test
    return replace(test, at={name: factor * x if name in names and x else x for name, x in test.at.items()})


def _exchanged(test: VibrationTest, a: str, b: str) -> VibrationTest:
    """Return a test at exchanged positions of two joints."""
    at = {name: x for name, x in test.at.items() if name not in (a, b)}
    if test.at.get(a, 0.0) == test.at.get(b, 0.0):
        return test
    return replace(test, at={**at, a: test.at.get(b, 0.0), b: test.at.get(a, 0.0)})


def _moved(test: VibrationTest, names: Sequence[str], how: str, motors: Sequence[str]) -> VibrationTest:
    """Return a test with motors held, free, or under a servo; the same where they are already."""
    held = held_in(test, motors)
    now = {HELD: set(held), SERVO: {*test.pd, *test.drives}}
    now[FREE] = {*motors} - now[HELD] - now[SERVO]
    if {*names} & now[how]:
        return test
    hold = tuple(name for name in motors if name in held and name not in names)
    pd = {name: gains for name, gains in test.pd.items() if name not in names}
    drives = tuple(name for name in test.drives if name not in names)
    if how == HELD:
        hold = tuple(name for name in motors if name in {*hold, *names})
    if how == SERVO:
        pd |= dict.fromkeys(names)
    return replace(test, hold=hold, pd=pd, drives=drives)


def _named(test: VibrationTest, side: int, name: str, other: str, sign: float) -> VibrationTest:
    """Return a test whose output (side 0) or input (1) of a name is another; the same where that is there."""
    pairs, found = {(one.output, one.input) for one in test.responses}, []
    for one in test.responses:
        if (one.output, one.input)[side] != name:
            found.append(one)
            continue
        new = replace(one, output=other, H=sign * one.H) if side == 0 else replace(one, input=other, H=sign * one.H)
        if other != name and (new.output, new.input) in pairs:
            return test
        found.append(new)
    return replace(test, responses=tuple(found))
