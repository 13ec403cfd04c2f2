"""Calls of generated C by all compilers that are installed: `python -m tests.benchmarks.compilers`.

The same text, at -O2 and -O3, with -march=native and without: how far each is from the fastest of its kind.
"""

from __future__ import annotations

import argparse
import itertools
import re
import shutil
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from symoro_elastic.machine.machine import Machine
from tests.benchmarks.contest import Array, Contestant, contest, difference
from tests.benchmarks.machines import arm_6, arm_7, elastic_arm, humanoid, rigid, two_axis, with_base_parameters
from tests.benchmarks.match import states
from tests.benchmarks.ours import NATIVE, Code, code, scalar
from tests.benchmarks.tables import print_table, progress, save_json

MODELS = ("inverse_dynamics", "direct_dynamics")
VERSIONS = [f"gcc-{k}" for k in range(12, 16)] + [f"clang-{k}" for k in range(14, 22)]
LEVELS = ("-O2", "-O3")
KINDS = {"-march=native": NATIVE, "any processor": ()}
WANTED = 1.2


@dataclass(frozen=True)
class Row:
    """Nanoseconds of a model of a machine on processors of a kind, by compiler and level."""

    machine: str
    model: str
    kind: str
    ns: dict[str, float]

    @property
    def worst(self) -> float:
        """The slowest over the fastest."""
        return max(self.ns.values()) / min(self.ns.values())


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m tests.benchmarks.compilers", description=__doc__)
    parser.add_argument("--rounds", type=int, default=101, help="rounds in which all take turns")
    parser.add_argument("--machine", nargs="*", help="machines, instead of five")
    parser.add_argument("--compiler", nargs="*", default=installed(), help="compilers, instead of all that are found")
    parser.add_argument("--json", type=Path, help="save the figures")
    arguments = parser.parse_args()
    wanted = list(itertools.product(arguments.machine or FIVE, MODELS))
    rows = [row for one in progress(wanted, "compile and time") for row in timed(*one, arguments)]
    for kind in KINDS:
        show(kind, [row for row in rows if row.kind == kind])
    if arguments.json:
        save_json(arguments.json, [vars(row) | {"worst": row.worst} for row in rows])


def installed() -> list[str]:
    """Compilers by version; those without a version in their names where there are no others."""
    found = [name for name in VERSIONS if shutil.which(name)]
    families = {re.split(r"-", name)[0] for name in found}
    return found + [name for name in ("gcc", "clang") if name not in families and shutil.which(name)]


def timed(machine: str, model: str, arguments: argparse.Namespace) -> Iterator[Row]:
    """All compilers take turns, after their numbers have been compared."""
    described, x = MACHINES[machine]()
    written = code(with_base_parameters(described), model)
    x = states(described, model) if x is None else x
    for kind, flags in KINDS.items():
        found = [
            compiled_by(compiler, level, flags, written, x)
            for compiler, level in itertools.product(arguments.compiler, LEVELS)
        ]
        wanted = found[0].results()
        assert all(difference(one.results(), wanted) < 1e-11 for one in found), (machine, model)
        times = contest(found, arguments.rounds)
        yield Row(machine, model, kind, {name: times.median(name) for name in times.names})


def compiled_by(compiler: str, level: str, flags: Sequence[str], written: Code, x: Array) -> Contestant:
    return scalar(written, x, f"{compiler} {level}", compiler, (*flags, level))


def show(kind: str, rows: Sequence[Row]) -> None:
    """A row a model of a machine, and the worst of all."""
    columns = list(rows[0].ns)
    cells = [
        [f"{row.machine}, {row.model}", *(f"{row.ns[name]:.1f}" for name in columns), f"{row.worst:.2f}"]
        for row in rows
    ]
    print_table(f"{kind}: ns a call, and the slowest over the fastest", ["", *columns, "worst"], cells)
    worst = max(row.worst for row in rows)
    print(f"{kind}: worst ratio {worst:.2f}, wanted {WANTED:g}\n")


@cache
def sr400() -> tuple[Machine, Array]:
    """The SR400 with its loop closed."""
    from tests.benchmarks import closed_chains
    from tests.closed_chains.machines import machine

    described = machine(closed_chains.SR400)
    return described, closed_chains.near(described).x


MACHINES: dict[str, Callable[[], tuple[Machine, Array | None]]] = {
    "two-axis machine, motors": lambda: (rigid(two_axis()), None),
    "6R arm": lambda: (arm_6(), None),
    "7R arm": lambda: (arm_7(), None),
    "elastic arm": lambda: (elastic_arm(), None),
    "SR400": sr400,
    "two-axis machine": lambda: (two_axis(), None),
    "humanoid, 29 joints": lambda: (humanoid(), None),
}
FIVE = list(MACHINES)[:5]


if __name__ == "__main__":
    main()
