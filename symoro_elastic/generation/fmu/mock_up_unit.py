"""An FMU as a whole: its parts put together, and packed."""

from __future__ import annotations

import hashlib
import io
import math
import platform
import tempfile
import zipfile
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from symoro_elastic.codegen.compile import CompilationFailed, CompilerMissing, compile_library
from symoro_elastic.codegen.package import Package
from symoro_elastic.codegen.package_context import Files
from symoro_elastic.codegen.templates import render
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.input_files import read_file
from symoro_elastic.foundation.progress import Announce, announce_nothing
from symoro_elastic.foundation.scalar import Scalar
from symoro_elastic.generation.fmu import Options
from symoro_elastic.generation.fmu.loads import measures_loads, with_loads
from symoro_elastic.generation.fmu.motors import Given, given_of
from symoro_elastic.generation.fmu.programs import Programs, programs_of, refuse_machines_without_unit
from symoro_elastic.generation.fmu.scalar_variables import Layout, Variable, layout_of, unit_powers
from symoro_elastic.generation.fmu.sources import interface_file, sources_of
from symoro_elastic.generation.fmu.start import Start, start_of
from symoro_elastic.machine.described import between_samples, without_drives
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.restrict import restrict
from symoro_elastic.machine.scene import Scene
from symoro_elastic.models.tracing import Trace
from symoro_elastic.symbolic.expression import reachable
from symoro_elastic.symbolic.operations import SYMBOL

TOLERANCE = "1e-7"
"""Of importers that are given none: what solvers with numerical Jacobians keep on stiff machines."""
STEPS = 1000
"""Communication steps over the duration that is offered."""

MOST_OPTIMISED = 20_000
"""Statements of a function that are compiled at -O2 in half a minute; longer ones at -O1."""
SYSTEMS = {"Linux": "linux", "Darwin": "darwin", "Windows": "windows"}
MACHINES = {"amd64": "x86_64", "x86_64": "x86_64", "arm64": "aarch64", "aarch64": "aarch64"}
OF_FMI_2 = {"x86_64-linux": "linux64", "x86_64-darwin": "darwin64", "x86_64-windows": "win64"}

UNTOLD = "00000000-0000-0000-0000-000000000000"
"""Stands for the token while it is not known."""
WITHOUT_BINARY = "no C compiler was found: the FMU holds sources only, which the importing tool has to compile"
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
    machine = without_drives(machine) if options.by_torque else machine
    kept = restrict(machine, scene)
    if measures_loads(kept):
        resting = start_of(replace(without_drives(kept), forces=()), options.at)
        machine = with_loads(machine, kept, dict(zip(kept.independent, resting.q.tolist(), strict=True)))
        kept = restrict(machine, scene)
    refuse_machines_without_unit(kept)
    given, said = given_of(kept)
    held = replace(kept, forces=())
    start = start_of(between_samples(held) if given is Given.SAMPLES else held, options.at)
    programs = programs_of(machine, scene)
    announce("render")
    sources, description = _texts(kept, programs, start, options.version)
    announce("compile")
    binary = shared_library(programs.package, sources, options.version)
    files = _files(programs.package.name, description, sources, binary, options.version)
    notes = (*said, *start.notes, *(() if binary else (WITHOUT_BINARY,)))
    return MockUpUnit(archive_of(files), programs, notes)


def _texts(machine: Machine, programs: Programs, start: Start, version: int) -> tuple[Files, str]:
    """Return sources by name, and the description; both hold a token that is made of them."""
    layout = layout_of(programs, start)
    structure = structure_of(programs, layout)
    sources = sources_of(programs, layout, start, version, UNTOLD)
    c = sorted(file for file in sources if file.endswith(".c"))
    name, summary = programs.package.name, _summary(machine)
    description = description_of(name, summary, layout, structure, start, c, version, UNTOLD)
    token = _token([description, *sources.values()])
    told = {file: text.replace(UNTOLD, token) for file, text in sources.items()}
    return told, description.replace(UNTOLD, token)


def _summary(machine: Machine) -> str:
    counts = f"{len(machine.independent)} joint variables, {len(machine.motors)} motors, {len(machine.elastic)} springs"
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


def archive_of(files: Mapping[str, bytes]) -> bytes:
    """Return an archive of files whose bytes depend on their paths and contents only."""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as archive:
        for path in sorted(files):
            entry = zipfile.ZipInfo(path, OLDEST)
            entry.compress_type, entry.external_attr, entry.create_system = zipfile.ZIP_DEFLATED, READABLE, 3
            archive.writestr(entry, files[path])
    return stream.getvalue()


def platform_folder(version: int) -> str:
    """Return the name of the folder of binaries for this platform."""
    system, machine = platform.system(), platform.machine().lower()
    named = f"{MACHINES.get(machine, machine)}-{SYSTEMS.get(system, system.lower())}"
    return OF_FMI_2.get(named, named) if version == 2 else named


def shared_library(package: Package, sources: Files, version: int) -> bytes | None:
    """Return the shared library made of the sources; None where there is no compiler. Raises `InputError`."""
    longest = max(len(f.program.once) + len(f.program.statements) for f in package.functions)
    level = "-O2" if longest <= MOST_OPTIMISED else "-O1"
    flags = (level, "-ffp-contract=off", "-fvisibility=hidden", "-Wno-error")
    names = [f"{package.name}.c", interface_file(version)]
    with tempfile.TemporaryDirectory(prefix="symoro_elastic_") as folder:
        try:
            return read_file(compile_library(sources, Path(folder), flags=flags, sources=names))
        except CompilerMissing:
            return None
        except CompilationFailed as error:
            raise InputError(package.source or package.name, "C compiler", str(error)) from None


@dataclass(frozen=True)
class Unit:
    """A unit and its exponents of base units."""

    name: str
    powers: list[tuple[str, int]]


