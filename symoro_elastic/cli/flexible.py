"""The command about finite-element bodies and flexible parts of machines: flexible."""

from __future__ import annotations

from typing import Any

import click

from symoro_elastic.api.options import CountingModes
from symoro_elastic.cli.listed import command
from symoro_elastic.cli.options import JSON, InputFile, OutputFile, call, takes, writes
from symoro_elastic.cli.output import print_result, steps
from symoro_elastic.foundation.errors import InputError

INTERFACES = click.option(
    "--interface",
    "interfaces",
    metavar="NAME=NODES",
    multiple=True,
    help="Nodes of an interface, averaged or NODES:rigid; becomes the row JOINT_NAME; may be repeated.",
)
RAILS = click.option(
    "--rail",
    "rails",
    metavar="NAME=NODES",
    multiple=True,
    help="Nodes of a strip on which a row slides, as along = JOINT_NAME of a machine; may be repeated.",
)
OF_MESH = "--fixed, --interface, --rail, --mass, --nodes or --save"


@command("flexible")
@click.argument("source", metavar="FILE", type=InputFile())
@click.option("--fixed", metavar="NODES", default="", help="Nodes that the joint holds: a set, z=0&x=0.1:0.5, 1-40,77.")
@INTERFACES
@RAILS
@click.option("--mass", metavar="FILE", type=InputFile(), help="Mass matrix of the stiffness FILE.")
@click.option("--nodes", metavar="FILE", type=InputFile(), help="Nodes of the matrices: lines of number, x, y, z.")
@click.option("--modes", metavar="N", type=int, default=6, help="Modes beside six for each interface (default: 6).")
@click.option(
    "--material", metavar="NAME", default="steel",
    help="Of a mesh: steel, cast-iron, aluminium, titanium, mineral-casting, or E,nu,density.",
)  # fmt: skip
@click.option("--scale", metavar="X", type=float, default=1.0, help="Coordinates times X are metres: 0.001 for mm.")
@click.option("--size", metavar="X", type=float, help="Largest element of a solid (.step), m (default: a tenth of it).")
@click.option("--mass-unit", metavar="UNIT", default="", help="Of matrices in mm: t (with N), or kg.")
@takes(CountingModes, "counting")
@click.option("--save", metavar="FILE", type=OutputFile((".npz",)), help="File of modes: .npz.")
@writes
@JSON
def flexible(
    source: str,
    counting: CountingModes,
    interfaces: tuple[str, ...],
    rails: tuple[str, ...],
    save: str | None,
    as_json: bool,
    **options: Any,
) -> None:
    """FILE is a mesh (extra fe), a solid (.step, extra step), a stiffness matrix with --mass and --nodes (Matrix
    Market, CalculiX, Nastran DMIG, Abaqus), or a file of modes, which is described. [flexible] of a machine names
    such a file. Of a machine file (.toml), show the errors that its numbers of joints and modes make, or how many
    are enough.
    """
    from symoro_elastic.api import flexible as operations
    from symoro_elastic.formats.modes_file import save as save_body

    is_machine = source.endswith(".toml")
    of_mesh = interfaces, rails, save, options["fixed"], options["mass"], options["nodes"]
    if any(of_mesh if is_machine else vars(counting).values()):
        other, names = ("a mesh", OF_MESH) if is_machine else ("a machine file (.toml)", "--frame, --at or --within")
        raise InputError("symoro-elastic", names, f"belongs to {other}: leave it out")
    if is_machine:
        with steps("vary joints and modes"):
            parts = call(operations.flexible_parts, source, counting)
        print_result(parts, as_json, None)
        return
    named = [_by_name(texts, option) for texts, option in ((interfaces, "--interface"), (rails, "--rail"))]
    with steps("reduce"):
        result = operations.flexible(source, interfaces=named[0], rails=named[1], **options)
    if save:
        save_body(result.body, save)
    print_result(result, as_json, save)


def _by_name(texts: tuple[str, ...], option: str) -> dict[str, str]:
    pairs = [text.partition("=") for text in texts]
    for name, equals, nodes in pairs:
        if not (name.isidentifier() and equals and nodes):
            raise InputError("symoro-elastic", option, f"{name!r} is no NAME=NODES, as tip=x=0.5")
    return {name: nodes for name, _, nodes in pairs}
