"""Machine files: TOML, and the .par files of SYMORO."""

from symoro_elastic.machine.formats.format import Format
from symoro_elastic.machine.formats.motions import read_motions, read_wanted
from symoro_elastic.machine.formats.reading import FORMATS, read_machine, write_machine
from symoro_elastic.machine.formats.scenes import read_scene

__all__ = ["FORMATS", "Format", "read_machine", "read_motions", "read_scene", "read_wanted", "write_machine"]
