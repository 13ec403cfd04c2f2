"""Scenes read from a table of a machine file, or from their own file."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from symoro_elastic.formats.files import load_text
from symoro_elastic.formats.toml.keys import SCENE
from symoro_elastic.formats.toml.tables import Table, load
from symoro_elastic.formats.toml.within import KEYS, within_of
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.resolve import Models, resolve
from symoro_elastic.machine.scene import Scene

BESIDE = ("motion", "wanted")
"""Tables of a scene file beside its scene."""


def read_scene(path: str | Path, machine: Machine, models: Models | None = None) -> Scene:
    """The scene in a TOML file, its names resolved in `machine`; raises `InputError`.

    Its keys stand under [scene] or at the top; tables of motions beside it are left to `read_motions`.
    """
    return scene_in(load(load_text(path), str(path)), machine, models)


def scene_in(top: Table, machine: Machine, models: Models | None = None) -> Scene:
    """The scene in the top table of a file, as `read_scene` gives it."""
    source, top = top.source, replace(top, entries={key: x for key, x in top.entries.items() if key not in BESIDE})
    if "scene" in top.entries:
        top = top.only(("scene",)).table("scene")
    return resolve(scene_of(top), machine, models, source)


def scene_of(table: Table) -> Scene:
    """The scene in a table, its names as written."""
    entries = SCENE.within(table)
    within = within_of(entries)
    return Scene(**{key: x for key, x in entries.items() if key not in KEYS}, within=within)
