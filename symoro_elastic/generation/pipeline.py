"""The journey of a machine: read, check, group, trace, prune, schedule, render, compile, verify.

`prepare` are its first three stages, `programs` the next three; `generate` goes on to files of code, `verify` to code
that is compiled and compared with a reference. `announce` is called with the name of a stage when it begins.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from symoro_elastic.codegen.embedded.disassembly import PROCESSORS, UnknownProcessor
from symoro_elastic.codegen.embedded.report import CodeReport, code_report
from symoro_elastic.codegen.embedded.tool_chain import ToolChain
from symoro_elastic.codegen.package import Package
from symoro_elastic.codegen.package_context import Files
from symoro_elastic.codegen.precision import DOUBLE, Precision
from symoro_elastic.codegen.targets import FMU, SCALED_TARGETS, TARGETS, render_targets
from symoro_elastic.formats.format import Conversion
from symoro_elastic.formats.reading import read
from symoro_elastic.formats.robots.toolbox import of_robot
from symoro_elastic.formats.toml.reading import machine_of
from symoro_elastic.formats.toml.tables import table_of
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.output_files import temporary_folder, write_files
from symoro_elastic.foundation.progress import Announce, Progress, announce_nothing, no_progress
from symoro_elastic.foundation.results import Result
from symoro_elastic.generation import fmu
from symoro_elastic.machine.checks import check
from symoro_elastic.machine.constants import with_free_numbers
from symoro_elastic.machine.described import DescribedMachine
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.names import unusable, why_no_machine
from symoro_elastic.machine.restrict import names_to_fold, restrict
from symoro_elastic.machine.rounded_angles import DECIMALS, with_exact_angles
from symoro_elastic.machine.scene import ALL, AUTO, INERTIA, RECURSION, Scene
from symoro_elastic.models.bound.model import Pivots
from symoro_elastic.models.bound.tracing import PrunedTrace, prune, schedule
from symoro_elastic.models.checks.degenerate import Degeneracy, SingularPivot, degeneracies
from symoro_elastic.models.checks.implausible import implausible_motions
from symoro_elastic.models.checks.loop_descriptions import described_loops, singular_starts
from symoro_elastic.models.packaging import Traced, reserved_words, with_steps
from symoro_elastic.models.programs.catalogue import KINEMATIC_MODELS, MODELS, TracedModel, models_of, trace_scene
from symoro_elastic.models.programs.catalogue import expressions_of_scene as trace
from symoro_elastic.models.steps.time_steps import notes_on_steps
from symoro_elastic.numerics.linear.grouping import grouping_by_rank
from symoro_elastic.quantities.frames import BASE
from symoro_elastic.symbolic.memory import no_collection
from symoro_elastic.symbolic.program import OperationCount

if TYPE_CHECKING:
    from symoro_elastic.generation.reduced_models.model import ReducedModel
    from symoro_elastic.numerics.guarantees.certificates import Certificates, Effort
    from symoro_elastic.numerics.verification.forms import Choice
    from symoro_elastic.numerics.verification.self_check import SelfCheck
    from symoro_elastic.numerics.verification.verify import Verification

MOST_WARNINGS = 20
DIRECT = "direct_dynamics"


@dataclass(frozen=True, repr=False)
class Generated(Result):
    """Written files and their models; `whole` are the same models of the full machine, `notes` remarks on files.

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
        return f"Generated {self.written[0].parent}: {', '.join(model.model.name for model in self.models)}"


def prepare(
    machine: Any,
    warn: Callable[[str], None] = announce_nothing,
    *,
    base: bool = False,
    free: Sequence[str] = (),
    conversion: Conversion | None = None,
    announce: Announce = announce_nothing,
) -> DescribedMachine:
    """The machine in a file, its inertial parameters grouped if `base`; raises `InputError`.

    Instead of a file, its tables or a robot of the Robotics Toolbox are taken. Numbers of the tables in `free` (bodies,
    springs ...) become parameters. A robot as links and joints gets the changes of `conversion`.

    `warn` is called with the first 20 warnings, line by line, and with the number of those omitted.
    """
    announce("read")
    return prepare_machine(_described(machine, conversion), warn, base=base, free=free, announce=announce)


