"""An FMU as a whole: its parts put together, and packed."""

from __future__ import annotations

import hashlib
import io
import math
import platform
import zipfile
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from symoro_elastic.codegen.compile import CompilationFailed, CompilerMissing, compile_library
from symoro_elastic.codegen.package import Package
from symoro_elastic.codegen.package_context import Files
from symoro_elastic.codegen.templates import render
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.input_files import read_file
from symoro_elastic.foundation.output_files import temporary_folder
from symoro_elastic.foundation.progress import Announce, announce_nothing
from symoro_elastic.foundation.scalar import Scalar
from symoro_elastic.generation.fmu import Options
from symoro_elastic.generation.fmu.programs import Given, Programs, given_of, programs_of, refuse_machines_without_unit
from symoro_elastic.generation.fmu.scalar_variables import Layout, Variable, layout_of, unit_powers
from symoro_elastic.generation.fmu.sources import interface_file, sources_of
from symoro_elastic.generation.fmu.start import Start, start_of
from symoro_elastic.machine.described import DescribedMachine, between_samples, drives_of, without_drives
from symoro_elastic.machine.drives import MOTOR, LoadPosition
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.restrict import restrict
from symoro_elastic.machine.scene import Scene
from symoro_elastic.models.bound.bind import Bound
from symoro_elastic.models.drives.drive_states import position_of_load
from symoro_elastic.numerics.evaluation.arrays import values_along
from symoro_elastic.numerics.motion.signals import FrameSignal, positions
from symoro_elastic.symbolic.differentiation import Differentiation
from symoro_elastic.symbolic.expression import operand, reachable
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

PLACEHOLDER = "00000000-0000-0000-0000-000000000000"
"""Replaced by the token, which is a hash of the texts that contain it."""
WITHOUT_BINARY = "no C compiler was found: the FMU holds sources only, which the importing tool has to compile"
OLDEST = (1980, 1, 1, 0, 0, 0)
"""The time of all files of an archive."""
READABLE = 0o644 << 16
STILL = 1e-9
"""Ratio of a load's motion by its motor to its largest by any joint, below which the motor does not move it."""


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
    restricted = restrict(machine, scene)
    if measures_loads(restricted):
        resting = start_of(replace(without_drives(restricted), forces=()), options.at)
        machine = with_loads(machine, restricted, dict(zip(restricted.independent, resting.q.tolist(), strict=True)))
        restricted = restrict(machine, scene)
    refuse_machines_without_unit(restricted)
    motor_inputs, notes_on_inputs = given_of(restricted)
    unloaded = replace(restricted, forces=())
    start = start_of(between_samples(unloaded) if motor_inputs is Given.SAMPLES else unloaded, options.at)
    programs = programs_of(machine, scene)
    announce("render")
    sources, description = _texts(restricted, programs, start, options.version)
    announce("compile")
    binary = shared_library(programs.package, sources, options.version)
    files = _files(programs.package.name, description, sources, binary, options.version)
    notes = (*notes_on_inputs, *start.notes, *(() if binary else (WITHOUT_BINARY,)))
    return MockUpUnit(archive_of(files), programs, notes)


def _texts(machine: Machine, programs: Programs, start: Start, version: int) -> tuple[Files, str]:
    """Return the sources by name, and the description; both contain the token, a hash of them."""
    layout = layout_of(programs, start)
    structure = structure_of(programs, layout)
    sources = sources_of(programs, layout, start, version, PLACEHOLDER)
    c = sorted(file for file in sources if file.endswith(".c"))
    description = description_of(machine, layout, structure, start, c, version)
    token = _token([description, *sources.values()])
    with_token = {file: text.replace(PLACEHOLDER, token) for file, text in sources.items()}
    return with_token, description.replace(PLACEHOLDER, token)


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
    """Return a hash of these texts as FMI writes it: 8-4-4-4-12 hexadecimal digits."""
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
    """Return the compiled sources as a shared library; None where there is no compiler. Raises `InputError`."""
    longest = max(len(f.program.once) + len(f.program.statements) for f in package.functions)
    level = "-O2" if longest <= MOST_OPTIMISED else "-O1"
    flags = (level, "-ffp-contract=off", "-fvisibility=hidden", "-Wno-error")
    names = [f"{package.name}.c", interface_file(version)]
    with temporary_folder() as folder:
        try:
            library = read_file(compile_library(sources, Path(folder), flags=flags, sources=names))
            if f"fmi{version}GetVersion".encode() not in library:
                raise CompilationFailed("the library has no function of FMI: is CC a C compiler?")
            return library
        except CompilerMissing:
            return None


