"""Models of machines: generate, check, certify, equations, benchmark."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

from symoro_elastic.api.checked_calls import COMMAND
from symoro_elastic.api.compilers import OF_C, reporting
from symoro_elastic.api.declaration import operation, operation_on_models
from symoro_elastic.api.machines import the_machine
from symoro_elastic.api.options import Certifying, Checking, Generating, Integrating, Trading, Writing
from symoro_elastic.api.rows import (
    BOXES,
    EFFORTS,
    OF_FILE,
    OF_SET_POINTS,
    MachineLike,
    SceneLike,
    Values,
    certified_names,
)
from symoro_elastic.api.scenes import SceneRequest, scene_for
from symoro_elastic.codegen.embedded.tool_chain import ToolChain
from symoro_elastic.codegen.package import Function, Package
from symoro_elastic.codegen.precision import DOUBLE, PRECISIONS
from symoro_elastic.codegen.targets import DEFAULT_TARGETS, FMU, TARGET_NAMES, TARGETS
from symoro_elastic.foundation.errors import InputError, among, reported_places
from symoro_elastic.foundation.file_forms import EQUATIONS, form_of
from symoro_elastic.foundation.output_files import permission, write_text
from symoro_elastic.foundation.results import Shown, inline_page
from symoro_elastic.generation import fmu, pipeline
from symoro_elastic.generation.pipeline import Generated
from symoro_elastic.machine.limits import LIMITED, JointLimits, Limits, Range
from symoro_elastic.machine.restrict import restrict
from symoro_elastic.machine.within import EXACT
from symoro_elastic.numerics.evaluation.values import NoValues

if TYPE_CHECKING:
    from symoro_elastic.analysis.simulation.simulated import Simulation
    from symoro_elastic.analysis.trade_off.trade import Trade
    from symoro_elastic.foundation.array_types import Array
    from symoro_elastic.machine.described import DescribedMachine
    from symoro_elastic.machine.machine import Machine
    from symoro_elastic.machine.scene import Scene
    from symoro_elastic.numerics.guarantees.certificates import Certificates
    from symoro_elastic.numerics.verification.self_check import SelfCheck
    from symoro_elastic.numerics.verification.verify import Verification

WIDENED = 1.1
"""The hull of a motion is widened by this factor about its middle."""


@operation_on_models(Generating)
def generate(machine: MachineLike, options: Generating) -> Generated:
    """Write code of a machine's models to `out/<machine name>/`, and return the files and operation counts.

    Raises
    ------
    InputError
        If the input is invalid; nothing is written then.
    """
    build = build_of(options)
    full = the_machine(machine)
    scene = replace(scene_for(full, options, options.steps), merge_angles=options.merge_angles)
    with permission(force=options.force):
        return build.written(full, scene, options)


@dataclass(frozen=True)
class Build:
    """Targets of code, the compiler for the report, and the options of an FMU."""

    targets: tuple[str, ...]
    precisions: tuple[str, ...]
    tools: ToolChain | None
    unit: fmu.Options

    def written(
        self, machine: DescribedMachine, scene: Scene, options: Generating, warn: Callable[[str], None] | None = None
    ) -> Generated:
        """Write the models that a scene requests, and return the files and operation counts.

        `warn` is called with a line for each soft static spring and each loop that starts near a singularity.
        Without it these are not determined.
        """
        if warn:
            for line in pipeline.soft_springs(machine, scene):
                warn(line)
        precisions = [PRECISIONS[name] for name in self.precisions or (DOUBLE.name,)]
        machine = with_limits(machine, options.limits, options.scene)
        with reported_places({"scene, within": "--within", "scene, keep": "--keep"} if options.within else {}):
            unit = replace(self.unit, at=dict(options.start))
            reports = options.announce, options.progress
            how = pipeline.CodeOptions(precisions, self.tools, unit, options.certify, *reports)
            generated = pipeline.generate(machine, scene, self.targets, Path(options.out), how)
        if warn:
            for line in pipeline.singular_loops(machine, scene):
                warn(line)
        return generated


def build_of(options: Generating) -> Build:
    """Return the build of options; raises `InputError` for unknown names, and for conflicting options."""
    targets = among(options.targets, TARGET_NAMES, "--target") or DEFAULT_TARGETS
    precisions = among(options.precisions, PRECISIONS, "--precision")
    if precisions and all(len(TARGETS[name].precisions) == 1 for name in targets if name in TARGETS):
        raise InputError(COMMAND, "--precision", OF_C)
    tools = reporting(options, targets)
    return Build(
        targets,
        precisions,
        tools,
        options_of_unit(targets, options.models, options.fmi, options.start, options.by_torque),
    )


def options_of_unit(
    targets: Sequence[str], models: Sequence[str], fmi: int, start: Values, by_torque: bool
) -> fmu.Options:
    """Return the options of an FMU; raises `InputError` for options that these targets cannot use."""
    if fmi not in fmu.VERSIONS:
        raise InputError(COMMAND, "--fmi", f"unknown version {fmi!r}: choose from {', '.join(map(str, fmu.VERSIONS))}")
    for value, option, what in (
        (start, "--start", "is where an FMU starts"),
        (fmi != fmu.VERSIONS[0], "--fmi", "is the version of an FMU"),
        (by_torque, "--by-torque", "leaves drives out of an FMU"),
    ):
        if value and FMU not in targets:
            raise InputError(COMMAND, option, f"{what}: add --target {FMU}, or leave it out")
    if models and {*targets} == {FMU}:
        what = "an FMU has models of its own: leave it out, or add another target"
        raise InputError(COMMAND, "--model", what)
    return fmu.Options(fmi, dict(start), by_torque)


@operation_on_models(Checking)
def check(machine: MachineLike, options: Checking) -> Verification:
    """Compare generated C and numpy with 50-digit references at random and at extreme states.

    `ok` of the result says whether every error is within its bound. Raises `InputError` for what cannot be checked.
    """
    full = the_machine(machine)
    try:
        scene = scene_for(full, options)
        return pipeline.verify(full, scene, seed=options.seed, announce=options.announce, progress=options.progress)
    except NoValues as error:
        raise InputError(full.label, "check", str(error)) from None


def check_by_itself(machine: DescribedMachine, options: Checking) -> SelfCheck:
    """Return the digits of results of generated C that agree in the four rounding modes; raises `InputError`."""
    try:
        return pipeline.verify_by_itself(
            machine, scene_for(machine, options), seed=options.seed, progress=options.progress
        )
    except NoValues as error:
        raise InputError(machine.label, "check --self", str(error)) from None


@operation_on_models(Certifying)
def certify(machine: MachineLike, options: Certifying) -> Certificates:
    """Return ranges and bounds on rounding errors of a machine's models within its joint limits.

    Bounds are proven for all states in the box that the limits span, by intervals and running errors; where none is
    found, the error is bounded at random states with a stated confidence, or reported as not bounded.

    Raises
    ------
    InputError
        If a joint has no limit that a model needs, or a parameter no value.
    """
    from symoro_elastic.numerics.guarantees.certificates import Effort

    full = with_limits(the_machine(machine), options.limits, options.scene)
    precisions = [PRECISIONS[name] for name in among(options.precisions, [*certified_names()], "--precision")]
    effort = Effort(options.sub_boxes, options.seed, options.progress, options.polynomials)
    scene = scene_for(full, options)
    return pipeline.certificates(full, scene, precisions or (DOUBLE,), effort, options.announce)


@dataclass(frozen=True, repr=False)
class Equations(Shown):
    """The equations of models of a machine, each in the order of evaluation.

    `models` are their names.
    """

    package: Package
    machine: Machine
    models: tuple[str, ...]

    @property
    def headline(self) -> str:
        """Machine and models."""
        return f"Equations of {self.package.name}: {', '.join(self.models)}"

    def _repr_html_(self) -> str:
        """Return the page in a frame of its own."""
        return inline_page(self.html)

    def _repr_latex_(self) -> str:
        """Return the equations as one array for each model; written out where they are short."""
        from symoro_elastic.pages.equations.page import latex_equations

        return "\n\n".join(latex_equations(self.package, function) for function in self.functions)

    @property
    def model(self) -> str:
        """Name of the first model."""
        return self.models[0]

    @property
    def functions(self) -> tuple[Function, ...]:
        """The programs of the models, in the order of `models`."""
        by_name = {function.name: function for function in self.package.functions}
        return tuple(by_name[name] for name in self.models)

    @cached_property
    def latex(self) -> str:
        """A standalone LaTeX document; it needs amsmath and geometry."""
        from symoro_elastic.pages.equations.page import latex_document

        return latex_document(self.package, *self.functions)

    @cached_property
    def html(self) -> str:
        """A standalone web page, in MathML, with a picture of the machine."""
        from symoro_elastic.pages.drawing.svg import svg_for_light_paper
        from symoro_elastic.pages.equations.page import html_page

        return html_page(self.package, *self.functions, picture=svg_for_light_paper(self.machine))

    def write(self, path: str | Path, *, force: bool = False) -> Path:
        """Write a .tex, .html or .pdf file (by LaTeX), and return its path; raises `InputError`."""
        from symoro_elastic.pages.equations.pdf import pdf

        file, form = Path(path), EQUATIONS[form_of(path, EQUATIONS, "path")]
        with permission(force=force):
            if form == "pdf":
                return pdf(self.latex, file)
            write_text(self.html if form == "html" else self.latex, file)
        return file


@operation(Writing)
def equations(machine: MachineLike, options: Writing) -> Equations:
    """Return the equations of models with their intermediate variables, as LaTeX and as a page.

    `model` is a name or a list of names: several are written on one page. Raises `InputError`.
    """
    full = the_machine(machine)
    models = (options.model,) if isinstance(options.model, str) else tuple(options.model)
    models = tuple(name for name in dict.fromkeys(models) if name)
    scene = SceneRequest(models, options.fold, options.only).of(full, options.scene)
    package = pipeline.programs(full, scene, options.announce).package
    return Equations(package, restrict(full, scene), models or (package.functions[0].name,))


@operation_on_models(Trading)
def benchmark(machine: MachineLike, options: Trading) -> Trade:
    """Measure speed and accuracy of every way to build the models of a machine on this computer.

    `advice(tolerance)` of the result is the fastest build within a relative error. With `within` its `curves` are paths
    of operations against guaranteed error. Raises `InputError`.
    """
    from symoro_elastic.analysis.trade_off.guaranteed import curves_of, grids_of
    from symoro_elastic.analysis.trade_off.trade import Request
    from symoro_elastic.analysis.trade_off.trade import trade as measured
    from symoro_elastic.foundation.progress import no_step_progress

    full = the_machine(machine)
    among((options.effort,), EFFORTS, "--effort")
    among((options.limits,), BOXES, "--limits")
    try:
        request = Request(options.effort, options.states, options.extreme, options.rounds, options.seed)
        scene = replace(scene_for(full, options), merge_angles=options.merge_angles)
        watched, exact = options.watched or no_step_progress, replace(scene, within=EXACT)
        if not scene.within:
            return measured(full, exact, request, watched)
        with reported_places({"scene, within": "--within", "scene, keep": "--keep"} if options.within else {}):
            grids = grids_of(with_limits(full, options.limits, options.scene), scene, watched("leave out"))
        points = measured(full, exact, request, watched)
        return replace(points, curves=curves_of(grids, points.measurements))
    except NoValues as error:
        raise InputError(full.label, "benchmark", str(error)) from None


def with_limits(machine: DescribedMachine, limits: str, scene: SceneLike) -> DescribedMachine:
    """Return the machine with the requested limits; raises `InputError` for a scene without a motion."""
    among((limits,), BOXES, "--limits")
    if limits == OF_FILE:
        return machine
    from symoro_elastic.api.motions import plan, simulate

    if limits == OF_SET_POINTS:
        from symoro_elastic.analysis.ladder.feed_forward import operating_range

        joints: Mapping[str, JointLimits] = operating_range(plan(machine, scene, Integrating()).references)
    else:
        joints = hull(simulate(machine, scene=scene))
    return replace(machine, limits=Limits(joints, machine.limits.parameters))


def hull(motions: Iterable[Simulation]) -> Mapping[str, JointLimits]:
    """Return the ranges of all joints in some motions, by joint, widened by a tenth."""
    ranges: dict[str, dict[str, Range]] = {}
    for simulation in motions:
        moving, motion = simulation.reference.machine, simulation.motion
        columns = [(moving.independent, (motion.q, motion.qd, motion.qdd)), (moving.motors, (motion.tau,))]
        for (numbers, arrays), names in zip(columns, (LIMITED[:3], LIMITED[3:]), strict=True):
            for name, values in zip(names, arrays, strict=True):
                for j, column in zip(numbers, values.T, strict=True):
                    of = ranges.setdefault(moving.joint(j).name, {})
                    of[name] = _hull_of(of.get(name), column)
    return {joint: JointLimits(**{name: _widen(x) for name, x in of.items()}) for joint, of in ranges.items()}


def _hull_of(before: Range | None, values: Array) -> Range:
    low, high = float(values.min()), float(values.max())
    return Range(min(low, before.low), max(high, before.high)) if before else Range(low, high)


def _widen(x: Range) -> Range:
    middle, half = x.low / 2 + x.high / 2, WIDENED * (x.high - x.low) / 2
    return Range(middle - half, middle + half)
