"""Machines drawn: picture, view."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

from symoro_elastic.api.declaration import operation
from symoro_elastic.api.machines import the_machine
from symoro_elastic.api.motions import Plan, plan
from symoro_elastic.api.options import Drawing, Integrating, Viewing
from symoro_elastic.api.rows import MachineLike, SceneLike, Values
from symoro_elastic.api.scenes import SceneRequest, motions_of_scene
from symoro_elastic.codegen.compile import CompilationFailed, CompilerMissing
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.file_forms import PAGES, form_of
from symoro_elastic.foundation.output_files import permission, write_text
from symoro_elastic.foundation.progress import Announce, Progress
from symoro_elastic.foundation.results import Shown
from symoro_elastic.machine.described import DescribedMachine
from symoro_elastic.machine.restrict import restrict
from symoro_elastic.pages.drawing.page import machine_page, page_frame, pages_beside
from symoro_elastic.pages.drawing.picture_files import write_picture
from symoro_elastic.pages.drawing.shown import ShownMachine, shown_machine
from symoro_elastic.pages.drawing.svg import Picture, machine_picture, svg

if TYPE_CHECKING:
    from symoro_elastic.analysis.simulation.reference_motion import Reference
    from symoro_elastic.pages.drawing.motions import Played


@dataclass(frozen=True, repr=False)
class MachinePicture(Shown):
    """The picture of a machine at a position."""

    drawn: Picture

    @property
    def headline(self) -> str:
        """The machine."""
        return f"Picture of {self.drawn.figure.title}"

    @property
    def remarks(self) -> tuple[str, ...]:
        """Lines about what is not drawn to scale or left out."""
        return self.drawn.figure.remarks

    @cached_property
    def svg(self) -> str:
        """A standalone SVG document, for light and dark paper."""
        return svg(self.drawn)

    def _repr_html_(self) -> str:
        """Return the picture."""
        return self.svg

    def write(self, path: str | Path, *, force: bool = False) -> Path:
        """Write a .svg, .png or .pdf file (the latter by matplotlib), and return its path; raises `InputError`."""
        with permission(force=force):
            write_picture(self.drawn, str(path), "path")
        return Path(path)


@dataclass(frozen=True, repr=False)
class MachinePage(Shown):
    """The page on which a machine moves, or machines beside each other: one file that needs no network."""

    shown: ShownMachine
    others: tuple[ShownMachine, ...] = ()

    def beside(self, other: MachinePage) -> MachinePage:
        """Return the page that shows the machines of another page beside those of this one."""
        return MachinePage(self.shown, (*self.others, other.shown, *other.others))

    @property
    def headline(self) -> str:
        """The machine, its modes and motions."""
        titles = " and ".join(one.figure.title for one in (self.shown, *self.others))
        return f"Page of {titles}: {sum(len(one.motions) for one in (self.shown, *self.others))} motions"

    @property
    def remarks(self) -> tuple[str, ...]:
        """Lines about what is not shown, or shown differently."""
        every = (self.shown, *self.others)
        return tuple(line for one in every for line in (*one.remarks, *(x.remark for x in one.motions if x.remark)))

    @cached_property
    def html(self) -> str:
        """The page."""
        if not self.others:
            return machine_page(self.shown)
        pages = ((one.figure.title, machine_page(one)) for one in (self.shown, *self.others))
        return pages_beside([(title, page) for title, page in pages])

    def _repr_html_(self) -> str:
        """Return a frame that holds the page: in a notebook it moves, without a server."""
        return page_frame(self.html, self.headline)

    def write(self, path: str | Path, *, force: bool = False) -> Path:
        """Write the page as .html, and return its path; raises `InputError`."""
        form_of(path, PAGES, "path")
        with permission(force=force):
            write_text(self.html, path)
        return Path(path)


@operation(Drawing)
def picture(machine: MachineLike, options: Drawing) -> MachinePicture:
    """Return the picture of a machine: bodies as boxes of equal inertia, joints, springs, rails, frames, names.

    Springs are neutral. Lengths without value are drawn as 1 m, which `remarks` say. Raises `InputError` for joints
    that do not move by themselves, and where a loop does not close.
    """
    whole = the_machine(machine, options.values)
    return MachinePicture(machine_picture(restrict(whole, SceneRequest().of(whole, options.scene)), options.at))


@operation(Viewing)
def view(machine: MachineLike, options: Viewing) -> MachinePage:
    """Return the page on which a machine moves: a slider for each motor, its modes, the motions of a scene.

    Springs are in equilibrium at the position of the motors; the modes are those about it. Motions are simulated;
    where they cannot be their reference is shown, and `remarks` say why. Raises `InputError`.
    """
    whole, scene, values = the_machine(machine), options.scene, options.values
    kept = the_machine(restrict(whole, SceneRequest().of(whole, scene)), values)
    played = list(_played(whole, scene, values, options.announce, options.progress))
    return MachinePage(shown_machine(kept, options.at, played))


def _played(
    whole: DescribedMachine, scene: SceneLike, values: Values, announce: Announce, progress: Progress
) -> Iterator[Played]:
    """The motions of a scene, simulated where that is possible."""
    if not motions_of_scene(whole, scene).motions:
        return
    planned = plan(whole, scene, Integrating(), values)
    for reference in planned.references:
        yield _simulated(planned, reference, announce, progress)


def _simulated(planned: Plan, reference: Reference, announce: Announce, progress: Progress) -> Played:
    """A motion as it is simulated; its reference where it cannot be, with the reason."""
    from symoro_elastic.pages.drawing.motions import reference_motion, simulated_motion

    try:
        return simulated_motion(planned.run(reference, announce, progress))
    except (InputError, CompilerMissing, CompilationFailed) as error:
        what = error.what if isinstance(error, InputError) else str(error)
        return reference_motion(reference, f"{reference.prescribed.place}: the reference only: {what}")
