"""How near certificates are, and whether any is exceeded: machines attacked at drawn states, corners, and by climbing.

    python -m tests.benchmarks.certificates [--states 1000000] [--machines NAME ...] [--sub-boxes 64] [--polynomials]
        [--held-out] [--form inertia] [--boxes ...] [--models ...]
    OPENBLAS_NUM_THREADS=1 python -m tests.benchmarks.certificates --within
    OPENBLAS_NUM_THREADS=1 python -m tests.benchmarks.certificates --reduced [--held-out] [--states 100000]

Each machine has its models certified in double and single precision, in its whole box (full turns, 0.4 m, 2 rad/s,
5 rad/s2, 50 N m; springs bent by 0.01 rad or 2 mm) and in a moderate one (a fifth of it). A row says how many results
have a proven error, how many times it is above the worst error that was found (least, median, largest), the same of the
95 % bound, and the time of the certificate; where a result has no proven error, what is said instead. A table by class
of machine ends it. More than 20 000 states are computed by generated C, beside C in a wider type. Bounds that are
exceeded are listed as they are found, and the run fails.

`--within` says what a search for terms that may be left out takes, in seconds of one processor: looking for them and
climbing to the worst states (search), bounds on all states (proof), and a million states that no search has seen.

`--reduced` attacks models with terms left out, and measures what structure they keep (`reduced_models.py`).
"""

from __future__ import annotations

import argparse
import itertools
import math
import re
import time
from collections import defaultdict
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import TypeAlias

import numpy as np

import symoro_elastic as se
from symoro_elastic.codegen.precision import PRECISIONS
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.generation.pipeline import certificates, prepare_machine, programs
from symoro_elastic.generation.reduced_models.search import reduced_models
from symoro_elastic.machine.described import DescribedMachine
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.scene import INERTIA, RECURSION, Scene
from symoro_elastic.machine.within import ALL_RESULTS, Evidence, Keep, Within
from symoro_elastic.machine.within import tolerance as tolerance_of
from symoro_elastic.numerics.evaluation.values import parameter_values
from symoro_elastic.numerics.guarantees.certificate import Certificate
from symoro_elastic.numerics.guarantees.certificates import Effort
from symoro_elastic.numerics.guarantees.header import divisors, overflow
from symoro_elastic.numerics.guarantees.running_error import ROUNDINGS
from tests.benchmarks.attack_in_c import attack_in_c
from tests.benchmarks.reduced_models import attack_reduced
from tests.closed_chains.machines import FILES
from tests.closed_chains.machines import machine as closed_machine
from tests.numerics.guarantees.attack import ROUNDED, SLACK, Attack, Worst, results_as_printed
from tests.numerics.guarantees.boxes import limits_of_test
from tests.references.random_machines import chain, random_machine, two_children

EXAMPLES = Path(__file__).parents[2] / "examples"
MODELS = ("inverse_dynamics", "direct_dynamics", "inertia_matrix")
BOXES = {"whole": 1.0, "moderate": 0.2}
DRAWN_AT_ONCE = 20_000
LOOPS_OF_EXAMPLES = ("closed_chain", "four_bar", "gantry", "sr400", "slider_crank", "geared_6r")
CLOSED = ("geared_6r", "gantry", "sr400", "five_bar", "palletizer", "coupled_wrist")
"""Of the held-out machines."""
Counts: TypeAlias = tuple[int, int]
SEARCHED = (
    ("puma560_measured.toml", "inverse_dynamics", "1 %", "proven"),
    ("puma560_measured.toml", "inverse_dynamics", "0.3 %", "proven"),
    ("puma560_measured.toml", "inverse_dynamics", "1 %", "confident"),
    ("rx90.par", "inverse_dynamics", "1 %", "confident"),
    ("two_axis.toml", "direct_dynamics", "0.1 %", "proven"),
    ("ball_screw.toml", "direct_dynamics", "1 %", "proven"),
    ("flex4.par", "direct_dynamics", "1 %", "confident"),
    ("sr400.par", "inverse_dynamics", "1 %", "confident"),
    ("gantry.toml", "direct_dynamics", "1 %", "confident"),
    ("puma560_measured.toml", "direct_dynamics", "1 %", "confident"),
)
"""Machine, model, tolerance and guarantee of searches that are timed."""
GROUPED = ("puma560_measured.toml", "rx90.par")
"""Whose base parameters are used."""


