"""Cost of commands on large machines: `python -m tests.benchmarks.commands [--joints 30 100] [--commands show ...]`.

Seconds of processor time, those of compilers included, and the most memory, of each command on chains, trees, chains
with springs and with couplings, with named parameters. The exponent is that of the power of n between the last two
sizes. Linear algebra runs on one thread, so that a busy machine changes little. Modules are compiled before, as they
are after an installation.
"""

from __future__ import annotations

import argparse
import compileall
import math
import os
import sys
import tempfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from symoro_elastic.formats import write_machine
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import Kind, Machine, Parameter, Spring
from tests.benchmarks.tables import print_table, progress, save_json
from tests.references.random_machines import chain, random_machine

STIFFER = 1e5
"""Factor on stiffnesses, under which a long chain does not buckle."""


def elastic(n: int) -> Machine:
    """A chain with a spring in every second joint."""
    made = chain(n, elastic=tuple(range(2, n + 1, 2)))
    stiff = [replace(p, value=_times(p, STIFFER)) if p.name[0] == "K" else p for p in made.parameters]
    return replace(made, parameters=tuple(stiff))


def coupled(n: int) -> Machine:
    """A chain in which every third joint follows the one before it, behind a ratio that is a parameter."""
    made = chain(n)
    rows, ratios = list(made.joints), []
    for j in range(3, n + 1, 3):
        ratios.append(Parameter(f"N{j}", Formula.parse(0.5)))
        follower = replace(rows[j - 1], kind=Kind.COUPLED, variable=None, spring=Spring())
        rows[j - 1] = follower.with_selected(Formula.parse(f"N{j}*q{j - 1}"))
    return replace(made, joints=tuple(rows), parameters=(*made.parameters, *ratios))


def tree(n: int) -> Machine:
    """A random tree of joints of all kinds."""
    return random_machine(3, joints=n, symbolic=True, friction=False, wrenches=False)


MACHINES: dict[str, Callable[[int], Machine]] = {"chain": chain, "tree": tree, "elastic": elastic, "coupled": coupled}
COMMANDS: dict[str, tuple[str, ...]] = {
    "show": (),
    "view": ("--out", "page.html", "--force"),
    "modes": ("--hold", "all"),
    "report": ("--out", "report.html", "--force"),
    "check": (),
    "generate": ("--target", "c", "--force"),
}
SIZES = (30, 100)


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m tests.benchmarks.commands", description=__doc__)
    parser.add_argument("--joints", type=int, nargs="+", default=SIZES)
    parser.add_argument("--commands", nargs="+", choices=COMMANDS, default=[*COMMANDS])
    parser.add_argument("--machines", nargs="+", choices=MACHINES, default=[*MACHINES])
    parser.add_argument("--json", type=Path, help="save the figures")
    asked = parser.parse_args()
    compileall.compile_dir("symoro_elastic", quiet=1)
    wanted = [(c, m, n) for c in asked.commands for m in asked.machines for n in asked.joints]
    found = {each: figures_of(*each) for each in progress(wanted, "run commands")}
    rows = [_row(c, m, asked.joints, found) for c in asked.commands for m in asked.machines]
    columns = ["command, machine", *(f"{n} joints" for n in asked.joints), "exponent"]
    print_table("Seconds of processor time, MB; (2): refused, with the reason", columns, rows)
    if asked.json:
        save_json(asked.json, {" ".join(map(str, key)): value for key, value in found.items()})


def figures_of(command: str, machine: str, n: int) -> tuple[float, float, int]:
    """Seconds, megabytes and exit code of a command on a machine of n joints."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "machine.toml"
        write_machine(replace(MACHINES[machine](n), name="machine"), file)
        words = [sys.executable, "-m", "symoro_elastic", command, str(file), *COMMANDS[command]]
        return _cost(words, folder)


def _cost(words: list[str], folder: str) -> tuple[float, float, int]:
    """The process is waited for by its number, so that its own memory is told, not that of the largest so far."""
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
    environment["PYTHONPATH"] = os.pathsep.join([str(Path.cwd()), environment.get("PYTHONPATH", "")])
    child = os.fork()
    if not child:
        os.chdir(folder)
        with open(os.devnull, "w") as nothing:
            os.dup2(nothing.fileno(), 1)
            os.dup2(nothing.fileno(), 2)
        os.execvpe(words[0], words, environment)
    _, status, used = os.wait4(child, 0)
    return used.ru_utime + used.ru_stime, used.ru_maxrss / 1024, os.waitstatus_to_exitcode(status)


def _row(
    command: str, machine: str, sizes: list[int], found: dict[tuple[str, str, int], tuple[float, float, int]]
) -> list[str]:
    cells = [found[command, machine, n] for n in sizes]
    told = [f"{s:.1f} s, {mb:.0f} MB" + f" ({code})" * bool(code) for s, mb, code in cells]
    if len(sizes) < 2:
        return [f"{command}, {machine}", *told, "-"]
    (first, *_), (last, *_) = cells[-2:]
    return [f"{command}, {machine}", *told, f"{math.log(last / first) / math.log(sizes[-1] / sizes[-2]):.1f}"]


def _times(parameter: Parameter, factor: float) -> Formula:
    assert parameter.value is not None
    return Formula.parse(float(f"{factor * parameter.value.value():.6g}"))


if __name__ == "__main__":
    main()
