"""Commands about a machine at one position, and its singular ones: evaluate, ik, stiffness, singularities."""

from __future__ import annotations

from symoro_elastic.api.options import Evaluating, Locating, Reaching, Reading, Yielding
from symoro_elastic.cli.listed import command
from symoro_elastic.cli.options import JSON, MACHINE, Plots, call, draws, takes, writes
from symoro_elastic.cli.output import print_result, steps
from symoro_elastic.cli.reading import read, read_for


@command("evaluate")
@MACHINE
@takes(Evaluating)
@takes(Reading, "reading", "base")
@draws
@writes
@JSON
def evaluate(machine: str, options: Evaluating, reading: Reading, plots: Plots, as_json: bool) -> None:
    """Give torques, accelerations, placements and what else models compute, with units."""
    from symoro_elastic.api import poses

    with steps("evaluate"):
        whole = read_for(options, machine, reading)
        result = call(poses.evaluate, whole, options)
    print_result(result, as_json)
    plots.write(result.plots)


@command("ik")
@MACHINE
@takes(Reaching)
@draws
@writes
@JSON
def ik(machine: str, options: Reaching, plots: Plots, as_json: bool) -> int:
    """Solve the inverse geometry within the limits of joints, from several starts and from closed forms.

    Springs stay neutral. Exit code 1 where no start reaches the pose.
    """
    from symoro_elastic.api import poses

    with steps("inverse geometry"):
        result = call(poses.ik, read(machine), options)
    print_result(result, as_json)
    plots.write(result.plots)
    return int(not result.solutions)


@command("stiffness")
@MACHINE
@takes(Yielding)
@draws
@writes
@JSON
def stiffness(machine: str, options: Yielding, plots: Plots, as_json: bool) -> None:
    """Give the 6 x 6 matrix with motors held, the worst direction, each spring's share, and what to stiffen."""
    from symoro_elastic.api import poses

    with steps("stiffness"):
        whole = read_for(options.scene, machine)
        result = call(poses.stiffness, whole, options)
    print_result(result, as_json)
    plots.write(result.plots)


@command("singularities")
@MACHINE
@takes(Locating)
@JSON
def singularities(machine: str, options: Locating, as_json: bool) -> None:
    """Print the determinant of the Jacobian of MACHINE's frame in factors.

    For each factor: where it vanishes, which joints are dependent there, and which motion is lost.
    """
    from symoro_elastic.api import poses

    with steps("factor"):
        result = call(poses.singularities, read(machine), options)
    print_result(result, as_json)
