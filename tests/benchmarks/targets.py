"""What the figures of `speed` ought to be."""

from __future__ import annotations

from collections.abc import Iterator

from tests.benchmarks.tables import print_table

Figures = list[dict[str, str | float]]

ARM, TREE, TWO = "6R arm", "humanoid, 29 joints", "two-axis machine"
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


def unmet(figures: Figures) -> None:
    """A table of the targets, what was found, and whether it is enough."""
    rows = [*_ratios(figures), *_casadi(figures)]
    print_table("Targets", ["", "wanted", "found", ""], [[*row[:3], "ok" if row[3] else "not met"] for row in rows])


def _ratios(figures: Figures) -> Iterator[tuple[str, str, str, bool]]:
    for machine, model, name, wanted in RATIOS:
        best = max(_of(figures, machine, model, name))
        yield f"{machine}, {model}, {name.rstrip(', ')}", f"{wanted:g}", f"{best:.3g}", best >= wanted


def _casadi(figures: Figures) -> Iterator[tuple[str, str, str, bool]]:
    """The call against CasADi's C of the same compiler: the least ratio of all rows."""
    for compiler in ("gcc", "clang"):
        least = {
            (str(f["machine"]), str(f["model"])): float(f["ns"]) / ours
            for f in figures
            if f["contestant"] == f"CasADi, {compiler}"
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
