"""The command singularities."""

from __future__ import annotations

import click

from symoro_elastic.api.options import Locating
from symoro_elastic.cli.options import JSON, MACHINE, call, takes
from symoro_elastic.cli.output import print_result, steps
from symoro_elastic.cli.reading import read


@click.command()
@MACHINE
@takes(Locating)
@JSON
def singularities(machine: str, options: Locating, as_json: bool) -> None:
    """Find where a frame loses a direction of motion.

    Prints the determinant of the Jacobian of MACHINE's frame in factors, and for each factor where it vanishes, which
    joints then move the frame alike, and which motion is lost.
    """
    from symoro_elastic.api import kinematics

    with steps() as step:
        step("factor")
        found = call(kinematics.singularities, read(machine), options)
    print_result(found, as_json)
