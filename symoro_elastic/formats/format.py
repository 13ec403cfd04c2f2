"""The interface of a file format."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from symoro_elastic.formats.files import UTF_8
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.described import DescribedMachine
from symoro_elastic.machine.format_names import FormatName
from symoro_elastic.machine.machine import Machine

if TYPE_CHECKING:
    from symoro_elastic.formats.robots.robot import Description


MOST_SNAP = 1e-3
"""Largest tolerance, rad and m: beyond it other angles are meant."""


@dataclass(frozen=True)
class Format:
    """A text format of machine files: its name and suffixes, and functions to read and write it.

    The text of a file is in the first of `encodings` that it fits.
    `read(text, source)` gives the machine, not yet checked, and raises `InputError` that names `source`, the path of
    the file; `write(machine)` gives the text, and raises `InputError` for what the format cannot hold. Without
    `write` the format is read only. Formats of robots as links and joints, whose names may be any, are read in two
    steps: `describe(text, source)` gives the links and joints.
    """

    named: FormatName
    read: Callable[[str, str], DescribedMachine]
    write: Callable[[Machine], str] | None = None
    encodings: tuple[str, ...] = (UTF_8,)
    describe: Callable[[str, str], Description] | None = None

    @property
    def title(self) -> str:
        """Title of the format."""
        return self.named.title

    @property
    def suffixes(self) -> tuple[str, ...]:
        """Suffixes of files in the format."""
        return self.named.suffixes


@dataclass(frozen=True)
class SpringOnJoint:
    """A spring between the motor and the load of a joint: stiffness, N m/rad or N/m, and rotor inertia, kg m2 or kg.

    The inertia is as the joint feels it; None keeps that of the file.
    """

    stiffness: float
    rotor_inertia: float | None = None


@dataclass(frozen=True)
class Conversion:
    """Changes to a robot before it is converted to a machine: rounding tolerance, and springs of joints.

    `snap` is the tolerance, rad and m, within which angles become multiples of pi/12 and lengths of robots as links and
    joints zero; None leaves these as they are. `springs` are put behind the motors of joints.
    """

    snap: float | None = None
    springs: Mapping[str, SpringOnJoint] = field(default_factory=dict)

    @classmethod
    def of(cls, snap: float | None, springs: Mapping[str, float | Sequence[float]]) -> Conversion | None:
        """Return the conversion with this tolerance and these springs by joint; None without changes.

        A spring is its stiffness, alone or with the inertia of the rotor.
        """
        springs_by_joint = {
            name: SpringOnJoint(*x) if isinstance(x, Sequence) else SpringOnJoint(x) for name, x in springs.items()
        }
        if snap is not None and not 0 < snap <= MOST_SNAP:
            what = f"{snap:g} is not a tolerance, rad and m: give more than 0, at most {MOST_SNAP:g}"
            raise InputError("symoro-elastic", "--snap", what)
        return cls(snap, springs_by_joint) if springs_by_joint or snap is not None else None