def _described(machine: Any, conversion: Conversion | None) -> DescribedMachine:
    """The machine of a file, of tables or of a robot, not yet checked."""
    if isinstance(machine, str | Path):
        return read(machine, reserved_words(), conversion)
    if isinstance(machine, Mapping):
        snap = conversion and conversion.snap
        return with_exact_angles(machine_of(table_of(machine, "machine")), snap or DECIMALS)
    if hasattr(machine, "links"):
        return of_robot(machine, reserved=reserved_words())
    kind = type(machine).__name__
    what = f"{kind} is not a machine: give a file, its tables as dictionaries, or a robot with links"
    raise InputError("symoro-elastic", "machine", what)


def prepare_machine(
    machine: DescribedMachine,
    warn: Callable[[str], None],
    *,
    base: bool = False,
    free: Sequence[str] = (),
    announce: Announce = announce_nothing,
) -> DescribedMachine:
    """The checked machine, its inertial parameters grouped if `base`, numbers of the tables in `free` as parameters."""
    reserved = reserved_words()
    announce("check")
    lines = list(dict.fromkeys(warnings_of(machine)))
    more = [f"{len(lines) - MOST_WARNINGS} more like these"] if len(lines) > MOST_WARNINGS else []
    for line in (*lines[:MOST_WARNINGS], *more):
        warn(line)
    if base:
        announce("group")
        machine = _with_base_parameters(machine, warn)
    return with_free_numbers(machine, free, reserved) if free else machine


def warnings_of(machine: DescribedMachine) -> list[str]:
    """Lines about what is allowed but rarely intended; raises `InputError` for what is not allowed."""
    return [*check(machine, reserved_words(), MODELS), *implausible_motions(machine)]


def refuse_name(name: str, place: str) -> None:
    """Raise `InputError` for a name that no machine may have."""
    words = reserved_words()
    if reason := why_no_machine(name, words):
        raise InputError("symoro-elastic", place, unusable(name, reason, words))


@no_collection()
def programs(
    machine: Machine, scene: Scene, announce: Announce = announce_nothing, choice: Choice | None = None
) -> Traced:
    """The models that a scene asks of a machine, as programs; raises `InputError`.

    `choice` is that of the form of the scene, where it is known: its model is not traced again.
    """
    scene, needed, traced = _pruned_models(machine, scene, announce, choice)
    announce("schedule")
    scheduled = {model.trace.model.name: schedule(model) for model in needed} | traced
    return with_steps(machine, scene, [scheduled[name] for name in models_of(scene)])


@no_collection()
def operation_counts(machine: Machine, scene: Scene) -> dict[str, tuple[OperationCount, OperationCount]]:
    """Operation counts of the models of a scene, per call and per parameter set; statements are not put in order.

    Raises `InputError`.
    """
    scene, needed, traced = _pruned_models(machine, scene)
    counts = {model.trace.model.name: (model.count, model.count_once) for model in needed}
    counts |= {name: (model.program.count, model.program.count_once) for name, model in traced.items()}
    return {name: counts[name] for name in scene.models}


def _pruned_models(
    machine: Machine, scene: Scene, announce: Announce = announce_nothing, choice: Choice | None = None
) -> tuple[Scene, list[PrunedTrace], dict[str, TracedModel]]:
    """The scene in its form, the pruned traces of its models, and the models already traced to choose the form."""
    if choice is None:
        refuse_degenerate(machine, scene)
        scene, choice = _with_form(machine, scene, announce)
    announce("trace")
    traced = {choice.traced.model.name: choice.traced} if choice else {}
    traces = trace(machine, scene, grouping_by_rank, traced)
    announce("prune")
    return scene, [prune(trace_of_model) for trace_of_model in traces], traced


@dataclass(frozen=True)
class CodeOptions:
    """How code is written: C in each of the precisions.

    With `tools` the C is compiled before, and what it costs is reported. `unit` are the options of an FMU, which has
    models of its own. With `check --proven` functions say what they guarantee within the limits of the machine.
    """

    precisions: Sequence[Precision] = (DOUBLE,)
    tools: ToolChain | None = None
    unit: fmu.Options = field(default_factory=fmu.Options)
    certify: bool = False
    announce: Announce = announce_nothing
    progress: Progress = no_progress


