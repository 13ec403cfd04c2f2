"""The machine and the scene on a command line."""

from __future__ import annotations

from typing import TYPE_CHECKING

from symoro_elastic.api.options import Reading, Requested
from symoro_elastic.cli.output import say
from symoro_elastic.foundation.progress import Announce, announce_nothing

if TYPE_CHECKING:
    from symoro_elastic.api.rows import SceneLike
    from symoro_elastic.machine.described import DescribedMachine
    from symoro_elastic.machine.scene import Scene

AS_WRITTEN = Reading()


def read(path: str, reading: Reading = AS_WRITTEN, announce: Announce = announce_nothing) -> DescribedMachine:
    """Return the machine of a file; its warnings are printed on stderr."""
    from symoro_elastic.api.machines import prepared

    return prepared(path, reading, warn, announce)


def warn(line: str) -> None:
    """Print a warning on stderr."""
    say(f"warning: {line}")


def scene_of(machine: DescribedMachine, options: Requested | SceneLike = None) -> Scene:
    """Return the scene of options or of a file, else that of the machine.

    Springs in series that the scene condenses are named on stderr.
    """
    from symoro_elastic.api.scenes import scene_for

    requested = options if isinstance(options, Requested) else Requested(scene=options)
    return scene_for(machine, requested, note=note)


def read_for(scene: Requested | SceneLike, path: str, reading: Reading = AS_WRITTEN) -> DescribedMachine:
    """Return the machine of a file, as `read` does; notes about this scene of it are printed, too."""
    machine = read(path, reading)
    scene_of(machine, scene)
    return machine


def note(line: str) -> None:
    """Print a note on stderr."""
    say(f"note: {line}")
