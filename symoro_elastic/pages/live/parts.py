"""Parts of the live page of a file, quick ones first; computed in a separate process."""

from __future__ import annotations

import multiprocessing
import os
from collections.abc import Iterator
from dataclasses import dataclass
from html import escape
from typing import Any

from symoro_elastic.formats.reading import read_content
from symoro_elastic.formats.toml.editing import MOST_CHARACTERS, Lines, tables_of
from symoro_elastic.formats.toml.reading import read as read_toml
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.generation.pipeline import prepare_machine, programs
from symoro_elastic.machine.described import DescribedMachine
from symoro_elastic.machine.format_names import TOML
from symoro_elastic.machine.restrict import restrict
from symoro_elastic.machine.scene import Scene
from symoro_elastic.models.packaging import reserved_words
from symoro_elastic.models.programs.catalogue import MODELS
from symoro_elastic.numerics.linear.grouping import base_parameters
from symoro_elastic.pages.drawing.figure import placements_of
from symoro_elastic.pages.drawing.page import ShownMachine, machine_page, shown_machine
from symoro_elastic.pages.equations.page import html_page
from symoro_elastic.pages.report.sections import COUNTED, refuse_large

AFTER_THE_PICTURE = 5
"""By how much the priority of the process falls once the picture is there."""


@dataclass(frozen=True)
class Part:
    """A part of the page by its name: data as JSON, and a page if it has one."""

    name: str
    data: Any
    page: str = ""


def is_toml(path: str) -> bool:
    """Return whether a file is TOML, by its suffix: only its cells can be written."""
    return path.lower().endswith(TOML.suffixes)


def parts_of_file(path: str, content: bytes) -> Iterator[Part]:
    """Yield the parts of a file of this content: cells, its errors, picture, modes, base parameters, counts."""
    text = content.decode("utf-8-sig", "replace")
    lines = Lines(text if is_toml(path) else "", path)
    yield Part("models", {"titles": {name: model.title for name, model in MODELS.items()}})
    yield Part("cells", _cells(path, text))
    warnings: list[str] = []
    try:
        machine = prepare_machine(read_content(content, path, reserved_words()), warnings.append)
        scene_machine = restrict(machine, machine.asked.scene or Scene())
        placements = placements_of(scene_machine)
        page = machine_page(ShownMachine(placements, placements.start), still=False)
    except InputError as error:
        yield Part("checked", {"error": _message_in_text(lines, text, error.place, error.what), "warnings": []})
        return
    messages = [_message_in_text(lines, text, *_split(warning)) for warning in warnings]
    yield Part("checked", {"error": None, "warnings": messages, "headline": scene_machine.headline})
    yield Part("picture", {"modes": False}, page)
    if multiprocessing.parent_process():
        os.nice(AFTER_THE_PICTURE)
    yield Part("picture", {"modes": True}, machine_page(shown_machine(scene_machine, {})))
    yield Part("base", _base(scene_machine))
    yield Part("cost", _cost(scene_machine))


def _cells(path: str, text: str) -> dict[str, Any]:
    """The tables of a file that can be edited, or why there are none."""
    if not is_toml(path):
        return {"tables": [], "refused": "Cells of .toml files are edited here; this file is shown as it is saved."}
    if len(text) > MOST_CHARACTERS:
        return {"tables": [], "refused": "The file is too long to be edited here: change it in an editor."}
    try:
        return {"tables": tables_of(text, path), "refused": ""}
    except InputError:
        return {"tables": None, "refused": ""}


def _split(warning: str) -> tuple[str, str]:
    place, _, what = warning.partition(": ")
    return (place, what) if what else ("", place)


def _message_in_text(lines: Lines, text: str, place: str, what: str) -> dict[str, Any]:
    """A message with its line and the text of it."""
    number = lines.of(place)
    rows = text.splitlines()
    row = rows[number - 1] if number and number <= len(rows) else ""
    return {"place": place, "what": what, "line": number, "text": row[:400]}


def _base(machine: DescribedMachine) -> dict[str, Any]:
    try:
        base = base_parameters(machine)
    except InputError as error:
        return {"refused": f"{error.place}: {error.what}", "rows": []}
    rows = [[name, str(x)] for name, x in {**base.parts, **base.formulas}.items()]
    return {"refused": "" if rows else base.check, "rows": rows}


def _cost(machine: DescribedMachine) -> dict[str, Any]:
    try:
        traced = programs(machine, Scene(models=COUNTED)).models
    except InputError as error:
        return {"refused": f"{error.place}: {error.what}", "rows": []}
    counts = ((function.model.name, function.program.count) for function in traced)
    return {"refused": "", "rows": [[name, count.products, count.add, count.sincos] for name, count in counts]}


def equations_of_file(path: str, content: bytes, model: str) -> Iterator[Part]:
    """Yield the equations of a model of a machine as a page, or the reason of a failure."""
    try:
        machine = prepare_machine(read_content(content, path, reserved_words()), lambda _: None)
        refuse_large(machine, "symoro-elastic equations writes them to a page of their own")
        scene = Scene(models=(model,))
        package = programs(restrict(machine, machine.asked.scene or Scene()), scene).package
        page = html_page(package, package.functions[0])
    except InputError as error:
        page = f"<!doctype html><title>{escape(model)}</title><p>{escape(f'{error.place}: {error.what}')}</p>"
    yield Part("equations", {"model": model}, page)


def fault_of_text(path: str, text: str) -> Iterator[Part]:
    """Yield the fault of a text before it is written to a TOML file; nothing for a valid machine."""
    try:
        prepare_machine(read_toml(text, path), lambda _: None)
    except InputError as error:
        yield Part("fault", f"{error.place}: {error.what}")