@no_collection()
def generate(
    machine: Machine, scene: Scene, targets: Sequence[str], out: Path, options: CodeOptions | None = None
) -> Generated:
    """Write the models that a scene asks of a machine to `out/<machine name>/`.

    Raises `InputError`; nothing is written then.
    """
    options = options or CodeOptions()
    announce, certify = options.announce, options.certify
    texts = [name for name in targets if name in TARGETS]
    scaled = [name for name in targets if name in SCALED_TARGETS]
    if scene.within and FMU in targets:
        what = "an FMU has models of its own, which are whole: leave out the target, or within"
        raise machine.error("scene, within", what)
    free = scene if certify and not scene.within else None
    scene = by_recursion(scene) if certify or scene.within else scene
    in_models = machine
    if not texts and not scaled:
        from symoro_elastic.generation.fmu.programs import with_parameters

        in_models = with_parameters(machine)
    scene, form = in_form(in_models, scene, announce)
    parts = [_code(machine, free or scene, form, texts, options)] if texts else []
    parts += [_scaled_code(machine, scene, name, options) for name in scaled]
    if FMU in targets:
        parts.append(_unit(machine, scene, options.unit, announce))
    announce("write")
    written = write_files(out / machine.name, {name: x for part in parts for name, x in part.files.items()})
    notes = tuple(note for part in parts for note in part.notes)
    reports = [x for part in parts for x in part.reports]
    reduced = [x for part in parts for x in part.reduced]
    return Generated(written, parts[0].models, parts[0].whole, reports, notes, form, reduced)


@dataclass(frozen=True)
class Written:
    """Files by name, their models, the same models of the whole machine, reports on them, remarks."""

    files: Mapping[str, str | bytes]
    models: Sequence[TracedModel]
    whole: Sequence[TracedModel]
    reports: Sequence[CodeReport] = ()
    notes: tuple[str, ...] = ()
    reduced: Sequence[ReducedModel] = ()


def _code(machine: Machine, scene: Scene, form: Choice | None, targets: Sequence[str], options: CodeOptions) -> Written:
    """The code of the models that a scene asks of a machine; raises `InputError`."""
    traced, package, reduced = _programs_with_guarantees(machine, scene, form, options)
    options.announce("render")
    files = render(package, targets, machine.source, options.precisions)
    reports = _reports(package, files, options.precisions, options)
    notes = notes_on_steps(traced.machine, scene.steps)
    return Written(files, traced.models, _of_whole_machine(traced), reports, notes, reduced)


def _programs_with_guarantees(
    machine: Machine, scene: Scene, form: Choice | None, options: CodeOptions
) -> tuple[Traced, Package, Sequence[ReducedModel]]:
    """The programs of a scene, within its tolerances, and their package, with guarantees in its text if requested."""
    announce, precisions, progress = options.announce, options.precisions, options.progress
    if not scene.within:
        if not options.certify:
            traced = programs(machine, scene, announce, form)
            return traced, traced.package, ()
        from symoro_elastic.numerics.guarantees.header import with_guarantees

        traced, certificates = certified_in_form(machine, scene, precisions, announce=announce)
        return traced, with_guarantees(traced.package, certificates), ()
    from symoro_elastic.generation.reduced_models.search import reduced_models
    from symoro_elastic.generation.reduced_models.sentences import sentences_on
    from symoro_elastic.numerics.guarantees.certificates import Certificates
    from symoro_elastic.numerics.guarantees.header import with_guarantees
    from symoro_elastic.numerics.guarantees.running_error import ROUNDINGS

    announce("leave out")
    roundings = [ROUNDINGS[precision.name] for precision in precisions if precision.name in ROUNDINGS]
    traced, reduced = reduced_models(DescribedMachine.of(machine), scene, programs, roundings, progress, announce)
    first = {model.model: sentences_on(model) for model in reduced}
    certificates = Certificates(machine.name, tuple(x for model in reduced for x in model.certificates))
    return traced, with_guarantees(traced.package, certificates, first), reduced


