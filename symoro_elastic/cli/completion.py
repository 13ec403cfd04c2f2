"""What the shell completes: names of models, targets and formats, and of the parts of the machine that is given."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from symoro_elastic.machine.machine import Machine

Completion = Callable[[click.Context, click.Parameter, str], list[str]]


def completed_from(names: Callable[[], Iterable[str]]) -> Completion:
    """Complete with these names."""
    return lambda _context, _option, begun: [name for name in names() if name.startswith(begun)]


def completed_from_machine(names: Callable[[Machine], Iterable[str]]) -> Completion:
    """Complete with names of the machine whose file the command line names, with none where it cannot be read."""

    def complete(context: click.Context, _option: click.Parameter, begun: str) -> list[str]:
        from symoro_elastic.errors import InputError
        from symoro_elastic.machine.formats.reading import read

        for path in (context.params.get("machine"), *context.args):
            try:
                return [name for name in names(read(path or "")) if name.startswith(begun)]
            except InputError:
                continue
        return []

    return complete


def _models() -> Iterable[str]:
    from symoro_elastic.models.catalogue import MODELS

    return MODELS


def _targets() -> Iterable[str]:
    from symoro_elastic import fmu
    from symoro_elastic.codegen.targets import TARGETS

    return (*TARGETS, fmu.NAME)


def _forms() -> Iterable[str]:
    from symoro_elastic.machine.scene import FORMS

    return FORMS


def _precisions() -> Iterable[str]:
    from symoro_elastic.codegen.precision import PRECISIONS

    return PRECISIONS


def _pictures() -> Iterable[str]:
    from symoro_elastic.pictures import PICTURE_FORMATS

    return PICTURE_FORMATS


def _methods() -> Iterable[str]:
    from symoro_elastic.integration.methods import METHODS

    return METHODS


def _freed() -> Iterable[str]:
    from symoro_elastic.machine.freed import SECTIONS

    return SECTIONS


MODELS = completed_from(_models)
FORMS = completed_from(_forms)
TARGETS = completed_from(_targets)
PRECISIONS = completed_from(_precisions)
METHODS = completed_from(_methods)
FREED = completed_from(_freed)
PICTURES = completed_from(_pictures)
DOCUMENTS = completed_from(lambda: ("latex", "html", "pdf"))
MOTORS = completed_from_machine(lambda machine: [*(joint.name for joint in machine.motor_joints), "all"])
PARAMETERS = completed_from_machine(lambda machine: [*(parameter.name for parameter in machine.parameters), "all"])
