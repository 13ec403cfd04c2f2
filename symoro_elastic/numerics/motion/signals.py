"""Names of inputs (`motor_x.tau`, `tool.fx`) and outputs (`motor_x.q`, `tool.x`, `tool.ax`).

A frame may be moved to a point of its body: `tool at (0.1, 0, L2).fx`. Directions are axes of frame 0.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass

from symoro_elastic.foundation.errors import reported_places
from symoro_elastic.machine.formula import FormulaError
from symoro_elastic.machine.frames import FrameNames, Points, points_of
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.names import no_such, quote, undeclared
from symoro_elastic.machine.prescribed_motion import WRENCH
from symoro_elastic.machine.scene import COMPONENTS, Point, RequestedPart

INPUT, OUTPUT = "--input", "--output"
MOTOR_TORQUE = "tau"
JOINT_OUTPUTS = {"q": 0, "qd": 1, "qdd": 2}
WRENCH_INPUTS = {name: k for k, name in enumerate(WRENCH)}
FRAME_OUTPUTS = {
    **{name: (0, k) for k, name in enumerate(COMPONENTS)},
    **{name: (1, k) for k, name in enumerate(("vx", "vy", "vz", "wx", "wy", "wz"))},
    **{name: (2, k) for k, name in enumerate(("ax", "ay", "az", "wdx", "wdy", "wdz"))},
}


@dataclass(frozen=True)
class JointSignal:
    """Torque of a motor, or position (0), velocity (1), acceleration (2) of a joint coordinate, by its number."""

    name: str
    number: int
    order: int = 0


@dataclass(frozen=True)
class FrameSignal:
    """Component of a wrench on frame `number`, or of its position (0), velocity (1), acceleration (2).

    Components 0-2 are linear, 3-5 angular (rotations are small), in axes of frame 0; `at` is a point in the frame.
    """

    name: str
    number: int
    component: int
    order: int = 0
    at: Point | None = None


Signal = JointSignal | FrameSignal


def inputs(machine: Machine, names: Iterable[str]) -> list[Signal]:
    """Return inputs by name; a motor alone means its torque. Raises `InputError` for unknown names."""
    return [_input(machine, " ".join(name.split())) for name in names]


def outputs(machine: Machine, names: Iterable[str]) -> list[Signal]:
    """Return outputs by name; a joint alone means its position. Raises `InputError` for unknown names."""
    return [_output(machine, " ".join(name.split())) for name in names]


def positions(machine: Machine, names: Iterable[str], place: str) -> list[Signal]:
    """Return outputs that are positions; raises `InputError` that names this place for others."""
    with reported_places({OUTPUT: place}):
        signals = outputs(machine, names)
    for signal in signals:
        if signal.order:
            raise machine.error(place, f"{signal.name} is no position: name one, such as tool.x or motor.q")
    return signals


def default_inputs(machine: Machine) -> list[str]:
    """Return the torques of all motors."""
    return [f"{joint.name}.{MOTOR_TORQUE}" for joint in machine.motor_joints]


def default_outputs(machine: Machine) -> list[str]:
    """Return the encoders of all motors."""
    return [f"{joint.name}.q" for joint in machine.motor_joints]


def input_unit(machine: Machine, name: str) -> str:
    """Return the unit of an input: N or N m."""
    (signal,) = inputs(machine, [name])
    if isinstance(signal, JointSignal):
        return machine.joint(signal.number).force_unit
    return "N" if signal.component < 3 else "N m"


def output_unit(machine: Machine, name: str) -> str:
    """Return the unit of an output: m, rad, m/s ... rad/s2."""
    (signal,) = outputs(machine, [name])
    turns = signal.component > 2 if isinstance(signal, FrameSignal) else machine.joint(signal.number).sigma == 0
    return ("rad" if turns else "m") + ("", "/s", "/s2")[signal.order]


def joint_signals(names: Iterable[str]) -> set[str]:
    """Return the torques, positions, velocities and accelerations of joints."""
    return {f"{name}.{quantity}" for name in names for quantity in (MOTOR_TORQUE, *JOINT_OUTPUTS)}


def entry_of(machine: Machine, signal: JointSignal) -> int:
    """Return the index in q of the joint of a signal; raises `InputError` for a joint that follows from others."""
    if signal.number not in machine.independent:
        what = machine.why_dependent(machine.joint(signal.number).name)
        raise machine.error(OUTPUT, f"{quote(signal.name)}: {what}")
    return machine.independent.index(signal.number)


def points_of_signals(machine: Machine, signals: Sequence[Signal]) -> Points:
    """Return the frames of signals that have no row, each once."""
    return points_of(machine, ((s.number, s.at) for s in signals if isinstance(s, FrameSignal)))


def _input(machine: Machine, name: str) -> Signal:
    owner, quantity = _split(machine, name, INPUT, {MOTOR_TORQUE, *WRENCH_INPUTS}, MOTOR_TORQUE)
    if quantity in WRENCH_INPUTS:
        return _frame(machine, name, owner, WRENCH_INPUTS[quantity], 0, INPUT)
    j = _joint(machine, name, owner, INPUT)
    if j not in machine.motors:
        what = f"{quote(name)}: {machine.why_no_motor(owner)}; or name <frame>.{'|'.join(WRENCH_INPUTS)}"
        raise machine.error(INPUT, what)
    return JointSignal(f"{owner}.{MOTOR_TORQUE}", j)


def _output(machine: Machine, name: str) -> Signal:
    owner, quantity = _split(machine, name, OUTPUT, {*JOINT_OUTPUTS, *FRAME_OUTPUTS}, "q")
    if quantity in FRAME_OUTPUTS:
        order, component = FRAME_OUTPUTS[quantity]
        return _frame(machine, name, owner, component, order, OUTPUT)
    return JointSignal(f"{owner}.{quantity}", _joint(machine, name, owner, OUTPUT), JOINT_OUTPUTS[quantity])


def _split(machine: Machine, name: str, place: str, known: Collection[str], usual: str) -> tuple[str, str]:
    """Return owner and quantity of a signal; a joint alone has its default quantity."""
    if name in {joint.name for joint in machine.joints if joint.sigma != 2}:
        return name, usual
    owner, dot, quantity = name.rpartition(".")
    if not dot or quantity not in known:
        what = f"{quote(name)} is not NAME.QUANTITY with a quantity of {', '.join(sorted(known))}"
        meant = f"{owner}.{quantity.lower()}"
        if dot and quantity.lower() in known:
            what += f"; did you mean {quote(meant)}?"
        raise machine.error(place, what)
    return owner, quantity


def _joint(machine: Machine, name: str, owner: str, place: str) -> int:
    """Return the number of a joint, independent or not, that has a variable."""
    numbers = {machine.joint(j).name: j for j in machine.with_variable}
    if owner not in numbers:
        raise machine.error(place, f"{quote(name)}: {no_such('moving joint', owner, numbers)}")
    return numbers[owner]


def _frame(machine: Machine, name: str, owner: str, component: int, order: int, place: str) -> FrameSignal:
    try:
        part = RequestedPart.parse(owner)
    except FormulaError as error:
        raise machine.error(place, f"{quote(name)}: {error}") from None
    names, moving = FrameNames(machine), machine.degrees_of_base > 0
    number = names.number(part.name, or_frame_0=moving and not part.at)
    if number == 0:
        return FrameSignal(name, 0, component, order)
    if part.seen_from:
        raise machine.error(place, f"{quote(name)}: directions are axes of frame 0: leave out 'in {part.seen_from}'")
    if number is None:
        raise machine.error(place, f"{quote(name)}: {no_such('frame', part.name, names.own)}")
    if reason := machine.no_frame_of_mode(number):
        raise machine.error(place, f"{quote(name)}: {reason}")
    unknown = sorted(set().union(*(cell.names for cell in part.at or ())) - machine.parameter_names)
    if unknown:
        raise machine.error(place, f"{quote(name)}: {undeclared(unknown[0], machine.parameter_names)}")
    return FrameSignal(name, number, component, order, part.at)
