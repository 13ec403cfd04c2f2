"""An FMU as a whole: its parts put together, and packed."""

from __future__ import annotations

import hashlib
import io
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass, replace

from symoro_elastic.codegen.described import Files
from symoro_elastic.codegen.templates import render
from symoro_elastic.fmu import Options
from symoro_elastic.fmu.binary import compiled, platform_folder
from symoro_elastic.fmu.description import description_of
from symoro_elastic.fmu.programs import Programs, programs_of, refuse_machines_without_unit
from symoro_elastic.fmu.sources import sources_of
from symoro_elastic.fmu.start import Start, start_of
from symoro_elastic.fmu.structure import structure_of
from symoro_elastic.fmu.variables import layout_of
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.restrict import restricted
from symoro_elastic.machine.scene import Scene
from symoro_elastic.progress import Announce, announce_nothing

UNTOLD = "00000000-0000-0000-0000-000000000000"
"""Stands for the token while it is not known."""
WITHOUT_BINARY = "no C compiler was found: the FMU holds sources only, which the tool that imports it has to compile"
OLDEST = (1980, 1, 1, 0, 0, 0)
"""The time of all files of an archive."""
READABLE = 0o644 << 16


@dataclass(frozen=True)
class MockUpUnit:
    """A packed FMU: its archive, its programs, and remarks about it, a line each."""

    archive: bytes
    programs: Programs
    notes: tuple[str, ...]


def unit_of(machine: Machine, scene: Scene, options: Options, announce: Announce = announce_nothing) -> MockUpUnit:
    """Return the FMU of a machine restricted to a scene, for Model Exchange and Co-Simulation.

    Without a C compiler it holds sources only. Raises `InputError` for machines that have no FMU.
    """
    announce("trace")
    kept = restricted(machine, scene)
    refuse_machines_without_unit(kept)
    start = start_of(replace(kept, forces=()), options.at)
    programs = programs_of(machine, scene)
    announce("render")
    sources, description = _texts(kept, programs, start, options.version)
    announce("compile")
    binary = compiled(programs.package, sources, options.version)
    files = _files(programs.package.name, description, sources, binary, options.version)
    notes = (*start.notes, *(() if binary else (WITHOUT_BINARY,)))
    return MockUpUnit(packed(files), programs, notes)


def _texts(machine: Machine, programs: Programs, start: Start, version: int) -> tuple[Files, str]:
    """Return sources by name, and the description; both hold a token that is made of them."""
    layout = layout_of(programs, start)
    structure = structure_of(programs, layout)
    sources = sources_of(programs.package, layout, start, programs.method, version, UNTOLD)
    c = sorted(file for file in sources if file.endswith(".c"))
    name, summary = programs.package.name, _summary(machine)
    description = description_of(name, summary, layout, structure, start, c, version, UNTOLD)
    token = _token([description, *sources.values()])
    told = {file: text.replace(UNTOLD, token) for file, text in sources.items()}
    return told, description.replace(UNTOLD, token)


def _summary(machine: Machine) -> str:
    counts = f"{len(machine.moving)} joint variables, {len(machine.motors)} motors, {len(machine.elastic)} springs"
    return f"{machine.name}: {counts}; SI units, radians"


def _files(name: str, description: str, sources: Files, binary: bytes | None, version: int) -> dict[str, bytes]:
    """Return the files of an FMU by their paths in it."""
    files = {"modelDescription.xml": description.encode()}
    files |= {f"sources/{file}": text.encode() for file, text in sources.items()}
    if version == 3:
        c = sorted(file for file in sources if file.endswith(".c"))
        files["sources/buildDescription.xml"] = render("fmu/buildDescription.xml.j2", name=name, sources=c).encode()
    if binary:
        folder = platform_folder(version)
        suffix = {"darwin": ".dylib", "win": ".dll", "windows": ".dll"}
        system = folder.rstrip("0123456789").rpartition("-")[2]
        files[f"binaries/{folder}/{name}{suffix.get(system, '.so')}"] = binary
    return files


def _token(texts: list[str]) -> str:
    """Return a number of these texts as FMI writes it: 8-4-4-4-12 hexadecimal digits."""
    digits = hashlib.sha256("\0".join(texts).encode()).hexdigest()
    return "-".join((digits[:8], digits[8:12], digits[12:16], digits[16:20], digits[20:32]))


def packed(files: Mapping[str, bytes]) -> bytes:
    """Return an archive of files whose bytes depend on their paths and contents only."""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as archive:
        for path in sorted(files):
            entry = zipfile.ZipInfo(path, OLDEST)
            entry.compress_type, entry.external_attr, entry.create_system = zipfile.ZIP_DEFLATED, READABLE, 3
            archive.writestr(entry, files[path])
    return stream.getvalue()
