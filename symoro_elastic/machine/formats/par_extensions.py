"""The extension lines of a .par file: what the format itself cannot hold."""

from __future__ import annotations

import json
import re
from collections import Counter
from collections.abc import Collection, Iterable, Mapping, Sequence
from enum import Enum
from typing import Any

from symoro_elastic.machine.columns import cells
from symoro_elastic.machine.formats.motions import entries_of_motion, entries_of_wanted
from symoro_elastic.machine.formats.par_loops import common_start
from symoro_elastic.machine.formats.par_syntax import EXTENDED
from symoro_elastic.machine.formula import ZERO, Formula
from symoro_elastic.machine.machine import Body, Closing, Loop, Machine, Orientation
from symoro_elastic.machine.scene import Scene


class Declared(Enum):
    """Names that are declared beside the cells in which they stand."""

    NOTHING = 0
    PARAMETERS = 1
    VARIABLES = 2


def extension_lines(
    machine: Machine, notes: Sequence[str], own: Collection[str], declared: Declared, ordered: Sequence[str]
) -> list[str]:
    """The lines of a machine; `notes` and the extras in `own` stand elsewhere, `ordered` are joints as in the table."""
    joints, parameters = machine.joints, machine.parameters
    turned = machine.floating and machine.floating.orientation
    usual_names = all(joint.name == f"j{j}" for j, joint in enumerate(joints, start=1))
    cells_by_key = [{cell.par: formula for cell, formula in cells(joint)} for joint in joints]
    values: dict[str, str] = {
        "names": "" if usual_names else listed(word(joint.name) for joint in joints),
        "order": listed(map(word, ordered)) if ordered else "",
        "parameters": listed(word(p.name) for p in parameters) if declared is not Declared.NOTHING else "",
        "variable": _entries(_shared(machine)) if declared is Declared.VARIABLES else "",
        "values": _entries({p.name: word(p.value.text) for p in parameters if p.value}),
        "units": _entries({p.name: word(p.unit) for p in parameters if p.unit}),
        **_loops(machine),
        **{key: _joint_list(row[key] for row in cells_by_key) for key in EXTENDED},
        "central": _entries({joint.name: _central(joint.body) for joint in joints if joint.body.central}),
        "orientation": "quaternion" if turned is Orientation.QUATERNION else "",
        "notes": listed(map(word, machine.notes[len(notes) :])) if machine.notes[len(notes) :] else "",
        "scene": _scene(machine.scene) if machine.scene else "",
        "motion": _plain([entries_of_motion(motion) for motion in machine.motions]) if machine.motions else "",
        "wanted": _plain(entries_of_wanted(machine.wanted)) if machine.wanted is not None else "",
        "extras": _entries({key: word(text) for key, text in machine.extras.items() if key not in own}),
    }
    return [extension(key, value) for key, value in values.items() if value]


def _shared(machine: Machine) -> dict[str, str]:
    """Variables of joints in whose cells those of others stand, or that stand in the cells of others."""
    parameters = {parameter.name for parameter in machine.parameters}
    holders = Counter(name for joint in machine.joints for name in joint.selected.names - parameters)
    owners = [joint for joint in machine.joints if joint.variable]
    shared = [joint for joint in owners if joint.variable in holders or joint.selected.names - parameters]
    return {joint.name: str(joint.variable) for joint in shared}


def extension(key: str, value: str) -> str:
    """An extension line."""
    return f"(*! {key} = {value} *)"


def _entries(table: dict[str, str]) -> str:
    return listed(f"{word(key)} = {value}" for key, value in table.items()) if table else ""


def _loops(machine: Machine) -> dict[str, str]:
    """What the rows do not say of closed loops: their names, how they close, what depends, and where they start."""
    loops = machine.loops
    start = common_start(loops)
    said = {loop.name: _loop(loop, start) for loop in loops}
    usual = [*said] == [f"loop_{k}" for k in range(1, len(loops) + 1)]
    if any(said.values()):
        value = _entries({name: entries or "{}" for name, entries in said.items()})
    else:
        value = "" if usual else listed(map(word, said))
    return {"loops": value, "start": _start(start)}


def _loop(loop: Loop, start: dict[str, Formula]) -> str:
    said = {
        "closes": "" if loop.closes is Closing.FRAME else loop.closes.value,
        "dependent": listed(map(word, loop.dependent)) if loop.dependent else "",
        "start": _start(loop.start) if loop.start != start else "",
    }
    return _entries({key: value for key, value in said.items() if value})


def _start(start: dict[str, Formula]) -> str:
    return _entries({variable: word(value.text) for variable, value in start.items()})


def _joint_list(formulas: Iterable[Formula]) -> str:
    cells = list(formulas)
    return listed(word(cell.text) for cell in cells) if any(cell != ZERO for cell in cells) else ""


def _central(body: Body) -> str:
    return listed(word(formula.text) for formula in (*body.moments, *body.inertia))


def _scene(scene: Scene) -> str:
    parts = {}
    if scene.models:
        parts["models"] = listed(map(word, scene.models))
    if scene.outputs:
        parts["outputs"] = _entries({model: listed(map(word, names)) for model, names in scene.outputs.items()})
    if scene.locked:
        parts["locked"] = _entries({joint: word(value.text) for joint, value in scene.locked.items()})
    if scene.static:
        parts["static"] = _static(scene.static)
    if scene.steps:
        parts["steps"] = listed(map(word, scene.steps))
    if scene.condense:
        parts["condense"] = "true"
    if scene.forces:
        parts["forces"] = listed(map(word, scene.forces))
    if scene.fold:
        parts["fold"] = scene.fold if isinstance(scene.fold, str) else listed(map(word, scene.fold))
    if not scene.gravity:
        parts["gravity"] = "false"
    return _entries(parts) or "{}"


def _plain(x: Any) -> str:
    """Text of a table of numbers, texts, lists and tables."""
    if isinstance(x, dict):
        return _entries({key: _plain(value) for key, value in x.items()}) or "{}"
    if isinstance(x, list):
        return listed(map(_plain, x))
    return word(x if isinstance(x, str) else repr(x))


def _static(static: Mapping[str, Formula | None]) -> str:
    if None in static.values():
        return listed(map(word, static))
    return _entries({joint: word(str(value)) for joint, value in static.items()})


def listed(cells: Iterable[str]) -> str:
    """Text of a list."""
    return "{" + ", ".join(cells) + "}"


def word(text: str) -> str:
    """A text in an extension line, quoted where it must be."""
    if re.fullmatch(r"[A-Za-z0-9_.+\-*/^]+( [A-Za-z0-9_.+\-*/^]+)*", text, re.ASCII):
        return text
    return json.dumps(text, ensure_ascii=not text.isprintable()).replace("*)", "*\\u0029")
