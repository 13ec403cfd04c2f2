"""What the figures of `speed` and of `derivatives` ought to be."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

from tests.benchmarks.contest import COMPILERS
from tests.benchmarks.tables import print_table

Figures = list[dict[str, str | float]]
Counts = list[dict[str, str | int]]
"""Machine, model, operations of ours and of `CASADI`."""

ARM, ARM_7, TREE, TWO = "6R arm", "7R arm", "humanoid, 29 joints", "two-axis machine"
QUADRUPED = "quadruped, 15 joints"
CASADI = "CasADi"
RATIOS: tuple[tuple[str, str, str, float], ...] = (
    (ARM, "inverse_dynamics", "call, ", 9),
    (ARM, "direct_dynamics", "call, ", 8),
    (TREE, "inverse_dynamics", "call, ", 6.5),
    (TREE, "direct_dynamics", "call, ", 4.5),
    (TWO, "direct_dynamics", "call, ", 40),
    (ARM, "inverse_dynamics", "batch, double, AVX-512", 60),
    (TWO, "direct_dynamics", "batch, double, AVX-512", 300),
    (ARM, "inverse_dynamics", "batch, double, AVX2", 30),
    (ARM, "inverse_dynamics", "batch, single, AVX-512", 120),
    (TWO, "direct_dynamics", "batch, single, AVX-512", 600),
    (ARM, "inverse_dynamics", "batch, single, AVX2", 60),
)
"""Machine, model, contestants of whom the best counts, how many times faster than Pinocchio."""
RATIOS_OF_DERIVATIVES = (
    (ARM, "inverse_dynamics_derivatives", "call, ", 15.0),
    (ARM, "direct_dynamics_derivatives", "call, ", 12.0),
    (TREE, "inverse_dynamics_derivatives", "call, ", 6.0),
    (TREE, "direct_dynamics_derivatives", "call, ", 4.0),
)
Verdict = tuple[str, str, str, bool]
"""What, wanted, found, whether it is enough."""


def unmet(figures: Figures) -> None:
    """A table of the targets, what was found, and whether it is enough."""
    _show([*_ratios(figures, RATIOS), *_casadi(figures)])


def unmet_of_derivatives(figures: Figures, counts: Counts) -> None:
    """The same for derivatives."""
    _show([*_ratios(figures, RATIOS_OF_DERIVATIVES), *_casadi(figures), *_fewer(counts)])


def _show(verdicts: Iterable[Verdict]) -> None:
    rows = [[what, wanted, found, "ok" if enough else "not met"] for what, wanted, found, enough in verdicts]
    print_table("Targets", ["", "wanted", "found", ""], rows)


def _fewer(counts: Counts) -> Iterator[Verdict]:
    for found in counts:
        if CASADI in found:
            ours, theirs = int(found["ours"]), int(found[CASADI])
            yield f"{found['machine']}, {found['model']}: operations", f"< {theirs}", str(ours), ours < theirs


def _ratios(figures: Figures, targets: Sequence[tuple[str, str, str, float]]) -> Iterator[Verdict]:
    for machine, model, name, wanted in targets:
        best = max(_of(figures, machine, model, name))
        yield f"{machine}, {model}, {name.rstrip(', ')}", f"{wanted:g}", f"{best:.3g}", best >= wanted


def _casadi(figures: Figures) -> Iterator[Verdict]:
    """The call against CasADi's C of the same compiler: the least ratio of all rows."""
    for compiler in COMPILERS:
        least = {
            (str(f["machine"]), str(f["model"])): float(f["ns"]) / ours
            for f in figures
            if f["contestant"] == f"{CASADI}, {compiler}"
            for ours in (_ns(figures, f, f"call, {compiler}"),)
        }
        if least:
            where = min(least, key=lambda key: least[key])
            yield (
                f"CasADi-generated C, {compiler}: worst row ({', '.join(where)})",
                "> 1",
                f"{least[where]:.3g}",
                least[where] > 1,
            )


def _of(figures: Figures, machine: str, model: str, name: str) -> list[float]:
    return [
        float(f["ratio"])
        for f in figures
        if f["machine"] == machine and f["model"] == model and str(f["contestant"]).startswith(name)
    ]


def _ns(figures: Figures, like: dict[str, str | float], name: str) -> float:
    return next(
        float(f["ns"])
        for f in figures
        if f["machine"] == like["machine"] and f["model"] == like["model"] and f["contestant"] == name
    )
