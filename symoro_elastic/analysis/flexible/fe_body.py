"""A body by modes as a result: its frequencies, and the compliance of its interfaces."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from symoro_elastic.formats.modes_file import ModalBody, save
from symoro_elastic.foundation.output_files import permission
from symoro_elastic.foundation.results import Result


@dataclass(frozen=True, repr=False)
class FlexibleModes(Result):
    """The body of a file of modes, or of a finite-element model that was reduced to one."""

    source: str
    body: ModalBody

    @property
    def headline(self) -> str:
        """Where it comes from, its mass and its first frequency."""
        about = f" ({self.body.about})" if self.body.about else ""
        count = f"{self.body.count} mode{'s' * (self.body.count > 1)}"
        return f"{self.source}{about}: {self.body.rigid[0]:.6g} kg, {count}, the first at {self.first:.5g} Hz"

    @property
    def first(self) -> float:
        """The lowest frequency with the joint held, Hz."""
        return float(self.body.frequencies.min())

    def write(self, file: str | Path, *, force: bool = False) -> Path:
        """Write the body to a .npz file, which `[flexible]` of a machine names; raises `InputError` if it exists."""
        with permission(force=force):
            save(self.body, file)
        return Path(file)