def machines() -> Iterator[tuple[str, Machine]]:
    """Examples, machines with couplings and loops, random trees and chains."""
    for path in sorted(EXAMPLES.glob("*.*")):
        if path.suffix in (".toml", ".par") and "all_keys" not in path.stem:
            machine = se.read(path)
            if machine.floating is None and not machine.forces:
                yield path.stem, with_values(machine)
    yield from ((f"{name} (loops)", closed_machine(name)) for name in FILES)
    yield from ((f"tree {seed}", random_machine(seed, joints=6)) for seed in range(8))
    yield from ((f"arm {seed}", random_machine(seed, joints=5, kinds=("motor",), prismatic=0)) for seed in range(4))
    yield "chain 6", chain(6, symbolic=False)
    yield "elastic chain 6", chain(6, elastic=(2, 4, 6), symbolic=False)
    yield "two children", two_children()


def with_values(machine: Machine) -> Machine:
    """The machine with a value for every parameter, drawn where the file gives none."""
    values = parameter_values(machine)
    parameters = tuple(replace(p, value=p.value or Formula.parse(values[p.name])) for p in machine.parameters)
    return replace(machine, parameters=parameters)


def held_out() -> Iterator[tuple[str, Machine]]:
    """Machines that no bound was tuned on: arms, trees, elastic, geared and closed ones."""
    arms = (random_machine(seed, joints=n, kinds=("motor",), prismatic=0) for seed, n in ((201, 6), (202, 4), (203, 3)))
    yield from ((f"arm {k}", one) for k, one in enumerate(arms))
    yield from ((f"tree {seed}", random_machine(seed, joints=6)) for seed in (101, 102, 103))
    yield "elastic chain 5", chain(5, elastic=(1, 3, 5), symbolic=False)
    yield "elastic axis 4", chain(4, elastic=(2, 4), prismatic=(1, 3), symbolic=False)
    elastic = (random_machine(seed, joints=5, kinds=("motor", "elastic")) for seed in (301, 302))
    yield from ((f"elastic tree {k}", one) for k, one in enumerate(elastic))
    yield from ((f"{name} (loops)", with_values(closed_machine(name))) for name in CLOSED)


def attacked(machine: Machine, model: str, found: Certificate, states: int, form: str = RECURSION) -> Worst:
    """The worst of drawn states and of climbing; of more than `DRAWN_AT_ONCE` in C, of generated code."""
    package = programs(machine, Scene(models=(model,), form=form)).package
    attack = Attack(results_as_printed(package.functions[0].program), found.box, found.precision)
    worst = attack.run(min(states, DRAWN_AT_ONCE))
    if states <= DRAWN_AT_ONCE:
        return worst
    more = attack_in_c(package, model, found.box, found.precision, states)
    return Worst(
        np.maximum(worst.error, more.error), np.minimum(worst.low, more.low), np.maximum(worst.high, more.high)
    )


def exceeded(found: Certificate, worst: Worst) -> list[str]:
    """The entries whose error or range is beyond what was proven, and what the reference may be off."""
    slack, rounded = 1 + SLACK[found.precision], ROUNDED[found.precision]
    return [
        f"{entry.name}[{entry.entry}]: {error:.3g} > {entry.error:.3g}, {low:.6g} to {high:.6g}"
        for entry, error, low, high in zip(found.entries, worst.error, worst.low, worst.high, strict=True)
        if not (math.isinf(entry.error) or error <= entry.error * slack + rounded * entry.magnitude)
        or not (math.isinf(entry.magnitude) or (entry.low <= low and high <= entry.high))
    ]


def ratios(bounds: list[float], worst: Worst) -> list[float]:
    """Ratios of finite bounds to what was found, where anything was."""
    return [b / e for b, e in zip(bounds, worst.error, strict=True) if e > 0 and math.isfinite(b)]


def least_median_largest(found: list[float]) -> str:
    return f"{min(found):.2g} / {np.median(found):.2g} / {max(found):.2g}" if found else "-"


def class_of(name: str) -> str:
    """What kind of machine it is, as the table at the end has it."""
    if name.endswith("(loops)") or name in LOOPS_OF_EXAMPLES:
        return "coupled and closed"
    if name.startswith("tree"):
        return "random trees"
    if name.startswith(("arm", "chain", "two children")) or "puma" in name or name == "planar_2r":
        return "arms"
    return "elastic and machine tools"


def print_table(
    rows: Mapping[tuple[str, str, str], list[list[float]]], results: Mapping[tuple[str, str, str], Counts]
) -> None:
    """Least, median and largest ratio by class, model and box, and how many results have a proven error."""
    print("\n| machines | model | box | proven | least / median / largest |\n|---|---|---|---|---|")
    for key in sorted(rows):
        proven, of = results[key]
        flat = [x for row in rows[key] for x in row]
        print(f"| {' | '.join(key)} | {proven} of {of} | {least_median_largest(flat)} |")


