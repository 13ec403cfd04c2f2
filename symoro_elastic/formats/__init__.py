"""Machine files: TOML, the .par files of SYMORO, robots in URDF, MJCF and tables."""

from symoro_elastic.formats.format import Format
from symoro_elastic.formats.reading import FORMATS, read_machine, write_machine
from symoro_elastic.formats.toml.motions import read_motions, read_wanted
from symoro_elastic.formats.toml.reading import read_scene

__all__ = ["FORMATS", "Format", "read_machine", "read_motions", "read_scene", "read_wanted", "write_machine"]
