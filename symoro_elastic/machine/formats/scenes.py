"""Scenes read from a table of a machine file, or from their own file."""

from __future__ import annotations

from pathlib import Path

from symoro_elastic.machine.formats.files import load_text
from symoro_elastic.machine.formats.tables import Table, load
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.resolve import Models, resolve
from symoro_elastic.machine.scene import ALL, Scene

KEYS = ("models", "outputs", "locked", "fold", "gravity")


def read_scene(path: str | Path, machine: Machine, models: Models | None = None) -> Scene:
    """The scene in a TOML file, its names resolved in `machine`; raises `InputError`."""
    top = load(load_text(path), str(path))
    if "scene" in top.entries:
        top = top.only(("scene",)).table("scene")
    return resolve(scene_of(top), machine, models, str(path))


def scene_of(table: Table) -> Scene:
    """The scene in a table, its names as written."""
    table.only(KEYS)
    outputs, locked = table.table("outputs"), table.table("locked")
    fold = table.entries.get("fold", [])
    return Scene(
        models=table.texts("models"),
        outputs={model: outputs.texts(model) for model in outputs.entries},
        locked={joint: locked.formula(joint) for joint in locked.entries},
        fold=ALL if fold == ALL else table.texts("fold"),
        gravity=table.truth("gravity", True),
    )
