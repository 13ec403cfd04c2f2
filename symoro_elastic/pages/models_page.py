"""The reference of all models and of their quantities, as Markdown."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import groupby

from symoro_elastic.models.programs.catalogue import MODELS, Model
from symoro_elastic.pages.show import NOTES
from symoro_elastic.quantities import INTERMEDIATES

HEAD = """# Models

Of every model of a machine: arguments, results with shapes, frames and units, and the equations of the paper. Generated
numpy functions and C functions have these names, `load(machine, "inertia_matrix")` loads them into Python, and
`generate --model NAME` writes them.
"""
QUANTITIES = """## Quantities in generated code

Names of intermediate quantities, as in `K5_33`: the letters of the quantity, the number of the row in the table of
geometric parameters, the entry.
"""


def models_page() -> str:
    """Return the page."""
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
