"""The files of an MJCF model, all in the folder of its file: parts that it includes, and shapes that inertias need.

They are read and checked here; MuJoCo is given texts, and opens no file.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath
from xml.etree.ElementTree import Element

from symoro_elastic.errors import InputError
from symoro_elastic.machine.formats.files import MAX_BYTES, load_text
from symoro_elastic.machine.formats.robots.xml_text import parsed
from symoro_elastic.machine.names import quoted

MOST_COPIES, MOST_PARTS, MOST_SHAPE_BYTES = 1000, 100, 100_000_000
OTHER_ROOTS = {
    "robot": "this is a URDF: give it the suffix .urdf",
    "sdf": "SDF is not read: write it as URDF or MJCF",
    "mujocoinclude": "it is a part of a model: read the file that includes it",
}
DEFORMABLE = {"flexcomp", "flex", "composite"}


@dataclass
class Sources:
    """The text of a model with those of the parts that it includes, by their paths from its folder."""

    text: str
    path: str
    parts: dict[str, bytes] = field(default_factory=dict)

    @property
    def folder(self) -> Path:
        """The folder of the model: no file outside it is read."""
        return Path(self.path).resolve().parent

    def shape(self, name: str, needed_by: str) -> bytes:
        """Return the content of the file of a shape; raises `InputError`, which says what needs it."""
        remedy = f"body {quoted(needed_by)} has no <inertial>, so its shape gives its mass: add an <inertial>"
        file = self._inside(name, f"mesh {quoted(name)}", remedy)
        try:
            content = file.read_bytes() if file.stat().st_size <= MOST_SHAPE_BYTES else None
        except OSError:
            raise self.error(f"mesh {quoted(name)}", f"there is no such file; {remedy}, or the file") from None
        if content is None:
            raise self.error(f"mesh {quoted(name)}", f"larger than {MOST_SHAPE_BYTES // 10**6} MB; {remedy}")
        return content

    def error(self, place: str, what: str) -> InputError:
        """The error to raise about one place of the file."""
        return InputError(self.path, place, what)

    def _inside(self, name: str, place: str, remedy: str) -> Path:
        """The path of a file that lies in the folder of the model, through links either."""
        try:
            file = (self.folder / name).resolve()
        except (OSError, ValueError, RuntimeError):
            raise self.error(place, "this is no path of a file") from None
        if not file.is_relative_to(self.folder):
            raise self.error(place, f"it is outside the folder of the model, where nothing is read: {remedy}")
        return file

    def include(self, name: str, by: str) -> tuple[str, str]:
        """Return the path of a part from the folder, and its text; `by` is that of the file that includes it."""
        place = f"include {quoted(name)}"
        remedy = "copy it into the folder"
        beside = str(PurePosixPath(by).parent / name)
        for path in dict.fromkeys((name, beside)):
            file = self._inside(path, place, remedy)
            if file.is_file():
                return path, load_text(file)
        raise self.error(place, f"there is no such file beside {quoted(Path(self.path).name)}")


def sources_of(text: str, path: str) -> Sources:
    """Return the text of a model with its parts; raises `InputError` for what is not read."""
    found = Sources(text, path)
    root = parsed(text, path)
    if root.tag != "mujoco":
        what = OTHER_ROOTS.get(root.tag, f"its root element is <{quoted(root.tag)[1:-1]}>, that of MJCF is <mujoco>")
        raise found.error("file", what)
    _take(root, path, "", found)
    return found


def _take(root: Element, file: str, path: str, found: Sources, copies: int = 1) -> None:
    """Refuse what is not taken of a file, and add the parts that it includes, with theirs."""
    for element, times in _with_copies(root, copies):
        _refuse(element, times, file)
        if element.tag == "include":
            _include(element, path, found, times)


def _include(element: Element, by: str, found: Sources, copies: int) -> None:
    name = element.get("file", "")
    place = f"include {quoted(name)}"
    if not name:
        raise found.error("include", "it names no file")
    path, text = found.include(name, by)
    if any(PurePosixPath(path).name == PurePosixPath(other).name for other in found.parts):
        raise found.error(place, "a file is included once, and MuJoCo knows it by its name: rename or remove one")
    found.parts[path] = text.encode()
    if len(found.parts) > MOST_PARTS or sum(map(len, found.parts.values())) > MAX_BYTES:
        raise found.error(place, f"at most {MOST_PARTS} files of {MAX_BYTES // 10**6} MB together are read")
    file = str(Path(found.path).parent / path)
    _take(parsed(text, file), file, path, found, copies)


def _refuse(element: Element, copies: int, file: str) -> None:
    """Refuse what is no tree of rigid bodies, other models, and copies without measure."""
    if element.tag in DEFORMABLE:
        raise InputError(file, f"<{element.tag}>", "it makes deformable bodies: only rigid ones are modelled")
    if element.tag == "plugin":
        raise InputError(file, "<plugin>", "forces of plugins are not modelled: remove it")
    if element.tag == "model" and "file" in element.attrib:
        what = "it attaches another model: let MuJoCo write both into one file, and read that"
        raise InputError(file, f"model {quoted(element.attrib['file'])}", what)
    if copies > MOST_COPIES:
        raise InputError(file, "replicate", f"it makes more than {MOST_COPIES} copies: no machine has as many bodies")


def _with_copies(root: Element, before: int) -> Iterator[tuple[Element, int]]:
    """Yield every element in its order, with how often each <replicate> around it repeats it."""
    waiting = [(root, before)]
    while waiting:
        element, times = waiting.pop()
        if element.tag == "replicate":
            count = element.get("count", "1").strip()
            times *= int(count) if count.isdecimal() and len(count) < 10 else MOST_COPIES + 1
        yield element, times
        waiting += ((child, times) for child in reversed(element))
