"""What the live page shows of a file, part after part, the quick ones first; computed in a process of its own."""

from __future__ import annotations

import multiprocessing
import os
from collections.abc import Iterator
from dataclasses import dataclass
from html import escape
from typing import Any

from symoro_elastic.formats.toml.editing import MOST_CHARACTERS, Lines, tables_of
from symoro_elastic.formats.toml.reading import read as read_toml
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.generation.pipeline import prepare, prepare_machine, programs
from symoro_elastic.machine.described import DescribedMachine
from symoro_elastic.machine.format_names import TOML
from symoro_elastic.machine.restrict import restrict
from symoro_elastic.machine.scene import Scene
from symoro_elastic.models.catalogue import MODELS
from symoro_elastic.numerics.grouping import base_parameters
from symoro_elastic.pages.drawing.page import machine_page
from symoro_elastic.pages.drawing.placements import placements_of
from symoro_elastic.pages.drawing.shown import ShownMachine, shown_machine
from symoro_elastic.pages.equations.page import html_page
from symoro_elastic.pages.report.sections import COUNTED, refuse_large

AFTER_THE_PICTURE = 5
"""By how much the priority of the process falls once the picture is there."""


@dataclass(frozen=True)
class Part:
    """A part of the page by its name: data as JSON has them, and a page of its own where it is one."""

    name: str
    data: Any
    page: str = ""


def is_toml(path: str) -> bool:
    """Return whether a file is one whose cells can be written."""
    return path.lower().endswith(TOML.suffixes)


def parts_of_file(path: str, text: str) -> Iterator[Part]:
    """Yield the parts of a file with this text: cells, what its check says, picture, modes, base parameters, counts."""
    lines = Lines(text if is_toml(path) else "", path)
    yield Part("models", {"titles": {name: model.title for name, model in MODELS.items()}})
    yield Part("cells", _cells(path, text))
    warnings: list[str] = []
    try:
        machine = prepare(path, warnings.append)
        kept = restrict(machine, machine.asked.scene or Scene())
        placements = placements_of(kept)
        page = machine_page(ShownMachine(placements, placements.start), still=False)
    except InputError as error:
        yield Part("checked", {"error": _placed(lines, text, error.place, error.what), "warnings": []})
        return
    said = [_placed(lines, text, *_split(warning)) for warning in warnings]
    yield Part("checked", {"error": None, "warnings": said, "headline": kept.headline})
    yield Part("picture", {"modes": False}, page)
    if multiprocessing.parent_process():
        os.nice(AFTER_THE_PICTURE)
    yield Part("picture", {"modes": True}, machine_page(shown_machine(kept, {})))
    yield Part("base", _base(kept))
    yield Part("cost", _cost(kept))


def _cells(path: str, text: str) -> dict[str, Any]:
    """The tables of a file that are edited, or why there are none."""
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


def _placed(lines: Lines, text: str, place: str, what: str) -> dict[str, Any]:
    """A message with its line and the text of it."""
    number = lines.of(place)
    rows = text.splitlines()
    shown = rows[number - 1] if number and number <= len(rows) else ""
    return {"place": place, "what": what, "line": number, "text": shown[:400]}


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
    counts = ((one.model.name, one.program.count) for one in traced)
    return {"refused": "", "rows": [[name, count.products, count.add, count.sincos] for name, count in counts]}


def equations_of_file(path: str, model: str) -> Iterator[Part]:
    """Yield the equations of a model of a machine as a page; what cannot be written says why."""
    try:
        machine = prepare(path, lambda _: None)
        refuse_large(machine, "symoro-elastic equations writes them to a page of their own")
        scene = Scene(models=(model,))
        package = programs(restrict(machine, machine.asked.scene or Scene()), scene).package
        page = html_page(package, package.functions[0])
    except InputError as error:
        page = f"<!doctype html><title>{escape(model)}</title><p>{escape(f'{error.place}: {error.what}')}</p>"
    yield Part("equations", {"model": model}, page)


def fault_of_text(path: str, text: str) -> Iterator[Part]:
    """Yield what is wrong with a text before it is written to a TOML file; nothing where it is a machine."""
    try:
        prepare_machine(read_toml(text, path), lambda _: None)
    except InputError as error:
        yield Part("fault", f"{error.place}: {error.what}")
