"""Motions of a scene: simulate, ladder."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from symoro_elastic.api.declaration import operation, part
from symoro_elastic.api.machines import NO_VALUES, the_machine
from symoro_elastic.api.options import Climbing, Integrating, Simulating
from symoro_elastic.api.rows import MachineLike, Ranges, SceneLike, Values
from symoro_elastic.api.scenes import Prescribed, SceneRequest, required_motions, top_of
from symoro_elastic.codegen.integration.methods import METHODS
from symoro_elastic.formats.toml.motions import motions_of, wanted_of
from symoro_elastic.foundation.errors import InputError, among
from symoro_elastic.foundation.progress import Announce, Progress, announce_nothing, no_progress
from symoro_elastic.machine.restrict import restrict

if TYPE_CHECKING:
    from symoro_elastic.analysis.ladder.climbed import Ladder
    from symoro_elastic.analysis.simulation.reference_motion import Reference
    from symoro_elastic.analysis.simulation.simulate import Request
    from symoro_elastic.analysis.simulation.simulated import Simulation, Simulations
    from symoro_elastic.machine.described import DescribedMachine, Wanted
    from symoro_elastic.machine.machine import Machine
    from symoro_elastic.machine.prescribed_motion import PrescribedMotion

NOTHING_TO_INTEGRATE = "every joint is a motor that follows exactly: leave it out, or give the motors servos"
NO_TERMS = (
    "a model that is simulated loses whole numbers, not terms, by which power is made from nothing; the tolerances are "
    "those of [wanted]: leave out within"
)
NEITHER = "choose even steps (--method, --step) or adapted ones (--adaptive)"


def refuse_mixture(steps: Integrating) -> None:
    """Raise `InputError` for options of an integration that exclude each other."""
    if steps.method is not None:
        among((steps.method,), METHODS, "--method")
    if steps.adaptive and (steps.method or steps.step is not None):
        raise InputError("symoro-elastic", "--adaptive", NEITHER)
    if steps.events and not steps.adaptive:
        raise InputError("symoro-elastic", "--event", "even steps find no events: add --adaptive")
    if steps.stop and not steps.events:
        raise InputError("symoro-elastic", "--stop", "there is no event to stop at: name one by --event")


@dataclass(frozen=True)
class Plan:
    """The motions of a scene of one machine, and how each is simulated."""

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
        """Return one of the motions, simulated."""
        from symoro_elastic.analysis.simulation.adaptive import simulate_adaptively
        from symoro_elastic.analysis.simulation.exact_following import follow, follows_exactly
        from symoro_elastic.analysis.simulation.simulate import simulate

        steps = self.integration
        if follows_exactly(reference):
            if steps.adaptive:
                raise InputError("symoro-elastic", "--adaptive", NOTHING_TO_INTEGRATE)
            return follow(reference, self.request)
        if steps.adaptive:
            return simulate_adaptively(reference, self.request, steps.events, steps.stop, announce, progress)
        return simulate(reference, self.request, announce, progress)


def plan(whole: DescribedMachine, scene: SceneLike, integration: Integrating, values: Values = NO_VALUES) -> Plan:
    """Return the motions of a scene, of a machine whose joints the scene locks; raises `InputError`."""
    from symoro_elastic.analysis.simulation.reference_motion import reference_of
    from symoro_elastic.analysis.simulation.tolerances import refuse_rounding, tolerances

    refuse_mixture(integration)
    moving = the_machine(restrict(whole, SceneRequest().of(whole, scene)), values)
    asked = required_motions(whole, scene)
    references = tuple(reference_of(moving, motion) for motion in asked.motions)
    allowed = tolerances(asked.wanted, moving) if asked.wanted else {}
    for reference in references:
        refuse_rounding(allowed, reference)
    return Plan(references, asked.wanted, integration)


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
    return Simulations(planned.run(one, options.announce, options.progress) for one in planned.references)


@operation(Climbing)
def ladder(machine: MachineLike, options: Climbing) -> Ladder:
    """Return which springs, method and step the motions of a scene require, with errors predicted and measured.

    The scene has tables [motion] and [wanted] with a tolerance. With `budget` numbers of bodies, steps and precision
    share the tolerance with springs: `budget` of the result. Its `write` writes the reduced scene. Raises `InputError`.
    """
    from symoro_elastic.analysis.ladder.climbed import Asked
    from symoro_elastic.analysis.ladder.rungs import ladder as ladder_of
    from symoro_elastic.analysis.simulation.tolerances import tolerances

    whole = the_machine(machine)
    scene = SceneRequest().of(whole, options.scene)
    kept = replace(restrict(whole, scene), forces=())
    asked = required_motions(kept, options.scene)
    wanted = _tolerated(asked)
    if options.budget and scene.within:
        raise InputError(asked.source, "scene, within", NO_TERMS)
    motions = _from_box(asked.motions, options.box or {}, options.starts, kept)
    found = ladder_of(
        kept, motions, tolerances(wanted, kept), wanted.period, options.announce, options.progress, options.budget
    )
    file = options.scene if isinstance(options.scene, str | Path) else None
    return replace(found, asked=Asked(whole, scene, asked.wanted, file))


def predicted_ladder(machine: MachineLike, scene: str | Path | Mapping[str, Any]) -> Ladder | None:
    """Return the ladder of the motions of a scene by prediction alone; None without a motion or a tolerance.

    Raises `InputError`.
    """
    from symoro_elastic.analysis.ladder.rungs import predicted_ladder as ladder_of
    from symoro_elastic.analysis.simulation.tolerances import tolerances

    whole = the_machine(machine)
    kept = replace(restrict(whole, SceneRequest().of(whole, scene)), forces=())
    motions, wanted = motions_of(top_of(scene), kept), wanted_of(top_of(scene))
    if not motions or wanted is None or wanted.tolerance is None:
        return None
    return ladder_of(kept, motions, tolerances(wanted, kept), wanted.period)


def _tolerated(asked: Prescribed) -> Wanted:
    if asked.wanted is None or asked.wanted.tolerance is None:
        what = 'no tolerance is given: write tolerance = { "tool.x" = 1e-6 }'
        raise InputError(asked.source, "wanted, tolerance", what)
    return asked.wanted


def _from_box(motions: Sequence[PrescribedMotion], box: Ranges, count: int, machine: Machine) -> list[PrescribedMotion]:
    """Return each motion from every position of a sample of the box; the same motions where there is no box."""
    from symoro_elastic.analysis.ladder.rungs import starts

    among(tuple(box), tuple(joint.name for joint in machine.independent_joints), "--box")
    for name, (low, high) in box.items():
        if not low <= high:
            raise InputError(
                "symoro-elastic", "--box", f"{name}={low:g}:{high:g} is not a range: give LOW:HIGH, LOW first"
            )
    places = starts(box, count) if box else [{}]
    return [replace(motion, start={**motion.start, **place}) for motion in motions for place in places]
