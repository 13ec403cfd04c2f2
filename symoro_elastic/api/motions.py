"""Motions of a scene: simulate, ladder."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from symoro_elastic.api.machines import NO_VALUES, MachineLike, Values, the_machine
from symoro_elastic.api.scenes import Asked, Prescribed, SceneLike, prescribed, top_of
from symoro_elastic.errors import InputError, among
from symoro_elastic.integration.methods import METHODS
from symoro_elastic.machine.formats.motions import motions_of, wanted_of
from symoro_elastic.machine.restrict import restricted
from symoro_elastic.progress import Announce, Progress, announce_nothing, no_progress

if TYPE_CHECKING:
    from symoro_elastic.machine.machine import Machine
    from symoro_elastic.machine.prescribed_motion import PrescribedMotion
    from symoro_elastic.machine.wanted import Wanted
    from symoro_elastic.model_ladder.rungs import Ladder
    from symoro_elastic.model_ladder.simulate import Request
    from symoro_elastic.simulation.reference import Reference
    from symoro_elastic.simulation.simulated import Simulation

NEITHER = "choose even steps (--method, --step) or adapted ones (--adaptive)"
Box = Mapping[str, tuple[float, float]]


@dataclass(frozen=True)
class Integration:
    """How to integrate: even steps of a method, or steps that are adapted and find events."""

    method: str | None = None
    step: float | None = None
    adaptive: bool = False
    events: Values = field(default_factory=dict)
    stop: bool = False

    def __post_init__(self) -> None:
        if self.method is not None:
            among((self.method,), METHODS, "--method")
        if self.adaptive and (self.method or self.step is not None):
            raise InputError("symoro-elastic", "--adaptive", NEITHER)
        if self.events and not self.adaptive:
            raise InputError("symoro-elastic", "--event", "even steps find no events: add --adaptive")
        if self.stop and not self.events:
            raise InputError("symoro-elastic", "--stop", "there is no event to stop at: name one by --event")

    def run(self, reference: Reference, request: Request, announce: Announce, progress: Progress) -> Simulation:
        """Return the simulated motion."""
        from symoro_elastic.model_ladder.simulate import simulate
        from symoro_elastic.model_ladder.simulate_adaptively import simulate_adaptively

        if self.adaptive:
            return simulate_adaptively(reference, request, self.events, self.stop, announce, progress)
        return simulate(reference, request, announce, progress)


@dataclass(frozen=True)
class Plan:
    """The motions of a scene of one machine, and how each is simulated."""

    references: tuple[Reference, ...]
    wanted: Wanted | None
    integration: Integration

    @cached_property
    def request(self) -> Request:
        """Outputs and tolerances, method and step."""
        from symoro_elastic.model_ladder.simulate import Request
        from symoro_elastic.simulation.tolerances import output_signals, tolerances

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
        return self.integration.run(reference, self.request, announce, progress)


def plan(whole: Machine, scene: SceneLike, integration: Integration, values: Values = NO_VALUES) -> Plan:
    """Return the motions of a scene, of a machine whose joints the scene locks; raises `InputError`."""
    from symoro_elastic.simulation.reference import reference_of
    from symoro_elastic.simulation.tolerances import refuse_rounding, tolerances

    moving = the_machine(restricted(whole, Asked().of(whole, scene)), values)
    found = prescribed(whole, scene)
    references = tuple(reference_of(moving, motion) for motion in found.motions)
    allowed = tolerances(found.wanted, moving) if found.wanted else {}
    for reference in references:
        refuse_rounding(allowed, reference)
    return Plan(references, found.wanted, integration)


def simulate(
    machine: MachineLike,
    scene: SceneLike = None,
    *,
    method: str | None = None,
    step: float | None = None,
    adaptive: bool = False,
    events: Values = NO_VALUES,
    stop: bool = False,
    values: Values = NO_VALUES,
    announce: Announce = announce_nothing,
    progress: Progress = no_progress,
) -> list[Simulation]:
    """Return the motions of a scene, simulated with a measured error: one for each table [motion].

    Parameters
    ----------
    machine
        A machine, its file or its tables.
    scene
        File or tables with [motion] (or several), [wanted] and [scene]; default: those of the machine.
    method, step
        Method of even steps ("w3", "w2", "rk4", "rodas4", "midpoint") and step, s; by default the cheapest by
        prediction that keeps the tolerances of [wanted].
    adaptive
        Adapted steps of scipy's DOP853 or Radau instead; they find `events` such as {"motor_x.qd": 0}, and `stop` at
        the first.
    values
        Values of parameters.

    Raises
    ------
    InputError
        For scenes without motion, machines whose motion is not determined, steps beyond stability.
    """
    planned = plan(the_machine(machine), scene, Integration(method, step, adaptive, events, stop), values)
    return [planned.run(one, announce, progress) for one in planned.references]


def ladder(
    machine: MachineLike,
    scene: SceneLike = None,
    *,
    box: Box | None = None,
    starts: int = 20,
    announce: Announce = announce_nothing,
    progress: Progress = no_progress,
) -> Ladder:
    """Return which springs, method and step the motions of a scene require, with errors predicted and measured.

    The scene has tables [motion] and [wanted] with a tolerance. `box` are ranges of positions by joint at which motions
    may start: `starts` of them are tried, a Latin hypercube. Raises `InputError`.
    """
    from symoro_elastic.model_ladder.rungs import ladder as ladder_of
    from symoro_elastic.simulation.tolerances import tolerances

    whole = the_machine(machine)
    found = replace(restricted(whole, Asked().of(whole, scene)), forces=())
    asked = prescribed(found, scene)
    wanted = _tolerated(asked)
    motions = _from_box(asked.motions, box or {}, starts, found)
    return ladder_of(found, motions, tolerances(wanted, found), wanted.period, announce, progress)


def predicted_ladder(machine: MachineLike, scene: str | Path | Mapping[str, Any]) -> Ladder | None:
    """Return the ladder of the motions of a scene by prediction alone; None without a motion or a tolerance.

    Raises `InputError`.
    """
    from symoro_elastic.model_ladder.rungs import predicted_ladder as ladder_of
    from symoro_elastic.simulation.tolerances import tolerances

    whole = the_machine(machine)
    found = replace(restricted(whole, Asked().of(whole, scene)), forces=())
    motions, wanted = motions_of(top_of(scene), found), wanted_of(top_of(scene))
    if not motions or wanted is None or wanted.tolerance is None:
        return None
    return ladder_of(found, motions, tolerances(wanted, found), wanted.period)


def _tolerated(asked: Prescribed) -> Wanted:
    if asked.wanted is None or asked.wanted.tolerance is None:
        what = 'no error is allowed yet: write tolerance = { "tool.x" = 1e-6 }'
        raise InputError(asked.source, "wanted, tolerance", what)
    return asked.wanted


def _from_box(motions: Sequence[PrescribedMotion], box: Box, count: int, machine: Machine) -> list[PrescribedMotion]:
    """Return each motion from every position of a sample of the box; the same motions where there is none."""
    from symoro_elastic.model_ladder.starts import starts

    among(tuple(box), tuple(joint.name for joint in machine.moving_joints), "--from")
    for name, (low, high) in box.items():
        if not low <= high:
            raise InputError(
                "symoro-elastic", "--from", f"{name}={low:g}:{high:g} is no range: give LOW:HIGH, LOW first"
            )
    places = starts(box, count) if box else [{}]
    return [replace(motion, start={**motion.start, **place}) for motion in motions for place in places]
