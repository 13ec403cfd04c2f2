"""The journey from a machine to files: check, trace, render, write."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from symoro_elastic.codegen.package import Package
from symoro_elastic.codegen.precision import DOUBLE, Precision
from symoro_elastic.codegen.targets import render_targets
from symoro_elastic.errors import InputError
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.restrict import folded, restricted
from symoro_elastic.machine.scene import BASE, Scene
from symoro_elastic.models.catalogue import DEFAULT_MODELS, MODELS, TracedModel, trace_scene
from symoro_elastic.models.degenerate import Degeneracy, degeneracies
from symoro_elastic.models.model import Pivots
from symoro_elastic.output_folder import write_files
from symoro_elastic.packaging import package
from symoro_elastic.symbolic.memory import no_collection


@dataclass(frozen=True)
class Generated:
    """What was written, and the models it holds; `whole` are the same models of the whole machine."""

    written: list[Path]
    models: list[TracedModel]
    whole: list[TracedModel]


def nothing(_: str) -> None:
    """Progress that nobody watches."""


@no_collection()
def generate(
    machine: Machine,
    scene: Scene,
    targets: Sequence[str],
    out: Path,
    step: Callable[[str], None] = nothing,
    precisions: Sequence[Precision] = (DOUBLE,),
) -> Generated:
    """Write the models that a scene asks of a machine to `out/<machine name>/`, C in each of the precisions.

    `step` is told each step of the journey by its verb. Raises `InputError`; nothing is written then.
    """
    step("check")
    refuse_degenerate(machine, scene)
    step("trace")
    models = trace_scene(machine, scene)
    whole = [_of_whole(machine, model) for model in models] if is_part(scene) else models
    step("render")
    described = package(restricted(machine, scene), models, folded(machine, scene), describe(scene, models))
    files = render(described, targets, machine.source, precisions)
    step("write")
    return Generated(write_files(out / machine.name, files), models, whole)


def described(machine: Machine, scene: Scene) -> Package:
    """The models that a scene asks of a machine, ready to be rendered. Raises `InputError`."""
    refuse_degenerate(machine, scene)
    models = trace_scene(machine, scene)
    return package(restricted(machine, scene), models, folded(machine, scene), describe(scene, models))


@no_collection()
def render(
    described: Package, targets: Sequence[str], source: str, precisions: Sequence[Precision] = (DOUBLE,)
) -> dict[str, str]:
    """File names and texts; raises `InputError` for constants that no double holds and for too low a precision."""
    _refuse_low_precision(described, source, precisions)
    try:
        return render_targets(described, targets, precisions)
    except OverflowError:
        what = "their products are out of the range of double precision: check the units"
        raise InputError(source or described.name, "numbers of the table", what) from None


def _refuse_low_precision(described: Package, source: str, precisions: Sequence[Precision]) -> None:
    for function in described.functions:
        low = [precision.name for precision in precisions if precision.bits < function.least_bits]
        if low:
            what = (
                f"{function.name} finds no solution in {low[0]} precision: --precision double, or leave the model out"
            )
            raise InputError(source or described.name, "--precision", what)


def refuse_degenerate(machine: Machine, scene: Scene) -> None:
    """Raise `InputError` for a machine whose asked models would divide by zero at every position."""
    found = found_degeneracies(machine, scene)
    if found:
        message, joints = found[0]
        likewise = "".join(f"; likewise {others}" for _, others in found[1:])
        raise machine.error(joints, message + likewise)


def found_degeneracies(machine: Machine, scene: Scene) -> list[tuple[str, str]]:
    """(message, joints) of each pivot that is zero in one of the asked models."""
    kept, constants = restricted(machine, scene), folded(machine, scene)
    asked = {MODELS[name].pivots for name in scene.models or DEFAULT_MODELS if name in MODELS}
    found: dict[int, Degeneracy] = {}
    for pivots in Pivots:
        if pivots in asked:
            for degeneracy in degeneracies(kept, pivots is Pivots.WITHOUT_MOTOR, constants):
                found.setdefault(degeneracy.joint, degeneracy)
    ordered = [found[j] for j in sorted(found)]
    return [(d.message(kept), ", ".join(f"joint {j}" if j else BASE for j in d.moving_together)) for d in ordered]


def is_part(scene: Scene) -> bool:
    """Whether a scene asks for less than the whole machine."""
    return bool(scene.outputs or scene.locked or scene.fold or not scene.gravity)


def _of_whole(machine: Machine, part: TracedModel) -> TracedModel:
    """The same model, nothing left out; itself where it exists only with joints locked."""
    try:
        return trace_scene(machine, Scene(models=(part.model.name,)))[0]
    except InputError:
        return part


def describe(scene: Scene, models: Sequence[TracedModel] = ()) -> str:
    """A scene and its models in a few words; empty for the whole machine."""
    parts = [f"{name} held at {value}" for name, value in scene.locked.items()]
    parts += ["without gravity"] if not scene.gravity else []
    if any(model.merged for model in models):
        parts.append(f"angles are summed: valid for |q| <= {scene.merge_angles:g} rad")
    return ", ".join(parts)
