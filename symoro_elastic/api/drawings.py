"""Pictures and pages of machines: picture, view, live, report."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

from symoro_elastic.api.declaration import operation
from symoro_elastic.api.machines import the_machine
from symoro_elastic.api.motions import Plan, ladder, plan
from symoro_elastic.api.options import Drawing, Integrating, Reporting, Serving, Viewing
from symoro_elastic.api.rows import READABLE, MachineLike, SceneLike, Values
from symoro_elastic.api.scenes import SceneRequest, motions_of_scene
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.file_forms import PAGES, form_of
from symoro_elastic.foundation.output_files import permission, write_all, write_text
from symoro_elastic.foundation.progress import Announce, Progress
from symoro_elastic.foundation.results import Shown, inline_page
from symoro_elastic.machine.described import DescribedMachine
from symoro_elastic.machine.restrict import restrict
from symoro_elastic.pages.drawing.page import ShownMachine, machine_page, page_frame, pages_beside, shown_machine
from symoro_elastic.pages.drawing.picture_files import write_picture
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
    """The page on which a machine, or several, move: one file that needs no network."""

    shown: ShownMachine
    others: tuple[ShownMachine, ...] = ()

    def beside(self, other: MachinePage) -> MachinePage:
        """Return the page of this machine and of the machines of another page, side by side."""
        return MachinePage(self.shown, (*self.others, other.shown, *other.others))

    @property
    def headline(self) -> str:
        """The machine, its modes and motions."""
        titles = " and ".join(page.figure.title for page in (self.shown, *self.others))
        return f"Page of {titles}: {sum(len(page.motions) for page in (self.shown, *self.others))} motions"

    @property
    def remarks(self) -> tuple[str, ...]:
        """Lines about parts that are omitted, or drawn differently."""
        every = (self.shown, *self.others)
        return tuple(line for page in every for line in (*page.remarks, *(x.remark for x in page.motions if x.remark)))

    @cached_property
    def html(self) -> str:
        """The page."""
        if not self.others:
            return machine_page(self.shown)
        pages = ((page.figure.title, machine_page(page)) for page in (self.shown, *self.others))
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
    full = the_machine(machine, options.values)
    return MachinePicture(machine_picture(restrict(full, SceneRequest().of(full, options.scene)), options.at))


@operation(Viewing)
def view(machine: MachineLike, options: Viewing) -> MachinePage:
    """Return the page on which a machine moves: a slider for each motor, its modes, the motions of a scene.

    Springs are in equilibrium at the position of the motors; the modes are those about it. Motions are simulated;
    where they cannot be their reference is shown, and `remarks` say why. Raises `InputError`.
    """
    full, scene, values = the_machine(machine), options.scene, options.values
    scene_machine = the_machine(restrict(full, SceneRequest().of(full, scene)), values)
    played = list(_motions_of(full, scene, values, options.announce, options.progress))
    return MachinePage(shown_machine(scene_machine, options.at, played))


def _motions_of(
    full: DescribedMachine, scene: SceneLike, values: Values, announce: Announce, progress: Progress
) -> Iterator[Played]:
    """Motions of a scene, simulated if possible."""
    if not motions_of_scene(full, scene).motions:
        return
    planned = plan(full, scene, Integrating(), values)
    for reference in planned.references:
        yield _simulated_motion(planned, reference, announce, progress)


def _simulated_motion(planned: Plan, reference: Reference, announce: Announce, progress: Progress) -> Played:
    """A simulated motion; its reference if simulation fails, with the reason."""
    from symoro_elastic.pages.drawing.motions import reference_motion, simulated_motion

    try:
        return simulated_motion(planned.run(reference, announce, progress))
    except InputError as error:
        return reference_motion(reference, f"{reference.prescribed.place}: the reference only: {error.what}")


@dataclass(frozen=True, repr=False)
class Report(Shown):
    """A page about a machine."""

    name: str
    html: str

    @property
    def headline(self) -> str:
        """Machine and size of the page."""
        return f"Report of {self.name}: {len(self.html) // 1000} kB"

    def _repr_html_(self) -> str:
        """Return the page in a frame of its own."""
        return inline_page(self.html)

    def write(self, folder: str | Path, *, force: bool = False) -> Path:
        """Write the page to a .html file, or to a folder as <machine name>.html, and return its path.

        Raises `InputError`.
        """
        with permission(force=force):
            return self.save(folder)

    def save(self, folder: str | Path) -> Path:
        """Write the page as `write` does, where files may be replaced as the command line says."""
        if Path(folder).suffix.lower() in PAGES:
            write_text(self.html, folder, "--out")
            return Path(folder)
        return write_all({f"{self.name}.html": self.html.encode("utf-8")}, Path(folder), "--out")[0]


@operation(Reporting)
def report(machine: MachineLike, options: Reporting) -> Report:
    """Return one page about a machine: picture, table, modes, responses, operations, accuracy, equations.

    With a scene that has [motion] and [wanted], what it requires of the model, too. What cannot be computed says why in
    its place. Raises `InputError` for machines and scenes that cannot be read.
    """
    from symoro_elastic.pages.report.sections import Subject, report_page

    full, scene = the_machine(machine, options.values), options.scene
    climbed = None
    if scene is not None:
        climbed = ladder(full, scene, announce=options.announce, progress=options.progress)
    scene_machine = restrict(full, SceneRequest().of(full, scene))
    return Report(full.name, report_page(Subject(scene_machine, climbed, options.announce, options.progress)))


def live(machine: str, options: Serving, ready: Callable[[str], None]) -> None:
    """Serve the page that follows a machine file until Ctrl+C; `ready` is called with its address.

    Raises `InputError` for a file of another kind, a port that is taken, and where the packages of the extra are
    missing.
    """
    import asyncio
    from contextlib import suppress

    from symoro_elastic.pages.live.handlers import serve

    form_of(machine, READABLE, "MACHINE")
    with suppress(KeyboardInterrupt):
        asyncio.run(serve(machine, options.port, ready))
