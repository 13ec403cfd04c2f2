"""The sections of a report."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property, partial

from symoro_elastic.errors import InputError
from symoro_elastic.grouping import base_parameters
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.named_cells import with_values
from symoro_elastic.machine.scene import Scene
from symoro_elastic.machine.table import bodies_table, machine_table
from symoro_elastic.machine_report.equations import equation_blocks
from symoro_elastic.machine_report.pictures import machine_image, mode_images
from symoro_elastic.machine_report.section import Section, block, folded, image, paragraph, section, shown
from symoro_elastic.model_ladder.plots import rungs
from symoro_elastic.model_ladder.rungs import Ladder
from symoro_elastic.models.joint_axes import placed_machine
from symoro_elastic.models.tables import models_table
from symoro_elastic.pictures import picture
from symoro_elastic.pipeline import programs, verify
from symoro_elastic.progress import Announce, Progress, announce_nothing, no_progress
from symoro_elastic.reports.closed_chains import closed_chain, closed_chain_lines
from symoro_elastic.reports.tables import axes_table
from symoro_elastic.results import Titled
from symoro_elastic.vibration.equilibrium import equilibrium
from symoro_elastic.vibration.linearization import Linearization, linearize, motion_of, with_motors
from symoro_elastic.vibration.modes import Modes, modes, refuse_rigid
from symoro_elastic.vibration.plots import bode
from symoro_elastic.vibration.responses import frequency_grid, frequency_response

COUNTED = ("inverse_dynamics", "direct_dynamics", "inertia_matrix", "bias_forces", "geometric_model")
MOST_RESPONSES, MOST_OPENED = 4, 20


@dataclass(frozen=True)
class Subject:
    """What a report is about: a machine restricted to a scene, and the ladder of its motions where one was climbed."""

    machine: Machine
    ladder: Ladder | None = None
    announce: Announce = announce_nothing
    progress: Progress = no_progress
    values: dict[str, float] = field(default_factory=dict)

    @cached_property
    def linear(self) -> Linearization:
        """The machine linearized about its equilibrium, motors free."""
        machine = with_values(self.machine, self.values) if self.values else self.machine
        motion = motion_of(machine)
        return linearize(motion, equilibrium(motion, {}, carried=machine.floating is not None))

    @cached_property
    def modal(self) -> Modes:
        """The modes with all motors held; with free ones where nothing else moves."""
        held = [self.linear.motion.names[k] for k in self.linear.motion.motors]
        kept = with_motors(self.linear, held) if held else self.linear
        try:
            refuse_rigid(kept)
        except InputError:
            kept = self.linear
        return modes(kept)


def sections(subject: Subject) -> Iterator[Section]:
    """Return the sections in their order; what cannot be computed says why."""
    made = (
        ("machine", "Machine", _machine),
        ("modes", "Modes", _modes),
        ("responses", "Frequency responses", _responses),
        ("scene", "What the scene requires", _scene),
        ("counts", "Operations", _counts),
        ("accuracy", "Accuracy", _accuracy),
        ("equations", "Equations", _equations),
    )
    for anchor, title, make in made:
        if anchor != "scene" or subject.ladder:
            subject.announce(title.lower())
            yield section(anchor, title, partial(make, subject))


def _machine(subject: Subject) -> Iterator[str]:
    machine = subject.machine
    yield machine_image(machine)
    yield from (paragraph(note) for note in machine.notes)
    yield block(Titled(machine_table(machine), "Geometric parameters, bodies and springs"))
    placed = placed_machine(machine, {})
    yield block(Titled(axes_table(placed), "Origins and axes in frame 0"))
    yield block(Titled(bodies_table(machine), "Bodies: mass, first moments and inertia about the origin of the frame"))
    if machine.parameters:
        values = (f"{p.name} = {p.value or 'no value'} {p.unit}".rstrip() for p in machine.parameters)
        yield folded("Parameters", [f'<div class="columns">{"".join(map(paragraph, values))}</div>'], opened=True)
    if machine.is_coupled:
        yield from map(paragraph, closed_chain_lines(closed_chain(machine, placed)))
    base = base_parameters(machine)
    formulas = [paragraph(f"{name} = {x}") for name, x in {**base.parts, **base.formulas}.items()]
    if formulas:
        yield folded(f"{len(formulas)} base inertial parameters", formulas, opened=len(formulas) <= MOST_OPENED)
    else:
        yield paragraph(f"Base inertial parameters: {base.check}")


def _modes(subject: Subject) -> Iterator[str]:
    if not subject.linear.motion.springs:
        raise InputError(subject.machine.label, "springs", "no joint is elastic, so nothing vibrates")
    if held := subject.modal.linear.held:
        yield paragraph(f"Held: {', '.join(held)}.")
    yield from shown(subject.modal)
    yield f'<div class="pictures">{"".join(mode_images(subject.modal, subject.machine))}</div>'


def _responses(subject: Subject) -> Iterator[str]:
    linear = subject.linear
    if not linear.inputs:
        raise InputError(subject.machine.label, "motors", "there is none, so no response to show")
    if not linear.motion.springs:
        raise InputError(subject.machine.label, "springs", "no joint is elastic, so nothing resonates")
    found = frequency_response(linear, frequency_grid(linear))
    for j, name in enumerate(found.inputs[:MOST_RESPONSES]):
        drawn = picture(bode(found, j), "svg")
        described = f"Magnitude and phase of {', '.join(found.outputs)} over {name}"
        yield image(drawn, described, f"Input: {name}", "plot")
    if len(found.inputs) > MOST_RESPONSES:
        yield paragraph(f"The other {len(found.inputs) - MOST_RESPONSES}: symoro-elastic response")


def _scene(subject: Subject) -> Iterator[str]:
    assert subject.ladder
    yield from shown(subject.ladder)
    drawn = picture(rungs(subject.ladder), "svg")
    yield image(drawn, "Error of each rung, predicted and measured", "Errors of the rungs", "plot")


def _counts(subject: Subject) -> Iterator[str]:
    traced = programs(subject.machine, Scene(models=COUNTED)).models
    yield block(Titled(models_table(traced, traced), "Operations of the models"))
    yield paragraph("x products and divisions, + sums and differences")


def _accuracy(subject: Subject) -> Iterator[str]:
    scene = Scene(models=("direct_dynamics", "inverse_dynamics"))
    yield from shown(verify(subject.machine, scene, announce=subject.announce, progress=subject.progress))


def _equations(subject: Subject) -> Iterator[str]:
    yield from equation_blocks(subject.machine)
