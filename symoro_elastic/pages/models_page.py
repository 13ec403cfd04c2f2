"""The reference of all models and of their quantities: as Markdown, as lines for the terminal, as plain data."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator
from itertools import groupby
from typing import Any

from symoro_elastic.codegen.package_context import SINGULAR
from symoro_elastic.models.programs.catalogue import MODELS, Model
from symoro_elastic.quantities import INTERMEDIATES, MOTION

HEAD = """# Models

Of every model of a machine: arguments, results with shapes, frames and units, and the equations of the paper. Generated
numpy functions and C functions have these names, `load(machine, "inertia_matrix")` loads them into Python, and
`generate --model NAME` writes them.
"""
QUANTITIES = """## Quantities in generated code

Names of intermediate quantities, as in `K5_33`: the letters of the quantity, the number of the row in the table of
geometric parameters, the entry.
"""

NOTES = (
    "n joints that move, m motors, so n - m elastic and passive joints; s static joints; frames: all rows of the "
    "table, or those a scene asks for ('tool at (0.1, 0, L2)' is a point in axes of tool, m)",
    "'tool in ram': geometric_model gives the placement of tool relative to ram; velocities, accelerations, jacobian "
    "and jacobian_dot_qd give its motion relative to frame 0, with components along the axes of ram",
    "inverse models: a target that is out of reach by more than rounding (1e-12) has no solution, so that fewer joints "
    "than it has degrees of freedom (6, or 3 for a position) need a target of 12 digits",
    "y ...: y and as many derivatives by time as the chain needs: yd, ydd, yddd ...",
    f"where a model solves for accelerations: {SINGULAR}, and so are their derivatives",
)


def models_page() -> str:
    """Return the page of all models, with their arguments and results, as Markdown."""
    families = groupby(sorted(MODELS.values(), key=lambda model: model.family), key=lambda model: model.family)
    parts = [HEAD, *(f"- {note}" for note in NOTES)]
    for family, models in families:
        parts += ["", f"## {family[:1].upper()}{family[1:]}", ""]
        for model in models:
            parts += [*_model(model), ""]
    return "\n".join([*parts, QUANTITIES, *_quantities(), ""])


def _model(model: Model) -> Iterator[str]:
    equations = f" {model.equations}" if model.equations else ""
    yield f"### `{model.name}`"
    yield ""
    yield f"{model.title}{equations}."
    yield ""
    yield "| | | shape | |"
    yield "|---|---|---|---|"
    for kind, names in (("argument", model.arguments), ("result", model.results)):
        for name in names:
            row = model.quantity(name)
            yield f"| {kind} | `{name}` | {row.shape} | {_cell(row.sentence)} |"


def _quantities() -> Iterator[str]:
    yield "| name | quantity | equations |"
    yield "|---|---|---|"
    for row in INTERMEDIATES:
        yield f"| `{row.name}` | {_cell(row.meaning)} | {_cell(', '.join(f'[{e}]' for e in row.equations))} |"


def _cell(text: str) -> str:
    return text.replace("|", "\\|")


def catalogue_json() -> dict[str, Any]:
    """Return every model: its family, arguments and results with shape and meaning, equations."""
    return {
        "models": {
            model.name: {
                "title": model.title,
                "family": model.family,
                "equations": model.equations,
                "arguments": {name: _description(model, name) for name in model.arguments},
                "results": {name: _description(model, name) for name in model.results},
            }
            for model in MODELS.values()
        },
        "notes": list(NOTES),
    }


def _description(model: Model, name: str) -> list[str]:
    """Shape and meaning of an argument or result."""
    row = model.quantity(name)
    return [row.shape, row.sentence]


def catalogue_lines(width: int) -> list[str]:
    """Return every model with its arguments and equations, then a line or two for each of its results."""
    rows = [(name, *_description(model, name)) for model in MODELS.values() for name in model.results]
    names, shapes = (max(len(row[k]) for row in rows) for k in (0, 1))
    lines = []
    for model in MODELS.values():
        lines.append(f"{model.name} of {_shown_arguments(model)} {model.equations}".rstrip())
        for name in model.results:
            shape, meaning = _description(model, name)
            head = f"  {name:{names}}  {shape:{shapes}}  "
            lines += textwrap.wrap(head + meaning, width, subsequent_indent=" " * len(head), break_on_hyphens=False)
    return lines


def _shown_arguments(model: Model) -> str:
    wanted = {row.name for row in MOTION}
    names = [name for name in model.arguments if name not in wanted]
    return ", ".join([*names, *(["y ..."] if len(names) < len(model.arguments) else [])]) or "p"
