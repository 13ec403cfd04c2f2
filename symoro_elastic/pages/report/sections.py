"""The sections of a report."""

from __future__ import annotations

import base64
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from html import escape
from typing import Any

import numpy as np

from symoro_elastic.analysis.control.control import control_at
from symoro_elastic.analysis.ladder.rungs import Ladder
from symoro_elastic.analysis.vibration.drawn_modes import MOST_PICTURES, drawn_modes
from symoro_elastic.analysis.vibration.linearization import Linearization, linearize, with_motors
from symoro_elastic.analysis.vibration.modes import Modes, modes, refuse_rigid, strain_shares
from symoro_elastic.analysis.vibration.plots import bode
from symoro_elastic.analysis.vibration.point_stiffness import point_stiffnesses
from symoro_elastic.analysis.vibration.responses import Response, frequency_grid, frequency_response
from symoro_elastic.analysis.vibration.views import modes_conclusion
from symoro_elastic.codegen.package_context import operations
from symoro_elastic.codegen.templates import render
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.pictures import Plot, picture
from symoro_elastic.foundation.progress import Announce, Progress, announce_nothing, no_progress
from symoro_elastic.foundation.results import Part, Result, Table, as_html
from symoro_elastic.generation.pipeline import operation_counts, programs, verify, warnings_of
from symoro_elastic.machine.described import DescribedMachine, drives_of
from symoro_elastic.machine.frames import FrameNames
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.named_cells import with_values
from symoro_elastic.machine.scene import Scene
from symoro_elastic.machine.views import (
    beams_table,
    bodies_table,
    catalogue_table,
    drives_table,
    limits_table,
    machine_table,
    parameter_lines,
)
from symoro_elastic.models.bound.joint_axes import placed_machine
from symoro_elastic.numerics.linear.grouping import base_parameters
from symoro_elastic.numerics.motion.equations_of_motion import motion_of
from symoro_elastic.numerics.motion.equilibrium import equilibrium
from symoro_elastic.numerics.verification.verify import Verification
from symoro_elastic.pages.closed_chains import closed_chain, closed_chain_lines
from symoro_elastic.pages.drawing.figure import Placements, figure_of, placements_of
from symoro_elastic.pages.drawing.svg import joint_counts, picture_of, svg
from symoro_elastic.pages.drawing.vibrations import arrows_of, changes_of, corners_of
from symoro_elastic.pages.equations.page import HTML, content
from symoro_elastic.pages.show import axes_table
from symoro_elastic.symbolic.program import OperationCount

MANY_DIGITS = re.compile(r"(?<![\w.])\d+\.\d{7,}(?:e[-+]?\d+)?(?![\w.])")

TEXTBOOK = ("inertia_matrix", "bias_forces")
MOST_LINES = 24
RECURSIONS = ("inverse_dynamics", "direct_dynamics")

COUNTED = ("inverse_dynamics", "direct_dynamics", "inertia_matrix", "bias_forces", "geometric_model")
BY_PAIRS = "inertia_matrix"
"""It grows with the pairs of joints, and is counted where they are few."""
MOST_RESPONSES, MOST_OPENED, MOST_WARNINGS = 4, 20, 5
PLOTTED = 1000
"""Frequencies of a plot of responses, two for each of its pixels."""
MOST_JOINTS = 60
"""Rows of a machine that a page has accuracy and equations of: 100 need minutes and 90 MB."""


