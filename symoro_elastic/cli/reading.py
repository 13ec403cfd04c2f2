"""What the words of a command line stand for: a machine, its scene, names, numbers."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import click

from symoro_elastic.errors import InputError

if TYPE_CHECKING:
    from symoro_elastic.machine.machine import Machine
    from symoro_elastic.machine.scene import Scene


def read(path: str, base: bool = False) -> Machine:
    """The machine of a file, its warnings on stderr; regrouped where base parameters are asked for."""
    from symoro_elastic.machine.formats import read_machine

    machine, warnings = read_machine(path)
    _warn(warnings)
    if not base:
        return machine
    from symoro_elastic.grouping import base_machine

    regrouped, doubts = base_machine(machine)
    _warn(doubts)
    return regrouped


def _warn(warnings: Sequence[str]) -> None:
    for warning in warnings:
        click.echo(f"warning: {warning}", err=True)


def scene_of(
    machine: Machine, file: str | None, models: Sequence[str] = (), fold: Sequence[str] = (), only: Sequence[str] = ()
) -> Scene:
    """The scene of the file or of the machine, with what the command line adds.

    Models of the command line replace those of the scene, and their outputs go with them.
    """
    from dataclasses import replace

    from symoro_elastic.machine.formats import read_scene
    from symoro_elastic.machine.resolve import resolve
    from symoro_elastic.machine.scene import ALL, Scene
    from symoro_elastic.models.catalogue import DEFAULT_MODELS, MODELS

    scene = read_scene(file, machine, MODELS) if file else machine.scene or Scene()
    if models:
        dropped = set(scene.models or DEFAULT_MODELS) - set(models)
        outputs = {model: names for model, names in scene.outputs.items() if model not in dropped}
        scene = replace(scene, models=tuple(dict.fromkeys(models)), outputs=outputs)
    if fold:
        everything = ALL in fold or scene.fold == ALL
        scene = replace(scene, fold=ALL if everything else (*scene.fold, *fold))
    added = resolve(Scene(outputs=_outputs(only)), machine, MODELS, "symoro-elastic").outputs
    outputs = {m: (*scene.outputs.get(m, ()), *added.get(m, ())) for m in (*scene.outputs, *added)}
    return resolve(replace(scene, outputs=outputs), machine, MODELS, file or machine.source)


def with_merged_angles(scene: Scene, bound: float | None) -> Scene:
    """The scene that allows sums of angles up to this bound, rad; as it is without one."""
    from dataclasses import replace

    if bound is not None and not math.isfinite(bound):
        raise InputError("symoro-elastic", "--merge-angles", f"{bound} is no bound: write the largest angle, rad")
    return replace(scene, merge_angles=bound)


def _outputs(only: Sequence[str]) -> dict[str, tuple[str, ...]]:
    """`MODEL=NAME` or `MODEL by NAMES`, by model."""
    from symoro_elastic.machine.scene import BY

    found: dict[str, tuple[str, ...]] = {}
    for text in only:
        model, equals, name = (part.strip() for part in text.partition("="))
        if not equals:
            model, by, name = (part.strip() for part in text.partition(BY))
            name = f"{by} {name}".strip()
        if not (model and name):
            what = f"{text!r} is not MODEL=NAME, as in 'jacobian=tool at (0.1, 0, L2) in base'"
            raise InputError("symoro-elastic", "--only", what)
        found[model] = (*found.get(model, ()), name)
    return found


def among(names: Sequence[str], known: Sequence[str] | dict[str, Any], option: str) -> tuple[str, ...]:
    """The names given to an option, each one of those known."""
    for name in names:
        if name not in known:
            raise InputError("symoro-elastic", option, f"there is no {name!r}: choose from {', '.join(known)}")
    return tuple(dict.fromkeys(names))


def ranges(given: Sequence[str], option: str) -> dict[str, tuple[float, float]]:
    """`NAME=LOW:HIGH` by name, or `NAME=X` for -X:X; the name "" where none is given."""
    found = {}
    for text in given:
        name, _, limit = text.rpartition("=")
        low, colon, high = limit.partition(":")
        try:
            found[name.strip()] = (float(low), float(high)) if colon else (-float(low), float(low))
            if not all(map(math.isfinite, found[name.strip()])):
                raise ValueError
        except ValueError:
            raise InputError("symoro-elastic", option, f"{text!r} is no limit: X, LOW:HIGH, NAME=X ...") from None
    return found


def numbers(given: Sequence[str], option: str) -> dict[str, float]:
    """`NAME=X` by name."""
    found = {}
    for text in given:
        name, _, number = text.partition("=")
        try:
            found[name.strip()] = float(number)
        except ValueError:
            raise InputError("symoro-elastic", option, f"{text!r} is not NAME=NUMBER") from None
    return found


def parameter_values(given: Sequence[str], machine: Machine) -> dict[str, float]:
    """`--value NAME=X` by name, each the name of a parameter of the machine."""
    found = numbers(given, "--value")
    among(tuple(found), tuple(p.name for p in machine.parameters), "--value")
    return found
