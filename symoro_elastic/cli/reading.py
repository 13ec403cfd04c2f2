"""What the words of a command line stand for: a machine, its scene, names, numbers."""

from __future__ import annotations

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
    for warning in warnings:
        click.echo(f"warning: {warning}", err=True)
    if not base:
        return machine
    from symoro_elastic.grouping import base_machine

    return base_machine(machine)


def scene_of(machine: Machine, file: str | None, models: Sequence[str], fold: Sequence[str]) -> Scene:
    """The scene of the file or of the machine, with what the command line adds."""
    from dataclasses import replace

    from symoro_elastic.machine.formats import read_scene
    from symoro_elastic.machine.resolve import resolve
    from symoro_elastic.machine.scene import ALL, Scene
    from symoro_elastic.models.catalogue import MODELS

    scene = read_scene(file, machine, MODELS) if file else machine.scene or Scene()
    if models:
        scene = replace(scene, models=tuple(dict.fromkeys(models)))
    if fold:
        everything = ALL in fold or scene.fold == ALL
        scene = replace(scene, fold=ALL if everything else (*scene.fold, *fold))
    return resolve(scene, machine, MODELS, file or machine.source)


def among(names: Sequence[str], known: Sequence[str] | dict[str, Any], option: str) -> tuple[str, ...]:
    """The names given to an option, each one of those known."""
    for name in names:
        if name not in known:
            raise InputError("symoro-elastic", option, f"there is no {name!r}: choose from {', '.join(known)}")
    return tuple(dict.fromkeys(names))


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
