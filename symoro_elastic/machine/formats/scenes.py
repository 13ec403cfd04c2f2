"""Scenes read from a table of a machine file, or from their own file."""

from __future__ import annotations

from pathlib import Path

from symoro_elastic.machine.formats.files import load_text
from symoro_elastic.machine.formats.tables import Table, load
from symoro_elastic.machine.formats.toml_keys import SCENE
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.resolve import Models, resolve
from symoro_elastic.machine.scene import Scene


def read_scene(path: str | Path, machine: Machine, models: Models | None = None) -> Scene:
    """The scene in a TOML file, its names resolved in `machine`; raises `InputError`."""
    top = load(load_text(path), str(path))
    if "scene" in top.entries:
        top = top.only(("scene",)).table("scene")
    return resolve(scene_of(top), machine, models, str(path))


def scene_of(table: Table) -> Scene:
    """The scene in a table, its names as written."""
    return Scene(**SCENE.within(table))