class Stages:
    """Processor times of the stages of a search, as it announces them."""

    def __init__(self) -> None:
        self.seconds: defaultdict[str, float] = defaultdict(float)
        self._stage, self._began = "", time.process_time()

    def begin(self, stage: str) -> None:
        now = time.process_time()
        self.seconds[re.split("[,:]", self._stage)[0]] += now - self._began
        self._stage, self._began = stage, now


def print_searches() -> None:
    """What each search takes, in the limits of the file or else of these tests."""
    print("machine, model, tolerance, guarantee | operations, whole | left | search, s | proof, s | unseen, s")
    for name, model, tolerance, guaranteed in SEARCHED:
        machine = DescribedMachine.of(with_values(se.read(EXAMPLES / name)))
        machine = machine if machine.limits else replace(machine, limits=limits_of_test(machine))
        within = Within({ALL_RESULTS: tolerance_of(tolerance)}, Keep.TERMS, Evidence(guaranteed))
        stages = Stages()
        scene = Scene((model,), within=within)
        base = prepare_machine(machine, lambda line: None, base=name in GROUPED)
        _, (found,) = reduced_models(base, scene, programs, [ROUNDINGS["double"]], announce=stages.begin)
        stages.begin("")
        whole, left = found.operations
        times = " | ".join(f"{stages.seconds[stage]:.1f}" for stage in ("leave out", "prove", "look at unseen states"))
        print(f"{name}, {model}, {tolerance}, {guaranteed} | {whole} | {left} | {times}", flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--states", type=int, default=20_000)
    parser.add_argument("--sub-boxes", type=int, default=64)
    parser.add_argument("--machines", nargs="*", default=[])
    parser.add_argument("--polynomials", action="store_true")
    parser.add_argument("--held-out", action="store_true", help="machines that no bound was tuned on")
    parser.add_argument("--boxes", nargs="*", default=[*BOXES])
    parser.add_argument("--models", nargs="*", default=[*MODELS])
    parser.add_argument("--form", choices=(RECURSION, INERTIA), default=RECURSION, help="of direct models")
    parser.add_argument("--within", action="store_true", help="time searches for terms that may be left out")
    parser.add_argument("--reduced", action="store_true", help="attack models with terms left out")
    options = parser.parse_args()
    if options.within:
        print_searches()
        return
    if options.reduced:
        asked = held_out() if options.held_out else machines()
        broken = sum(attack_reduced(asked, options.machines, BOXES[box], options.states) for box in options.boxes[:1])
        if broken:
            raise SystemExit(f"{broken} reduced models break what is said of them")
        return
    effort = Effort(options.sub_boxes, polynomials=options.polynomials)
    rows: dict[tuple[str, str, str], list[list[float]]] = {}
    counts: dict[tuple[str, str, str], Counts] = {}
    holes = 0
    print("machine, model, precision, box | finite | proven/found | likely/found | s")
    for name, whole in held_out() if options.held_out else machines():
        if options.machines and name not in options.machines:
            continue
        for box, model, precision in itertools.product(options.boxes, options.models, ("double", "single")):
            machine = replace(DescribedMachine.of(whole), limits=limits_of_test(whole, BOXES[box]))
            began = time.process_time()
            try:
                made = certificates(machine, Scene(models=(model,), form=options.form), [PRECISIONS[precision]], effort)
            except InputError as error:
                print(f"{name}, {model}: {error}", flush=True)
                continue
            (found,) = made.certificates
            took = time.process_time() - began
            worst = attacked(machine, model, found, options.states, options.form)
            if wrong := exceeded(found, worst):
                holes += 1
                print(f"EXCEEDED: {name}, {model}, {precision}, {box}: {wrong}", flush=True)
            finite = sum(math.isfinite(entry.error) for entry in found.entries)
            proven, likely = (ratios([getattr(e, key) for e in found.entries], worst) for key in ("error", "likely"))
            key = class_of(name), model, box
            rows.setdefault(key, []).append(proven)
            before = counts.get(key, (0, 0))
            counts[key] = before[0] + finite, before[1] + len(found.entries)
            said = "" if finite == len(found.entries) else f" | {divisors(found)}; {overflow(found)}"
            print(
                f"{name}, {model}, {precision}, {box} | {finite}/{len(found.entries)} | "
                f"{least_median_largest(proven)} | {least_median_largest(likely)} | {took:.1f}{said}",
                flush=True,
            )
    print_table(rows, counts)
    if holes:
        raise SystemExit(f"{holes} certificates were exceeded")


if __name__ == "__main__":
    main()
