"""The command singularities."""

from __future__ import annotations

from symoro_elastic.api.options import Locating
from symoro_elastic.cli.listed import command
from symoro_elastic.cli.options import JSON, MACHINE, call, takes
from symoro_elastic.cli.output import print_result, steps
from symoro_elastic.cli.reading import read


@command("singularities")
@MACHINE
@takes(Locating)
@JSON
def singularities(machine: str, options: Locating, as_json: bool) -> None:
    """Print the determinant of the Jacobian of MACHINE's frame in factors.

    For each factor: where it vanishes, which joints are dependent there, and which motion is lost.
    """
    from symoro_elastic.api import kinematics

    with steps("factor"):
        result = call(kinematics.singularities, read(machine), options)
    print_result(result, as_json)
