"""The machine and the scene that a command line asks for."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import click

from symoro_elastic.cli.parsing import outputs
from symoro_elastic.errors import among

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
    form: str = "recursion"

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
        from symoro_elastic.api.scenes import in_form

        scene = scene_of(machine, self.scene, self.models, self.fold, self.only)
        return in_form(replace(scene, merge_angles=self.merge_angles), self.form)

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
    """Return the machine of a file with the joints locked that the scene locks, without wrenches as arguments."""
    from symoro_elastic.machine.restrict import restricted

    machine = read(path)
    return replace(restricted(machine, scene_of(machine, scene)), forces=())


def scene_of(
    machine: Machine, file: str | None, models: Sequence[str] = (), fold: Sequence[str] = (), only: Sequence[str] = ()
) -> Scene:
    """Return the scene of the file or of the machine, with models, constants and outputs added.

    Springs in series that the scene condenses are named on stderr.
    """
    from symoro_elastic.api.scenes import Asked

    return Asked(models, fold, outputs(only, "--only")).of(machine, file, note)


def note(line: str) -> None:
    """Print a note on stderr."""
    click.echo(f"note: {line}", err=True)


def of_parameters(values: Mapping[str, float], machine: Machine) -> dict[str, float]:
    """Return the values by parameter; raise `InputError` for a name that is no parameter of the machine."""
    among(tuple(values), tuple(parameter.name for parameter in machine.parameters), "--value")
    return dict(values)
