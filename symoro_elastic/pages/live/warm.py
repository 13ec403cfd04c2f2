"""Computes all parts of a small machine on import, so that forked processes have all late imports."""

from __future__ import annotations

from symoro_elastic.foundation.input_files import examples, read_file
from symoro_elastic.pages.live.parts import equations_of_file, parts_of_file

SMALL = str(examples(scenes=False)["planar_2r"])

CONTENT = read_file(SMALL)
PARTS = [*parts_of_file(SMALL, CONTENT), *equations_of_file(SMALL, CONTENT, "inertia_matrix")]
