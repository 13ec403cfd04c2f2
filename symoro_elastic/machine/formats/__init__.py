"""Machine files: TOML, and the .par files of SYMORO."""

from symoro_elastic.machine.formats.format import Format
from symoro_elastic.machine.formats.reading import FORMATS, read_machine, write_machine
from symoro_elastic.machine.formats.scenes import read_scene

__all__ = ["FORMATS", "Format", "read_machine", "read_scene", "write_machine"]
