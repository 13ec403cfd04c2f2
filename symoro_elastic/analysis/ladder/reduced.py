"""A machine reduced to what tolerances at the tool require: the model that is simulated, the torques fed forward."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from enum import StrEnum
from pathlib import Path

from symoro_elastic.analysis.ladder.feed_forward import MODEL, FeedForward, FeedForwardSearch
from symoro_elastic.analysis.ladder.predicted_rungs import Prediction
from symoro_elastic.analysis.ladder.rung import Budget, Expense
from symoro_elastic.analysis.ladder.rungs import Asked, Ladder, ladder_of_prediction, reduced_scene
from symoro_elastic.analysis.ladder.torque_tolerances import acceleration_tolerances
from symoro_elastic.analysis.simulation.compiled_steps import ways_of
from symoro_elastic.analysis.simulation.prediction.spring_errors import relative
from symoro_elastic.codegen.embedded.report import FunctionReport
from symoro_elastic.codegen.embedded.tool_chain import ToolChain
from symoro_elastic.codegen.package import Package
from symoro_elastic.codegen.precision import DOUBLE, MIXED, SINGLE, Precision
from symoro_elastic.codegen.targets.c import render_c
from symoro_elastic.formats.toml.writing import write_scene
from symoro_elastic.foundation.output_files import permission, write_text
from symoro_elastic.foundation.progress import Announce, Progress, announce_nothing, no_progress
from symoro_elastic.foundation.results import Result
from symoro_elastic.generation.pipeline import programs, report
from symoro_elastic.machine.described import DescribedMachine
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.scene import ALL
from symoro_elastic.machine.within import Evidence


class Purpose(StrEnum):
    """Purposes of a reduced model: simulation, feed-forward, or both."""

    SIMULATION = "simulation"
    FEED_FORWARD = "feed-forward"
    BOTH = "both"


class Part(StrEnum):
    """Parts that may be omitted: springs, numbers of bodies, terms of the inverse model, digits, time steps."""

    SPRINGS = "springs"
    NUMBERS = "numbers"
    TERMS = "terms"
    PRECISION = "precision"
    STEPS = "steps"


OF_TORQUES = "# torques that are fed forward: generate and check --limits set-points"
DIRECT = "direct_dynamics"
SPENT_ON = {
    Part.SPRINGS: (Expense.SPRINGS,),
    Part.NUMBERS: (Expense.NUMBERS, Expense.NEUTRAL),
    Part.PRECISION: (Expense.PRECISION,),
    Part.STEPS: (Expense.STEPS,),
}


@dataclass(frozen=True, repr=False)
class Reduced(Result):
    """Reduced models of a machine that keep its outputs within tolerances in the motions of a scene.

    `simulation` is the path of models to simulate, `feed_forward` the accuracy of torques and the reduced inverse
    model; each has all of the tolerances, None where it was not asked for. `accelerations` are by joint the errors of
    a direct model that keep the tolerances, rad/s2 or m/s2, where nothing controls the motors. `rate` is that of the
    controller, Hz. `costs` are those on a processor, where it was named.
    """

    machine: Machine
    tolerance: Mapping[str, float]
    simulation: Ladder | None
    feed_forward: FeedForward | None
    accelerations: Mapping[str, float]
    asked: Asked
    rate: float | None = None
    costs: ProcessorCosts | None = None

    @property
    def headline(self) -> str:
        """Machine, and the operations that are saved, by purpose."""
        saved = []
        if self.simulation and self.simulation.budget:
            saved.append(f"{self.simulation.budget.saved:.0%} fewer operations to simulate")
        if self.feed_forward:
            saved.append(f"{self.feed_forward.operations} of {self.feed_forward.full} operations to feed forward")
        return f"Reduced {self.machine.name}: {', '.join(saved) or 'nothing left out'}"

    @property
    def is_within(self) -> bool:
        """Whether the measured errors of the advised models are within the tolerances."""
        budget = self.simulation.budget if self.simulation else None
        chosen = self.feed_forward.chosen if self.feed_forward else None
        measured = [budget.measured.errors] if budget else []
        measured += [chosen.measured] if chosen and chosen.measured else []
        return all(x[name] <= limit for x in measured for name, limit in self.tolerance.items())

    def write(self, file: str | Path, *, force: bool = False) -> list[Path]:
        """Write a scene for each purpose and return the paths; for both, "_feed_forward" is appended to one name.

        `simulate` reads the scene of the simulation, `generate` and `check` either. Raises `InputError` for files that
        exist unless `force`.
        """
        with permission(force=force):
            self.save(file)
            return self.files(file)

    def files(self, file: str | Path) -> list[Path]:
        """Return the files of the scenes."""
        path = Path(file)
        both = [path, path.with_stem(f"{path.stem}_feed_forward")]
        return both if self.simulation and self.feed_forward else [path]

    def save(self, file: str | Path) -> str:
        """Write the scenes as `write` does; existing files are replaced as the command line allows.

        Returned is a line on comments of the scene that are lost.
        """
        files = self.files(file)
        lost = self.simulation.save(files[0]) if self.simulation else ""
        if self.feed_forward:
            motions = [reference.prescribed for reference in self.feed_forward.references]
            text = write_scene(self.feed_forward.scene, motions, self.asked.wanted)
            write_text(f"{OF_TORQUES}\n\n{text}", files[-1], "--save")
        return lost


@dataclass(frozen=True)
class ProcessorCosts:
    """Costs on a processor of a call of the torque model and of a simulation step; None where there is none."""

    processor: str
    precision: str
    torques: FunctionReport | None
    step: FunctionReport | None


@dataclass(frozen=True)
class Compiler:
    """The compiler of a processor, and the precision in which torques are computed there."""

    processor: str
    tools: ToolChain
    precision: Precision

    def cost(self, package: Package, function: str, precision: Precision) -> FunctionReport:
        """Return the costs of a function of a package; raises `InputError`."""
        (code,) = report(package, render_c(package, precision), [precision], self.tools)
        names = precision.function(package.name, function), f"{package.name}{precision.suffix}_{function}"
        return next(x for x in code.functions if x.name in names)

    def precision_of_step(self, budget: Budget) -> Precision:
        """Return mixed precision where it is advised, or where double is emulated and mixed keeps the tolerances."""
        if budget.advised.expense is Expense.PRECISION:
            return MIXED
        keeps = relative(budget.measured.errors_mixed, budget.tolerance) <= 1
        return MIXED if self.precision is SINGLE and keeps else DOUBLE

    def cost_of_step(self, ladder: Ladder, asked: Asked) -> FunctionReport | None:
        """Return the costs of a step of the advised model, None without one; raises `InputError`."""
        if not (ladder.budget and ladder.advised and ladder.advised.chosen and ladder.advised.chosen.method):
            return None
        scene = reduced_scene(ladder, asked.machine, asked.scene)
        method = ladder.advised.chosen.method
        scene = replace(scene, models=(DIRECT,), outputs={}, fold=ALL, steps=(method,))
        package = programs(asked.machine, scene).package
        function = f"step_{method}{ways_of(ladder.references[0]).suffix}"
        return self.cost(package, function, self.precision_of_step(ladder.budget))


@dataclass(frozen=True)
class Goal:
    """Purpose of reduced models, evidence for torques, parts that may be omitted, and a compiler to count costs."""

    purpose: Purpose
    evidence: Evidence = Evidence.CONFIDENT
    parts: tuple[Part, ...] = tuple(Part)
    compiler: Compiler | None = None


def reduced_for(
    goal: Goal,
    prediction: Prediction,
    asked: Asked,
    announce: Announce = announce_nothing,
    progress: Progress = no_progress,
) -> Reduced:
    """Return the models that the tolerances of a prediction require, measured by simulation; raises `InputError`."""
    spent = frozenset(x for part in goal.parts for x in SPENT_ON.get(part, ()))
    simulation = feed_forward = torques = step = None
    compiler = goal.compiler
    if goal.purpose is not Purpose.SIMULATION and Part.TERMS in goal.parts:
        machine, precision = DescribedMachine.of(asked.machine), compiler.precision if compiler else DOUBLE
        search = FeedForwardSearch(prediction, machine, asked.scene, goal.evidence, precision)
        feed_forward = search.run(announce)
        torques = compiler.cost(search.package_of(feed_forward), MODEL, precision) if compiler else None
    if goal.purpose is not Purpose.FEED_FORWARD and spent:
        simulation = replace(ladder_of_prediction(prediction, announce, progress, spent), asked=asked)
        step = compiler.cost_of_step(simulation, asked) if compiler else None
    costs = ProcessorCosts(compiler.processor, compiler.precision.name, torques, step) if compiler else None
    first = prediction.paths[0]
    free = {} if first.reference.servo is not None else acceleration_tolerances(first, prediction.tolerance)
    rate = 1 / prediction.request.period if prediction.request.period else None
    return Reduced(prediction.machine, prediction.tolerance, simulation, feed_forward, free, asked, rate, costs)