@dataclass(frozen=True)
class Subject:
    """The subject of a report: a machine restricted to a scene, and the ladder of its motions if there is one."""

    machine: DescribedMachine
    ladder: Ladder | None = None
    announce: Announce = announce_nothing
    progress: Progress = no_progress
    values: dict[str, float] = field(default_factory=dict)

    @cached_property
    def linear(self) -> Linearization:
        """The machine linearized about its equilibrium, motors free."""
        machine = with_values(self.machine, self.values) if self.values else self.machine
        motion = motion_of(machine)
        return linearize(motion, equilibrium(motion, {}, carried=bool(machine.degrees_of_base)))

    @cached_property
    def modal(self) -> Modes:
        """The modes with all motors held; with free ones if nothing else moves."""
        locked = [self.linear.motion.names[k] for k in self.linear.motion.motors]
        linear = with_motors(self.linear, locked) if locked else self.linear
        try:
            refuse_rigid(linear)
        except InputError:
            linear = self.linear
        return modes(linear)

    @cached_property
    def tool(self) -> Response:
        """The response of the tool along forces on it, motors held; raises `InputError` for a rigid one."""
        machine = with_values(self.machine, self.values) if self.values else self.machine
        frame, linear = _tool(machine), self.linear
        ins, outs = ([f"{frame}.{prefix}{axis}" for axis in "xyz"] for prefix in ("f", ""))
        locked = [linear.motion.names[k] for k in linear.motion.motors]
        pushed = with_motors(linearize(linear.motion, linear.state, ins, outs), locked)
        response = frequency_response(pushed, frequency_grid(pushed))
        return replace(response, stiffnesses=point_stiffnesses(pushed, response))

    @cached_property
    def placements(self) -> Placements:
        """Placements of the frames in pictures."""
        return placements_of(self.machine)

    @cached_property
    def counts(self) -> Mapping[str, tuple[OperationCount, OperationCount]]:
        """Operations of some models, in a call and once for a parameter set."""
        is_long = len(self.machine.joints) > MOST_JOINTS
        counted = tuple(name for name in COUNTED if not (is_long and name == BY_PAIRS))
        return operation_counts(self.machine, Scene(models=counted))

    @cached_property
    def verification(self) -> Verification:
        """Direct and inverse dynamics compared with 50 digits; raises `InputError` for large machines."""
        refuse_large(self.machine, "symoro-elastic check compares the code of larger machines")
        scene = Scene(models=("direct_dynamics", "inverse_dynamics"))
        return verify(self.machine, scene, announce=self.announce, progress=self.progress)


def sections(subject: Subject) -> Iterator[Section]:
    """Return the sections in order; a failed one contains the reason."""
    makers = (
        ("summary", "Summary", _summary),
        ("machine", "Machine", _machine),
        ("modes", "Modes", _modes),
        ("stiffness", "Stiffness at the tool", _stiffness),
        ("responses", "Frequency responses", _responses),
        ("drives", "Drives and control", _drives),
        ("scene", "What the scene requires", _scene),
        ("counts", "Operations", _counts),
        ("accuracy", "Accuracy", lambda subject: blocks_of(subject.verification)),
        ("equations", "Equations", _equations),
    )
    for anchor, title, make in makers:
        if {"scene": subject.ladder, "drives": drives_of(subject.machine)}.get(anchor, True):
            subject.announce(title.lower())
            yield section(anchor, title, partial(make, subject))


def _summary(subject: Subject) -> Iterator[str]:
    """Key results, a line each; a failed one contains the reason."""
    makers = (
        ("First vibration", _first_vibration),
        ("Stiffness at rest", _static_stiffness),
        ("Cost of a call", _cost),
        ("Accuracy", _worst_error),
        ("Warnings", _warnings),
    )
    rows = "".join(f"<dt>{title}</dt><dd>{escape(_or_why(make, subject))}</dd>" for title, make in makers)
    yield f'<dl class="summary">{rows}</dl>'


def _or_why(make: Callable[[Subject], str], subject: Subject) -> str:
    try:
        return make(subject)
    except InputError as error:
        return f"not computed: {error.what}"


def _first_vibration(subject: Subject) -> str:
    _refuse_stiff(subject, "so nothing vibrates")
    return modes_conclusion(subject.modal)


