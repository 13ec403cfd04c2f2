"""Equations of a machine in a page: written out where they are short, else step by step, symbols linked."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from symoro_elastic.codegen.templates import render
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.scene import Scene
from symoro_elastic.machine_report.section import folded, paragraph
from symoro_elastic.pipeline import programs
from symoro_elastic.reports.page import HTML, content

TEXTBOOK = ("inertia_matrix", "bias_forces")
MOST_LINES = 24
RECURSIONS = ("inverse_dynamics", "direct_dynamics")


def equation_blocks(machine: Machine) -> Iterator[str]:
    """Return A(q) and H(q, qd) written out where they are short, and the recursions step by step."""
    textbook = [_content(machine, name) for name in TEXTBOOK]
    if all(one["short"] for one in textbook) and sum(len(one["short"]) for one in textbook) <= MOST_LINES:
        yield paragraph("A(q) qdd + H(q, qd) = the torques of motors, springs and dampers:")
        yield from (render("html/written_out.html.j2", **one) for one in textbook)
    else:
        yield paragraph("A(q) and H(q, qd) are long for this machine, and computed step by step.")
    for name in (*TEXTBOOK, *RECURSIONS):
        one = _content(machine, name)
        yield folded(one["title"], [render("html/equation_parts.html.j2", **one)])


def _content(machine: Machine, model: str) -> dict[str, Any]:
    package = programs(machine, Scene(models=(model,))).package
    return content(package, package.functions[0], HTML, prefix=f"{model}-")
