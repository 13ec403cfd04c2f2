"""The operating point of a machine, and the linearization there."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import click

from symoro_elastic.cli import completion
from symoro_elastic.cli.options import AT, VALUE, Command, gather
from symoro_elastic.cli.parsing import gains, numbers, numbers_or_none, parsed_by
from symoro_elastic.cli.reading import read_restricted

if TYPE_CHECKING:
    from symoro_elastic.api.vibrations import OperatingPoint
    from symoro_elastic.vibration.linearization import Linearization


@dataclass(frozen=True)
class Situation:
    """Positions, velocities and torques by joint, held motors, controller gains and parameter values."""

    positions: Mapping[str, float]
    torques: Mapping[str, float]
    rates: Mapping[str, float]
    as_given: bool
    hold: Sequence[str]
    gains: Mapping[str, tuple[float, float]]
    values: Mapping[str, float]
    hover: bool
    thrusts: Mapping[str, float | None]

    @property
    def point(self) -> OperatingPoint:
        """The operating point."""
        from symoro_elastic.api.vibrations import OperatingPoint

        return OperatingPoint(
            self.positions, self.torques, self.rates, self.as_given, self.hold, self.gains, self.hover, self.thrusts
        )

    def linearization(self, path: str, inputs: Sequence[str] = (), outputs: Sequence[str] = ()) -> Linearization:
        """Return the machine of a file linearized here, with its motors held or controlled."""
        return self.point.linearization(read_restricted(path), self.values, inputs, outputs)


OPTIONS = (
    AT,
    click.option(
        "--torque",
        "torques",
        metavar="MOTOR=X",
        multiple=True,
        callback=parsed_by(numbers),
        help="Torque or force of a motor that is free to move to its equilibrium.",
    ),
    click.option(
        "--rate",
        "rates",
        metavar="JOINT=X",
        multiple=True,
        callback=parsed_by(numbers),
        help="Velocity of a joint, with --as-given.",
    ),
    click.option(
        "--as-given", is_flag=True, help="Take --at, --rate and --torque as the state instead of an equilibrium."
    ),
    click.option(
        "--hold",
        metavar="MOTOR|all",
        multiple=True,
        shell_complete=completion.MOTORS,
        help="Motor that is held (default: motors are free).",
    ),
    click.option(
        "--pd",
        "gains",
        metavar="MOTOR=KP:KD",
        multiple=True,
        callback=parsed_by(gains),
        help="Gains of a motor's position controller.",
    ),
    click.option(
        "--hover", is_flag=True, help="Carry a floating base in place by a force and a moment of constant direction."
    ),
    click.option(
        "--thrust",
        "thrusts",
        metavar="FRAME.fz[=X]",
        multiple=True,
        callback=parsed_by(numbers_or_none),
        help="Force or moment that turns with its frame and carries a floating base (fx ... mz, N or N m; without X it "
        "is found); may be repeated.",
    ),
    VALUE,
)


def takes_situation(command: Command) -> Command:
    """Add the options of an operating point to a command, which takes them as `situation`."""
    command = gather("situation", Situation)(command)
    for option in reversed(OPTIONS):
        command = option(command)
    return command
