"""Models of machines: generate, check, equations, trade."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

from symoro_elastic import fmu, pipeline
from symoro_elastic.api.arguments import COMMAND
from symoro_elastic.api.machines import NO_VALUES, MachineLike, Values, the_machine
from symoro_elastic.api.scenes import Asked, SceneLike, in_form
from symoro_elastic.codegen.compile import CompilationFailed, CompilerMissing
from symoro_elastic.codegen.package import Package
from symoro_elastic.codegen.precision import DOUBLE, PRECISIONS
from symoro_elastic.codegen.targets import DEFAULT_TARGETS
from symoro_elastic.codegen.targets.c import C
from symoro_elastic.codegen.targets.c_batch import C_BATCH
from symoro_elastic.embedded.tool_chain import ToolChain, tool_chain
from symoro_elastic.errors import InputError, among
from symoro_elastic.machine.restrict import restricted
from symoro_elastic.machine.scene import RECURSION
from symoro_elastic.numerics.values import NoValues
from symoro_elastic.output_files import permission, write_text
from symoro_elastic.pipeline import TARGET_NAMES, Generated
from symoro_elastic.progress import Announce, Progress, announce_nothing, no_progress
from symoro_elastic.results import Shown, framed

if TYPE_CHECKING:
    from symoro_elastic.machine.machine import Machine
    from symoro_elastic.machine.scene import Scene
    from symoro_elastic.numerics.verify import Verification
    from symoro_elastic.progress import StepProgress
    from symoro_elastic.trade_off.trade import Trade


def generate(
    machine: MachineLike,
    *models: str,
    out: str | Path = "generated",
    targets: Sequence[str] = DEFAULT_TARGETS,
    scene: SceneLike = None,
    outputs: Mapping[str, Sequence[str]] | None = None,
    fold: Sequence[str] = (),
    steps: Sequence[str] = (),
    precisions: Sequence[str] = (DOUBLE.name,),
    form: str = RECURSION,
    report: bool = False,
    compiler: str = "",
    compiler_flags: str = "",
    fmi: int = fmu.VERSIONS[0],
    at: Values = NO_VALUES,
    force: bool = False,
    announce: Announce = announce_nothing,
) -> Generated:
    """Write code of a machine's models to `out/<machine name>/`, and return what was written with operation counts.

    Parameters
    ----------
    machine
        A machine, its file or its tables.
    models
        Names of models; by default those of the scene, else direct_dynamics and inverse_dynamics.
    out
        Folder of generated machines.
    targets
        "numpy", "c", "c-batch", "cpp", "matlab", "cuda"; "fmu", which has models of its own.
    scene, outputs, fold, steps
        As in `load`.
    precisions
        Precisions of the C code: "double", "single", "mixed", "double-double" (not in CUDA).
    form
        Form of direct_dynamics: "recursion", "inertia" (through the inertia matrix), or "auto": the one with fewer
        operations whose predicted error is within twice that of the recursion.
    report
        Compile the C, and report stack, code and instructions of each function (`reports` of the result).
    compiler, compiler_flags
        The compiler of the report, by default that of this computer, and its options, as one types them.
    fmi, at
        Version of FMI, 2 or 3, and positions at which motors stand at the start, rad or m: of the target "fmu".
    force
        Replace existing files that the program has not written itself.

    Raises
    ------
    InputError
        Nothing is written then.
    """
    found = the_machine(machine)
    asked = in_form(Asked(models, fold, outputs, steps).of(found, scene), form)
    names, written_in = among(targets, TARGET_NAMES, "--target"), among(precisions, PRECISIONS, "--precision")
    tools = reporting(report, compiler, compiler_flags, names)
    options = options_of_unit(names, models, fmi, at)
    with permission(force=force):
        return written(found, out, names, asked, written_in, announce, tools, options)


def options_of_unit(targets: Sequence[str], models: Sequence[str], fmi: int, at: Mapping[str, float]) -> fmu.Options:
    """Return the options of an FMU; raises `InputError` for those that have no meaning beside the targets."""
    if fmi not in fmu.VERSIONS:
        raise InputError(COMMAND, "--fmi", f"there is no {fmi!r}: choose from {', '.join(map(str, fmu.VERSIONS))}")
    for given, option, what in (
        (at, "--at", "is where an FMU starts"),
        (fmi != fmu.VERSIONS[0], "--fmi", "is the version of an FMU"),
    ):
        if given and fmu.NAME not in targets:
            raise InputError(COMMAND, option, f"{what}: add --target {fmu.NAME}, or leave it out")
    if models and {*targets} == {fmu.NAME}:
        what = "an FMU has models of its own: leave it out, or add another target"
        raise InputError(COMMAND, "--model", what)
    return fmu.Options(fmi, dict(at))


def reporting(report: bool, compiler: str, flags: str, targets: Sequence[str]) -> ToolChain | None:
    """Return the compiler of a report, None where there is to be none; raises `InputError`."""
    if not report:
        if compiler or flags:
            place = "--cc" if compiler else "--cflags"
            raise InputError("symoro-elastic", place, "is of the report: add --report, or leave it out")
        return None
    if not {C.name, C_BATCH.name} & {*targets}:
        raise InputError("symoro-elastic", "--report", "is of the C code: add --target c")
    try:
        return tool_chain(compiler, flags)
    except CompilerMissing as error:
        raise InputError("symoro-elastic", "--cc" if compiler else "--report", str(error)) from None
    except ValueError as error:
        place = "--cflags" if str(error) == flags else "--cc"
        raise InputError("symoro-elastic", place, f"{str(error)!r} has a quotation mark without its other") from None


def written(
    machine: Machine,
    out: str | Path,
    targets: Sequence[str],
    scene: Scene,
    precisions: Sequence[str],
    announce: Announce = announce_nothing,
    tools: ToolChain | None = None,
    options: fmu.Options | None = None,
) -> Generated:
    """Write the models that a scene asks of a machine, as `generate` does; `options` are those of an FMU."""
    chosen = [PRECISIONS[name] for name in precisions]
    return pipeline.generate(machine, scene, targets, Path(out), announce, chosen, tools, options)


def check(
    machine: MachineLike,
    *models: str,
    scene: SceneLike = None,
    seed: int = 0,
    form: str = RECURSION,
    announce: Announce = announce_nothing,
    progress: Progress = no_progress,
) -> Verification:
    """Compare generated C and numpy with 50-digit references at random and at extreme states.

    `ok` of the result says whether every error is within its bound; `form` as in `generate`. Raises `InputError` for
    what cannot be checked.
    """
    found = the_machine(machine)
    try:
        asked = in_form(Asked(models).of(found, scene), form)
        return pipeline.verify(found, asked, seed=seed, announce=announce, progress=progress)
    except (CompilationFailed, NoValues) as error:
        raise InputError(found.label, "check", str(error)) from None


@dataclass(frozen=True, repr=False)
class Equations(Shown):
    """The equations of one model of a machine, in the order of evaluation."""

    package: Package
    machine: Machine

    @property
    def headline(self) -> str:
        """Machine and model."""
        return f"Equations of {self.package.name}: {self.model}"

    def _repr_html_(self) -> str:
        """Return the page in a frame of its own."""
        return framed(self.html)

    def _repr_latex_(self) -> str:
        """Return the equations as one array; written out where they are short."""
        from symoro_elastic.reports.page import latex_equations

        return latex_equations(self.package, self.package.functions[0])

    @property
    def model(self) -> str:
        """Name of the model."""
        return self.package.functions[0].name

    @cached_property
    def latex(self) -> str:
        """A standalone LaTeX document; it needs amsmath and geometry."""
        from symoro_elastic.reports.page import latex_document

        return latex_document(self.package, self.package.functions[0])

    @cached_property
    def html(self) -> str:
        """A standalone web page, in MathML, with a picture of the machine."""
        from symoro_elastic.drawing.svg import svg_for_light_paper
        from symoro_elastic.reports.page import html_page

        return html_page(self.package, self.package.functions[0], svg_for_light_paper(self.machine))

    def write(self, path: str | Path, *, force: bool = False) -> Path:
        """Write a .tex, .html or .pdf file (by LaTeX), and return its path; raises `InputError`."""
        from symoro_elastic.reports.pdf import pdf

        file = Path(path)
        if file.suffix not in {".tex", ".html", ".pdf"}:
            raise InputError(str(path), "path", "equations are written as .tex, .html or .pdf")
        with permission(force=force):
            if file.suffix == ".pdf":
                return pdf(self.latex, file)
            write_text(self.html if file.suffix == ".html" else self.latex, file)
        return file


def equations(
    machine: MachineLike,
    model: str = "",
    *,
    scene: SceneLike = None,
    outputs: Mapping[str, Sequence[str]] | None = None,
    fold: Sequence[str] = (),
    announce: Announce = announce_nothing,
) -> Equations:
    """Return the equations of a model with its intermediate variables, as LaTeX and as a page. Raises `InputError`.

    Without a name it is the first model of the scene, else direct_dynamics.
    """
    found = the_machine(machine)
    asked = Asked((model,) if model else (), fold, outputs).of(found, scene)
    return Equations(pipeline.programs(found, asked, announce).package, restricted(found, asked))


def trade(
    machine: MachineLike,
    *models: str,
    scene: SceneLike = None,
    effort: str = "usual",
    states: int = 20_000,
    extreme: bool = False,
    rounds: int = 15,
    seed: int = 0,
    watched: StepProgress | None = None,
) -> Trade:
    """Measure speed and accuracy of every way to build the models of a machine on this computer.

    `effort` is "quick", "usual" or "all"; errors are measured at `states` moderate or `extreme` states, times in
    `rounds`. `advice(tolerance)` of the result is the fastest build within a relative error. Raises `InputError`.
    """
    from symoro_elastic.progress import no_step_progress
    from symoro_elastic.trade_off.trade import Request
    from symoro_elastic.trade_off.trade import trade as measured

    found = the_machine(machine)
    among((effort,), ("quick", "usual", "all"), "--effort")
    try:
        request = Request(effort, states, extreme, rounds, seed)
        return measured(found, Asked(models).of(found, scene), request, watched or no_step_progress)
    except (CompilationFailed, NoValues) as error:
        raise InputError(found.label, "trade", str(error)) from None
