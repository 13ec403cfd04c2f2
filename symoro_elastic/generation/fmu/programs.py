"""The functions inside an FMU: accelerations, outputs, their directional derivatives, a time step."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import MISSING, dataclass, fields, replace
from enum import Enum
from functools import partial

from symoro_elastic.codegen.integration.tableaus import METHODS, Method
from symoro_elastic.codegen.package import EXTERNAL, Package
from symoro_elastic.codegen.time_steps import DRIVES
from symoro_elastic.foundation.scalar import Scalar
from symoro_elastic.machine.columns import cells
from symoro_elastic.machine.constants import unused_name, with_free_numbers
from symoro_elastic.machine.described import DescribedMachine, between_samples, drives_of
from symoro_elastic.machine.drives import NO_NUMBER, ONE, TUNED, Drive, Drives, dead_time_within
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.frames import FrameNames
from symoro_elastic.machine.joints import Joint
from symoro_elastic.machine.machine import Machine, Parameter
from symoro_elastic.machine.named_cells import DriveNumber, with_changed
from symoro_elastic.machine.names import IN_USE, Reasons
from symoro_elastic.machine.restrict import names_to_fold, restrict
from symoro_elastic.machine.scene import RequestedPart, Scene
from symoro_elastic.models.bound.bind import Bound
from symoro_elastic.models.bound.model import Frame, Model, Result, TracedModel
from symoro_elastic.models.bound.state import closing_models
from symoro_elastic.models.bound.tracing import Trace, prune, schedule
from symoro_elastic.models.derivatives.directional_derivatives import directional_derivative
from symoro_elastic.models.drives.control import CONTROL, START, sampled_drives
from symoro_elastic.models.drives.drive_states import SET_POINTS, controlled_position, driven_motors
from symoro_elastic.models.kinematics.geometric import geometric_model
from symoro_elastic.models.packaging import Traced, reserved_words
from symoro_elastic.models.programs.catalogue import in_form, points_among, requested_frames, trace, trace_of
from symoro_elastic.models.steps.closed_dynamics import closed_trace
from symoro_elastic.models.steps.implicit_steps import Motors, implicit_system
from symoro_elastic.models.steps.time_steps import dependent_motors, motor_coordinates, passed_trace, refuse_machines
from symoro_elastic.quantities import Quantity, Role
from symoro_elastic.symbolic.expression import Expression, Level
from symoro_elastic.symbolic.memory import no_collection

FREED = ("bodies", "springs")
"""Tables whose numbers are parameters of an FMU."""
ACCELERATIONS = "direct_dynamics"
WITH_DERIVATIVES, WITH_STIFFNESSES = "rodas4", "w3"
"""Methods of co-simulation: that with exact derivatives, and that for motors on joints that follow from others."""
FRAMES = "geometric_model"
"""The model whose outputs in a scene name frames."""
OUTPUTS, Y = "outputs", "y"
WAY_OUT = "leave it out, or give --by-torque"
KEYS = {"torque_limit": "limits, torque", "current": "current, kp"}
"""Keys of a file whose names are others than those of a `Drive`."""
OF_SAMPLES = ("period", "dead_time", "time")
"""Numbers that decide when a controller is called, and what it keeps: constants of an FMU."""


@dataclass(frozen=True)
class NamedCell:
    """A number of the table as a parameter: its name, `ram.mass`, what it is, and its column, `mass`."""

    name: str
    meaning: str
    quantity: str = ""


@dataclass(frozen=True)
class Programs:
    """The functions of a machine that an FMU needs.

    `machine` is the one restricted to the scene, `cells` are those of its table that became parameters, by their names,
    `traces` those of accelerations and of outputs, `models` all that are written. `sampling` is that of sampled drives.
    """

    machine: Machine
    cells: Mapping[str, NamedCell]
    package: Package
    method: Method
    outputs: tuple[Output, ...]
    traces: tuple[Trace, ...]
    models: tuple[TracedModel, ...]
    given: Given
    sampling: Sampling | None

    @property
    def states(self) -> tuple[str, ...]:
        """Names of the states other than positions and velocities: of friction, then of drives."""
        return self.package.states

    @property
    def inputs(self) -> dict[str, int]:
        """Arguments that are inputs, in their order, and their entries."""
        motors = dict.fromkeys(
            ("tau",) if self.given is Given.TORQUES else (*SET_POINTS, "tau"), len(self.machine.motors)
        )
        return motors | ({EXTERNAL: self.package.external} if self.package.external else {})

    @property
    def with_drive(self) -> frozenset[str]:
        """The motors that have drives here."""
        return frozenset() if self.given is Given.TORQUES else frozenset(drives_of(self.machine).by_motor)


@no_collection()
def programs_of(machine: Machine, scene: Scene) -> Programs:
    """Return the functions of a machine restricted to a scene."""
    motor_inputs, _ = given_of(restrict(machine, scene))
    freed = with_parameters(machine)
    full, of_drives = (freed, {}) if motor_inputs is Given.TORQUES else with_free_drives(freed, reserved_words())
    sampled = restrict(full, scene) if motor_inputs is Given.SAMPLES else None
    full = between_samples(full) if sampled else full
    restricted, constants = restrict(full, scene), names_to_fold(full, scene)
    method = method_of(restricted)
    frames = asked_frames(restricted, scene)
    bound, placed = Bound(restricted, constants), Bound(restricted, constants, points_among(restricted, frames))
    traces = {bound: _accelerations(bound, motor_inputs, scene)}
    outputs = outputs_of(placed, frames)
    if outputs:
        model, results = outputs_model(outputs, placed)
        traces[placed] = trace_of(model, placed, results)
    loads = Bound(restricted, constants)
    called = {**traces, **({loads: passed_trace(loads)} if restricted.loaded else {})}
    models = [schedule(prune(model)) for model in called.values()]
    models += [schedule(prune(directional_derivative(*pair, constants))) for pair in called.items()]
    models += _of_steps(restricted, method, constants, motor_inputs)
    models += _of_samples(sampled, constants) if sampled else []
    traced = Traced(full, replace(scene, steps=(method.name,)), models)
    written = replace(traced.package, only="" if motor_inputs is Given.TORQUES else DRIVES.suffix)
    named = _named_cells(machine, freed) | {
        name: NamedCell(f"{model.joint.name}.{model.place}", f"{model.place} of the drive of {model.joint.name}")
        for name, model in of_drives.items()
    }
    return Programs(
        restricted,
        named,
        written,
        method,
        tuple(outputs),
        tuple(traces.values()),
        tuple(models),
        motor_inputs,
        sampling_of(sampled) if sampled else None,
    )


def _accelerations(bound: Bound, given: Given, scene: Scene) -> Trace:
    """Return the trace of the model that gives derivatives of states."""
    if given is not Given.TORQUES:
        return closed_trace(bound, scene.form)
    model = in_form(ACCELERATIONS, scene.form)
    return trace_of(model, bound, model.run(bound, bound.machine.independent))


def with_parameters(machine: Machine) -> Machine:
    """Return the machine with the numbers of its bodies and springs as parameters."""
    return with_free_numbers(machine, FREED, reserved_words())


def method_of(machine: Machine) -> Method:
    """Return the method of co-simulation: exact derivatives unless friction, drives or dependent motors prevent it."""
    has_states = machine.bristles or machine.loaded or given_of(machine)[0] is not Given.TORQUES
    return METHODS[WITH_STIFFNESSES if has_states or dependent_motors(machine) else WITH_DERIVATIVES]


def _of_steps(machine: Machine, method: Method, folded: Sequence[str], given: Given) -> list[TracedModel]:
    """Return the models that steps call in addition to the accelerations."""
    closing = [trace(machine, name, folded=folded) for name in closing_models(machine)]
    if method.name == WITH_DERIVATIVES:
        return [*closing, trace(machine, "linearization", folded=folded)]
    return [*closing, *implicit_system(machine, Motors.TORQUE if given is Given.TORQUES else Motors.DRIVES, folded)]


def _of_samples(machine: Machine, folded: Sequence[str]) -> list[TracedModel]:
    """Return the models that sampled controllers need."""
    of_controllers = [trace(machine, name, folded=folded) for name in (CONTROL, START)]
    return [*of_controllers, motor_coordinates(machine, folded, controlled_position)]


def _named_cells(before: Machine, after: Machine) -> dict[str, NamedCell]:
    """Return the cells of the parameters that were numbers before, by their names in the code."""
    of_table = ((joint, cell, formula) for joint in after.joints for cell, formula in cells(joint))
    named = [(joint, cell, str(formula.tree[1])) for joint, cell, formula in of_table if formula.tree[0] == "name"]
    new = after.parameter_names - before.parameter_names
    return {
        name: NamedCell(f"{joint.name}.{cell.name}", f"{cell.label} of {joint.name}", cell.name)
        for joint, cell, name in named
        if name in new
    }


def refuse_machines_without_unit(machine: Machine) -> None:
    """Raise `InputError` for a restricted machine that has no FMU."""
    if machine.floating:
        what = "an FMU has a fixed base: write the six degrees of freedom as joints, three slides and three turns"
        raise machine.error("base, floating", what)
    if not machine.independent:
        raise machine.error("fmu", "no joint moves, so an FMU would have no state: leave fewer joints locked")
    refuse_machines(machine, (method_of(machine).name,))
    machine.refuse_missing_values("parameters")


@dataclass(frozen=True)
class Output:
    """An output that is not a state: its owner and quantity, `tool` and `x`, its unit, what it is, its value."""

    owner: str
    quantity: str
    unit: str
    meaning: str
    value: Scalar


def asked_frames(machine: Machine, scene: Scene) -> tuple[Frame, ...]:
    """Return the frames that a scene asks of the geometric model, else those at the ends of the tree."""
    if scene.outputs.get(FRAMES):
        return requested_frames(machine, scene, FRAMES)
    cut = {loop.cut for loop in machine.loops}
    ends = {*range(1, len(machine.joints) + 1)} - {*machine.antecedents} - cut
    return tuple(map(Frame, map(FrameNames(machine).of_row, sorted(ends))))


def outputs_of(bound: Bound, frames: tuple[Frame, ...]) -> list[Output]:
    """Return the outputs that depend on the state and are not a state themselves."""
    candidates = [*_dependent_joints(bound), *_deflections(bound), *_positions(bound, frames)]
    return [x for x in candidates if isinstance(x.value, Expression) and x.value.level is Level.STATE]


def outputs_model(outputs: Sequence[Output], bound: Bound) -> tuple[Model, dict[str, Result]]:
    """Return the model that gives outputs, and its results."""
    row = Quantity(
        name=Y, meaning="outputs that are not states", symbol="y", unit=None, shape="outputs", roles=(Role.RESULT,)
    )
    arguments = ("q", "qd") if bound.machine.is_coupled else ("q",)
    results = {Y: Result(None, tuple(output.value for output in outputs), (len(outputs),))}
    model = Model(OUTPUTS, "outputs of the FMU", "[1], [9]", arguments, (Y,), own=(row,))
    return model, results


def _dependent_joints(bound: Bound) -> Iterator[Output]:
    """Positions and velocities of joints whose variables follow from loops."""
    for j in bound.machine.dependent:
        joint = bound.machine.joint(j)
        yield Output(joint.name, "q", joint.unit, "position, which follows from a loop", bound.variables[j])
        yield Output(joint.name, "qd", f"{joint.unit}/s", "velocity, which follows from a loop", bound.rate(j))


def _deflections(bound: Bound) -> Iterator[Output]:
    """Deflections of springs that are not joint variables themselves."""
    for j in bound.machine.elastic:
        joint, (_, deflection) = bound.machine.joint(j), bound.spring(j)
        if deflection is not bound.variables[j]:
            yield Output(joint.name, "deflection", joint.unit, "deflection of its spring", deflection)


def _positions(bound: Bound, frames: tuple[Frame, ...]) -> Iterator[Output]:
    placements = geometric_model(bound, frames)["T"].entries
    name = FrameNames(bound.machine).name
    for number, frame in enumerate(frames):
        seen_from = None if frame.seen_from is None else name(frame.seen_from)
        observer, owner = seen_from or "frame 0", str(RequestedPart(name(frame.number), frame.at, seen_from))
        for k, axis in enumerate("xyz"):
            value = placements[16 * number + 4 * k + 3]
            yield Output(owner, axis, "m", f"position of its origin along {axis} of {observer}", value)


class Given(Enum):
    """Kind of inputs of the motors."""

    TORQUES = "torques"
    SET_POINTS = "set points of drives"
    SAMPLES = "set points of sampled drives"


def given_of(machine: Machine) -> tuple[Given, tuple[str, ...]]:
    """Return the kind of inputs of the motors of a machine, and a note where drives are omitted.

    Raises `InputError` for drives that no FMU has, by motor and key.
    """
    drives = drives_of(machine).by_motor
    if not drives:
        return Given.TORQUES, ()
    if tuned := [name for name, x in drives.items() if TUNED in (x.Kv, x.Kp, x.Tn)]:
        what = f"torques of motors are inputs: a gain of [drives] ({', '.join(tuned)}) is {NO_NUMBER}"
        return Given.TORQUES, (what,)
    if any(x.period is not None for x in drives.values()):
        sampled_drives(machine)
        return Given.SAMPLES, ()
    if not driven_motors(machine):
        name, key = next(_without_states(machine), (next(iter(drives)), ""))
        place = ", ".join(filter(None, ("drives", name, key)))
        raise machine.error(place, f"no generated model has its states, so no FMU has: {WAY_OUT}")
    return Given.SET_POINTS, ()


def _without_states(machine: Machine) -> Iterator[tuple[str, str]]:
    """Yield motor and key of each setting of a drive that by itself rules out a model with drives."""
    described = DescribedMachine.of(machine)
    for name, drive in drives_of(machine).by_motor.items():
        for field in fields(Drive):
            value = getattr(drive, field.name)
            if field.default is MISSING or value == field.default:
                continue
            alone = Drive(ONE, ONE, **{field.name: value})
            if not driven_motors(replace(described, drives=Drives({name: alone}))):
                yield name, KEYS.get(field.name, field.name)


@dataclass(frozen=True)
class Sampling:
    """Times of sampled drives: the period, s, and times after a sample at which torques change, s, the first 0.

    `applied` is, motor by motor, the index of the time at which its torque changes, their number for the next sample.
    """

    period: float
    offsets: tuple[float, ...]
    applied: tuple[int, ...]


def sampling_of(machine: Machine) -> Sampling:
    """Return the times of the sampled drives of a machine; raises `InputError` for dead times above the period."""
    drives = sampled_drives(machine)
    values = machine.given_values
    period = min(float(drive.period.value(values)) for drive in drives.values() if drive.period)
    late = []
    for j, drive in drives.items():
        dead = period if drive.dead_time is None else float(drive.dead_time.value(values))
        late.append(dead_time_within(period, dead, machine.joint(j).name, machine.label))
    offsets = (0.0, *sorted({x for x in late if 0 < x < period}))
    return Sampling(period, offsets, tuple((*offsets, period).index(x) for x in late))


def with_free_drives(machine: Machine, reserved: Reasons) -> tuple[Machine, dict[str, DriveNumber]]:
    """Return the machine with the numbers of its drives as parameters, and these by the names of the parameters.

    Zeros stay: they are structure; so do the times of samples, as numbers. `taken` are names that are none of
    parameters.
    """
    drives, loads, numbers = drives_of(machine).by_motor, drives_of(machine).loads, dict[str, DriveNumber]()
    if not drives:
        return machine, {}
    joints = {joint.name: joint for joint in machine.joints}
    own = (machine.name, *joints, *(p.name for p in machine.parameters), *(x.variable or "" for x in machine.joints))
    used, named = {**reserved, **dict.fromkeys(own, IN_USE)}, list[Parameter]()

    def free(joint: Joint, place: str, x: Formula) -> Formula:
        if place.rpartition(".")[2] in OF_SAMPLES and drives[joint.name].period is not None:
            return Formula.parse(float(x.value(machine.given_values)))
        if x.names or x.is_zero:
            return x
        number = DriveNumber(joint, place)
        name = unused_name(f"{place.replace('.', '_')}{machine.joints.index(joint) + 1}", used)
        used[name], numbers[name] = IN_USE, number
        named.append(Parameter(name, x, number.unit))
        return Formula.parse(name)

    freed_drives = {name: with_changed(drive, partial(free, joints[name])) for name, drive in drives.items()}
    freed = replace(machine, drives=Drives(freed_drives, loads), parameters=(*machine.parameters, *named))  # type: ignore[call-arg]
    return freed, numbers
