"""The functions inside an FMU: accelerations, outputs, their directional derivatives, a time step."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from symoro_elastic.codegen.integration.methods import METHODS, Method
from symoro_elastic.codegen.package import EXTERNAL, Package
from symoro_elastic.codegen.time_steps import DRIVES
from symoro_elastic.generation.fmu.motors import Given, Sampling, given_of, sampling_of, with_free_drives
from symoro_elastic.generation.fmu.outputs import Output, asked_frames, outputs_model, outputs_of
from symoro_elastic.machine.columns import cells
from symoro_elastic.machine.described import between_samples, drives_of
from symoro_elastic.machine.freed import with_free_numbers
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.restrict import names_to_fold, restrict
from symoro_elastic.machine.scene import Scene
from symoro_elastic.models.bind import Bound
from symoro_elastic.models.catalogue import in_form, points_of, trace, trace_of
from symoro_elastic.models.directional_derivatives import directional_derivative
from symoro_elastic.models.drives.closed_dynamics import closed_trace
from symoro_elastic.models.drives.control import CONTROL, START
from symoro_elastic.models.drives.drive_states import SET_POINTS, controlled_position
from symoro_elastic.models.implicit_steps import Motors, implicit_system
from symoro_elastic.models.model import TracedModel
from symoro_elastic.models.motor_coordinates import dependent_motors, motor_coordinates
from symoro_elastic.models.packaging import reserved_words
from symoro_elastic.models.passed_torques import passed_trace
from symoro_elastic.models.state import closing_models
from symoro_elastic.models.time_steps import refuse_machines
from symoro_elastic.models.traced import Traced
from symoro_elastic.models.tracing import Trace, prune, schedule
from symoro_elastic.symbolic.memory import no_collection

FREED = ("bodies", "springs")
"""Tables whose numbers are parameters of an FMU."""
ACCELERATIONS = "direct_dynamics"
WITH_DERIVATIVES, WITH_STIFFNESSES = "rodas4", "w3"
"""Methods of co-simulation: that with exact derivatives, and that for motors on joints that follow from others."""


@dataclass(frozen=True)
class NamedCell:
    """A number of the table as a parameter: its name, `ram.mass`, what it is, and its column, `mass`."""

    name: str
    meaning: str
    quantity: str = ""


@dataclass(frozen=True)
class Programs:
    """The functions of a machine as an FMU needs them.

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
        """Names of the states beside positions and velocities: of friction, then of drives."""
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
    given, _ = given_of(restrict(machine, scene))
    freed = with_parameters(machine)
    whole, of_drives = (freed, {}) if given is Given.TORQUES else with_free_drives(freed, reserved_words())
    sampled = restrict(whole, scene) if given is Given.SAMPLES else None
    whole = between_samples(whole) if sampled else whole
    made, constants = restrict(whole, scene), names_to_fold(whole, scene)
    method = method_of(made)
    frames = asked_frames(made, scene)
    bound, placed = Bound(made, constants), Bound(made, constants, points_of(frames))
    traces = {bound: _accelerations(bound, given, scene)}
    outputs = outputs_of(placed, frames)
    if outputs:
        traces[placed] = _trace_of_outputs(outputs, placed)
    loads = Bound(made, constants)
    called = {**traces, **({loads: passed_trace(loads)} if made.loaded else {})}
    models = [schedule(prune(one)) for one in called.values()]
    models += [schedule(prune(directional_derivative(*pair, constants))) for pair in called.items()]
    models += _of_steps(made, method, constants, given)
    models += _of_samples(sampled, constants) if sampled else []
    asked = Traced(whole, replace(scene, steps=(method.name,)), models)
    written = replace(asked.package, only="" if given is Given.TORQUES else DRIVES.suffix)
    named = _named_cells(machine, freed) | {
        name: NamedCell(f"{one.joint.name}.{one.place}", f"{one.place} of the drive of {one.joint.name}")
        for name, one in of_drives.items()
    }
    return Programs(
        made,
        named,
        written,
        method,
        tuple(outputs),
        tuple(traces.values()),
        tuple(models),
        given,
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
    """Return the method of co-simulation: exact derivatives where motors own their variables, and no others are."""
    has_states = machine.bristles or machine.loaded or given_of(machine)[0] is not Given.TORQUES
    return METHODS[WITH_STIFFNESSES if has_states or dependent_motors(machine) else WITH_DERIVATIVES]


def _of_steps(machine: Machine, method: Method, folded: Sequence[str], given: Given) -> list[TracedModel]:
    """Return the models that steps call beside the accelerations."""
    found = [trace(machine, name, folded=folded) for name in closing_models(machine)]
    if method.name == WITH_DERIVATIVES:
        return [*found, trace(machine, "linearization", folded=folded)]
    return [*found, *implicit_system(machine, Motors.TORQUE if given is Given.TORQUES else Motors.DRIVES, folded)]


def _of_samples(machine: Machine, folded: Sequence[str]) -> list[TracedModel]:
    """Return the models that sampled controllers need."""
    found = [trace(machine, name, folded=folded) for name in (CONTROL, START)]
    return [*found, motor_coordinates(machine, folded, controlled_position)]


def _named_cells(before: Machine, after: Machine) -> dict[str, NamedCell]:
    """Return the cells of the parameters that were numbers before, by their names in the code."""
    known = {parameter.name for parameter in before.parameters}
    found = ((joint, cell, formula) for joint in after.joints for cell, formula in cells(joint))
    named = [(joint, cell, str(formula.tree[1])) for joint, cell, formula in found if formula.tree[0] == "name"]
    new = {parameter.name for parameter in after.parameters} - known
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
    _refuse_missing_values(machine)


def _refuse_missing_values(machine: Machine) -> None:
    missing = [p.name for p in machine.parameters if p.value is None]
    if missing:
        others = f" ({len(missing) - 1} more as well)" if len(missing) > 1 else ""
        what = f"{missing[0]} has no value{others}, and an FMU needs a start value: give it in the file"
        raise machine.error("parameters", what)


def _trace_of_outputs(outputs: Sequence[Output], bound: Bound) -> Trace:
    model, results = outputs_model(outputs, bound)
    return trace_of(model, bound, results)
