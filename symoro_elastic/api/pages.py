"""Pages about machines: report, live."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from symoro_elastic.api.declaration import operation
from symoro_elastic.api.machines import the_machine
from symoro_elastic.api.motions import ladder
from symoro_elastic.api.options import Reporting, Serving
from symoro_elastic.api.rows import READABLE, MachineLike
from symoro_elastic.api.scenes import SceneRequest
from symoro_elastic.foundation.file_forms import PAGES, form_of
from symoro_elastic.foundation.output_files import permission, write_all, write_text
from symoro_elastic.foundation.results import Shown, inline_page
from symoro_elastic.machine.restrict import restrict


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

    whole, scene = the_machine(machine, options.values), options.scene
    climbed = None
    if scene is not None:
        climbed = ladder(whole, scene, announce=options.announce, progress=options.progress)
    kept = restrict(whole, SceneRequest().of(whole, scene))
    return Report(whole.name, report_page(Subject(kept, climbed, options.announce, options.progress)))


def live(machine: str, options: Serving, ready: Callable[[str], None]) -> None:
    """Serve the page that follows a machine file until Ctrl+C; `ready` is called with its address.

    Raises `InputError` for a file of another kind, a port that is taken, and where the packages of the extra are
    missing.
    """
    import asyncio
    from contextlib import suppress

    from symoro_elastic.pages.live.server import serve

    form_of(machine, READABLE, "MACHINE")
    with suppress(KeyboardInterrupt):
        asyncio.run(serve(machine, options.port, ready))
