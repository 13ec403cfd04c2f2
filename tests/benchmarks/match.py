"""A model of a machine, computed by all who can: the same numbers first, then times."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from importlib.util import find_spec

import numpy as np

from symoro_elastic.machine.machine import Kind, Machine
from tests.benchmarks.contest import Array, Contestant, Times, contest, difference
from tests.benchmarks.peers.headers import eigen
from tests.benchmarks.tables import print_table
from tests.benchmarks.targets import Figures

STATES = 64


@dataclass(frozen=True)
class Match:
    """A model of a machine: times of all who compute it, and how far their numbers are from Pinocchio's.

    `operations` are products and sums by contestant, `sines` the sines and cosines beside them.
    """

    machine: str
    model: str
    times: Times
    differences: dict[str, float]
    operations: dict[str, int]
    sines: int = 0

    @property
    def reference(self) -> str:
        """The fastest build of Pinocchio, to which all are compared."""
        return min(builds_of(self.times.names), key=self.times.median)

    def figures(self) -> Iterator[dict[str, str | float]]:
        for name, apart in self.differences.items():
            yield {
                "machine": self.machine,
                "model": self.model,
                "contestant": name,
                "ns": self.times.median(name),
                "ratio": self.times.ratio(self.reference, name),
                "difference": apart,
                "operations": self.operations.get(name, 0),
                "sines": self.sines,
            }


def builds_of(names: Sequence[str]) -> list[str]:
    """Return the names of the builds of the peer that comes first, by several compilers."""
    peer = names[0].partition(",")[0]
    return [name for name in names if name.partition(",")[0] == peer]


def require_pinocchio(compiled: bool = False) -> None:
    """Stop in one line where it is not installed, or where Eigen is not, without which it cannot be `compiled`."""
    if not find_spec("cmeel") or not find_spec("pinocchio"):
        raise SystemExit("Pinocchio, to which all are compared, is not installed: pip install -e '.[benchmarks]'")
    if compiled and not eigen():
        raise SystemExit("Eigen, which Pinocchio's headers need, is not installed: pip install -e '.[benchmarks]'")


def matched(
    title: str,
    model: str,
    contestants: Sequence[Contestant],
    operations: Mapping[str, int],
    rounds: int,
    parts: int = 1,
    sines: int = 0,
) -> Match:
    """Check that all give the numbers of the first, part by part, whatever else they give, then time them."""
    wanted = contestants[0].results()
    compared = wanted.shape[1]
    differences = {c.name: difference(c.results()[:, :compared], wanted, parts) for c in contestants}
    wrong = {name: apart for name, apart in differences.items() if apart > (1e-4 if "single" in name else 1e-11)}
    if wrong:
        raise SystemExit(f"{title}, {model}: not the same numbers: {wrong}")
    return Match(title, model, contest(contestants, rounds), differences, dict(operations), sines)


def states(machine: Machine, model: str, seed: int = 0) -> Array:
    """q, qd and the third argument of every state; springs are within 1 mm or 1 mrad of rest."""
    rng = np.random.default_rng([seed, len(machine.joints)])
    independent = [machine.joints[j - 1] for j in machine.independent]
    reach = [1e-3 if joint.kind is Kind.ELASTIC else 0.4 if joint.sigma else np.pi for joint in independent]
    q = rng.uniform(-1, 1, (STATES, len(independent))) * reach
    qd = rng.uniform(-2, 2, (STATES, len(independent)))
    motors = sum(joint.kind is Kind.MOTOR for joint in independent)
    if model == "inertia_matrix":
        return q
    return np.hstack([q, qd, rng.uniform(-1, 1, (STATES, motors)) * (20 if model.startswith("direct_dynamics") else 5)])


def cell(figure: dict[str, str | float]) -> str:
    return f"{float(figure['ns']):.3g} ns  x{float(figure['ratio']):.3g}"


def show(model: str, figures: Figures, machines: Sequence[str]) -> None:
    """A row a contestant, a column a machine."""
    chosen = [figure for figure in figures if figure["model"] == model]
    names = dict.fromkeys(str(figure["contestant"]) for figure in chosen)
    rows = []
    for name in names:
        cells = {f["machine"]: cell(f) for f in chosen if f["contestant"] == name}
        apart = max(float(f["difference"]) for f in chosen if f["contestant"] == name)
        rows.append([name, *(cells.get(machine, "-") for machine in machines), f"{apart:.0e}"])
    title = f"{model}: median time of a state, and how many times faster than the fastest build of Pinocchio"
    print_table(title, ["", *machines, "difference"], rows)
