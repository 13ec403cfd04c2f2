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
from symoro_elastic.foundation.errors import placed
from symoro_elastic.machine.scene import COMPONENTS, RequestedPart

if TYPE_CHECKING:
    from symoro_elastic.analysis.singularities.singularities import Singularities

UNKNOWN = 0.2, 0.9
"""Values between these stand for parameters that have none, where a position is looked for."""


@operation(Locating)
def singularities(machine: MachineLike, options: Locating) -> Singularities:
    """Return the determinant of the Jacobian of a frame, factored, and the positions where it vanishes, in words.

    As many components of the twist of the frame as joints that move them are taken: all that some joint changes, or
    those named, as in "tool.x", "tool.y" (Khalil and Dombre 2002, 5.3). Each factor is a condition on the joint
    variables; at such a position the result names the joints that move the components alike, and the motion lost.

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

    whole = the_machine(machine)
    asked = [*options.components] or [whole.joints[-1].name]
    frame = str(replace(RequestedPart.parse(asked[0]), component=""))
    symbols, numbers = {"jacobian_determinant": asked}, {"inverse_jacobian": asked, "jacobian": [frame]}
    with placed({"--only, jacobian_determinant": "--component"}):
        symbolic = load(whole, *symbols, only=symbols, scene=options.scene, backend="sympy")
    model = load(whole, *numbers, only=numbers, scene=options.scene)
    (inverse,) = (f.results[0] for f in model.package.functions if f.name == "inverse_jacobian")
    names = [axis.name for axis in model.package.axes]
    rows, columns = map(COMPONENTS.index, inverse.columns), map(names.index, inverse.rows)
    variables = dict(axis.unit.split(", ") for axis in model.package.axes)
    task = Task(whole.label, variables, inverse.rows, tuple(f"{frame}.{x}" for x in inverse.columns), _values(model))
    samples = Samples(model.jacobian, tuple(rows), tuple(columns), task)
    determinant, positions = singular_positions(symbolic.jacobian_determinant()[0], task, samples)
    return Singularities(whole.name, task.components, inverse.rows, str(determinant), latex(determinant), positions)


def _values(model: LoadedModel) -> dict[str, float]:
    """Values of the parameters; those of a robot of usual size for parameters that have none."""
    parameters = model.package.parameters
    lengths = np.linspace(*UNKNOWN, len(parameters))
    return {p.name: x if np.isnan(p.value) else p.value for p, x in zip(parameters, lengths.tolist(), strict=True)}