def _static_stiffness(subject: Subject) -> str:
    _refuse_stiff(subject, "so nothing yields")
    stiffnesses = subject.tool.stiffnesses
    bounded = [stiffness for stiffness in stiffnesses if np.isfinite(stiffness.static)]
    if not bounded:
        return f"{_tool(subject.machine)} yields in no direction, or is held in none"
    softest = max(bounded, key=lambda stiffness: stiffness.static)
    return softest.sentence.partition(";")[0]


def _cost(subject: Subject) -> str:
    return "; ".join(f"{name.replace('_', ' ')} {operations(subject.counts[name][0])}" for name in RECURSIONS)


def _worst_error(subject: Subject) -> str:
    verification = subject.verification
    models = verification.models
    worst = max((max(x.numpy.moderate, x.c.moderate if x.c else 0.0) for x in models), default=0.0)
    verdict = "every error is within its bound" if verification.ok else "an error is out of its bound"
    return f"worst relative error of generated code at moderate states {worst:.1e}; {verdict}"


def _warnings(subject: Subject) -> str:
    warnings = warnings_of(subject.machine)
    return "; ".join(warnings[:MOST_WARNINGS]) + ("; ..." if len(warnings) > MOST_WARNINGS else "") or "none"


def _tool(machine: Machine) -> str:
    """The frame called tool, else the last one without a variable, else the last one."""
    names = [joint.name for joint in machine.joints]
    fixed = [joint.name for joint in machine.joints if joint.variable is None]
    return "tool" if "tool" in FrameNames(machine).own else (fixed or names)[-1]


def _refuse_stiff(subject: Subject, so: str) -> None:
    if not subject.linear.motion.springs:
        raise InputError(subject.machine.label, "springs", f"no joint is elastic, {so}")


def _stiffness(subject: Subject) -> Iterator[str]:
    _refuse_stiff(subject, "so nothing yields")
    response = subject.tool
    if not response.stiffnesses:
        raise InputError(subject.machine.label, response.inputs[0].rpartition(".")[0], "a force on it moves nothing")
    yield from (paragraph(stiffness.sentence) for stiffness in response.stiffnesses)
    for name, plot in response.plots().all.items():
        if name.startswith("stiffness_") and isinstance(plot, Plot):
            yield image(picture(plot.figure(), "svg"), plot.title, "", "plot")


def _machine(subject: Subject) -> Iterator[str]:
    machine = subject.machine
    yield machine_image(subject.placements)
    yield from (paragraph(note) for note in machine.origin.notes)
    yield block(machine_table(machine, "Geometric parameters, bodies and springs", with_units=True))
    yield paragraph(machine.gravity_in_words)
    placement = placed_machine(machine, {})
    yield block(axes_table(placement, "Origins and axes in frame 0"))
    yield block(bodies_table(machine, "Bodies: mass, first moments and inertia about the origin of the frame"))
    flexible = beams_table(machine, "Beams"), catalogue_table(machine, "Springs from catalogues")
    for table in (*flexible, limits_table(machine, "Limits"), drives_table(machine, "Drives")):
        if table.rows:
            yield block(table)
    if machine.parameters:
        values = "".join(map(paragraph, parameter_lines(machine)))
        yield collapsible("Parameters", [f'<div class="columns">{values}</div>'], opened=True)
    if machine.is_coupled:
        yield from map(paragraph, closed_chain_lines(closed_chain(machine, placement)))
    base = base_parameters(machine)
    formulas = [paragraph(f"{name} = {x}") for name, x in {**base.parts, **base.formulas}.items()]
    if formulas:
        parts = [f'<div class="columns">{"".join(formulas)}</div>']
        yield collapsible(f"{len(formulas)} base inertial parameters", parts, opened=len(formulas) <= MOST_OPENED)
    else:
        yield paragraph(f"Base inertial parameters: {base.check}")


