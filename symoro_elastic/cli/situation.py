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
from symoro_elastic.errors import InputError

if TYPE_CHECKING:
    from symoro_elastic.vibration.equations_of_motion import EquationsOfMotion, State
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

    def motion(self, path: str, inputs: Sequence[str] = (), outputs: Sequence[str] = ()) -> EquationsOfMotion:
        """Return the equations of motion of the machine in a file."""
        from symoro_elastic.vibration.hover import with_thrusts
        from symoro_elastic.vibration.linearization import motion_of

        return motion_of(with_thrusts(read_restricted(path), self.thrusts), dict(self.values), inputs, outputs)

    def held(self, motion: EquationsOfMotion) -> list[str]:
        """Names of the motors that are held."""
        return [motion.names[k] for k in motion.motors] if "all" in self.hold else list(self.hold)

    def state(self, motion: EquationsOfMotion) -> State:
        """Return the given state, or the equilibrium."""
        from symoro_elastic.vibration.equilibrium import equilibrium, given_state
        from symoro_elastic.vibration.hover import hover

        self._refuse_mixture()
        if self.thrusts and not self.as_given:
            return hover(motion, self.positions, self.thrusts)
        if self.as_given:
            return given_state(motion, self.positions, self.rates, self.torques)
        if self.rates:
            what = "an equilibrium is at rest: add --as-given, or leave it out"
            raise InputError("symoro-elastic", "--rate", what)
        return equilibrium(motion, self.positions, self.torques, self.hover)

    def _refuse_mixture(self) -> None:
        """Raise `InputError` for options that exclude each other."""
        unknown = [name for name, x in self.thrusts.items() if x is None]
        for wrong, option, what in (
            (self.hover and (self.thrusts or self.as_given), "--hover", "leave out --thrust and --as-given, or it"),
            (unknown and self.as_given, "--thrust", f"{unknown} is found for an equilibrium: give its size"),
            (
                self.thrusts and self.torques and not self.as_given,
                "--torque",
                "motors are held in a hover: leave it out",
            ),
        ):
            if wrong:
                raise InputError("symoro-elastic", option, what)

    def linearization(self, path: str, inputs: Sequence[str] = (), outputs: Sequence[str] = ()) -> Linearization:
        """Return the machine of a file linearized here, with its motors held or controlled."""
        from symoro_elastic.vibration.linearization import linearize, with_motors

        motion = self.motion(path, inputs, outputs)
        linear = linearize(motion, self.state(motion), inputs or None, outputs or None)
        found = with_motors(linear, self.held(motion), self.gains)
        _refuse_held_signals(linear, found, inputs, outputs)
        return found


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


def _refuse_held_signals(
    linear: Linearization, held: Linearization, inputs: Sequence[str], outputs: Sequence[str]
) -> None:
    """Raise `InputError` where an input or output was requested that belongs to a held motor."""
    for option, asked, before, left in (
        ("--input", inputs, linear.inputs, held.inputs),
        ("--output", outputs, linear.outputs, held.outputs),
    ):
        still = [name for name in before if name not in left]
        if asked and still:
            what = f"{still[0]} is of a motor that is held, so nothing moves there: leave out one of the two"
            raise InputError(linear.motion.source, option, what)
