"""Shared parts of options: types of arguments, names of registries, rows that several records have."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from symoro_elastic.api import kinds
from symoro_elastic.api.declaration import argument, option
from symoro_elastic.api.quantities import of_joints, of_parameters
from symoro_elastic.foundation.progress import announce_nothing, no_progress
from symoro_elastic.machine.format_names import suffixes

if TYPE_CHECKING:
    from symoro_elastic.analysis.sweeps.ranges import AxisLike
    from symoro_elastic.machine.machine import Machine
    from symoro_elastic.machine.scene import Scene

MachineLike: TypeAlias = "Machine | str | Path | Mapping[str, Any]"
"""A machine, its file, or the tables of such a file as dictionaries and lists."""
SceneLike: TypeAlias = "Scene | str | Path | Mapping[str, Any] | None"
"""A scene, its TOML file, or the tables of such a file as dictionaries and lists; None is that of the machine."""
Values: TypeAlias = Mapping[str, float]
"""Numbers by the name of a joint or a parameter."""
Gains: TypeAlias = Mapping[str, tuple[float, float]]
Range: TypeAlias = tuple[float, float]
Ranges: TypeAlias = Mapping[str, Range]
Record: TypeAlias = str | Path | Mapping[str, Any]
"""A file of measurements, or its columns by name."""
Of: TypeAlias = str | Callable[..., Mapping[str, float]]
Over: TypeAlias = "Mapping[str, AxisLike]"

READABLE, WRITABLE = suffixes(), suffixes(written=True)
"""Suffixes of machine files."""

# Names of registries, imported when help is printed or the shell completes


def _names_of(module: str, registry: str) -> Callable[[], Iterable[str]]:
    """Return a function that imports a registry and returns its names."""
    return lambda: tuple(getattr(import_module(f"symoro_elastic.{module}"), registry))


model_names = _names_of("models.programs.catalogue", "MODELS")
target_names = _names_of("codegen.targets", "TARGET_NAMES")
form_names = _names_of("machine.scene", "FORMS")
kept_names = _names_of("machine.within", "Keep")
guaranteed_names = _names_of("machine.within", "GUARANTEES")
precision_names = _names_of("codegen.precision", "PRECISIONS")
method_names = _names_of("codegen.integration.tableaus", "METHODS")
table_names = _names_of("machine.constants", "SECTIONS")
sampling_names = _names_of("analysis.sweeps.design", "SAMPLINGS")
purpose_names = _names_of("analysis.ladder.reduced", "Purpose")
part_names = _names_of("analysis.ladder.reduced", "Part")
left_out_names = _names_of("machine.left_out_parts", "PARTS")
schema_names = _names_of("formats.toml.schema", "SCHEMAS")
start_names = _names_of("formats.toml.starting", "STARTS")
processor_names = _names_of("codegen.embedded.processors", "CONTROLLERS")


def certified_names() -> Iterable[str]:
    """Return the precisions of C code with certificates."""
    from symoro_elastic.codegen.precision import PRECISIONS

    return [name for name, precision in PRECISIONS.items() if not precision.is_pair]


OF_FILE, OF_MOTION, OF_SET_POINTS = "file", "motion", "set-points"
BOXES = (OF_FILE, OF_MOTION, OF_SET_POINTS)
"""Where the box of arguments may come from."""


def processor_row(what: str) -> Any:
    """Return the option for a processor by its name."""
    return option("", "NAME", f"Processor {what}: {{names}}.", names=processor_names)


def limits_row() -> Any:
    """Return the option for where the operating range of the arguments comes from: limits or simulated motions."""
    return option(
        "file", "NAME", "Operating range: {names} ([limits] of the machine; range of the simulated motions of the "
        "scene, or of the set points of its motors, plus 10 %).", names=lambda: BOXES,
    )  # fmt: skip


def within_row() -> Any:
    """Return the option for tolerances of results."""
    return option(
        {}, "[NAME=]TOL", "Leave out terms while results stay within TOL of the whole model as long as joints are "
        "within their [limits]: '1%' of the largest value, or a number in the unit of the result; for all, or of a "
        "result, a joint, or frequencies, the natural ones.", kinds.TOLERANCES,
    )  # fmt: skip


def keep_row() -> Any:
    """Return the option for the kind of reduction."""
    return option("", "NAME", "Kind of reduction, with --within: {names} (default: terms).", names=kept_names)


def guaranteed_row() -> Any:
    """Return the option for the kind of guarantee."""
    what = "Kind of guarantee of --within: {names} (default: confident, statistical at unseen states)."
    return option("", "NAME", what, names=guaranteed_names)


def motors_or_all(machine: Machine) -> Iterable[str]:
    """Return the names of motors, and "all"."""
    return [*(joint.name for joint in machine.motor_joints), "all"]


def parameters_or_all(machine: Machine) -> Iterable[str]:
    """Return the names of parameters, and "all"."""
    return [*(parameter.name for parameter in machine.parameters), "all"]


SEEKING = ("auto", "always", "never")
EFFORTS = ("quick", "usual", "all")
ANALYSES = ("modes", "response", "control", "ladder", "simulation")

POSITION = of_joints("position")

# Rows that several operations share


def scene_row(meaning: str) -> Any:
    """Return the option for a scene."""
    return option(None, "FILE", f"Scene: TOML file {meaning}.", kinds.SCENE)


def frame_row() -> Any:
    """Return the row of one frame."""
    return option(
        "", "NAME", "Frame, or a point of its body: 'tool at (0.1, 0, L2)' (default: the last fixed one).",
        of_machine=frame_names,
    )  # fmt: skip


def frame_names(machine: Machine) -> Iterable[str]:
    """Return the names of the frames of a machine."""
    from symoro_elastic.machine.frames import FrameNames

    return FrameNames(machine).own


def values_row() -> Any:
    """Return the option for values of parameters."""
    return option({}, "NAME=X", "Value of a parameter.", kinds.NUMBERS, unit=of_parameters)


def at_row(more: str = "") -> Any:
    """Return the option for a position."""
    return option({}, "JOINT=X", f"Position of a motor, rad or m (default 0){more}.", kinds.NUMBERS, unit=POSITION)


def along_row() -> Any:
    """Return the option for a grid of positions."""
    return option(
        {}, "JOINT=LOW:HIGH:COUNT", "Positions of a joint for the computation, one after the other.", kinds.GRID,
        gone=("--over",), unit=POSITION,
    )  # fmt: skip


def damping_row() -> Any:
    """Return the option for a damping ratio of all modes."""
    return option(0.0, "RATIO", "Damping ratio added to every mode: 0.01 is 1 %.", kinds.NUMBER, unit="")


def merge_angles_row() -> Any:
    """Return the option for the bound up to which angles are merged."""
    what = "Add angles of parallel axes where that saves operations; valid for |q| up to BOUND, rad."
    return option(None, "BOUND", what, kinds.BOUND, above=0, most=1e6, unit="rad")


def start_row() -> Any:
    """Return the option for the start position of a motion."""
    what = "Position of a joint at the start, rad or m (default 0, or the start of a loop)."
    return option({}, "JOINT=X", what, kinds.NUMBERS, gone=("--at", "at"), unit=POSITION)


def seed_row() -> Any:
    """Return the option for a random seed."""
    return option(0, "N", "Random seed.", kinds.WHOLE, least=0)


def sample_rate_row(default: float | None, **bounds: float) -> Any:
    """Return the option for a sample rate."""
    what = f"Sample rate, Hz{'' if default else ' (default 1000)'}."
    return option(default, "HZ", what, kinds.NUMBER, gone=("--rate", "rate"), unit="Hz", **bounds)


def duration_row() -> Any:
    """Return the option for the duration of a move."""
    what = "Duration of the move, s (default: five periods of the first natural frequency)."
    return option(None, "S", what, kinds.NUMBER, unit="s")


def motion_row(meaning: str) -> Any:
    """Return the option for the file of a motion."""
    return option(None, "FILE", meaning, kinds.INPUT_FILE)


def known_row() -> Any:
    """Return the option for fixed parameters."""
    what = "Parameter or group with a known value, which is not estimated; excite needs no value."
    return option({}, "LABEL[=X]", what, kinds.NUMBERS_OR_NONE)


def seek_row() -> Any:
    """Return the option for the only parameters and bodies to estimate."""
    what = "Parameter that is sought, or body, by its joint, whose parameters are, such as a payload; all others are "
    return option((), "LABEL", what + "those of the file (default: all are sought).", kinds.TEXTS)


def announce_row(**more: Any) -> Any:
    """Return the option for a callback at each stage."""
    return argument(announce_nothing, "Called with the name of each stage.", **more)


def progress_row() -> Any:
    """Return the option for a callback that counts steps."""
    return argument(no_progress, "Called with the steps that are done, and their number.")