def description_of(
    name: str,
    summary: str,
    layout: Layout,
    structure: Structure,
    start: Start,
    sources: list[str],
    version: int,
    token: str,
) -> str:
    """Return modelDescription.xml of a version of FMI."""
    tags = {
        2: ("Outputs", "Derivatives", "InitialUnknowns"),
        3: ("Output", "ContinuousStateDerivative", "InitialUnknown"),
    }
    unknowns = (structure.outputs, structure.derivatives, structure.initial)
    duration = _round_number(start.duration)
    return render(
        f"fmu/modelDescription{version}.xml.j2",
        name=name,
        description=summary,
        token=token,
        sources=sources,
        units=[Unit(unit, powers) for unit, powers in unit_powers(layout.variables).items()],
        variables=layout.variables,
        numbers={one.reference: k for k, one in enumerate(layout.variables, start=1)},
        structure=list(zip(tags[version], unknowns, strict=True)),
        stop_time=f"{duration:g}",
        step_size=f"{duration / STEPS:g}",
        tolerance=TOLERANCE,
    )


def _round_number(x: float) -> float:
    """Return 1, 2 or 5 times a power of ten, at least x."""
    power = 10.0 ** math.floor(math.log10(x))
    return next(digit * power for digit in (1, 2, 5, 10) if digit * power >= x * (1 - 1e-9))


# Which unknowns of an FMU depend on which knowns: exactly what their equations hold.
@dataclass(frozen=True)
class Unknown:
    """An unknown and the references of what it depends on; `kinds` where it is linear in them, else empty."""

    reference: int
    knowns: tuple[int, ...]
    kinds: tuple[str, ...] = ()

    def known_numbers(self, numbers: Mapping[int, int]) -> list[int]:
        """Return the knowns by their number among the variables."""
        return [numbers[one] for one in self.knowns]


@dataclass(frozen=True)
class Structure:
    """Outputs, derivatives, and unknowns of the initialization, which depend on parameters too."""

    outputs: tuple[Unknown, ...]
    derivatives: tuple[Unknown, ...]
    initial: tuple[Unknown, ...]


def structure_of(programs: Programs, layout: Layout) -> Structure:
    """Return what depends on what."""
    symbols = _references(programs, layout)
    known = {one.reference for one in layout.block("P")}
    accelerations, *others = programs.traces
    found = [
        one
        for result, block in (("qdd", "DER_QD"), ("zd", "DER_Z"))
        if result in accelerations.results
        for one in _unknowns(layout.block(block), accelerations.results[result].entries, symbols)
    ]
    torques = accelerations.results["tau_m"].entries if layout.block("TAU_M") else ()
    outputs = _unknowns(layout.block("TAU_M"), torques, symbols)
    outputs += [one for trace in others for one in _unknowns(layout.block("Y"), _roots(trace), symbols)]
    velocities = [
        Unknown(rate.reference, (state.reference,), ("constant",))
        for rate, state in zip(layout.block("DER_Q"), layout.block("QD"), strict=True)
    ]
    states = [
        Unknown(one.reference, (one.reference,), ("constant",)) for one in layout.states if one.causality == "output"
    ]
    return Structure(
        (*states, *(_without(one, known) for one in outputs)),
        (*velocities, *(_without(one, known) for one in found)),
        tuple(sorted((*velocities, *found, *outputs), key=lambda one: one.reference)),
    )


def _roots(trace: Trace) -> Iterable[Scalar]:
    return (x for result in trace.results.values() for x in result.entries)


def _unknowns(
    variables: Sequence[Variable], roots: Iterable[Scalar], symbols: Mapping[str, frozenset[int]]
) -> list[Unknown]:
    return [
        Unknown(one.reference, tuple(sorted(_needed(root, symbols))))
        for one, root in zip(variables, roots, strict=True)
    ]


def _needed(root: Scalar, symbols: Mapping[str, frozenset[int]]) -> frozenset[int]:
    names = (node.operands[0] for node in reachable([root]) if node.operation == SYMBOL)
    return frozenset().union(*(symbols.get(name, frozenset()) for name in names))


def _references(programs: Programs, layout: Layout) -> dict[str, frozenset[int]]:
    """Return the references of variables by symbol; those of what closes loops without closed form for q_dep.

    Loads that friction rises with depend on all of them.
    """
    of_inputs = {one.name: one.symbols for trace in programs.traces for one in trace.inputs}
    references, first, found = layout.block("INPUT"), 0, dict[str, int]()
    for name, size in programs.inputs.items():
        held = programs.sampling and name == "tau"
        found |= {} if held else _pairs(of_inputs.get(name, ()), references[first : first + size])
        first += size
    found |= _pairs(of_inputs["q"], layout.block("Q")) | _pairs(of_inputs.get("qd", ()), layout.block("QD"))
    found |= _pairs(of_inputs.get("z", ()), layout.block("Z"))
    found |= _pairs([one.name for one in programs.package.parameters], layout.block("P"))
    closing = {one.reference for block in ("Q", "P") for one in layout.block(block)}
    loads = frozenset(found.values()) if programs.machine.loaded else frozenset()
    return (
        {name: frozenset({one}) for name, one in found.items()}
        | dict.fromkeys(of_inputs.get("q_dep", ()), frozenset(closing))
        | dict.fromkeys(of_inputs.get("load", ()), loads)
    )


def _pairs(symbols: Sequence[str], variables: Sequence[Variable]) -> dict[str, int]:
    return dict(zip(symbols, (one.reference for one in variables), strict=True)) if symbols else {}


def _without(unknown: Unknown, left_out: set[int]) -> Unknown:
    return Unknown(unknown.reference, tuple(one for one in unknown.knowns if one not in left_out))
