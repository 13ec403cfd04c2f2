"""Options that several commands share."""

from __future__ import annotations

import click

MACHINE = click.argument("machine", metavar="MACHINE", type=click.Path())
MODEL = click.option("--model", "models", metavar="NAME", multiple=True, help="Model to make; may be repeated.")
FOLD = click.option("--fold", metavar="NAME|all", multiple=True, help="Parameter to make a constant; may be repeated.")
ONLY = click.option(
    "--only",
    metavar="MODEL=NAME",
    multiple=True,
    help="Joint or frame that a model is to give, and no other: 'jacobian=tool at (0.1, 0, L2) in base'; columns of "
    "derivatives: 'direct_dynamics_parameter_derivatives by M1, K2'; may be repeated.",
)
BASE = click.option("--base", is_flag=True, help="Group the inertial parameters first.")
SCENE = click.option(
    "--scene", metavar="FILE", type=click.Path(), help="TOML file saying what is asked of the machine."
)
MERGE_ANGLES = click.option(
    "--merge-angles",
    metavar="BOUND",
    type=click.FloatRange(0, 1e6, min_open=True),
    help="Sum angles of parallel axes where that saves operations; good for |q| up to BOUND, rad.",
)
JSON = click.option("--json", "as_json", is_flag=True, help="Print figures as one JSON object.")
