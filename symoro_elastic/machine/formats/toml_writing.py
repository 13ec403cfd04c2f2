"""The TOML text of a machine, aligned as a table."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Sequence

from symoro_elastic.machine.formats.cells import cell_of
from symoro_elastic.machine.formula import ZERO, Formula
from symoro_elastic.machine.machine import NO_INERTIA, NO_VECTOR, Base, Body, Floating, Joint, Machine, Parameter
from symoro_elastic.machine.scene import Scene

# Numbers that TOML reads back with the same text (`-0` would lose its sign).
_NUMBER = re.compile(r"(?!-0$)-?(0|[1-9]\d*)(\.\d+)?([eE][+-]?\d+)?", re.ASCII)

Entry = list[tuple[str, str]]


def write(machine: Machine) -> str:
    """The TOML text that `read` reads back."""
    top = [f"name = {_text(machine.name)}"]
    if machine.notes:
        top += ["notes = [", *(f"  {_text(note)}," for note in machine.notes), "]"]
    if machine.base.gravity != NO_VECTOR:
        top.append(f"gravity = {_list(machine.base.gravity)}")
    blocks = [top, _joints(machine)]
    blocks += [[f"[{title}]", *lines] for title, lines in _sections(machine) if lines]
    if machine.scene is not None:
        blocks.append(["[scene]", *_scene(machine.scene)])
    return "\n\n".join("\n".join(block) for block in blocks) + "\n"


def _sections(machine: Machine) -> Iterable[tuple[str, list[str]]]:
    joints = machine.joints
    yield "parameters", _table((parameter.name, _parameter(parameter)) for parameter in machine.parameters)
    yield "bodies", _named(joints, _body)
    yield "springs", _named(joints, _spring)
    yield "motors", _named(joints, lambda joint: _cells(rotor_inertia=joint.rotor_inertia))
    yield "friction", _named(joints, lambda j: _cells(viscous=j.friction.viscous, coulomb=j.friction.coulomb))
    yield "wrenches", _named(joints, lambda j: _vectors(force=j.wrench.force, moment=j.wrench.moment))
    yield "base", _table([*_base(machine.base), *_floating(machine.floating)])
    yield "extras", _table((key, _text(value)) for key, value in machine.extras.items())


def _joints(machine: Machine) -> list[str]:
    rows = [_row(joint, machine) for joint in machine.joints]
    unused = {key for key in ("gamma", "b") if all(dict(row)[key] == "0" for row in rows)}
    rows = [[(key, value) for key, value in row if key not in unused] for row in rows]
    return ["joints = [", *(f"  {line}," for line in _aligned(rows)), "]"]


def _row(joint: Joint, machine: Machine) -> Entry:
    known = 0 < joint.antecedent <= len(machine.joints)
    theta = cell_of(joint.variable if joint.sigma == 0 else None, joint.theta)
    r = cell_of(joint.variable if joint.sigma == 1 else None, joint.r)
    return [
        ("name", _text(joint.name)),
        ("antecedent", _text(machine.joint(joint.antecedent).name) if known else str(joint.antecedent)),
        ("kind", _text(joint.kind.value)),
        ("sigma", str(joint.sigma)),
        ("gamma", _cell(joint.gamma.text)),
        ("b", _cell(joint.b.text)),
        ("alpha", _cell(joint.alpha.text)),
        ("d", _cell(joint.d.text)),
        ("theta", _cell(theta)),
        ("r", _cell(r)),
    ]


def _aligned(rows: Sequence[Entry]) -> list[str]:
    """Inline tables whose entries stand below one another; all rows have the same keys."""
    widths = [max(len(row[column][1]) for row in rows) for column in range(len(rows[0]))] if rows else []
    return ["{ " + _padded(row, widths) + " }" for row in rows]


def _padded(row: Entry, widths: list[int]) -> str:
    cells = [f"{key} = {value}" for key, value in row]
    pads = [" " * (width - len(value)) for width, (_, value) in zip(widths, row, strict=True)]
    return " ".join([f"{cell},{pad}" for cell, pad in zip(cells[:-1], pads, strict=False)] + [cells[-1] + pads[-1]])


def _table(entries: Iterable[tuple[str, str]]) -> list[str]:
    rows = [(_key(key), value) for key, value in entries]
    width = max((len(key) for key, _ in rows), default=0)
    return [f"{key:{width}} = {value}" for key, value in rows]


def _named(joints: Sequence[Joint], entry: Callable[[Joint], Entry]) -> list[str]:
    """A line a joint, aligned where all lines have the same keys."""
    found = [(joint.name, cells) for joint in joints if (cells := entry(joint))]
    same = len({tuple(key for key, _ in cells) for _, cells in found}) == 1
    lines = _aligned([cells for _, cells in found]) if same else [_inline(cells) for _, cells in found]
    return _table((name, line) for (name, _), line in zip(found, lines, strict=True))


def _inline(entry: Entry) -> str:
    return "{ " + ", ".join(f"{key} = {value}" for key, value in entry) + " }"


def _cells(**values: Formula) -> Entry:
    return [(key, _cell(value.text)) for key, value in values.items() if value != ZERO]


def _vectors(**values: tuple[Formula, ...]) -> Entry:
    return [(key, _list(value)) for key, value in values.items() if value != NO_VECTOR]


def _body(joint: Joint) -> Entry:
    return _body_cells(joint.body)


def _body_cells(body: Body) -> Entry:
    if body == Body():
        return []
    moments, inertia = ("center_of_mass", "inertia") if body.central else ("first_moments", "inertia_at_origin")
    entry = [("mass", _cell(body.mass.text))]
    if body.central or body.moments != NO_VECTOR:
        entry.append((moments, _list(body.moments)))
    if body.inertia != NO_INERTIA:
        xx, xy, xz, yy, yz, zz = body.inertia
        entry.append((inertia, _list((xx, yy, zz) if xy == xz == yz == ZERO else body.inertia)))
    return entry


def _spring(joint: Joint) -> Entry:
    spring = joint.spring
    return _cells(stiffness=spring.stiffness, damping=spring.damping, neutral=spring.neutral)


def _base(base: Base) -> Entry:
    return _vectors(
        velocity=base.velocity,
        angular_velocity=base.angular_velocity,
        acceleration=base.acceleration,
        angular_acceleration=base.angular_acceleration,
    )


def _floating(floating: Floating | None) -> Entry:
    if floating is None:
        return []
    body = _body_cells(floating.body)
    entry = [("floating", _text(floating.orientation.value)), ("known", _text(floating.known.value))]
    return [*entry, ("body", _inline(body))] if body else entry


def _parameter(parameter: Parameter) -> str:
    value = _cell(parameter.value.text) if parameter.value else "nan"
    return f"{{ value = {value}, unit = {_text(parameter.unit)} }}" if parameter.unit else value


def _scene(scene: Scene) -> list[str]:
    lines = []
    if scene.models:
        lines.append(f"models = {_names(scene.models)}")
    if scene.outputs:
        lines.append(f"outputs = {_inline([(_key(m), _names(names)) for m, names in scene.outputs.items()])}")
    if scene.locked:
        lines.append(f"locked = {_inline([(_key(joint), _cell(v.text)) for joint, v in scene.locked.items()])}")
    if scene.fold:
        lines.append(f"fold = {_text(scene.fold) if isinstance(scene.fold, str) else _names(scene.fold)}")
    return lines if scene.gravity else [*lines, "gravity = false"]


def _list(formulas: Iterable[Formula]) -> str:
    return "[" + ", ".join(_cell(formula.text) for formula in formulas) + "]"


def _names(names: Iterable[str]) -> str:
    return "[" + ", ".join(_text(name) for name in names) + "]"


def _cell(text: str) -> str:
    """A number as a number, anything else in quotes."""
    return text if _NUMBER.fullmatch(text) else _text(text)


def _key(name: str) -> str:
    return name if re.fullmatch(r"[A-Za-z0-9_-]+", name, re.ASCII) else _text(name)


def _text(text: str) -> str:
    escaped = text.replace("\\", "\\\\").replace('"', '\\"')
    return '"' + re.sub(r"[\x00-\x1f\x7f]", lambda match: f"\\u{ord(match[0]):04x}", escaped) + '"'
