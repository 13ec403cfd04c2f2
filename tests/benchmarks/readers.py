"""How many units and logs are read right, refused, or read wrong, in silence: `python -m tests.benchmarks.readers`.

Units of catalogues, and slips of them, where each is needed; logs as programs write them, with faults of sensors.
"""

from __future__ import annotations

import re
import sys
import tempfile
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from symoro_elastic.analysis.time_series.clocks import tidy
from symoro_elastic.analysis.time_series.measurements import (
    Measurements,
    measurements_of,
    read_columns,
    renamed_columns,
)
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.measured.logs.identify import identify
from symoro_elastic.quantities.unit_reader import COMPACT, WORDS, UnitError, conversion
from tests.benchmarks.tables import print_table
from tests.measured.logs.test_clipped import TRUE, clipped, machine
from tests.quantities.test_unit_reader import CATALOGUES, REFUSED

RIGHT, SAID, OTHER, REFUSES, WRONG = "right", "right, and said", "another unit", "refused", "WRONG"
OUTCOMES = (RIGHT, SAID, OTHER, REFUSES, WRONG)
LOGS, SENSORS = "shapes of logs", "faults of sensors"
T = np.arange(0, 20, 2e-3)
Q = 0.2 * np.sin(0.7 * T) + 0.05 * np.sin(3 * T)
TAU = 95 * np.gradient(np.gradient(Q, T), T) + 120 * np.gradient(Q, T) + 25 * np.sign(np.gradient(Q, T))
STRONGEST = 4.5
"""Standard deviations of estimates off the truth, above which they are wrong."""


def slips(text: str) -> Iterator[str]:
    """Yield the text with one letter left out, doubled, in another case, and two exchanged."""
    for k in range(len(text)):
        yield text[:k] + text[k + 1 :]
        yield text[: k + 1] + text[k:]
        yield text[:k] + text[k].swapcase() + text[k + 1 :]
        yield text[:k] + text[k : k + 2][::-1] + text[k + 2 :]


def units() -> Iterator[tuple[str, str, str]]:
    """Yield kind, text, and outcome of each unit."""
    for text, needed, factor, pi in CATALOGUES:
        yield "catalogues", text, _unit(text, needed, float(factor) * np.pi**pi)
    for text, needed, _ in REFUSED:
        yield "nonsense, two meanings", text, _unit(text, needed, None)
    for text, needed, factor, pi in CATALOGUES:
        for slip in {*slips(text)} - {text}:
            outcome = _unit(slip, needed, float(factor) * np.pi**pi)
            yield "one letter off", slip, OTHER if outcome == WRONG and _is_exact(slip) else outcome


def _is_exact(slip: str) -> bool:
    """Whether a slip is another unit of the same dimension, as mm is of m: all of its words are known as they are."""
    plain = slip.translate({ord("µ"): "u", ord("μ"): "u", ord("°"): "deg", ord("Ω"): "Ohm", 0x2126: "Ohm"})
    return all(word in WORDS or word in COMPACT or word == "Kg" for word in re.findall("[A-Za-z]+", plain))


def _unit(text: str, needed: str, right: float | None) -> str:
    try:
        found = conversion(text, needed).number
    except UnitError:
        return REFUSES
    return RIGHT if right is not None and np.isclose(found, right, rtol=1e-12) else WRONG


# Logs


def written(**more: str) -> str:
    """Return a log with this separator, head, lines above, below and behind, and end of line."""
    form = {"sep": ",", "head": "t,q_x,tau_x", "above": "", "end": "", "last": "", "decimal": "."} | more
    rows = [
        form["sep"].join(f"{x:.9g}" for x in row).replace(".", form["decimal"]) for row in zip(T, Q, TAU, strict=True)
    ]
    return form["above"] + form["head"] + "\n" + "\n".join(row + form["end"] for row in rows) + "\n" + form["last"]


