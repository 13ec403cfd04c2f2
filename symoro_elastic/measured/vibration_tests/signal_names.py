"""Names and units of what a test measured, as its file or `rename` writes them: `tool.ax / -tool.fz [g/N]`."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from functools import cached_property, partial

from symoro_elastic.analysis.time_series.reading import name_and_unit
from symoro_elastic.analysis.vibration.responses import quotient_unit
from symoro_elastic.formats.toml.vibration_tests import RENAME, ListedTest
from symoro_elastic.foundation.array_types import Array, ComplexArray
from symoro_elastic.foundation.errors import TWICE, InputError
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.names import list_of_names, quote
from symoro_elastic.numerics.motion.signals import Signal, input_unit, inputs, joint_signals, output_unit, outputs
from symoro_elastic.quantities.unit_reader import UnitError, conversion

Fail = Callable[[str], InputError]
"""Makes the error about a place of a file."""
_NODE = re.compile(r"(?P<node>\d+):(?P<sign>[+-]?)(?P<axis>R?[XYZ]|S)", re.ASCII)


@dataclass(frozen=True)
class FileResponse:
    """A response as its file has it: f (N) in Hz, H (N), which is `scale` times `unit`, None where it names none."""

    name: str
    unit: str | None
    f: Array
    H: ComplexArray
    coherence: Array | None
    place: str
    scale: float = 1.0


def split_pair(text: str) -> tuple[str, str] | None:
    """Return OUT and IN of `OUT/IN`; slashes in brackets belong to points. None where there is not one slash."""
    depth, slashes = 0, []
    for k, sign in enumerate(text):
        depth += (sign == "(") - (sign == ")")
        if sign == "/" and depth == 0:
            slashes.append(k)
    return (text[: slashes[0]].strip(), text[slashes[0] + 1 :].strip()) if len(slashes) == 1 else None


def pair_name(text: str) -> str:
    """Return the name of a pair of a file without spaces about its slash."""
    parts = split_pair(text)
    return "/".join(parts) if parts else text


def normal_name(text: str) -> tuple[str, float]:
    """Return a name such as `3:-Z/1:X` in positive directions, `3:+Z/1:+X`, and its sign; other texts as they are."""
    ends = [_NODE.fullmatch(end.strip()) for end in text.split("/")]
    sign = 1.0
    named = []
    for end in ends:
        if end is None:
            return text, 1.0
        sign *= -1.0 if end["sign"] == "-" else 1.0
        named.append(f"{int(end['node'])}:{'' if end['axis'] == 'S' else '+'}{end['axis']}")
    return "/".join(named), sign


@dataclass(frozen=True)
class _Given:
    """Meaning of a name in a file: signals, unit of the numbers (None if SI), their scale and sign."""

    text: str
    unit: str | None
    scale: float
    fail: Fail

    def factor(self, si: str) -> float:
        """Return the factor to SI units; raises `InputError` for a unit of another dimension."""
        if self.unit is None:
            return self.scale
        try:
            return self.scale * conversion(self.unit, si).number
        except UnitError as error:
            raise self.fail(f"{error}: write the unit behind the name, such as [{si}]") from None


@dataclass
class Names:
    """Names of a test's file as signals of a machine: renamed, with their signs and factors to SI units."""

    machine: Machine
    test: ListedTest
    used: set[str] = field(default_factory=set)
    known: dict[str, str] = field(default_factory=dict)
    """Names of the file by signals."""

    @cached_property
    def rename(self) -> dict[str, tuple[str, float]]:
        """Keys of `rename` with their signs, by names of the file: spaces do not count, directions are positive."""
        names: dict[str, tuple[str, float]] = {}
        for key in self.test.rename:
            name, sign = normal_name(pair_name(key))
            if name in names:
                raise self.test.fail(f"{RENAME.name}, {key}", f"{name} {TWICE}")
            names[name] = key, sign
        return names

    def pair(self, entry: FileResponse, source: str) -> tuple[str, str, float]:
        """Return output and input of a response and the factor to SI units, sign included; raises `InputError`."""
        signal = self._given(entry.name, entry.unit, partial(InputError, source, entry.place), entry.scale)
        parts = split_pair(signal.text)
        if parts is None:
            raise signal.fail(f"{quote(signal.text)} is not OUT/IN with signals of `response`, such as tool.ax/tool.fx")
        (sign, output), (other, into) = map(_sign_and_name, parts)
        output, into = self._signal(outputs, output, signal.fail), self._signal(inputs, into, signal.fail)
        si = quotient_unit(output_unit(self.machine, output), input_unit(self.machine, into))
        self._once(f"{output} / {into}", entry.name, signal.fail)
        return output, into, sign * other * signal.factor(si)

    def output(self, name: str, unit: str | None, fail: Fail) -> tuple[str, float]:
        """Return an output and the factor to SI units, sign included; raises `InputError`."""
        signal = self._given(name, unit, fail)
        sign, output = _sign_and_name(signal.text)
        output = self._signal(outputs, output, signal.fail)
        self._once(output, name, signal.fail)
        return output, sign * signal.factor(output_unit(self.machine, output))

    def refuse_unused(self, there: Iterable[str]) -> None:
        """Raise `InputError` for a name in `rename` that the file does not contain."""
        for name, (key, _) in self.rename.items():
            if name not in self.used:
                what = f"{self.test.file} has no such name; it has {list_of_names(there)}"
                raise self.test.fail(f"{RENAME.name}, {key}", what)

    def _given(self, name: str, unit: str | None, fail: Fail, scale: float = 1.0) -> _Given:
        """Return the signal that a name in the file denotes. A unit in `rename` replaces that of the file."""
        if name not in self.rename:
            return _Given(name, unit, scale, fail)
        key, sign = self.rename[name]
        self.used.add(name)
        text, other = name_and_unit(self.test.rename[key], is_pair=True)
        unit, scale = (unit, scale) if other is None else (other, 1.0)
        return _Given(text, unit, sign * scale, partial(self.test.fail, f"{RENAME.name}, {key}"))

    def _once(self, signal: str, name: str, fail: Fail) -> None:
        if signal in self.known:
            raise fail(f"{signal} is measured twice, by {self.known[signal]} too: keep one, or make two tests")
        self.known[signal] = name

    def _signal(self, find: Callable[[Machine, list[str]], list[Signal]], name: str, fail: Fail) -> str:
        """Return the full name of a movable signal of the machine."""
        try:
            full = find(self.machine, [name])[0].name
        except InputError as error:
            raise fail(error.what) from None
        for motor in self.test.hold:
            if full in joint_signals([motor]):
                raise fail(f"{full} is a signal of {motor}, which the test holds: correct the name, or hold")
        return full


def _sign_and_name(text: str) -> tuple[float, str]:
    signs = {"-": -1.0, "+": 1.0}
    return signs.get(text[:1], 1.0), (text[1:] if text[:1] in signs else text).strip()
