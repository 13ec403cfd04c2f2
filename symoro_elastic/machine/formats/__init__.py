"""Machine files: TOML, and the .par files of SYMORO."""

from symoro_elastic.machine.formats.reading import read_machine, write_machine
from symoro_elastic.machine.formats.scenes import read_scene

__all__ = ["read_machine", "read_scene", "write_machine"]
