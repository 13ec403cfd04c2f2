"""The targets: each renders a package as file names and their texts."""

from __future__ import annotations

from collections.abc import Callable

from symoro_elastic.codegen.c import render_c
from symoro_elastic.codegen.described import Files
from symoro_elastic.codegen.package import Package
from symoro_elastic.codegen.python import render_numpy

TARGETS: dict[str, Callable[[Package], Files]] = {"numpy": render_numpy, "c": render_c}