def _scaled_code(machine: Machine, scene: Scene, target: str, options: CodeOptions) -> Written:
    """The code of a target whose numbers have proven scales; parameters are constants. Raises `InputError`."""
    from symoro_elastic.numerics.guarantees.fixed_point import with_scales

    announce, progress = options.announce, options.progress
    if scene.steps:
        raise machine.error(f"--target {target}", "has no time steps: leave them out, or choose another target")
    described, reduced = DescribedMachine.of(machine), list["ReducedModel"]()
    if scene.within:
        from symoro_elastic.generation.reduced_models.search import models_in_fixed_point
        from symoro_elastic.generation.reduced_models.sentences import fixed_totals

        announce("leave out")
        traced, reduced = models_in_fixed_point(described, scene, programs, announce, progress)
        announce("certify")
        package = with_scales(traced, described.limits, progress=progress, totals=fixed_totals(reduced))
    else:
        traced = programs(machine, replace(scene, fold=ALL), announce)
        announce("certify")
        package = with_scales(traced, described.limits, progress=progress)
    package = replace(package, source=traced.package.source)
    announce("render")
    files = SCALED_TARGETS[target].render(package, ())
    reports = _reports(package, files, SCALED_TARGETS[target].precisions, options)
    return Written(files, traced.models, _of_whole_machine(traced), reports, reduced=reduced)


def _reports(
    package: Package, files: Files, precisions: Sequence[Precision], options: CodeOptions
) -> Sequence[CodeReport]:
    """Reports on the cost of the C of a package, where a compiler is given."""
    if not options.tools:
        return ()
    options.announce(f"compile: {options.tools.command}")
    return report(package, files, precisions, options.tools)


def report(package: Package, files: Files, precisions: Sequence[Precision], tools: ToolChain) -> list[CodeReport]:
    """Reports on the cost of the C of a package, precision by precision; raises `InputError`."""
    try:
        return [code_report(package, files, precision, tools) for precision in precisions]
    except UnknownProcessor as error:
        what = f"the code that {tools.compiler[0]} makes ({error}) is not read: {', '.join(PROCESSORS)} are"
        raise InputError("symoro-elastic", "--compiler", what) from None


def in_form(machine: Machine, scene: Scene, announce: Announce = announce_nothing) -> tuple[Scene, Choice | None]:
    """The scene with the form of the direct dynamic model decided, and the choice if the program made it.

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
    """The scene with the recursion if the form is open: its error bounds are closer, and its terms are forces."""
    return replace(scene, form=RECURSION) if scene.form == AUTO else scene


def _unit(machine: Machine, scene: Scene, options: fmu.Options, announce: Announce) -> Written:
    """The FMU of a machine; raises `InputError`."""
    from symoro_elastic.generation.fmu.mock_up_unit import unit_of

    refuse_degenerate(machine, replace(scene, models=(DIRECT,)))
    unit = unit_of(machine, scene, options, announce)
    models = unit.programs.models
    return Written({f"{machine.name}.fmu": unit.archive}, models, models, notes=unit.notes)


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
    traced = programs(machine, replace(scene, steps=()), announce)
    announce("render")
    files = render_verified(traced.package)
    with temporary_folder() as folder:
        announce("compile")
        code = build_code(traced.package, files, Path(folder))
        announce("verify")
        return compare(traced, code, seed=seed, progress=progress)


def verify_by_itself(machine: Machine, scene: Scene, *, seed: int = 0, progress: Progress = no_progress) -> SelfCheck:
    """Compare runs of the C of a scene's models in the four rounding modes; raises as `verify` does."""
    from symoro_elastic.numerics.verification.self_check import SelfCheck, self_check
    from symoro_elastic.numerics.verification.verify import refuse_unverifiable

    refuse_degenerate(machine, scene)
    refuse_unverifiable(machine, scene)
    scene, _ = in_form(machine, scene)
    return SelfCheck(machine.name, self_check(machine, scene, seed=seed, progress=progress))


