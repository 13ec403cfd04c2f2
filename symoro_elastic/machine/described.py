"""A machine as its file describes it: with its requests, and with the file's other entries."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, fields, replace
from typing import TYPE_CHECKING, Any, Self, TypeVar

from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.beams.beam import Beam
from symoro_elastic.machine.catalogue import CatalogueSpring
from symoro_elastic.machine.drives import Drives, within_motors
from symoro_elastic.machine.limits import Limits, within_machine
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.prescribed_motion import PrescribedMotion
from symoro_elastic.machine.scene import Scene

if TYPE_CHECKING:
    from symoro_elastic.foundation.array_types import Array

AnyMachine = TypeVar("AnyMachine", bound=Machine)
"""A machine, or one with its description, which is kept."""


@dataclass(frozen=True)
class Wanted:
    """Errors that are allowed, by signal ("tool.x", "motor_x.tau"), or one for all `outputs`, m or rad.

    `period` is that of a controller, which a whole number of steps fills, and `time` the largest time that these steps
    may take, s. None: nothing is wanted of it. `source` is the file.
    """

    tolerance: dict[str, float] | float | None = None
    outputs: tuple[str, ...] = ()
    period: float | None = None
    time: float | None = None
    source: str = field(default="", compare=False)

    def error(self, key: str, what: str) -> InputError:
        """The error to raise about one key of the table of required errors."""
        return InputError(self.source, f"wanted, {key}", what)


@dataclass(frozen=True)
class Request:
    """Requests of a file: the scene, the motions to simulate, and the requirements on these."""

    scene: Scene | None = None
    motions: tuple[PrescribedMotion, ...] = ()
    wanted: Wanted | None = None


@dataclass(frozen=True, eq=False)
class BodyShape:
    """The shape of a body: the mesh of a `file`, as the machine's file names it, or a `solid` of half length 1.

    `points` (4, 4) maps points of the mesh, m, to the frame of the `joint` that carries the body, "" for frame 0: it
    turns, moves and scales them. A solid is a "box", an "ellipsoid", a "cylinder" along z, or a "capsule" along z whose
    radius is 1 and whose straight part is 2 `straight`.
    """

    points: Array
    file: str = ""
    solid: str = ""
    straight: float = 0.0
    joint: str = ""


@dataclass(frozen=True)
class Origin:
    """Entries of a file that are neither mechanics nor requests, kept so that reading then writing loses nothing.

    `notes` are remarks of its author, `extras` entries of a format that no model uses. `remarks` say, a line each, what
    the file holds and the machine does not: `checks.check` warns of them. `of_name` says where the machine's name
    comes from unless it is given there. `ungrouped` is the machine before its inertial parameters were grouped.
    `shapes` are what bodies look like, `beams` those that became rows, `catalogue_springs` the springs whose stiffness
    comes from a catalogue.
    """

    notes: tuple[str, ...] = ()
    extras: dict[str, str] = field(default_factory=dict)
    remarks: tuple[str, ...] = field(default=(), compare=False)
    of_name: str = field(default="", compare=False)
    ungrouped: Machine | None = field(default=None, compare=False, repr=False)
    shapes: tuple[BodyShape, ...] = field(default=(), compare=False, repr=False)
    catalogue_springs: tuple[CatalogueSpring, ...] = field(default=(), compare=False, repr=False)
    beams: tuple[Beam, ...] = field(default=(), compare=False, repr=False)


@dataclass(frozen=True, repr=False)
class DescribedMachine(Machine):
    """A machine with its requests `asked`, its `limits`, its `drives`, and other entries of its file (`origin`).

    Functions that need mechanics only have a `Machine` as argument.
    """

    asked: Request = Request()
    origin: Origin = Origin()
    limits: Limits = Limits()
    drives: Drives = Drives()

    @classmethod
    def of(cls, machine: Machine) -> DescribedMachine:
        """The machine itself if it is described, else the machine without requests and origin."""
        if isinstance(machine, cls):
            return machine
        return cls(**{field.name: getattr(machine, field.name) for field in fields(machine)})

    def asking(self, **changes: Any) -> Self:
        """Return the machine with other requests: `scene`, `motions`, `wanted`."""
        return replace(self, asked=replace(self.asked, **changes))

    def with_notes(self, *notes: str) -> Self:
        """The machine with these notes after its own, each once."""
        return replace(self, origin=replace(self.origin, notes=tuple(dict.fromkeys((*self.origin.notes, *notes)))))

    def with_remarks(self, *remarks: str) -> Self:
        """The machine with these remarks after its own."""
        return replace(self, origin=replace(self.origin, remarks=(*self.origin.remarks, *remarks)))


def limits_of(machine: Machine) -> Limits:
    """The limits that apply to a machine: to its independent joints and parameters; none without description."""
    return within_machine(machine.limits, machine) if isinstance(machine, DescribedMachine) else Limits()


def drives_of(machine: Machine) -> Drives:
    """The drives of the motors of a machine; none where it has no description."""
    return within_motors(machine.drives, machine) if isinstance(machine, DescribedMachine) else Drives()


def between_samples(machine: Machine) -> DescribedMachine:
    """The machine with its drives' power stages alone: lag or winding of a held torque."""
    stages = {name: drive.power_stage for name, drive in drives_of(machine).by_motor.items()}
    return replace(DescribedMachine.of(machine), drives=Drives(stages))


def without_drives(machine: Machine) -> Machine:
    """The machine without its drives."""
    return replace(machine, drives=Drives()) if isinstance(machine, DescribedMachine) else machine


def with_changed_scene(machine: AnyMachine, change: Callable[[Scene], Scene | None]) -> AnyMachine:
    """The machine with another scene in place of that of its file, where it has one."""
    if isinstance(machine, DescribedMachine) and machine.asked.scene is not None:
        return machine.asking(scene=change(machine.asked.scene))
    return machine
