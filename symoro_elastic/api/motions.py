"""Motions of a scene: simulate, reduce, ladder."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

from symoro_elastic.api.declaration import operation, part
from symoro_elastic.api.machines import NO_VALUES, the_machine
from symoro_elastic.api.options import Climbing, Integrating, Reducing, Simulating
from symoro_elastic.api.rows import MachineLike, Ranges, SceneLike, Values
from symoro_elastic.api.scenes import Prescribed, SceneRequest, required_motions
from symoro_elastic.codegen.embedded.processors import CONTROLLERS
from symoro_elastic.codegen.integration.tableaus import METHODS
from symoro_elastic.codegen.precision import PRECISIONS
from symoro_elastic.foundation.errors import NO_RANGE, InputError, among, reported_places
from symoro_elastic.foundation.progress import Announce, Progress, announce_nothing, no_progress
from symoro_elastic.machine.described import Wanted
from symoro_elastic.machine.restrict import restrict
from symoro_elastic.machine.within import Evidence

if TYPE_CHECKING:
    from symoro_elastic.analysis.ladder.reduced import Compiler, Reduced
    from symoro_elastic.analysis.ladder.rungs import Ladder
    from symoro_elastic.analysis.simulation.reference_motion import Reference
    from symoro_elastic.analysis.simulation.simulate import Request
    from symoro_elastic.analysis.simulation.simulated import Simulation, Simulations
    from symoro_elastic.machine.described import DescribedMachine
    from symoro_elastic.machine.machine import Machine
    from symoro_elastic.machine.prescribed_motion import PrescribedMotion

NO_TERMS = (
    "a model that is simulated loses numbers, not terms, which would violate the power balance; the tolerances are "
    "those of [wanted]: leave out within"
)
NO_TOLERANCE = 'no tolerance is given: write tolerance = { "tool.x" = 1e-6 }'
NEITHER = "choose even steps (--method, --step) or adapted ones (--adaptive)"


def refuse_mixture(steps: Integrating) -> None:
    """Raise `InputError` for conflicting options of an integration."""
    if steps.method is not None:
        among((steps.method,), METHODS, "--method")
    if steps.adaptive and (steps.method or steps.step is not None):
        raise InputError("symoro-elastic", "--adaptive", NEITHER)
    if steps.events and not steps.adaptive:
        raise InputError("symoro-elastic", "--event", "even steps find no events: add --adaptive")
    if steps.stop and not steps.events:
        raise InputError("symoro-elastic", "--stop", "needs an event: name one by --event")


@dataclass(frozen=True)
class Plan:
    """Motions of a scene of a machine, and their integration."""

    references: tuple[Reference, ...]
    wanted: Wanted | None
    integration: Integrating

    @cached_property
    def request(self) -> Request:
        """Outputs and tolerances, method and step."""
        from symoro_elastic.analysis.simulation.simulate import Request
        from symoro_elastic.analysis.simulation.tolerances import output_signals, tolerances

        integration, wanted = self.integration, self.wanted
        if wanted is None:
            return Request(method=integration.method, step=integration.step)
        machine = self.references[0].machine
        outputs, allowed = output_signals(wanted, machine), tolerances(wanted, machine)
        names = tuple(dict.fromkeys((*outputs, *allowed)))
        return Request(names, allowed or None, integration.method, integration.step, wanted.period)

    def run(
        self, reference: Reference, announce: Announce = announce_nothing, progress: Progress = no_progress
    ) -> Simulation:
        """Return the simulation of a reference motion."""
        from symoro_elastic.analysis.simulation.adaptive import simulate_adaptively
        from symoro_elastic.analysis.simulation.compiled_steps import NOTHING_TO_INTEGRATE
        from symoro_elastic.analysis.simulation.simulate import follow, follows_exactly, simulate

        steps = self.integration
        if follows_exactly(reference):
            if steps.adaptive:
                raise InputError("symoro-elastic", "--adaptive", f"{NOTHING_TO_INTEGRATE}, or leave it out")
            return follow(reference, self.request)
        if steps.adaptive:
            return simulate_adaptively(reference, self.request, steps.events, steps.stop, announce, progress)
        return simulate(reference, self.request, announce, progress)


def plan(full: DescribedMachine, scene: SceneLike, integration: Integrating, values: Values = NO_VALUES) -> Plan:
    """Return the motions of a scene, and their machine with joints of the scene locked; raises `InputError`."""
    from symoro_elastic.analysis.simulation.reference_motion import reference_of
    from symoro_elastic.analysis.simulation.tolerances import refuse_rounding, tolerances

    refuse_mixture(integration)
    moving = the_machine(restrict(full, SceneRequest().of(full, scene)), values)
    prescribed = required_motions(full, scene)
    references = tuple(reference_of(moving, motion) for motion in prescribed.motions)
    allowed = tolerances(prescribed.wanted, moving) if prescribed.wanted else {}
    for reference in references:
        refuse_rounding(allowed, reference)
    return Plan(references, prescribed.wanted, integration)


@operation(Simulating)
def simulate(machine: MachineLike, options: Simulating) -> Simulations:
    """Return the motions of a scene, simulated with a measured error: a list with one for each table [motion].

    The list has tables, plots and a data frame of its own, of all motions.

    Raises
    ------
    InputError
        For scenes without a motion, machines whose motion is not determined, or steps beyond the stability limit.
    """
    from symoro_elastic.analysis.simulation.simulated import Simulations

    planned = plan(the_machine(machine), options.scene, part(Integrating, options), options.values)
    return Simulations(planned.run(reference, options.announce, options.progress) for reference in planned.references)


@operation(Climbing)
def ladder(machine: MachineLike, options: Climbing) -> Ladder:
    """Return the springs, method and step that the motions of a scene require, with predicted and measured errors.

    The scene has tables [motion] and [wanted] with a tolerance. With `budget` numbers of bodies, steps and precision
    share the tolerance with springs: `budget` of the result. Its `write` writes the reduced scene. Raises `InputError`.
    """
    from symoro_elastic.analysis.ladder.rung import Expense
    from symoro_elastic.analysis.ladder.rungs import Asked, ladder_of_prediction, prediction_of
    from symoro_elastic.analysis.simulation.tolerances import tolerances

    full = the_machine(machine)
    scene = SceneRequest().of(full, options.scene)
    moving = replace(restrict(full, scene), forces=())
    prescribed = required_motions(moving, options.scene)
    wanted = _requirements(prescribed)
    if options.budget and scene.within:
        raise InputError(prescribed.source, "scene, within", NO_TERMS)
    motions = _from_box(prescribed.motions, options.box or {}, options.starts, moving)
    options.announce("predict errors")
    prediction = prediction_of(moving, motions, tolerances(wanted, moving), wanted.period)
    spent = frozenset(Expense) if options.budget else frozenset()
    result = ladder_of_prediction(prediction, options.announce, options.progress, spent)
    file = options.scene if isinstance(options.scene, str | Path) else None
    return replace(result, asked=Asked(full, scene, prescribed.wanted, file))


@operation(Reducing)
def reduce(machine: MachineLike, options: Reducing) -> Reduced:
    """Return the cheapest models that keep tolerances at the tool in the motions of a scene, measured by simulation.

    For simulation springs, numbers of bodies, time steps and precision share the tolerances. For feed-forward they
    become tolerances of torques by joint, within which terms are left out of the inverse model. `write` of the result
    writes their scenes. Raises `InputError`.
    """
    from symoro_elastic.analysis.ladder.reduced import Goal, Part, Purpose, reduced_for
    from symoro_elastic.analysis.ladder.rungs import Asked, prediction_of
    from symoro_elastic.analysis.simulation.tolerances import tolerances

    for names, known, place in (((options.for_,), Purpose, "--for"), (options.only, Part, "--only")):
        among(tuple(filter(None, names)), [*map(str, known)], place)
    whole = the_machine(machine)
    scene = SceneRequest().of(whole, options.scene)
    if scene.within:
        what = "tolerances are those at the tool, from which those of results follow: leave out within"
        raise InputError(scene.source or whole.label, "scene, within", what)
    kept = replace(restrict(whole, scene), forces=())
    asked = required_motions(kept, options.scene)
    wanted = _wanted(asked, options)
    options.announce("predict errors")
    with reported_places({"wanted, tolerance": "--to"} if options.to else {}):
        prediction = prediction_of(kept, asked.motions, tolerances(wanted, kept), wanted.period)
    controlled = prediction.references[0].servo is not None
    purpose = Purpose(options.for_ or (Purpose.BOTH if controlled else Purpose.SIMULATION))
    file = options.scene if isinstance(options.scene, str | Path) else None
    evidence = Evidence.PROVEN if options.proven else Evidence.CONFIDENT
    parts = tuple(map(Part, options.only)) or tuple(Part)
    goal = Goal(purpose, evidence, parts, compiler_for(options.processor) if options.processor else None)
    return reduced_for(goal, prediction, Asked(whole, scene, wanted, file), options.announce, options.progress)


def compiler_for(processor: str) -> Compiler:
    """Return the compiler of a processor by its name; raises `InputError`."""
    from symoro_elastic.analysis.ladder.reduced import Compiler
    from symoro_elastic.api.compilers import tools_of

    tools = tools_of(processor)
    return Compiler(processor, tools, PRECISIONS[CONTROLLERS[processor].precision])


def _wanted(asked: Prescribed, options: Reducing) -> Wanted:
    """Return the requirements of a scene with the tolerances and the rate of options; raises `InputError`."""
    wanted = asked.wanted or Wanted(source=asked.source)
    if options.to:
        wanted = replace(wanted, tolerance=dict(options.to), outputs=())
    if options.rate:
        wanted = replace(wanted, period=1 / options.rate)
    if wanted.tolerance is None:
        raise InputError(asked.source, "wanted, tolerance", f"{NO_TOLERANCE}, or --to tool.x=1um")
    return wanted


def _requirements(prescribed: Prescribed) -> Wanted:
    if prescribed.wanted is None or prescribed.wanted.tolerance is None:
        raise InputError(prescribed.source, "wanted, tolerance", NO_TOLERANCE)
    return prescribed.wanted


def _from_box(motions: Sequence[PrescribedMotion], box: Ranges, count: int, machine: Machine) -> list[PrescribedMotion]:
    """Return each motion from every position of a sample of the box; the same motions without a box."""
    from symoro_elastic.analysis.ladder.rungs import starts

    among(tuple(box), tuple(joint.name for joint in machine.independent_joints), "--box")
    for name, (low, high) in box.items():
        if not low <= high:
            raise InputError("symoro-elastic", "--box", f"{name}={NO_RANGE.format(low, high)}")
    places = starts(box, count) if box else [{}]
    return [replace(motion, start={**motion.start, **place}) for motion in motions for place in places]
