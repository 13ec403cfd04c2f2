"""Usual mistakes of vibration tests, undone: rows of positions, held motors, signals, responses and modes."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from enum import StrEnum
from functools import cached_property, partial
from itertools import combinations, product

import numpy as np

from symoro_elastic.foundation.array_types import Array, ComplexArray
from symoro_elastic.machine.machine import Machine
from symoro_elastic.measured.fitting.corrections import Correction
from symoro_elastic.measured.vibration_tests.measured import MeasuredModes, MeasuredResponse, VibrationTest
from symoro_elastic.measured.vibration_tests.unknowns import held_in
from symoro_elastic.numerics.motion.signals import FRAME_OUTPUTS, JOINT_OUTPUTS, MOTOR_TORQUE, WRENCH_INPUTS

MOST_TOGETHER = 3  # largest number of motors of which all combinations are rows
AT = "at: "
ZEROS = (np.geomspace(0.1, math.pi, 14).tolist(), np.geomspace(0.02, 0.8, 6).tolist())
"""Of joints that turn, rad, and that slide, m: zeros that are tried."""
HELD, FREE, SERVO = "held", "free", "under a servo"


Undone = Callable[[ComplexArray, ComplexArray], ComplexArray]
"""A right response from a wrong one H and s = 2 pi i f."""
WRITTEN: dict[str, Undone] = {
    "with the opposite sign": lambda H, s: -H,
    "with imaginary parts of the opposite sign": lambda H, s: H.conj(),
    "with real and imaginary parts exchanged": lambda H, s: 1j * H.conj(),
    "in g, not in m/s2": lambda H, s: 9.80665 * H,
    "in m/s2, not in g": lambda H, s: H / 9.80665,
    "in mm, not in m, or in N, not in kN": lambda H, s: 1e-3 * H,
    "in m, not in mm, or in kN, not in N": lambda H, s: 1e3 * H,
    "as velocities, not accelerations, or displacements, not velocities": lambda H, s: s * H,
    "as displacements, not accelerations": lambda H, s: s**2 * H,
    "as accelerations, not velocities, or velocities, not displacements": lambda H, s: H / s,
    "as accelerations, not displacements": lambda H, s: H / s**2,
    "as inputs over outputs": lambda H, s: 1 / H,
}
"""How a response may be written, and how that is undone."""
RADIANS = "over frequencies in rad/s, not in Hz"

FACTORS_F = {
    "frequencies are in rad/s, not in Hz": 1 / (2 * math.pi),
    "frequencies are in turns a minute, not in Hz": 1 / 60,
    "frequencies are in kHz, or times in ms, and are called Hz and s": 1e3,
    "frequencies are in Hz, and are called kHz": 1e-3,
}
FACTORS_ZETA = {
    "damping ratios are in percent: write damping_ratio [%]": 1e-2,
    "damping ratios are in 1, not in percent": 1e2,
    "damping ratios are logarithmic decrements, which are 2 pi times as large": 1 / (2 * math.pi),
    "damping ratios are loss factors, which are twice as large": 0.5,
}


Row = Correction[tuple[VibrationTest, ...]]
"""Tests without a mistake."""


class Kind(StrEnum):
    """Kind of a correction: the part of the tests that it changes; SIGN is the sign of a signal alone."""

    RESPONSES = "responses"
    SIGNALS = "signals"
    SIGN = "sign"
    POSITIONS = "positions"
    ZERO = "zero"
    MOTORS = "motors"
    LIST_OF_MODES = "list of modes"
    MODE = "mode"


def files(row: Row) -> str:
    """Return the names of the tests that a row changes."""
    return ", ".join(dict.fromkeys(row.data[k].name for k in row.changed))


class ListedTests:
    """Listed tests of a machine, and variants of them without a usual mistake in the list."""

    def __init__(self, machine: Machine, tests: Sequence[VibrationTest]) -> None:
        self.machine, self.tests = machine, tuple(tests)
        self.motors = [joint.name for joint in machine.motor_joints]

    @cached_property
    def scopes(self) -> list[tuple[int, ...]]:
        """Indices of the tests that a mistake may concern: all tests, then each test alone."""
        every = tuple(range(len(self.tests)))
        return [every, *((k,) for k in every)] if len(every) > 1 else [every]

    def _rows(self, kind: str, name: str, of: Callable[[VibrationTest], VibrationTest]) -> Iterator[Row]:
        """Yield corrections of all tests, and of each test alone."""
        for scope in self.scopes:
            tests = tuple(of(test) if k in scope else test for k, test in enumerate(self.tests))
            changed = tuple(k for k in scope if tests[k] is not self.tests[k])
            if changed and (len(scope) == 1 or len(changed) > 1):
                yield Correction(name, tests, changed, kind)

    def responses(self) -> Iterator[Row]:
        """Yield tests with corrected responses: in another form or unit, frequencies in rad/s, exchanged signals."""
        for what, undone in WRITTEN.items():
            of = partial(_with_each_response, of=partial(_rewritten, undone))
            yield from self._rows(Kind.RESPONSES, f"are written {what}", of)
        yield from self._rows(Kind.RESPONSES, f"are written {RADIANS}", partial(_with_each_response, of=_in_hertz))
        responses = [response for test in self.tests for response in test.responses]
        for names in ({r.output: None for r in responses}, {r.input: None for r in responses}):
            for a, b in combinations(names, 2):
                if a[:-1] == b[:-1]:
                    of = partial(_with_exchanged_signals, names={a: b, b: a})
                    yield from self._rows(Kind.RESPONSES, f"are written with {a} and {b} exchanged", of)

    def positions(self) -> Iterator[Row]:
        """Yield tests with corrected positions: opposite signs, other units, exchanged joints or tests."""
        names = list(dict.fromkeys(name for test in self.tests for name in test.at))
        sigma = {joint.name: joint.sigma for joint in self.machine.joints}
        groups = [[name] for name in names] + ([names] if len(names) > 1 else [])
        for group in groups:
            what = f"{AT}{', '.join(group)} {'has' if len(group) == 1 else 'have'} the opposite sign"
            yield from self._rows(Kind.POSITIONS, what, partial(_with_scaled_positions, names=group, factor=-1.0))
            for kind, factor, unit in ((0, math.radians(1), "degrees, not rad"), (1, 1e-3, "mm, not m")):
                own = [name for name in group if sigma.get(name) == kind]
                if own and (len(group) == 1 or len(own) > 1):
                    what = f"{AT}{', '.join(own)} {'is' if len(own) == 1 else 'are'} in {unit}"
                    yield from self._rows(
                        Kind.POSITIONS, what, partial(_with_scaled_positions, names=own, factor=factor)
                    )
        for a, b in combinations(names, 2):
            yield from self._rows(
                Kind.POSITIONS, f"{AT}{a} and {b} are exchanged", partial(_with_exchanged_positions, a=a, b=b)
            )
        for i, j in combinations(range(len(self.tests)), 2):
            a_test, b_test = self.tests[i], self.tests[j]
            if a_test.at != b_test.at:
                at = {i: b_test.at, j: a_test.at}
                tests = tuple(replace(t, at=at.get(k, t.at)) for k, t in enumerate(self.tests))
                yield Correction(f"{AT}the positions of these two are exchanged", tests, (i, j), Kind.POSITIONS)

    def zeros(self) -> Iterator[Row]:
        """Yield tests with other zero positions of motor joints, one family of corrections for each joint."""
        for joint in self.machine.motor_joints:
            if joint in self.machine.independent_joints:
                zeros = (sign * size for size in ZEROS[joint.sigma] for sign in (1, -1))
                yield from (self._zero(joint.name, joint.unit, zero) for zero in zeros)

    def _zero(self, joint: str, unit: str, zero: float) -> Row:
        """Return the tests with another zero of a joint."""
        tests = tuple(test.with_zero(joint, zero) for test in self.tests)
        name = f"{AT}the zero of {joint} is off: add {zero:.4g} {unit} to its positions"
        return Correction(
            name, tests, tuple(range(len(tests))), Kind.ZERO, joint, zero, partial(self._zero, joint, unit)
        )

    def motors_held(self) -> Iterator[Row]:
        """Yield tests with other sets of motors locked, free, or under a servo with unknown gains."""
        for names in self._groups_of_motors():
            for how in (HELD, FREE, SERVO):
                what = f"hold: {', '.join(names)} {'was' if len(names) == 1 else 'were'} {how}"
                yield from self._rows(Kind.MOTORS, what, partial(_driven, names=names, how=how, motors=self.motors))

    def _groups_of_motors(self) -> list[tuple[str, ...]]:
        most = len(self.motors) if len(self.motors) <= MOST_TOGETHER else 1
        groups = [group for n in range(1, most + 1) for group in combinations(self.motors, n)]
        return groups if most == len(self.motors) else [*groups, tuple(self.motors)]

    def signals(self) -> Iterator[Row]:
        """Yield tests with another axis, body, quantity or sign of an input or output."""
        pairs = [(response.output, response.input) for test in self.tests for response in test.responses]
        for side, alternatives in ((0, self.other_outputs), (1, self._other_inputs)):
            for name in dict.fromkeys(pair[side] for pair in pairs):
                for other, sign in [(name, -1.0), *product(alternatives(name), (1.0, -1.0))]:
                    what = f"{name} is {'-' if sign < 0 else ''}{other}"
                    of = partial(_with_signal, side=side, name=name, other=other, sign=sign)
                    yield from self._rows(Kind.SIGN if other == name else Kind.SIGNALS, what, of)

    def modes(self) -> Iterator[Row]:
        """Yield tests with modes in another unit, or with another sign, order or name of their outputs."""
        for what, factor in FACTORS_F.items():
            yield from self._rows(Kind.LIST_OF_MODES, what, partial(_with_modes, of=partial(_times, f=factor)))
        for what, factor in FACTORS_ZETA.items():
            yield from self._rows(Kind.LIST_OF_MODES, what, partial(_with_modes, of=partial(_times, zeta=factor)))
        names = list(dict.fromkeys(name for test in self.tests if test.modes for name in test.modes.outputs))
        renamed = [(f"{name} is {other}", {name: other}, "") for name in names for other in self.other_outputs(name)]
        renamed += [(f"{name} has the opposite sign", {}, name) for name in names]
        renamed += [(f"{a} and {b} are exchanged", {a: b, b: a}, "") for a, b in combinations(names, 2)]
        for what, outputs, opposite in renamed:
            of = partial(_with_outputs, names=outputs, opposite=opposite)
            yield from self._rows(Kind.LIST_OF_MODES, what, partial(_with_modes, of=of))

    def single_modes(self) -> Iterator[Row]:
        """Yield tests without one of their modes, and with the opposite sign of one amplitude."""
        for t, test in enumerate(self.tests):
            if test.modes is None or len(test.modes.f) < 2:
                continue
            for k, f in enumerate(test.modes.f):
                wrong = [
                    ("is not of the model, is there twice, or its numbers are wrong", _without_mode(test.modes, k))
                ]
                for column, name in enumerate(test.modes.outputs):
                    wrong.append((f"has the opposite sign of {name}", _with_opposite(test.modes, k, column)))
                for what, modes in wrong:
                    tests = (*self.tests[:t], replace(test, modes=modes), *self.tests[t + 1 :])
                    yield Correction(f"mode {k + 1}, {f:.4g} Hz, {what}", tests, (t,), Kind.MODE)

    def other_outputs(self, name: str) -> Iterator[str]:
        """Yield outputs that may be meant instead of one: other axes of its frame, other frames or joints."""
        owner, _, quantity = name.rpartition(".")
        if quantity in JOINT_OUTPUTS:
            yield from (f"{other}.{quantity}" for other in self._moving if other != owner)
            return
        order = FRAME_OUTPUTS[quantity][0]
        yield from (f"{owner}.{axis}" for axis, (of, _) in FRAME_OUTPUTS.items() if of == order and axis != quantity)
        yield from (f"{other}.{quantity}" for other in self._frames if other != owner)

    def _other_inputs(self, name: str) -> Iterator[str]:
        owner, _, quantity = name.rpartition(".")
        if quantity == MOTOR_TORQUE:
            yield from (f"{other}.{quantity}" for other in self._moving if other != owner and other in self.motors)
            return
        yield from (f"{owner}.{axis}" for axis in WRENCH_INPUTS if axis != quantity)
        yield from (f"{other}.{quantity}" for other in self._frames if other != owner)

    @cached_property
    def _frames(self) -> list[str]:
        return [joint.name for joint in self.machine.joints]

    @cached_property
    def _moving(self) -> list[str]:
        """Joints whose motion is free, and whose motors no test holds."""
        held_motors = {name for test in self.tests for name in held_in(test, self.motors)}
        return [joint.name for joint in self.machine.independent_joints if joint.name not in held_motors]


def _with_scaled_positions(test: VibrationTest, names: Sequence[str], factor: float) -> VibrationTest:
    """Return a test at positions of some joints times a factor; a zero has no sign."""
    if not any(test.at.get(name) for name in names):
        return test
    return replace(test, at={name: factor * x if name in names and x else x for name, x in test.at.items()})


def _with_exchanged_positions(test: VibrationTest, a: str, b: str) -> VibrationTest:
    """Return a test at exchanged positions of two joints."""
    at = {name: x for name, x in test.at.items() if name not in (a, b)}
    if test.at.get(a, 0.0) == test.at.get(b, 0.0):
        return test
    return replace(test, at={**at, a: test.at.get(b, 0.0), b: test.at.get(a, 0.0)})


def _driven(test: VibrationTest, names: Sequence[str], how: str, motors: Sequence[str]) -> VibrationTest:
    """Return a test with motors held, free, or under a servo; the same where they are already."""
    held_motors = held_in(test, motors)
    now = {HELD: set(held_motors), SERVO: {*test.pd, *test.drives}}
    now[FREE] = {*motors} - now[HELD] - now[SERVO]
    if {*names} & now[how]:
        return test
    hold = tuple(name for name in motors if name in held_motors and name not in names)
    pd = {name: gains for name, gains in test.pd.items() if name not in names}
    drives = tuple(name for name in test.drives if name not in names)
    if how == HELD:
        hold = tuple(name for name in motors if name in {*hold, *names})
    if how == SERVO:
        pd |= dict.fromkeys(names)
    return replace(test, hold=hold, pd=pd, drives=drives)


def _with_signal(test: VibrationTest, side: int, name: str, other: str, sign: float) -> VibrationTest:
    """Return a test with another output (side 0) or input (1) in place of `name`; unchanged if that exists."""
    pairs, responses = {response.pair for response in test.responses}, []
    for response in test.responses:
        if (response.output, response.input)[side] != name:
            responses.append(response)
            continue
        output, input_ = (other, response.input) if side == 0 else (response.output, other)
        responses.append(replace(response, output=output, input=input_, H=sign * response.H))
        if other != name and responses[-1].pair in pairs:
            return test
    return replace(test, responses=tuple(responses))


def _with_each_response(test: VibrationTest, of: Callable[[MeasuredResponse], MeasuredResponse]) -> VibrationTest:
    return replace(test, responses=tuple(map(of, test.responses))) if test.responses else test


def _rewritten(undone: Undone, response: MeasuredResponse) -> MeasuredResponse:
    return replace(response, H=undone(response.H, laplace_of(response.f)))


def _in_hertz(response: MeasuredResponse) -> MeasuredResponse:
    return replace(response, f=response.f / (2 * math.pi))


def laplace_of(f: Array) -> ComplexArray:
    """Return s = 2 pi i f."""
    return np.asarray(2j * math.pi * f, dtype=complex)


def _with_exchanged_signals(test: VibrationTest, names: Mapping[str, str]) -> VibrationTest:
    """Return a test with signals of these names exchanged; pairs without partner stay."""
    by_pair = {(response.output, response.input): response for response in test.responses}
    exchanged = []
    for response in test.responses:
        pair = names.get(response.output, response.output), names.get(response.input, response.input)
        other = by_pair.get(pair, response)
        same = other is response or not np.array_equal(other.f, response.f)
        exchanged.append(response if same else replace(response, H=other.H, coherence=other.coherence))
    same = all(a is b for a, b in zip(exchanged, test.responses, strict=True))
    return test if same else replace(test, responses=tuple(exchanged))


def _with_modes(test: VibrationTest, of: Callable[[MeasuredModes], MeasuredModes | None]) -> VibrationTest:
    """Return a test with its modes changed by `of`; unchanged if it has none."""
    modes = None if test.modes is None else of(test.modes)
    return test if modes is None else replace(test, modes=modes)


def _times(modes: MeasuredModes, f: float = 1.0, zeta: float = 1.0) -> MeasuredModes | None:
    """Return modes with scaled frequencies and damping ratios; None where these are missing or not below 1."""
    if zeta != 1 and (modes.zeta is None or not np.nanmax(zeta * modes.zeta) < 1):
        return None
    std_f, ratio, std = (
        None if x is None else c * x for x, c in ((modes.std_f, f), (modes.zeta, zeta), (modes.std_zeta, zeta))
    )
    return replace(modes, f=f * modes.f, std_f=std_f, zeta=ratio, std_zeta=std)


def _with_outputs(modes: MeasuredModes, names: Mapping[str, str], opposite: str) -> MeasuredModes | None:
    """Return modes with other names of outputs, or the opposite sign of an output; None where nothing changes."""
    outputs = tuple(names.get(name, name) for name in modes.outputs)
    if modes.shapes is None or len(set(outputs)) < len(outputs):
        return None
    signs = np.array([-1.0 if name == opposite else 1.0 for name in modes.outputs])
    if outputs == modes.outputs and (signs > 0).all():
        return None
    return replace(modes, outputs=outputs, shapes=modes.shapes * signs)


def _without_mode(modes: MeasuredModes, k: int) -> MeasuredModes:
    """Return all modes but one."""
    numbers = modes.zeta, modes.std_f, modes.std_zeta
    zeta, std_f, std_zeta = (None if x is None else np.delete(x, k) for x in numbers)
    shapes = None if modes.shapes is None else np.delete(modes.shapes, k, axis=0)
    return replace(modes, f=np.delete(modes.f, k), zeta=zeta, std_f=std_f, std_zeta=std_zeta, shapes=shapes)


def _with_opposite(modes: MeasuredModes, k: int, column: int) -> MeasuredModes:
    """Return modes with the opposite sign of an amplitude of mode k."""
    shapes = np.array(modes.shapes)
    shapes[k, column] *= -1
    return replace(modes, shapes=shapes)
