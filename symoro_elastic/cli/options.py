"""Options that several commands share, and records that commands take them as."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields
from functools import wraps
from typing import Any

import click

from symoro_elastic.cli.parsing import bound, numbers, parsed_by

Command = Callable[..., Any]

MACHINE = click.argument("machine", metavar="MACHINE", type=click.Path())
MODEL = click.option("--model", "models", metavar="NAME", multiple=True, help="Model to generate; may be repeated.")
FOLD = click.option(
    "--fold", metavar="NAME|all", multiple=True, help="Parameter to replace by its value; may be repeated."
)
ONLY = click.option(
    "--only",
    metavar="MODEL=NAME",
    multiple=True,
    help="Only this joint or frame of a model, as in 'jacobian=tool at (0.1, 0, L2) in base', or these columns of "
    "derivatives, as in 'direct_dynamics_parameter_derivatives by M1, K2'; may be repeated.",
)
BASE = click.option("--base", is_flag=True, help="Group the inertial parameters first.")
SCENE = click.option(
    "--scene", metavar="FILE", type=click.Path(), help="TOML file of models, outputs, constants and locked joints."
)
MERGE_ANGLES = click.option(
    "--merge-angles",
    metavar="BOUND",
    type=click.FloatRange(0, 1e6, min_open=True),
    callback=parsed_by(bound),
    help="Add angles of parallel axes where that saves operations; valid for |q| up to BOUND, rad.",
)
AT = click.option(
    "--at",
    "positions",
    metavar="JOINT=X",
    multiple=True,
    callback=parsed_by(numbers),
    help="Position of a motor, rad or m (default 0), or initial guess for another joint; may be repeated.",
)
VALUE = click.option(
    "--value",
    "values",
    metavar="NAME=X",
    multiple=True,
    callback=parsed_by(numbers),
    help="Value of a parameter; may be repeated.",
)
PLOTS = click.option("--plots", metavar="FOLDER", type=click.Path(), help="Draw plots into this folder.")
JSON = click.option("--json", "as_json", is_flag=True, help="Print the results as one JSON object.")


def gather(name: str, record: type[Any]) -> Callable[[Command], Command]:
    """Return a decorator that passes the options named as the fields of a dataclass as one argument."""

    def decorate(command: Command) -> Command:
        @wraps(command)
        def called(**options: Any) -> Any:
            own = {field.name: options.pop(field.name) for field in fields(record) if field.name in options}
            return command(**options, **{name: record(**own)})

        return called

    return decorate
