"""Options that several commands share."""

from __future__ import annotations

import click

MACHINE = click.argument("machine", metavar="MACHINE", type=click.Path())
MODEL = click.option("--model", "models", metavar="NAME", multiple=True, help="Model to make; may be repeated.")
FOLD = click.option("--fold", metavar="NAME|all", multiple=True, help="Parameter to make a constant; may be repeated.")
BASE = click.option("--base", is_flag=True, help="Group the inertial parameters first.")
SCENE = click.option(
    "--scene", metavar="FILE", type=click.Path(), help="TOML file saying what is asked of the machine."
)
JSON = click.option("--json", "as_json", is_flag=True, help="Print figures as one JSON object.")
