"""Kinematics of frames: singularities."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from symoro_elastic.api.declaration import operation
from symoro_elastic.api.loaded import LoadedModel, load
from symoro_elastic.api.machines import the_machine
from symoro_elastic.api.options import Locating
from symoro_elastic.api.rows import MachineLike
from symoro_elastic.foundation.errors import reported_places
from symoro_elastic.machine.frames import FrameNames
from symoro_elastic.machine.scene import COMPONENTS, RequestedPart

if TYPE_CHECKING:
    from symoro_elastic.analysis.singularities.singularities import Singularities

UNKNOWN = 0.2, 0.9
"""Bounds of random values of parameters without value, in the search for a position."""


@operation(Locating)
def singularities(machine: MachineLike, options: Locating) -> Singularities:
    """Return the determinant of the Jacobian of a frame, factored, and the positions where it vanishes, in words.

    As many components of the twist of the frame as joints that move them are taken: all that some joint changes, or
    those named, as in "tool.x", "tool.y" (Khalil and Dombre 2002, 5.3). Each factor is a condition on the joint
    variables; at such a position the result names the joints that are dependent there, and the lost motion.

    Raises
    ------
    InputError
        Where the Jacobian is not square, where it is singular at every position, or too long to be factored.
    """
    from symoro_elastic.analysis.singularities.singularities import (
        Samples,
        Singularities,
        Task,
        latex,
        singular_positions,
    )

    full = the_machine(machine)
    frames = FrameNames(full)
    components = [*options.components] or [frames.name(frames.of_row(len(full.joints)))]
    frame = str(replace(RequestedPart.parse(components[0]), component=""))
    symbols, numbers = {"jacobian_determinant": components}, {"inverse_jacobian": components, "jacobian": [frame]}
    with reported_places({"--only, jacobian_determinant": "--component"}):
        symbolic = load(full, *symbols, only=symbols, scene=options.scene, backend="sympy")
    model = load(full, *numbers, only=numbers, scene=options.scene)
    (inverse,) = (f.results[0] for f in model.package.functions if f.name == "inverse_jacobian")
    names = [axis.name for axis in model.package.axes]
    rows, columns = map(COMPONENTS.index, inverse.columns), map(names.index, inverse.rows)
    variables = dict(axis.unit.split(", ") for axis in model.package.axes)
    task = Task(full.label, variables, inverse.rows, tuple(f"{frame}.{x}" for x in inverse.columns), _values(model))
    samples = Samples(model.jacobian, tuple(rows), tuple(columns), task)
    determinant, positions = singular_positions(symbolic.jacobian_determinant()[0], task, samples)
    return Singularities(full.name, task.components, inverse.rows, str(determinant), latex(determinant), positions)


def _values(model: LoadedModel) -> dict[str, float]:
    """Values of the parameters, typical ones of robots for parameters without value."""
    parameters = model.package.parameters
    lengths = np.linspace(*UNKNOWN, len(parameters))
    return {p.name: x if np.isnan(p.value) else p.value for p, x in zip(parameters, lengths.tolist(), strict=True)}