SHAPES: dict[str, tuple[str, str, dict[str, str]]] = {
    "plain": (written(), "utf-8", {}),
    "semicolons, decimal commas": (written(sep=";", head="t;q_x;tau_x", decimal=","), "utf-8", {}),
    "tabs, UTF-16": (written(sep="\t", head="t\tq_x\ttau_x"), "utf-16", {}),
    "spaces (UR)": (written(sep=" ", head="t q_x tau_x"), "utf-8", {}),
    "numpy.savetxt": (written(head="# t,q_x,tau_x"), "utf-8", {}),
    "Klipper": (written(head="#time,q_x,tau_x"), "utf-8", {}),
    "comments": (written(above="# a\n% b\n", last="# end\n"), "utf-8", {}),
    "preamble (TwinCAT)": (written(sep="\t", head="t\tq_x\ttau_x", above="Name\tScope\nFile\tc:/a\n\n"), "utf-8", {}),
    "a line of units": (written(head="t,q_x,tau_x\ns,m,N"), "utf-8", {}),
    "round brackets": (written(head="t (s),q_x (m),tau_x (N)"), "utf-8", {}),
    "slashes": (written(head="t/s,q_x/m,tau_x/N"), "utf-8", {}),
    "a delimiter at the end": (written(end=",", head="t,q_x,tau_x,"), "utf-8", {}),
    "a last line that is cut": (written(last="20.002,0.0"), "utf-8", {}),
    "Windows": (
        written(head="t,q_x [m],tau_x,temp [°C]").replace("\n", ",20\n").replace("[°C],20", "[°C]"),
        "cp1252",
        {},
    ),
    "other names": (written(head="Zeit,Pos,Kraft"), "utf-8", {"t": "Zeit", "q_x": "Pos [m]", "tau_x": "1*Kraft"}),
    "other names, without a way": (written(head="Zeit,Pos,Kraft"), "utf-8", {}),
    "bars": (written(sep="|", head="t|q_x|tau_x"), "utf-8", {}),
    "counts": (written(head="t,q_x [counts],tau_x"), "utf-8", {}),
    "a cell that is no number": (written().replace("\n0.1,", "\nx,"), "utf-8", {}),
}


def shapes(folder: Path) -> Iterator[tuple[str, str, str]]:
    """Yield kind, name and outcome of each way to write a log."""
    robot, _ = machine("slide")
    for name, (text, encoding, names) in SHAPES.items():
        path = folder / "log.csv"
        path.write_text(text, encoding=encoding)
        try:
            found = measurements_of(renamed_columns(read_columns(path, robot), names, "log"), robot, "log")
        except InputError:
            yield LOGS, name, REFUSES
            continue
        same = len(found.t) == len(T) and np.allclose(found.q[:, 0], Q, atol=1e-8) and np.allclose(found.tau[:, 0], TAU)
        yield LOGS, name, RIGHT if same else WRONG


FAULTS: dict[str, Callable[[Array, Array], tuple[Array, Array]]] = {
    "none": lambda q, tau: (q, tau),
    "a wrap of 16 bits": lambda q, tau: ((q + 0.032768) % 0.065536 - 0.032768, tau),
    "a wrap of 0.3 m": lambda q, tau: ((q + 0.15) % 0.3 - 0.15, tau),
    "positions stuck for 1 s": lambda q, tau: (np.where(np.abs(np.arange(len(q)) - 9000) < 500, q[8500], q), tau),
    "positions clipped at 20 %": lambda q, tau: (np.clip(q, *np.quantile(q, [0.1, 0.9])), tau),
    "torques stuck for 1 s": lambda q, tau: (q, np.where(np.abs(np.arange(len(q)) - 9000) < 500, tau[8500], tau)),
    "steps of 2 N": lambda q, tau: (q, np.round(tau / 2) * 2),
    "a dead band of 5 N": lambda q, tau: (q, np.where(np.abs(tau) < 5, 0, tau)),
}


def faults() -> Iterator[tuple[str, str, str]]:
    """Yield kind, name and outcome of faults of sensors, of three draws each."""
    for seed in range(3):
        for name, change in FAULTS.items():
            whole = clipped("slide", 0.0, seed)
            q, tau = change(whole.q[:, 0], whole.tau[:, 0])
            yield SENSORS, name, _identified("slide", Measurements(whole.t, q[:, None], tau[:, None]))
        for share in (0.01, 0.05, 0.2, 0.6, 0.97):
            for robot in TRUE:
                record = clipped(robot, share, seed)
                yield SENSORS, f"{100 * share:g} % clipped, {robot}", _identified(robot, record)


def _identified(robot: str, record: Measurements) -> str:
    whole, Y = machine(robot)
    try:
        found = identify(whole, tidy(record, whole), Y=Y)
    except InputError:
        return REFUSES
    each = {e.unknown.label: e for e in found.estimates}
    z = [abs(each[label].value - x) / each[label].std for label, x in TRUE[robot].items()]
    if not max(z) < STRONGEST:
        return WRONG
    return SAID if any("left out" in note or "resolve" in note for note in found.notes) else RIGHT


def main() -> int:
    with tempfile.TemporaryDirectory() as folder:
        outcomes = [*units(), *shapes(Path(folder)), *faults()]
    counts = {kind: Counter(outcome for one, _, outcome in outcomes if one == kind) for kind, _, _ in outcomes}
    rows = [(kind, *(str(of[name]) for name in OUTCOMES)) for kind, of in counts.items()]
    print_table("readers", ("kind", *OUTCOMES), rows)
    wrong = [f"{kind}: {text!r}" for kind, text, outcome in outcomes if outcome == WRONG]
    refused = [f"{kind}, refused: {name}" for kind, name, x in outcomes if kind in (LOGS, SENSORS) and x == REFUSES]
    print("\n".join([*wrong, *dict.fromkeys(refused)]))
    return int(bool(wrong))


if __name__ == "__main__":
    sys.exit(main())
