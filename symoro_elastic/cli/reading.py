"""The machine and the scene that a command line asks for."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import click

from symoro_elastic.cli.parsing import among, outputs

if TYPE_CHECKING:
    from symoro_elastic.machine.formats.format import Conversion
    from symoro_elastic.machine.machine import Machine
    from symoro_elastic.machine.scene import Scene
    from symoro_elastic.progress import Announce


@dataclass(frozen=True)
class Selection:
    """Models, constants and outputs selected on the command line, added to the scene of a file."""

    models: tuple[str, ...] = ()
    fold: tuple[str, ...] = ()
    only: tuple[str, ...] = ()
    scene: str | None = None
    base: bool = False
    merge_angles: float | None = None
    free: tuple[str, ...] = ()

    def read(self, path: str, announce: Announce | None = None) -> tuple[Machine, Scene]:
        """Return the machine of a file, with grouped parameters if requested, and its scene."""
        machine = read(path, self.base, announce, self._free())
        return machine, self.scene_of(machine)

    def _free(self) -> tuple[str, ...]:
        """The tables whose numbers stay parameters; raises `InputError` for others."""
        from symoro_elastic.machine.freed import SECTIONS

        return among([name.strip() for tables in self.free for name in tables.split(",")], SECTIONS, "--free")

    def scene_of(self, machine: Machine) -> Scene:
        """Return the scene of the file or of the machine, with the selection added."""
        scene = scene_of(machine, self.scene, self.models, self.fold, self.only)
        return replace(scene, merge_angles=self.merge_angles)

    def as_words(self) -> list[str]:
        """The options as `generate` takes them, without models and merged angles."""
        words = [word for name in self.fold for word in ("--fold", name)] + ["--base"] * self.base
        words += [word for name in self.only for word in ("--only", name)]
        return [*words, *(["--scene", self.scene] if self.scene else [])]


def read(
    path: str,
    base: bool = False,
    announce: Announce | None = None,
    free: tuple[str, ...] = (),
    conversion: Conversion | None = None,
) -> Machine:
    """Return the machine of a file, its inertial parameters grouped if `base`, numbers of tables `free` as parameters.

    A robot as links and joints gets the changes of `conversion`. Prints its warnings on stderr.
    """
    from symoro_elastic.pipeline import prepare
    from symoro_elastic.progress import announce_nothing

    announce = announce or announce_nothing
    return prepare(path, _warn, base=base, free=free, conversion=conversion, announce=announce)


def _warn(warning: str) -> None:
    click.echo(f"warning: {warning}", err=True)


def read_restricted(path: str, scene: str | None = None) -> Machine:
    """Return the machine of a file with the joints locked that the scene locks."""
    from symoro_elastic.machine.restrict import restricted

    machine = read(path)
    return restricted(machine, scene_of(machine, scene))


def scene_of(
    machine: Machine, file: str | None, models: Sequence[str] = (), fold: Sequence[str] = (), only: Sequence[str] = ()
) -> Scene:
    """Return the scene of the file or of the machine, with models, constants and outputs added.

    Models of the command line replace those of the scene, and their outputs go with them. Springs in series that the
    scene condenses are named on stderr.
    """
    from symoro_elastic.machine.formats import read_scene
    from symoro_elastic.machine.resolve import resolve
    from symoro_elastic.machine.scene import ALL, Scene
    from symoro_elastic.machine.series_springs import condensed
    from symoro_elastic.models.catalogue import DEFAULT_MODELS, MODELS

    scene = read_scene(file, machine, MODELS) if file else machine.scene or Scene()
    if models:
        dropped = set(scene.models or DEFAULT_MODELS) - set(models)
        kept = {model: names for model, names in scene.outputs.items() if model not in dropped}
        scene = replace(scene, models=tuple(dict.fromkeys(models)), outputs=kept)
    if fold:
        everything = ALL in fold or scene.fold == ALL
        scene = replace(scene, fold=ALL if everything else (*scene.fold, *fold))
    added = resolve(Scene(outputs=outputs(only, "--only")), machine, MODELS, "symoro-elastic").outputs
    merged = {m: (*scene.outputs.get(m, ()), *added.get(m, ())) for m in (*scene.outputs, *added)}
    scene = resolve(replace(scene, outputs=merged), machine, MODELS, file or machine.source)
    if scene.condense:
        for note in condensed(machine).notes:
            click.echo(f"note: {note}", err=True)
    return scene


def of_parameters(values: Mapping[str, float], machine: Machine) -> dict[str, float]:
    """Return the values by parameter; raise `InputError` for a name that is no parameter of the machine."""
    among(tuple(values), tuple(parameter.name for parameter in machine.parameters), "--value")
    return dict(values)