def _modes(subject: Subject) -> Iterator[str]:
    _refuse_stiff(subject, "so nothing vibrates")
    if locked := subject.modal.linear.held:
        yield paragraph(f"Held: {', '.join(locked)}.")
    yield from blocks_of(subject.modal)
    yield f'<div class="pictures">{"".join(mode_images(subject.modal, subject.placements))}</div>'


def _responses(subject: Subject) -> Iterator[str]:
    linear = subject.linear
    if not linear.inputs:
        raise InputError(subject.machine.label, "motors", "there is none, so no response to show")
    _refuse_stiff(subject, "so nothing resonates")
    limited = replace(linear, F=linear.F[:, :MOST_RESPONSES], inputs=linear.inputs[:MOST_RESPONSES])
    response = frequency_response(limited, frequency_grid(linear, points=PLOTTED))
    for j, name in enumerate(response.inputs):
        image_data = picture(bode(response, j).figure(), "svg")
        described = f"Magnitude and phase of {', '.join(response.outputs)} over {name}"
        yield image(image_data, described, f"Input: {name}", "plot")
    if len(linear.inputs) > MOST_RESPONSES:
        yield paragraph(f"The other {len(linear.inputs) - MOST_RESPONSES}: symoro-elastic response")


def _drives(subject: Subject) -> Iterator[str]:
    """Margins and limits of the gains about the equilibrium, for the damping of the machine."""
    motion = subject.linear.motion
    result = control_at(motion, [({}, subject.linear.state)])
    yield from blocks_of(result)
    for plot in result.plots().all.values():
        if isinstance(plot, Plot):
            yield image(picture(plot.figure(), "svg"), plot.title, "", "plot")


def _scene(subject: Subject) -> Iterator[str]:
    assert subject.ladder
    yield from blocks_of(subject.ladder)
    image_data = picture(subject.ladder.plot("rungs"), "svg")
    yield image(image_data, "Error of each rung, predicted and measured", "Errors of the rungs", "plot")


def _counts(subject: Subject) -> Iterator[str]:
    table = Table(("model", "a call", "once for each parameter set"), title="Operations of the models")
    for name, counts in subject.counts.items():
        table.add_row(name, *map(operations, counts))
    yield block(table)
    yield paragraph("x products and divisions, + sums and differences")
    if BY_PAIRS not in subject.counts:
        which = f"{BY_PAIRS} of more than {MOST_JOINTS} joints grows with their pairs"
        yield paragraph(f"{which}: symoro-elastic generate --model {BY_PAIRS} counts it.")


def _equations(subject: Subject) -> Iterator[str]:
    refuse_large(subject.machine, "symoro-elastic equations writes them to a page of their own")
    yield from equation_blocks(subject.machine)


def refuse_large(machine: Machine, instead: str) -> None:
    """Raise `InputError` for a machine of too many rows for a page of equations; `instead` is the way out."""
    if len(machine.joints) > MOST_JOINTS:
        raise machine.error("joints", f"{len(machine.joints)}, and this section is for up to {MOST_JOINTS}: {instead}")


def equation_blocks(machine: Machine) -> Iterator[str]:
    """Return A(q) and H(q, qd) written out if they are short, and the recursions step by step."""
    textbook = [_content(machine, name) for name in TEXTBOOK]
    if all(x["short"] for x in textbook) and sum(len(x["short"]) for x in textbook) <= MOST_LINES:
        yield paragraph("A(q) qdd + H(q, qd) = the torques of motors, springs and dampers:")
        yield from (render("html/written_out.html.j2", **equation) for equation in textbook)
    else:
        yield paragraph("A(q) and H(q, qd) are long for this machine, and computed step by step.")
    for name in (*TEXTBOOK, *RECURSIONS):
        context = _content(machine, name)
        yield collapsible(context["title"], [render("html/equation_parts.html.j2", **context)])


def _content(machine: Machine, model: str) -> dict[str, Any]:
    package = programs(machine, Scene(models=(model,))).package
    return content(package, package.functions[0], HTML, prefix=f"{model}-")


