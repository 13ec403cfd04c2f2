"""The variables of an FMU as data: names, references, units, starts, nominals."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from symoro_elastic.generation.fmu.programs import Given, NamedCell, Output, Programs
from symoro_elastic.generation.fmu.start import Start
from symoro_elastic.machine.machine import Joint
from symoro_elastic.quantities.unit_reader import in_base_units

WRENCH = (("fx", "N"), ("fy", "N"), ("fz", "N"), ("mx", "N m"), ("my", "N m"), ("mz", "N m"))
IDLE = "in no equation of this machine: nothing depends on it"
"""Said of a parameter of a body whose inertia does not act there, as that about axes that it never turns about."""
NOT_NEGATIVE = ("mass", "stiffness")
"""Quantities whose variables have a least value."""
DIGITS = 2
"""Of nominal values."""


@dataclass(frozen=True)
class Variable:
    """A variable: its name, value reference, unit, role in the words of FMI, start and nominal values.

    `derivative_of` is the reference of the state that it is the derivative of.
    """

    name: str
    reference: int
    unit: str
    description: str
    causality: str = "local"
    variability: str = "continuous"
    initial: str = ""
    start: str | None = None
    nominal: str | None = None
    minimum: str | None = None
    derivative_of: int | None = None

    @property
    def shown_in(self) -> str:
        """The unit that tools display, where it is another one: deg for rad; else empty."""
        return "deg" if self.unit == "rad" else ""


@dataclass(frozen=True)
class Block:
    """Adjacent variables: the name of their first reference in C, and their meaning."""

    name: str
    meaning: str
    variables: tuple[Variable, ...]
    first: int


@dataclass(frozen=True)
class Layout:
    """All variables, in blocks in the order of their value references; the time is reference 0."""

    blocks: tuple[Block, ...]

    @cached_property
    def variables(self) -> list[Variable]:
        """The variables in order, the time first."""
        time = Variable("time", 0, "s", "time", "independent")
        return [time, *(variable for block in self.blocks for variable in block.variables)]

    def block(self, name: str) -> tuple[Variable, ...]:
        """Return the variables of a block."""
        return next((block.variables for block in self.blocks if block.name == name), ())

    @property
    def states(self) -> tuple[Variable, ...]:
        """Positions, velocities, then states of friction and drives."""
        return (*self.block("Q"), *self.block("QD"), *self.block("Z"))


def layout_of(programs: Programs, start: Start) -> Layout:
    """Return the variables of an FMU; names are those of `linearize`: `motor_x.tau`, `tool.fx`, `ram.q`, `tool.x`."""
    joints = programs.machine.independent_joints
    rates = [Variable(f"der({x})", 0, "", f"rate of {x}", initial="calculated") for x in programs.states]
    parts = (
        ("INPUT", "forces of motors, wrenches on frames", _inputs(programs, start)),
        ("Q", "joint variables", _states(joints, "q", "", start.q.tolist(), start.positions.tolist())),
        ("QD", "joint velocities", _states(joints, "qd", "/s", [0.0] * len(joints), start.velocities.tolist())),
        *([("Z", "states of friction, then of drives", _further(programs, start))] if programs.states else []),
        ("DER_Q", "derivatives of joint variables", _derivatives(joints, "q", "/s")),
        ("DER_QD", "joint accelerations", _derivatives(joints, "qd", "/s2")),
        *([("DER_Z", "rates of states of friction and drives", rates)] if programs.states else []),
        *([] if programs.given is Given.TORQUES else [("TAU_M", "torques of motors", _torques(programs))]),
        ("Y", "outputs that are not states", map(_output, programs.outputs)),
        ("P", "parameters", _parameters(programs)),
    )
    blocks: list[Block] = []
    first = 1
    for name, meaning, variables in parts:
        numbered = tuple(replace(variable, reference=first + k) for k, variable in enumerate(variables))
        blocks.append(Block(name, meaning, numbered, first))
        first += len(numbered)
    return Layout(_derivatives_of_states(blocks))


def _derivatives_of_states(blocks: Sequence[Block]) -> tuple[Block, ...]:
    firsts = {block.name: block.first for block in blocks}
    of = {f"DER_{name}": firsts[name] for name in ("Q", "QD", "Z") if name in firsts}
    return tuple(
        replace(
            block, variables=tuple(replace(x, derivative_of=of[block.name] + k) for k, x in enumerate(block.variables))
        )
        if block.name in of
        else block
        for block in blocks
    )


def _inputs(programs: Programs, start: Start) -> Iterator[Variable]:
    motors, has_drives = programs.machine.motor_joints, programs.given is not Given.TORQUES
    if has_drives:
        yield from _set_points(programs, start)
    for joint, torque in zip(motors, start.torques.tolist(), strict=True):
        what = "force" if joint.sigma else "torque"
        addition = " that is added to what its drive demands" if joint.name in programs.with_drive else ""
        yield _input(f"{joint.name}.tau", joint.force_unit, f"{what} of the motor of {joint.name}{addition}", torque)
    for frame in programs.machine.forces:
        for component, unit in WRENCH:
            what = "force" if unit == "N" else "moment"
            described = f"{what} on {frame} along {component[1]} of frame 0"
            yield _input(f"{_quote_owner(str(frame))}.{component}", unit, described, 0.0)


def _set_points(programs: Programs, start: Start) -> Iterator[Variable]:
    """Positions, velocities and accelerations at which drives hold their motors."""
    motors = programs.machine.motor_joints
    for name, per, meaning, at in (
        ("r", "", "set point of the position", start.motors.tolist()),
        ("rd", "/s", "velocity of the set point", [0.0] * len(motors)),
        ("rdd", "/s2", "acceleration of the set point", [0.0] * len(motors)),
    ):
        for joint, x in zip(motors, at, strict=True):
            idle = "" if joint.name in programs.with_drive else f" ({IDLE})"
            yield _input(f"{joint.name}.{name}", joint.unit + per, f"{meaning} of {joint.name}{idle}", x)


def _further(programs: Programs, start: Start) -> Iterator[Variable]:
    """States of friction and drives."""
    bristles = {f"{programs.machine.joint(j).name}.friction": j for j in programs.machine.bristles}
    for name, x, size in zip(programs.states, start.z.tolist(), start.states.tolist(), strict=True):
        unit = programs.machine.joint(bristles[name]).unit if name in bristles else ""
        what = "deflection of the bristle" if name in bristles else f"{name.partition('.')[2]} of the drive"
        described = f"{what} of {name.partition('.')[0]}"
        nominal = _number(float(f"{float(size):.{DIGITS - 1}e}"))
        yield Variable(name, 0, _unit(unit), described, initial="exact", start=_number(x), nominal=nominal)


def _torques(programs: Programs) -> Iterator[Variable]:
    for joint in programs.machine.motor_joints:
        what = f"{'force' if joint.sigma else 'torque'} that the motor of {joint.name} gives"
        yield Variable(f"{joint.name}.tau_m", 0, _unit(joint.force_unit), what, "output", initial="calculated")


def _input(name: str, unit: str, description: str, start: float) -> Variable:
    return Variable(name, 0, _unit(unit), description, "input", start=_number(start))


def _states(
    joints: Sequence[Joint], quantity: str, per: str, start: Sequence[float], nominal: Sequence[float]
) -> Iterator[Variable]:
    meaning = {"q": "position", "qd": "velocity"}[quantity]
    for joint, x, size in zip(joints, start, nominal, strict=True):
        described = f"{meaning} of {joint.name}, {joint.kind.value}"
        rounded = f"{float(size):.{DIGITS - 1}e}"
        yield Variable(
            f"{joint.name}.{quantity}",
            0,
            _unit(joint.unit + per),
            described,
            "output",
            initial="exact",
            start=_number(x),
            nominal=_number(float(rounded)),
        )


def _derivatives(joints: Sequence[Joint], quantity: str, per: str) -> Iterator[Variable]:
    meaning = {"q": "velocity", "qd": "acceleration"}[quantity]
    for joint in joints:
        described = f"{meaning} of {joint.name}"
        yield Variable(f"der({joint.name}.{quantity})", 0, _unit(joint.unit + per), described, initial="calculated")


def _output(output: Output) -> Variable:
    name, described = f"{_quote_owner(output.owner)}.{output.quantity}", f"{output.owner}: {output.meaning}"
    return Variable(name, 0, _unit(output.unit), described, "output", initial="calculated")


def _parameters(programs: Programs) -> Iterator[Variable]:
    reserved = {"time"}
    units = {parameter.name: parameter.unit for parameter in programs.machine.parameters}
    used = frozenset[str]().union(*(model.program.used for model in programs.models))
    for x in programs.package.parameters:
        cell = programs.cells.get(x.name, NamedCell(x.name, f"parameter {x.name}"))
        name = f"parameter.{cell.name}" if cell.name in reserved else cell.name
        unit = _unit(units.get(x.name, ""))
        least = "0.0" if cell.quantity in NOT_NEGATIVE and x.value >= 0 else None
        meaning = cell.meaning if x.name in used else f"{cell.meaning} ({IDLE})"
        yield Variable(name, 0, unit, meaning, "parameter", "tunable", "exact", _number(x.value), minimum=least)


def _unit(text: str) -> str:
    """Return a unit as FMI usually has it, `N.m/rad`; empty for one whose base units are not known."""
    return text.replace(" ", ".") if text and in_base_units(text) is not None else ""


def _number(x: float) -> str:
    return repr(float(x) + 0.0)


def _quote_owner(owner: str) -> str:
    """Return the owner in a name, in quotes unless it is an identifier, as `'tool at (0.1, 0, L2)'`."""
    return owner if owner.isidentifier() else f"'{owner}'"


def unit_powers(variables: Sequence[Variable]) -> Mapping[str, list[tuple[str, int]]]:
    """Return exponents of base units by name of unit, in the order of FMI."""
    names = sorted({variable.unit for variable in variables if variable.unit})
    powers = {name: in_base_units(name) or {} for name in names}
    return {name: [(b, int(x[b])) for b in ("kg", "m", "s", "rad") if b in x] for name, x in powers.items()}
