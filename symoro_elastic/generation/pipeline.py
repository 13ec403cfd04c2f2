"""The journey of a machine: read, check, group, trace, prune, schedule, render, compile, verify.

`prepare` are its first three stages, `programs` the next three; `generate` goes on to files of code, `verify` to code
that is compiled and compared with a reference. `announce` is called with the name of each stage when it begins.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from symoro_elastic.codegen.compile import CompilationFailed, CompilerMissing
from symoro_elastic.codegen.embedded.disassembly import PROCESSORS, UnknownProcessor
from symoro_elastic.codegen.embedded.report import CodeReport, code_report
from symoro_elastic.codegen.embedded.tool_chain import ToolChain
from symoro_elastic.codegen.package import Package
from symoro_elastic.codegen.package_context import Files
from symoro_elastic.codegen.precision import DOUBLE, Precision
from symoro_elastic.codegen.targets import FMU, SCALED_TARGETS, TARGETS, render_targets
from symoro_elastic.formats.format import Conversion
from symoro_elastic.formats.reading import read
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.output_folder import write_files
from symoro_elastic.foundation.progress import Announce, Progress, announce_nothing, no_progress
from symoro_elastic.foundation.results import Result
from symoro_elastic.generation import fmu
from symoro_elastic.machine.checks import check
from symoro_elastic.machine.described import DescribedMachine
from symoro_elastic.machine.freed import with_free_numbers
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.names import free_name, quote, why_no_machine
from symoro_elastic.machine.restrict import names_to_fold, restrict
from symoro_elastic.machine.scene import ALL, AUTO, INERTIA, RECURSION, Scene
from symoro_elastic.models.catalogue import MODELS, TracedModel, models_of, trace_scene
from symoro_elastic.models.catalogue import expressions_of_scene as trace
from symoro_elastic.models.degenerate import Degeneracy, SingularPivot, degeneracies
from symoro_elastic.models.implausible import implausible_motions
from symoro_elastic.models.model import Pivots
from symoro_elastic.models.packaging import reserved_words
from symoro_elastic.models.time_steps import notes_on_steps
from symoro_elastic.models.traced import Traced, with_steps
from symoro_elastic.models.tracing import PrunedTrace, prune, schedule
from symoro_elastic.numerics.grouping import grouping_by_rank
from symoro_elastic.quantities.frames import BASE
from symoro_elastic.symbolic.memory import no_collection
from symoro_elastic.symbolic.program import OperationCount

if TYPE_CHECKING:
    from symoro_elastic.generation.reduced import ReducedModel
    from symoro_elastic.numerics.guarantees.certificates import Certificates, Effort
    from symoro_elastic.numerics.verification.forms import Choice
    from symoro_elastic.numerics.verification.verify import Verification

MOST_WARNINGS = 20
DIRECT = "direct_dynamics"


@dataclass(frozen=True, repr=False)
class Generated(Result):
    """Written files and their models; `whole` are the same models of the whole machine, `notes` remarks on files.

    `form` is the choice of the form of the direct dynamic model, where it was asked for, `reduced` what was left out of
    models within tolerances.
    """

    written: list[Path]
    models: Sequence[TracedModel]
    whole: Sequence[TracedModel]
    reports: Sequence[CodeReport] = ()
    notes: tuple[str, ...] = ()
    form: Choice | None = None
    reduced: Sequence[ReducedModel] = ()

    @property
    def headline(self) -> str:
        """Folder, and models."""
        return f"Generated {self.written[0].parent}: {', '.join(one.model.name for one in self.models)}"


def prepare(
    file: str | Path,
    warn: Callable[[str], None],
    *,
    base: bool = False,
    free: Sequence[str] = (),
    conversion: Conversion | None = None,
    announce: Announce = announce_nothing,
) -> DescribedMachine:
    """The machine in a file, its inertial parameters grouped if `base`; raises `InputError`.

    Numbers of the tables in `free` (bodies, springs ...) become parameters. A robot as links and joints gets the
    changes of `conversion`.

    `warn` is called with each of the first 20 warnings, one line, and with the number of those left out.
    """
    announce("read")
    machine = read(file, reserved_words(), conversion)
    return prepare_machine(machine, warn, base=base, free=free, announce=announce)


def read_robot(robot: Any) -> DescribedMachine:
    """The machine, not yet checked, of a robot of the Robotics Toolbox; raises `InputError`."""
    from symoro_elastic.formats.robots.toolbox import of_robot

    return of_robot(robot, taken=reserved_words())


def prepare_machine(
    machine: DescribedMachine,
    warn: Callable[[str], None],
    *,
    base: bool = False,
    free: Sequence[str] = (),
    announce: Announce = announce_nothing,
) -> DescribedMachine:
    """The machine as `prepare` returns it, from one that is not yet checked."""
    taken = reserved_words()
    announce("check")
    for line in _first(warnings_of(machine)):
        warn(line)
    if base:
        announce("group")
        machine = _grouped(machine, warn)
    return with_free_numbers(machine, free, taken) if free else machine


def warnings_of(machine: DescribedMachine) -> list[str]:
    """Lines about what is allowed but rarely intended; raises `InputError` for what is not allowed."""
    return [*check(machine, reserved_words(), MODELS), *implausible_motions(machine)]


def refuse_name(name: str, place: str) -> None:
    """Raise `InputError` for a name that no machine may have."""
    words = reserved_words()
    if reason := why_no_machine(name, words):
        what = f"the name {quote(name)} cannot be used: {reason}; {free_name(name, words)!r} is free"
        raise InputError("symoro-elastic", place, what)


def _first(warnings: Sequence[str]) -> Iterator[str]:
    yield from warnings[:MOST_WARNINGS]
    if len(warnings) > MOST_WARNINGS:
        yield f"{len(warnings) - MOST_WARNINGS} more like these"


@no_collection()
def programs(
    machine: Machine, scene: Scene, announce: Announce = announce_nothing, choice: Choice | None = None
) -> Traced:
    """The models that a scene asks of a machine, as programs; raises `InputError`.

    `choice` is that of the form of the scene, where it is known: its model is not traced again.
    """
    scene, needed, known = _needed(machine, scene, announce, choice)
    announce("schedule")
    scheduled = {one.trace.model.name: schedule(one) for one in needed} | known
    return with_steps(machine, scene, [scheduled[name] for name in models_of(scene)])


@no_collection()
def operation_counts(machine: Machine, scene: Scene) -> dict[str, tuple[OperationCount, OperationCount]]:
    """Operations of each model of a scene, in a call and once for a parameter set; statements are not put in order.

    Raises `InputError`.
    """
    scene, needed, known = _needed(machine, scene)
    counts = {one.trace.model.name: (one.count, one.count_once) for one in needed}
    counts |= {name: (one.program.count, one.program.count_once) for name, one in known.items()}
    return {name: counts[name] for name in scene.models}


def _needed(
    machine: Machine, scene: Scene, announce: Announce = announce_nothing, choice: Choice | None = None
) -> tuple[Scene, list[PrunedTrace], dict[str, TracedModel]]:
    """The scene in its form, what its models need, and the models that the choice of the form has made."""
    if choice is None:
        refuse_degenerate(machine, scene)
        scene, choice = _with_form(machine, scene, announce)
    announce("trace")
    known = {choice.traced.model.name: choice.traced} if choice else {}
    traces = trace(machine, scene, grouping_by_rank, known)
    announce("prune")
    return scene, [prune(one) for one in traces], known


@no_collection()
def generate(
    machine: Machine,
    scene: Scene,
    targets: Sequence[str],
    out: Path,
    announce: Announce = announce_nothing,
    precisions: Sequence[Precision] = (DOUBLE,),
    tools: ToolChain | None = None,
    options: fmu.Options | None = None,
    certify: bool = False,
    progress: Progress = no_progress,
) -> Generated:
    """Write the models that a scene asks of a machine to `out/<machine name>/`, C in each of the precisions.

    With `tools` the C is compiled before, and what it costs is reported. `options` are those of an FMU, which has
    models of its own. With `certify` functions say what they guarantee within the limits of the machine. Raises
    `InputError`; nothing is written then.
    """
    texts = [name for name in targets if name in TARGETS]
    scaled = [name for name in targets if name in SCALED_TARGETS]
    if scene.within and FMU in targets:
        what = "an FMU has models of its own, which are whole: leave out the target, or within"
        raise machine.error("scene, within", what)
    free = scene if certify and not scene.within else None
    scene = by_recursion(scene) if certify or scene.within else scene
    scene, form = in_form(machine if texts or scaled else _of_unit(machine), scene, announce)
    made = [_code(machine, free or scene, form, texts, announce, precisions, tools, certify, progress)] if texts else []
    made += [_scaled(machine, scene, name, announce, tools, progress) for name in scaled]
    if FMU in targets:
        made.append(_unit(machine, scene, options or fmu.Options(), announce))
    announce("write")
    written = write_files(out / machine.name, {name: x for one in made for name, x in one.files.items()})
    notes = tuple(note for one in made for note in one.notes)
    reports = [each for one in made for each in one.reports]
    reduced = [each for one in made for each in one.reduced]
    return Generated(written, made[0].models, made[0].whole, reports, notes, form, reduced)


@dataclass(frozen=True)
class _Made:
    """Files by name, their models, the same models of the whole machine, reports on them, remarks."""

    files: Mapping[str, str | bytes]
    models: Sequence[TracedModel]
    whole: Sequence[TracedModel]
    reports: Sequence[CodeReport] = ()
    notes: tuple[str, ...] = ()
    reduced: Sequence[ReducedModel] = ()


def _code(
    machine: Machine,
    scene: Scene,
    form: Choice | None,
    targets: Sequence[str],
    announce: Announce,
    precisions: Sequence[Precision],
    tools: ToolChain | None,
    certify: bool,
    progress: Progress,
) -> _Made:
    """The code of the models that a scene asks of a machine; raises `InputError`."""
    asked, package, reduced = _guaranteed(machine, scene, form, precisions, certify, announce, progress)
    announce("render")
    files = render(package, targets, machine.source, precisions)
    reports: Sequence[CodeReport] = ()
    if tools:
        announce(f"compile: {tools.command}")
        reports = report(package, files, machine.label, precisions, tools)
    notes = notes_on_steps(asked.machine, scene.steps)
    return _Made(files, asked.models, _of_whole_machine(asked), reports, notes, reduced)


def _guaranteed(
    machine: Machine,
    scene: Scene,
    form: Choice | None,
    precisions: Sequence[Precision],
    certify: bool,
    announce: Announce,
    progress: Progress,
) -> tuple[Traced, Package, Sequence[ReducedModel]]:
    """The programs of a scene, within its tolerances, and their package, which says what is guaranteed if asked for."""
    if not scene.within:
        if not certify:
            asked = programs(machine, scene, announce, form)
            return asked, asked.package, ()
        from symoro_elastic.numerics.guarantees.header import with_guarantees

        asked, found = certified_in_form(machine, scene, precisions, announce=announce)
        return asked, with_guarantees(asked.package, found), ()
    from symoro_elastic.generation.reduced import certificates_of, reduced_models, said
    from symoro_elastic.numerics.guarantees.header import with_guarantees
    from symoro_elastic.numerics.guarantees.running_error import ROUNDINGS

    announce("leave out")
    roundings = [ROUNDINGS[precision.name] for precision in precisions if precision.name in ROUNDINGS]
    asked, reduced = reduced_models(DescribedMachine.of(machine), scene, programs, roundings, progress, announce)
    first = {one.model: said(one) for one in reduced}
    return asked, with_guarantees(asked.package, certificates_of(reduced, machine.name), first), reduced


def _scaled(
    machine: Machine, scene: Scene, target: str, announce: Announce, tools: ToolChain | None, progress: Progress
) -> _Made:
    """The code of a target whose numbers have proven scales; parameters are constants. Raises `InputError`."""
    from symoro_elastic.numerics.guarantees.fixed_point import with_scales

    if scene.steps:
        raise machine.error(f"--target {target}", "has no time steps: leave them out, or take another target")
    described, reduced = DescribedMachine.of(machine), list["ReducedModel"]()
    if scene.within:
        from symoro_elastic.generation.reduced import fixed_totals, models_in_fixed_point

        announce("leave out")
        asked, reduced = models_in_fixed_point(described, scene, programs, announce, progress)
        announce("certify")
        package = with_scales(asked, described.limits, progress=progress, totals=fixed_totals(reduced))
    else:
        asked = programs(machine, replace(scene, fold=ALL), announce)
        announce("certify")
        package = with_scales(asked, described.limits, progress=progress)
    package = replace(package, source=asked.package.source)
    announce("render")
    files = SCALED_TARGETS[target].render(package, ())
    reports: Sequence[CodeReport] = ()
    if tools:
        announce(f"compile: {tools.command}")
        reports = report(package, files, machine.label, SCALED_TARGETS[target].precisions, tools)
    return _Made(files, asked.models, _of_whole_machine(asked), reports, reduced=reduced)


def report(
    package: Package, files: Files, source: str, precisions: Sequence[Precision], tools: ToolChain
) -> list[CodeReport]:
    """What the C of a package costs in each of the precisions; raises `InputError`."""
    try:
        return [code_report(package, files, precision, tools) for precision in precisions]
    except CompilerMissing as error:
        raise InputError("symoro-elastic", "--report", str(error)) from None
    except CompilationFailed as error:
        raise InputError(source, "--report", str(error)) from None
    except UnknownProcessor as error:
        what = f"the code that {tools.compiler[0]} makes ({error}) is not read: {', '.join(PROCESSORS)} are"
        raise InputError("symoro-elastic", "--compiler", what) from None


def in_form(machine: Machine, scene: Scene, announce: Announce = announce_nothing) -> tuple[Scene, Choice | None]:
    """The scene with the form of the direct dynamic model, and the choice where it is the program's.

    Raises `InputError` where the inertia matrix is asked for and no model of the scene has forms.
    """
    from symoro_elastic.numerics.verification.forms import has_forms

    if scene.form == AUTO and has_forms(scene):
        refuse_degenerate(machine, scene)
    return _with_form(machine, scene, announce)


def _with_form(machine: Machine, scene: Scene, announce: Announce) -> tuple[Scene, Choice | None]:
    from symoro_elastic.numerics.verification.forms import has_forms, with_form

    if scene.form == AUTO and has_forms(scene):
        announce("compare forms")
    return with_form(machine, scene)


def by_recursion(scene: Scene) -> Scene:
    """The scene without a choice of forms: errors of the recursion are bounded nearer, and its terms are forces."""
    return replace(scene, form=RECURSION) if scene.form == AUTO else scene


def _of_unit(machine: Machine) -> Machine:
    """The machine whose models an FMU holds."""
    from symoro_elastic.generation.fmu.programs import with_parameters

    return with_parameters(machine)


def _unit(machine: Machine, scene: Scene, options: fmu.Options, announce: Announce) -> _Made:
    """The FMU of a machine; raises `InputError`."""
    from symoro_elastic.generation.fmu.mock_up_unit import unit_of

    refuse_degenerate(machine, replace(scene, models=(DIRECT,)))
    unit = unit_of(machine, scene, options, announce)
    models = unit.programs.models
    return _Made({f"{machine.name}.fmu": unit.archive}, models, models, notes=unit.notes)


def verify(
    machine: Machine,
    scene: Scene,
    *,
    seed: int = 0,
    announce: Announce = announce_nothing,
    progress: Progress = no_progress,
) -> Verification:
    """Compare the code of the models that a scene asks of a machine with a 50-digit reference.

    `progress(done, total)` is called after each state. Raises `InputError`, `NoValues`, `CompilationFailed`.
    """
    from symoro_elastic.numerics.verification.verify import build_code, compare, refuse_unverifiable, render_verified

    refuse_unverifiable(machine, scene)
    asked = programs(machine, replace(scene, steps=()), announce)
    announce("render")
    files = render_verified(asked.package)
    with tempfile.TemporaryDirectory() as folder:
        announce("compile")
        code = build_code(asked.package, files, Path(folder))
        announce("verify")
        return compare(asked, code, seed=seed, progress=progress)


def certificates(
    machine: Machine,
    scene: Scene,
    precisions: Sequence[Precision] = (DOUBLE,),
    effort: Effort | None = None,
    announce: Announce = announce_nothing,
) -> Certificates:
    """What the models that a scene asks of a machine guarantee within its limits; raises `InputError`."""
    return certified_in_form(machine, replace(scene, steps=()), precisions, effort, announce)[1]


def certified_in_form(
    machine: Machine,
    scene: Scene,
    precisions: Sequence[Precision] = (DOUBLE,),
    effort: Effort | None = None,
    announce: Announce = announce_nothing,
) -> tuple[Traced, Certificates]:
    """The programs of a scene and their certificates; raises `InputError`.

    Where the form is free, direct models are solved by the recursion, or through the inertia matrix where that proves
    more: errors of the recursion are bounded nearer, as long as they are bounded.
    """
    from symoro_elastic.numerics.verification.forms import has_forms

    asked = programs(machine, by_recursion(scene), announce)
    found = certified(machine, asked, precisions, effort, announce)
    if scene.form != AUTO or not has_forms(scene) or not found.doubt[0]:
        return asked, found
    other = programs(machine, replace(scene, form=INERTIA), announce)
    of_other = certified(machine, other, precisions, effort, announce)
    return (other, of_other) if of_other.doubt < found.doubt else (asked, found)


def certified(
    machine: Machine,
    asked: Traced,
    precisions: Sequence[Precision],
    effort: Effort | None = None,
    announce: Announce = announce_nothing,
) -> Certificates:
    """The certificates of programs in each of the precisions that have one; raises `InputError`."""
    from symoro_elastic.numerics.guarantees.certificates import Effort, certify_models
    from symoro_elastic.numerics.guarantees.running_error import ROUNDINGS

    announce("certify")
    described = DescribedMachine.of(machine)
    physical = described.origin.ungrouped or machine
    roundings = [ROUNDINGS[precision.name] for precision in precisions if precision.name in ROUNDINGS]
    return certify_models(asked, physical, described.limits, roundings, effort or Effort())


def _grouped(machine: DescribedMachine, warn: Callable[[str], None]) -> DescribedMachine:
    """The machine with base inertial parameters."""
    from symoro_elastic.numerics.grouping import base_machine

    grouped, doubts = base_machine(machine)
    for line in doubts:
        warn(line)
    return replace(grouped, origin=replace(grouped.origin, ungrouped=machine))


@no_collection()
def render(package: Package, targets: Sequence[str], source: str, precisions: Sequence[Precision] = (DOUBLE,)) -> Files:
    """File names and texts; raises `InputError` for constants out of range and for too low a precision."""
    _refuse_low_precision(package, source, precisions)
    try:
        return render_targets(package, targets, precisions)
    except OverflowError:
        what = "their products are out of the range of double precision: check the units"
        raise InputError(source or package.name, "numbers of the table", what) from None


def _refuse_low_precision(package: Package, source: str, precisions: Sequence[Precision]) -> None:
    for function in package.functions:
        low = [precision.name for precision in precisions if precision.bits < function.least_bits]
        if low:
            what = f"{function.name} finds no solution in {low[0]} precision"
            what += ": --precision double, or leave the model out"
            raise InputError(source or package.name, "--precision", what)


def refuse_degenerate(machine: Machine, scene: Scene) -> None:
    """Raise `InputError` for a machine whose asked models would divide by zero at every position."""
    found = found_degeneracies(machine, scene)
    if found:
        message, joints = found[0]
        others = "".join(f"; the same holds for {joints}" for _, joints in found[1:])
        raise machine.error(joints, message + others)


def found_degeneracies(machine: Machine, scene: Scene) -> list[tuple[str, str]]:
    """(message, joints) of each pivot that is zero in one of the asked models."""
    kept, constants = restrict(machine, scene), names_to_fold(machine, scene)
    asked = {MODELS[name].pivots for name in models_of(scene) if name in MODELS}
    asked |= {Pivots.ALL} if scene.steps else set()
    found: dict[int, Degeneracy] = {}
    for pivots in Pivots:
        if pivots in asked:
            for degeneracy in degeneracies(kept, pivots is Pivots.WITHOUT_MOTOR, constants):
                found.setdefault(degeneracy.joint, degeneracy)
    ordered = [found[j] for j in sorted(found)]
    return [(d.message(kept), ", ".join(f"joint {j}" if j else BASE for j in d.moving_together)) for d in ordered]


def is_part(scene: Scene) -> bool:
    """Whether a scene asks for less than the whole machine."""
    held = scene.locked or scene.static or scene.condense or scene.zero
    return bool(scene.outputs or held or scene.fold or not scene.gravity)


def _of_whole_machine(asked: Traced) -> Sequence[TracedModel]:
    """The same models of the whole machine; a model that exists only with joints locked stays as it is."""
    return (
        [_whole(asked.whole, model, asked.scene.form) for model in asked.models]
        if is_part(asked.scene)
        else asked.models
    )


def _whole(machine: Machine, part: TracedModel, form: str) -> TracedModel:
    try:
        return trace_scene(machine, Scene(models=(part.model.name,), form=form), grouping_by_rank)[0]
    except (InputError, SingularPivot):
        return part
