"""What several operations are given: types of arguments, names of registries, rows of options that records share."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from symoro_elastic.api import kinds
from symoro_elastic.api.declaration import argument, option
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

# Names of registries, read when help is printed or the shell completes


def model_names() -> Iterable[str]:
    """Return the names of all models."""
    from symoro_elastic.models.catalogue import MODELS

    return MODELS


def target_names() -> Iterable[str]:
    """Return the names of all targets."""
    from symoro_elastic.codegen.targets import TARGET_NAMES

    return TARGET_NAMES


def form_names() -> Iterable[str]:
    """Return the forms of direct_dynamics."""
    from symoro_elastic.machine.scene import FORMS

    return FORMS


def certified_names() -> Iterable[str]:
    """Return the precisions of C code that certificates are made for."""
    from symoro_elastic.codegen.precision import PRECISIONS

    return [name for name, precision in PRECISIONS.items() if not precision.is_pair]


OF_FILE, OF_MOTION = "file", "motion"
BOXES = (OF_FILE, OF_MOTION)
"""Where the box of arguments may come from."""


def limits_row() -> Any:
    """Return the row of where the box of arguments comes from."""
    return option(
        "file", "NAME", "Where the box comes from: {names} (file: the [limits] of the machine; motion: the hull of the "
        "scene's motions, simulated, and a tenth more).", names=box_names,
    )  # fmt: skip


def within_row() -> Any:
    """Return the row of tolerances of results."""
    return option(
        {}, "[NAME=]TOL", "Leave out terms while results stay within TOL of the whole model as long as joints are "
        "within their [limits]: '1%' of the largest value, or a number in the unit of the result; for all, or of a "
        "result, a joint, or frequencies, the natural ones.", kinds.TOLERANCES,
    )  # fmt: skip


def keep_row() -> Any:
    """Return the row of what is left out."""
    return option("", "NAME", "What is left out, with --within: {names} (default: terms).", names=kept_names)


def guaranteed_row() -> Any:
    """Return the row of what stands behind tolerances."""
    what = "What stands behind --within: {names} (default: confident, at unseen states)."
    return option("", "NAME", what, names=guaranteed_names)


def box_names() -> Iterable[str]:
    """Return where the box of arguments may come from."""
    return BOXES


def kept_names() -> Iterable[str]:
    """Return what of a model may be kept where terms are left out."""
    from symoro_elastic.machine.within import Keep

    return list(Keep)


def guaranteed_names() -> Iterable[str]:
    """Return what may stand behind a tolerance."""
    from symoro_elastic.machine.within import Guaranteed

    return list(Guaranteed)


def precision_names() -> Iterable[str]:
    """Return the precisions of C code."""
    from symoro_elastic.codegen.precision import PRECISIONS

    return PRECISIONS


def method_names() -> Iterable[str]:
    """Return the methods of even steps."""
    from symoro_elastic.codegen.integration.methods import METHODS

    return METHODS


def table_names() -> Iterable[str]:
    """Return the tables whose numbers may stay parameters."""
    from symoro_elastic.machine.freed import SECTIONS

    return SECTIONS


def sampling_names() -> Iterable[str]:
    """Return the ways of drawing points."""
    from symoro_elastic.analysis.sweeps.design import SAMPLINGS

    return SAMPLINGS


def motors_or_all(machine: Machine) -> Iterable[str]:
    """Return the names of motors, and "all"."""
    return [*(joint.name for joint in machine.motor_joints), "all"]


def parameters_or_all(machine: Machine) -> Iterable[str]:
    """Return the names of parameters, and "all"."""
    return [*(parameter.name for parameter in machine.parameters), "all"]


SEEKING = ("auto", "always", "never")
EFFORTS = ("quick", "usual", "all")
ANALYSES = ("modes", "response", "control", "ladder", "simulation")

# Rows that several operations share


def scene_row(meaning: str) -> Any:
    """Return the row of a scene."""
    return option(None, "FILE", f"Scene: TOML file {meaning}.", kinds.SCENE)


def values_row() -> Any:
    """Return the row of values of parameters."""
    return option({}, "NAME=X", "Value of a parameter.", kinds.NUMBERS)


def at_row(more: str = "") -> Any:
    """Return the row of a position."""
    return option({}, "JOINT=X", f"Position of a motor, rad or m (default 0){more}.", kinds.NUMBERS)


def along_row() -> Any:
    """Return the row of a grid of positions."""
    return option(
        {}, "JOINT=LOW:HIGH:COUNT", "Positions of a joint at which it is computed, one after the other.", kinds.GRID,
        formerly=("--over",),
    )  # fmt: skip


def damping_row() -> Any:
    """Return the row of a damping ratio of all modes."""
    return option(0.0, "RATIO", "Damping ratio added to every mode: 0.01 is 1 %.", kinds.NUMBER)


def merge_angles_row() -> Any:
    """Return the row of the bound up to which angles are merged."""
    what = "Add angles of parallel axes where that saves operations; valid for |q| up to BOUND, rad."
    return option(None, "BOUND", what, kinds.BOUND, above=0, most=1e6)


def start_row() -> Any:
    """Return the row of the position where a motion starts."""
    what = "Position of a joint at the start, rad or m (default 0, or the start of a loop)."
    return option({}, "JOINT=X", what, kinds.NUMBERS, formerly=("--at", "at"))


def seed_row() -> Any:
    """Return the row of a random seed."""
    return option(0, "N", "Random seed.", kinds.WHOLE, least=0)


def sample_rate_row(default: float | None, **bounds: float) -> Any:
    """Return the row of a sample rate."""
    what = f"Sample rate, Hz{'' if default else ' (default 1000)'}."
    return option(default, "HZ", what, kinds.NUMBER, formerly=("--rate", "rate"), **bounds)


def duration_row() -> Any:
    """Return the row of the duration of a move."""
    what = "Duration of the move, s (default: five periods of the first natural frequency)."
    return option(None, "S", what, kinds.NUMBER)


def motion_row(meaning: str) -> Any:
    """Return the row of the file of a motion."""
    return option(None, "FILE", meaning, kinds.INPUT_FILE)


def known_row() -> Any:
    """Return the row of known parameters."""
    what = "Parameter or group whose value is known, so that it is not estimated; excite needs no value."
    return option({}, "LABEL[=X]", what, kinds.NUMBERS_OR_NONE)


def seek_row() -> Any:
    """Return the row of parameters and bodies that are sought alone."""
    what = "Parameter that is sought, or body, by its joint, whose parameters are, such as a payload; all others are "
    return option((), "LABEL", what + "those of the file (default: all are sought).", kinds.TEXTS)


def announce_row(**more: Any) -> Any:
    """Return the row of what is called at each stage."""
    return argument(announce_nothing, "Called with the name of each stage.", **more)


def progress_row() -> Any:
    """Return the row of what counts the work."""
    return argument(no_progress, "Called with the steps that are done, and their number.")


def force_row() -> Any:
    """Return the row of the permission to replace files."""
    return argument(False, "Replace existing files that the program has not written itself.")
