"""Computes all parts of a small machine when it is imported: what they import late is there in forked processes."""

from __future__ import annotations

from symoro_elastic.formats.files import load_text
from symoro_elastic.foundation.shipped import examples
from symoro_elastic.pages.live.parts import equations_of_file, parts_of_file

SMALL = str(examples(scenes=False)["planar_2r"])

PARTS = [*parts_of_file(SMALL, load_text(SMALL)), *equations_of_file(SMALL, "inertia_matrix")]
