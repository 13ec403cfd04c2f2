"""What is asked of a machine: scenes, motions and tolerances, from files, tables or arguments."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, TypeAlias

from symoro_elastic.api.machines import MachineLike, the_machine
from symoro_elastic.errors import InputError, among
from symoro_elastic.machine.formats.files import load_text
from symoro_elastic.machine.formats.motions import motions_of, wanted_of
from symoro_elastic.machine.formats.scenes import scene_in
from symoro_elastic.machine.formats.tables import Table, load, table_of
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.prescribed_motion import PrescribedMotion
from symoro_elastic.machine.resolve import resolve
from symoro_elastic.machine.restrict import restricted
from symoro_elastic.machine.scene import ALL, FORMS, RECURSION, Scene
from symoro_elastic.machine.series_springs import condensed
from symoro_elastic.machine.wanted import Wanted
from symoro_elastic.models.catalogue import DEFAULT_MODELS, MODELS

SceneLike: TypeAlias = Scene | str | Path | Mapping[str, Any] | None
"""A scene, its TOML file, or the tables of such a file as dictionaries and lists; None is that of the machine."""
ARGUMENTS = "symoro-elastic"


def no_note(_line: str) -> None:
    """Drop a note."""


@dataclass(frozen=True)
class Asked:
    """Models, constants and outputs that are added to the scene of a file.

    `outputs` are names of joints or frames by model, or columns of derivatives ("by M1, K2").
    """

    models: Sequence[str] = ()
    fold: Sequence[str] = ()
    outputs: Mapping[str, Sequence[str]] | None = None
    steps: Sequence[str] = ()

    def of(self, machine: Machine, scene: SceneLike, note: Callable[[str], None] = no_note) -> Scene:
        """Return the scene of a machine with these added.

        Models replace those of the scene, and their outputs go with them. `note` is called with a line for springs in
        series that the scene condenses.
        """
        found = self._with_models(given_scene(machine, scene))
        if self.fold:
            everything = ALL in self.fold or found.fold == ALL
            found = replace(found, fold=ALL if everything else (*found.fold, *self.fold))
        asked = Scene(outputs={model: tuple(names) for model, names in (self.outputs or {}).items()})
        added = resolve(asked, machine, MODELS, ARGUMENTS).outputs
        merged = {m: (*found.outputs.get(m, ()), *added.get(m, ())) for m in (*found.outputs, *added)}
        steps = tuple(dict.fromkeys((*found.steps, *self.steps)))
        found = resolve(replace(found, outputs=merged, steps=steps), machine, MODELS, found.source or machine.source)
        for line in condensed(machine).notes if found.condense else ():
            note(line)
        return found

    def _with_models(self, scene: Scene) -> Scene:
        if not self.models:
            return scene
        dropped = set(scene.models or DEFAULT_MODELS) - set(self.models)
        kept = {model: names for model, names in scene.outputs.items() if model not in dropped}
        return replace(scene, models=tuple(dict.fromkeys(self.models)), outputs=kept)


def in_form(scene: Scene, form: str) -> Scene:
    """Return the scene with direct_dynamics in a form, where that is not the usual one; raises `InputError`."""
    among((form,), FORMS, "--form")
    return scene if form == RECURSION else replace(scene, form=form)


def top_of(scene: str | Path | Mapping[str, Any]) -> Table:
    """Return the top table of a scene file, or of the tables given in its place."""
    if isinstance(scene, Mapping):
        return table_of(scene, "scene")
    return load(load_text(scene), str(scene))


def given_scene(machine: Machine, scene: SceneLike) -> Scene:
    """Return the scene of a file, of tables, or of the machine."""
    if isinstance(scene, Scene):
        return scene
    return (machine.scene or Scene()) if scene is None else scene_in(top_of(scene), machine, MODELS)


def kept_machine(machine: MachineLike, scene: SceneLike) -> Machine:
    """Return a machine with the joints locked that the scene locks."""
    found = the_machine(machine)
    return replace(restricted(found, Asked().of(found, scene)), forces=())


@dataclass(frozen=True)
class Prescribed:
    """Motions of a scene, and what is wanted of them; `source` is their file."""

    motions: tuple[PrescribedMotion, ...]
    wanted: Wanted | None
    source: str


def prescribed(machine: Machine, scene: SceneLike) -> Prescribed:
    """Return the motions of a scene, or those of the machine's file; raises `InputError` where there are none."""
    found = described(machine, scene)
    if not found.motions:
        what = "missing: write a table [motion] with duration and moves, or give a scene that has one"
        raise InputError(found.source, "motion", what)
    return found


def described(machine: Machine, scene: SceneLike) -> Prescribed:
    """Return the motions of a scene, or those of the machine's file, however many there are."""
    if scene is None or isinstance(scene, Scene):
        return Prescribed(machine.motions, machine.wanted, machine.source or machine.name)
    top = top_of(scene)
    return Prescribed(motions_of(top, machine), wanted_of(top), top.source)