def certificates(
    machine: Machine,
    scene: Scene,
    precisions: Sequence[Precision] = (DOUBLE,),
    effort: Effort | None = None,
    announce: Announce = announce_nothing,
) -> Certificates:
    """The certificates of the models of a scene within the limits of the machine; raises `InputError`."""
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

    traced = programs(machine, by_recursion(scene), announce)
    certificates = certificates_of_programs(machine, traced, precisions, effort, announce)
    if scene.form != AUTO or not has_forms(scene) or not certificates.doubt[0]:
        return traced, certificates
    other = programs(machine, replace(scene, form=INERTIA), announce)
    of_other = certificates_of_programs(machine, other, precisions, effort, announce)
    return (other, of_other) if of_other.doubt < certificates.doubt else (traced, certificates)


def certificates_of_programs(
    machine: Machine,
    traced: Traced,
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
    return certify_models(traced, physical, described.limits, roundings, effort or Effort())


def _with_base_parameters(machine: DescribedMachine, warn: Callable[[str], None]) -> DescribedMachine:
    """The machine with base inertial parameters."""
    from symoro_elastic.numerics.linear.grouping import base_machine

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


MASSLESS = (
    "no body has mass or inertia, so no dynamic model exists: give masses, or ask for models of geometry "
    f"and kinematics ({', '.join(KINEMATIC_MODELS)}, inverse_geometric_model, velocities, ...)"
)


def refuse_degenerate(machine: Machine, scene: Scene) -> None:
    """Raise `InputError` for a machine whose asked models would divide by zero at every position."""
    pivots = zero_pivots(machine, scene)
    if pivots:
        message, joints = pivots[0]
        more = "".join(f"; the same holds for {joints}" for _, joints in pivots[1:])
        raise machine.error(joints, message + more)


def zero_pivots(machine: Machine, scene: Scene) -> list[tuple[str, str]]:
    """(message, joints) of the pivots that are zero in a requested model."""
    restricted, constants = restrict(machine, scene), names_to_fold(machine, scene)
    pivots_in_use = {MODELS[name].pivots for name in models_of(scene) if name in MODELS}
    pivots_in_use |= {Pivots.ALL} if scene.steps else set()
    by_joint: dict[int, Degeneracy] = {}
    for pivots in Pivots:
        if pivots in pivots_in_use:
            for degeneracy in degeneracies(restricted, pivots is Pivots.WITHOUT_MOTOR, constants):
                by_joint.setdefault(degeneracy.joint, degeneracy)
    if by_joint and not machine.has_inertia:
        return [(MASSLESS, "bodies")]
    ordered = [by_joint[j] for j in sorted(by_joint)]
    return [(d.message(restricted), ", ".join(f"joint {j}" if j else BASE for j in d.moving_together)) for d in ordered]


def soft_springs(machine: Machine, scene: Scene) -> Iterator[str]:
    """Yield a warning of a static spring whose load deflects it more than its stiffness restores, motors at 0."""
    if not scene.static:
        return
    from symoro_elastic.numerics.motion.equilibrium import SOFT, soft_static

    with suppress(InputError):
        if weakest := soft_static(restrict(machine, scene), {}):
            yield f"{scene.source or machine.label}: scene, static, {weakest}: {SOFT}"


def singular_loops(machine: Machine, scene: Scene) -> list[str]:
    """A warning of each loop that starts near a position at which generated models give inf or NaN."""
    return singular_starts(described_loops(restrict(machine, scene)))


def is_part(scene: Scene) -> bool:
    """Whether a scene asks for less than the whole machine."""
    has_fixed_joints = scene.locked or scene.static or scene.condense or scene.zero
    return bool(scene.outputs or has_fixed_joints or scene.fold or not scene.gravity)


def _of_whole_machine(traced: Traced) -> Sequence[TracedModel]:
    """The same models of the whole machine; a model that exists only with joints locked stays as it is."""
    return (
        [_whole(traced.whole, model, traced.scene.form) for model in traced.models]
        if is_part(traced.scene)
        else traced.models
    )


def _whole(machine: Machine, part: TracedModel, form: str) -> TracedModel:
    try:
        return trace_scene(machine, Scene(models=(part.model.name,), form=form), grouping_by_rank)[0]
    except (InputError, SingularPivot):
        return part
