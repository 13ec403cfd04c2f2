"""Pages about machines: report."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from symoro_elastic.api.machines import NO_VALUES, MachineLike, Values, the_machine
from symoro_elastic.api.motions import ladder
from symoro_elastic.api.scenes import Asked, SceneLike
from symoro_elastic.machine.restrict import restricted
from symoro_elastic.output_files import permission, write_all
from symoro_elastic.progress import Announce, Progress, announce_nothing, no_progress
from symoro_elastic.results import Shown, framed


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
        return framed(self.html)

    def write(self, folder: str | Path, *, force: bool = False) -> Path:
        """Write the page to a folder as <machine name>.html, and return its path; raises `InputError`."""
        with permission(force=force):
            return self.save(folder)

    def save(self, folder: str | Path) -> Path:
        """Write the page as `write` does, where files may be replaced as the command line says."""
        return write_all({f"{self.name}.html": self.html.encode("utf-8")}, Path(folder), "--out")[0]


def report(
    machine: MachineLike,
    scene: SceneLike = None,
    *,
    values: Values = NO_VALUES,
    announce: Announce = announce_nothing,
    progress: Progress = no_progress,
) -> Report:
    """Return one page about a machine: picture, table, modes, responses, operations, accuracy, equations.

    With a scene that has [motion] and [wanted], what it requires of the model, too. What cannot be computed says why in
    its place. Raises `InputError` for machines and scenes that cannot be read.
    """
    from symoro_elastic.machine_report.page import report_page
    from symoro_elastic.machine_report.sections import Subject

    whole = the_machine(machine, values)
    climbed = None
    if scene is not None:
        climbed = ladder(whole, scene, announce=announce, progress=progress)
    kept = restricted(whole, Asked().of(whole, scene))
    return Report(whole.name, report_page(Subject(kept, climbed, announce, progress)))