def machine_image(placements: Placements) -> str:
    """Return the picture of a machine with joints at zero and neutral springs."""
    figure = figure_of(placements, placements.start)
    return image(svg(picture_of(figure)), f"{placements.machine.name}: {joint_counts(figure)}")


def mode_images(modal: Modes, placements: Placements) -> Iterator[str]:
    """Return a picture of each of the lowest modes at full amplitude, with a ghost of the rest position and arrows."""
    q = modal.linear.state.q
    figure = figure_of(placements, q)
    corners = corners_of(figure)
    strain = strain_shares(modal)
    vibrating = [int(k) for k in np.flatnonzero(modal.frequencies > 0)][:MOST_PICTURES]
    for mode in drawn_modes(modal, vibrating, corners):
        k, (name, share) = mode.k, strain.largest(mode.k)
        said_of = f"Mode {k + 1}: {modal.frequencies[k]:.4g} Hz, {share:.0%} of the strain energy in {name}"
        T = placements.at(q + changes_of(modal, mode))
        yield image(svg(picture_of(figure, T, arrows_of(mode, corners))), said_of, said_of)


# Sections of a page, as HTML: texts of a machine are escaped where they become part of one.
@dataclass(frozen=True)
class Section:
    """A title, and blocks of HTML; `anchor` is its name in links."""

    anchor: str
    title: str
    blocks: tuple[str, ...]


def section(anchor: str, title: str, make: Callable[[], Iterable[str]]) -> Section:
    """Return a section; on failure with a line of the reason."""
    try:
        blocks = tuple(make())
    except InputError as error:
        blocks = (paragraph(f"Not computed: {error.place}: {error.what}", "refused"),)
    return Section(anchor, title, blocks)


def blocks_of(result: Result) -> list[str]:
    """Return the parts of a result as blocks."""
    return [block(part) for part in result.parts()]


def block(part: Part) -> str:
    """Return a sentence or a table; a table that is too wide scrolls within its block."""
    if isinstance(part, Table):
        name = escape(part.title or "table", quote=True)
        return (
            f'<div class="wide" role="region" tabindex="0" aria-label="{name}">{shorten_numbers(as_html(part))}</div>'
        )
    return as_html(part)


def shorten_numbers(table: str) -> str:
    """Return a table with numbers shortened to six digits."""
    return MANY_DIGITS.sub(lambda number: f"{float(number[0]):.6g}", table)


def paragraph(text: str, kind: str = "") -> str:
    """Return a sentence as an HTML paragraph of the CSS class `kind`."""
    return f'<p class="{kind}">{escape(text)}</p>' if kind else f"<p>{escape(text)}</p>"


def image(svg: str | bytes, described: str, caption: str = "", kind: str = "machine") -> str:
    """Return a picture within the page, with a description for screen readers; `kind` is its class of styles."""
    data = base64.b64encode(svg if isinstance(svg, bytes) else svg.encode("utf-8")).decode("ascii")
    below = f"<figcaption>{escape(caption)}</figcaption>" if caption else ""
    source = f"data:image/svg+xml;base64,{data}"
    return f'<figure><img class="{kind}" src="{source}" alt="{escape(described, quote=True)}">{below}</figure>'


def collapsible(title: str, blocks: Sequence[str], opened: bool = False) -> str:
    """Return blocks under a title that opens and closes them; open ones are printed."""
    state = " open" if opened else ""
    return f"<details{state}><summary>{escape(title)}</summary>{''.join(blocks)}</details>"


def report_page(subject: Subject) -> str:
    """Return the page as HTML: nothing is loaded from elsewhere, and names of the machine are escaped."""
    parts = list(sections(subject))
    title, headline = escape(subject.machine.name), escape(subject.machine.headline.partition(": ")[2])
    return render("report/report.html.j2", title=title, headline=headline, sections=parts)