def description_of(
    machine: Machine, layout: Layout, structure: Structure, start: Start, sources: list[str], version: int
) -> str:
    """Return modelDescription.xml of a version of FMI, with the placeholder of the token."""
    counts = f"{len(machine.independent)} joint variables, {len(machine.motors)} motors, {len(machine.elastic)} springs"
    tags = {
        2: ("Outputs", "Derivatives", "InitialUnknowns"),
        3: ("Output", "ContinuousStateDerivative", "InitialUnknown"),
    }
    unknowns = (structure.outputs, structure.derivatives, structure.initial)
    duration = _round_number(start.duration)
    return render(
        f"fmu/modelDescription{version}.xml.j2",
        name=machine.name,
        description=f"{machine.name}: {counts}; SI units, radians",
        token=PLACEHOLDER,
        sources=sources,
        units=unit_powers(layout.variables),
        variables=layout.variables,
        numbers={variable.reference: k for k, variable in enumerate(layout.variables, start=1)},
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
class Dependency:
    """An unknown of an FMU and the references of its knowns; `kinds` where it depends on them linearly, else empty."""

    reference: int
    knowns: tuple[int, ...]
    kinds: tuple[str, ...] = ()

    def known_numbers(self, numbers: Mapping[int, int]) -> list[int]:
        """Return the numbers of the knowns among the variables; `numbers` maps value references to them."""
        return [numbers[reference] for reference in self.knowns]


@dataclass(frozen=True)
class Structure:
    """Outputs, derivatives, and unknowns of the initialization, which depend on parameters too."""

    outputs: tuple[Dependency, ...]
    derivatives: tuple[Dependency, ...]
    initial: tuple[Dependency, ...]


def structure_of(programs: Programs, layout: Layout) -> Structure:
    """Return the dependencies of outputs, derivatives and initial unknowns."""
    symbols = _references(programs, layout)
    parameters = {variable.reference for variable in layout.block("P")}
    accelerations, *others = programs.traces
    derivatives = [
        unknown
        for result, block in (("qdd", "DER_QD"), ("zd", "DER_Z"))
        if result in accelerations.results
        for unknown in _unknowns(layout.block(block), accelerations.results[result].entries, symbols)
    ]
    torques = accelerations.results["tau_m"].entries if layout.block("TAU_M") else ()
    outputs = _unknowns(layout.block("TAU_M"), torques, symbols)
    for trace in others:
        roots = [x for result in trace.results.values() for x in result.entries]
        outputs += _unknowns(layout.block("Y"), roots, symbols)
    velocities = [
        Dependency(rate.reference, (state.reference,), ("constant",))
        for rate, state in zip(layout.block("DER_Q"), layout.block("QD"), strict=True)
    ]
    states = [Dependency(x.reference, (x.reference,), ("constant",)) for x in layout.states if x.causality == "output"]
    return Structure(
        (*states, *(_without(unknown, parameters) for unknown in outputs)),
        (*velocities, *(_without(unknown, parameters) for unknown in derivatives)),
        tuple(sorted((*velocities, *derivatives, *outputs), key=lambda unknown: unknown.reference)),
    )


def _unknowns(
    variables: Sequence[Variable], roots: Iterable[Scalar], symbols: Mapping[str, frozenset[int]]
) -> list[Dependency]:
    return [
        Dependency(variable.reference, tuple(sorted(_symbol_references(root, symbols))))
        for variable, root in zip(variables, roots, strict=True)
    ]


def _symbol_references(root: Scalar, symbols: Mapping[str, frozenset[int]]) -> frozenset[int]:
    symbol_names = (node.operands[0] for node in reachable([root]) if node.operation == SYMBOL)
    return frozenset().union(*(symbols.get(name, frozenset()) for name in symbol_names))


def _references(programs: Programs, layout: Layout) -> dict[str, frozenset[int]]:
    """Return the references that symbols depend on; q_dep of loops without closed form has all that close them.

    Loads that friction rises with depend on all of them.
    """
    of_inputs = {x.name: x.symbols for trace in programs.traces for x in trace.inputs}
    references, first, numbers = layout.block("INPUT"), 0, dict[str, int]()
    for name, size in programs.inputs.items():
        is_sampled = programs.sampling and name == "tau"
        numbers |= {} if is_sampled else _pairs(of_inputs.get(name, ()), references[first : first + size])
        first += size
    numbers |= _pairs(of_inputs["q"], layout.block("Q")) | _pairs(of_inputs.get("qd", ()), layout.block("QD"))
    numbers |= _pairs(of_inputs.get("z", ()), layout.block("Z"))
    numbers |= _pairs([x.name for x in programs.package.parameters], layout.block("P"))
    closing = {x.reference for block in ("Q", "P") for x in layout.block(block)}
    loads = frozenset(numbers.values()) if programs.machine.loaded else frozenset()
    return (
        {name: frozenset({x}) for name, x in numbers.items()}
        | dict.fromkeys(of_inputs.get("q_dep", ()), frozenset(closing))
        | dict.fromkeys(of_inputs.get("load", ()), loads)
    )


def _pairs(symbols: Sequence[str], variables: Sequence[Variable]) -> dict[str, int]:
    return dict(zip(symbols, (variable.reference for variable in variables), strict=True)) if symbols else {}


def _without(unknown: Dependency, left_out: set[int]) -> Dependency:
    return Dependency(unknown.reference, tuple(x for x in unknown.knowns if x not in left_out))


def measures_loads(machine: Machine) -> bool:
    """Return whether drives of a machine measure other positions than those of their motors."""
    return any(drive.measured != MOTOR for drive in drives_of(machine).by_motor.values())


def with_loads(machine: Machine, restricted: Machine, q: Mapping[int, float]) -> Machine:
    """Return a machine with the load positions that its drives measure, linearized about q, by joint of `restricted`.

    Raises `InputError` for signals that are not such positions.
    """
    numbers = {restricted.joint(j).name: j for j in restricted.motors}
    measured = {name: x.measured for name, x in drives_of(restricted).by_motor.items() if x.measured != MOTOR}
    loads = {name: _load(restricted, numbers[name], signal, q) for name, signal in measured.items()}
    return replace(DescribedMachine.of(machine), drives=replace(drives_of(machine), loads=loads))


def _load(machine: Machine, j: int, measured: str, q: Mapping[int, float]) -> LoadPosition:
    place = f"drives, {machine.joint(j).name}, measured"
    (signal,) = positions(machine, [measured], place)
    if machine.is_coupled:
        raise machine.error(place, "positions of the load are not simulated where joints are coupled")
    if isinstance(signal, FrameSignal) and (signal.component > 2 or machine.static):
        of = "frames on static springs" if machine.static else "rotations of frames"
        raise machine.error(place, f"an FMU does not measure {of}: name a joint or a point, or give --by-torque")
    axis, at = (signal.component, signal.at) if isinstance(signal, FrameSignal) else (None, None)
    load = LoadPosition(signal.number, axis, at, 0.0, 1.0, q[j])
    start, *slopes = _values(machine, load, q)
    ratio = slopes[machine.independent.index(j)]
    if abs(ratio) <= STILL * max(map(abs, slopes)):
        what = f"{measured} does not move with {machine.joint(j).name} here: name a position behind it"
        raise machine.error(place, what)
    return replace(load, start=start, ratio=ratio)


def _values(machine: Machine, load: LoadPosition, q: Mapping[int, float]) -> list[float]:
    """Return the position of a load, and its derivatives by the variables of the joints."""
    bound = Bound(machine)
    position = position_of_load(bound, load)
    by = Differentiation([position])
    roots = [position, *(by.by(bound.q[j]).of(position) for j in machine.independent)]
    symbols: dict[str, float] = machine.given_values
    symbols |= {str(bound.q[j].operands[0]): q[j] for j in machine.independent}
    values: Array = values_along(list(map(operand, roots)), symbols, 1)[:, 0]
    return [float(x) for x in values]
